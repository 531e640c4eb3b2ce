"""Fits: closed forms of linear and multiplicative models, a scaling law of the contact, and the command."""

import itertools
import json
import math
import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from studies import Scene, run
from studies.__main__ import main
from studies.inverse import Measurement, Parameter, Residual, fit, read_measurement, read_parameter
from studies.inverse import fit as fit_function
from studies.inverse.directions import undetermined
from studies.inverse.fitting import fit_about
from studies.inverse.free_parameters import as_parameters
from studies.inverse.least_squares import Problem
from studies.inverse.prediction import MeasurementPredictor
from studies.refusal import SceneError

LEVELS = tuple(np.linspace(1.0, 4.0, 7))


class Model:
    """A predictor whose answer is a formula of its numbers and the level."""

    prescribed_wave, one_by_one, costly, table = True, False, False, {}

    def __init__(self, formula, **own):
        self.formula, self.own = formula, own

    def begin(self, stage, total=0):
        """Say nothing."""

    def predict(self, questions, *, travelling=True):
        return [self.formula(np.array(m.levels), **(self.own | numbers)) for m, numbers in questions]

    def value(self, key):
        return self.own.get(key)

    def needs_stator(self, key):
        return False


def explored(model, parameters, monkeypatch, **own):
    """Return the fit of a formula to its own values; no next measurements."""
    monkeypatch.setattr(import_module("studies.inverse.fitting"), "ranked", lambda *_: [])
    data = Measurement(name="m", quantity="velocity", level_key="voltage_V", levels=LEVELS,
                       values=tuple(model.formula(np.array(LEVELS), **model.own)), **own)  # fmt: skip
    problem = Problem(predictor=model, parameters=parameters, measurements=(data,))
    return fit_about(problem, problem.minima(), problem.points - len(parameters), False, False)


def test_intervals_of_a_straight_line_are_those_of_the_textbook(monkeypatch):
    """Both coefficients free: variance sigma^2 (X^T X)^-1, intervals 1.96 standard deviations either way."""
    model = Model(lambda x, a, b: a + b * x, a=0.3, b=2.0)
    free = (Parameter(key="a", low=-9.0, high=9.0), Parameter(key="b", low=-9.0, high=9.0))
    found = explored(model, free, monkeypatch, deviations=(0.1,) * 7)
    design = np.column_stack([np.ones(7), LEVELS])
    sizes = 0.1 * np.sqrt(np.diag(np.linalg.inv(design.T @ design)))
    for key, size, value in zip("ab", sizes, (0.3, 2.0), strict=True):
        low, high = found.intervals[key]
        assert (high - value, value - low) == pytest.approx((1.95996 * size,) * 2, rel=0.02)
    assert not found.directions
    expected = -np.mean(LEVELS) / np.sqrt(np.mean(np.square(LEVELS)))
    assert found.correlation[0, 1] == pytest.approx(expected, abs=1e-3)


def test_derivatives_by_a_number_of_the_stator_take_few_stators():
    """Within its range and at both ends: right to the square of a step, and steps of a search share their stators."""
    solved = set()

    def formula(x, thickness, b):
        solved.add(thickness)
        return x * np.sin(30.0 * np.log(thickness) + 1.0) + b

    model = Model(formula, thickness=1.0, b=2.0)
    model.needs_stator = lambda key: key == "thickness"
    free = (Parameter(key="thickness", low=0.9, high=1.1), Parameter(key="b", low=-9.0, high=9.0))
    data = Measurement(name="m", quantity="velocity", level_key="voltage_V", levels=LEVELS, values=LEVELS,
                       deviations=(1.0,) * len(LEVELS))  # fmt: skip
    problem = Problem(predictor=model, parameters=free, measurements=(data,))
    for near in (np.log(0.9), 0.0, np.log(1.1)):
        solved.clear()
        inside = near - 3e-4 if near > 0 else near + 3e-4
        for value in (near, inside, inside + 1e-5):
            derivatives = problem.jacobian([value, 2.0])
            assert derivatives[:, 0] == pytest.approx(-30.0 * np.array(LEVELS) * np.cos(30.0 * value + 1.0), rel=1e-3)
            assert derivatives[:, 1] == pytest.approx(-np.ones(len(LEVELS)), rel=1e-9)
        assert len(solved) <= 3 + 3


