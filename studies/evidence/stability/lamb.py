"""Surface waves of isotropic solids in closed form: Rayleigh's half-space and Lamb's plate.

Half-space (Rayleigh 1885), s = (v/v_S)^2, q = (v_S/v_L)^2: s^3 - 8 s^2 + (24 - 16 q) s - 16 (1 - q) = 0.  Plate of
half-thickness h (Lamb 1917), exp(i(omega t - k x)), p^2 = (omega/v_L)^2 - k^2, q^2 = (omega/v_S)^2 - k^2:

    symmetric      (q^2 - k^2)^2 cos(p h) sin(q h)/q + 4 k^2 p sin(p h) cos(q h) = 0
    antisymmetric  (q^2 - k^2)^2 sin(p h)/p cos(q h) + 4 k^2 q cos(p h) sin(q h) = 0

Real for real k.  Hyperbolic factors are divided by their growth, so that no thickness overflows.
"""

import numpy as np

__all__ = ["bulk_velocities", "plate_wavenumbers", "rayleigh_velocity"]


def bulk_velocities(youngs_modulus: float, poisson_ratio: float, density: float) -> tuple[float, float]:
    """Longitudinal and shear velocity in m/s of a modulus in Pa and a density in kg/m3."""
    shear = youngs_modulus / (2 * (1 + poisson_ratio))
    ratio = 2 * (1 - poisson_ratio) / (1 - 2 * poisson_ratio)
    return float(np.sqrt(shear * ratio / density)), float(np.sqrt(shear / density))


def rayleigh_velocity(longitudinal: float, shear: float) -> float:
    """Velocity in m/s of the half-space's wave."""
    q = (shear / longitudinal) ** 2
    cubic = np.polynomial.Polynomial([-16 * (1 - q), 24 - 16 * q, -8, 1])
    (s,) = (root.real for root in cubic.roots() if abs(root.imag) < 1e-9 and 0 < root.real < 1)
    for _ in range(3):
        s -= cubic(s) / cubic.deriv()(s)
    return float(np.sqrt(s) * shear)


def plate_wavenumbers(
    omega: float, *, longitudinal: float, shear: float, half_thickness: float, symmetric: bool
) -> np.ndarray:
    """All real positive wavenumbers of a plate's modes of one symmetry, rising.

    Parameters
    ----------
    omega : float
        rad/s.
    longitudinal, shear : float
        m/s.
    half_thickness : float
        m.
    symmetric : bool

    Returns
    -------
    ndarray
        rad/m.
    """

    def value(k):
        p2, q2 = (omega / longitudinal) ** 2 - k**2, (omega / shear) ** 2 - k**2
        (cos_p, sin_p), (cos_q, sin_q) = (_circular(square, half_thickness) for square in (p2, q2))
        if symmetric:
            return (q2 - k**2) ** 2 * cos_p * sin_q + 4 * k**2 * p2 * sin_p * cos_q
        return (q2 - k**2) ** 2 * sin_p * cos_q + 4 * k**2 * q2 * cos_p * sin_q

    top = 1.6 * omega / shear + 3.0 / half_thickness
    line = np.linspace(1e-6 * top, top, 40001)
    signs = np.sign(value(line))
    at = np.flatnonzero(signs[:-1] * signs[1:] < 0)
    low, high = line[at], line[at + 1]
    for _ in range(60):
        middle = (low + high) / 2
        same = np.sign(value(middle)) == signs[at]
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2


def _circular(square: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """cos(r h) and sin(r h) / r, r = sqrt(square), over exp(|r| h) where square is negative."""
    root = np.sqrt(abs(square))
    small = root * h < 1e-6
    safe = np.where(small, 1.0, root)
    fading = np.exp(-2 * root * h)
    cosine = np.where(square >= 0, np.cos(root * h), (1 + fading) / 2)
    sine = np.where(square >= 0, np.sin(safe * h), (1 - fading) / 2) / safe
    return cosine, np.where(small, h, sine)
