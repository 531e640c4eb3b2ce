"""Design search: a brute-force grid, constraints, a search killed and resumed, the front, refusals."""

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

import numpy as np
import pytest

from studies import Scene, run
from studies.__main__ import main
from studies.inverse.free_parameters import Parameter
from studies.inverse.goals import read_constraint, read_variable
from studies.inverse.optimum import Options, design
from studies.inverse.search import REPEATED
from studies.model.resolve import build
from studies.refusal import RunError, SceneError
from studies.sweeps import sweep

RANGES = ("slider.preload=0.4 mN:10 mN", "wave.normal_amplitude=2 nm:30 nm")
VARIABLES = [read_variable(text) for text in RANGES]
LIMIT = "contact_pressure <= 140 MPa"


@pytest.mark.slow
def test_the_optimum_is_that_of_a_brute_force_grid():
    """Largest thrust times nothing else under a pressure limit: the optimum lies on the constraint."""
    side = 50
    grid = sweep(
        "twente-contact",
        {"slider.preload": f"0.4 mN:10 mN:{side}:log", "wave.normal_amplitude": f"2 nm:30 nm:{side}:log"},
        tolerance=3e-2, also=("pressure",),
    ).columns()  # fmt: skip
    velocity, pressure = (np.array(grid["velocity_m_per_s"], float), np.array(grid["contact_pressure_Pa"], float))
    best = int(np.argmax(np.where(pressure <= 140e6, velocity, -1.0)))
    result = design(
        Scene.load("twente-contact"),
        ["velocity"],
        VARIABLES,
        [read_constraint(LIMIT)],
        options=Options(evaluations=120),
    )
    assert len(result.points) <= side**2 / 20
    assert result.optimum["contact_pressure_Pa"] <= 140e6
    for variable in VARIABLES:
        spacing = np.log(variable.high / variable.low) / (side - 1)
        assert abs(np.log(result.optimum[variable.key] / grid[variable.key][best])) < 1.01 * spacing, variable.key
    assert result.optimum["velocity_m_per_s"] > 0.999 * velocity[best]


def test_the_front_holds_both_ends_and_nothing_that_is_beaten():
    goals = ["velocity", "thrust"]
    result = design(
        Scene.load("twente-contact"), goals, VARIABLES, [read_constraint(LIMIT)], options=Options(evaluations=40)
    )
    assert result.rows is result.points  # the former name
    columns = np.array([[point["velocity_m_per_s"], point["thrust_N"]] for point in result.front])
    allowed = [point for point in result.points if point["contact_pressure_Pa"] <= 140e6]
    assert columns[:, 0].max() == max(point["velocity_m_per_s"] for point in allowed)
    assert columns[:, 1].max() == max(point["thrust_N"] for point in allowed)
    for point in allowed:
        beats = (point["velocity_m_per_s"] > columns[:, 0]) & (point["thrust_N"] > columns[:, 1])
        assert not beats.any()
    assert np.all(np.diff(columns[:, 0]) < 0)
    assert np.all(np.diff(columns[:, 1]) > 0)


