r"""One smooth stretch of motion between two events, by Chebyshev-Picard iteration.

The forces at the nodes give velocities and positions by the collocation's integration matrices, and these give the
forces again. A slider is heavy against the contact's stiffness over a part of a cycle, so each sweep gains a factor of
about (omega_n L)^2/2: four digits and more at a wave of 2 MHz, and a shorter stretch where it gains too little.
"""

import numpy as np

from contact.compiled import compiled
from contact.memory import memory_guard, moment
from contact.regimes import ANNULUS, GROW, SEPARATED, SLIP, back_force, guard, traction

# rows of the table of node values common to all contacts
HEIGHT, CLIMB, TRAVEL, SPEED, PUSH, PULL = 0, 1, 2, 3, 4, 5
# planes of the table of node values per contact
U_Z, U_X, U_Z_RATE, U_X_RATE, Z, X, P, Q, BACK, FRONT, LEVEL, PLANES = range(12)


@compiled
def surface(phase, length, tau, waves, own):
    """Fill the surface's displacement (u_x relative to the start) and velocity at the nodes."""
    c0, s0 = np.cos(phase), np.sin(phase)
    for j in range(tau.size):
        t = phase + length * tau[j]
        c, s = np.cos(t), np.sin(t)
        for i in range(waves.shape[0]):
            own[U_Z, i, j] = waves[i, 0] * c + waves[i, 1] * s
            own[U_X, i, j] = waves[i, 2] * (c - c0) + waves[i, 3] * (s - s0)
            own[U_Z_RATE, i, j] = waves[i, 1] * c - waves[i, 0] * s
            own[U_X_RATE, i, j] = waves[i, 3] * c - waves[i, 2] * s


@compiled
def forces(parameters, regime, sign, start_x, shared, own, mobile, length, once, sigma, bary, memory):
    """Fill approach, deformation, forces and accelerations at the nodes from the slider's motion there."""
    kappa, chi, d_n, p, d_t, q, mu, c = parameters[:8]
    reciprocal = parameters[10] == 1.0
    if memory is not None:
        _edge(regime, c, shared, own, length, once, memory)
    for j in range(shared.shape[1]):
        push, pull = 0.0, 0.0
        for i in range(regime.size):
            z = own[U_Z, i, j] - shared[HEIGHT, j]
            own[Z, i, j] = z
            own[P, i, j] = 0.0
            own[Q, i, j] = 0.0
            own[X, i, j] = 0.0
            own[BACK, i, j] = 0.0
            if regime[i] == SEPARATED:
                continue
            x = sign[i] * c * z if regime[i] == SLIP else start_x[i] + own[U_X, i, j] - shared[TRAVEL, j]
            own[X, i, j] = x
            if z > 0.0:
                elastic = kappa * z * np.sqrt(z)
                own[P, i, j] = elastic
                if memory is not None and regime[i] >= ANNULUS:
                    own[Q, i, j] = mu * kappa * own[LEVEL, i, j]
                    if regime[i] == ANNULUS:
                        level, own[FRONT, i, j] = moment(memory, i, ANNULUS, sign[i], z, x, c, sigma, bary)
                        own[Q, i, j] = mu * kappa * level
                else:
                    own[Q, i, j] = traction(regime[i], sign[i], z, x, elastic, mu, c)
                push += elastic * (1.0 + chi * (own[U_Z_RATE, i, j] - shared[CLIMB, j]))
                pull += own[Q, i, j]
                if reciprocal:
                    own[BACK, i, j] = back_force(regime[i], sign[i], z, x, elastic, mu, c)
                    push += own[BACK, i, j]
        if mobile:
            shared[PUSH, j] = push - d_n * shared[CLIMB, j] - p
            shared[PULL, j] = pull - d_t * shared[SPEED, j] - q
        else:
            shared[PUSH, j] = 0.0
            shared[PULL, j] = 0.0


@compiled
def _edge(regime, c, shared, own, length, once, memory):
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
                total += once[j, k] * own[FRONT, i, k]
            own[LEVEL, i, j] = memory.level[i] + 1.5 / c * length * total


@compiled
def sweep(
    parameters, state, length, tau, once, twice, regime, sign, shared, own, mobile, sigma, bary, memory, most
):
    """Iterate to the fixed point; return (converged, sweeps).

    The motion on entry is the first guess. Converged: the last change times the observed gain is below rounding.
    """
    n = tau.size
    last = np.inf
    for count in range(1, most + 1):
        forces(parameters, regime, sign, state[3:], shared, own, mobile, length, once, sigma, bary, memory)
        if not mobile:
            return True, 1
        change = 0.0
        for j in range(n):
            w = h = v = d = 0.0
            for k in range(n):
                w += once[j, k] * shared[PUSH, k]
                h += twice[j, k] * shared[PUSH, k]
                v += once[j, k] * shared[PULL, k]
                d += twice[j, k] * shared[PULL, k]
            w = state[1] + length * w
            h = state[0] + length * (state[1] * tau[j] + length * h)
            v = state[2] + length * v
            d = length * (state[2] * tau[j] + length * d)
            change = max(change, abs(h - shared[HEIGHT, j]), abs(d - shared[TRAVEL, j]))
            change = max(change, abs(w - shared[CLIMB, j]), abs(v - shared[SPEED, j]))
            shared[HEIGHT, j], shared[CLIMB, j], shared[TRAVEL, j], shared[SPEED, j] = h, w, d, v
        if not change < 1e100:
            return False, count
        change /= 1.0 + abs(state[0])
        gain = change / last
        if (
            change < 1e-16
            or (count > 1 and change * gain < 1e-15 and gain < 0.5)
            or (change < 2e-15 and gain > 0.5)
        ):
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
def guards(i, which, regime, sign, shared, own, c, band, memory, out):
    """Fill `out` with guard `which` of contact i at all nodes."""
    for j in range(out.size):
        z, x = own[Z, i, j], own[X, i, j]
        z_rate, x_rate = own[U_Z_RATE, i, j] - shared[CLIMB, j], own[U_X_RATE, i, j] - shared[SPEED, j]
        if memory is not None and regime[i] >= ANNULUS:
            out[j], _ = memory_guard(
                memory, i, regime[i], which, sign[i], z, x, z_rate, x_rate, own[FRONT, i, j], c
            )
        else:
            out[j] = guard(regime[i], which, sign[i], z, x, z_rate, x_rate, c, band)