def test_a_systematic_error_adds_to_the_interval_as_its_variance_does(monkeypatch):
    """Values y = b x with a common factor known to s: var(ln b) = 1 / sum (b x / sigma)^2 + s^2."""
    model = Model(lambda x, b: b * x, b=2.0)
    free = (Parameter(key="b", low=0.5, high=8.0),)
    found = explored(model, free, monkeypatch, deviations=(0.05,) * 7, systematic=0.03)
    size = math.sqrt(1.0 / np.sum((2.0 * np.array(LEVELS) / 0.05) ** 2) + 0.03**2)
    low, high = np.log(np.array(found.intervals["b"]) / 2.0)
    # the factor 1 + s makes one end nearer and the other farther, by as much
    assert 0.5 * (high - low) == pytest.approx(1.95996 * size, rel=0.01)


def test_intervals_without_deviations_are_student_s(monkeypatch):
    """Slope of scattered values of unknown, equal deviation: t(0.975, n - 1) times the residual's estimate."""
    from scipy.stats import t

    scatter = 0.02 * np.array([1.0, -2.0, 0.5, 1.5, -1.0, 0.7, -0.4])
    model = Model(lambda x, b, e=1.0: b * x + e * scatter, b=2.0)
    fitted = Model(lambda x, b: b * x, b=2.0)
    monkeypatch.setattr(import_module("studies.inverse.fitting"), "ranked", lambda *_: [])
    data = Measurement(name="m", quantity="velocity", level_key="voltage_V", levels=LEVELS,
                       values=tuple(model.formula(np.array(LEVELS), 2.0)), deviations=(1.0,) * 7)  # fmt: skip
    free = (Parameter(key="b", low=0.5, high=8.0),)
    problem = Problem(predictor=fitted, parameters=free, measurements=(data,))
    found = fit_about(problem, problem.minima(), problem.points - 1, True, False)
    x = np.array(LEVELS)
    slope = float(x @ data.values / (x @ x))
    residual = math.sqrt(np.sum((np.array(data.values) - slope * x) ** 2) / (len(x) - 1))
    size = t.ppf(0.975, len(x) - 1) * residual / math.sqrt(x @ x)
    low, high = found.intervals["b"]
    assert 0.5 * (low + high) == pytest.approx(slope, rel=1e-3)
    assert 0.5 * (high - low) == pytest.approx(size, rel=0.02)


def test_a_product_leaves_its_factors_undetermined_however_narrow_their_ranges(monkeypatch):
    """The range of the other factor would make a finite interval; the data make none."""
    model = Model(lambda x, a, b, c: a * b * x + c, a=1.0, b=2.0, c=0.5)
    free = tuple(Parameter(key=key, low=low, high=high) for key, low, high in
                 (("a", 0.01, 100.0), ("b", 1.6, 2.5), ("c", 0.1, 3.0)))  # fmt: skip
    found = explored(model, free, monkeypatch, deviations=(0.01,) * 7)
    assert found.intervals["a"] == found.intervals["b"] == (None, None)
    low, high = found.intervals["c"]
    assert low < 0.5 < high
    (way,) = found.directions
    assert way.components == pytest.approx({"a": 1.0, "b": -1.0}, abs=1e-6)
    assert way.sentence == "a and b trade off: only their product is determined"


def test_factors_of_a_product_stay_nearest_to_the_scene_s_own_whatever_the_misfit(monkeypatch):
    """Points some deviations off the line: the fitted product is shared out in the ratio of the scene's values."""
    monkeypatch.setattr(import_module("studies.inverse.fitting"), "ranked", lambda *_: [])
    scatter = 0.02 * np.array([1.0, -2.0, 0.5, 1.5, -1.0, 0.7, -0.4])
    data = Measurement(name="m", quantity="velocity", level_key="voltage_V", levels=LEVELS,
                       values=tuple(2.0 * np.array(LEVELS) + scatter), deviations=(0.01,) * 7)  # fmt: skip
    free = tuple(Parameter(key=key, low=0.01, high=100.0) for key in "ab")
    problem = Problem(predictor=Model(lambda x, a, b: a * b * x, a=1.0, b=2.2), parameters=free, measurements=(data,))
    found = fit_about(problem, problem.minima(), problem.points - 2, False, False)
    assert found.chi2 > 10.0
    assert found.values["b"] / found.values["a"] == pytest.approx(2.2, rel=1e-6)


