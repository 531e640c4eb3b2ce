"""Pieces of the stator given as meshes: what must not change, what must balance, and what other programs say."""

import gc
import weakref
from dataclasses import replace
from itertools import pairwise

import meshio
import numpy as np
import pytest

from fem.circuit import Drive
from fem.condense.interpolated_piece import PieceSample, rational_piece
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import ConvergenceError, InputError
from fem.geometry import Stator, Transducer
from fem.layout import check_layout
from fem.materials import material
from fem.materials.christoffel import slowest_wavelength
from fem.mesh import quad_mesh
from fem.mesh.even_corners import with_even_corners
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import Cells, SectionMesh, read_mesh
from fem.results.field_evaluation import surface_of
from fem.results.field_files import write_vtu
from fem.results.interior_field import wave_field
from fem.results.power_balance import power_balance
from fem.results.stator_solution import driven_solution
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import driven_wave, motion_difference, solve_driven
from fem.solve.forced_surface import forced_wave
from fem.solve.p_matrix_from_field import cascade_admittance, p_matrix
from fem.solve.piece_scattering import reflector
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import stator_cascade
from fem.waveguide.stator_meshes import StatorMeshes
from tests.fem.drawings import bevelled_end, chip, profile, rectangle
from tests.fem.piece_references import REFERENCES, places
from tests.fem.stators import comb, cut, plate, wave_of

LEVEL = Resolution(order=8, edge_layers=3)
PLACES = np.array([0.3, 3.7, 4.3, 5.9, 6.4, 8.7])  # wavelengths; the last but two on the second piece


def _solved(stator, drive="a", level=LEVEL):
    row = (
        comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45),
        comb(stator, "b", 7.5, metallisation=0.45, termination=50.0),
    )
    return solve_driven(stator, row, frequency=2.3e6, drive=drive, resolution=level)


def _with_pieces(stator, path, places, **rest):
    """Pieces whose file is in wavelengths of the stator."""
    unit = stator.thickness / 0.8
    mesh = read_mesh(path, unit)
    return replace(
        stator,
        pieces=tuple(
            MeshPiece(name=f"p{k}", mesh=mesh, position=place * unit, **rest) for k, place in enumerate(places)
        ),
    )


def _motion(solution):
    unit = solution.fields.section.length_unit
    return surface_of(solution).motion(PLACES * unit)


@pytest.mark.parametrize(
    ("name", "orientation", "sides", "bound"),
    [
        # on 128YX, below, with the same sides
        pytest.param("PZT-4", "Z", {"ends": "absorbing", "bottom": "free"}, 1e-8, marks=pytest.mark.slow),
        pytest.param("PZT-4", "Z", {"ends": "free", "bottom": "grounded"}, 1e-8, marks=pytest.mark.slow),
        pytest.param("PZT-5H", "X", {"ends": "absorbing", "bottom": "clamped"}, 1e-8, marks=pytest.mark.slow),
        # the line is graded towards the clamped bottom: 7e-5 where the projection is tested with functions held there
        ("PZT-4", "Z", {"ends": "free", "bottom": "clamped"}, 1e-8),
        # one element through 0.8 wavelengths: the section's own error
        ("LiNbO3 (Kovacs)", "128YX", {"ends": "absorbing", "bottom": "free"}, 3e-7),
    ],
)
def test_a_meshed_plain_stretch_is_invisible(tmp_path, name, orientation, sides, bound):
    """Two pieces of plain stator as irregular triangles change neither motion nor admittance; all of it balances.

    The piece's interface does not conform to the section's line: only the L2 projection keeps this (sampling at the
    nodes errs by 3e-2).
    """
    stator = plate(cut(name, orientation, quality=200), length=9.0, **sides)
    path = rectangle(tmp_path / "plain.msh", 0.9, 0.8, size=0.3)
    plain, meshed = _solved(stator), _solved(_with_pieces(stator, path, (3.6, 5.2)))
    size = abs(_motion(plain)).max()
    assert abs(_motion(meshed) - _motion(plain)).max() < bound * size
    before, after = plain.fields.admittances, meshed.fields.admittances
    assert abs(after - before).max() < bound * abs(before).max()
    assert abs(after - after.T).max() < 1e-11 * abs(after).max()
    assert power_balance(meshed).residual < 1e-11


def test_a_piece_is_freed_with_its_last_user(tmp_path):
    """Also after a field in it was asked for: no cycle of references keeps its factors."""
    path = rectangle(tmp_path / "plain.msh", 0.9, 0.8, size=0.45)
    stator = _with_pieces(plate(cut("PZT-4", "Z", quality=200), length=9.0), path, (4.2,))
    level = Resolution(order=5, edge_layers=0)
    section = discretise(stator, level, wavelength=slowest_wavelength(stator.solid, 2.3e6), surface_scale=np.inf)
    (piece,) = StatorMeshes(stator, section, level, 2.3e6).condensed(2.3e6).values()
    field = piece.recover(np.ones(len(piece.matrix)))
    assert field.piece is piece
    gc.disable()
    try:
        kept = weakref.ref(piece)
        del piece, field
        assert kept() is None
    finally:
        gc.enable()


