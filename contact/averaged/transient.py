r"""The averaged equations through time: first the bounce with the velocity, then the velocity alone.

As long as the slider bounces, the classical Runge-Kutta method follows height and height's rate in fixed steps. The
velocity changes by 1e-4 of its range in such a step, and is advanced with the mean tangential force at the middle of
the step (`follow_bounce`). The effect of the bounce on this force is quadratic in its amplitude. When it is below the
tolerance, only the velocity equation remains (`accelerate`), which is solved by Dormand and Prince's pair of orders 5
and 4 with its continuous extension (`runge_kutta`).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import clear, cycle, respond
from contact.averaged.cycle_pieces import FORWARD, Counted, Cycle, Mean
from contact.averaged.equilibrium import force_left, full_slip_speed, settle, work_arrays
from contact.averaged.riding import Rule, mean_normal_force, mean_pull, riding
from contact.averaged.runge_kutta import CLASSICAL, Stages, integrate, runge_kutta_step, stages
from contact.body import Coordinates, body_force, contact_force
from contact.codes import At, Recorded, Status
from contact.jit.compiled import compiled, native
from contact.problem import Problem
from contact.stepping.end_corrections import cubic

# Change of height and fast motion, over the tolerance of a step, below which a stage's cycle counts as settled. The
# next round would change them by (f_n/f)^2 of it.
CLOSE = 0.1


class Arrays(NamedTuple):
    """Work arrays of the integration."""

    y: np.ndarray  # (2,): h and h' of the bounce; later V alone
    kept: np.ndarray  # (1,): what a rate leaves for the next one
    stages: Stages


def integration_arrays() -> Arrays:
    """Return the work arrays of the integration."""
    return Arrays(np.zeros(2), np.zeros(1), stages(2))


class Bounce(NamedTuple):
    """The bounce about the riding height, for `runge_kutta_step`; its quantities are h and h'."""

    problem: Problem
    rule: Rule
    gain: np.ndarray  # (1,): correction of the mean normal force by second order
    rates: Callable


@compiled
def _bounce_rates(bounce, time, y, out):
    """Fill the rates of (h, h')."""
    h, w = y
    force, _ = mean_normal_force(bounce.problem, h, bounce.rule)
    own = body_force(bounce.problem, Coordinates(-w, 0.0))
    pull = mean_pull(bounce.problem, h) if bounce.problem.normal.pull > 0.0 else 0.0
    out[0], out[1] = w, -own.normal - (contact_force(bounce.problem, force + pull + bounce.gain[0], w) - pull)
    return Status.DONE


@compiled
def _bounce_step(bounce, y, d, stages):
    """Fill `stages.new` with (h, h') after a step d of the classical Runge-Kutta method."""
    bounce.rates(bounce, 0.0, y, stages.rates[0])
    runge_kutta_step(CLASSICAL, bounce, 0.0, y, d, stages)


@compiled
def fast_state(fast):
    """Return what the fast motion adds to z_s, z_s' and v at phase 0."""
    fast_height = fast_rate = speed = 0.0
    for k in range(fast.normal_cos.size):
        fast_height += fast.normal_cos[k]
        fast_rate += (k + 1) * fast.normal_sin[k]
        speed += (k + 1) * fast.tangential_sin[k]
    return fast_height, fast_rate, speed


class Span(NamedTuple):
    """End and accuracy of a run, and what it records."""

    stop: float  # phase at the end, a whole number of cycles
    tolerance: float  # of V; also the squared amplitude below which the bounce is neglected
    per_period: int  # steps per period of the bounce
    rule: Rule  # quadrature of a smooth piece, of at most `equilibrium.FINE_NODES` nodes
    second_order: int  # 1: with the correction of second order, 0: without
    at: np.ndarray  # (k,): phases at which v and z_s are recorded, increasing
    record: np.ndarray  # (k, 2): v and z_s at these phases


