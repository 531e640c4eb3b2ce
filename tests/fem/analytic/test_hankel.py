"""Hankel functions against those of SciPy."""

import numpy as np
import pytest
from scipy.special import hankel2e

from fem.analytic.hankel import scaled_hankel


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize(("smallest", "largest"), [(1e-4, 300.0), (30.0, 40.0)])
def test_the_functions_are_those_of_scipy(order, smallest, largest):
    rng = np.random.default_rng(0)
    logarithm = rng.uniform(np.log(smallest), np.log(largest), 2000) + 1j * rng.uniform(-np.pi, np.pi / 4, 2000)
    z = np.exp(logarithm)
    np.testing.assert_allclose(scaled_hankel(order, z), hankel2e(order, z), rtol=1e-12)


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("size", [5.0, 25.0])
def test_a_backward_wave_without_loss_is_that_of_a_vanishing_loss(order, size):
    """The functions are continuous where arg z is -pi, near and far."""
    exact, lossy = scaled_hankel(order, np.array([-size + 0j, -size - 1e-13j]))
    assert exact == pytest.approx(lossy, rel=1e-11)
