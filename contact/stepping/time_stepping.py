r"""Many cycles in fixed steps: the Verlet method with the stop operator as a projection.

The deformation follows the surface and is cut to the slip limit, [-X(z), X(z)]. The slider is heavy on the wave's time
scale, so that its own step has a small error. Most of the error of a plain projection arises at the events: contact,
release, end of stick, and x = 0. They are therefore located within the step, on cubics through values and rates, and
the deformation is computed from there. The trapezoidal sums of the forces get the terms of a fractional power at an
edge (`end_corrections`). The surface motion of one cycle is tabulated.

An envelope scales the wave, u = Re(e U exp(i phi)). Amplitude and phase of e are linear between its knots; they are
evaluated at every step.

The method does not apply with a stick band (creep) or if the step does not resolve the contact resonance.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.body import Coordinates, Point, approach, approach_rate, at_phase, body_force, contact_force, travel
from contact.codes import At, Recorded
from contact.exceptions import ConvergenceError
from contact.jit.compiled import compiled, native
from contact.law.holding import (
    approach_at,
    attraction,
    closes_as_point,
    depth,
    depth_rate,
    is_open,
    made_depth,
    opens_as_point,
    stiffness,
)
from contact.law.normal import curvature, load, slope
from contact.law.normal import force as elastic_force
from contact.law.protocol import slip_limit, slip_rate
from contact.problem import contact_parameters
from contact.stepping import end_corrections as edges


class StepSlider(IntEnum):
    """Indices in `Work.slider`."""

    POSITION = 0
    NORMAL_VELOCITY = 1
    VELOCITY = 2
    NORMAL = 3  # sum of the contacts' normal forces
    TANGENTIAL = 4
    TRAVELLED = 5  # since the start of the cycle
    STEP = 6  # phase of a time step
    DAMP_N = 7  # factors of the dampers on the velocities in a step
    DAMP_T = 8


class SurfaceRow(IntEnum):
    """Planes of `Work.table`: surface displacement and velocity at the steps of a cycle."""

    U_Z = 0
    U_X = 1
    W_Z = 2
    W_X = 3


class StepContact(IntEnum):
    """First index of `Work.contact`: approach, deformation, sign of slip or 0.

    Of a contact that holds on beyond the touch (`law.holding`) the depth stands for the approach of a closed one, and
    the approach, at most 0, for itself of an open one.
    """

    Z = 0
    X = 1
    SLIP = 2


class Knots(NamedTuple):
    """An envelope: amplitude and phase of the factor on the wave, linear between its knots and constant beyond them."""

    at: np.ndarray  # (k,): phase of the wave, rad, rising
    amplitude: np.ndarray  # (k,)
    angle: np.ndarray  # (k,), rad


class Task(NamedTuple):
    """What a run does and records."""

    number: int  # of cycles
    per_cycle: int  # steps
    stride: int  # cycles per recorded sample; 0: none
    record: np.ndarray  # (number // stride, len(Recorded))
    envelope: Knots


class Work(NamedTuple):
    """Work arrays."""

    table: np.ndarray  # (len(SurfaceRow), steps + 1, n): surface motion
    contact: np.ndarray  # (len(StepContact), n)
    slider: np.ndarray  # (len(StepSlider),)


class Passage(NamedTuple):
    """Motion of one contact in a step."""

    h: float  # phase of the step
    z_old: float  # approach at its start
    z_new: float  # and at its end
    z_rate_old: float
    z_rate_new: float
    x_rate_old: float  # of the deformation while it sticks
    x_rate_new: float
    along: float  # travel of the surface less that of the slider
    z_bend: float  # z''
    x_bend: float


@compiled
def factor(envelope, phase, j):
    """Return (factor on the wave, its rate, knot before this phase); the search for this knot begins at knot j."""
    at, amplitude, angle = envelope.at, envelope.amplitude, envelope.angle
    while j + 1 < at.size and at[j + 1] <= phase:
        j += 1
    a, p, a_rate, p_rate = amplitude[j], angle[j], 0.0, 0.0
    if j + 1 < at.size and phase >= at[j]:
        width = at[j + 1] - at[j]
        a_rate, p_rate = (amplitude[j + 1] - a) / width, (angle[j + 1] - p) / width
        a, p = a + a_rate * (phase - at[j]), p + p_rate * (phase - at[j])
    turn = complex(np.cos(p), np.sin(p))
    return a * turn, complex(a_rate, a * p_rate) * turn, j


@compiled
def tabulate_cycle(paths, per_cycle, cycle, envelope, j, table):
    """Fill scaled displacement and velocity of the surface in one cycle under an envelope; return the knot at its end.

    `table` (4, per_cycle + 1, contacts) is in the order of `SurfaceRow`; `cycle` is the number of the cycle, j the knot
    of the envelope from which `factor` searches.
    """
    h = 2.0 * np.pi / per_cycle
    for k in range(per_cycle + 1):
        co, si = np.cos(h * (k % per_cycle)), np.sin(h * (k % per_cycle))
        e, turn, j = factor(envelope, 2.0 * np.pi * cycle + h * k, j)
        for i in range(paths.height.size):
            u_z, w_z, u_x, w_x = at_phase(paths, i, co, si)
            table[SurfaceRow.U_Z, k, i] = e.real * u_z + e.imag * w_z
            table[SurfaceRow.W_Z, k, i] = e.real * w_z - e.imag * u_z + turn.real * u_z + turn.imag * w_z
            table[SurfaceRow.U_X, k, i] = e.real * u_x + e.imag * w_x
            table[SurfaceRow.W_X, k, i] = e.real * w_x - e.imag * u_x + turn.real * u_x + turn.imag * w_x
    return j


@compiled
def _slip_speeds(contact, passage, sign):
    """Return the speeds of slip of a sign at the ends of the step."""
    before = Point(passage.z_old, 0.0, passage.z_rate_old, passage.x_rate_old)
    after = Point(passage.z_new, 0.0, passage.z_rate_new, passage.x_rate_new)
    return slip_rate(contact, sign, before), slip_rate(contact, sign, after)


@compiled
def _leave_stick(contact, passage, x):
    """Return (sign, excess of Q) of a contact that leaves stick towards where its deformation goes."""
    old, new = passage.z_old, passage.z_new
    sign = 1.0 if x + passage.along > 0.0 else -1.0
    v_old, v_new = _slip_speeds(contact, passage, sign)
    below, above = sign * x - slip_limit(contact, old), sign * (x + passage.along) - slip_limit(contact, new)
    return sign, -sign * edges.slip_edge(contact, old, new, below, above, v_old, v_new, passage.h)


@compiled
def _release(contact, passage, x, slip):
    """Return (x, slip, excess of P, excess of Q) of a contact that opens."""
    h = passage.h
    r0, r1 = h * passage.z_rate_old, h * passage.z_rate_new
    s = edges.rising_root(-passage.z_old, -passage.z_new, -r0, -r1)
    rate = max(-(r0 + s * (r1 - r0)) / h, 1e-6)
    first, second = edges.contact_edge(contact, rate, passage.z_bend, h)
    sign, tangential = 1.0 if x > 0.0 else -1.0, 0.0
    if slip == 0.0:  # it must have slipped before
        sign, tangential = _leave_stick(contact, passage, x)
    normal = edges.edge_excess(s, h, first * (1.0 - contact.contact_damping * rate), second, contact.normal)
    normal += contact.stiffness * contact.normal.pull * h * (s - 0.5)
    if not contact.law.rated:
        tangential += sign * contact.friction * edges.edge_excess(s, h, first, second, contact.normal)
    return 0.0, 0.0, normal, tangential


@compiled
def _stick(contact, passage, x, sticks):
    """Return (x, slip, excess of Q) of a contact that sticks at the start of the step, or `sticks` all along."""
    limit, deformation = slip_limit(contact, passage.z_new), x + passage.along
    if sticks:  # past x = 0
        x_rate = passage.x_rate_new
        friction = contact.stiffness * contact.law.stuck(contact, passage.z_new, limit)
        bend = curvature(passage.z_new, contact.normal) * friction * x_rate * abs(x_rate) / (limit * limit)
        return deformation, 0.0, edges.passage_excess(x / (x - deformation), passage.h, bend)
    sign, excess = _leave_stick(contact, passage, x)
    _, v_new = _slip_speeds(contact, passage, sign)
    # it may slip and stick again within the step
    return sign * limit, sign if v_new >= 0.0 else 0.0, excess


@compiled
def _slip(contact, passage, sign):
    """Return (x, slip) of a contact that slips at the start of the step."""
    h, old, new = passage.h, slip_limit(contact, passage.z_old), slip_limit(contact, passage.z_new)
    v_old, v_new = _slip_speeds(contact, passage, sign)
    if v_new >= 0.0:
        return sign * new, sign
    if v_old <= 0.0:  # at its limit at the start of the step, and sticks from there
        return sign * old + passage.along, 0.0
    _, lag = edges.last_part(v_old, v_new, (sign * passage.along - (new - old)) / h)
    return sign * (new + h * lag), 0.0


@compiled
def _close(contact, passage):
    """Return (x, slip, excess of P, excess of Q) of a contact that closes."""
    h, profile, law = passage.h, contact.normal, contact.law
    c = law.limit_rate(contact, 0.0)
    r0, r1 = h * passage.z_rate_old, h * passage.z_rate_new
    s = edges.rising_root(passage.z_old, passage.z_new, r0, r1)
    y0, y1 = h * passage.x_rate_old, h * passage.x_rate_new
    rate, drift = max((r0 + s * (r1 - r0)) / h, 1e-6), (y0 + s * (y1 - y0)) / h
    sign = 1.0 if drift > 0.0 else -1.0
    first, second = edges.contact_edge(contact, rate, passage.z_bend, h)
    normal = edges.edge_excess(1.0 - s, h, first * (1.0 + contact.contact_damping * rate), second, profile)
    normal -= contact.stiffness * contact.normal.pull * h * (s - 0.5)
    ratio = min(sign * drift / (c * rate), 1.0)
    (share, steep), turn = edges.closing_share(ratio, profile), 0.0
    if ratio < 1.0:
        turn = steep * (sign * passage.x_bend / c - ratio * passage.z_bend) / rate
        turn = min(max(turn, -1.0 / h), 1.0 / h)
    excess = edges.edge_excess(1.0 - s, h, first * share, second * share + first * turn, profile)
    tangential = sign * contact.friction * excess
    if law.rated:
        tangential = 0.0
    x, limit = passage.along - edges.cubic(s, 0.0, passage.along, y0, y1), slip_limit(contact, passage.z_new)
    if ratio == 1.0:
        v_old, v_new = sign * drift - c * rate, _slip_speeds(contact, passage, sign)[1]
        if v_new >= 0.0:
            return sign * limit, sign, normal, tangential
        # slip ends within the step: what follows is stick from the limit there
        rest = (1.0 - s) * h * v_new / (v_new - v_old)
        return sign * (limit + 0.5 * rest * v_new), 0.0, normal, tangential
    if abs(x) < limit:
        return x, 0.0, normal, tangential
    sign = 1.0 if x > 0.0 else -1.0
    return sign * limit, sign, normal, tangential


@compiled
def _followed(z_old, z, hold):
    """Return what stands for an approach z in `StepContact.Z`, after what stood there before."""
    if hold is None:
        return z
    elif is_open(z, z_old <= 0.0, hold):
        return min(z, 0.0)
    else:
        return depth(z, hold)


@compiled
def _rates(z_rate, d, hold):
    """Return the rate of the depth of a closed contact; the approach's rate of an open one."""
    return z_rate * depth_rate(d, hold) if d > 0.0 else z_rate