@compiled
def follow_bounce(problem, state, span, work, arrays):
    """Follow bounce and velocity until the bounce is negligible or the end; return (phase, samples taken, `Status`).

    `state`, here (h, h', V), is overwritten. `gain`, the second-order correction of the mean normal force, is kept
    from the middle of one step to the next. `largest` is the largest squared amplitude in a period of the bounce.
    """
    rule = span.rule
    stop, per_period, at, record = span.stop, span.per_period, span.at, span.record
    h_end = riding(problem, rule)
    _, slope = mean_normal_force(problem, max(h_end, state[At.POSITION]), rule)
    rate = np.sqrt(slope)
    dt = 2.0 * np.pi / rate / per_period
    h, w, v = state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY]
    phase, taken, tangential_force, largest, steps = 0.0, 0, 0.0, 0.0, 0
    y, gain, new = arrays.y, arrays.kept, arrays.stages.new
    gain[0] = 0.0
    bounce = Bounce(problem, rule, gain, _bounce_rates)
    while phase < stop:
        d = min(dt, stop - phase)
        h0, w0, v0 = h, w, v
        y[0], y[1] = h, w
        _bounce_step(bounce, y, 0.5 * d, arrays.stages)
        middle, y[0], y[1] = new[0], new[0], new[1]
        _bounce_step(bounce, y, 0.5 * d, arrays.stages)
        h, w = new
        v_middle = v + 0.5 * d * force_left(problem, tangential_force, v)
        for _ in range(2 if steps == 0 else 1):  # in the first step there is no force of the step before
            if span.second_order:
                cycle(problem, middle, v_middle, FORWARD, rule, work.second)
                respond(problem, work.second)
                cycle(problem, middle, v_middle, FORWARD, rule, work.second)
                force, _ = mean_normal_force(problem, middle, rule)
                gain[0] = work.second.means[Mean.NORMAL] - force
                tangential_force = work.second.means[Mean.TANGENTIAL]
                stuck = work.second.counts[Counted.STUCK]
            else:
                cycle(problem, middle, v_middle, FORWARD, rule, work.first)
                tangential_force, stuck = work.first.means[Mean.TANGENTIAL], work.first.counts[Counted.STUCK]
            v_middle = v + 0.5 * d * force_left(problem, tangential_force, v_middle)
        if stuck > 0:
            return phase, taken, Status.STICKS
        # trapezoidal rule for the damper
        v = (v * (1.0 - 0.5 * d * problem.tangential_damping) + d * (tangential_force - problem.load)) / (
            1.0 + 0.5 * d * problem.tangential_damping
        )
        if not np.isfinite(h + w + v):
            return phase, taken, Status.UNSETTLED
        while taken < at.size and at[taken] <= phase + d * (1.0 + 1e-12):
            s = (at[taken] - phase) / d
            record[taken, Recorded.VELOCITY] = v0 + s * (v - v0)
            record[taken, Recorded.POSITION] = -cubic(s, h0, h, d * w0, d * w)
            taken += 1
        phase += d
        steps += 1
        largest = max(largest, (h - h_end) ** 2 + (w / rate) ** 2)
        if steps % per_period == 0:
            if largest < span.tolerance:
                break
            largest = 0.0
    state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY] = h, w, v
    return phase, taken, Status.DONE


@compiled
def averaged_rate(problem, h, v, rule, work, max_rounds, close):
    """Return (V', h): the scaled acceleration at the scaled mean velocity `v`, and the riding height.

    The height follows after at most `max_rounds` rounds of `equilibrium.settle`; 0 keeps it. A round that changes
    height and fast motion by less than `close` is the last one, and the means are those of its cycle.
    """
    change = np.inf
    if max_rounds > 0:
        h, change = settle(problem, rule, h, v, work, max_rounds, close)
    if change >= close:
        cycle(problem, h, v, FORWARD, rule, work)
    return force_left(problem, work.means[Mean.TANGENTIAL], v), h


