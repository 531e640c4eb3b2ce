r"""One smooth stretch of motion between two events, by Chebyshev-Picard iteration.

The forces at the nodes give velocities and positions by the collocation's integration matrices, and these give the
forces again. A slider is heavy against the contact's stiffness over a part of a cycle, so each sweep gains a factor of
about (omega_n L)^2/2: four digits and more at a wave of 2 MHz, and a shorter stretch where it gains too little.
"""

import numpy as np

from contact.jit.compiled import compiled
from contact.kinematics import at_phase
from contact.law.elastic import (
    ANNULUS,
    FAR_SIDE,
    GROW,
    SEPARATED,
    SLIP,
    STICK,
    back_force,
    friction_load,
    guard,
    traction,
)
from contact.law.hysteretic import memory_guard, moment
from contact.law.normal import load
from contact.problem import RECIPROCAL

# rows of the table of node values common to all contacts
HEIGHT, CLIMB, TRAVEL, SPEED, PUSH, PULL, ROWS = range(7)
# planes of the table of node values per contact
U_Z, U_X, U_Z_RATE, U_X_RATE, Z, X, P, Q, BACK, FRONT, LEVEL, PLANES = range(12)
# a longer stretch takes the C library's sine and cosine
_SHORT = 0.8


@compiled
def surface(phase, length, tau, paths, own):
    """Fill the surface's displacement (u_z with the contact's height, u_x from the start) and velocity at the nodes."""
    c0, s0 = np.cos(phase), np.sin(phase)
    short = length <= _SHORT
    for i in range(paths.height.size):
        # in the frame of the start: u_z = a cos t + b sin t, u_x = d cos t + e sin t
        a, b, d, e = at_phase(paths, i, c0, s0)
        for j in range(tau.size):
            t = length * tau[j]
            if short:
                s, v = _sine(t)
            else:
                s, v = np.sin(t), 1.0 - np.cos(t)
            c = 1.0 - v
            own[U_Z, i, j] = paths.height[i] + a * c + b * s
            own[U_X, i, j] = e * s - d * v
            own[U_Z_RATE, i, j] = b * c - a * s
            own[U_X_RATE, i, j] = e * c - d * s


@compiled
def _sine(t):
    """Return sin t and 1 - cos t for |t| <= 0.8 by their series, to rounding."""
    y = t * t
    s, v = 1.0 - y * (1.0 / 272.0), 1.0 - y * (1.0 / 306.0)
    s, v = 1.0 - y * (1.0 / 210.0) * s, 1.0 - y * (1.0 / 240.0) * v
    s, v = 1.0 - y * (1.0 / 156.0) * s, 1.0 - y * (1.0 / 182.0) * v
    s, v = 1.0 - y * (1.0 / 110.0) * s, 1.0 - y * (1.0 / 132.0) * v
    s, v = 1.0 - y * (1.0 / 72.0) * s, 1.0 - y * (1.0 / 90.0) * v
    s, v = 1.0 - y * (1.0 / 42.0) * s, 1.0 - y * (1.0 / 56.0) * v
    s, v = 1.0 - y * (1.0 / 20.0) * s, 1.0 - y * (1.0 / 30.0) * v
    s, v = 1.0 - y * (1.0 / 6.0) * s, 1.0 - y * (1.0 / 12.0) * v
    return t * s, 0.5 * y * v


@compiled
def forces(problem, regime, sign, start_x, shared, own, mobile, length, columns, sigma, bary, memory):
    """Fill approach, deformation, forces and accelerations at the nodes from the slider's motion there."""
    d_n, p, d_t, q = problem.normal_damping, problem.preload, problem.tangential_damping, problem.load
    n = shared.shape[1]
    if memory is not None:
        _edge(regime, problem.limit_slope, shared, own, length, columns, memory)
    for j in range(n):
        shared[PUSH, j] = -d_n * shared[CLIMB, j] - p if mobile else 0.0
        shared[PULL, j] = -d_t * shared[SPEED, j] - q if mobile else 0.0
    for i in range(regime.size):
        if regime[i] == SEPARATED:
            for j in range(n):
                own[Z, i, j] = own[U_Z, i, j] - shared[HEIGHT, j]
                own[P, i, j] = own[Q, i, j] = own[X, i, j] = own[BACK, i, j] = 0.0
            continue
        _contact(problem, i, regime[i], sign[i], start_x[i], shared, own, sigma, bary, memory)
        if mobile:
            chi = problem.contact_damping
            for j in range(n):
                damped = own[P, i, j] * (1.0 + chi * (own[U_Z_RATE, i, j] - shared[CLIMB, j]))
                shared[PUSH, j] += damped + own[BACK, i, j]
                shared[PULL, j] += own[Q, i, j]


