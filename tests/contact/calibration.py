"""The contact's three ways by themselves: true error over stated error on random sliders and waves.

Method: sliders, waves and bursts drawn around the seed's (every parameter by up to a factor of ten either way, phases,
one or three balls), bursts of 100 to 6000 cycles by each way and steady states by averages and by the full equations,
at tolerances from 1e-2 to 1e-6.  Truth: the event-exact way at 20 nodes.  The true error is the difference over
max(|v|, omega |u_x|/10), as the stated one.  Expected: at most twice the stated error in 95 of 100 answers of every
way, and a median stated error within ten times the true one.  Run time: about a minute for 200 draws.
"""

from dataclasses import dataclass

from tests.motors import TOLERANCES, around_the_seed

__all__ = ["ContactChecked", "contact_calibration", "kept", "pessimism"]

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


def checked(number: int) -> list[ContactChecked]:
    """Return the answers of every way that applies to one draw."""
    import contact
    from contact.error_estimate import relative_to_reference

    slider, orbits, cycles = around_the_seed(number)
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
    from contact.answers.rest_motion import rest, rest_problem
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
