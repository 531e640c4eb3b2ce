"""The axes of a sweep: which keys of a scene take which values.

``slider.preload=1 mN:100 mN:50`` is 50 values evenly spaced, ``...:50:log`` evenly spaced in their logarithm,
``5 mN,10 mN`` a list (``[...]`` a TOML list of values).  A CSV file of points is one axis of several keys.  Axes are
multiplied.

Values are converted to SI here and checked at their points: one that breaks a rule of the scene costs its own
points alone.  The command refuses values of ``--over`` that break the rule of their own key before it computes any.
"""

import math
from dataclasses import dataclass
from pathlib import Path

from studies.lab.csv_columns import CsvColumns
from studies.model.scene_errors import input_errors
from studies.model.solid_of_material import crystal
from studies.refusal import SceneError, misread, refuse_if, shown
from studies.scene.keys import rule_at, unit_of
from studies.scene.override import toml_value
from studies.scene.quantity import si_value
from studies.scene.ranges import MAX_COUNT, read_range
from studies.scene.rule import Count

MATERIAL_KEYS = ("material", "ball")  # last names of keys that take materials of the catalogue


@dataclass(frozen=True)
class Axis:
    """Keys whose values change together."""

    keys: tuple[str, ...]  # dotted, as in a scene
    columns: tuple[list, ...]  # the values of each key, equally many

    def __len__(self):
        return len(self.columns[0])


def axis(key: str, values) -> Axis:
    """Return the axis of a key.

    ``key``: dotted; ``values``: a text as in this module's docstring, or the values themselves.

    Raises
    ------
    SceneError
        If the scene has no such key, or the text cannot be read.
    """
    rule = rule_at(key)
    if not isinstance(values, str):
        values = values.tolist() if hasattr(values, "tolist") else values
        values = list(values) if isinstance(values, (list, tuple, range)) else [values]
        return _listed(key, rule, values)
    if ":" in values and not values.lstrip().startswith(("[", '"', "'")):
        return _ranged(key, rule, values)
    whole = toml_value(values if values.lstrip().startswith("[") else f"[{values}]")
    if not isinstance(whole, list):
        whole = [toml_value(part.strip()) for part in values.split(",")]
    return _listed(key, rule, whole)


def refuse_bad_values(over: dict) -> None:
    """Raise a SceneError of all values of axes that break the rule of their key, whatever the other keys are."""
    faults = []
    for key, values in over.items():
        rule, column = rule_at(key), axis(key, values).columns[0]
        for number, value in enumerate(column, 1):
            try:
                read = rule.read(key, value)
                if key.rpartition(".")[2] in MATERIAL_KEYS:
                    with input_errors(key):
                        crystal(read)
            except SceneError as fault:
                place = f" (value {number} of {len(column)})" if len(column) > 1 else ""
                faults += [SceneError(f"--over {each.path}", f"{each.rule}{place}") for each in fault.problems]
    if faults:
        raise SceneError.together(faults)


def point_axis(source) -> Axis:
    """Return the axis of a table of points: a CSV file with keys in its first line, or a data frame."""
    if isinstance(source, Path):
        source = _read(source)
    elif hasattr(source, "columns"):
        source = {key: source[key].tolist() for key in source.columns}
    else:
        raise misread("over", "a dict of a key's values, a Path or a data frame", source)
    axes = [axis(key, values if not isinstance(values, str) else [values]) for key, values in source.items()]
    refuse_if(
        not axes or len({len(each) for each in axes}) != 1, "points", "must hold a value for every key in every line"
    )
    return Axis(tuple(source), tuple(each.columns[0] for each in axes))


def level_key(table: dict) -> str | None:
    """Return the key of a scene's levels; None for a free wave."""
    if "wave" in table:
        return "wave.normal_amplitude"
    level = "power" if "power" in table.get("drive", {}) else "voltage"
    return f"drive.{level}" if table.get("transducer") else None


def _ranged(key, rule, text):
    unit = unit_of(rule)
    if unit is None:
        raise SceneError(f"over {key}", f"takes words: give a list with commas, got {shown(text)}")
    steps = read_range(f"over {key}", text, unit)
    if isinstance(rule.number, Count):
        refuse_if(
            any(abs(step - round(step)) > 1e-9 for step in steps),
            f"over {key}",
            f"must fall on whole numbers, got {shown(text)}",
        )
        steps = [round(step) for step in steps]
    return Axis((key,), (steps,))


def _listed(key, rule, values):
    refuse_if(not 1 <= len(values) <= MAX_COUNT, f"over {key}", f"must hold 1 to {MAX_COUNT} values, got {len(values)}")
    return Axis((key,), ([_entry(rule, value) for value in values],))


def _entry(rule, value):
    """Return a value in SI units; one that cannot be converted stays, and is refused at its point."""
    if isinstance(value, (list, tuple)):
        return tuple(_entry(rule.each or rule, each) for each in value)
    unit, rule = unit_of(rule), rule.number
    if isinstance(rule, Count) and isinstance(value, float) and value.is_integer():
        return int(value)
    if unit is None or isinstance(rule, Count):
        return value
    try:
        return si_value("", value, unit)
    except SceneError:
        # infinities and NaN have no JSON or SQLite value; as text they are refused by name
        return value if not isinstance(value, float) or math.isfinite(value) else repr(value)


def _read(path: Path) -> dict[str, list]:
    table = CsvColumns.read(path, "points")
    table.refuse_if(len(set(table.names)) < len(table.names), "names a key twice")
    table.refuse_uneven()
    columns = zip(*table.rows, strict=True)
    return {key: list(map(toml_value, column)) for key, column in zip(table.names, columns, strict=True)}
