r"""The event-driven motion of many contacts: a segment spans the events of all, each contact has its own within it.

If a segment ended at every event of any contact, n contacts would cost O(n^2): n times as many segments, each with n
contacts. Here a segment is as long as the wave and the contact's resonance allow, and the slider's accelerations on it
are polynomials. With these fixed, each contact is followed by itself from event to event (`_followed`, with the guards,
transitions, maps and integrals of the other solver). Its forces are projected piece by piece,

    alpha_k = (2k + 1)/2 sum_i int F_i L_k d sigma,   k < nodes,   L_k Legendre's polynomials on the segment,

with the quadrature of the pieces, none of which contains a kink. Picard's iteration repeats this with the new motion.
Position and velocity at the segment's end are exact, because they depend on alpha_0 and alpha_1 alone. Between its ends
the position lacks the part of the forces that is orthogonal to all L_k. This part is about (L/2)^2/k^2 of the last
alpha_k, and the tolerance bounds it. The cost is O(n) for each segment, and O(n log n) for the order of the events,
which is needed for their smallest gap.
"""

from typing import NamedTuple

import numpy as np

from contact.body import Coordinates, damping_force
from contact.codes import LAST_GUARD, At, AttemptOutcome, Event, Regime, Status, WorkCount
from contact.events import segment as seg
from contact.events.collocation import ROOT_AT_START, SMOOTH
from contact.events.energy import EnergySum, account_contact, account_slider, mark
from contact.events.segment import Attempt, ContactRow, SliderRow
from contact.events.transitions import cut, end_guard, enter_next, is_sharp
from contact.jit.compiled import compiled
from contact.law.hysteretic import Memory
from contact.roots import first_root

# Smallest number of contacts for this solver. Its CPU time over that of the other one (`event_driven`), in the mean of
# steady states and bursts of balls, rough balls and punches: 1.8 of 8 contacts, 1.4 of 12, 1.2 of 16, 1.1 of 24, 1.0 of
# 32, 0.8 of 48; of steady balls of one height 0.8 of 12 to 16 (`tests/benchmarks/many_contacts.py`).
MANY = 16
# Largest number of pieces of a contact on one segment, and of successive pieces without length
MAX_PIECES, MAX_IDLE = 200, 20
# Number of indices `SliderRow` that have a series in `Span.series`: position, travel, velocities, accelerations
MOTION = 6


class Span(NamedTuple):
    """Work arrays of a segment that spans events; N is the number of nodes of a piece and of Legendre moments."""

    legendre: np.ndarray  # (N + 2, N): Legendre's polynomials at the nodes of a piece
    # (MOTION, N + 2): coefficients of the slider's motion, travel from the segment's start
    series: np.ndarray
    moments: np.ndarray  # (2, N): sum of int F L_k d sigma, of the normal and the tangential forces
    start: np.ndarray  # (1,): travel where the piece begins
    # the state at the segment's start
    regime: np.ndarray
    sign: np.ndarray
    deformation: np.ndarray
    sums: np.ndarray
    tally: np.ndarray
    phases: np.ndarray  # (events,): of the events on the segment
    stored: np.ndarray  # (1,) int: how many of them


def span(contacts: int, nodes: int, tally: int) -> Span:
    """Return work arrays."""
    return Span(
        np.zeros((nodes + 2, nodes)), np.zeros((MOTION, nodes + 2)), np.zeros((2, nodes)), np.zeros(1),
        np.zeros(contacts, np.int64), np.zeros(contacts), np.zeros(contacts), np.zeros(len(EnergySum)),
        np.zeros(tally, np.int64), np.zeros(16 * contacts), np.zeros(1, np.int64),
    )  # fmt: skip


class Following(NamedTuple):
    """How the contacts are followed over a segment."""

    recorded: bool  # True if energies, events and samples are recorded
    taken: int  # samples that lie before the segment
    memory: Memory | None


