r"""One smooth segment of motion between two events, by Chebyshev-Picard iteration.

The forces at the nodes give velocities and positions through the integration matrices of `collocation`, and these give
the forces again. One such iteration is a sweep. It reduces the error by a factor of about (omega_n L)^2/2, with omega_n
the contact resonance over omega and L the segment's length: four digits and more for a wave of 2 MHz. If the iteration
does not converge, the segment is shortened.

The values at the nodes are kept in `Nodes`: the slider's in one array (`SliderRow`), those of each contact in the
planes of another (`ContactRow`). The segment ends where a guard of a contact vanishes. A *guard* is a function that is
positive inside a regime (`law.elastic`); its end is searched by Newton's method on the segment's length.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.body import (
    Coordinates,
    Point,
    approach,
    approach_rate,
    at_phase,
    body_force,
    contact_force,
    short_sine,
    travel,
)
from contact.codes import At, Guard, Regime, Tangential
from contact.events.collocation import ROOT_AT_END, ROOT_AT_START
from contact.jit.compiled import compiled
from contact.law.elastic import FAR_SIDE, spring
from contact.law.holding import circle, closes_at, depth_rate, opens_at
from contact.law.hysteretic import moment_rate
from contact.law.normal import load
from contact.law.protocol import slip_limit
from contact.problem import contact_parameters
from contact.roots import interpolate

MAX_SWEEPS = 25  # of Picard's iteration
# From this number of contacts on, what is done for each of them before and after a run is compiled. In Python it takes
# 0.2 ms for one contact: 5 of the 15 s of a steady state of 3000 balls.
COMPILED_CONTACTS = 100
# shapes of a problem and a state, see `contact.jit.array_shapes`
SHAPES = {
    "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.paths.tangential_cos": "n",
    "problem.factors.stiffness": "n", "problem.factors.limit_slope": "n", "state.slider": "3",
    "state.lost": "3", "state.deformation": "n", "state.sign": "n", "state.regime": "n",
}  # fmt: skip


class SliderRow(IntEnum):
    """First index of `Nodes.slider`: motion, accelerations, and these integrated once and twice over tau."""

    POSITION = 0
    NORMAL_VELOCITY = 1
    TRAVEL = 2  # from the segment's start
    VELOCITY = 3
    NORMAL_ACCELERATION = 4
    TANGENTIAL_ACCELERATION = 5
    NORMAL_ONCE = 6
    NORMAL_TWICE = 7
    TANGENTIAL_ONCE = 8
    TANGENTIAL_TWICE = 9


class ContactRow(IntEnum):
    """Planes of `Nodes.contact`."""

    U_Z = 0  # surface displacement
    U_X = 1  # from the segment's start
    U_Z_RATE = 2
    U_X_RATE = 3
    Z = 4  # approach
    X = 5  # deformation
    P = 6  # elastic normal force, without attraction
    Q = 7  # tangential force
    # reciprocal normal force dW/dz, W the energy of the tangential spring (`law.elastic.spring`), less the attraction
    BACK = 8
    FRONT = 9  # front of the slip annulus, `law.hysteretic`
    LEVEL = 10  # moment M of the hysteretic memory at the node, or the depth of a contact that holds on (`law.holding`)


class SegmentState(NamedTuple):
    """State of a slider between two segments, with the tally and the sums of the run so far."""

    slider: np.ndarray  # (3,): z_s, z_s' and v
    lost: np.ndarray  # (3,): what rounding has cut off from them, see `advance_slider`
    deformation: np.ndarray  # (contacts,): x
    sign: np.ndarray  # (contacts,): of deformation or slip
    regime: np.ndarray  # (contacts,) int: `codes.Regime`
    tally: np.ndarray  # (event_driven.TALLY,) int: how many of each `codes.Event` and `codes.WorkCount`
    sums: np.ndarray  # (len(energy.EnergySum),): integrals, see `energy.EnergySum`


class Nodes(NamedTuple):
    """Values at the n nodes: slider (len(SliderRow), n), contacts (len(ContactRow), contacts, n), a guard (n,)."""

    slider: np.ndarray
    contact: np.ndarray
    guard: np.ndarray


class Segment(NamedTuple):
    """Position of a segment, and the event that ends it."""

    phase: float  # of its start
    length: float  # 0 if an event falls on its start
    longest: float  # length before an event shortened it: the upper bound of Newton's method for the event
    map: int  # of the collocation: SMOOTH, ROOT_AT_START or ROOT_AT_END
    contact: int  # number of the contact whose guard vanishes at the end; -1 without an event
    guard: int  # `codes.Guard` of that guard
    last: int  # 1 if it ends where the run ends


class Attempt(NamedTuple):
    """Result of an attempt to compute a segment."""

    outcome: int  # one of `codes.AttemptOutcome`
    segment: Segment
    length: float  # to try next
    status: int  # `codes.Status`: why it did not converge


@compiled
def next_segment(phase, length, stop, map_):
    """Return a segment of at most this length without an event."""
    last = phase + length >= stop - 1e-12
    return segment_at(phase, stop - phase if last else length, map_, int(last))


@compiled
def segment_at(phase, length, map_, last):
    """Return a segment without an event."""
    return Segment(phase, length, length, map_, -1, -1, last)


@compiled
def resized(segment, length):
    """Return the segment with another length."""
    return Segment(segment.phase, length, segment.longest, segment.map, segment.contact, segment.guard, segment.last)


@compiled
def surface(problem, grid, nodes, segment):
    """Fill the surface's displacement (u_x relative to the start) and velocity at the nodes."""
    c0, s0 = np.cos(segment.phase), np.sin(segment.phase)
    for i in range(nodes.contact.shape[1]):
        surface_of(problem, grid, nodes, segment, i, c0, s0, 0)


