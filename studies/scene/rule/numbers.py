"""Numbers: quantities with their unit, counts, impedances and tables."""

import re
from dataclasses import dataclass

from studies.refusal import SceneError, shown
from studies.scene.quantity import DIMENSIONS, POWERS, si_value
from studies.scene.rule.protocol import Rule
from studies.scene.rule.words import Choice

# In SI units: beyond it, and below its inverse, no motor has a quantity; products of a few stay finite.
MAX_SIZE = 1e30
DIGITS = r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?"


def units(unit: str) -> str:
    """Return the alternatives of a pattern that matches the usual units of an SI unit's dimension."""
    return "|".join(sorted(map(re.escape, POWERS[unit])))


@dataclass(frozen=True)
class Quantity(Rule):
    """A number with a unit; ``words`` are the texts that stand for a number found later."""

    unit: str = ""
    zero: bool = False
    negative: bool = False
    below: float | None = None
    words: tuple[str, ...] = ()

    def read(self, path, value):
        """Return a float, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        if isinstance(value, str) and self.words and not any(character.isdigit() for character in value):
            raise SceneError(path, f'must be {self._allowed} or "{self.words[0]}", got {shown(value)}')
        number = si_value(path, value, self.unit)
        if (number < 0 and not self.negative) or (number == 0 and not (self.zero or self.negative)):
            raise SceneError(path, f"must be {self._allowed}, got {number!r} {self.unit}".rstrip())
        if self.below is not None and number >= self.below:
            raise SceneError(path, f"must be {self._allowed}, got {number!r} {self.unit}".rstrip())
        smallest = 0.0 if self.zero or self.negative else 1 / MAX_SIZE
        if not smallest <= abs(number) <= MAX_SIZE:
            size = f"must have a size between {smallest:g} and {MAX_SIZE:g}"
            raise SceneError(path, f"{size}, got {number!r} {self.unit}".rstrip())
        return number + 0.0  # no negative zero

    @property
    def expected(self):
        noun, example = DIMENSIONS[self.unit]
        number = f"{noun} in {self.unit}" if self.unit else noun
        sign = (
            "" if self.negative and self.below is None else f", {self._allowed.removesuffix(' and finite')}"
        )
        text = f' (a number, or a string such as "{example}")' if self.unit else ""
        return " or ".join([f"{number}{sign}{text}", *(f'"{word}"' for word in self.words)])

    @property
    def range(self):
        sign = "any" if self.negative else ">= 0" if self.zero else "> 0"
        below = "" if self.below is None else f"{', ' if sign != 'any' else ''}< {self.below:g}"
        return ", or ".join(
            [(sign if sign != "any" or not below else "") + below, *(f'"{word}"' for word in self.words)]
        )

    def schema(self):
        number = {"type": "number", "maximum": MAX_SIZE}
        if self.negative:
            number["minimum"] = -MAX_SIZE
        else:
            number |= {"minimum": 0} if self.zero else {"exclusiveMinimum": 0}
        if self.below is not None:
            number["exclusiveMaximum"] = self.below
        either = [number]
        if self.unit:
            sign = "[+-]?" if self.negative else r"\+?"
            either.append({"type": "string", "pattern": rf"^\s*{sign}{DIGITS}\s*({units(self.unit)})\s*$"})
        if self.words:
            either.append({"enum": list(self.words)})
        return either[0] if len(either) == 1 else {"anyOf": either}

    @property
    def _allowed(self) -> str:
        sign = "finite" if self.negative else "zero or positive" if self.zero else "positive and finite"
        return sign if self.below is None else f"{sign} and below {self.below:g}"


@dataclass(frozen=True)
class Count(Rule):
    """An integer of at least 1."""

    maximum: int = 1_000_000

    def read(self, path, value):
        """Return the integer."""
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= self.maximum:
            raise SceneError(path, f"must be {self.expected}, got {shown(value)}")
        return value

    @property
    def expected(self):
        return f"an integer from 1 to {self.maximum}"

    def schema(self):
        return {"type": "integer", "minimum": 1, "maximum": self.maximum}


@dataclass(frozen=True)
class Impedance(Rule):
    """A passive impedance in ohm: a quantity, [resistance, reactance], or one of the words."""

    words: tuple[str, ...] = ()

    def read(self, path, value):
        """Return a float, a complex number or a word."""
        if isinstance(value, complex):
            value = [value.real, value.imag]
        if isinstance(value, (list, tuple)):
            if len(value) != 2:
                raise SceneError(
                    path, f"must be an impedance, [resistance, reactance] in ohm, got {shown(value)}"
                )
            resistance = Quantity("ohm", zero=True).read(f"{path}.0", value[0])
            reactance = Quantity("ohm", negative=True).read(f"{path}.1", value[1])
            return complex(resistance, reactance) if reactance else resistance
        if isinstance(value, str) and self.words and not any(character.isdigit() for character in value):
            return Choice(self.words).read(path, value)
        return Quantity("ohm", zero=True).read(path, value)

    def written(self, value):
        return [value.real, value.imag] if isinstance(value, complex) else value

    @property
    def expected(self):
        words = "".join(f' or "{word}"' for word in self.words)
        return f'a resistance in ohm, a string such as "50 ohm", [resistance, reactance] in ohm{words}'

    @property
    def unit_name(self):
        return "ohm"

    def schema(self):
        resistance = Quantity("ohm", zero=True, words=self.words).schema()["anyOf"]
        pair = [Quantity("ohm", zero=True).schema(), Quantity("ohm", negative=True).schema()]
        return {"anyOf": [*resistance, {"type": "array", "prefixItems": pair, "minItems": 2, "maxItems": 2}]}


@dataclass(frozen=True)
class Place(Rule):
    """A place on the surface: x, which ``along`` reads, or [x, y]; [x, 0] is x."""

    along: Quantity

    def read(self, path, value):
        """Return x, or the pair (x, y) in m."""
        if hasattr(value, "tolist"):
            value = value.tolist()
        if not isinstance(value, (list, tuple)):
            return self.along.read(path, value)
        if len(value) != 2:
            raise SceneError(path, f"must be {self.expected}, got {shown(list(value))}")
        lateral = Quantity(self.along.unit, negative=True)
        x, y = self.along.read(f"{path}.0", value[0]), lateral.read(f"{path}.1", value[1])
        return (x, y) if y else x

    def written(self, value):
        return list(value) if isinstance(value, tuple) else value

    @property
    def expected(self):
        return f"{self.along.expected}, or [x, y]"

    @property
    def unit_name(self):
        return self.along.unit

    def schema(self):
        along, lateral = self.along.schema(), Quantity(self.along.unit, negative=True).schema()
        pair = {"type": "array", "prefixItems": [along, lateral], "minItems": 2, "maxItems": 2}
        return {"anyOf": [along, pair]}


def as_pair(place: float | tuple[float, float]) -> tuple[float, float]:
    """Return (x, y) of what `Place` reads."""
    return place if isinstance(place, tuple) else (place, 0.0)


@dataclass(frozen=True)
class Matrix(Rule):
    """A table of numbers of a given shape."""

    rows: int
    columns: int

    def read(self, path, value):
        """Return a tuple of rows."""
        if hasattr(value, "tolist"):
            value = value.tolist()
        if not isinstance(value, (list, tuple)) or len(value) != self.rows:
            raise SceneError(path, f"must be {self.expected}, got {shown(value)}")
        for row in value:
            if not isinstance(row, (list, tuple)) or len(row) != self.columns:
                raise SceneError(path, f"must be {self.expected}, got the row {shown(row)}")
        return self.read_each(Row(), path, value)

    def written(self, value):
        return [list(row) for row in value]

    @property
    def expected(self):
        return f"a {self.rows}x{self.columns} table of numbers"

    def schema(self):
        row = {
            "type": "array",
            "items": {"type": "number"},
            "minItems": self.columns,
            "maxItems": self.columns,
        }
        return {"type": "array", "items": row, "minItems": self.rows, "maxItems": self.rows}


class Row(Rule):
    """One row of a table of numbers."""

    def read(self, path, value):
        """Return a tuple of floats."""
        return self.read_each(Quantity(negative=True), path, value)
