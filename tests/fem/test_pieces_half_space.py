"""Meshed pieces of a half-space: the program continues the mesh downwards to the absorbing layer and through it."""

from dataclasses import replace

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.exceptions import InputError
from fem.geometry import Stator
from fem.layout import check_layout
from fem.materials import fields
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import medium
from fem.mesh.deepened import deepened
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import SectionMesh, read_mesh
from fem.results.field_evaluation import surface_of
from fem.results.power_balance import power_balance
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import solve_driven
from fem.solve.piece_scattering import reflector
from fem.waveguide.stator_meshes import StatorMeshes
from tests.fem.drawings import rectangle
from tests.fem.stators import comb, cut, lossless, plate

# Elements of half a wavelength: the section's own error is 1e-7 of the motion with elements of a wavelength at order 8.
LEVEL = Resolution(order=7, edge_layers=1, element_size=0.5, absorber=1)
PLAIN = Resolution(order=6, edge_layers=0, element_size=0.5, absorber=0)
COARSE = Resolution(order=5, edge_layers=0, absorber=0)


def _half_space(solid, **rest) -> Stator:
    return plate(solid, length=9.0, **({"thickness": np.inf} | rest))


def _with_pieces(stator, mesh: SectionMesh, places) -> Stator:
    unit = slowest_wavelength(stator.solid, 2.3e6)
    pieces = tuple(MeshPiece(name=f"p{k}", mesh=mesh, position=place * unit) for k, place in enumerate(places))
    return replace(stator, pieces=pieces)


def _drawn(stator, path) -> SectionMesh:
    """A file in wavelengths."""
    return read_mesh(path, slowest_wavelength(stator.solid, 2.3e6))


def _solved(stator, level=LEVEL):
    row = (
        comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45),
        comb(stator, "b", 7.5, metallisation=0.45, termination=50.0),
    )
    return solve_driven(stator, row, frequency=2.3e6, drive="a", resolution=level)


def _motion(solution, places=(0.3, 3.7, 4.3, 5.9, 6.4, 8.7)):
    """On the second piece too: it covers 5.2 to 6.1 wavelengths."""
    return surface_of(solution).motion(np.array(places) * solution.fields.section.length_unit)


@pytest.mark.parametrize(
    ("name", "orientation", "rest", "depth"),
    [
        pytest.param("PZT-4", "Z", {}, 0.6, marks=pytest.mark.slow),
        pytest.param("PZT-4", "Z", {"bottom": "absorbing", "thickness": 2.5}, 0.6, marks=pytest.mark.slow),
        pytest.param("PZT-4", "Z", {}, 2.0, marks=pytest.mark.slow),  # down to the layer
        pytest.param("LiNbO3 (Kovacs)", "YZ", {}, 0.6, marks=pytest.mark.slow),
        ("LiNbO3 (Kovacs)", "128YX", {}, 0.6),  # selective layer
    ],
)
def test_a_plain_piece_of_a_half_space_is_invisible(tmp_path, name, orientation, rest, depth):
    """Two pieces of irregular triangles, continued through the layer, change nothing; what they absorb balances."""
    stator = _half_space(cut(name, orientation, quality=200), **rest)
    mesh = _drawn(stator, rectangle(tmp_path / "plain.msh", 0.9, depth, size=0.3))
    plain, meshed = _solved(stator), _solved(_with_pieces(stator, mesh, (3.6, 5.2)))
    assert abs(_motion(meshed) - _motion(plain)).max() < 2e-8 * abs(_motion(plain)).max()
    before, after = plain.fields.admittances, meshed.fields.admittances
    assert abs(after - before).max() < 2e-9 * abs(before).max()
    assert abs(after - after.T).max() < 1e-11 * abs(after).max()
    assert power_balance(meshed).residual < 1e-11


def test_a_plain_end_of_a_half_space_is_the_free_end(tmp_path):
    """A mesh with the line group left alone: its free side goes on down through the layer."""
    stator = _half_space(cut("PZT-4", "Z", quality=200), ends="free")
    mesh = _drawn(stator, rectangle(tmp_path / "end.msh", 0.7, 0.8, size=0.35, groups=("left",)))
    plain, meshed = (_solved(each, PLAIN) for each in (stator, _with_pieces(stator, mesh, (8.3,))))
    assert abs(_motion(meshed) - _motion(plain)).max() < 2e-5 * abs(_motion(plain)).max()
    assert meshed.fields.admittances == pytest.approx(plain.fields.admittances, rel=2e-6)


