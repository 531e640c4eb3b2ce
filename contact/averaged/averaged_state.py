r"""The averaged motion and the state of the slider: they differ by the motion within a cycle.

The *averaged motion* is the mean approach h, its rate h' and the mean velocity V. The *state* holds z_s, z_s' and v at
phase 0 of a cycle. With the fast motion, the answer of the slider to the harmonics of the forces
(`cycle_mean.respond`),

    z_s = fast z_s - h,    z_s' = fast z_s' - h',    v = V + fast v.                                                (1)
"""

from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import clear, cycle, respond
from contact.averaged.cycle_pieces import FORWARD, Counted
from contact.averaged.riding import Rule
from contact.codes import At
from contact.jit.compiled import compiled


class AveragedMotion(NamedTuple):
    """Mean approach, its rate and mean velocity, scaled."""

    approach: float  # h, of a contact of height 0
    rate: float  # h'
    velocity: float  # V


class Span(NamedTuple):
    """End and accuracy of a run, and what it records."""

    stop: float  # phase at the end, a whole number of cycles
    tolerance: float  # of V; also the squared amplitude below which the bounce is neglected
    per_period: int  # steps per period of the bounce
    rule: Rule  # quadrature of a smooth piece, of at most `equilibrium.FINE_NODES` nodes
    second_order: int  # 1: with the correction of second order, 0: without
    at: np.ndarray  # (k,): phases at which v and z_s are recorded, increasing
    record: np.ndarray  # (k, 2): v and z_s at these phases, by `Recorded`


class Stage(NamedTuple):
    """How far one stage of a run has come: its `Status` and, if that is DONE, the averaged motion at its end."""

    status: int
    motion: AveragedMotion
    phase: float
    taken: int  # samples recorded up to this phase


@compiled
def fast_state(fast):
    """Return the fast parts of z_s, z_s' and v at phase 0."""
    position = normal_velocity = velocity = 0.0
    for k in range(fast.normal_cos.size):
        position += fast.normal_cos[k]
        normal_velocity += (k + 1) * fast.normal_sin[k]
        velocity += (k + 1) * fast.tangential_sin[k]
    return position, normal_velocity, velocity


@compiled
def averaged_motion(problem, state, rule, work):
    """Return (whether a contact sticks through the cycle, the averaged motion of a state) by equation (1).

    The fast motion depends on the averaged motion: it is left in `work`, a `Cycle`, after three rounds.
    """
    motion = AveragedMotion(-state[At.POSITION], -state[At.NORMAL_VELOCITY], state[At.VELOCITY])
    clear(work.fast)
    for _ in range(3):
        cycle(problem, motion.approach, motion.velocity, FORWARD, rule, work)
        if work.counts[Counted.STUCK] > 0:
            return True, motion
        respond(problem, work)
        position, normal_velocity, velocity = fast_state(work.fast)
        motion = AveragedMotion(
            position - state[At.POSITION], normal_velocity - state[At.NORMAL_VELOCITY], state[At.VELOCITY] - velocity
        )
    return False, motion


@compiled
def set_state(state, motion, fast):
    """Set a state to that of an averaged motion by equation (1)."""
    position, normal_velocity, velocity = fast_state(fast)
    state[At.POSITION] = position - motion.approach
    state[At.NORMAL_VELOCITY] = normal_velocity - motion.rate
    state[At.VELOCITY] = motion.velocity + velocity