@compiled
def _opened(contact, passage, z_new, x, slip, hold):
    """Return (x, slip, excess of P, excess of Q) of a contact that holds on and opens in the step, at `z_new`."""
    h, end, sign = passage.h, hold.end_depth, 1.0 if x > 0.0 else -1.0
    r0, r1 = h * passage.z_rate_old, h * passage.z_rate_new
    s = edges.rising_root(hold.leave - approach_at(passage.z_old, hold), hold.leave - z_new, -r0, -r1)
    rate = max(-(r0 + s * (r1 - r0)) / h, 1e-6)
    normal = edges.break_excess(s, h, rate, passage.z_bend, hold.elastic)
    normal -= edges.break_excess(s, h, rate, passage.z_bend, hold.attraction)
    normal = contact.stiffness * (normal - contact.contact_damping * rate * load(end, contact.normal) * h * (0.5 - s))
    friction, kept = contact.friction * contact.stiffness, abs(x + s * passage.along)
    tangential = friction * edges.break_excess(s, h, rate, passage.z_bend, hold.elastic)
    left = end - kept / contact.limit_slope
    if slip == 0.0 and left > 0.0:  # it sticks to the end: Q is less by what the spring lacks to the limit
        steep = -slope(left, contact.normal) * hold.elastic.root / slope(end, contact.normal) * np.sqrt(rate)
        tangential += friction * (
            edges.whole_excess(s, h, -load(left, contact.normal), 0.0) + steep * h * np.sqrt(h) * edges.zeta_one_half(s)
        )
    return 0.0, 0.0, normal, sign * tangential


