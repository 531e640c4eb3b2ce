"""Points and blocks of a record: their fields are the table of quantities, and they read as mappings."""

import ast
import copy
import dataclasses
import json
import pickle
import re
from pathlib import Path

import pytest

import studies
from studies.record.blocks import (
    Effect,
    ElectricalBlock,
    ErrorBlock,
    HeatBlock,
    SummaryBlock,
    UncertaintyBlock,
    WaveBlock,
)
from studies.record.point import Point
from studies.record.quantities import quantities, quantity
from studies.record.values import Count, Flag, Text
from studies.refusal import SceneError

BLOCKS = {
    WaveBlock: ("wave",), ElectricalBlock: ("electrical",), SummaryBlock: ("summary",), HeatBlock: ("heat",),
    ErrorBlock: ("error",), Effect: ("model_error",), UncertaintyBlock: ("uncertainty",), Point: ("points", "sweep"),
}  # fmt: skip


def of_table(blocks):
    """Return the fields that the table names for some blocks; of a dotted field its first part."""
    keys = (key.split(".") for key in quantities())
    return {field for block, field, *_ in (key for key in keys if len(key) > 1) if block in blocks}


@pytest.mark.parametrize("kind", BLOCKS, ids=lambda kind: kind.__name__)
def test_the_fields_are_those_of_the_table(kind):
    assert kind.fields == of_table(BLOCKS[kind])
    assert all(getattr(kind, name) is None for name in kind.fields)


@pytest.mark.parametrize("kind", BLOCKS, ids=lambda kind: kind.__name__)
def test_words_are_texts_or_flags_and_units_are_numbers(kind):
    for name, declared in kind.__annotations__.items():
        found = {quantities()[f"{block}.{name}"].unit for block in BLOCKS[kind] if f"{block}.{name}" in quantities()}
        if not found:  # a field that holds others
            continue
        assert (declared in (Text, Flag)) == (found == {"-"}), name
        assert declared != Count or found == {"1"}, name


def test_values_that_are_absent_are_none_as_attributes_and_no_keys():
    point = Point(voltage_V=10.0, regime="slip", velocity_m_per_s=None)
    assert (point.voltage_V, point.velocity_m_per_s) == (10.0, None)
    assert list(point) == ["voltage_V", "regime"]
    assert point == {"voltage_V": 10.0, "regime": "slip"}
    assert "velocity_m_per_s" not in point
    assert point.get("velocity_m_per_s", 0.5) == 0.5
    with pytest.raises(KeyError, match="velocity_m_per_s"):
        point["velocity_m_per_s"]
    assert dict(point) == point.to_dict() == {**point}


def test_a_union_keeps_the_order_and_takes_the_right_value():
    left, right = Point(voltage_V=1.0, duty=0.5), Point(regime="stick", voltage_V=2.0)
    assert list((left | right).items()) == [("voltage_V", 2.0), ("duty", 0.5), ("regime", "stick")]
    assert (left.voltage_V, right.duty) == (1.0, None)
    assert left | {"voltage_V": 3.0} == {"voltage_V": 3.0, "duty": 0.5}
    for nothing in (Point(duty=None), {"duty": None}, Point()):
        assert left | nothing == left


def test_a_name_that_is_no_field_is_refused_and_a_value_stays():
    with pytest.raises(TypeError, match=r"Point has no field duti, velocity$"):
        Point(duti=0.5, velocity=0.5, duty=0.1)
    point = Point(duty=0.5)
    for change in (lambda: setattr(point, "duty", 1.0), lambda: delattr(point, "duty")):
        with pytest.raises(dataclasses.FrozenInstanceError, match="'duty'"):
            change()
    assert point.duty == 0.5


def test_a_file_of_another_version_is_read_with_its_own_keys():
    point = Point.read({"velocity_m_per_s": 0.1, "speed_of_1999": 3.0, "status": None})
    assert (point.velocity_m_per_s, point["speed_of_1999"], point.to_dict()) == (
        0.1, 3.0, {"velocity_m_per_s": 0.1, "speed_of_1999": 3.0},
    )  # fmt: skip
    assert Point.read(point) is point


def test_copies_and_pickles_are_equal_points():
    point = Point(duty=0.5, tilt_rad=[1.0, 2.0])
    for other in (copy.deepcopy(point), pickle.loads(pickle.dumps(point))):
        assert (type(other), other, other.tilt_rad) == (Point, point, [1.0, 2.0])


def test_pandas_takes_points_as_it_takes_dicts():
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame([Point(voltage_V=1.0), Point(voltage_V=2.0, regime="slip")])
    assert list(table.columns) == ["voltage_V", "regime"]
    assert table["voltage_V"].tolist() == [1.0, 2.0]


def test_the_level_is_the_voltage_or_the_amplitude():
    assert Point(normal_amplitude_m=1e-9).level == 1e-9
    assert Point(normal_amplitude_m=1e-9, voltage_V=0.0).level == 0.0


def test_a_run_of_an_older_version_is_loaded_and_written_again_as_it_was(tmp_path):
    from studies import Record, run
    from studies.record.files import write_run

    record = run("twente-contact", tolerance=1e-2)
    write_run(record, tmp_path, field=False)
    text = (tmp_path / "run.json").read_text()
    assert [point.velocity_m_per_s for point in Record.load(tmp_path).points] == record.velocity.tolist()
    older = re.sub(r'"stick_margin"', '"margin_of_old"', text)
    assert older != text
    (tmp_path / "run.json").write_text(older)
    loaded = Record.load(tmp_path)
    assert loaded.points[0].stick_margin is None
    assert loaded.points[0]["margin_of_old"] == record.points[0].stick_margin
    assert json.dumps(loaded.to_dict()) == json.dumps(json.loads(older))


def test_every_quantity_that_the_source_names_is_in_the_table():
    """``quantity.NAME`` is looked up when it is reached; a wrong name is seen here without reaching it."""
    named = set()
    for file in Path(studies.__file__).parent.rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        if re.search(r"^ *from studies\.record\.quantities import .*\bquantity\b", text, re.MULTILINE):
            named |= {
                node.attr
                for node in ast.walk(ast.parse(text))
                if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "quantity"
            }
    assert {"velocity_m_per_s", "time_s"} <= named
    assert named - {each.column for each in quantities().values() if each.label} == set()
    with pytest.raises(SceneError, match="is no quantity of a record"):
        quantity.velocity_in_knots  # noqa: B018


def test_the_fields_of_classes_are_written_from_the_table(monkeypatch):
    from studies.record import quantities as table

    folder = Path(studies.__file__).parent / "record"
    for name in ("point.py", "blocks.py"):
        text = (folder / name).read_text(encoding="utf-8")
        assert table.with_quantities(text) == text
    text = (folder / "point.py").read_text(encoding="utf-8")
    rows, duty = table.quantities(), table.quantities()["points.duty"]
    more = {"points.jerk_m_per_s3": ("m/s^3", "Number"), "sweep.mood": ("-", "Text")}
    new = {key: dataclasses.replace(duty, key=key, unit=unit) for key, (unit, _) in more.items()}
    monkeypatch.setattr(table, "quantities", lambda: {key: rows[key] for key in rows if key != "points.duty"} | new)
    changed = set(table.with_quantities(text).splitlines()) ^ set(text.splitlines())
    assert changed == {
        "    duty: Number = None", *(f"    {key.split('.')[1]}: {kind} = None" for key, (_, kind) in more.items()),
    }  # fmt: skip
