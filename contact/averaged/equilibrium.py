r"""The averaged equilibrium of a slider that is heavy on the wave's time scale: one search over any cycle means.

In the units of `problem`, with h the mean approach, V the mean velocity, <> the means over a cycle of the wave, and the
sums over the contacts,

    h'' = p - <sum P>(h) (1 + chi h') - d_n h'      the bounce,
    V'  = <sum Q>(h, V) - d_t V - q                 the velocity.

P and Q are the normal and the tangential force of a contact, p the preload, q the load, chi the damping of a contact,
and d_n and d_t the dampers of the slider.

At rest h follows from <sum P> = p (`riding`) and V from <sum Q>(V) = d_t V + q, which `balanced_speed` searches between
rest and the velocity at which every contact slips all the time. The search takes the mean from any provider with a
function `net_force(problem, means, v)`, the mean force that accelerates the slider along the wave:

    `ClosedForm`                     cycles in closed form between exact events (`cycle_mean`), here
    `event_equilibrium.EventCycles`  cycles of the event-driven solver, for laws that the closed form does not know
    `endless_bounce.Heights`         several heights of a bounce
    `coupled_motion.CoupledSearch`   rows of contacts, with tilts, a soft backing or a wave that they load: each mean is
                                     taken in the equilibrium of these unknowns at that v (`coupled_equilibrium`)

For a body that is held on a prescribed wave, whose only other unknown is h, this search is compiled as a whole
(`solve_equilibrium`).

All this is first-order averaging, error O((f_n/f)^2). The correction of second order feeds the fast part of the
slider's own motion, the answer to the harmonics of the forces, back into the cycle (`cycle_mean.respond`); at a steady
height and velocity its fixed point is the full periodic motion but for the harmonics left out.
"""

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import ContactMean, clear, contact_cycles, cycle, respond
from contact.averaged.cycle_pieces import BACKWARD, FORWARD, Counted, Cycle, Mean, cycle_arrays
from contact.averaged.riding import Rule, mean_normal_force, quadrature, riding, riding_approach
from contact.body import Coordinates, damping_force, normal_amplitude, tangential_amplitude
from contact.codes import Status
from contact.error_estimate import quadrature_error, tail_error
from contact.jit.compiled import compiled, formula, per_thread
from contact.problem import changed, full_friction, load_direction, repeated
from contact.roots import narrowed, trial


class Entry(IntEnum):
    """Columns of an answer: of the equilibrium, and from REGIME on what `sweep_kernel` adds.

    Scaled, and SI units where `sweep_kernel` returns them; errors are over max(|v|, omega |u_x|/10).
    """

    VELOCITY = 0  # mean
    FIRST_ORDER = 1  # the velocity of first order
    HEIGHT = 2  # mean approach
    HELD = 3  # 1 or 0
    LOAD_SIGN = 4
    COARSE = 5  # velocity of first order by the coarse rule
    RESIDUAL = 6  # of the velocity
    MADE_PER_CYCLE = 7  # contacts that close
    SLIPS_PER_CYCLE = 8  # slips that begin
    TAIL = 9  # error of the velocity by harmonics left out
    QUADRATURE = 10  # error of the velocity by quadrature
    LEAST_AT_REST = 11  # mean tangential force of a cycle at rest
    LARGEST_AT_REST = 12
    REGIME = 13  # `codes.SteadyRegime`
    ERROR = 14  # of the velocity
    FROM_WAVE = 15  # error of the velocity by that of the wave
    THRUST = 16  # load at which the slider stalls
    THRUST_ERROR = 17
    STATUS = 18  # `codes.Status`


# Nodes per smooth piece of a cycle: those of the search, and those of the answer.
NODES, FINE_NODES = 16, 24
# Rounding of a mean tangential force over mu F, of a sum over many contacts: what does not exceed a load by more than
# that does not move the slider.
ROUNDING = 1e-12
# Relative step of `tangential_slopes`: the means have 12 digits, so that the derivatives have four
DIFFERENCE = 1e-5


