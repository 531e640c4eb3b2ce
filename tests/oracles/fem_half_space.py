"""Strips of charge on a piezoelectric half-space: partial waves in depth, boundary elements on the surface.

``surface_response``: displacement and potential at the surface of a half-space z < 0 (no traction, D_n = 0 outside)
per surface charge exp(i (omega t - k x)), by the partial waves of one wavenumber (Stroh 1962).  ``FingerStrips``:
equipotential fingers without mass; on each the charge is a sum of Chebyshev polynomials over the square root that it
has at the edges.  The potential's transform is c / |k| at large k, whose function of x is a logarithm with closed forms
for Chebyshev polynomials (Mason and Handscomb, *Chebyshev Polynomials*, 2003, section 9.5.1); the rest is smooth and is
integrated over k.  Needs loss, which keeps the poles off the real axis.  Nothing of the package is imported.
"""

from functools import cached_property

import numpy as np

VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


def surface_response(c, e, eps, density, omega, wavenumbers):
    """u_x, u_y, u_z in m and phi in V per C/m2 of surface charge; shape (wavenumbers, 4).

    ``c``: (6, 6) in Pa, complex with loss; ``e``: (3, 6) in C/m2; ``eps``: (3, 3) in F/m.
    """
    stress, volts = abs(c[0, 0]), np.sqrt(abs(c[0, 0]) / abs(eps[0, 0]))  # scale phi and D
    full = np.zeros((4, 3, 3, 4), dtype=complex)  # T_j of column i: D as a fourth row of the stress, phi of u
    full[:3, :, :, :3] = c[VOIGT][:, :, VOIGT].transpose(0, 1, 3, 2) / stress
    coupling = e[:, VOIGT] * volts / stress  # e_jkl
    full[:3, :, :, 3] = coupling.transpose(1, 2, 0)
    full[3, :, :, :3] = coupling.transpose(0, 2, 1)
    full[3, :, :, 3] = -eps * volts**2 / stress
    q, r, t = full[:, 0, 0], full[:, 0, 2], full[:, 2, 2]
    inertia = np.diag([density / stress] * 3 + [0.0]) * omega**2
    k = np.asarray(wavenumbers, dtype=float)
    inverse = np.linalg.inv(t)
    problem = np.zeros((len(k), 8, 8), dtype=complex)  # of (u, u' / i k) for u exp(-i k p z)
    problem[:, :4, 4:] = np.eye(4)
    problem[:, 4:, :4] = inverse @ (inertia / k[:, None, None] ** 2 - q)
    problem[:, 4:, 4:] = -inverse @ (r + r.T)
    roots, vectors = np.linalg.eig(problem)
    order = np.argsort(-(roots * k[:, None]).imag, axis=1)[:, :4]  # those that decay at z -> -infinity
    p = np.take_along_axis(roots, order, axis=1)
    a = np.take_along_axis(vectors[:, :4], order[:, None], axis=2)
    traction = -1j * k[:, None, None] * (r.T @ a + t @ (a * p[:, None, :]))  # T_zj and D_z
    load = np.array([0, 0, 0, -volts / stress])[:, None]  # D_z inside is minus the charge
    u = (a @ np.linalg.solve(traction, np.broadcast_to(load, (len(k), 4, 1))))[:, :, 0]
    return u * np.array([1.0, 1.0, 1.0, volts])


