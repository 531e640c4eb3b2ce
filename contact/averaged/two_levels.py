"""The speed at which no mean force is left on a heavy slider on rough balls, by a fine discretisation and a coarse one.

The balls are any named tuple with the fields ``heavy`` (`Heavy`), ``waves`` (one row for each ball), and
``net_force(balls, way, v, parts)``: the mean forces in N of friction and damper along the motion at a speed v >= 0 in
m/s in the direction ``way``, by so many parts of a cycle or of depth and a fine table of the surface, and by the coarse
one. A search by the fine one gives both speeds: at its end the other force is left, over the slope of the force.

The load opposes the motion of the unloaded slider, or the crests where friction holds the unloaded one. It drives the
slider back where it exceeds what friction at rest holds (`averaged.equilibrium` has the same rule for smooth balls).
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled
from contact.roots import narrowed, trial

VELOCITY = 1e-6  # of a velocity over that at which all slips backwards
ROUGHLY = 3e-3  # of the velocity by few parts, from which the search goes on
FEW = 8  # parts of that first search
NOTHING = 1e-9  # force over the friction of a ball that is no drive
CLEAR = 0.1  # force over the friction of a ball at rest whose sign few parts tell
NEAR = 0.05  # change of a velocity over it up to which the force is a straight line


class Heavy(NamedTuple):
    """Numbers of a slider that moves at one velocity, and of its waves."""

    friction: float  # mu
    limit_slope: float  # c
    load: float  # N, against the motion of the unloaded slider
    damping: float  # R_t, N s/m
    share: float  # of the preload for each ball, N
    omega: float  # rad/s


@compiled
def _left(balls, way, v, parts, load):
    """Return the mean forces left at a speed in the direction `way`, with the load against it, of both levels."""
    fine, coarse = balls.net_force(balls, way, v, parts)
    return fine - load, coarse - load


@compiled
def _first_speed(balls, way, parts, left, top, load):
    """Return a speed near that at which no force is left, which is `left` at rest, and the force's slope there."""
    heavy = balls.heavy
    a, fa, b = 0.0, left, top
    # all slips backwards
    fb = -heavy.friction * heavy.share * balls.waves.shape[0] - load - heavy.damping * top
    slope = (fb - fa) / (b - a)
    for count in range(60):
        x = trial(a, fa, b, fb, count)
        close = abs(x - b) <= ROUGHLY * x
        if close:
            return x, slope
        old, fold = b, fb
        a, fa, b, fb = narrowed(a, fa, b, fb, x, _left(balls, way, x, parts, load)[0])
        if b != old:
            slope = (fb - fold) / (b - old)
    return b, slope


class Balance(NamedTuple):
    """End of a search for the speed of a level: the finer parts and table (0), or the coarser ones (1)."""

    speed: float
    slope: float  # of the force
    # the force left at a speed close by, of both levels
    at: float
    left: tuple[float, float]


@compiled
def _balance(balls, way, parts, level, speed, slope, top, load):
    """Return the speed of a level at which no force is left, by secants from one near it."""
    low, high, tolerance = 0.0, top, VELOCITY * top
    old, f_old = -1.0, 0.0
    speed = min(max(speed, tolerance), top)
    left = 0.0, 0.0
    for count in range(100):
        left = _left(balls, way, speed, parts, load)
        f = left[level]
        if f > 0.0:
            low = speed
        else:
            high = speed
        if old >= 0.0 and speed != old and (f - f_old) / (speed - old) < 0.0:
            slope = (f - f_old) / (speed - old)
        new = speed - f / slope if slope < 0.0 else -1.0
        if not low <= new <= high or count % 12 == 11:
            new = 0.5 * (low + high)
        if abs(new - speed) <= tolerance:
            return Balance(new, slope, speed, left)
        old, f_old, speed = speed, f, new
    return Balance(speed, slope, old, left)


@compiled
def _at_rest(balls, way, parts, load):
    """Return the forces left at rest: of few parts where they tell the sign, and by how much they do."""
    clear = CLEAR * balls.heavy.friction * balls.heavy.share * balls.waves.shape[0]
    few = min(FEW, parts)
    left = _left(balls, way, 0.0, few, load)
    if abs(left[0]) > clear and abs(left[1]) > clear:
        return left
    return left if few == parts else _left(balls, way, 0.0, parts, load)


@compiled
def _drive(balls, parts, nothing):
    """Return the direction in which the slider starts, 0 if it rests, the forces left at rest, and the load against it.

    The load is negative where it drives the slider.
    """
    load, against, left = balls.heavy.load, 0.0, (0.0, 0.0)
    for sign in (1.0, -1.0):
        left = _at_rest(balls, sign, parts, 0.0)
        if max(left[0], left[1]) > nothing:
            against = sign
            break
    if load == 0.0:
        return against, left, 0.0
    if against == 0.0:
        # u_x' at the crest is -omega times the part of u_x before u_z
        against = -1.0 if np.sum(balls.waves[:, 2]) > 0.0 else 1.0
    for sign in (1.0, -1.0):
        left = _at_rest(balls, sign * against, parts, sign * load)
        if max(left[0], left[1]) > nothing:
            return sign * against, left, sign * load
    return 0.0, left, 0.0


@compiled
def balanced_speeds(balls, parts, top, out):
    """Write the velocities by the fine and the coarse discretisation, the slope of the force, and the load; return 0.

    The load is that against the motion, negative where it drives the slider. ``top``: speed in m/s from which on
    everything slips backwards. At first ``out`` holds a velocity from which the search starts and the slope there, or
    zeros. A load beyond full friction needs a damper.
    """
    heavy, start, rate = balls.heavy, out[0], out[2]
    out[0] = out[1] = out[2] = out[3] = 0.0
    nothing = NOTHING * heavy.friction * heavy.share
    way, left, load = _drive(balls, parts, nothing)
    out[3] = load
    if way == 0.0:
        return 0
    beyond = -load - heavy.friction * heavy.share * balls.waves.shape[0]
    if beyond >= heavy.damping * top:  # the damper alone holds it
        top = 2.0 * beyond / heavy.damping
    if not (start * way > 0.0 and rate < 0.0):
        start, rate = _first_speed(balls, way, min(FEW, parts), max(left[0], nothing), top, load)
    slips = left[0] > nothing, left[1] > nothing
    found = _balance(balls, way, parts, 0 if slips[0] else 1, abs(start), rate, top, load)
    if slips[0]:
        out[0], out[2] = way * found.speed, found.slope
    if slips[0] and slips[1]:
        other = found.at - found.left[1] / found.slope
        if abs(other - found.speed) > NEAR * found.speed:
            other = _balance(balls, way, parts, 1, max(other, 0.0), found.slope, top, load).speed
        out[1] = way * other
    elif slips[1]:
        out[1] = way * found.speed
    return 0
