r"""Events at the end of a stretch: which guard vanishes first, how fast, and what follows.

The table of node values of the stretch is that of `segment`.
"""

import numpy as np

from contact.jit.compiled import compiled
from contact.kinematics import at_phase
from contact.law.elastic import (
    ANNULUS,
    CONTACT,
    CREEP,
    FAR_SIDE,
    GRAZE,
    GROW,
    SEPARATED,
    SLIP,
    follow,
    guard,
    opening,
)  # fmt: skip
from contact.law.hysteretic import memory_guard, recall
from contact.solve.roots import first_root
from contact.solve.segment import (
    CLIMB,
    FRONT,
    PULL,
    PUSH,
    SPEED,
    U_X_RATE,
    U_Z_RATE,
    X,
    Z,
    guards,
)  # fmt: skip

# the last guard of each regime
_LAST = (0, 2, 1, 2, 3, 2)


def open_regimes(problem, phase, state, regime, sign):
    """Set regime and sign of every contact, and its deformation within the slip limit, from the state at a phase."""
    paths, c, s = problem.paths, np.cos(phase), np.sin(phase)
    for i in range(regime.size):
        u_z, u_z_rate, _, u_x_rate = at_phase(paths, i, c, s)
        regime[i], sign[i], state[3 + i] = opening(
            paths.height[i] + u_z - state[0], state[3 + i], u_z_rate - state[1], u_x_rate - state[2],
            problem.limit_slope, problem.stick_band,
        )  # fmt: skip


@compiled
def earliest(sigma, bary, rates, regime, sign, shared, own, c, band, memory, values):
    """Return (sigma, contact, guard) of the earliest root on the stretch; sigma = 2 if there is none."""
    first, who, which = 2.0, -1, -1
    for i in range(regime.size):
        for k in range(4):
            if (k > 0 and regime[i] == SEPARATED) or (k > _LAST[regime[i]]):
                continue
            if (
                k == 3
                and first < 1.0 - 1e-6
                and memory is not None
                and memory.kind[i, memory.count[i] - 1] == 0
            ):
                continue  # the front on a curve is smooth only up to the first of the other events
            guards(i, k, regime, sign, shared, own, c, band, memory, values)
            place = first_root(sigma, bary, rates, values)
            if place < first:
                first, who, which = place, i, k
    return first, who, which


@compiled
def end_guard(i, which, regime, sign, shared, own, paths, phase, c, band, memory):
    """Return a guard at the end of the stretch and its rate there."""
    n = shared.shape[1] - 1
    z_rate, x_rate = own[U_Z_RATE, i, n] - shared[CLIMB, n], own[U_X_RATE, i, n] - shared[SPEED, n]
    u_z, _, u_x, _ = at_phase(paths, i, np.cos(phase), np.sin(phase))
    z_second, x_second = -u_z - shared[PUSH, n], -u_x - shared[PULL, n]
    if memory is not None and regime[i] >= ANNULUS:
        value, rate = memory_guard(
            memory,
            i,
            regime[i],
            which,
            sign[i],
            own[Z, i, n],
            own[X, i, n],
            z_rate,
            x_rate,
            own[FRONT, i, n],
            c,
        )
        if which == 1:
            rate = sign[i] * x_second - c * z_second if regime[i] == ANNULUS else c * z_second - x_second
        elif which == 2 and regime[i] == GROW:
            rate = c * z_second + x_second
        return value, rate
    value = guard(regime[i], which, sign[i], own[Z, i, n], own[X, i, n], z_rate, x_rate, c, band)
    if (regime[i] == SLIP or regime[i] == CREEP) and which == 1:
        rate = sign[i] * x_second - c * z_second
        return value, rate if regime[i] == SLIP else -rate
    # the guards on position are linear in (z, x): their rate is the guard of the rates
    return value, guard(regime[i], which, sign[i], z_rate, x_rate, 0.0, 0.0, c, band) - FAR_SIDE


@compiled
def transit(problem, sigma, bary, state, regime, sign, phase, who, which, shared, own, memory, tally):
    """Take contact `who`, and all whose guards vanish at the same instant, to their next regimes and count it.

    Returns whether a contact was made.
    """
    contacts, n = regime.size, shared.shape[1]
    c, band = problem.limit_slope, problem.stick_band
    made = False
    _, rate = end_guard(who, which, regime, sign, shared, own, problem.paths, phase, c, band, memory)
    if not rate < 0.0:
        tally[GRAZE] += 1
    for i in range(contacts):
        for k in range(4):
            met = i == who and k == which
            if i != who and (regime[i] != SEPARATED or k == 0):
                value, rate = end_guard(
                    i, k, regime, sign, shared, own, problem.paths, phase, c, band, memory
                )
                met = abs(value) < 4e-16 and rate < 0.0
            if met:
                z_rate = own[U_Z_RATE, i, n - 1] - shared[CLIMB, n - 1]
                x_rate = own[U_X_RATE, i, n - 1] - shared[SPEED, n - 1]
                if memory is not None:
                    regime[i], sign[i], state[3 + i], kind = recall(
                        memory, i, regime[i], k, sign[i], own[Z, i, n - 1], state[3 + i], z_rate, x_rate, c,
                        sigma, bary,
                    )  # fmt: skip
                else:
                    regime[i], sign[i], state[3 + i], kind = follow(
                        regime[i], k, sign[i], own[Z, i, n - 1], state[3 + i], z_rate, x_rate, c, band
                    )
                tally[kind] += 1
                made = made or kind == CONTACT
                break
    return made
