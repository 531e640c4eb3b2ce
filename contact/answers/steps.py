r"""Steps on demand: what a number of cycles moves the slider by, how many cycles a step takes, where it stops.

A step is a burst from rest and what follows until the slider is held by its spring and rings about where it will stay.
The net displacement is the travel of the slider to where its tangential spring is relaxed: position plus the load's
own deformation of the contact, so the ring does not blur it.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.answers.methods import EXACT_CYCLES, rest, rest_problem, silence, why_not_stepped
from contact.convergence import ConvergenceError
from contact.drive import towards_plus
from contact.envelope import Envelope
from contact.law.normal import slope
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

MOST_CYCLES = 3_000_000


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of the motor.

    Attributes
    ----------
    cycles : int
        Of the wave.
    displacement : float
        Net, m, positive along +x: where the slider settles, the ring taken out.
    during, stopping : float
        Travel during the burst and after it, m; they sum to `displacement`.
    velocity : float
        At the end of the burst, m/s.
    stopping_time : float
        s from the end of the burst to the last slip.
    ring : float
        Amplitude of the ring that is left, m.
    """

    cycles: int
    displacement: float
    during: float
    stopping: float
    velocity: float
    stopping_time: float
    ring: float


def step(
    slider: Slider, orbits: Orbit | tuple[Orbit, ...], *, cycles: int, envelope: Envelope | None = None
) -> Step:
    """Return the step that a burst of whole cycles makes from rest.

    Parameters
    ----------
    slider : Slider
        The slider; with friction, or it never stops.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact.
    cycles : int
        Of the wave, at least one.
    envelope : Envelope, optional
        Factor on the orbits over time.

    Returns
    -------
    Step
    """
    listed = as_orbits(orbits)
    bounds.count("cycles", cycles, 1)
    return next(iter(_steps(slider, listed, [int(cycles)], envelope)))


def cycles_for(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    displacement: float,
    envelope: Envelope | None = None,
) -> tuple[Step, Step]:
    """Return the largest step that does not reach a displacement and the next, one cycle more, that does.

    Parameters
    ----------
    slider, orbits, envelope
        As for `step`.
    displacement : float
        Size of the step, m, positive; the direction is the motor's.

    Raises
    ------
    ConvergenceError
        Status "out of reach" when 3 million cycles do not move the slider so far.
    """
    listed = as_orbits(orbits)
    wanted = bounds.positive("displacement", displacement, "m")
    known: dict[int, Step] = {}

    def at(number):
        if number not in known:
            known[number] = step(slider, listed, cycles=number, envelope=envelope)
        return known[number]

    # a few cycles leave the contacts strained, whichever way: the motor's direction shows after some more
    way = math.copysign(1.0, at(256).displacement)
    low, high = 0, 8
    while way * at(high).displacement < wanted:
        low, high = high, 2 * high
        if high > MOST_CYCLES:
            raise ConvergenceError(
                "out of reach",
                f"{low} cycles move the slider by {at(low).displacement:.3g} m; raise the amplitude or the time",
            )
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if way * at(middle).displacement >= wanted else (middle, high)
    return at(max(low, 1)), at(high)


def _steps(slider, orbits, numbers, envelope):
    """Yield the step of each number of cycles."""
    if slider.friction_coefficient * slider.preload <= slider.load:
        raise ConvergenceError(
            "runaway", "friction cannot hold the load, so the slider never stops; lower slider.load"
        )
    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    for cycles in numbers:
        motion = rest(slider, driven, problem, nodes=12, truncation=1e-10)
        travelled = _drive(slider, problem, motion, cycles, envelope, driven[0].frequency)
        yield _stopped(slider, problem, motion, travelled, side, cycles)


def _drive(slider, problem, motion, cycles, envelope, frequency):
    """Move through the burst; return the distance travelled, scaled."""
    from contact.solve.energy import DISPLACEMENT
    from contact.solve.time_stepping import steps

    if envelope is None and cycles <= EXACT_CYCLES:
        motion.turn(cycles)
        return float(motion.sums[DISPLACEMENT])
    reason = why_not_stepped(slider, problem, 96)
    if reason:
        if envelope is not None:
            raise ConvergenceError("not applicable", f"an envelope needs fixed steps: {reason}")
        motion.turn(cycles)
        return float(motion.sums[DISPLACEMENT])
    shape = envelope.at(np.arange(cycles + 1) / frequency) if envelope is not None else None
    rows = steps(problem, motion.state, cycles, 96, envelope=shape)
    return float(2.0 * math.pi * np.sum(rows[:, 2]))


def _stopped(slider, problem, motion, travelled, side, cycles):
    """Follow the slider until it has slipped for the last time; return the step."""
    from contact.codes import Regime
    from contact.solve.energy import DISPLACEMENT

    speed, contacts = float(motion.state[2]), problem.contacts
    # what the load alone leaves of the deformations, each with its contact's share in the stiffness
    share = slope(slider.rest_approach(contacts) + slider.offsets(contacts), slider.contact_shape)
    share = share / np.sum(share)
    spring = np.copysign(share @ slider.rest_deformations(contacts), problem.load) / problem.length
    still = silence(motion)
    friction = slider.friction_coefficient * slider.preload - slider.load
    omega = problem.omega
    # long enough to brake, and then bounce periods until no contact slips through a whole one
    period = 2.0 * math.pi * omega / (2.0 * math.pi * slider.tangential_resonance(contacts))
    phase, last, quiet = 0.0, 0.0, 0
    brake = abs(speed) * problem.speed * slider.mass / friction * omega
    largest = 0.0
    while quiet < 12:
        span = 0.5 * period if phase >= brake else max(0.5 * period, 0.25 * brake)
        at = phase + span * np.arange(1, 33) / 32
        samples = still.move(phase, float(at[-1]) * (1.0 + 1e-14), at)
        phase = float(at[-1])
        _, deformation, _, _, regime, _ = np.moveaxis(samples, -1, 0)
        apart, sticks = regime == Regime.SEPARATED, regime == Regime.STICK
        # a contact that does not touch at rest holds nothing
        slipping = np.any(~sticks & ~(apart & (share == 0.0)), axis=1)
        if np.any(slipping):
            last, quiet, largest = float(at[np.flatnonzero(slipping)[-1]]), 0, 0.0
        else:
            quiet += 1
            x = deformation @ share
            largest = max(largest, float(np.max(np.abs(x - spring))))
        if phase > 1e9:
            raise ConvergenceError(
                "not converged", "the slider goes on slipping; give it normal or tangential damping"
            )
    # the contacts stick: position plus deformation stays, and the load's own deformation is what remains
    relaxed = float(still.sums[DISPLACEMENT] + still.state[3:] @ share - spring)
    unit = side * problem.length
    return Step(
        cycles=cycles,
        displacement=unit * (travelled + relaxed),
        during=unit * travelled,
        stopping=unit * relaxed,
        velocity=side * speed * problem.speed,
        stopping_time=last / omega,
        ring=largest * problem.length,
    )