class Speed(NamedTuple):
    """The mean velocity without a bounce, for `runge_kutta.integrate`."""

    problem: Problem
    rule: Rule
    cycle: Cycle
    max_rounds: int
    close: float
    height: np.ndarray  # (1,): h, which follows the velocity
    record: np.ndarray
    rates: Callable
    sampled: Callable


@compiled
def _speed_rates(speed, time, y, out):
    """Fill the rate of V and the height."""
    out[0], speed.height[0] = averaged_rate(
        speed.problem, speed.height[0], y[0], speed.rule, speed.cycle, speed.max_rounds, speed.close
    )
    return Status.STICKS if speed.cycle.counts[Counted.STUCK] > 0 else Status.DONE


@compiled
def _speed_sampled(speed, number):
    """Record the height."""
    speed.record[number, Recorded.POSITION] = -speed.height[0]


@compiled
def accelerate(problem, state, phase, taken, span, work, arrays):
    """Follow the velocity without the bounce; return the `Status`."""
    tolerance, rule, second, h = 0.1 * span.tolerance, span.rule, work.second, arrays.kept
    y, k, max_rounds, close = arrays.y[:1], arrays.stages.rates, 3 if span.second_order else 0, CLOSE * tolerance
    h[0], y[0] = state[At.POSITION], state[At.VELOCITY]
    if span.second_order:
        averaged_rate(problem, h[0], y[0], rule, second, 8, close)
    else:  # the fast motion stays that of the start
        h[0] = riding(problem, rule)
    speed = Speed(problem, rule, second, max_rounds, close, h, span.record, _speed_rates, _speed_sampled)
    _speed_rates(speed, phase, y, k[0])
    d = min(span.stop - phase, 0.02 * full_slip_speed(problem.paths, 0.0) / (abs(k[0, 0]) + 1e-300))
    why = integrate(speed, span, tolerance, phase, taken, y, d, arrays.stages)
    if why == Status.DONE:
        state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY] = h[0], 0.0, y[0]
    return why


@native("t f1 t t t")
def _response(problem, state, span, work, arrays):
    """Fill the answer of `response`; return the `Status`."""
    rule, second, speed = span.rule, work.second, state[At.VELOCITY]
    clear(second.fast)
    h, w, v = -state[At.POSITION], -state[At.NORMAL_VELOCITY], speed
    # the mean motion at phase 0 is the state less the fast motion, which depends on the mean motion: three rounds
    for _ in range(3):
        cycle(problem, h, v, FORWARD, rule, second)
        if second.counts[Counted.STUCK] > 0:
            return Status.STICKS
        respond(problem, second)
        fast_height, fast_rate, fast_speed = fast_state(second.fast)
        h, w, v = fast_height - state[At.POSITION], fast_rate - state[At.NORMAL_VELOCITY], speed - fast_speed
    state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY] = h, w, v
    phase, taken, why = follow_bounce(problem, state, span, work, arrays)
    if why == Status.DONE and phase < span.stop:
        why = accelerate(problem, state, phase, taken, span, work, arrays)
    if not span.second_order:
        clear(second.fast)
        cycle(problem, state[At.POSITION], state[At.VELOCITY], FORWARD, rule, second)
        respond(problem, second)
    fast_height, fast_rate, fast_speed = fast_state(second.fast)
    state[At.POSITION] = fast_height - state[At.POSITION]
    state[At.NORMAL_VELOCITY] = fast_rate - state[At.NORMAL_VELOCITY]
    state[At.VELOCITY] = state[At.VELOCITY] + fast_speed
    for m in range(span.at.size):
        span.record[m, Recorded.VELOCITY] += fast_speed
    return why


def response(problem, state, span: Span, harmonics: int) -> int:
    """Follow the mean motion over a span; return the `Status`.

    `state` holds (z_s, z_s', v) at phase 0 on entry and at the end on return.
    """
    return _response(problem, state, span, work_arrays(harmonics), integration_arrays())
