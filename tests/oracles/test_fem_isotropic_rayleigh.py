"""The oracle of the isotropic Rayleigh wave against closed forms and its own boundary conditions."""

import numpy as np
import pytest

from tests.oracles.fem_isotropic_rayleigh import profile, surface_ratio, velocity_over_shear

_ROOT = np.sqrt((136 / 27) ** 2 + (8 / 9) ** 3)


@pytest.mark.parametrize(
    ("poisson_ratio", "velocity"),
    [
        (0.25, np.sqrt(2 - 2 / np.sqrt(3))),
        (0.0, np.sqrt(3 - np.sqrt(5))),
        # Cardano's formula for s^3 - 8 s^2 + 24 s - 16
        (0.5, np.sqrt(8 / 3 + np.cbrt(-136 / 27 + _ROOT) + np.cbrt(-136 / 27 - _ROOT))),
    ],
)
def test_velocity_is_the_closed_form(poisson_ratio, velocity):
    assert velocity_over_shear(poisson_ratio) == pytest.approx(velocity, rel=1e-10)


def test_surface_ratio_at_one_quarter():
    assert surface_ratio(0.25) == pytest.approx(0.6812500386, rel=1e-9)


@pytest.mark.parametrize("poisson_ratio", [-0.7, 0.13, 0.37])
def test_profile_leaves_the_surface_free(poisson_ratio):
    """sigma_zz and sigma_xz by central differences of the profile: 1e-6 is the differences' error."""
    h = 1e-4
    (ux_up, ux, ux_down), (uz_up, uz, uz_down) = profile(poisson_ratio, np.array([-h, 0.0, h]))
    k = 2 * np.pi
    d_z = lambda up, down: (up - down) / (2 * h)  # noqa: E731
    lame_over_shear = 2 * poisson_ratio / (1 - 2 * poisson_ratio)
    shear = d_z(ux_up, ux_down) - 1j * k * uz
    normal = (lame_over_shear + 2) * d_z(uz_up, uz_down) - lame_over_shear * 1j * k * ux
    assert abs(shear) / k < 1e-6
    assert abs(normal) / k < 1e-6
    assert abs(ux) == pytest.approx(surface_ratio(poisson_ratio), rel=1e-12)


def test_orbit_is_retrograde():
    """At the crest (u_z largest) the surface moves against the wave: Re(i omega u_x) < 0."""
    u_x, u_z = profile(0.3, np.array([0.0]))
    assert (1j * u_x[0] / u_z[0]).real < 0
