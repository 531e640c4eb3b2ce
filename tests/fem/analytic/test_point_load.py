"""Response of a half-space to a surface load.  Oracles: Stroh's eigenproblem, closed forms, Boussinesq's fall-off."""

import numpy as np
import pytest

import fem
from fem.analytic.point_load import point_load, surface_compliance
from tests.oracles import fem_surface_compliance as oracle

CUTS = [
    ("LiNbO3 (Warner)", "YZ"),
    ("LiNbO3 (Kovacs)", "128YX"),
    ("quartz (Bechmann)", "ST-X"),
    ("quartz (Bechmann)", (17.0, 41.0, -23.0)),
    ("PZT-5H", "X"),
]


def cut(name, orientation):
    return fem.rotated(fem.material(name), orientation).stiffness


@pytest.mark.parametrize("name", ["PZT-4", "PZT-8", "PZT-5H", "PIC181"])
def test_an_axis_of_symmetry_gives_the_closed_forms(name):
    c = fem.material(name).stiffness
    load = point_load(c)
    assert load.indentation_modulus == pytest.approx(oracle.axial_modulus(c), rel=1e-13)
    assert load.tangential_compliance == pytest.approx(oracle.axial_tangential_compliance(c), rel=1e-13)
    assert load.spread < 1e-14
    assert abs(load.coupling) < 1e-14


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.499])
def test_isotropic_solid(nu):
    c = fem.isotropic(name="x", youngs_modulus=70e9, poisson_ratio=nu, density=1).stiffness
    load = point_load(c)
    assert load.indentation_modulus == pytest.approx(70e9 / (1 - nu**2), rel=1e-12)
    assert load.tangential_compliance == pytest.approx((2 - nu) * 2 * (1 + nu) / 70e9, rel=1e-12)


@pytest.mark.parametrize(("name", "orientation"), CUTS)
def test_every_direction_against_the_eigenproblem(name, orientation):
    c = cut(name, orientation)
    angles = np.array([0.0, 0.3, 1.1, 2.6])
    for angle, found in zip(angles, surface_compliance(c, angles), strict=True):
        expected = oracle.surface_compliance(c, angle).real
        assert found == pytest.approx(expected, rel=1e-10, abs=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize(("name", "orientation"), CUTS)
def test_means_over_the_directions(name, orientation):
    c = cut(name, orientation)
    load, expected = point_load(c), oracle.averaged(c, 60)
    assert load.compliance == pytest.approx(expected, rel=1e-10, abs=1e-12 * expected[2, 2])
    every = [oracle.surface_compliance(c, angle).real[2, 2] for angle in np.arange(180) * np.pi / 180]
    assert load.spread == pytest.approx((max(every) - min(every)) / 2 / np.mean(every), rel=2e-2)


def test_a_turn_about_the_normal_turns_the_compliance_and_keeps_the_modulus():
    c = cut("quartz (Bechmann)", (0.0, 40.0, 0.0))
    turned = cut("quartz (Bechmann)", (0.0, 40.0, 30.0))
    one, other = point_load(c), point_load(turned)
    assert other.indentation_modulus == pytest.approx(one.indentation_modulus, rel=1e-12)
    cos, sin = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    expected = turn @ one.compliance @ turn.T
    assert other.compliance == pytest.approx(expected, rel=1e-11, abs=1e-12 * one.compliance[2, 2])
    assert abs(other.tangential_compliance / one.tangential_compliance - 1) > 1e-3