@compiled
def surface_of(problem, grid, nodes, segment, i, c0, s0, first):
    """Fill what `surface` fills for one contact from node `first` on; c0, s0: cosine and sine of the start."""
    # with t from the start of the segment: u_z = a cos t + b sin t, u_x = d cos t + e sin t
    a, b, d, e = at_phase(problem.paths, i, c0, s0)
    own = nodes.contact
    for j in range(first, own.shape[2]):
        t = segment.length * grid.tau[segment.map, j]
        if segment.length <= 0.8:
            s, v = short_sine(t)
        elif segment.length <= 1.6:  # of twice the angle
            s, v = short_sine(0.5 * t)
            s, v = 2.0 * s * (1.0 - v), 2.0 * s * s
        else:
            s, v = np.sin(t), 1.0 - np.cos(t)
        c = 1.0 - v
        own[ContactRow.U_Z, i, j] = a * c + b * s
        own[ContactRow.U_X, i, j] = e * s - d * v
        own[ContactRow.U_Z_RATE, i, j] = b * c - a * s
        own[ContactRow.U_X_RATE, i, j] = e * c - d * s


@compiled
def coordinates_at(nodes, j):
    """Return the slider's coordinates at a node, the travel from the segment's start."""
    return Coordinates(nodes.slider[SliderRow.POSITION, j], nodes.slider[SliderRow.TRAVEL, j])


@compiled
def rate_at(nodes, j):
    """Return the rates of the slider's coordinates at a node."""
    return Coordinates(nodes.slider[SliderRow.NORMAL_VELOCITY, j], nodes.slider[SliderRow.VELOCITY, j])


@compiled
def height_rate(nodes, i, j):
    """Return the rate of a contact's approach at a node."""
    return approach_rate(nodes.contact[ContactRow.U_Z_RATE, i, j], rate_at(nodes, j))


@compiled
def depth_at(nodes, i, j, hold):
    """Return the depth of a closed contact at a node, its approach without adhesion that holds on."""
    if hold is None:
        return nodes.contact[ContactRow.Z, i, j]
    else:
        return nodes.contact[ContactRow.LEVEL, i, j]


@compiled
def point_at(nodes, i, j, hold):
    """Return depth, deformation and their rates of a contact at a node, see `depth_at`."""
    own, rate = nodes.contact, rate_at(nodes, j)
    d = depth_at(nodes, i, j, hold)
    z_rate = approach_rate(own[ContactRow.U_Z_RATE, i, j], rate) * depth_rate(d, hold)
    return Point(d, own[ContactRow.X, i, j], z_rate, travel(own[ContactRow.U_X_RATE, i, j], rate))


@compiled
def keep_circle(nodes, i, j, pull, hold):
    """Store the depth of a contact at a node, at its approach there; return depth and attraction over its stiffness."""
    d, own = circle(nodes.contact[ContactRow.Z, i, j], pull, hold)
    if hold is not None:
        nodes.contact[ContactRow.LEVEL, i, j] = d
    return d, own


