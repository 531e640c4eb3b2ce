"""Quadrature over the lateral wavenumber k_y: contour, nodes and weights of the inverse Fourier transform.

The integrand has branch points at k_y = +-k_p near the real axis.  The contour of integration

    k_y = t +- i D tanh(t / 3 D)

stays away from them (+ for modes whose phase and group velocities have the same direction, - for backward modes).  The
integrand is analytic in a strip about the contour.  The trapezoidal rule with steps h in t therefore converges
exponentially, as exp(-2 pi D / h) (Trefethen and Weideman, SIAM Review 56 (2014) 385), and with half as many nodes the
error is the square root of that.  On the contour the integrand is larger by a factor up to exp(D r), with r the largest
distance along y from a point to the far end of the aperture, which limits D.

Between two side faces that reflect like mirrors the field is periodic in y, and the integral becomes a sum over
k_y = 2 pi n / width.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

GROWTH = 4.0  # D r; half or twice this value needs 1.5 times as many nodes
MAX_TILT = 0.04  # largest D over the largest wavenumber; it matters if the aperture is a few wavelengths only
# h / D: the error is 1e-8 on Feenstra and Breedveld's stator, and 1e-4 with half as many nodes.
SPACING = 0.36
ROUNDING = 1e-9  # |Im kappa| / |kappa| of a mode without loss, by rounding
# Rules of `inverse_transform`: all nodes, every second, every fourth, and one that ends at a smaller k_y.
RULES = 4
CHUNK = 2000  # points at which spectra are tabulated at a time, to limit memory
# The motion is computed on the whole grid of all x and y if that has at most this many points per requested point.
FULL_GRID = 4
EVANESCENT = (13.0, 20.0)  # exponents of the decay along x between which evanescent k_y are faded out


@dataclass(frozen=True, kw_only=True)
class LateralRule:
    """Quadrature rule on the half-line t >= 0.

    The weights contain 1/pi, so that the rule gives the integral of an even integrand over the whole line, over 2 pi.

    Attributes
    ----------
    nodes, weights : ndarray, shape (n,)
        In rad/m, complex.  Every second or fourth node with twice or four times its weight is a coarser rule.
    share : ndarray, shape (n,)
        Factors of the weights that give a rule which ends at smaller k_y; 1 without such a rule.
    """

    nodes: np.ndarray = field(repr=False)
    weights: np.ndarray = field(repr=False)
    share: np.ndarray | float = field(default=1.0, repr=False)

    @property
    def conjugate(self) -> "LateralRule":
        """The same rule with its contour mirrored at the real axis."""
        return LateralRule(nodes=self.nodes.conj(), weights=self.weights.conj(), share=self.share)

    def contours(self, wavenumbers: np.ndarray) -> Iterator[tuple[np.ndarray, "LateralRule"]]:
        """Masks of the forward and of the backward modes (Re k at k_y = 0), each with the rule on their contour."""
        yield wavenumbers.real >= 0, self
        yield wavenumbers.real < 0, self.conjugate


# For fields that do not depend on y.
PLANE = LateralRule(nodes=np.zeros(1), weights=np.ones(1))


def lateral_rule(
    highest: float,
    reach: float,
    fade: tuple[float, float],
    mirror_width: float | None = None,
    *,
    coarser: float = 1.0,
    halvings: int = 0,
    max_tilt: float = MAX_TILT,
    narrow: tuple[float, float] | None = None,
    cusp: bool = False,
) -> LateralRule:
    """Nodes and weights of the integral over k_y.

    Parameters
    ----------
    highest : float
        Square root of the largest real part of k_p^2, rad/m: beyond it all modes are evanescent along x.
    reach : float
        Half the aperture plus the largest |y|, m.
    fade : tuple of float
        Lateral wavenumbers, rad/m, between which the integrand is faded out (`evanescent`).
    mirror_width : float, optional
        Distance in m of two faces y = const that reflect.  The rule is then an exact sum and has no coarser rule.
    coarser : float
        Factor on the spacing of the nodes, for integrands that are expensive to evaluate.
    halvings : int
        How often this spacing is halved; every second node is then one of the rule with one halving less, bit for bit.
    max_tilt : float
        Largest distance of the contour from the real axis over ``highest``.
    narrow : tuple of float, optional
        The same as ``fade`` for the rule that ends at smaller k_y.
    cusp : bool
        True if the integrand depends on |k_y|.  The rule is then uniform in s, t = s^3 / (s^2 + D^2), where the cusp
        becomes |s|^5 and leaves an error of h^6 instead of h^2.

    Returns
    -------
    LateralRule
    """
    if mirror_width is not None:
        nodes = np.arange(int(fade[1] * mirror_width / (2 * np.pi)) + 1) * (2 * np.pi / mirror_width)
        weights = 2 / mirror_width * _faded(nodes, *fade)
        weights[0] *= 0.5
        return LateralRule(nodes=nodes, weights=weights, share=1.0 if narrow is None else _faded(nodes, *narrow))
    offset = min(GROWTH / reach, max_tilt * highest)
    scale = 3.0 * offset
    start, stop = (each + scale for each in fade)
    count = 4 * int(np.ceil(stop / (coarser * SPACING * offset) / 4)) * 2**halvings
    t = np.linspace(0.0, stop, count + 1)
    weights = np.full(count + 1, t[1] / np.pi)
    if cusp:
        square = t**2 / (t**2 + offset**2)
        t, weights = t * square, weights * square * (3 - 2 * square)
    weights *= _faded(t, start, stop)
    weights[0] *= 0.5
    tilt = np.tanh(t / scale)
    return LateralRule(
        nodes=t + 1j * offset * tilt,
        weights=weights * (1.0 + 1j * (offset / scale) * (1.0 - tilt**2)),
        share=1.0 if narrow is None else _faded(t, *(each + scale for each in narrow)),
    )


class Waves(Protocol):
    """Waves at the nodes of a quadrature rule."""

    @property
    def rule(self) -> LateralRule:
        """The rule."""

    @property
    def signs(self) -> tuple:
        """Signs of k_y for which the waves hold, each with its factors of u_x, u_y and u_z."""


class Points(NamedTuple):
    """Points of the surface, in which x and y occur repeatedly: number i is (x[column[i]], y[line[i]]), m."""

    x: np.ndarray
    y: np.ndarray
    column: np.ndarray
    line: np.ndarray

    @classmethod
    def of(cls, x: np.ndarray, y: np.ndarray) -> "Points":
        """Return the points of coordinates in m, two arrays of one dimension."""
        (distinct_x, column), (distinct_y, line) = (np.unique(each, return_inverse=True) for each in (x, y))
        return cls(distinct_x, distinct_y, column, line)


def inverse_transform(
    waves: Waves, sheets: list, points: Points, spectra: Callable[[np.ndarray], np.ndarray], thinned: bool
) -> np.ndarray:
    """Inverse Fourier transform of the motion u from k_y to y, by all RULES, shape (RULES, 3, points).

    A sheet of length W about y_0 has the spectrum s(k_y) of `sheet_spectrum` times exp(i k_y y_0), and

        u(x, y) = sum over both signs of k_y and the nodes n of  w_n / 2  u^(x, k_y) exp(-i k_y y),

    where ``spectra`` maps the spectra s of the sheets, (sheets, n), to the spectra u^ at the different x, (x, 3,
    n).  ``thinned``: False between mirrors, where the sum is exact and the first three rules are the same.
    """
    column, line = points.column, points.line
    sent, count = None, len(column)
    lateral, weights = waves.rule.nodes, waves.rule.weights / 2
    narrow = None if np.all(waves.rule.share == 1.0) else weights * waves.rule.share
    lengths, centers = (np.array([getattr(each, name) for each in sheets]) for name in ("length", "center"))
    uniform = sheet_spectrum(lengths, lateral)
    total = np.zeros((RULES, 3, count), dtype=complex)
    for sign, factors in waves.signs:
        # sheets centred on y = 0 have the same spectrum at both signs of k_y: the sum over the charges is done once
        if sent is None or centers.any():
            sent = spectra(uniform * np.exp(1j * sign * np.outer(centers, lateral)))
        phases = np.exp(-1j * sign * np.outer(lateral, points.y))
        # every second node has twice the weight; between mirrors no rule is thinned
        half, quarter = (2, 4) if thinned else (1, 1)
        rules = (1, weights), (half, half * weights), (quarter, quarter * weights), (1, narrow)
        for rule, (step, of_rule) in enumerate(rules):
            if of_rule is None:
                total[rule] = total[0]
                continue
            weighted = factors[:, None] * sent[..., ::step] * of_rule[::step]
            # where most pairs (x, y) are requested, a matrix product for all pairs is cheaper than a sum per point
            if len(sent) * len(points.y) <= FULL_GRID * count:
                total[rule] += (weighted @ phases[::step])[column, :, line].T
            else:
                for start in range(0, count, CHUNK):
                    chunk = slice(start, start + CHUNK)
                    x_part, y_part = weighted[column[chunk]], phases[::step, line[chunk]]
                    total[rule][:, chunk] += np.einsum("pcn,np->cp", x_part, y_part)
    return total


def wavenumber_along(wavenumbers: complex | np.ndarray, lateral: complex | np.ndarray) -> np.ndarray:
    """Wavenumbers along x, kappa = (k^2 - k_y^2)^(1/2), of modes that run to the right.

    Parameters
    ----------
    wavenumbers : complex or ndarray
        k at k_y = 0; Re k < 0 for backward modes, whose phase runs to the left.
    lateral : ndarray
        k_y in the same unit, broadcast against k.

    Returns
    -------
    ndarray
        The root whose phase runs in the direction of that at k_y = 0, or the one that decays if that grows.
    """
    kappa = np.where(np.real(wavenumbers) < 0, -1, 1) * np.sqrt(wavenumbers**2 - lateral**2 + 0j)
    return np.where(kappa.imag > ROUNDING * abs(kappa), -kappa, kappa)


def amplitude_ratio(
    wavenumbers: complex | np.ndarray, along: np.ndarray, *, tangential: bool = False
) -> np.ndarray | float:
    """Amplitude of oblique modes over that of the same modes at k_y = 0: k / kappa, with kappa = ``along``.

    It is 1 for a force along x (``tangential``), of which the part kappa / k acts along the wave vector.
    """
    return 1.0 if tangential else wavenumbers / along


def sheet_spectrum(lengths: float | np.ndarray, lateral: np.ndarray) -> np.ndarray:
    """Fourier transform W sinc(k_y W / 2) of 1 on |y| < W / 2, in m, shape (*lengths, nodes)."""
    return np.asarray(lengths)[..., None] * np.sinc(np.multiply.outer(lengths, lateral / (2 * np.pi)))


def highest_wavenumber(wavenumbers: np.ndarray) -> float:
    """Square root of the largest real part of k^2: the lateral wavenumber beyond which all modes are evanescent."""
    return float(np.sqrt((wavenumbers**2).real.max()))


def rounded_reach(reach: float) -> float:
    """Reach along y rounded up to a power of the root of 2, so that few rules serve all points."""
    return float(2.0 ** (np.ceil(2 * np.log2(reach)) / 2))


def evanescent(highest: float, distance: float) -> tuple[float, float]:
    """Lateral wavenumbers beyond the decay of all waves at a distance in m: start and end of the fade-out."""
    low, high = (float(np.hypot(highest, each / distance)) for each in EVANESCENT)
    return low, high


def _faded(t: np.ndarray, start: float, stop: float) -> np.ndarray:
    """Smooth step from 1 at ``start`` to 0 at ``stop``, by the complementary error function."""
    return np.array([0.5 * math.erfc(5.0 * (2.0 * (each - start) / (stop - start) - 1.0)) for each in t])
