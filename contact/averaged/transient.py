r"""The averaged equations through time: first the bounce with the velocity, then the velocity alone.

As long as the slider bounces, the classical Runge-Kutta method follows height and height's rate in fixed steps. The
velocity changes by 1e-4 of its range in such a step, and is advanced with the mean tangential force at the middle of
the step (`follow_bounce`). The effect of the bounce on this force is quadratic in its amplitude. When it is below the
tolerance, only the velocity equation remains (`accelerate`), which is solved by Dormand and Prince's pair of orders 5
and 4 with its continuous extension (Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, II.5-6).
"""

from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import clear, cycle, respond
from contact.averaged.cycle_pieces import Counted, Mean
from contact.averaged.equilibrium import force_left, full_slip_speed, settle, work_arrays
from contact.averaged.riding import Rule, mean_normal_force, riding
from contact.body import Coordinates, body_force, contact_force
from contact.codes import Status
from contact.events.segment import At, Column
from contact.jit.compiled import compiled, native
from contact.stepping.end_corrections import cubic

# A step whose error stays above the tolerance is shortened this many times, each time to between 0.2 and 0.9 of it. The
# error falls with the step at least in proportion, so that more rejections mean rates without bound.
MAX_REJECTED = 60
# Change of height and fast motion, over the tolerance of a step, below which a stage's cycle counts as settled. The
# next round would change them by (f_n/f)^2 of it.
CLOSE = 0.1
_TABLE = np.array(
    [
        [0.0] * 6,
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
_ERROR = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
_DENSE = np.array(
    [
        -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    ]
)  # fmt: skip


@compiled
def _bounce_acceleration(problem, h, w, gain, rule):
    """Return h'' of the bounce at (h, h'); `gain` is the second-order correction of the mean force."""
    force, _ = mean_normal_force(problem, h, rule)
    own = body_force(problem, Coordinates(-w, 0.0))
    return -own.normal - contact_force(problem, force + gain, w)


@compiled
def _bounce_step(problem, h, w, gain, rule, d):
    """Return (h, h') after a step d of the classical Runge-Kutta method."""
    a1 = _bounce_acceleration(problem, h, w, gain, rule)
    w2 = w + 0.5 * d * a1
    a2 = _bounce_acceleration(problem, h + 0.5 * d * w, w2, gain, rule)
    w3 = w + 0.5 * d * a2
    a3 = _bounce_acceleration(problem, h + 0.5 * d * w2, w3, gain, rule)
    w4 = w + d * a3
    a4 = _bounce_acceleration(problem, h + d * w3, w4, gain, rule)
    return h + d / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4), w + d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


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
def follow_bounce(problem, state, span, work):
    """Follow bounce and velocity until the bounce is negligible or the end; return (phase, samples taken, `Status`).

    `state`, here (h, h', V), is overwritten. `gain` is the second-order correction of the mean normal force; it is
    kept from the middle of one step to the next. `largest` is the largest squared amplitude in a period of the bounce.
    """
    rule = span.rule
    stop, per_period, at, record = span.stop, span.per_period, span.at, span.record
    h_end = riding(problem, rule)
    _, slope = mean_normal_force(problem, max(h_end, state[At.POSITION]), rule)
    rate = np.sqrt(slope)
    dt = 2.0 * np.pi / rate / per_period
    h, w, v = state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY]
    phase, taken, gain, tangential_force, largest, steps = 0.0, 0, 0.0, 0.0, 0.0, 0
    while phase < stop:
        d = min(dt, stop - phase)
        h0, w0, v0 = h, w, v
        middle, w = _bounce_step(problem, h, w, gain, rule, 0.5 * d)
        h, w = _bounce_step(problem, middle, w, gain, rule, 0.5 * d)
        v_middle = v + 0.5 * d * force_left(problem, tangential_force, v)
        for _ in range(2 if steps == 0 else 1):  # in the first step there is no force of the step before
            if span.second_order:
                cycle(problem, middle, v_middle, rule, work.second)
                respond(problem, work.second)
                cycle(problem, middle, v_middle, rule, work.second)
                force, _ = mean_normal_force(problem, middle, rule)
                gain = work.second.means[Mean.NORMAL] - force
                tangential_force = work.second.means[Mean.TANGENTIAL]
                stuck = work.second.counts[Counted.STUCK]
            else:
                cycle(problem, middle, v_middle, rule, work.first)
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
            record[taken, Column.VELOCITY] = v0 + s * (v - v0)
            record[taken, Column.POSITION] = -cubic(s, h0, h, d * w0, d * w)
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
        cycle(problem, h, v, rule, work)
    return force_left(problem, work.means[Mean.TANGENTIAL], v), h


