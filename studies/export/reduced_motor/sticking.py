"""A slider whose contacts stick: it oscillates on their springs until they reach the limit of slip."""

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.contact_spring import rest_approach, spring_deformation, spring_force, spring_share
from studies.export.reduced_motor.force_tables import bounded, mean_load, steady_load, stick_limit
from studies.export.reduced_motor.index import Array


@compiled
def parts(duration: float, longest: float) -> int:
    """Return the number of equal steps into which a duration is divided."""
    if duration <= longest:
        return 1
    return int(duration / longest * (1.0 - 1e-12)) + 1


@compiled
def ring(p: Array, tables: Array, state: Array, force: float, limit: float, inverse: float, d: float) -> float:
    """Advance deformation and velocity of sticking contacts by a step d in s (Nystrom, order 4); return 0."""
    depth = 1.0 / (p[index.LIMIT_SLOPE] * inverse)
    lightness = 1.0 / p[index.MASS]
    fade = 0.5 * d * p[index.TANGENTIAL_DAMPING] * lightness
    fade = 1.0 - fade * (1.0 - 0.5 * fade)  # of the dampers in half a step
    x = state[index.DEFORMATION]
    v = fade * state[index.VELOCITY]
    first = lightness * (force + limit * spring_share(p, tables, x * inverse, depth))
    middle = lightness * (
        force + limit * spring_share(p, tables, (x - 0.5 * d * (v + 0.25 * d * first)) * inverse, depth)
    )
    last = lightness * (force + limit * spring_share(p, tables, (x - d * (v + 0.5 * d * middle)) * inverse, depth))
    state[index.DEFORMATION] = x - d * (v + d / 6.0 * (first + 2.0 * middle))
    state[index.VELOCITY] = fade * (v + d / 6.0 * (first + 4.0 * middle + last))
    return 0.0


@compiled
def stick_step(p: Array, tables: Array, state: Array, h: float, s: float, force: float, d: float) -> float:
    """Advance a sticking slider by a step d in s; return the rest of d, in which it slips, s."""
    drive: int = int(state[index.ACTIVE])
    load = mean_load(p, tables, drive, h, s)
    least = stick_limit(p, tables, drive, h, s, load, 1)
    largest = stick_limit(p, tables, drive, h, s, load, 0)
    low = spring_deformation(p, tables, load, least)
    high = spring_deformation(p, tables, load, largest)
    v = state[index.VELOCITY]
    x = bounded(state[index.DEFORMATION], low, high)
    if (largest <= least) or (x >= high and v < 0.0) or (x <= low and v > 0.0):
        state[index.STICKS] = 0.0
        state[index.PINNED] = 1.0 if v < 0.0 else -1.0
        state[index.DEFORMATION] = x
        state[index.FORCE] = spring_force(p, tables, load, x)
        return d
    limit = p[index.FRICTION] * load
    depth = rest_approach(p, tables, load)
    inverse = 1.0 / (p[index.LIMIT_SLOPE] * depth)
    state[index.DEFORMATION] = x
    ring(p, tables, state, force, limit, inverse, d)
    share = 1.0
    edge = bounded(state[index.DEFORMATION], low, high)
    if edge != state[index.DEFORMATION]:  # slip begins within the step
        share = (edge - x) / (state[index.DEFORMATION] - x)
        state[index.DEFORMATION] = edge
        state[index.VELOCITY] = v + share * (state[index.VELOCITY] - v)
        if state[index.VELOCITY] * (x - edge) <= 0.0:
            state[index.VELOCITY] = (x - edge) / d * 1e-12
        state[index.STICKS] = 0.0
        state[index.PINNED] = 1.0 if edge > x else -1.0
    state[index.POSITION] = state[index.POSITION] + x - state[index.DEFORMATION]
    state[index.FORCE] = limit * spring_share(p, tables, state[index.DEFORMATION] * inverse, depth)
    return (1.0 - share) * d


