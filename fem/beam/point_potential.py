"""Electric potential of a point charge on the bare surface, and of uniformly charged strips along y.

In a solid isotropic about z a mode g_p exp(-i k_p |x|) of a line source becomes g_p k_p H_0(k_p r) / 2 for a point
source (H: Hankel functions of the second kind), and the term s |x| of the pole at k = 0 becomes (s / pi) log r.  Their
sum G(r) is tabulated once by Chebyshev polynomials on intervals, whose lengths grow geometrically from the smallest
distance up to half a wavelength and are constant from there on.

The potential of a charge that is uniform on |y| < A / 2, integrated over |y| < B / 2 at a distance x, is the integral
of G over the correlation of the two intervals, which is a trapezium.  With a = (A + B) / 2 and b = |A - B| / 2,

    K_AB(x) = T(a, x) - T(b, x),    T(h, x) = 2 int_0^h (h - y) G((x^2 + y^2)^(1/2)) dy.                        (1)

If h is many wavelengths long, and Z is the potential of a line of charge, then

    T(h, x) = h Z - 2 int_0^oo y G dy + 2 int_h^oo (y - h) G dy.                                                (2)

For a mode the second term is g_p x H_1(k_p x), because int r H_0(k r) dr = r H_1(k r) / k.  The third is integrated
along the path of steepest descent from y = h,

    y = h - i (R / h) s / k,    R^2 = x^2 + h^2,    where exp(-i k r) = exp(-i k R) exp(-s) to first order in s,  (3)

by Gauss and Laguerre's rule.  The pole at k = 0, with r = (x^2 + y^2)^(1/2), has closed integrals:

    int_0^h log r dy = h log R - h + x arctan(h / x),
    int_0^h y log r dy = (R^2 log R - x^2 log x) / 2 - h^2 / 4.                                                 (4)
"""

from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebint, chebvander

from fem.analytic.hankel import scaled_hankel
from fem.beam.line_source import LineSource
from fem.discretize.spectral import chebyshev_nodes

TERMS = 12  # of the polynomials on an interval of r and on a panel of y: accurate to 1e-10
# m: at smaller distances G is constant.  The sum of modes has a logarithm at 0, so that 1e-8 m gives an error of 1 % in
# T(h, 0).
SMALLEST = 1e-12
DECAYED = 45.0  # a Hankel function is neglected if its exponent exceeds this
SERIES = 2e-4  # |z| below which H_0 = 1 - 2i/pi (log(z / 2) + Euler's constant) is accurate to 1e-8
# Largest number of half wavelengths up to the longest h, times the number of distances, for integration over panels;
# beyond it the path of steepest descent is used.
MAX_PANELS = 300_000
LAGUERRE = 12  # nodes on the path of steepest descent: 1e-10

UNIT_NODES = chebyshev_nodes(-1.0, 1.0, TERMS)
TO_COEFFICIENTS = np.linalg.inv(chebvander(UNIT_NODES, TERMS - 1))  # of Chebyshev polynomials, from values at the nodes
laguerre_rule = cache(np.polynomial.laguerre.laggauss)


