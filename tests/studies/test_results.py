"""Result directories: numbers whole or not at all, and nothing of anybody else's is lost."""

import json
import os
import stat
import subprocess
import sys
import tomllib
from hashlib import sha256
from pathlib import Path

import pytest

from studies.__main__ import main
from studies.record.files import write_run
from studies.refusal import RunError, SceneError
from studies.report.drawing import Drawing
from studies.results import MANIFEST, Origin, result_directory
from studies.results.directory import LOCK, READY, WORK
from studies.runs import run
from studies.scene import Scene, read_table
from tests.seed_motor import PRELOAD

ROOT = Path(__file__).parents[2]


RUN = Origin(kind="run", name="motor")


def contents(folder):
    """Return what a user sees in a directory."""
    return sorted(path.name for path in folder.iterdir() if path.name != MANIFEST)


def written(target, files, origin=RUN, **options):
    """Write a result of these files, given as name and text, and return what the user is told."""
    with result_directory(target, origin, **options) as result:
        for name, text in files.items():
            (result.folder / name).parent.mkdir(exist_ok=True)
            (result.folder / name).write_text(text)
        result.commit()
    return " ".join(result.notes)


def test_a_result_appears_when_it_is_committed(tmp_path):
    target = tmp_path / "deep" / "motor"
    with result_directory(target, RUN) as result:
        (result.folder / "run.json").write_text("{}")
        assert not (target / "run.json").exists()
        result.commit()
        assert (target / "run.json").read_text() == "{}"
        (result.folder / "late").mkdir()
        (result.folder / "late" / "velocity.png").write_text("picture")
        result.commit()
    assert contents(target) == ["late", "run.json"]
    assert contents(target.parent) == ["motor"]
    assert sorted(p.name for p in target.iterdir()) == [MANIFEST, "late", "run.json"]
    assert result.notes == []


def test_only_the_files_of_the_former_result_are_replaced(tmp_path):
    written(tmp_path, {"run.json": "old", "extra.csv": "old", "pictures/a.png": "old"})
    (tmp_path / "notes.md").write_text("mine")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "run.json").write_text("another result")
    said = written(tmp_path, {"run.json": "new"})
    assert contents(tmp_path) == ["notes.md", "other", "run.json"]
    assert (tmp_path / "run.json").read_text() == "new"
    assert (tmp_path / "notes.md").read_text() == "mine"
    assert (tmp_path / "other" / "run.json").read_text() == "another result"
    assert "replaced" in said
    assert all(name in said for name in ("run.json", "extra.csv", "pictures/a.png", "notes.md", "other"))


def test_a_file_that_somebody_edited_is_kept_under_another_name(tmp_path):
    for number, name in enumerate(("velocity.former.csv", "velocity.former-2.csv")):
        written(tmp_path, {"run.json": "a", "velocity.csv": "1", "table.csv": "2"})
        (tmp_path / "velocity.csv").write_text(f"edited {number}")
        (tmp_path / "table.csv").write_text("edited")
        said = written(tmp_path, {"run.json": "b", "velocity.csv": "3"})
        assert (tmp_path / name).read_text() == f"edited {number}"
        assert (tmp_path / "table.csv").read_text() == "edited"  # its name is free: it stays
        assert name in said
        (tmp_path / "table.csv").unlink()
    assert (tmp_path / "velocity.csv").read_text() == "3"


def test_a_directory_from_before_there_were_manifests_loses_nothing(tmp_path):
    for name in ("run.json", "velocity.csv", "field.vtu", "thesis.tex"):
        (tmp_path / name).write_text("old")
    written(tmp_path, {"run.json": "new", "velocity.csv": "new"})
    assert (tmp_path / "run.json").read_text() == "new"
    for name in ("run.former.json", "velocity.former.csv", "field.vtu", "thesis.tex"):
        assert (tmp_path / name).read_text() == "old"


