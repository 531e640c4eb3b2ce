r"""Warm start of the event-driven motion from the events of the last period of the waves.

A motion changes little from one period to the next: an event of the last period, moved by the period and by its own
change per period, tells where the next one lies, to some 1e-6 of a period near the steady state. Segments then end at
events at once, where a trial beyond them and the search for their instant take four trials or five. What is foretold is
only a first trial: the events found are the same.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled

PER_CYCLE = 24  # events of a contact that are kept
AHEAD = 4  # events of the last period that are looked at
MAX_CHANGE = 0.03  # rad per period of an event's phase


class Place(IntEnum):
    """Index of `LastPeriod.place`."""

    PRESENT = 0  # row of the present period
    NEXT = 1  # event of the last period that is expected next
    COUNT = 2  # events in both rows: this one and the next index


class Ended(IntEnum):
    """Index of `LastPeriod.ended`: the last segment that has ended at an event."""

    BEHIND = 0  # phase from its end to the event
    REACH = 1  # length that its error would have allowed, where its map removes the square roots at its end; else 0


class LastPeriod(NamedTuple):
    """Events of the last period and of the present one, two rows each."""

    period: float  # rad; 0: nothing is kept
    begun: np.ndarray  # (1,): phase at which the present period began
    place: np.ndarray  # (4,), integers, by `Place`
    ended: np.ndarray  # (2,), by `Ended`
    phase: np.ndarray  # (2, k)
    change: np.ndarray  # (2, k): of the phase, in a period
    bend: np.ndarray  # (2, k): change of that
    reach: np.ndarray  # (2, k): `Ended.REACH` of the segment before the event
    step: np.ndarray  # (2, k): proposed length of the segments behind the event
    regimes: np.ndarray  # (2, k), integers: regimes before the event, as one number
    contact: np.ndarray  # (2, k), integers
    guard: np.ndarray  # (2, k), integers
    known: np.ndarray  # (2, k), integers: periods before in which the event was met too


def last_period_of(n: int, period: float) -> LastPeriod:
    """Return the empty events of n contacts on waves of a period in rad."""
    size = PER_CYCLE * n * max(round(period / (2.0 * np.pi)), 1)
    rows = [np.zeros((2, size)) for _ in range(5)] + [np.zeros((2, size), np.int64) for _ in range(4)]
    return LastPeriod(period, np.zeros(1), np.zeros(4, np.int64), np.zeros(2), *rows)


@compiled
def regimes_of(state, first, last):
    """Return the regimes of the contacts as one number."""
    number = 0
    for i in range(first, last):
        number = 3 * number + state.regime[i]
    return number


@compiled
def expected_event(kept, regimes, phase):
    """Return the index of the event of the last period that is expected next, -1 without one."""
    if kept.period == 0.0:
        return -1
    place = kept.place
    if not kept.begun[0] <= phase < kept.begun[0] + 2.0 * kept.period:  # phases are counted anew
        place[Place.COUNT] = place[Place.COUNT + 1] = place[Place.NEXT] = 0
        kept.begun[0] = phase
    elif phase >= kept.begun[0] + kept.period:
        kept.begun[0] += kept.period
        place[Place.PRESENT], place[Place.NEXT] = 1 - place[Place.PRESENT], 0
        place[Place.COUNT + place[Place.PRESENT]] = 0
    row = 1 - place[Place.PRESENT]
    for k in range(place[Place.NEXT], min(place[Place.NEXT] + AHEAD, place[Place.COUNT + row])):
        if kept.regimes[row, k] == regimes and expected_phase(kept, k) > phase + 1e-6:
            return k
    return -1


@compiled
def expected_phase(kept, k):
    """Return the phase at which an event of the last period is expected in this one."""
    row = 1 - kept.place[Place.PRESENT]
    return kept.phase[row, k] + kept.period + kept.change[row, k] + kept.bend[row, k]


@compiled
def keep_event(kept, regimes, contact, guard, phase):
    """Keep an event at the end of a segment, at a phase.

    Return the length of the segments that followed it in the last period, 0 where it is new.
    """
    if kept.period == 0.0:
        return 0.0
    place, row = kept.place, kept.place[Place.PRESENT]
    last, step, change, bend, known = 1 - row, 0.0, 0.0, 0.0, 0
    phase += kept.ended[Ended.BEHIND]
    for k in range(place[Place.NEXT], min(place[Place.NEXT] + AHEAD, place[Place.COUNT + last])):
        same = kept.regimes[last, k] == regimes and kept.contact[last, k] == contact and kept.guard[last, k] == guard
        moved = phase - kept.phase[last, k] - kept.period
        if same and abs(moved) < MAX_CHANGE:
            step, change, known = kept.step[last, k], moved, kept.known[last, k] + 1
            bend = moved - kept.change[last, k] if known > 1 else 0.0
            place[Place.NEXT] = k + 1
            break
    k = place[Place.COUNT + row]
    if k < kept.phase.shape[1]:
        kept.phase[row, k], kept.change[row, k], kept.bend[row, k] = phase, change, bend
        kept.step[row, k], kept.reach[row, k], kept.known[row, k] = step, kept.ended[Ended.REACH], known
        kept.regimes[row, k], kept.contact[row, k], kept.guard[row, k] = regimes, contact, guard
        place[Place.COUNT + row] = k + 1
    return step


@compiled
def keep_step(kept, step):
    """Keep the proposed length of the segments behind the last event."""
    row = kept.place[Place.PRESENT]
    k = kept.place[Place.COUNT + row] - 1
    if kept.period > 0.0 and k >= 0:
        kept.step[row, k] = step
