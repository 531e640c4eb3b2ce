"""A slider that slips: mean friction drives or brakes it until it stops."""

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.contact_spring import spring_deformation
from studies.export.reduced_motor.force_tables import (
    bounded,
    cached_share,
    mean_load,
    slip_force,
    steady_load,
    stick_limit,
)
from studies.export.reduced_motor.index import Array
from studies.export.reduced_motor.sticking import parts


@compiled
def slip_step(p: Array, tables: Array, state: Array, h: float, s: float, force: float, d: float) -> float:
    """Advance a slipping slider by a step d in s (midpoint rule); return the rest of d, in which it sticks, s."""
    drive: int = int(state[index.ACTIVE])
    load = mean_load(p, tables, drive, h, s)
    v = state[index.VELOCITY]
    low = stick_limit(p, tables, drive, h, s, load, 1)
    high = stick_limit(p, tables, drive, h, s, load, 0)
    if high - low <= 1e-6 * p[index.FRICTION] * load:
        state[index.PINNED] = 0.0
    elif (state[index.PINNED] >= 0.0 and v > 0.0) or (state[index.PINNED] <= 0.0 and v < 0.0) or v == 0.0:
        # contacts that can stick slip only once their spring is at its limit
        state[index.STICKS] = 1.0
        state[index.DEFORMATION] = spring_deformation(p, tables, load, bounded(state[index.FORCE], low, high))
        return d
    else:  # if the limit grows faster than the spring deforms, the contacts stick
        limit = spring_deformation(p, tables, load, high if v < 0.0 else low)
        if (limit - state[index.DEFORMATION]) * state[index.PINNED] > abs(v) * d:
            state[index.STICKS] = 1.0
            return d
        state[index.DEFORMATION] = limit
    if v == 0.0:  # the side of the jump to which the force leads
        if low + force > 0.0:
            v = 1e-300
        else:
            v = -1e-300
    q = slip_force(p, tables, drive, h, s, load, v)
    half = v + 0.5 * d * (q - p[index.TANGENTIAL_DAMPING] * v + force) / p[index.MASS]
    if half * v > 0.0:
        q = slip_force(p, tables, drive, h, s, load, half)
    new = v + d * (q - p[index.TANGENTIAL_DAMPING] * half + force) / p[index.MASS]
    share = 1.0
    if new * v < 0.0:
        if high > low:  # the slider stops, and may stick
            share = v / (v - new)
            new = 0.0
            state[index.STICKS] = 1.0
            q = low if v > 0.0 else high
        else:  # the force is continuous: it crosses zero velocity
            half = 0.5 * (v + new)
    state[index.POSITION] = state[index.POSITION] + share * d * 0.5 * (v + new)
    state[index.VELOCITY] = new
    state[index.FORCE] = q
    if state[index.STICKS] > 0.5:
        state[index.DEFORMATION] = spring_deformation(p, tables, load, q)
    return (1.0 - share) * d


@compiled
def glide(p: Array, tables: Array, state: Array, force: float, preload: float, duration: float) -> float:
    """Advance a slipping slider on a steady wave without bounce; return the rest of the duration, s.

    The midpoint rule of `slip_step` with constant terms computed once; it ends before the slider stops.
    """
    s = state[index.SURFACE]
    v = state[index.VELOCITY]
    if state[index.APPROACH] + s <= p[index.START] or v == 0.0:
        return duration
    drive: int = int(state[index.ACTIVE])
    sign = 1.0 if v > 0.0 else -1.0
    inverse = 0.0
    if s > 0.0:
        inverse = sign / (p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.SATURATION] * s)
    lightness = 1.0 / p[index.MASS]
    load = steady_load(p, tables, drive, state[index.APPROACH], s, preload)
    limit = p[index.FRICTION] * load * lightness
    rate = p[index.TANGENTIAL_DAMPING] * lightness
    pull = force * lightness
    left = duration
    distance = 0.0
    g = -sign
    steps: int = parts(duration, p[index.MAX_STEP])
    step = duration / steps
    while steps > 0:
        if s > 0.0:
            g = cached_share(p, tables, state, drive, sign, v * inverse)
        half = v + 0.5 * step * (limit * g - rate * v + pull)
        new = half
        if half * sign > 0.0:
            if s > 0.0:
                g = cached_share(p, tables, state, drive, sign, half * inverse)
            new = v + step * (limit * g - rate * half + pull)
        if new * sign <= 0.0:
            steps = -1
        else:
            distance = distance + 0.5 * step * (v + new)
            v = new
            state[index.FORCE] = p[index.FRICTION] * load * g
            left = left - step
            steps = steps - 1
    state[index.VELOCITY] = v
    state[index.POSITION] = state[index.POSITION] + distance
    return left if steps < 0 else 0.0
