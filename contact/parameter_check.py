"""Checks of physical parameters.

Rules of several parameters together are methods ``check_...`` of their class, see `Checks`.
A check that fails raises an `InputError` that names parameter, rule, value and unit:
``slider.radius must be positive and finite, got -1e-06 m``.
"""

import cmath
import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import numpy as np

from contact.exceptions import InputError


def refuse_if(broken: Any, name: str, rule: str, value: object = None, unit: str = "") -> None:
    """Raise an InputError about a parameter if a condition holds."""
    if broken:
        raise InputError(name, rule, value, unit)


def positive(name: str, value: float, unit: str) -> float:
    """Return `value` as a float if it is positive and finite, else raise."""
    return _checked(name, value, unit, "positive and finite", lambda v: 0.0 < v < math.inf)


def non_negative(name: str, value: float, unit: str) -> float:
    """Return `value` as a float if it is zero or positive, and finite, else raise."""
    return _checked(name, value, unit, "zero or positive, and finite", lambda v: 0.0 <= v < math.inf)


def finite(name: str, value: float, unit: str) -> float:
    """Return `value` as a float if it is finite, else raise."""
    return _checked(name, value, unit, "finite", math.isfinite)


def finite_complex(name: str, value: complex, unit: str) -> complex:
    """Return `value` as a complex number if both its parts are finite, else raise."""
    return _checked(name, value, unit, "a finite complex number", cmath.isfinite, kind=complex)


def count(name: str, value: int, least: int) -> int:
    """Return `value` as an int if it is a whole number of at least `least`, else raise."""
    if isinstance(value, bool | str) or np.ndim(value) != 0 or value != value or int(value) != value or value < least:
        raise InputError(name, f"must be a whole number of at least {least}", value)
    return int(value)


def choice(name: str, value: str, allowed: tuple[str, ...]) -> str:
    """Return `value` if it is one of `allowed`, else raise."""
    if value not in allowed:
        raise InputError(name, "must be one of " + ", ".join(map(repr, allowed)), value)
    return value


class Checks:
    """Base of the classes whose methods ``check_...`` yield a field, and the rest of the sentence about it.

    They use attributes alone, so that they also check anything else that has these, before there is an object.
    """

    checks: ClassVar[tuple[Callable[[Any], Iterator[tuple[str, str]]], ...]] = ()

    def __init_subclass__(cls) -> None:
        own = tuple(method for name, method in vars(cls).items() if name.startswith("check_"))
        cls.checks = own or cls.checks

    def _refuse(self, prefix: str) -> None:
        """Raise the first refusal of the checks, an InputError about a field behind a prefix."""
        for check in self.checks:
            for name, sentence in check(self):
                raise InputError(".".join(filter(None, (prefix, name))), sentence)


def _checked(name, value, unit, rule, holds, kind=float):
    try:
        other = (bool, str) if kind is complex else (bool, str, complex)
        if isinstance(value, other) or not (isinstance(value, (int, float, complex)) or np.ndim(value) == 0):
            raise TypeError
        number = kind(value)
        if not holds(number):
            raise ValueError
    except (TypeError, ValueError):
        raise InputError(name, f"must be {rule}", value, unit) from None
    return number