@pytest.mark.parametrize(
    ("bottom", "connection", "floats"),
    [
        ("free", "floating", True),
        ("clamped", "floating", True),
        ("free", "grounded", False),
        ("grounded", "floating", False),
        ("free", "a+", False),
    ],
)
def test_the_potential_of_a_piece_without_fingers_is_a_matter_of_gauge(tmp_path, bottom, connection, floats):
    """It is where the constant potential, on both lines, has no flux: nothing in the piece holds it, and no port."""
    stator = plate(cut("PZT-4", "Z", quality=200), length=9.0, bottom=bottom)
    groups = ("left", "right", "bottom", "electrode:strip")
    path = rectangle(tmp_path / "strip.msh", 0.9, 0.8, size=0.45, strip=(0.35, 0.2, 0.1), groups=groups)
    rest = {"solids": (("strip", material("aluminium")),), "electrodes": (("strip", connection),)}
    stator = _with_pieces(stator, path, (4.2,), **rest)
    level = Resolution(order=5, edge_layers=0)
    unit = slowest_wavelength(stator.solid, 2.3e6)
    section = discretise(stator, level, wavelength=unit, surface_scale=np.inf)
    row = StatorMeshes(stator, section, level, 2.3e6)
    (piece,) = row.condensed(2.3e6).values()
    assert piece.floating_potential == floats
    constant = np.zeros(len(piece.matrix))
    constant[: len(section.constant_potential)] = section.constant_potential
    constant[piece.size :][: len(section.constant_potential)] = section.constant_potential
    flux = abs(piece.matrix @ constant).max() / abs(piece.matrix).max()
    assert flux < 1e-12 if floats else flux > 1e-6
    found = reflector(stator, frequency=2.3e6, tolerance=0.5)
    assert 1e-3 < abs(found.reflection) < 1


def test_a_groove_reflects_and_its_power_balances(tmp_path):
    """A groove with loss: what arrives is what leaves and what is lost inside, and the ports stay reciprocal."""
    stator = plate(cut("PZT-4", "Z", quality=300), length=9.0)
    path = rectangle(tmp_path / "groove.msh", 0.9, 0.8, size=0.45, groove=(0.35, 0.2, 0.1))
    level = Resolution(order=6, edge_layers=1)
    plain, grooved = (_solved(each, level=level) for each in (stator, _with_pieces(stator, path, (4.2,))))
    assert abs(_motion(grooved) - _motion(plain)).max() > 0.1 * abs(_motion(plain)).max()
    after = grooved.fields.admittances
    assert abs(after - after.T).max() < 1e-11 * abs(after).max()
    balance = power_balance(grooved)
    assert balance.residual < 1e-11
    assert balance.input == pytest.approx(balance.solid + balance.loads + balance.radiated, rel=1e-9)


def _reference_stator(tmp_path, case):
    path, rest = tmp_path / "piece.msh", {}
    if case == "bevel":
        bevelled_end(path, 1.0, 0.6, 1.1, size=0.35)
        position = 7e-3
    elif case == "strip":
        groups = ("left", "right", "bottom", "electrode:strip")
        rectangle(path, 1.0, 1.1, size=0.25, strip=(0.35, 0.3, 0.1), groups=groups)
        position, rest = 4.85e-3, {"solids": (("strip", material("aluminium")),)}
    elif case == "five grooves":
        rectangle(path, 2.75, 1.1, size=0.25, groove=[(0.25 + 0.5 * k, 0.25, 0.1) for k in range(5)])
        position = 4.25e-3
    else:
        groove, position = {"groove": ((0.35, 0.25, 0.15), 4.9e-3), "step": ((0.5, 0.5, 0.3), 5e-3)}[case]
        rectangle(path, 1.0, 1.1, size=0.25, groove=groove)
    piece = MeshPiece(name=case, mesh=read_mesh(path, 1e-3), position=position, **rest)
    stator = Stator(
        solid=cut("PZT-4", "Z"),
        length=8e-3,
        thickness=1.1e-3,
        ends="absorbing" if case == "step" else "free",
        pieces=(piece,),
    )
    row = Transducer(name="t", center=2.2e-3, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=10e-3)
    return stator, (row,)


def _apart(case, admittance, motion):
    """Relative differences of admittance and motion from NGSolve's, the motion's over the largest."""
    reference, moved = REFERENCES[case]
    return abs(admittance / reference - 1), abs(motion - moved).max() / abs(moved).max()


@pytest.mark.parametrize("case", REFERENCES)
def test_pieces_against_ngsolve(tmp_path, case):
    """One discretisation of every piece; without them Y differs by 6e-2 to 1."""
    stator, row = _reference_stator(tmp_path, case)
    solved = solve_driven(stator, row, frequency=2.17e6, drive="t", resolution=Resolution(order=7, edge_layers=2))
    motion = surface_of(solved).motion(places(case))
    of_admittance, of_motion = _apart(case, solved.circuit.admittance, motion)
    assert of_admittance < 3e-4
    assert of_motion < 5e-4
    assert power_balance(solved).residual < 1e-10


