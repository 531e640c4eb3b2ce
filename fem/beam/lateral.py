"""Inverse transform over the lateral wavenumber k_y.

The integrand has branch points at k_y = +-k_p near the real axis, from which a contour

    k_y = t +- i D tanh(t / 3 D)

keeps its distance (+ for modes whose phase runs along their power, - for the others).  It is analytic in a strip about
the contour, so that the trapezoidal rule in t converges exponentially, as exp(-2 pi D / h) (Trefethen and Weideman,
SIAM Review 56 (2014) 385), and half as many nodes leave the square root of its error.  The factor exp(D r) by which
the integrand grows, r the farthest lateral distance from a point to the aperture, bounds D.

Between two faces that reflect like mirrors the field is periodic in y: a sum over k_y = 2 pi n / width.
"""

import math
from dataclasses import dataclass, field

import numpy as np

GROWTH = 4.0  # D r; half or twice as much takes 1.5 times as many nodes
MAX_TILT = 0.04  # D over the largest wavenumber, where the aperture is a few wavelengths only
SPACING = 0.36  # h / D: 1e-8 on Feenstra and Breedveld's stator; half as many nodes give 1e-4
EVANESCENT = (13.0, 20.0)  # exponents between which evanescent k_y are faded out


@dataclass(frozen=True, kw_only=True)
class LateralRule:
    """Nodes for the half-line t >= 0 and weights that contain 1/pi (even integrands over the whole line, over 2 pi).

    Attributes
    ----------
    nodes, weights : ndarray, shape (n,)
        rad/m, complex; every second and every fourth node are rules too, with twice and four times the weights.
    share : ndarray, shape (n,)
        Of the weights that is left where the integral fades out earlier; all without such a rule.
    """

    nodes: np.ndarray = field(repr=False)
    weights: np.ndarray = field(repr=False)
    share: np.ndarray | float = field(default=1.0, repr=False)

    @property
    def conjugate(self) -> "LateralRule":
        """The same rule below the real axis."""
        return LateralRule(nodes=self.nodes.conj(), weights=self.weights.conj(), share=self.share)


def lateral_rule(
    highest: float,
    reach: float,
    fade: tuple[float, float],
    mirror_width: float | None = None,
    *,
    coarser: float = 1.0,
    max_tilt: float = MAX_TILT,
    narrow: tuple[float, float] | None = None,
) -> LateralRule:
    """Nodes and weights of the integral over k_y.

    Parameters
    ----------
    highest : float
        Square root of the largest real part of k_p^2, rad/m: beyond it all modes are evanescent along x.
    reach : float
        Half the aperture and the largest |y| together, m.
    fade : tuple of float
        Lateral wavenumbers, rad/m, between which the integrand is faded out.
    mirror_width : float, optional
        Distance in m of two faces y = const that reflect; the rule is then the exact sum and has no coarser one.
    coarser : float
        Factor of the nodes' spacing, where a node is dear.
    max_tilt : float
        Largest distance of the contour from the real axis over ``highest``.
    narrow : tuple of float, optional
        As ``fade``, of the rule's narrower weights.

    Returns
    -------
    LateralRule
    """
    if mirror_width is not None:
        nodes = np.arange(int(fade[1] * mirror_width / (2 * np.pi)) + 1) * (2 * np.pi / mirror_width)
        weights = 2 / mirror_width * _faded(nodes, *fade)
        weights[0] *= 0.5
        return LateralRule(
            nodes=nodes, weights=weights, share=1.0 if narrow is None else _faded(nodes, *narrow)
        )
    offset = min(GROWTH / reach, max_tilt * highest)
    scale = 3.0 * offset
    start, stop = (each + scale for each in fade)
    count = 4 * int(np.ceil(stop / (coarser * SPACING * offset) / 4))
    t = np.linspace(0.0, stop, count + 1)
    weights = t[1] / np.pi * _faded(t, start, stop)
    weights[0] *= 0.5
    tilt = np.tanh(t / scale)
    return LateralRule(
        nodes=t + 1j * offset * tilt,
        weights=weights * (1.0 + 1j * (offset / scale) * (1.0 - tilt**2)),
        share=1.0 if narrow is None else _faded(t, *(each + scale for each in narrow)),
    )


def evanescent(highest: float, distance: float) -> tuple[float, float]:
    """Lateral wavenumbers between which all that is left at a distance in m fades out."""
    low, high = (float(np.hypot(highest, each / distance)) for each in EVANESCENT)
    return low, high


def _faded(t: np.ndarray, start: float, stop: float) -> np.ndarray:
    return np.array([0.5 * math.erfc(5.0 * (2.0 * (each - start) / (stop - start) - 1.0)) for each in t])
