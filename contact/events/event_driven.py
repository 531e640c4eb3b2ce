r"""The event-driven motion: segment after segment, each ended by the first root of any guard.

A *guard* is a function that is positive inside a contact's regime (`law.elastic`), and its root is an *event*. A
contact that has just closed has *entered*: its force rises as a fractional power of time, so that the next segment uses
the map ROOT_AT_START of `collocation`; other segments begin with SMOOTH. A segment is *rough* if its highest Chebyshev
coefficients, which estimate the truncation error, exceed the tolerance (`segment.roughness`).

*Cold start.* A segment is first computed to its longest length. If a guard turns negative on it, the root is that of
the interpolant, and the segment is computed again to end there. Newton's method with the true rate then corrects
the length until the guard vanishes to rounding.

*Warm start* (`warm_start`). If the last cycle had the same segment, its length and accelerations are the first guess.
Newton's iteration for the length and Picard's for the motion then go on together.

In both cases the extrema of every guard between the nodes are searched, so that no contact is missed. A segment that is
rough, or on which Picard's iteration does not converge, is computed again with a shorter length. With many contacts, a
segment spans their events (`many_contacts`).
"""

from typing import NamedTuple

import numpy as np

from contact.codes import At, AttemptOutcome, Event, Recorded, Regime, Status, WorkCount
from contact.events import many_contacts
from contact.events import segment as seg
from contact.events.collocation import ROOT_AT_START, SMOOTH
from contact.events.energy import EnergySum, account, mark
from contact.events.segment import Attempt, ContactRow, SliderRow
from contact.events.transitions import cut, earliest, end_guard, is_sharp, transit
from contact.events.warm_start import NEXT, Pattern, blank, matching, recall, store
from contact.jit.compiled import compiled, native, per_thread
from contact.law.hysteretic import is_full, trim, write_curve
from contact.problem import contact_parameters, largest_stiffness

# Lengths of segments. MAX_GROWTH: largest ratio of the next length to the last one; 2 and 10 cost as many iterations to
# 3 %. After an event the longest one is tried, because an event says nothing of how smooth the next regime is: with
# 0.3 times it a cycle of the seed's motor takes a fifth more iterations. EVENT_VALUE, EVENT_STEP: guard and step of
# Newton's method at which a warm start has found its event, both below `law.elastic.FAR_SIDE`. With a quarter of them
# a cycle takes 3 to 6 % more iterations, as the last ones only move by rounding.
MAX_GROWTH = 4.0
MAX_LENGTHS = 12  # that Newton's method tries for one event
EVENT_VALUE, EVENT_STEP = 4e-16, 1e-15
NEWTON_STEPS = 4  # at most, with the accelerations of one of Picard's
TALLY = len(Event) + len(WorkCount)


class Task(NamedTuple):
    """What a run does and records."""

    start: float  # phase at which it starts
    stop: float  # and ends
    number: int  # repetitions; more than one only over a whole cycle
    mobile: int  # 0: the slider keeps its velocity whatever the forces, as a body of infinite mass
    tolerance: float  # largest roughness of a segment (`segment.roughness`)
    limit: int  # largest number of attempts at a segment in one repetition
    at: np.ndarray  # (k,): phases of the samples, rising, in (start, stop]; they do not change the motion
    samples: np.ndarray  # (k, contacts, len(Sample))
    stride: int  # cycles per recorded sample; 0: none
    record: np.ndarray  # (number // stride, len(Recorded))
    close: float = 0.0  # change of the motion that the iteration of a warm start may leave out
    warm: int = 0  # 1: the last call computed in the same work arrays a cycle like these, whose segments are known


class Work(NamedTuple):
    """Work arrays: values at the nodes, segments of the last cycle (`warm_start`), and those of `many_contacts`."""

    nodes: seg.Nodes
    pattern: Pattern
    span: many_contacts.Span | None  # None for few contacts


@per_thread
def work_arrays(contacts: int, nodes: int, many: bool) -> Work:
    """Return the work arrays for so many contacts and nodes of a segment; `many`: with those of `many_contacts`."""
    values = seg.Nodes(np.zeros((len(SliderRow), nodes)), np.zeros((len(ContactRow), contacts, nodes)), np.empty(nodes))
    return Work(values, blank(contacts, nodes), many_contacts.span(contacts, nodes, TALLY) if many else None)


