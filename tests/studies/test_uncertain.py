"""Tolerances in a scene: Hertz's release amplitude as the closed form of both bands, the level's, and refusals."""

import csv
import json

import numpy as np
import pytest

import fem
from studies import Record, Scene, run
from studies.__main__ import main
from studies.inverse.prediction import MeasurementPredictor
from studies.model.contact_moduli import pair_moduli
from studies.record import run_pictures
from studies.record.plots import new_figure
from studies.record.text import answer
from studies.scene.toml import document
from studies.scene.uncertain import Tolerance
from studies.solve import stators
from studies.solve.uncertainty import sampled, without_level
from tests.seed_motor import GRAVITY, MASS, SCENE_SLIDER

PRELOAD, MODULUS = 8e-4, 64e9
SMALL = {
    "stator": {"material": "PZT-8", "length": 12e-3, "thickness": 0.7e-3, "width": 0.025, "ends": "absorbing",
               "diffraction": False},
    "transducer": [
        {"name": "left", "center": 3e-3, "finger_pairs": 2, "period": 0.98e-3, "metallisation": 0.5, "aperture": 0.02}
    ],
    "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [30.0]},
    "slider": SCENE_SLIDER | {"position": 7e-3},
}  # fmt: skip


def motor(levels=("5 nm",), **uncertain):
    """Return the seed's slider at some amplitudes, with tolerances."""
    return Scene.load("twente-contact").replace(
        slider={"preload": PRELOAD, "effective_modulus": MODULUS}, wave={"normal_amplitude": list(levels)},
        uncertain=uncertain,
    )  # fmt: skip


def test_linear_bands_of_the_release_are_hertz_s_in_quadrature():
    """The release amplitude goes as (preload / E*)^(2/3)."""
    record = run(motor(slider={"preload": "+- 10 %", "effective_modulus": "+- 4 GPa"}))
    release, shares = record.summary["release_amplitude_m"], ((0.1, 1), (4e9 / MODULUS, -1))
    halves = [((1 + t) ** (2 * s / 3) - (1 - t) ** (2 * s / 3)) / 2 for t, s in shares]
    low, high = record.uncertainty["release_amplitude_m"]
    assert (high - release, release - low) == pytest.approx((release * np.hypot(*halves),) * 2, rel=2e-6)
    assert record.uncertainty["tolerances"] == pytest.approx(
        {"slider.preload": 0.1 * PRELOAD, "slider.effective_modulus": 4e9}
    )


def test_sampled_bands_of_a_monotonic_answer_are_its_values_at_the_tolerances_ends():
    """95 % of the preload lie within its tolerance, and so 95 % of the release amplitude between its ends."""
    record = run(motor(slider={"preload": "+- 30 %"}, method="sampled", samples=100))
    expected = record.summary["release_amplitude_m"] * np.array([0.7, 1.3]) ** (2 / 3)
    assert record.uncertainty["release_amplitude_m"] == pytest.approx(expected, rel=2e-2)
    assert record.uncertainty["samples"] == 100


@pytest.mark.slow
def test_both_methods_agree_for_small_tolerances():
    tolerances = {"slider": {"preload": "0.5 %", "friction_coefficient": 0.001, "radius": "+- 2 um"}}
    linear = run(motor(("6 nm", "15 nm"), **tolerances))
    sampled = run(motor(("6 nm", "15 nm"), **tolerances, method="sampled", samples=1000))
    for one, other in zip(linear.points, sampled.points, strict=True):
        for key in ("velocity_low_m_per_s", "velocity_high_m_per_s"):
            half = one[key] - one["velocity_m_per_s"]
            assert other[key] - other["velocity_m_per_s"] == pytest.approx(half, rel=0.08)


def test_a_tolerance_of_the_level_moves_along_the_curve():
    """With 5 % on the amplitude alone the band is half the difference of the velocities 5 % above and below."""
    record = run(motor(("5.7 nm", "6 nm", "6.3 nm"), wave={"normal_amplitude": "5 %"}))
    below, point, above = record.velocity[0], record.points[1], record.velocity[2]
    assert point["velocity_high_m_per_s"] - point["velocity_m_per_s"] == pytest.approx((above - below) / 2, rel=1e-6)


