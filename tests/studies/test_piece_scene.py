"""Scenes with [[piece]]: what a run gives, and every fault of a mesh in one sentence."""

import base64
import gzip
import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import fem
import studies
from studies import Scene, SceneError, run
from studies.export.mask_files import gds_files
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.solve.predictor import Predictor
from studies.study_list import module
from studies.sweeps.plan import designed
from studies.view import wave_page
from studies.view.field_points import SectionPart, sheets
from studies.view.field_quantities import shade
from studies.view.picture import Picture
from studies.view.run_field import run_field
from studies.view.views import views
from tests.fem.drawings import bevelled_end, chip, rectangle, write_msh

STATOR = {"material": "PZT-4", "length": "12 mm", "thickness": "1.1 mm", "width": "20 mm", "ends": "absorbing"}
ROW = {"name": "t", "center": "2.5 mm", "finger_pairs": 2, "period": "1 mm", "metallisation": 0.5, "aperture": "10 mm"}
DRIVE = {"frequency": "2.17 MHz", "transducer": "t", "voltage": "10 V"}


def scene(file, stator=None, **piece):
    piece = {"file": str(file), "length_unit": "mm", "position": "6 mm"} | piece
    return Scene.from_table(
        "", {"stator": STATOR | (stator or {}), "transducer": [ROW], "piece": [piece], "drive": DRIVE}
    )


def refused(*args, **piece) -> str:
    with pytest.raises(SceneError) as error:
        resolved(scene(*args, **piece))
    return str(error.value)


@pytest.fixture(name="plain")
def plain_mesh(tmp_path):
    return rectangle(tmp_path / "plain.msh", 1.0, 1.1, size=0.5)


def square(path, points=None, triangles=None, lines=None, solid="stator"):
    """Two triangles between x = 0 and 1, z = -1.1 and 0, with some faults."""
    points = points or [(0, -1.1), (1, -1.1), (1, 0), (0, 0)]
    triangles = triangles or [(0, 1, 2), (0, 2, 3)]
    lines = {"left": [(3, 0)], "right": [(1, 2)]} if lines is None else lines
    return write_msh(path, points, {solid: triangles}, lines)


def test_a_groove_runs_from_the_scene_to_the_surface(tmp_path):
    """The surface is known on the groove too; the power that leaves and is lost is what came in."""
    groove = rectangle(tmp_path / "groove.msh", 1.0, 1.1, size=0.5, groove=(0.4, 0.2, 0.15))
    record = run(scene(groove), tolerance=1e-2)
    plain = run(scene(groove).replace(piece=None), tolerance=1e-2)
    assert record.error["relative"] < 1e-2
    x, u_z = record.surface["x_m"], record.surface["u_z_m_per_V"]
    on_groove = (x > 6.4e-3) & (x < 6.6e-3)
    assert on_groove.sum() > 2
    assert np.isfinite(abs(u_z)).all()
    assert abs(u_z[on_groove]).max() > 0.1 * abs(u_z).max()
    changed = record.electrical["admittance_S"] / plain.electrical["admittance_S"] - 1
    assert abs(changed) > 1e-2
    again = run(Scene.from_table("", record.scene.to_table()), tolerance=1e-2)
    assert again.electrical["admittance_S"] == record.electrical["admittance_S"]
    _drawn_with_its_groove(run_field(record), 6e-3, (6.4e-3, 6.6e-3), -0.15e-3)


