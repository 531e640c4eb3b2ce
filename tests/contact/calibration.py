"""The contact's three ways by themselves: true error over stated error on random sliders and waves.

Method: sliders, waves and bursts drawn around the seed's (every parameter by up to a factor of ten either way, phases,
one or three balls), bursts of 100 to 6000 cycles by each way and steady states by averages and by the full equations,
at tolerances from 1e-2 to 1e-6.  Truth: the event-exact way at 20 nodes.  The true error is the difference over
max(|v|, omega |u_x|/10), as the stated one.  Expected: at most twice the stated error in 95 of 100 answers of every
way, and a median stated error within ten times the true one.  Run time: about a minute for 200 draws.
"""

import math
from dataclasses import dataclass

__all__ = ["ContactChecked", "contact_calibration", "kept", "pessimism"]

SEED, TOLERANCES = 20261, (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
NODES, TRUNCATION = 20, 1e-13
ROUNDING = 1e-13  # of a velocity; below it an error is noise


@dataclass(frozen=True, kw_only=True)
class ContactChecked:
    """One answer of one way.

    Attributes
    ----------
    number : int
        Of the draw.
    way : str
        "burst, exact", "burst, stepped", "burst, averaged", "steady, exact" or "steady, averaged".
    tolerance, true, estimate : float
        What was asked for, the error against the truth, and the stated one.
    """

    number: int
    way: str
    tolerance: float
    true: float
    estimate: float


def drawn(number: int):
    """Return (slider, orbits, cycles) of a draw: the same for a number in every process."""
    import numpy as np

    from contact import Orbit, Slider
    from studies.evidence.stability.contact import SLIDER

    draw = np.random.default_rng([SEED, number])

    def around(value, factor):
        return float(value * factor ** draw.uniform(-1.0, 1.0))

    seed = SLIDER
    mass = around(seed["mass"], 10.0)
    slider = Slider(**(seed | {
        "mass": mass, "preload": around(9.81 * mass, 3.0), "radius": around(1e-3, 10.0),
        "friction_coefficient": around(0.12, 3.0), "effective_modulus": around(64e9, 2.0),
        "tangential_modulus": around(12e9, 2.0),
        "normal_damping": around(5e3, 10.0) * mass, "tangential_damping": around(1.0, 30.0) * mass,
    }))  # fmt: skip
    amplitude, angle = around(4e-9, 6.0), -0.5 * math.pi + float(draw.uniform(-0.4, 0.4))
    wave = Orbit(
        frequency=around(2.2e6, 4.0), normal=amplitude,
        tangential=around(0.7, 1.6) * amplitude * complex(np.exp(1j * angle)),
    )  # fmt: skip
    contacts = int(draw.choice([1, 1, 3]))
    step = float(draw.uniform(0.0, 2.0 * math.pi))
    orbits = tuple(wave.scaled(complex(np.exp(1j * step * k))) for k in range(contacts))
    return slider, orbits, int(100 * 60.0 ** draw.random())


def checked(number: int) -> list[ContactChecked]:
    """Return the answers of every way that applies to one draw."""
    import contact
    from contact.error_estimate import relative_to_reference

    slider, orbits, cycles = drawn(number)
    truths = {"burst": _burst_truth(slider, orbits, cycles), "steady": _steady_truth(slider, orbits)}
    duration = cycles / orbits[0].frequency
    found = []
    for tolerance in TOLERANCES:
        for kind, methods in (("burst", ("exact", "stepped", "averaged")), ("steady", ("exact", "averaged"))):
            for method in methods:
                try:
                    if kind == "burst":
                        answer = contact.burst(
                            slider, orbits, duration=duration, after=0.0, tolerance=tolerance, samples=2,
                            method=method,
                        )  # fmt: skip
                        velocity = answer.velocity_at_burst_end
                    else:
                        answer = contact.steady(slider, orbits, tolerance=tolerance, method=method)
                        velocity = answer.velocity
                except contact.ConvergenceError:
                    continue
                truth = truths[kind]
                if truth is None:
                    continue
                true = relative_to_reference(velocity - truth, truth, orbits)
                found.append(
                    ContactChecked(
                        number=number,
                        way=f"{kind}, {answer.method}",
                        tolerance=tolerance,
                        true=true,
                        estimate=answer.relative_error,
                    )
                )
    return found


def contact_calibration(draws: int = 200) -> list[ContactChecked]:
    """Return the answers of every way to a number of draws."""
    return [each for number in range(draws) for each in checked(number)]


def kept(found: list[ContactChecked]) -> dict[str, float]:
    """Return by way the share of answers whose true error is at most twice the stated one."""
    return {
        way: sum(each.true <= 2.0 * each.estimate + ROUNDING for each in group) / len(group)
        for way, group in _by_way(found).items()
    }


def pessimism(found: list[ContactChecked]) -> dict[str, float]:
    """Return by way the median of the stated error over the true one."""
    from statistics import median

    return {
        way: median(each.estimate / max(each.true, ROUNDING) for each in group) for way, group in _by_way(found).items()
    }


def _by_way(found):
    return {way: [each for each in found if each.way == way] for way in sorted({each.way for each in found})}


def _burst_truth(slider, orbits, cycles):
    """Return v at the burst's end by the finest event-exact motion, m/s."""
    from contact.answers.burst_methods import rest, rest_problem
    from contact.orbit import towards_plus

    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    motion = rest(slider, driven, problem, nodes=NODES, truncation=TRUNCATION)
    motion.turn(cycles)
    return side * float(motion.state[2]) * problem.speed


def _steady_truth(slider, orbits):
    """Return the mean velocity of the finest periodic motion, m/s, or None where there is none to trust."""
    import contact
    from contact.averaged.event_equilibrium import balanced
    from contact.orbit import towards_plus
    from contact.periodic.shooting import periodic

    side, driven = towards_plus(orbits)
    balance = balanced(slider, driven)
    if balance.held:
        return 0.0
    try:
        return side * float(periodic(balance, nodes=NODES, truncation=TRUNCATION).speed) * balance.problem.speed
    except contact.ConvergenceError:
        return None
