r"""The averaged motor as one step function, in a subset of Python that `c_translation` turns into C.

Model
-----
The slider is heavy on the time scale of the wave, so that the cycle means of the contact forces move it (first-order
averaging, as `contact.burst(method="averaged")`)::

    m h'' = preload - <P>(h, s) (1 + chi h') - d_n h'         h: mean approach of the contacts, m
    m V'  = Q - d_t V + F                                     V: slider velocity along +x, m/s; F: external force
    slip:   Q = mu <P> g(tau, nu),   tau = sqrt(s)/(sqrt(s) + sqrt(h + s)),   nu = V/(v_1 s)
    stick:  Q = mu <P> (1 - (1 - |x|/(c h_0))^e) sign x,   x' = -V,   x kept between the limits of slip

s is the largest normal amplitude |u_z| of the contacts, v_1 s the slider velocity beyond which friction has one
direction throughout the cycle, and <P> = n K (h + s)^e R(tau), with e = 3/2 for spheres and 1 for flat punches.  All
orbits grow with the drive, so that mean forces depend on (h, s, V) through the two ratios tau and nu only: R and g are
tables over them, exact in amplitude, preload and mass.  g jumps at V = 0 where the contacts can stick; the limits of
slip are the two sides of that jump, and the spring between them is that of a surface at rest, h_0 its approach under
<P>: exact without a wave, and an approximation while the wave is below the threshold.

The wave follows its drive by the step response of the surface under the slider, a table over time: inputs are
piecewise constant, and the last `ENTRIES` changes of each drive are kept.  Where two drives act at the same time the
larger wave alone counts.

Integration: slip by the explicit midpoint rule in steps of at most `MAX_STEP`; stick by Nystrom's method of order 4 in
steps of `RING_STEP`; the approach by the classical Runge-Kutta method; `FAST_STEP` while the wave changes, and while
the bounce lives on a surface at rest.  Ends of stick and slip are located within their step.  Tables are read by cubic
interpolation over four neighbours; on a wave at rest (`glide`, `hold`) what does not change is read once.
"""

from math import sqrt

import numpy as np

from contact.jit.compiled import compiled

Array = np.ndarray

SIXTH = 0.16666666666666666

# Places in the parameters (a flat array of doubles)
MASS = 0
NORMAL_DAMPING = 1
TANGENTIAL_DAMPING = 2
CONTACT_DAMPING = 3
FRICTION = 4
LIMIT_SLOPE = 5
STIFFNESS = 6  # n K of all contacts, N/m^e
EXPONENT = 7  # 1.5 or 1
SPAN_TAU = 8  # number of tau nodes
SPAN_NU = 9  # number of nodes of each side of nu
DRIVES = 10  # 1 or 2
MAX_STEP = 11
FAST_STEP = 12
RING_STEP = 13
DEAD_BOUNCE = 14  # relative to the approach at rest: below it the approach follows the wave at once
FIRST_DRIVE = 15
# places in the parameters of each drive
AMPLITUDE = 0  # largest |u_z| of the contacts per unit of the drive, m
SATURATION = 1  # v_1, (m/s)/m
RESPONSE_NODES = 2  # 0: the wave follows at once
RESPONSE_STEP = 3  # s
POWER = 4  # W per squared unit of the drive
LOADS = 5  # where the table R begins
FORCES = 6  # where the table g begins
RESPONSE = 7  # where the step response begins, real and imaginary part
FACING = 8  # 1, or -1 where the table g is that of the mirrored wave
DRIVE_SIZE = 9

