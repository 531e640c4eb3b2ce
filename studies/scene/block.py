"""A block of a scene: a frozen dataclass whose fields are the keys of a TOML table.

A field is declared ``mass: Annotated[float, Quantity("kg"), "Mass of the whole slider."]``: its type once read, the
rule that reads it, and its meaning in one sentence for the reference of all keys and the JSON Schema.
"""

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import ClassVar, Self

from studies.refusal import Refusals, SceneError, nearest, shown, suggestion
from studies.scene.rule import Rule
from studies.scene.synonyms import meant
from studies.scene.uncertain import stated_schema


@dataclass(frozen=True)
class Key:
    """One key of a block."""

    name: str
    rule: Rule  # how it is read
    meaning: str  # one sentence
    required: bool  # whether it must be given when its block is
    default: object  # its value when absent; None where absence means something of its own


@cache
def keys_of(kind: "type[Block]") -> dict[str, Key]:
    """Return the keys of a block's class by name."""
    return {
        entry.name: Key(
            name=entry.name,
            rule=entry.type.__metadata__[0],
            meaning=entry.type.__metadata__[1],
            required=entry.default is MISSING,
            default=None if entry.default is MISSING else entry.default,
        )
        for entry in fields(kind)
    }


class Block:
    """Base of the blocks: reads every field by its rule, then checks them together."""

    block: ClassVar[str]

    def __post_init__(self):
        problems, unread = [], ()
        for name, key in keys_of(type(self)).items():
            value = getattr(self, name)
            if value is None and not key.required and key.default is None:
                continue
            try:
                object.__setattr__(self, name, key.rule.read(self._path(name), value))
            except SceneError as error:
                problems += error.problems
                unread += (name,)
        problems += self.contradictions(frozenset(unread))
        if problems:
            raise SceneError.together(problems)

    def contradictions(self, unread: frozenset[str]) -> Iterator[SceneError]:
        """Yield what the single keys allow but together contradict; ``unread`` are the keys that were refused."""
        return iter(())

    def refusal(self, key: str, rule: str) -> SceneError:
        """Return the refusal of one of this block's keys."""
        return SceneError(self._path(key), rule)

    def refuse(self, key: str, rule: str) -> None:
        """Raise the refusal of one of this block's keys."""
        raise self.refusal(key, rule)

    def _path(self, key: str) -> str:
        return f"{self.block}.{key}" if self.block else key

    @classmethod
    def from_table(cls, path: str, table) -> Self:
        """Build the block from a TOML table found at a path.

        Raises
        ------
        SceneError
            For every unknown or missing key, and for every value that breaks its rule.
        """
        if not isinstance(table, dict):
            raise SceneError(path, f"must be a block of keys, got {shown(table)}")
        known, refusals, at = keys_of(cls), Refusals(), f"{path}." if path else ""
        misspelt = set()
        for word in table:
            if word not in known:
                meant, hint = _meant(word, cls)
                misspelt.add(meant)
                refusals.problems.append(SceneError(f"{at}{word}", f"is no key of a scene{hint}"))
        missing = [key for name, key in known.items() if key.required and name not in table]
        for key in missing:
            if key.name in misspelt:
                continue  # said already, with the word that stands for it
            rule = f"is required and missing: give {key.rule.expected}"
            refusals.problems.append(SceneError(f"{at}{key.name}", rule))
        given = {name: table[name] for name in known if name in table}
        block = None
        with refusals:
            if missing:
                _read_each(at, known, given)
            else:
                block = cls._built(path, given)
        refusals.raise_all()
        return block

    @classmethod
    def _built(cls, path: str, given: dict) -> Self:
        try:
            return cls(**given)
        except SceneError as error:
            raise error.moved(cls.block, path) from None

    def to_table(self) -> dict:
        """Return the TOML table of this block, in SI units; what is absent stays absent."""
        table = {}
        for name, key in keys_of(type(self)).items():
            value = getattr(self, name)
            if value is not None and value != ():
                table[name] = key.rule.written(value)
        return table


def block_schema(kind: type[Block]) -> dict:
    """Return the JSON Schema of a block: its keys with their meaning and default, no others."""
    properties = {}
    for name, key in keys_of(kind).items():
        about = {"description": f"{key.meaning} Allowed: {key.rule.expected}."}
        allowed, stated = key.rule.schema(), stated_schema(key.rule)
        if stated:
            allowed = {"anyOf": [*allowed.get("anyOf", [allowed]), *stated]}
        properties[name] = allowed | about
        if not key.required and key.default not in (None, ()) and not isinstance(key.default, Block):
            properties[name]["default"] = key.rule.written(key.default)
    required = [name for name, key in keys_of(kind).items() if key.required]
    schema = {"type": "object", "description": kind.__doc__.splitlines()[0], "properties": properties}
    return schema | ({"required": required} if required else {}) | {"additionalProperties": False}


def _read_each(at: str, known: dict[str, Key], given: dict) -> None:
    """Raise what is wrong with the keys of a block that cannot be built."""
    refusals = Refusals()
    for name, value in given.items():
        with refusals:
            known[name].rule.read(f"{at}{name}", value)
    refusals.raise_all()


def _meant(word: str, kind: type[Block]) -> tuple[str | None, str]:
    """Return the key of a block that was probably meant by an unknown one, and the hint to be given."""
    found = meant(word, keys_of(kind))
    homes = [each.block for each in Block.__subclasses__() if word in keys_of(each) and each.block]
    if found is None and homes:
        return None, f"; {word} belongs in [{'] or ['.join(homes)}]"
    found = found or suggestion(word, keys_of(kind))
    return found, nearest(word, keys_of(kind)) if found is None else f"; did you mean {found}?"


@dataclass(frozen=True)
class Within(Rule):
    """A block inside a block."""

    kind: type[Block]

    def read(self, path, value):
        """Return the block."""
        return value if isinstance(value, self.kind) else self.kind.from_table(path, value)

    def written(self, value):
        return value.to_table()

    @property
    def expected(self):
        return f"the block [{self.kind.block}]"

    def schema(self):
        return block_schema(self.kind)


@dataclass(frozen=True)
class Blocks(Rule):
    """A list of blocks of one kind, perhaps empty."""

    kind: type[Block]

    def read(self, path, value):
        """Return a tuple of blocks."""
        if not isinstance(value, (list, tuple)):
            raise SceneError(path, f"must be a list of blocks, written [[{path}]], got {shown(value)}")
        return self.read_each(Within(self.kind), path, value)

    def written(self, value):
        return [block.to_table() for block in value]

    @property
    def expected(self):
        return f"one or more blocks [[{self.kind.block}]]"

    def schema(self):
        return {"type": "array", "items": block_schema(self.kind)}


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
        matches = [len(value.keys() & set(keys_of(kind))) for kind in self.kinds]
        return self.kinds[matches.index(max(matches))].from_table(path, value)

    def written(self, value):
        return value.to_table() if isinstance(value, Block) else value

    @property
    def expected(self):
        tables = " or ".join(
            ", ".join(name for name, key in keys_of(kind).items() if key.required) for kind in self.kinds
        )
        return f"{self.text.expected}, or a table of {tables}"

    def schema(self):
        return {"anyOf": [self.text.schema(), *map(block_schema, self.kinds)]}