def test_an_end_that_another_number_s_range_makes_is_open(monkeypatch):
    """Told apart by a curvature; downwards the profile of a meets the end of the range of b, upwards it does not."""
    model = Model(lambda x, a, b: a * b * x + 0.05 * b * x**2, a=1.0, b=2.04)
    free = (Parameter(key="a", low=0.01, high=100.0), Parameter(key="b", low=1.6, high=2.05))
    found = explored(model, free, monkeypatch, deviations=(0.01,) * 7)
    wide = (free[0], Parameter(key="b", low=0.02, high=200.0))
    low, high = explored(model, wide, monkeypatch, deviations=(0.01,) * 7).intervals["a"]
    assert found.intervals["a"][0] is None
    assert found.ends["a"][0].because == "b is at the end of its range"
    assert found.intervals["a"][1] == pytest.approx(high, rel=1e-3)
    assert low < 0.99 * 2.04 / 2.05


def test_an_interval_holds_every_minimum_that_the_data_do_not_rule_out(monkeypatch):
    """Y = a^2 x with a of either sign: both minima are as good; a small term tells them apart by less than 3.84."""
    model = Model(lambda x, a: a**2 * x + 1e-3 * a * x, a=1.0)
    found = explored(model, (Parameter(key="a", low=-4.0, high=4.0),), monkeypatch, deviations=(0.01,) * 7)
    low, high = found.intervals["a"]
    assert low < -1.0 < 1.0 < high
    assert [rival["a"] for rival in found.rivals] == [pytest.approx(-1.0, abs=2e-3)]


def test_no_finite_interval_where_nothing_is_told():
    """A column of zeros and two equal columns."""
    slopes = np.outer(np.arange(1.0, 6.0), [3.0, 3.0, 0.0])
    free = tuple(Parameter(key=key, low=0.1, high=10.0) for key in "abc")
    ways = undetermined(slopes, free, np.full(3, math.log(10.0)))
    assert sorted(tuple(way.components) for way in ways) == [("a", "b"), ("c",)]
    assert "c has no effect on these data" in [way.sentence for way in ways]


@pytest.fixture(scope="module")
def curve():
    """A velocity curve of the seed's slider, without noise."""
    levels = tuple(np.linspace(1.5e-9, 2e-8, 8))
    planned = Measurement(name="lab", quantity="velocity", level_key="normal_amplitude_m", levels=levels)
    values = MeasurementPredictor(Scene.load("twente-contact")).predict([(planned, {})])[0]
    return replace(planned, values=tuple(values), deviations=tuple(0.01 * values))


def test_the_contact_s_scaling_law_is_found_and_mass_has_no_effect(curve):
    """Preload and modulus up, friction down by one factor keep mu P, P/E and mu E, and so the averaged motion."""
    free = ["slider.preload=0.2 mN:4 mN", "slider.friction_coefficient=0.02:0.3"]
    free += ["slider.effective_modulus=20 GPa:200 GPa", "slider.mass=0.01 g:1 g"]
    found = fit("twente-contact", [curve], [read_parameter(text) for text in free])
    by_size = {len(way.components): way for way in found.directions}
    assert by_size[1].sentence == "slider.mass has no effect on these data"
    expected = {"slider.preload": 1.0, "slider.friction_coefficient": -1.0, "slider.effective_modulus": 1.0}
    assert by_size[3].components == pytest.approx(expected, abs=1e-3)
    assert by_size[3].exact
    assert set(found.intervals.values()) == {(None, None)}
    assert all(low is None for low, _ in (entry["interval95"] for entry in found.to_dict()["parameters"].values()))


def test_predictions_are_those_of_a_run(curve):
    """A curve, and a burst at its own keys, by the chain's other door."""
    scene = Scene.load("twente-contact").replace(slider={"preload": "1.5 mN"})
    predictor = MeasurementPredictor(Scene.load("twente-contact"))
    numbers = {"slider.preload": 1.5e-3}
    levels = curve.levels[::4]
    record = run(scene.replace(wave={"normal_amplitude": list(levels), "burst": 0.05}), tolerance=1e-4)
    found = predictor.predict([(replace(curve, levels=levels), numbers)])[0]
    assert found == pytest.approx(record.velocity, rel=1e-4)
    level, motion = record.trajectories[-1]
    burst = Measurement(name="b", quantity="burst", level_key="normal_amplitude_m", levels=(level,),
                        time=tuple(motion.time[::100]), settings={"wave.burst": 0.05})  # fmt: skip
    found = predictor.predict([(burst, numbers)])[0]
    assert np.max(np.abs(found - motion.velocity[::100])) < 5e-3 * np.max(motion.velocity)