@compiled
def _in_depth(passage, hold):
    """Return the passage of a contact that opens or closes as a point with depths in the place of approaches."""
    deeper = depth_rate(0.0, hold)
    old, new, rate_old, rate_new = passage.z_old, passage.z_new, passage.z_rate_old, passage.z_rate_new
    old, rate_old = (
        (old, _rates(rate_old, old, hold)) if old > 0.0 else (deeper * (old - hold.leave), deeper * rate_old)
    )
    new, rate_new = (
        (new, _rates(rate_new, new, hold)) if new > 0.0 else (deeper * (new - hold.leave), deeper * rate_new)
    )
    return Passage(
        passage.h, min(old, 0.0) if passage.z_old <= 0.0 else old, min(new, 0.0) if passage.z_new <= 0.0 else new,
        rate_old, rate_new, passage.x_rate_old, passage.x_rate_new, passage.along, deeper * passage.z_bend,
        passage.x_bend,
    )  # fmt: skip


@compiled
def _as_point(contact, passage, x, slip, hold):
    """Return (x, slip, excess of P, excess of Q) of a contact that holds on and opens or closes as a point in the step.

    Its elastic force and friction are those of a contact without adhesion at its depth. The attraction jumps.
    """
    moved, h = _in_depth(passage, hold), passage.h
    r0, r1 = h * passage.z_rate_old, h * passage.z_rate_new
    if moved.z_new <= 0.0:
        x, slip, normal, tangential = _release(contact, moved, x, slip)
        s = edges.rising_root(hold.leave - approach_at(passage.z_old, hold), hold.leave - passage.z_new, -r0, -r1)
        theta, rate = s, -(r0 + s * (r1 - r0)) / h
    else:
        x, slip, normal, tangential = _close(contact, moved)
        s = edges.rising_root(passage.z_old - hold.leave, approach_at(passage.z_new, hold) - hold.leave, r0, r1)
        theta, rate = 1.0 - s, (r0 + s * (r1 - r0)) / h
    fall = edges.break_excess(theta, h, max(rate, 1e-6), passage.z_bend, hold.attraction)
    return x, slip, normal - contact.stiffness * fall, tangential


