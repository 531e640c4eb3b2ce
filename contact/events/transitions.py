r"""What happens at separation, touch, slip and stick: the guard that ends a segment, and the regime that follows."""

import numpy as np

from contact.body import Coordinates, Point, approach, approach_rate, at_phase, travel
from contact.codes import LAST_GUARD, At, Event, Guard, Regime
from contact.events.collocation import ROOT_AT_END, ROOT_AT_START
from contact.events.energy import EnergySum
from contact.events.segment import (
    COMPILED_CONTACTS,
    SHAPES,
    ContactRow,
    Segment,
    SliderRow,
    finite_at_end,
    gap_guard,
    guards,
    height_rate,
    point_at,
)
from contact.jit.compiled import compiled, native
from contact.law.elastic import regime_at, spring
from contact.law.holding import depth, depth_rate, depth_second, is_open, stored
from contact.law.hysteretic import on_curve
from contact.problem import contact_parameters
from contact.roots import first_root


def open_regimes(problem, phase, state):
    """Set regime and sign of every contact, and its deformation within the slip limit, from the state at a phase."""
    (_open_compiled if state.regime.size >= COMPILED_CONTACTS else _open)(problem, phase, state)


def _open(problem, phase, state):
    q = Coordinates(state.slider[At.POSITION], 0.0)
    rate = Coordinates(state.slider[At.NORMAL_VELOCITY], state.slider[At.VELOCITY])
    for i in range(state.regime.size):
        u_z, u_z_rate, _, u_x_rate = at_phase(problem.paths, i, np.cos(phase), np.sin(phase))
        z, hold = approach(problem.paths, i, u_z, q), problem.normal.hold
        if is_open(z, state.regime[i] == Regime.SEPARATED, hold):
            state.regime[i], state.sign[i], state.deformation[i] = Regime.SEPARATED, 1.0, 0.0
            continue
        d = depth(z, hold)
        z_rate = approach_rate(u_z_rate, rate) * depth_rate(d, hold)
        point = Point(d, state.deformation[i], z_rate, travel(u_x_rate, rate))
        state.regime[i], state.sign[i], state.deformation[i] = regime_at(contact_parameters(problem, i), point)
    return 0


_open_compiled = native("t f t", SHAPES)(_open)


@compiled
def earliest(problem, grid, state, nodes, memory, segment):
    """Return (sigma, contact, guard) of the earliest root on the segment; sigma = 2 if there is none.

    The guard that ends the segment at a root of the force begins there as (1 - s)^2, s as in `collocation`, and its
    interpolant may cross zero just before: it is searched up to the last node but one.
    """
    first, contact, which = 2.0, -1, -1
    for i in range(state.regime.size):
        regime = state.regime[i]
        for k in range(Guard.ANNULUS_EDGE + 1):
            if (k > 0 and regime == Regime.SEPARATED) or k > LAST_GUARD[regime]:
                continue
            if k == Guard.ANNULUS_EDGE and first < 1.0 - 1e-6 and memory is not None:
                if on_curve(memory, i):
                    continue  # the front is smooth only up to the first of the other events
            guards(problem, state, nodes, i, k, memory)
            own = i == segment.contact and k == segment.guard and segment.map == ROOT_AT_END
            root = first_root(grid.sigma, grid.bary, grid.rates, nodes.guard, grid.sigma.size - int(own))
            if root < first:
                first, contact, which = root, i, k
            if problem.normal.hold is not None and k == Guard.GAP and root < 1.0 - 1e-6:
                break  # the depth of a contact that holds on has a kink where it opens: no other guard is smooth there
    return first, contact, which


@compiled
def is_sharp(which, regime):
    """Return True if the force has a square root where this guard vanishes."""
    if which == Guard.GAP:
        return regime != Regime.SEPARATED
    stick_ends = which == Guard.STICK_LIMIT and regime == Regime.STICK
    return stick_ends or (which == Guard.ANNULUS_PIECE and regime == Regime.ANNULUS)


