"""Surface impedance of a half-space by Stroh's formalism.

Fields u(z) exp(i(omega t - k x)), body at z < 0, z its outward normal, d/dy = 0, no loss.  With the
tables xx, xz, zz of element_matrices.py, generalised traction -i k b on z = const and partial waves exp(-i k p z),
Stroh's problem is N (u, b) = p (u, b) with the real matrix (Stroh 1962; Ting, *Anisotropic Elasticity*,
1996, chapters 5, 12)

    N = [[-zz^-1 xz^T, zz^-1], [xz zz^-1 xz^T - xx + rho v^2, -xz zz^-1]].                                 (1)

Below the limiting velocity all p are complex.  The decaying half is the +i eigenspace of the real matrix
W = [[S, H], [-L, S^T]], W^2 = -1, which shares its invariant subspaces with N (Barnett and Lothe 1973).
W is the limit of W <- (W - 1/W)/2 from W = N, the matrix sign iteration of -iN (Roberts 1980; Higham,
*Functions of Matrices*, 2008, chapter 5).  It converges quadratically, and coinciding p cause no difficulty, because no
eigenvectors are computed.  The impedance Z, with traction = k Z u, is

    Z = H^-1 + i H^-1 S,    Hermitian.                                                                     (2)

The electrical condition at the surface determines phi in terms of u (phi = 0, D_n = 0, or D_n = eps0 k phi under
vacuum).  The impedance that remains acts on displacements alone.  It is positive definite at v = 0, and its eigenvalues
fall with v (Lothe and Barnett 1976).
"""

import numpy as np

from fem.exceptions import ConvergenceError
from fem.materials import VACUUM_PERMITTIVITY
from fem.materials.christoffel import christoffel
from fem.materials.medium import Medium

# Many steps are allowed, because near the limiting velocity the p are almost real and a step only doubles their angle.
_SIGN_STEPS = 60


class SurfaceImpedance:
    """Surface impedance Z(v) of a lossless medium whose surface is under "vacuum", "open" or "metallised".

    Velocities are in units of ``velocity_unit`` = sqrt(body.stress_unit / rho) in m/s; Z is in ``stress_unit``, Pa.
    """

    def __init__(self, body: Medium, surface: str):
        # The softest modulus as the unit keeps N of order one for a nearly incompressible solid too.
        displaced = body.displaced
        softest = np.diag(body.zz)[displaced].min()
        self.stress_unit = float(softest * body.stress_unit)
        self.velocity_unit = float(np.sqrt(1.0 / body.inertia[0]))
        xx, xz, zz = body.xx / softest, body.xz / softest, body.zz / softest
        inverse = np.linalg.inv(zz)
        self.upper = -inverse @ xz.T
        self.inverse = inverse
        self.lower = xz @ inverse @ xz.T - xx
        self.inertia = np.diag(displaced.astype(float)) / softest
        self.displaced = displaced
        # scaled permittivity of the vacuum above: D_n = eps0 k phi at the surface
        gap = VACUUM_PERMITTIVITY * body.potential_unit**2 / body.stress_unit / softest
        self.gap = gap if surface == "vacuum" else 0.0
        self.electric = surface != "metallised" and "phi" in body.fields

    def eigenvalues(self, velocity: float) -> np.ndarray:
        """Eigenvalues of the impedance of the displacements alone, in ascending order."""
        return np.linalg.eigvalsh(self.stiff(velocity))

    def stiff(self, velocity: float) -> np.ndarray:
        """Impedance of the displacements alone, shape (displacements, displacements)."""
        return self._condensed(self.of_all_fields(velocity))

    def mode(self, velocity: float, index: int) -> np.ndarray:
        """Surface amplitude of all fields, shape (fields,), at a velocity where eigenvalue ``index`` vanishes."""
        full = self.of_all_fields(velocity)
        amplitude = np.zeros(len(self.displaced), dtype=complex)
        amplitude[self.displaced] = np.linalg.eigh(self._condensed(full))[1][:, index]
        if self.electric:
            across = full[~self.displaced][:, self.displaced] @ amplitude[self.displaced]
            amplitude[~self.displaced] = -across / (full[-1, -1] - self.gap)
        return amplitude

    def decay(self, velocity: float) -> np.ndarray:
        """Matrix G of u(z) = exp(-i k G z) u(0), shape (fields, fields); its eigenvalues are the decaying p."""
        return self.upper + 1j * self.inverse @ self.of_all_fields(velocity)

    def _condensed(self, full: np.ndarray) -> np.ndarray:
        """Impedance of the displacements: phi is eliminated by its own equation, Z_pu u + (Z_pp - gap) phi = 0."""
        m = self.displaced
        stiff = full[np.ix_(m, m)]
        if not self.electric:
            return stiff
        across = full[np.ix_(m, ~m)]
        return stiff - across @ across.conj().T / (full[-1, -1].real - self.gap)

    def of_all_fields(self, velocity: float | np.ndarray) -> np.ndarray:
        """Z of all fields, equation (2), before the electrical condition is applied.

        Shape (fields, fields) at a velocity, (v, fields, fields) at several.
        """
        n = len(self.displaced)
        squared = np.square(np.asarray(velocity))
        w = np.empty((*squared.shape, 2 * n, 2 * n))  # equation (1)
        w[..., :n, :n], w[..., :n, n:], w[..., n:, n:] = self.upper, self.inverse, self.upper.T
        w[..., n:, :n] = self.lower + squared[..., None, None] * self.inertia
        for _ in range(_SIGN_STEPS):
            new = (w - np.linalg.inv(w)) / 2
            change = np.abs(new - w).max(axis=(-2, -1))
            w = new
            if np.all(change < 1e-8 * np.abs(w).max(axis=(-2, -1))):
                break
        else:
            fastest = float(np.max(velocity)) * self.velocity_unit
            raise ConvergenceError(f"no decaying partial waves at {fastest:.6g} m/s")
        inverse = np.linalg.inv(w[..., :n, n:])
        z = inverse + 1j * inverse @ w[..., :n, :n]
        return (z + z.conj().swapaxes(-1, -2)) / 2


def limiting_velocity(body: Medium) -> float:
    """Return min of c(theta) / cos(theta), the slowest trace velocity of a bulk wave, in sqrt(stress_unit / rho)."""

    def trace_velocity_squared(theta):
        return np.linalg.eigvalsh(christoffel(body, theta))[:, 0] / np.cos(theta) ** 2

    centre, half = 0.0, np.pi / 2 * 0.99
    for points in (91, 21, 21, 21, 21):
        theta = np.linspace(centre - half, centre + half, points)
        values = trace_velocity_squared(theta)
        centre, half = theta[np.argmin(values)], theta[1] - theta[0]
    return float(np.sqrt(values.min()))
