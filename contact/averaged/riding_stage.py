r"""Second stage of the averaged transient: the velocity alone, of a slider whose bounce has decayed.

The slider rides at the approach at which the mean normal force balances the preload. Of second order this approach and
the fast motion follow the velocity; of first order they are those of the start. The velocity equation is solved by
Dormand's and Prince's pair of orders 5 and 4 with its continuous extension (`runge_kutta.integrate`).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.averaged_state import AveragedMotion, Stage
from contact.averaged.cycle_mean import cycle
from contact.averaged.cycle_pieces import FORWARD, Counted, Cycle, Mean
from contact.averaged.equilibrium import full_slip_speed, net_force, settle
from contact.averaged.riding import Rule, riding
from contact.averaged.runge_kutta import Stages, integrate, stages
from contact.codes import Recorded, Status
from contact.jit.compiled import compiled
from contact.problem import Problem

# Change of approach and fast motion, over the tolerance of a step, below which a stage's cycle counts as settled. The
# next round would change them by (f_n/f)^2 of it.
CLOSE = 0.1
# Rounds of `equilibrium.settle`: at the start, and in each stage of second order, which begins where the last one ended
FIRST_ROUNDS, ROUNDS = 8, 3
STEP_TOLERANCE = 0.1  # of one step over that of the run
FIRST_STEP = 0.02  # change of the velocity in the first step to try, over that of full slip


class VelocityArrays(NamedTuple):
    """Work arrays of the velocity."""

    velocity: np.ndarray  # (1,): V
    approach: np.ndarray  # (1,): see `VelocityEquation`
    stages: Stages


def velocity_arrays() -> VelocityArrays:
    """Return the work arrays of the velocity."""
    return VelocityArrays(np.zeros(1), np.zeros(1), stages(1))


class VelocityEquation(NamedTuple):
    """The equation of the mean velocity without a bounce, for `runge_kutta.integrate`."""

    problem: Problem
    rule: Rule
    cycle: Cycle
    max_rounds: int
    close: float
    approach: np.ndarray  # (1,): h, which follows the velocity
    record: np.ndarray
    rates: Callable
    sampled: Callable


@compiled
def averaged_rate(problem, approach, velocity, rule, work, max_rounds, close):
    """Return (V', h): the scaled acceleration at the scaled mean velocity, and the riding approach.

    The approach follows after at most `max_rounds` rounds of `equilibrium.settle`; 0 keeps it. A round that changes
    approach and fast motion by less than `close` is the last one, and the means are those of its cycle.
    """
    change = np.inf
    if max_rounds > 0:
        approach, change = settle(problem, rule, approach, velocity, work, max_rounds, close)
    if change >= close:
        cycle(problem, approach, velocity, FORWARD, rule, work)
    return net_force(problem, work.means[Mean.TANGENTIAL], velocity), approach


@compiled
def _velocity_rates(equation, time, unknowns, out):
    """Fill the rate of V and the approach."""
    out[0], equation.approach[0] = averaged_rate(
        equation.problem, equation.approach[0], unknowns[0], equation.rule, equation.cycle, equation.max_rounds,
        equation.close,
    )  # fmt: skip
    return Status.STICKS if equation.cycle.counts[Counted.STUCK] > 0 else Status.DONE


@compiled
def _record_position(equation, number):
    """Record the position at a sample whose velocity has been recorded."""
    equation.record[number, Recorded.POSITION] = -equation.approach[0]


@compiled
def follow_velocity(problem, start, span, work, arrays):
    """Follow the velocity from the end of the `Stage` before to the end of the run; return the `Stage`."""
    rule, second = span.rule, work.second
    tolerance = STEP_TOLERANCE * span.tolerance
    max_rounds, close = ROUNDS if span.second_order else 0, CLOSE * tolerance
    velocity, approach, rates = arrays.velocity, arrays.approach, arrays.stages.rates
    approach[0], velocity[0] = start.motion.approach, start.motion.velocity
    if span.second_order:
        averaged_rate(problem, approach[0], velocity[0], rule, second, FIRST_ROUNDS, close)
    else:  # the fast motion stays that of the start
        approach[0] = riding(problem, rule)
    equation = VelocityEquation(
        problem, rule, second, max_rounds, close, approach, span.record, _velocity_rates, _record_position
    )
    _velocity_rates(equation, start.phase, velocity, rates[0])
    step = FIRST_STEP * full_slip_speed(problem.paths, 0.0) / (abs(rates[0, 0]) + 1e-300)
    step = min(span.stop - start.phase, step)
    status = integrate(equation, span, tolerance, start.phase, start.taken, velocity, step, arrays.stages)
    if status != Status.DONE:
        return Stage(status, start.motion, start.phase, start.taken)
    return Stage(Status.DONE, AveragedMotion(approach[0], 0.0, velocity[0]), span.stop, span.at.size)
