"""Scenes with turned transducers: crossing beams in a run, and what is refused."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fem
from studies import Scene, run
from studies.model import resolve
from studies.model.model import Model
from studies.model.resolve import build
from studies.record import Record
from studies.remarks.stator_effects import stator_effects
from studies.report.beam_map import draw_surface_map
from studies.solve.electrical import electrical_block
from studies.solve.plane_surface import further_motions
from studies.solve.surface_blocks import wave_block
from studies.solve.surface_motion import solved_motion
from studies.stator import beam
from tests.studies.conftest import SMALL

TOLERANCE = 5e-2


@pytest.fixture(scope="module")
def chip():
    """The small motor with a second transducer in front, which sends across."""
    return Scene.load(SMALL.with_name("crossing.toml"))


@pytest.fixture(scope="module")
def crossing(chip):
    """Both driven, the first a little turned; no slider."""
    drive = {"transducer": None, "sources": {"left": 1.0, "front": 0.2}}
    oblique = {"left": {"angle": "10 deg"}}
    return run(chip.replace(slider=None, drive=drive, transducer=oblique), tolerance=TOLERANCE)


def test_a_run_of_crossing_beams(crossing):
    scene, motion = crossing.scene, crossing.surface_motion
    assert scene.stator.diffraction is True
    assert [[each.name for each in row.transducers] for row in motion.beam.rows] == [["left"], ["front"]]
    place = (scene.stator.length / 2, 0.0)
    assert crossing.wave["normal_m_per_V"] == complex(motion.beam.motion(*place)[2])
    assert crossing.wave["section_normal_m_per_V"] == complex(motion.wave.motion(motion.in_section(place))[1])
    left = motion.beam.rows[0].transducers[0]
    along, ahead = np.radians(10.0), place[0] - 4e-3
    assert motion.in_section(place) - left.center == pytest.approx(ahead * np.cos(along))
    assert -left.center_y == pytest.approx(-ahead * np.sin(along))
    x, columns = crossing.surface["x_m"], crossing.surface
    assert (x[0], x[-1]) == (0.0, scene.stator.length)  # no section lies along x: the beams on y = 0
    np.testing.assert_array_equal(columns["u_z_m_per_V"], motion.along(x, 0.0)[2])
    assert set(crossing.electrical["sources"]) == {"left", "front"}
    assert any("metal of a transducer that it crosses" in each for each in crossing.left_out)
    effects = {each["effect"]: each["size"] for each in crossing.model_error}
    assert 0 < effects["metal of the transducers in the way of crossing beams"] < 0.5
    assert effects["side faces"] > 0
    assert Scene.from_table("", scene.to_table()) == scene


def test_side_faces_are_those_along_the_beams_of_every_frequency(chip):
    """Against each source alone: the face that "front" is aimed at, whose image is larger than the wave, is its end."""
    slider = {"freedom": "xy", "contacts": [["1 mm", 0], [0, "1 mm"]]}
    scene = chip.replace(
        slider=slider,
        drive={"transducer": None, "sources": {"left": 1, "front": 1}, "source_frequencies": {"front": "2.3 MHz"}},
    )
    model = build(scene)
    places = model.scene.contact_positions
    motion = solved_motion(model.alone, places, tolerance=TOLERANCE, slider=True, missed=True)
    further = tuple(further_motions(model, TOLERANCE))
    record = Record(
        scene=model.scene, tolerance=TOLERANCE, surface_motion=motion, further_motions=further,
        wave=wave_block(model.scene, motion, None), electrical=electrical_block(model.scene.drive, motion, further),
    )  # fmt: skip
    sizes = {effect: size for effect, _, size, *_ in stator_effects(record)}
    (x, y), width, length = np.transpose(places), scene.stator.width, scene.stator.length
    left, front = motion.beam.beams[0], further[0].beam.beams[0]
    assert further[0].beam.rows[0].angle == np.pi / 2
    along = sum(abs(left.motion(x, side * width - y)[2]) for side in (1.0, -1.0))
    across = [further[0].beam.rows[0].local(image, y) for image in (-x, 2 * length - x)]
    across = sum(abs(front.motion(*each)[2]) for each in across)
    direct = np.hypot(abs(left.motion(x, y)[2]), abs(front.motion(*further[0].beam.rows[0].local(x, y))[2]))
    assert sizes["side faces"] == pytest.approx((np.hypot(along, across) / direct).max(), rel=1e-12)
    assert sizes["side faces"] < 0.1
    behind, aside = further[0].beam.rows[0].local(x, -width - y)  # the image of "front" in the face behind it
    assert abs(front.motion(np.maximum(behind, 0.0), aside)[2]).max() > 0.3 * direct.max()
    assert sizes["metal of the transducers in the way of crossing beams"] > 0
    charge = [float(each.charge_error(x, y).max()) for each in (motion.beam, further[0].beam)]
    other = replace(record, surface_motion=further[0], further_motions=(motion,))  # with the smaller one as the first
    swapped = {effect: size for effect, _, size, *_ in stator_effects(other)}
    assert sizes["charge at the finger ends"] == swapped["charge at the finger ends"] == charge[0] > charge[1]
    stator = model.stator
    coated = [fem.film_shift(stator, fem.material("AlN"), 100e-9, each) for each in (2.2e6, 2.3e6)]
    assert sizes["coating of 100 nm AlN, if there is one"] == coated[1] > 1.04 * coated[0] > 0.0


def test_the_map_shows_turned_frames(crossing):
    from matplotlib.figure import Figure

    still = SimpleNamespace(wave=crossing.surface_wave, rows=(), motion=lambda x, y: np.zeros((3, len(x), len(y))))
    still.pictured = still
    ax = draw_surface_map(still, crossing.scene, Figure().add_subplot())
    left, front = (patch.get_path().vertices[:4] for patch in ax.patches)
    assert np.ptp(front[:, 0]) == pytest.approx(5.0)
    assert np.linalg.norm(left[1] - left[2]) == pytest.approx(6.0)
    assert front[:, 1].mean() == pytest.approx(-9.0)


def test_places_and_angles_that_change_nothing(small):
    """[x, 0] is x, and whole turns are none."""
    small = small.replace(transducer={"left": {"period": "1 mm"}})
    plain = small.transducer[0]
    same = small.replace(transducer={"left": {"center": ["4 mm", 0], "angle": "360 deg"}})
    assert same.transducer[0].center == plain.center
    assert not same.crossed
    assert replace(build(same).transducers[0], angle=0.0) == build(small).transducers[0]


def test_a_turned_transducer_within_45_deg_of_x_drives(chip):
    turned = resolve.resolved(chip.replace(drive={"transducer": "front"}, transducer={"front": {"angle": "40 deg"}}))
    alone, place = Model(turned).first_section(turned.slider.center)
    (front,) = alone.scene.transducer
    assert not alone.scene.crossed
    assert place - front.center_xy[0] == pytest.approx(9e-3 * np.sin(np.radians(40.0)))


@pytest.mark.slow
def test_the_study_of_a_beam_looks_at_the_row_whose_waves_run_nearest_to_x():
    """Two like rows cross at the slider of the shipped scene: each spreads as if it were alone."""
    record = beam.run("crossed", count=9)
    assert all(finding.confirmed for finding in record.findings)
    alone = {"transducer": "left", "sources": None, "voltage": [20.0]}
    single = beam.run(Scene.load("crossed").replace(drive=alone), count=9)
    ratio = [each.panel("across").data["beam_m_per_V"][4] / each.panel("across").data["section_m_per_V"][750]
             for each in (record, single)]  # fmt: skip
    assert ratio[0] == pytest.approx(ratio[1], rel=1e-2)