@compiled
def attempt(problem, grid, state, work, task, memory, progress):
    """Compute the next segment; return an `Attempt`. If it is accepted, the contacts are at its end.

    `work`, `task`, `progress`: a `Work`, `Task` and `Progress` of `event_driven`.
    """
    span = work.span
    outer = seg.next_segment(progress.phase, progress.length, task.stop, SMOOTH)
    _remember(state, span)
    why, rough, recorded = _iterated(problem, grid, state, work, task, outer, memory, progress.taken)
    too_rough = rough > task.tolerance and outer.length > 1e-6 * problem.longest
    if why != Status.DONE or too_rough:
        _recall(state, span)
        outcome = AttemptOutcome.NOT_CONVERGED if why != Status.DONE else AttemptOutcome.TOO_ROUGH
        return Attempt(outcome, outer, 0.5 * outer.length, why)
    if not recorded:
        _recall(state, span)
        why = _all_followed(problem, grid, state, work, task, outer, Following(True, progress.taken, memory))
        if why != Status.DONE:
            return Attempt(AttemptOutcome.NOT_CONVERGED, outer, 0.0, why)
    grow = 2.0 if rough == 0.0 else min(2.0, 0.9 * (task.tolerance / rough) ** 0.2)
    return Attempt(AttemptOutcome.ACCEPTED, outer, min(problem.longest, outer.length * max(grow, 1.0)), why)


@compiled
def accept(problem, grid, state, work, task, outer, taken):
    """Move the slider to the end of a segment and add its integrals; return the number of samples taken so far."""
    _account_slider(problem, grid, state, work, outer)
    while taken < task.at.size and task.at[taken] <= outer.phase + outer.length:
        taken += 1
    return taken


@compiled
def _remember(state, span):
    """Store what a trial of the segment changes."""
    for i in range(state.regime.size):
        span.regime[i], span.sign[i] = state.regime[i], state.sign[i]
        span.deformation[i] = state.deformation[i]
    for k in range(state.sums.size):
        span.sums[k] = state.sums[k]
    for k in range(state.tally.size):
        span.tally[k] = state.tally[k]


@compiled
def _recall(state, span):
    """Set the contacts, the sums and the tally back to the start of the segment, but not the work of this trial."""
    for i in range(state.regime.size):
        state.regime[i], state.sign[i] = span.regime[i], span.sign[i]
        state.deformation[i] = span.deformation[i]
    for k in range(state.sums.size):
        state.sums[k] = span.sums[k]
    for k in range(state.tally.size):
        if k != WorkCount.SWEEPS and k != WorkCount.HALVINGS:
            state.tally[k] = span.tally[k]


@compiled
def _iterated(problem, grid, state, work, task, outer, memory, taken):
    """Iterate to the slider's motion on a segment; return (reason for ending, roughness, whether it was recorded).

    The roughness is that of the slider's accelerations. Events, energies and samples are recorded from the second sweep
    on, which is the last one of most segments: it follows the contacts on a motion that the last update changes by less
    than rounding.
    """
    span, last = work.span, np.inf
    n = grid.sigma.size
    _guess(problem, state, span, outer, task.mobile)
    for sweep in range(seg.MAX_SWEEPS):
        recorded = sweep > 0 or not task.mobile
        _recall(state, span)
        why = _all_followed(problem, grid, state, work, task, outer, Following(recorded, taken, memory))
        state.tally[WorkCount.SWEEPS] += 1
        if why != Status.DONE:
            return why, 0.0, False
        if not task.mobile:
            return Status.DONE, 0.0, True
        change = _updated(problem, state, span, outer, n) / (1.0 + abs(state.slider[At.POSITION]))
        if not change < 1e100:
            break
        if seg.has_converged(change, last):
            normal, along = 0.0, 0.0
            for k in range(n - 2, n):
                normal = max(normal, abs(span.series[SliderRow.NORMAL_ACCELERATION, k]))
                along = max(along, abs(span.series[SliderRow.TANGENTIAL_ACCELERATION, k]))
            # Error of the position between the ends, (L/2)^2/n^2 of the last coefficients; it changes sign about n
            # times, so its integral over the segment is smaller by another L/n.
            return Status.DONE, max(normal, along) * outer.length**3 / (4.0 * n**3), recorded
        last = change
    return Status.STIFF, 0.0, False


