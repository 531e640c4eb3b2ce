"""Velocity over half a wavelength about a position: mean over place and range, on a partly standing wave.

The truth is a scan of places of its own: the contact solved at each, by `contact.steady`, on the field that the stator
has there; the mean is by the trapezoidal rule. The scans share neither the interpolation of the field, nor the
polynomials, nor the averaged states.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import resample

import contact
from studies import Scene, run, sweep
from studies.inverse.optimum import Options, design
from studies.inverse.prediction import MeasurementPredictor
from studies.lab.measurement_csv import read_measured
from studies.model.model import Model
from studies.model.resolve import build
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.run_pictures import velocity as draw_velocity
from studies.remarks.run_warnings import warnings_of
from studies.solve import chebyshev, stators
from studies.solve.loaded_wave import wave_velocity
from studies.solve.measured_run import measured_block
from studies.solve.nearby_motion import nearby_motions
from studies.solve.ripple import Known, NearbyContact, ripples
from studies.solve.solved_stator import SolvedStator, contact_of_run
from studies.solve.wave_ripple import wave_ripple_point

TOLERANCE = 1e-2
COLUMNS = ("mean_velocity_m_per_s", "lowest_velocity_m_per_s", "highest_velocity_m_per_s")
ECHOES = Scene.load(Path(__file__).parent / "scenes" / "echoes.toml")  # 40 mm of PZT-4, standing-wave ratio 2.15
BALLS = ["-0.31 mm", ["0.1 mm", "3 mm"]]


def scanned(record, level: float, count: int = 65) -> np.ndarray:
    """Return the velocities at evenly spaced places of the interval of a run, each solved alone."""
    scene, motion, summary = record.scene, record.surface_motion, record.summary
    slider, positions = contact_of_run(record).slider, scene.slider.contact_positions
    shifts = np.linspace(summary["ripple_from_m"], summary["ripple_to_m"], count) - scene.slider.center[0]
    # one part in 1e9 inside, so that the ends lie on the stator
    balls = [motion.along(x + shifts * (1 - 1e-9), y) for x, y in positions]
    velocities = []
    for k in range(count):
        orbits = tuple(
            contact.Orbit(frequency=motion.wave.frequency, tangential=complex(u[0][k]), normal=complex(u[2][k])).scaled(
                level
            )
            for u in balls
        )
        velocities.append(contact.steady(slider, orbits, tolerance=1e-4).velocity)
    return np.array(velocities)


def truth(velocities: np.ndarray) -> np.ndarray:
    """Return mean over place, lowest and highest velocity of a scan."""
    return np.array([np.trapezoid(velocities) / (velocities.size - 1), velocities.min(), velocities.max()])


def assert_as_scanned(record, point: dict, count: int = 65) -> None:
    """Assert that a point's columns are within twice their stated error of a scan, and within its own resolution."""
    velocities = scanned(record, point["voltage_V"], count)
    error = abs(truth(velocities) - [point[name] for name in COLUMNS])
    omega = 2 * np.pi * record.scene.frequency
    reference = max(abs(point["mean_velocity_m_per_s"]), 0.1 * omega * point["tangential_amplitude_m"])
    resolution = abs(truth(velocities) - truth(velocities[::2])).max()  # of the scan itself
    assert error.max() <= 2 * point["mean_velocity_relative_error"] * reference + resolution


@pytest.fixture(scope="module")
def rippled(small):
    """A small motor whose stator's end modes make a standing wave, standing-wave ratio 1.45."""
    return run(small, tolerance=TOLERANCE)


def test_polynomials_through_chebyshev_points():
    """Closed form: exp on [-1, 1]."""
    x, at = chebyshev.points(17), np.linspace(-1, 1, 7)
    assert np.allclose(chebyshev.interpolation(17, at) @ np.exp(x), np.exp(at), rtol=1e-13, atol=0.0)
    assert chebyshev.weights(17) @ np.exp(x) == pytest.approx(np.sinh(1.0), rel=1e-13)
    assert np.array_equal(chebyshev.points(17)[::2], chebyshev.points(9))


