"""Rotations against four-index summation, and the group and symmetries that they must have."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.materials import (
    ORIENTATIONS,
    VACUUM_PERMITTIVITY,
    Solid,
    fields,
    isotropic,
    isotropic_about_normal,
    material,
    rotated,
    rotation_matrix,
)
from tests.oracles.fem_crystal import rotated_tables

SOLIDS = tuple(material(name) for name in ("PZT-4", "LiNbO3 (Kovacs)", "quartz (Bechmann)"))
angle = st.floats(-360, 360, allow_nan=False)
euler = st.tuples(angle, angle, angle)


def same(one, other):
    return all(
        np.abs(getattr(one, key) - getattr(other, key)).max() <= 1e-13 * np.abs(getattr(one, key)).max()
        for key in ("stiffness", "coupling", "permittivity")
    )


@given(solid=st.sampled_from(SOLIDS), orientation=euler)
def test_bond_rotation_is_the_rotation_of_four_index_tensors(solid, orientation):
    turned = rotated(solid, orientation)
    tables = rotated_tables(rotation_matrix(orientation), solid.stiffness, solid.coupling, solid.permittivity)
    for key, table in zip(("stiffness", "coupling", "permittivity"), tables, strict=True):
        assert np.abs(getattr(turned, key) - table).max() <= 1e-13 * np.abs(table).max()


@given(solid=st.sampled_from(SOLIDS), orientation=euler)
def test_inverse_rotation_returns_the_crystal(solid, orientation):
    phi, theta, psi = orientation
    assert same(solid, rotated(rotated(solid, orientation), (-psi, -theta, -phi)))


@given(solid=st.sampled_from(SOLIDS), orientation=euler, more=angle)
def test_rotations_about_one_axis_add(solid, orientation, more):
    phi, theta, psi = orientation
    assert same(rotated(solid, (phi, theta, psi + more)), rotated(rotated(solid, orientation), (more, 0, 0)))


@given(orientation=euler)
def test_rotation_matrix_is_proper_and_passive_z_x_z(orientation):
    a = rotation_matrix(orientation)
    phi, theta, _ = np.radians(orientation)
    assert np.abs(a @ a.T - np.eye(3)).max() < 1e-14
    assert np.linalg.det(a) == pytest.approx(1, rel=1e-13)
    normal = [np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi), np.cos(theta)]
    assert np.abs(a[2] - normal).max() < 1e-13


@given(solid=st.sampled_from(SOLIDS), orientation=euler)
def test_invariants_stay(solid, orientation):
    """C_iikk, C_ikik of the stiffness, |e|^2 and the eigenvalues of the permittivity."""
    turned = rotated(solid, orientation)
    weights = np.array([1, 1, 1, 2, 2, 2])
    c, d = turned.stiffness, solid.stiffness
    assert c[:3, :3].sum() == pytest.approx(d[:3, :3].sum(), rel=1e-12)
    assert np.diag(c) @ weights == pytest.approx(np.diag(d) @ weights, rel=1e-12)
    assert np.sum(turned.coupling**2 * weights) == pytest.approx(np.sum(solid.coupling**2 * weights), rel=1e-12)
    assert np.linalg.eigvalsh(turned.permittivity / VACUUM_PERMITTIVITY) == pytest.approx(
        np.linalg.eigvalsh(solid.permittivity / VACUUM_PERMITTIVITY), rel=1e-12
    )


@given(orientation=euler, poisson_ratio=st.floats(-0.9, 0.49))
def test_isotropic_solid_looks_the_same_from_everywhere(orientation, poisson_ratio):
    solid = isotropic(name="x", youngs_modulus=7.1e10, poisson_ratio=poisson_ratio, density=2700)
    assert same(solid, rotated(solid, orientation))


@given(phi=angle)
def test_ceramic_is_invariant_about_its_poling(phi):
    assert same(SOLIDS[0], rotated(SOLIDS[0], (phi, 0, 0)))
    assert same(rotated(SOLIDS[0], "X"), rotated(rotated(SOLIDS[0], (phi, 0, 0)), "X"))


def crystal(shear: float) -> Solid:
    """Paratellurite (class 422; Ohmachi and Uchida 1970), or with c66 = (c11 - c12) / 2 a crystal of class 622."""
    stiffness = np.diag([5.57e10, 5.57e10, 10.58e10, 2.65e10, 2.65e10, shear])
    for i, j, value in ((0, 1, 5.12e10), (0, 2, 2.18e10), (1, 2, 2.18e10)):
        stiffness[i, j] = stiffness[j, i] = value
    coupling = np.zeros((3, 6))
    coupling[0, 3], coupling[1, 4] = 0.216, -0.216
    permittivity = VACUUM_PERMITTIVITY * np.diag([22.9, 22.9, 24.7])
    return Solid(
        name="crystal", source="", frame="Z", stiffness=stiffness, coupling=coupling, permittivity=permittivity,
        density=5990.0, mechanical_quality=np.inf, dielectric_loss=0.0,
    )  # fmt: skip


@pytest.mark.parametrize("turn", [0.0, 30.0, 45.0, 90.0])
def test_a_fourfold_crystal_is_not_isotropic_about_its_axis(turn):
    """Class 422: a quarter turn changes nothing, any other does, although e and eps alone are those of class 622."""
    fourfold, sixfold = crystal(6.59e10), crystal(0.5 * (5.57e10 - 5.12e10))
    assert same(fourfold, rotated(fourfold, (90.0, 0, 0)))
    assert not same(fourfold, rotated(fourfold, (45.0, 0, 0)))
    assert not isotropic_about_normal(rotated(fourfold, (turn, 0, 0)))
    assert isotropic_about_normal(rotated(sixfold, (turn, 0, 0)))
    assert not isotropic_about_normal(rotated(sixfold, (turn, 90.0, 0)))
    # the sagittal plane that the axis lies in: u_y couples to phi, and beside a turn of the fourfold axis to u_x
    assert fields(rotated(sixfold, (turn, 0, 0))) == ("ux", "uz")
    assert ("uy" in fields(rotated(fourfold, (turn, 0, 0)))) is (turn == 30.0)


@pytest.mark.parametrize(
    ("name", "propagation", "normal"),
    [
        ("Z", (1, 0, 0), (0, 0, 1)),
        ("X", (0, 0, 1), (-1, 0, 0)),
        ("YZ", (0, 0, 1), (0, 1, 0)),
        ("128YX", (1, 0, 0), (0, np.cos(np.radians(128)), np.sin(np.radians(128)))),
        ("ST-X", (1, 0, 0), (0, np.cos(np.radians(222.75)), np.sin(np.radians(222.75)))),
    ],
)
def test_named_cuts_mean_what_crystallographers_mean(name, propagation, normal):
    """A Y cut rotated by beta about X has the normal (0, cos beta, sin beta): beta = theta + 90."""
    a = rotation_matrix(name)
    assert np.abs(a[0] - propagation).max() < 1e-15
    assert np.abs(a[2] - normal).max() < 1e-15


@pytest.mark.parametrize(
    ("name", "orientation", "expected"),
    [
        ("PZT-4", "Z", ("ux", "uz", "phi")),
        ("PZT-4", "X", ("ux", "uz", "phi")),
        ("PZT-4", [30, 0, 0], ("ux", "uz", "phi")),
        ("PZT-4", [0, 90, 0], ("ux", "uz")),
        ("PZT-4", [0, 20, 0], ("ux", "uy", "uz", "phi")),
        ("PZT-4", [0, 360, 180], ("ux", "uz", "phi")),
        ("LiNbO3 (Warner)", "YZ", ("ux", "uz", "phi")),
        ("LiNbO3 (Warner)", "128YX", ("ux", "uy", "uz", "phi")),
        ("quartz (Bechmann)", "ST-X", ("ux", "uy", "uz", "phi")),
        ("quartz (Bechmann)", "YZ", ("ux", "uz")),
        ("steel", "128YX", ("ux", "uz")),
    ],
)
def test_fields_that_the_cut_couples(name, orientation, expected):
    assert fields(rotated(material(name), orientation)) == expected


@pytest.mark.parametrize("orientation", ["Y", [0, 38], [0, np.nan, 0], ["a", 0, 0]])
def test_refusals(orientation):
    with pytest.raises(ValueError, match="orientation must be"):
        rotation_matrix(orientation)


def test_frame_says_how_the_solid_is_turned():
    assert material("PZT-4").frame == "crystal"
    assert rotated(material("PZT-4"), "X").frame == "X"
    assert rotated(material("PZT-4"), [0, 38, 0]).frame == "[0.0, 38.0, 0.0]"
    assert set(ORIENTATIONS) == {"Z", "X", "YZ", "128YX", "ST-X"}
