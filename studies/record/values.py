"""Named values of a record as attributes: the base class of its points and blocks."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import FrozenInstanceError
from typing import Any, ClassVar, NoReturn, Self, dataclass_transform

import numpy as np

# Types of fields.  A field without a value is None; `Any` spares its readers the question where the value must exist.
Number = float | Any
Count = int | Any
Complex = complex | Any
Text = str | Any
Flag = bool | Any
Pair = tuple[float, float] | Any


@dataclass_transform(kw_only_default=True, frozen_default=True)
class Values(Mapping[str, Any]):
    """Values of the fields that a subclass declares, each None where it is absent; they cannot be changed.

    The values that are present also make a mapping, by the keys of run.json, in the order in which they were set:
    ``values["frequency_Hz"]``, ``values.get(key)``, ``key in values``, ``dict(values)``.  ``values | others`` returns
    the values of both, those of ``others`` where both have one; None in ``others`` takes nothing away.

    Type checkers and editors treat a subclass as a frozen dataclass.  It is none of the standard library, because only
    the values that are present are stored: a point has 80 fields, of which a sweep sets 5.

    Raises
    ------
    TypeError
        If an argument is no field.

    Examples
    --------
    >>> class Wave(Values):
    ...     frequency_Hz: Number = None
    ...     surface_ratio: Number = None
    >>> wave = Wave(frequency_Hz=1e6) | Wave(surface_ratio=0.7)
    >>> wave.surface_ratio, wave["frequency_Hz"], Wave(frequency_Hz=2e6).surface_ratio
    (0.7, 1000000.0, None)
    """

    fields: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls) -> None:
        cls.fields = frozenset(cls.__annotations__)

    def __init__(self, **values: Any) -> None:
        if not self.fields.issuperset(values):
            raise TypeError(f"{type(self).__name__} has no field {', '.join(sorted(values.keys() - self.fields))}")
        self.__dict__.update({key: value for key, value in values.items() if value is not None})

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> Self:
        """Return the values of a mapping; of a file of another version also those that are no field."""
        if type(values) is cls:  # isinstance costs 1 us, as a mapping is an abstract class
            return values
        new = object.__new__(cls)
        new.__dict__.update({key: value for key, value in values.items() if value is not None})
        return new

    def to_dict(self) -> dict[str, Any]:
        """Return the values that are present, by the keys of run.json."""
        return dict(self.__dict__)

    def __or__(self, other: Mapping[str, Any]) -> Self:
        new = object.__new__(type(self))
        new.__dict__.update(self.__dict__ | self.read(other).__dict__)
        return new

    def __getitem__(self, key: str) -> Any:
        return self.__dict__[key]

    def __contains__(self, key: object) -> bool:
        return key in self.__dict__

    def __iter__(self) -> Iterator[str]:
        return iter(self.__dict__)

    def __len__(self) -> int:
        return len(self.__dict__)

    def __setattr__(self, key: str, value: Any) -> NoReturn:
        raise FrozenInstanceError(f"cannot assign to field {key!r}")

    def __delattr__(self, key: str) -> NoReturn:
        raise FrozenInstanceError(f"cannot delete field {key!r}")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{key}={value!r}' for key, value in self.__dict__.items())})"


class Columns(dict):
    """Columns of a table by name, which also are attributes: ``columns.frequency_Hz``.

    Examples
    --------
    >>> Columns(frequency_Hz=[1e6]).frequency_Hz
    [1000000.0]
    """

    @classmethod
    def read(cls, columns: Mapping[str, Any]) -> Self:
        """Return the columns of a mapping."""
        return columns if isinstance(columns, cls) else cls(columns)

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"no column {name!r}")
        return self[name]


def as_array(values: Iterable[Any]) -> np.ndarray:
    """Return numbers as an array of floats, or of complex numbers if one is complex; NaN for None.

    Examples
    --------
    >>> as_array([1.0, None])
    array([ 1., nan])
    """
    present = [math.nan if value is None else value for value in values]
    return np.array(present, dtype=complex if any(isinstance(value, complex) for value in present) else float)
