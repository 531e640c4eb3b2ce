"""Masks read back by gdstk and ezdxf: period, metallisation, aperture, place and angle to the grid, combs apart."""

import math
from functools import cache
from importlib.resources import files
from itertools import combinations, pairwise

import numpy as np
import pytest

from studies.__main__ import main
from studies.export.mask import LAYERS, Sizes, apart, mask
from studies.export.mask_files import dxf, gds
from studies.model import resolve
from studies.scene import Scene

NAMES = ("twente", "lithium-niobate-128yx", "crossed")
gdstk = pytest.importorskip("gdstk")


@cache
def drawn(name):
    return mask(Scene.load(name))


@cache
def blocks(name):
    return resolve.resolved(Scene.load(name)).transducer


@cache
def read_back(name, tmp):
    path = tmp / f"{name}.gds"
    path.write_bytes(gds(drawn(name)))
    library = gdstk.read_gds(str(path))
    assert library.unit == 1e-6
    (cell,) = library.cells
    return cell


def polygons(cell, layer, transducer, comb=None):
    """Corners in m of the polygons of a layer and a transducer (counted from 1), of one comb (1, 2) or of both."""
    kinds = [10 * transducer + each for each in ([comb] if comb else [1, 2, 3])]
    return [each.points * 1e-6 for each in cell.polygons if each.layer == LAYERS[layer] and each.datatype in kinds]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("gds")


@pytest.mark.parametrize("name", NAMES)
def test_the_polygons_give_the_transducers_to_the_grid(name, folder):
    cell, grid = read_back(name, folder), drawn(name).grid
    for number, block in enumerate(blocks(name), 1):
        angle = math.radians(block.angle)
        along, across = (np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)]))
        fingers = polygons(cell, "fingers", number)
        assert len(fingers) == 2 * block.finger_pairs
        left = np.array(sorted(float((each @ along).min()) for each in fingers))
        width = np.array([np.ptp(each @ along) for each in fingers])
        # period over the whole row, metallisation of every finger
        periods = 2 * np.ptp(left) / (len(left) - 1)
        assert abs(periods - block.period) <= 2 * grid / (len(left) - 1) * 1.01
        assert np.abs(width - block.metallisation * block.period / 2).max() <= grid * 1.01
        # aperture: where fingers of both combs lie side by side
        plus, minus = (polygons(cell, "fingers", number, comb) for comb in (1, 2))
        high = min(float((each @ across).max()) for each in minus)
        low = max(float((each @ across).min()) for each in plus)
        assert abs(high - low - block.aperture) <= grid * 1.01
        # place: the middle of the overlap
        middle = 0.5 * (left[0] + left[-1] + width.mean()) * along + 0.5 * (low + high) * across
        assert np.abs(middle - block.center_xy).max() <= grid * 1.01
        # angle: the long sides of the first finger
        sides = np.diff(np.vstack([fingers[0], fingers[0][:1]]), axis=0)
        longest = sides[np.argmax(np.linalg.norm(sides, axis=1))]
        turned = (math.degrees(math.atan2(longest[1], longest[0])) - 90.0 - block.angle) % 180.0
        assert min(turned, 180.0 - turned) < 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_no_polygon_overlaps_one_of_another_comb(name, folder):
    cell = read_back(name, folder)
    combs = {}
    for each in cell.polygons:
        if each.datatype:
            combs.setdefault(each.datatype, []).append(each)
    assert len(combs) == 2 * len(blocks(name))
    for one, other in combinations(combs.values(), 2):
        assert gdstk.boolean(one, other, "and") == []
    # and each comb is one piece of metal: fingers, busbar and pad
    for own in combs.values():
        assert len(gdstk.boolean(own, [], "or", precision=1e-4)) == 1
    outline = next(each for each in cell.polygons if each.layer == LAYERS["outline"])
    assert gdstk.boolean([each for own in combs.values() for each in own], outline, "not") == []


def test_a_turned_transducer_off_the_right_angle_is_snapped_and_says_by_how_much():
    scene = Scene.load("crossed")
    turned = [dict(each) for each in scene.to_table()["transducer"]]
    turned[0]["angle"] = "10 deg"
    made = mask(scene.replace(transducer=turned), Sizes(grid=1e-7))
    corners = np.vstack([each.corners for each in made.polygons])
    assert np.abs(corners / 1e-7 - np.round(corners / 1e-7)).max() < 1e-6
    assert 2e-8 < made.shift <= 5.01e-8
    assert 1e-8 < made.width_error < 1.5e-7
    own = [each.corners for each in made.polygons if each.transducer == "left" and each.layer == "fingers"]
    side = own[0][1] - own[0][0]
    assert math.degrees(math.atan2(side[1], side[0])) == pytest.approx(10.0, abs=0.05)


