r"""Mean forces over one cycle of the wave under rough balls whose asperities slip on their own, in steps of phase.

The approaches u_j of the asperities of a ball are cubics in the ball's approach z between the rows of a table. Asperity
j touches from z_j on, its tangential deformation x_j follows the surface in stick and is held within
|x_j| <= c (z - z_j), and it carries (Ciavarella; Jaeger)

    Q_j = mu (P_j(z) - P_j(z - |x_j|/c)) sign x_j.

A step in which it touches counts from the touch on, so that the means err by the square of the step.
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled, native


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
def _force(table, j, z):
    """Return P_j at an approach of the ball."""
    if z <= table.touch[j]:
        return 0.0
    at = (z - table.start) / table.spacing
    row = min(max(int(at), 0), table.approaches.shape[0] - 2)
    t = at - row
    low, high = table.approaches[row, j], table.approaches[row + 1, j]
    rise, fall = table.rates[row, j], table.rates[row + 1, j]
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
    u = max(low + t * (rise + t * (square + t * cubic)), 0.0)
    cap = min(u, table.merged[j])
    return table.stiffness[j] * np.sqrt(cap) * (cap + 1.5 * (u - cap))


@native("t f1 f1", {"z": "k", "out": "1"})
def mean_normal(table, z, out):
    """Write the mean of sum P_j over approaches of the ball."""
    total = 0.0
    for k in range(z.size):
        for j in range(table.touch.size):
            total += _force(table, j, z[k])
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
                force = _force(table, j, z[k]) - _force(table, j, z[k] - abs(x) / slope)
                own += force if x > 0.0 else -force
            if abs(x - before) <= repeats:
                break
        total += own
    out[0] = total / steps
    return 0