@compiled
def cut(segment, root, contact, which, sharp, entered):
    """Return the segment cut at a root in sigma; with roots of the force at both ends it is cut in the middle."""
    s = 0.5 * (min(root, 1.0) + 1.0)
    if segment.map == ROOT_AT_START:
        s = s * s
    elif segment.map == ROOT_AT_END:
        s = 1.0 - (1.0 - s) ** 2
    length, map_ = segment.length * s, segment.map
    if sharp and entered and length > 1e-9:
        length, contact = 0.5 * length, -1
    elif sharp:
        map_ = ROOT_AT_END
    return Segment(segment.phase, length, segment.longest, map_, contact, which, 0)


@compiled
def end_guard(problem, state, nodes, i, which, phase, memory):
    """Return a guard at the end of the segment, which is at this phase, and its rate there."""
    n, regime, sign, contact = nodes.guard.size - 1, state.regime[i], state.sign[i], contact_parameters(problem, i)
    hold = contact.normal.hold
    if which == Guard.GAP:
        rate = height_rate(nodes, i, n)
        return gap_guard(regime, nodes.contact[ContactRow.Z, i, n], hold), -rate if regime == Regime.SEPARATED else rate
    point = point_at(nodes, i, n, hold)
    u_z, _, u_x, _ = at_phase(problem.paths, i, np.cos(phase), np.sin(phase))
    acceleration = Coordinates(
        nodes.slider[SliderRow.NORMAL_ACCELERATION, n], nodes.slider[SliderRow.TANGENTIAL_ACCELERATION, n]
    )
    z_second = depth_second(point.approach, height_rate(nodes, i, n), approach_rate(-u_z, acceleration), hold)
    second = z_second, travel(-u_x, acceleration)
    value = contact.law.guard(contact, memory, i, regime, which, sign, point, nodes.contact[ContactRow.FRONT, i, n])
    rate = contact.law.guard_rate(contact, memory, i, regime, which, sign, point, second)
    return finite_at_end(value, regime, point, hold), finite_at_end(rate, regime, point, hold)


@compiled
def transit(problem, state, nodes, segment, phase, memory):
    """Take the contact whose guard ends the segment, and all whose guards vanish then, to their next regimes.

    Returns True if a contact was made.
    """
    made = False
    _, rate = end_guard(problem, state, nodes, segment.contact, segment.guard, phase, memory)
    if not rate < 0.0:
        state.tally[Event.GRAZE] += 1
    for i in range(state.regime.size):
        for k in range(Guard.ANNULUS_EDGE + 1):
            met = i == segment.contact and k == segment.guard
            if i != segment.contact and (state.regime[i] != Regime.SEPARATED or k == Guard.GAP):
                value, rate = end_guard(problem, state, nodes, i, k, phase, memory)
                met = abs(value) < 4e-16 and rate < 0.0
            if met:
                kind = enter_next(problem, state, nodes, i, k, memory)
                state.tally[kind] += 1
                made = made or kind == Event.CONTACT
                break
    return made


@compiled
def enter_next(problem, state, nodes, i, which, memory):
    """Take a contact to the far side of a guard; return the kind of event."""
    regime, sign, n = state.regime[i], state.sign[i], nodes.guard.size - 1
    contact = contact_parameters(problem, i)
    law, hold = contact.law, contact.normal.hold
    end = point_at(nodes, i, n, hold)
    point = Point(end.approach, state.deformation[i], end.approach_rate, end.deformation_rate)
    if which == Guard.GAP and regime != Regime.SEPARATED:
        lose_hold(contact, state, regime, sign, point, hold)
    before = spring(contact, regime, sign, point)[2] if law.rated else 0.0
    state.regime[i], state.sign[i], state.deformation[i], kind = law.follow(
        contact, memory, i, regime, which, sign, point
    )
    if law.rated:  # where slip begins the force falls at once, and the spring's energy with it
        point = Point(end.approach, state.deformation[i], end.approach_rate, end.deformation_rate)
        state.sums[EnergySum.SLIP_LOSS] += before - spring(contact, state.regime[i], state.sign[i], point)[2]
    return kind


@compiled
def lose_hold(contact, state, regime, sign, point, hold):
    """Add what a contact that opens has stored to the loss by adhesion: its spring's energy and that of its hold."""
    if hold is not None:
        energy = contact.stiffness * stored(point.approach, hold) + spring(contact, regime, sign, point)[2]
        state.sums[EnergySum.ADHESION_LOSS] += energy