def _drawn_with_its_groove(found, start, groove, foot):
    """In a picture the piece stands on its own elements in the place of the grid; page and solid leave the groove."""
    shading = shade(found, "u_z")
    drawn = SectionPart.of(found, shading, span=(0.0, found.length), bottom=-1.1e-3, spacing=0.05e-3)
    section, mesh = sheets(found, drawn, shading, solid=False)
    middle = (drawn.x[1:] + drawn.x[:-1]) / 2
    assert np.array_equal(section.hidden.all(axis=1), (middle > start) & (middle < start + 1e-3))
    x, z = mesh.rest[mesh.quads, 0, 0][..., [0, 2]].mean(axis=1).T
    assert (x.min() > start) & (x.max() < start + 1e-3)
    assert not ((x > groove[0]) & (x < groove[1]) & (z > foot)).any()
    _, surface, *_ = sheets(found, drawn, shading, solid=True)
    step = np.diff(drawn.x).max()
    assert surface.hidden[(middle > groove[0]) & (middle < groove[1])].all()
    assert not surface.hidden[(middle < groove[0] - step) | (middle > groove[1] + step)].any()
    drawing = Picture(found, views(found), size=(900, 600), quantity="u_z", phase=0.0, factor=None)
    assert drawing.image(0.3).std() > 5
    drawing.plotter.close()
    page = wave_page.page(found, quantity="u_z", phase=0.0, factor=None, span=None)
    meta = json.loads(re.search(r'<script id="meta"[^>]*>(.*?)</script>', page, re.S).group(1))
    raw = gzip.decompress(base64.b64decode(re.search(r'<script id="data"[^>]*>(.*?)<', page, re.S).group(1)))
    offset = 4 * (meta["nx"] + meta["nz"])  # behind x and z
    inside = np.frombuffer(raw, dtype="u1", count=meta["nx"] * meta["nz"], offset=offset)
    x = np.frombuffer(raw, dtype="<f4", count=meta["nx"])
    empty = ~inside.reshape(meta["nx"], -1).astype(bool)
    assert empty.any()
    assert not empty[(x < groove[0]) | (x > groove[1])].any()


def test_a_left_end_is_the_mirror_image_of_a_right_end(tmp_path):
    """A file with ``right`` alone and one with ``left`` alone: the same motion from the other side, and power lost."""
    place, length = np.array([5.3e-3, 6.1e-3, 1e-3]), 12e-3
    records = []
    for mirrored in (False, True):
        file = bevelled_end(tmp_path / f"end{mirrored}.msh", 1.0, 0.6, 1.1, size=0.35, mirrored=mirrored)
        table = scene(file, {"ends": "free"}, position="1 mm" if mirrored else "11 mm").to_table()
        table["transducer"][0]["center"] = 9.5e-3 if mirrored else 2.5e-3
        records.append(run(Scene.from_table("", table), tolerance=1e-2))
    right, left = (record.surface_motion.wave for record in records)
    assert records[0].electrical["admittance_S"] == pytest.approx(records[1].electrical["admittance_S"], rel=1e-6)
    # the fingers stand in the other order: the mirror image has the other sign, and u_x changes it again
    expected = -left.motion(length - place) * np.array([[-1], [1]])
    assert abs(right.motion(place) - expected).max() < 1e-6 * abs(expected).max()
    assert not any("ends at x" in line for record in records for line in record.warnings)
    drawn = [run_field(record).field for record in records]
    (right_piece,), (left_piece,) = (each.pieces for each in drawn)
    assert right_piece.span == pytest.approx((11e-3, 12e-3))
    assert left_piece.span == pytest.approx((0, 1e-3), abs=1e-9)
    at = np.lexsort(np.round(right_piece.points, 9).T), np.lexsort(np.round(left_piece.points * [-1, 1], 9).T)
    u_z, mirrored_u_z = (p.displacement[k, 2] for p, k in zip((right_piece, left_piece), at, strict=True))
    assert abs(u_z + mirrored_u_z).max() < 1e-6 * abs(u_z).max()


def whole(tmp_path, stator=None, electrodes=None, position="0 mm", drawn=None, row=ROW):
    """A scene whose stator is one mesh, with the fingers of its transducer drawn."""
    fingers = {"p": [[1.625, 1.875], [2.625, 2.875]], "m": [[2.125, 2.375], [3.125, 3.375]]}
    file = chip(tmp_path / "chip.msh", 8.0, 1.1, drawn or fingers, size=0.5)
    piece = {"file": str(file), "length_unit": "mm", "position": position}
    piece["electrodes"] = electrodes or {"p": "t+", "m": "t-"}
    blocks = {"stator": STATOR | {"length": "8 mm", "ends": "free"} | (stator or {}), "drive": DRIVE}
    return Scene.from_table("", blocks | {"transducer": [row], "piece": [piece]})