class FingerStrips:
    """Fingers of one width on a half-space; lengths in m, ``solid``: (c, e, eps, density)."""

    TERMS, NODES = 6, 10  # Chebyshev polynomials on a finger, and nodes that integrate them
    REACH, POINTS = 40.0, 12  # largest k over the slowest wave's; points of a Gauss panel

    def __init__(self, solid, frequency, centers, half_width, slowest, panels):
        """``slowest``: velocity below all waves', m/s; ``panels`` of the axis where there are waves."""
        self.panels = panels
        self.solid, self.omega = solid, 2 * np.pi * frequency
        self.centers, self.half_width = np.asarray(centers), half_width
        self.unit = self.omega / slowest  # a wavenumber above all waves'

    @cached_property
    def _axis(self):
        """Positive wavenumbers and weights: equal panels where there are waves, growing ones beyond."""
        far = 2.6 * np.exp(np.linspace(0, np.log(self.REACH / 2.6), 40))
        edges = [
            np.geomspace(1e-5, 1e-3, 12),
            np.linspace(0, 1.3, self.panels),
            np.linspace(1.3, 2.6, self.panels // 3),
            far,
        ]
        edges = np.concatenate(edges)
        edges = self.unit * np.unique(edges)
        x, w = np.polynomial.legendre.leggauss(self.POINTS)
        half = np.diff(edges) / 2
        return ((edges[:-1] + half)[:, None] + half[:, None] * x).ravel(), np.outer(half, w).ravel()

    @cached_property
    def _responses(self):
        k, _ = self._axis
        return [surface_response(*self.solid, self.omega, sign * k) for sign in (1, -1)]

    @cached_property
    def _singular(self):
        """Factors of 1 / |k|: that at large k, and what is added at small k."""
        large = surface_response(*self.solid, self.omega, [1e4 * self.unit])[0, 3] * 1e4 * self.unit
        small = surface_response(*self.solid, self.omega, [1e-6 * self.unit])[0, 3] * 1e-6 * self.unit
        return large, small - large

    def _smooth(self, x):
        """Potential at x of a line of 1 C/m without its logarithm; up to a constant."""
        (k, w), (large, extra) = self._axis, self._singular
        width = 2.0 / self.unit
        shape = (large + extra * np.exp(-k * width)) / k
        total = np.zeros(len(x), dtype=complex)
        for response, sign in zip(self._responses, (1, -1), strict=True):
            rest = w * (response[:, 3] - shape)
            for some in np.array_split(np.arange(len(x)), max(1, len(x) // 200)):
                total[some] += np.exp(-1j * sign * np.outer(x[some], k)) @ rest
        return total / (2 * np.pi) - extra * np.log(x**2 + width**2) / (2 * np.pi)

    @cached_property
    def matrix(self):
        """Potential, tested with polynomials, of charges; shape (fingers, terms, fingers, terms); up to a constant."""
        n, m = self.TERMS, self.NODES
        nodes = np.cos(np.pi * (np.arange(m) + 0.5) / m)
        basis = np.cos(np.outer(np.arccos(nodes), np.arange(n))) / m
        large, a = self._singular[0], self.half_width
        offsets = a * (nodes[:, None] - nodes[None, :])
        made, out = {}, np.zeros((len(self.centers), n, len(self.centers), n), dtype=complex)
        own = np.diag(np.concatenate([[np.log(2.0)], 1 / (2.0 * np.arange(1, n))])) - np.outer(
            np.eye(n)[0], np.eye(n)[0]
        ) * np.log(a)
        for i, j in np.ndindex(len(self.centers), len(self.centers)):
            distance = self.centers[i] - self.centers[j]
            key = round(distance / a * 1e6)
            if key not in made:
                x = (distance + offsets).ravel()
                values = self._smooth(x).reshape(m, m)
                if key:
                    values = values - large * np.log(abs(x)).reshape(m, m) / np.pi
                made[key] = basis.T @ values @ basis + (0 if key else large * own / np.pi)
            out[i, :, j] = made[key]
        return out

    def charges(self, electrode):
        """Coefficients (fingers, terms) in C/m for half a volt and minus half a volt on electrodes +1 and -1."""
        count, n = len(self.centers), self.TERMS
        size = count * n
        scale = abs(self.matrix).max()
        system = np.zeros((size + 1, size + 1), dtype=complex)
        system[:size, :size] = self.matrix.reshape(size, size) / scale
        system[:size:n, size] = system[size, :size:n] = 1.0  # a common potential: no net charge
        load = np.zeros(size + 1)
        load[:size:n] = np.asarray(electrode) / 2 / scale
        return np.linalg.solve(system, load)[:size].reshape(count, n)

    def motion(self, coefficients, places):
        """u_x, u_y and u_z in m at places outside the fingers, shape (places, 3)."""
        from scipy.special import jv

        k, w = self._axis
        kept = k < 2.6 * self.unit  # beyond all waves the spectrum is smooth: faded out, it matters only nearby
        k, w = (k[kept], w[kept] * np.cos(np.pi / 2 * np.clip((k[kept] / self.unit - 1.3) / 1.3, 0, 1) ** 2) ** 2)
        orders = np.arange(self.TERMS)
        out = np.zeros((len(places), 3), dtype=complex)
        for response, sign in zip(self._responses, (1, -1), strict=True):
            # transform of T_n(s) / (pi a sqrt(1 - s^2)): int exp(i k x) = i^n J_n(k a)
            bessel = jv(orders, sign * k[:, None] * self.half_width) * 1j**orders
            charge = np.sum((np.exp(1j * sign * np.outer(k, self.centers)) @ coefficients) * bessel, axis=1)
            waves = np.exp(-1j * sign * np.outer(places, k))
            out += waves @ ((w * charge)[:, None] * response[kept, :3])
        return out / (2 * np.pi)
