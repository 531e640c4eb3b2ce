"""Checks of the shapes of a kernel's arrays before a call, because kernels check no index.

A shape is written as in "n 4": a number, a letter that stands for the same length wherever it occurs in a call, or a
number of times a letter and a number ("2+4k"). "2 | 2+4k" allows either shape.
"""

import re
from collections.abc import Mapping
from typing import Any

_LENGTH = re.compile(r"(?:(\d+)\+)?(\d*)([a-z]?)")


def check_shapes(kernel: str, declared: Mapping[str, str], arguments: Mapping[str, object]) -> None:
    """Raise a ValueError for arrays that do not have the shapes that a kernel declares.

    `declared` are shapes by argument, a field of a named tuple as "argument.field"; None has no shape.
    """
    lengths: dict[str, int] = {}
    for name, shapes in declared.items():
        array: Any = arguments
        for part in name.split("."):
            array = array[part] if isinstance(array, Mapping) else getattr(array, part, None)
            if array is None:
                break
        if array is None:
            continue
        if not any(_fits(shape.split(), array.shape, lengths) for shape in shapes.split("|")):
            known = ", ".join(f"{letter} = {length}" for letter, length in lengths.items())
            raise ValueError(
                f"{kernel}: {name} has the shape {array.shape}, but ({shapes.strip()}) is expected"
                + (f" with {known}" if known else "")
            )


def _fits(declared, shape, lengths):
    """Return True if a shape is as declared; letters that are new take their lengths from it."""
    if len(declared) != len(shape):
        return False
    found = dict(lengths)
    for word, length in zip(declared, shape, strict=True):
        offset, factor, letter = _LENGTH.fullmatch(word).groups()
        rest = length - int(offset or 0)
        if not letter:
            if rest != int(factor):
                return False
            continue
        number, left = divmod(rest, int(factor or 1))
        if left or number < 0 or found.setdefault(letter, number) != number:
            return False
    lengths.update(found)
    return True
