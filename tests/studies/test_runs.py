"""A run: symmetries and limits of the physics, the record against what the scene asked for, the rule for stators."""

import gc
import weakref
from dataclasses import replace
from functools import partial

import pytest

import contact
from studies import Scene, Wave, runs
from studies.__main__ import main
from studies.model.balls import prescribed_orbits
from studies.model.model import Model
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.text import answer
from studies.refusal import RunError
from studies.results.content import plain
from studies.runs import run
from studies.scene import read_table
from studies.solve import stators
from studies.solve.point_answer import PointAnswer
from studies.solve.predictor import Predictor
from studies.solve.refinement import finer, refined
from studies.solve.ring_up import RingUp
from studies.solve.solved_stator import SolvedStator, contact_of_run
from tests.studies.settings import changed


@pytest.fixture(scope="module")
def given():
    return run(Scene.load("twente-contact"), tolerance=1e-3)


def test_a_contact_scene_rises_through_stick_slip_and_intermittent_contact(given):
    regimes = [point["regime"] for point in given.points]
    assert regimes == sorted(regimes, key=["stick", "slip", "intermittent"].index)
    assert set(regimes) == {"stick", "slip", "intermittent"}
    speeds = [point["velocity_m_per_s"] for point in given.points]
    assert speeds == sorted(speeds)
    assert speeds[0] == 0.0
    assert given.shortfall == ""


def test_threshold_and_release_lie_between_the_points_of_their_regimes(given):
    last = {point["regime"]: point["normal_amplitude_m"] for point in given.points}
    first = {point["regime"]: point["normal_amplitude_m"] for point in reversed(given.points)}
    summary = given.summary
    assert last["stick"] < summary["threshold_amplitude_m"] < first["slip"]
    assert last["slip"] < summary["release_amplitude_m"] < first["intermittent"]
    assert summary["release_amplitude_m"] == pytest.approx(4.17258e-9, rel=2e-5)  # design.md, by averaging


def test_the_error_is_that_of_the_worst_point_and_the_sum_of_its_parts(given):
    assert given.error["relative"] == max(point["relative_error"] for point in given.points)
    assert given.error["relative"] == sum(given.error["parts"].values())


def test_the_stators_of_a_run_are_freed_with_it():
    """No cycle of references keeps them until the next search for garbage: gigabytes in a loop over many scenes."""
    gc.disable()
    try:
        predictor = Predictor(read_table("twente-contact"), tolerance=0.1)
        predictor.contact({"slider.friction_coefficient": 0.1})
        kept = weakref.ref(predictor)
        del predictor
        assert kept() is None
    finally:
        gc.enable()


def test_no_drive_gives_no_velocity_and_no_error():
    record = run(changed("twente-contact", "wave.normal_amplitude=0"), tolerance=1e-3)
    (point,) = record.points
    assert (point["velocity_m_per_s"], point["relative_error"], point["status"]) == (0.0, 0.0, "ok")


def test_contacts_in_phase_move_as_one():
    one = run(changed("twente-contact", "wave.normal_amplitude=3 nm"), tolerance=1e-6)
    settings = ["slider.mass=0.267 g", "slider.damping.normal=1.5", "slider.damping.tangential=3e-4"]
    three = changed("twente-contact", "wave.normal_amplitude=3 nm", "slider.contacts=3", *settings)
    record = run(three, tolerance=1e-6)
    assert record.points[0]["velocity_m_per_s"] == pytest.approx(one.points[0]["velocity_m_per_s"], rel=1e-10)
    assert any("2 of 3 contacts" in reason for reason in record.left_out)


def test_a_burst_leaves_its_end_velocity_and_its_trajectory():
    record = run(changed("twente-contact", "wave.normal_amplitude=5 nm", "wave.burst=0.2 ms"), tolerance=1e-3)
    ((level, motion),) = record.trajectories
    (point,) = record.points
    assert level == 5e-9
    assert point["velocity_at_burst_end_m_per_s"] == motion.velocity_at_burst_end
    assert 0 < motion.velocity_at_burst_end < point["velocity_m_per_s"]
    driven = contact_of_run(record)
    step = contact.step(driven.slider, driven.at(5e-9), cycles=motion.cycles)
    assert point["displacement_m"] == pytest.approx(step.displacement, abs=1.1 * step.ring)
    assert step.ring < 0.1 * point["displacement_m"]
    assert motion.velocity[0] == 0.0
    assert motion.time[-1] > 0.2e-3


def test_the_resolved_scene_runs_again_to_the_same_numbers(given):
    again = run(given.scene, tolerance=1e-3)
    assert again.scene == given.scene
    assert again.points == given.points
    assert again.summary == given.summary


