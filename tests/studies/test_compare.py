"""``sawmotor compare``: differences of scenes and answers, changes against stated errors, picture, refusals."""

import json
import math
import re

import pytest

from studies import RunError, Scene, SceneError, compare, run
from studies.__main__ import main
from studies.record import Record

LEVELS = ["0.5 nm", "0.9 nm", "10 nm"]


@pytest.fixture(scope="module")
def records():
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": LEVELS})
    return [
        run(scene),
        run(scene.replace(slider={"friction_coefficient": 0.16}, wave={"normal_amplitude": LEVELS[1:]})),
    ]


@pytest.fixture(scope="module")
def folders(records, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    for name, record in zip(("seed", "rubbed"), records, strict=True):
        record.save(folder / name)
    return [str(folder / name) for name in ("seed", "rubbed")]


def test_scenes_and_answers_that_differ(records):
    pair = compare(*records)
    assert pair.names == ("1", "2")
    assert dict(pair.scenes) == {
        "slider.friction_coefficient": [0.08, 0.16],
        "wave.normal_amplitude": [[0.5e-9, 0.9e-9, 10e-9], [0.9e-9, 10e-9]],
    }
    answers = dict(pair.numbers)
    assert answers["summary.threshold_amplitude_m"] == [each.summary["threshold_amplitude_m"] for each in records]
    assert "summary.release_amplitude_m" not in answers  # friction does not lift the slider


def test_velocities_and_their_changes_by_hand(records):
    rows = dict(compare(*records).points())
    assert list(rows) == pytest.approx([0.5e-9, 0.9e-9, 10e-9])
    assert rows[0.5e-9] == [(0.0, 0.0), None]
    whole = compare(*records).to_dict()["points"]
    for k, level in ((1, 0.9e-9), (2, 10e-9)):
        first, second = records[0].velocity[k], records[1].velocity[k - 1]
        assert whole[k]["velocity"] == [first, second]
        assert whole[k]["change"] == [pytest.approx(second / first - 1, rel=1e-12)]
        # errors are over max(|v|, omega |u_x|/10), m/s
        surface = 2 * math.pi * 2.2e6 * abs(records[0].tangential_amplitude[k])
        error = records[0].relative_error[k] * max(abs(first), surface / 10)
        assert rows[level][0] == (first, pytest.approx(error, rel=1e-12))


def test_rotors_are_compared_by_their_rotation_and_the_plane_by_both_velocities():
    """A rotor's velocities, all 0, were compared. Errors in the plane are over the speed."""
    from studies.record.point import Point

    def of(name, **values):
        scene = Scene.load(name).replace(drive={"voltage": [20.0]})
        point = Point(voltage_V=20.0, tangential_amplitude_m=1e-12, relative_error=1e-3, **values)
        return Record(scene=scene, tolerance=1e-3, points=(point,), seconds={"total": 1.0})

    rotor = [of("rotor", velocity_m_per_s=0.0, lateral_velocity_m_per_s=0.0, rotation_rpm=n) for n in (60.0, 66.0)]
    (row,) = compare(*rotor).to_dict()["points"]
    assert row["rotation_rpm"] == [60.0, 66.0]
    assert row["change"] == pytest.approx([0.1])
    assert row["error"] == pytest.approx([0.06, 0.066])
    assert "rotations and changes from 1 (* by more than both stated errors)" in str(compare(*rotor))
    keys = {"velocity_m_per_s": 0.03, "lateral_velocity_m_per_s": 0.04, "rotation_rpm": 0.0}
    planar = compare(*[of("twente-planar", **(keys | {"lateral_velocity_m_per_s": v})) for v in (0.04, -0.04)])
    whole = planar.to_dict()
    assert whole["points"][0]["error"] == pytest.approx([5e-5, 5e-5])
    assert whole["lateral_velocity_m_per_s"][0]["change"] == pytest.approx([-2.0])
    assert whole["rotation_rpm"][0]["error"] == pytest.approx([5e-5 / 5.309e-3 * 60 / (2 * math.pi)] * 2, rel=1e-3)


@pytest.mark.parametrize(
    ("one", "other", "row"),
    [
        (["-1 mm", "1.5 mm"], ["-2 mm", "2 mm"], ["slider.contacts (mm)", "-1, 1.5", "-2, 2"]),
        ([["1 mm", "2 mm"], [0, 0]], ["-2 um"], ["slider.contacts (mm)", "[1, 2], 0", "-0.002"]),
        (["-1 mm", "1 mm"], 4, ["slider.contacts (mm)", "-1, 1", "4 (number)"]),
        (2, 4, ["slider.contacts", "2", "4"]),
    ],
)
def test_positions_of_balls_have_a_unit_and_their_mere_number_has_none(one, other, row):
    from studies.report.comparison import Comparison

    scenes = [Scene.load("twente").replace(slider={"contacts": each}) for each in (one, other)]
    records = tuple(Record(scene=each, tolerance=1e-3, points=(), seconds={"total": 1.0}) for each in scenes)
    line = str(Comparison(names=("1", "2"), records=records)).splitlines()[2]
    assert re.split(r"\s{2,}", line.strip()) == row


def test_order_of_the_runs_is_kept(records):
    one, other = compare(*records).to_dict(), compare(*records[::-1]).to_dict()
    for forward, back in zip(one["points"], other["points"], strict=True):
        assert forward["velocity"] == back["velocity"][::-1]
    assert (1 + one["points"][2]["change"][0]) * (1 + other["points"][2]["change"][0]) == pytest.approx(1, rel=1e-12)


def test_text_marks_what_is_beyond_the_errors(records, folders, capsys):
    assert main(["compare", *folders]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:4] == [
        "what differs in the scenes",
        "                                     seed   rubbed",
        " wave.normal_amplitude (nm)  0.5, 0.9, 10  0.9, 10",
        "slider.friction_coefficient          0.08     0.16",
    ]
    changed = next(line for line in lines if line.split()[:1] == ["10"])
    assert changed.endswith(f"{100 * (records[1].velocity[1] / records[0].velocity[2] - 1):+.3g} %*")
    assert main(["compare", folders[0], folders[0]]) == 0
    out = capsys.readouterr().out
    assert "the scenes are equal" in out
    assert "all within the stated errors" in out
    assert "*" not in out


def test_every_velocity_stands_with_its_error_and_runs_without_a_common_level_are_not_called_equal(records):
    pair = compare(*records)
    ((velocity, error), _) = dict(pair.points())[10e-9]
    assert f"{velocity * 1e3:.5g} ± {error * 1e3:.2g}" in str(pair)
    assert "0 ± 0" not in str(pair)
    apart = compare(records[0], run(records[0].scene.replace(wave={"normal_amplitude": "11 nm"})))
    assert "velocities and changes from 1 (no u_z is that of another run)" in str(apart)


def test_json_and_picture(folders, tmp_path, capsys):
    from PIL import Image

    file = tmp_path / "both.png"
    assert main(["compare", *folders, "--json", "--picture", str(file)]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert whole["runs"] == ["seed", "rubbed"]
    assert whole["scene"]["slider.friction_coefficient"] == [0.08, 0.16]
    with Image.open(file) as image:
        assert image.format == "PNG"


def test_refusals(records, folders, tmp_path, capsys):
    with pytest.raises(SceneError, match="compare needs at least two runs, got 1"):
        compare(records[0])
    with pytest.raises(RunError, match="holds no run"):
        compare(records[0], tmp_path)
    with pytest.raises(SceneError, match="compare needs runs over the same level, got 1 over u_z, 2 without a slider"):
        compare(records[0], run("rayleigh"))
    assert main(["compare", folders[0], str(tmp_path)]) == 2
    assert capsys.readouterr().err == (f"sawmotor: '{tmp_path}' holds no run.json: name a directory that a run left\n")
    scene = tmp_path / "motor.toml"
    scene.touch()
    assert main(["compare", str(scene), folders[0]]) == 2
    assert capsys.readouterr().err == f"sawmotor: '{scene}' is a file: name a directory that a run left\n"
    assert main(["compare", *folders, "--picture", str(tmp_path / "x.gif")]) == 2
    assert capsys.readouterr().err.strip() == (
        f"sawmotor: --picture must end in one of .png, .svg, .pdf, got '{tmp_path / 'x.gif'}'"
    )
    with pytest.raises(SceneError, match="compare draws velocities, and these runs have no slider"):
        compare(run("rayleigh"), run("rayleigh")).plot()
