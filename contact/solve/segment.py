r"""One smooth segment of motion between two events, by Chebyshev-Picard iteration.

The forces at the nodes give velocities and positions by the collocation's integration matrices, and these give the
forces again. A slider is heavy against the contact's stiffness over a part of a cycle, so each sweep gains a factor of
about (omega_n L)^2/2: four digits and more at a wave of 2 MHz, and a shorter segment where it gains too little.
"""

from typing import NamedTuple

import numpy as np

from contact.codes import Regime, Tangential
from contact.jit.compiled import compiled
from contact.kinematics import Point, at_phase
from contact.law.elastic import FAR_SIDE, guard, spring, tangential
from contact.law.hysteretic import memory_guard, moment
from contact.law.normal import load
from contact.solve.riding import short_sine

# what `State.slider` holds, and where the deformations begin behind it in the state of a whole motion
POSITION, NORMAL_VELOCITY, VELOCITY, DEFORMATIONS = range(4)
# columns of the rows that a run records
ROW_VELOCITY, ROW_POSITION, ROW_MEAN_VELOCITY, ROW = range(4)
# rows of `Nodes.slider`: the motion, its accelerations, and the integrals of these, once and twice
HEIGHT, CLIMB, TRAVEL, SPEED, NORMAL_ACCELERATION, TANGENTIAL_ACCELERATION = range(6)
NORMAL_ONCE, NORMAL_TWICE, TANGENTIAL_ONCE, TANGENTIAL_TWICE, ROWS = range(6, 11)
# planes of `Nodes.contact`
U_Z, U_X, U_Z_RATE, U_X_RATE, Z, X, P, Q, BACK, FRONT, LEVEL, PLANES = range(12)
# sweeps of Picard's iteration
MAX_SWEEPS = 25


class State(NamedTuple):
    """What a slider carries from one segment to the next, and what has been counted on the way."""

    slider: np.ndarray  # (3,): z_s, z_s' and v
    deformation: np.ndarray  # (contacts,): x
    sign: np.ndarray  # (contacts,): of deformation or slip
    regime: np.ndarray  # (contacts,) int: see `law.elastic`
    tally: np.ndarray  # (TALLY,) int: events and work, see `event_driven`
    sums: np.ndarray  # (SUMS,): integrals, see `energy`


class Nodes(NamedTuple):
    """Values at the nodes: of the slider (ROWS, n), of the contacts (PLANES, contacts, n), of a guard (n,)."""

    slider: np.ndarray
    contact: np.ndarray
    guard: np.ndarray


class Segment(NamedTuple):
    """Where a segment lies and how it ends."""

    phase: float  # of its start
    length: float  # so far; 0 where an event falls on its start
    longest: float  # the length that it had before an event was found on it
    map: int  # of the collocation
    contact: int  # whose guard vanishes at its end, -1 without an event
    guard: int  # and which
    last: int  # whether it ends where the run ends


@compiled
def segment_at(phase, length, map_, last):
    """Return a segment without an event."""
    return Segment(phase, length, length, map_, -1, -1, last)


@compiled
def resized(segment, length):
    """Return the segment with another length."""
    return Segment(
        segment.phase, length, segment.longest, segment.map, segment.contact, segment.guard, segment.last
    )


@compiled
def surface(problem, grid, nodes, segment):
    """Fill the surface's displacement (u_x relative to the start) and velocity at the nodes."""
    c0, s0 = np.cos(segment.phase), np.sin(segment.phase)
    for i in range(nodes.contact.shape[1]):
        surface_of(problem, grid, nodes, segment, i, c0, s0, 0)


@compiled
def surface_of(problem, grid, nodes, segment, i, c0, s0, first):
    """Fill what `surface` fills for one contact from node `first` on; c0, s0: cosine and sine of the start."""
    # in the frame of the start: u_z = a cos t + b sin t
    a, b, d, e = at_phase(problem.paths, i, c0, s0)
    height, own, short = problem.paths.height[i], nodes.contact, segment.length <= 0.8
    for j in range(first, own.shape[2]):
        t = segment.length * grid.tau[segment.map, j]
        if short:
            s, v = short_sine(t)
        else:
            s, v = np.sin(t), 1.0 - np.cos(t)
        c = 1.0 - v
        own[U_Z, i, j] = a * c + b * s + height
        own[U_X, i, j] = e * s - d * v
        own[U_Z_RATE, i, j] = b * c - a * s
        own[U_X_RATE, i, j] = e * c - d * s


