"""The periodic cell against the half-space without a mesh, its orders, and the two-dimensional assembly."""

from itertools import pairwise

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.convergence import ConvergenceError
from fem.discretize.forms import scikit_fem_derivatives
from fem.materials import fields, isotropic, material, rotated
from fem.materials.medium import medium
from studies.evidence.peers.periodic_cell import graded_heights
from studies.evidence.peers.periodic_wave import periodic_wave

CUTS = (
    ("PZT-4", "Z", "open"),
    ("PZT-4", "Z", "metallised"),
    ("PZT-4", "Z", "vacuum"),
    ("PZT-5H", "X", "open"),
    ("LiNbO3 (Kovacs)", "128YX", "metallised"),
    ("quartz (Bechmann)", "ST-X", "vacuum"),
    ("steel", "Z", "open"),
)


@pytest.mark.parametrize(("name", "orientation", "surface"), CUTS)
def test_velocity_and_shape_are_those_of_the_half_space(name, orientation, surface):
    """1e-10 in velocity at under 3000 unknowns; the shape to the square root of that, at the surface to 1e-8."""
    solid = rotated(material(name), orientation)
    expected = rayleigh(solid, surface)
    wave = periodic_wave(solid, 0.98e-3, order=8, surface=surface)
    assert wave.unknowns <= 3000
    assert wave.velocity == pytest.approx(expected.velocity, rel=1e-10)
    assert wave.relative_error == pytest.approx(abs(wave.velocity / expected.velocity - 1), abs=1e-15)
    assert wave.frequency == pytest.approx(expected.velocity / 0.98e-3, rel=1e-10)
    assert wave.surface_ratio == pytest.approx(expected.surface_ratio, rel=1e-8)
    depth = np.linspace(0, 3, 31)
    (u, phi), (u_expected, phi_expected) = wave.profile(depth), expected.profile(depth)
    assert np.abs(u - u_expected).max() < 1e-5
    assert np.abs(phi - phi_expected).max() <= 2e-5 * np.abs(phi_expected).max()
    assert np.abs(wave.displacement - expected.displacement).max() < 1e-8


@pytest.mark.parametrize(
    ("order", "grids", "layers_per_column", "surface"),
    [(1, (12, 18, 24), 3, "open"), (3, (4, 6, 8), 4, "metallised"), (5, (2, 3, 4), 4, "open")],
)
def test_velocity_converges_with_twice_the_order(order, grids, layers_per_column, surface):
    """Neighbouring pairs within 0.2 of 2 p, the cell's total grading fixed while its layers multiply."""
    solid = material("PZT-4")
    expected = rayleigh(solid, surface).velocity
    errors = [
        abs(
            periodic_wave(
                solid, 1.0, order=order, elements=(n, layers_per_column * n), surface=surface, grading=4.0
            ).velocity
            / expected
            - 1
        )
        for n in grids
    ]
    orders = [
        np.log(coarse / fine) / np.log(m / n)
        for (n, coarse), (m, fine) in pairwise(zip(grids, errors, strict=True))
    ]
    assert orders == pytest.approx([2 * order] * 2, abs=0.2)


def side_dofs(basis, x):
    """Unknowns of a vertical side from the bottom up: those of its vertices, then those of its facets."""
    mesh = basis.mesh
    facets = mesh.facets_satisfying(lambda at: at[0] == x)
    facets = facets[np.argsort(mesh.p[1, mesh.facets[:, facets]].mean(axis=0))]
    vertices = mesh.nodes_satisfying(lambda at: at[0] == x)
    vertices = vertices[np.argsort(mesh.p[1, vertices])]
    return np.concatenate([basis.nodal_dofs[0, vertices], basis.facet_dofs[:, facets].T.ravel()])


@pytest.mark.parametrize("surface", ["open", "metallised"])
def test_half_the_cell_is_the_whole_cell_assembled_in_two_dimensions(surface):
    """One whole wavelength of `ElementQuadP` with identified sides has the same pair of eigenvalues."""
    import skfem
    from scipy.linalg import eigh
    from scipy.sparse import csr_matrix, kron

    order, columns, layers, depth = 4, 2, 3, 2.5
    solid = rotated(material("LiNbO3 (Kovacs)"), "YZ")
    wave = periodic_wave(
        solid, 1.0, order=order, elements=(columns, layers), depth=depth, grading=3.0, surface=surface
    )
    names = fields(solid)
    body = medium(solid, names, lossy=False)
    heights = graded_heights(layers, depth, 3.0)
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 1, 2 * columns + 1), heights)
    basis = skfem.Basis(mesh, skfem.ElementQuadP(order), intorder=2 * order)
    master = np.arange(basis.N)
    master[side_dofs(basis, 1.0)] = side_dofs(basis, 0.0)
    periodic = csr_matrix((np.ones(basis.N), (np.arange(basis.N), master)), shape=(basis.N, basis.N))
    parts = (form.assemble(basis) for form in scikit_fem_derivatives())
    xx, xz, zz, mass = (periodic.T @ part @ periodic for part in parts)
    stiffness = kron(xx, body.xx) + kron(xz, body.xz) + kron(xz.T, body.xz.T) + kron(zz, body.zz)
    inertia = kron(mass, np.diag(body.inertia / body.inertia[0]))
    kept = np.zeros((basis.N, len(names)), dtype=bool)
    kept[np.unique(master)] = True
    kept[basis.get_dofs(lambda x: x[1] == heights[0]).flatten()] = False
    if surface == "metallised":
        kept[basis.get_dofs(lambda x: x[1] == heights[-1]).flatten(), names.index("phi")] = False
    # phi has no inertia: eliminated, it leaves the displacements a symmetric problem with a mass
    kept = np.flatnonzero(kept.ravel())
    electric = kept % len(names) == names.index("phi")
    k, m = (part.tocsr()[kept][:, kept].toarray() for part in (stiffness, inertia))
    across = k[np.ix_(~electric, electric)]
    k = k[np.ix_(~electric, ~electric)] - across @ np.linalg.solve(k[np.ix_(electric, electric)], across.T)
    values = eigh(k, m[np.ix_(~electric, ~electric)], eigvals_only=True)
    velocities = np.sqrt(values / body.inertia[0]) / (2 * np.pi)
    pair = velocities[np.argsort(abs(velocities - wave.velocity))[:2]]
    assert np.sqrt(np.mean(pair**2)) == pytest.approx(wave.velocity, rel=1e-11)


