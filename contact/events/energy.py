r"""Energies of a motion, segment by segment: powers at the nodes, integrated with the motion's own matrices.

The surface does work on a contact with the power N u_z' + Q u_x', N the whole normal force. The part that does not
reach the slider is stored in the springs, lost in the Hunt-Crossley damper (power chi P z'^2) or lost in slip (Q times
the slip speed). The energy W(z, x) of the tangential spring depends on the approach, so that the elastic law is
conservative only with the reciprocal normal force dW/dz. Without this force the power -(dW/dz) z', which may be
negative, has no physical source or sink; its integral is recorded as the *leak*. The slider gives its energy to its
dampers, the load and the potential of the preload. The unit of energy is m omega^2 ell^2.

The normal force without damper and reciprocal force has a potential V(z): with u_z' = z' + z_s' the surface does on it
the work [V] + int N z_s' dt. The work on the spring is known from its ends too: of a contact that slips with one
coefficient of friction by closed integrals of F dx and (dW/dz) z', of one that sticks by
-int (dW/dz) z' dt = int Q dx - [W]. By quadrature these integrals have the truncation error of the forces: with it a
burst's balance missed by 1e-9 to 1e-8 where its velocity was right to 1e-11. The hysteretic law keeps the quadrature,
since that of its slipping annuli has the same error.

A contact that holds on beyond the touch (`law.holding`) stores the work of its normal force since it closed; where it
opens this is lost, and with it the energy of its spring (`ADHESION_LOSS`). Its depth d takes the place of the approach.

A law is *rated* if its sliding force depends on the slip speed (`law.protocol.Law`). The spring of a rated contact
unloads while it slips, which `_slip_spring_work` accounts for.
"""

from enum import IntEnum

import numpy as np

from contact.body import Coordinates, Point, approach_rate, normal_amplitude, travel
from contact.codes import At, Regime, Tangential
from contact.events.collocation import ROOT_AT_START, SMOOTH
from contact.events.segment import (
    COMPILED_CONTACTS,
    SHAPES,
    ContactRow,
    SliderRow,
    depth_at,
    height_rate,
    normal_force,
    point_at,
)
from contact.jit.compiled import compiled, formula, native
from contact.law.elastic import spring, tangential
from contact.law.holding import depth, work
from contact.law.hysteretic import annulus_slip
from contact.law.normal import energy as load_energy
from contact.law.normal import load
from contact.law.protocol import slip_limit, slip_rate
from contact.problem import contact_parameters
from contact.roots import interpolate


class EnergySum(IntEnum):
    """Indices in `State.sums`; from WAVE_NORMAL to ADHESION_LOSS energies, in the order of `answers.ledger.Ledger`."""

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
    ADHESION_LOSS = 11
    SINCE = 12  # phase since the last event; 0 before the first one
    CROWDING = 13  # inverse of the smallest phase between two events
    HEIGHT = 14  # integral of the slider's position


# Gauss-Legendre rule on [0, 1]
GAUSS_POINTS, GAUSS_WEIGHTS = (0.5 * each for each in np.polynomial.legendre.leggauss(20))
GAUSS_POINTS = GAUSS_POINTS + 0.5


def spring_energy(problem, state, approaches):
    """Return the energy of all tangential springs at phase 0, of a law without memory."""
    total = np.zeros(1)
    (_add_compiled if approaches.size >= COMPILED_CONTACTS else _add_springs)(problem, state, approaches, total)
    return total[0]


def _add_springs(problem, state, approaches, total):
    rate, paths = Coordinates(state.slider[At.NORMAL_VELOCITY], state.slider[At.VELOCITY]), problem.paths
    for i in range(state.regime.size):
        z_rate, x_rate = approach_rate(paths.normal_sin[i], rate), travel(paths.tangential_sin[i], rate)
        point = Point(depth(approaches[i], problem.normal.hold), state.deformation[i], z_rate, x_rate)
        total[0] += spring(contact_parameters(problem, i), state.regime[i], state.sign[i], point)[2]
    return 0


_add_compiled = native("t t f1 f1", SHAPES | {"approaches": "n", "total": "1"})(_add_springs)


@compiled
def account(problem, grid, state, nodes, segment):
    """Add the integrals over one segment to the sums."""
    account_slider(problem, grid, state, nodes, segment)
    for i in range(state.regime.size):
        account_contact(problem, grid, state, nodes, segment, i)
    if state.sums[EnergySum.SINCE] > 0.0:
        state.sums[EnergySum.SINCE] += segment.length


