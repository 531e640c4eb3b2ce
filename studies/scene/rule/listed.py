"""One value or several."""

import re
from dataclasses import dataclass

from studies.refusal import SceneError, shown
from studies.scene.ranges import read_range
from studies.scene.rule.numbers import DIGITS, units
from studies.scene.rule.protocol import Rule


@dataclass(frozen=True)
class Listed(Rule):
    """One value or a list that is not empty.

    ``alone`` is the rule of a single value, if another one; ``ranged`` allows ``"START:STOP:N"``.
    """

    each: Rule
    alone: Rule | None = None
    distinct: bool = False
    ranged: bool = False

    def read(self, path, value):
        """Return a tuple, or what ``alone`` makes of a single value; arrays and ranges are lists."""
        if hasattr(value, "tolist"):
            value = value.tolist()
        elif isinstance(value, range):
            value = list(value)
        elif self.ranged and isinstance(value, str):
            value = self._from_text(path, value)
        if not isinstance(value, (list, tuple)):
            if self.alone is not None:
                return self.alone.read(path, value)
            return (self.each.read(path, value),)
        if not value:
            raise SceneError(path, "must name at least one value, got an empty list")
        values = self.read_each(self.each, path, value)
        if self.distinct and len(set(values)) < len(values):
            raise SceneError(path, f"must differ from each other, got {shown(list(values))}")
        return values

    def _from_text(self, path, text):
        if ":" in text:
            return read_range(path, text, self.each.unit).values
        try:
            return self.each.read(path, text)
        except SceneError:
            if re.fullmatch(r"\s*[\d.]+\s*(\w+\s*)?(-|\.\.|to)\s*[\d.]+.*", text):
                raise SceneError(path, f"must be START:STOP:N or a list, got {shown(text)}") from None
            raise

    def written(self, value):
        return [self.each.written(each) for each in value] if isinstance(value, tuple) else value

    @property
    def expected(self):
        if self.alone is None:
            return f"{self.each.expected}; {self._several}"
        return f"{self.alone.expected}; or a list, each {self.each.expected}"

    @property
    def range(self):
        if self.alone is None:
            return f"{self.each.range}; {self._several}"
        return f"{self.alone.range}; or a list, {self.each.range}{', all different' if self.distinct else ''}"

    @property
    def _several(self):
        return 'one, a list, or "START:STOP:N" (:log)' if self.ranged else "one or a list"

    @property
    def unit_name(self):
        return self.each.unit_name

    def schema(self):
        several = {"type": "array", "items": self.each.schema(), "minItems": 1}
        if self.distinct:
            several["uniqueItems"] = True
        either = [(self.alone or self.each).schema(), several]
        if self.ranged:
            end = rf"\s*{DIGITS}\s*({units(self.each.unit)})?\s*"
            either.append({"type": "string", "pattern": rf"^{end}:{end}:\s*\d+\s*(:\s*log\s*)?$"})
        return {"anyOf": either}