def test_a_point_that_has_no_answer_says_why_and_holds_no_number():
    settings = ["slider.load=1 N", "slider.damping.tangential=0", "wave.normal_amplitude=3 nm"]
    record = run(changed("twente-contact", *settings), tolerance=1e-3)
    (point,) = record.points
    assert "velocity_m_per_s" not in point
    assert "runaway" in point["status"]
    assert "1 of 1 points have no answer" in record.shortfall


def test_a_given_wave_drives_towards_plus_x():
    wave = Wave(frequency="1 MHz", normal_amplitude="1 nm", tangential_ratio=0.7)
    (orbit,) = prescribed_orbits(wave)
    assert orbit.scaled(1e-9).crest_velocity > 0


@pytest.fixture(scope="module")
def chip():
    """A small motor: 12 wavelengths, so that the stator costs little."""
    settings = [
        "stator.length=24 mm",
        "stator.thickness=2 mm",
        "transducer.0.center=5 mm",
        "transducer.1.center=19 mm",
        "transducer.0.finger_pairs=3",
        "transducer.1.finger_pairs=3",
        "transducer.0.period=0.98 mm",
        "transducer.1.period=0.98 mm",
        "stator.diffraction=false",
        "slider.position=12 mm",
        "drive.voltage=[0, 60, 120, 180]",
    ]
    return changed("twente", *settings)


@pytest.fixture(scope="module")
def driven(chip):
    return run(chip, tolerance=1e-3)


def test_the_slider_runs_towards_the_driven_transducer(driven):
    still, *moving = [point["velocity_m_per_s"] for point in driven.points]
    assert still == 0.0
    assert driven.points[0]["relative_error"] == 0.0
    assert all(speed < 0 for speed in moving)


def test_driven_from_the_other_side_it_runs_the_other_way(chip, driven):
    mirrored = run(replace(chip, drive=replace(chip.drive, transducer="right")), tolerance=1e-3)
    for one, other in zip(driven.points[1:], mirrored.points[1:], strict=True):
        assert one["velocity_m_per_s"] == pytest.approx(-other["velocity_m_per_s"], rel=1e-9)


def test_amplitudes_are_volts_times_metres_per_volt(driven):
    for point in driven.points:
        size = abs(driven.wave["normal_m_per_V"]) * point["voltage_V"]
        assert point["normal_amplitude_m"] == pytest.approx(size, rel=1e-14)
    summary = driven.summary
    ratio = summary["threshold_amplitude_m"] / summary["threshold_voltage_V"]
    assert ratio == pytest.approx(abs(driven.wave["normal_m_per_V"]), rel=1e-12)


def test_the_error_holds_against_a_sharper_run(chip, driven):
    rough = run(chip, tolerance=3e-2)
    assert 1e-4 < rough.error["relative"] <= 3e-2
    assert driven.error["relative"] <= 1e-3
    for coarse, fine in zip(rough.points[1:], driven.points[1:], strict=True):
        true = abs(coarse["velocity_m_per_s"] / fine["velocity_m_per_s"] - 1)
        assert true <= 2 * coarse["relative_error"]


def test_a_stator_that_is_too_rough_for_the_slider_is_solved_again(chip, monkeypatch):
    monkeypatch.setattr(stators, "SHARE", 30.0)
    solved, goals = stators.solved_motion, []

    def noted(scene, places, *, tolerance, **given):
        goals.append(tolerance)
        return solved(scene, places, tolerance=tolerance, **given)

    monkeypatch.setattr(stators, "solved_motion", noted)
    record = run(chip, tolerance=1e-3)
    assert len(goals) == 2
    assert goals[1] < 1e-3 < goals[0]
    assert record.error["relative"] <= 1e-3
    monkeypatch.setattr(runs, "refined", partial(refined, rounds=1))
    rough = run(chip, tolerance=1e-3)
    assert rough.error["relative"] > 1e-3
    assert "1.0e-03 was asked for" in rough.shortfall


def test_without_a_slider_the_amplitude_is_the_result(chip):
    record = run(replace(chip, slider=None), tolerance=1e-2)
    assert all("velocity_m_per_s" not in point for point in record.points)
    assert record.error["relative"] <= 1e-2
    assert record.to_dict().keys().isdisjoint({"summary"})


def test_the_free_wave_is_the_half_space_s():
    import fem

    record = run(Scene.load("rayleigh"), tolerance=1e-6)
    expected = fem.rayleigh(fem.material("PZT-8"), "open")
    assert record.wave["phase_velocity_m_per_s"] == pytest.approx(expected.velocity, rel=1e-6)
    assert record.wave["surface_ratio"] == pytest.approx(expected.surface_ratio, rel=1e-4)
    assert not record.points