@compiled
def accelerate(problem, state, phase, taken, span, work, k):
    """Follow the velocity without the bounce; return the `Status`. `k`: (7,) work array, the stages' rates."""
    stop, at, record, tolerance = span.stop, span.at, span.record, 0.1 * span.tolerance
    h, v, rule, second = state[At.POSITION], state[At.VELOCITY], span.rule, work.second
    max_rounds, close = 3 if span.second_order else 0, CLOSE * tolerance
    if span.second_order:
        averaged_rate(problem, h, v, rule, second, 8, close)
    else:  # the fast motion stays that of the start
        h = riding(problem, rule)
    k[0], h = averaged_rate(problem, h, v, rule, second, max_rounds, close)
    top = full_slip_speed(problem.paths, 0.0)
    d = min(stop - phase, 0.02 * top / (abs(k[0]) + 1e-300))
    rejected = 0
    while phase < stop:
        d = min(d, stop - phase)
        if stop - phase - d < 1e-9 * stop:
            d = stop - phase
        for i in range(1, 7):
            new_v = v  # of the last stage: the velocity after the step
            for j in range(i):
                new_v += d * _TABLE[i, j] * k[j]
            k[i], h = averaged_rate(problem, h, new_v, rule, second, max_rounds, close)
        error = 0.0
        for i in range(7):
            error += d * _ERROR[i] * k[i]
        error = abs(error) / tolerance
        if second.counts[Counted.STUCK] > 0:
            return Status.STICKS
        if not np.isfinite(error) or (error > 1.0 and rejected == MAX_REJECTED):
            return Status.UNSETTLED
        if error > 1.0:
            d *= max(0.2, 0.9 * error**-0.2)
            rejected += 1
            continue
        rejected = 0
        # rise, bend, fourth and last are the coefficients 2 to 5 of the continuous extension as in CONTD5 of Hairer and
        # Wanner's program DOPRI5
        rise = new_v - v
        bend = d * k[0] - rise
        fourth = rise - d * k[6] - bend
        last = 0.0
        for i in range(7):
            last += d * _DENSE[i] * k[i]
        while taken < at.size and at[taken] <= phase + d * (1.0 + 1e-12):
            s = (at[taken] - phase) / d
            record[taken, Column.VELOCITY] = v + s * (rise + (1.0 - s) * (bend + s * (fourth + (1.0 - s) * last)))
            record[taken, Column.POSITION] = -h
            taken += 1
        phase += d
        v = new_v
        k[0] = k[6]
        d *= min(5.0, 0.9 * max(error, 1e-10) ** -0.2)
    state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY] = h, 0.0, v
    return Status.DONE


@native("t f1 t t f1")
def _response(problem, state, span, work, k):
    """Fill the answer of `response`; return the `Status`."""
    rule, second, speed = span.rule, work.second, state[At.VELOCITY]
    clear(second.fast)
    h, w, v = -state[At.POSITION], -state[At.NORMAL_VELOCITY], speed
    # the mean motion at phase 0 is the state less the fast motion, which depends on the mean motion: three rounds
    for _ in range(3):
        cycle(problem, h, v, rule, second)
        if second.counts[Counted.STUCK] > 0:
            return Status.STICKS
        respond(problem, second)
        fast_height, fast_rate, fast_speed = fast_state(second.fast)
        h, w, v = fast_height - state[At.POSITION], fast_rate - state[At.NORMAL_VELOCITY], speed - fast_speed
    state[At.POSITION], state[At.NORMAL_VELOCITY], state[At.VELOCITY] = h, w, v
    phase, taken, why = follow_bounce(problem, state, span, work)
    if why == Status.DONE and phase < span.stop:
        why = accelerate(problem, state, phase, taken, span, work, k)
    if not span.second_order:
        clear(second.fast)
        cycle(problem, state[At.POSITION], state[At.VELOCITY], rule, second)
        respond(problem, second)
    fast_height, fast_rate, fast_speed = fast_state(second.fast)
    state[At.POSITION] = fast_height - state[At.POSITION]
    state[At.NORMAL_VELOCITY] = fast_rate - state[At.NORMAL_VELOCITY]
    state[At.VELOCITY] = state[At.VELOCITY] + fast_speed
    for m in range(span.at.size):
        span.record[m, Column.VELOCITY] += fast_speed
    return why


def response(problem, state, span: Span, harmonics: int) -> int:
    """Follow the mean motion over a span; return the `Status`.

    `state` holds (z_s, z_s', v) at phase 0 on entry and at the end on return.
    """
    return _response(problem, state, span, work_arrays(harmonics), np.zeros(7))
