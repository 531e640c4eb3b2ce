"""Hankel functions of the second kind, H_n = J_n - i Y_n, on large arrays.

`scipy.special` has them too; its import takes 0.2 s of processor time beyond NumPy's, a tenth of a whole run, of which
nothing else needs SciPy.  H_n(z) = (2 / pi) i^(n + 1) K_n(i z), and exp(w) K_n(w) is entire in log w: Taylor series
about the middles of cells of the plane of log w serve all arguments in them.  Their coefficients are a Fourier
transform of values on a circle (Cauchy's integral), and these values

    exp(w) K_n(w) = int_0^oo exp(-2 w sinh(t / 2)^2) cosh(n t) dt

(DLMF 10.32.9), along any path from 0 on which w exp(t) loses its phase: there the integrand falls double exponentially,
and the trapezoidal rule converges exponentially (Trefethen and Weideman, SIAM Review 56 (2014) 385).
"""

import numpy as np

INTERVALS = 56  # of the rule: rounding down to |z| = 1e-4; 48 leave 5e-12
ENDS = 42.0  # exponent at which the integral is cut off
CELL = 0.5  # side of the cells in log w
TERMS, POINTS = 16, 24  # of a cell's series, and of the circle, its radius CELL: rounding
FAR, FAR_TERMS = 20.0, 14  # argument from which Hankel's asymptotic series is used, and its terms: 1e-14

_series: dict[tuple[int, complex], np.ndarray] = {}  # coefficients by order and cell


def scaled_hankel(order: int, z: np.ndarray) -> np.ndarray:
    """H_n(z) exp(i z).

    Parameters
    ----------
    order : int
        n, 0 or 1.
    z : ndarray of complex
        -pi <= arg z <= pi / 4, |z| >= 1e-4.

    Returns
    -------
    ndarray, shape of z
        Relative error 1e-12.

    Examples
    --------
    >>> complex(scaled_hankel(0, np.array([1.0 + 0j]))[0] * np.exp(-1j)).real  # J_0(1)
    0.76519768...
    """
    out = np.empty(z.shape, dtype=complex)
    near = abs(z) < FAR
    if near.any():
        out[near] = 2 / np.pi * 1j ** (order + 1) * _near(order, 1j * z[near])
    far = z[~near]
    total, inverse = np.ones_like(far), -1j / far
    for term in range(FAR_TERMS, 0, -1):
        total *= inverse * ((4 * order**2 - (2 * term - 1) ** 2) / (8 * term))
        total += 1
    out[~near] = np.sqrt(2 / np.pi) * 1j ** (order + 1) / np.sqrt(1j * far) * total  # continuous at arg z = -pi
    return out


def _near(order: int, w: np.ndarray) -> np.ndarray:
    """exp(w) K_n(w) by the cells' series, shape (points,)."""
    position = np.log(w) / CELL
    cells, which = np.unique(np.round(position), return_inverse=True)
    new = np.array([cell for cell in cells if (order, cell) not in _series])
    if len(new):
        circle = np.exp(2j * np.pi * np.arange(POINTS) / POINTS)
        values = _integral(order, new[:, None] * CELL + CELL * circle)
        coefficients_of_new = np.fft.fft(values, axis=1)[:, :TERMS] / POINTS
        _series.update({(order, cell): own for cell, own in zip(new, coefficients_of_new, strict=True)})
    coefficients = np.stack([_series[order, cell] for cell in cells], axis=1)
    local = position - cells[which]
    total = coefficients[-1, which]
    for each in coefficients[-2::-1]:
        total *= local
        total += each[which]
    return total


def _integral(order: int, logarithm: np.ndarray) -> np.ndarray:
    """exp(w) K_n(w) at log w, shape (cells, points); a cell's points share the path t = u - i phase tanh(u / 2)."""
    phase = logarithm.imag.mean(axis=1, keepdims=True)
    smallest = np.exp(logarithm.real.min(axis=1, keepdims=True))
    step = np.arccosh(1 + ENDS / smallest) / INTERVALS
    u = step * np.arange(INTERVALS + 1)
    turn = np.tanh(u / 2)
    t = u - 1j * phase * turn
    weights = step * np.cosh(order * t) * (1 - 0.5j * phase * (1 - turn**2))
    weights[:, 0] /= 2
    rates = -2 * np.sinh(t / 2) ** 2
    return np.einsum("cpn,cn->cp", np.exp(np.exp(logarithm)[..., None] * rates[:, None]), weights)
