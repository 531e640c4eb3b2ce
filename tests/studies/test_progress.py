"""Progress: on stderr, and only when something takes long."""

import logging
import os
import pty
import re
import time

import contact
import fem
from studies import Scene, run
from studies.progress import Countdown, Progress, counted, reported_to

FIRST, SECOND = logging.getLogger("studies.runs"), logging.getLogger("fem.solve.driven_stator")


def test_a_quick_task_says_nothing(capsys):
    with Progress():
        FIRST.info("quick")
    assert capsys.readouterr() == ("", "")


def test_a_slow_task_is_shown_on_stderr(capsys, monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    progress = Progress()
    progress("first")  # before the clock starts: a busy machine may be late with what comes after
    with progress:
        time.sleep(0.1)
        SECOND.info("second")
    out, err = capsys.readouterr()
    assert out == ""
    assert "first (0." in err
    assert "second (0." in err


def test_the_expected_time_stands_beside_the_time_so_far(capsys, monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    for expected, words in ((60.0, " of about 1 min 0 s)"), (4.0, " s)\n")):
        progress = Progress(expected)
        progress("stator")
        with progress:
            time.sleep(0.1)
        assert words in capsys.readouterr().err


def test_the_search_for_a_period_is_reported_by_its_trials():
    block = fem.Stator(solid=fem.material("PZT-8"), length=40e-3, thickness=5e-3, ends="absorbing")
    row = fem.Transducer(name="t", center=20e-3, finger_pairs=3, period=1e-3, metallisation=0.5, aperture=20e-3)
    texts = []
    with reported_to(texts.append):
        fem.best_period(block, row, 2.2e6)
    assert [f"trial {k} of 21" in texts for k in (1, 11, 21)] == [True] * 3
    assert texts[-1] == "between the best trials"


def test_a_detail_is_reported_behind_its_step_and_nothing_afterwards():
    levels = [logging.getLogger(name).level for name in ("studies", "fem")]
    texts = []
    with reported_to(texts.append):
        SECOND.debug("order 3")
        FIRST.info("stator 1")
        SECOND.debug("order 4")
        SECOND.debug("order 5")
        FIRST.info("stator 2")
    FIRST.info("nobody listens")
    assert texts == ["order 3", "stator 1", "stator 1, order 4", "stator 1, order 5", "stator 2"]
    assert [logging.getLogger(name).level for name in ("studies", "fem")] == levels
    with reported_to(None):
        FIRST.info("nobody asked")
    assert len(texts) == 5


def test_a_sweep_says_how_many_points_are_kept(monkeypatch):
    """30 of 100 points in 2 s, 10 of them kept before: 10 points/s, the other 70 in 7 s."""
    clock = iter([0.0, 0.0, 2.0])
    monkeypatch.setattr("studies.progress.time.perf_counter", lambda: next(clock))
    progress = Progress()
    progress.points(100, 10, 1, 0.0)
    progress.points(100, 30, 2, 75.0)
    assert progress.text == "30 of 100 points kept: 10 points/s, 7.0 s left, 2 failed, 1 min 15 s of work"


def test_a_terminal_shows_the_time_that_goes_on_within_a_step(monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w", encoding="utf-8") as terminal:
        monkeypatch.setattr("sys.stderr", terminal)
        with Progress() as progress:
            progress("[drive] point 1 of 20")
            time.sleep(1.0)  # some drawings of the same step
        shown = os.read(ours, 100_000).decode()
    os.close(ours)
    times = {float(each) for each in re.findall(r"\[drive\] point 1 of 20 \(([0-9.]+) s\)", shown)}
    assert len(times) > 1
    assert max(times) < 30.0


def test_a_kernel_that_is_compiled_is_announced_below_its_step(monkeypatch):
    """As `contact.jit.compiled` logs it; the threshold, which comes before the first point, waits for the compiler."""
    threshold_factor, texts = contact.threshold_factor, []

    def compiling(*of):
        logging.getLogger("contact.jit.compiled").debug("compiling kernel %s, once", "travel")
        return threshold_factor(*of)

    monkeypatch.setattr("contact.threshold_factor", compiling)
    run(Scene.load("twente-contact").replace(wave={"normal_amplitude": "5 nm"}), progress=texts.append)
    assert texts[:2] == ["contact", "contact, compiling kernel travel, once"]
    assert "contact, point 1 of 1" in texts[2:]


def test_a_counted_computation_says_how_long_the_rest_takes(monkeypatch):
    """Two of five parts in 8 s: the other three take 12 s."""
    clock = iter([0.0, 4.0, 8.0])
    monkeypatch.setattr("studies.progress.time.perf_counter", lambda: next(clock))
    texts = []
    with reported_to(texts.append):
        for done in counted(FIRST, "load lines", range(5)):
            if done == 2:
                break
    assert texts == [
        "load lines: 0 of 5",
        "load lines: 1 of 5, about 16.0 s left",
        "load lines: 2 of 5, about 12.0 s left",
    ]


def test_more_parts_than_were_expected_are_counted_without_a_total():
    assert [Countdown("design", 30, "evaluations").text(done) for done in (0, 31)] == [
        "design: 0 of 30 evaluations",
        "design: 31 evaluations",
    ]


def test_a_silent_computation_is_repeated_with_its_time(capsys, monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    monkeypatch.setattr("studies.progress.MAX_SILENCE", 0.05)
    with Progress() as progress:
        progress("following the contact")
        time.sleep(0.3)
    assert capsys.readouterr().err.count("following the contact") >= 3