@pytest.mark.slow
def test_slender_elements_at_corners_are_halved(tmp_path):
    """A groove's mesh with elements 16 times as long as wide at the corner is as exact as an even one.

    Its motion is 3e-4 from NGSolve if they stay, 2e-5 if they are halved.
    """
    stator, row = _reference_stator(tmp_path, "groove")
    path = rectangle(tmp_path / "slender.msh", 1.0, 1.1, size=0.35, groove=(0.35, 0.25, 0.15))
    slender = replace(stator, pieces=(replace(stator.pieces[0], mesh=read_mesh(path, 1e-3)),))
    solved = solve_driven(slender, row, frequency=2.17e6, drive="t", resolution=Resolution(order=8, edge_layers=3))
    of_admittance, of_motion = _apart("groove", solved.circuit.admittance, surface_of(solved).motion(places("groove")))
    assert of_admittance < 3e-5
    assert of_motion < 4e-5


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad", "quad9"])
def test_halving_keeps_the_region_and_its_lines(kind):
    """A slender rectangle of two elements, halved towards one corner: conforming, area and length of the lines kept."""
    x = np.array([[0, 0], [8, 0], [8, 1], [0, 1], [4, 0], [8, 0.5], [4, 1], [0, 0.5], [4, 0.5]], dtype=float)
    nodes = {
        "triangle": [[0, 1, 2], [0, 2, 3]],
        "triangle6": [[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 7]],
        "quad": [[0, 1, 2, 3]],
        "quad9": [list(range(9))],
    }[kind]
    mesh = SectionMesh(
        name="m",
        digest=kind,
        unit=1.0,
        points=x,
        cells=(Cells(kind=kind, solid="stator", nodes=np.array(nodes)),),
        lines={"bottom": np.array([[0, 1]])},
    )
    even = with_even_corners(mesh, {0})
    corners = even.points[even.cells[0].nodes[:, :3]]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(8)
    assert all(len(owners) == 1 for owners in even.edges.values())
    perimeter = sum(np.linalg.norm(even.points[a] - even.points[b]) for a, b in even.boundary)
    assert perimeter == pytest.approx(18)
    bottom = even.points[even.lines["bottom"]]
    assert len(bottom) > 1
    assert np.linalg.norm(bottom[:, 1] - bottom[:, 0], axis=1).sum() == pytest.approx(8)
    if even.cells[0].nodes.shape[1] == 6:
        middles = even.points[even.cells[0].nodes[:, 3]]
        assert middles == pytest.approx((corners[:, 0] + corners[:, 1]) / 2)


@pytest.mark.slow
@pytest.mark.parametrize("case", REFERENCES)
def test_pieces_against_ngsolve_to_1e_6(tmp_path, case):
    stator, row = _reference_stator(tmp_path, case)
    wave = driven_wave(stator, row, frequency=2.17e6, drive="t", tolerance=1e-6, places=tuple(places(case)))
    of_admittance, of_motion = _apart(case, wave.admittance, wave.motion(places(case)))
    assert of_admittance < 5e-6
    assert of_motion < 5e-6


