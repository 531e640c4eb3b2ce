"""The stator's answer at the contacts of a sweep, as it is kept and sent to workers: motion, admittance, error."""

import json
from dataclasses import asdict, dataclass
from functools import cached_property

from studies.refusal import RunError, SceneError


def reason(error: Exception) -> str:
    """Return why a point or a stator has no answer, as a row's status says it."""
    text = " ".join(str(error).split())
    if isinstance(error, SceneError):
        return f"refused: {text}"
    if isinstance(error, RunError):
        return f"no answer: {text}"
    if isinstance(error, MemoryError):
        return "no answer: it needs more memory than the worker has"
    return f"no answer: a defect of sawmotor: {type(error).__name__}: {text}"


@dataclass(frozen=True, kw_only=True)
class Source:
    """Surface motion per volt where contacts may be."""

    name: str  # the values that it depends on, as JSON
    step: int  # 0 to ``STEPS - 1``
    frequency: float = 0.0  # Hz
    places: tuple[tuple[float, float], ...] = ()  # x and y in m
    tangential: tuple[complex, ...] = ()  # m per V
    normal: tuple[complex, ...] = ()  # m per V
    errors: tuple[float | None, ...] = ()  # relative, at each place; None where there is no answer
    covered: tuple[bool, ...] = ()  # whether the place lies under a transducer
    admittance: complex = 0.0  # S
    comb_voltage: complex = 1.0  # V per V of the source
    reason: str = ""  # why there is no answer; empty where there is one

    def index(self, place: tuple[float, float]) -> int:
        """Return which of the places this one is."""
        return self._index[place]

    def orbits(self, places: tuple[tuple[float, float], ...]) -> tuple:
        """Return the contact.Orbit of 1 V at some of the places."""
        if places not in self._orbits:
            from contact import Orbit

            self._orbits[places] = tuple(
                Orbit(frequency=self.frequency, normal=self.normal[k], tangential=self.tangential[k])
                for k in map(self.index, places)
            )
        return self._orbits[places]

    @cached_property
    def _index(self) -> dict[tuple[float, float], int]:
        return {place: k for k, place in enumerate(self.places)}

    @cached_property
    def _orbits(self) -> dict:
        return {}

    def text(self) -> str:
        """Return it as JSON, complex numbers as [re, im], every digit kept."""
        return json.dumps(asdict(self), default=lambda number: [number.real, number.imag])

    @classmethod
    def read(cls, text: str) -> "Source":
        """Return what ``text`` wrote."""
        table = json.loads(text)
        for key in ("tangential", "normal"):
            table[key] = tuple(complex(*pair) for pair in table[key])
        for key in ("admittance", "comb_voltage"):
            table[key] = complex(*table[key]) if isinstance(table[key], list) else complex(table[key])
        table["places"] = tuple(map(tuple, table["places"]))
        for key in ("errors", "covered"):
            table[key] = tuple(table[key])
        return cls(**table)
