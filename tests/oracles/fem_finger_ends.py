"""Static charge of fingers of finite length in a long row, alternately at +1 and -1: boundary elements in the plane.

Fingers |x - j p / 2| < a, |y| < W / 2 with the potentials (-1)^j on a surface whose permittivity for charges
exp(-i (k_x x + k_y y)) is eps(k_x, k_y) |k| (a half-space of any dielectric, with or without vacuum above it).
Galerkin's method with the charge

    s(x, y) = sum c_mn T_m(x / a) T_n(2 y / W) / [(1 - x^2 / a^2)^(1/2) (1 - 4 y^2 / W^2)^(1/2)],    m and n even,

whose transform is a product of Bessel functions; the row makes k_x = 2 pi (2 l + 1) / p.
"""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import jv, yv

ACROSS, HARMONICS = 3, 4000  # even functions over the width; k_x of either sign
LONGEST, FARTHEST = 20.0, 2000.0  # k_y in 1 / a: of the sum, and of its asymptotic rest
STEP = 0.1  # of k_y W / 2
REST = 1000
TABLE = 300  # k_y at which the sum over k_x is tabulated


def end_excess(permittivity, *, metallisation: float, length: float, along: int = 40) -> float:
    """Length in periods by which each end of a finger seems longer: charge over that per length in the middle.

    ``permittivity`` of arrays k_x and k_y, times |k|; ``length`` W in periods.
    """
    half_width, half_length = metallisation / 4, length / 2
    k_x = 2 * np.pi * (2 * np.arange(HARMONICS) + 1)
    over_width = np.array([jv(2 * m, k_x * half_width) for m in range(ACROSS)])
    table = np.geomspace(1e-3 / half_length, FARTHEST / half_width, TABLE)
    response = sum(1 / permittivity(side * k_x, table[:, None]) for side in (1, -1))
    values = np.einsum("ak,bk,yk->aby", over_width, over_width, response)
    kernel = CubicSpline(np.log(table), values, axis=2)

    k_y = (np.arange(int(LONGEST / half_width * half_length / STEP)) + 0.5) * STEP / half_length
    over_length = np.array([jv(2 * n, k_y * half_length) for n in range(along)])
    inner = kernel(np.log(k_y)) * STEP / half_length
    matrix = np.einsum("ny,aby,my->anbm", over_length, inner, over_length, optimize=True)
    # beyond, what does not oscillate of J_2n J_2m is half of J_2n J_2m + Y_2n Y_2m
    rest, step = np.linspace(np.log(k_y[-1] + STEP / half_length / 2), np.log(table[-1]), REST, retstep=True)
    both = [[each(2 * n, np.exp(rest) * half_length) for n in range(along)] for each in (jv, yv)]
    outer = kernel(rest) * np.exp(rest) * step / 2
    outer[..., [0, -1]] /= 2
    matrix += sum(np.einsum("ny,aby,my->anbm", each, outer, each, optimize=True) for each in np.array(both))

    size = ACROSS * along
    sign = (-1.0) ** np.add.outer(np.arange(ACROSS), np.arange(along)).ravel()
    matrix = matrix.reshape(size, size) * np.outer(sign, sign)
    unit = np.zeros(size)
    unit[0] = 1.0  # the constant potential, tested: J_0(0) alone
    charge = np.linalg.solve(matrix, unit).reshape(ACROSS, along)[0]
    in_the_middle = charge @ np.cos(np.pi * np.arange(along))  # T_2n(0)
    return float((np.pi * half_length * charge[0] / in_the_middle - length) / 2)