def test_after_a_failure_nothing_is_left_and_the_former_result_stays(tmp_path):
    written(tmp_path / "motor", {"run.json": "former"})

    def fail(target):
        with result_directory(target, RUN) as result:
            (result.folder / "run.json").write_text("half")
            raise KeyError

    for target in (tmp_path / "motor", tmp_path / "new" / "motor"):
        with pytest.raises(KeyError):
            fail(target)
    assert (tmp_path / "motor" / "run.json").read_text() == "former"
    assert contents(tmp_path) == ["motor"]


@pytest.mark.parametrize("moves", range(7))
def test_an_interrupt_within_the_commit_leaves_one_whole_result(tmp_path, monkeypatch, moves):
    written(tmp_path, {"run.json": "old", "velocity.csv": "old", "gone.csv": "old"})
    (tmp_path / "velocity.csv").write_text("edited")
    before = {path.name: path.read_text() for path in tmp_path.iterdir()}
    left = [moves]

    def counted(original):
        def move(*arguments):
            left[0] -= 1
            if left[0] == -1:
                raise KeyboardInterrupt
            return original(*arguments)

        return move

    for name in ("rename", "replace"):
        monkeypatch.setattr(Path, name, counted(getattr(Path, name)))
    if moves < 6:  # the work folder, one kept aside, three new, the manifest
        with pytest.raises(KeyboardInterrupt):
            written(tmp_path, {"run.json": "new", "velocity.csv": "new", "scene.toml": "new"})
    else:
        written(tmp_path, {"run.json": "new", "velocity.csv": "new", "scene.toml": "new"})
    after = {path.name: path.read_text() for path in tmp_path.iterdir()}
    if moves == 0:
        assert after == before
    else:
        assert contents(tmp_path) == ["run.json", "scene.toml", "velocity.csv", "velocity.former.csv"]
        assert after["velocity.former.csv"] == "edited"
        assert {after[name] for name in ("run.json", "scene.toml", "velocity.csv")} == {"new"}


def test_what_a_killed_process_left_is_completed(tmp_path):
    """The rename of the work folder decides: what was not renamed is dropped, what was is moved into place."""
    written(tmp_path, {"run.json": "old", "gone.csv": "old"})
    for folder, text in ((WORK, "half"), (READY, "new")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "run.json").write_text(text)
    about = json.loads((tmp_path / MANIFEST).read_text()) | {"files": {"run.json": sha256(b"new").hexdigest()}}
    (tmp_path / READY / MANIFEST).write_text(json.dumps(about))
    with result_directory(tmp_path, RUN):
        assert (tmp_path / "run.json").read_text() == "new"
    assert contents(tmp_path) == ["run.json"]


KILLED = """
import os, pathlib, sys
from studies.results import Origin, result_directory

target, moves = pathlib.Path(sys.argv[1]), int(sys.argv[2])
made = {"rename": os.rename, "replace": os.replace}

def counted(name):
    def move(*given, **more):
        global moves
        moves -= 1
        if moves < 0:
            os._exit(9)  # as SIGKILL: nothing is cleared away
        return made[name](*given, **more)
    return move

for name in made:
    setattr(os, name, counted(name))
with result_directory(target, Origin(kind="run", name="motor")) as result:
    for name in ("run.json", "velocity.csv", "wave.png"):
        (result.folder / name).write_text("new " + name)
    result.commit()
print("whole")
"""


def test_a_kill_at_any_move_of_a_commit_loses_nothing(tmp_path):
    """The next command leaves the former result or the new one; what somebody edited stays in either case."""
    old = {name: f"old {name}" for name in ("run.json", "velocity.csv", "surface.csv")}
    for moves in range(30):
        target = tmp_path / str(moves)
        written(target, old)
        (target / "velocity.csv").write_text("mine")
        (target / "notes.md").write_text("mine too")
        words = [sys.executable, "-c", KILLED, str(target), str(moves)]
        done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
        for reopened in (False, True):
            if reopened:
                with result_directory(target, RUN):  # completes what the dead process left
                    pass
            held = {path.name: path.read_text() for path in target.iterdir() if path.is_file()}
            assert held["notes.md"] == "mine too"
            assert "mine" in held.values()
            if not reopened and "run.json" not in held:  # it is removed first and moved last
                continue
            if held["run.json"] == "new run.json":
                assert held["wave.png"] == "new wave.png"
                assert held["velocity.csv"] == "new velocity.csv"
            else:
                assert held["run.json"] == "old run.json"
                assert held["surface.csv"] == "old surface.csv"
                assert held["velocity.csv"] == "mine"
        if "whole" in done.stdout:
            break
        assert done.returncode == 9
    assert 3 < moves < 29


