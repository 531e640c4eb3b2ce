r"""Stated against true error of bursts and steps under an envelope; the truth is the oracle `contact_motion`.

Random sliders on one to three balls or punches, with and without load and dampers. The envelopes have kinks within a
cycle, peaks of less than a cycle, and phases that run by up to 10 rad while the load bends the contacts. Prints each
draw with a true error of more than the stated one, and the largest ratios of true and stated error.

    python -m tests.benchmarks.envelope_error --number 100
"""

import argparse

import numpy as np

from contact import ConvergenceError, Envelope, burst, step
from contact.averaged.event_equilibrium import opposed
from contact.orbit import towards_plus
from tests.contact.motors import way_to_rest
from tests.motors import under_an_envelope
from tests.oracles.contact_motion import Motor


def faded(envelope, cycles, frequency):
    """Return (the ring-down, the envelope of burst and ring-down): the wave falls to nothing in some 20 cycles."""
    end, last = cycles / frequency, complex(envelope.at(np.array([cycles / frequency]))[0])
    fall, inside = np.array([0.0, 7.3, 20.6]) / frequency, envelope.time < end
    phase = np.interp(end, envelope.time, envelope.phase) + np.array([0.0, 0.8, 0.5])
    amplitude = abs(last) * np.array([1.0, 0.4, 0.0])
    whole = Envelope(
        time=np.append(envelope.time[inside], end + fall), amplitude=np.append(envelope.amplitude[inside], amplitude),
        phase=np.append(envelope.phase[inside], phase),
    )  # fmt: skip
    return Envelope(time=fall, amplitude=amplitude, phase=phase), whole


def truth(slider, orbits, cycles, envelope):
    """Return (velocity at the end of the burst, displacement of the step) by the oracle."""
    side, driven = towards_plus(orbits)
    # the load opposes the motion; the oracle's acts along -x
    load, mu = slider.load * opposed(slider, driven), slider.friction_coefficient
    motor = Motor(
        mass=slider.mass, preload=slider.preload, load=load, frequency=orbits[0].frequency, radius=slider.radius,
        normal=tuple(each.normal for each in driven), tangential=tuple(each.tangential for each in driven),
        E=slider.effective_modulus, G=slider.tangential_modulus, normal_damping=slider.normal_damping,
        tangential_damping=slider.tangential_damping, heights=slider.heights, punch=slider.shape == "punch",
        numbers=(mu, 1.0, 1.0, mu, 1.0, np.inf), times=tuple(envelope.time), amplitude=tuple(envelope.amplitude),
        phase=tuple(envelope.phase), tolerance=1e-11,
    )  # fmt: skip
    _, rows, state = motor.run(cycles, every=cycles)
    _, _, state = motor.run(21, every=21, state=state)
    c, power = slider.limit_slope, 1.0 if slider.shape == "punch" else 1.5
    at_rest, places = motor.rest_height() + motor.offsets, []
    periods = int(np.ceil(3.0 * orbits[0].frequency / slider.tangential_resonance(len(orbits))))  # of the ring
    while len(places) < 40 and (len(places) < 6 or np.ptp(places[-6:]) > 1e-10 * abs(places[-1])):
        _, _, state = motor.run(periods, every=periods, state=state, silent=True)
        y = state[1]
        bent = y[3 : 3 + len(orbits)]
        places.append(y[-1] + way_to_rest(at_rest, bent, c, power, load=load / (mu * slider.normal_stiffness)))
    return side * rows[-1, 0], side * places[-1], np.ptp(places[-6:])


def main():
    """Print the draws that are further off than stated, and the largest ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    ratios = {"burst": [], "step": []}
    for number in range(options.first, options.first + options.number):
        slider, orbits, cycles, envelope = under_an_envelope(number)
        try:
            found = burst(
                slider, orbits, duration=cycles / orbits[0].frequency, after=0.0, tolerance=1e-4, samples=2,
                envelope=envelope,
            )  # fmt: skip
            fall, whole = faded(envelope, cycles, orbits[0].frequency)
            moved = step(slider, orbits, cycles=cycles, envelope=envelope, after=fall)
        except ConvergenceError as refused:
            print(number, refused)
            continue
        velocity, displacement, unsettled = truth(slider, orbits, cycles, whole)
        pairs = {"burst": (found.velocity_at_burst_end - velocity, found.answer.error)}
        if unsettled < 0.1 * moved.error:
            pairs["step"] = moved.displacement - displacement, moved.error
        for kind, (error, stated) in pairs.items():
            ratios[kind].append(abs(error) / stated)
            if abs(error) > stated:
                size = velocity if kind == "burst" else displacement
                print(f"{number:4d} {kind:5s} of {size:.3e}: true {abs(error):.2e} stated {stated:.2e}")
    for kind, each in ratios.items():
        print(f"{kind}: {len(each)} draws, {np.sum(np.array(each) > 2)} beyond twice, largest {max(each):.2f}")


if __name__ == "__main__":
    main()
