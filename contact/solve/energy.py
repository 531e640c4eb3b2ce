r"""Where the energy goes, segment by segment: powers at the nodes, integrated with the motion's own matrices.

The surface does the work N u_z' + Q u_x' on the contact, N all of the normal force. What does not reach the slider is
stored in the springs, lost in the Hunt-Crossley damper (chi P z'^2) or in slip (Q times slip speed). The elastic law
has no potential unless the reciprocal normal force dW/dz acts: without it the law itself loses -(dW/dz) z'
(negative: energy out of nothing). The slider passes on to its dampers, the load, and the preload's
potential. All in the scaled problem's unit of energy, m omega^2 ell^2.
"""

import numpy as np

from contact.codes import Regime, Tangential
from contact.interpolation import interpolate
from contact.jit.compiled import compiled, formula
from contact.kinematics import Point, slip_speed
from contact.law.elastic import spring, tangential
from contact.law.hysteretic import annulus_slip, front, place_on
from contact.solve.collocation import ROOT_AT_START, SMOOTH
from contact.solve.segment import (
    BACK,
    CLIMB,
    FRONT,
    LEVEL,
    SPEED,
    TRAVEL,
    U_X_RATE,
    U_Z_RATE,
    P,
    Q,
    Z,
    point_at,
)

# places in the sums: integrals over phase of sum Q, of the sum of normal forces without damper, slider displacement
TRACTION, SUPPORT, DISPLACEMENT = 0, 1, 2
# energies, in the order of `answers.ledger.Ledger`
WAVE_NORMAL, WAVE_TANGENTIAL, SLIP_LOSS, CONTACT_LOSS, NORMAL_LOSS, TANGENTIAL_LOSS, LOAD_WORK, LEAK = range(
    3, 11
)
# phase since the last event (0: none yet) and the inverse of the smallest gap between two
SINCE, CROWDING, SUMS = 11, 12, 13
# Gauss and Legendre's rule on [0, 1]
CROWDED, WEIGHT = (0.5 * each for each in np.polynomial.legendre.leggauss(20))
CROWDED = CROWDED + 0.5


@compiled
def account(problem, grid, state, nodes, segment):
    """Add the integrals over one segment to the sums."""
    account_slider(problem, grid, state, nodes, segment)
    for i in range(state.regime.size):
        account_contact(problem, grid, state, nodes, segment, i)
    if state.sums[SINCE] > 0.0:
        state.sums[SINCE] += segment.length


@compiled
def account_slider(problem, grid, state, nodes, segment):
    """Add the slider's own integrals over one segment."""
    slider, sums, last = nodes.slider, state.sums, nodes.guard.size - 1
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        w, v = slider[CLIMB, k], slider[SPEED, k]
        sums[NORMAL_LOSS] += weight * problem.normal_damping * w * w
        sums[TANGENTIAL_LOSS] += weight * problem.tangential_damping * v * v
        sums[LOAD_WORK] += weight * problem.load * v
    sums[DISPLACEMENT] += slider[TRAVEL, last]


@compiled
def account_contact(problem, grid, state, nodes, segment, i):
    """Add the integrals of one contact over one segment."""
    own, sums, law, last = nodes.contact, state.sums, problem.law, nodes.guard.size - 1
    regime, sign, friction = state.regime[i], state.sign[i], problem.friction * problem.stiffness
    if regime == Regime.SEPARATED:
        return
    rated = regime == Regime.SLIP and law.rated
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        point, tangential_force = point_at(nodes, i, k), own[Q, i, k]
        z, _, z_rate, x_rate = point
        normal = own[P, i, k] + own[BACK, i, k]
        damper = problem.contact_damping * own[P, i, k] * z_rate
        sums[TRACTION] += weight * tangential_force
        sums[SUPPORT] += weight * normal
        sums[WAVE_NORMAL] += weight * (normal + damper) * own[U_Z_RATE, i, k]
        sums[WAVE_TANGENTIAL] += weight * tangential_force * own[U_X_RATE, i, k]
        sums[CONTACT_LOSS] += weight * damper * z_rate
        slip = slip_speed(sign, z_rate, x_rate, law.limit_rate(problem, z))
        if rated:
            sums[SLIP_LOSS] += weight * tangential_force * x_rate
        elif regime == Regime.SLIP or regime == Regime.CREEP:
            sums[SLIP_LOSS] += weight * tangential_force * sign * slip
        elif regime == Regime.ANNULUS:
            sums[SLIP_LOSS] += weight * friction * annulus_slip(z, own[FRONT, i, k]) * slip
        if law.kind == Tangential.ELASTIC and not rated:
            sums[LEAK] -= weight * spring(problem, regime, sign, point)[1] * z_rate
    if rated:
        work, leak = _spring_in_slip(problem, grid, state, nodes, segment, i)
        sums[SLIP_LOSS] -= work
        sums[LEAK] += leak