class Progress(NamedTuple):
    """Start of the next segment."""

    phase: float
    length: float  # to try
    entered: bool  # True if a contact has just closed
    match: int  # number of the matching segment of the last cycle, -1 without one
    old: int  # index of the last cycle in `Pattern`
    taken: int  # number of samples taken


@compiled
def _warm_started(problem, grid, state, nodes, task, segment, memory):
    """Compute a segment from recalled accelerations up to its event, if it has one; return its length, 0 if this fails.

    Each iteration is a step of Picard's for the motion, and Newton's method for the length with the motion at its end.
    It ends at rounding, or where the next step would change the motion by less than `task.close`.
    """
    room = min(problem.longest, task.stop - segment.phase)
    gain, event = _largest_gain(problem, segment.length), segment.contact >= 0
    # The front of the hysteretic law at the end is that of the last forces: its length changes once in an iteration.
    steps = NEWTON_STEPS if task.close > 0.0 and memory is None else 1
    seg.integrate(grid, state, nodes, segment)
    if event and steps > 1:
        seg.end_at(problem, grid, state, nodes, segment)
        segment = _at_event(problem, grid, state, nodes, segment, memory, room, steps)
        if segment.length == 0.0:
            return 0.0
        seg.place(grid, state, nodes, segment, 0)
    seg.surface(problem, grid, nodes, segment)
    last = np.inf
    for _ in range(15):
        seg.forces(problem, grid, state, nodes, segment, task.mobile, memory)
        change = 0.0
        if task.mobile:
            change = seg.integrate(grid, state, nodes, segment) / (1.0 + abs(state.slider[At.POSITION]))
        state.tally[WorkCount.SWEEPS] += 1
        if not change < 1e100:
            return 0.0
        seg.end_kinematics(problem, state, nodes)
        before = segment.length
        if event:
            segment = _at_event(problem, grid, state, nodes, segment, memory, room, steps)
            if segment.length == 0.0:
                return 0.0
        moved = segment.length - before
        if (moved == 0.0 and seg.has_converged(change, last)) or max(change, abs(moved)) * gain < task.close:
            root, other, _ = earliest(problem, grid, state, nodes, memory, segment)
            # Accepted only if no guard turns negative before the end (a root at 1 is the event that ends the segment);
            # an earlier event needs a cold start.
            known = other < 0 or (event and root > 1.0 - 1e-6)
            return segment.length if known else 0.0
        last = change
        if moved != 0.0:
            seg.place(grid, state, nodes, segment, 0)
            seg.surface(problem, grid, nodes, segment)
    return 0.0


@compiled
def _largest_gain(problem, length):
    """Return a bound on the change by a step of Picard's iteration over that by the step before; inf if not known.

    A change of position changes the accelerations by the contacts' stiffness, normal or tangential (mu K p'/c in
    stick), and one of velocity by the dampers.
    """
    law = problem.law
    if law.rated or law.bent or problem.contact_damping > 0.0 or problem.limit_slope == 0.0:
        return np.inf  # not known
    stiffness = largest_stiffness(problem) * max(1.0, problem.friction / problem.limit_slope)
    damping = max(problem.normal_damping, problem.tangential_damping)
    return length * (max(1.0, 0.5 * length) * stiffness + damping)


@compiled
def _at_event(problem, grid, state, nodes, segment, memory, room, steps):
    """Return the segment with the length at which its guard vanishes, after so many steps of Newton's method at most.

    The accelerations at its nodes are kept. Its length is 0 if that fails.
    """
    for _ in range(steps):
        end = segment.phase + segment.length
        value, rate = end_guard(problem, state, nodes, segment.contact, segment.guard, end, memory)
        step = -value / rate
        if not rate < 0.0 or abs(step) > 0.2 * segment.length:  # the event is not near that of the last cycle
            return seg.resized(segment, 0.0)
        if abs(value) < EVENT_VALUE or abs(step) < EVENT_STEP:
            break
        segment = seg.resized(segment, segment.length + step)
        if not 0.0 < segment.length < room:
            return seg.resized(segment, 0.0)
        if steps > 1:
            seg.end_at(problem, grid, state, nodes, segment)
    return segment