def test_the_motion_between_the_points_is_that_of_the_stator(rippled):
    """Oracle: the field itself, beside the axis too."""
    motion, position = rippled.surface_motion, (9e-3, 1e-3)
    (nearby,) = nearby_motions(motion, [position])
    quarter = motion.wave.phase_velocity / motion.wave.frequency / 4
    assert (nearby.low, nearby.high) == pytest.approx((-quarter, quarter), rel=1e-12)
    shifts = np.array([-0.97, -0.2, 0.013, 0.61]) * quarter
    u_x, u_z, error = nearby.at(shifts)
    truth_x, _, truth_z = motion.along(position[0] + shifts, position[1])
    size = abs(truth_z).max()
    assert abs(np.array([u_x - truth_x, u_z - truth_z])).max() < 1e-6 * size
    assert np.all(error > 0.0)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_mean_and_range_are_those_of_a_scan(rippled, level):
    point = rippled.points[level]
    assert_as_scanned(rippled, point)
    low, mean, high = (
        point["lowest_velocity_m_per_s"],
        point["mean_velocity_m_per_s"],
        point["highest_velocity_m_per_s"],
    )
    assert low < mean < high < 0.0
    assert low <= point["velocity_m_per_s"] <= high
    assert 0.5 * point["relative_error"] < point["mean_velocity_relative_error"] < TOLERANCE
    assert high - low > 0.3 * abs(mean)


def test_the_error_of_the_motion_and_that_of_the_places_are_both_in_the_error(rippled, small):
    """Property: a motion known 100 times worse moves the velocities by as much; a finer tolerance takes more places."""
    driven = Contact.of_stator(
        Model(rippled.scene), SolvedStator.of(rippled.surface_motion, rippled.scene.positions, nearby=True)
    )
    nearby, point = NearbyContact.of(driven, TOLERANCE), rippled.points[2]
    worse = replace(nearby, motions=tuple(replace(each, error=100 * each.error) for each in nearby.motions))
    known = {120.0: Known(point["velocity_m_per_s"], 1.0)}
    one, other = (ripples(each, known)[120.0] for each in (nearby, worse))
    assert other.mean == one.mean
    stator = point["relative_error"] * abs(point["velocity_m_per_s"])
    assert 50 * stator < other.error - one.error < 400 * stator
    (finer,) = run(small.replace(drive={"voltage": "20 V"}), tolerance=1e-3).points
    assert 2 * finer["mean_velocity_relative_error"] < rippled.points[0]["mean_velocity_relative_error"]


def test_they_are_those_of_runs_at_other_positions(rippled, small):
    """Another door: a sweep over the slider's position, whose places are runs of their own."""
    summary, point = rippled.summary, rippled.points[2]
    places = np.linspace(summary["ripple_from_m"], summary["ripple_to_m"], 33)
    one = small.replace(drive={"voltage": ["120 V"]})
    rows = sweep(one, {"slider.position": places.tolist()}, tolerance=TOLERANCE).to_dataframe()
    found = truth(rows["velocity_m_per_s"].to_numpy())
    assert np.allclose([point[name] for name in COLUMNS], found, rtol=TOLERANCE, atol=0.0)


@pytest.mark.parametrize(("position", "expected"), [(20e-3, (130.1, 72.7, 182.6)), (20.28e-3, (114.0, 69.8, 178.5))])
def test_a_motor_in_front_of_a_reflector(position, expected):
    """Oracle: scans of 64 runs over half a wavelength, in mm/s; they miss a minimum by 1 %, and the ends by 0.5 %."""
    record = run(ECHOES.replace(slider={"position": position}), tolerance=1e-3)
    (point,) = record.points
    mean, fastest, slowest = (-1e3 * point[name] for name in COLUMNS)
    assert mean == pytest.approx(expected[0], rel=2e-3)
    assert slowest == pytest.approx(expected[1], rel=1.2e-2)
    assert fastest == pytest.approx(expected[2], rel=6e-3)
    assert any("partly a standing one" in each for each in record.warnings)


