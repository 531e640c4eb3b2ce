"""Numbers of a fit that follow others by an expression, as lmfit's parameters with ``expr`` do."""

import ast
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from fem.parameters import refuses
from studies.inverse.free_parameters import FREE, Parameter, key_of
from studies.refusal import SceneError
from studies.scene.keys import rule_at


class Ties:
    """The tied numbers of lmfit's parameters; none where the parameters have another form.

    lmfit itself evaluates the expressions, on a copy, and keeps the tied numbers within their ranges.

    Attributes
    ----------
    expressions : dict
        Of the tied numbers of a scene, by key, as they were written.
    """

    def __init__(self, parameters: Any = None):
        self._lmfit = deepcopy(parameters) if hasattr(parameters, "valuesdict") else {}
        texts = {name: each.expr for name, each in self._lmfit.items() if each.expr}
        self._names = {name: _names(text) for name, text in texts.items()}
        # a name that is no key of a scene is a step on the way to others
        self.expressions = {key_of(name): text for name, text in texts.items() if is_of_scene(key_of(name))}

    def __call__(self, numbers: dict[str, float]) -> dict[str, float]:
        """Return the tied numbers by key for the others by key, SI units."""
        if not self.expressions:
            return {}
        for key, value in numbers.items():
            self._lmfit[_name(key)].value = value
        return {key: float(self._lmfit[_name(key)].value) for key in self.expressions}

    def followers(self, key: str) -> list[str]:
        """Return the keys of the tied numbers that follow a number, directly or by others."""
        reached, size = {_name(key)}, 0
        while len(reached) > size:
            size = len(reached)
            reached |= {name for name, names in self._names.items() if reached & names}
        return [each for each in self.expressions if _name(each) in reached]

    def uses(self, key: str) -> bool:
        """Return whether an expression names a number."""
        return any(_name(key) in names for names in self._names.values())

    def parameters(self, values: dict[str, float]) -> Any:
        """Return a copy of lmfit's parameters with values by key."""
        own = deepcopy(self._lmfit)
        for key, value in values.items():
            own[_name(key)].value = value
        return own


def is_of_scene(key: str) -> bool:
    """Return whether a name is a key of a scene's number, or one of the numbers that belong to a measurement."""
    return "." in key or key in FREE


@refuses(SceneError)
def refuse_names(ties: Ties, parameters: tuple[Parameter, ...]) -> Iterator[Any]:
    """Refuse tied keys that are no numbers of a scene, and names that are neither keys nor in an expression."""
    for key in ties.expressions:
        if "." in key and rule_at(key).number is None:
            yield f"parameters {key}", "must be a number of a scene, to follow an expression"
    for each in parameters:
        if not is_of_scene(each.key) and not ties.uses(each.key):
            try:
                rule_at(each.key)
            except SceneError as error:
                raise error.moved("", "parameters ") from None
            yield f"parameters {each.key}", "must be a number of a scene, such as slider.preload"


def _names(text: str) -> set[str]:
    return {node.id for node in ast.walk(ast.parse(text, mode="eval")) if isinstance(node, ast.Name)}


def _name(key: str) -> str:
    return key.replace(".", "__")
