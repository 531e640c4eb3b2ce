"""Static charges on strips against conformal mapping, and their transform against its own integral."""

import numpy as np
import pytest
from scipy.special import ellipk

from tests.oracles.fem_static_strips import charge_transform, static_charges


@pytest.mark.parametrize("strips", [[[0.0, 1.0], [2.0, 3.0]], [[-1.0, 0.3], [0.5, 5.0]]])
def test_two_strips_have_the_capacitance_of_conformal_mapping(strips):
    """C / eps = K'(k) / K(k), k^2 = (c - b)(d - a) / ((c - a)(d - b)) for strips (a, b) and (c, d)."""
    (a, b), (c, d) = strips
    modulus = (c - b) * (d - a) / ((c - a) * (d - b))
    charges = static_charges(strips, [0.5, -0.5], terms=24)
    assert charges[0, 0] == pytest.approx(ellipk(1 - modulus) / ellipk(modulus), rel=1e-6)
    assert charges[:, 0].sum() == pytest.approx(0.0, abs=1e-12)


def test_transform_of_a_strip_is_the_integral_of_its_charge():
    strips, charges, k = [[0.2, 1.0]], np.array([[0.7, -0.3, 0.1]]), 5.0
    s = np.cos((np.arange(400) + 0.5) * np.pi / 400)  # Gauss-Chebyshev
    density = np.polynomial.chebyshev.chebval(s, charges[0])
    expected = np.mean(density * np.exp(1j * k * (0.6 + 0.4 * s)))
    assert charge_transform(strips, charges, k) == pytest.approx(expected, rel=1e-12)
