"""Published quantities of motors and the inputs of their predictions: reads ``published_motors.toml``.

A quantity that a paper does not state exactly is an `Unknown`; a published quantity and the inputs of its prediction
are a `Comparison`.
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
    """A published quantity, and the model that predicts it for every combination of the unknown inputs."""

    motor: str
    quantity: str
    published: tuple[float | str, ...]  # a value, or the ends of a range; a string: value of that model
    model: str  # key of `published_motors.MODELS`
    taken: dict[str, Any]  # inputs of the model, stated or assumed, in SI units
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
    return tuple(_comparison(motor, entry) for motor in _table()["motor"] for entry in motor["row"])


def left_aside() -> dict[str, str]:
    """Return the published motors that are not computed, and why."""
    return dict(_table()["left_aside"])


def _table() -> dict:
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def _comparison(motor: dict, entry: dict) -> Comparison:
    entry = dict(entry)
    inputs = motor.get("unknown", {}) | entry.pop("unknown", {})
    unknowns = {key: Unknown(**{"name": key} | each | {"swept": tuple(each["swept"])}) for key, each in inputs.items()}
    published = entry.pop("published")
    return Comparison(
        motor=motor["name"],
        published=tuple(published) if isinstance(published, list) else (published,),
        taken=motor.get("fixed", {}) | {key: each.taken for key, each in unknowns.items()},
        swept={key: unknowns[key] for key in entry.pop("swept")},
        **entry,
    )
