"""The oracles of the surface compliance against the isotropic half-space and each other."""

import numpy as np
import pytest

from tests.oracles.fem_surface_compliance import averaged, axial_modulus, axial_tangential_compliance

E, NU = 210e9, 0.3


def isotropic():
    shear, lame = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    c = np.diag([2 * shear] * 3 + [shear] * 3)
    c[:3, :3] += lame
    return c


def test_closed_forms_in_the_isotropic_limit():
    assert axial_modulus(isotropic()) == pytest.approx(E / (1 - NU**2), rel=1e-12)
    assert axial_tangential_compliance(isotropic()) == pytest.approx((2 - NU) * 2.6 / E, rel=1e-12)


def test_eigenproblem_near_the_isotropic_limit():
    near = isotropic() + np.diag([0, 0, 1e3, 0, 0, 0])  # Stroh's eigenvalues of an isotropic solid coincide
    mean = averaged(near)
    assert mean[2, 2] == pytest.approx(2 * (1 - NU**2) / E, rel=1e-3)
    assert mean[0, 0] + mean[1, 1] == pytest.approx((2 - NU) * 2.6 / E, rel=1e-3)


def test_closed_forms_against_the_eigenproblem():
    c = np.diag([140e9, 140e9, 115e9, 25e9, 25e9, 31e9])
    c[:2, :2] += np.array([[0, 78e9], [78e9, 0]])
    c[0, 2] = c[2, 0] = c[1, 2] = c[2, 1] = 74e9
    mean = averaged(c)
    assert 2 / axial_modulus(c) == pytest.approx(mean[2, 2], rel=1e-9)
    assert axial_tangential_compliance(c) == pytest.approx(mean[0, 0] + mean[1, 1], rel=1e-9)
