"""Fingers on a plate of any cut under vacuum: charges of the fingers, admittance and motion, without a mesh or modes.

Partial waves at every real wavenumber (`PlateField`) give the potential and the motion per charge, G and U.  With the
vacuum's own share of the charge, eps_0 |k| phi, they become

    G' = G / (1 + eps_0 |k| G),    U' = U / (1 + eps_0 |k| G).                                              (1)

The charge of a finger is a sum of Chebyshev polynomials over sqrt(1 - t^2), whose potentials are Fourier integrals over
real k: the solid's loss keeps the poles off the axis.  Of G' the part c R, R = (1 - exp(-|k| b)) / |k|, is transformed
in closed form, 1 / (2 pi) (ln(x^2 + b^2) - 2 ln|x|), and ln|t - s| = -ln 2 - sum 2 / n T_n(t) T_n(s).

exp(+i omega t), body at -h < z < 0; below it there is no field.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import jv

from tests.oracles.fem_plate_field import PlateField

VACUUM = 8.8541878188e-12
FUNCTIONS = 10  # of the charge of a finger
NODES = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True, kw_only=True, eq=False)
class ChargedPlate:
    """A plate with one transducer; lengths in m.

    Attributes
    ----------
    plate : PlateField
    thickness, frequency : float
    quality : float
        Mechanical quality, which sets the steps of the integrals.
    slowest : float
        Wavenumber of the slowest wave of the plate, rad/m: no pole lies beyond 1.5 times that.
    centers, half_width : ndarray, float
        Of the fingers.
    signs : str
        "+" or "-" for each finger.
    vacuum : bool
    """

    plate: PlateField
    thickness: float
    frequency: float
    quality: float
    slowest: float
    centers: np.ndarray
    half_width: float
    signs: str
    vacuum: bool = True

    def responses(self, k: np.ndarray) -> np.ndarray:
        """u_x, u_z and phi per charge at real k, (n, 3)."""
        edge = 0.005 / self.thickness
        found = np.empty((len(k), 3), dtype=complex)
        far = abs(k) > edge
        found[far] = self._solid(k[far])
        # near the double pole at k = 0 the partial waves nearly coincide: Laurent's series by Cauchy's integral
        circle = 2 * edge * np.exp(2j * np.pi * (np.arange(24) + 0.5) / 24)
        values, powers = self._solid(circle), np.arange(-2, 8)
        series = np.array([np.mean(values * circle[:, None] ** -power, axis=0) for power in powers])
        found[~far] = np.einsum("np,pf->nf", k[~far, None] ** powers.astype(float), series)
        if self.vacuum:
            found /= (1 + VACUUM * abs(k) * found[:, 2])[:, None]
        return found

    def _solid(self, k: np.ndarray) -> np.ndarray:
        parts = [self.plate.response(part, 0 * part) for part in np.array_split(k, 1 + len(k) // 20000)]
        return np.concatenate(parts)[:, [0, 2, 3]]

    def panels(self, reach: float, highest: float) -> tuple[np.ndarray, np.ndarray]:
        """Nodes and weights on 0 < k < highest for fields up to a distance: finer than poles and oscillations."""
        fine = min(0.5 * self.slowest / self.quality, 8.0 / reach)
        low = np.geomspace(1e-7 * self.slowest, fine, 80)
        middle = np.arange(fine, 1.5 * self.slowest, fine)[1:]
        high = [max(middle[-1], 1.5 * self.slowest)]
        while high[-1] < highest:
            high.append(high[-1] + min(8.0 / reach, 0.3 * high[-1]))
        edges = np.concatenate([[0.0], low, middle, high])
        if self.vacuum:
            edges = np.union1d(edges, self._about_electric_pole(fine))
        half = np.diff(edges) / 2
        return ((edges[:-1] + half)[:, None] + half[:, None] * NODES[0]).ravel(), np.outer(half, NODES[1]).ravel()

    def _about_electric_pole(self, fine: float) -> np.ndarray:
        """Edges of panels that shrink towards the root of 1 + eps_0 k G where it lies near the real axis.

        Where the plate's permittivity along x is negative, above a resonance of its thickness, a wave follows the plate
        whose field in the vacuum is many wavelengths high.
        """
        k = 0j + 0.02 / self.thickness
        for _ in range(60):  # eps_0 k^2 G is nearly constant
            k = -VACUUM * k**2 * self._solid(np.array([k]))[0, 2]
        if not 0 < k.real < self.slowest:
            return np.empty(0)
        steps = np.geomspace(0.3 * abs(k.imag), 2 * fine, 24)
        edges = np.concatenate([k.real - steps, k.real + steps])
        return edges[edges > 0]

    def charges(self) -> np.ndarray:
        """Coefficients of the charge density in C/m for 1 V, (fingers, FUNCTIONS); the first are total charges."""
        a, places, count = self.half_width, self.centers, len(self.centers)
        large = np.array([200.0, 400.0]) * self.slowest
        first, second = large * self.responses(large)[:, 2]
        c, b = (4 * second - first) / 3, 1.0 / self.slowest
        k, weights = self.panels(float(np.ptp(places)) + 4 * a, 25.0 * self.slowest + 20 / a)
        kernel = self.responses(k)[:, 2] - c * (1 - np.exp(-k * b)) / k
        fade = np.exp(-((k / self.slowest) ** 2))  # the same constant for all fingers, which neutrality removes
        bessel = np.array([jv(n, k * a) for n in range(FUNCTIONS)])
        nodes = np.cos(np.pi * (np.arange(120) + 0.5) / 120)
        chebyshev = np.array([np.cos(n * np.arccos(nodes)) for n in range(FUNCTIONS)]) / 120
        blocks = {}
        for step in {round(float(x - y), 12) for x in places for y in places}:
            phase = np.exp(1j * k * step)
            block = np.empty((FUNCTIONS, FUNCTIONS), dtype=complex)
            for m in range(FUNCTIONS):
                for n in range(FUNCTIONS):
                    factor = np.real(1j ** (n - m) * phase) * bessel[m] * bessel[n] - fade * (m == n == 0)
                    block[m, n] = weights @ (kernel * factor) / np.pi
            apart = a * (nodes[:, None] - nodes) - step
            smooth = np.log(apart**2 + b**2)
            if step:
                smooth = smooth - 2 * np.log(abs(apart))
            static = chebyshev @ smooth @ chebyshev.T
            if not step:
                static += np.diag([2 * np.log(2) - 2 * np.log(a), *(1 / np.arange(1, FUNCTIONS))])
            blocks[step] = block + c / (2 * np.pi) * static
        # row: finger f and function m, column: finger g and function n; step = x_g - x_f
        system = np.zeros((count * FUNCTIONS + 1,) * 2, dtype=complex)
        for f in range(count):
            for g in range(count):
                at = np.ix_(f * FUNCTIONS + np.arange(FUNCTIONS), g * FUNCTIONS + np.arange(FUNCTIONS))
                system[at] = blocks[round(float(places[g] - places[f]), 12)]
        load = np.zeros(len(system), dtype=complex)
        load[:-1:FUNCTIONS] = [0.5 if sign == "+" else -0.5 for sign in self.signs]
        scale = abs(system).max()
        system[:-1:FUNCTIONS, -1] = system[-1, :-1:FUNCTIONS] = scale  # the mean potential; no net charge
        return np.linalg.solve(system, load)[:-1].reshape(count, FUNCTIONS)

    def admittance(self, charges: np.ndarray, aperture: float) -> complex:
        """Of the transducer, S."""
        positive = np.array([sign == "+" for sign in self.signs])
        return 2j * np.pi * self.frequency * aperture * complex(charges[positive, 0].sum())

    def motion(self, charges: np.ndarray, x: np.ndarray) -> np.ndarray:
        """u_x and u_z at the surface per volt, some wavelengths beside the fingers, (2, n)."""
        reach = float(abs(x[:, None] - self.centers).max())
        k, weights = self.panels(reach, 14.0 * self.slowest)
        window = 0.5 * (1 - np.tanh(1.5 * (k / self.slowest - 9.0)))
        out = np.zeros((2, len(x)), dtype=complex)
        for sign in (1, -1):
            bessel = np.array([jv(n, sign * k * self.half_width) * 1j**n for n in range(FUNCTIONS)])
            sent = np.zeros(len(k), dtype=complex)
            for place, own in zip(self.centers, charges, strict=True):
                sent += np.exp(1j * sign * k * place) * (own @ bessel)
            fields = self.responses(sign * k)[:, :2] * (sent * window * weights)[:, None] / (2 * np.pi)
            out += fields.T @ np.exp(-1j * sign * np.outer(k, x))
        return out
