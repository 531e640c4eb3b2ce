"""Normal motion of the slider: its bounce about the steady approach, at which <P> is the preload.

Arguments: p, the flat array of parameters, and state, that of the state (`index`); tables, R, g and the step response
of every drive, one after the other; drive, number of the drive whose wave counts, 0 or 1; s, the normal amplitude of
the wave at the slider, m; h, the mean approach, m, and w, its rate, m/s; preload, N.  <P> is the mean normal force of a
cycle, summed over the contacts, N; it is zero from h = -s downwards, where no contact touches.
"""

from math import sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.contact_spring import carrying_approach, rest_approach
from studies.export.reduced_motor.force_tables import attracts, mean_load, mean_pull, normal_force
from studies.export.reduced_motor.index import Array


@compiled
def steady_approach(p: Array, tables: Array, drive: int, s: float, preload: float, hops: int) -> float:
    """Return the mean approach in m at which <P> is the preload.

    It lies between -s, where no contact touches, and the approach without a wave, because a wave raises <P>. Contacts
    that attract may have two: that of contacts which stay closed, or with `hops` = 1 that of contacts which open.
    """
    if attracts(p) == 0 and p[index.DEPTHS] < 0.5:
        rest = rest_approach(p, tables, preload)
        return rest if s <= 0.0 else riding_between(p, tables, drive, s, preload, -s, rest)
    start = p[index.START]
    top = start + carrying_approach(p, tables, preload + p[index.CONTACTS] * p[index.PULL])
    if p[index.FIRST_DRIVE + index.PULLS] >= 0.0:
        top = start + p[index.DEEPEST]
    if s <= 0.0:
        return riding_between(p, tables, drive, 0.0, preload, start, top) if attracts(p) == 1 else top
    high = top + s
    if attracts(p) == 0:
        return riding_between(p, tables, drive, s, preload, start - s, high)
    closed = start + s * (1.0 + 1e-9)
    opens = start + s * (1.0 - 1e-9)
    if hops == 1 and normal_force(p, tables, drive, opens, s) > preload:
        return riding_between(p, tables, drive, s, preload, start - s, opens)
    if closed < high and normal_force(p, tables, drive, closed, s) <= preload:
        return riding_between(p, tables, drive, s, preload, closed, high)
    return riding_between(p, tables, drive, s, preload, start - s, min(opens, high))


@compiled
def riding_between(p: Array, tables: Array, drive: int, s: float, preload: float, low: float, high: float) -> float:
    """Return the approach between two bounds at which <P> is the preload (false position, Illinois variant)."""
    span = high + s
    below = normal_force(p, tables, drive, low, s) - preload
    above = normal_force(p, tables, drive, high, s) - preload
    if above <= 0.0:
        return high
    if below >= 0.0:
        return low
    last_side: int = 0
    h = high
    i: int = 0
    while i < 60 and high - low > 1e-14 * span:
        h = (low * above - high * below) / (above - below)
        f = normal_force(p, tables, drive, h, s) - preload
        if abs(f) < 1e-14 * preload:
            i = 60
        if f > 0.0:
            high = h
            above = f
            if last_side == 1:
                below = 0.5 * below
            last_side = 1
        else:
            low = h
            below = f
            if last_side == -1:
                above = 0.5 * above
            last_side = -1
        i = i + 1
    return h


@compiled
def normal_acceleration(p: Array, tables: Array, drive: int, s: float, preload: float, h: float, w: float) -> float:
    """Return h'' = (preload - <P> (1 + contact damping w) - normal damping w)/mass, m/s^2."""
    force = mean_load(p, tables, drive, h, s) * (1.0 + p[index.CONTACT_DAMPING] * w)
    if attracts(p) == 1:
        force = force - mean_pull(p, tables, drive, h, s)
    return (preload - force - p[index.NORMAL_DAMPING] * w) / p[index.MASS]


@compiled
def bounce_step(p: Array, tables: Array, state: Array, drive: int, s: float, preload: float, d: float) -> float:
    """Advance the approach and its rate by a step d in s (Runge-Kutta of order 4).

    Return the approach in the middle of the step, from the cubic Hermite polynomial through both ends.
    """
    h = state[index.APPROACH]
    w = state[index.APPROACH_RATE]
    a1 = normal_acceleration(p, tables, drive, s, preload, h, w)
    w2 = w + 0.5 * d * a1
    h2 = h + 0.5 * d * w
    a2 = normal_acceleration(p, tables, drive, s, preload, h2, w2)
    w3 = w + 0.5 * d * a2
    h3 = h + 0.5 * d * w2
    a3 = normal_acceleration(p, tables, drive, s, preload, h3, w3)
    w4 = w + d * a3
    a4 = normal_acceleration(p, tables, drive, s, preload, h + d * w3, w4)
    state[index.APPROACH] = h + d / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
    state[index.APPROACH_RATE] = w + d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return 0.5 * (h + state[index.APPROACH]) + 0.125 * d * (w - state[index.APPROACH_RATE])


@compiled
def update_steady_approach(p: Array, tables: Array, state: Array, drive: int, s: float, preload: float) -> float:
    """Store the steady approach and the angular frequency of the bounce about it; return this approach in m.

    The frequency follows from the slope of <P> over h, by a central difference.
    """
    hops: int = 1 if state[index.APPROACH] - s < p[index.START] else 0
    h = steady_approach(p, tables, drive, s, preload, hops)
    span = 1e-4 * (abs(h) + s)
    rise = normal_force(p, tables, drive, h + span, s) - normal_force(p, tables, drive, h - span, s)
    state[index.STEADY_APPROACH] = h
    state[index.BOUNCE_OMEGA] = sqrt(max(0.5 * rise / span, 1e-30) / p[index.MASS])
    return h


@compiled
def settle(p: Array, state: Array, s: float) -> float:
    """Return 1 if the bounce persists, else 0, after putting the slider at rest at the steady approach h_0.

    The bounce has decayed if its amplitude, |h - h_0| + |w|/(its angular frequency), is below DEAD_BOUNCE (|h_0| + s).
    """
    amplitude = (
        abs(state[index.APPROACH] - state[index.STEADY_APPROACH])
        + abs(state[index.APPROACH_RATE]) / state[index.BOUNCE_OMEGA]
    )
    state[index.BOUNCES] = 1.0
    if amplitude < p[index.DEAD_BOUNCE] * (abs(state[index.STEADY_APPROACH]) + s):
        state[index.APPROACH] = state[index.STEADY_APPROACH]
        state[index.APPROACH_RATE] = 0.0
        state[index.BOUNCES] = 0.0
    return state[index.BOUNCES]
