"""Static charges on strips of any widths in one plane of a dielectric half-space, without waves and without a mesh.

Chebyshev polynomials over the square root of the charge at the edges, at points of collocation.  A line charge q on the
surface of a half-space of permittivity eps has the potential -q ln(r) / (pi eps).  On its own strip, |s| < 1,

    integral of T_n(t) ln|s - t| / (pi sqrt(1 - t^2)) dt = -ln 2 for n = 0, -T_n(s) / n for n > 0;

on the others Gauss-Chebyshev quadrature.
"""

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.special import jv

__all__ = ["charge_transform", "static_charges"]

POINTS = 40  # of the quadrature on another strip


def static_charges(strips, potentials, *, terms: int = 8) -> np.ndarray:
    """Return the coefficients q_n of every strip over eps, in V, shape (strips, terms).

    ``strips``: left and right edges in m, shape (strips, 2); ``potentials`` in V, up to a constant that makes the total
    charge zero.
    """
    strips = np.asarray(strips, dtype=float)
    middles, halves = strips.mean(axis=1), np.ptp(strips, axis=1) / 2
    s = np.cos((np.arange(terms) + 0.5) * np.pi / terms)
    t = np.cos((np.arange(POINTS) + 0.5) * np.pi / POINTS)
    own, shapes, orders = chebvander(s, terms - 1), chebvander(t, terms - 1), np.arange(terms)
    count = len(strips)
    system, load = np.zeros((count * terms + 1,) * 2), np.zeros(count * terms + 1)
    for row in range(count):
        lines = slice(row * terms, (row + 1) * terms)
        for column in range(count):
            if row == column:
                part = own / np.maximum(orders, 1)
                part[:, 0] = np.log(2.0) - np.log(halves[row])
            else:
                apart = abs(middles[row] + halves[row] * s[:, None] - middles[column] - halves[column] * t)
                part = -np.log(apart) @ shapes / POINTS
            system[lines, column * terms : (column + 1) * terms] = part / np.pi
        system[lines, -1] = 1.0
        system[-1, row * terms] = 1.0
        load[lines] = potentials[row]
    return np.linalg.solve(system, load)[:-1].reshape(count, terms)


def charge_transform(strips, coefficients: np.ndarray, k: float) -> complex:
    """Return the integral of the charge times exp(i k x) over all strips."""
    strips = np.asarray(strips, dtype=float)
    orders = np.arange(coefficients.shape[1])
    middles, halves = strips.mean(axis=1), np.ptp(strips, axis=1) / 2
    shapes = 1j**orders * jv(orders, k * halves[:, None])
    return complex(np.sum(coefficients * shapes * np.exp(1j * k * middles)[:, None]))
