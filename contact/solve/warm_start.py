r"""The stretches of the last cycle, as the first guess of the next.

A slider that is heavy on the wave's time scale meets the same events, at nearly the same phases, in cycle after cycle.
For each stretch the kernel keeps where it began and ended, how it ended and the accelerations at its nodes. The next
cycle lays its stretch out to the same end at once; what it finds there is checked as any other stretch is, so that the
pattern saves time and decides nothing.
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled
from contact.solve.segment import PULL, PUSH

# stretches that are kept per cycle: of an impact many more are not worth it
ROOM = 48
# places in the numbers before the accelerations, and in the marks before regimes and signs
BEGIN, END, NODES = 0, 1, 2
MAP, WHO, WHICH, MARKS = 0, 1, 2, 3
# how far a stretch may begin from where it did, in its own length
_NEAR = 0.3


class Pattern(NamedTuple):
    """Two cycles, the last and this: stretches (2,), marks (2, K, 3 + 2 contacts), numbers (2, K, 2 + 2 nodes)."""

    count: np.ndarray
    marks: np.ndarray
    numbers: np.ndarray


def blank(contacts: int, nodes: int) -> Pattern:
    """Return room for a pattern."""
    return Pattern(
        np.zeros(2, np.int64),
        np.zeros((2, ROOM, MARKS + 2 * contacts), np.int64),
        np.zeros((2, ROOM, NODES + 2 * nodes)),
    )


@compiled
def matching(count, marks, numbers, old, first, phase, regime, sign):
    """Return the number of the last cycle's stretch that begins here with these regimes, -1 if there is none."""
    for m in range(first, min(first + 4, count[old])):
        begin, end = numbers[old, m, BEGIN], numbers[old, m, END]
        if abs(phase - begin) > _NEAR * (end - begin):
            continue
        same = True
        for i in range(regime.size):
            same = same and marks[old, m, MARKS + 2 * i] == regime[i]
            same = same and marks[old, m, MARKS + 2 * i + 1] == sign[i]
        if same:
            return m
    return -1


@compiled
def recalled(numbers, old, m, shared):
    """Fill the accelerations at the nodes with those of the last cycle's stretch."""
    n = shared.shape[1]
    for j in range(n):
        shared[PUSH, j] = numbers[old, m, NODES + j]
        shared[PULL, j] = numbers[old, m, NODES + n + j]


@compiled
def kept(count, marks, numbers, new, begin, end, map_, who, which, regime, sign, shared):
    """Keep a stretch of this cycle."""
    m, n = count[new], shared.shape[1]
    if m >= marks.shape[1]:
        return
    marks[new, m, MAP], marks[new, m, WHO], marks[new, m, WHICH] = map_, who, which
    for i in range(regime.size):
        marks[new, m, MARKS + 2 * i] = regime[i]
        marks[new, m, MARKS + 2 * i + 1] = 1 if sign[i] > 0.0 else -1
    numbers[new, m, BEGIN], numbers[new, m, END] = begin, end
    for j in range(n):
        numbers[new, m, NODES + j] = shared[PUSH, j]
        numbers[new, m, NODES + n + j] = shared[PULL, j]
    count[new] = m + 1
