"""Sweeps: designs, rows that are runs, reasons, one stator for many points, and stores that survive."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import threadpoolctl

import contact
import fem
from studies.__main__ import main
from studies.refusal import RunError, SceneError
from studies.report.explanation import long_sweep
from studies.runs import run
from studies.scene import Scene, read_table
from studies.scene.override import replaced
from studies.solve import requested_quantities, stators
from studies.solve.predictor import Predictor
from studies.solve.stators import Shared
from studies.sweeps import driver, store, sweep
from studies.sweeps.axes import axis
from studies.sweeps.plan import designed
from studies.sweeps.store import FILE, Store
from studies.sweeps.workers import ONE_THREAD, Processes, Workers
from tests.seed_motor import MASS, SCENE_SLIDER

OVER = {"slider.preload": "0.1 mN:10 mN:8:log", "wave.normal_amplitude": "0.5 nm:20 nm:6"}
SMALL = {
    "stator": {"material": "PZT-8", "length": 12e-3, "thickness": 0.7e-3, "width": 0.025, "ends": "absorbing"},
    "transducer": [
        {"name": "left", "center": 3e-3, "finger_pairs": 2, "period": 0.98e-3, "metallisation": 0.5, "aperture": 0.02}
    ],
    "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [30.0]},
    "slider": SCENE_SLIDER | {"position": 7e-3},
}  # fmt: skip


PLANE = SMALL | {"stator": SMALL["stator"] | {"diffraction": False}}


@pytest.fixture(scope="module")
def whole():
    """The small sweep, undisturbed and in memory."""
    return sweep("twente-contact", OVER).columns()


def command(*words, **options):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, "-m", "studies", "sweep", *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, **options,
    )  # fmt: skip


def rows(folder):
    with closing(sqlite3.connect(folder / FILE)) as connection, connection:
        found = connection.execute("select * from points order by point").fetchall()
    connection.close()
    return found


def seen(folder):
    """Return the rows that stand while another process is at work."""
    try:
        return rows(folder) if (folder / FILE).exists() else []
    except sqlite3.OperationalError:
        return []  # its tables are not there yet


# --- designs


@pytest.mark.parametrize(
    ("key", "text", "values"),
    [
        ("slider.preload", "1 mN:5 mN:3", [1e-3, 3e-3, 5e-3]),
        ("slider.preload", "1e-3:0.1:3:log", [1e-3, 1e-2, 0.1]),
        ("slider.preload", "5 mN, 0.01", [5e-3, 0.01]),
        ("slider.preload", "weight,1 mN", ["weight", 1e-3]),
        ("drive.voltage", "5:10:2", [5.0, 10.0]),
        ("slider.contacts", "1, 3", [1, 3]),
        ("slider.contacts", "[1, ['-1 mm', '1 mm']]", [1, (-1e-3, 1e-3)]),
        ("transducer.1.finger_pairs", "5:20:4", [5, 10, 15, 20]),
        ("slider.reciprocal", "true,false", [True, False]),
        ("stator.material", "PZT-8,PIC181", ["PZT-8", "PIC181"]),
        ("slider.damping.normal", np.array([0.1, 0.5]), [0.1, 0.5]),
    ],
)
def test_values_of_an_axis(key, text, values):
    found = axis(key, text).columns[0]
    assert [type(each) for each in found] == [type(each) for each in values]
    assert found == [pytest.approx(each, rel=1e-15) if isinstance(each, float) else each for each in values]


@pytest.mark.parametrize(
    ("over", "options", "sentence"),
    [
        ({"slider.prelod": "1:2:3"}, {}, "did you mean preload"),
        ({"slider": "1"}, {}, "is a block"),
        ({"transducer.name": "a"}, {}, "say which one"),
        ({"slider.preload": "1:2"}, {}, "must be START:STOP:N"),
        ({"slider.preload": "5:40 mN:3"}, {}, "must have a unit at both ends or at neither, got '5:40 mN:3'"),
        ({"slider.preload": "1:2:0"}, {}, "1 to"),
        ({"slider.preload": "0:2:5:log"}, {}, "above 0"),
        ({"slider.preload": "1 kg:2 kg:5"}, {}, "a force"),
        ({"stator.material": "1:2:5"}, {}, "takes words"),
        ({"slider.contacts": "1:2:5"}, {}, "whole numbers"),
        ({"slider.preload": "1:2:3"}, {"also": ("speed",)}, "also"),
        ([{"slider.preload": "1:2:3"}, {"slider.preload": [1.0]}], {}, "twice"),
    ],
)  # fmt: skip
def test_what_is_wrong_whatever_the_point_is_refused(over, options, sentence):
    with pytest.raises(SceneError, match=sentence):
        sweep("twente-contact", over, **options)


def test_a_rule_that_every_point_breaks_is_refused_once():
    with pytest.raises(SceneError, match=r"slider\.mass must be positive"):
        sweep(replaced(Scene.load("twente-contact").to_table(), "slider.mass", -1.0), OVER)


def test_axes_multiply_and_a_table_of_points_is_one_axis(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("slider.radius,slider.mass\n1 mm,0.1 g\n0.002,2e-4\n")
    found = sweep("twente-contact", [file, {"wave.normal_amplitude": "3 nm"}]).columns()
    assert found["slider.radius"] == [1e-3, 2e-3]
    assert found["slider.mass"] == [1e-4, 2e-4]
    assert found["wave.normal_amplitude"] == [3e-9, 3e-9]
    design = designed(SMALL, {"slider.radius": "1:2:3", "slider.mass": "1:2:2"}, tolerance=1e-3)
    assert len(design) == 6
    assert design.values(np.array([0, 1, 5])) == [(1.0, 1.0, 30.0), (1.0, 2.0, 30.0), (2.0, 2.0, 30.0)]


# --- rows


def test_a_row_is_what_a_run_of_its_scene_finds(whole):
    table = Scene.load("twente-contact").to_table()
    for point in (5, 22, 40):
        here = table
        for key in OVER:
            here = replaced(here, key, whole[key][point])
        (expected,) = run(Scene.from_table("", here), tolerance=1e-3).points
        speed = max(abs(expected["velocity_m_per_s"]), 2 * np.pi * 2.2e6 * whole["tangential_amplitude_m"][point] / 10)
        allowed = 2 * (expected["relative_error"] + whole["relative_error"][point]) * speed + 1e-12
        assert abs(whole["velocity_m_per_s"][point] - expected["velocity_m_per_s"]) <= allowed
        assert (whole["regime"][point], whole["status"][point]) == (expected["regime"], "ok")


@pytest.mark.parametrize(
    "over",
    [
        {"slider.reciprocal": "true"},
        {"slider.method": "exact"},
        pytest.param({"wave.burst": "5e-4", "slider.law": "hysteretic"}, marks=pytest.mark.slow),
    ],
)
def test_what_the_loop_does_not_know_is_solved_as_in_a_run(over):
    over = over | {"wave.normal_amplitude": "3 nm"}
    found = sweep("twente-contact", over).columns()
    table = Scene.load("twente-contact").to_table()
    for key, text in over.items():
        table = replaced(table, key, axis(key, text).columns[0][0])
    (expected,) = run(Scene.from_table("", table), tolerance=1e-3).points
    shared = [key for key in expected if key in found]
    assert {"normal_amplitude_m", "velocity_m_per_s", "regime", "relative_error", "status"} <= set(shared)
    assert {key: found[key][0] for key in shared} == {key: expected[key] for key in shared}


def test_every_bad_point_is_a_row_with_its_reason():
    preloads = [1e-3 * (-1) ** (k % 10 == 3) for k in range(40)] + [float("nan"), "heavy", "3 kg"]
    found = sweep("twente-contact", {"slider.preload": preloads, "wave.normal_amplitude": "3 nm"}).columns()
    bad = [status for status in found["status"] if status != "ok"]
    assert len(bad) == 4 + 3
    assert [status == "ok" for status in found["status"][:40]] == [k % 10 != 3 for k in range(40)]
    assert set(bad[:4]) == {"refused: slider.preload must be zero or positive, got -0.001 N"}
    assert "nan" in bad[4]
    assert "'heavy'" in bad[5]
    assert "a mass" in bad[6]
    assert all(found["velocity_m_per_s"][k] is None for k in (3, 13, 40, 41, 42))


def counted(monkeypatch):
    """Return a list that fills with frequency and tolerance of every stator that is solved."""
    solved, solve = [], stators.solved_motion

    def noted(model, *rest, tolerance, **options):
        solved.append((model.scene.frequency, tolerance))
        return solve(model, *rest, tolerance=tolerance, **options)

    monkeypatch.setattr(stators, "solved_motion", noted)
    return solved


def test_the_stator_is_solved_once_for_each_frequency_and_geometry(tmp_path, monkeypatch):
    over = {
        "slider.position": [6.5e-3, 7e-3, 1.0], "slider.preload": "1 mN:5 mN:2", "slider.radius": "1 mm:2 mm:2",
        "drive.frequency": "2.19 MHz, 2.2 MHz", "drive.voltage": "20:60:2",
    }  # fmt: skip
    solved = counted(monkeypatch)
    found = sweep(SMALL, over, tolerance=1e-2, also=("limits", "thrust", "efficiency"), out=tmp_path / "s")
    assert [frequency for frequency, _ in solved] == [2.19e6, 2.2e6]
    columns = found.columns()
    assert found.counts["refused"] == 16
    assert "contacts on the stator" in next(s for s in columns["status"] if s.startswith("refused"))
    point = next(k for k in range(len(columns["point"]) - 1, 0, -1) if columns["status"][k] == "ok")
    table = SMALL
    for key in over:
        table = replaced(table, key, columns[key][point])
    record = run(Scene.from_table("", table), tolerance=1e-2)
    expected = record.points[0]
    error = 2 * (expected["relative_error"] + columns["relative_error"][point])
    assert columns["velocity_m_per_s"][point] == pytest.approx(expected["velocity_m_per_s"], rel=error, abs=0)
    assert columns["threshold_factor"][point] == pytest.approx(
        record.summary["threshold_voltage_V"] / columns["drive.voltage"][point], rel=error, abs=0
    )
    power = record.electrical["power_W_per_V2"] * columns["drive.voltage"][point] ** 2
    assert columns["power_W"][point] == pytest.approx(power, rel=1e-2, abs=0)
    assert 0 < columns["motor_efficiency"][point] < columns["contact_efficiency"][point] < 1
    assert 0 < columns["thrust_N"][point] < 0.08 * columns["slider.preload"][point]


def test_many_frequencies_of_a_plane_section_are_a_band():
    """A band gives what a run gives at each frequency by itself."""
    found = sweep(PLANE, {"drive.frequency": "2.17 MHz:2.22 MHz:6", "slider.position": [6.5e-3, 7e-3]}, tolerance=2e-2)
    assert found.counts == {"ok": 12}
    columns = found.columns()
    table = PLANE
    for key in ("drive.frequency", "slider.position"):
        table = replaced(table, key, columns[key][5])
    (expected,) = run(Scene.from_table("", table), tolerance=2e-2).points
    error = 2 * (expected["relative_error"] + columns["relative_error"][5])
    assert columns["velocity_m_per_s"][5] == pytest.approx(expected["velocity_m_per_s"], rel=error, abs=0)


@pytest.mark.parametrize("contacts", [1, pytest.param([[-4e-4, 0.0], [2e-4, 1e-3]], marks=pytest.mark.slow)])
def test_many_frequencies_of_finite_apertures_are_a_band(monkeypatch, contacts):
    """A band of beams gives what a run gives at each frequency by itself, also under unequal balls off the axis."""
    table = replaced(SMALL, "slider.contacts", contacts)
    monkeypatch.setattr("fem.driven_wave", None)  # no frequency is solved alone
    found = sweep(table, {"drive.frequency": "2.17 MHz:2.22 MHz:8"}, tolerance=2e-2)
    monkeypatch.undo()
    assert found.counts == {"ok": 8}
    columns = found.columns()
    for point in (1, 6):
        one = replaced(table, "drive.frequency", columns["drive.frequency"][point])
        (expected,) = run(Scene.from_table("", one), tolerance=2e-2).points
        error = 2 * (expected["relative_error"] + columns["relative_error"][point])
        assert columns["velocity_m_per_s"][point] == pytest.approx(expected["velocity_m_per_s"], rel=error, abs=0)


def test_bands_that_fail_leave_each_frequency_to_be_solved_alone(monkeypatch):
    tried = []

    def failing(*given, **options):
        tried.append(given)
        raise fem.ConvergenceError("the motion of the band's beams is known to 2 only")

    monkeypatch.setattr("fem.beam_band", failing)
    over = {"drive.frequency": "2.17 MHz:2.22 MHz:12", "slider.preload": [1e-3, 2e-3]}
    found = sweep(SMALL, over, tolerance=0.1)
    assert len(tried) == 1
    assert found.counts == {"ok": 24}


def test_a_stator_without_an_answer_costs_its_own_points_alone(monkeypatch):
    solved = fem.driven_wave

    def failing(*given, frequency, **options):
        if frequency > 2.195e6:
            raise (fem.ConvergenceError("its error stays large") if frequency < 2.205e6 else ZeroDivisionError("0/0"))
        return solved(*given, frequency=frequency, **options)

    monkeypatch.setattr(fem, "driven_wave", failing)
    over = {"drive.frequency": "2.19 MHz,2.2 MHz,2.21 MHz", "slider.mass": "1e-4,-1"}
    found = sweep(SMALL, over, tolerance=1e-2).columns()["status"]
    assert found[::2] == [
        "ok", "no answer: its error stays large", "no answer: a defect of sawmotor: ZeroDivisionError: 0/0",
    ]  # fmt: skip
    assert all(status.startswith("refused: slider.mass") for status in found[1::2])


@pytest.mark.parametrize(("wanted", "threads"), [("1", 1), ("3", 3), ("0", None), ("", None), ("all", None)])
def test_the_loop_of_averaged_states_takes_the_threads_of_its_process(monkeypatch, wanted, threads):
    solved, taken = contact.steady_sweep, []

    def noted(*problem, threads, **options):
        taken.append(threads)
        return solved(*problem, threads=threads, **options)

    monkeypatch.setattr(contact, "steady_sweep", noted)
    monkeypatch.setenv("SAWMOTOR_THREADS", wanted)
    Predictor(read_table("twente-contact"), tolerance=1e-2).answers([{"wave.normal_amplitude": 3e-9}], quick=True)
    assert taken == [threads]


def test_a_point_where_the_beam_is_not_resolved_has_no_answer_as_a_run_has_none(monkeypatch):
    spread = replaced(SMALL, "stator.diffraction", True)
    monkeypatch.setattr("fem.SurfaceBeam.unresolved", lambda self, x, y: x == 7e-3)
    record = run(Scene.from_table("", spread), tolerance=0.1)
    (answer,) = Predictor(spread, tolerance=0.1).answers([{"drive.voltage": 30.0}])
    assert answer.point.status == record.shortfall
    assert record.shortfall.startswith("no answer: in this cut the field beside the fingers")


def test_a_point_near_the_threshold_gets_a_better_stator(tmp_path, monkeypatch):
    # a stator that is just good enough by itself
    monkeypatch.setattr("studies.solve.stators.SHARE", 1.0)
    solved = counted(monkeypatch)
    voltages = [5.0, 11.2, 40.0]
    found = sweep(PLANE, {"drive.voltage": voltages}, tolerance=2.5e-4, out=tmp_path / "s")
    columns = found.columns()
    assert [tolerance for _, tolerance in solved] == pytest.approx([2.5e-4, 0.25 * 2.5e-4 / 8])
    assert columns["status"] == ["ok"] * 3
    assert columns["relative_error"][1] < 2.5e-4
    # which stator a point uses is its own matter: alone it has the same row
    alone = sweep(PLANE, {"drive.voltage": [voltages[1]]}, tolerance=2.5e-4).columns()
    assert columns["velocity_m_per_s"][1] == alone["velocity_m_per_s"][0]
    amplitudes = np.array(columns["normal_amplitude_m"]) / voltages
    assert amplitudes[0] != amplitudes[1]


# --- the predictor


def test_a_stator_is_solved_for_each_change_that_concerns_it_and_for_no_other(monkeypatch):
    solved, motors = counted(monkeypatch), Predictor(PLANE, tolerance=3e-2, coarse=True)
    own = motors.contact({})
    for changes in ({"slider.mass": 1e-4}, {"drive.voltage": 50.0}, {"slider.preload": 2e-3}, {}):
        other = motors.contact(changes)
        assert other.solved is own.solved
        assert (other.slider == own.slider) == (not any("slider" in key for key in changes))
    assert len(solved) == 1
    thick = motors.contact({"stator.thickness": 0.8e-3})
    assert len(solved) == 2
    assert thick.amplitude != own.amplitude
    assert motors.contact({"stator.thickness": 0.8e-3, "slider.radius": 2e-3}).orbits == thick.orbits
    assert len(solved) == 2
    moved = motors.contact({"slider.position": 6.5e-3})
    assert moved.solved.admittance == pytest.approx(own.solved.admittance, rel=0.05)
    assert len(solved) == 3


def test_what_has_no_answer_is_said_each_time_and_tried_once(monkeypatch):
    def failing(*given, **options):
        tried.append(given)
        raise RunError("its error stays large")

    tried, motors = [], Predictor(PLANE, tolerance=3e-2, coarse=True)
    monkeypatch.setattr(stators, "solved_motion", failing)
    for _ in range(2):
        with pytest.raises(RunError, match="stays large"):
            motors.contact({"slider.mass": 1e-4})
    assert len(tried) == 1
    with pytest.raises(SceneError, match=r"slider\.mass must be positive"):
        motors.contact({"slider.mass": -1.0})


def test_a_stator_that_memory_has_ended_is_solved_when_it_is_needed_again(monkeypatch):
    solved, tried, motors = stators.solved_motion, [], Predictor(PLANE, tolerance=3e-2, coarse=True)

    def failing_once(*given, **options):
        tried.append(given)
        if len(tried) == 1:
            raise MemoryError
        return solved(*given, **options)

    monkeypatch.setattr(stators, "solved_motion", failing_once)
    with pytest.raises(MemoryError):
        motors.contact({})
    assert motors.contact({}).amplitude > 0.0
    assert len(tried) == 2


def test_a_band_that_memory_has_ended_is_tried_again_and_one_without_an_answer_is_not(monkeypatch):
    outcomes = [MemoryError(), RunError("its error stays large")]  # what is raised by each setup

    def failing(*given, **options):
        raise outcomes.pop(0)

    monkeypatch.setattr(stators, "motion_bands", failing)
    model = Predictor(PLANE, tolerance=1e-2).scenes.model({})
    of_band = stators.Stators(tolerance=1e-2, slider=True, shared=Shared(limits=(2.1e6, 2.3e6), frequencies=20))
    with pytest.raises(MemoryError):
        of_band.solve_together([(model, None)])
    assert len(outcomes) == 1
    for _ in range(2):  # each frequency is left to be solved alone
        of_band.solve_together([(model, None)])
    assert not outcomes


# --- stores


def test_batches_and_interruptions_change_nothing(whole, tmp_path, monkeypatch):
    def stop(count, kept, failed, cost):
        if kept > 20:
            raise KeyboardInterrupt

    monkeypatch.setattr(driver, "MAX_BATCH_POINTS", 3)
    with pytest.raises(RunError, match=r"interrupted: \d+ of 48 points are kept and the same command"):
        sweep("twente-contact", OVER, out=tmp_path / "s", progress=stop)
    before = rows(tmp_path / "s")
    assert 20 < len(before) < 48
    found = sweep("twente-contact", OVER, out=tmp_path / "s")
    assert found.columns() == whole
    assert rows(tmp_path / "s")[: len(before)] == before
    assert found.counts == {"ok": 48}
    with closing(sqlite3.connect(found.path)) as connection:
        computed = connection.execute("select sum(points) from batches").fetchone()[0]
    assert computed == 48  # what was there is not computed again


def test_another_sweep_in_the_same_place_is_refused(tmp_path):
    small = {"wave.normal_amplitude": "3 nm"}
    sweep("twente-contact", small, out=tmp_path / "s")
    kept = rows(tmp_path / "s")
    for over, options, what in (
        ({"wave.normal_amplitude": "4 nm"}, {}, r"axis wave\.normal_amplitude"),
        (small, {"tolerance": 1e-2}, "tolerance"),
        (small, {"also": ("limits",)}, "also"),
    ):
        with pytest.raises(SceneError, match=f"another sweep: its {what} differs"):
            sweep("twente-contact", over, out=tmp_path / "s", **options)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("all of it")
    with pytest.raises(SceneError, match="no sweep"):
        sweep("twente-contact", small, out=tmp_path / "mine")
    assert rows(tmp_path / "s") == kept


def test_a_second_driver_is_refused_while_the_first_lives(tmp_path):
    design = designed(Scene.load("twente-contact").to_table(), OVER, tolerance=1e-3)
    words = [part for key, text in OVER.items() for part in ("--over", f"{key}={text}")]
    with closing(Store(tmp_path / "s", design)):
        with pytest.raises(RunError, match=f"another sweep, process {os.getpid()} on .*, is writing"):
            sweep("twente-contact", OVER, out=tmp_path / "s")
        second = command("twente-contact", *words, "--out", str(tmp_path / "s"))
        out, err = second.communicate(timeout=60)
        assert (second.returncode, out) == (3, "")
        assert "is writing into" in err
        assert err.count("\n") == 1
    assert rows(tmp_path / "s") == []
    assert sweep("twente-contact", OVER, out=tmp_path / "s").counts == {"ok": 48}


def test_a_driver_that_is_killed_loses_nothing_that_it_reported(tmp_path):
    over = {"slider.preload": "0.1 mN:10 mN:60:log", "wave.normal_amplitude": "0.5 nm:20 nm:50:log"}
    words = [part for key, text in over.items() for part in ("--over", f"{key}={text}")]
    process = command("twente-contact", *words, "--out", str(tmp_path / "s"))
    reported = []
    while process.poll() is None and len(reported) < 50:
        time.sleep(0.02)
        reported = seen(tmp_path / "s")
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert 0 < len(reported) < 3000
    assert rows(tmp_path / "s")[: len(reported)] == reported
    found = sweep("twente-contact", over, out=tmp_path / "s")
    assert found.counts == {"ok": 3000}
    assert rows(tmp_path / "s")[: len(reported)] == reported


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="this system has no limit of file sizes")
def test_a_full_disk_is_said_and_costs_nothing_that_was_kept(tmp_path):
    import resource

    over = {"slider.preload": "0.1 mN:10 mN:40:log", "wave.normal_amplitude": "0.5 nm:20 nm:50:log"}
    words = [part for key, text in over.items() for part in ("--over", f"{key}={text}")]
    process = command(
        "twente-contact", *words, "--out", str(tmp_path / "s"),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000)),
    )  # fmt: skip
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (3, "")
    assert "is the disk full?" in err.splitlines()[-1]
    assert "Traceback" not in err
    kept = rows(tmp_path / "s")
    assert 0 < len(kept) < 2000
    found = sweep("twente-contact", over, out=tmp_path / "s")
    columns = found.columns()
    assert found.counts == {"ok": 2000}
    assert [row[3:] for row in kept] == [tuple(columns[name][row[0]] for name in list(columns)[3:]) for row in kept]


class Poisoned(Workers):
    """Workers that a certain point kills."""

    lost = (BrokenProcessPool,)
    renewed = 0

    def submit(self, work, question, points, *rest):
        if 17 in points:
            future = Future()
            future.set_exception(BrokenProcessPool("a worker vanished"))
            return future
        return super().submit(work, question, points, *rest)

    def renew(self):
        self.renewed += 1


def test_a_point_that_kills_its_workers_is_a_row_and_is_tried_again(whole, tmp_path, monkeypatch):
    staff = Poisoned()
    monkeypatch.setattr("studies.sweeps.start_workers", lambda number: staff)
    found = sweep("twente-contact", OVER, out=tmp_path / "s")
    assert found.counts == {"ok": 47, "lost": 1}
    assert found.columns()["status"][17] == "lost: 3 workers that computed it vanished"
    assert staff.renewed >= 3
    monkeypatch.undo()
    assert sweep("twente-contact", OVER, out=tmp_path / "s").columns() == whole


@pytest.mark.slow
def test_processes_give_the_same_bits_and_may_vanish(whole):
    import multiprocessing

    killed = []

    def kill(count, kept, failed, cost):
        children = multiprocessing.active_children()
        if children and len(killed) < 2:
            killed.append(children[0].pid)
            os.kill(children[0].pid, signal.SIGKILL)

    found = sweep("twente-contact", OVER, workers=2, progress=kill)
    assert found.columns() == whole
    assert killed


@pytest.mark.slow
def test_processes_that_do_not_start_are_said_to(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text(
        "from studies.sweeps import sweep\nsweep('twente-contact', {'slider.radius': [1e-3]}, workers=2)\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, env=environment, timeout=100)
    assert "RunError: the worker processes do not start" in done.stderr


@pytest.mark.slow
def test_an_interrupt_from_the_terminal_stops_processes_and_keeps_points(tmp_path):
    # so many points that no machine is done with them before the interrupt
    over = {"slider.preload": "0.1 mN:10 mN:1000:log", "wave.normal_amplitude": "0.5 nm:20 nm:1000:log"}
    words = [part for key, text in over.items() for part in ("--over", f"{key}={text}")]
    process = command(
        "twente-contact", *words, "--workers", "2", "--out", str(tmp_path / "s"), start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background job ignores it
    )  # fmt: skip
    while not seen(tmp_path / "s"):
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "points are kept and the same command goes on" in err.splitlines()[-1]
    assert "Traceback" not in err
    assert 0 < len(rows(tmp_path / "s")) < 1_000_000


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="reads the signal mask of another process")
def test_a_worker_starts_deaf_to_interrupts():
    with closing(Processes(1)) as staff:
        pid = staff.submit(os.getpid).result()
        masks = dict(line.split(":") for line in Path(f"/proc/{pid}/status").read_text().splitlines())
    assert int(masks["SigBlk"], 16) & 1 << signal.SIGINT - 1  # held back by who started it, from its first instruction
    assert int(masks["SigIgn"], 16) & 1 << signal.SIGINT - 1
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_a_worker_has_one_blas_thread_and_the_environment_stays(monkeypatch):
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)
    with closing(Processes(1)) as staff:
        libraries = staff.submit(threadpoolctl.threadpool_info).result()
    threads = [each["num_threads"] for each in libraries if each["user_api"] == "blas"]
    assert threads
    assert set(threads) == {1}
    assert not set(ONE_THREAD) & set(os.environ)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_bits(whole, tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask is optional")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        found = sweep("twente-contact", OVER, workers=cluster.scheduler_address)
    assert found.columns() == whole


def test_the_command_prints_json_and_says_what_is_not_ok(tmp_path):
    points = tmp_path / "points.csv"
    points.write_text("slider.preload\n-1 mN\n1 mN\n")
    process = command(
        "twente-contact", "--points", str(points), "--over", "wave.normal_amplitude=3 nm", "--json",
        "--out", str(tmp_path / "s"),
    )  # fmt: skip
    out, err = process.communicate(timeout=60)
    answer = json.loads(out)
    assert process.returncode == 1
    assert answer["counts"] == {"ok": 1, "refused": 1}
    assert answer["reasons"][0]["status"] == "refused: slider.preload must be zero or positive, got -0.001 N"
    assert "1 of 2 points have no answer within the tolerance; point 0: refused" in err


def test_the_command_refuses_bad_values_of_its_axes_before_it_computes_any(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(Store, "__init__", None)  # no point is begun
    axes = ["--over", "slider.mass=0.1 g:-0.1 g:3", "--over", "slider.law=elastic,plastic"]
    assert main(["sweep", "twente-contact", *axes, "--out", str(tmp_path / "s")]) == 2
    said = capsys.readouterr().err
    for value, number in (("0.0", 2), ("-0.0001", 3)):
        assert f"--over slider.mass must be positive and finite, got {value} kg (value {number} of 3)" in said
    assert "got 'plastic'; did you mean elastic? (value 2 of 2)" in said
    axes = ["--over", "slider.ball=steel,stel", "--over", "stator.material=PZT-4,PZT-9"]
    assert main(["sweep", "twente", *axes, "--out", str(tmp_path / "s")]) == 2
    said = capsys.readouterr().err  # half of the points were computed before
    assert "--over slider.ball must be in the catalogue" in said
    assert "got 'stel'; the nearest known one is 'steel' (value 2 of 2)" in said
    assert "got 'PZT-9'; the nearest known one is 'PZT-8' (value 2 of 2)" in said
    assert not (tmp_path / "s").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "over",
    [
        {"drive.frequency": "2.15 MHz:2.25 MHz:7", "slider.position": "6.5 mm,7 mm"},  # a band
        {"drive.burst": "2e-4", "slider.preload": "1 mN,2 mN"},  # its ring-up
        {"drive.frequency": "center", "slider.preload": "1 mN,2 mN", "stator.thickness": "0.35 mm"},
        {"stator.length": "12 mm,13 mm", "slider.contacts": "[1, ['-0.2 mm', '0.2 mm']]"},
    ],
)
def test_driven_points_are_those_of_a_run(over):
    found = sweep(SMALL, over, tolerance=1e-2)
    columns = found.columns()
    assert found.counts == {"ok": found.points}
    for point in (0, found.points - 1):
        table = SMALL
        for key in over:
            value = columns[key][point]
            table = replaced(table, key, json.loads(value) if str(value).startswith("[") else value)
        (expected,) = run(Scene.from_table("", table), tolerance=1e-2).points
        error = 2 * (expected["relative_error"] + columns["relative_error"][point])
        for key in (key for key in columns if key.startswith("velocity") or key.endswith("amplitude_m")):
            if key in expected:
                assert columns[key][point] == pytest.approx(expected[key], rel=error, abs=0), key


def test_a_ball_beside_the_axis_changes_no_other_point():
    """Where all balls lie on the axis the section may stand for the wave, whatever other points ask for."""
    predictor = Predictor(PLANE, tolerance=1e-2, shared=Shared(positions=((0.007, 0.0), (0.007, 0.004))))
    length = predictor.scene({}).stator.length
    for y, expected in ((0.0, {0.0}), (0.004, {0.0, 0.004})):
        moved = predictor.scene({"slider.position": [0.007, y], "slider.contacts": 1})
        assert moved.stator.length == length
        assert {across for _, across in predictor.stators.shared_positions(moved)} == expected


def test_a_table_is_a_value_like_others():
    """It is no key of a memory, and no defect either."""
    predictor = Predictor(read_table("twente"), tolerance=1e-2)
    sources = {"left": 1, "right": -1}
    changed = predictor.scene({"drive.sources": sources, "drive.transducer": None})
    assert changed.drive.driven.keys() == sources.keys()


@pytest.mark.parametrize("tolerance", [2.0, 0.0, float("nan")])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(SceneError, match="tolerance"):
        sweep("twente-contact", {"slider.preload": [1e-3]}, tolerance=tolerance)


# --- cases in which a wrong mask, unit or version shows


def test_a_store_with_gaps_is_filled_where_the_stator_s_axis_is_not_the_first(tmp_path):
    """Three loads, two frequencies, three voltages; five rows of both frequencies are lost."""
    over = {"slider.load": [0.0, 2e-6, 4e-6], "drive.frequency": [2.18e6, 2.2e6], "drive.voltage": [20.0, 60.0, 90.0]}
    whole = sweep(PLANE, over, tolerance=3e-2, out=tmp_path / "s").columns()
    with closing(sqlite3.connect(tmp_path / "s" / FILE)) as connection, connection:
        connection.execute("delete from points where point in (1, 3, 8, 10, 17)")
    connection.close()
    found = sweep(PLANE, over, tolerance=3e-2, out=tmp_path / "s")
    assert found.counts == {"ok": 18}
    assert found.columns() == whole
    assert whole["drive.frequency"] == ([2.18e6] * 3 + [2.2e6] * 3) * 3
    assert len(set(whole["velocity_m_per_s"])) == 18


def test_a_store_of_another_version_is_refused_by_name(tmp_path):
    small = {"wave.normal_amplitude": "3 nm"}
    sweep("twente-contact", small, out=tmp_path / "s")
    kept = rows(tmp_path / "s")
    with closing(sqlite3.connect(tmp_path / "s" / FILE)) as connection, connection:
        (text,) = connection.execute("select value from sweep where name = 'identity'").fetchone()
        held = json.loads(text) | {"version of numpy": "1.0.0"}
        connection.execute("update sweep set value = ? where name = 'identity'", (json.dumps(held),))
    connection.close()
    with pytest.raises(SceneError, match="another sweep: its version of numpy differs"):
        sweep("twente-contact", small, out=tmp_path / "s")
    assert rows(tmp_path / "s") == kept


def test_every_number_of_a_dataset_has_the_unit_of_its_name():
    over = {"wave.normal_amplitude": [3e-9, 1e-8], "slider.preload": [1e-3, 2e-3]}
    also = ("limits", "thrust", "efficiency", "pressure", "step")
    data = sweep("twente-contact", over, also=also).to_xarray()
    endings = {
        "_m_per_s": "m/s", "_per_m": "1/m", "_W": "W", "_Pa": "Pa", "_N": "N", "_V": "V", "_m": "m",
    }  # fmt: skip
    seen = set()
    for name, values in data.items():
        ending = next((each for each in endings if name.endswith(each)), None)
        pure = "1" if values.dtype.kind == "f" else ""
        assert values.attrs.get("units", "") == endings.get(ending, pure), name
        seen.add(endings.get(ending))
    assert {key: each.attrs["units"] for key, each in data.coords.items()} == {
        "wave.normal_amplitude": "m", "slider.preload": "N",
    }  # fmt: skip
    assert {"m/s", "m", "N", "Pa"} <= seen


def test_five_balls_in_phase_have_five_times_the_thrust_at_the_same_efficiency():
    """Mass, preload, and viscous dampers five times as large: each ball moves as the one did."""
    slider = PLANE["slider"] | {"preload": 0.9e-3, "mass": MASS}
    five = {"contacts": 5, "mass": 5 * MASS, "preload": 4.5e-3, "damping": {"normal": 2.5, "tangential": 5e-4}}

    def answers(changes):
        table = PLANE | {"slider": slider | changes}
        found = sweep(table, {"drive.voltage": [90.0]}, also=("efficiency", "thrust"), tolerance=3e-2)
        return {name: values[0] for name, values in found.columns().items()}

    one, many = answers({}), answers(five)
    assert many["velocity_m_per_s"] == pytest.approx(one["velocity_m_per_s"], rel=1e-6)
    assert 0.1 < one["contact_efficiency"] < 0.9
    assert many["contact_efficiency"] == pytest.approx(one["contact_efficiency"], rel=1e-3)
    for key in ("thrust_N", "motor_efficiency"):
        assert one[key] > 0
        assert many[key] == pytest.approx(5 * one[key], rel=1e-3)


def test_the_expected_time_of_a_long_sweep_is_said():
    """As many stators as there are geometries, a band of frequencies as one for each."""
    over = {
        "stator.thickness": [1e-3 + 1e-6 * k for k in range(50)],
        "drive.frequency": [2.1e6 + 1e4 * k for k in range(8)],
        "slider.mass": [1e-5, 2e-5],
    }
    design = designed(SMALL, over, tolerance=1e-2)
    assert (design.stators, len(design)) == (50, 800)
    scene = Scene.from_table("", SMALL)
    assert long_sweep(scene, tolerance=1e-2, stators=1, points=800) == ()
    (sentence,) = long_sweep(scene, tolerance=1e-2, stators=100_000, points=800)
    assert sentence.startswith("expected time: about")
    (sentence,) = long_sweep(scene, tolerance=1e-2, stators=1, points=10_000_000)
    assert "50 minutes" in sentence


def test_an_outcome_without_an_answer_does_not_hide_the_others(monkeypatch):
    def fails(*_args, **_options):
        raise contact.ConvergenceError("not converged", "this outcome alone")

    names = {"start_up_time": "start_up_time_s", "half_thrust": "contact_efficiency"}
    wave = {"wave.normal_amplitude": 5e-9}
    for function, column in names.items():
        with monkeypatch.context() as patch:
            patch.setattr(requested_quantities, function, fails)
            (answer,) = Predictor(read_table("twente-contact"), tolerance=1e-2).answers(
                [wave], ("thrust", "start-up", "efficiency")
            )
        assert answer.point.thrust_N > 0.0
        assert {name for name in names.values() if name in answer.point} == set(names.values()) - {column}


def test_a_start_against_a_load_is_followed_to_its_end():
    """At 0.85 of the thrust the load leaves 0.15 of it to accelerate: the start takes longer than without a load."""
    light = {"wave.normal_amplitude": 10e-9, "slider.mass": 3.5e-6, "slider.preload": 0.873e-3}
    light["slider.damping.normal"] = 0.02
    motor = Predictor(read_table("twente-contact"), tolerance=1e-3)
    (free,) = motor.answers([light], ("thrust", "start-up"), averaged=True)
    loaded = light | {"slider.load": 0.85 * free.point.thrust_N}
    (answer,) = motor.answers([loaded], ("start-up",), averaged=True)
    driven = motor.contact(loaded)
    path = contact.burst(
        driven.slider, driven.at(driven.level), duration=6 * answer.point.start_up_time_s, after=0.0, tolerance=1e-3,
        samples=4000, method="averaged",
    )  # fmt: skip
    risen = np.interp(0.632, np.abs(path.velocity) / abs(answer.point.velocity_m_per_s), path.time)
    assert answer.point.start_up_time_s == pytest.approx(float(risen), rel=5e-3)
    assert answer.point.start_up_time_s > 1.5 * free.point.start_up_time_s


@pytest.mark.parametrize("stored", [True, False])
def test_the_summary_does_not_hold_all_rows(stored, tmp_path, monkeypatch):
    """Of a million points they take 0.6 GB."""
    monkeypatch.setattr(store, "BATCH", 2)
    over = {"wave.normal_amplitude": ["9 nm", "3 nm", "10 nm"], "slider.mass": [8.9e-5, -1e-3]}
    result = sweep("twente-contact", over, out=tmp_path / "s" if stored else None)
    columns = result.columns()
    frugal = replace(result, columns=lambda: pytest.fail("all rows were read"))
    speeds = [each for each in columns["velocity_m_per_s"] if each is not None]
    assert frugal.summary["ranges"]["velocity_m_per_s"] == [min(speeds), max(speeds)]
    assert frugal.summary["largest_relative_error"] == max(each for each in columns["relative_error"] if each)
    (reason,) = frugal.summary["reasons"]
    assert (reason["points"], reason["first_point"]) == (3, columns["status"].index(reason["status"]))
    assert "6: 3 refused, 3 ok" in str(frugal)
