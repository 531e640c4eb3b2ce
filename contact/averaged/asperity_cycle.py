r"""Mean forces over one cycle of the wave under rough balls whose asperities slip on their own, in steps of phase.

The approaches u_j of the asperities of a ball are cubics in the ball's approach z between the rows of a table. Asperity
j touches from z_j on, its tangential deformation x_j follows the surface in stick and is held within
|x_j| <= c (z - z_j), and it carries (Ciavarella; Jaeger)

    Q_j = mu (P_j(z) - P_j(z - |x_j|/c)) sign x_j.

A step in which it touches counts from the touch on, so that the means err by the square of the step.

The powers of a cycle are integrals between events. The stop of asperity j is the anchor of `memory_cycle` at the depth
e_j = (h - z_j)/A, so that the walk of that module gives its events. With the energy of the spring at constant z,
U_j = mu int (P_j(z) - P_j(z - x/c)) dx, the surface's work is

    Q u' = Q v + mu P_j (s x' - c z') in slip - dU_j/dz z' + dU_j/dt:                                               (1)

travel, loss by slip, the leak of this law, which has no potential, and what comes back within the cycle.
"""

import math
from typing import NamedTuple

import numpy as np

from contact.averaged.memory_cycle import first_walk, next_piece, path_of
from contact.jit.compiled import compiled, native

PANELS = 64  # of Gauss's rule in a cycle, besides the cuts where a table goes on with another cubic
LOOKED = 4  # places within a panel at which a cut is looked for
CUT = 1e-14  # rad: error of a cut
POINT, WEIGHT = (tuple(map(float, each)) for each in np.polynomial.legendre.leggauss(8))
NO_ANGLES = 10.0 * math.pi, 10.0 * math.pi


class Table(NamedTuple):
    """Approaches of the asperities of one ball at equally spaced approaches of the ball."""

    approaches: np.ndarray  # u_j in m, shape (rows, n)
    rates: np.ndarray  # du_j/dz times the spacing of the rows, m, shape (rows, n)
    touch: np.ndarray  # z_j, m, shape (n,)
    stiffness: np.ndarray  # N/m^1.5, shape (n,)
    merged: np.ndarray  # approach from which on an asperity is a punch, m, shape (n,)
    start: float  # approach of the first row, m
    spacing: float  # of the rows, m


@compiled
def _row(table, z):
    """Return the row of the table at an approach of the ball, and the place behind it."""
    at = (z - table.start) / table.spacing
    row = min(max(int(at), 0), table.approaches.shape[0] - 2)
    return row, at - row


@compiled
def _force(table, j, z):
    """Return P_j at an approach of the ball, and its derivative."""
    if z <= table.touch[j]:
        return 0.0, 0.0
    row, t = _row(table, z)
    low, high = table.approaches[row, j], table.approaches[row + 1, j]
    rise, fall = table.rates[row, j], table.rates[row + 1, j]
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
    u = max(low + t * (rise + t * (square + t * cubic)), 0.0)
    cap = min(u, table.merged[j])
    root = table.stiffness[j] * np.sqrt(cap)
    rate = rise + t * (2.0 * square + 3.0 * t * cubic)
    return root * (cap + 1.5 * (u - cap)), 1.5 * root * rate / table.spacing


@native("t f1 f1", {"z": "k", "out": "1"})
def mean_normal(table, z, out):
    """Write the mean of sum P_j over approaches of the ball."""
    total = 0.0
    for k in range(z.size):
        for j in range(table.touch.size):
            total += _force(table, j, z[k])[0]
    out[0] = total / z.size
    return 0


@native("t f1 f1 f f f1", {"z": "k", "moved": "k", "out": "1"})
def mean_pull(table, z, moved, slope, repeats, out):
    """Write the mean of sum Q_j/mu over a periodic cycle.

    ``moved[k]`` is the surface's motion less the slider's from step k - 1 to k, m; ``slope`` is c. The deformations
    are followed until they repeat to ``repeats`` in m, 24 cycles at most.
    """
    steps, total = z.size, 0.0
    for j in range(table.touch.size):
        x, own = 0.0, 0.0
        for _ in range(24):
            before, own = x, 0.0
            for k in range(steps):
                above, below = z[k] - table.touch[j], z[k - 1] - table.touch[j]
                if above <= 0.0:
                    x = 0.0
                    continue
                share = 1.0 if below >= 0.0 else above / (above - below)
                limit = slope * above
                x = min(max(x + share * moved[k], -limit), limit)
                force = _force(table, j, z[k])[0] - _force(table, j, z[k] - abs(x) / slope)[0]
                own += force if x > 0.0 else -force
            if abs(x - before) <= repeats:
                break
        total += own
    out[0] = total / steps
    return 0


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
    return (_row(table, z)[0] * rows + _row(table, below)[0]) * 8 + signs


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
def _add_piece(table, j, path, c, height, piece, cut, sums):
    """Add the integrals of Q/mu and of the three powers of (1) over mu and the angular frequency, over a piece."""
    length = piece.stop - piece.start
    panels = math.ceil(length / (2.0 * math.pi) * PANELS) + 1
    low, panel = piece.start, 1
    while panel <= panels:
        end = piece.start + length * panel / panels
        high = end
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


@native("t f1 t f f i f1", {"motion": "3", "sums": "4"})
def asperity_powers(table, motion, heavy, height, v, cut, sums):
    """Write the means of sum Q/mu in N, and over mu the powers of the surface, of slip and of the leak in W.

    ``motion``: as in `memory_cycle.path_of`; ``v``: not 0; ``cut``: 1 for integrals to rounding, 0 for those to 1e-7.
    """
    path = path_of(motion, heavy, np.sign(v), abs(v))
    sums[:] = 0.0
    for j in range(table.touch.size):
        e = (height - table.touch[j]) / path.normal
        if e > -1.0:
            walk, met = first_walk(path, e), NO_ANGLES
            while walk.theta < walk.end:
                piece, walk, met = next_piece(path, e, walk, met, met)
                _add_piece(table, j, path, heavy.limit_slope, height, piece, cut == 1, sums)
    for k in range(4):
        sums[k] /= 2.0 * math.pi
    for k in range(1, 4):
        sums[k] *= heavy.omega
    sums[0] *= np.sign(v)
    return 0