@compiled
def forces(problem, grid, state, nodes, segment, mobile, memory):
    """Fill approach, deformation, forces and accelerations at the nodes from the slider's motion there."""
    slider, own = nodes.slider, nodes.contact
    n = grid.sigma.size
    if memory is not None:
        _edge(problem, grid, state, nodes, segment, memory)
    d_n, p, d_t, q = problem.normal_damping, problem.preload, problem.tangential_damping, problem.load
    for j in range(n):
        slider[NORMAL_ACCELERATION, j] = -d_n * slider[CLIMB, j] - p if mobile else 0.0
        slider[TANGENTIAL_ACCELERATION, j] = -d_t * slider[SPEED, j] - q if mobile else 0.0
    for i in range(state.regime.size):
        contact_forces(problem, grid, state, nodes, i, memory)
        if mobile and state.regime[i] != Regime.SEPARATED:
            chi = problem.contact_damping
            for j in range(n):
                damped = own[P, i, j] * (1.0 + chi * (own[U_Z_RATE, i, j] - slider[CLIMB, j]))
                slider[NORMAL_ACCELERATION, j] += damped + own[BACK, i, j]
                slider[TANGENTIAL_ACCELERATION, j] += own[Q, i, j]


@compiled
def contact_forces(problem, grid, state, nodes, i, memory):
    """Fill approach, deformation and forces of one contact."""
    kappa, c, shape, law = problem.stiffness, problem.limit_slope, problem.shape, problem.law
    friction, regime, sign, own = problem.friction * kappa, state.regime[i], state.sign[i], nodes.contact
    n = grid.sigma.size
    if regime == Regime.SEPARATED:
        for j in range(n):
            own[Z, i, j] = own[U_Z, i, j] - nodes.slider[HEIGHT, j]
            own[P, i, j] = own[Q, i, j] = own[X, i, j] = own[BACK, i, j] = 0.0
        return
    for j in range(n):
        z = own[U_Z, i, j] - nodes.slider[HEIGHT, j]
        slid = state.deformation[i] + own[U_X, i, j] - nodes.slider[TRAVEL, j]
        own[Z, i, j] = z
        own[X, i, j] = sign * law.limit(problem, z) if regime == Regime.SLIP else slid
        own[P, i, j] = kappa * load(z, shape)
        own[BACK, i, j] = 0.0
    if memory is not None and regime >= Regime.ANNULUS:
        for j in range(n):
            z = own[Z, i, j]
            level = own[LEVEL, i, j] if z > 0.0 else 0.0
            if regime == Regime.ANNULUS and z > 0.0:
                level, own[FRONT, i, j] = moment(memory, i, Regime.ANNULUS, sign, z, own[X, i, j], c)
            own[Q, i, j] = friction * level
    else:
        for j in range(n):
            own[Q, i, j] = tangential(problem, regime, sign, point_at(nodes, i, j))[0]
    if law.kind == Tangential.RECIPROCAL:
        for j in range(n):
            own[BACK, i, j] = spring(problem, regime, sign, point_at(nodes, i, j))[1]


@compiled
def _edge(problem, grid, state, nodes, segment, memory):
    """Fill the moment M at the nodes of contacts that grow without slip: dM = (3/2c) sqrt(z) dx."""
    own, n = nodes.contact, grid.sigma.size
    for i in range(state.regime.size):
        if state.regime[i] != Regime.GROW:
            continue
        for j in range(n):
            z = max(own[U_Z, i, j] - nodes.slider[HEIGHT, j], 0.0)
            own[FRONT, i, j] = np.sqrt(z) * (own[U_X_RATE, i, j] - nodes.slider[SPEED, j])
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += grid.integrals[segment.map, 0, k, j] * own[FRONT, i, k]
            own[LEVEL, i, j] = memory.level[i] + 1.5 / problem.limit_slope * segment.length * total


