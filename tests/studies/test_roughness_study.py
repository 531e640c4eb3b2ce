"""The study of roughness: thresholds, releases and velocities against it, and the roughness that a threshold tells."""

import csv
import io

import numpy as np
import pytest

import contact
from studies import Scene, SceneError
from studies.evidence import rough_balls
from studies.motor import roughness

KNOWN = {"rms_m": [1e-9, 4e-9], "threshold": {"lowest": [1.0, 2.0], "median": [2.0, 4.0], "highest": [3.0, 6.0]}}


@pytest.fixture(scope="module")
def record():
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["5 nm", "8 nm"]})
    return roughness.run(scene, rms=(3e-9,), measured="1.1 nm")


def test_a_roughness_of_3_nm_has_the_ranges_of_an_independent_program(record):
    """Ratios to the smooth ball with the elastic law, median (lowest to highest) of another eight balls at r = 0.67."""
    data = record.panel().data
    smooth = data["smooth"]["elastic"]
    expected = {"threshold": (1.24, 1.05, 1.43), 0: (0.95, 0.90, 1.02), 1: (0.99, 0.96, 1.02)}
    for key, (median, lowest, highest) in expected.items():
        numbers = data["threshold"] if key == "threshold" else {
            kind: [values[0][key]] for kind, values in data["speeds"].items()
        }  # fmt: skip
        base = smooth["threshold"] if key == "threshold" else smooth["speeds"][key]
        width = highest - lowest  # of other balls
        assert numbers["median"][0] / base == pytest.approx(median, abs=0.5 * width)
        for kind in ("lowest", "highest", "mean_field"):
            assert lowest - 0.5 * width < numbers[kind][0] / base < highest + 0.5 * width


def test_smooth_limits_are_those_of_the_closed_forms(record):
    smooth = record.panel().data["smooth"]
    ball = rough_balls.ball()
    orbit = contact.Orbit(frequency=2.2e6, normal=1.0, tangential=-0.7j)
    assert smooth["elastic"]["release"] == pytest.approx(contact.release_factor(ball, orbit), rel=1e-6)
    assert contact.threshold_factor(ball, orbit) < smooth["elastic"]["threshold"] < 0.84e-9
    assert smooth["hysteretic"]["threshold"] < smooth["elastic"]["threshold"]


def test_the_table_has_every_number_of_the_panel(record):
    rows = list(csv.DictReader(io.StringIO(roughness.tables(record)["roughness.csv"])))
    data = record.panel().data
    assert [row["quantity"] for row in rows] == ["threshold", "release", "speed_m_per_s", "speed_m_per_s"]
    assert [float(row["median"]) for row in rows[:2]] == [data[key]["median"][0] for key in ("threshold", "release")]
    assert [float(row["level"]) for row in rows[2:]] == [5e-9, 8e-9]
    assert [float(row["mean_field"]) for row in rows[2:]] == list(data["speeds"]["mean_field"][0])


def test_a_measured_threshold_is_read_with_its_range_and_with_more_friction(record):
    told = dict(record.answer)["measured"]
    assert "1.1 nm is the threshold of balls with a roughness of" in told
    assert "with a friction coefficient larger by 10 %" in told


def test_a_threshold_becomes_the_roughness_of_the_median_and_of_the_extremes():
    """Between 1 and 4 nm the logarithm is interpolated: the middle is 2 nm."""
    assert roughness.roughness_at(KNOWN, 3.0) == {"lowest": "more than 4 nm", "median": "2 nm", "highest": "1 nm"}
    assert roughness.roughness_at(KNOWN, 1.5)["median"] == "less than 1 nm"


def test_the_release_of_one_asperity_is_that_of_a_sphere_of_its_radius():
    """One asperity at the lowest point is a smooth ball of its radius: its release in closed form."""
    one = contact.Asperities(x=[0.0], y=[0.0], heights=[0.0], radius=1e-3)
    ball = rough_balls.ball()
    factor = contact.RoughBalls(ball, [one]).release(rough_balls.orbit(1e-9))
    assert factor == pytest.approx(contact.release_factor(ball, rough_balls.orbit(1e-9)), rel=2e-3)


def test_half_of_all_balls_have_left_where_the_mean_field_parts():
    """150 drawn balls: their median lies within three standard deviations of a median."""
    rough = contact.Roughness(rms=3e-9)
    parts = np.array([rough.drawn(seed, 8e-6).parting(1e-3) for seed in range(150)])
    expected = contact.MeanField(1e-3, 64e9, rough).parting(1e-3)
    share = np.mean(parts > expected)  # touches nothing there
    assert abs(share - 0.5) < 3.0 * 0.5 / np.sqrt(parts.size)
    assert expected == pytest.approx(np.median(parts), abs=0.3e-9)


@pytest.mark.parametrize(
    ("changes", "options", "sentence"),
    [
        ({"slider": {"roughness": {"file": "a.npy", "step": "1 nm"}}}, {}, r"slider\.roughness\.file must be absent"),
        ({"slider": None}, {}, "slider is missing"),
        ({"slider": {"stick_band": "1 mm/s"}}, {}, "stick_band does not go with slider.roughness"),
        ({}, {"measured": "3 kg"}, "--measured"),
        ({}, {"measured": -1e-9}, "--measured must be positive"),
    ],
)  # fmt: skip
def test_what_the_study_cannot_take_is_refused(changes, options, sentence):
    with pytest.raises(SceneError, match=sentence):
        roughness.run(Scene.load("twente-contact").replace(**changes), **options)


def test_a_threshold_below_that_of_smooth_balls_tells_no_roughness():
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": "5 nm"})
    record = roughness.run(scene, rms=(7e-9,), measured=0.5e-9)
    assert "0.5 nm tells no roughness: smooth balls start at 0.83" in dict(record.answer)["measured"]