@compiled
def _cold_started(problem, grid, state, nodes, task, segment, memory):
    """Compute a segment and end it at the first root of a guard on it; return (converged, segment)."""
    entered = segment.map == ROOT_AT_START
    converged, sweeps = seg.iterate_motion(problem, grid, state, nodes, segment, task.mobile, memory)
    state.tally[WorkCount.SWEEPS] += sweeps
    if not converged:
        return False, segment
    root, contact, which = earliest(problem, grid, state, nodes, memory, segment)
    for _ in range(12):
        if contact < 0:
            break
        sharp = is_sharp(which, state.regime[contact])
        segment = cut(segment, root, contact, which, sharp, entered)
        segment = _ended_at_event(problem, grid, state, nodes, task, segment, memory)
        if segment.length == 0.0 or segment.contact < 0:
            break
        # with the better motion another guard may come first
        root, contact, which = earliest(problem, grid, state, nodes, memory, segment)
        if (contact == segment.contact and which == segment.guard) or root > 1.0 - 1e-6:
            break
    return True, segment


@compiled
def _ended_at_event(problem, grid, state, nodes, task, segment, memory):
    """Return the segment, computed, with its length corrected by Newton's method until its guard vanishes at the end.

    A segment without a guard is computed once. Where the guard is still positive after `MAX_LENGTHS`, because its root
    was one of the interpolant or is far off, the segment ends without an event; the next one meets it.
    """
    for trial in range(MAX_LENGTHS):
        if segment.length < 1e-14:
            segment = seg.resized(segment, 0.0)
        _, sweeps = seg.iterate_motion(problem, grid, state, nodes, segment, task.mobile, memory)
        state.tally[WorkCount.SWEEPS] += sweeps
        if segment.contact < 0:
            break
        end = segment.phase + segment.length
        value, rate = end_guard(problem, state, nodes, segment.contact, segment.guard, end, memory)
        length = seg.next_length(segment, value, rate, trial)
        if length == segment.length:
            break
        if trial == MAX_LENGTHS - 1:
            if value > EVENT_VALUE:
                segment = seg.segment_at(segment.phase, segment.length, segment.map, 0)
            break
        segment = seg.resized(segment, length)
    return segment


@compiled
def _roughness(problem, grid, nodes, segment):
    """Return the largest roughness of a contact's forces on the segment."""
    worst = most = 0.0
    for i in range(nodes.contact.shape[1]):
        most = max(most, seg.largest_normal_force(nodes, i))
    for i in range(nodes.contact.shape[1]):
        worst = max(worst, seg.roughness(problem, grid, nodes, segment, i, most))
    return worst


@compiled
def _sampled(grid, state, nodes, task, segment, taken):
    """Take the samples on the segment; return the number taken so far."""
    while taken < task.at.size and task.at[taken] <= segment.phase + segment.length:
        for i in range(state.regime.size):
            seg.sample(grid, state, nodes, segment, i, task.at[taken], task.samples[taken, i])
        taken += 1
    return taken


@compiled
def _move_to_end(problem, state, nodes, memory, length):
    """Set the state to that at the end of a segment; the next one is guessed from the accelerations there."""
    end, slider, own = nodes.guard.size - 1, nodes.slider, nodes.contact
    once, twice = slider[SliderRow.NORMAL_ONCE, end], slider[SliderRow.NORMAL_TWICE, end]
    seg.advance_slider(state, length, once, twice, slider[SliderRow.TANGENTIAL_ONCE, end])
    for i in range(state.regime.size):
        state.deformation[i] = own[ContactRow.X, i, end]
        if memory is not None:
            grows, c = state.regime[i] == Regime.GROW, contact_parameters(problem, i).limit_slope
            if grows:
                write_curve(memory, i, own[ContactRow.Z, i], own[ContactRow.X, i], own[ContactRow.LEVEL, i], c)
            elif state.regime[i] == Regime.ANNULUS:
                trim(memory, i, state.sign[i], own[ContactRow.Z, i, end], own[ContactRow.X, i, end], c)
            memory.growing[i] = int(grows)
    _begin_with(nodes, slider[SliderRow.NORMAL_ACCELERATION, end], slider[SliderRow.TANGENTIAL_ACCELERATION, end])


@compiled
def _begin_with(nodes, normal, tangential):
    """Set the accelerations from which the next segment is guessed."""
    nodes.slider[SliderRow.NORMAL_ACCELERATION, 0] = normal
    nodes.slider[SliderRow.TANGENTIAL_ACCELERATION, 0] = tangential