@compiled
def _closed(contact, passage, z_old, hold):
    """Return (x, slip, excess of P, excess of Q) of a contact that holds on and closes in the step, from `z_old`."""
    h, d = passage.h, made_depth(hold)
    r0, r1 = h * passage.z_rate_old, h * passage.z_rate_new
    s = edges.rising_root(z_old - hold.make, approach_at(passage.z_new, hold) - hold.make, r0, r1)
    y0, y1 = h * passage.x_rate_old, h * passage.x_rate_new
    rate, drift = max((r0 + s * (r1 - r0)) / h, 1e-6), (y0 + s * (y1 - y0)) / h
    elastic = load(d, contact.normal)
    jump = elastic * (1.0 + contact.contact_damping * rate) - attraction(d, 0.0, hold)
    normal = contact.stiffness * edges.whole_excess(1.0 - s, h, jump, stiffness(d, hold) * rate)
    rise = contact.friction * contact.stiffness * slope(d, contact.normal) * drift / contact.limit_slope
    tangential = edges.whole_excess(1.0 - s, h, 0.0, rise)
    x, limit = passage.along - edges.cubic(s, 0.0, passage.along, y0, y1), slip_limit(contact, passage.z_new)
    if abs(x) < limit:
        return x, 0.0, normal, tangential
    sign = 1.0 if x > 0.0 else -1.0
    return sign * limit, sign, normal, tangential