class Work(NamedTuple):
    """Work arrays of the averaged equations."""

    # Quadrature of the search and of the answer
    rule: Rule
    fine: Rule
    # Of first order, without fast motion, and of second order
    first: Cycle
    second: Cycle


class ClosedForm(NamedTuple):
    """Cycle means between exact events, at one height."""

    rule: Rule
    height: float
    work: Work
    net_force: Callable


@per_thread
def work_arrays(harmonics: int) -> Work:
    """Return the work arrays for so many harmonics of the fast motion."""
    return Work(quadrature(NODES), quadrature(FINE_NODES), cycle_arrays(1), cycle_arrays(harmonics, FINE_NODES))


@compiled
def settle(problem, rule, h, v, work, most, close=1e-13):
    """Set fast motion, means and height of the cycle that repeats at mean velocity v; return (h, residual change).

    `work` is a `Cycle`; the first guess is its fast motion and `h`, and each round gains a factor of about (f_n/f)^2.
    The search ends where a round changes them by less than `close`.
    """
    change, fast = np.inf, work.fast
    for _ in range(most):
        cycle(problem, h, v, FORWARD, rule, work)
        _, slope = mean_normal_force(problem, h, rule)
        step = (problem.preload - work.means[Mean.NORMAL]) / slope if slope > 0.0 else 0.0
        a, b, c, d = fast.normal_cos[0], fast.normal_sin[0], fast.tangential_cos[0], fast.tangential_sin[0]
        respond(problem, work)
        h += step
        change = max(abs(step), abs(fast.normal_cos[0] - a), abs(fast.normal_sin[0] - b))
        change = max(change, abs(fast.tangential_cos[0] - c), abs(fast.tangential_sin[0] - d))
        if change < close:
            break
    return h, change


@formula
def net_force(problem, mean, v):
    """Return the force that accelerates the slider under a mean tangential force of the contacts, load and damper."""
    return mean + damping_force(problem, Coordinates(0.0, v)).along - problem.load


@compiled
def net_force_at(problem, rule, h, v, before, work):
    """Return the mean net force, of first order, on a slider at a mean approach and velocity."""
    cycle(problem, h, v, before, rule, work.first)
    return net_force(problem, work.first.means[Mean.TANGENTIAL], v)


@compiled
def _net_force(problem, means, v):
    return net_force_at(problem, means.rule, means.height, v, FORWARD, means.work)


@formula
def full_slip_speed(paths, c):
    """Return the slider velocity beyond which every contact slips all the time, max |u_x| + c |u_z|, scaled.

    With c = 0 it is the largest velocity of the surface along the wave.
    """
    top = 0.0
    for i in range(paths.height.size):
        top = max(top, tangential_amplitude(paths, i) + c * normal_amplitude(paths, i))
    return top


class BalancedSpeed(NamedTuple):
    """Result of `balanced_speed`."""

    status: int
    way: float  # direction of the motion, +1 or -1; 0 if friction holds the slider
    velocity: float
    force: float  # net force at that velocity
    slope: float  # of the force in the velocity
    top: float  # range of the search


@formula
def balanced_speed(problem, means, least, largest, fastest, close):
    """Return the velocity at which the mean net force vanishes, as a `BalancedSpeed`.

    `least` and `largest` bound the mean tangential force of a cycle at rest: the slider is held under a load between
    them. `fastest` is the speed beyond which every contact slips all the time; the search ends where a step is below
    `close` of its range. Of `problem` the friction coefficient, preload, load and tangential damping are used.
    """
    friction = full_friction(problem)
    if least - problem.load > ROUNDING * friction:
        way, fa = 1.0, least - problem.load
    elif largest - problem.load < -ROUNDING * friction:
        way, fa = -1.0, largest - problem.load
    else:
        return BalancedSpeed(Status.DONE, 0.0, 0.0, 0.0, 0.0, fastest)
    a, b = 0.0, way * fastest
    fb = means.net_force(problem, means, b)
    if fb * way >= 0.0:  # full friction does not balance the load: the damper has to
        if problem.tangential_damping == 0.0:
            return BalancedSpeed(Status.RUNAWAY, way, 0.0, 0.0, 0.0, fastest)
        for _ in range(60):  # one step where friction does not fall with speed
            b += 1.000001 * fb / problem.tangential_damping
            fb = means.net_force(problem, means, b)
            if fb * way < 0.0:
                break
    v, top, v_old, f_old = b, abs(b), a, fa
    slope = (fb - fa) / (b - a)
    for count in range(100):
        v = trial(a, fa, b, fb, count)
        f = means.net_force(problem, means, v)
        if v != v_old:
            slope = (f - f_old) / (v - v_old)
        moved = abs(v - v_old)
        v_old, f_old = v, f
        a, fa, b, fb = narrowed(a, fa, b, fb, v, f)
        if f == 0.0 or abs(f) < 1e-13 * friction or moved < close * top:
            break
    return BalancedSpeed(Status.DONE, way, v, f_old, slope, top)