@pytest.mark.slow
def test_a_burst_on_a_stator_is_that_of_a_run():
    scene = Scene.load("twente-left").replace(
        stator={"length": "30 mm", "thickness": "1 mm", "diffraction": False}, slider={"position": "20 mm"},
        transducer={"left": {"finger_pairs": 2, "center": "6 mm"}}, drive={"voltage": "60 V", "burst": "0.2 ms"},
    )  # fmt: skip
    ((level, motion),) = run(scene, tolerance=1e-2).trajectories
    burst = Measurement(
        name="b", quantity="burst", level_key="voltage_V", levels=(level,), time=tuple(motion.time[1::100])
    )
    (found,) = MeasurementPredictor(scene, tolerance=1e-2).predict([(burst, {})])
    assert np.max(np.abs(found - motion.velocity[1::100])) < 2e-2 * np.max(np.abs(motion.velocity))


@pytest.mark.slow
def test_a_stator_s_amplitude_and_speeds_without_a_sign(tmp_path, capsys):
    """Voltages on the seed's stator: the factor on its amplitude comes back; a motor towards -x measured as speed."""
    true = MeasurementPredictor(Scene.load("twente-left"), tolerance=1e-2)
    volts = (15.0, 25.0, 40.0, 55.0)
    planned = Measurement(name="v", quantity="velocity", level_key="voltage_V", levels=volts)
    speeds = -true.predict([(planned, {"amplitude_factor": 0.8})])[0]
    assert np.all(speeds > 0)
    file = tmp_path / "speeds.csv"
    rows = [f"{v},{s * 1e3},{0.02 * s * 1e3}" for v, s in zip(volts, speeds, strict=True)]
    file.write_text("voltage_V,velocity_mm_per_s,velocity_standard_deviation_mm_per_s\n" + "\n".join(rows) + "\n")
    words = ["fit", "twente-left", "--data", str(file), "--free", "amplitude_factor=0.3:2", "--tolerance", "1e-2"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    whole = json.loads((tmp_path / "out" / "fit.json").read_text())
    entry = whole["parameters"]["amplitude_factor"]
    assert entry["value"] == pytest.approx(0.8, rel=1e-3)
    assert entry["interval95"][0] < 0.8 < entry["interval95"][1]
    assert (tmp_path / "out" / "fit.png").stat().st_size > 10_000
    fitted = Scene.load(tmp_path / "out" / "fitted.toml")
    assert fitted.slider == true.contact({}).scene.slider
    assert "amplitude_factor = 0.8" in (tmp_path / "out" / "fitted.toml").read_text()
    assert "amplitude_factor" in capsys.readouterr().out


def test_the_command_prints_json_in_si_units(tmp_path, capsys, curve):
    file = tmp_path / "lab.csv"
    rows = [f"{a * 1e9},{v}" for a, v in zip(curve.levels, curve.values, strict=True)]
    file.write_text("normal_amplitude_nm,velocity_m_per_s\n" + "\n".join(rows) + "\n")
    free = "slider.damping.tangential=1e-5 N s/m:1e-3 N s/m"
    assert main(["fit", "twente-contact", "--data", str(file), "--free", free, "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert {"parameters", "undetermined", "chi2", "degrees_of_freedom"} <= set(whole)
    assert whole["parameters"]["slider.damping.tangential"]["value"] == pytest.approx(1e-4, rel=1e-4)
    assert whole["degrees_of_freedom"] == len(curve.levels) - 1
    assert not any(tmp_path.glob("results*"))


def test_a_fit_shows_itself_in_the_units_of_its_numbers_and_says_what_it_computes(curve, monkeypatch):
    monkeypatch.setattr("studies.inverse.prediction.time.monotonic", itertools.count(0.0, 2.0).__next__)
    said: list[str] = []
    result = fit("twente-contact", curve, {"slider.preload": (2e-4, 4e-3)}, progress=said.append)
    assert result.best == result.values
    preload = result.best["slider.preload"]
    assert re.match(rf"Fit\(slider.preload = {1e6 * preload:.4g} µN \([\d.]+ to [\d.]+\), chi\^2", repr(result))
    (row,) = (line.split() for line in str(result).splitlines() if line.startswith("slider.preload "))
    assert row[-1] == "µN"
    assert float(row[1]) == pytest.approx(1e6 * preload, rel=1e-4)
    assert "fit: 65 starting points" in said
    assert "fit: 65 starting points: 65 of 65 predictions" in said
    assert any(re.fullmatch(r"fit: least squares: \d+ predictions", each) for each in said)


@pytest.mark.parametrize(
    ("text", "settings", "words"),
    [
        ("time_s,velocity_m_per_s\n0,0\n0,1\n", (), "time must rise"),
        ("force_N,velocity_m_per_s\n0,0\n", (), "must have the columns"),
        ("voltage_V,velocity_m_per_s\n-1,0\n", (), "zero or positive"),
        ("voltage_V,velocity_m_per_s,velocity_standard_deviation_m_per_s\n1,0,0\n", (), "must be positive"),
        ("voltage_V,velocity_m_per_s\n1,0\n", ("slider.preload",), "KEY=VALUE"),
        ("voltage_V,velocity_m_per_s\n1,0\n", ("slider.preload=5 mm",), "must be a force"),
    ],
)
def test_a_file_that_is_no_measurement_is_refused(tmp_path, text, settings, words):
    file = tmp_path / "lab.csv"
    file.write_text(text)
    with pytest.raises(SceneError, match=words):
        read_measurement(file, settings)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("slider.preload", "KEY=LOW:HIGH"),
        ("slider.preload=4 mN:1 mN", "LOW below HIGH"),
        ("slider.law=0:1", "must be a number of a scene"),
        ("slider.preloads=1:2", "is no key of a scene"),
        ("wave.normal_amplitude=1e-9:2e-9", "follows from each measured point"),
        ("friction=0:1", r"did you mean slider\.friction_coefficient\?"),
        ("amplitud=0:1", r"did you mean amplitude_factor\?"),
        ("systematic=0.1:1", "belongs to a measurement"),
        (("slider.preload", 1e-3, 2e-3), "must be KEY=LOW:HIGH or a Parameter"),
        (Parameter(key="slider.preload", low=2e-3, high=1e-3), "LOW below HIGH"),
    ],
)
def test_what_is_no_free_number_is_refused(text, words):
    with pytest.raises(SceneError, match=words):
        read_parameter(text)


def test_a_range_of_a_dict_may_have_units_and_keeps_the_rules_of_a_text():
    preload = Parameter(key="slider.preload", low=1e-3, high=4e-3)
    for span in ("1 mN:4 mN", ("1 mN", "4 mN"), (1e-3, 4e-3), np.array([1e-3, 4e-3])):
        assert as_parameters({"slider.preload": span}) == (preload,)
    with pytest.raises(SceneError, match="LOW below HIGH"):
        as_parameters({"slider.preload": (4e-3, 1e-3)})
    with pytest.raises(SceneError, match="must be KEY=LOW:HIGH"):
        as_parameters({"slider.preload": 1e-3})
    assert as_parameters("slider.preload=1 mN:4 mN") == as_parameters(preload) == (preload,)
    with pytest.raises(SceneError, match="did you mean preload"):
        as_parameters({"slider.prelod": (1e-3, 4e-3)})


def test_a_place_may_be_free():
    assert read_parameter("slider.position=60 mm:80 mm") == Parameter(key="slider.position", low=0.06, high=0.08)


@pytest.mark.parametrize(
    ("free", "words"),
    [
        (["amplitude_factor=0.5:2"], r"needs a \[stator\]"),
        (["slider.mass=1e-5:1e-4", "slider.mass=1e-5:1e-4"], "given twice"),
        ([], "is required"),
        ([f"slider.damping.{name}=1e-5:1e-4" for name in ("normal", "tangential")], "asks for 2 numbers from 1"),
    ],
)
def test_what_cannot_be_fitted_is_refused(curve, free, words):
    one = replace(curve, levels=curve.levels[:1], values=curve.values[:1], deviations=curve.deviations[:1])
    with pytest.raises(SceneError, match=words):
        fit_function("twente-contact", [one], [read_parameter(text) for text in free])


LAB = Measurement(name="lab", quantity="velocity", level_key="normal_amplitude_m", levels=(2e-9, 5e-9, 1e-8, 2e-8),
                  values=(0.0058, 0.0280, 0.0693, 0.1520), deviations=(1e-3,) * 4)  # fmt: skip
RATIO = "wave.tangential_ratio"


def test_parameters_are_as_lmfit_s_users_know_them():
    """The standard error is that of lmfit's own least squares; a number that does not vary keeps its value."""
    lmfit = pytest.importorskip("lmfit")
    free, held = (
        Parameter(key=RATIO, low=0.3, high=1.5),
        Parameter(key="slider.friction_coefficient", low=0.01, high=1.0, value=0.11, vary=False),
    )
    found = fit("twente-contact", LAB, [free, held]).params
    assert (found[RATIO].min, found[RATIO].max, found[RATIO].vary) == (0.3, 1.5, True)
    assert found["slider.friction_coefficient"] is held
    residual = Residual("twente-contact", LAB, [free, held])
    parameters = residual.lmfit_parameters()
    assert list(parameters) == ["wave__tangential_ratio"]
    theirs = lmfit.minimize(residual, parameters, epsfcn=1e-8, scale_covar=False).params["wave__tangential_ratio"]
    assert found[RATIO].value == pytest.approx(theirs.value, rel=1e-4)
    assert found[RATIO].stderr == pytest.approx(theirs.stderr, rel=2e-2)
    parameters.add("slider__friction_coefficient", value=0.11, min=0.01, max=1.0, vary=False)
    ours = fit("twente-contact", LAB, parameters).params
    assert ours[RATIO].value == pytest.approx(found[RATIO].value, rel=1e-6)
    assert ours["slider.friction_coefficient"] == held


def test_a_tied_number_follows_the_others():
    """Preload 0.02 N times friction, by a free name of its own; the truth has both: friction held free gave 0.192."""
    lmfit = pytest.importorskip("lmfit")
    truth = MeasurementPredictor(Scene.load("twente-contact"))
    curve = Measurement(name="m", quantity="velocity", level_key="normal_amplitude_m", levels=(5e-9, 1e-8, 2e-8),
                        values=(1.0,) * 3, deviations=(1e-5,) * 3)  # fmt: skip
    (values,) = truth.predict([(curve, {"slider.friction_coefficient": 0.12, "slider.preload": 2.4e-3})])
    curve = replace(curve, values=tuple(values))
    parameters = lmfit.Parameters()
    parameters.add("mu", 0.08, min=0.05, max=0.6)
    parameters.add("scale", 0.02, vary=False)
    parameters.add("slider__friction_coefficient", expr="mu")
    parameters.add("slider__preload", expr="slider__friction_coefficient * scale", min=1e-4, max=1e-1)
    found = fit("twente-contact", curve, parameters, next_measurements=False)
    assert found.values["mu"] == pytest.approx(0.12, rel=1e-6)
    assert found.values["slider.preload"] == pytest.approx(2.4e-3, rel=1e-6)
    tied = found.params["slider.preload"]
    assert (tied.vary, tied.stderr) == (False, pytest.approx(0.02 * found.params["mu"].stderr, rel=1e-6))
    assert found.to_dict()["tied"]["slider.preload"]["expression"] == "slider__friction_coefficient * scale"
    assert found.scene().slider.preload == pytest.approx(2.4e-3, rel=1e-6)
    assert "slider.preload = 2.4 mN, standard error" in str(found)
    residual = Residual("twente-contact", curve, parameters)
    assert residual.lmfit_parameters()["slider__preload"].expr == "slider__friction_coefficient * scale"
    theirs = lmfit.minimize(residual, residual.lmfit_parameters(), epsfcn=1e-8)
    assert theirs.params["slider__preload"].value == pytest.approx(2.4e-3, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "options", "sentence"),
    [
        ("mu", {"value": 0.1, "min": 0.0, "max": 1.0}, "parameters mu is no key of a scene"),
        ("slider__mas", {"expr": "2 * wave__tangential_ratio"}, r"slider\.mas is no key of a scene; did you mean mass"),
        ("slider__law", {"expr": "2 * wave__tangential_ratio"}, r"parameters slider\.law must be a number of a scene"),
        ("wave__normal_amplitude", {"value": 1e-9, "min": 1e-10, "max": 1e-8}, "follows from each measured point"),
        ("slider__mass", {"value": 1e-4}, r"slider\.mass must have LOW below HIGH, got -inf and inf"),
    ],
)
def test_parameters_of_lmfit_that_are_refused(name, options, sentence):
    lmfit = pytest.importorskip("lmfit")
    parameters = lmfit.Parameters()
    parameters.add("wave__tangential_ratio", 0.7, min=0.3, max=1.5)
    parameters.add(name, **options)
    with pytest.raises(SceneError, match=sentence):
        fit("twente-contact", LAB, parameters)