@compiled
def _contact(problem, i, regime, sign, start_x, shared, own, sigma, bary, memory):
    """Fill approach, deformation and forces of one contact that is not apart; branch-free where it is often used."""
    kappa, mu, c = problem.stiffness, problem.friction, problem.limit_slope
    n = shared.shape[1]
    for j in range(n):
        z = own[U_Z, i, j] - shared[HEIGHT, j]
        x = sign * c * z if regime == SLIP else start_x + own[U_X, i, j] - shared[TRAVEL, j]
        own[Z, i, j] = z
        own[X, i, j] = x
        own[P, i, j] = kappa * load(z, problem.shape)
        own[BACK, i, j] = 0.0
    if regime == STICK and c > 0.0:
        for j in range(n):
            z = own[Z, i, j]
            full = sign * mu * kappa * friction_load(z, z - sign * own[X, i, j] / c, problem.shape)
            own[Q, i, j] = full if z > 0.0 else 0.0
    elif memory is not None and regime >= ANNULUS:
        for j in range(n):
            z = own[Z, i, j]
            level = own[LEVEL, i, j] if z > 0.0 else 0.0
            if regime == ANNULUS and z > 0.0:
                level, own[FRONT, i, j] = moment(memory, i, ANNULUS, sign, z, own[X, i, j], c, sigma, bary)
            own[Q, i, j] = mu * kappa * level
    else:
        for j in range(n):
            own[Q, i, j] = traction(regime, sign, own[Z, i, j], own[X, i, j], mu * kappa, c, problem.shape)
    if problem.law == RECIPROCAL:
        for j in range(n):
            own[BACK, i, j] = back_force(
                regime, sign, own[Z, i, j], own[X, i, j], mu * kappa, c, problem.shape
            )


@compiled
def _edge(regime, c, shared, own, length, columns, memory):
    """Fill the moment M at the nodes of contacts that grow without slip: dM = (3/2c) sqrt(z) dx."""
    n = shared.shape[1]
    for i in range(regime.size):
        if regime[i] != GROW:
            continue
        for j in range(n):
            z = max(own[U_Z, i, j] - shared[HEIGHT, j], 0.0)
            own[FRONT, i, j] = np.sqrt(z) * (own[U_X_RATE, i, j] - shared[SPEED, j])
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += columns[0, k, j] * own[FRONT, i, k]
            own[LEVEL, i, j] = memory.level[i] + 1.5 / c * length * total


@compiled
def integrate(state, length, tau, columns, shared):
    """Fill the slider's motion at the nodes from its accelerations there; return the largest change."""
    n = tau.size
    change = 0.0
    for j in range(0, n, 4):
        # the last four nodes may overlap with those before
        b = min(j, n - 4)
        w0, w1, w2, w3 = _four(columns[0], b, shared[PUSH])
        h0, h1, h2, h3 = _four(columns[1], b, shared[PUSH])
        v0, v1, v2, v3 = _four(columns[0], b, shared[PULL])
        d0, d1, d2, d3 = _four(columns[1], b, shared[PULL])
        change = max(change, _settle(state, length, tau, shared, b, w0, h0, v0, d0))
        change = max(change, _settle(state, length, tau, shared, b + 1, w1, h1, v1, d1))
        change = max(change, _settle(state, length, tau, shared, b + 2, w2, h2, v2, d2))
        change = max(change, _settle(state, length, tau, shared, b + 3, w3, h3, v3, d3))
    return change


