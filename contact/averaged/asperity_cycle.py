r"""Mean forces over one cycle of the wave under rough balls whose asperities slip on their own, between exact events.

The approaches u_j of the asperities of a ball are cubics in the ball's approach z between the rows of a table. Asperity
j touches from z_j on, its tangential deformation x_j follows the surface in stick and is held within
|x_j| <= c (z - z_j), and it carries (Ciavarella; Jaeger)

    Q_j = mu (P_j(z) - P_j(z - |x_j|/c)) sign x_j.

The means of a cycle are integrals between events. The stop of asperity j is the anchor of `memory_cycle` at the depth
e_j = (h - z_j)/A, so that the walk of that module gives its events. With the energy of the spring at constant z,
U_j = mu int (P_j(z) - P_j(z - x/c)) dx, the surface's work is

    Q u' = Q v + mu P_j (s x' - c z') in slip - dU_j/dz z' + dU_j/dt:                                               (1)

travel, loss by slip, the leak of this law, which has no potential, and what comes back within the cycle.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.memory_cycle import ANGLE_OF_WORK, first_walk, mean_height, next_piece, path_of, rest_approach
from contact.averaged.two_levels import Heavy, balanced_speeds
from contact.jit.compiled import compiled, native

PANELS_OF_WORK = (
    64  # of Gauss's rule in a cycle, of energies; besides the cuts where a table goes on with another cubic
)
CENTRED = 4  # secants to where a deformation passes zero, in a panel of it
LOOKED = 4  # places within a panel at which a cut is looked for
CUT = 1e-14  # rad: error of a cut
POINT, WEIGHT = (tuple(map(float, each)) for each in np.polynomial.legendre.leggauss(8))
NO_ANGLES = 10.0 * math.pi, 10.0 * math.pi


class Table(NamedTuple):
    """Approaches of the asperities of balls at equally spaced approaches of each ball."""

    approaches: np.ndarray  # u_j in m, shape (rows, n)
    rates: np.ndarray  # du_j/dz times the spacing of the rows, m, shape (rows, n)
    touch: np.ndarray  # z_j, m, shape (n,)
    stiffness: np.ndarray  # N/m^1.5, shape (n,)
    merged: np.ndarray  # approach from which on an asperity is a punch, m, shape (n,)
    ball: np.ndarray  # number of its ball, shape (n,)
    start: np.ndarray  # approach of the first row of each ball, m, shape (balls,)
    spacing: np.ndarray  # of the rows of each ball, m, shape (balls,)
    rows: np.ndarray  # number of rows of each ball, shape (balls,)


@compiled
def _row(table, j, z):
    """Return the row of the table at an approach of the ball of asperity j, and the place behind it."""
    ball = table.ball[j]
    at = (z - table.start[ball]) / table.spacing[ball]
    row = min(max(int(at), 0), table.rows[ball] - 2)
    return row, at - row


@compiled
def _force(table, j, z):
    """Return P_j at an approach of the ball, and its derivative."""
    if z <= table.touch[j]:
        return 0.0, 0.0
    row, t = _row(table, j, z)
    low, high = table.approaches[row, j], table.approaches[row + 1, j]
    rise, fall = table.rates[row, j], table.rates[row + 1, j]
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
    u = max(low + t * (rise + t * (square + t * cubic)), 0.0)
    cap = min(u, table.merged[j])
    root = table.stiffness[j] * np.sqrt(cap)
    rate = rise + t * (2.0 * square + 3.0 * t * cubic)
    return root * (cap + 1.5 * (u - cap)), 1.5 * root * rate / table.spacing[table.ball[j]]


@compiled
def _place(path, c, height, touch, piece, theta):
    """Return (approach z, deformation x, z - |x|/c) at an angle, in m."""
    cosine, z = np.cos(theta), height + path.normal * np.cos(theta)
    if piece.sign != 0.0:
        return z, piece.sign * c * (z - touch), touch
    behind = path.along * cosine - path.behind * np.sin(theta) - path.drift * theta
    x = c * path.normal * (behind - piece.anchor)
    return z, x, z - abs(x) / c


@compiled
def _cubics(table, j, path, c, height, piece, theta):
    """Return a number that changes where Q goes on as another function, of a table's other cubic for instance."""
    z, x, below = _place(path, c, height, table.touch[j], piece, theta)
    rows = table.approaches.shape[0]
    signs = (x > 0.0) + 2 * (_force(table, j, z)[0] > 0.0) + 4 * (_force(table, j, below)[0] > 0.0)
    return (_row(table, j, z)[0] * rows + _row(table, j, below)[0]) * 8 + signs


@compiled
def _add_panel(table, j, path, c, height, piece, low, high, sums):
    """Add the integrals of `_add_piece` over a part of a piece."""
    A, touch = path.normal, table.touch[j]
    for k in range(len(POINT)):
        # takes the fractional powers at both ends out
        s = 0.5 * (1.0 + POINT[k])
        theta, weight = low + (high - low) * s * s * (3.0 - 2.0 * s), 3.0 * (high - low) * s * (1.0 - s) * WEIGHT[k]
        z, x, under = _place(path, c, height, touch, piece, theta)
        sine = np.sin(theta)
        z_rate, u_rate = -A * sine, -c * A * (path.along * sine + path.behind * np.cos(theta))
        force, rise = _force(table, j, z)
        below = _force(table, j, under)[0]
        pull = force - below if x > 0.0 else below - force
        sums[0] += weight * pull
        sums[1] += weight * pull * u_rate
        if piece.sign != 0.0:
            sums[2] += weight * force * (piece.sign * (u_rate - c * A * path.drift) - c * z_rate)
        sums[3] -= weight * (rise * abs(x) - c * (force - below)) * z_rate


