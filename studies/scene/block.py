"""A block of a scene: a frozen dataclass whose fields are the keys of a TOML table.

A field is declared ``mass: Annotated[float, Quantity("kg"), "Mass of the whole slider."]``: the type of
its value, the rule that reads it, and its meaning, which the reference of all keys and the JSON Schema show.
"""

from contextlib import suppress
from dataclasses import MISSING, dataclass, fields
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar, NoReturn, Self, get_args

from fem import parameters
from fem.parameters import Checks, Number, Parameters, rules_of
from studies.refusal import SceneError, misread, nearest, suggestion
from studies.scene.numbers import Quantity, stated_schema
from studies.scene.rule import Count, Either, Field, Rule, as_table, choice, read_each, signs
from studies.scene.synonyms import key_for


@dataclass(frozen=True)
class Key:
    """One key of a block."""

    name: str
    declared: Rule  # as the block's class declares it
    home: type["Block"]
    meaning: str  # one sentence
    required: bool  # True if its block is refused without it
    default: object  # its value when absent; None where its meaning says what absence does

    @cached_property
    def rule(self) -> Rule:
        """How it is read: by the rule of the object's field where the block declares no other."""
        return _with_fields(self.declared, self.home, self.name)


def object_of(kind: type["Block"]) -> type[Parameters]:
    """Return the class of `fem` or `contact` whose parameters a block holds, imported on first use."""
    return _named(kind.parameters_of) if kind.parameters_of else Parameters


def _named(path: str) -> Any:
    package, _, name = path.partition(".")
    return getattr(import_module(package), name)


def _with_fields(rule: Rule, home: type["Block"], key: str) -> Rule:
    """Return a rule whose `Field` is the rule of the block's object."""
    if isinstance(rule, Either):
        return Either(tuple(_with_fields(each, home, key) for each in rule.rules))
    if not isinstance(rule, Field):
        return rule
    path, _, name = (rule.name or key).rpartition(".")
    if path == "fem":
        return choice(*_named(rule.name))
    field, _ = rules_of(_named(path) if path else object_of(home))[name]
    if isinstance(field, Number):
        return Quantity(**vars(field) | {"infinite": False})  # a key has a word for it
    if isinstance(field, parameters.Count):
        return Count(field.most)
    if isinstance(field, parameters.Signs):
        return signs(field.signs)
    assert isinstance(field, parameters.Words)
    return choice(*field.words)


_KEYS: dict[type, dict[str, Key]] = {}  # functools.cache would take no class for mypy


def keys_of(kind: type) -> dict[str, Key]:
    """Return the keys of a block's class by name."""
    if kind in _KEYS:
        return _KEYS[kind]
    keys = _KEYS[kind] = {}
    for entry in fields(kind):
        rule, meaning = get_args(entry.type)[1:]
        default = None if entry.default is MISSING else entry.default
        keys[entry.name] = Key(entry.name, rule, kind, meaning, entry.default is MISSING, default)
    return keys


class UnreadError(Exception):
    """Raised when a check uses a key that is missing or was refused: the check is skipped."""


class Unread:
    """Replaces a value that is missing or was refused while the others are checked; any use of it raises."""


def _refuse(*_):
    raise UnreadError


OPERATIONS = """getattr bool eq ne lt gt le ge hash abs neg complex float iter len contains getitem format str repr
add radd sub rsub mul rmul truediv rtruediv pow rpow"""
for operation in OPERATIONS.split():
    setattr(Unread, f"__{operation}__", _refuse)