# Places in the state (a flat array of doubles)
TIME = 0
POSITION = 1
VELOCITY = 2
DEFORMATION = 3  # of contacts that stick, m; see `deformation`
APPROACH = 4
APPROACH_RATE = 5
STICKS = 6  # 1: the contact sticks
BOUNCES = 7  # 1: the bounce lives
SURFACE = 8  # normal amplitude under the slider, m
FORCE = 9  # Q, N
ACTIVE = 10  # drive whose wave counts
PRELOAD = 11  # of the last step, N
RIDE = 12  # approach at rest on the wave, m, and the bounce's angular frequency there, rad/s
BOUNCE_RATE = 13
PINNED = 14  # at the upper (1) or lower (-1) limit of a spring that slips; 0 where the contacts do not stick at all
DEPTH = 15  # approach that carries <P> without a wave, m; 0 where the three numbers are to be computed anew
LOWEST = 16  # deformations at which slip begins, m
HIGHEST = 17
CELL = 18  # cell of the table g that was read last, from 1 and with the sign of V, and its cubic; 0: none
CUBIC = 19
HISTORY = 23
# places in the history of each drive
LEVEL = 0  # present value of the drive, zero or positive
COUNT = 1  # changes that are kept
SETTLED = 2  # sum of the changes that have settled
CHANGES = 3  # pairs (time, change)
ENTRIES = 48
HISTORY_SIZE = 99  # CHANGES + 2 ENTRIES
STATE_SIZE = 221  # HISTORY + 2 HISTORY_SIZE


@compiled
def cubic(t: float, a: float, b: float, c: float, d: float) -> float:
    """Return the cubic through a, b, c, d at -1, 0, 1, 2."""
    e = t * (t - 1.0)
    f = (t + 1.0) * (t - 2.0)
    return SIXTH * e * ((t + 1.0) * d - (t - 2.0) * a) + 0.5 * f * ((t - 1.0) * b - t * c)


@compiled
def bounded(x: float, low: float, high: float) -> float:
    """Return x within its bounds; not a number stays so."""
    if x < low:
        return low
    if x > high:
        return high
    return x


@compiled
def parts(duration: float, longest: float) -> int:
    """Return into how many equal steps a duration is divided."""
    if duration <= longest:
        return 1
    return int(duration / longest * (1.0 - 1e-12)) + 1


@compiled
def node(position: float, nodes: int) -> int:
    """Return the second of the four nodes about a position, which counts from 0 and is not negative."""
    k: int = int(position)
    if k < 1:
        k = 1
    if k > nodes - 3:
        k = nodes - 3
    return k


@compiled
def ratio(h: float, s: float) -> float:
    """Return tau of a mean approach and a normal amplitude; h + s is positive."""
    return sqrt(s) / (sqrt(s) + sqrt(h + s))


@compiled
def power(z: float, exponent: float) -> float:
    """Return z^(3/2) or z, for z >= 0."""
    if exponent > 1.25:
        return z * sqrt(z)
    return z