def test_a_stator_that_is_one_mesh(tmp_path):
    """Run, its field and a warning where the block's fingers are others; what no such stator has is refused."""
    given = whole(tmp_path)
    record = run(given, tolerance=1e-2)
    assert not [line for line in record.warnings if "mesh draws" in line]
    (aperture,) = [row["size"] for row in record.model_error if row["effect"] == "finite aperture"]
    assert 1e-5 < abs(aperture) < 0.2
    field = run_field(record).field
    assert field.pieces[0].span == pytest.approx((0, 8e-3))
    moved = record.surface_motion.wave.motion(field.x.clip(0, 8e-3))
    assert abs(field.displacement[:, -1, [0, 2]].T - moved).max() < 1e-6 * abs(moved).max()
    wider = ROW | {"metallisation": 0.6}
    (said,) = [line for line in run(whole(tmp_path, row=wider), tolerance=0.5).warnings if "mesh draws" in line]
    assert said == (
        'transducer "t": the mesh draws 2 fingers "+" from 1.625 to 2.875 mm and 2 "-" from 2.125 to 3.375 mm, the '
        "block has 2 from 1.6 to 2.9 mm and 2 from 2.1 to 3.4 mm: the mesh counts"
    )


def test_the_reflector_at_the_frequencies_of_a_band():
    """The study's frequencies are those asked for, and its answer states the reflection of each."""
    groove, tolerance = Path(studies.__file__).parent / "scenes" / "meshes" / "groove.msh", 0.1
    given = scene(groove, {"thickness": "2 mm", "ends": "absorbing"}, position="9 mm")
    found = module("reflector").run(given, band="2.1:2.3:2", tolerance=tolerance)
    stator = build(given).stator
    lines = dict(found.answer)
    for frequency, name in ((2.1e6, "2.1 MHz"), (2.3e6, "2.3 MHz")):
        alone = fem.reflector(stator, frequency=frequency, tolerance=tolerance)
        expected = f"reflection {abs(alone.reflection):.4f}, transmission {abs(alone.transmission):.4f}"
        assert lines[name] == expected
    with pytest.raises(SceneError, match="--band must rise from START"):
        module("reflector").run(given, band="2.3:2.1:2")


def test_a_mask_of_a_mesh(tmp_path):
    """Its picture asks for no beam."""
    drawn = gds_files(whole(tmp_path), "chip", tolerance=1e-2)
    ax = Figure().subplots()
    drawn.pictures["mask.png"](ax)
    assert ax.patches or ax.collections


def test_places_of_one_file(plain):
    """Several places are several pieces; the unit of the file counts."""
    stator = Model(scene(plain, {"bottom": "grounded"}, position=["5 mm", "7 mm", "9.5 mm"])).stator
    assert [each.extent[0] for each in stator.pieces] == pytest.approx([5e-3, 7e-3, 9.5e-3])
    assert stator.pieces[0].mesh.extent == pytest.approx((0, 1e-3))
    assert "meant?" not in refused(plain, position="15 mm")