@compiled
def _from_last_cycle(problem, grid, state, work, task, memory, progress):
    """Return the last cycle's segment computed to the same end or event; its length is 0 if that fails."""
    pattern, old, m = work.pattern, progress.old, progress.match
    nothing = seg.segment_at(progress.phase, 0.0, SMOOTH, 0)
    if m < 0:
        return nothing
    map_, contact, end = pattern.map[old, m], pattern.contact[old, m], pattern.end[old, m] + pattern.end_change[old, m]
    last = contact < 0 and end >= task.stop - 1e-12
    length = (task.stop if last else end) - progress.phase
    if contact < 0 and not last:
        length = min(length, problem.longest)
    fits = 0.0 < length <= problem.longest and progress.phase + length <= task.stop
    if not fits or (map_ == ROOT_AT_START) != progress.entered:
        return nothing
    segment = seg.Segment(progress.phase, length, length, map_, contact, pattern.guard[old, m], int(last))
    recall(pattern, old, m, work.nodes)
    length = _warm_started(problem, grid, state, work.nodes, task, segment, memory)
    return seg.Segment(segment.phase, length, length, map_, contact, segment.guard, segment.last)


@compiled
def _attempt(problem, grid, state, work, task, memory, progress):
    """Compute the next segment; return an `Attempt`."""
    nodes, longest = work.nodes, problem.longest
    normal = nodes.slider[SliderRow.NORMAL_ACCELERATION, 0]
    tangential = nodes.slider[SliderRow.TANGENTIAL_ACCELERATION, 0]
    segment = _from_last_cycle(problem, grid, state, work, task, memory, progress)
    if segment.length == 0.0:
        _begin_with(nodes, normal, tangential)
        map_ = ROOT_AT_START if progress.entered else SMOOTH
        segment = seg.next_segment(progress.phase, progress.length, task.stop, map_)
        converged, segment = _cold_started(problem, grid, state, nodes, task, segment, memory)
        if not converged:
            return Attempt(AttemptOutcome.NOT_CONVERGED, segment, 0.25 * segment.length, Status.STIFF)
    if segment.length == 0.0:
        # A guard vanishes at the start: nothing moves, and `advance` changes the regime. If it does not change, the
        # root was one of the interpolant alone, on a segment too long for it: the next one is shorter.
        return Attempt(AttemptOutcome.EVENT_AT_START, segment, 0.25 * segment.longest, Status.DONE)
    rough, change = _roughness(problem, grid, nodes, segment), 1.0
    if progress.match < 0 or rough > task.tolerance:
        order = nodes.guard.size - 1  # the roughness is about proportional to this power of the length
        change = min(MAX_GROWTH, max(0.2, 0.9 * (task.tolerance / (rough + 1e-300)) ** (1.0 / order)))
    if rough > task.tolerance and segment.length > 1e-6 * longest:
        _begin_with(nodes, normal, tangential)
        return Attempt(AttemptOutcome.TOO_ROUGH, segment, segment.length * min(change, 0.7), Status.DONE)
    least = longest if segment.contact >= 0 else 0.3 * segment.longest
    return Attempt(AttemptOutcome.ACCEPTED, segment, max(segment.length * change, least), Status.DONE)


@compiled
def _next(problem, grid, state, work, task, memory, span, progress):
    """Compute the next segment, with many contacts one that spans their events; return an `Attempt`."""
    if span is None:
        return _attempt(problem, grid, state, work, task, memory, progress)
    else:  # with an `else` numba compiles the branch that is taken, and nothing of the other
        return many_contacts.attempt(problem, grid, state, work, task, memory, progress)


@compiled
def _accept(problem, grid, state, work, task, memory, span, progress, segment):
    """Add a segment's integrals, take its samples, store it for the next cycle, and move the state to its end.

    Return (phase there, number of samples taken so far).
    """
    phase = task.stop if segment.last else progress.phase + segment.length
    if span is None:
        account(problem, grid, state, work.nodes, segment)
        taken = _sampled(grid, state, work.nodes, task, segment, progress.taken)
        store(work.pattern, 1 - progress.old, progress.match, segment, phase, state, work.nodes)
        _move_to_end(problem, state, work.nodes, memory, segment.length)
    else:
        taken = many_contacts.accept(problem, grid, state, work, task, segment, progress.taken)
    return phase, taken