@compiled
def forces(problem, grid, state, nodes, segment, mobile, memory):
    """Fill approach, deformation, forces and accelerations at the nodes from the slider's motion there."""
    slider, own = nodes.slider, nodes.contact
    n = grid.sigma.size
    if memory is not None:
        _moments(problem, grid, state, nodes, segment, memory)
    for j in range(n):
        force = body_force(problem, rate_at(nodes, j))
        slider[SliderRow.NORMAL_ACCELERATION, j] = force.normal if mobile else 0.0
        slider[SliderRow.TANGENTIAL_ACCELERATION, j] = force.along if mobile else 0.0
    for i in range(state.regime.size):
        contact_forces(problem, grid, state, nodes, i, memory)
        if mobile and state.regime[i] != Regime.SEPARATED:
            for j in range(n):
                slider[SliderRow.NORMAL_ACCELERATION, j] += normal_force(problem, nodes, i, j)
                slider[SliderRow.TANGENTIAL_ACCELERATION, j] += own[ContactRow.Q, i, j]


@compiled
def normal_force(problem, nodes, i, j):
    """Return the normal force of a contact on the slider at a node, damper and reciprocal force with it."""
    own = nodes.contact
    return contact_force(problem, own[ContactRow.P, i, j], height_rate(nodes, i, j)) + own[ContactRow.BACK, i, j]


@compiled
def contact_forces(problem, grid, state, nodes, i, memory):
    """Fill approach, deformation and forces of one contact."""
    regime, sign, own = state.regime[i], state.sign[i], nodes.contact
    contact, n = contact_parameters(problem, i), grid.sigma.size
    for j in range(n):
        own[ContactRow.Z, i, j] = approach(problem.paths, i, own[ContactRow.U_Z, i, j], coordinates_at(nodes, j))
        own[ContactRow.BACK, i, j] = 0.0
    if regime == Regime.SEPARATED:
        for j in range(n):
            own[ContactRow.P, i, j] = own[ContactRow.Q, i, j] = own[ContactRow.X, i, j] = 0.0
        return
    hold = contact.normal.hold
    for j in range(n):
        d, pull = keep_circle(nodes, i, j, contact.normal.pull, hold)
        own[ContactRow.BACK, i, j] = -contact.stiffness * pull
        own[ContactRow.P, i, j] = contact.stiffness * load(d, contact.normal)
    if regime == Regime.SLIP:
        for j in range(n):
            own[ContactRow.X, i, j] = sign * slip_limit(contact, depth_at(nodes, i, j, hold))
    else:
        for j in range(n):
            own[ContactRow.X, i, j] = state.deformation[i] + travel(own[ContactRow.U_X, i, j], coordinates_at(nodes, j))
    for j in range(n):
        level, front = own[ContactRow.LEVEL, i, j], own[ContactRow.FRONT, i, j]
        own[ContactRow.Q, i, j], own[ContactRow.FRONT, i, j] = contact.law.force(
            contact, memory, i, regime, sign, point_at(nodes, i, j, hold), level, front
        )
    if contact.law.kind == Tangential.RECIPROCAL:
        for j in range(n):
            own[ContactRow.BACK, i, j] = spring(contact, regime, sign, point_at(nodes, i, j, hold))[1]


@compiled
def _moments(problem, grid, state, nodes, segment, memory):
    """Fill the moment M (LEVEL) at the nodes of contacts in `Regime.GROW`, which grow without slip.

    It is integrated from dM/dt, which the plane FRONT holds meanwhile.
    """
    own, n = nodes.contact, grid.sigma.size
    for i in range(state.regime.size):
        if state.regime[i] != Regime.GROW:
            continue
        for j in range(n):
            z = approach(problem.paths, i, own[ContactRow.U_Z, i, j], coordinates_at(nodes, j))
            x_rate = travel(own[ContactRow.U_X_RATE, i, j], rate_at(nodes, j))
            own[ContactRow.FRONT, i, j] = moment_rate(contact_parameters(problem, i), z, x_rate)
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += grid.integrals[segment.map, 0, k, j] * own[ContactRow.FRONT, i, k]
            own[ContactRow.LEVEL, i, j] = memory.level[i] + segment.length * total