class Panels:
    """Intervals of r between two distances in m, with Chebyshev nodes, on which a function of r is a polynomial.

    Their lengths double from the smallest distance up to half a wavelength, and are constant from there on.
    """

    def __init__(self, half_wavelength: float, nearest: float, farthest: float):
        self.half_wavelength = half = half_wavelength
        self.halvings = max(int(np.ceil(np.log2(half / max(nearest, SMALLEST)))), 0)
        self.edges = np.append(
            half * 2.0 ** np.arange(-self.halvings, 0), half * np.arange(1, int(farthest / half) + 3)
        )
        low, high = self.edges[:-1, None], self.edges[1:, None]
        self.nodes = ((low + high) / 2 + (high - low) / 2 * UNIT_NODES).ravel()  # those of each panel together

    @classmethod
    def of(cls, source: LineSource, nearest: float, farthest: float) -> "Panels":
        """For functions that oscillate as the modes of a source do."""
        k = source.wavenumbers
        highest = max(float((k**2).real.max()), float(abs(k).min()) ** 2)
        return cls(np.pi / np.sqrt(highest), nearest, farthest)

    def places(self, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Number of the panel of each distance in m, and the place on it from -1 to 1."""
        r = np.maximum(distances, self.edges[0])
        exponent = np.floor(np.log2(np.minimum(r / self.half_wavelength, 1.0))).astype(int)
        piece = self.halvings + np.where(exponent < 0, exponent, np.floor(r / self.half_wavelength).astype(int) - 1)
        low, high = self.edges[piece], self.edges[piece + 1]
        return piece, (2 * r - low - high) / (high - low)

    def interpolation(self, distances: np.ndarray) -> Any:
        """Matrix (distances, nodes) from values at the nodes to those at distances in m, (distances,)."""
        from scipy.sparse import csr_array  # its import takes longer than a run

        piece, local = self.places(distances)
        weights = chebvander(local, TERMS - 1) @ TO_COEFFICIENTS
        columns = piece[:, None] * TERMS + np.arange(TERMS)
        return csr_array(
            (weights.ravel(), columns.ravel(), np.arange(len(local) + 1) * TERMS), (len(local), self.nodes.size)
        )


class PointPotential:
    """G(r) in V per C, tabulated between two distances in m; an additive constant is arbitrary."""

    def __init__(self, source: LineSource, nearest: float, farthest: float):
        self.source, self.panels = source, Panels.of(source, nearest, farthest)
        self.half_wavelength, nodes = self.panels.half_wavelength, self.panels.nodes
        values = np.empty(len(nodes), dtype=complex)
        from_nearest = np.argsort(nodes)
        values[from_nearest] = _sum_of_modes(source, nodes[from_nearest])
        self._coefficients = TO_COEFFICIENTS @ values.reshape(-1, TERMS).T

    def __call__(self, distances: np.ndarray) -> np.ndarray:
        """G at distances in m, an array of any shape."""
        piece, local = self.panels.places(distances)
        twice = 2 * local
        last, before = self._coefficients[-1][piece], 0.0  # Clenshaw's recurrence
        for term in range(TERMS - 2, 0, -1):
            last, before = self._coefficients[term][piece] + twice * last - before, last
        return self._coefficients[0][piece] + twice / 2 * last - before


class StripPotential:
    """T(h, x) in V m2 per C at distances x in m, for any lengths h up to ``longest`` in m."""

    def __init__(self, source: LineSource, distances: np.ndarray, longest: float):
        self.source, self.x, self.longest = source, distances, longest
        self.point = PointPotential(source, distances.min(), float(np.hypot(distances.max(), longest)))

    def __call__(self, lengths: np.ndarray) -> np.ndarray:
        """T for lengths in m, shape (lengths, distances)."""
        near = lengths < self._longest_near
        out = np.empty((len(lengths), len(self.x)), dtype=complex)
        if near.any():
            charge, moment = self._near(lengths[near])
            out[near] = 2 * (lengths[near, None] * charge - moment)
        if not near.all():
            charge, moment = self._far(np.append(lengths[~near], self.longest))
            value, slope = _wide(self.source, self.x, self.longest)
            shorter = self.longest - lengths[~near, None]
            beyond = (moment[-1] - moment[:-1]) - lengths[~near, None] * (charge[-1] - charge[:-1])
            out[~near] = value - shorter * slope + 2 * beyond
        return out

    @property
    def _longest_near(self) -> float:
        """Length below which G is integrated over panels from y = 0, m."""
        direct = self.longest / self.point.half_wavelength * len(self.x) < MAX_PANELS
        return np.inf if direct else self.longest / 4

    @cached_property
    def _near(self) -> "_Antiderivatives":
        """Integrals from y = 0; towards it the panels shrink to a quarter of the smallest distance."""
        half, stop = self.point.half_wavelength, min(self._longest_near, self.longest)
        halvings = int(np.ceil(np.log2(half / max(self.x.min() / 4, SMALLEST))))
        shrinking = half * 2.0 ** np.arange(-halvings, 0)
        edges = np.concatenate([[0.0], shrinking, half * np.arange(1, stop / half)])
        return _Antiderivatives(self.point, self.x, np.append(edges[edges < stop], stop))

    @cached_property
    def _far(self) -> "_Antiderivatives":
        """Integrals from a quarter of the longest length."""
        count = int(0.75 * self.longest / self.point.half_wavelength) + 2
        return _Antiderivatives(self.point, self.x, np.linspace(self.longest / 4, self.longest, count))


class _Antiderivatives:
    """Integrals of G dy and y G dy at distances x, from the first of the ``edges`` of panels along y (m).

    On each panel the integrand is a Chebyshev polynomial, whose antiderivative gives the integral up to any y.
    """

    def __init__(self, point: PointPotential, x: np.ndarray, edges: np.ndarray):
        self.edges, self.half_widths = edges, np.diff(edges) / 2
        y = edges[:-1, None] + self.half_widths[:, None] * (UNIT_NODES + 1)
        g = point(np.hypot(x, y[..., None]))  # (panels, TERMS, x)
        self.integrands = g, g * y[..., None]
        self.from_values = chebint(np.eye(TERMS), lbnd=-1) @ TO_COEFFICIENTS

    def __call__(self, stops: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Both integrals up to the positions ``stops`` along y in m, shape (stops, x) each."""
        panel = np.clip(np.searchsorted(self.edges, stops) - 1, 0, len(self.half_widths) - 1)
        local = (stops - self.edges[panel]) / self.half_widths[panel] - 1
        weights = chebvander(local, TERMS) @ self.from_values * self.half_widths[panel, None]
        whole = self.from_values.sum(axis=0)  # up to the end of a panel, where all polynomials are 1
        results = []
        for integrand in self.integrands:
            before = np.cumsum(self.half_widths[:, None] * np.tensordot(whole, integrand, axes=(0, 1)), axis=0)
            out = np.append(np.zeros((1, before.shape[1])), before, axis=0)[panel]
            for each in set(panel.tolist()):
                out[panel == each] += weights[panel == each] @ integrand[each]
            results.append(out)
        return results[0], results[1]


def _wide(source: LineSource, x: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """T(h, x) by (2) for a length h of many wavelengths, and its derivative with respect to h, shape (x,) each."""
    reach = np.hypot(x, h)  # R
    # the pole at k = 0, by (4)
    angle, squares = x * np.arctan2(h, x), x**2 * np.log(np.where(x > 0, x, 1.0))
    log_integral = h * np.log(reach) - h + angle
    static = 2 * source.slope / np.pi
    value = static * (h * log_integral - (reach**2 * np.log(reach) - squares) / 2 + h**2 / 4) + 0j
    derivative = static * log_integral + 0j
    s, weights = laguerre_rule(LAGUERRE)
    for k, potential in zip(source.wavenumbers, source.potential, strict=True):
        line = np.exp(-1j * k * x)  # Z over g_p
        second = np.full(len(x), 2j / np.pi / k)  # x H_1(k x), its limit at x = 0
        some = (abs(k) * x > SERIES) & (-k.imag * x < DECAYED)
        second[some] = x[some] * line[some] * scaled_hankel(1, k * x[some])
        second[-k.imag * x >= DECAYED] = 0.0
        value += potential * (h * line + second)
        derivative += potential * line
        if -k.imag * h < DECAYED:  # the third term, with y - h = ``path`` of (3)
            path = -1j * (reach / h)[:, None] * s / k
            z = k * np.sqrt(reach[:, None] ** 2 + path * (2 * h + path))
            integrand = scaled_hankel(0, z) * np.exp(s - 1j * (z - (k * reach)[:, None])) * weights
            integrand *= (-1j * reach / h * np.exp(-1j * k * reach))[:, None] * potential
            value += np.sum(integrand * path, axis=1)
            derivative -= np.sum(integrand, axis=1)
    return value, derivative


def _sum_of_modes(source: LineSource, r: np.ndarray) -> np.ndarray:
    """G at increasing distances, shape (n,)."""
    k, potentials = source.wavenumbers, source.potential
    total = source.slope / np.pi * np.log(r).astype(complex)
    decay = np.maximum(-k.imag, DECAYED / np.finfo(float).max)  # the quotient of a wave without decay is finite
    reached = np.searchsorted(r, DECAYED / decay)  # number of distances
    z = np.concatenate([mode * r[:count] for mode, count in zip(k, reached, strict=True)])  # all modes at once
    small = abs(z) < SERIES
    hankel = np.empty_like(z)
    hankel[small] = 1 - 2j / np.pi * (np.log(z[small] / 2) + np.euler_gamma)
    hankel[~small] = np.exp(-1j * z[~small]) * scaled_hankel(0, z[~small])
    for mode, potential, own in zip(k, potentials, np.split(hankel, np.cumsum(reached)[:-1]), strict=True):
        total[: len(own)] += potential * mode / 2 * own
    return total
