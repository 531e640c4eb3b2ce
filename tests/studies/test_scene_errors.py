"""Faults of a scene file as a new user meets them: all at once, each with its line, and with what to write."""

import tomllib

import pytest

from studies import Scene, SceneError, shipped_scenes
from studies.__main__ import main
from studies.scene import SceneFile
from studies.scene.lines import key_lines, line_of
from studies.scene.override import toml_value

BAD = """\
title = "ten faults"
[stator]
material = "PZT-9"
length = "160 mm"
thickness = "5 mm"
width = "35 mm"

[[transducer]]
name = "left"
center = "15 mm"
finger_pairs = 10
metallized = 0.5
aperture = "40 mm"

[drive]
frequency = "2.2 mHz"
voltage = ["3 V", "5 mm",
           "4,5 V"]

[slider]
position = "80 mm"
radius = -1
friction = 0.08
frequency = 3
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Write a scene into the working directory; its name."""
    monkeypatch.chdir(tmp_path)

    def written(content: str | bytes, name="motor.toml"):
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return name

    return written


def faults(name) -> list[str]:
    with pytest.raises(SceneError) as refusal:
        Scene.load(name)
    return [str(problem) for problem in refusal.value.problems]


def test_all_faults_are_said_at_once_with_their_lines(written, capsys):
    expected = [  # line, key, words
        (2, "stator.ends", '"absorbing" or "free" or "clamped"'),
        (3, "stator.material", "the nearest known one is 'PZT-8'"),
        (12, "transducer.0.metallized", "did you mean metallisation?"),
        (16, "drive.frequency", "did you mean 2.2 MHz?"),
        (17, "drive.voltage.1", "a length"),
        (18, "drive.voltage.2", "write a decimal point, '4.5 V'"),
        (20, "slider.mass", "a mass in kg, positive (a number, or a string such as"),
        (20, "slider.preload", '"weight"'),
        (20, "slider.contacts", "an integer from 1"),
        (20, "slider.effective_modulus", 'or ball = "steel" instead'),
        (20, "slider.tangential_modulus", 'or ball = "steel" instead'),
        (22, "slider.radius", "positive"),
        (23, "slider.friction", "did you mean friction_coefficient?"),
        (24, "slider.frequency", "frequency belongs in [drive] or [wave]"),
    ]
    assert main(["check", written(BAD)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == len(expected), "\n".join(said)
    for line, (number, key, words) in zip(said, expected, strict=True):
        assert line.startswith(f"sawmotor: motor.toml, line {number}: {key} "), line
        assert words in line


def test_contradictions_between_the_blocks_that_can_be_read_are_said_too(written):
    text = shipped_scenes()["twente"].read_text().replace('mass = "0.089 g"', "mass = -1")
    said = faults(written(text.replace('"left"\nvoltage', '"lift"\nvoltage').replace('"20 mm"', '"36 mm"')))
    assert [any(key in line for line in said) for key in ("drive.transducer", "slider.mass")] == [True, True]
    assert sum("aperture must be at most stator.width" in line for line in said) == 2


def test_what_the_command_line_changed_is_not_blamed_on_a_line(capsys):
    assert main(["check", "twente", "--set", "slider.mas=1", "--set", "stator.width=1 kg"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in said] == ["stator.width", "slider.mas"]


def test_the_blocks_of_a_lost_key_are_named_once_in_the_order_of_a_scene(capsys):
    """The order does not depend on which file of the program is imported first."""
    for key, homes in {"width": "[stator] or [slider.pillars]", "compliance": "[stator.material] or [wave]"}.items():
        assert main(["check", "twente", "--set", f"{key}=1"]) == 2
        said = capsys.readouterr().err
        assert said == f"sawmotor: {key} is no key of a scene; {key} belongs in {homes}\n"


def test_what_only_the_physics_can_refuse_has_its_line_too(written, capsys):
    name = written(shipped_scenes()["rayleigh"].read_text().replace("PZT-8", "PZT-88"))
    assert main(["check", name]) == 2
    assert capsys.readouterr().err.startswith("sawmotor: motor.toml, line 6: stator.material must be in the")


@pytest.mark.parametrize(
    ("line", "advice"),
    [
        ("friction_coefficient = .15", "write 0.15"),
        ("voltage = [1.5, .5]", "write 0.5"),
        ("radius = 5.", "write 5.0"),
        ("friction_coefficient = 0,15", "write 0.15"),
        ("mass = 0.1 g", 'write mass = "0.1 g"'),
        ("material = PZT-8", 'write material = "PZT-8"'),
        ("reciprocal = True", "write true"),
        ("name = \N{LEFT DOUBLE QUOTATION MARK}a\N{RIGHT DOUBLE QUOTATION MARK}", "straight quotes"),
        ("mass =", "mass has no value"),
        ('name = "left', "not closed"),
        ("voltage = [1, 2", "] is missing"),
        ("mass 5", "KEY = VALUE"),
        ("[slider", "between brackets"),
        ("title = 'again'", "given twice"),
        ("[drive]\n[drive]", "given twice"),
    ],
)
def test_a_syntax_error_is_explained(written, line, advice):
    with pytest.raises(tomllib.TOMLDecodeError):
        tomllib.loads(f"title = 'a'\n{line}\n")
    said = faults(written(f"title = 'a'\n{line}\n"))
    last = 2 + line.count("\n")
    assert len(said) == 1
    assert said[0].startswith(f"motor.toml, line {last}: "), said
    assert advice in said[0]


def test_a_byte_order_mark_and_line_ends_of_other_systems_are_accepted(written):
    text = shipped_scenes()["twente"].read_text()
    name = written(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert Scene.load(name) == Scene.load("twente")


@pytest.mark.parametrize(
    ("content", "words"),
    [("title = 'a'".encode("utf-16"), "UTF-16"), (b"# ok\ntitle = '\xb5m'", "line 2: a character is not UTF-8")],
)
def test_another_encoding_is_named(written, content, words):
    assert words in faults(written(content))[0]


def test_a_directory_is_no_scene_but_holds_one(written, tmp_path):
    assert "is a directory, not a scene file" in faults(".")[0]
    written("", name="scene.toml")
    assert faults(str(tmp_path))[0].endswith("scene.toml'?")


DOCUMENT = '''\
# [not.a.block]
title = "a = b # [c]"
text = """
[fake]
x = 1
"""
[a]
"quoted key" = 1
b.c = { x = [1, 2], y = 3 }  # comment, with = signs
list = [ [1,
          2], # [
  [3, 4]]
[[many]]
k = 1
[[many]]
k = ["]", "," ,
  'it''s']
[many.inner]
z = 1
'''.replace("it''s", "its")


def test_lines_of_keys():
    tomllib.loads(DOCUMENT)
    lines = key_lines(DOCUMENT)
    for path, line in {
        "title": 2, "text": 3, "a": 7, "a.quoted key": 8, "a.b.c": 9, "a.list": 10, "a.list.0.1": 11,
        "a.list.1.1": 12, "many.0.k": 14, "many.1": 15, "many.1.k.1": 16, "many.1.k.2": 17, "many.1.inner.z": 19,
    }.items():  # fmt: skip
        assert lines[path] == line, path
    assert "fake" not in lines
    assert line_of("a.b.c.x.1", lines) == 9
    assert line_of("other.key", lines) is None


@pytest.mark.parametrize("name", sorted(shipped_scenes()))
def test_every_key_of_a_shipped_scene_has_the_line_where_its_value_stands(name):
    """Oracle: the text of the line itself, read alone."""
    file, text = SceneFile.read(name), shipped_scenes()[name].read_text().splitlines()
    for block, table in file.table.items():
        for key, value in table.items() if isinstance(table, dict) else ():
            if isinstance(value, (str, int, float)):
                line = text[file.lines[f"{block}.{key}"] - 1]
                assert line.startswith(f"{key} = ")
                assert toml_value(line.partition("= ")[2]) == value


def test_a_complex_number_is_no_list_of_levels():
    with pytest.raises(SceneError, match="voltage"):
        Scene.load("twente").replace(drive={"voltage": 1 + 2j})