@compiled
def _four(columns, j, values):
    """Return four sums at once, sum_k columns[k, j..j+3] values[k]: the processor's width."""
    a = b = c = d = 0.0
    # unsigned places: no check for negative ones stands between the four
    j0, j1, j2, j3 = np.uint64(j), np.uint64(j + 1), np.uint64(j + 2), np.uint64(j + 3)
    for k in range(values.size):
        f = values[k]
        a += columns[k, j0] * f
        b += columns[k, j1] * f
        c += columns[k, j2] * f
        d += columns[k, j3] * f
    return a, b, c, d


@compiled
def _settle(state, length, tau, shared, j, w, h, v, d):
    """Set the motion at one node from the integrals; return its change."""
    w = state[1] + length * w
    h = state[0] + length * (state[1] * tau[j] + length * h)
    v = state[2] + length * v
    d = length * (state[2] * tau[j] + length * d)
    change = max(abs(h - shared[HEIGHT, j]), abs(d - shared[TRAVEL, j]))
    change = max(change, abs(w - shared[CLIMB, j]), abs(v - shared[SPEED, j]))
    shared[HEIGHT, j], shared[CLIMB, j], shared[TRAVEL, j], shared[SPEED, j] = h, w, d, v
    # a motion that is not finite must not pass for one that does not change
    return change if change < 1e100 else 1e300


@compiled
def still(change, last):
    """Return whether Picard's iteration has arrived: the last change times the observed gain is below rounding."""
    gain = change / last
    return change < 1e-16 or (0.0 < gain < 0.5 and change * gain < 1e-15) or (gain > 0.5 and change < 2e-15)


@compiled
def sweep(problem, state, length, tau, columns, regime, sign, shared, own, mobile, sigma, bary, memory, most):
    """Iterate to the fixed point; return (converged, sweeps).

    The motion on entry is the first guess.
    """
    last = np.inf
    for count in range(1, most + 1):
        forces(problem, regime, sign, state[3:], shared, own, mobile, length, columns, sigma, bary, memory)
        if not mobile:
            return True, 1
        change = integrate(state, length, tau, columns, shared) / (1.0 + abs(state[0]))
        if not change < 1e100:
            return False, count
        if still(change, last):
            return True, count
        last = change
    return False, most


@compiled
def guess(state, length, tau, push, pull, shared):
    """Fill the first guess: constant accelerations from the end of the last stretch."""
    for j in range(tau.size):
        t = length * tau[j]
        shared[HEIGHT, j] = state[0] + t * (state[1] + 0.5 * t * push)
        shared[CLIMB, j] = state[1] + t * push
        shared[TRAVEL, j] = t * (state[2] + 0.5 * t * pull)
        shared[SPEED, j] = state[2] + t * pull


@compiled
def end_kinematics(regime, sign, start_x, c, shared, own):
    """Set approach and deformation of every contact at the end of the segment from the slider's motion there.

    Picard's iteration leaves them as they were before its last sweep, up to 1e-12 away: enough for a contact that has
    just closed to begin the next segment with a negative approach.
    """
    n = shared.shape[1] - 1
    for i in range(regime.size):
        z = own[U_Z, i, n] - shared[HEIGHT, n]
        own[Z, i, n] = z
        if regime[i] == SLIP:
            own[X, i, n] = sign[i] * c * z
        elif regime[i] != SEPARATED:
            own[X, i, n] = start_x[i] + own[U_X, i, n] - shared[TRAVEL, n]


@compiled
def guards(i, which, regime, sign, shared, own, c, band, memory, out):
    """Fill `out` with guard `which` of contact i at all nodes."""
    if which == 0:
        side = -1.0 if regime[i] == SEPARATED else 1.0
        for j in range(out.size):
            out[j] = FAR_SIDE + side * own[Z, i, j]
        return
    for j in range(out.size):
        z, x = own[Z, i, j], own[X, i, j]
        z_rate, x_rate = own[U_Z_RATE, i, j] - shared[CLIMB, j], own[U_X_RATE, i, j] - shared[SPEED, j]
        if memory is not None and regime[i] >= ANNULUS:
            out[j], _ = memory_guard(
                memory, i, regime[i], which, sign[i], z, x, z_rate, x_rate, own[FRONT, i, j], c
            )
        else:
            out[j] = guard(regime[i], which, sign[i], z, x, z_rate, x_rate, c, band)
