r"""First stage of the averaged transient: the bounce of the slider together with its velocity, in fixed steps.

The classical Runge-Kutta method follows the mean approach h and its rate h' in two half steps. The velocity V changes
by 1e-4 of its range in a whole step, and is advanced with the mean tangential force at the middle of the step.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.averaged_state import AveragedMotion, Stage
from contact.averaged.cycle_mean import cycle, respond
from contact.averaged.cycle_pieces import FORWARD, Counted, Mean
from contact.averaged.equilibrium import net_force
from contact.averaged.riding import Rule, mean_normal_force, mean_pull, riding
from contact.averaged.runge_kutta import CLASSICAL, Stages, runge_kutta_step, stages
from contact.body import Coordinates, body_force, contact_force
from contact.codes import Recorded, Status
from contact.jit.compiled import compiled
from contact.problem import Problem
from contact.stepping.end_corrections import cubic


class BounceArrays(NamedTuple):
    """Work arrays of the bounce."""

    bounce: np.ndarray  # (2,): h and h' at the start of a step
    correction: np.ndarray  # (1,): see `BounceEquation`
    stages: Stages


def bounce_arrays() -> BounceArrays:
    """Return the work arrays of the bounce."""
    return BounceArrays(np.zeros(2), np.zeros(1), stages(2))


class BounceEquation(NamedTuple):
    """The equation of the bounce, for `runge_kutta_step`; its unknowns are h and h'."""

    problem: Problem
    rule: Rule
    # (1,): of the mean normal force by second order, kept from the middle of one step to the next
    correction: np.ndarray
    rates: Callable


@compiled
def _bounce_rates(bounce, time, unknowns, out):
    """Fill the rates of (h, h')."""
    approach, rate = unknowns
    problem = bounce.problem
    force, _ = mean_normal_force(problem, approach, bounce.rule)
    own = body_force(problem, Coordinates(-rate, 0.0))
    pull = mean_pull(problem, approach) if problem.normal.pull > 0.0 else 0.0
    out[0] = rate
    out[1] = -own.normal - (contact_force(problem, force + pull + bounce.correction[0], rate) - pull)
    return Status.DONE


@compiled
def _half_step(equation, step, arrays):
    """Return (h, h') half a step after `arrays.bounce`."""
    start, new = arrays.bounce, arrays.stages.new
    equation.rates(equation, 0.0, start, arrays.stages.rates[0])
    runge_kutta_step(CLASSICAL, equation, 0.0, start, 0.5 * step, arrays.stages)
    return new[0], new[1]


@compiled
def _force_at_middle(problem, approach, velocity, span, work, correction):
    """Return (mean tangential force, contacts that stick) at the middle of a step; set the second-order correction."""
    if span.second_order == 0:
        cycle(problem, approach, velocity, FORWARD, span.rule, work.first)
        return work.first.means[Mean.TANGENTIAL], work.first.counts[Counted.STUCK]
    second = work.second
    cycle(problem, approach, velocity, FORWARD, span.rule, second)
    respond(problem, second)
    cycle(problem, approach, velocity, FORWARD, span.rule, second)
    first_order_force, _ = mean_normal_force(problem, approach, span.rule)
    correction[0] = second.means[Mean.NORMAL] - first_order_force
    return second.means[Mean.TANGENTIAL], second.counts[Counted.STUCK]


@compiled
def _advanced_velocity(problem, velocity, tangential_force, step):
    """Return V after a step under a mean force, with the trapezoidal rule for the damper."""
    damped = 0.5 * step * problem.tangential_damping
    return (velocity * (1.0 - damped) + step * (tangential_force - problem.load)) / (1.0 + damped)


@compiled
def _record_step(span, taken, phase, step, old, new):
    """Record the samples within a step, V linear and h cubic in it; return how many are taken now."""
    while taken < span.at.size and span.at[taken] <= phase + step * (1.0 + 1e-12):
        s = (span.at[taken] - phase) / step
        span.record[taken, Recorded.VELOCITY] = old.velocity + s * (new.velocity - old.velocity)
        span.record[taken, Recorded.POSITION] = -cubic(s, old.approach, new.approach, step * old.rate, step * new.rate)
        taken += 1
    return taken


@compiled
def follow_bounce(problem, motion, span, work, arrays):
    """Follow bounce and velocity until the bounce is negligible or the run ends; return the `Stage`.

    The bounce is negligible when its largest squared amplitude in a period is below `span.tolerance`.
    """
    riding_approach = riding(problem, span.rule)
    _, slope = mean_normal_force(problem, max(riding_approach, motion.approach), span.rule)
    resonance = np.sqrt(slope)
    longest = 2.0 * np.pi / resonance / span.per_period
    arrays.correction[0] = 0.0
    equation = BounceEquation(problem, span.rule, arrays.correction, _bounce_rates)
    phase, taken, steps, tangential_force, largest = 0.0, 0, 0, 0.0, 0.0
    while phase < span.stop:
        step = min(longest, span.stop - phase)
        arrays.bounce[0], arrays.bounce[1] = motion.approach, motion.rate
        middle, middle_rate = _half_step(equation, step, arrays)
        arrays.bounce[0], arrays.bounce[1] = middle, middle_rate
        approach, rate = _half_step(equation, step, arrays)
        v_middle = motion.velocity + 0.5 * step * net_force(problem, tangential_force, motion.velocity)
        stuck = 0
        for _ in range(2 if steps == 0 else 1):  # the first step has no force of a step before
            tangential_force, stuck = _force_at_middle(problem, middle, v_middle, span, work, arrays.correction)
            v_middle = motion.velocity + 0.5 * step * net_force(problem, tangential_force, v_middle)
        if stuck > 0:
            return Stage(Status.STICKS, motion, phase, taken)
        new = AveragedMotion(approach, rate, _advanced_velocity(problem, motion.velocity, tangential_force, step))
        if not np.isfinite(new.approach + new.rate + new.velocity):
            return Stage(Status.UNSETTLED, motion, phase, taken)
        taken = _record_step(span, taken, phase, step, motion, new)
        motion = new
        phase += step
        steps += 1
        largest = max(largest, (approach - riding_approach) ** 2 + (rate / resonance) ** 2)
        if steps % span.per_period == 0:
            if largest < span.tolerance:
                break
            largest = 0.0
    return Stage(Status.DONE, motion, phase, taken)
