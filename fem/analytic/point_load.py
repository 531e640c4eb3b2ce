"""Static displacement of a half-space under a load on its surface, for any anisotropy.

A traction t exp(i k.x) on the surface z = 0 of the body z < 0 moves it by u = C(psi) t / |k|, psi the direction of k. C
is Hermitian; its real part is the inverse of the Barnett-Lothe tensor L, an average over a turn of the sextic
formalism's matrix N3, with m in the direction of k and n the normal, turned together by theta,

    L(psi) = -1/pi int_0^pi N3 dtheta,   N3 = R T^-1 R^T - Q,   Q = m c m, R = m c n, T = n c n,                (1)

T. C. T. Ting, Anisotropic Elasticity, Oxford 1996, eqs. 7.6-3 and 6.4-14. No eigenvalue is computed, so that isotropic
and other degenerate solids are no exception. The imaginary part is odd in k and has no mean.

A force F that is spread over a circle of radius a like that of a rigid flat punch, 1/sqrt(a^2 - r^2), moves all points
of the circle alike, by F/(2 a) times the mean of C over psi: the integral over |k| of sin(k a)/(k a) exp(i k.x) is the
same for all x inside the circle. This mean gives the contact stiffness. J. R. Willis, J. Mech. Phys. Solids 14 (1966)
163; for a sphere, where the circle is an approximation to a slender ellipse, J. J. Vlassak and W. D. Nix, Phil. Mag. A
67 (1993) 1045. The elastic constants are c^E: the electric field that the load raises, and its stiffening, are left
out.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["PointLoad", "point_load", "surface_compliance"]

VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])  # Voigt index of the components ij of a tensor
ACCURACY = 1e-12  # relative, of the averages: they converge exponentially in the number of directions
MAX_DIRECTIONS = 4096  # at which the averages are returned even if they have not converged


@dataclass(frozen=True, kw_only=True)
class PointLoad:
    """Mean compliances of a half-space under a load on its surface.

    Attributes
    ----------
    compliance : ndarray, shape (3, 3)
        Mean of Re C over the directions, symmetric, in 1/Pa; isotropic: 2 (1 - nu^2)/E normal, (1 - nu/2)/G tangential.
    spread : float
        Half the range of the normal compliance over the directions, relative to its mean; 0 where the normal is an axis
        of symmetry.
    """

    compliance: np.ndarray
    spread: float

    @property
    def indentation_modulus(self) -> float:
        """M in Pa, E/(1 - nu^2) of an isotropic solid."""
        return float(2 / self.compliance[2, 2])

    @property
    def tangential_compliance(self) -> float:
        """Part of 1/G* in 1/Pa for a force along x, (2 - nu)/G of an isotropic solid."""
        return float(2 * self.compliance[0, 0])

    @property
    def coupling(self) -> float:
        """Motion along x over that along z under a normal load; 0 where a mirror turns x round."""
        return float(self.compliance[0, 2] / self.compliance[2, 2])


def point_load(stiffness: np.ndarray) -> PointLoad:
    """Return the mean compliances of a half-space z < 0.

    Parameters
    ----------
    stiffness : ndarray, shape (6, 6)
        c in Pa, in the axes of the surface; Voigt 11 22 33 23 13 12.

    Examples
    --------
    >>> from fem import material
    >>> round(point_load(material("steel").stiffness).indentation_modulus / 1e9, 6)  # 210 / (1 - 0.3^2)
    230.769231
    """
    count = 16
    by_direction = _compliances(stiffness, count)
    mean = by_direction.mean(axis=0)
    while count < MAX_DIRECTIONS:
        count *= 2
        coarser_mean = mean
        by_direction = _compliances(stiffness, count)
        mean = by_direction.mean(axis=0)
        if np.max(np.abs(mean - coarser_mean)) <= ACCURACY * np.max(np.abs(mean)):
            break
    normal = by_direction[:, 2, 2]
    spread = float((normal.max() - normal.min()) / (2 * normal.mean()))
    mean.flags.writeable = False
    return PointLoad(compliance=mean, spread=spread)


def surface_compliance(stiffness: np.ndarray, directions: np.ndarray, *, turns: int = 256) -> np.ndarray:
    """Return Re C = L^-1, equation (1), for directions of the wavevector (rad from x), shape (n, 3, 3), 1/Pa.

    ``stiffness``: c in Pa; ``turns``: points of the average over theta.
    """
    full = np.asarray(stiffness)[VOIGT][:, :, VOIGT]  # c_ijkl
    psi = np.asarray(directions, dtype=float)[:, None]
    theta = np.arange(turns) * np.pi / turns
    # at theta = 0: m = along, in the direction of k, and n = up, the normal; shape (n, turns, 3), the terms 0 * theta
    # and 0 * psi only broadcast
    along = np.stack([np.cos(psi) + 0 * theta, np.sin(psi) + 0 * theta, 0 * (psi + theta)], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
    m, n = cos * along + sin * up, cos * up - sin * along
    q, r, t = (np.einsum("...i,ijkl,...l->...jk", a, full, b) for a, b in ((m, m), (m, n), (n, n)))
    n3 = r @ np.linalg.solve(t, np.swapaxes(r, -1, -2)) - q
    return np.linalg.inv(-n3.mean(axis=1))


def _compliances(stiffness: np.ndarray, count: int) -> np.ndarray:
    """Return Re C for ``count`` directions evenly spread over half a turn, with as many points in theta."""
    return surface_compliance(stiffness, np.arange(count) * np.pi / count, turns=count)
