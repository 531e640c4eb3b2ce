"""The friction of a slider that is not a number or a word: a table, or a law of the user."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.refusal import SceneError, shown
from studies.scene.block import Block
from studies.scene.numbers import Quantity
from studies.scene.rule import TEXT, Plain, Rule


@dataclass(frozen=True, kw_only=True)
class Friction(Block):
    """A friction coefficient that depends on slip speed, contact pressure, or both: a table instead of a number."""

    block: ClassVar[str] = "slider.friction_coefficient"
    parameters_of = "contact.FrictionRules"
    keys: ClassVar[dict[str, str]] = {"": "static"}
    static: Annotated[float, Quantity(), "Coefficient at rest and at low pressure."]
    sliding: Annotated[
        float | None,
        Quantity(zero=True),
        "Coefficient at high slip speed w: mu = sliding + (static - sliding) exp(-w/speed). Requires speed.",
    ] = None
    speed: Annotated[
        float | None, Quantity("m/s"), "Slip speed over which the difference decays by a factor e. Requires sliding."
    ] = None
    high_pressure: Annotated[
        float | None,
        Quantity(),
        "Static coefficient at high mean pressure p: static approaches it as 1/(1 + p/pressure), and sliding "
        "changes in proportion. Requires pressure.",
    ] = None
    pressure: Annotated[
        float | None,
        Quantity("Pa"),
        "Mean contact pressure at which half of the difference remains. Requires high_pressure.",
    ] = None


@dataclass(frozen=True, kw_only=True)
class LawText(Block):
    """A tangential law of the user with its source, as a resolved scene keeps it."""

    block: ClassVar[str] = "slider.law"
    name: Annotated[str, TEXT, "Name of the file."]
    source: Annotated[
        str,
        Plain("the text of a file", lambda value: isinstance(value, str) and value != "", {"type": "string"}),
        "Content of the file: Python code that defines sliding(approach, normal_force, slip_speed, contact) in SI "
        "units.",
    ]

    def __str__(self) -> Any:
        return self.name


class LawFile(Rule):
    """A Python file with a law, read as a block with its source."""

    def __init__(self, text: type[Any] = LawText):
        self.text = text

    expected = 'a file such as "my_law.py", from the scene\'s folder'

    def takes(self, value: Any) -> Any:
        return isinstance(value, str) and value.endswith(".py")

    def read(self, path: Any, value: Any) -> Any:
        try:
            with open(value, encoding="utf-8") as file:
                return self.text(name=value.replace("\\", "/").rsplit("/", 1)[-1], source=file.read())
        except (OSError, UnicodeDecodeError) as error:
            why = getattr(error, "strerror", None) or "it is no UTF-8 text"
            raise SceneError(path, f"names the file {shown(value)}, which cannot be read: {why}") from None

    def schema(self) -> Any:
        return {"type": "string", "pattern": r"\.py$"}
