r"""Averaged method for a burst: one integration step covers many wave cycles of a heavy slider.

The averaged equations for height and velocity (`equilibrium`, `transient`) contain the mean tangential force over a
cycle, integrated exactly between events. First-order averaging has an error of O((f_n/f)^2). Second-order averaging
includes the slider's motion within a cycle: its steady state equals the full periodic motion except for neglected
harmonics, and its v(t) is about a hundred times more accurate. The event-driven solver computes the first and the last
cycle of a run, because the start from rest is not a repeating cycle and averaging does not give the deformations of the
contacts at the end.

The method does not apply to stiff contacts (f_n/f above 0.1), with `slider.stick_band`, or to laws other than the
elastic one. It also does not apply if a contact sticks through whole cycles, because the mean tangential force then
depends on the history.
"""

import math

import numpy as np

from contact.averaged.averaged_state import Span
from contact.averaged.riding import quadrature
from contact.averaged.transient import response
from contact.codes import At, Recorded, Status
from contact.error_estimate import averaged_steps_error, second_order_burst_error
from contact.exceptions import ConvergenceError
from contact.orbit import Orbits
from contact.slider import Slider

# largest f_n/f for v(t), and for the steady state with second-order correction
STIFFEST, STIFFEST_STEADY = 0.1, 0.3
HARMONICS = 8
# number of times in the second half of a burst at which two runs are compared
COMPARED = 24
STICKS = (
    "not applicable",
    "the averaged method does not apply: a contact sticks through whole cycles; use method stepped or exact",
)
UNSETTLED = "not converged", "the averaged motion was not finite or changed too abruptly; use method exact"


def refusals(slider: Slider, orbits: Orbits, stiffest: float = STIFFEST, *, memory: bool = False) -> tuple[str, ...]:
    """Return the reasons why averaging does not apply; empty if it does.

    ``memory``: whether the means are those of cycles of the event-driven solver, which knows the hysteretic law.
    """
    why: tuple[str, ...] = ()
    if (slider.law != "elastic" and not memory) or slider.reciprocal:
        why += ("it knows the elastic law without its reciprocal force only",)
    if slider.stick_band > 0.0:
        why += ("slider.stick_band needs the events",)
    if slider.profile.hold is not None:
        why += ("it knows no contact that holds on beyond the touch",)
    if slider.slope_unit == 0.0 or slider.preload == 0.0:
        why += ("there is no friction force",)
    if orbits.still:
        why += ("there is no wave",)
    ratio = slider.normal_resonance(len(orbits)) / orbits.frequency
    if ratio > stiffest:
        why += (f"the contact is too stiff: it resonates at {ratio:.3g} of the wave's frequency, more than {stiffest}",)
    rate = max(slider.normal_damping, slider.tangential_damping) / (slider.mass * orbits.omega)
    if rate > stiffest**2:
        why += (f"the dampers act within {1.0 / rate:.3g} radians of the wave",)
    return why


def refuse_unless_applicable(
    slider: Slider, orbits: Orbits, stiffest: float = STIFFEST, *, memory: bool = False
) -> None:
    """Raise a `ConvergenceError` if averaging does not apply; ``memory`` as in `refusals`."""
    why = refusals(slider, orbits, stiffest, memory=memory)
    if why:
        raise ConvergenceError(
            "not applicable", f"the averaged method does not apply: {', '.join(why)}; use method exact"
        )


def averaged_run(burst, motion, checked):
    """Return (motion, record, error, check, statistics) of a `burst_question.Burst` of at least 3 cycles.

    `motion` is the motion after the first cycle; it is advanced to the end of the burst. The record has (v, z_s); z_s
    excludes the motion within a cycle. `error` is that of v at the end, scaled. `checked` are numbers of cycles inside
    the burst after which the motion is compared with the exact one; `check` has v there and the error that is stated
    for these. An error is the sum of three parts:

    - step size and quadrature, from a second run with half the steps and fewer nodes;
    - for a first-order run, the difference between first and second order, both with the coarse steps;
    - the error of second-order averaging.
    """
    cycles, tolerance, unit, turn = burst.cycles, burst.tolerance, burst.reference(), 2.0 * math.pi
    ends = burst.stride * np.arange(1, cycles // burst.stride + 1)
    inner = (ends > 1) & (ends < cycles)
    compared = 1 + np.unique(np.linspace(cycles // 2, cycles - 2, COMPARED).astype(int))
    numbers = np.unique(np.concatenate([ends[inner], compared, checked]))
    late, early = np.searchsorted(numbers, compared), np.searchsorted(numbers, checked)
    phases, stop = turn * (numbers - 1.0), turn * (cycles - 2)

    def follow(second_order, v_tolerance, per_period, nodes):
        """Return (final state, record) of a run with `per_period` steps per bounce and this relative tolerance on v."""
        state, record = motion.carried.slider.copy(), np.zeros((phases.size, 2))
        span = Span(stop, v_tolerance * unit, per_period, quadrature(nodes), int(second_order), phases, record)
        why = response(burst.problem, state, span, HARMONICS)
        if why != Status.DONE:
            raise ConvergenceError(*(STICKS if why == Status.STICKS else UNSETTLED))
        return state, record

    def differences(one, other):
        """Return the largest difference in v between two runs in the second half of the burst, and where checked."""
        apart = np.abs(one[1][:, Recorded.VELOCITY] - other[1][:, Recorded.VELOCITY])
        last = abs(one[0][At.VELOCITY] - other[0][At.VELOCITY])
        return np.array([max(np.max(apart[late]), last), np.max(apart[early], initial=0.0)])

    v_tolerance = max(min(tolerance, 1e-3), 1e-9)
    per_period = int(min(8.0 * max(1.0, 1e-4 / v_tolerance) ** 0.4, 96.0))
    few, nodes = (8, 10) if v_tolerance >= 1e-5 else (12, 16)
    first, second = (follow(order, 2.0 * v_tolerance, per_period // 2, few) for order in (False, True))
    averaging = differences(first, second)
    ratio = burst.slider.normal_resonance(len(burst.orbits)) / burst.orbits.frequency
    second_order = second_order_burst_error(averaging, ratio, unit)
    second_order_needed = averaging[0] + second_order[0] > 0.7 * tolerance * unit
    state, averaged_record = fine = follow(second_order_needed, v_tolerance, per_period, nodes)
    steps = averaged_steps_error(differences(fine, second if second_order_needed else first), v_tolerance * unit)
    error, stated = steps + second_order + (0.0 if second_order_needed else averaging)
    record = np.zeros((ends.size, 2))
    record[ends <= 1] = motion.state[At.VELOCITY], motion.state[At.POSITION]
    record[inner] = averaged_record[np.searchsorted(numbers, ends[inner])]
    # The contacts slip within a cycle, so that the deformations at its start do not matter. The first cycle, started
    # with zero deformations, gives those at phase 0. The second cycle starts from the averaged state with these
    # deformations and is the last cycle of the burst.
    motion.set_state(*state, 0.0)
    motion.turn(1)
    motion.set_state(*state, motion.carried.deformation)
    motion.turn(1)
    record[ends >= cycles] = motion.state[At.VELOCITY], motion.state[At.POSITION]
    check = averaged_record[early, Recorded.VELOCITY], float(stated)
    return motion, record, float(error), check, {"cycles": cycles, "order": 2 if second_order_needed else 1}
