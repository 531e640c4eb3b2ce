"""The rules that a key of a scene obeys: how its value is read, what is allowed, how it is written back.

A rule's ``read(path, value)`` returns the value in SI units, immutable, or raises SceneError; it accepts what
a TOML file holds and what it returned before.  ``written(value)`` is the inverse, in terms of a TOML document.
``expected`` says in words what is allowed, ``schema()`` says it as JSON Schema (draft 2020-12).
"""

from studies.scene.rule.listed import Listed
from studies.scene.rule.numbers import Count, Impedance, Matrix, Place, Quantity, as_pair
from studies.scene.rule.protocol import Rule
from studies.scene.rule.words import Choice, Flag, Signs, Text

__all__ = [
    "Choice",
    "Count",
    "Flag",
    "Impedance",
    "Listed",
    "Matrix",
    "Place",
    "Quantity",
    "Rule",
    "Signs",
    "Text",
    "as_pair",
]