def test_where_the_answer_bends_the_band_holds_the_middle_and_both_ends(capsys):
    """Across the threshold one end rests: half the difference to either side would reverse the slider."""
    bare = Scene.load("twente-contact").replace(slider={"preload": PRELOAD, "effective_modulus": MODULUS})
    threshold = run(bare).summary["threshold_amplitude_m"]
    levels = [0.98 * threshold, 1.02 * threshold, 6e-9]
    tolerance = 0.05
    given = {"wave": {"normal_amplitude": f"+- {100 * tolerance:g} %"}}
    free = run(motor(levels, **given, samples=8))  # where the scene leaves the method open
    assert free.uncertainty["method"] == "sampled"
    record = run(motor(levels, **given, method="linear"))
    near = [factor * level for level in levels for factor in (1 - tolerance, 1 + tolerance)]
    ends = run(bare.replace(wave={"normal_amplitude": near})).velocity.reshape(3, 2)
    for (low, high), point in zip(ends[:2], record.points, strict=False):
        assert point["velocity_low_m_per_s"] == pytest.approx(low, abs=1e-9)
        assert point["velocity_high_m_per_s"] == pytest.approx(high, rel=1e-3)
    assert record.uncertainty["bent"] == {"wave.normal_amplitude": 2}
    assert "the answer is nonlinear within the tolerance of wave.normal_amplitude at 2 points" in answer(record)
    half = (ends[2, 1] - ends[2, 0]) / 2  # and where it does not, the band is half the difference
    assert record.points[2]["velocity_high_m_per_s"] - record.velocity[2] == pytest.approx(half, rel=1e-3)


def test_a_value_with_its_tolerance_is_an_entry_of_the_block():
    """The tolerance takes the value's unit and the value the tolerance's."""
    text = {"preload": "0.8 +- 0.02 mN", "mass": "89 mg ± 2", "friction_coefficient": "0.08 +/- 0.02", "load": "0 N"}
    scene = Scene.load("twente-contact").replace(slider=text)
    assert (scene.slider.preload, scene.slider.mass, scene.slider.friction_coefficient) == (8e-4, MASS, 0.08)
    assert dict(scene.uncertain) == {
        "slider.preload": "+- 0.02 mN", "slider.mass": "+- 2 mg", "slider.friction_coefficient": "+- 0.02"
    }  # fmt: skip
    assert Scene.from_table("", scene.to_table()) == scene


def test_a_run_shows_its_bands_everywhere(tmp_path, capsys):
    file = tmp_path / "motor.toml"
    text = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["4 nm", "8 nm"]}).to_table()
    text["slider"]["friction_coefficient"] = "0.08 +- 0.01"
    file.write_text(document(text))
    assert main(["run", str(file), "--no-plot", "--out", str(tmp_path / "out")]) == 0
    assert "bands of 95 %: linear" in capsys.readouterr().out
    whole = json.loads((tmp_path / "out" / "run.json").read_text())
    rows = list(csv.DictReader((tmp_path / "out" / "velocity.csv").read_text().splitlines()))
    for point, row in zip(whole["points"], rows, strict=True):
        assert point["velocity_low_m_per_s"] < point["velocity_m_per_s"] < point["velocity_high_m_per_s"]
        assert float(row["velocity_high_m_per_s"]) == point["velocity_high_m_per_s"]
    record = Record.load(tmp_path / "out")
    assert record.uncertainty == whole["uncertainty"]
    again = run(tmp_path / "out" / "scene.toml")
    assert again.uncertainty == record.uncertainty
    assert "+- 0.01" in answer(again)
    ax = new_figure(6.0, 4.0)[1]
    run_pictures.velocity(record, ax)
    assert "95 % of the tolerances (linear)" in ax.get_legend_handles_labels()[1]


@pytest.mark.parametrize("words", [["sweep", "--over", "slider.preload=1 mN,2 mN"], ["study", "regime_map", "--quick"]])
def test_what_draws_no_bands_says_so(words, tmp_path, capsys):
    scene = tmp_path / "motor.toml"
    scene.write_text(document(motor(slider={"preload": "+- 5 %"}).to_table()))
    place = 2 if words[0] == "study" else 1
    assert main([*words[:place], str(scene), *words[place:], "--out", str(tmp_path / "out")]) == 0
    assert "[uncertain] is not used here" in capsys.readouterr().err


def test_samples_keep_their_sign_and_a_power_is_the_square_of_the_level():
    wide = Tolerance("slider.mass", 1e-4, 1.5e-4), Tolerance("drive.power", 1.0, 0.1)
    samples = sampled(wide, 200)
    assert min(each["slider.mass"] for each in samples) > 0.0
    assert np.std([each["drive.power"] for each in samples]) == pytest.approx(0.1 / 1.96, rel=0.02)
    assert without_level({"drive.power": 1.21, "slider.mass": 2e-4}) == (pytest.approx(1.1), {"slider.mass": 2e-4})
    assert without_level({"drive.voltage": 1.21}) == (1.21, {})


