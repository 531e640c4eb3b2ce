"""The wave under the slider: the sum of the step responses of the surface to the changes of the drives."""

from math import sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.index import Array


@compiled
def change_drive(p: Array, state: Array, drive: int, level: float) -> float:
    """Set the drive to a level, zero or positive, from now on; return the change."""
    base: int = index.HISTORY + drive * index.HISTORY_SIZE
    change = level - state[base + index.LEVEL]
    if change == 0.0:
        return 0.0
    state[base + index.LEVEL] = level
    count: int = int(state[base + index.COUNT])
    i: int = 0
    if p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.RESPONSE_NODES] < 1.0:
        state[base + index.SETTLED] = level
        return change
    if count == index.ENTRIES:  # merge the two oldest at their mean time, weighted by their sizes
        first = state[base + index.CHANGES + 1]
        second = state[base + index.CHANGES + 3]
        weight = abs(first) + abs(second)
        when = (abs(first) * state[base + index.CHANGES] + abs(second) * state[base + index.CHANGES + 2]) / weight
        state[base + index.CHANGES + 2] = when
        state[base + index.CHANGES + 3] = first + second
        while i < 2 * index.ENTRIES - 2:
            state[base + index.CHANGES + i] = state[base + index.CHANGES + i + 2]
            i = i + 1
        count = index.ENTRIES - 1
    state[base + index.CHANGES + 2 * count] = state[index.TIME]
    state[base + index.CHANGES + 2 * count + 1] = change
    state[base + index.COUNT] = count + 1
    return change


@compiled
def wave(p: Array, tables: Array, state: Array, drive: int, time: float) -> float:
    """Return the normal amplitude in m that a drive makes at a time, no earlier than the state's."""
    base: int = index.HISTORY + drive * index.HISTORY_SIZE
    own: int = index.FIRST_DRIVE + drive * index.DRIVE_SIZE
    nodes: int = int(p[own + index.RESPONSE_NODES])
    count: int = int(state[base + index.COUNT])
    if count == 0:
        return max(state[base + index.SETTLED], 0.0) * p[own + index.AMPLITUDE]
    start: int = int(p[own + index.RESPONSE])
    real = state[base + index.SETTLED]
    imaginary = 0.0
    i: int = 0
    while i < count:
        at = (time - state[base + index.CHANGES + 2 * i]) / p[own + index.RESPONSE_STEP]
        change = state[base + index.CHANGES + 2 * i + 1]
        k: int = nodes - 2
        if at < nodes - 1:
            k = int(at)
        else:
            at = nodes - 1.0
        share = at - k
        real += change * ((1.0 - share) * tables[start + 2 * k] + share * tables[start + 2 * k + 2])
        imaginary += change * ((1.0 - share) * tables[start + 2 * k + 1] + share * tables[start + 2 * k + 3])
        i = i + 1
    return sqrt(real * real + imaginary * imaginary) * p[own + index.AMPLITUDE]


@compiled
def forget(p: Array, state: Array, drive: int) -> float:
    """Add the changes that have settled to the settled sum; return how many are left."""
    base: int = index.HISTORY + drive * index.HISTORY_SIZE
    own: int = index.FIRST_DRIVE + drive * index.DRIVE_SIZE
    lasting = (p[own + index.RESPONSE_NODES] - 1.0) * p[own + index.RESPONSE_STEP]
    count: int = int(state[base + index.COUNT])
    i: int = 0
    while count > 0 and state[index.TIME] - state[base + index.CHANGES] >= lasting:
        state[base + index.SETTLED] = state[base + index.SETTLED] + state[base + index.CHANGES + 1]
        i = 0
        while i < 2 * count - 2:
            state[base + index.CHANGES + i] = state[base + index.CHANGES + i + 2]
            i = i + 1
        count = count - 1
    state[base + index.COUNT] = count
    if count == 0:
        state[base + index.SETTLED] = state[base + index.LEVEL]
    return count
