"""The weak form: the tensor-product matrices against scikit-fem's, and the tables against tensor algebra."""

import numpy as np
import pytest
from skfem import Basis, ElementQuadP, MeshQuad

from fem.discretize.element_matrices import element_matrix
from fem.discretize.spectral import gll_nodes
from fem.materials import VACUUM_PERMITTIVITY, fields
from fem.materials.medium import medium, units, vacuum_medium
from tests.fem.direct import scikit_fem_derivatives
from tests.fem.stators import cut, lossless

ALL = ("ux", "uy", "uz", "phi")
LOSSY = {"quality": 70.0, "loss": 0.03}
CASES = (
    ("PZT-4", "Z", LOSSY),
    ("PZT-5H", "X", {"quality": np.inf, "loss": 0.0}),
    ("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0), LOSSY),
    ("quartz (Bechmann)", (0.0, 132.75, 20.0), {"quality": np.inf, "loss": 0.02}),
    ("steel", "Z", {"quality": 300.0}),
)
WIDTH, HEIGHT, ANGULAR = 0.37, 0.81, 2 * np.pi * 1900.0


def scikit_fem_parts(order, tables, height):
    """Four assembled parts (xx, xz + its transpose, zz, inertia) of one element, and its basis at the nodes."""
    mesh = MeshQuad.init_tensor(np.array([0.0, WIDTH]), np.array([-height, 0.0]))
    basis = Basis(mesh, ElementQuadP(order), intorder=2 * order)
    xx, xz, zz, mass = (form.assemble(basis).toarray() for form in scikit_fem_derivatives())
    parts = (
        np.kron(xx, tables.xx),
        np.kron(xz, tables.xz) + np.kron(xz.T, tables.xz.T),
        np.kron(zz, tables.zz),
        np.kron(mass, np.diag(tables.inertia)),
    )
    x, z = np.meshgrid(WIDTH * gll_nodes(order), height * (gll_nodes(order) - 1), indexing="ij")
    at_nodes = basis.probes(np.stack([x.ravel(), z.ravel()])).toarray()
    return parts, np.kron(at_nodes, np.eye(len(tables.fields)))


@pytest.mark.parametrize("order", [2, 5])
@pytest.mark.parametrize(("name", "orientation", "losses"), CASES)
def test_element_matrix_is_the_one_of_scikit_fem(name, orientation, losses, order):
    """Hierarchical basis, two-dimensional quadrature: another discretisation of the same space."""
    solid = cut(name, orientation, **losses)
    body = medium(solid, fields(solid))
    parts, at_nodes = scikit_fem_parts(order, body, HEIGHT)
    expected = parts[0] + parts[1] + parts[2] - ANGULAR**2 * parts[3]
    ours = element_matrix(body, WIDTH, HEIGHT, order, ANGULAR)
    assert np.abs(at_nodes.T @ ours @ at_nodes - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.abs(ours - ours.T).max() < 1e-13 * np.abs(ours).max()
    assert np.isrealobj(ours) == (not solid.is_lossy)


def test_element_of_complex_height():
    """A stretched depth divides d/dz and multiplies dz: integrals of height one, recombined."""
    solid = cut("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0), **LOSSY)
    body = medium(solid, fields(solid))
    parts, at_nodes = scikit_fem_parts(4, body, 1.0)
    stretched = 0.6 * (10.0 - 6.0j)
    expected = stretched * parts[0] + parts[1] + parts[2] / stretched - ANGULAR**2 * stretched * parts[3]
    ours = at_nodes.T @ element_matrix(body, WIDTH, stretched, 4, ANGULAR) @ at_nodes
    assert np.abs(ours - expected).max() < 1e-12 * np.abs(expected).max()
    plain = element_matrix(body, WIDTH, HEIGHT + 0j, 4, ANGULAR)
    assert np.array_equal(plain, element_matrix(body, WIDTH, HEIGHT, 4, ANGULAR))


def test_loss_is_the_imaginary_part():
    """Q dissipates, and so does tan delta: the loss is a non-negative form of the fields."""
    solid = cut("PZT-4", (0.0, 20.0, 10.0), **LOSSY)
    body = medium(solid, fields(solid))
    loss = element_matrix(body, WIDTH, HEIGHT, 4, ANGULAR, part="loss")
    whole = element_matrix(body, WIDTH, HEIGHT, 4, ANGULAR)
    assert np.abs(loss - whole.imag).max() < 1e-13 * np.abs(loss).max()
    assert np.linalg.eigvalsh(loss)[0] > -1e-12 * np.abs(loss).max()


@pytest.mark.parametrize(("name", "orientation", "losses"), CASES)
def test_tables_are_the_constitutive_law(name, orientation, losses):
    """C_xx etc. against T_ij = c_ijkl S_kl + e_kij phi_,k and D_i = e_ikl S_kl - eps_ij phi_,j, unscaled."""
    solid = cut(name, orientation, **losses)
    body = medium(solid, ALL)
    voigt = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    c = solid.stiffness_lossy[voigt[:, :, None, None], voigt]
    e = solid.coupling[:, voigt]
    random = np.random.default_rng(3)
    u_x, u_z, v_x, v_z = random.normal(size=(4, 4))

    def gradients(d_x, d_z):
        slope = np.zeros((4, 3))
        slope[:, 0], slope[:, 2] = d_x, d_z
        return slope[:3] / 1.0, slope[3] * body.potential_unit

    strain, tilt = gradients(u_x, u_z)
    test_strain, test_tilt = gradients(v_x, v_z)
    stress = np.einsum("ijkl,kl->ij", c, strain) + np.einsum("kij,k->ij", e, tilt)
    flux = np.einsum("ikl,kl->i", e, strain) - solid.permittivity_lossy @ tilt
    expected = np.sum(test_strain * stress) + test_tilt @ flux
    ours = (v_x @ body.xx @ u_x + v_x @ body.xz @ u_z + v_z @ body.xz.T @ u_x + v_z @ body.zz @ u_z) * body.stress_unit
    assert ours == pytest.approx(expected, rel=1e-12)
    assert np.allclose(body.inertia, [solid.density / body.stress_unit] * 3 + [0.0], rtol=1e-15, atol=0.0)


@pytest.mark.parametrize(
    ("name", "orientation", "odd"),
    [
        ("PZT-4", "Z", {"ux"}),
        ("PZT-4", "X", {"ux", "phi"}),
        ("LiNbO3 (Kovacs)", "128YX", {"ux"}),
        ("quartz (Bechmann)", "ST-X", {"ux", "phi"}),
        ("steel", "Z", {"ux"}),
        ("LiNbO3 (Warner)", "YZ", None),
        ("LiNbO3 (Warner)", (0.0, 38.0, 10.0), None),
    ],
)
def test_mirror_symmetry_of_the_cuts(name, orientation, odd):
    """Poled along z: u_x odd; along x: phi too; 128YX has the mirror x -> -x, quartz ST-X a two-fold axis along x."""
    solid = cut(name, orientation)
    body = medium(solid, fields(solid))
    if odd is None:
        assert body.parity is None
        return
    mirror = np.diag(np.where(body.parity, -1.0, 1.0))
    size = 1e-12 * np.abs(body.xx).max()
    assert {name for name, changes in zip(body.fields, body.parity, strict=True) if changes} - {"uy"} == odd
    assert np.abs(mirror @ body.xx @ mirror - body.xx).max() < size
    assert np.abs(mirror @ body.zz @ mirror - body.zz).max() < size
    assert np.abs(mirror @ body.xz @ mirror + body.xz).max() < size


def test_lossless_tables_are_real_and_units_balance():
    solid = lossless("PZT-8", "Z")
    body = medium(solid, fields(solid))
    assert np.isrealobj(body.xx)
    assert np.isrealobj(medium(cut("PZT-8", "Z"), ("ux", "uz", "phi"), lossy=False).xx)
    assert 0.1 < np.abs(body.zz).max() <= 1.5
    assert np.abs(np.linalg.eigvalsh(body.zz)).min() > 0.05


def test_vacuum_is_a_dielectric_in_the_solids_units():
    solid = cut("PZT-4", "Z")
    gap = vacuum_medium(*units(solid))
    stress, potential = units(solid)
    assert gap.fields == ("phi",)
    assert gap.xx[0, 0] * stress / potential**2 == pytest.approx(-VACUUM_PERMITTIVITY, rel=1e-14)
    assert gap.zz[0, 0] == gap.xx[0, 0]
    assert gap.xz[0, 0] == 0
    assert gap.inertia[0] == 0