@compiled
def _centred(path, c, height, touch, piece, low, high, before, after):
    """Return the angle between two at which x passes zero, from `before` to `after`, in stick."""
    middle = high
    for _ in range(CENTRED):
        middle = low + (high - low) * before / (before - after)
        x = _place(path, c, height, touch, piece, middle)[1]
        if x * before > 0.0:
            low, before = middle, x
        else:
            high, after = middle, x
        if x == 0.0:
            break
    return middle


@compiled
def _add_piece(table, j, path, c, height, piece, number, cut, sums):
    """Add the integrals of Q/mu and of the three powers of (1) over mu and the angular frequency, over a piece.

    ``number``: of panels in a cycle; ``cut``: whether they are cut where Q goes on as another function.
    """
    length = piece.stop - piece.start
    panels = math.ceil(length / (2.0 * math.pi) * number) + 1
    low, panel = piece.start, 1
    before = _place(path, c, height, table.touch[j], piece, low)[1]
    while panel <= panels:
        end = piece.start + length * panel / panels
        high = end
        if not cut and piece.sign == 0.0:
            after = _place(path, c, height, table.touch[j], piece, end)[1]
            if before * after < 0.0:
                high = _centred(path, c, height, table.touch[j], piece, low, end, before, after)
            before = after
        if cut:
            here = _cubics(table, j, path, c, height, piece, low + CUT)
            inside = low
            for look in range(1, LOOKED + 1):
                seen = min(low + (end - low) * look / LOOKED, end - CUT)
                if _cubics(table, j, path, c, height, piece, seen) != here:
                    high = seen
                    break
                inside = seen
            while high < end and high - inside > CUT:
                middle = 0.5 * (inside + high)
                if _cubics(table, j, path, c, height, piece, middle) == here:
                    inside = middle
                else:
                    high = middle
        _add_panel(table, j, path, c, height, piece, low, high, sums)
        low = high
        if end - high <= 2.0 * CUT:
            low, panel = end, panel + 1


@compiled
def _add_stops(table, waves, heavy, heights, way, v, number, cut, sums):
    """Write the integrals of `_add_piece` over a cycle, of all asperities; those of powers in m of the surface."""
    sums[:] = 0.0
    for j in range(table.touch.size):
        ball = table.ball[j]
        path = path_of(waves[ball], heavy, way, v)
        e = (heights[ball] - table.touch[j]) / path.normal
        if e > -1.0:
            walk, met = first_walk(path, e), NO_ANGLES
            while walk.theta < walk.end:
                piece, walk, met = next_piece(path, e, walk, met, met, ANGLE_OF_WORK)
                _add_piece(table, j, path, heavy.limit_slope, heights[ball], piece, number, cut, sums)


class StopBalls(NamedTuple):
    """Balls whose asperities have a stop each, of two tables; see `two_levels`."""

    coarse: Table
    fine: Table
    waves: np.ndarray  # (n, 3): as in `memory_cycle.path_of`
    heights: np.ndarray  # (2, n): mean approaches by the coarse and by the fine table, m
    heavy: Heavy
    sums: np.ndarray  # (4,) for the integrals
    net_force: Callable


@compiled
def _left(balls, way, v, panels):
    """Return the mean forces of friction and damper along the motion at a speed v >= 0 in the direction `way`.

    By the fine table and so many panels in a cycle, and by the coarse one and half of them.
    """
    heavy, sums = balls.heavy, balls.sums
    held = heavy.damping * v
    _add_stops(balls.fine, balls.waves, heavy, balls.heights[1], way, v, panels, False, sums)
    fine = sums[0]
    _add_stops(balls.coarse, balls.waves, heavy, balls.heights[0], way, v, panels // 2, False, sums)
    unit = heavy.friction / (2.0 * math.pi)
    return unit * fine - held, unit * sums[0] - held


@native("t t t t i1 f2 t i f2 f1 f1", {"which": "n", "waves": "n 3", "heights": "2 n", "sums": "4", "out": "4"})
def stops_motion(coarse_force, fine_force, coarse, fine, which, waves, heavy, panels, heights, sums, out):
    """Write the mean approaches of balls and the slider's velocity, by coarse and fine tables, as `memory_motion` does.

    `which` are the balls' contacts in the tables of forces; ``panels`` of a cycle for the fine tables. Mean approaches
    take four steps of phase for each.
    """
    balls, top = StopBalls(coarse, fine, waves, heights, heavy, sums, _left), 0.0
    for ball in range(which.size):
        k, A = which[ball], waves[ball, 0]
        near = rest_approach(coarse_force, k, heavy.share)
        heights[0, ball] = near = mean_height(coarse_force, k, A, heavy.share, 2 * panels, near)
        heights[1, ball] = mean_height(fine_force, k, A, heavy.share, 4 * panels, near)
        along = math.hypot(waves[ball, 1], waves[ball, 2])
        # at this speed every asperity slips backwards all the time
        top = max(top, heavy.omega * (along + heavy.limit_slope * A))
    return balanced_speeds(balls, panels, top, out)


@native("t f2 t f1 f f i f1", {"waves": "n 3", "heights": "n", "sums": "4"})
def asperity_powers(table, waves, heavy, heights, way, v, cut, sums):
    """Write the mean of sum Q/mu along the motion, N, and over mu the powers of the surface, slip and leak, W.

    ``waves``: as in `memory_cycle.path_of`; ``v``: speed in the direction ``way``; ``cut``: 1 for integrals to
    rounding, 0 for those to 1e-7.
    """
    _add_stops(table, waves, heavy, heights, way, v, PANELS_OF_WORK, cut == 1, sums)
    for k in range(4):
        sums[k] /= 2.0 * math.pi
    for k in range(1, 4):
        sums[k] *= heavy.omega
    return 0