@compiled
def _jumps(contact, passage, z_old, z_new, x, slip, sticks, hold):
    """Return what `_passed` does; `z_old` and `z_new` are approaches of a contact that opens or closes."""
    if hold is None:
        return _passed(contact, passage, x, slip, sticks)
    elif passage.z_new <= 0.0:
        if opens_as_point(hold):
            return _as_point(contact, passage, x, slip, hold)
        return _opened(contact, passage, z_new, x, slip, hold)
    elif passage.z_old <= 0.0:
        if closes_as_point(hold):
            return _as_point(contact, passage, x, slip, hold)
        return _closed(contact, passage, z_old, hold)
    else:
        return _passed(contact, passage, x, slip, sticks)


@compiled
def _passed(contact, passage, x, slip, sticks):
    """Return (x, slip, excess of P, excess of Q) after the step; an excess is that of the trapezoidal sum."""
    if passage.z_new <= 0.0:
        return _release(contact, passage, x, slip)
    if passage.z_old <= 0.0:
        return _close(contact, passage)
    if slip == 0.0:
        x, slip, excess = _stick(contact, passage, x, sticks)
        return x, slip, 0.0, excess
    x, slip = _slip(contact, passage, slip)
    return x, slip, 0.0, 0.0


@compiled
def _traction(contact, point, slip):
    """Return Q of a contact that touches, of the sign of its slip or, where that is 0, of its deformation."""
    law, z = contact.law, point.approach
    if slip != 0.0:
        return slip * contact.stiffness * law.sliding(contact, z, max(slip_rate(contact, slip, point), 0.0))
    force = contact.stiffness * law.stuck(contact, z, min(abs(point.deformation), slip_limit(contact, z)))
    return force if point.deformation > 0.0 else -force


