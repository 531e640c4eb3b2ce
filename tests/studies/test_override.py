"""Changes from the command line."""

import pytest

from studies.command.parser import parser
from studies.command.scene_argument import changed_scene
from studies.refusal import SceneError
from studies.scene import Scene, read_table
from studies.scene.keys import rule_at
from studies.scene.override import toml_value
from tests.studies.settings import assigned


def rest_equal(changed, original, key):
    """Both entries at a key, once all the others are found equal."""
    if isinstance(original, list):
        assert [v for i, v in enumerate(changed) if i != key] == [v for i, v in enumerate(original) if i != key]
        return changed[key], original[key]
    assert {k: v for k, v in changed.items() if k != key} == {k: v for k, v in original.items() if k != key}
    return changed[key], original.get(key, {})


@pytest.mark.parametrize(
    ("setting", "path", "value"),
    [
        ("slider.mass=1e-4", ("slider", "mass"), 1e-4),
        ('transducer.1.center="900 mm"', ("transducer", 1, "center"), "900 mm"),
        ("stator.length=900 mm", ("stator", "length"), "900 mm"),
        ("drive.voltage=[1, 2]", ("drive", "voltage"), [1, 2]),
        ("drive.voltage.0 = 4", ("drive", "voltage", 0), 4),
        ("slider.damping.normal=0", ("slider", "damping", "normal"), 0),
        ("slider.reciprocal=true", ("slider", "reciprocal"), True),
        ("title=a = b", ("title",), "a = b"),
    ],
)
def test_a_setting_changes_its_key_and_nothing_else(setting, path, value):
    before = read_table("twente")
    after = assigned(before, setting)
    assert before == read_table("twente")
    holder, original = after, before
    for key in path[:-1]:
        holder, original = rest_equal(holder, original, key)
    assert rest_equal(holder, original, path[-1])[0] == value


@pytest.mark.parametrize(
    "setting", ["slider.mass", "=3", "a..b=3", "transducer.2.center=1", "transducer.-1.center=1", "title.x=3"]
)
def test_a_setting_that_leads_nowhere_is_refused(setting):
    with pytest.raises(SceneError):
        assigned(read_table("twente"), setting)


def test_a_value_cannot_smuggle_in_another_key():
    assert toml_value("1\nother = 2") == "1\nother = 2"


@pytest.mark.parametrize("key", ["drive.voltage", "drive.power", "wave.normal_amplitude"])
@pytest.mark.parametrize(
    ("text", "values"),
    [("5:60:12", [5 + 5 * k for k in range(12)]), ("60:5:2", [60, 5]), ("5:5:1", [5]), ("1:100:3:log", [1, 10, 100])],
)
def test_a_range_in_a_scene(key, text, values):
    assert rule_at(key).read(key, text) == pytest.approx(values, rel=1e-15)


def test_an_exponent_is_no_range():
    assert rule_at("drive.voltage").read("drive.voltage", "15e-3 V") == (0.015,)


def test_a_range_has_units_at_both_ends_or_neither():
    assert rule_at("drive.voltage").read("drive.voltage", "0:1 kV:3") == (0, 500, 1000)


@pytest.mark.parametrize(
    ("text", "values"), [("5,10,20 V", (5, 10, 20)), ("1 kV, 5", (1000, 5)), ("7", (7,)), ("5:7:3", (5, 6, 7))]
)
def test_voltages_of_a_call(text, values):
    call = parser().parse_args(["run", "twente", "--voltage", text])
    assert changed_scene(call).drive.voltage == values


@pytest.mark.parametrize("text", ["-5", "5,,6", "nan", "inf", "1 A"])
def test_voltages_that_make_no_list_are_refused(text):
    with pytest.raises(SceneError, match=r"^drive\.voltage"):
        changed_scene(parser().parse_args(["run", "twente", f"--voltage={text}"]))


def test_voltages_that_look_like_a_time_of_day_are_a_range():
    """TOML reads 12:28:17 as a time."""
    motor = Scene.from_table("", assigned(read_table("twente-contact"), "wave.normal_amplitude=10:50:20"))
    assert len(motor.levels) == 20
    assert toml_value("2026-11-22") == "2026-11-22"