def test_a_search_that_was_killed_goes_on_and_ends_as_if_it_had_not(tmp_path, capsys):
    words = ["design", "twente-contact", "--maximise", "velocity", "--over", *RANGES, "--subject", LIMIT,
             "--evaluations", "32", "--json"]  # fmt: skip
    assert main([*words, "--out", str(tmp_path / "whole")]) == 0
    whole = json.loads(capsys.readouterr().out)
    # the optimum lies on the constraint, which alone keeps the preload from growing
    assert 0.97 * 140e6 < whole["optimum"]["contact_pressure_Pa"] <= 140e6
    part = tmp_path / "part"
    running = subprocess.Popen(
        [sys.executable, "-m", "studies", *words, "--out", str(part)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
    )  # fmt: skip
    while running.poll() is None and _points(part) < 10:
        time.sleep(0.01)
    running.send_signal(signal.SIGKILL)
    running.communicate()
    before = _points(part)
    assert before >= 8
    assert main([*words, "--out", str(part)]) == 0
    assert json.loads(capsys.readouterr().out) == whole
    assert _points(part) == whole["evaluations"]
    optimum = Scene.load(part / "optimum.toml")
    assert optimum.slider.preload == whole["optimum"]["slider.preload"]
    assert main([*words, "--seed", "1", "--out", str(part)]) == 2
    assert "holds another sweep" in capsys.readouterr().err


def _points(folder) -> int:
    try:
        with closing(sqlite3.connect(f"file:{folder / 'points.sqlite'}?mode=ro", uri=True)) as connection:
            return connection.execute("select count(*) from points").fetchone()[0]
    except sqlite3.Error:
        return 0


@pytest.mark.slow
def test_with_a_stator_the_best_points_of_a_coarse_search_are_evaluated_at_the_tolerance(tmp_path):
    """The optimum is a row at the tolerance, and a sweep of its own gives the same."""
    short = Scene.load("twente-left").replace(
        stator={"length": "30 mm", "thickness": "1 mm", "diffraction": False},
        transducer={"left": {"finger_pairs": 2, "center": "6 mm"}}, slider={"position": "20 mm"},
        drive={"voltage": "60 V"},
    )  # fmt: skip
    variables = [read_variable("stator.thickness=0.9 mm:1.3 mm"), read_variable("slider.preload=0.4 mN:2 mN")]
    options = Options(evaluations=24, out=tmp_path, tolerance=1e-2)
    result = design(short, ["velocity"], variables, [], options=options)
    assert result.optimum["status"] == "ok"
    assert result.optimum["relative_error"] < 1e-2
    coarse = [point for point in result.points if point["relative_error"] > 1e-2]
    assert 10 <= len(coarse) < len(result.points) - REPEATED
    keys = [each.key for each in variables]
    same = sweep(short, {key: [result.optimum[key]] for key in keys}, tolerance=1e-2).columns()
    assert same["velocity_m_per_s"][0] == pytest.approx(result.optimum["velocity_m_per_s"], rel=1e-12)
    best = max(abs(point["velocity_m_per_s"]) for point in result.points if point["status"] == "ok")
    assert abs(result.optimum["velocity_m_per_s"]) == best
    assert design(short, ["velocity"], variables, [], options=options).to_dict() == result.to_dict()


def test_constraints_that_nothing_keeps_are_named():
    with pytest.raises(RunError, match="contact_pressure <= 1 MPa is broken"):
        design(Scene.load("twente-contact"), ["velocity"], VARIABLES, [read_constraint("contact_pressure <= 1 MPa")],
               options=Options(evaluations=16))  # fmt: skip


def test_the_least_amplitude_for_a_velocity_is_that_of_the_velocity_curve(tmp_path):
    """The curve rises with the amplitude: the least that reaches 30 mm/s is where it passes 30 mm/s."""
    key = "wave.normal_amplitude"
    words = ["--minimise", key, "--over", f"{key}=2 nm:30 nm", "--subject", "velocity >= 30 mm/s"]
    assert main(["design", "twente-contact", *words, "--evaluations", "24", "--out", str(tmp_path / "least")]) == 0
    whole = json.loads((tmp_path / "least" / "design.json").read_text())
    assert whole["goals"] == [f"least {key}"]
    assert 0.03 <= whole["optimum"]["velocity_m_per_s"] < 0.0301
    assert whole["robustness"][key] == {"least_share_of_goal": pytest.approx(1 / 1.05), "keeps_constraints": False}
    assert f"# least {key} of" in (tmp_path / "least" / "optimum.toml").read_text()
    with pytest.raises(SceneError, match=r"minimise slider\.mass must be of power_W, .*, slider\.pre"):
        design(Scene.load("twente-contact"), ["least slider.mass"], VARIABLES)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("contact_pressure < 4 MPa", "NAME <= VALUE"),
        ("pressure <= 4 MPa", "did you mean contact_pressure"),
        ("contact_pressure <= 4 mm", "a stiffness"),
        ("drive.voltag <= 4 V", "is no key of a scene"),
    ],
)
def test_what_is_no_constraint_is_refused(text, words):
    with pytest.raises(SceneError, match=words):
        read_constraint(text)