@compiled
def one_step(problem, k, work):
    """Move the slider from step k of the cycle to the next."""
    table, own, slider = work.table, work.contact, work.slider
    h, paths = slider[StepSlider.STEP], problem.paths
    rate = Coordinates(slider[StepSlider.NORMAL_VELOCITY], slider[StepSlider.VELOCITY])
    force = body_force(problem, rate)
    normal_half = rate.normal + 0.5 * h * (slider[StepSlider.NORMAL] + force.normal)
    along_half = rate.along + 0.5 * h * (slider[StepSlider.TANGENTIAL] + force.along)
    q = Coordinates(slider[StepSlider.POSITION] + h * normal_half, h * along_half)
    # enough for rates at the step's end
    rate_next = Coordinates(2.0 * normal_half - rate.normal, 2.0 * along_half - rate.along)
    normal_force, tangential_force, normal_excess, tangential_excess = 0.0, 0.0, 0.0, 0.0
    for i in range(own.shape[1]):
        z_old, x, slip = own[StepContact.Z, i], own[StepContact.X, i], own[StepContact.SLIP, i]
        z, hold = approach(paths, i, table[SurfaceRow.U_Z, k + 1, i], q), problem.normal.hold
        z_new = _followed(z_old, z, hold)
        own[StepContact.Z, i] = z_new
        if z_old <= 0.0 and z_new <= 0.0:
            continue
        along = travel(table[SurfaceRow.U_X, k + 1, i] - table[SurfaceRow.U_X, k, i], q)
        z_rate = approach_rate(table[SurfaceRow.W_Z, k + 1, i], rate_next)
        moved = x + along
        contact = contact_parameters(problem, i)
        changes = z_old <= 0.0 or z_new <= 0.0
        sticks = z_old > 0.0 and slip == 0.0 and abs(moved) < slip_limit(contact, z_new)
        if sticks and x * moved >= 0.0:
            x = moved
        else:
            z_rate_old, z_rate_new = approach_rate(table[SurfaceRow.W_Z, k, i], rate), z_rate
            if hold is not None and not changes:
                z_rate_old, z_rate_new = _rates(z_rate_old, z_old, hold), _rates(z_rate, z_new, hold)
            passage = Passage(
                h, z_old, z_new, z_rate_old, z_rate_new,
                travel(table[SurfaceRow.W_X, k, i], rate), travel(table[SurfaceRow.W_X, k + 1, i], rate_next), along,
                approach(paths, i, 0.0, q),  # z'' = -u_z at z = 0
                (table[SurfaceRow.W_X, k + 1, i] - table[SurfaceRow.W_X, k, i]) / h,
            )  # fmt: skip
            x, slip, normal, tangential = _jumps(contact, passage, z_old, z, x, slip, sticks, hold)
            normal_excess += normal
            tangential_excess += tangential
        own[StepContact.X, i], own[StepContact.SLIP, i] = x, slip
        if z_new > 0.0:
            own_rate = _rates(z_rate, z_new, hold)
            point = Point(z_new, x, own_rate, travel(table[SurfaceRow.W_X, k + 1, i], rate_next))
            normal_force += contact_force(contact, elastic_force(contact.stiffness, z_new, contact.normal), z_rate)
            normal_force -= contact.stiffness * attraction(z_new, contact.normal.pull, hold)
            tangential_force += _traction(contact, point, slip)
    normal_velocity = normal_half + 0.5 * h * (normal_force - problem.preload) - normal_excess
    speed = along_half + 0.5 * h * (tangential_force - problem.load) - tangential_excess
    slider[StepSlider.POSITION] = q.normal
    slider[StepSlider.NORMAL_VELOCITY] = normal_velocity * slider[StepSlider.DAMP_N]
    slider[StepSlider.VELOCITY] = speed * slider[StepSlider.DAMP_T]
    slider[StepSlider.NORMAL], slider[StepSlider.TANGENTIAL] = normal_force, tangential_force
    slider[StepSlider.TRAVELLED] += q.along