@compiled
def integrate(grid, state, nodes, segment):
    """Fill the slider's motion at the nodes from its accelerations there; return the largest change."""
    once, twice = grid.integrals[segment.map, 0], grid.integrals[segment.map, 1]
    slider, length, n = nodes.slider, segment.length, grid.sigma.size
    for j in range(0, n, 4):
        b = min(j, n - 4)  # the last four nodes may overlap with those before
        _four(once, b, slider[NORMAL_ACCELERATION], slider[NORMAL_ONCE])
        _four(twice, b, slider[NORMAL_ACCELERATION], slider[NORMAL_TWICE])
        _four(once, b, slider[TANGENTIAL_ACCELERATION], slider[TANGENTIAL_ONCE])
        _four(twice, b, slider[TANGENTIAL_ACCELERATION], slider[TANGENTIAL_TWICE])
    change = 0.0
    z_s, z_rate, v = state.slider[POSITION], state.slider[NORMAL_VELOCITY], state.slider[VELOCITY]
    for j in range(n):
        tau = grid.tau[segment.map, j]
        climb, speed = z_rate + length * slider[NORMAL_ONCE, j], v + length * slider[TANGENTIAL_ONCE, j]
        height = z_s + length * (z_rate * tau + length * slider[NORMAL_TWICE, j])
        travel = length * (v * tau + length * slider[TANGENTIAL_TWICE, j])
        moved = max(abs(height - slider[HEIGHT, j]), abs(travel - slider[TRAVEL, j]))
        moved = max(moved, abs(climb - slider[CLIMB, j]), abs(speed - slider[SPEED, j]))
        slider[HEIGHT, j], slider[CLIMB, j] = height, climb
        slider[TRAVEL, j], slider[SPEED, j] = travel, speed
        # a motion that is not finite must not pass for one that does not change
        change = max(change, moved if moved < 1e100 else 1e300)
    return change


@compiled
def _four(columns, j, values, out):
    """Fill four sums at once, sum_k columns[k, j..j+3] values[k]: the processor's width."""
    a = b = c = d = 0.0
    # unsigned places: no check for negative ones stands between the four
    j0, j1, j2, j3 = np.uint64(j), np.uint64(j + 1), np.uint64(j + 2), np.uint64(j + 3)
    for k in range(values.size):
        f = values[k]
        a += columns[k, j0] * f
        b += columns[k, j1] * f
        c += columns[k, j2] * f
        d += columns[k, j3] * f
    out[j0], out[j1], out[j2], out[j3] = a, b, c, d


@compiled
def has_converged(change, last):
    """Return whether Picard's iteration has arrived: the last change times the observed gain is below rounding."""
    gain = change / last
    return change < 1e-16 or (0.0 < gain < 0.5 and change * gain < 1e-15) or (gain > 0.5 and change < 2e-15)


@compiled
def lay_out(problem, grid, state, nodes, segment, mobile, memory):
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
        change = integrate(grid, state, nodes, segment) / (1.0 + abs(state.slider[POSITION]))
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
    normal, tangential = slider[NORMAL_ACCELERATION, 0], slider[TANGENTIAL_ACCELERATION, 0]
    z_s, climb, v = state.slider[POSITION], state.slider[NORMAL_VELOCITY], state.slider[VELOCITY]
    for j in range(grid.sigma.size):
        t = segment.length * grid.tau[segment.map, j]
        slider[HEIGHT, j] = z_s + t * (climb + 0.5 * t * normal)
        slider[CLIMB, j] = climb + t * normal
        slider[TRAVEL, j] = t * (v + 0.5 * t * tangential)
        slider[SPEED, j] = v + t * tangential


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
    z = own[U_Z, i, n] - nodes.slider[HEIGHT, n]
    own[Z, i, n] = z
    if state.regime[i] == Regime.SLIP:
        own[X, i, n] = state.sign[i] * problem.law.limit(problem, z)
    elif state.regime[i] != Regime.SEPARATED:
        own[X, i, n] = state.deformation[i] + own[U_X, i, n] - nodes.slider[TRAVEL, n]


@compiled
def point_at(nodes, i, j):
    """Return approach, deformation and their rates of a contact at a node."""
    own, slider = nodes.contact, nodes.slider
    z_rate, x_rate = own[U_Z_RATE, i, j] - slider[CLIMB, j], own[U_X_RATE, i, j] - slider[SPEED, j]
    return Point(own[Z, i, j], own[X, i, j], z_rate, x_rate)


@compiled
def guards(problem, state, nodes, i, which, memory):
    """Fill `nodes.guard` with guard `which` of contact i at all nodes."""
    regime, sign, own, out = state.regime[i], state.sign[i], nodes.contact, nodes.guard
    if which == 0:
        side = -1.0 if regime == Regime.SEPARATED else 1.0
        for j in range(out.size):
            out[j] = FAR_SIDE + side * own[Z, i, j]
        return
    for j in range(out.size):
        point = point_at(nodes, i, j)
        if memory is not None and regime >= Regime.ANNULUS:
            front, c = own[FRONT, i, j], problem.limit_slope
            out[j], _ = memory_guard(memory, i, regime, which, sign, point, front, c)
        else:
            out[j] = guard(problem, regime, which, sign, point)