def test_the_residual_s_derivatives_are_differences_of_it():
    residual = Residual("twente-contact", LAB, {RATIO: (0.3, 1.5), "slider.preload": "0.2 mN:4 mN"})
    at = residual.start * [1.05, 0.9]
    assert residual(dict(zip([each.key for each in residual.parameters], at, strict=True))) == pytest.approx(
        residual(at)
    )
    for k, column in enumerate(residual.jacobian(at).T):
        step = np.zeros(2)
        step[k] = 1e-3 * at[k]
        assert (residual(at + step) - residual(at - step)) / (2e-3 * at[k]) == pytest.approx(column, rel=1e-3)


def test_what_a_fit_does_is_logged(caplog):
    with caplog.at_level("INFO", logger="studies"):
        fit("twente-contact", LAB, {RATIO: (0.3, 1.5)})
    assert "fit: least squares" in [
        each.message for each in caplog.records if each.name == "studies.inverse.prediction"
    ]


def test_a_fit_tells_all_faults_at_once(tmp_path, capsys):
    file = tmp_path / "lab.csv"
    file.write_text("force_N,velocity_m_per_s\n0,0\n")
    words = ["--data", str(file), "--data", str(tmp_path / "none.csv")]
    words += ["--free", "slider.preload=4 mN:1 mN", "speed=1:2"]
    assert main(["fit", "twente-contact", "--set", "slider.mass=-1", *words, "--json"]) == 2
    lines = capsys.readouterr().err.splitlines()
    parts = ("slider.mass", "must have the columns", "none.csv", "--free slider.preload", "--free speed")
    assert len(lines) == len(parts)
    assert all(any(part in line for line in lines) for part in parts)
    with pytest.raises(SceneError) as refused:
        fit("twente-contact", LAB, ["amplitude_factor=0.5:2", "slider.mass=1 mg:1 g", "slider.mass=1 mg:2 g"])
    assert [each.path for each in refused.value.problems] == ["parameters amplitude_factor", "parameters slider.mass"]