@pytest.mark.parametrize("groove", [None, (0.35, 0.2, 0.12)])
def test_the_field_inside_a_mesh_joins_its_neighbours(tmp_path, groove):
    """Displacement and potential on the grid are those of the section where the mesh is plain, and zero in a groove."""
    stator = plate(cut("PZT-4", "Z", quality=300), length=9.0)
    path = rectangle(tmp_path / "piece.msh", 0.9, 0.8, size=0.3, groove=groove)
    places = (4.2, 5.3) if groove else (4.2,)
    solved = _solved(_with_pieces(stator, path, places), level=Resolution(order=7, edge_layers=1))
    unit = stator.thickness / 0.8
    field = wave_field(wave_of(solved), span=(4.25 * unit, 5.05 * unit), energies=True)
    if groove is None:
        plain = wave_of(_solved(stator, level=Resolution(order=7, edge_layers=1)))
        exact = wave_field(plain, span=(4.25 * unit, 5.05 * unit), places=tuple(field.x), energies=True)
        same = [int(np.argmin(abs(exact.x - x))) for x in field.x]
        for one, other in (
            (field.displacement, exact.displacement[same]),
            (field.potential, exact.potential[same]),
            (field.densities.power_flow, exact.densities.power_flow[same]),
        ):
            assert abs(one - other).max() < 5e-4 * abs(other).max()
        (piece,) = field.pieces
        some = piece.quads[::29, 0]
        x, z = piece.points[some].T
        exact = wave_field(plain, span=piece.span, places=tuple(x), energies=True)
        line = abs(exact.x - x[:, None]).argmin(axis=1)
        assert abs(exact.x[line] - x).max() < 1e-3 * unit / 16
        basis = exact.depth_basis(z)
        for own, on_grid in (
            (piece.displacement, exact.displacement),
            (piece.potential, exact.potential),
            (piece.densities.power_flow, exact.densities.power_flow),
        ):
            expected = np.einsum("pj,pj...->p...", basis, on_grid[line])
            assert abs(own[some] - expected).max() < 1e-3 * abs(expected).max()
        return
    hole = (field.x[:, None] > 4.56 * unit) & (field.x[:, None] < 4.74 * unit) & (field.z > -0.115 * unit)
    assert not field.inside[hole].any()
    assert not field.displacement[~field.inside].any()
    assert field.inside[~(field.x[:, None] > 4.54 * unit) & (field.z < 0)].all()
    whole = wave_field(wave_of(solved), span=(4.0 * unit, 6.3 * unit))
    write_vtu(whole, tmp_path / "field.vtu")
    written = meshio.read(tmp_path / "field.vtu")
    x, z = np.moveaxis(written.points[written.cells[0].data][..., [0, 2]], -1, 0)
    area = 0.5 * np.sum(x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z)
    assert area == pytest.approx((2.3 * 0.8 - 2 * 0.2 * 0.12) * unit**2, rel=1e-9)  # each place is covered once
    for place in places:
        left = np.flatnonzero(abs(written.points[:, 0] - place * unit) < 1e-9 * unit)
        order = left[np.lexsort([written.points[left, 2]])]
        moved = written.point_data["displacement_m_per_V_real"][order]
        same = np.flatnonzero(np.diff(written.points[order, 2]) < 1e-9 * unit)  # of the grid and of the mesh
        assert len(same) > 2
        assert abs(moved[same] - moved[same + 1]).max() < 1e-3 * abs(moved).max()


def test_strain_energy_in_another_solid(tmp_path):
    """On the grid and on the piece's own elements it is that of the solid which is there."""
    stator = plate(cut("PZT-4", "Z", quality=300), length=9.0)
    path = rectangle(tmp_path / "plain.msh", 0.9, 0.8, size=0.3)
    stator = _with_pieces(stator, path, (4.2,), solids=(("inlay", material("aluminium")),))
    (piece,) = stator.pieces
    (cells,) = piece.mesh.cells
    unit = stator.thickness / 0.8
    x, z = piece.mesh.points[cells.nodes].mean(axis=1).T / unit
    inlaid = (abs(x - 0.45) < 0.2) & (z > -0.3)
    parts = tuple(
        replace(cells, solid=name, nodes=cells.nodes[which]) for name, which in (("stator", ~inlaid), ("inlay", inlaid))
    )
    stator = replace(stator, pieces=(replace(piece, mesh=replace(piece.mesh, cells=parts, digest="inlay")),))
    solved = _solved(stator, level=Resolution(order=7, edge_layers=0))
    field = wave_field(wave_of(solved), span=(4.2 * unit, 5.1 * unit), energies=True)
    (own,) = field.pieces
    # no traction acts on the surface: with the constants of the ceramic power would flow through it
    middle = abs(field.x / unit - 4.65) < 0.1
    on_grid = abs(field.densities.power_flow_pulse[middle])
    assert on_grid[:, -1, 1].max() < 0.02 * on_grid[..., 0].max()
    inside = (abs(own.points[:, 0] / unit - 4.65) < 0.1) & (own.points[:, 1] > -0.2 * unit)
    top, flow = inside & (abs(own.points[:, 1]) < 1e-12), abs(own.densities.power_flow_pulse)
    assert flow[top, 1].max() < 0.02 * flow[inside, 0].max()
    in_line = np.flatnonzero(middle)[0]
    near = inside & (abs(own.points[:, 0] - field.x[in_line]) < 0.02 * unit)
    energy = own.densities.strain_energy[near]
    grid_energy = field.densities.strain_energy[in_line, field.z > -0.2 * unit]
    assert 0.7 * energy.min() < grid_energy.min()
    assert grid_energy.max() < 1.4 * energy.max()