@compiled
def _guess(problem, state, span, outer, mobile):
    """Set the motion of constant accelerations: those at the end of the last segment."""
    series, half = span.series, 0.5 * outer.length
    for axis in range(2):
        index = SliderRow.NORMAL_ACCELERATION + axis
        end = 0.0
        for k in range(series.shape[1]):
            end += series[index, k]
            series[index, k] = 0.0
        series[index, 0] = end if mobile else 0.0
    _integrate(state, series, half, span.legendre.shape[1])


@compiled
def _updated(problem, state, span, outer, n):
    """Set the accelerations that the moments give, and the motion; return the largest change."""
    series = span.series
    for k in range(n):
        weight = 0.5 * (2 * k + 1)
        force = damping_force(problem, Coordinates(series[SliderRow.NORMAL_VELOCITY, k], series[SliderRow.VELOCITY, k]))
        normal, along = weight * span.moments[0, k] + force.normal, weight * span.moments[1, k] + force.along
        series[SliderRow.NORMAL_ACCELERATION, k] = normal - (problem.preload if k == 0 else 0.0)
        series[SliderRow.TANGENTIAL_ACCELERATION, k] = along - (problem.load if k == 0 else 0.0)
    return _integrate(state, series, 0.5 * outer.length, n)


@compiled
def _integrate(state, series, half, n):
    """Set velocities and positions from the accelerations' series; return the largest change of one, in sum."""
    change = 0.0
    for axis in range(2):
        acceleration = series[SliderRow.NORMAL_ACCELERATION + axis]
        normal_velocity, height = (series[SliderRow.NORMAL_VELOCITY], series[SliderRow.POSITION]) if axis == 0 else (
            series[SliderRow.VELOCITY], series[SliderRow.TRAVEL])  # fmt: skip
        velocity = state.slider[At.NORMAL_VELOCITY] if axis == 0 else state.slider[At.VELOCITY]
        begin = state.slider[At.POSITION] if axis == 0 else 0.0
        change = max(change, _primitive(acceleration, normal_velocity, velocity, half, n))
        change = max(change, _primitive(normal_velocity, height, begin, half, n + 1))
    return change


@compiled
def _primitive(series, out, begin, half, n):
    """Fill the series of the integral of one with n terms, `begin` at sigma = -1; return its change, in sum."""
    change = 0.0
    for k in range(out.size):
        # int L_k = (L_(k+1) - L_(k-1))/(2k + 1), int L_0 = L_1 + L_0
        value = 0.0
        if 0 < k <= n:
            value += series[k - 1] / (2 * k - 1)
        if k + 1 < n:
            value -= series[k + 1] / (2 * k + 3)
        if k == 0:
            value += series[0]
        value = half * value + (begin if k == 0 else 0.0)
        change += abs(value - out[k])
        out[k] = value
    return change


@compiled
def _all_followed(problem, grid, state, work, task, outer, following):
    """Follow every contact over the segment and fill the moments of the forces; return the reason for ending."""
    span = work.span
    span.moments[:] = 0.0
    span.stored[0] = 0
    for i in range(state.regime.size):
        why = _followed(problem, grid, state, work, task, outer, i, following)
        if why != Status.DONE:
            return why
    return Status.DONE