def test_goals_and_counts_that_do_not_exist_are_refused():
    scene = Scene.load("twente-contact")
    with pytest.raises(SceneError, match=r"goals speed is none of velocity, .*; did you mean velocity"):
        design(scene, ["speed"], VARIABLES)
    with pytest.raises(SceneError, match="goals must be one or two different ones of velocity"):
        design(scene, ["velocity", "velocity"], VARIABLES)
    for goal in ("velocity", "mean_velocity", "thrust"):
        with pytest.raises(SceneError, match=f"goals {goal} is zero for a slider on an axle"):
            design(Scene.load("rotor"), [goal], ["slider.preload=5 mN:50 mN"])
    with pytest.raises(SceneError, match="whole numbers"):
        read_variable("transducer.0.finger_pairs=2.5:10")
    assert read_variable("transducer.0.finger_pairs=5:12").low == 5
    assert read_variable("drive.voltage=5 V:100 V").high == 100.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"minimise": "power_W"}, "minimise power_W is neither varied nor an outcome"),
        ({"goals": "power_W"}, "goals power_W can only be minimised"),
        ({"goals": "velocity", "constraints": "slider.mass <= 1 g"}, "constraints slider.mass is neither varied nor"),
        ({"goals": "velocity", "variables": "friction=0.1:0.2"}, r"did you mean slider\.friction_coefficient"),
        ({"goals": "velocity", "variables": Parameter(key="slider.mass", low=2.0, high=1.0)}, "LOW below HIGH"),
    ],
)
def test_what_no_evaluation_could_answer_is_refused_before_the_search(arguments, words):
    with pytest.raises(SceneError, match=words):
        design("twente-contact", **{"variables": "slider.preload=1 mN:4 mN"} | arguments)


def test_a_goal_without_an_answer_in_the_plane_is_refused_by_its_own_name():
    """The refusal named an option of sweeps."""
    with pytest.raises(SceneError, match="goals efficiency is neither varied nor an outcome of this scene"):
        design("twente-planar", "efficiency", "slider.mass=1e-4:5e-4")


def test_a_goal_that_is_zero_everywhere_is_no_optimum():
    """All amplitudes lie below the threshold."""
    with pytest.raises(RunError, match="has a velocity other than 0"):
        design("twente-contact", "velocity", {"wave.normal_amplitude": ("0.1 nm", "0.2 nm")},
               options=Options(evaluations=12))  # fmt: skip


def test_evaluations_without_an_answer_say_why():
    """The mesh of the grooves is 2 mm high."""
    with pytest.raises(RunError, match=r"evaluations has an answer; the first one: refused: piece\.0 .* 2 mm high"):
        design("reflector", "velocity", {"stator.thickness": ("1 mm", "1.5 mm")}, options=Options(evaluations=12))


def test_a_best_value_at_an_end_of_its_range_is_remarked():
    """Velocity rises with the amplitude, without end: the best is the largest that the range allows."""
    key = "wave.normal_amplitude"
    best = design("twente-contact", "velocity", {key: ("2 nm", "10 nm")}, options=Options(evaluations=16))
    assert f"{key} is best at the upper end of its range, 10 nm" in str(best)
    assert best.to_dict()["at_end_of_range"] == {key: "upper"}
    inside = design("twente-contact", variables={key: "2 nm:30 nm"}, constraints=["velocity >= 30 mm/s"], minimise=key,
                    options=Options(evaluations=24))  # fmt: skip
    assert inside.goals == (f"least {key}",)
    assert "at_end_of_range" not in inside.to_dict()
    assert "end of its range" not in str(inside)


def test_a_count_is_at_an_end_of_its_range_only_there():
    pairs = read_variable("transducer.0.finger_pairs=5:500")
    assert [pairs.end_reached(value, 0.1) for value in (5, 6, 499, 500)] == ["lower", None, None, "upper"]


def test_a_design_tells_all_faults_at_once():
    with pytest.raises(SceneError) as refused:
        design("twente-contact", "velocity", {"slider.mas": "1 mg:1 g", "slider.preload": "4 mN:1 mN"}, ["speed <= 3"])
    assert [each.path for each in refused.value.problems] == [
        "slider.mas", "variables slider.preload", "constraints speed"
    ]  # fmt: skip


def test_a_position_is_off_by_a_share_of_a_wavelength(small):
    """Property: what is left is that of positions 5 % of a wavelength to either side, whatever the origin."""
    one = small.replace(drive={"voltage": ["120 V"]})
    found = design(
        one, "velocity", {"slider.position": (8.6e-3, 9.4e-3)}, options=Options(evaluations=14, tolerance=0.1)
    )
    best, length = found.optimum["slider.position"], build(one).wavelength
    speeds = [
        abs(run(one.replace(slider={"position": best + shift * length}), tolerance=1e-2).velocity[0])
        for shift in (0.0, -0.05, 0.05)
    ]
    left = found.robustness["slider.position"]["least_share_of_goal"]
    assert left == pytest.approx(min(speeds[1:]) / speeds[0], rel=5e-3)
    assert left < 0.98
    head, row = str(found).splitlines()[:2]
    assert re.split(r"  +", head.strip()) == ["variable", "best", "if changed by", "goal left", "constraints"]
    assert re.split(r"  +", row.strip())[2:] == ["5 % of a wavelength", f"{100 * left:.4g} % or more", "all kept"]