def test_reflection_of_a_groove_and_of_a_row(tmp_path):
    """Lossless: no power is made, S is symmetric; a plain stretch reflects nothing and turns the phase."""
    stator = plate(cut("PZT-4", "Z", quality=np.inf, loss=0.0), length=9.0, thickness=0.8)
    unit, given = stator.thickness / 0.8, {"frequency": 2.3e6, "tolerance": 1e-2}
    groove = rectangle(tmp_path / "groove.msh", 0.9, 0.8, size=0.45, groove=(0.35, 0.2, 0.1))
    plain = rectangle(tmp_path / "plain.msh", 0.7, 0.8, size=0.35)
    grooved, empty = (_with_pieces(stator, path, (3.0,)).pieces[0] for path in (groove, plain))
    nothing = reflector(replace(stator, pieces=(empty,)), **given)
    one = reflector(replace(stator, pieces=(grooved,)), **given)
    both = reflector(replace(stator, pieces=(replace(empty, position=1.9 * unit), grooved)), **given)
    two = reflector(_with_pieces(stator, groove, (3.0, 4.7)), **given)
    assert abs(nothing.reflection) < 1e-6
    assert abs(nothing.transmission) == pytest.approx(1, abs=1e-6)
    assert abs(one.reflection) > 0.03
    turn = np.exp(-2j * np.pi * 1.1 * unit / one.wavelength)  # over the plain mesh and the gap behind it
    assert both.reflection == pytest.approx(one.reflection * turn**2, abs=2e-6)
    assert both.transmission == pytest.approx(one.transmission * turn, abs=2e-6)
    for each in (one, both, two):
        assert abs(each.scattering - each.scattering.T).max() < 1e-9
        assert np.linalg.norm(each.scattering[:, 0]) <= 1 + 1e-9
    assert two.pieces[0][1].scattering == pytest.approx(one.scattering, abs=1e-12)
    assert [number for _, number in two.positions] == [0, 0]
    assert abs(two.reflection - one.reflection) > 0.01


def test_a_plain_end_as_a_mesh_is_the_free_end(tmp_path):
    """The stator's free end given as a mesh of plain stator: the same motion and admittance."""
    stator = plate(cut("PZT-4", "Z", quality=200), length=9.0, ends="free")
    unit = stator.thickness / 0.8
    end = rectangle(tmp_path / "end.msh", 0.7, 0.8, size=0.35, groups=("left", "bottom"))
    meshed = replace(stator, pieces=(MeshPiece(name="end", mesh=read_mesh(end, unit), position=8.3 * unit),))
    plain, meshed = _solved(stator), _solved(meshed)
    size = abs(_motion(plain)).max()
    assert abs(_motion(meshed) - _motion(plain)).max() < 5e-6 * size
    assert meshed.fields.admittances == pytest.approx(plain.fields.admittances, rel=1e-6)


def test_fingers_as_a_mesh_are_the_built_in_ones(tmp_path):
    """A pair of fingers in a mesh, wired to a transducer, against a built-in pair driven as that transducer is."""
    stator = plate(cut("PZT-4", "Z", quality=200), length=9.0)
    unit = stator.thickness / 0.8
    path = rectangle(tmp_path / "pair.msh", 2.0, 0.8, size=0.25, groups=("left", "right", "bottom"))
    mesh = read_mesh(path, unit)
    top = np.flatnonzero(abs(mesh.points[:, 1]) < 1e-12)
    top = top[np.argsort(mesh.points[top, 0])]
    lines = {
        f"electrode:{name}": np.array(
            [(a, b) for a, b in pairwise(top) if low < (mesh.points[a, 0] + mesh.points[b, 0]) / 2 / unit < low + 0.25]
        )
        for name, low in (("a", 0.75), ("b", 1.25))
    }
    mesh = replace(mesh, lines=mesh.lines | lines, digest="a pair of fingers")
    piece = MeshPiece(name="pair", mesh=mesh, position=4.875 * unit, electrodes=(("a", "a+"), ("b", "a-")))
    first = comb(stator, "a", 1.5)
    second = comb(stator, "b", 6.0)
    level = Resolution(order=7, edge_layers=2)
    meshed = solve_driven(replace(stator, pieces=(piece,)), (first,), frequency=2.3e6, drive="a", resolution=level)
    both = solve_driven(
        stator, (first, second), frequency=2.3e6, drive=Drive(sources={"a": 1.0, "b": 1.0}), resolution=level
    )
    at = np.array([0.5, 3.7, 8.5]) * unit
    one, other = (surface_of(each).motion(at) for each in (meshed, both))
    assert abs(one - other).max() < 2e-4 * abs(other).max()
    assert meshed.circuit.admittance == pytest.approx(both.fields.admittances.sum(), rel=2e-4)


def test_the_p_matrix_of_a_plain_mesh_is_a_distance(tmp_path):
    """In a cascade of two transducers it stands for as much bare surface, and the admittances stay."""
    stator = plate(cut("PZT-4", "Z"), length=16.0)
    unit = stator.thickness / 0.8
    path = rectangle(tmp_path / "plain.msh", 0.9, 0.8, size=0.45)
    given = {"frequency": 2.3e6, "tolerance": 1e-2}
    found = reflector(_with_pieces(stator, path, (6.0,)), **given)
    ((left, number),), ((_, piece),) = found.positions, found.pieces
    assert (left, number, piece.length) == (pytest.approx(6 * unit), 0, pytest.approx(0.9 * unit))
    parts = [p_matrix(stator, comb(stator, "a", 2.5, finger_pairs=pairs), **given) for pairs in (1, 2)]
    plain = cascade_admittance(parts, [3.0 * unit])
    with_piece = cascade_admittance([parts[0], piece, parts[1]], [1.6 * unit, 0.5 * unit])
    assert not with_piece[1].any()
    assert with_piece[np.ix_([0, 2], [0, 2])] == pytest.approx(plain, abs=1e-4 * abs(plain[0, 1]))
    assert abs(plain[0, 1]) > 0.01 * abs(plain[0, 0])