def test_an_estimate_at_an_end_of_its_range_is_remarked():
    """The data ask for a ratio of 0.7."""
    assert "best at the upper end of its range, 0.6" in str(fit("twente-contact", LAB, {RATIO: (0.3, 0.6)}))
    assert "end of its range" not in str(fit("twente-contact", LAB, {RATIO: (0.3, 1.5)}))


def test_a_residual_shows_itself():
    residual = Residual("twente-contact", LAB, {RATIO: (0.3, 1.5), "slider.mass": (1e-5, 1e-3)})
    assert repr(residual) == f"Residual(lab (4 values); {RATIO} = 0.3 to 1.5, slider.mass = 10 mg to 1 g)"


def test_a_burst_to_be_measured_next_is_planned_where_the_slider_stands(monkeypatch):
    """On a stator: a burst that is followed along the field takes seconds for each of its derivatives."""

    def followed(*_):
        raise AssertionError("the burst is followed through ring-up and along the field")

    monkeypatch.setattr("studies.solve.stators.Stators.bursting", followed)
    levels = (20.0, 40.0, 60.0)
    values = (0.0107, 0.0353, 0.0598)
    curve = Measurement(
        name="lab", quantity="velocity", level_key="voltage_V", levels=levels, values=values, deviations=(1e-3,) * 3
    )
    free = {"slider.friction_coefficient": (0.02, 0.3), "slider.preload": (2e-4, 4e-3)}
    planned = {each.name: each for each in fit("twente", curve, free).candidates}
    (burst,) = (each for name, each in planned.items() if name.startswith("v(t) of a burst"))
    assert 0.005 < burst.after < 0.5 * burst.before
