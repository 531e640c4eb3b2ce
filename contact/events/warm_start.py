r"""Warm start: the segments of the last cycle are the first guess of the next cycle's.

A slider that is heavy on the wave's time scale meets the same events at nearly the same phases in every cycle. For each
segment the kernel stores where it began and ended, which guard ended it, and the accelerations at its nodes, with the
changes of end and accelerations from the cycle before. The next cycle computes its segment at once up to the end, and
from the accelerations, that these changes lead to. The result is checked like that of any other segment, so that the
warm start saves time and does not change the motion beyond rounding.
"""

from typing import NamedTuple

import numpy as np

from contact.events.segment import SliderRow
from contact.jit.compiled import compiled

# Segments stored per cycle. A motion with more events than that does not repeat closely enough to gain.
MAX_SEGMENTS = 48
# largest distance between the starts of two segments that match, over the length of the stored one
_NEAR = 0.3
NEXT = 2  # index in `Pattern.stored`


class Pattern(NamedTuple):
    """Segments of the last cycle and of this one, K of each at most."""

    stored: np.ndarray  # (3,) int: segments of both cycles, and which of the two is the next one's
    begin: np.ndarray  # (2, K): phases
    end: np.ndarray
    map: np.ndarray  # (2, K) int: as in `segment.Segment`
    contact: np.ndarray
    guard: np.ndarray
    regime: np.ndarray  # (2, K, contacts): of the contacts
    sign: np.ndarray
    acceleration: np.ndarray  # (2, K, 2, nodes): of the slider, normal and tangential
    # changes from the same segment of the cycle before, zero where it had none
    end_change: np.ndarray  # (2, K)
    acceleration_change: np.ndarray  # (2, K, 2, nodes)


def blank(contacts: int, nodes: int) -> Pattern:
    """Return an empty pattern for so many contacts and nodes of a segment."""
    which, contact = (2, MAX_SEGMENTS), (2, MAX_SEGMENTS, contacts)
    return Pattern(
        stored=np.zeros(3, np.int64), begin=np.empty(which), end=np.empty(which), map=np.empty(which, np.int64),
        contact=np.empty(which, np.int64), guard=np.empty(which, np.int64), regime=np.empty(contact, np.int64),
        sign=np.empty(contact), acceleration=np.empty((2, MAX_SEGMENTS, 2, nodes)),
        end_change=np.empty(which), acceleration_change=np.empty((2, MAX_SEGMENTS, 2, nodes)),
    )  # fmt: skip


@compiled
def matching(pattern, old, first, phase, state):
    """Return the number of the last cycle's segment that begins here with these regimes, -1 if there is none."""
    for m in range(first, min(first + 4, pattern.stored[old])):
        begin, end = pattern.begin[old, m], pattern.end[old, m]
        if abs(phase - begin) > _NEAR * (end - begin):
            continue
        same = True
        for i in range(state.regime.size):
            same = same and pattern.regime[old, m, i] == state.regime[i]
            same = same and pattern.sign[old, m, i] == state.sign[i]
        if same:
            return m
    return -1


@compiled
def recall(pattern, old, m, nodes):
    """Fill the accelerations at the nodes with those of the last cycle's segment and their last change."""
    known, change = pattern.acceleration[old, m], pattern.acceleration_change[old, m]
    for j in range(nodes.guard.size):
        nodes.slider[SliderRow.NORMAL_ACCELERATION, j] = known[0, j] + change[0, j]
        nodes.slider[SliderRow.TANGENTIAL_ACCELERATION, j] = known[1, j] + change[1, j]


@compiled
def store(pattern, new, match, segment, end, state, nodes):
    """Store a segment of this cycle, which ends at the phase `end`; `match`: that of the last cycle, -1 without one."""
    m, old = pattern.stored[new], 1 - new
    if m >= pattern.begin.shape[1]:
        return
    pattern.begin[new, m], pattern.end[new, m], pattern.map[new, m] = segment.phase, end, segment.map
    pattern.contact[new, m], pattern.guard[new, m] = segment.contact, segment.guard
    for i in range(state.regime.size):
        pattern.regime[new, m, i], pattern.sign[new, m, i] = state.regime[i], state.sign[i]
    normal, tangential = nodes.slider[SliderRow.NORMAL_ACCELERATION], nodes.slider[SliderRow.TANGENTIAL_ACCELERATION]
    same = match >= 0 and segment.map == pattern.map[old, match]
    same = same and segment.contact == pattern.contact[old, match] and segment.guard == pattern.guard[old, match]
    known, change = pattern.acceleration[new, m], pattern.acceleration_change[new, m]
    before = pattern.acceleration[old, max(match, 0)]
    pattern.end_change[new, m] = end - pattern.end[old, match] if same and segment.contact >= 0 else 0.0
    for j in range(nodes.guard.size):
        known[0, j], known[1, j] = normal[j], tangential[j]
        change[0, j] = normal[j] - before[0, j] if same else 0.0
        change[1, j] = tangential[j] - before[1, j] if same else 0.0
    pattern.stored[new] = m + 1
