r"""Spectral nodes on one smooth segment of motion, and the matrices that integrate along it.

A segment [t0, t0 + L] runs between two events; t = t0 + L tau. At contact and release (z^1.5), and where stick ends
((1 - x/x_max)^1.5), the forces have a square root. A quadratic map makes it a polynomial: tau = s^2 if the segment
starts at such an event, tau = 1 - (1 - s)^2 if it ends at one, tau = s if neither. In sigma = 2 s - 1 on [-1, 1]
everything is then smooth, and interpolation at Chebyshev-Lobatto nodes in sigma is spectral.
Clenshaw and Curtis, Numer. Math. 2 (1960) 197; the iteration that uses the matrices is Picard's (Clenshaw and Norton,
Computer J. 6 (1963) 88).
"""

from functools import cache
from typing import NamedTuple

import numpy as np

# the three maps: smooth ends, root at the start, root at the end
SMOOTH, ROOT_AT_START, ROOT_AT_END = 0, 1, 2


class Collocation(NamedTuple):
    """Nodes and matrices of one order; every array is read-only, first axis the map where there are three."""

    sigma: np.ndarray  # (n,): Chebyshev-Lobatto points, rising from -1 to 1
    bary: np.ndarray  # (n,): barycentric weights in sigma
    tau: np.ndarray  # (3, n): fraction of the segment at each node, 0 to 1
    # (3, 2, n, n): [map, which, k, j]: weight of f_k in int_0^tau_j f dtau (which = 0) and in the double integral
    # int_0^tau_j (tau_j - tau) f dtau (which = 1); kernels add up along the last axis
    integrals: np.ndarray
    rates: np.ndarray  # (n, n): derivatives in sigma at the nodes
    tail: np.ndarray  # (2, n): rows that return the two highest Chebyshev coefficients: the truncation gauge


@cache
def collocation(nodes: int) -> Collocation:
    """Return the collocation of `nodes` points (at least 4)."""
    n = nodes - 1
    k = np.arange(nodes)
    angle = np.pi * k[::-1] / n
    sigma = np.cos(angle)
    sigma[0], sigma[-1] = -1.0, 1.0
    bary = (-1.0) ** k
    bary[[0, -1]] *= 0.5
    # values -> Chebyshev coefficients (discrete cosine transform as a matrix)
    half = np.ones(nodes)
    half[[0, -1]] = 0.5
    analysis = (2.0 / n) * half[:, None] * np.cos(np.outer(k, angle)) * half[None, :]
    # Gauss-Legendre on [-1, sigma_j]: exact for these polynomials
    point, weight = np.polynomial.legendre.leggauss(nodes + 4)
    at = -1.0 + 0.5 * (sigma[:, None] + 1.0) * (point + 1.0)
    area = 0.5 * (sigma[:, None] + 1.0) * weight
    chebyshev = np.cos(k[:, None, None] * np.arccos(at))
    taus, integrals = [], []
    for fraction, rate in (
        (lambda s: s, lambda s: 0.5 + 0.0 * s),
        (lambda s: s**2, lambda s: s),
        (lambda s: 1.0 - (1.0 - s) ** 2, lambda s: 1.0 - s),
    ):
        tau, tau_at, slope = fraction(0.5 * (sigma + 1.0)), fraction(0.5 * (at + 1.0)), rate(0.5 * (at + 1.0))
        taus.append(tau)
        # Cauchy's formula for repeated integration
        weights = area * slope, area * slope * (tau[:, None] - tau_at)
        integrals.append([(np.einsum("jq,kjq->jk", each, chebyshev) @ analysis).T for each in weights])
    gap = sigma[:, None] - sigma + np.eye(nodes)
    rates = bary[None, :] / bary[:, None] / gap
    rates -= np.diag(rates.sum(axis=1))  # a constant has no slope
    table = Collocation(sigma, bary, np.array(taus), np.array(integrals), rates, analysis[-2:].copy())
    for array in table:
        array.setflags(write=False)
    return table
