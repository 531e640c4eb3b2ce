r"""Mean tangential force over a cycle of a contact of any normal force, with the memory of Mindlin and Deresiewicz.

Jaeger (Arch. Appl. Mech. 68 (1998) 245) and Ciavarella (J. Appl. Mech. 65 (1998) 998): where tangential displacements
of a half-space are proportional to normal ones, as Cattaneo and Mindlin take them, a contact of any shape is a
sequence of punches, and what touches first at the approach eta carries the part P'(eta) d eta of the normal force. Its
anchor y slips where |x - y| reaches c (z - eta). So for every history of approach z and displacement x

    Q = (mu/c) int P''(eta) (x - y(eta)) d eta,        |x - y(eta)| <= c (z - eta)                                 (1)

(the memory diagrams of Aleshin, Bou Matar and Van Den Abeele, Int. J. Solids Struct. 60-61 (2015) 1). For P of Hertz it
is `law.hysteretic`. It holds for asperities that interact, of one sample or of a mean field: those that touch first
share the displacement of all, and draw each other along as they push each other down.

On a wave z = h + A cos theta, x = c A (b cos(theta + phi) - w theta), all of it depends on the depth e = (h - eta)/A
alone: in units of c A the anchor lies between the walls

    x - cos theta - e <= y <= x + cos theta + e,

and is moved by the one that meets it. A wall sigma (+1: the lower one) moves towards the anchor, so that the anchor can
slip, where

    sigma x' - (cos theta)' = r sin(theta + psi) - sigma w > 0,      r exp(i psi) = 1 - sigma b exp(i phi),          (2)

once in a cycle, and at the same angles at every depth. From (1), by parts,

    <Q> = -mu int P'(eta) <dy/de> d eta,                                                                           (3)

where dy/de is +1 after the upper wall has moved the anchor, -1 after the lower one, and x'/(cos theta)' of the first
touch before that. So the mean needs the angles at which a wall meets the anchor, and no steps of time.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.two_levels import Heavy, balanced_speeds
from contact.jit.compiled import compiled, formula, native
from contact.law.force_table import ForceTable, force_and_rate_at, force_at

NEWTON = 50  # steps at most of the search for an angle, most of which take 3 or 4
# rad: last step of that search, whose error is about its square. Energies err by that, a mean force by its square
ANGLE, ANGLE_OF_WORK = 1e-4, 1e-9
HEIGHT = 1e-10  # of a mean approach over its range
FAR_AWAY = 10.0 * math.pi, 10.0 * math.pi  # angles that a search for a meeting does not start from
APART, SECANTS, EVEN = 1e-6, 12, 1e-14  # relative step, steps, and force over the friction of a ball of a last search


class Path(NamedTuple):
    """Motion of the surface past one ball in the units of the text, and where the walls can move the anchors."""

    normal: float  # A, m
    along: float  # b cos phi
    behind: float  # b sin phi
    drift: float  # w, not negative
    # where (2) is positive, for the lower and the upper wall; never if the stop is before the start
    start: tuple[float, float]
    stop: tuple[float, float]


@compiled
def _displacement(path, theta):
    """Return x."""
    return path.along * np.cos(theta) - path.behind * np.sin(theta) - path.drift * theta


@compiled
def _sum_of_displacements(path, low, high):
    """Return the integral of x over an interval."""
    sines, cosines = np.sin(high) - np.sin(low), np.cos(high) - np.cos(low)
    return path.along * sines + path.behind * cosines - 0.5 * path.drift * (high - low) * (high + low)


@compiled
def _meeting(path, e, wall, y, low, high, near, close):
    """Return the angle between two at which a wall meets the anchor; `high` + 1 if it does not.

    Newton's method starts from `near` if that is between them, and ends with a step of `close`.
    """
    sign = 1.0 - 2.0 * wall
    if e + np.cos(high) - sign * (_displacement(path, high) - y) >= 0.0:
        return high + 1.0
    a, b = low, high
    theta = near if low < near < high else 0.5 * (low + high)
    for _ in range(NEWTON):
        cosine, sine = np.cos(theta), np.sin(theta)
        gap = e + cosine - sign * (path.along * cosine - path.behind * sine - path.drift * theta - y)
        if gap >= 0.0:
            a = theta
        else:
            b = theta
        closing = sine + sign * (-path.along * sine - path.behind * cosine - path.drift)
        new = theta + gap / closing if closing > 0.0 else a
        if abs(new - theta) <= close:
            return min(max(new, a), b)
        if not a < new < b:
            new = 0.5 * (a + b)
        theta = new
    return theta


@compiled
def _slipping(path, wall, theta):
    """Return the first interval after an angle, or about it, in which a wall moves towards the anchor."""
    turn = 2.0 * math.pi
    shift = turn * math.floor((theta - path.stop[wall]) / turn + 1.0)
    return path.start[wall] + shift, path.stop[wall] + shift


@compiled
def _next_slip(path, e, y, theta, end, near, close):
    """Return (wall, start, stop) of the next slip of an anchor that sticks at an angle; wall -1 if there is none."""
    mover, first, last = -1, end, end
    for wall in range(2):
        if path.stop[wall] > path.start[wall]:
            low, high = _slipping(path, wall, theta)
            while low < first:
                stop = min(high, end)
                at = _meeting(path, e, wall, y, max(low, theta), stop, near[wall], close)
                if at <= stop:
                    if at < first:
                        mover, first, last = wall, at, stop
                    break
                low, high = low + 2.0 * math.pi, high + 2.0 * math.pi
    return mover, first, last


class Walk(NamedTuple):
    """Where the walk of an anchor through a cycle has come to."""

    theta: float  # angle
    end: float  # angle at which the cycle of this depth ends
    mover: int  # wall that moves the anchor from here on, -1: it sticks
    stop: float  # angle at which that wall ceases to
    anchor: float  # y


class Piece(NamedTuple):
    """A part of the cycle in which an anchor sticks, or is moved by one wall."""

    start: float
    stop: float
    sign: float  # of x - y in slip: 1 by the lower wall, -1 by the upper one; 0 in stick
    anchor: float  # y in stick


@compiled
def first_walk(path, e):
    """Return where the walk of the anchor at a depth e > -1 begins."""
    if e < 1.0:
        end = math.acos(-e)
        theta = -end
        y = _displacement(path, theta)
        rate = (path.along * np.sin(theta) + path.behind * np.cos(theta) + path.drift) / np.sin(end)  # -x'/(cos theta)'
        mover, stop = -1, end
        if abs(rate) > 1.0:
            mover = 1 if rate > 0.0 else 0
            stop = min(_slipping(path, mover, theta)[1], end)
        return Walk(theta, end, mover, stop, y)
    # where the upper wall, which drifts downwards, ends to move the anchor
    theta = path.stop[1]
    return Walk(theta, theta + 2.0 * math.pi, -1, 0.0, _displacement(path, theta) + e + np.cos(theta))


@compiled
def next_piece(path, e, walk, near, met, close):
    """Return the piece of the cycle that begins where a walk has come to, where it then is, and the angles `met`."""
    theta, end, mover, stop, y = walk
    if mover < 0:
        mover, start, stop = _next_slip(path, e, y, theta, end, near, close)
        if mover == 0:
            met = start, met[1]
        elif mover == 1:
            met = met[0], start
        return Piece(theta, start, 0.0, y), Walk(start, end, mover, stop, y), met
    sign = 1.0 - 2.0 * mover
    y = _displacement(path, stop) - sign * (e + np.cos(stop))
    return Piece(theta, stop, sign, 0.0), Walk(stop, end, -1, stop, y), met


@compiled
def mean_deformation(path, e, near):
    """Return the mean of x - y at a depth e > -1 over a cycle that repeats, zero while it does not touch.

    Also the angles at which each wall met the anchor first; `near` are those of a depth nearby.
    """
    walk, total, met = first_walk(path, e), 0.0, near
    while walk.theta < walk.end:
        piece, walk, met = next_piece(path, e, walk, near, met, ANGLE)
        start, stop, sign, y = piece
        if sign == 0.0:
            total += _sum_of_displacements(path, start, stop) - y * (stop - start)
        else:
            total += sign * (e * (stop - start) + np.sin(stop) - np.sin(start))
    return total / (2.0 * math.pi), met


@compiled
def mean_works(path, e, near):
    """Return the means of two powers at a depth e > -1 as `mean_deformation` does, and the angles met.

    They are (x - y) u' of the surface's motion u, and (x - y) y' of slip, in (c A)^2 times the angular frequency.
    """
    walk, work, slip, met = first_walk(path, e), 0.0, 0.0, near
    while walk.theta < walk.end:
        piece, walk, met = next_piece(path, e, walk, near, met, ANGLE_OF_WORK)
        start, stop, sign, y = piece
        before, after = _displacement(path, start), _displacement(path, stop)
        first, last = before + path.drift * start, after + path.drift * stop  # u
        if sign == 0.0:
            sums = _sum_of_displacements(path, start, stop)
            # int x u' = int x x' + w int x
            work += 0.5 * (after**2 - before**2) + path.drift * sums - y * (last - first)
        else:
            sines, cosines = np.sin(stop) - np.sin(start), np.cos(stop) - np.cos(start)
            squares = 0.5 * (np.sin(stop) ** 2 - np.sin(start) ** 2)
            products = 0.5 * (stop - start + np.sin(stop) * np.cos(stop) - np.sin(start) * np.cos(start))
            done = sign * (e * (last - first) - path.along * squares - path.behind * products)
            work += done
            slip += done - sign * path.drift * (e * (stop - start) + sines) - e * cosines + squares
    return work / (2.0 * math.pi), slip / (2.0 * math.pi), met


@compiled
def _interval(along, behind, drift, sign):
    """Return (start, stop) of the angles at which (2) is positive; stop is before the start if it never is."""
    real, imaginary = 1.0 - sign * along, -sign * behind
    size, turn, level = math.hypot(real, imaginary), math.atan2(imaginary, real), sign * drift
    if level >= size:
        return 0.0, -1.0
    if level <= -size:
        return -math.pi, math.pi
    first = math.asin(level / size)
    return first - turn, math.pi - first - turn


@compiled
def _last_depth(path, deepest):
    """Return the depth below which the lower wall does not reach what the upper one has left, at most `deepest`."""
    last = 1.0
    if path.stop[0] > path.start[0]:
        left = path.stop[1]
        top = _slipping(path, 0, left)[1]
        gap = _displacement(path, top) - math.cos(top) - _displacement(path, left) - math.cos(left)
        last = max(last, 0.5 * gap)
    return min(last, deepest)


@formula
def _depth(last, cell, cells):
    """Return the depth at the end of a cell: they are finer near the crest, where layers hardly touch."""
    return (last + 1.0) * (cell / cells) ** 1.5 - 1.0


class Balls(NamedTuple):
    """Balls of two tables of forces, at mean approaches of each, and their waves."""

    coarse: ForceTable
    fine: ForceTable
    which: np.ndarray  # (n,) int: the balls' contacts in the tables
    waves: np.ndarray  # (n, 3): as in `path_of`
    heights: np.ndarray  # (2, n): mean approaches by the coarse and by the fine table, m
    heavy: Heavy
    net_force: Callable  # of `two_levels`


@compiled
def mean_memory(balls, ball, path, cells):
    """Return <Q>/mu of a ball by the fine table and by the coarse one.

    x - y is a straight line over each of so many cells of depth; of the coarse table over every two of them.
    """
    k, A, low, high = balls.which[ball], path.normal, balls.heights[0, ball], balls.heights[1, ball]
    last = _last_depth(path, max(low - balls.coarse.start[k], high - balls.fine.start[k]) / A)
    total, above, before, shallow = 0.0, force_at(balls.fine, k, high + A), 0.0, -1.0
    total_2, above_2, before_2, shallow_2 = 0.0, force_at(balls.coarse, k, low + A), 0.0, -1.0
    near = met = FAR_AWAY
    if last > -1.0:
        for cell in range(1, cells + 1):
            e = _depth(last, cell, cells)
            deformation, new = mean_deformation(path, e, near)
            # the angles of the next depth, on a straight line
            on = (_depth(last, cell + 1, cells) - e) / (e - shallow)
            near = new[0] + on * (new[0] - met[0]), new[1] + on * (new[1] - met[1])
            met = new
            below = force_at(balls.fine, k, high - A * e)
            total += (above - below) * (deformation - before) / (e - shallow)
            above, before, shallow = below, deformation, e
            if cell % 2 == 0:
                below = force_at(balls.coarse, k, low - A * e)
                total_2 += (above_2 - below) * (deformation - before_2) / (e - shallow_2)
                above_2, before_2, shallow_2 = below, deformation, e
    return total - above, total_2 - above_2  # what is deeper is moved by the upper wall alone, once in a cycle


@compiled
def memory_works(table, k, height, path, cells):
    """Return the work of the surface and the loss by slip as `mean_memory` does the force.

    They are means over mu, c A and the angular frequency, N.
    """
    A, deepest = path.normal, (height - table.start[k]) / path.normal
    last = _last_depth(path, deepest)
    work = slip = work_before = slip_before = 0.0
    above, shallow, near = force_at(table, k, height + A), -1.0, FAR_AWAY
    if last > -1.0:
        for cell in range(1, cells + 1):
            e = _depth(last, cell, cells)
            worked, slipped, near = mean_works(path, e, near)
            below = force_at(table, k, height - A * e)
            share = (above - below) / (e - shallow)
            work += share * (worked - work_before)
            slip += share * (slipped - slip_before)
            above, work_before, slip_before, shallow = below, worked, slipped, e
    return work, slip + above * path.drift  # what is deeper slips by the drift in each cycle, and takes no work


@compiled
def path_of(motion, heavy, way, v):
    """Return the path past a ball at a speed v >= 0 in the direction `way`.

    `motion`: A, and the parts of u_x along u_z and a quarter of a cycle before it, m.
    """
    A = motion[0]
    unit = heavy.limit_slope * A
    along, behind, drift = way * motion[1] / unit, way * motion[2] / unit, v / (heavy.omega * unit)
    lower, upper = _interval(along, behind, drift, 1.0), _interval(along, behind, drift, -1.0)
    return Path(A, along, behind, drift, (lower[0], upper[0]), (lower[1], upper[1]))


@compiled
def net_force(balls, way, v, cells):
    """Return the mean forces of friction and damper along the motion at a speed v >= 0 in the direction `way`."""
    heavy, fine, coarse = balls.heavy, 0.0, 0.0
    for ball in range(balls.which.size):
        path = path_of(balls.waves[ball], heavy, way, v)
        of_fine, of_coarse = mean_memory(balls, ball, path, cells)
        fine += of_fine
        coarse += of_coarse
    held = heavy.damping * v
    return heavy.friction * fine - held, heavy.friction * coarse - held


@native("t i1 f2 t i f2 f1", {"which": "n", "waves": "n 3", "heights": "2 n", "out": "3"})
def memory_powers(table, which, waves, heavy, cells, heights, out):
    """Write the velocity to rounding, the power of the surface's motion along x and that of slip, W; return nothing.

    ``out[0]`` holds the velocity of `memory_motion` with as many cells, which is not 0, `heights` its mean approaches,
    twice, and `heavy` the load against this motion.
    """
    way, v, load = np.sign(out[0]), abs(out[0]), heavy.load
    balls = Balls(table, table, which, waves, heights, heavy, net_force)
    left = net_force(balls, way, v, cells)[0] - load
    a, fa, b = v, left, v * (1.0 + APART)
    for _ in range(SECANTS):
        fb = net_force(balls, way, b, cells)[0] - load
        if abs(fb) <= EVEN * heavy.friction * heavy.share or fa == fb:
            break
        a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
    work = slip = 0.0
    for ball in range(which.size):
        path = path_of(waves[ball], heavy, way, b)
        worked, slipped = memory_works(table, which[ball], heights[1, ball], path, cells)
        unit = heavy.friction * heavy.limit_slope * heavy.omega * path.normal
        work += unit * worked
        slip += unit * slipped
    out[0], out[1], out[2] = way * b, work, slip
    return 0


@compiled
def _mean_force(table, k, height, normal, steps):
    """Return the mean normal force of ball k and its derivative in the height, by the trapezoidal rule."""
    force, rate = 0.0, 0.0
    turn, sine = math.cos(math.pi / steps), math.sin(math.pi / steps)
    c, s = 1.0, 0.0
    for step in range(steps + 1):
        weight = 0.5 if step == 0 or step == steps else 1.0
        of_force, of_rate = force_and_rate_at(table, k, height + normal * c)
        force += weight * of_force
        rate += weight * of_rate
        c, s = c * turn - s * sine, s * turn + c * sine
    return force / steps, rate / steps


@compiled
def mean_height(table, k, normal, share, steps, near):
    """Return the mean approach at which the mean force of ball k is its share of the preload; Newton from `near`."""
    a, b = table.start[k] - normal, table.start[k] + (table.force.shape[1] - 1) * table.spacing[k] - normal
    tolerance, height = HEIGHT * (b - a), min(max(near, a), b)
    for _ in range(100):
        force, rate = _mean_force(table, k, height, normal, steps)
        if force > share:
            b = height
        else:
            a = height
        new = height - (force - share) / rate if rate > 0.0 else b
        if not a <= new <= b:
            new = 0.5 * (a + b)
        step, height = new - height, new
        if abs(step) <= tolerance:
            break
    return height


@compiled
def rest_approach(table, k, share):
    """Return the approach of the first row at which ball k carries a force."""
    low, high = 0, table.force.shape[1] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table.force[k, middle] < share:
            low = middle
        else:
            high = middle
    return table.start[k] + high * table.spacing[k]


@native("t t i1 f2 t i f2 f1", {"which": "n", "waves": "n 3", "heights": "2 n", "out": "4"})
def memory_motion(coarse, fine, which, waves, heavy, cells, heights, out):
    """Write the mean approaches of balls and the slider's velocity by two tables of forces; return nothing.

    `which` are the balls' contacts in the tables, `waves` their motions as in `path_of`, and ``cells`` an even number
    of cells of depth for the fine table; the coarse one has half of them, and half of the steps of phase for heights.
    ``out`` are the velocities by the fine and the coarse table, the slope of the force that is left, and the load
    against the motion. At first it holds a velocity from which the search starts, and the slope there, or zeros.
    """
    balls, top = Balls(coarse, fine, which, waves, heights, heavy, net_force), 0.0
    for ball in range(which.size):
        k, A = which[ball], waves[ball, 0]
        near = rest_approach(coarse, k, heavy.share)
        heights[0, ball] = near = mean_height(coarse, k, A, heavy.share, cells, near)
        heights[1, ball] = mean_height(fine, k, A, heavy.share, 2 * cells, near)
        along = math.hypot(waves[ball, 1], waves[ball, 2])
        # from this speed on every layer slips backwards all the time
        top = max(top, heavy.omega * (along + heavy.limit_slope * A))
    return balanced_speeds(balls, cells, top, out)