@pytest.mark.parametrize("value", [float("nan"), float("inf"), complex(1, float("nan"))])
def test_what_is_not_finite_never_leaves(value):
    with pytest.raises(RunError, match=r"points\.0\.velocity_m_per_s"):
        plain("points", [{"velocity_m_per_s": value}])


def on_a_stator(section, whole, ringing=0.0):
    """Return a contact whose stator has these errors: of its section, of the motion, of the ring-up."""
    solved = SolvedStator(at={}, section_error=section, goal=1.0, frequency=1e6, admittance=0j, power=0.0, currents={})
    model = Model(Scene.load("twente-contact"))
    return Contact(
        model=model, orbits=(), amplitudes=(1.0, 1.0), stator_error=whole, solved=solved, ringing=RingUp(error=ringing)
    )


def test_a_finer_stator_is_asked_for_only_where_it_helps():
    def goal(*parts, section=1e-4, whole=1e-4, ringing=0.0, before=None):
        answers = [PointAnswer(point=Point(), from_stator=each[0], from_contact=each[1]) for each in parts]
        return finer(answers, on_a_stator(section, whole, ringing), 1e-3, before)

    def below(needed):
        """Return the largest of 1/4, 1/8, ... of the tolerance that is not above what the velocity needs."""
        return max(0.25e-3 / 2**k for k in range(20) if 0.25e-3 / 2**k <= needed)

    assert goal((2e-3, 1e-6), (5e-4, 0.0)) == pytest.approx(below(1e-4 * 0.5e-3 / 2e-3), rel=1e-12, abs=0)
    assert goal((9e-4, 0.0)) is None
    assert goal((5.2e-3, 0.0), ringing=5e-3) is None  # the ringing alone is too much
    assert goal((1.9e-3, 0.0), ringing=1e-4) == pytest.approx(below(1e-4 * 0.4e-3 / 1.8e-3), rel=1e-12, abs=0)
    assert goal((3e-4, 9e-4)) is None  # the contact limits
    # half of the error is the beam's, of which 8e-4 is left to the velocity
    half = goal((1.6e-3, 0.0), section=1e-4, whole=2e-4)
    assert half == pytest.approx(below(1e-4 * 0.5 * (1e-3 - 8e-4) / 8e-4), rel=1e-12, abs=0)
    assert goal((7e-3, 0.0), section=1e-4, whole=2e-4) is None  # the beam alone takes the tolerance
    # a round that did not help is the last
    assert goal((2e-3, 0.0), before=on_a_stator(1e-4, 2e-4)) is None
    assert goal((2e-3, 0.0), section=0.9e-4, whole=1e-4, before=on_a_stator(1e-4, 1.1e-4)) is None
    assert goal((2e-3, 0.0), section=0.5e-4, whole=0.5e-4, before=on_a_stator(1e-4, 1e-4)) is not None


def test_a_stator_too_thick_to_solve_is_no_defect_of_the_program(capsys):
    """Found while the automatic period is: the sentence names the key."""
    auto = ("lithium-niobate-128yx", "--set", "transducer.0.period=auto", "--set", "stator.thickness=1 m")
    assert main(["run", *auto, "--no-plot"]) == 3
    assert capsys.readouterr().err.splitlines()[-1].startswith("sawmotor: stator.thickness, 1 m, is ")


def test_a_load_above_friction_has_no_threshold():
    sliding = Scene.load("twente-contact").replace(slider={"load": 0.9}, wave={"normal_amplitude": ["10 nm"]})
    assert "threshold       none: the load exceeds friction" in answer(run(sliding, tolerance=1e-2))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
@pytest.mark.parametrize("burst", [None, 1e-4])
def test_a_run_is_its_prediction_at_one_point_to_the_last_bit(chip, burst, tolerance):
    """Near the threshold too, where the stator is solved again; with the prescribed wave and with a burst."""
    scenes = [
        Scene.load("twente-contact").replace(wave={"normal_amplitude": "3 nm", "burst": burst}),
        *(chip.replace(drive={"voltage": volts, "burst": burst}) for volts in (20.0, 60.0)),
    ]
    for scene in scenes:
        (point,) = run(scene, tolerance=tolerance).points
        (predicted,) = Predictor(scene.to_table(), tolerance=tolerance).answers([{}])
        shared = point.keys() & predicted.point.keys()
        assert {"velocity_m_per_s", "relative_error", "regime", "normal_amplitude_m", "status"} <= shared
        assert {key: point[key] for key in shared} == {key: predicted.point[key] for key in shared}
