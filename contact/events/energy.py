r"""Energies of a motion, segment by segment: powers at the nodes, integrated with the motion's own matrices.

The surface does the work N u_z' + Q u_x' on a contact, N the whole normal force. The part that does not reach the
slider is stored in the springs, lost in the Hunt-Crossley damper (power chi P z'^2) or lost in slip (Q times the speed
of slip). The elastic law has no potential unless the reciprocal normal force dW/dz acts. Without it the law itself
loses -(dW/dz) z', which may be negative (the leak). The slider gives its energy to its dampers, the load and the
potential of the preload. The unit of energy is m omega^2 ell^2.
"""

from enum import IntEnum

import numpy as np

from contact.body import Point
from contact.codes import Regime, Tangential
from contact.events.collocation import ROOT_AT_START, SMOOTH
from contact.events.segment import Plane, Row, normal_force, point_at
from contact.jit.compiled import compiled, formula
from contact.law.elastic import spring, tangential
from contact.law.hysteretic import annulus_slip
from contact.law.protocol import slip_limit, slip_rate
from contact.roots import interpolate


class Sum(IntEnum):
    """Places in `State.sums`; from WAVE_NORMAL to LEAK energies, in the order of `answers.ledger.Ledger`."""

    TANGENTIAL_FORCE = 0  # integral of sum Q over the phase
    NORMAL_FORCE = 1  # integral of the sum of the normal forces without their dampers
    DISPLACEMENT = 2  # of the slider along the wave
    WAVE_NORMAL = 3
    WAVE_TANGENTIAL = 4
    SLIP_LOSS = 5
    CONTACT_LOSS = 6
    NORMAL_LOSS = 7
    TANGENTIAL_LOSS = 8
    LOAD_WORK = 9
    LEAK = 10
    SINCE = 11  # phase since the last event; 0: none yet
    CROWDING = 12  # inverse of the smallest phase between two events


# Gauss-Legendre rule on [0, 1], whose points are then crowded at the end of slip
CROWDED, WEIGHT = (0.5 * each for each in np.polynomial.legendre.leggauss(20))
CROWDED = CROWDED + 0.5


@compiled
def account(problem, grid, state, nodes, segment):
    """Add the integrals over one segment to the sums."""
    account_slider(problem, grid, state, nodes, segment)
    for i in range(state.regime.size):
        account_contact(problem, grid, state, nodes, segment, i)
    if state.sums[Sum.SINCE] > 0.0:
        state.sums[Sum.SINCE] += segment.length


@compiled
def account_slider(problem, grid, state, nodes, segment):
    """Add the slider's own integrals over one segment."""
    slider, sums, last = nodes.slider, state.sums, nodes.guard.size - 1
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        w, v = slider[Row.NORMAL_VELOCITY, k], slider[Row.VELOCITY, k]
        sums[Sum.NORMAL_LOSS] += weight * problem.normal_damping * w * w
        sums[Sum.TANGENTIAL_LOSS] += weight * problem.tangential_damping * v * v
        sums[Sum.LOAD_WORK] += weight * problem.load * v
    sums[Sum.DISPLACEMENT] += slider[Row.TRAVEL, last]


@compiled
def account_contact(problem, grid, state, nodes, segment, i):
    """Add the integrals of one contact over one segment."""
    own, sums, law, last = nodes.contact, state.sums, problem.law, nodes.guard.size - 1
    regime, sign, friction = state.regime[i], state.sign[i], problem.friction * problem.stiffness
    if regime == Regime.SEPARATED:
        return
    rated = regime == Regime.SLIP and law.rated
    traction = support = by_normal = by_tangential = slip_loss = damper_loss = leak = 0.0
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        point, pull = point_at(nodes, i, k), weight * own[Plane.Q, i, k]
        z, _, z_rate, x_rate = point
        push = weight * normal_force(problem, nodes, i, k)
        damper = weight * problem.contact_damping * own[Plane.P, i, k] * z_rate
        traction += pull
        support += push - damper
        by_normal += push * own[Plane.U_Z_RATE, i, k]
        by_tangential += pull * own[Plane.U_X_RATE, i, k]
        damper_loss += damper * z_rate
        if rated:
            slip_loss += pull * x_rate
        elif regime != Regime.STICK:
            slip = slip_rate(problem, sign, point)
            if regime == Regime.SLIP or regime == Regime.CREEP:
                slip_loss += pull * sign * slip
            elif regime == Regime.ANNULUS:
                slip_loss += weight * friction * annulus_slip(z, own[Plane.FRONT, i, k]) * slip
        if law.kind == Tangential.ELASTIC and not rated:
            leak -= weight * spring(problem, regime, sign, point)[1] * z_rate
    if rated:
        work, leak = _spring_in_slip(problem, grid, state, nodes, segment, i)
        slip_loss -= work
    sums[Sum.TANGENTIAL_FORCE] += traction
    sums[Sum.NORMAL_FORCE] += support
    sums[Sum.WAVE_NORMAL] += by_normal
    sums[Sum.WAVE_TANGENTIAL] += by_tangential
    sums[Sum.SLIP_LOSS] += slip_loss
    sums[Sum.CONTACT_LOSS] += damper_loss
    sums[Sum.LEAK] += leak


@compiled
def _spring_in_slip(problem, grid, state, nodes, segment, i):
    """Return (work on the spring of a contact that slips, leak of the law) over a segment.

    The work is int F dx = [F x] - int x dF, F at most the force at the slip limit: towards the end of slip x of a
    sphere goes as the time left to the power 2/3, and F is smooth. Gauss's points crowd there as a cube.
    """
    sign, own, n = state.sign[i], nodes.contact, nodes.guard.size
    force, rate = own[Plane.LEVEL, i], own[Plane.FRONT, i]
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
        z = interpolate(sigma, grid.sigma, grid.bary, own[Plane.Z, i])
        z_rate = interpolate(sigma, grid.sigma, grid.bary, own[Plane.U_Z_RATE, i])
        z_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[Row.NORMAL_VELOCITY])
        x_rate = interpolate(sigma, grid.sigma, grid.bary, own[Plane.U_X_RATE, i])
        x_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[Row.VELOCITY])
        point = Point(z, 0.0, z_rate, x_rate)
        work -= weight * _spring_force(problem, sign, point)[1] * interpolate(sigma, grid.sigma, grid.bary, rate)
        if segment.map == SMOOTH:  # d tau/d sigma of the map
            slope = 0.5
        else:
            slope = 0.5 * (1.0 + sigma if segment.map == ROOT_AT_START else 1.0 - sigma)
        leak -= weight * segment.length * slope * spring(problem, Regime.SLIP, sign, point)[1] * z_rate
    return work, leak


@formula
def _spring_force(problem, sign, point):
    """Return the force of the spring of a contact that slips, and its deformation."""
    force, x = tangential(problem, Regime.SLIP, sign, point)
    z, law = point[0], problem.law
    most = problem.stiffness * law.stuck(problem, z, slip_limit(problem, z)) if z > 0.0 else 0.0
    return min(abs(force), most), x


@compiled
def mark(sums):
    """Record an event: the phase since the last one, if there was one, may be the smallest."""
    if sums[Sum.SINCE] > 1e-200:
        sums[Sum.CROWDING] = max(sums[Sum.CROWDING], 1.0 / sums[Sum.SINCE])
    sums[Sum.SINCE] = 1e-300
