"""Forms, orders and conventions of constants; the oracle is the 9 x 9 system of the constitutive equations."""

import numpy as np
import pytest

import fem
from fem.materials.crystal_classes import crystal_class, nearest_class, tables_of
from fem.materials.rotation import CONVENTIONS, rotation_matrix

EPS0 = 8.8541878188e-12
LN = fem.material("LiNbO3 (Kovacs)")


def strain_charge(solid):
    """s^E, d and eps^T: strain and D of a solid under each stress alone and each field alone, of T and D of S and E."""
    law = np.block([[solid.stiffness / 1e11, -solid.coupling.T], [solid.coupling, solid.permittivity * 1e11]])
    # [T/1e11; D] = law [S; E/1e11]; solve for S under the unit stresses and fields
    strain = np.linalg.solve(law[:6, :6], np.hstack([np.eye(6), -law[:6, 6:]]))
    charge = law[6:, :6] @ strain + np.hstack([np.zeros((3, 6)), law[6:, 6:]])
    return strain[:, :6] / 1e11, charge[:, :6] / 1e11, charge[:, 6:] / 1e11


def test_strain_charge_and_back():
    c, e, eps = fem.from_strain_charge(*strain_charge(LN))
    assert c == pytest.approx(LN.stiffness, rel=1e-12, abs=1e-3)
    assert e == pytest.approx(LN.coupling, rel=1e-12, abs=1e-12)
    assert eps == pytest.approx(LN.permittivity, rel=1e-12, abs=1e-24)


def test_the_published_forms_of_one_ceramic():
    """PZT-5H of Berlincourt, Curran and Jaffe is published in both forms, with three digits each."""
    s11, s12, s13, s33, s44 = 16.5, -4.78, -8.45, 20.7, 43.5
    s = np.diag([s11, s11, s33, s44, s44, 2 * (s11 - s12)])
    s[0, 1] = s[1, 0] = s12
    s[:2, 2] = s[2, :2] = s13
    d = np.zeros((3, 6))
    d[0, 4] = d[1, 3] = 741
    d[2, :3] = -274, -274, 593
    c, e, eps = fem.from_strain_charge(s * 1e-12, d * 1e-12, np.diag([3130, 3130, 3400]) * EPS0)
    known = fem.material("PZT-5H")
    assert c == pytest.approx(known.stiffness, rel=0.02, abs=1e8)
    assert e == pytest.approx(known.coupling, rel=0.02, abs=1e-9)
    # a difference of rounded numbers: 3400 - 1967
    assert eps == pytest.approx(known.permittivity, rel=0.03, abs=1e-14)


def test_constants_at_other_conditions():
    """c^D = inverse of s^D, which is s^E - d^T (eps^T)^-1 d; eps^T as above."""
    s, d, eps_t = strain_charge(LN)
    c_d = np.linalg.inv(s - d.T @ np.linalg.inv(eps_t) @ d)
    assert c_d[3, 3] > 1.4 * LN.stiffness[3, 3]
    assert fem.at_constant_field(c_d, LN.coupling, LN.permittivity) == pytest.approx(LN.stiffness, rel=1e-12, abs=1e-3)
    converted = fem.at_constant_strain(LN.stiffness, LN.coupling, eps_t)
    assert converted == pytest.approx(LN.permittivity, rel=1e-12, abs=1e-24)


@pytest.mark.parametrize("order", ["11 22 33 12 23 13", "11 22 33 12 13 23", "33 22 11 21 31 32"])
def test_orders_of_indices(order):
    names = ["".join(sorted(each)) for each in order.split()]
    picked = [["11", "22", "33", "23", "13", "12"].index(each) for each in names]
    written = LN.stiffness[np.ix_(picked, picked)], LN.coupling[:, picked]
    assert np.array_equal(fem.in_order(written[0], order), LN.stiffness)
    assert np.array_equal(fem.in_order(written[1], order), LN.coupling)


