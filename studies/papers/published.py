"""What papers state and do not state about their motors: reads ``published_motors.toml``.

A quantity that a paper does not state exactly is an `Unknown`. A published quantity, with all that its prediction
needs, is a `Comparison`.
"""

import tomllib
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("published_motors.toml")


@dataclass(frozen=True, kw_only=True)
class Unknown:
    """A quantity that a paper does not state exactly: the assumed value and the swept range, in SI units."""

    name: str
    taken: float | str
    swept: tuple[float | str, ...]
    unit: str = ""
    scale: float = 1.0

    def __str__(self):
        if isinstance(self.taken, str):
            return f"{self.name} {' or '.join(map(str, self.swept))}"
        low, high = min(self.swept) * self.scale, max(self.swept) * self.scale
        return f"{self.name} {low:.4g} to {high:.4g}{' ' * bool(self.unit)}{self.unit}"


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A published quantity, and the model that predicts it over every combination of what is unknown."""

    motor: str
    quantity: str
    published: tuple[float | str, ...]  # a value, or the ends of a range; a word: the value of that model, as taken
    model: str  # key of `published_motors.MODELS`
    taken: dict[str, Any]  # every input of the model, as stated or assumed, in SI units
    swept: dict[str, Unknown]
    unit: str = ""
    scale: float = 1.0
    remark: str = ""


def corners(unknowns: dict[str, Unknown]):
    """Yield every combination of the swept values, by name."""
    for values in product(*(unknown.swept for unknown in unknowns.values())):
        yield dict(zip(unknowns, values, strict=True))


@cache
def comparisons() -> tuple[Comparison, ...]:
    """Return all comparisons in the order of the file."""
    return tuple(_comparison(motor, row) for motor in _table()["motor"] for row in motor["row"])


def left_aside() -> dict[str, str]:
    """Return what published motors are not computed, and why."""
    return dict(_table()["left_aside"])


def _table() -> dict:
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def _comparison(motor: dict, row: dict) -> Comparison:
    row = dict(row)
    inputs = motor.get("unknown", {}) | row.pop("unknown", {})
    unknowns = {key: Unknown(**{"name": key} | each | {"swept": tuple(each["swept"])}) for key, each in inputs.items()}
    published = row.pop("published")
    return Comparison(
        motor=motor["name"],
        published=tuple(published) if isinstance(published, list) else (published,),
        taken=motor.get("fixed", {}) | {key: each.taken for key, each in unknowns.items()},
        swept={key: unknowns[key] for key in row.pop("swept")},
        **row,
    )
