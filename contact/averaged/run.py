r"""The averaged method: a slider that is heavy on the wave's time scale, many cycles at once.

The bounce equation and the velocity equation (`equilibrium`, `transient`) take the event-exact mean of the tangential
force over a cycle. First order errs by O((f_n/f)^2); with the slider's fast motion fed back (second
order) the steady state is the full periodic motion but for the harmonics left out, and v(t) is a hundred times closer.
The first and the last cycle of a run are followed event by event: the start from rest is no cycle that repeats, and
averaging does not give the deformations of the contacts at the end.

It does not apply to a stiff contact (f_n/f above 0.1), to a `slider.stick_band`, to other laws than the elastic
one, or where a contact sticks through whole cycles, because its traction then depends on its history.
"""

import math

import numpy as np

from contact.averaged.riding import quadrature
from contact.averaged.transient import Span, response
from contact.codes import Status
from contact.convergence_error import ConvergenceError
from contact.orbit import Orbit
from contact.slider import Slider

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
STICKS = (
    "not applicable",
    "the averaged method does not apply: a contact sticks through whole cycles; use method stepped or exact",
)
NOT_FINITE = "not converged", "the averaged motion was not finite; use method exact"


def refusals(slider: Slider, orbits: tuple[Orbit, ...], stiffest: float = STIFFEST) -> tuple[str, ...]:
    """Return why averaging does not apply; nothing where it does."""
    why: tuple[str, ...] = ()
    if slider.law != "elastic" or slider.reciprocal:
        why += ("it knows the elastic law without its reciprocal force only",)
    if slider.stick_band > 0.0:
        why += ("slider.stick_band needs the events",)
    if slider.limit_slope == 0.0 or slider.preload == 0.0:
        why += ("there is no friction force",)
    if all(orbit.normal == 0 and orbit.tangential == 0 for orbit in orbits):
        why += ("there is no wave",)
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    if ratio > stiffest:
        why += (
            f"the contact is too stiff: it resonates at {ratio:.3g} of the wave's frequency, more than {stiffest}",
        )
    rate = max(slider.normal_damping, slider.tangential_damping) / (slider.mass * orbits[0].omega)
    if rate > stiffest**2:
        why += (f"the dampers act within {1.0 / rate:.3g} radians of the wave",)
    return why


def refuse_unless_applicable(slider: Slider, orbits: tuple[Orbit, ...], stiffest: float = STIFFEST) -> None:
    """Raise if averaging does not apply."""
    why = refusals(slider, orbits, stiffest)
    if why:
        raise ConvergenceError(
            "not applicable", f"the averaged method does not apply: {', '.join(why)}; use method exact"
        )


def averaged_run(burst, begin):
    """Return (motion, rows, error, statistics) of a `methods.Burst` of at least 3 cycles.

    `begin` is the motion at phase 0, which is moved; rows (v, z_s), z_s without its fast part; `error` of v in scaled
    units. The error is the sum of three parts: steps and quadrature, from a second run with half the steps and fewer
    nodes; for a run of first order its difference to second order, both with the coarse steps; and what second order
    leaves (`LEFT_OF_FIRST`, `LEFT_OF_RATIO`).
    """
    cycles, tolerance, unit, turn = burst.cycles, burst.tolerance, burst.reference(), 2.0 * math.pi
    begin.turn(1)
    ends = burst.stride * np.arange(1, cycles // burst.stride + 1)
    inner = (ends > 1) & (ends < cycles)
    at = turn * (ends[inner] - 1.0)
    compared = turn * np.unique(np.linspace(cycles // 2, cycles - 2, COMPARED).astype(int))
    phases = np.union1d(at, compared)
    late, stop = np.isin(phases, compared), turn * (cycles - 2)

    def follow(harmonics, allowed, per_period, nodes):
        """Return (state at the end, rows) of one run: v to `allowed` of the unit, so many steps per bounce."""
        state, rows = begin.state[:3].copy(), np.zeros((phases.size, 2))
        rule, corrected = quadrature(nodes), int(harmonics > 0)
        span = Span(stop, allowed * unit, per_period, rule, corrected, phases, rows)
        why = response(burst.problem, state, span, HARMONICS)
        if why != Status.DONE:
            raise ConvergenceError(*(STICKS if why == Status.STICKS else NOT_FINITE))
        return state, rows

    def difference(one, other):
        """Return the largest difference in v between two runs over the second half of the burst."""
        return max(float(np.max(np.abs(one[1] - other[1])[late, 0])), abs(float(one[0][2] - other[0][2])))

    allowed = max(min(tolerance, 1e-3), 1e-9)
    per_period = int(min(8.0 * max(1.0, 1e-4 / allowed) ** 0.4, 96.0))
    few, nodes = (8, 10) if allowed >= 1e-5 else (12, 16)
    coarse = [follow(harmonics, 2.0 * allowed, per_period // 2, few) for harmonics in (0, HARMONICS)]
    averaging = difference(*coarse)
    ratio = burst.slider.normal_resonance(len(burst.orbits)) / burst.orbits[0].frequency
    left = LEFT_OF_FIRST * averaging + LEFT_OF_RATIO * ratio**2 * unit
    corrected = averaging + left > 0.7 * tolerance * unit
    state, found = fine = follow(HARMONICS if corrected else 0, allowed, per_period, nodes)
    steps = difference(fine, coarse[corrected]) / STEP_GAIN
    error = steps + left + (0.0 if corrected else averaging)
    rows = np.zeros((ends.size, 2))
    rows[ends <= 1] = begin.state[2], begin.state[0]
    rows[inner] = found[np.searchsorted(phases, at)]
    # A cycle of slip forgets the deformations at its start. The first turn, from deformations of 0, gives those at
    # phase 0; the second, from the averaged motion with these, is the last cycle of the run.
    begin.place(*state, 0.0)
    begin.turn(1)
    begin.place(*state, begin.state[3:])
    begin.turn(1)
    rows[ends >= cycles] = begin.state[2], begin.state[0]
    return begin, rows, error, {"cycles": cycles, "order": 2 if corrected else 1}
