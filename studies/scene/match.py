"""The rule of ``drive.match``: nothing, the best lossless L-section, or a ladder of named elements."""

from dataclasses import dataclass

from studies.refusal import Refusals, SceneError, nearest, shown
from studies.scene.rule import Quantity, Rule

UNITS = {"L": "H", "C": "F", "R": "ohm"}
ELEMENTS = {f"{place}_{kind}": unit for place in ("series", "shunt") for kind, unit in UNITS.items()}


@dataclass(frozen=True)
class Match(Rule):
    """A word, or a list of tables of one element each, from the source to the transducer."""

    def read(self, path, value):
        """Return the word, or a tuple of elements, each ``((name, value),)`` or with ``("Q", quality)``."""
        if value in ("none", "auto"):
            return value
        if not isinstance(value, (list, tuple)) or not value:
            raise SceneError(path, f"must be {self.expected}, got {shown(value)}")
        refusals, elements = Refusals(), []
        for index, element in enumerate(value):
            with refusals:
                elements.append(_element(f"{path}.{index}", element))
        refusals.raise_all()
        return tuple(elements)

    def written(self, value):
        return value if isinstance(value, str) else [dict(element) for element in value]

    @property
    def expected(self):
        return '"none", "auto" or a ladder such as [{ series_L = "2.6 uH", Q = 80 }, { shunt_C = "1 nF" }]'

    @property
    def range(self):
        return f'"none", "auto", or tables of one of {", ".join(ELEMENTS)} each, with Q'

    def schema(self):
        keys = {name: Quantity(unit).schema() for name, unit in ELEMENTS.items()} | {"Q": Quantity().schema()}
        element = {"type": "object", "properties": keys, "additionalProperties": False}
        return {"anyOf": [{"enum": ["none", "auto"]}, {"type": "array", "minItems": 1, "items": element}]}


def _element(path: str, given) -> tuple:
    given = dict(given) if isinstance(given, (dict, tuple)) else given
    names = [] if not isinstance(given, dict) else [name for name in given if name != "Q"]
    if len(names) != 1:
        raise SceneError(
            path, f"must be a table of one element, one of {', '.join(ELEMENTS)}, got {shown(given)}"
        )
    (name,) = names
    if name not in ELEMENTS:
        rule = f"is no element, which is one of {', '.join(ELEMENTS)}"
        raise SceneError(f"{path}.{name}", rule + nearest(name, list(ELEMENTS)))
    element = [(name, Quantity(ELEMENTS[name]).read(f"{path}.{name}", given[name]))]
    if "Q" in given:
        if name.endswith("R"):
            raise SceneError(f"{path}.Q", "must be absent with a resistance")
        element.append(("Q", Quantity().read(f"{path}.Q", given["Q"])))
    return tuple(element)