def test_two_balls_have_their_own_places(small):
    record = run(small.replace(slider={"contacts": BALLS}), tolerance=TOLERANCE)
    assert_as_scanned(record, record.points[2], 33)


def test_the_mirrored_motor_has_the_mirrored_range(small, rippled):
    """Property: x -> -x changes the signs, and exchanges lowest and highest."""
    table = small.to_table()
    table["transducer"][0]["center"], table["slider"]["position"] = 10e-3, 5e-3
    image = run(Scene.from_table("", table), tolerance=TOLERANCE)
    for own, other in zip(image.points, rippled.points, strict=True):
        expected = (
            -other["mean_velocity_m_per_s"],
            -other["highest_velocity_m_per_s"],
            -other["lowest_velocity_m_per_s"],
        )
        assert np.allclose([own[name] for name in COLUMNS], expected, rtol=1e-6, atol=0.0)
    ends = 14e-3 - image.summary["ripple_to_m"], 14e-3 - image.summary["ripple_from_m"]
    assert ends == pytest.approx((rippled.summary["ripple_from_m"], rippled.summary["ripple_to_m"]), rel=1e-12)


def test_a_sweep_and_a_design_have_the_columns_of_a_run(rippled, small):
    """Property: the same mean and range by three doors; of a search for the least ripple, the best is that place."""
    one = small.replace(drive={"voltage": ["120 V"]})
    places = [8.8e-3, 9e-3]
    swept = sweep(one, {"slider.position": places}, tolerance=TOLERANCE, also=("ripple",))
    assert "that of the slider's position" in str(swept)
    rows = swept.to_dataframe()
    assert np.allclose(rows[list(COLUMNS)].iloc[1], [rippled.points[2][name] for name in COLUMNS], rtol=1e-6, atol=0.0)
    assert rows["mean_velocity_relative_error"].max() < TOLERANCE
    width = rows["highest_velocity_m_per_s"] - rows["lowest_velocity_m_per_s"]
    assert np.allclose(rows["velocity_ripple"], width / abs(rows["mean_velocity_m_per_s"]), rtol=1e-12)
    again = sweep(one, {"slider.preload": [0.5e-3, 0.87e-3]}, tolerance=TOLERANCE, also=("ripple", "thrust"))
    assert {"thrust_N", *COLUMNS} <= set(again.to_dataframe())
    found = design(
        one, "mean_velocity", {"slider.preload": (0.5e-3, 5e-3)}, ["ripple <= 0.5"],
        options=Options(evaluations=14, tolerance=0.1),
    )  # fmt: skip
    assert found.columns == ("mean_velocity_m_per_s",)
    assert "that of the slider's position" in str(found)
    fastest = max(abs(point["mean_velocity_m_per_s"]) for point in found.points if point["velocity_ripple"] <= 0.5)
    assert abs(found.optimum["mean_velocity_m_per_s"]) == fastest
    assert abs(found.optimum["mean_velocity_m_per_s"]) != abs(found.optimum["velocity_m_per_s"])


def test_along_a_prescribed_wave_all_places_are_alike():
    rows = sweep("twente-contact", {"wave.normal_amplitude": [8e-9]}, tolerance=TOLERANCE, also=("ripple",))
    (row,) = rows.to_dataframe().to_dict("records")
    assert row["mean_velocity_m_per_s"] == row["lowest_velocity_m_per_s"] == row["velocity_m_per_s"] != 0.0
    assert row["velocity_ripple"] == 0.0


def test_a_slider_that_sticks_at_some_places(small):
    """Near the threshold the velocity has kinks; at 10 V it sticks at two places of three and runs both ways beside."""
    record = run(small.replace(drive={"voltage": ["10 V"]}), tolerance=1e-3)
    (point,) = record.points
    assert point["velocity_m_per_s"] == 0.0
    assert_as_scanned(record, point, 65)
    velocities = scanned(record, 10.0, 65)
    assert np.sum(velocities == 0.0) > 32
    found = [point[name] for name in COLUMNS[1:]]
    assert found == pytest.approx([velocities.min(), velocities.max()], rel=1e-3)
    assert found[0] < 0.0 < found[1]
    assert point["mean_velocity_m_per_s"] == pytest.approx(truth(velocities)[0], rel=1e-2)


