"""Lamb's problem at rest (Boussinesq and Cerruti) and far away, where the Rayleigh wave alone is left."""

import numpy as np
import pytest

from tests.oracles.fem_point_force import point_force

NU = 0.25


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_slow_force_is_that_of_boussinesq_and_cerruti(angle):
    mu, r = 2.0, 0.5
    u_z, u_x, u_y = point_force(mu, NU, 0.02, r, angle)
    assert u_z.real == pytest.approx((1 - NU) / (2 * np.pi * mu * r), rel=1e-3)
    assert u_x.real == pytest.approx((1 - NU + NU * np.cos(angle) ** 2) / (2 * np.pi * mu * r), rel=1e-3)
    assert u_y.real == pytest.approx(NU * np.sin(angle) * np.cos(angle) / (2 * np.pi * mu * r), abs=1e-3 * abs(u_x))


def test_the_rayleigh_wave_is_left_far_away():
    """u_z = -i Gamma k_R H_0(k_R r) / 2 with Gamma = 0.183486 / mu (nu = 1/4); bulk waves fall as r^-2."""
    mu, k_t = 2.0, 1.0
    k_r = k_t / 0.919402
    r = 1000.0
    expected = 0.183486 / mu * np.sqrt(k_r / (2 * np.pi * r)) * np.exp(-1j * (k_r * r + np.pi / 4))
    assert abs(point_force(mu, NU, k_t, r, 0.0)[0] / expected - 1) < 1e-3