@compiled
def _followed(problem, grid, state, work, task, outer, i, following):
    """Follow one contact from event to event over the segment; return the reason for ending.

    Each pass of the loop computes one piece: up to the earliest event on it, to the end of the segment, or shorter if
    its forces are too rough for the nodes (then it is repeated with half the length). The moments of its forces are
    added, and the contact enters its next regime. `entered`: the contact has just closed, so that its force has a root
    at the start of the piece.
    """
    nodes, stop, memory = work.nodes, outer.phase + outer.length, following.memory
    phase, length, entered, idle = outer.phase, outer.length, False, 0
    for _ in range(MAX_PIECES):
        piece = seg.segment_at(phase, min(length, stop - phase), ROOT_AT_START if entered else SMOOTH, 0)
        _fill_piece(problem, grid, state, work, outer, piece, i, memory)
        root, which = _first_event(problem, grid, state, nodes, i, memory)
        if which >= 0:
            sharp = is_sharp(which, state.regime[i])
            piece = cut(piece, root, i, which, sharp, entered)
            if piece.contact >= 0:
                piece = _ended_at_event(problem, grid, state, work, outer, piece, i, memory)
            if piece.length > 0.0:
                _fill_piece(problem, grid, state, work, outer, piece, i, memory)
        if piece.length > 0.0:
            rough = seg.roughness(problem, grid, nodes, piece, i, seg.largest_normal_force(nodes, i))
            if rough > task.tolerance and piece.length > 1e-6 * problem.longest:
                length = 0.5 * piece.length
                continue
            _project(grid, work.span, nodes, problem, piece, outer, i)
            if following.recorded:
                account_contact(problem, grid, state, nodes, piece, i)
                _sampled(grid, state, nodes, task, piece, i, following.taken, outer.phase)
            state.deformation[i] = nodes.contact[ContactRow.X, i, nodes.guard.size - 1]
            phase, idle, entered = phase + piece.length, 0, False
        else:
            idle += 1
            if idle > MAX_IDLE:
                return Status.TOO_MANY
        if piece.contact >= 0:
            _, rate = end_guard(problem, state, nodes, i, piece.guard, phase, memory)
            if not rate < 0.0:
                state.tally[Event.GRAZE] += 1
            kind = enter_next(problem, state, nodes, i, piece.guard, memory)
            state.tally[kind] += 1
            entered = entered or kind == Event.CONTACT
            if following.recorded and work.span.stored[0] < work.span.phases.size:
                work.span.phases[work.span.stored[0]] = phase
                work.span.stored[0] += 1
        if phase >= stop - 1e-15:
            return Status.DONE
        length = stop - phase
    return Status.TOO_MANY


@compiled
def _fill_piece(problem, grid, state, work, outer, piece, i, memory):
    """Fill the motion and the forces of a contact at the nodes of a piece."""
    _move(grid, work, outer, piece, 0)
    seg.surface_of(problem, grid, work.nodes, piece, i, np.cos(piece.phase), np.sin(piece.phase), 0)
    seg.contact_forces(problem, grid, state, work.nodes, i, memory)
    seg.contact_end(problem, state, work.nodes, i)


@compiled
def _move(grid, work, outer, piece, first):
    """Fill the slider's motion at the nodes of a piece from node `first` on, the travel from the piece's start.

    The series of the segment are evaluated with Legendre's polynomials by their recurrence,
    (k + 1) L_(k+1) = (2k + 1) sigma L_k - k L_(k-1).
    """
    span, slider, n = work.span, work.nodes.slider, grid.sigma.size
    legendre, series = span.legendre, span.series
    at = 2.0 * (piece.phase - outer.phase) / outer.length - 1.0
    for j in range(first, n):
        legendre[0, j] = 1.0
        legendre[1, j] = at + 2.0 * piece.length / outer.length * grid.tau[piece.map, j]
    for k in range(1, n + 1):
        a, b = (2 * k + 1) / (k + 1), k / (k + 1)
        for j in range(first, n):
            legendre[k + 1, j] = a * legendre[1, j] * legendre[k, j] - b * legendre[k - 1, j]
    for r in range(MOTION):
        for j in range(first, n):
            slider[r, j] = series[r, 0]
        for k in range(1, n + 2):
            c = series[r, k]
            for j in range(first, n):
                slider[r, j] += c * legendre[k, j]
    if first == 0:
        span.start[0] = slider[SliderRow.TRAVEL, 0]
    for j in range(first, n):
        slider[SliderRow.TRAVEL, j] -= span.start[0]


