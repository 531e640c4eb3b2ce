"""The crystal oracle against waves that are known in closed form."""

import numpy as np
import pytest

from tests.oracles.fem_crystal import (
    VACUUM,
    SurfaceProblem,
    coupling_table,
    coupling_tensor,
    rotated_tables,
    stiffness_table,
    stiffness_tensor,
)

C11, C12, C13, C33, C44 = 139e9, 77.8e9, 74.3e9, 115e9, 25.6e9
C66 = (C11 - C12) / 2
STIFFNESS = np.array(
    [
        [C11, C12, C13, 0, 0, 0],
        [C12, C11, C13, 0, 0, 0],
        [C13, C13, C33, 0, 0, 0],
        [0, 0, 0, C44, 0, 0],
        [0, 0, 0, 0, C44, 0],
        [0, 0, 0, 0, 0, C66],
    ]
)
COUPLING = np.array([[0, 0, 0, 0, 12.7, 0], [0, 0, 0, 12.7, 0, 0], [-5.2, -5.2, 15.1, 0, 0, 0]])
PERMITTIVITY = np.diag([730, 730, 635]) * VACUUM


def test_tables_and_tensors_are_inverse():
    assert np.array_equal(stiffness_table(stiffness_tensor(STIFFNESS)), STIFFNESS)
    assert np.array_equal(coupling_table(coupling_tensor(COUPLING)), COUPLING)


def test_quarter_turn_about_x_exchanges_axes():
    """New z along old -y, new y along old z: 33 takes the value of 22 and 66 that of 55."""
    a = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    c, e, eps = rotated_tables(a, STIFFNESS, COUPLING, PERMITTIVITY)
    assert c[2, 2] == pytest.approx(C11)
    assert c[1, 1] == pytest.approx(C33)
    assert c[4, 4] == pytest.approx(C66)
    assert c[5, 5] == pytest.approx(C44)
    assert e[1, 1] == pytest.approx(15.1)
    assert e[1, 0] == pytest.approx(-5.2)
    assert eps[1, 1] / VACUUM == pytest.approx(635)


def test_cyclic_turn_knows_its_direction():
    """New x, y, z along old y, z, x: the polar axis 3 becomes axis 2, not axis 1."""
    a = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    c, e, eps = rotated_tables(a, STIFFNESS, COUPLING, PERMITTIVITY)
    assert c[1, 1] == pytest.approx(C33)
    assert c[0, 0] == pytest.approx(C11)
    assert c[4, 4] == pytest.approx(C66)
    assert e[1, 1] == pytest.approx(15.1)
    assert e[0, 5] == pytest.approx(12.7)
    assert np.diag(eps) / VACUUM == pytest.approx([730, 635, 730])


@pytest.mark.parametrize("surface", ["vacuum", "metallised"])
def test_bleustein_gulyaev_wave(surface):
    """Class 6mm poled along y, Bleustein 1968: v^2 = v_s^2 (1 - K^4); K^2/(1 + eps/eps0) under vacuum."""
    a = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    density = 7500.0
    problem = SurfaceProblem(*rotated_tables(a, STIFFNESS, COUPLING, PERMITTIVITY), density, (1, 3), surface)
    stiffened = C44 + 12.7**2 / (730 * VACUUM)
    shear = np.sqrt(stiffened / density)
    coupling = 12.7**2 / (730 * VACUUM) / stiffened
    if surface == "vacuum":
        coupling /= 1 + 730
    expected = shear * np.sqrt(1 - coupling**2)
    low = 0.5 * shear if surface == "metallised" else shear * (1 - 1e-6)
    # the vacuum wave lies 3e-7 below the shear wave
    assert problem.velocity_between(low, shear * (1 - 1e-12)) == pytest.approx(expected, rel=1e-9)


def test_isotropic_wave():
    modulus, shear = 90e9, 30e9
    c = np.diag([2 * shear] * 3 + [shear] * 3)
    c[:3, :3] += modulus - 2 * shear
    nu = (modulus - 2 * shear) / (2 * (modulus - shear))
    assert nu == pytest.approx(0.25)
    problem = SurfaceProblem(c, np.zeros((3, 6)), np.eye(3) * VACUUM, 3100.0, (0, 2), "open")
    shear_velocity = np.sqrt(shear / 3100.0)
    found = problem.velocity_between(0.8 * shear_velocity, 0.99 * shear_velocity)
    assert found == pytest.approx(0.9194016867619663 * shear_velocity, rel=1e-9)