@compiled
def integrate(grid, state, nodes, segment):
    """Fill the slider's motion at the nodes from its accelerations there; return the largest change."""
    once, twice = grid.integrals[segment.map, 0], grid.integrals[segment.map, 1]
    n = grid.sigma.size
    for j in range(0, n, 4):
        _four(once, twice, min(j, n - 4), nodes.slider)  # the last four nodes may overlap with those before
    return place(grid, state, nodes, segment, 0)


@compiled
def place(grid, state, nodes, segment, first):
    """Fill the slider's motion from node `first` on from the integrals of its accelerations; return the change."""
    slider, length, change = nodes.slider, segment.length, 0.0
    z_s, z_rate, v = state.slider[At.POSITION], state.slider[At.NORMAL_VELOCITY], state.slider[At.VELOCITY]
    z_lost, rate_lost, v_lost = state.lost[At.POSITION], state.lost[At.NORMAL_VELOCITY], state.lost[At.VELOCITY]
    for j in range(first, grid.sigma.size):
        tau = grid.tau[segment.map, j]
        normal_velocity = z_rate + (rate_lost + length * slider[SliderRow.NORMAL_ONCE, j])
        speed = v + (v_lost + length * slider[SliderRow.TANGENTIAL_ONCE, j])
        height = z_s + (z_lost + length * (z_rate * tau + length * slider[SliderRow.NORMAL_TWICE, j]))
        way = length * (v * tau + length * slider[SliderRow.TANGENTIAL_TWICE, j])
        moved = max(abs(height - slider[SliderRow.POSITION, j]), abs(way - slider[SliderRow.TRAVEL, j]))
        moved = max(
            moved,
            abs(normal_velocity - slider[SliderRow.NORMAL_VELOCITY, j]),
            abs(speed - slider[SliderRow.VELOCITY, j]),
        )
        slider[SliderRow.POSITION, j], slider[SliderRow.NORMAL_VELOCITY, j] = height, normal_velocity
        slider[SliderRow.TRAVEL, j], slider[SliderRow.VELOCITY, j] = way, speed
        # a motion that is not finite must not pass for one that does not change
        change = max(change, moved if moved < 1e100 else 1e300)
    return change


@compiled
def advance_slider(state, length, once, twice, along):
    """Move the slider by the integrals of its accelerations over a segment, and keep what the sums round off.

    `once`, `twice`: single and double integral over tau of the normal acceleration; `along`: of the tangential one. A
    heavy slider's velocity changes in a segment by as little as 1e-9 of itself, so that its rounding would be 1e-7 of
    the work of a cycle. The remainders of the sums (Kahan, Comm. ACM 8 (1965) 40) go into those of the next segment.
    """
    z_rate = state.slider[At.NORMAL_VELOCITY]
    _advance(state, At.POSITION, length * (z_rate + length * twice))
    _advance(state, At.NORMAL_VELOCITY, length * once)
    _advance(state, At.VELOCITY, length * along)


@compiled
def _advance(state, k, change):
    """Add a change to one quantity of the slider; the remainder is exact whichever of the two is larger (Knuth)."""
    before, change = state.slider[k], state.lost[k] + change
    after = before + change
    added = after - before
    state.slider[k], state.lost[k] = after, (before - (after - added)) + (change - added)


@compiled
def end_at(problem, grid, state, nodes, segment):
    """Set the motion of slider, surface and contacts at the end of a segment of another length, and nothing else."""
    place(grid, state, nodes, segment, grid.sigma.size - 1)
    c0, s0 = np.cos(segment.phase), np.sin(segment.phase)
    for i in range(state.regime.size):
        surface_of(problem, grid, nodes, segment, i, c0, s0, grid.sigma.size - 1)
        contact_end(problem, state, nodes, i)


