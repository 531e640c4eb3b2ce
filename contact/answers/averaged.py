r"""The averaged way: a slider that is heavy on the wave's time scale, many cycles at once.

The bounce equation and the velocity equation (`solve.averaged`, `solve.averaged_transient`) take the event-exact mean
of the tangential force over a cycle. First order errs by O((f_n/f)^2); with the slider's fast motion fed back (second
order) the steady state is the full periodic motion but for the harmonics left out, and v(t) is a hundred times closer.
The first and the last cycle of a run are followed event by event: the start from rest is no cycle that repeats, and the
end wants deformations.

It does not apply to a stiff contact (f_n/f above 0.1), to a stick band, to other laws than the seed's, or where a
contact sticks through whole cycles, for its traction then remembers how it got there.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import scaling
from contact.convergence import ConvergenceError
from contact.drive import reference_speed, towards_plus
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

# largest ratio of bounce to wave frequency, for v(t) and for the corrected steady state
STIFFEST, STIFFEST_STEADY = 0.1, 0.3
HARMONICS = 8
# shares of the bound on the first-order error that first order has been seen to make of v(t), and second to leave
FIRST_ORDER, LEFT_BY_SECOND_ORDER = 0.17, 0.05


@dataclass(frozen=True, kw_only=True)
class MeanMotion:
    """Steady state of the averaged equations.

    Attributes
    ----------
    velocity : float
        Mean, m/s; exactly 0 when held.
    height : float
        Mean approach h, m.
    regime : str
        "stick", "slip" or "intermittent".
    held : bool
        Whether friction keeps the slider at rest.
    error : float
        Estimated error of `velocity`, m/s.
    first_order : float
        The velocity without the second-order correction, m/s.
    """

    velocity: float
    height: float
    regime: str
    held: bool
    error: float
    first_order: float


def why_not(slider: Slider, orbits: tuple[Orbit, ...], stiffest: float = STIFFEST) -> str:
    """Return why averaging does not apply, or an empty string."""
    if slider.law != "elastic" or slider.reciprocal:
        return "it knows the elastic law without its reciprocal force only"
    if slider.stick_band > 0.0:
        return "slider.stick_band needs the events"
    if slider.limit_slope == 0.0 or slider.preload == 0.0:
        return "there is no friction force"
    if all(orbit.normal == 0 and orbit.tangential == 0 for orbit in orbits):
        return "there is no wave"
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    if ratio > stiffest:
        return f"the contact is too stiff: it resonates at {ratio:.3g} of the wave's frequency, more than {stiffest}"
    rate = max(slider.normal_damping, slider.tangential_damping) / (slider.mass * orbits[0].omega)
    if rate > stiffest**2:
        return f"the dampers act within {1.0 / rate:.3g} radians of the wave"
    return ""


def mean_motion(
    slider: Slider, orbits: Orbit | tuple[Orbit, ...], *, harmonics: int = HARMONICS
) -> MeanMotion:
    """Return the steady state by averaging with the second-order correction.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact.
    harmonics : int
        Of the slider's fast motion; 0 for first order alone.

    Returns
    -------
    MeanMotion

    Raises
    ------
    ConvergenceError
        Status "not applicable", "runaway" or "not converged".
    """
    from contact.solve import averaged
    from contact.solve.cycle_mean import quadrature

    listed = as_orbits(orbits)
    refuse_unless_applicable(slider, listed, STIFFEST_STEADY)
    side, driven = towards_plus(listed)
    problem = scaling.scaled(slider, driven, direction=1.0, start=0.0)
    first, second, rule = np.zeros(7), np.zeros(7), quadrature(20)
    why = averaged.balance(problem.parameters, problem.waves, rule, 0, first)
    if first[0] < 0.0 and slider.load > 0.0 and averaged.drives_back(problem.parameters, problem.waves, rule):
        problem = scaling.scaled(slider, driven, direction=-1.0, start=0.0)
        why = averaged.balance(problem.parameters, problem.waves, rule, 0, first)
    second[:] = first
    if harmonics > 0 and why == averaged.DONE and not first[3]:
        why = averaged.balance(problem.parameters, problem.waves, rule, harmonics, second)
    if why == averaged.UNSETTLED and first[0] == 0.0:
        raise ConvergenceError(
            "runaway",
            "friction cannot balance the load at any speed and no tangential damping bounds it; "
            "lower slider.load or give slider.damping.tangential",
        )
    if why != averaged.DONE:
        raise ConvergenceError("not converged", "the averaged motion was not reached; use method exact")
    moved = abs(second[0] - first[0])
    error = max(second[6], second[2], 1e-4 * moved, 1e-11 * second[0]) if harmonics > 0 else moved
    if harmonics == 0:
        error = 12.0 * (slider.normal_resonance(len(listed)) / listed[0].frequency) ** 2 * abs(second[0])
    regime = "intermittent" if second[4] else "slip" if second[5] else "stick"
    return MeanMotion(
        velocity=float(side * second[0] * problem.speed), height=float(second[1] * problem.length), regime=regime,
        held=bool(first[3]), error=float(error * problem.speed), first_order=float(side * first[0] * problem.speed),
    )  # fmt: skip


def refuse_unless_applicable(slider: Slider, orbits: tuple[Orbit, ...], stiffest: float = STIFFEST) -> None:
    """Raise if averaging does not apply."""
    reason = why_not(slider, orbits, stiffest)
    if reason:
        raise ConvergenceError(
            "not applicable", f"the averaged way does not apply: {reason}; use method stepped or exact"
        )


def averaged_run(
    slider: Slider, orbits: tuple[Orbit, ...], problem, begin, cycles: int, stride: int, tolerance: float
):
    """Return (motion, rows, error, statistics) of a burst of at least 3 cycles.

    `begin` is the motion at phase 0, which is moved; rows (v, z_s) every `stride` cycles, z_s without its fast part;
    `error` of v in scaled units.
    """
    from contact.solve import averaged, averaged_transient
    from contact.solve.cycle_mean import quadrature

    refuse_unless_applicable(slider, orbits)
    begin.turn(1)
    turn = 2.0 * math.pi
    ends = stride * np.arange(1, cycles // stride + 1)
    inner = (ends > 1) & (ends < cycles)
    at, stop = turn * (ends[inner] - 1.0), turn * (cycles - 2)
    rows = np.zeros((ends.size, 2))
    rows[ends <= 1] = begin.state[2], begin.state[0]
    at = np.minimum(at, stop)
    unit = reference_speed(0.0, orbits) / problem.speed
    first, second, fine = np.zeros(7), np.zeros(7), quadrature(12)
    averaged.balance(problem.parameters, problem.waves, fine, 0, first)
    averaged.balance(problem.parameters, problem.waves, fine, HARMONICS, second)
    by_average = abs(second[0] - first[0])
    for share in (0.2, 0.5, 0.9):  # of the velocity that is left to gain
        gap = averaged.first_order_gap(
            problem.parameters, problem.waves, share * second[0], stop, fine, HARMONICS
        )
        by_average = max(by_average, gap)
    # the bounce passes through heights at which first order errs otherwise: 2.5 (f_n/f)^2 seen, hopping at 20 nm
    by_average = max(
        by_average, 3.0 * unit * (slider.normal_resonance(len(orbits)) / orbits[0].frequency) ** 2
    )
    corrected = FIRST_ORDER * by_average > 0.7 * tolerance * unit
    work = np.zeros(2, np.int64)

    def run(allowed, per_period, nodes, record):
        state, found = begin.state[:3].copy(), np.zeros((at.size if record else 0, 2))
        why = averaged_transient.response(
            problem.parameters, problem.waves, state, stop, quadrature(nodes), 8 if corrected else 0, allowed * unit,
            per_period, at if record else at[:0], found, work,
        )  # fmt: skip
        if why == averaged.STICKS:
            raise ConvergenceError(
                "not applicable",
                "the averaged way does not apply: a contact sticks through whole cycles; use method stepped or exact",
            )
        if why != averaged.DONE:
            raise ConvergenceError("not converged", "the averaged motion was not finite; use method exact")
        return state, found

    allowed = max(min(tolerance, 1e-3), 1e-9)
    per_period = int(min(8.0 * max(1.0, 1e-4 / allowed) ** 0.4, 96.0))
    coarse, _ = run(2.0 * allowed, per_period // 2, 8, False)
    state, rows[inner] = run(allowed, per_period, 8 if allowed >= 1e-5 else 16, True)
    error = abs(float(state[2] - coarse[2])) + by_average * (
        LEFT_BY_SECOND_ORDER if corrected else FIRST_ORDER
    )
    # a cycle forgets its deformations: one for those it starts with, one for the motion
    begin.place(*state, 0.0)
    begin.turn(1)
    begin.place(*state, begin.state[3:])
    begin.turn(1)
    rows[ends >= cycles] = begin.state[2], begin.state[0]
    statistics = {
        "cycles": cycles, "order": 2 if corrected else 1, "bounce_steps": int(work[0]), "velocity_steps": int(work[1]),
    }  # fmt: skip
    return begin, rows, error, statistics