@compiled
def solve_equilibrium(problem, harmonics, work, out):
    """Fill an equilibrium, its columns by `Entry`; return the reason for ending.

    `harmonics` of the fast motion; 0: first order. The load is taken with the sign with which it opposes the unloaded
    motion.
    """
    for k in range(out.size):
        out[k] = 0.0
    h = riding(problem, work.rule)
    out[Entry.HEIGHT] = h
    _fill_rest_forces(problem, h, work, out)
    sticks = work.first.counts[Counted.STUCK] > 0
    load = problem.load * load_direction(out[Entry.LARGEST_AT_REST])
    problem = changed(problem, load, problem.paths)
    out[Entry.LOAD_SIGN] = -1.0 if load < 0.0 else 1.0
    status, top, slope = _first_order(problem, h, 1e-11 if harmonics == 0 else 1e-5, work, out)
    if status != Status.DONE or harmonics == 0 or not slope < 0.0:
        return status
    status = _second_order(problem, slope, top, work, out)
    return Status.STICKS if sticks and abs(out[Entry.VELOCITY]) < 1e-6 * top else status


@compiled
def _fill_rest_forces(problem, h, work, out):
    """Fill the least and the largest tangential force of a cycle at rest."""
    counts = work.first.counts
    least = largest = net_force_at(problem, work.fine, h, 0.0, FORWARD, work) + problem.load
    stuck = counts[Counted.STUCK]
    out[Entry.MADE_PER_CYCLE], out[Entry.SLIPS_PER_CYCLE] = counts[Counted.MADE], counts[Counted.SLIPS]
    if least - max(problem.load, 0.0) <= ROUNDING * full_friction(problem):
        # the slider may be held or move backwards
        largest = net_force_at(problem, work.fine, h, 0.0, BACKWARD, work) + problem.load
    counts[Counted.STUCK] = stuck
    out[Entry.LEAST_AT_REST], out[Entry.LARGEST_AT_REST] = least, largest


@compiled
def _first_order(problem, h, close, work, out):
    """Fill the velocity of first order and its errors; return (reason, range of the search, slope of the force in v).

    The search ends where a step is below `close` of its range. Of a held slider the slope is 0.
    """
    means = ClosedForm(work.rule, h, work, _net_force)
    least, largest = out[Entry.LEAST_AT_REST], out[Entry.LARGEST_AT_REST]
    status, way, v, force, slope, top = balanced_speed(
        problem, means, least, largest, full_slip_speed(problem.paths, problem.limit_slope), close
    )
    out[Entry.HELD] = 1.0 if way == 0.0 else 0.0
    if status != Status.DONE or way == 0.0:
        return status, top, 0.0
    # the search may stop early: Newton's step from there has an error of the square of the last step
    out[Entry.COARSE], out[Entry.RESIDUAL] = (v - force / slope if slope < 0.0 else v), abs(force / slope)
    f = net_force_at(problem, work.fine, h, v, FORWARD, work)
    out[Entry.QUADRATURE] = quadrature_error((f - force) / slope)
    if slope < 0.0:
        v -= f / slope
    out[Entry.VELOCITY], out[Entry.FIRST_ORDER] = v, v
    counts = work.first.counts
    out[Entry.MADE_PER_CYCLE], out[Entry.SLIPS_PER_CYCLE] = counts[Counted.MADE], counts[Counted.SLIPS]
    return status, top, slope