def test_a_second_run_in_the_same_directory_is_refused(tmp_path):
    with result_directory(tmp_path / "motor", RUN) as result:
        with pytest.raises(RunError, match="another run is writing"), result_directory(tmp_path / "motor", RUN):
            pytest.fail("lent twice")
        (result.folder / "run.json").write_text("{}")
        result.commit()
    assert contents(tmp_path / "motor") == ["run.json"]


def test_the_lock_of_a_dead_process_blocks_nobody(tmp_path):
    program = (
        "import os, pathlib; from studies.results import *;"
        f"lent = result_directory({str(tmp_path / 'motor')!r}, Origin(kind='run', name='motor'));"
        "lent.__enter__(); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT).returncode == 9
    assert sorted(p.name for p in (tmp_path / "motor").iterdir()) == [LOCK, WORK]
    written(tmp_path / "motor", {"run.json": "{}"})
    assert contents(tmp_path / "motor") == ["run.json"]


def test_a_default_directory_is_never_that_of_another_result(tmp_path):
    here, there = (tmp_path / name / "motor.toml" for name in ("a", "b"))
    first = Origin(kind="run", name="motor", source=here)
    written(tmp_path / "results", {"run.json": "a"}, first, named_by_user=False)
    written(tmp_path / "results", {"run.json": "again"}, first, named_by_user=False)
    second = Origin(kind="run", name="motor", source=there)
    study = Origin(kind="study", name="motor")
    for other in (second, study):
        with pytest.raises(SceneError, match=r"a.motor\.toml") as refusal:
            written(tmp_path / "results", {"run.json": "b"}, other, named_by_user=False)
        assert "--out" in str(refusal.value)
    assert (tmp_path / "results" / "run.json").read_text() == "again"
    said = written(tmp_path / "results", {"run.json": "b"}, second)
    assert "a/motor.toml" in said.replace(os.sep, "/")
    assert (tmp_path / "results" / "run.json").read_text() == "b"


def test_a_default_directory_of_an_old_study_is_not_for_a_run(tmp_path):
    (tmp_path / "study.json").write_text("{}")
    with pytest.raises(SceneError, match="result of a study"):
        written(tmp_path, {"run.json": "{}"}, named_by_user=False)


def test_a_moved_project_keeps_its_default_directories(tmp_path):
    origin = Origin(kind="run", name="motor", source=tmp_path / "old" / "motor.toml")
    written(tmp_path / "old" / "results", {"run.json": "a"}, origin, named_by_user=False)
    (tmp_path / "old").rename(tmp_path / "new")
    moved = Origin(kind="run", name="motor", source=tmp_path / "new" / "motor.toml")
    written(tmp_path / "new" / "results", {"run.json": "b"}, moved, named_by_user=False)
    assert (tmp_path / "new" / "results" / "run.json").read_text() == "b"


def test_an_empty_directory_may_be_filled(tmp_path):
    (tmp_path / "motor").mkdir()
    written(tmp_path / "motor", {"run.json": "{}"})
    assert contents(tmp_path / "motor") == ["run.json"]


def test_a_stranger_s_directory_is_never_touched(tmp_path):
    (tmp_path / "thesis.tex").write_text("three years")
    with pytest.raises(SceneError, match="not a result of sawmotor"), result_directory(tmp_path, RUN):
        pytest.fail("lent")
    assert contents(tmp_path) == ["thesis.tex"]


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "motor"):
        with pytest.raises(SceneError, match="cannot be written"), result_directory(place, RUN):
            pytest.fail("lent")


