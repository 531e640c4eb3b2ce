"""A slider that moves through the field of a stator: its orbits there, how far it comes and where its way ends.

The motion along a track is tested in tests/contact/test_track.py.
"""

from pathlib import Path

import numpy as np
import pytest

import contact
from studies import run
from studies.inverse.prediction import MeasurementPredictor
from studies.lab.measurement import Measurement
from studies.model import resolve
from studies.model.free_way import free_way
from studies.model.model import Model
from studies.record.text import answer
from studies.scene import Scene
from studies.solve.solved_stator import contact_of_run
from studies.solve.travel import WaveAlong
from tests.studies.settings import assigned

SCENES = Path(__file__).parent / "scenes"


def test_a_run_says_how_far_it_went(small):
    scene = small.replace(drive={"burst": "1 ms", "voltage": "120 V"}, slider={"travel": True})
    moved, still = (run(each, tolerance=0.05) for each in (scene, scene.replace(slider={"travel": False})))
    travel = moved.points[0]["travel_m"]
    _, trajectory = still.trajectories[0]
    on = trajectory.time <= trajectory.duration
    assert travel == pytest.approx(np.trapezoid(trajectory.velocity[on], trajectory.time[on]), rel=0.1)
    assert moved.points[0]["velocity_at_burst_end_m_per_s"] == pytest.approx(
        still.points[0]["velocity_at_burst_end_m_per_s"], rel=0.05
    )
    # a fit predicts the burst of the run, whatever factor its amplitude is the product of
    time = (3e-4, 6e-4, 1e-3)  # instants that a trajectory holds
    measured = Measurement(name="trace", quantity="burst", time=time)
    halved = scene.replace(drive={"voltage": "60 V"})
    for each, numbers in ((scene, {}), (halved, {"amplitude_factor": 2.0})):
        (predicted,) = MeasurementPredictor(each, tolerance=0.05).predict([(measured, numbers)])
        of_moved, of_still = (
            np.interp(time, path.time, path.velocity) for _, path in (moved.trajectories[0], still.trajectories[0])
        )
        assert abs(predicted - of_moved).max() < 0.01 * abs(of_moved - of_still).max()
    assert "travel_m" not in still.points[0]
    assert any("slider.travel is false" in each for each in still.left_out)
    absent = run(small.replace(drive={"burst": "1 ms", "voltage": "120 V"}), tolerance=0.05)
    assert absent.points == still.points  # less than a tenth of a wavelength: bit-equal


# It reaches the fingers, 0.35 mm away, within 20 ms. The mirror image has the other end's drive.
FAST = (
    "drive.burst=30 ms",
    "drive.voltage=120 V",
    "slider.mass=40 mg",
    "slider.preload=3 mN",
    "slider.position=5.7 mm",
)
MIRRORED = (*FAST, "transducer.0.center=10 mm", "slider.position=8.3 mm")


def test_a_burst_stops_at_the_fingers_and_says_so(small):
    stopped = {}
    for name, settings in (("left", FAST), ("right", MIRRORED)):
        found = run(Scene.from_table("", assigned(small.to_table(), *settings)), tolerance=0.05)
        (point,), ((_, path),) = found.points, found.trajectories
        stopped[name] = point
        assert point["way_ends_after_s"] < 30e-3
        assert path.time[-1] == point["way_ends_after_s"]
        way = free_way(Model(found.scene))
        assert way.low <= path.displacement.min() <= path.displacement.max() <= way.high
        reached = way.low if point["travel_m"] < 0 else way.high
        assert point["travel_m"] == pytest.approx(reached, rel=1e-3)
        (sentence,) = (each for each in found.warnings if "the end of its way" in each)
        assert "the contact reaches the fingers of transducer left" in sentence
        assert "drive.burst" in sentence
    stated = stopped["left"]["relative_error"]
    for key, error in (("travel_m", 1e-4), ("velocity_at_burst_end_m_per_s", 2.0 * stated)):
        assert stopped["right"][key] == pytest.approx(-stopped["left"][key], rel=error)
    fixed = assigned(small.to_table(), *FAST, "slider.travel=false")
    crossing = run(Scene.from_table("", fixed), tolerance=0.05)
    (sentence,) = (each for each in crossing.warnings if "although" in each)
    assert "reaches the fingers of transducer left" in sentence


