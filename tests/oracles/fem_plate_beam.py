"""Motion of a plate under strips of charge that end at y = +-W/2, summed over the plane of real wave vectors.

    u(x, y) = sum over k_x, k_y of  G(|k|) q(k_x) W sinc(k_y W / 2) exp(-i k_x x - i k_y y) / (2 pi)^2  dk_x dk_y

with G of the exact plate response: u_z as it is, u_x and u_y the components of the motion along k.  No pole is located
and no contour is bent: the solid's loss keeps the poles off the real plane, by k / 2Q, and the sums' periodic images
fade on their way.  Beyond the cut-off the charge is filtered, which changes the field near the strips only.
"""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import erfc

STEP = 18.0  # rad/m of the sums; loss of 50 rad/m makes images at 2 pi / 18 m fade to 1e-7
CUT_OFF = 2.6  # of k_x over the wavenumber given; the filter begins at 1.4
LATERAL = 1.5  # of k_y over the wavenumber given


def plate_beam(response, wavenumber, x_charges, charges, aperture, points) -> np.ndarray:
    """Surface motion at points to the right or left of all charges, more than three wavelengths away.

    Parameters
    ----------
    response : callable
        u_x, u_z, ... per unit charge (m per C/m2) for waves along x at real wavenumbers (rad/m), shape (n, >= 2).
    wavenumber : float
        Largest of a propagating mode, rad/m.
    x_charges, charges : ndarray, shape (m,)
        m and C/m.
    aperture : float
        W, m.
    points : ndarray, shape (p, 2)
        x and y in m.

    Returns
    -------
    ndarray, shape (3, p)
        u_x, u_y, u_z in m.
    """
    along = (np.arange(-int(CUT_OFF * wavenumber / STEP), int(CUT_OFF * wavenumber / STEP)) + 0.5) * STEP
    across = (np.arange(int(LATERAL * wavenumber / STEP)) + 0.5) * STEP
    radial = np.hypot(along[:, None], across)
    table = np.linspace(radial.min() * 0.5, radial.max(), int(radial.max() / (0.08 * STEP)))
    motion = CubicSpline(table, response(table)[:, :2])(radial)
    position = (abs(along) / wavenumber - 1.4) / (CUT_OFF - 1.4)
    window = 0.5 * erfc(7.0 * (position - 0.5))
    spectrum = window * (np.exp(1j * np.outer(along, x_charges)) @ charges)
    weight = aperture * np.sinc(across * aperture / (2 * np.pi)) * STEP**2 / (2 * np.pi) ** 2
    sent = spectrum[:, None] * weight
    out = np.empty((3, len(points)), dtype=complex)
    for number, (x, y) in enumerate(points):
        wave = np.exp(-1j * along * x)
        even, odd = 2 * np.cos(across * y), -2j * np.sin(across * y)
        out[0, number] = (wave * along) @ (sent * motion[..., 0] / radial) @ even
        out[1, number] = wave @ (sent * motion[..., 0] / radial) @ (across * odd)
        out[2, number] = wave @ (sent * motion[..., 1]) @ even
    return out
