"""Slowness curve of a half-space: published curvatures, and the curve of the waves that a beam consists of."""

import numpy as np
import pytest

import fem

# Curvature of the free surface: tables of surface-acoustic-wave cuts.  That of YZ falls off within a few degrees.
CURVATURES = [
    ("128YX", "LiNbO3 (Kovacs)", -0.34, 0.02),
    ("YZ", "LiNbO3 (Warner)", -1.10, 0.02),
    ("ST-X", "quartz (Bechmann)", 0.378, 0.02),
]


@pytest.mark.parametrize(("cut", "name", "curvature", "spread"), CURVATURES)
def test_curvature_is_the_published_one(cut, name, curvature, spread):
    curve = fem.Slowness.of_half_space(fem.rotated(fem.material(name), cut), 10e6, "open")
    assert curve.curvature == pytest.approx(curvature, abs=spread)
    assert curve.steering == pytest.approx(0.0, abs=1e-6)


def test_power_flow_of_a_generic_cut_is_that_of_the_velocity():
    """tan(angle) = v' / v, M. G. Cohen, J. Appl. Phys. 38 (1967) 3821; the other way for the wave to the left."""
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), (10.0, 38.0, 15.0))
    before, here, after = (fem.rayleigh(fem.rotated(solid, (turn, 0.0, 0.0))).velocity for turn in (-0.1, 0.0, 0.1))
    slope = (after - before) / here / np.radians(0.2)
    assert abs(slope) > 0.02
    curve = fem.Slowness.of_half_space(solid, 10e6)
    assert curve.steering == pytest.approx(slope, rel=1e-3)
    aperture, away = 20e-3, 60e-3
    y = np.linspace(-60e-3, 60e-3, 241)
    right, left = (curve.spectrum(aperture, np.full(241, side), y) for side in (away, -away))
    assert (y * right**2).sum() / (right**2).sum() == pytest.approx(slope * away, rel=0.02)
    np.testing.assert_allclose(left, right[::-1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("distance", "amplitude"), [(0.05, 0.855), (0.065, 0.837), (0.08, 1.060), (0.1, 1.251), (0.13, 1.338)]
)
def test_spectrum_of_an_isotropic_surface(distance, amplitude):
    """Scalar angular spectrum of the seed's 20 mm aperture at a wavelength of 0.992 mm, all angles."""
    curve = fem.Slowness.circle(2 * np.pi / 0.992e-3)
    assert curve.spectrum(20e-3, distance, 0.0) == pytest.approx(amplitude, abs=0.02)