@compiled
def advance(problem, grid, state, work, task, memory, span, new):
    """Move the state from the start to the stop of the task; return the reason for ending.

    `work.pattern` stores the segments of two cycles: those of this one are written to the index `new`, those of the
    last one are read from the other index.
    """
    contacts, nodes, tally = state.regime.size, work.nodes, state.tally
    phase, length, taken = task.start, problem.longest, 0
    spent = 0  # attempts at a segment
    idle = 0  # events since the last segment, all at one phase
    first = 0  # segment of the last cycle at which the search for a match begins
    warm = True  # False after a rough segment: the next attempt is a cold start
    entered = False  # True if a contact has closed at this phase
    work.pattern.stored[new] = 0
    while phase < task.stop:
        spent += 1
        if spent > task.limit:
            return Status.TOO_MANY
        if memory is not None:
            if is_full(memory):
                return Status.FULL
        if not np.isfinite(state.slider[At.POSITION] + state.slider[At.NORMAL_VELOCITY] + state.slider[At.VELOCITY]):
            return Status.NOT_FINITE
        match = matching(work.pattern, 1 - new, first, phase, state) if warm else -1
        first = max(first, match + 1)
        progress = Progress(phase, min(length, problem.longest), entered, match, 1 - new, taken)
        tried = _next(problem, grid, state, work, task, memory, span, progress)
        segment, length = tried.segment, tried.length
        if tried.outcome == AttemptOutcome.NOT_CONVERGED or tried.outcome == AttemptOutcome.TOO_ROUGH:
            tally[WorkCount.HALVINGS] += 1
            if tried.outcome == AttemptOutcome.NOT_CONVERGED and length < 1e-9 * problem.longest:
                return tried.status
            warm = warm and tried.outcome == AttemptOutcome.NOT_CONVERGED
            continue
        if tried.outcome == AttemptOutcome.ACCEPTED:
            tally[WorkCount.SEGMENTS] += 1
            phase, taken = _accept(problem, grid, state, work, task, memory, span, progress, segment)
            idle, entered, warm = 0, False, True
        else:
            idle += 1
            tally[WorkCount.CHATTER] += idle > contacts  # more than one event per contact at one instant
            if idle > 20 * contacts + 20:  # they follow one another without end
                return Status.TOO_MANY
        if segment.contact >= 0:
            made = transit(problem, state, nodes, segment, phase, memory)
            mark(state.sums)
            entered = entered or made
    return Status.DONE


@native(
    "t t t t t t t",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.paths.tangential_cos": "n",
        "problem.factors.stiffness": "n", "problem.factors.limit_slope": "n",
        "grid.sigma": "m", "grid.bary": "m", "grid.tau": "3 m", "grid.integrals": "3 2 m m", "grid.rates": "m m",
        "grid.tail": "2 m", "state.slider": "3", "state.lost": "3", "state.deformation": "n", "state.sign": "n",
        "state.regime": "n", "state.tally": "12", "state.sums": "15",
        "work.nodes.slider": "10 m", "work.nodes.contact": "11 n m", "work.nodes.guard": "m",
        "work.pattern.regime": "2 c n", "work.pattern.acceleration": "2 c 2 m",
        "work.pattern.acceleration_change": "2 c 2 m",
        "task.at": "s", "task.samples": "s n 6", "task.record": "r 3", "memory.number": "n", "memory.kind": "n p",
        "memory.corner": "n p 4", "memory.curve": "n p 5 m", "memory.arc": "n p",
        "memory.growing": "n", "memory.level": "n",
    },
)  # fmt: skip
def travel(problem, grid, state, work, task, memory, span):
    """Move the state from one phase to another, or again and again over the same cycle; return the reason for ending.

    `memory` is None for a law without one, and then nothing of the hysteretic law is compiled. `span` is that of the
    work arrays: a kernel for few contacts does not compile `many_contacts`, one for many nothing else.
    """
    work.nodes.slider[:], work.nodes.contact[:] = 0.0, 0.0
    stored = work.pattern.stored
    if task.warm == 0:
        stored[:] = 0
    for k in range(task.number):
        before = state.sums[EnergySum.DISPLACEMENT]
        _begin_with(work.nodes, 0.0, 0.0)
        why = advance(problem, grid, state, work, task, memory, span, stored[NEXT])
        if why != Status.DONE:
            return why
        state.tally[WorkCount.CYCLES] += 1
        stored[NEXT] = 1 - stored[NEXT]
        if task.stride > 0 and (k + 1) % task.stride == 0:
            recorded = task.record[(k + 1) // task.stride - 1]
            recorded[Recorded.VELOCITY] = state.slider[At.VELOCITY]
            recorded[Recorded.POSITION] = state.slider[At.POSITION]
            recorded[Recorded.MEAN_VELOCITY] = (state.sums[EnergySum.DISPLACEMENT] - before) / (2.0 * np.pi)
    return Status.DONE
