"""Result directories: whole or not at all, and never over somebody's files."""

import json
import os
import stat
import tomllib

import pytest

from studies.chain import run
from studies.refusal import RunError
from studies.report.drawing import Drawing
from studies.report.files import write_run
from studies.results import result_directory
from studies.scene import Scene, read_table


def contents(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_result_appears_when_it_is_whole(tmp_path):
    target = tmp_path / "deep" / "motor"
    with result_directory(target) as folder:
        (folder / "run.json").write_text("{}")
        assert not target.exists()
        assert folder.parent == target.parent
    assert contents(target) == ["run.json"]
    assert contents(target.parent) == ["motor"]


def test_a_former_result_is_replaced_whole(tmp_path):
    for name in ("run.json", "extra.csv"), ("run.json",):
        with result_directory(tmp_path / "motor") as folder:
            for file in name:
                (folder / file).write_text("new")
    assert contents(tmp_path / "motor") == ["run.json"]
    assert contents(tmp_path) == ["motor"]


def test_after_a_failure_nothing_is_left_and_the_former_result_stays(tmp_path):
    with result_directory(tmp_path / "motor") as folder:
        (folder / "run.json").write_text("former")

    def fail(target):
        with result_directory(target) as folder:
            (folder / "run.json").write_text("half")
            raise KeyError

    for target in (tmp_path / "motor", tmp_path / "new" / "motor"):
        with pytest.raises(KeyError):
            fail(target)
    assert (tmp_path / "motor" / "run.json").read_text() == "former"
    assert contents(tmp_path) == ["motor"]


def test_an_empty_directory_may_be_filled(tmp_path):
    (tmp_path / "motor").mkdir()
    with result_directory(tmp_path / "motor") as folder:
        (folder / "run.json").write_text("{}")
    assert contents(tmp_path / "motor") == ["run.json"]


def test_a_stranger_s_directory_is_never_touched(tmp_path):
    (tmp_path / "thesis.tex").write_text("three years")
    with pytest.raises(RunError, match="no former result"), result_directory(tmp_path):
        pytest.fail("lent")
    assert contents(tmp_path) == ["thesis.tex"]


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "motor"):
        with pytest.raises(RunError, match="cannot be written"), result_directory(place):
            pytest.fail("lent")


def test_the_directory_has_the_usual_permissions(tmp_path):
    mask = os.umask(0o022)
    try:
        with result_directory(tmp_path / "motor") as folder:
            (folder / "run.json").write_text("{}")
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


def test_what_the_drawing_raises_is_raised_here(record, tmp_path):
    with Drawing() as drawing, pytest.raises(FileNotFoundError, match="velocity"):
        drawing.draw(record, tmp_path / "absent")


def test_a_drawing_process_that_ends_is_said(record, tmp_path):
    with Drawing() as drawing:
        drawing._process.kill()
        with pytest.raises(RunError, match="pictures were not drawn"):
            drawing.draw(record, tmp_path)


def test_the_scene_that_is_left_is_the_scene_that_ran(record, tmp_path):
    write_run(record, tmp_path, field=False)
    assert Scene.load(tmp_path / "scene.toml") == record.scene
    assert Scene.from_table("", json.loads((tmp_path / "run.json").read_text())["scene"]) == record.scene
    assert tomllib.loads((tmp_path / "scene.toml").read_text())["slider"]["preload"] == 0.089e-3 * 9.81
    assert f"--tolerance {record.tolerance}" in (tmp_path / "scene.toml").read_text()