CHIP = {"length": 7e-3, "thickness": 1.1e-3, "ends": "free"}
CHIP_ROW = (
    Transducer(name="a", center=2.5e-3, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=10e-3),
    Transducer(
        name="b", center=5.5e-3, finger_pairs=1, period=1e-3, metallisation=0.5, aperture=10e-3, termination=50.0
    ),
)


def _whole(tmp_path, *, bottom="free", grounded=(), **rest):
    """A stator as one mesh with the fingers of both transducers; ``grounded``: line groups drawn besides."""
    strips = {each.name + sign: each.strips(sign) * 1e3 for each in CHIP_ROW for sign in "+-"} | dict(grounded)
    path = chip(tmp_path / "chip.msh", 7.0, 1.1, strips, size=0.5)
    electrodes = tuple((name, name if name[0] in "ab" else "grounded") for name in strips)
    piece = MeshPiece(name="chip", mesh=read_mesh(path, 1e-3), position=0.0, electrodes=electrodes)
    return Stator(solid=cut("PZT-4", "Z", quality=200), bottom=bottom, pieces=(piece,), **(CHIP | rest))


@pytest.mark.parametrize(
    "bottom", ["free", *(pytest.param(each, marks=pytest.mark.slow) for each in ("grounded", "absorbing"))]
)
def test_a_whole_stator_as_a_mesh_is_the_built_in_one(tmp_path, bottom):
    """The same small chip drawn and built in: motion and admittances agree within the two stated errors."""
    meshed = _whole(tmp_path, bottom=bottom)
    plain = replace(meshed, pieces=())
    places = (0.3e-3, 2.5e-3, 4e-3, 6.9e-3)
    drawn, built = (
        driven_wave(each, CHIP_ROW, frequency=2.17e6, drive="a", tolerance=1e-3, places=places)
        for each in (meshed, plain)
    )
    stated = drawn.relative_error + built.relative_error
    assert stated < 1.5e-3
    assert motion_difference(drawn.motion(np.array(places)), built.motion(np.array(places))) < stated
    assert abs(drawn.admittance / built.admittance - 1) < drawn.admittance_error + built.admittance_error
    for name in ("input", "solid", "loads"):
        assert getattr(drawn.power, name) == pytest.approx(getattr(built.power, name), rel=2 * stated)
    assert drawn.power.radiated == 0
    assert drawn.power_residual < 1e-11


def test_a_grounded_electrode_takes_no_net_charge_from_the_transducers(tmp_path):
    """On a plate without ground a grounded strip refers both means to it: no comb's pair has a net charge then.

    A strip that is grounded and nothing else is one that floats.
    """
    stator = _whole(tmp_path, grounded={"ground": [[4.3, 4.6]]})
    (piece,) = stator.pieces
    afloat = replace(piece, electrodes=tuple(each for each in piece.electrodes if each[0] != "ground"))
    solutions = [
        solve_driven(
            replace(stator, pieces=(each,)),
            CHIP_ROW,
            frequency=2.17e6,
            drive="a",
            resolution=Resolution(order=6, edge_layers=1),
        )
        for each in (piece, afloat)
    ]
    kinds = [[port.kind for port in each.fields.network.ports] for each in solutions]
    assert kinds == [["voltage", "mean", "voltage", "mean"], ["voltage", "voltage", "mean"]]
    one, other = (each.fields.admittances for each in solutions)
    assert abs(one - other).max() < 1e-9 * abs(other).max()


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_stated_error_of_a_reflection_is_that_of_its_discretisation(tmp_path, mirrored):
    """Against two levels more, from both sides: neither a share of the true error nor many times it is stated."""
    stator = plate(cut("PZT-4", "Z", quality=300.0), length=9.0)
    start = 0.2 if not mirrored else 0.5
    path = rectangle(tmp_path / "groove.msh", 0.9, 0.8, size=0.45, groove=(start, 0.2, 0.1))
    stator, given = _with_pieces(stator, path, (3.0,)), {"frequency": 2.3e6}
    found, finer = (reflector(stator, tolerance=tolerance, **given) for tolerance in (1e-2, 1e-5))
    error = abs(found.scattering - finer.scattering).max()
    assert 0.4 * found.relative_error < error < 2 * found.relative_error < 2e-2
    assert finer.relative_error < 0.1 * found.relative_error


