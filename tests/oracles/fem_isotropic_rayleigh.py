"""The Rayleigh wave of an isotropic half-space in closed form (Rayleigh 1885; Achenbach 1973, section 5.11).

x along the propagation, body at depth d >= 0 below the surface (z = -d), exp(i(omega t - k x)).
"""

import numpy as np
from numpy.polynomial import Polynomial


def velocity_over_shear(poisson_ratio: float) -> float:
    """v_R / v_S = sqrt(s): the root below 1 of s^3 - 8 s^2 + (24 - 16 q) s - 16 (1 - q), q = (v_S/v_L)^2."""
    q = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    cubic = Polynomial([-16 * (1 - q), 24 - 16 * q, -8, 1])
    (s,) = (root.real for root in cubic.roots() if abs(root.imag) < 1e-9 and 0 < root.real < 1)
    for _ in range(3):
        s -= cubic(s) / cubic.deriv()(s)
    return float(np.sqrt(s))


def _decays(poisson_ratio: float) -> tuple[float, float]:
    s = velocity_over_shear(poisson_ratio) ** 2
    q = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    return float(np.sqrt(1 - q * s)), float(np.sqrt(1 - s))


def profile(poisson_ratio: float, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u_x (imaginary) and u_z (real) against depth in wavelengths, u_z = 1 at the surface, z outwards."""
    a, b = _decays(poisson_ratio)
    kd = 2 * np.pi * np.asarray(depth)
    mixed = 2 * a * b / (1 + b * b)
    u_x = np.exp(-a * kd) - mixed * np.exp(-b * kd)
    u_z = a * (np.exp(-a * kd) - (2 / (1 + b * b)) * np.exp(-b * kd))
    at_surface = a * (1 - 2 / (1 + b * b))
    return -1j * u_x / at_surface, u_z / at_surface + 0j


def surface_ratio(poisson_ratio: float) -> float:
    """|u_x / u_z| at the surface, 2 sqrt(1 - s) / (2 - s)."""
    s = velocity_over_shear(poisson_ratio) ** 2
    return float(2 * np.sqrt(1 - s) / (2 - s))
