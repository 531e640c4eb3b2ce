"""Hankel functions against those of SciPy."""

import numpy as np
import pytest
from scipy.special import hankel2e

from fem.analytic.hankel import scaled_hankel


@pytest.mark.parametrize("order", [0, 1])
def test_the_functions_are_those_of_scipy(order):
    rng = np.random.default_rng(0)
    z = np.exp(rng.uniform(np.log(1e-4), np.log(300), 2000) + 1j * rng.uniform(-np.pi, np.pi / 4, 2000))
    np.testing.assert_allclose(scaled_hankel(order, z), hankel2e(order, z), rtol=1e-12)