@pytest.mark.parametrize("cells", ["triangle", "triangle6"])
def test_a_mesh_is_continued_to_a_depth(tmp_path, cells):
    """Area, interfaces and foot of the mesh continued by quadrilaterals, of second order under curved elements."""
    mesh = read_mesh(rectangle(tmp_path / "plain.msh", 0.9, 0.6, size=0.3), 1.0)
    if cells == "triangle6":
        (own,) = mesh.cells
        middles = (mesh.points[own.nodes] + mesh.points[np.roll(own.nodes, -1, axis=1)]) / 2
        numbers = len(mesh.points) + np.arange(own.nodes.size).reshape(own.nodes.shape)
        own = replace(own, kind="triangle6", nodes=np.hstack([own.nodes, numbers]))
        mesh = replace(mesh, points=np.concatenate([mesh.points, middles.reshape(-1, 2)]), cells=(own,))
    deep = deepened(mesh, 1.7, 0.4)
    assert [line[1:] for line in map(deep.interface, ("left", "right"))] == [(1.7, 0.0)] * 2
    x, z = deep.points[deep.foot].T
    assert z == pytest.approx(-1.7)
    assert (x.min(), x.max()) == (0.0, pytest.approx(0.9))
    assert deep.cells[-1].kind == ("quad" if cells == "triangle" else "quad8")
    assert len(deep.cells[-1].nodes) == 3 * 3
    assert set(deep.lines) == {"left", "right"}  # the group bottom would be inside
    one, other = np.array(deep.boundary).T
    (x, z), (end, foot) = deep.points[one].T, deep.points[other].T
    assert 0.5 * np.sum(x * foot - end * z) == pytest.approx(0.9 * 1.7)


def _grooved(tmp_path) -> Stator:
    stator = _half_space(cut("PZT-4", "Z", quality=200))
    mesh = _drawn(stator, rectangle(tmp_path / "groove.msh", 0.9, 0.4, size=0.45, groove=(0.35, 0.2, 0.1)))
    return _with_pieces(stator, mesh, (4.2,))


def test_inertia_of_the_layer(tmp_path):
    """The matrix over a band is interpolated by -dS/ds = X^T M X, with the layer's share: against a difference."""
    stator = _grooved(tmp_path)
    unit = slowest_wavelength(stator.solid, 2.4e6)
    section = discretise(stator, COARSE, wavelength=unit, surface_scale=np.inf)
    (assembly,) = StatorMeshes(stator, section, COARSE, 2.4e6).assemblies.values()
    step = 1e3
    ahead, at, behind = (assembly.condensed(2.14e6 + change) for change in (step, 0.0, -step))
    slope = (ahead.matrix - behind.matrix) / (16 * np.pi**2 * 2.14e6 * step)
    assert abs(at.inertia(np.eye(2 * section.size)) + slope).max() < 1e-5 * abs(slope).max()
    assert not at.floating_potential  # phi is zero below the layer
    layer = assembly.layer
    faces = layer.held[(len(layer.widths) + 1) * section.bottom :].reshape(len(layer.widths), layer.layers, -1)
    assert faces[:, 0].all()
    assert not faces[:, 1:].any()


@pytest.mark.slow
def test_a_band_with_a_piece_of_a_half_space_is_each_frequency_alone(tmp_path):
    stator = _grooved(tmp_path)
    place = 6.6 * slowest_wavelength(stator.solid, 2.3e6)
    row = (comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45),)
    band = frequency_band(stator, row, lowest=2.26e6, highest=2.33e6, drive="a", tolerance=5e-2, places=(place,))
    for frequency in (2.265e6, 2.33e6):
        alone = solve_driven(stator, row, frequency=frequency, drive="a", resolution=band.model.resolution)
        exact = surface_of(alone).motion(np.array([place]))
        assert abs(band.wave(frequency, "a").motion(np.array([place])) - exact).max() < (
            band.relative_error * abs(exact).max()
        )


