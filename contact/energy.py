r"""Where the energy goes, stretch by stretch: powers at the nodes, integrated with the motion's own matrices.

The surface does the work N u_z' + Q u_x' on the contact, N all of the normal force. What does not reach the slider is
stored in the springs, lost in the Hunt-Crossley damper (chi P z'^2) or in slip (Q times slip speed). The elastic law
has no potential unless the reciprocal normal force dW/dz acts: without it the law itself loses -(dW/dz) z'
(negative: energy out of nothing). The slider passes on to its dampers, the load, and the preload's
potential. All in the scaled problem's unit of energy, m omega^2 ell^2.
"""

import numpy as np

from contact.compiled import compiled
from contact.regimes import CREEP, SEPARATED, SLIP, back_force
from contact.stretch import BACK, CLIMB, SPEED, TRAVEL, U_X_RATE, U_Z_RATE, P, Q, X, Z

# places in the sums: integrals over phase of sum Q, of the sum of normal forces without damper, slider displacement
TRACTION, SUPPORT, DISPLACEMENT = 0, 1, 2
# energies
WAVE_NORMAL, WAVE_TANGENTIAL, SLIP_LOSS, CONTACT_LOSS, NORMAL_LOSS, TANGENTIAL_LOSS, LOAD_WORK, LEAK = range(
    3, 11
)
# phase since the last event (0: none yet) and the inverse of the smallest gap between two
SINCE, CROWDING, SUMS = 11, 12, 13


@compiled
def account(parameters, length, once, regime, sign, shared, own, sums):
    """Add the integrals over one stretch to the sums."""
    chi, d_n, d_t, q, mu, c = (
        parameters[1], parameters[2], parameters[4], parameters[5], parameters[6], parameters[7],
    )  # fmt: skip
    n = shared.shape[1]
    for k in range(n):
        weight = length * once[n - 1, k]
        w, v = shared[CLIMB, k], shared[SPEED, k]
        sums[NORMAL_LOSS] += weight * d_n * w * w
        sums[TANGENTIAL_LOSS] += weight * d_t * v * v
        sums[LOAD_WORK] += weight * q * v
        for i in range(regime.size):
            if regime[i] == SEPARATED:
                continue
            normal, traction = own[P, i, k], own[Q, i, k]
            z_rate, x_rate = own[U_Z_RATE, i, k] - w, own[U_X_RATE, i, k] - v
            spring = normal + own[BACK, i, k]
            damper = chi * normal * z_rate
            sums[TRACTION] += weight * traction
            sums[SUPPORT] += weight * spring
            sums[WAVE_NORMAL] += weight * (spring + damper) * own[U_Z_RATE, i, k]
            sums[WAVE_TANGENTIAL] += weight * traction * own[U_X_RATE, i, k]
            sums[CONTACT_LOSS] += weight * damper * z_rate
            if regime[i] == SLIP or regime[i] == CREEP:
                sums[SLIP_LOSS] += weight * traction * (x_rate - sign[i] * c * z_rate)
            if parameters[10] == 0.0:
                force = back_force(regime[i], sign[i], own[Z, i, k], own[X, i, k], normal, mu, c)
                sums[LEAK] -= weight * force * z_rate
    sums[DISPLACEMENT] += shared[TRAVEL, n - 1]
    if sums[SINCE] > 0.0:
        sums[SINCE] += length


@compiled
def mark(sums):
    """Note an event: the gap since the last one counts if there was one."""
    if sums[SINCE] > 1e-200:
        sums[CROWDING] = max(sums[CROWDING], 1.0 / sums[SINCE])
    sums[SINCE] = np.finfo(np.float64).tiny