@compiled
def _spring_in_slip(problem, grid, state, nodes, segment, i):
    """Return (work on the spring of a contact that slips, leak of the law) over a segment.

    The work is int F dx = [F x] - int x dF, F at most the force at the slip limit: towards the end of slip x of a
    sphere goes as the time left to the power 2/3, and F is smooth. Gauss's points crowd there as a cube.
    """
    sign, own, n = state.sign[i], nodes.contact, nodes.guard.size
    force, rate = own[LEVEL, i], own[FRONT, i]
    x = 0.0
    for j in range(n):
        force[j], x = _spring_force(problem, sign, point_at(nodes, i, j))
        if j == 0:
            start = force[0] * x
    work, leak = force[n - 1] * x - start, 0.0
    for k in range(n):
        rate[k] = 0.0
        for j in range(n):
            rate[k] += grid.rates[k, j] * force[j]
    for k in range(CROWDED.size):
        sigma, weight = 1.0 - 2.0 * CROWDED[k] ** 3, 6.0 * CROWDED[k] ** 2 * WEIGHT[k]
        z = interpolate(sigma, grid.sigma, grid.bary, own[Z, i])
        z_rate = interpolate(sigma, grid.sigma, grid.bary, own[U_Z_RATE, i])
        z_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[CLIMB])
        x_rate = interpolate(sigma, grid.sigma, grid.bary, own[U_X_RATE, i])
        x_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[SPEED])
        point = Point(z, 0.0, z_rate, x_rate)
        work -= (
            weight * _spring_force(problem, sign, point)[1] * interpolate(sigma, grid.sigma, grid.bary, rate)
        )
        # d tau/d sigma of the map
        slope = (
            0.5
            if segment.map == SMOOTH
            else 0.5 * (1.0 + sigma if segment.map == ROOT_AT_START else 1.0 - sigma)
        )
        leak -= weight * segment.length * slope * spring(problem, Regime.SLIP, sign, point)[1] * z_rate
    return work, leak


@formula
def _spring_force(problem, sign, point):
    """Return the force of the spring of a contact that slips, and its deformation."""
    force, x = tangential(problem, Regime.SLIP, sign, point)
    z, law = point[0], problem.law
    most = problem.stiffness * law.stuck(problem, z, law.limit(problem, z)) if z > 0.0 else 0.0
    return min(abs(force), most), x


@compiled
def mark(sums):
    """Note an event: the gap since the last one counts if there was one."""
    if sums[SINCE] > 1e-200:
        sums[CROWDING] = max(sums[CROWDING], 1.0 / sums[SINCE])
    sums[SINCE] = 1e-300


def chain_energy(problem, memory, i, regime, s, z, x):
    """Return the tangential springs' energy, mu K (3/8c) int (x - y)^2/sqrt(eta) d eta, x - y the deflection.

    On a line y is linear in eta; on a curve sqrt(eta) dy = (2c/3) dM, so that by parts the integral is
    [2 sqrt(eta) (x - y)^2] + (8c/3) int (x - y) dM, by Gauss's rule on its polynomials.
    """
    if regime == Regime.SEPARATED or z <= 0.0:
        return 0.0
    c = problem.limit_slope
    pieces = [(memory.kind[i, k], *memory.corner[i, k, :3], k) for k in range(memory.count[i])]
    if regime == Regime.SLIP:
        pieces = [(int(s), 0.0, 0.0, 0.0, -1)]
    elif regime == Regime.ANNULUS:
        eta, _ = front(memory, i, s, z, x, c)
        y = x - s * c * (z - eta)
        pieces.append((int(s), eta, y - c * eta, y + c * eta, -1))
    node, weight = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for number, (kind, start, u, w, k) in enumerate(pieces):
        stop = pieces[number + 1][1] if number + 1 < len(pieces) else z
        if kind != 0:
            deflection, roots = x - 0.5 * (u + w) + kind * c * start, np.sqrt([max(start, 0.0), stop])
            parts = (
                2.0 * deflection**2 * roots
                - 4.0 / 3.0 * deflection * kind * c * roots**3
                + 0.4 * c**2 * roots**5
            )
            total += parts[1] - parts[0]
            continue
        curve = memory.curve[i, k]
        end = (
            place_on(curve, stop, c, memory.grid.sigma, memory.grid.bary)
            if 2.0 * c * stop < curve[1, -1] - curve[0, -1]
            else 1.0
        )
        middle, half = 0.5 * (end - 1.0), 0.5 * (end + 1.0)
        profile, slope = 0.5 * (curve[0] + curve[1]), memory.grid.rates @ curve[2]

        def at(values, place):
            return interpolate(place, memory.grid.sigma, memory.grid.bary, values)

        inside = sum(
            g * (x - at(profile, middle + half * p)) * at(slope, middle + half * p)
            for p, g in zip(node, weight, strict=True)
        )
        total += 8.0 * c / 3.0 * half * inside
        total += (
            2.0 * np.sqrt(stop) * (x - at(profile, end)) ** 2
            - 2.0 * np.sqrt(max(start, 0.0)) * (x - profile[0]) ** 2
        )
    return problem.friction * problem.stiffness * 0.375 / c * total
