"""Point force on an isotropic half-space: Lamb's problem by numerical integration over the wavenumber.

The surface's response to a force of wavenumber k is closed (Achenbach, Wave Propagation in Elastic Solids, 1973,
section 7.4; Miller and Pursey, Proc. R. Soc. A 223, 1954, 521).  With exp(+i omega t), q_L^2 = k^2 - k_L^2, q_T^2 =
k^2 - k_T^2 and R = (2 k^2 - k_T^2)^2 - 4 k^2 q_L q_T, up to one common sign,

    G_zz = k_T^2 q_L / (mu R),    G_ss = k_T^2 q_T / (mu R),    G_tt = 1 / (mu q_T)

for a normal force, a force along the wave vector and a force across it.  The path of integration passes above the
poles on the real axis; the static parts, (1 - nu) / (mu k) and 1 / (mu k), are integrated in closed form.
"""

import numpy as np
from scipy.special import jv


def _gauss(start, stop, panels, nodes=16):
    s, weights = np.polynomial.legendre.leggauss(nodes)
    edges = np.linspace(start, stop, panels + 1)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1] + edges[1:])[:, None] / 2 + half * s).ravel(), (half * weights).ravel()


def point_force(shear_modulus, poisson_ratio, shear_wavenumber, r, angle):
    """Motion per newton at a distance r (m): u_z by a normal force; u_x and u_y by one along x, ``angle`` from x."""
    mu, nu, k_t = shear_modulus, poisson_ratio, shear_wavenumber
    k_l = k_t * np.sqrt((1 - 2 * nu) / (2 - 2 * nu))
    bend, tail = 2.5 * k_t, 400 / r + 40 * k_t
    t, weights = _gauss(0.0, bend, int(10 + bend * r / 2))
    height = min(2.0 / r, 0.2 * k_t)
    k = t + 1j * height * np.sin(np.pi * t / bend)
    weights = weights * (1 + 1j * height * np.pi / bend * np.cos(np.pi * t / bend))
    further, more = _gauss(bend, bend + tail, int(200 + tail * r / 2))
    bessel = {order: np.append(jv(order, k * r), jv(order, further * r)) for order in (0, 2)}
    k, weights = np.append(k, further), np.append(weights, more)
    q_l, q_t = (np.sqrt(k - own) * np.sqrt(k + own) for own in (k_l, k_t))
    rayleigh = 4 * k**2 * q_l * q_t - (2 * k**2 - k_t**2) ** 2
    normal, along, across = k_t**2 * q_l / (mu * rayleigh), k_t**2 * q_t / (mu * rayleigh), 1 / (mu * q_t)
    static, static_across = (1 - nu) / mu, 1 / mu

    def integral(response, at_rest, order):
        rest = np.sum((response - at_rest / k) * bessel[order] * k * weights)
        return (rest + at_rest / r) / (2 * np.pi)

    mean = integral((along + across) / 2, (static + static_across) / 2, 0)
    difference = integral((along - across) / 2, (static - static_across) / 2, 2)
    return (integral(normal, static, 0), mean - np.cos(2 * angle) * difference, -np.sin(2 * angle) * difference)