@compiled
def account_slider(problem, grid, state, nodes, segment):
    """Add the slider's own integrals over one segment."""
    slider, sums, last = nodes.slider, state.sums, nodes.guard.size - 1
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        w, v = slider[SliderRow.NORMAL_VELOCITY, k], slider[SliderRow.VELOCITY, k]
        sums[EnergySum.NORMAL_LOSS] += weight * problem.normal_damping * w * w
        sums[EnergySum.TANGENTIAL_LOSS] += weight * problem.tangential_damping * v * v
        sums[EnergySum.LOAD_WORK] += weight * problem.load * v
        sums[EnergySum.HEIGHT] += weight * slider[SliderRow.POSITION, k]
    sums[EnergySum.DISPLACEMENT] += slider[SliderRow.TRAVEL, last]


@compiled
def account_contact(problem, grid, state, nodes, segment, i):
    """Add the integrals of one contact over one segment."""
    own, sums, last, contact = nodes.contact, state.sums, nodes.guard.size - 1, contact_parameters(problem, i)
    law, regime, sign, friction = contact.law, state.regime[i], state.sign[i], contact.friction * contact.stiffness
    if regime == Regime.SEPARATED:
        return
    slips, hold, conserves = regime == Regime.SLIP, contact.normal.hold, law.kind != Tangential.RECIPROCAL
    rated = slips and law.rated
    plain = not law.rated and not law.bent and law.callbacks is None
    # the work on its spring follows from the ends
    closed = law.kind != Tangential.HYSTERETIC and (regime == Regime.STICK or (slips and plain))
    tangential_sum = normal_sum = normal_work = tangential_work = slip_loss = damper_loss = leak = 0.0
    potential_work = back_work = 0.0
    for k in range(last + 1):
        weight = segment.length * grid.integrals[segment.map, 0, k, last]
        point, weighted_q = point_at(nodes, i, k, hold), weight * own[ContactRow.Q, i, k]
        z, _, z_rate, x_rate = point
        weighted_n, height = weight * normal_force(problem, nodes, i, k), height_rate(nodes, i, k)
        damper = weight * problem.contact_damping * own[ContactRow.P, i, k] * height
        tangential_sum += weighted_q
        normal_sum += weighted_n - damper
        weighted_back = weight * own[ContactRow.BACK, i, k]
        potential_work += (weight * own[ContactRow.P, i, k] + (weighted_back if conserves else 0.0)) * height
        back_work += 0.0 if conserves else weighted_back * height
        normal_work += weighted_n * own[ContactRow.U_Z_RATE, i, k]
        tangential_work += weighted_q * own[ContactRow.U_X_RATE, i, k]
        damper_loss += damper * height
        if rated or closed:  # work on spring and slip together; that on the spring is subtracted below
            slip_loss += weighted_q * x_rate
        elif regime != Regime.STICK:
            slip = slip_rate(contact, sign, point)
            if slips or regime == Regime.CREEP:
                slip_loss += weighted_q * sign * slip
            elif regime == Regime.ANNULUS:
                slip_loss += weight * friction * annulus_slip(z, own[ContactRow.FRONT, i, k], contact.normal) * slip
        if law.kind == Tangential.ELASTIC and not rated and not closed:
            leak -= weight * spring(contact, regime, sign, point)[1] * z_rate
    if rated:
        spring_work, leak = _slip_spring_work(contact, grid, state, nodes, segment, i)
        slip_loss -= spring_work
    if closed:
        begin, end = point_at(nodes, i, 0, hold), point_at(nodes, i, last, hold)
        spring_work, leak = closed_spring_work(contact, begin, end, regime, sign, slip_loss)
        slip_loss = 0.0 if regime == Regime.STICK else slip_loss - spring_work
        if not conserves:  # dW/dz is a force on the surface: it does this work instead of what the quadrature gives
            back_work, leak = back_work + leak, 0.0
        else:
            back_work = 0.0
    if law.kind != Tangential.HYSTERETIC and normal_amplitude(problem.paths, i) > 0.0:
        low, high = depth_at(nodes, i, 0, hold), depth_at(nodes, i, last, hold)
        stored = potential(high, contact.normal, hold) - potential(low, contact.normal, hold)
        normal_work += contact.stiffness * stored - potential_work - back_work
    sums[EnergySum.TANGENTIAL_FORCE] += tangential_sum
    sums[EnergySum.NORMAL_FORCE] += normal_sum
    sums[EnergySum.WAVE_NORMAL] += normal_work
    sums[EnergySum.WAVE_TANGENTIAL] += tangential_work
    sums[EnergySum.SLIP_LOSS] += slip_loss
    sums[EnergySum.CONTACT_LOSS] += damper_loss
    sums[EnergySum.LEAK] += leak