def test_a_plain_stretch_of_a_plate_of_two_waves_passes_the_wave_of_its_face(tmp_path):
    """T of the first wave is exp(-i k d) cos(dk d / 2) of its two modes; it does not reflect, nor leave the face."""
    stator = plate(cut("PZT-4", "Z", quality=100.0), length=9.0, thickness=2.0)
    unit = stator.thickness / 2.0
    mesh = read_mesh(rectangle(tmp_path / "plain.msh", 0.6, 2.0, size=0.7), unit)
    stator = replace(stator, pieces=(MeshPiece(name="plain", mesh=mesh, position=3.0 * unit),))
    found = reflector(stator, frequency=2.3e6, tolerance=1e-2)
    section = discretise(stator, Resolution(order=7, edge_layers=2), wavelength=unit, surface_scale=np.inf)
    modes = guided_modes(section, 2.3e6)
    one, other = modes.wavenumbers[modes.rayleigh]
    assert found.scattering.shape == (4, 4)
    expected = (np.exp(-0.6j * one) + np.exp(-0.6j * other)) / 2
    assert found.transmission == pytest.approx(expected, abs=1e-4)
    assert found.transmission == pytest.approx(found.scattering[2, 0], abs=0)
    assert abs(found.reflection) < 1e-4
    assert found.scattered == pytest.approx(1 - abs(np.exp(-0.6j * one)) ** 2, abs=1e-3)


@pytest.mark.slow
def test_a_band_of_a_whole_stator(tmp_path):
    """Between a few condensations the mesh is interpolated, motion and interior too, to a tenth of the tolerance.

    The error of the discretisation is that of the sharpest resonance between the frequencies that are checked.
    """
    stator = replace(_whole(tmp_path), solid=cut("PZT-4", "Z", quality=1000))
    places = (4e-3,)
    band = frequency_band(stator, CHIP_ROW, lowest=2.13e6, highest=2.21e6, drive="a", tolerance=5e-2, places=places)
    middle = driven_wave(stator, CHIP_ROW, frequency=2.17e6, drive="a", tolerance=5e-2, places=places)
    assert 3 * middle.relative_error < band.relative_error < 5e-2
    finer = LEVELS[LEVELS.index(band.model.resolution) + 1]
    for frequency in (2.1335e6, 2.188e6):  # of the largest error, on a resonance, and of a small one
        wave = band.wave(frequency, "a")
        exact = solve_driven(stator, CHIP_ROW, frequency=frequency, drive="a", resolution=finer)
        assert abs(wave.admittance / exact.circuit.admittance - 1) < band.admittance_error
        moved = surface_of(exact).motion(np.array(places))
        assert motion_difference(wave.motion(np.array(places)), moved) < band.relative_error
    anew = driven_solution(replace(band.model, interpolation=None).cascade(2.188e6).solved(), "a")
    moved = surface_of(anew).motion(np.array(places))
    assert motion_difference(wave.motion(np.array(places)), moved) < 5e-3
    assert abs(wave.admittance / anew.circuit.admittance - 1) < 1e-5
    assert len(band.model.interpolation[1].rational.nodes) < 10
    assert wave.power_residual < 1e-5
    nodes = [
        stator_cascade(stator, CHIP_ROW, frequency=f, resolution=LEVELS[0]).solved() for f in (2.13e6, 2.17e6, 2.21e6)
    ]
    at = nodes[0].network.scatterers[0].potentials
    samples = [PieceSample.of(each.network.scatterers[0].piece, at) for each in nodes]
    found = rational_piece(nodes[0].network.scatterers[0].piece, at, 0, samples).resonances
    (square,) = (each for each in found if 2.17e6 < abs(each) ** 0.5 / 2 / np.pi < 2.2e6)
    assert 0.6 < abs(square / square.imag) / 1000 < 1.3  # lossy in permittivity and coupling, too
    peak = abs(square) ** 0.5 / 2 / np.pi
    width = peak * abs(square.imag / square)
    conductance = [
        stator_cascade(stator, CHIP_ROW, frequency=peak + more * width, resolution=LEVELS[0])
        .solved()
        .admittances[0, 0]
        .real
        for more in (-1.0, 0.0, 1.0)
    ]
    assert conductance[0] < 0.7 * conductance[1] > conductance[2], conductance


def test_the_level_of_a_band_of_a_whole_stator_is_chosen_at_its_ends_and_middle(tmp_path, monkeypatch):
    asked = []

    def refuse_the_third(*given, frequency, **rest):
        asked.append(frequency)
        if len(asked) == 3:
            raise ConvergenceError("enough")

    monkeypatch.setattr("fem.solve.band_solution.driven_wave", refuse_the_third)
    with pytest.raises(ConvergenceError, match="enough"):
        frequency_band(_whole(tmp_path), CHIP_ROW, lowest=2.1e6, highest=2.3e6, drive="a", tolerance=0.05)
    assert asked == pytest.approx([2.1e6, 2.2e6, 2.3e6], rel=1e-12)