@compiled
def _four(once, twice, j, slider):
    """Fill both integrals of both accelerations at four nodes, sum_k columns[k, j..j+3] acceleration[k].

    A vector register holds four doubles. The sums are independent, so that no addition waits for another.
    """
    normal, tangential = slider[SliderRow.NORMAL_ACCELERATION], slider[SliderRow.TANGENTIAL_ACCELERATION]
    a0 = a1 = a2 = a3 = b0 = b1 = b2 = b3 = c0 = c1 = c2 = c3 = d0 = d1 = d2 = d3 = 0.0
    # unsigned indices: with signed ones numba puts a test for negative indices between the four loads
    j0, j1, j2, j3 = np.uint64(j), np.uint64(j + 1), np.uint64(j + 2), np.uint64(j + 3)
    for k in range(normal.size):
        f, g = normal[k], tangential[k]
        a0 += once[k, j0] * f
        a1 += once[k, j1] * f
        a2 += once[k, j2] * f
        a3 += once[k, j3] * f
        b0 += twice[k, j0] * f
        b1 += twice[k, j1] * f
        b2 += twice[k, j2] * f
        b3 += twice[k, j3] * f
        c0 += once[k, j0] * g
        c1 += once[k, j1] * g
        c2 += once[k, j2] * g
        c3 += once[k, j3] * g
        d0 += twice[k, j0] * g
        d1 += twice[k, j1] * g
        d2 += twice[k, j2] * g
        d3 += twice[k, j3] * g
    out = slider[SliderRow.NORMAL_ONCE]
    out[j0], out[j1], out[j2], out[j3] = a0, a1, a2, a3
    out = slider[SliderRow.NORMAL_TWICE]
    out[j0], out[j1], out[j2], out[j3] = b0, b1, b2, b3
    out = slider[SliderRow.TANGENTIAL_ONCE]
    out[j0], out[j1], out[j2], out[j3] = c0, c1, c2, c3
    out = slider[SliderRow.TANGENTIAL_TWICE]
    out[j0], out[j1], out[j2], out[j3] = d0, d1, d2, d3


@compiled
def has_converged(change, last):
    """Return True if Picard's iteration has converged: the remaining error, change times gain, is below rounding.

    The gain is the ratio of the last two changes. If it is above 1/2, the changes are rounding errors, provided that
    they are small.
    """
    gain = change / last
    return change < 1e-16 or (0.0 < gain < 0.5 and change * gain < 1e-15) or (gain > 0.5 and change < 2e-15)


@compiled
def iterate_motion(problem, grid, state, nodes, segment, mobile, memory):
    """Iterate to the motion on a segment, from constant accelerations; return (converged, sweeps)."""
    surface(problem, grid, nodes, segment)
    _guess(grid, state, nodes, segment)
    converged, count, last = False, 0, np.inf
    while not converged and count < MAX_SWEEPS:
        count += 1
        forces(problem, grid, state, nodes, segment, mobile, memory)
        if not mobile:
            converged = True
            break
        change = integrate(grid, state, nodes, segment) / (1.0 + abs(state.slider[At.POSITION]))
        if not change < 1e100:
            break
        converged = has_converged(change, last)
        last = change
    end_kinematics(problem, state, nodes)
    return converged, count


@compiled
def _guess(grid, state, nodes, segment):
    """Fill the first guess: constant accelerations from the end of the last segment."""
    slider = nodes.slider
    normal, tangential = slider[SliderRow.NORMAL_ACCELERATION, 0], slider[SliderRow.TANGENTIAL_ACCELERATION, 0]
    z_s = state.slider[At.POSITION]
    normal_velocity = state.slider[At.NORMAL_VELOCITY]
    v = state.slider[At.VELOCITY]
    for j in range(grid.sigma.size):
        t = segment.length * grid.tau[segment.map, j]
        slider[SliderRow.POSITION, j] = z_s + t * (normal_velocity + 0.5 * t * normal)
        slider[SliderRow.NORMAL_VELOCITY, j] = normal_velocity + t * normal
        slider[SliderRow.TRAVEL, j] = t * (v + 0.5 * t * tangential)
        slider[SliderRow.VELOCITY, j] = v + t * tangential


@compiled
def end_kinematics(problem, state, nodes):
    """Set approach and deformation of every contact at the end of the segment from the slider's motion there.

    Picard's iteration leaves them as they were before its last sweep, up to 1e-12 away: enough for a contact that has
    just closed to begin the next segment with a negative approach.
    """
    for i in range(state.regime.size):
        contact_end(problem, state, nodes, i)


@compiled
def contact_end(problem, state, nodes, i):
    """Set approach and deformation of a contact at the end of the segment from the slider's motion there."""
    own, n = nodes.contact, nodes.guard.size - 1
    q = coordinates_at(nodes, n)
    own[ContactRow.Z, i, n] = approach(problem.paths, i, own[ContactRow.U_Z, i, n], q)
    hold = problem.normal.hold
    d, _ = keep_circle(nodes, i, n, 0.0, hold)
    if state.regime[i] == Regime.SLIP:
        own[ContactRow.X, i, n] = state.sign[i] * slip_limit(contact_parameters(problem, i), d)
    elif state.regime[i] != Regime.SEPARATED:
        own[ContactRow.X, i, n] = state.deformation[i] + travel(own[ContactRow.U_X, i, n], q)


