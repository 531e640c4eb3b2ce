"""The rule for the integral over k_y against closed forms, with the cusp that a pole at k = 0 leaves."""

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam.cut_source import SPACING_FLOATING
from fem.beam.lateral import evanescent, lateral_rule, wavenumber_along


@pytest.mark.parametrize(("x", "y", "reach"), [(8e-3, 0.0, 5e-3), (8e-3, 4e-3, 9e-3), (2e-2, 1e-2, 1.5e-2)])
def test_integrand_of_a_mode(x, y, reach):
    """exp(-i kappa x) cos(k_y y) / kappa: H_0(k r) / 2; up to 2.2e-8 off, 1.3e-7 with SPACING = 0.42."""
    k = 1e4
    rule = lateral_rule(k, reach, evanescent(k, x))
    kappa = wavenumber_along(np.array(k), rule.nodes)
    found = np.sum(rule.weights * np.exp(-1j * kappa * x) / kappa * np.cos(rule.nodes * y))
    assert abs(found / (hankel2(0, k * np.hypot(x, y)) / 2) - 1) < 4e-8


@pytest.mark.parametrize("y", [0.0, 2e-3, 5e-3])
def test_spacing_at_a_cusp(y):
    """The integrand of the next test at the spacing of floating plates: 1.9e-4 off, 5.2e-4 with 1 in place of 0.85."""
    x = 12e-3
    rule = lateral_rule(15e3, 10e-3, evanescent(1e3, x), cusp=True, coarser=SPACING_FLOATING)
    found = np.sum(rule.weights * np.exp(-rule.nodes * x) * np.cos(rule.nodes * y)).real
    assert abs(found / (x / np.pi / (x**2 + y**2)) - 1) < 3e-4


@pytest.mark.parametrize("y", [0.0, 2e-3, 5e-3])
def test_integrand_with_a_cusp(y):
    """exp(-|k| x) cos(k y): x / pi (x^2 + y^2) over 2 pi; without ``cusp`` the rule errs by 4 to 30 %."""
    x = 12e-3
    rule = lateral_rule(15e3, 10e-3, evanescent(1e3, x), cusp=True)
    exact = x / np.pi / (x**2 + y**2)
    found = np.sum(rule.weights * np.exp(-rule.nodes * x) * np.cos(rule.nodes * y)).real
    assert abs(found / exact - 1) < 2e-3
    plain = lateral_rule(15e3, 10e-3, evanescent(1e3, x))
    assert abs(np.sum(plain.weights * np.exp(-plain.nodes * x) * np.cos(plain.nodes * y)).real / exact - 1) > 0.03
