"""A block of a scene: a frozen dataclass whose fields are the keys of a TOML table.

A field is declared ``mass: Annotated[float, Quantity("kg")]``: its type once read, and the rule that reads
it.
"""

from dataclasses import MISSING, dataclass, fields
from typing import ClassVar, Self

from studies.refusal import SceneError, nearest, shown
from studies.scene.rule import Rule

__all__ = ["Block", "Blocks", "OneOf", "Within"]


class Block:
    """Base of the blocks: reads every field by its rule, then checks them together."""

    block: ClassVar[str]

    def __post_init__(self):
        for entry in fields(self):
            value = getattr(self, entry.name)
            if value is None and entry.default is None:
                continue
            key = f"{self.block}.{entry.name}" if self.block else entry.name
            object.__setattr__(self, entry.name, entry.type.__metadata__[0].read(key, value))
        self.check()

    def check(self) -> None:
        """Refuse what the single keys allow but together contradict."""

    def refuse(self, key: str, rule: str) -> None:
        """Raise the refusal of one of this block's keys."""
        raise SceneError(f"{self.block}.{key}" if self.block else key, rule)

    @classmethod
    def from_table(cls, path: str, table) -> Self:
        """Build the block from a TOML table found at a path.

        Raises
        ------
        SceneError
            For an unknown or a missing key, and for a value that breaks its rule.
        """
        if not isinstance(table, dict):
            raise SceneError(path, f"must be a block of keys, got {shown(table)}")
        known = {entry.name: entry for entry in fields(cls)}
        at = f"{path}." if path else ""
        for key in table:
            if key not in known:
                raise SceneError(f"{at}{key}", f"is no key of a scene{nearest(key, known)}")
        for name, entry in known.items():
            if entry.default is MISSING and name not in table:
                raise SceneError(f"{at}{name}", "is required and missing")
        try:
            return cls(**table)
        except SceneError as error:
            raise error.moved(cls.block, path) from None

    def to_table(self) -> dict:
        """Return the TOML table of this block, in SI units; what is absent stays absent."""
        table = {}
        for entry in fields(self):
            value = getattr(self, entry.name)
            if value is not None and value != ():
                table[entry.name] = entry.type.__metadata__[0].written(value)
        return table


@dataclass(frozen=True)
class Within(Rule):
    """A block inside a block."""

    kind: type[Block]

    def read(self, path, value):
        """Return the block."""
        return value if isinstance(value, self.kind) else self.kind.from_table(path, value)

    def written(self, value):
        """Return its table."""
        return value.to_table()


@dataclass(frozen=True)
class Blocks(Rule):
    """A list of blocks of one kind, perhaps empty."""

    kind: type[Block]

    def read(self, path, value):
        """Return a tuple of blocks."""
        if not isinstance(value, (list, tuple)):
            raise SceneError(path, f"must be a list of blocks, written [[{path}]], got {shown(value)}")
        one = Within(self.kind)
        return tuple(one.read(f"{path}.{index}", entry) for index, entry in enumerate(value))

    def written(self, value):
        """Return the list of their tables."""
        return [block.to_table() for block in value]


@dataclass(frozen=True)
class OneOf(Rule):
    """Text, or a table of the first kind that has one of the table's keys for its own."""

    text: Rule
    kinds: tuple[type[Block], ...]

    def read(self, path, value):
        """Return the text or the block."""
        if isinstance(value, self.kinds):
            return value
        if not isinstance(value, dict):
            return self.text.read(path, value)
        matches = [len(value.keys() & {entry.name for entry in fields(kind)}) for kind in self.kinds]
        return self.kinds[matches.index(max(matches))].from_table(path, value)

    def written(self, value):
        """Return the text or the table."""
        return value.to_table() if isinstance(value, Block) else value
