"""A transducer's response to its own charges where its fingers end at y = +-W/2.

A line of charge q, uniform over |y| < W/2, makes on a parallel one at a distance x, averaged over the same aperture,
the potential q G(x).  In a section that extends without end along y each mode gives g_p exp(-i k_p x) of G.  In a solid
isotropic about z a point of charge has the cylindrical waves k_p H_0(k_p r) / 2 in their place (H: Hankel functions of
the second kind), so that with r^2 = x^2 + y^2, R^2 = x^2 + W^2

    G_p - g_p exp(-i k_p x) = -g_p k_p {int_0^W (y / W) H_0(k_p r) dy + int_W^oo H_0(k_p r) dy},

    int_0^W y H_0(k r) dy = [R H_1(k R) - x H_1(k x)] / k.

The pole at k = 0 has (s / pi) log r in the place of s |x|.

The charges across the fingers are combinations of those that the section has for one volt on each finger, uniform along
y; which, follows from the mean potential over every finger (Galerkin's method).  In these small changes a finger's
charge q counts as q / (pi (a^2 - x^2)^(1/2)), a the half width, and its dipole by that and x.  What an uneven change
of the potential adds to the dipoles is, to the first order, that of a strip on a half-space,

    M = -(a^2 / 2) (d phi / d x) / [x d G(x; 0) / d x],    x << wavelength.
"""

from functools import cache

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fem.analytic.hankel import scaled_hankel
from fem.beam.line_source import LineSource
from fem.discretize.spectral import chebyshev_nodes
from fem.geometry import Transducer

ACROSS = (
    3  # places on a finger for the charge 1 / sqrt(1 - s^2): Chebyshev nodes, exact to the fifth power of s
)
NODES = 12  # of Laguerre's rule along the path of steepest descent from y = W
WIDEST, SLOW = 16.0, 4.0  # over the largest wavenumber: k_y of mirrors, and modes that reach them
PLACES, MAX_STRETCH = 16, 2.0  # nodes of an interpolation in R, and R / W up to which they leave 1e-13
DECAYED = 45.0  # exponent beyond which a Hankel function is nothing

laguerre_rule = cache(np.polynomial.laguerre.laggauss)


def mean_potential_change(
    source: LineSource, aperture: float, distances: np.ndarray, mirror_width: float | None = None
) -> np.ndarray:
    """Potential averaged over a finite aperture, less that of the section, V per C/m, up to a constant.

    Parameters
    ----------
    source : LineSource
    aperture : float
        m.
    distances : ndarray, shape (n,)
        Of two parallel lines, m.
    mirror_width : float, optional
        Of two reflecting side faces, m.

    Returns
    -------
    ndarray, shape (n,)
    """
    k, x = source.wavenumbers, np.asarray(distances, dtype=float)
    change = mode_change(k, aperture, x)
    if mirror_width is None:
        return source.potential @ change + source.slope * static_change(aperture, x)
    highest = WIDEST * np.sqrt((k**2).real.max())
    for mode in np.flatnonzero(abs(k) < highest / WIDEST * SLOW):
        change[mode] = _between_mirrors(k[mode], aperture, x, mirror_width, highest)
    return source.potential @ change


def _between_mirrors(k: complex, aperture: float, x: np.ndarray, width: float, highest: float) -> np.ndarray:
    """Change of a mode where the field is a sum over k_y = 2 pi n / width."""
    lateral = np.arange(1, int(highest * width / (2 * np.pi))) * (2 * np.pi / width)
    along = np.sqrt(k**2 - lateral**2) * (-1 if k.real < 0 else 1)
    along[along.imag > 0] *= -1
    shares = 2 * aperture / width * np.sinc(lateral * aperture / (2 * np.pi)) ** 2 * (k / along)
    return shares @ np.exp(-1j * np.outer(along, x)) + (aperture / width - 1) * np.exp(-1j * k * x)


