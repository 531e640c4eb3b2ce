"""The rules of the keys of a scene: how a value is read, what is allowed, how it is written back.

A rule's ``read(path, value)`` returns the value in SI units, immutable, or raises SceneError; it accepts
values of a TOML file and values that it has returned.  ``written(value)`` is the inverse, in terms of a TOML document.
``expected`` says in words what is allowed, ``range`` in fewer, ``schema()`` as JSON Schema (draft 2020-12).
``Quantity("N") | choice("weight")`` takes what either takes; the rules of numbers are in ``numbers``.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from fem import parameters
from studies.refusal import all_answers, misread, resembling


class Rule:
    """The rule of a value."""

    expected: str  # as a noun: ``a length in m, positive (a number, or a string such as "5 mm")``
    words: tuple[str, ...] = ()  # the texts that it takes, of a choice
    unit = ""  # the SI unit of its numbers
    number: "Rule | None" = None  # of a single number: a Quantity or a Count; None where it takes none
    each: "Rule | None" = None  # of the entries of a list

    def read(self, path, value):
        raise NotImplementedError

    def takes(self, value) -> bool:
        """Return whether this rule, of several in `Either`, reads or refuses a value."""
        raise NotImplementedError

    def written(self, value):
        """Return what a TOML document holds for a value that was read."""
        if hasattr(value, "to_table"):
            return value.to_table()
        if isinstance(value, complex):
            return [value.real, value.imag]
        return [self.written(each) for each in value] if isinstance(value, tuple) else value

    @property
    def range(self) -> str:
        return self.expected

    def schema(self) -> dict:
        raise NotImplementedError

    def require(self, held: bool, path, value) -> None:
        """Raise a SceneError that quotes the value, unless the rule held."""
        if not held:
            hint = resembling(value, self.words) if isinstance(value, str) and len(self.words) > 1 else ""
            raise misread(path, self.expected, value, hint)

    def __or__(self, other):
        return Either((*getattr(self, "rules", (self,)), *getattr(other, "rules", (other,))))


@dataclass(frozen=True)
class Either(Rule):
    """A value that one of several rules takes."""

    rules: tuple[Rule, ...]

    def read(self, path, value):
        rule = next((each for each in self.rules if each.takes(value)), None)
        self.require(rule is not None, path, value)
        return rule.read(path, value)

    def takes(self, value):
        return any(rule.takes(value) for rule in self.rules)

    expected = property(lambda self: " or ".join(rule.expected for rule in self.rules))
    range = property(lambda self: ", or ".join(rule.range for rule in self.rules))
    words = property(lambda self: tuple(word for rule in self.rules for word in rule.words))
    unit = property(lambda self: next((rule.unit for rule in self.rules if rule.unit), ""))
    number = property(lambda self: next((rule.number for rule in self.rules if rule.number), None))
    each = property(lambda self: next((rule.each for rule in self.rules if rule.each), None))

    def schema(self):
        parts = [rule.schema() for rule in self.rules]
        return {"anyOf": [each for part in parts for each in part.get("anyOf", [part])]}


@dataclass(frozen=True)
class Plain(Rule):
    """A value that is kept unchanged if a test holds."""

    expected: str
    holds: Callable
    json: dict
    words: tuple[str, ...] = ()

    def takes(self, value):
        return self.holds(value)

    def read(self, path, value):
        self.require(self.holds(value), path, value)
        return value

    def schema(self):
        return dict(self.json)


def _plain(rule: parameters.ValueRule, json: dict, words: tuple[str, ...] = ()) -> Plain:
    """Return the rule of a key whose value is kept unchanged where a rule of parameters allows it."""
    return Plain(rule.allowed, rule.allows, json, words)


class Count(Plain):
    """An integer of at least 1."""

    number = property(lambda self: self)

    def __init__(self, most: int):
        rule = parameters.Count(most=most)
        super().__init__(rule.allowed, rule.allows, {"type": "integer", "minimum": 1, "maximum": most})


def choice(*words: str) -> Rule:
    """Return the rule of one of a few words."""
    return _plain(parameters.Words(words), {"enum": list(words)}, words)


def signs(allowed: str) -> Rule:
    """Return the rule of a text of the allowed signs, at least one."""
    return _plain(parameters.Signs(allowed), {"type": "string", "pattern": f"^[{re.escape(allowed)}]+$"})


@dataclass(frozen=True)
class Field(Rule):
    """Stands for the rule of a field of the block's object, by default of the key's name.

    ``name``: of a field, of a field of another object as in ``fem.Solid.density``, or of a list of words as in
    ``fem.FORMS``.
    """

    name: str = ""


FIELD = Field()


TEXT = Plain("text on one line", lambda value: isinstance(value, str) and value.isprintable(), {"type": "string"})
FLAG = Plain("true or false", lambda value: isinstance(value, bool), {"type": "boolean"})
RANDOM_SEED = Plain(
    "an integer of at least 0",
    lambda value: type(value) is int and 0 <= value < 2**63,
    {"type": "integer", "minimum": 0},
)


@dataclass(frozen=True)
class Named(Rule):
    """A table of values by name, at least one; read as pairs in the order of the file."""

    expected: str
    value: Rule

    def read(self, path, value):
        value = dict(value) if isinstance(value, tuple) else value
        self.require(isinstance(value, dict) and bool(value), path, value)
        return tuple(zip(value, read_each([self.value] * len(value), path, value.values(), value), strict=True))

    def written(self, value):
        return {name: super(Named, self).written(each) for name, each in value}

    def schema(self):
        return {"type": "object", "minProperties": 1, "additionalProperties": self.value.schema()}


def as_table(path: str, value) -> dict:
    """Return a table of keys and values; a SceneError for anything else."""
    if not isinstance(value, dict):
        raise misread(path, "a block of keys", value)
    return value


def entries_of(value) -> list | None:
    """Return the entries of a list, an array, a range or a complex number; None of anything else."""
    if isinstance(value, complex):
        return [value.real, value.imag]
    value = value.tolist() if hasattr(value, "tolist") else value
    return list(value) if isinstance(value, (list, tuple, range)) else None


def read_each(rules, path: str, values, names=None) -> tuple:
    """Return the entries of a list, or of a table with names, read by a rule each; one error carries all faults."""
    each = zip(names or range(len(rules)), rules, values, strict=True)
    return tuple(all_answers(partial(rule.read, f"{path}.{name}", value) for name, rule, value in each))