@compiled
def mean_load(p: Array, tables: Array, drive: int, h: float, s: float) -> float:
    """Return <P> in N, the sum over the contacts."""
    if h + s <= 0.0:
        return 0.0
    nodes: int = int(p[SPAN_TAU])
    start: int = int(p[FIRST_DRIVE + drive * DRIVE_SIZE + LOADS])
    at = ratio(h, s) * (nodes - 1)
    k: int = node(at, nodes)
    i: int = start + k
    share = cubic(at - k, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return p[STIFFNESS] * power(h + s, p[EXPONENT]) * max(share, 0.0)


@compiled
def traction_share(p: Array, tables: Array, drive: int, tau: float, side: int, size: float) -> float:
    """Return g in -1..1 for V > 0 (side 1) or V < 0 (side 0); `size` is sqrt(|nu|)."""
    if size >= 1.0:
        return -1.0 if side == 1 else 1.0
    rows: int = int(p[SPAN_TAU])
    columns: int = int(p[SPAN_NU])
    facing = p[FIRST_DRIVE + drive * DRIVE_SIZE + FACING]
    start: int = int(p[FIRST_DRIVE + drive * DRIVE_SIZE + FORCES])
    if (side == 1) == (facing > 0.0):  # the second half of the table is that of V > 0
        start = start + rows * columns
    down = tau * (rows - 1)
    along = size * (columns - 1)
    j: int = node(down, rows)
    k: int = node(along, columns)
    t = along - k
    i: int = start + (j - 1) * columns + k
    a = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    b = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    c = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    d = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return facing * bounded(cubic(down - j, a, b, c, d), -1.0, 1.0)


@compiled
def slip_force(p: Array, tables: Array, drive: int, h: float, s: float, load: float, v: float) -> float:
    """Return Q in N of a slipping slider; `load` is <P>."""
    if load <= 0.0:
        return 0.0
    limit = p[FRICTION] * load
    if s <= 0.0:
        return -limit if v > 0.0 else limit
    nu = v / (p[FIRST_DRIVE + drive * DRIVE_SIZE + SATURATION] * s)
    side: int = 1 if v > 0.0 else 0
    return limit * traction_share(p, tables, drive, ratio(h, s), side, sqrt(abs(nu)))


@compiled
def stick_limit(p: Array, tables: Array, drive: int, h: float, s: float, load: float, side: int) -> float:
    """Return the force in N at which slip begins towards +x (side 1) or -x (side 0) of the slider."""
    if load <= 0.0:
        return 0.0
    limit = p[FRICTION] * load
    if s <= 0.0:
        return -limit if side == 1 else limit
    return limit * traction_share(p, tables, drive, ratio(h, s), side, 0.0)


@compiled
def spring_share(u: float, exponent: float) -> float:
    """Return Q over its limit of contacts that stick, deformed by u times the deformation at which they slip."""
    share = 1.0 - power(max(1.0 - abs(u), 0.0), exponent)
    return share if u > 0.0 else -share


@compiled
def rest_approach(p: Array, load: float) -> float:
    """Return the approach in m that carries a load in N on a surface at rest."""
    z = max(load, 0.0) / p[STIFFNESS]
    return z ** (2.0 / 3.0) if p[EXPONENT] > 1.25 else z


@compiled
def spring_force(p: Array, load: float, x: float) -> float:
    """Return Q in N of contacts that stick, deformed by x in m, under a normal force in N."""
    if load <= 0.0:
        return 0.0
    return p[FRICTION] * load * spring_share(x / (p[LIMIT_SLOPE] * rest_approach(p, load)), p[EXPONENT])


@compiled
def spring_deformation(p: Array, load: float, force: float) -> float:
    """Return x in m at which contacts that stick carry a force in N: the inverse of `spring_force`."""
    if load <= 0.0:
        return 0.0
    left = max(1.0 - abs(force) / (p[FRICTION] * load), 0.0)
    if p[EXPONENT] > 1.25:
        left = left ** (2.0 / 3.0)
    x = p[LIMIT_SLOPE] * rest_approach(p, load) * (1.0 - left)
    return x if force > 0.0 else -x


@compiled
def riding(p: Array, tables: Array, drive: int, s: float, preload: float) -> float:
    """Return the mean approach in m at which <P> is the preload (false position, Illinois variant)."""
    rest = rest_approach(p, preload)
    if s <= 0.0:
        return rest
    low = -s
    high = rest
    below = -preload
    above = mean_load(p, tables, drive, high, s) - preload
    if above <= 0.0:
        return high
    kept: int = 0
    h = high
    i: int = 0
    while i < 60 and high - low > 1e-14 * (rest + s):
        h = (low * above - high * below) / (above - below)
        f = mean_load(p, tables, drive, h, s) - preload
        if abs(f) < 1e-14 * preload:
            i = 60
        if f > 0.0:
            high = h
            above = f
            if kept == 1:
                below = 0.5 * below
            kept = 1
        else:
            low = h
            below = f
            if kept == -1:
                above = 0.5 * above
            kept = -1
        i = i + 1
    return h


@compiled
def push(p: Array, tables: Array, drive: int, s: float, preload: float, h: float, w: float) -> float:
    """Return h'' in m/s^2."""
    force = mean_load(p, tables, drive, h, s) * (1.0 + p[CONTACT_DAMPING] * w)
    return (preload - force - p[NORMAL_DAMPING] * w) / p[MASS]


@compiled
def fall(p: Array, tables: Array, state: Array, drive: int, s: float, preload: float, d: float) -> float:
    """Move approach and its rate by a step d in s (Runge-Kutta of order 4); return the approach half-way."""
    h = state[APPROACH]
    w = state[APPROACH_RATE]
    a1 = push(p, tables, drive, s, preload, h, w)
    w2 = w + 0.5 * d * a1
    h2 = h + 0.5 * d * w
    a2 = push(p, tables, drive, s, preload, h2, w2)
    w3 = w + 0.5 * d * a2
    h3 = h + 0.5 * d * w2
    a3 = push(p, tables, drive, s, preload, h3, w3)
    w4 = w + d * a3
    a4 = push(p, tables, drive, s, preload, h + d * w3, w4)
    state[APPROACH] = h + d / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
    state[APPROACH_RATE] = w + d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return 0.5 * (h + state[APPROACH]) + 0.125 * d * (w - state[APPROACH_RATE])


@compiled
def ride(p: Array, tables: Array, state: Array, drive: int, s: float, preload: float) -> float:
    """Find the approach at rest on the wave and the bounce's rate about it; return the former in m."""
    h = riding(p, tables, drive, s, preload)
    span = 1e-4 * (abs(h) + s)
    rise = mean_load(p, tables, drive, h + span, s) - mean_load(p, tables, drive, h - span, s)
    state[RIDE] = h
    state[BOUNCE_RATE] = sqrt(max(0.5 * rise / span, 1e-30) / p[MASS])
    return h


@compiled
def settle(p: Array, state: Array, s: float) -> float:
    """Let the approach follow the wave at once where the bounce has died; return 1 while it lives."""
    apart = abs(state[APPROACH] - state[RIDE]) + abs(state[APPROACH_RATE]) / state[BOUNCE_RATE]
    state[BOUNCES] = 1.0
    if apart < p[DEAD_BOUNCE] * (abs(state[RIDE]) + s):
        state[APPROACH] = state[RIDE]
        state[APPROACH_RATE] = 0.0
        state[BOUNCES] = 0.0
    return state[BOUNCES]


@compiled
def change_drive(p: Array, state: Array, drive: int, level: float) -> float:
    """Set the drive to a level, zero or positive, from now on; return how much it changes."""
    base: int = HISTORY + drive * HISTORY_SIZE
    change = level - state[base + LEVEL]
    if change == 0.0:
        return 0.0
    state[base + LEVEL] = level
    count: int = int(state[base + COUNT])
    i: int = 0
    if p[FIRST_DRIVE + drive * DRIVE_SIZE + RESPONSE_NODES] < 1.0:
        state[base + SETTLED] = level
        return change
    if count == ENTRIES:  # the two oldest become one, at their common mean time
        first = state[base + CHANGES + 1]
        second = state[base + CHANGES + 3]
        weight = abs(first) + abs(second)
        when = (abs(first) * state[base + CHANGES] + abs(second) * state[base + CHANGES + 2]) / weight
        state[base + CHANGES + 2] = when
        state[base + CHANGES + 3] = first + second
        while i < 2 * ENTRIES - 2:
            state[base + CHANGES + i] = state[base + CHANGES + i + 2]
            i = i + 1
        count = ENTRIES - 1
    state[base + CHANGES + 2 * count] = state[TIME]
    state[base + CHANGES + 2 * count + 1] = change
    state[base + COUNT] = count + 1
    return change


@compiled
def wave(p: Array, tables: Array, state: Array, drive: int, time: float) -> float:
    """Return the normal amplitude in m that a drive makes at a time, no earlier than the state's."""
    base: int = HISTORY + drive * HISTORY_SIZE
    own: int = FIRST_DRIVE + drive * DRIVE_SIZE
    nodes: int = int(p[own + RESPONSE_NODES])
    count: int = int(state[base + COUNT])
    if count == 0:
        return max(state[base + SETTLED], 0.0) * p[own + AMPLITUDE]
    start: int = int(p[own + RESPONSE])
    real = state[base + SETTLED]
    imaginary = 0.0
    i: int = 0
    while i < count:
        at = (time - state[base + CHANGES + 2 * i]) / p[own + RESPONSE_STEP]
        change = state[base + CHANGES + 2 * i + 1]
        k: int = nodes - 2
        if at < nodes - 1:
            k = int(at)
        else:
            at = nodes - 1.0
        share = at - k
        real += change * ((1.0 - share) * tables[start + 2 * k] + share * tables[start + 2 * k + 2])
        imaginary += change * ((1.0 - share) * tables[start + 2 * k + 1] + share * tables[start + 2 * k + 3])
        i = i + 1
    return sqrt(real * real + imaginary * imaginary) * p[own + AMPLITUDE]


@compiled
def forget(p: Array, state: Array, drive: int) -> float:
    """Add the changes that have settled to the settled sum; return how many are left."""
    base: int = HISTORY + drive * HISTORY_SIZE
    own: int = FIRST_DRIVE + drive * DRIVE_SIZE
    lasting = (p[own + RESPONSE_NODES] - 1.0) * p[own + RESPONSE_STEP]
    count: int = int(state[base + COUNT])
    i: int = 0
    while count > 0 and state[TIME] - state[base + CHANGES] >= lasting:
        state[base + SETTLED] = state[base + SETTLED] + state[base + CHANGES + 1]
        i = 0
        while i < 2 * count - 2:
            state[base + CHANGES + i] = state[base + CHANGES + i + 2]
            i = i + 1
        count = count - 1
    state[base + COUNT] = count
    if count == 0:
        state[base + SETTLED] = state[base + LEVEL]
    return count


@compiled
def begin(p: Array, tables: Array, state: Array, preload: float, force: float) -> float:
    """Put the slider at rest at time 0 and position 0, its contacts deformed by an external force in N; return 0."""
    i: int = 0
    while i < STATE_SIZE:
        state[i] = 0.0
        i = i + 1
    state[APPROACH] = rest_approach(p, preload)
    state[STICKS] = 1.0
    limit = p[FRICTION] * preload
    held = bounded(-force, -limit, limit)
    state[DEFORMATION] = spring_deformation(p, preload, held)
    state[FORCE] = held
    return 0.0


@compiled
def stick_step(p: Array, tables: Array, state: Array, h: float, s: float, force: float, d: float) -> float:
    """Move a sticking slider by a step d in s; return the part of it that it slips for."""
    drive: int = int(state[ACTIVE])
    load = mean_load(p, tables, drive, h, s)
    least = stick_limit(p, tables, drive, h, s, load, 1)
    largest = stick_limit(p, tables, drive, h, s, load, 0)
    low = spring_deformation(p, load, least)
    high = spring_deformation(p, load, largest)
    v = state[VELOCITY]
    x = bounded(state[DEFORMATION], low, high)
    if (largest <= least) or (x >= high and v < 0.0) or (x <= low and v > 0.0):
        state[STICKS] = 0.0
        state[PINNED] = 1.0 if v < 0.0 else -1.0
        state[DEFORMATION] = x
        state[FORCE] = spring_force(p, load, x)
        return d
    limit = p[FRICTION] * load
    inverse = 1.0 / (p[LIMIT_SLOPE] * rest_approach(p, load))
    state[DEFORMATION] = x
    ring(p, state, force, limit, inverse, d)
    share = 1.0
    edge = bounded(state[DEFORMATION], low, high)
    if edge != state[DEFORMATION]:  # slip begins within the step
        share = (edge - x) / (state[DEFORMATION] - x)
        state[DEFORMATION] = edge
        state[VELOCITY] = v + share * (state[VELOCITY] - v)
        if state[VELOCITY] * (x - edge) <= 0.0:
            state[VELOCITY] = (x - edge) / d * 1e-12
        state[STICKS] = 0.0
        state[PINNED] = 1.0 if edge > x else -1.0
    state[POSITION] = state[POSITION] + x - state[DEFORMATION]
    state[FORCE] = limit * spring_share(state[DEFORMATION] * inverse, p[EXPONENT])
    return (1.0 - share) * d


@compiled
def slip_step(p: Array, tables: Array, state: Array, h: float, s: float, force: float, d: float) -> float:
    """Move a slipping slider by a step d in s (midpoint rule); return the part of it that it sticks for."""
    drive: int = int(state[ACTIVE])
    load = mean_load(p, tables, drive, h, s)
    v = state[VELOCITY]
    low = stick_limit(p, tables, drive, h, s, load, 1)
    high = stick_limit(p, tables, drive, h, s, load, 0)
    if high - low <= 1e-6 * p[FRICTION] * load:
        state[PINNED] = 0.0
    elif (state[PINNED] >= 0.0 and v > 0.0) or (state[PINNED] <= 0.0 and v < 0.0) or v == 0.0:
        # contacts that can stick slip at their limit only: their spring goes there first
        state[STICKS] = 1.0
        state[DEFORMATION] = spring_deformation(p, load, bounded(state[FORCE], low, high))
        return d
    else:  # as the load grows the limit may run away from the spring, which sticks then
        limit = spring_deformation(p, load, high if v < 0.0 else low)
        if (limit - state[DEFORMATION]) * state[PINNED] > abs(v) * d:
            state[STICKS] = 1.0
            return d
        state[DEFORMATION] = limit
    if v == 0.0:  # the side of the jump to which the force leads
        if low + force > 0.0:
            v = 1e-300
        else:
            v = -1e-300
    q = slip_force(p, tables, drive, h, s, load, v)
    half = v + 0.5 * d * (q - p[TANGENTIAL_DAMPING] * v + force) / p[MASS]
    if half * v > 0.0:
        q = slip_force(p, tables, drive, h, s, load, half)
    new = v + d * (q - p[TANGENTIAL_DAMPING] * half + force) / p[MASS]
    share = 1.0
    if new * v < 0.0:
        if high > low:  # the slider stops, and may stick
            share = v / (v - new)
            new = 0.0
            state[STICKS] = 1.0
            q = low if v > 0.0 else high
        else:  # the force is continuous: it crosses zero velocity
            half = 0.5 * (v + new)
    state[POSITION] = state[POSITION] + share * d * 0.5 * (v + new)
    state[VELOCITY] = new
    state[FORCE] = q
    if state[STICKS] > 0.5:
        state[DEFORMATION] = spring_deformation(p, load, q)
    return (1.0 - share) * d


@compiled
def deformation(p: Array, tables: Array, state: Array) -> float:
    """Return the tangential deformation of the contacts in m; slipping, that which would carry their force."""
    if state[STICKS] > 0.5:
        return state[DEFORMATION]
    load = mean_load(p, tables, int(state[ACTIVE]), state[APPROACH], state[SURFACE])
    limit = p[FRICTION] * load
    return spring_deformation(p, load, bounded(state[FORCE], -limit, limit))


@compiled
def glide(p: Array, tables: Array, state: Array, force: float, preload: float, duration: float) -> float:
    """Move a slipping slider on a wave at rest, its bounce dead; return the part of the duration that is left.

    The same midpoint rule as `slip_step`, with all that does not change computed once; it ends before the slider stops.
    """
    s = state[SURFACE]
    v = state[VELOCITY]
    if state[APPROACH] + s <= 0.0 or v == 0.0:
        return duration
    drive: int = int(state[ACTIVE])
    sign = 1.0 if v > 0.0 else -1.0
    inverse = 0.0
    if s > 0.0:
        inverse = sign / (p[FIRST_DRIVE + drive * DRIVE_SIZE + SATURATION] * s)
    lightness = 1.0 / p[MASS]
    limit = p[FRICTION] * preload * lightness
    rate = p[TANGENTIAL_DAMPING] * lightness
    pull = force * lightness
    left = duration
    way = 0.0
    g = -sign
    steps: int = parts(duration, p[MAX_STEP])
    step = duration / steps
    while steps > 0:
        if s > 0.0:
            g = kept_share(p, tables, state, drive, sign, v * inverse)
        half = v + 0.5 * step * (limit * g - rate * v + pull)
        new = half
        if half * sign > 0.0:
            if s > 0.0:
                g = kept_share(p, tables, state, drive, sign, half * inverse)
            new = v + step * (limit * g - rate * half + pull)
        if new * sign <= 0.0:
            steps = -1
        else:
            way = way + 0.5 * step * (v + new)
            v = new
            state[FORCE] = p[FRICTION] * preload * g
            left = left - step
            steps = steps - 1
    state[VELOCITY] = v
    state[POSITION] = state[POSITION] + way
    return left if steps < 0 else 0.0


@compiled
def kept_share(p: Array, tables: Array, state: Array, drive: int, sign: float, nu: float) -> float:
    """Return g at |nu| = `nu` on a wave at rest; the cubic over the cell is kept in the state."""
    if nu >= 1.0:
        return -sign
    rows: int = int(p[SPAN_TAU])
    columns: int = int(p[SPAN_NU])
    along = sqrt(nu) * (columns - 1)
    k: int = node(along, columns)
    t = along - k
    cell = sign * k
    if state[CELL] != cell:
        state[CELL] = cell
        down = ratio(state[APPROACH], state[SURFACE]) * (rows - 1)
        j: int = node(down, rows)
        facing = p[FIRST_DRIVE + drive * DRIVE_SIZE + FACING]
        i: int = int(p[FIRST_DRIVE + drive * DRIVE_SIZE + FORCES]) + (j - 1) * columns + k - 1
        if sign * facing > 0.0:
            i = i + rows * columns
        before = facing * row_blend(tables, i, columns, down - j)
        here = facing * row_blend(tables, i + 1, columns, down - j)
        after = facing * row_blend(tables, i + 2, columns, down - j)
        beyond = facing * row_blend(tables, i + 3, columns, down - j)
        # Newton's form of the cubic through the values at -1, 0, 1, 2
        state[CUBIC] = before
        state[CUBIC + 1] = here - before
        state[CUBIC + 2] = 0.5 * (after - 2.0 * here + before)
        state[CUBIC + 3] = SIXTH * (beyond - 3.0 * after + 3.0 * here - before)
    g = state[CUBIC + 2] + (t - 1.0) * state[CUBIC + 3]
    g = state[CUBIC] + (t + 1.0) * (state[CUBIC + 1] + t * g)
    return bounded(g, -1.0, 1.0)


@compiled
def row_blend(tables: Array, i: int, columns: int, t: float) -> float:
    """Return the cubic across four rows of a table, the first at `i`."""
    j: int = i + 2 * columns
    return cubic(t, tables[i], tables[i + columns], tables[j], tables[j + columns])


@compiled
def hold(p: Array, tables: Array, state: Array, force: float, preload: float, duration: float) -> float:
    """Move a sticking slider on a wave at rest, its bounce dead; return the part of the duration that is left.

    It ends before the contacts slip.  A step ends at zero deformation, where the second derivative of the force jumps.
    """
    if state[DEPTH] <= 0.0:
        drive: int = int(state[ACTIVE])
        h = state[APPROACH]
        s = state[SURFACE]
        state[DEPTH] = rest_approach(p, preload)
        state[LOWEST] = spring_deformation(p, preload, stick_limit(p, tables, drive, h, s, preload, 1))
        state[HIGHEST] = spring_deformation(p, preload, stick_limit(p, tables, drive, h, s, preload, 0))
    limit = p[FRICTION] * preload
    inverse = 1.0 / (p[LIMIT_SLOPE] * state[DEPTH])
    x = state[DEFORMATION]
    place = x
    step = duration / parts(duration, p[RING_STEP])
    left = duration
    inside: int = 1 if x > state[LOWEST] and x < state[HIGHEST] else 0
    while inside == 1 and left > 1e-12 * duration:
        d = min(step, left)
        v = state[VELOCITY]
        ring(p, state, force, limit, inverse, d)
        if state[DEFORMATION] * x < 0.0:
            turns: int = 0
            while turns < 3:  # Newton's method for the instant of zero deformation
                d = d + state[DEFORMATION] / state[VELOCITY]
                state[DEFORMATION] = x
                state[VELOCITY] = v
                ring(p, state, force, limit, inverse, d)
                turns = turns + 1
            state[DEFORMATION] = 0.0
        if state[DEFORMATION] > state[LOWEST] and state[DEFORMATION] < state[HIGHEST]:
            x = state[DEFORMATION]
            left = left - d
        else:
            state[DEFORMATION] = x
            state[VELOCITY] = v
            inside = 0
    state[POSITION] = state[POSITION] + place - x
    state[FORCE] = limit * spring_share(x * inverse, p[EXPONENT])
    return 0.0 if inside == 1 else left


@compiled
def ring(p: Array, state: Array, force: float, limit: float, inverse: float, d: float) -> float:
    """Move deformation and velocity of sticking contacts by a step d in s (Nystrom's method of order 4); return 0."""
    e = p[EXPONENT]
    lightness = 1.0 / p[MASS]
    fade = 0.5 * d * p[TANGENTIAL_DAMPING] * lightness
    fade = 1.0 - fade * (1.0 - 0.5 * fade)  # of the dampers in half a step
    x = state[DEFORMATION]
    v = fade * state[VELOCITY]
    first = lightness * (force + limit * spring_share(x * inverse, e))
    middle = lightness * (force + limit * spring_share((x - 0.5 * d * (v + 0.25 * d * first)) * inverse, e))
    last = lightness * (force + limit * spring_share((x - d * (v + 0.5 * d * middle)) * inverse, e))
    state[DEFORMATION] = x - d * (v + d / 6.0 * (first + 2.0 * middle))
    state[VELOCITY] = fade * (v + d / 6.0 * (first + 4.0 * middle + last))
    return 0.0


@compiled
def advance(
    p: Array, tables: Array, state: Array, level: float, force: float, preload: float, duration: float
) -> float:
    """Move the motor by a duration in s under constant inputs; return 0, or 1 where a number is not finite.

    `level`: of the drive, V or m, negative for the second drive; `force`: external, N along +x; `preload`: N, positive.
    """
    drive: int = 0
    second: int = int(p[DRIVES]) - 1
    changed = change_drive(p, state, 0, max(level, 0.0))
    if second == 1:
        changed = abs(changed) + abs(change_drive(p, state, 1, max(-level, 0.0)))
    done = 0.0
    start = state[TIME]
    pending = state[HISTORY + COUNT]
    if second == 1:
        pending = pending + state[HISTORY + HISTORY_SIZE + COUNT]
    anew = 1.0 if changed != 0.0 or state[PRELOAD] != preload else 0.0
    state[PRELOAD] = preload
    while done < duration * (1.0 - 1e-12):
        if pending > 0.0:
            pending = forget(p, state, 0)
            if second == 1:
                pending = pending + forget(p, state, 1)
            if pending == 0.0:
                anew = anew + 1.0
        if pending > 0.0 or anew > 0.0:
            anew = 0.0
            s = wave(p, tables, state, 0, state[TIME])
            drive = 0
            if second == 1:
                other = wave(p, tables, state, 1, state[TIME])
                if other > s:
                    drive = 1
                    s = other
            state[ACTIVE] = drive
            state[SURFACE] = s
            state[DEPTH] = 0.0
            state[CELL] = 0.0
            ride(p, tables, state, drive, s, preload)
            settle(p, state, s)
        elif state[BOUNCES] > 0.5:
            settle(p, state, state[SURFACE])
        drive = int(state[ACTIVE])
        if pending == 0.0 and state[BOUNCES] < 0.5:
            if state[STICKS] < 0.5:
                done = duration - glide(p, tables, state, force, preload, duration - done)
            elif state[VELOCITY] == 0.0 and abs(state[FORCE] + force) <= 1e-12 * p[FRICTION] * preload:
                done = duration  # at rest
            else:
                done = duration - hold(p, tables, state, force, preload, duration - done)
            state[TIME] = start + done
        if done < duration * (1.0 - 1e-12):
            d = p[MAX_STEP]
            if pending > 0.0 or state[STICKS] > 0.5:
                d = p[FAST_STEP]
            elif state[BOUNCES] > 0.5:  # on a surface at rest contacts stick and slip in turn
                d = p[RING_STEP] if state[SURFACE] > 0.0 else p[FAST_STEP]
            d = min(d, duration - done)
            s = state[SURFACE]
            if pending > 0.0:
                s = wave(p, tables, state, drive, state[TIME] + 0.5 * d)
            h = state[APPROACH]
            if state[BOUNCES] > 0.5:
                h = fall(p, tables, state, drive, s, preload, d)
            left = d
            turns: int = 0
            while left > 0.0 and turns < 4:
                if state[STICKS] > 0.5:
                    left = stick_step(p, tables, state, h, s, force, left)
                else:
                    left = slip_step(p, tables, state, h, s, force, left)
                turns = turns + 1
            done = done + d
            state[TIME] = start + done
    if pending > 0.0:
        state[SURFACE] = wave(p, tables, state, int(state[ACTIVE]), state[TIME])
    check = state[POSITION] + state[VELOCITY] + state[APPROACH] + state[DEFORMATION]
    return 0.0 if check - check == 0.0 else 1.0
