"""The rules of numbers: quantities with their unit, tables, positions, impedances, phasors and lists of levels."""

import cmath
import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from fem.parameters import Number
from studies.refusal import SceneError, misread, shown
from studies.scene.quantity import DIMENSIONS, POWERS, si_value
from studies.scene.ranges import read_range
from studies.scene.rule import Rule, choice, entries_of, read_each

# In SI units: no quantity of a motor is larger, or smaller than its inverse; products of a few stay finite.
MAX_SIZE = 1e30
DIGITS = r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?"
PHASED = re.compile(rf"\s*({DIGITS})\s+at\s+([+-]?{DIGITS})\s*(deg|rad)\s*")
QUARTERS = {0.0: 1.0, 90.0: 1j, 180.0: -1.0, 270.0: -1j}  # exact, where cos 90 deg is 6e-17


@dataclass(frozen=True)
class Quantity(Rule, Number):
    """A number with a unit: a number of TOML in the SI unit, or a text."""

    number = property(lambda self: self)

    def takes(self, value):
        if isinstance(value, str):
            return bool(self.unit) and any(character.isdigit() for character in value)
        return hasattr(value, "__float__") and not getattr(value, "ndim", 0)

    def read(self, path, value):
        number = si_value(path, value, self.unit)
        smallest, rule = 0.0 if self.zero or self.signed else 1 / MAX_SIZE, ""
        if not self.holds(number):
            rule = self.sentence(number)
        elif not smallest <= abs(number) <= MAX_SIZE:
            rule = f"must have a size between {smallest:g} and {MAX_SIZE:g}"
        if rule:
            raise SceneError(path, f"{rule}, got {number!r} {self.unit}".rstrip())
        return number + 0.0  # no negative zero

    @property
    def expected(self):
        noun, example = DIMENSIONS[self.unit]
        sign = "" if self.allowed == "finite" else f", {self.allowed.removesuffix(' and finite')}"
        if not self.unit:
            return f"{noun}{sign}"
        return f'{noun} in {self.unit}{sign} (a number, or a string such as "{example}")'

    @property
    def range(self):
        if self.least > -math.inf:
            return f"{self.least:g} to {self.most:g}"
        above = f"> {self.above:g}" if self.above > -math.inf else ""
        sign = above if self.signed else ">= 0" if self.zero else "> 0"
        below = "" if self.below == math.inf else f"< {self.below:g}"
        return ", ".join(filter(None, (sign, below))) or "any"

    def schema(self):
        low = max(self.above, self.least, -MAX_SIZE) if self.signed else 0
        closed = self.zero or (self.signed and low > self.above)
        number = {"type": "number", "maximum": MAX_SIZE, "minimum" if closed else "exclusiveMinimum": low}
        if self.most < math.inf:
            number["maximum"] = self.most
        if self.below < math.inf:
            number["exclusiveMaximum"] = self.below
        if not self.unit:
            return number
        sign = "[+-]?" if self.signed else r"\+?"
        text = {"type": "string", "pattern": rf"^\s*{sign}{DIGITS}\s*({units(self.unit)})\s*$"}
        return {"anyOf": [number, text]}


NUMBER = Quantity(negative=True)


def units(unit: str) -> str:
    """Return the alternatives of a pattern that matches the usual units of an SI unit's dimension."""
    return "|".join(sorted(map(re.escape, POWERS[unit])))


def stated_schema(rule: Rule) -> list[dict]:
    """Return the JSON Schema of ``"VALUE +- TOLERANCE"`` at a key, in a list; empty for a key without a number."""
    if rule.each or not isinstance(rule.number, Quantity):
        return []
    sign, value = rf"(\s+\+/?-\s+|\s*±\s*){DIGITS}", rf"^\s*[+-]?{DIGITS}"
    if not rule.unit:
        return [{"type": "string", "pattern": rf"{value}{sign}\s*%?\s*$"}]
    name = units(rule.unit)
    return [{"type": "string", "pattern": rf"{value}(\s*({name}){sign}(\s*({name}|%))?|{sign}\s*({name}|%))\s*$"}]


@dataclass(frozen=True)
class FixedList(Rule):
    """A list of a fixed length, each entry with a rule of its own."""

    parts: tuple[Rule, ...]
    expected: str
    into: Callable = lambda *entries: entries

    def takes(self, value):
        entries = entries_of(value)
        return entries is not None and len(entries) == len(self.parts)

    def read(self, path, value):
        self.require(self.takes(value), path, value)
        return self.into(*read_each(self.parts, path, entries_of(value)))

    def schema(self):
        size = {"minItems": len(self.parts), "maxItems": len(self.parts)}
        if len(set(self.parts)) == 1:
            return {"type": "array", "items": self.parts[0].schema(), **size}
        return {"type": "array", "prefixItems": [rule.schema() for rule in self.parts], **size}


