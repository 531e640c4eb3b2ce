"""Polynomials through values at Chebyshev points, for smooth functions on an interval.

The n points x_k = -cos(pi k / (n - 1)), k = 0 ... n - 1, include both ends of [-1, 1], and every second of 2 n - 1
points is one of n points. Source: L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, chapters
2 and 19 (Clenshaw-Curtis quadrature).
"""

from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev


def points(count: int) -> np.ndarray:
    """Return the Chebyshev points on [-1, 1], rising, shape (count,)."""
    return -np.cos(np.pi * np.arange(count) / (count - 1))


def interpolation(count: int, at) -> np.ndarray:
    """Return the matrix from values at the points to values of the polynomial at ``at``, shape (len(at), count)."""
    return chebyshev.chebvander(np.asarray(at, dtype=float), count - 1) @ _coefficients(count)


@lru_cache(16)
def weights(count: int) -> np.ndarray:
    """Return the weights of the mean over [-1, 1] of the polynomial through values at the points, shape (count,).

    Examples
    --------
    >>> bool(abs(weights(9) @ points(9) ** 6 - 1 / 7) < 1e-15)
    True
    """
    order = np.arange(count)
    mean = np.zeros(count)
    mean[::2] = 1.0 / (1.0 - order[::2] ** 2.0)  # of the Chebyshev polynomials of even order; that of the others is 0
    return mean @ _coefficients(count)


@lru_cache(16)
def _coefficients(count: int) -> np.ndarray:
    """Return the matrix from values at the points to coefficients of Chebyshev polynomials, shape (count, count)."""
    return np.linalg.inv(chebyshev.chebvander(points(count), count - 1))