def test_what_a_whole_stator_has_not(tmp_path):
    """A wave from outside, and for now a line force, are refused in a sentence."""
    stator = _whole(tmp_path)
    path = rectangle(tmp_path / "plain.msh", 0.5, 1.1, size=0.5)
    other = MeshPiece(name="plain", mesh=read_mesh(path, 1e-3), position=6e-3)
    with pytest.raises(InputError, match="is the whole stator: it must be the only piece, got 2"):
        check_layout(replace(stator, pieces=(*stator.pieces, other)), ())
    with pytest.raises(InputError, match="this piece is all of it"):
        reflector(stator, frequency=2.17e6, tolerance=0.1)
    with pytest.raises(InputError, match="must leave some uniform stator for a line force"):
        forced_wave(
            stator,
            CHIP_ROW,
            (LineForce(name="tip", position=4e-3, component="z"),),
            frequency=2.17e6,
            tolerance=0.1,
            places=(1e-3,),
        )


def test_two_pieces_as_one_end_are_told_apart_by_their_places(tmp_path):
    """One file at two places has one name: the refusal says where each of them lies."""
    mesh = read_mesh(bevelled_end(tmp_path / "end.msh", 0.7, 0.5, 0.8, size=0.35), 1e-3)
    ends = tuple(MeshPiece(name="end", mesh=mesh, position=place) for place in (7e-3, 5e-3))
    stator = replace(plate(cut("PZT-4", "Z")), length=8e-3, thickness=0.8e-3, ends="free", pieces=ends)
    with pytest.raises(InputError, match=r'"end" \(5 to 5.7 mm\) and "end" \(7 to 7.7 mm\) are both the right end'):
        check_layout(stator, ())


def _with_profile(path, bottom, *, width=2.0) -> Stator:
    """A stator with a piece between whose flat ends the upper side runs through the points ``bottom`` (mm)."""
    flat = [[0.0, 0.0], [0.3, 0.0]]
    top = np.array([*flat, *bottom, *([width - x, z] for x, z in flat[::-1])])
    piece = MeshPiece(name="arc", mesh=read_mesh(profile(path, top, 1.1), 1e-3), position=5e-3)
    return Stator(solid=cut("PZT-4", "Z"), length=10e-3, thickness=1.1e-3, ends="absorbing", pieces=(piece,))


def test_the_sagitta_of_a_coarsely_drawn_arc_is_stated(tmp_path):
    """The change of u_z that a warning states contains that against edges a third as long, and is not far from it."""
    row = (Transducer(name="a", center=2.5e-3, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=1e-2),)
    places, moved, stated = np.array([4.1e-3, 7.6e-3]), [], []
    radius, half = 0.5125, 0.4  # 0.2 mm deep
    for edges in (8, 24):
        angle = np.arcsin(half / radius) * np.linspace(-1, 1, edges + 1)
        arc = np.stack([1 + radius * np.sin(angle), radius * (np.cos(angle[0]) - np.cos(angle))], axis=1)
        stator = _with_profile(tmp_path / f"arc{edges}.msh", arc)
        solved = solve_driven(stator, row, frequency=2.17e6, drive="a", resolution=LEVELS[0])
        moved.append(surface_of(solved).motion(places))
        (said,) = [each for each in stator.piece_warnings(2.17e6) if "sagitta" in each]
        stated.append(float(said.split("about ")[1].split()[0]))
    assert stated[1] == pytest.approx(stated[0] / 9, rel=0.1)
    true = motion_difference(*moved)
    assert true < stated[0] - stated[1] < 10 * true


@pytest.mark.slow
def test_the_vertices_of_an_arc_need_fewer_layers(tmp_path, monkeypatch):
    """Two layers of three at vertices that turn by 13 degrees: the motion of all layers; with none it is not."""
    row = (Transducer(name="a", center=2.5e-3, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=1e-2),)
    angle = np.arcsin(0.4 / 0.5) * np.linspace(-1, 1, 9)
    arc = np.stack([1 + 0.5 * np.sin(angle), 0.5 * (np.cos(angle[0]) - np.cos(angle))], axis=1)
    stator = _with_profile(tmp_path / "arc.msh", arc)

    def motion():
        solved = solve_driven(stator, row, frequency=2.17e6, drive="a", resolution=LEVELS[2])
        return surface_of(solved).motion(np.array([4.1e-3, 7.6e-3]))

    fewer = motion()
    assert quad_mesh.corner_layers(np.deg2rad(13.3), 3) == 2
    assert quad_mesh.corner_layers(np.deg2rad(30), 3) == 3
    monkeypatch.setattr(quad_mesh, "corner_layers", lambda turn, layers: layers)
    every = motion()
    monkeypatch.setattr(quad_mesh, "corner_layers", lambda turn, layers: 0)
    none = motion()
    assert 1e-9 < motion_difference(fewer, every) < 2e-6
    assert motion_difference(none, every) > 2e-5


@pytest.mark.parametrize("bottom", [[[0.6, -0.2], [1.2, -0.2]], [[0.7, -0.01], [1.3, -0.01]]])
def test_slanted_walls_are_no_arc(tmp_path, bottom):
    """A trapezoidal groove has two corners that turn to one side: they were drawn on purpose."""
    stator = _with_profile(tmp_path / "trapezoid.msh", bottom)
    assert not any("sagitta" in each for each in stator.piece_warnings(2.17e6))
