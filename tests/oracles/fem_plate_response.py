"""Response of an infinite piezoelectric plate to charge on its surface, from exact partial waves: no mesh.

Fields exp(i (omega t - k x)) in a plate -h < z < 0 of one solid, in the plane x, z.  With U = (u_x, u_z, phi) and
t = (T_xz, T_zz, D_z) on planes z = const, and A_lm the 3 x 3 tables of T_l = A_lm d_m U (l, m in x, z),

    U' = A_zz^-1 (t + i k A_zx U),    t' = (k^2 (A_xx - A_xz A_zz^-1 A_zx) - rho omega^2 P) U + i k A_xz A_zz^-1 t,

P the projection on displacements.  The six eigenvectors are the partial waves, exp(lambda z); the three that decay
downwards are counted from the top, the others from the bottom, so that no exponential grows.  Top: no traction,
D_z = -1 (unit charge, nothing above); bottom: no traction, D_z = 0.  Nothing here is shared with `fem`.

Limits: u_y uncoupled; loss in the solid, so that no pole lies on the real axis; x -> -x a symmetry (ceramic poled
along z).

Sources: Stroh, J. Math. Phys. 41 (1962) 77; Milsom, Reilly and Redwood, IEEE Trans. SU-24 (1977) 147.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

__all__ = ["PlateResponse"]

TURN = np.exp(-0.3j)  # direction of the rays in `PlateResponse.forced`
_ROWS = {0: (0, 4), 2: (4, 2)}  # Voigt strain that d_x and d_z of u_x and u_z feed


@dataclass(frozen=True, kw_only=True)
class PlateResponse:
    """A plate at one frequency.

    Attributes
    ----------
    stiffness : ndarray, shape (6, 6), complex
        c^E with loss, Pa.
    coupling : ndarray, shape (3, 6)
        e, C/m2.
    permittivity : ndarray, shape (3, 3), complex
        eps^S with loss, F/m.
    density : float
        kg/m3.
    thickness : float
        m.
    frequency : float
        Hz.
    """

    stiffness: np.ndarray = field(repr=False)
    coupling: np.ndarray = field(repr=False)
    permittivity: np.ndarray = field(repr=False)
    density: float
    thickness: float
    frequency: float

    @cached_property
    def _units(self) -> tuple[float, float, float]:
        """Stress (Pa), potential over displacement (V/m), length (m)."""
        stress = float(abs(self.stiffness).max())
        potential = float(np.sqrt(stress / abs(self.permittivity).max()))
        return stress, potential, float(np.sqrt(stress / self.density) / (2 * np.pi * self.frequency))

    @cached_property
    def _tables(self) -> tuple[np.ndarray, ...]:
        """A_xx, A_xz, A_zx, A_zz in scaled units."""
        stress, potential, _ = self._units
        law = np.zeros((9, 9), dtype=complex)
        law[:6, :6] = self.stiffness / stress
        law[6:, :6] = self.coupling * (potential / stress)
        law[:6, 6:] = law[6:, :6].T
        law[6:, 6:] = -self.permittivity * (potential**2 / stress)
        across = [_ROWS[0][0], _ROWS[2][0], 6]
        down = [_ROWS[0][1], _ROWS[2][1], 8]
        return tuple(law[np.ix_(rows, columns)] for rows in (across, down) for columns in (across, down))

    @cached_property
    def low_wavenumbers(self) -> np.ndarray:
        """Laurent coefficients of phi per charge at k = 0, of k^-2, 1, k^2 ... k^10 (SI), by Cauchy's integral.

        The plate conducts D along x: a double pole.  The circle's radius is ``small_wavenumber``, inside all others.

        Raises
        ------
        ValueError
            If another pole is too near.
        """
        circle = self.small_wavenumber * np.exp(2j * np.pi * (np.arange(32) + 0.5) / 32)
        values = self.surface(circle)[:, 2]
        found = np.array([np.mean(values * circle**-power) for power in range(-2, 11, 2)])
        if abs(found[-1]) * self.small_wavenumber**12 > 1e-7 * abs(found[0]):
            raise ValueError(
                f"a mode of the plate is at its cut-off at {self.frequency:g} Hz: change the frequency slightly"
            )
        return found

    @property
    def small_wavenumber(self) -> float:
        """A tenth over the thickness, rad/m."""
        return 0.1 / self.thickness

    @cached_property
    def high_wavenumber(self) -> complex:
        """Factor c of c / |k| in phi per charge as k -> infinity: the static half-space, m/F."""
        return complex(self._solved(np.array([1.0 / self._units[2]]), 2, static=True)[0, 2] / self._units[2])

    def surface(self, wavenumbers: np.ndarray) -> np.ndarray:
        """u_x, u_z (m) and phi (V) at the surface for unit charge (C/m2) at wavenumbers (rad/m).

        Parameters
        ----------
        wavenumbers : ndarray, shape (n,), real or complex

        Returns
        -------
        ndarray, shape (n, 3)
        """
        return self._solved(np.asarray(wavenumbers), 2, static=False)

    def forced(self, component: str, distances: np.ndarray) -> np.ndarray:
        """u_x and u_z (m) at the surface beside a line force of 1 N/m along "x" or "z" (outwards), shape (2, n).

        The integral over k runs along the real axis, where loss keeps the poles off, to a wavenumber beyond all slow
        modes, and then along rays where exp(-i k |x|) decays, turned by less than the partial waves' own angles.

        Parameters
        ----------
        component : "x" or "z"
        distances : ndarray, shape (n,)
            x of the places less that of the force, m, not zero.
        """
        slow = self._bulk_wavenumber
        corner = 4 * slow + (12 / self.thickness if np.isfinite(self.thickness) else 0.0)
        loss = float(np.min(self.stiffness.imag.diagonal() / self.stiffness.real.diagonal()))
        out = np.empty((2, len(distances)), dtype=complex)
        for number, x in enumerate(distances):
            reach = abs(x)
            step = min(0.7 * slow * loss, 2.0 / reach, corner / 40)
            k, weights = _panels(np.linspace(-corner, corner, int(2 * corner / step)))
            last = max(45.0 / reach / abs(TURN.imag), corner)
            t, down = _panels(np.append(0.0, np.geomspace(corner / 8, last, int(4 + 4 * np.log(8 * last / corner)))))
            paths = (
                (k, weights),
                (corner + TURN * t, TURN * down),
                (-corner - TURN.conjugate() * t, TURN.conjugate() * down),
            )
            total = np.zeros(2, dtype=complex)
            for at, weight in paths:
                spectrum = self._solved(at, ("x", "z").index(component), static=False)[:, :2]
                if x < 0:  # u(-x): the mirrored spectrum, k -> -k, on the same path
                    spectrum = self._solved(-at, ("x", "z").index(component), static=False)[:, :2]
                total += (weight * np.exp(-1j * at * reach)) @ spectrum
            out[:, number] = total / (2 * np.pi)
        return out

    @property
    def _bulk_wavenumber(self) -> float:
        """Wavenumber of the slowest shear wave without piezoelectric stiffening, rad/m."""
        softest = float(np.linalg.eigvalsh(self.stiffness.real[np.ix_([0, 2, 4], [0, 2, 4])]).min())
        return float(2 * np.pi * self.frequency / np.sqrt(softest / self.density))

    def _solved(self, wavenumbers, row: int, *, static: bool) -> np.ndarray:
        """u_x, u_z and phi for a unit of the load ``row``: a force along x, along z, or a charge."""
        stress, potential, length = self._units
        k = (wavenumbers * length)[:, None, None].astype(complex)
        xx, xz, zx, zz = self._tables
        inverse = np.linalg.inv(zz)
        inertia = np.diag([0.0, 0.0, 0.0] if static else [1.0, 1.0, 0.0])
        system = np.empty((len(wavenumbers), 6, 6), dtype=complex)
        system[:, :3, :3] = 1j * k * (inverse @ zx)
        system[:, :3, 3:] = inverse
        system[:, 3:, :3] = k**2 * (xx - xz @ inverse @ zx) - inertia
        system[:, 3:, 3:] = 1j * k * (xz @ inverse)
        # t is measured in k, which balances the two halves for short waves
        scale = np.maximum(abs(k[:, 0]), 1.0)
        balance = np.concatenate([np.ones((len(k), 3)), np.repeat(scale, 3, axis=1)], axis=1)
        system *= balance[:, None, :] / balance[:, :, None]
        rates, waves = np.linalg.eig(system)
        order = np.argsort(-rates.real, axis=1)
        rates = np.take_along_axis(rates, order, axis=1)
        waves = np.take_along_axis(waves, order[:, None, :], axis=2)
        depth = np.inf if static else self.thickness / length
        decay = np.exp(-np.abs(depth) * np.where(np.arange(6) < 3, rates, -rates)) if not static else 0.0
        at_top = np.ones((len(k), 6), dtype=complex)
        at_bottom = np.ones((len(k), 6), dtype=complex)
        at_top[:, 3:] = decay if static else decay[:, 3:]
        at_bottom[:, :3] = decay if static else decay[:, :3]
        conditions = np.concatenate([waves[:, 3:] * at_top[:, None], waves[:, 3:] * at_bottom[:, None]], axis=1)
        load = np.zeros((len(k), 6, 1), dtype=complex)
        load[:, row, 0] = (-1.0 if row == 2 else 1.0) / scale[:, 0]
        amplitudes = np.linalg.solve(conditions, load)
        fields = ((waves[:, :3] * at_top[:, None]) @ amplitudes)[:, :, 0]
        # scaled: T = stress, D = stress / potential, U = length for displacements, length * potential for phi
        fields = fields * ((potential if row == 2 else 1.0) / stress * length)
        fields[:, 2] *= potential
        return fields


def _panels(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of Gauss's rule of 12 points on each panel."""
    points, weights = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1] + edges[1:])[:, None] / 2 + half * points).ravel(), (half * weights).ravel()
