"""Tolerances in a scene: Hertz's release amplitude as the closed form of both bands, the level's, and refusals."""

import csv
import json

import numpy as np
import pytest

from studies import Record, Scene, run
from studies.__main__ import main
from studies.chain.uncertainty import sampled, without_level
from studies.record import run_pictures
from studies.record.plots import new_figure
from studies.record.text import answer
from studies.scene.toml import document
from studies.scene.uncertain import Tolerance

PRELOAD, MODULUS = 8e-4, 64e9


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
    assert (scene.slider.preload, scene.slider.mass, scene.slider.friction_coefficient) == (8e-4, 8.9e-5, 0.08)
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