FAULTS = {
    "leaning": (
        {"points": [(0, -1.1), (1, -1.1), (1, 0), (0.03, 0)]},
        "the line group left is not one vertical line: x runs from 0 to 0.03 mm",
    ),
    "flat": (
        {"triangles": [(0, 1, 2), (0, 2, 3), (0, 3, 3)]},
        r"1 triangle has no area, the first at \(0.00, -0.37\) mm",
    ),
    "group": (
        {"lines": {"Left": [(3, 0)], "right": [(1, 2)]}},
        'unknown line group "Left": left, right, bottom, grounded, clamped, surface or electrode:NAME',
    ),
    "no stator": ({"solid": "body"}, "has no surface group stator"),
    "folded": (
        {"triangles": [(0, 1, 2), (0, 2, 3), (0, 2, 4)], "points": [(0, -1.1), (1, -1.1), (1, 0), (0, 0), (0.2, -0.2)]},
        "elements overlap or are inverted",
    ),
    "twice": (
        {"lines": {"left": [(3, 0)], "right": [(1, 2)], "clamped": [(0, 1)], "bottom": [(0, 1)]}},
        r"the line at \(0.50, -1.10\) mm is in two groups, clamped and bottom",
    ),
    "parts": (
        {
            "points": [(0, -1.1), (1, -1.1), (1, 0), (0, 0), (0.2, 0.0), (0.4, 0.0), (0.3, 0.1)],
            "triangles": [(0, 1, 2), (0, 2, 3), (4, 5, 6)],
        },
        "the mesh has 2 parts that share no nodes",
    ),
    "no interface": ({"lines": {}}, "has no line group left or right"),
    "inside": ({"lines": {"left": [(0, 2)], "right": [(1, 2)]}}, "the line group left is not one vertical line"),
    "hole in the bottom": (
        {
            "points": [(0, -1.1), (0.4, -1.1), (0.6, -1.1), (1, -1.1), (1, 0), (0, 0)],
            "triangles": [(0, 1, 5), (3, 4, 5), (1, 3, 5)],
            "lines": {"left": [(5, 0)], "right": [(3, 4)], "bottom": [(0, 1), (1, 2), (2, 3)]},
        },
        r"no element has the line at \(0.50, -1.10\) mm of the group bottom as an edge: either the mesh has a hole",
    ),
    "no edge": (
        {"lines": {"left": [(3, 0)], "right": [(1, 2)], "clamped": [(1, 3)]}},
        r"no element has the line at \(0.50, -0.55\) mm of the group clamped as an edge: either the mesh has a hole",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_faulty_mesh_is_refused_in_a_sentence(tmp_path, name):
    given, sentence = FAULTS[name]
    path = square(tmp_path / "piece.msh", **given)
    with pytest.raises(SceneError, match=sentence):
        resolved(scene(path))


def test_a_gap_in_the_interface(tmp_path):
    path = square(
        tmp_path / "p.msh",
        points=[(0, -1.1), (1, -1.1), (1, 0), (0, 0), (0, -0.4), (0, -0.7), (0.2, -0.55)],
        triangles=[(0, 1, 5), (5, 1, 6), (6, 1, 2), (6, 2, 4), (4, 2, 3)],
        lines={"left": [(0, 5), (4, 3)], "right": [(1, 2)]},
    )
    assert "the group left has a gap from z = -0.7 to -0.4 mm; gmsh writes only surfaces" in refused(path)


def test_an_end_piece_ends_where_the_stator_does_but_for_rounding(tmp_path):
    end = rectangle(tmp_path / "end.msh", 1.0, 1.1, size=0.5, groups=("left", "bottom"))
    rounded = run(scene(end, {"ends": "free"}, position="10.99999 mm"), tolerance=0.5)
    assert rounded.surface["x_m"][-1] == 12e-3


def test_a_group_that_covers_part_of_a_border(tmp_path):
    points = [(0, -1.1), (1, -1.1), (1, 0), (0, 0), (0, -0.6)]
    triangles, lines = [(0, 1, 4), (1, 2, 4), (2, 3, 4)], {"left": [(4, 0)], "right": [(1, 2)]}
    half = square(tmp_path / "half.msh", points, triangles, lines)
    assert (
        'piece.0 ("a") must have all lines of its left border in the line group left: in the file "half" the group '
        "covers 0.5 of 1.1 mm" in refused(half, name="a")
    )


def test_a_ball_over_a_groove_is_refused_wherever_it_is_asked_for(tmp_path):
    corners = [(0, -1.1), (1, -1.1), (1, 0), (0.65, 0), (0.6, -0.1), (0.4, -0.1), (0.35, 0), (0, 0)]
    triangles = [(0, 1, 4), (1, 2, 3), (1, 3, 4), (0, 4, 5), (0, 5, 6), (0, 6, 7)]
    lines = {"left": [(7, 0)], "right": [(1, 2)]}
    drawn = scene(write_msh(tmp_path / "v.msh", corners, {"stator": triangles}, lines))
    assert Model(drawn).pieces[0].gaps == (pytest.approx((6.35e-3, 6.65e-3)),)
    slider = {
        "mass": "0.1 g", "preload": "1 mN", "friction_coefficient": 0.1, "radius": "1 mm", "ball": "steel",
        "contacts": ["-0.5 mm", "0.5 mm"],
    }  # fmt: skip
    on_groove = drawn.replace(slider=slider | {"position": "6.9 mm"})
    with pytest.raises(SceneError) as error:
        resolved(on_groove)
    assert "off 'v' from 6.35 to 6.65 mm, where it has no plain surface at z = 0, got some at 6.4 mm" in str(
        error.value
    )
    beside = drawn.replace(slider=slider | {"position": "6.5 mm"})
    assert resolved(beside).slider.contact_positions[0][0] == pytest.approx(6e-3)
    with pytest.raises(SceneError, match="no plain surface"):
        Predictor(beside.to_table(), tolerance=1e-3).contact({"slider.position": 6.9e-3})
    wide = {"diameter": "20 um", "pitch": "0.2 mm", "rows": 10, "columns": 1}
    slider = {key: value for key, value in slider.items() if key not in ("radius", "contacts")} | {"pillars": wide}
    with pytest.raises(SceneError, match=r"got some at 6\.09 to 7\.91 mm"):
        resolved(drawn.replace(slider=slider | {"position": "7 mm"}))


def test_a_strip_of_a_solid_is_a_finger(tmp_path):
    groups = ("left", "right", "bottom", "electrode:strip")
    strip = rectangle(tmp_path / "s.msh", 1.0, 1.1, size=0.5, strip=(0.4, 0.2, 0.1), groups=groups)
    resolved(scene(strip, materials={"strip": "aluminium"}, electrodes={"strip": "t+"}))


def test_electrodes_in_the_wrong_place(tmp_path):
    """Refused before anything is solved: at an interface, on another electrode, on a solid without coupling."""
    sides = {"left": [(3, 0)], "right": [(1, 2)]}
    file = square(tmp_path / "p.msh", lines=sides | {"electrode:e": [(2, 3)]})
    assert 'piece.0.file ("p") "electrode:e" reaches the interface left at (0, 0) mm' in refused(file)
    points = [(0, -1.1), (0.5, -1.1), (1, -1.1), (1, 0), (0.7, 0), (0.5, 0), (0.3, 0), (0, 0)]
    triangles = [(0, 1, 7), (1, 6, 7), (1, 5, 6), (1, 4, 5), (1, 3, 4), (1, 2, 3)]
    sides = {"left": [(7, 0)], "right": [(2, 3)]}
    file = square(tmp_path / "q.msh", points, triangles, sides | {"electrode:a": [(6, 5)], "electrode:b": [(5, 4)]})
    assert '"electrode:a" and "electrode:b" touch at (0.5, 0) mm: give them one name' in refused(file)
    points = [(0, -1.1), (1, -1.1), (1, 0), (0.6, 0), (0.4, 0), (0, 0), (0.5, 0.1)]
    solids = {"stator": [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)], "strip": [(4, 3, 6)]}
    sides = {"left": [(5, 0)], "right": [(1, 2)], "electrode:e": [(3, 6)]}
    file = write_msh(tmp_path / "r.msh", points, solids, sides)
    assert 'must draw the line group "electrode:e" on a piezoelectric solid' in refused(
        file, materials={"strip": "aluminium"}
    )


def test_a_mesh_that_is_too_fine(tmp_path):
    """A file whose coarsest discretisation is too large: refused at once, with the size that would do."""
    fine = rectangle(tmp_path / "fine.msh", 1.0, 1.1, size=0.0122)
    words = refused(fine)
    assert 'piece.0.file ("fine") has 14760 elements, about 0.013 mm wide, and at least 2.1e+06 unknowns' in words
    assert "draw elements of 0.013 mm or more" in words


def test_files_that_are_no_mesh(tmp_path, plain):
    (tmp_path / "text.msh").write_text("a groove")
    assert '"text.msh": the file is no mesh of gmsh, format 2.2 or 4.1' in refused(tmp_path / "text.msh")
    text = plain.read_text()
    (tmp_path / "deep.msh").write_text(text.replace(" 0.0 0\n", " 0.0 0.5\n"))
    assert "the file's third coordinate is not constant: a section has two" in refused(tmp_path / "deep.msh")
    (tmp_path / "nan.msh").write_text(text.replace("1 0.0 -1.1 0", "1 nan -1.1 0"))
    assert "the file has a coordinate that is no finite number" in refused(tmp_path / "nan.msh")
    (tmp_path / "far.msh").write_text(text.replace("1 0.0 -1.1 0", "1 1e300 -1.1 0"))
    assert "the file has a coordinate of 1e+297 m, at most 1000 m" in refused(tmp_path / "far.msh")
    lines = text.split("$Elements\n")
    count, *rest = lines[1].split("\n")
    cubic = f"{int(count)}\n" + "\n".join(rest).replace("1 1 2 1 1 1 2", "1 26 2 1 1 1 2 3 4", 1)
    (tmp_path / "cubic.msh").write_text(lines[0] + "$Elements\n" + cubic)
    assert "elements of order 3 are not read: gmsh -order 2" in refused(tmp_path / "cubic.msh")


def test_what_a_run_warns_of(tmp_path):
    """A corner near the interface."""
    near = rectangle(tmp_path / "near.msh", 1.0, 1.1, size=0.5, groove=(0.05, 0.2, 0.15))
    (said,) = Model(scene(near)).stator.piece_warnings(2.17e6)
    assert said.startswith('piece "near": a corner stands 0.05 mm from the interface left, nearer than an eighth')


def test_a_free_wave_says_that_it_meets_no_piece(plain):
    table = scene(plain).to_table()
    free = Scene.from_table("", {key: table[key] for key in ("stator", "piece")} | {"drive": {"frequency": 2.17e6}})
    assert any(line.startswith("meshed pieces: the free wave") for line in run(free, tolerance=1e-2).left_out)


def test_a_sweep_of_a_changed_mesh_is_another_sweep(tmp_path, plain):
    """The mesh's content counts, not its name and not its date."""
    table = scene(plain).to_table()

    def identity():
        return designed(table, {"drive.frequency": ["2.1 MHz", "2.2 MHz"]}, tolerance=1e-2).identity

    before = identity()
    plain.touch()
    assert identity() == before
    rectangle(plain, 1.0, 1.1, size=0.5, groove=(0.4, 0.2, 0.15))
    changed = {name for name, digest in identity().items() if before[name] != digest}
    assert changed == {f"file {plain}"}


def test_the_shipped_meshes(tmp_path):
    """Groove, strip and bevel as they are shipped: groups, extents, and a solution of each at a coarse level."""
    meshes = Path(studies.__file__).parent / "scenes" / "meshes"
    for name, rest in (("groove", {}), ("strip", {"materials": {"strip": "aluminium"}}), ("bevel", {})):
        end = name == "bevel"
        given = scene(
            meshes / f"{name}.msh",
            {"thickness": "2 mm", "ends": "free" if end else "absorbing"},
            position="9 mm" if not end else "10.5 mm",
            **rest,
        )
        stator = build(given).stator
        (piece,) = stator.pieces
        assert {"left", "bottom"} <= set(piece.mesh.lines)
        assert ("right" in piece.mesh.lines) == (not end)
        assert piece.fits("left", 2e-3)
        found = fem.reflector(stator, frequency=2.17e6, tolerance=0.1)
        sent = abs(found.ends[0][1]) if end else abs(found.reflection)
        assert 1e-3 < sent < 1 + 1e-6
    block = {"length": "12 mm", "thickness": "1 mm", "ends": "free"}
    given = scene(meshes / "chip.msh", block, position="0 mm", electrodes={"plus": "t+", "minus": "t-"}).to_table()
    given["transducer"][0] |= {"center": "3.875 mm", "finger_pairs": 4}
    record = run(Scene.from_table("", given), tolerance=0.1)
    assert not [line for line in record.warnings if "mesh draws" in line]
    assert 0 < record.electrical["admittance_S"].imag