@pytest.mark.parametrize(
    "words",
    [
        ["run", "twente-contact"],
        ["study", "reflector"],
        ["export", "twente-contact", "--format", "c"],
        ["sweep", "twente-contact", "--over", "slider.preload=1e-3:2e-3:2"],
    ],
)
def test_an_out_that_cannot_be_written_is_bad_input(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("mine")
    assert main([*words, "--out", "file/below"]) == 2
    assert capsys.readouterr().err.splitlines()[-1].endswith(": Not a directory")
    assert contents(tmp_path) == ["file"]


def test_the_directory_has_the_usual_permissions(tmp_path):
    mask = os.umask(0o022)
    try:
        written(tmp_path / "motor", {"run.json": "{}"})
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "motor").stat().st_mode) == 0o755


@pytest.fixture(scope="module")
def record():
    table = read_table("twente-contact")
    table["wave"] |= {"normal_amplitude": ["0.5 nm", "3 nm", "5 nm"], "burst": "0.05 ms"}
    return run(Scene.from_table("", table), tolerance=1e-3)


def test_the_files_of_a_contact_run(record, tmp_path):
    with Drawing() as drawing:
        write_run(record, tmp_path, field=True)
        drawing.draw(record, tmp_path)
    names = ["run.json", "scene.toml", "trajectory.csv", "trajectory.png", "velocity.csv", "velocity.png"]
    assert contents(tmp_path) == names
    assert json.loads((tmp_path / "run.json").read_text()) == json.loads(json.dumps(record.to_dict()))
    head, *rows = (tmp_path / "velocity.csv").read_text().splitlines()
    assert head.split(",") == list(dict.fromkeys(key for point in record.points for key in point))
    assert [float(row.split(",")[2]) for row in rows] == [p["velocity_m_per_s"] for p in record.points]
    assert (tmp_path / "velocity.png").read_bytes().startswith(b"\x89PNG")
    trajectory = (tmp_path / "trajectory.csv").read_text().splitlines()
    assert len(trajectory) == 1 + sum(len(motion.time) for _, motion in record.trajectories)


def test_what_the_drawing_raises_is_raised_here(record, tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    with Drawing() as drawing, pytest.raises(FileNotFoundError, match="velocity"):
        drawing.draw(record, tmp_path / "absent")


@pytest.mark.parametrize("blocked", ["velocity.png", "trajectory.png"])
def test_an_error_of_any_picture_is_raised_and_the_other_one_drawn(record, tmp_path, monkeypatch, blocked):
    """The pictures are drawn by the drawing process and, beside it, by a copy of it."""
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    (tmp_path / blocked).mkdir()
    with Drawing() as drawing, pytest.raises(IsADirectoryError, match=blocked):
        drawing.draw(record, tmp_path)
    if blocked == "trajectory.png":
        assert (tmp_path / "velocity.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / blocked).rmdir()
    with Drawing() as drawing:
        drawing.draw(record, tmp_path)
    assert all((tmp_path / name).is_file() for name in ("velocity.png", "trajectory.png"))


def test_a_drawing_process_that_ends_is_said(record, tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    with Drawing() as drawing:
        drawing.process.kill()
        with pytest.raises(RunError, match="pictures were not drawn"):
            drawing.draw(record, tmp_path)


def test_the_scene_that_is_left_is_the_scene_that_ran(record, tmp_path):
    write_run(record, tmp_path, field=False)
    assert Scene.load(tmp_path / "scene.toml") == record.scene
    assert Scene.from_table("", json.loads((tmp_path / "run.json").read_text())["scene"]) == record.scene
    assert tomllib.loads((tmp_path / "scene.toml").read_text())["slider"]["preload"] == PRELOAD
    assert f"--tolerance {record.tolerance}" in (tmp_path / "scene.toml").read_text()