@pytest.mark.parametrize(("order", "largest"), [(6, 2e-6), (8, 3e-9), (10, 1e-9)])
@pytest.mark.parametrize("poisson_ratio", [0.499, 0.4999999])
def test_high_orders_do_not_lock(order, largest, poisson_ratio):
    """The error stays what it is at nu = 0.499; the floor of 1e-9 is the rounding of a stiffness of 1e7 mu."""
    rubber = isotropic(name="rubber", youngs_modulus=3e6, poisson_ratio=poisson_ratio, density=1100.0)
    wave = periodic_wave(rubber, 1.0, order=order, elements=(2 if order == 6 else 1, None))
    assert wave.relative_error < largest


def test_low_orders_lock_and_say_so():
    rubber = isotropic(name="rubber", youngs_modulus=3e6, poisson_ratio=0.49999, density=1100.0)
    wave = periodic_wave(rubber, 1.0, order=2, elements=(8, 16))
    assert 5e-3 < wave.relative_error < 5e-2


def test_shape_to_nine_digits():
    """To two wavelengths down, where the clamped bottom of the cell is not yet felt."""
    solid = material("PZT-4")
    (u, phi), (u_expected, phi_expected) = (
        wave.profile(np.linspace(0, 2, 21))
        for wave in (periodic_wave(solid, 1.0, order=14), rayleigh(solid, "open"))
    )
    assert np.abs(u - u_expected).max() < 1e-9
    assert np.abs(phi - phi_expected).max() <= 1e-9 * np.abs(phi_expected).max()


@pytest.mark.parametrize("points", [1, 2, 5, 12])
def test_profile_does_not_depend_on_how_many_depths_are_asked_for(points):
    """scikit-fem's element remembers its values by the number of points alone."""
    wave = periodic_wave(material("PZT-4"), 1.0, order=4)
    depth = np.linspace(0.3, 2.0, points)
    together = wave.profile(depth)[0]
    one_by_one = np.concatenate([wave.profile(at)[0] for at in depth])
    assert np.abs(together - one_by_one).max() < 1e-13


def test_wavelength_sets_the_frequency_only():
    waves = [periodic_wave(material("PZT-8"), wavelength, order=6) for wavelength in (2e-6, 0.7)]
    assert waves[0].velocity == pytest.approx(waves[1].velocity, rel=1e-13)
    assert waves[0].frequency * 2e-6 == pytest.approx(waves[1].frequency * 0.7, rel=1e-13)


def test_another_shift_finds_the_same_wave():
    solid = material("PZT-4")
    named = periodic_wave(solid, 1.0, order=8)
    other = periodic_wave(solid, 1.0, order=8, shift=2200.0)
    assert other.velocity == pytest.approx(named.velocity, rel=1e-12)
    assert named.residual < 1e-7
    assert named.backward < 1e-7


def test_a_shift_without_a_travelling_wave_is_refused():
    """Far above, the nearest two modes of the cell are not sine and cosine of one wave."""
    with pytest.raises(ConvergenceError, match=r"no wave near 9000 m/s: residual .* try a nearer shift"):
        periodic_wave(material("PZT-4"), 1.0, order=6, shift=9000.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wavelength": -1.0}, r"wavelength must be positive and finite, got -1\.0 m"),
        ({"depth": np.nan}, r"depth must be positive and finite, got nan wavelengths"),
        ({"shift": 0.0}, r"shift must be positive and finite, got 0\.0 m/s"),
        ({"grading": 0.0}, r"grading must be positive and finite, got 0\.0$"),
        ({"order": 0}, r"order must be an integer of at least 1, got 0"),
        ({"order": 1, "elements": (1, None)}, r"too few unknowns, got 1, 1, 4"),
        ({"order": 1, "elements": (2, 1)}, r"too few unknowns, got 1, 2, 1"),
        ({"surface": "gold"}, r"surface must be one of"),
    ],
)
def test_refusals(change, message):
    with pytest.raises(ValueError, match=message):
        periodic_wave(material("PZT-4"), **{"wavelength": 1.0, "order": 4} | change)


def test_profile_ends_with_the_cell():
    wave = periodic_wave(material("PZT-4"), 1.0, order=4, depth=3.0)
    assert np.abs(wave.profile([3.0])[0]).max() < 1e-14
    with pytest.raises(ValueError, match="depth must lie between 0 and 3 wavelengths"):
        wave.profile([3.1])


@pytest.mark.parametrize("layers", [1, 2, 7])
def test_grading_is_a_total_ratio(layers):
    heights = graded_heights(layers, 5.0, 8.0)
    sizes = np.diff(heights)
    assert heights[-1] == 0
    assert heights[0] == pytest.approx(-5, rel=1e-15)
    assert sizes[0] / sizes[-1] == pytest.approx(8 if layers > 1 else 1, rel=1e-12)
