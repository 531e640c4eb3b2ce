"""Elasticities: Hertz's exponents, friction's law, Richardson extrapolation, and the study's record."""

from types import SimpleNamespace

import numpy as np
import pytest

import contact
from studies import Scene
from studies import run as run_chain
from studies.inverse import elasticity
from studies.inverse.elasticity import answers_at, both_sides, elasticities, numbers
from studies.inverse.prediction import MeasurementPredictor
from studies.inverse.sensitivity import run, tables, without_effect
from studies.record.point import Point
from studies.refusal import SceneError
from studies.solve.point_answer import PointAnswer


@pytest.fixture(scope="module")
def predictor():
    """The seed's slider with generic numbers, its preload the weight."""
    changed = {"mass": "0.13 g", "radius": "0.9 mm", "friction_coefficient": 0.11, "contacts": 2}
    return MeasurementPredictor(
        Scene.load("twente-contact").replace(slider=changed, wave={"normal_amplitude": "6.3 nm"})
    )


def test_release_follows_hertz(predictor):
    """The rest approach goes as (weight / (E* sqrt R))^(2/3); the bounce moves it by (f_n/f)^2 = 2e-5."""
    found = elasticities(predictor, ("release",), 6.3e-9)["release"]
    exact = {
        "slider.preload": 2 / 3, "slider.mass": 2 / 3, "slider.effective_modulus": -2 / 3, "slider.radius": -1 / 3
    }  # fmt: skip
    assert set(found) == set(numbers(predictor))
    for key, (value, error) in found.items():
        assert abs(value - exact.get(key, 0.0)) < 5e-5, key
        assert error < 1e-8, key


def test_blocked_thrust_is_mu_times_preload(predictor):
    """Well above release every contact slips forwards all the time it touches: nothing but mu and weight counts."""
    found = elasticities(predictor, ("thrust",), 30e-9)["thrust"]
    for key, (value, error) in found.items():
        exact = 1.0 if key in ("slider.friction_coefficient", "slider.preload", "slider.mass") else 0.0
        assert abs(value - exact) < max(error, 1e-8), key


def test_velocity_against_richardson_extrapolation(predictor):
    """An independent table of differences, of sixth order, of single steady states; the errors are kept."""
    found = elasticities(predictor, ("velocity",), 6.3e-9)["velocity"]

    def log_velocity(key, s):
        motor = predictor.contact({key: predictor.value(key) * np.exp(s)})
        orbits = tuple(orbit.scaled(6.3e-9) for orbit in motor.orbits)
        return np.log(abs(contact.mean_motion(motor.slider, orbits).velocity))

    for key in ("slider.friction_coefficient", "slider.preload", "wave.tangential_ratio", "slider.mass"):
        table = [(log_velocity(key, h) - log_velocity(key, -h)) / (2 * h) for h in (2e-2, 1e-2, 5e-3)]
        expected = (64.0 * table[2] - 20.0 * table[1] + table[0]) / 45.0
        assert abs(found[key][0] - expected) < min(found[key][1] + 1e-7, 1e-5), key


def test_richardson_s_error_is_that_of_the_last_extrapolation(monkeypatch):
    """An outcome exp(f(ln s)), f = s + s^3 + s^5 + c s^7: the table of three steps leaves the seventh power alone."""
    size = 1e9

    class Known:
        prescribed_wave, one_by_one = True, False

        def scene(self, changes):
            return SimpleNamespace(level_key="wave.normal_amplitude")

        def answers(self, many, also, *, tolerance, averaged):
            s = np.log([changes["wave.normal_amplitude"] / 6.3e-9 for changes in many])
            speeds = np.exp(s + s**3 + s**5 + size * s**7)
            points = [Point(status="ok", relative_error=1e-11, velocity_m_per_s=speed) for speed in speeds]
            return [PointAnswer(point=point, averaged=True) for point in points]

    monkeypatch.setattr(elasticity, "numbers", lambda predictor: [])
    ((value, error),) = elasticities(Known(), ("velocity",), 6.3e-9)["velocity"].values()
    step = 1e-11**0.2
    # Closed form: steps h, h/2, h/4 leave c h^6 / 64 of c s^7, and the last extrapolation changes 84/64 of that
    left = size * step**6 / 64
    assert value - 1.0 == pytest.approx(left, rel=1e-3)
    assert error == pytest.approx(84 / 64 * left + 8 * 1e-11 / step, rel=0.02)


