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

from contact.codes import Status
from contact.convergence import ConvergenceError
from contact.drive import reference_speed
from contact.orbit import Orbit
from contact.problem import Problem
from contact.slider import Slider
from contact.solve.riding import quadrature

# largest ratio of bounce to wave frequency, for v(t) and for the corrected steady state
STIFFEST, STIFFEST_STEADY = 0.1, 0.3
HARMONICS = 8
# instants in the second half of a burst at which two runs are compared
COMPARED = 24
# What second order leaves of the error of v(t): shares of the difference between the orders and of (f_n/f)^2, the
# latter of the reference speed. Measured by tests/benchmarks/averaging_error.py: the worst of 86 bursts aimed at weak
# spots is off by 1.3 times its stated error; by 1.5 times with half of these shares, by 1.1 times with twice.
LEFT_OF_FIRST, LEFT_OF_RATIO = 0.12, 0.1
# velocity by the midpoint rule: half the steps, four times the error
STEP_GAIN = 3.0


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


def refuse_unless_applicable(slider: Slider, orbits: tuple[Orbit, ...], stiffest: float = STIFFEST) -> None:
    """Raise if averaging does not apply."""
    reason = why_not(slider, orbits, stiffest)
    if reason:
        raise ConvergenceError(
            "not applicable", f"the averaged way does not apply: {reason}; use method stepped or exact"
        )


@dataclass(frozen=True)
class _Transient:
    """Averaged equations of one burst: where they start, what is recorded."""

    problem: Problem  # The scaled problem
    start: np.ndarray  # (3,) array: z_s, z_s' and v at the end of the first cycle
    phases: np.ndarray  # (k,) array: Where v and z_s are recorded
    compared: np.ndarray  # (k,) bool array: Which of them serve to compare two runs
    stop: float  # Phase of the end, from that of the start
    unit: float  # Reference speed, scaled
    work: np.ndarray  # (2,) int array: Steps of the bounce and of the velocity, added up

    def follow(self, harmonics, allowed, per_period, nodes):
        """Return (state at the end, rows) of one run: v to `allowed` of the unit, so many steps per bounce."""
        from contact.solve import averaged_transient

        state, rows = self.start.copy(), np.zeros((self.phases.size, 2))
        span = averaged_transient.Span(
            self.stop,
            allowed * self.unit,
            per_period,
            quadrature(nodes),
            int(harmonics > 0),
            self.phases,
            rows,
            self.work,
        )
        why = averaged_transient.response(self.problem, state, span, HARMONICS)
        if why == Status.STICKS:
            raise ConvergenceError(
                "not applicable",
                "the averaged way does not apply: a contact sticks through whole cycles; use method stepped or exact",
            )
        if why != Status.DONE:
            raise ConvergenceError("not converged", "the averaged motion was not finite; use method exact")
        return state, rows

    def difference(self, one, other):
        """Return the largest difference in v between two runs over the second half of the burst."""
        late = np.abs(one[1] - other[1])[self.compared, 0]
        return max(float(np.max(late)), abs(float(one[0][2] - other[0][2])))


def averaged_run(
    slider: Slider, orbits: tuple[Orbit, ...], problem, begin, cycles: int, stride: int, tolerance: float
):
    """Return (motion, rows, error, statistics) of a burst of at least 3 cycles.

    `begin` is the motion at phase 0, which is moved; rows (v, z_s) every `stride` cycles, z_s without its fast part;
    `error` of v in scaled units. The error is the sum of three parts: steps and quadrature, from a second run with half
    the steps and fewer nodes; for a run of first order its difference to second order, both with the coarse steps; and
    what second order leaves (`LEFT_OF_FIRST`, `LEFT_OF_RATIO`).
    """
    refuse_unless_applicable(slider, orbits)
    begin.turn(1)
    turn = 2.0 * math.pi
    ends = stride * np.arange(1, cycles // stride + 1)
    inner = (ends > 1) & (ends < cycles)
    stop = turn * (cycles - 2)
    at = np.minimum(turn * (ends[inner] - 1.0), stop)
    compared = turn * np.unique(np.linspace(cycles // 2, cycles - 2, COMPARED).astype(int))
    phases = np.union1d(at, compared)
    unit = reference_speed(0.0, orbits) / problem.speed
    burst = _Transient(
        problem, begin.state[:3].copy(), phases, np.isin(phases, compared), stop, unit, np.zeros(2, np.int64)
    )
    rows = np.zeros((ends.size, 2))
    rows[ends <= 1] = begin.state[2], begin.state[0]

    allowed = max(min(tolerance, 1e-3), 1e-9)
    per_period = int(min(8.0 * max(1.0, 1e-4 / allowed) ** 0.4, 96.0))
    few, nodes = (8, 10) if allowed >= 1e-5 else (12, 16)
    coarse = [burst.follow(harmonics, 2.0 * allowed, per_period // 2, few) for harmonics in (0, HARMONICS)]
    averaging = burst.difference(*coarse)
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    left = LEFT_OF_FIRST * averaging + LEFT_OF_RATIO * ratio**2 * unit
    corrected = averaging + left > 0.7 * tolerance * unit
    state, found = fine = burst.follow(HARMONICS if corrected else 0, allowed, per_period, nodes)
    steps = burst.difference(fine, coarse[corrected]) / STEP_GAIN
    error = steps + left + (0.0 if corrected else averaging)
    rows[inner] = found[np.searchsorted(phases, at)]
    # a cycle forgets its deformations: one for those it starts with, one for the motion
    begin.place(*state, 0.0)
    begin.turn(1)
    begin.place(*state, begin.state[3:])
    begin.turn(1)
    rows[ends >= cycles] = begin.state[2], begin.state[0]
    statistics = {
        "cycles": cycles, "order": 2 if corrected else 1, "bounce_steps": int(burst.work[0]),
        "velocity_steps": int(burst.work[1]),
    }  # fmt: skip
    return begin, rows, error, statistics