@pytest.mark.parametrize("order", ["11 22 33 23 13", "11 22 33 23 13 13", ""])
def test_an_order_names_each_component_once(order):
    with pytest.raises(ValueError, match="order must name each of 11 22 33 23 13 12 once"):
        fem.in_order(LN.stiffness, order)


@pytest.mark.parametrize("angles", [(0, -38, 0), (20, -38, 70)])
def test_conventions_that_turn_from_the_cut_to_the_crystal(angles):
    """Sawsim 2.0.2 (rotation_matrix) and COMSOL: A = R_z(alpha) R_x(beta) R_z(gamma) with active matrices."""
    alpha, beta, gamma = np.radians(angles)

    def about_z(t):
        return np.array([[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1]])

    about_x = np.array([[1, 0, 0], [0, np.cos(beta), -np.sin(beta)], [0, np.sin(beta), np.cos(beta)]])
    theirs = about_z(alpha) @ about_x @ about_z(gamma)
    for convention in CONVENTIONS[1:]:
        ours = rotation_matrix(fem.euler_angles(angles, convention))
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12)
    if angles == (0, -38, 0):
        assert theirs == pytest.approx(rotation_matrix("128YX"), rel=1e-12, abs=1e-12)
    with pytest.raises(ValueError, match='euler_convention must be "SAW" or "COMSOL" or "sawsim"'):
        fem.euler_angles(angles, "Bunge")


def test_cuts_by_their_crystal_axes():
    """Normal and propagation along crystal axes, or turned from Y towards Z."""
    axes = dict(zip("XYZ", np.eye(3), strict=True))
    for name in ("XY", "XZ", "YX", "YZ", "ZX", "ZY"):
        x, _, z = rotation_matrix(name)
        assert (*x, *z) == pytest.approx((*axes[name[1]], *axes[name[0]]), rel=1e-12, abs=1e-12)
    x, _, z = rotation_matrix("X-112Y")
    assert (*x, *z) == pytest.approx(
        (0, np.cos(np.radians(112)), np.sin(np.radians(112)), 1, 0, 0), rel=1e-12, abs=1e-12
    )
    for name, degrees in (("64YX", 64), ("41.5 YX", 41.5), ("36-YX", 36), ("128° Y-X", 128), ("128YX", 128)):
        x, _, z = rotation_matrix(name)
        t = np.radians(degrees)
        assert (*x, *z) == pytest.approx((1, 0, 0, 0, np.cos(t), np.sin(t)), rel=1e-12, abs=1e-12)
    with pytest.raises(ValueError, match="another such as 64YX"):
        rotation_matrix("64XY")


@pytest.mark.parametrize(
    ("name", "expected"), [("PZT-4", "6mm"), ("LiNbO3 (Warner)", "3m"), ("quartz (Bechmann)", "32")]
)
def test_classes_of_known_solids_in_any_axes(name, expected):
    """Also poled along x, and with x and y exchanged; a rotated Y cut keeps one mirror."""
    solid = fem.material(name)
    for orientation in ("Z", "X", (90, 0, 0), (0, 90, 0)):
        assert crystal_class(tables_of(fem.rotated(solid, orientation)))[0] == expected
    assert crystal_class(tables_of(fem.rotated(solid, (10, 20, 30)))) == ("1", 1)
    assert crystal_class(tables_of(fem.rotated(fem.material("LiNbO3 (Warner)"), "128YX"))) == ("m", 2)


def test_the_entry_of_a_mistyped_digit():
    stiffness = np.array(LN.stiffness)
    stiffness[3, 3] *= 1.3
    tables = stiffness / stiffness.max(), LN.coupling / abs(LN.coupling).max(), LN.permittivity / LN.permittivity.max()
    name, table, entry, _ = nearest_class(tables)
    assert (name, table) == ("3m", "stiffness")
    assert entry in ((4, 4), (5, 5))