def _shallow_reflection(solid, frequency: float) -> tuple[complex, float]:
    """Limit of R / integral of d(x) exp(-2 i k x) dx for a small depth d of removed solid, 1/m2, and k in rad/m.

    Removal of a thin layer with traction-free faces: with u the surface wave of power P per width, whose
    counterpart in the other direction is its conjugate, the sources Q u in its place give

        R = -i omega / (4 P) Q,     Q = T_xx S_xx + ... - D_x E_x - rho omega^2 u . u,

    not conjugated, at the surface with T_iz = D_z = 0 (B. A. Auld, Acoustic Fields and Waves in Solids, vol. 2, 1973,
    chapter 12).  P = v (energy per area), twice the kinetic energy.
    """
    wave = rayleigh(solid, "open")
    omega = 2 * np.pi * frequency
    k = omega / wave.velocity
    body = medium(solid, fields(solid), lossy=False)
    values = dict(zip(("ux", "uy", "uz"), wave.displacement, strict=True))
    values["phi"] = wave.potential / body.potential_unit
    along = -1j * k * np.array([values[name] for name in wave.fields])
    planar = body.xx - body.xz @ np.linalg.solve(body.zz, body.xz.T)
    q = body.stress_unit * (along @ planar @ along) - omega**2 * solid.density * np.sum(wave.displacement**2)
    depth, weights = np.polynomial.laguerre.laggauss(60)
    inside = np.sum(abs(wave.profile(depth / 4)[0]) ** 2, axis=1)
    integral = np.sum(weights * np.exp(depth) / 4 * inside) * wave.velocity / frequency
    power = wave.velocity * 0.5 * solid.density * omega**2 * integral
    return -1j * omega * q / (4 * power), k


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "orientation"), [("LiNbO3 (Warner)", "128YX"), ("PZT-4", "Z"), ("LiNbO3 (Warner)", "YZ")]
)
def test_a_shallow_groove_reflects_as_perturbation_theory_says(tmp_path, name, orientation):
    """Amplitude and phase of R over the depth, extrapolated from depths of 0.005 and 0.01 wavelengths.

    Extrapolated from 0.0025 and 0.005 the error is 0.3 (128YX), 0.6 and 0.8 %: energy is stored at the corners.
    """
    solid, frequency = lossless(name, orientation), 9.6e6
    slope, k = _shallow_reflection(solid, frequency)
    wavelength, wide, width = 2 * np.pi / k, 0.25, 0.8
    ratios = []
    for depth in (0.01, 0.005):
        path = rectangle(
            tmp_path / "groove.msh", width, 0.3, size=0.4, groove=(width / 2 - wide / 2, wide, depth),
            groups=("left", "right"),
        )  # fmt: skip
        piece = MeshPiece(name="groove", mesh=read_mesh(path, wavelength), position=wavelength)
        stator = Stator(solid=solid, length=3 * wavelength, thickness=np.inf, ends="absorbing", pieces=(piece,))
        found = reflector(stator, frequency=frequency, tolerance=1e-2)
        middle = found.reflection * np.exp(1j * k * width * wavelength)
        ratios.append(middle / (slope * depth * wavelength * np.sin(k * wide * wavelength) / k))
        assert np.linalg.norm(found.scattering[:, 0]) < 1
        assert abs(found.scattering - found.scattering.T).max() < 1e-11
    assert 2 * ratios[1] - ratios[0] == pytest.approx(1, abs=0.025)
    assert abs(ratios[1] - 1) < 0.6 * abs(ratios[0] - 1)


@pytest.mark.parametrize(("drawn", "depth"), [(0.6, 2.0), (2.6, 2.6)])
def test_the_section_is_as_deep_as_the_deepest_mesh(tmp_path, drawn, depth):
    stator = _half_space(cut("PZT-4", "Z"))
    mesh = _drawn(stator, rectangle(tmp_path / "plain.msh", 0.9, drawn, size=0.3))
    unit = slowest_wavelength(stator.solid, 2.3e6)
    section = discretise(_with_pieces(stator, mesh, (4.0,)), COARSE, wavelength=unit, surface_scale=np.inf)
    assert section.breakpoints[section.bottom // section.order] == pytest.approx(-depth)


def test_meshes_that_cannot_be_continued(tmp_path):
    """A slanted or stepped lower side, another solid or a condition there, one drawn too deep."""
    stator = _half_space(cut("PZT-4", "Z"))

    def refused(mesh, at=4.0, **rest) -> str:
        with pytest.raises(InputError) as error:
            check_layout(replace(_with_pieces(stator, mesh, (at,)), **rest), ())
        return str(error.value)

    drawn = _drawn(stator, rectangle(tmp_path / "plain.msh", 0.9, 0.6, size=0.3))
    slanted = replace(
        drawn, points=drawn.points + np.outer(drawn.points[:, 0] * (drawn.points[:, 1] < -1e-4), [0, 0.1])
    )
    assert "must reach at its group right from the surface, z = 0, down to its lowest point" in refused(slanted)
    bent = drawn.points.copy()
    bent[drawn.foot[1, 0], 1] *= 0.9
    assert "must have one straight horizontal lower side" in refused(replace(drawn, points=bent))
    (cells,) = drawn.cells
    at_foot = np.isin(cells.nodes, drawn.foot).sum(axis=1) == 2
    parts = ((cells.nodes[~at_foot], "stator"), (cells.nodes[at_foot], "glass"))
    mixed = replace(drawn, cells=tuple(replace(cells, nodes=nodes, solid=solid) for nodes, solid in parts))
    assert "must consist of the stator's own material at its lower side" in refused(mixed)
    clamped = replace(drawn, lines={("clamped" if name == "bottom" else name): v for name, v in drawn.lines.items()})
    assert "must have no other line group than bottom at its lower side" in refused(clamped)
    low = replace(drawn, points=drawn.points - [0.0, 1e-4])
    with pytest.raises(InputError, match="must reach at its group left from the surface"):
        reflector(_with_pieces(stator, low, (4.0,)), frequency=2.3e6, tolerance=0.1)
    deep = _drawn(stator, rectangle(tmp_path / "deep.msh", 0.9, 9.0, size=0.45))
    with pytest.raises(InputError, match="must be drawn down to at most "):
        discretise(
            _with_pieces(stator, deep, (4.0,)),
            COARSE,
            wavelength=slowest_wavelength(stator.solid, 2.3e6),
            surface_scale=np.inf,
        )