@compiled
def _first_event(problem, grid, state, nodes, i, memory):
    """Return (sigma, guard) of the earliest root of a contact's guards on the piece; (2, -1) if there is none."""
    regime, first, which = state.regime[i], 2.0, -1
    for k in range(1 if regime == Regime.SEPARATED else LAST_GUARD[regime] + 1):
        seg.guards(problem, state, nodes, i, k, memory)
        root = first_root(grid.sigma, grid.bary, grid.rates, nodes.guard, grid.sigma.size)
        if root < first:
            first, which = root, k
    return first, which


@compiled
def _ended_at_event(problem, grid, state, work, outer, piece, i, memory):
    """Return the piece ended where its guard vanishes, by Newton's method with the motion at its end alone."""
    n, nodes = grid.sigma.size - 1, work.nodes
    c0, s0 = np.cos(piece.phase), np.sin(piece.phase)
    for trial in range(12):
        if piece.length < 1e-14:
            piece = seg.resized(piece, 0.0)
        _move(grid, work, outer, piece, n)
        seg.surface_of(problem, grid, nodes, piece, i, c0, s0, n)
        seg.contact_end(problem, state, nodes, i)
        value, rate = end_guard(problem, state, nodes, i, piece.guard, piece.phase + piece.length, memory)
        length = seg.next_length(piece, value, rate, trial)
        if length == piece.length:
            break
        piece = seg.resized(piece, length)
    return piece


@compiled
def _project(grid, span, nodes, problem, piece, outer, i):
    """Add the moments of a contact's forces on a piece; `Span.legendre` holds the polynomials at its nodes."""
    own, n = nodes.contact, nodes.guard.size
    scale = 2.0 * piece.length / outer.length
    for j in range(n):
        weight = scale * grid.integrals[piece.map, 0, j, n - 1]
        normal = weight * seg.normal_force(problem, nodes, i, j)
        along = weight * own[ContactRow.Q, i, j]
        for k in range(n):
            span.moments[0, k] += normal * span.legendre[k, j]
            span.moments[1, k] += along * span.legendre[k, j]


@compiled
def _account_slider(problem, grid, state, work, outer):
    """Add the slider's own integrals, move it to the end, and note the events in their order."""
    nodes, span = work.nodes, work.span
    _move(grid, work, outer, outer, 0)
    account_slider(problem, grid, state, nodes, outer)
    # over tau int L_0 is 1, that of the others 0; the double integrals are 1/2 of L_0, -1/6 of L_1
    normal, along = (span.series[SliderRow.NORMAL_ACCELERATION], span.series[SliderRow.TANGENTIAL_ACCELERATION])
    seg.advance_slider(state, outer.length, normal[0], 0.5 * normal[0] - normal[1] / 6.0, along[0])
    _sort(span.phases, span.stored[0])
    before = outer.phase
    for k in range(span.stored[0]):
        if state.sums[EnergySum.SINCE] > 0.0:
            state.sums[EnergySum.SINCE] += span.phases[k] - before
        mark(state.sums)
        before = span.phases[k]
    if state.sums[EnergySum.SINCE] > 0.0:
        state.sums[EnergySum.SINCE] += outer.phase + outer.length - before


@compiled
def _sort(values, count):
    """Sort the first values (Shell's method)."""
    gap = count // 2
    while gap > 0:
        for k in range(gap, count):
            value, m = values[k], k
            while m >= gap and values[m - gap] > value:
                values[m] = values[m - gap]
                m -= gap
            values[m] = value
        gap //= 2


@compiled
def _sampled(grid, state, nodes, task, piece, i, taken, begin):
    """Interpolate the samples of a contact on a piece; `taken` lie before the segment, which starts at `begin`."""
    for number in range(taken, task.at.size):
        at = task.at[number]
        if at > piece.phase + piece.length:
            break
        if at <= piece.phase and piece.phase > begin:  # of the piece before
            continue
        seg.sample(grid, state, nodes, piece, i, at, task.samples[number, i])
