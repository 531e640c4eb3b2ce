"""Modes of a free isotropic plate: the Rayleigh-Lamb equations (Lamb 1917; Achenbach 1973, section 6.7).

Plate -h <= z <= h, exp(i(omega t - k x)), p^2 = (omega/c_L)^2 - k^2, q^2 = (omega/c_S)^2 - k^2:

    symmetric      (q^2 - k^2)^2 cos(p h) sin(q h)/q + 4 k^2 p sin(p h) cos(q h) = 0
    antisymmetric  (q^2 - k^2)^2 sin(p h)/p cos(q h) + 4 k^2 q cos(p h) sin(q h) = 0

real for real k, whatever the signs of p^2 and q^2.
"""

import numpy as np


def _circular(square, h):
    """cos(r h) and sin(r h)/r, r = sqrt(square), over exp(|r| h) where square is negative: nothing overflows."""
    root = np.sqrt(np.abs(square))
    small = root * h < 1e-6
    safe = np.where(small, 1.0, root)
    fading = np.exp(-2 * root * h)
    cosine = np.where(square >= 0, np.cos(root * h), (1 + fading) / 2)
    sine = np.where(square >= 0, np.sin(safe * h), (1 - fading) / 2) / safe
    return cosine, np.where(small, h, sine)


def determinant(k, omega, *, longitudinal: float, shear: float, half_thickness: float, symmetric: bool) -> np.ndarray:
    """Left side of the Rayleigh-Lamb equation, divided by the growth of its hyperbolic factors."""
    k = np.asarray(k, dtype=float)
    h = half_thickness
    p2, q2 = (omega / longitudinal) ** 2 - k**2, (omega / shear) ** 2 - k**2
    (cos_p, sin_p), (cos_q, sin_q) = _circular(p2, h), _circular(q2, h)
    if symmetric:
        return (q2 - k**2) ** 2 * cos_p * sin_q + 4 * k**2 * p2 * sin_p * cos_q
    return (q2 - k**2) ** 2 * sin_p * cos_q + 4 * k**2 * q2 * cos_p * sin_q


def wavenumbers(omega: float, *, longitudinal: float, shear: float, half_thickness: float, symmetric: bool):
    """All real positive roots k, increasing, by sign changes on a fine line and bisection."""
    plate = {"longitudinal": longitudinal, "shear": shear, "half_thickness": half_thickness, "symmetric": symmetric}
    top = 1.6 * omega / shear + 3.0 / half_thickness
    line = np.linspace(1e-6 * top, top, 40001)
    signs = np.sign(determinant(line, omega, **plate))
    roots = []
    for index in np.flatnonzero(signs[:-1] * signs[1:] < 0):
        low, high = line[index], line[index + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = np.sign(determinant(middle, omega, **plate)) == signs[index]
            low, high = (middle, high) if same else (low, middle)
        roots.append(0.5 * (low + high))
    return np.array(roots)


def group_velocity(k: float, omega: float, **plate) -> float:
    """D omega/d k on a branch, -(d/dk)/(d/d omega) of the determinant, by central differences."""
    dk, dw = 1e-6 * k, 1e-6 * omega
    along_k = determinant(k + dk, omega, **plate) - determinant(k - dk, omega, **plate)
    along_w = determinant(k, omega + dw, **plate) - determinant(k, omega - dw, **plate)
    return float(-(along_k / dk) / (along_w / dw))


def surface_share(k: float, omega: float, *, longitudinal: float, shear: float, half_thickness: float, symmetric: bool):
    """Squared motion at the surface over its integral through the depth, 1/m, of the mode of a wavenumber.

    With the potentials A cos(p z), B sin(q z) of a symmetric mode, and A sin(p z), B cos(q z) of an antisymmetric one,
    u_x = i k phi + psi', u_z = phi' - i k psi, and no shear stress at z = h.
    """
    h, p, q = (
        half_thickness,
        np.sqrt((omega / longitudinal) ** 2 - k**2 + 0j),
        np.sqrt((omega / shear) ** 2 - k**2 + 0j),
    )
    point, weight = np.polynomial.legendre.leggauss(400)
    z = np.append(h * point, h)
    if symmetric:
        b = 2j * k * p * np.sin(p * h) / ((k**2 - q**2) * np.sin(q * h))
        motion = 1j * k * np.cos(p * z) + q * b * np.cos(q * z), -p * np.sin(p * z) - 1j * k * b * np.sin(q * z)
    else:
        b = -2j * k * p * np.cos(p * h) / ((k**2 - q**2) * np.cos(q * h))
        motion = 1j * k * np.sin(p * z) - q * b * np.sin(q * z), p * np.cos(p * z) - 1j * k * b * np.cos(q * z)
    square = sum(abs(each) ** 2 for each in motion)
    return square[-1] / (h * weight @ square[:-1])