@pytest.mark.parametrize(("key", "value"), [("mass", MASS), ("gravity", 9.81)])
def test_a_weight_follows_its_mass_and_its_gravity(key, value):
    """The band is that of the program's own runs: +-0.73 mm/s; a frozen weight left +-1.3e-5 mm/s of the mass."""
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["5 nm"]})
    record = run(scene.replace(uncertain={"slider": {key: "+- 10 %"}}))
    low, high = sorted(float(run(scene.replace(slider={key: factor * value})).velocity[0]) for factor in (0.9, 1.1))
    point = record.points[0]
    band = point["velocity_low_m_per_s"], point["velocity_high_m_per_s"]
    assert high - low > 1e-3
    assert band[1] - band[0] == pytest.approx(high - low, rel=1e-6)
    assert np.mean(band) == pytest.approx(record.velocity[0], rel=1e-12)
    assert record.scene.slider.preload == "weight"
    assert run(record.scene).uncertainty == record.uncertainty


def test_a_tolerance_of_the_weight_adds_to_that_of_the_mass():
    """The release goes as weight^(2/3): 95 % of the samples of both together, as of independent numbers."""
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["5 nm"]})
    record = run(scene.replace(uncertain={"slider": {"mass": "8 %", "preload": "6 %"}, "method": "sampled",
                                          "samples": 60}))  # fmt: skip
    low, high = np.array(record.uncertainty["release_amplitude_m"]) / record.summary["release_amplitude_m"]
    assert (low, high) == pytest.approx((0.9 ** (2 / 3), 1.1 ** (2 / 3)), rel=0.02)


@pytest.mark.parametrize("method", ["linear", "sampled"])
def test_an_uncertain_position_is_evaluated_on_one_solution_of_the_stator(monkeypatch, method):
    """Velocities are those of whole runs at the ends; a sample took a stator of its own."""
    small = Scene.from_table("", SMALL)
    solved, solve = [], stators.solved_motion

    def counted(scene, positions, **options):
        solved.append(len(positions))
        return solve(scene, positions, **options)

    monkeypatch.setattr(stators, "solved_motion", counted)
    uncertain = {"slider": {"position": "+- 0.1 mm"}, "method": method, "samples": 40}
    record = run(small.replace(uncertain=uncertain), tolerance=1e-2)
    assert solved[0] == 1
    assert solved[1:] == [5 if method == "linear" else 45]
    if method == "linear":
        ends = [run(small.replace(slider={"position": x}), tolerance=1e-2).velocity[0] for x in (6.9e-3, 7.1e-3)]
        half = record.uncertainty["velocity_half_width_m_per_s"]["slider.position"]
        assert half == pytest.approx(abs(ends[1] - ends[0]) / 2, rel=2e-2)


@pytest.mark.parametrize("key", ["slider.mass", "slider.gravity"])
def test_a_fit_and_a_sensitivity_let_the_weight_follow_too(key):
    predictor = MeasurementPredictor(Scene.load("twente-contact"))
    (own,) = (predictor.value(each) or 9.81 for each in (key,))
    body = predictor.contact({key: 1.2 * own}).slider
    assert body.preload == pytest.approx(1.2 * MASS * GRAVITY, rel=1e-12)
    assert predictor.value("slider.preload") == pytest.approx(MASS * GRAVITY, rel=1e-12)
    assert predictor.contact({"slider.preload": 1e-3, key: 1.2 * own}).slider.preload == 1e-3


def test_moduli_follow_a_named_ball_until_one_of_them_is_changed():
    numbers = ("effective_modulus", "tangential_modulus")
    slider = {key: value for key, value in SMALL["slider"].items() if key not in numbers}
    predictor = MeasurementPredictor(Scene.from_table("", SMALL | {"slider": slider | {"ball": "steel"}}))
    moduli = [predictor.value(f"slider.{name}") for name in numbers]
    for changes, material in (({}, "PZT-8"), ({"stator.material": "PZT-4"}, "PZT-4")):
        slider = predictor.scenes.model(changes).scene.slider
        assert (slider.effective_modulus, slider.tangential_modulus) == pair_moduli("steel", fem.material(material))
    one = predictor.scenes.model({"slider.effective_modulus": 70e9}).scene.slider
    assert (one.ball, one.effective_modulus, one.tangential_modulus) == (None, 70e9, moduli[1])