def matrix(rows: int, columns: int) -> Rule:
    """Return the rule of a table of numbers of a given shape."""
    row = FixedList((NUMBER,) * columns, f"a row of {columns} numbers")
    return FixedList((row,) * rows, f"a {rows}x{columns} table of numbers")


def surface_position(*, negative: bool = False) -> Rule:
    """Return the rule of a position on the surface: x, or [x, y]; [x, 0] is x."""
    along, across = Quantity("m", negative=negative), Quantity("m", negative=True)
    return along | FixedList((along, across), "[x, y]", lambda x, y: (x, y) if y else x)


def as_pair(position: float | tuple[float, float]) -> tuple[float, float]:
    """Return (x, y) of what `surface_position` reads."""
    return position if isinstance(position, tuple) else (position, 0.0)


def impedance(*words: str) -> Rule:
    """Return the rule of a passive impedance: a resistance, [resistance, reactance], or one of the words."""
    parts = (Quantity("ohm", zero=True), Quantity("ohm", negative=True))
    pair = FixedList(parts, "[resistance, reactance] in ohm", _complex)
    return parts[0] | choice(*words) | pair if words else parts[0] | pair


def _complex(real: float, imaginary: float) -> float | complex:
    return complex(real, imaginary) if imaginary else real


class Phased(Rule):
    """An amplitude with a phase, as text."""

    expected = '"amplitude at phase deg" such as "0.5 at 90 deg"'

    def takes(self, value):
        return isinstance(value, str) and PHASED.fullmatch(value) is not None

    def read(self, path, value):
        size, _, _, phase, _, _, unit = PHASED.fullmatch(value).groups()
        size, degrees = float(size), float(phase) if unit == "deg" else math.degrees(float(phase))
        exact = QUARTERS.get(degrees % 360.0)
        amplitude = size * exact if exact is not None else cmath.rect(size, math.radians(degrees))
        return AMPLITUDE.read(path, [amplitude.real, amplitude.imag])

    def schema(self):
        return {"type": "string", "pattern": f"^{PHASED.pattern}$"}


AMPLITUDE = NUMBER | Phased() | FixedList((NUMBER, NUMBER), "[real, imaginary part]", _complex)


@dataclass(frozen=True)
class Listed(Rule):
    """One value or a list that is not empty; ``ranged`` also allows ``"START:STOP:N"``, ``distinct`` only a list."""

    each: Rule
    distinct: bool = False
    ranged: bool = False

    number = property(lambda self: self.each.number)
    unit = property(lambda self: self.each.unit)

    def takes(self, value):
        return entries_of(value) is not None or (not self.distinct and self.each.takes(value))

    def read(self, path, value):
        if self.ranged and isinstance(value, str) and ":" in value:
            value = read_range(path, value, self.unit)
        entries = None if isinstance(value, complex) else entries_of(value)
        if entries is None:
            return (self._alone(path, value),)
        if not entries:
            raise SceneError(path, "must name at least one value, got an empty list")
        values = read_each([self.each] * len(entries), path, entries)
        if self.distinct and len(set(values)) < len(values):
            raise SceneError(path, f"must differ from each other, got {shown(list(values))}")
        return values

    def _alone(self, path, value):
        try:
            return self.each.read(path, value)
        except SceneError:
            if (
                self.ranged
                and isinstance(value, str)
                and re.fullmatch(r"\s*[\d.]+\s*(\w+\s*)?(-|\.\.|to)\s*[\d.]+.*", value)
            ):
                raise misread(path, "START:STOP:N or a list", value) from None
            raise

    expected = property(lambda self: self._several(self.each.expected))
    range = property(lambda self: self._several(self.each.range))

    def _several(self, each):
        if self.distinct:
            return f"a list of different ones, each: {each}"
        return f'{each}; one, a list, or "START:STOP:N" (:log)' if self.ranged else f"{each}; one or a list"

    def schema(self):
        several = {"type": "array", "items": self.each.schema(), "minItems": 1}
        if self.distinct:
            return several | {"uniqueItems": True}
        either = [self.each.schema(), several]
        if self.ranged:
            end = rf"\s*{DIGITS}\s*({units(self.unit)})?\s*"
            either.append({"type": "string", "pattern": rf"^{end}:{end}:\s*\d+\s*(:\s*log\s*)?$"})
        return {"anyOf": either}
