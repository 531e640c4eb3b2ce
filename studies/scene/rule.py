"""The rules that a key of a scene obeys: how its value is read, what is allowed, how it is written back.

A rule's ``read(path, value)`` returns the value in SI units, immutable, or raises SceneError; it accepts what
a TOML file holds and what it returned before.  ``written(value)`` is the inverse, in terms of a TOML
document.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from studies.refusal import SceneError, nearest, shown
from studies.scene.quantity import si_value

__all__ = ["Choice", "Count", "Flag", "Impedance", "Listed", "Matrix", "Quantity", "Rule", "Signs", "Text"]


LARGEST = 1e30  # in SI units; beyond it, and below its inverse, no motor has a quantity: products stay finite


class Rule:
    """What a value may be."""

    def read(self, path: str, value) -> Any:
        """Return the value in SI units, immutable."""
        raise NotImplementedError

    def written(self, value) -> Any:
        """Return what a TOML document holds for a value that was read."""
        return value


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
        smallest = 0.0 if self.zero or self.negative else 1 / LARGEST
        if not smallest <= abs(number) <= LARGEST:
            size = f"must have a size between {smallest:g} and {LARGEST:g}"
            raise SceneError(path, f"{size}, got {number!r} {self.unit}".rstrip())
        return number + 0.0  # no negative zero

    @property
    def _allowed(self) -> str:
        sign = "finite" if self.negative else "zero or positive" if self.zero else "positive and finite"
        return sign if self.below is None else f"{sign} and below {self.below:g}"


@dataclass(frozen=True)
class Choice(Rule):
    """One of a few words."""

    words: tuple[str, ...]

    def read(self, path, value):
        """Return the word."""
        if not isinstance(value, str) or value not in self.words:
            allowed = " or ".join(f'"{word}"' for word in self.words)
            hint = nearest(value, self.words) if isinstance(value, str) and len(self.words) > 1 else ""
            raise SceneError(path, f"must be {allowed}, got {shown(value)}{hint if 'mean' in hint else ''}")
        return value


@dataclass(frozen=True)
class Text(Rule):
    """Free text on one line."""

    def read(self, path, value):
        """Return the text."""
        if not isinstance(value, str) or not value.isprintable():
            raise SceneError(path, f"must be text on one line, got {shown(value)}")
        return value


@dataclass(frozen=True)
class Signs(Rule):
    """A row of signs, at least one."""

    allowed: str

    def read(self, path, value):
        """Return the text."""
        if not isinstance(value, str) or not value or set(value) - set(self.allowed):
            signs = " ".join(self.allowed)
            raise SceneError(path, f"must be a text of the signs {signs}, got {shown(value)}")
        return value


@dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def read(self, path, value):
        """Return the boolean."""
        if not isinstance(value, bool):
            raise SceneError(path, f"must be true or false, got {shown(value)}")
        return value


@dataclass(frozen=True)
class Count(Rule):
    """An integer of at least 1."""

    most: int = 1_000_000

    def read(self, path, value):
        """Return the integer."""
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= self.most:
            raise SceneError(path, f"must be an integer from 1 to {self.most}, got {shown(value)}")
        return value


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
        """Return the pair of a complex value."""
        return [value.real, value.imag] if isinstance(value, complex) else value


@dataclass(frozen=True)
class Listed(Rule):
    """One value or a list that is not empty; ``alone`` is the rule of a single value, if another one."""

    each: Rule
    alone: Rule | None = None
    distinct: bool = False

    def read(self, path, value):
        """Return a tuple, or what ``alone`` makes of a single value."""
        if not isinstance(value, (list, tuple)):
            if self.alone is not None:
                return self.alone.read(path, value)
            return (self.each.read(path, value),)
        if not value:
            raise SceneError(path, "must name at least one value, got an empty list")
        values = tuple(self.each.read(f"{path}.{index}", entry) for index, entry in enumerate(value))
        if self.distinct and any(first == second for first, second in pairwise(sorted(values))):
            raise SceneError(path, f"must differ from each other, got {shown(list(values))}")
        return values

    def written(self, value):
        """Return a list."""
        return list(value) if isinstance(value, tuple) else value


@dataclass(frozen=True)
class Matrix(Rule):
    """A table of numbers of a given shape."""

    rows: int
    columns: int

    def read(self, path, value):
        """Return a tuple of rows."""
        wanted = f"must be a {self.rows}x{self.columns} table of numbers"
        if hasattr(value, "tolist"):
            value = value.tolist()
        if not isinstance(value, (list, tuple)) or len(value) != self.rows:
            raise SceneError(path, f"{wanted}, got {shown(value)}")
        for row in value:
            if not isinstance(row, (list, tuple)) or len(row) != self.columns:
                raise SceneError(path, f"{wanted}, got the row {shown(row)}")
        entry = Quantity(negative=True)
        return tuple(
            tuple(entry.read(f"{path}.{i}.{j}", number) for j, number in enumerate(row))
            for i, row in enumerate(value)
        )

    def written(self, value):
        """Return lists."""
        return [list(row) for row in value]