@compiled
def guards(problem, state, nodes, i, which, memory):
    """Fill `nodes.guard` with guard `which` of contact i at all nodes."""
    regime, sign, own, out = state.regime[i], state.sign[i], nodes.contact, nodes.guard
    if which == Guard.GAP:
        for j in range(out.size):
            out[j] = gap_guard(regime, own[ContactRow.Z, i, j], problem.normal.hold)
        return
    contact = contact_parameters(problem, i)
    for j in range(out.size):
        front = own[ContactRow.FRONT, i, j]
        point = point_at(nodes, i, j, contact.normal.hold)
        value = contact.law.guard(contact, memory, i, regime, which, sign, point, front)
        out[j] = finite_at_end(value, regime, point, contact.normal.hold)


@compiled
def finite_at_end(value, regime, point, hold):
    """Return a guard or its rate: a speed of slip, infinite where a contact that holds on ends, over d'/z'."""
    if hold is None:
        return value
    else:
        return value / depth_rate(point.approach, hold) if regime == Regime.SLIP else value


@compiled
def gap_guard(regime, z, hold):
    """Return what is positive while an open contact stays open, and a closed one closed, at an approach."""
    if regime == Regime.SEPARATED:
        return FAR_SIDE - (z - closes_at(hold))
    return FAR_SIDE + (z - opens_at(hold))


@compiled
def next_length(segment, value, rate, trial):
    """Return the length at which the segment's guard vanishes, by Newton's method; the same one if it is good enough.

    `value`, `rate`: of the guard at the end; `trial`: how many lengths have been tried.
    """
    length = segment.length
    if length == 0.0 or abs(value) < 1e-16 or not rate < 0.0:
        return length
    step = -value / rate
    if abs(step) < 2e-16 or (trial > 6 and abs(step) < 1e-14):
        return length
    return min(max(length + step, 0.5 * length), min(1.1 * length + 1e-12, segment.longest))


@compiled
def roughness(problem, grid, nodes, segment, i, most):
    """Return the larger of the two highest Chebyshev coefficients of a contact's forces, times length over scale.

    `most`: the largest normal force on the segment. It sets the scale of an impact without preload.
    """
    own, tail, worst = nodes.contact, grid.tail, 0.0
    normal_scale = max(problem.preload, 1e-3 * most) + 1e-300
    tangential_scale = problem.friction * normal_scale + 1e-300
    for r in range(2):
        ep, eq = 0.0, 0.0
        for k in range(own.shape[2]):
            ep += tail[r, k] * own[ContactRow.P, i, k]
            eq += tail[r, k] * own[ContactRow.Q, i, k]
        worst = max(worst, segment.length * abs(ep) / normal_scale, segment.length * abs(eq) / tangential_scale)
    return worst


@compiled
def largest_normal_force(nodes, i):
    """Return the largest normal force of a contact at the nodes."""
    most = 0.0
    for k in range(nodes.guard.size):
        most = max(most, nodes.contact[ContactRow.P, i, k])
    return most


class SampleColumn(IntEnum):
    """Columns of the samples of a contact."""

    APPROACH = 0
    DEFORMATION = 1
    NORMAL_FORCE = 2
    TANGENTIAL_FORCE = 3
    REGIME = 4
    SLIDER_VELOCITY = 5


@compiled
def sample(grid, state, nodes, segment, i, phase, out):
    """Fill a sample of a contact at a phase of the segment."""
    t = min(max((phase - segment.phase) / segment.length, 0.0), 1.0)
    if segment.map == ROOT_AT_START:
        t = np.sqrt(t)
    elif segment.map == ROOT_AT_END:
        t = 1.0 - np.sqrt(1.0 - t)
    node_sigma = 2.0 * t - 1.0
    for k in range(SampleColumn.REGIME):
        out[k] = interpolate(node_sigma, grid.sigma, grid.bary, nodes.contact[ContactRow.Z + k, i])
    out[SampleColumn.REGIME] = state.regime[i]
    out[SampleColumn.SLIDER_VELOCITY] = interpolate(node_sigma, grid.sigma, grid.bary, nodes.slider[SliderRow.VELOCITY])