def test_patterns_split_fingers_and_open_strips_are_drawn():
    scene = Scene.load("twente-left").replace(
        transducer=[
            {
                "name": "left", "center": "15 mm", "finger_pairs": 3, "period": "1 mm", "metallisation": 0.4,
                "aperture": "20 mm", "pattern": "+-0o+-",
            },
            {
                "name": "split", "center": "60 mm", "finger_pairs": 2, "period": "1 mm", "metallisation": 0.5,
                "aperture": "10 mm", "split": True,
            },
        ]
    )  # fmt: skip
    made = mask(scene)
    combs = [(each.transducer, each.comb) for each in made.polygons if each.layer == "fingers"]
    assert [comb for name, comb in combs if name == "left"] == ["+", "-", "o", "+", "-"]
    assert [comb for name, comb in combs if name == "split"] == ["+", "+", "-", "-"] * 2
    strip = next(each.corners for each in made.polygons if each.comb == "o")
    assert np.ptp(strip[:, 1]) == pytest.approx(20e-3)
    widths = {
        name: np.ptp(each.corners[:, 0])
        for each in made.polygons
        for name in [each.transducer]
        if each.layer == "fingers"
    }
    assert widths["left"] == pytest.approx(0.2e-3)
    assert widths["split"] == pytest.approx(0.125e-3)


def test_chirped_transducers_and_cells_of_three_are_drawn():
    """The drawn edges, and the errors of the grid, of fingers of different widths."""
    own = {"center": "15 mm", "finger_pairs": 4, "period": "1 mm", "metallisation": 0.5, "aperture": "20 mm"}
    scene = Scene.load("twente-left").replace(
        transducer=[own | {"name": "left", "cell": "DART"}, own | {"name": "b", "center": "60 mm", "chirp": 0.4}]
    )
    made = mask(scene, Sizes(grid=1e-6))
    fingers = [each for each in made.polygons if each.layer == "fingers"]
    dart, chirped = ([each for each in fingers if each.transducer == name] for name in ("left", "b"))
    assert "".join(each.comb for each in dart) == "-+-" * 4
    np.testing.assert_allclose([np.ptp(each.corners[:, 0]) for each in dart[:3]], [125e-6, 125e-6, 375e-6], atol=1.1e-6)
    x = np.array([each.corners[:, 0].mean() for each in chirped])
    np.testing.assert_allclose(np.diff(x)[[0, -1]], [0.5e-3 * 0.85, 0.5e-3 * 1.15], rtol=0.01)
    np.testing.assert_allclose(np.diff(np.diff(x)), np.mean(np.diff(np.diff(x))), atol=3e-6)  # linear but for the grid
    assert 0 < made.width_error <= 1.01e-6
    edges = sorted((each.corners[:, 0].min(), each.corners[:, 0].max()) for each in dart)
    assert made.gap == pytest.approx(min(b[0] - a[1] for a, b in pairwise(edges)), abs=1e-12)
    busbars = [each.corners for each in made.polygons if each.layer == "busbars" and each.transducer == "b"]
    assert {round(float(each[:, 0].min()), 9) for each in busbars} == {
        round(float(x[0] - np.ptp(chirped[0].corners[:, 0]) / 2), 9)
    }


def test_apodised_and_slanted_transducers_are_drawn():
    """Tips and dummy fingers about a gap; sides that run apart with y."""
    own = {"center": "15 mm", "finger_pairs": 2, "period": "1 mm", "metallisation": 0.5, "aperture": "8 mm"}
    overlaps = [1.0, 0.5, 0.25, 0.99]  # beyond the last tip half a gap does not fit
    scene = Scene.load("twente-left").replace(
        transducer=[
            own | {"name": "left", "apodisation": overlaps},
            own | {"name": "b", "center": "60 mm", "slant": 0.4},
        ]
    )
    made = mask(scene, Sizes(busbar=1e-3, end_gap=0.2e-3, pad=0.0))
    fingers = [each for each in made.polygons if each.layer == "fingers"]
    spans = [
        (each.comb, round(float(each.corners[:, 1].min()) * 1e3, 6), round(float(each.corners[:, 1].max()) * 1e3, 6))
        for each in fingers
        if each.transducer == "left"
    ]
    assert spans == [
        ("+", -4.0, 4.7), ("-", -4.7, 1.9), ("+", 2.1, 4.7), ("+", -0.9, 4.7), ("-", -4.7, -1.1), ("-", -4.7, 4.0),
    ]  # fmt: skip
    slanted = [each.corners for each in fingers if each.transducer == "b"]
    low, high = slanted[0][np.argsort(slanted[0][:, 1])].reshape(2, 2, 2)
    for y, corners in ((-4.0e-3, low), (4.7e-3, high)):
        edges = 60e-3 + np.array([-0.875e-3, -0.625e-3]) * (1 + 0.4 * y / 8e-3)
        np.testing.assert_allclose(np.sort(corners[:, 0]), edges, atol=6e-9)
    assert made.gap == pytest.approx(0.25e-3 * 0.8, abs=2e-8)  # of the slanted one at y = -W/2