@compiled
def _second_order(problem, slope, top, work, out):
    """Correct the equilibrium by the slider's fast motion; return the reason for ending."""
    second = work.second
    clear(second.fast)
    h, v, v_old, f_old = out[Entry.HEIGHT], out[Entry.VELOCITY], out[Entry.VELOCITY], 0.0
    change = np.inf
    for count in range(40):
        h, change = settle(problem, work.fine, h, v, second, 1)
        f = net_force(problem, second.means[Mean.TANGENTIAL], v)
        if count > 1 and abs(v - v_old) > 1e-9 * top:
            new = (f - f_old) / (v - v_old)
            if 0.5 * slope > new > 2.0 * slope:  # a secant within a factor of two of the last slope; both < 0
                slope = new
        v_old, f_old = v, f
        v -= f / slope
        change = max(change, abs(f / slope))
        if change < 1e-12:
            break
    counts = second.counts
    out[Entry.VELOCITY], out[Entry.HEIGHT], out[Entry.RESIDUAL] = v, h, change
    out[Entry.MADE_PER_CYCLE], out[Entry.SLIPS_PER_CYCLE] = counts[Counted.MADE], counts[Counted.SLIPS]
    force, last, tail = second.force, second.force.tangential_cos.size - 1, 0.0
    for k in range(max(last - 2, 0), last + 1):
        along = np.hypot(force.tangential_cos[k], force.tangential_sin[k])
        tail = max(tail, along + problem.friction * np.hypot(force.normal_cos[k], force.normal_sin[k]))
    out[Entry.TAIL] = tail_error(tail, last + 1.0)
    return Status.DONE if change < 1e-7 else Status.UNSETTLED


def mean_tangential_forces(problem, speeds, before=FORWARD):
    """Return the mean tangential forces, scaled, of cycles at these scaled velocities, of first order.

    `before`: side of the motion before a velocity of 0, one for all or one for each.
    """
    work, n = work_arrays(1), problem.contacts
    h, sides = riding_approach(problem, FINE_NODES), np.broadcast_to(before, np.shape(speeds))
    forces = np.empty(len(speeds))
    for side in set(sides.tolist()):
        # every contact at every velocity is a contact by itself: one call of the kernel
        chosen = np.flatnonzero(sides == side)
        cycles = np.empty((len(ContactMean), n * len(chosen)))
        velocities = np.repeat(np.asarray(speeds, float)[chosen], n)
        contact_cycles(repeated(problem, len(chosen)), h, velocities, side, work.fine, work.second, cycles)
        forces[chosen] = cycles[ContactMean.TANGENTIAL].reshape(len(chosen), n).sum(axis=1)
    return forces


def rest_forces(problem):
    """Return the least and the largest mean tangential force of a cycle at rest; they differ where a contact sticks."""
    least, largest = mean_tangential_forces(problem, np.zeros(2), (FORWARD, BACKWARD))
    return float(least), float(largest)


def tangential_slopes(problem, height, speed):
    """Return the derivatives of the mean tangential force of contacts and damper in mean approach and velocity.

    By one-sided differences of cycles of first order, forwards in the direction of the motion.
    """
    work = work_arrays(1)
    steps = DIFFERENCE * max(abs(height), 1e-3), DIFFERENCE * (speed + np.copysign(1e-3, speed))
    at, higher, faster = (
        net_force_of(problem, work, h, v)
        for h, v in ((height, speed), (height + steps[0], speed), (height, speed + steps[1]))
    )
    return (higher - at) / steps[0], (faster - at) / steps[1]


def net_force_of(problem, work, h, v):
    """Return what `net_force_at` returns, called from Python."""
    cycle(problem, h, v, FORWARD, work.rule, work.first)
    return net_force(problem, work.first.means[Mean.TANGENTIAL], v)