MIDDLE, UPPER, LOWER = ["0 mm", "0 mm"], ["0 mm", "1 mm"], ["0 mm", "-1 mm"]  # the wave is symmetric in y
HEIGHTS = {
    "middle highest": ([MIDDLE, UPPER, LOWER], ["0 nm", "-2 nm", "-2.3 nm"], (1, 3)),
    "in another order": ([LOWER, MIDDLE, UPPER], ["-2.3 nm", "0 nm", "-2 nm"], (2, 1)),
    "mirrored": ([UPPER, MIDDLE, LOWER], ["-2.3 nm", "0 nm", "-2 nm"], (2, 1)),
}


@pytest.mark.parametrize("name", HEIGHTS)
def test_contacts_that_leave_one_after_another_are_named(small, name):
    contacts, heights, (last, first) = HEIGHTS[name]
    record = run(small.replace(slider={"contacts": contacts, "heights": heights}), tolerance=0.05)
    summary, driven = record.summary, contact_of_run(record)
    factors = [each.value for each in contact.releases(driven.slider, driven.orbits)]
    assert (summary["first_released_contact"], summary["last_released_contact"]) == (first, last)
    assert summary["release_voltage_V"] == pytest.approx(min(factors), rel=1e-9)
    assert summary["last_release_voltage_V"] == pytest.approx(max(factors), rel=1e-9)
    text = " ".join(answer(record).split())
    assert f"contact {first}, the first of 3, leaves the surface in every cycle; contact {last} is the last" in text
    level = f"{summary['last_release_voltage_V']:.4g} V"
    assert f"is the last, from {level}" in text


def test_a_slider_with_memory_travels_event_by_event(small):
    scene = small.replace(drive={"burst": "0.3 ms", "voltage": "120 V"}, slider={"travel": True, "law": "hysteretic"})
    moved, still = (run(each, tolerance=0.05) for each in (scene, scene.replace(slider={"travel": False})))
    assert moved.points[0]["burst_method"] == "exact"
    (v, e), (w, _) = (
        (each.points[0]["velocity_at_burst_end_m_per_s"], each.points[0]["relative_error"]) for each in (moved, still)
    )
    assert v == pytest.approx(w, rel=0.02)  # in so short a burst the slider hardly moves
    assert 0.0 < e < 0.05


def test_the_way_ends_at_fingers_pieces_and_ends(small):
    scene = resolve.resolved(Scene.load("twente"))
    left, right = scene.transducer
    way = free_way(Model(scene))
    balls = [x for x, _ in scene.slider.contact_positions]
    fingers = [each.center_xy[0] for each in (left, right)]
    assert fingers[0] < min(balls) + way.low < max(balls) + way.high < fingers[1]
    assert way.at_low.endswith("mm")
    assert "reaches the fingers of transducer left" in way.at_low
    assert "reaches the fingers of transducer right" in way.at_high
    clear = free_way(Model(scene), clear=1e-3)
    assert (clear.low, clear.high) == pytest.approx((way.low + 1e-3, way.high - 1e-3), abs=1e-15)
    groove = free_way(resolve.build(Scene.load("reflector")))
    assert groove.at_high == "the contact reaches the piece groove, at x = 26 mm"
    rotated = free_way(resolve.build(Scene.load(SCENES / "crossing.toml")))
    assert (rotated.low, rotated.high) == pytest.approx((-4.125e-3, 5e-3))
    pillars = free_way(resolve.build(Scene.load(SCENES / "driven-pillars.toml")))
    assert pillars.at_low == "a pillar reaches the fingers of transducer left, at x = 6.95 mm"
    alone = free_way(resolve.build(small))
    assert "reaches the stator's end" in alone.at_high
    assert alone.high == pytest.approx(5e-3)


def test_the_orbits_along_the_way_are_those_of_the_surface(small):
    record = run(small, tolerance=0.05)
    driven, motion = contact_of_run(record), record.surface_motion
    along = WaveAlong.under(Model(record.scene), motion)
    places = np.array([-1.1e-3, 0.0, 0.7e-3])
    for (x, y), number in zip(record.scene.slider.contact_positions, range(9), strict=False):
        u_x, _, u_z = motion.along(x + places, y)
        found = along.orbits(places)
        size = abs(u_z).max()
        assert [each[number].normal for each in found] == pytest.approx(u_z, abs=1e-4 * size)
        assert [each[number].tangential for each in found] == pytest.approx(u_x, abs=1e-4 * size)
    assert along.scaled(2.0).orbits([0.0])[0][0].normal == pytest.approx(2.0 * driven.orbits[0].normal, rel=1e-4)