@compiled
def update_limits(p: Array, tables: Array, state: Array, load: float) -> float:
    """Store the deformations at which contacts on a steady wave slip, once for each wave and preload; return 0."""
    if state[index.DEPTH] <= 0.0:
        drive: int = int(state[index.ACTIVE])
        h = state[index.APPROACH]
        s = state[index.SURFACE]
        state[index.DEPTH] = rest_approach(p, tables, load)
        state[index.LOWEST] = spring_deformation(p, tables, load, stick_limit(p, tables, drive, h, s, load, 1))
        state[index.HIGHEST] = spring_deformation(p, tables, load, stick_limit(p, tables, drive, h, s, load, 0))
    return 0.0


@compiled
def rests(p: Array, tables: Array, state: Array, force: float, preload: float) -> float:
    """Return 1 if a sticking slider on a steady wave without bounce stays where it is, else 0.

    Its contacts carry the external force within the limits of slip: a wave above the threshold has none about zero.
    """
    if state[index.VELOCITY] != 0.0 or abs(state[index.FORCE] + force) > 1e-12 * p[index.FRICTION] * preload:
        return 0.0
    drive: int = int(state[index.ACTIVE])
    update_limits(p, tables, state, steady_load(p, tables, drive, state[index.APPROACH], state[index.SURFACE], preload))
    x = state[index.DEFORMATION]
    return 1.0 if x > state[index.LOWEST] and x < state[index.HIGHEST] else 0.0


@compiled
def hold(p: Array, tables: Array, state: Array, force: float, preload: float, duration: float) -> float:
    """Advance a sticking slider on a steady wave without bounce; return the rest of the duration, s.

    It ends before the contacts slip.  A step ends at zero deformation, where the second derivative of the force jumps.
    """
    drive: int = int(state[index.ACTIVE])
    load = steady_load(p, tables, drive, state[index.APPROACH], state[index.SURFACE], preload)
    update_limits(p, tables, state, load)
    limit = p[index.FRICTION] * load
    inverse = 1.0 / (p[index.LIMIT_SLOPE] * state[index.DEPTH])
    x = state[index.DEFORMATION]
    initial = x
    step = duration / parts(duration, p[index.RING_STEP])
    left = duration
    inside: int = 1 if x > state[index.LOWEST] and x < state[index.HIGHEST] else 0
    while inside == 1 and left > 1e-12 * duration:
        d = min(step, left)
        v = state[index.VELOCITY]
        ring(p, tables, state, force, limit, inverse, d)
        if state[index.DEFORMATION] * x < 0.0:
            turns: int = 0
            while turns < 3:  # Newton's method for the instant of zero deformation
                d = d + state[index.DEFORMATION] / state[index.VELOCITY]
                state[index.DEFORMATION] = x
                state[index.VELOCITY] = v
                ring(p, tables, state, force, limit, inverse, d)
                turns = turns + 1
            state[index.DEFORMATION] = 0.0
        if state[index.DEFORMATION] > state[index.LOWEST] and state[index.DEFORMATION] < state[index.HIGHEST]:
            x = state[index.DEFORMATION]
            left = left - d
        else:
            state[index.DEFORMATION] = x
            state[index.VELOCITY] = v
            inside = 0
    state[index.POSITION] = state[index.POSITION] + initial - x
    state[index.FORCE] = limit * spring_share(p, tables, x * inverse, state[index.DEPTH])
    return 0.0 if inside == 1 else left


@compiled
def deformation(p: Array, tables: Array, state: Array) -> float:
    """Return the tangential deformation of the contacts in m; while they slip, the one that would carry their force."""
    if state[index.STICKS] > 0.5:
        return state[index.DEFORMATION]
    load = mean_load(p, tables, int(state[index.ACTIVE]), state[index.APPROACH], state[index.SURFACE])
    limit = p[index.FRICTION] * load
    return spring_deformation(p, tables, load, bounded(state[index.FORCE], -limit, limit))