def test_the_start_up_time_goes_as_the_mass(predictor):
    """At a given preload the averaged motion runs on the time scale of m v / (mu P)."""
    times, _ = answers_at(
        predictor, ("start-up time",), 6.3e-9, [{"slider.mass": mass, "slider.preload": 1.0} for mass in (0.04, 0.08)]
    )
    assert times[1] == pytest.approx(2.0 * times[0], rel=1e-3)
    assert 2e-4 < times[0, 0] < 5e-3  # a light slider, to be quick


def test_an_averaged_start_is_the_exact_one(predictor):
    changes = [{"slider.mass": 0.04 * predictor.value("slider.mass"), "wave.normal_amplitude": 6.3e-9}]
    (averaged,), (exact,) = (
        predictor.answers(changes, ("start-up",), tolerance=1e-6, averaged=way) for way in (True, False)
    )
    assert averaged.point.start_up_time_s == pytest.approx(exact.point.start_up_time_s, rel=2e-3)
    assert averaged.point.start_up_time_s != exact.point.start_up_time_s


@pytest.mark.slow
def test_numbers_of_a_stator(monkeypatch):
    """Against differences of whole runs; without diffraction the aperture moves nothing."""
    keys = ["stator.thickness", "transducer.0.aperture"]
    monkeypatch.setattr("studies.inverse.elasticity.numbers", lambda predictor: keys)
    short = Scene.load("twente-left").replace(
        stator={"length": "30 mm", "thickness": "1 mm", "diffraction": False},
        transducer={"left": {"finger_pairs": 2, "center": "6 mm"}}, slider={"position": "20 mm"},
        drive={"voltage": "60 V"},
    )  # fmt: skip
    found = elasticities(MeasurementPredictor(short, tolerance=1e-3), ("velocity",), 60.0)["velocity"]
    assert abs(found["transducer.0.aperture"][0]) < 1e-9
    runs = [
        run_chain(short.replace(stator={"thickness": 1e-3 * (1 + s)}), tolerance=1e-4).velocity[0]
        for s in (5e-4, -5e-4)
    ]
    value, error = found["stator.thickness"]
    assert value == pytest.approx(np.log(runs[0] / runs[1]) / 1e-3, rel=0.02)
    assert error < 0.02 * abs(value)


def test_the_sensitivity_of_a_position_is_per_micrometre_and_per_wavelength(small, monkeypatch):
    """Against runs one micrometre to either side; a shift of both positions shows that the origin is arbitrary."""
    keys = ["transducer.0.center", "slider.position", "slider.preload"]
    monkeypatch.setattr("studies.inverse.elasticity.numbers", lambda predictor: keys)
    record = run(small.replace(drive={"voltage": "120 V"}), outcomes=("velocity",))
    (panel,) = record.panels
    assert set(panel.data["key"]) == {"slider.preload", "level"}
    rows = {key: row for key, *row in panel.data["coordinates"]}
    one, more, less = (
        run_chain(small.replace(drive={"voltage": "120 V"}, slider={"position": x}), tolerance=1e-2).velocity[0]
        for x in (9e-3, 9.001e-3, 8.999e-3)
    )
    unit, slope, error, for_more, for_less, per_wavelength = rows["slider.position"]
    assert unit == "um"
    assert slope == pytest.approx((more - less) / (2 * one), rel=1e-3)
    assert error < 1e-4 * abs(slope)
    assert (for_more, for_less) == pytest.approx((more / one - 1, less / one - 1), rel=1e-3)
    assert per_wavelength == pytest.approx(slope * 991.78, rel=1e-4)
    assert rows["transducer.0.center"][1] == pytest.approx(-slope, rel=1e-6)  # absorbing ends: the distance counts
    text = "\n".join(line for _, line in record.answer)
    assert (
        f"{100 * slope:+.3g} % for 1 um of slider.position ({per_wavelength:+.3g} times its size per wavelength)"
        in text
    )
    assert "position" not in next(line for name, line in record.answer if name == "velocity")
    head, *lines = tables(record)["sensitivity.csv"].splitlines()
    cells = dict(zip(head.split(","), next(x for x in lines if "slider.position" in x).split(","), strict=True))
    assert cells["elasticity"] == cells["change_for_1_percent_more"] == ""
    assert (cells["unit"], float(cells["change_per_unit"])) == ("um", slope)