@pytest.mark.parametrize(
    "slider", [{"mass": 2e-7, "preload": 0.87e-3}, {"law": "hysteretic"}], ids=["light", "hysteretic"]
)
def test_where_averaging_does_not_suffice_the_motion_itself_is_solved(small, slider):
    scene = small.replace(slider=slider, drive={"voltage": ["60 V"]})
    record = run(scene, tolerance=1e-3)
    (point,) = record.points
    assert_as_scanned(record, point, 33)
    assert point["mean_velocity_relative_error"] < 3e-3


def test_the_interval_ends_with_the_stator_and_at_the_fingers(small):
    at_end = run(small.replace(slider={"position": "13.9 mm"}), tolerance=0.1).summary
    assert 13.98e-3 < at_end["ripple_to_m"] <= 14e-3
    assert at_end["ripple_from_m"] == pytest.approx(13.9e-3 - 0.25 * 0.992e-3, abs=2e-6)
    fingers = 4e-3 + 3 * 0.98e-3 / 2
    beside = run(small.replace(slider={"position": fingers + 0.1e-3}), tolerance=0.5).summary
    assert fingers - 0.15e-3 < beside["ripple_from_m"] < fingers + 0.09e-3


def test_without_reflection_there_are_no_columns(small, rippled):
    """The same run at a tolerance above its ripple: the summary and the text say so."""
    still = small.replace(stator={"thickness": "half-space", "diffraction": False}, drive={"voltage": ["120 V"]})
    record = run(still, tolerance=0.15)
    assert 0.0 < record.summary["velocity_ripple"] < 0.15
    assert not set(COLUMNS) & set(record.points[0])
    text = str(record)
    assert "below the tolerance" in next(line for line in text.splitlines() if line.startswith("ripple"))
    assert "mean (mm/s)" not in text
    assert "mean (mm/s)" in str(rippled)
    assert (
        "velocity_ripple" not in run("twente-contact", tolerance=TOLERANCE).summary
    )  # a prescribed wave has no places


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_range_of_ten_percent_is_a_warning(rippled, share):
    mean, half = -0.05, 0.5 * 0.1 * 0.05 * share
    columns = dict(zip(COLUMNS, (mean, mean - half, mean + half), strict=True))
    summary = rippled.summary | {"velocity_ripple": 0.1 * share}
    record = replace(rippled, points=tuple(each | columns for each in rippled.points), summary=summary)
    said = [each for each in warnings_of(record) if "partly a standing one" in each]
    assert len(said) == (share > 1.0)
    assert all("-50 mm/s in the mean over place" in each and "120 V" in each for each in said)
    assert any("mm/s in the mean over place" in each for each in rippled.warnings)


def test_the_picture_shows_range_and_mean(rippled):
    from studies.record.plots import new_figure

    _, ax = new_figure(7, 4)
    labels = draw_velocity(rippled, ax).get_legend_handles_labels()[1]
    assert {"mean over place", "range, half a wavelength"} <= set(labels)
    assert any(each.endswith("at the position") for each in labels)


def test_pillars_on_waves_from_both_sides_have_the_range_of_displaced_pillars():
    """Oracle: the same pillars at other coordinates, on the same waves, 48 places and the trapezoidal rule."""
    scene = Scene.load(Path(__file__).parent / "scenes" / "pillars.toml")
    body = Contact.prescribed(build(scene))
    body = replace(body, orbits=replace(body.orbits, forward=0.2 * body.orbits.backward))  # it runs to -x
    level = 20e-9
    point = Point(velocity_m_per_s=wave_velocity(body, level))
    columns, size = wave_ripple_point(body, level, point, 1e-3)
    velocities = []
    for shift in body.orbits.wavelength / 2 * np.arange(48) / 48:
        moved = replace(body.slider, x=np.array(body.slider.x) + shift)
        velocities.append(contact.steady(moved, body.at(level), tolerance=1e-3).velocity)
    expected = np.mean(velocities), min(velocities), max(velocities)
    error = 2 * columns["mean_velocity_relative_error"] * abs(columns["mean_velocity_m_per_s"])
    assert [columns[name] for name in COLUMNS] == pytest.approx(expected, abs=error + 1e-3 * np.ptp(velocities))
    assert columns["mean_velocity_relative_error"] < 5e-3
    assert size > 0.02


