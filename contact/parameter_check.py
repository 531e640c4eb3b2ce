"""Checks of physical parameters.

A check that fails raises an `InputError` that names parameter, rule, value and unit:
``slider.radius must be positive and finite, got -1e-06 m``.
"""

import math

import numpy as np

from contact.exceptions import InputError


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
    if isinstance(value, bool | str) or np.ndim(value) != 0:
        raise InputError(name, "must be a finite complex number", value, unit)
    try:
        number = complex(value)
    except (TypeError, ValueError):
        raise InputError(name, "must be a finite complex number", value, unit) from None
    if not (math.isfinite(number.real) and math.isfinite(number.imag)):
        raise InputError(name, "must be finite", value, unit)
    return number


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


def _checked(name, value, unit, rule, holds):
    if isinstance(value, bool | str | complex) or np.ndim(value) != 0:
        raise InputError(name, f"must be {rule}", value, unit)
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(name, f"must be {rule}", value, unit) from None
    if not holds(number):
        raise InputError(name, f"must be {rule}", value, unit)
    return number