def test_what_is_said_to_have_no_effect_is_tried(predictor):
    """A number that does move the answer among the silent ones contradicts the finding."""
    rows = elasticities(predictor, ("release",), 6.3e-9)["release"]
    (silent,) = without_effect(predictor, "release", rows, 6.3e-9)
    assert silent.confirmed
    (wrong,) = without_effect(predictor, "release", rows | {"slider.radius": (0.0, 0.0)}, 6.3e-9)
    assert not wrong.confirmed


def test_the_study_says_what_has_no_effect():
    record = run("twente-contact", outcomes=("velocity", "release"))
    assert all(finding.confirmed for finding in record.findings)
    assert record.findings[0].statement == "Without effect on the velocity: slider.damping.normal."
    cells = tables(record)["sensitivity.csv"].split("velocity,wave.tangential_ratio,")[1].split("\n")[0].split(",")
    elasticity, _, more, less = map(float, cells[:4])
    assert (more, less) == pytest.approx((0.01 * elasticity, -0.01 * elasticity), rel=0.05)
    assert more != -less


def test_one_outcome_may_be_a_text_and_a_scene_needs_a_slider():
    assert [panel.name for panel in run("twente-contact", outcomes="release").panels] == ["release"]
    with pytest.raises(SceneError, match="slider is missing"):
        run(Scene.load("twente-left").replace(slider=None))


def test_both_sides_are_those_of_whole_runs_and_a_bend_is_said(predictor):
    """1 % more and 1 % less of the amplitude ratio just above the threshold: one side stops the slider."""
    scene = Scene.load("twente-contact")
    threshold = run_chain(scene).summary["threshold_amplitude_m"]
    near = scene.replace(wave={"normal_amplitude": [1.005 * threshold]})
    ratio = near.wave.tangential_ratio
    speeds = [
        run_chain(near.replace(wave={"tangential_ratio": ratio * factor}), tolerance=1e-5).velocity[0]
        for factor in (1.0, 1.01, 0.99)
    ]
    assert speeds[2] == 0.0
    sides = both_sides(MeasurementPredictor(near), ("velocity",), 1.005 * threshold)
    more, less = sides["velocity"]["wave.tangential_ratio"]
    assert more == pytest.approx(speeds[1] / speeds[0] - 1.0, rel=1e-3)
    assert less == -1.0
    record = run(near, outcomes=("velocity",))
    said = [text for _, text in record.answer if text.startswith("bends with wave.tangential_ratio")]
    assert said == [f"bends with wave.tangential_ratio: {100 * more:+.3g} % for 1 % more, -100 % for 1 % less"]


def test_a_state_that_averaging_does_not_give_is_judged_by_the_tolerance_of_the_question():
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["3 nm"]}, slider={"method": "exact"})
    predictor = MeasurementPredictor(scene, tolerance=1e-2)
    loose, tight = (predictor.answers([{}], tolerance=each)[0] for each in (None, 1e-11))
    assert loose.point.status == "ok"
    assert tight.point.status.startswith("above tolerance")
    assert tight.point.velocity_m_per_s == pytest.approx(loose.point.velocity_m_per_s, rel=1e-10)


def test_the_error_of_an_exact_state_s_elasticity_holds_its_numerical_error(predictor):
    """The averaged states, whose errors cancel, are the reference; the exact ones keep 1e-10 of their own."""
    exact = MeasurementPredictor(
        Scene.load("twente-contact").replace(wave={"normal_amplitude": "8 nm"}, slider={"method": "exact"})
    )
    averaged = MeasurementPredictor(Scene.load("twente-contact").replace(wave={"normal_amplitude": "8 nm"}))
    one, other = (elasticities(each, ("velocity",), 8e-9)["velocity"] for each in (exact, averaged))
    stated = exact.answers([{}], tolerance=1e-11)[0].from_contact
    for key, (value, error) in one.items():
        # the term of the rounding: 8 of the answers' errors over the step, the fifth root of 1e-11
        assert error > 8 * 0.5 * stated / 1e-11**0.2, key
        assert abs(value - other[key][0]) < error + other[key][1], key
