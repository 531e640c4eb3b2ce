"""What every rule of a key offers: reading, writing, and saying what is allowed."""

from typing import Any

from studies.refusal import Refusals


class Rule:
    """What a value may be."""

    def read(self, path: str, value) -> Any:
        """Return the value in SI units, immutable."""
        raise NotImplementedError

    def written(self, value) -> Any:
        """Return what a TOML document holds for a value that was read."""
        return value

    @property
    def expected(self) -> str:
        """What is allowed, as a noun: ``a length in m, positive, or a string such as "5 mm"``."""
        raise NotImplementedError

    @property
    def range(self) -> str:
        """What is allowed, in few words, beside the unit."""
        return self.expected

    @property
    def unit_name(self) -> str:
        """The SI unit of a number; empty where there is none."""
        return getattr(self, "unit", "")

    def schema(self) -> dict:
        """Return the JSON Schema of a value."""
        raise NotImplementedError

    @staticmethod
    def read_each(rule: "Rule", path: str, values) -> tuple:
        """Return the entries of a list as a rule reads them; every fault is said."""
        refusals, entries = Refusals(), []
        for index, value in enumerate(values):
            with refusals:
                entries.append(rule.read(f"{path}.{index}", value))
        refusals.raise_all()
        return tuple(entries)
