"""Progress: on stderr, and only when something takes long."""

import time

from studies.progress import Progress


def test_a_quick_task_says_nothing(capsys):
    with Progress() as progress:
        progress("quick")
    assert capsys.readouterr() == ("", "")


def test_a_slow_task_is_shown_on_stderr(capsys, monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    progress = Progress()
    progress("first")  # before the clock starts: a busy machine may be late with what comes after
    with progress:
        time.sleep(0.1)
        progress("second")
    out, err = capsys.readouterr()
    assert out == ""
    assert "first (0." in err
    assert "second (0." in err


def test_a_sweep_says_how_many_points_are_kept(monkeypatch):
    """30 of 100 points in 2 s, 10 of them kept before: 10 points/s, the other 70 in 7 s."""
    clock = iter([0.0, 0.0, 2.0])
    monkeypatch.setattr("studies.progress.time.perf_counter", lambda: next(clock))
    progress = Progress()
    progress.points(100, 10, 1, 0.0)
    progress.points(100, 30, 2, 75.0)
    assert progress.text == "30 of 100 points kept: 10 points/s, 7.0 s left, 2 failed, 1 min 15 s of work"