def test_dxf_has_named_layers_and_the_same_polygons(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    path = tmp_path / "mask.dxf"
    path.write_bytes(dxf(drawn("twente")))
    document = ezdxf.readfile(path)
    lines = list(document.modelspace().query("LWPOLYLINE"))
    assert document.header["$INSUNITS"] == 13
    assert len(lines) == len(drawn("twente").polygons)
    assert {"FINGERS_left_plus", "PADS_right_minus", "OUTLINE"} <= {each.dxf.layer for each in lines}
    first, same = np.array(lines[0].get_points("xy")) * 1e-6, drawn("twente").polygons[0].corners
    np.testing.assert_allclose(first, same, atol=1e-12)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (['pad="30 mm"'], "must leave its parts on the chip"),
        (['pad="3 ms"'], "size.pad must be a length"),
        (["pat=1e-3"], "--size must be KEY=VALUE, got 'pat=1e-3'; did you mean pad?"),
        (["grid=0"], "size.grid must be positive"),
        (['grid="0.4 mm"'], "size.grid must be at most a tenth of the narrowest finger, 24.68 um, got 400 um"),
        (['grid="24.7 um"'], "size.grid must be at most a tenth"),
        (['mark="60 mm"', 'margin="30 mm"'], "size.mark must leave the marks free"),
    ],
)
def test_masks_that_cannot_be_are_one_sentence_and_no_file(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sizes = [part for word in words for part in ("--size", word)]
    assert main(["export", "twente", "--format", "gds", *sizes]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert list(tmp_path.iterdir()) == []


def test_two_squares_are_apart_where_a_gap_lies_between_them():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    diamond = np.array([[2.2, 0.5], [1.6, 1.1], [1.0, 0.5], [1.6, -0.1]])
    assert not apart(square, diamond)
    assert apart(square, diamond + np.array([0.01, 0.0]))


def test_the_command_writes_one_file_beside_its_layers(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "crossed", "--format", "gds", "--no-plot", "--out", "chip.gds"]) == 0
    assert gdstk.read_gds("chip.gds").cells[0].name == "CHIP"
    assert "36 fingers, 6 busbars, 6 pads" in capsys.readouterr().out


def test_a_mask_says_which_grooves_and_electrodes_of_meshed_pieces_it_leaves_out(tmp_path, capsys):
    block = {"file": str(files("studies") / "scenes/meshes/strip.msh"), "length_unit": "mm"}
    strips = Scene.load("reflector").replace(
        piece=[block | {"position": ["26 mm", "29 mm"], "materials": {"strip": "aluminium"}}]
    )
    said = "the mask leaves out grooves and strips (26.35 to 26.65 mm, 29.35 to 29.65 mm) and electrodes (2) of meshed"
    assert mask(strips).left_out.startswith(said)
    assert drawn("twente").left_out == ""
    assert main(["export", "reflector", "--format", "dxf", "--no-plot", "--out", str(tmp_path / "mask")]) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "leaves out grooves and strips (26.35 to 26.6 mm, 27.85 to 28.1 mm, 29.35 to 29.6 mm, ...) of" in said


def test_fingers_below_layers_have_openings_inside_their_pads():
    """For the second mask of coated-128yx; without layers above, none."""
    buried, bare = mask(Scene.load("coated-128yx")), mask(Scene.load("lithium-niobate-128yx"))
    assert not any(each.layer == "openings" for each in bare.polygons)
    pads, openings = ([each for each in buried.polygons if each.layer == layer] for layer in ("pads", "openings"))
    assert [each.comb for each in openings] == [each.comb for each in pads] == ["+", "-"]
    for pad, opening in zip(pads, openings, strict=True):
        low, high = pad.corners.min(axis=0), pad.corners.max(axis=0)
        assert np.all(opening.corners > low + 0.04 * (high - low))
        assert np.all(opening.corners < high - 0.04 * (high - low))
        assert np.ptp(opening.corners[:, 0]) == pytest.approx(0.9 * np.ptp(pad.corners[:, 0]), abs=2e-8)