@native(
    "t f1 t t",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.factors.stiffness": "n",
        "problem.factors.limit_slope": "n", "state": "3+n", "task.record": "m 3",
        "task.envelope.at": "k", "task.envelope.amplitude": "k", "task.envelope.angle": "k",
        "work.table": "4 s n", "work.contact": "3 n", "work.slider": "9",
    },
)  # fmt: skip
def _run(problem, state, task, work):
    """Do the work of `steps`; return True if all is finite."""
    per_cycle, slider, envelope = task.per_cycle, work.slider, task.envelope
    knot = tabulate_cycle(problem.paths, per_cycle, 0, envelope, 0, work.table)
    begin_steps(problem, state, per_cycle, work)
    for cycle in range(task.number):
        slider[StepSlider.TRAVELLED] = 0.0
        if cycle > 0 and envelope.at.size > 1:
            # the last knot of a cycle may lie at its end, where the next cycle begins
            knot = tabulate_cycle(problem.paths, per_cycle, cycle, envelope, max(knot - 1, 0), work.table)
        for k in range(per_cycle):
            one_step(problem, k, work)
        if not np.isfinite(
            slider[StepSlider.POSITION] + slider[StepSlider.NORMAL_VELOCITY] + slider[StepSlider.VELOCITY]
        ):
            return False
        if task.stride > 0 and (cycle + 1) % task.stride == 0:
            recorded = task.record[(cycle + 1) // task.stride - 1]
            recorded[Recorded.VELOCITY] = slider[StepSlider.VELOCITY]
            recorded[Recorded.POSITION] = slider[StepSlider.POSITION]
            recorded[Recorded.MEAN_VELOCITY] = slider[StepSlider.TRAVELLED] / (2.0 * np.pi)
    state[At.POSITION], state[At.NORMAL_VELOCITY] = slider[StepSlider.POSITION], slider[StepSlider.NORMAL_VELOCITY]
    state[At.VELOCITY] = slider[StepSlider.VELOCITY]
    for i in range(work.contact.shape[1]):
        state[At.DEFORMATIONS + i] = work.contact[StepContact.X, i]
    return True


@compiled
def begin_steps(problem, state, per_cycle, work):
    """Set the forces of the first instant and what stays the same."""
    slider, own, table = work.slider, work.contact, work.table
    h = 2.0 * np.pi / per_cycle
    slider[StepSlider.STEP] = h
    slider[StepSlider.DAMP_N] = 1.0 / (1.0 + 0.5 * h * problem.normal_damping)
    slider[StepSlider.DAMP_T] = 1.0 / (1.0 + 0.5 * h * problem.tangential_damping)
    slider[StepSlider.POSITION], slider[StepSlider.NORMAL_VELOCITY] = state[At.POSITION], state[At.NORMAL_VELOCITY]
    slider[StepSlider.VELOCITY] = state[At.VELOCITY]
    q = Coordinates(state[At.POSITION], 0.0)
    rate = Coordinates(state[At.NORMAL_VELOCITY], state[At.VELOCITY])
    normal_force, tangential_force = 0.0, 0.0
    for i in range(own.shape[1]):
        x, slip = state[At.DEFORMATIONS + i], 0.0
        hold = problem.normal.hold
        # where both are possible, a contact without deformation is open
        z = _followed(abs(x), approach(problem.paths, i, table[SurfaceRow.U_Z, 0, i], q), hold)
        if z > 0.0:
            contact = contact_parameters(problem, i)
            z_rate, limit = approach_rate(table[SurfaceRow.W_Z, 0, i], rate), slip_limit(contact, z)
            normal_force += contact_force(contact, elastic_force(contact.stiffness, z, contact.normal), z_rate)
            normal_force -= contact.stiffness * attraction(z, contact.normal.pull, hold)
            if abs(x) > limit * (1.0 - 1e-13):
                slip = np.sign(x)
            if x != 0.0:
                point = Point(z, x, _rates(z_rate, z, hold), travel(table[SurfaceRow.W_X, 0, i], rate))
                tangential_force += _traction(contact, point, slip)
        own[StepContact.Z, i], own[StepContact.X, i], own[StepContact.SLIP, i] = z, x, slip
    slider[StepSlider.NORMAL], slider[StepSlider.TANGENTIAL] = normal_force, tangential_force


def knots_of(problem, envelope) -> Knots:
    """Return an envelope, or None for none, as the kernels take it."""
    if envelope is None:
        return Knots(np.zeros(1), np.ones(1), np.zeros(1))
    return Knots(problem.omega * envelope.time, envelope.amplitude.copy(), envelope.phase.copy())


def steps(problem, state, number, per_cycle, *, stride=1, envelope=None) -> np.ndarray:
    """Move the slider through whole cycles of equal steps; return the record (number // stride, len(`Recorded`)).

    `state` (3 + n,) holds z_s, z_s', v, x_1..x_n and is overwritten. `envelope` is the `contact.Envelope` from the
    first cycle on, None for none. A sample every `stride` cycles (0: none) has v, z_s and the mean v of the last one.
    """
    n = problem.contacts
    work = Work(
        np.empty((len(SurfaceRow), per_cycle + 1, n)), np.empty((len(StepContact), n)), np.zeros(len(StepSlider))
    )
    record = np.empty((number // stride if stride else 0, len(Recorded)))
    task = Task(number, per_cycle, stride, record, knots_of(problem, envelope))
    if not _run(problem, state, task, work):
        raise ConvergenceError("not finite", "the stepped motion overflowed; use method exact")
    return record
