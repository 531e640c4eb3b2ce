r"""The averaged equations through time, in two stages: the bounce with the velocity, then the velocity alone.

As long as the slider bounces about its riding height, `bouncing_stage` follows height and velocity in fixed steps. The
effect of the bounce on the mean tangential force is quadratic in its amplitude. When it is below the tolerance, only
the velocity equation remains, which `riding_stage` solves with steps of variable length.
"""

from typing import NamedTuple

from contact.averaged.averaged_state import Span, averaged_motion, fast_state, set_state
from contact.averaged.bouncing_stage import BounceArrays, bounce_arrays, follow_bounce
from contact.averaged.cycle_mean import clear, cycle, respond
from contact.averaged.cycle_pieces import FORWARD
from contact.averaged.equilibrium import Work, work_arrays
from contact.averaged.riding_stage import VelocityArrays, follow_velocity, velocity_arrays
from contact.codes import Recorded, Status
from contact.jit.compiled import native, per_thread


class Arrays(NamedTuple):
    """Work arrays of a run."""

    cycles: Work
    bounce: BounceArrays
    velocity: VelocityArrays


@per_thread
def run_arrays(harmonics: int) -> Arrays:
    """Return the work arrays for so many harmonics of the fast motion."""
    return Arrays(work_arrays(harmonics), bounce_arrays(), velocity_arrays())


@native("t f1 t t")
def _response(problem, state, span, arrays):
    """Do the work of `response`."""
    second = arrays.cycles.second
    sticks, motion = averaged_motion(problem, state, span.rule, second)
    if sticks:
        return Status.STICKS
    stage = follow_bounce(problem, motion, span, arrays.cycles, arrays.bounce)
    if stage.status == Status.DONE and stage.phase < span.stop:
        stage = follow_velocity(problem, stage, span, arrays.cycles, arrays.velocity)
    if stage.status != Status.DONE:
        return stage.status
    if span.second_order == 0:  # the fast motion is still that of the start
        clear(second.fast)
        cycle(problem, stage.motion.approach, stage.motion.velocity, FORWARD, span.rule, second)
        respond(problem, second)
    set_state(state, stage.motion, second.fast)
    _, _, fast_velocity = fast_state(second.fast)
    for m in range(span.at.size):
        span.record[m, Recorded.VELOCITY] += fast_velocity
    return Status.DONE


def response(problem, state, span: Span, harmonics: int) -> int:
    """Follow the averaged motion over a span; return the `Status`.

    `state` holds (z_s, z_s', v) at phase 0 on entry and, if the status is DONE, at the end on return.
    """
    return _response(problem, state, span, run_arrays(harmonics))