def mode_change(wavenumbers: np.ndarray, aperture: float, distances: np.ndarray) -> np.ndarray:
    """The same of each mode, over its potential at x = 0 in the section, shape (modes, n)."""
    k, x, width = np.asarray(wavenumbers)[:, None], distances, aperture
    reach = np.hypot(x, width)
    near = np.full((len(k), len(x)), 2j / np.pi) / k**2
    there = (x > 0) & (-(k.imag) * x < DECAYED)
    near[:, x > 0] = 0.0
    here = np.broadcast_to(x, there.shape)[there]
    of = np.broadcast_to(k, there.shape)[there]
    near[there] = here * np.exp(-1j * of * here) * scaled_hankel(1, of * here) / of
    out = near / width
    lasting = -wavenumbers.imag * width < DECAYED
    k, farthest = k[lasting], reach.max() / width
    if len(x) > PLACES and farthest < MAX_STRETCH:  # a smooth function of log R
        places, coefficients = _interpolation()
        terms = chebvander(2 * np.log(reach / width) / np.log(farthest) - 1, PLACES - 1)
        beyond = _beyond(k, width, width * farthest ** ((places + 1) / 2)) @ (terms @ coefficients).T
    else:
        beyond = _beyond(k, width, reach)
    out[lasting] -= np.exp(-1j * k * reach) * beyond
    return out * wavenumbers[:, None]


@cache
def _interpolation() -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev nodes in [-1, 1], and the matrix from values there to coefficients of Chebyshev polynomials."""
    nodes = chebyshev_nodes(-1.0, 1.0, PLACES)
    return nodes, np.linalg.inv(chebvander(nodes, PLACES - 1))


def _beyond(k: np.ndarray, width: float, reach: np.ndarray) -> np.ndarray:
    """R H_1(k R) / (k W) + int_W^oo H_0(k r) dy, times exp(i k R), shape (modes, n); k of shape (modes, 1)."""
    # from y = W on along exp(-i k y) falling; r leaves no branch cut on the way
    s, weights = laguerre_rule(NODES)
    path = -1j * (reach / width)[:, None] * s / k[..., None]
    z = k[..., None] * np.sqrt(reach[:, None] ** 2 + path * (2 * width + path))
    value = scaled_hankel(0, z) * np.exp(s - 1j * (z - (k * reach)[..., None]))
    return reach * scaled_hankel(1, k * reach) / (k * width) - 1j / k * (reach / width) * (value @ weights)


def static_change(aperture: float, distances: np.ndarray) -> np.ndarray:
    """The same of the pole at k = 0 over its slope, m, shape (n,)."""
    x, width = distances, aperture
    reach = np.hypot(x, width)
    squares = x**2 * np.log(np.where(x > 0, x, 1.0))
    mean = width * np.log(reach) + x * np.arctan2(width, x)
    mean -= 0.5 * (reach**2 * np.log(reach) - squares) / width
    return 2 / np.pi * mean - x


def polarisability(source: LineSource, finger_width: float) -> complex:
    """Dipole of a strip, C, per V/m of the potential along it."""
    a, k = finger_width / 2, source.wavenumbers
    slope = np.sum(-1j * k * source.potential * np.exp(-1j * k * a)) + source.slope
    return complex(-a / (2 * slope))


def finger_coupling(
    source: LineSource, transducer: Transducer, mirror_width: float | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Change of the charged fingers' potentials by the charges of all.

    Returns
    -------
    tuple of ndarray, shape (fingers, fingers)
        Over charge and charge, charge and dipole, dipole and dipole: V, V/m and V/m2 per C/m or C m/m.
    """
    charged = np.flatnonzero([sign in "+-" for sign in transducer.signs])
    across = transducer.finger_width / 2 * np.cos(np.pi * (np.arange(ACROSS) + 0.5) / ACROSS)
    count = len(transducer.signs)
    apart = np.arange(1 - count, count) * transducer.pitch
    distances = abs(apart[:, None, None] + np.subtract.outer(across, across))
    different, which = np.unique(distances.round(12), return_inverse=True)
    between = mean_potential_change(source, transducer.aperture, different, mirror_width)[which]
    between = between.reshape(distances.shape)
    charge, dipole = np.full(ACROSS, 1 / ACROSS), across / np.sum(across**2)
    numbers = np.subtract.outer(charged, charged) + count - 1
    return tuple(
        (between @ right @ left)[numbers]
        for left, right in ((charge, charge), (charge, dipole), (dipole, dipole))
    )
