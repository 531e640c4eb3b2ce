"""What is wrong with a call is said in a sentence: of the Python interface, of the command's options, of ended runs."""

import os
import signal
import subprocess
import sys
import time

import pytest

from studies import Record, Scene, SceneError, run, sweep
from studies.__main__ import main
from studies.lab.measurement_csv import read_measured
from studies.motor import load_line


@pytest.fixture
def call(capsys):
    """Run the command in this process; return exit code, stdout and stderr."""

    def called(*words):
        status = main(list(words))
        return status, *capsys.readouterr()

    return called


MOTOR = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["5 nm", "10 nm"]})


def test_a_contact_that_misses_its_share_is_an_answer_if_the_sum_keeps_the_tolerance():
    """The contact is asked for a quarter of the tolerance: missing that alone is no shortfall."""
    motor = MOTOR.replace(slider={"method": "averaged"})
    reached = run(motor).relative_error.max()
    kept = run(motor, tolerance=2 * reached)  # a quarter of which is less than what is reached
    assert set(kept.status) == {"ok"}
    assert kept.shortfall == ""
    missed = run(motor, tolerance=0.5 * reached)
    assert any(status.startswith("above tolerance") for status in missed.status)
    assert "was asked for" in missed.shortfall


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: run(MOTOR, tolerance="1%"), "tolerance must be a plain number, got '1%'"),
        (lambda: run(3), "a scene is a Scene, a file or the name of one that ships, got 3"),
        (lambda: sweep(MOTOR, "slider.preload=1"), "over must be a dict of a key's values"),
    ],
)
def test_a_wrong_argument_is_a_sentence(call, sentence):
    with pytest.raises(SceneError, match=sentence.replace("(", r"\(")):
        call()


def test_a_figure_of_something_else_is_refused():
    with pytest.raises(TypeError, match="what the study's run returned, got a Record"):
        load_line.figure(Record(scene=MOTOR, tolerance=1e-3), None)


def test_columns_of_a_sweep_have_units():
    found = sweep(MOTOR, {"slider.preload": ["1 mN", "2 mN"]}).to_xarray()
    units = {name: each.attrs.get("units") for name, each in found.data_vars.items()}
    assert units["velocity_m_per_s"] == "m/s"
    assert units["normal_amplitude_m"] == "m"
    assert units["relative_error"] == "1"
    assert units["regime"] is None


def test_an_error_without_a_unit_is_refused(tmp_path):
    file = tmp_path / "measured.csv"
    file.write_text("voltage_V,velocity_mm_per_s,error\n10,3,0.5\n")
    with pytest.raises(SceneError, match="must name the unit of the column error, as in error_m_per_s"):
        read_measured(file)


@pytest.mark.parametrize("text", ["5-60", "5 - 60 V", "5 to 60"])
def test_a_range_in_words_is_told_how_a_range_is_written(call, text):
    status, _, err = call("run", "twente", "--voltage", text)
    assert status == 2
    assert "must be START:STOP:N or a list" in err


def test_a_misspelt_file_is_found_beside(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my-motor.toml").write_text('title = "a"\n')
    status, _, err = call("check", "my-moter.toml")
    assert status == 2
    assert "did you mean my-motor.toml?" in err


def test_check_warns_of_what_the_layout_alone_shows(call):
    """Fingers of twente's left transducer reach from 2.7 to 22.7 mm."""
    changes = ("slider.position=12 mm", "slider.contacts=3", "stator.length=90")
    status, _, err = call("check", "twente", *(word for each in changes for word in ("--set", each)))
    assert status == 0
    assert "3 balls at one position" in err
    assert "the slider lies over the fingers of transducer left" in err
    assert "stator.length is 90 m" in err
    assert call("check", "twente")[2] == ""


def test_an_interrupt_within_exec_ends_with_130(tmp_path):
    # "python -m" ended by SIGINT (-2) here, because CPython takes such an interrupt for unhandled
    (tmp_path / "interrupted.py").write_text(
        "import sys\n"
        "from studies import __main__ as command\n"
        "command._dispatch = lambda words: exec('raise KeyboardInterrupt')\n"
        "sys.exit(command.main())\n"
    )
    path = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    ended = subprocess.run(
        [sys.executable, "-m", "interrupted"], env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True
    )
    assert (ended.returncode, ended.stderr) == (130, "sawmotor: interrupted, nothing was written\n")


def test_a_run_that_is_ended_leaves_no_work_files(tmp_path):
    words = [sys.executable, "-m", "studies", "run", "twente", "--out", "here"]
    path = os.pathsep.join(each for each in sys.path if each)
    process = subprocess.Popen(
        words, cwd=tmp_path, env=os.environ | {"PYTHONPATH": path}, stderr=subprocess.PIPE, text=True
    )
    while not (tmp_path / "here" / ".sawmotor.work").exists() and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert "interrupted, nothing was written" in err
    assert not (tmp_path / "here").exists()