@formula
def potential(d, normal, hold):
    """Return the potential of the normal force over its stiffness at an approach, or a depth, of a closed contact."""
    if hold is None:
        return load_energy(d, normal) - normal.pull * 0.5 * (d + abs(d))
    else:
        return work(d, hold)


@formula
def closed_spring_work(contact, begin, end, regime, sign, work):
    """Return (work on the spring, -int (dW/dd) d' dt) between two `body.Point`; see the module's text.

    `work` is the integral of Q dx; of a contact that sticks it is all work on the spring and its leak.
    """
    if regime == Regime.STICK:
        change = spring(contact, regime, sign, end)[2] - spring(contact, regime, sign, begin)[2]
        return change, work - change
    normal, size = contact.normal, contact.friction * contact.stiffness * contact.limit_slope
    low, high = begin.approach, end.approach
    stored = load_energy(high, normal) - load_energy(low, normal)
    leak = 2.0 * stored - high * load(high, normal) + low * load(low, normal)
    return size * stored, size * leak


@compiled
def _slip_spring_work(contact, grid, state, nodes, segment, i):
    """Return (work on the spring of a contact that slips, leak of the law) over a segment, for a rated law.

    With the spring's force F and deformation x the work is, by parts,

        int F dx = [F x] - int x dF.                                                                          (1)

    Towards the end of slip x of a sphere is proportional to (remaining time)^(2/3), whose derivative is singular, while
    F is smooth. In terms of g with sigma = 1 - 2 g^3, d sigma = -6 g^2 dg, x is smooth too, and Gauss's rule in g is
    used for the last integral. The planes LEVEL and FRONT, which belong to the hysteretic law, hold F and dF/d sigma
    at the nodes.
    """
    sign, own, n = state.sign[i], nodes.contact, nodes.guard.size
    force, rate = own[ContactRow.LEVEL, i], own[ContactRow.FRONT, i]
    hold = contact.normal.hold
    force[0], x = _spring_force(contact, sign, point_at(nodes, i, 0, hold))
    at_start = force[0] * x
    for j in range(1, n):
        force[j], x = _spring_force(contact, sign, point_at(nodes, i, j, hold))
    work, leak = force[n - 1] * x - at_start, 0.0
    for k in range(n):
        rate[k] = 0.0
        for j in range(n):
            rate[k] += grid.rates[k, j] * force[j]
    for k in range(GAUSS_POINTS.size):
        g = GAUSS_POINTS[k]
        sigma, weight = 1.0 - 2.0 * g**3, 6.0 * g**2 * GAUSS_WEIGHTS[k]
        z = interpolate(sigma, grid.sigma, grid.bary, own[ContactRow.Z, i])
        z_rate = interpolate(sigma, grid.sigma, grid.bary, own[ContactRow.U_Z_RATE, i])
        z_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[SliderRow.NORMAL_VELOCITY])
        x_rate = interpolate(sigma, grid.sigma, grid.bary, own[ContactRow.U_X_RATE, i])
        x_rate -= interpolate(sigma, grid.sigma, grid.bary, nodes.slider[SliderRow.VELOCITY])
        point = Point(z, 0.0, z_rate, x_rate)
        work -= weight * _spring_force(contact, sign, point)[1] * interpolate(sigma, grid.sigma, grid.bary, rate)
        if segment.map == SMOOTH:  # d tau/d sigma of the map
            slope = 0.5
        else:
            slope = 0.5 * (1.0 + sigma if segment.map == ROOT_AT_START else 1.0 - sigma)
        leak -= weight * segment.length * slope * spring(contact, Regime.SLIP, sign, point)[1] * z_rate
    return work, leak


@formula
def _spring_force(contact, sign, point):
    """Return the force of the spring of a contact that slips, at most that of the slip limit, and its deformation."""
    force, x = tangential(contact, Regime.SLIP, sign, point)
    z, law = point[0], contact.law
    limit = contact.stiffness * law.stuck(contact, z, slip_limit(contact, z)) if z > 0.0 else 0.0
    return min(abs(force), limit), x


@compiled
def mark(sums):
    """Record an event, and the phase since the last one if it is the smallest so far.

    SINCE is set to 1e-300, not 0, because 0 means that there has been no event.
    """
    if sums[EnergySum.SINCE] > 1e-200:
        sums[EnergySum.CROWDING] = max(sums[EnergySum.CROWDING], 1.0 / sums[EnergySum.SINCE])
    sums[EnergySum.SINCE] = 1e-300
