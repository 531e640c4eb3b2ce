"""A measured curve beside the predicted one.  Oracle: numbers made by hand from a straight prediction."""

import json
import math
from pathlib import Path

import pytest

from studies.__main__ import main
from studies.lab.measurement_csv import read_measured
from studies.model.resolve import resolved
from studies.record import Record
from studies.record.run_pictures import velocity
from studies.record.text import comparison
from studies.record.velocity_comparison import compared, refuse_incomparable
from studies.refusal import SceneError
from studies.runs import run
from studies.scene import Scene

STRAIGHT = tuple(
    {"voltage_V": v, "velocity_m_per_s": -1e-3 * v, "regime": "slip", "tangential_amplitude_m": 1e-9}
    for v in (10.0, 20.0, 40.0)
)


@pytest.fixture
def measured(tmp_path):
    """Read a file of a text."""

    def measured(text: str):
        path = tmp_path / "lab.csv"
        path.write_text(text)
        return read_measured(path)

    return measured


@pytest.fixture(scope="module")
def record():
    """A motor that runs backwards at 1 mm/s per volt."""
    return Record(scene=resolved(Scene.load("twente")), tolerance=1e-3, points=STRAIGHT)


def test_deviations_are_those_worked_out_by_hand(record, measured):
    text = "voltage_V,velocity_mm_per_s,error_mm_per_s\n10,-11,2\n15,-15,0.5\n30,-27,1\n50,-60,1\n"
    block = compared(measured(text), [-0.01, -0.015, -0.03, None])
    *predicted, missing = [point.get("predicted_m_per_s") for point in block["points"]]
    assert predicted == pytest.approx([-0.01, -0.015, -0.03])
    assert missing is None
    gaps = [-1e-3, 0.0, 3e-3]
    assert block["compared"] == 3
    assert block["rms_deviation_m_per_s"] == pytest.approx(math.sqrt(sum(g**2 for g in gaps) / 3))
    assert block["mean_deviation_m_per_s"] == pytest.approx(2e-3 / 3)
    assert block["rms_deviation_relative"] == pytest.approx(block["rms_deviation_m_per_s"] / 0.03)
    assert block["measured_over_predicted"] == pytest.approx((110 + 225 + 810) / (100 + 225 + 900))
    assert block["within_one_error"] == 2
    assert block["chi_square_per_point"] == pytest.approx((0.25 + 0 + 9) / 3)
    said = "\n".join(line for _, line in comparison(block))
    assert "3 of 4 points of lab.csv" in said
    assert "1.83 mm/s rms" in said
    assert "2 of 3 within their error" in said


def test_speeds_without_a_sign_take_the_prediction_s(record, measured):
    block = compared(measured("voltage_V;velocity_m_per_s\n10;0.011\n20;0.02\n"), [-0.01, -0.02])
    assert block["sign_of_prediction_given"]
    assert block["points"][0]["velocity_m_per_s"] == -0.011
    assert block["rms_deviation_m_per_s"] == pytest.approx(1e-3 / math.sqrt(2))
    one_backwards = compared(measured("voltage_V\tvelocity_m_per_s\n10\t0.011\n20\t-0.02\n"), [-0.01, -0.02])
    assert not one_backwards["sign_of_prediction_given"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "a line of names"),
        ("voltage_V,velocity_m_per_s\n", "a line of names"),
        ("V,v\n1,2\n", "must have the columns voltage_V"),
        ("voltage_V,velocity_m_per_s\n10,fast\n", "line 2, velocity_m_per_s must be a finite number, got 'fast'"),
        ('voltage_V,velocity_m_per_s\n10,"1,250"\n', "write a decimal point and no thousands separator"),
        (
            "voltage_V,velocity_m_per_s\n10,0,0,01\n",
            "line 2, must have 2 values, got 4: decimal commas need semicolons",
        ),
        ("voltage_dBm,velocity_m_per_s\n10,0.1\n", "got voltage_dBm, velocity_m_per_s"),
        ("voltage_V,velocity_m_per_s\n10\n", "line 2, velocity_m_per_s"),
        ("voltage_V,velocity_m_per_s,error_m_per_s\n10,0.01,0\n", "line 2, error_m_per_s must be positive, got 0 m/s"),
    ],
)
def test_a_file_that_is_no_measurement_is_refused(measured, text, words):
    with pytest.raises(SceneError, match="--measured") as refusal:
        measured(text)
    assert words in str(refusal.value)


