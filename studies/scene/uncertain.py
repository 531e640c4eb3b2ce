"""Tolerances of a scene's numbers: the block ``[uncertain]``, or ``"0.08 +- 0.02"`` at a key itself.

A tolerance is the half width of the interval that holds a number with 95 % probability, normally distributed; those
of several numbers are independent.
"""

import re
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

from studies.refusal import SceneError, misread, shown
from studies.scene.override import replaced, walk
from studies.scene.quantity import NUMBER, si_value
from studies.scene.ranges import is_number
from studies.scene.rule import Count, Rule, as_table, choice

OPTIONS = {"method": choice("linear", "sampled"), "samples": Count(100_000)}
DEFAULTS = {"method": "linear", "samples": 500}
SIGN = r"(?:\+-|\+/-|±)"
# with blanks around the sign: "0+-0" is a pattern of fingers
STATED = re.compile(r"\s*([+-]?[\d.][^%]*?)(?:\s+(?:\+-|\+/-)\s+|\s*±\s*)([\d.].*?)\s*")
ALONE = re.compile(rf"\s*{SIGN}?\s*([\d.].*?)\s*")


class Tolerance(NamedTuple):
    """A number of the scene in SI units and its tolerance; a level (voltage, amplitude) is 1, a common factor."""

    key: str
    value: float
    half_width: float


@dataclass(frozen=True)
class Uncertain(Rule):
    """Tolerances by key of the scene, with ``method`` and ``samples``."""

    def read(self, path, value):
        """Return pairs of key and option or text, in the order of the file."""
        pairs = value if isinstance(value, tuple) else as_table(path, value)
        if isinstance(value, dict):
            pairs = [(key, each) for key, each in walk(value) if not isinstance(each, dict)]
        for key, each in pairs:
            if key in OPTIONS:
                OPTIONS[key].read(f"{path}.{key}", each)
            elif "." not in key:
                rule = "must be a key of a scene, such as slider.preload, or method or samples"
                raise SceneError(f"{path}.{key}", rule)
            elif isinstance(each, bool) or not isinstance(each, (int, float, str)):
                raise misread(f"{path}.{key}", 'such as "+- 0.02" or "+- 5 %"', each)
        if not any("." in key for key, _ in pairs):
            raise SceneError(path, "must hold a tolerance, such as slider.friction_coefficient = 0.02")
        return tuple(pairs)

    def written(self, value):
        return reduce(lambda table, pair: replaced(table, *pair), value, {})

    @property
    def expected(self):
        return 'keys of the scene with their tolerances, such as slider.preload = "+- 5 %"'

    @property
    def range(self):
        return 'keys with "+- 0.2 mN" or "+- 5 %" or a number; method = "linear" or "sampled"; samples'

    def schema(self):
        tolerances = {"type": "object", "additionalProperties": {"type": ["number", "string", "object"]}}
        options = {name: rule.schema() | {"default": DEFAULTS[name]} for name, rule in OPTIONS.items()}
        return {"type": "object", "properties": options, "additionalProperties": tolerances}


def half_width(path: str, stated: float | str, value: float, unit: str) -> float:
    """Return a tolerance in the unit of its value: a number, ``"+- 0.2 mN"`` or ``"+- 5 %"`` of the value."""
    match = ALONE.fullmatch(stated) if isinstance(stated, str) else None
    text = stated if match is None else match[1]
    if isinstance(text, str) and text.endswith("%"):
        size = si_value(path, _number(text[:-1].strip()), "") / 100 * abs(value)
    else:
        size = si_value(path, text if unit else _number(text), unit)
    if size <= 0:
        raise SceneError(path, f"must be positive, got {shown(stated)} of {value:g} {unit}".rstrip())
    return size


def split_tolerances(table: dict) -> dict:
    """Return a scene's table with every ``"VALUE +- TOLERANCE"`` as its value and an entry of [uncertain].

    Examples
    --------
    >>> split_tolerances({"slider": {"preload": "5 +- 0.2 mN"}})
    {'slider': {'preload': '5 mN'}, 'uncertain': {'slider': {'preload': '+- 0.2 mN'}}}
    """
    tolerances = {}
    for key, value in walk({key: each for key, each in table.items() if key not in ("title", "uncertain")}):
        match = STATED.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            continue
        number, size = match.groups()
        units = [part[2] if (part := NUMBER.fullmatch(text)) else None for text in (number, size)]
        if units[0] is None and units[1] not in (None, "%"):
            number = f"{number} {units[1]}"
        elif units[1] is None and units[0] is not None:
            size = f"{size} {units[0]}"
        table, tolerances[key] = replaced(table, key, _number(number)), f"+- {size}"
    for key, _ in walk(table.get("uncertain")) if tolerances else ():
        if key in tolerances:
            raise SceneError(f"uncertain.{key}", "is given twice: here and with the value itself")
    return reduce(lambda table, pair: replaced(table, f"uncertain.{pair[0]}", pair[1]), tolerances.items(), table)


def _number(text):
    return float(text) if is_number(text) else text
