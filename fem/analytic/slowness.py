"""Slowness curve of a surface wave, and the angular spectrum of an aperture on it.

The curve is the wavenumber along x as a function of the lateral wavenumber.  Its slope at zero steers a beam, its
curvature says how fast the beam spreads (M. G. Cohen, J. Appl. Phys. 38 (1967) 3821).
"""

import math
from dataclasses import dataclass

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.materials import Solid, isotropic_about_normal, rotated

SPECTRUM_END, FADE_START = 0.35, 0.25  # lateral wavenumbers of the angular spectrum, over the wavenumber along x
_SPECTRUM = 400  # lateral wavenumbers on either side
_DIRECTIONS = 32  # of the curve, within 25 degrees: 16 leave 0.13 of the curvature in YZ lithium niobate
_ANGLES = math.radians(25) * np.cos(np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS)


@dataclass(frozen=True, kw_only=True)
class Slowness:
    """Wavenumber along x of a surface wave as a polynomial in the lateral wavenumber, both rad/m.

    Examples
    --------
    >>> from fem import material
    >>> curve = Slowness.of_half_space(rotated(material("LiNbO3 (Kovacs)"), "128YX"), 9.6e6)
    >>> round(curve.curvature, 1)
    -0.3
    >>> curve.spectrum(8e-3, [1e-4], [0.0]).round(1)  # at a wide aperture
    array([1.])
    """

    along: np.polynomial.Chebyshev

    @classmethod
    def through(cls, lateral: np.ndarray, along: np.ndarray) -> "Slowness":
        """Return the curve through wavenumbers, by least squares."""
        return cls(along=np.polynomial.Chebyshev.fit(lateral, along, len(lateral) - 3))

    @classmethod
    def of_half_space(cls, solid: Solid, frequency: float, surface: str = "vacuum") -> "Slowness":
        """Return the curve of the Rayleigh wave of a half-space, at a frequency in Hz; see `rayleigh` for the rest."""
        if isotropic_about_normal(solid):
            return cls.circle(2 * math.pi * frequency / rayleigh(solid, surface).velocity)
        turned = [rotated(solid, (degrees, 0.0, 0.0)) for degrees in np.degrees(_ANGLES)]
        k = 2 * math.pi * frequency / np.array([rayleigh(each, surface).velocity for each in turned])
        return cls.through(k * np.sin(_ANGLES), k * np.cos(_ANGLES))

    @classmethod
    def circle(cls, wavenumber: float) -> "Slowness":
        """Return the curve of a wave of the same velocity in all directions; ``wavenumber`` in rad/m."""
        return cls.through(wavenumber * np.sin(_ANGLES), wavenumber * np.cos(_ANGLES))

    @property
    def steering(self) -> float:
        """Tangent of the power-flow angle of the wave along x."""
        return float(-self.along.deriv()(0.0).real)

    @property
    def curvature(self) -> float:
        """Curvature -k k'' - 1 of the slowness curve k(k_y) at k_y = 0: 0 for a circle, -1 for a straight line."""
        return float(-self.along.deriv(2)(0.0).real * self.along(0.0).real - 1)

    def spectrum(self, aperture: float, away, lateral) -> np.ndarray:
        """Return the amplitude of a uniform aperture (m) over that of a plane wave.

        Parameters
        ----------
        away : array_like
            Distance along x from the aperture, m; negative for the wave that runs to the left.
        lateral : array_like
            Distance from the beam's axis along y, m.
        """
        away, lateral = np.asarray(away), np.asarray(lateral) * np.sign(away)
        k = self.along(0.0).real
        t, step = np.linspace(-SPECTRUM_END * k, SPECTRUM_END * k, 2 * _SPECTRUM + 1, retstep=True)
        fade = np.cos(np.pi / 2 * np.clip((abs(t) / k - FADE_START) / (SPECTRUM_END - FADE_START), 0, 1)) ** 2
        weights = fade * step * aperture / (2 * np.pi) * np.sinc(t * aperture / (2 * np.pi))
        change = self.along(t) - self.along(0.0)
        sent = np.exp(-1j * (np.multiply.outer(abs(away), change) + np.multiply.outer(lateral, t)))
        return abs(sent @ weights)