def test_what_cannot_be_compared_is_refused(record, measured):
    curve = measured("voltage_V,velocity_m_per_s\n50,0.01\n")
    with pytest.raises(SceneError, match="the motor has no velocity at its levels"):
        compared(curve, [None])
    with pytest.raises(SceneError, match="must have the column voltage_V for this scene"):
        refuse_incomparable(record.scene, measured("normal_amplitude_nm,velocity_m_per_s\n5,0.01\n"))
    with pytest.raises(SceneError, match=r"needs a scene with a \[slider\]"):
        refuse_incomparable(Scene.load("rayleigh"), curve)


def test_the_picture_shows_measured_points_with_their_errors(record, measured):
    from dataclasses import replace

    from matplotlib.figure import Figure

    text = "voltage_V,velocity_mm_per_s,error_mm_per_s\n10,-11,2\n30,-27,1\n"
    block = compared(measured(text), [-0.01, -0.032])
    ax = velocity(replace(record, measured=block), Figure().add_subplot())
    bars = ax.containers[0]
    assert bars.get_label() == "measured"
    assert bars[0].get_xydata().tolist() == [[10.0, -11.0], [30.0, -27.0]]
    (line,) = [each for each in ax.lines if each.get_label() == "predicted"]
    assert line.get_xydata().ravel() == pytest.approx([10, -10, 20, -20, 30, -32, 40, -40])
    ends = [segment[:, 1].tolist() for segment in bars[2][0].get_segments()]
    assert ends == [[-13.0, -9.0], [-28.0, -26.0]]


def test_a_run_is_compared_with_itself(tmp_path, capsys, monkeypatch):
    """Its own velocity.csv deviates by nothing; halved amplitudes of the file by what the curve says."""
    monkeypatch.chdir(tmp_path)
    words = ["run", "twente-contact", "--set", "wave.normal_amplitude=[4e-9, 8e-9]", "--no-plot"]
    assert main([*words, "--out", "first"]) == 0
    assert main([*words, "--out", "second", "--measured", "first/velocity.csv"]) == 0
    assert "deviation 0 mm/s rms" in capsys.readouterr().out
    block = json.loads((tmp_path / "second" / "run.json").read_text())["measured"]
    assert block["compared"] == 2
    assert block["rms_deviation_m_per_s"] == 0.0
    assert block["measured_over_predicted"] == 1.0
    assert main([*words, "--out", "third", "--measured", "nowhere.csv"]) == 2
    assert not (tmp_path / "third").exists()


def test_the_prediction_is_computed_at_the_measured_levels_and_not_across_the_threshold(tmp_path, monkeypatch):
    """Below the threshold the slider rests, although it moves at the next level of the run."""
    monkeypatch.chdir(tmp_path)
    threshold = run("twente-contact", tolerance=1e-2).summary["threshold_amplitude_m"]
    levels = [0.5 * threshold, 0.97 * threshold, 1.5 * threshold, 4 * threshold]
    rows = "".join(f"{level!r},0.01\n" for level in levels)
    Path("lab.csv").write_text(f"normal_amplitude_m,velocity_m_per_s\n{rows}")
    words = ["run", "twente-contact", "--set", f"wave.normal_amplitude=[{0.5 * threshold}, {3 * threshold}]"]
    assert main([*words, "--no-plot", "--measured", "lab.csv", "--out", "out"]) == 0
    points = json.loads(Path("out/run.json").read_text())["measured"]["points"]
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": levels})
    expected = run(scene).column("velocity_m_per_s")
    assert [points[0]["predicted_m_per_s"], points[1]["predicted_m_per_s"]] == [0.0, 0.0]
    assert [point["predicted_m_per_s"] for point in points] == pytest.approx(list(expected), rel=1e-3)


def test_a_file_in_another_unit_than_it_says_is_wondered_at(record, measured):
    """mm/s under a heading in m/s: a thousand times the prediction."""
    right, wrong = (
        "voltage_V,velocity_m_per_s\n10,-0.011\n30,-0.027\n",
        "voltage_V,velocity_m_per_s\n10,-11\n30,-27\n",
    )
    said = [
        "\n".join(line for _, line in comparison(compared(measured(text), [-0.01, -0.03]))) for text in (right, wrong)
    ]
    assert ["is the file in m/s?" in each for each in said] == [False, True]