def test_pillars_in_front_of_a_reflector(monkeypatch):
    """Another door: runs at other positions, each with its own fit of the waves; without the reflector no columns.

    The stator is solved once for all positions.
    """
    solved, solve = [], stators.solved_motion
    monkeypatch.setattr(
        stators, "solved_motion", lambda *given, **options: solved.append(1) or solve(*given, **options)
    )
    scene = Scene.load(Path(__file__).parent / "scenes" / "driven-pillars.toml")
    table = scene.to_table()
    pillars = {"rows": 10, "columns": 10, "height_scatter": 0.0, "seed": 0}
    table["slider"] |= {"preload": 1.0, "loading": False, "pillars": table["slider"]["pillars"] | pillars}
    alone = run(Scene.from_table("", table), tolerance=TOLERANCE)
    assert not set(COLUMNS) & set(alone.points[0])
    assert alone.summary["velocity_ripple"] < 1e-6
    table["transducer"].append(table["transducer"][0] | {"name": "right", "center": 25e-3, "termination": "short"})
    both = Scene.from_table("", table)
    record = run(both, tolerance=TOLERANCE)
    (point,) = record.points
    places = np.linspace(record.summary["ripple_from_m"], record.summary["ripple_to_m"], 8, endpoint=False)
    solved.clear()
    rows = sweep(both, {"slider.position": places.tolist()}, tolerance=TOLERANCE, also=("ripple",)).to_dataframe()
    assert len(solved) == 1
    velocities = resample(rows["velocity_m_per_s"].to_numpy(), 256)  # half a wavelength is its period: Fourier series
    expected = [velocities.mean(), velocities.min(), velocities.max()]
    assert [point[name] for name in COLUMNS] == pytest.approx(expected, rel=TOLERANCE)
    assert np.ptp(velocities) > 10 * TOLERANCE * velocities.mean()
    assert np.ptp(rows["mean_velocity_m_per_s"]) < 2e-3 * abs(point["mean_velocity_m_per_s"])
    assert any("partly a standing one" in each for each in record.warnings)


def test_a_fit_and_a_comparison_of_mean_velocities(rippled, small, tmp_path):
    """Round trip: the mean velocities of a run give its friction coefficient back; as velocities they do not."""
    means = [point["mean_velocity_m_per_s"] for point in rippled.points]
    files = {}
    for name in ("mean_velocity_m_per_s", "velocity_m_per_s"):
        rows = [f"{v},{mean!r}" for v, mean in zip((20.0, 60.0, 120.0), means, strict=True)]
        files[name] = tmp_path / f"{name}.csv"
        files[name].write_text("\n".join([f"voltage_V,{name}", *rows]) + "\n")
    mean = read_measured(files["mean_velocity_m_per_s"])
    assert mean.quantity == "mean velocity"
    block = measured_block(rippled, mean)
    assert block["of"] == "mean over half a wavelength"
    assert block["rms_deviation_m_per_s"] == 0.0
    here = measured_block(rippled, read_measured(files["velocity_m_per_s"]))
    assert here["of"] == "at the position"
    assert here["measured_over_predicted"] > 1.05
    other = replace(mean, levels=(80.0,), values=(means[2],))
    (point,) = measured_block(rippled, other)["points"]
    assert means[1] > point["predicted_m_per_s"] > means[2]
    predictor = MeasurementPredictor(small, tolerance=TOLERANCE)
    (predicted,) = predictor.predict([(mean, {})])
    assert predicted == pytest.approx(means, rel=2e-3)
    (larger,) = predictor.predict([(mean, {"amplitude_factor": 1.1})])
    (voltages,) = predictor.predict([(replace(mean, levels=(22.0, 66.0, 132.0)), {})])
    assert larger == pytest.approx(voltages, rel=1e-3)