class Block(Checks):
    """Base of the blocks: reads every field by its rule, then checks them together.

    Keys that are fields of an object of `fem` or `contact` have that field's rule, and the object's checks of several
    fields are made on the block, after its own methods ``check_...``.
    """

    block: ClassVar[str]  # path in a scene
    parameters_of: ClassVar[str] = ""  # the object or its rules, such as fem.Transducer
    keys: ClassVar[dict[str, str]] = {}  # the object's fields that have another name as keys

    def __post_init__(self):
        problems = []
        for name, key in keys_of(type(self)).items():
            value = getattr(self, name)
            if isinstance(value, Unread) or (value is key.default and not key.required):
                continue
            try:
                value = key.rule.read(self._path(name), value)
            except SceneError as error:
                problems += error.problems
                value = Unread()
            object.__setattr__(self, name, value)
        for check in (*type(self).checks, *object_of(type(self)).checks):
            with suppress(UnreadError):
                for name, rule in check(self):
                    problems.append(SceneError(self._path(self.keys.get(name, name)), rule))
        if problems:
            raise SceneError.together(problems)

    def refuse(self, key: str, rule: str) -> NoReturn:
        """Raise the refusal of one of this block's keys."""
        raise SceneError(self._path(key), rule)

    def _path(self, key: str) -> str:
        return ".".join(filter(None, (self.block, key)))

    @classmethod
    def from_table(cls, path: str, table) -> Self:
        """Build the block from the TOML table at a path of a scene.

        Raises
        ------
        SceneError
            For every unknown or missing key, and for every value that breaks its rule.
        """
        table = as_table(path, table)
        known, problems, at = keys_of(cls), [], f"{path}." if path else ""
        misspelt = set()
        for word in (word for word in table if word not in known):
            key, hint = _intended(word, cls)
            misspelt.add(key)
            problems.append(SceneError(f"{at}{word}", f"is no key of a scene{hint}"))
        absent = [name for name, key in known.items() if key.required and name not in table]
        for name in absent:
            if name not in misspelt:  # otherwise the refusal of the misspelt word names this key
                rule = f"is required and missing: give {known[name].rule.expected}"
                problems.append(SceneError(f"{at}{name}", rule))
        values = {name: table[name] for name in known if name in table} | {name: Unread() for name in absent}
        try:
            block = cls(**values)
        except SceneError as error:
            problems.append(error.moved(cls.block, path))
        if problems:
            raise SceneError.together(problems)
        return block

    def arguments(self, kind: type) -> dict:
        """Return the present values of the keys that are fields of a class of parameters, by field."""
        names = {each.name for each in fields(kind)} & keys_of(type(self)).keys()
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def to_table(self) -> dict:
        """Return the TOML table of this block, in SI units; what is absent stays absent."""
        values = ((name, key.rule, getattr(self, name)) for name, key in keys_of(type(self)).items())
        return {name: rule.written(value) for name, rule, value in values if value is not None and value != ()}


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
    schema = {"type": "object", "description": (kind.__doc__ or "").splitlines()[0], "properties": properties}
    return schema | ({"required": required} if required else {}) | {"additionalProperties": False}


def _intended(word: str, kind: type[Block]) -> tuple[str | None, str]:
    """Return the key of a block that an unknown word probably stands for, and the hint in its refusal."""
    key = key_for(word, keys_of(kind))
    blocks = Block.__subclasses__()
    order = [name for each in blocks if not each.block for name in keys_of(each)]  # of the scene's own blocks
    known = {each.block for each in blocks if word in keys_of(each) and each.block}
    homes = sorted(known, key=lambda block: (order.index(block.partition(".")[0]), block))
    homes = [each for each in homes if each.rpartition(".")[0] not in homes]  # a block before those inside it
    if key is None and homes:
        return None, f"; {word} belongs in [{'] or ['.join(homes)}]"
    key = key or suggestion(word, keys_of(kind))
    return key, nearest(word, keys_of(kind)) if key is None else f"; did you mean {key}?"


class Within(Rule):
    """A block inside a block; of several kinds the one that has most keys in common with the table."""

    def __init__(self, *kinds: type[Block]):
        self.kinds = kinds

    def takes(self, value):
        return isinstance(value, (dict, *self.kinds))

    def read(self, path, value):
        if isinstance(value, self.kinds):
            return value
        shared = [len(value.keys() & keys_of(kind).keys()) if self.takes(value) else 0 for kind in self.kinds]
        return self.kinds[shared.index(max(shared))].from_table(path, value)

    @property
    def expected(self):
        if len(self.kinds) == 1:
            return f"the block [{self.kinds[0].block}]"
        required = ([name for name, key in keys_of(kind).items() if key.required] for kind in self.kinds)
        return f"a table of {' or '.join(map(', '.join, required))}"

    def schema(self):
        schemas = [block_schema(kind) for kind in self.kinds]
        return schemas[0] if len(schemas) == 1 else {"anyOf": schemas}


class Blocks(Rule):
    """A list of blocks of one kind, of at least some length."""

    def __init__(self, kind: type[Block], least: int = 0):
        self.kinds, self.least = (kind,), least

    def takes(self, value):
        return isinstance(value, (list, tuple)) and len(value) >= self.least

    def read(self, path, value):
        if not self.takes(value):
            raise misread(path, f"a list of blocks, written [[{path}]]", value)
        return read_each([Within(*self.kinds)] * len(value), path, value)

    @property
    def expected(self):
        return f"one or more blocks [[{self.kinds[0].block}]]"

    def schema(self):
        sizes = {"minItems": self.least} if self.least else {}
        return {"type": "array", "items": block_schema(*self.kinds), **sizes}
