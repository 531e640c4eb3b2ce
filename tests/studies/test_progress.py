"""Progress: on stderr, and only when something takes long."""

import time

from studies.progress import Progress


def test_a_quick_task_says_nothing(capsys):
    with Progress() as progress:
        progress("quick")
    assert capsys.readouterr() == ("", "")


def test_a_slow_task_is_shown_on_stderr(capsys, monkeypatch):
    monkeypatch.setattr("studies.progress.PATIENCE", 0.01)
    with Progress() as progress:
        progress("first")
        time.sleep(0.1)
        progress("second")
    out, err = capsys.readouterr()
    assert out == ""
    assert "first (0." in err
    assert "second (0." in err
