"""Rules of parameters: what a value may be, checked and refused in one sentence, for `fem` and the scenes.

A class of parameters derives from `Parameters` and declares the rule of a field in its type, as in
``period: Annotated[float, Number("m")]``; a `Literal` is the rule of a few words.  Rules of several fields together
are methods ``check_...``, which yield the name of a field and the rest of the sentence.  They use attributes alone, so
that a block of a scene, whose keys have the names of the fields, is checked by the same methods before there is an
object.
"""

import cmath
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from numbers import Integral
from typing import Annotated, Any, ClassVar, Literal, ParamSpec, get_args, get_origin

Arguments = ParamSpec("Arguments")


class InputError(ValueError):
    """An argument that breaks a rule; as text ``key rule``, such as ``stator.length must be positive, got -1 m``.

    Attributes
    ----------
    key : str
        Name of the argument or of the field, such as ``stator.length``.
    rule : str
        The rest of the sentence: what is allowed, the value and its unit.
    value : object
        The value; None if the rule contains it.
    owner : str
        Which of several transducers the key belongs to, by its name; empty where there is one object alone.

    Examples
    --------
    >>> error = InputError("transducer.period", "must be positive", -1, "m", owner="left")
    >>> print(error, error.key, error.value, sep=" | ")
    transducer 'left'.period must be positive, got -1 m | transducer.period | -1
    """

    def __init__(self, key: str, rule: str, value: object = None, unit: str = "", owner: str = ""):
        super().__init__(key, rule, value, unit, owner)
        self.key, self.value, self.owner = key, value, owner
        got = shown(value) if isinstance(value, str) else value
        self.rule = rule if value is None else f"{rule}, got {got} {unit}".rstrip()

    def __str__(self):
        kind, dot, name = self.key.partition(".")
        key = f"{kind} {self.owner!r}{dot}{name}" if self.owner else self.key
        return f"{key} {self.rule}"


def refuse_if(broken: Any, key: str, rule: str, value: object = None, unit: str = "", owner: str = "") -> None:
    """Raise an InputError about a key if a condition holds."""
    if broken:
        raise InputError(key, rule, value, unit, owner)


def refuses(
    error: Callable[..., Exception],
) -> Callable[[Callable[Arguments, Iterator[Any]]], Callable[Arguments, None]]:
    """Return the decorator of a checking function, which yields refusals: the first of them is raised.

    A refusal is what ``error`` takes: a key and a rule, or one sentence.

    Examples
    --------
    >>> @refuses(InputError)
    ... def check(length):
    ...     if length < 0:
    ...         yield "length", "must be positive", length, "m"
    >>> check(-1.0)
    Traceback (most recent call last):
    fem.parameters.InputError: length must be positive, got -1.0 m
    """

    def decorated(check: Callable[Arguments, Iterator[Any]]) -> Callable[Arguments, None]:
        @wraps(check)
        def checked(*arguments: Arguments.args, **named: Arguments.kwargs) -> None:
            for refusal in check(*arguments, **named):
                raise error(*refusal) if isinstance(refusal, tuple) else error(refusal)

        return checked

    return decorated


def shown(value: Any) -> str:
    """Return a value as an error quotes it: on one line and short."""
    try:
        # TOML's dates and times are the only values without a Python literal
        text = repr(value) if type(value).__module__ != "datetime" else f"the date or time {value} (quotes are missing)"
    except (ValueError, RecursionError):  # an integer of more digits than Python prints, or nesting without end
        text = f"a {type(value).__name__} too large to print"
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


class ValueRule:
    """What one value may be."""

    unit = ""
    allowed: Any  # in words, behind "must be"

    def converted(self, value: Any) -> Any:
        """Return a value in its type; a TypeError, ValueError or OverflowError where it is not allowed."""
        raise NotImplementedError

    def allows(self, value: Any) -> bool:
        """Return whether a value is allowed."""
        try:
            self.converted(value)
        except (TypeError, ValueError, OverflowError):
            return False
        return True

    def sentence(self, value: Any) -> str:
        """Return what is said of a value that is not allowed."""
        return f"must be {self.allowed}"

    def __or__(self, other: "ValueRule") -> "ValueRule":
        return Either((self, other))

    def checked(self, key: str, value: Any, owner: str = "") -> Any:
        """Return a value in its type; an InputError about the key where it is not allowed."""
        try:
            return self.converted(value)
        except (TypeError, ValueError, OverflowError):
            raise InputError(key, self.sentence(value), value, self.unit, owner=owner) from None


@dataclass(frozen=True)
class Number(ValueRule):
    """A finite number in an interval: by default a positive one.

    Attributes
    ----------
    unit : str
        SI unit.
    zero, negative : bool
        True if zero, or every sign, is allowed.
    above, below, least, most : float
        Ends of the interval, which belong to it (``least`` and ``most``) or not.
    infinite : bool
        True if infinity is allowed.

    Examples
    --------
    >>> Number("m").checked("radius", 2)
    2.0
    >>> Number(least=0.001, most=0.999).checked("metallisation", 1.0)
    Traceback (most recent call last):
    fem.parameters.InputError: metallisation must be between 0.001 and 0.999, got 1.0
    """

    unit: str = ""
    zero: bool = False
    negative: bool = False
    above: float = -math.inf
    below: float = math.inf
    least: float = -math.inf
    most: float = math.inf
    infinite: bool = False

    @property
    def signed(self) -> bool:
        """True if the interval says which signs are allowed, or all are."""
        return self.negative or max(self.above, self.least) > -math.inf

    def converted(self, value):
        if isinstance(value, bool | str | complex) or getattr(value, "ndim", 0):
            raise TypeError
        number = float(value)
        if not self.holds(number):
            raise ValueError
        return number

    def holds(self, number: float) -> bool:
        """Return whether a number is allowed."""
        if number == math.inf:
            return self.infinite
        sign = self.signed or number > 0.0 or (self.zero and number == 0.0)
        return sign and self.above < number < self.below and self.least <= number <= self.most

    @property
    def allowed(self) -> str:
        if self.least > -math.inf:
            return f"between {self.least:g} and {self.most:g}"
        if self.above > -math.inf:
            return f"above {self.above:g} and below {self.below:g}"
        sign = "finite" if self.negative else "zero or positive" if self.zero else "positive"
        finite = "" if self.negative or self.zero or self.infinite else " and finite"
        return f"{sign}{finite}" if self.below == math.inf else f"{sign}{finite} and below {self.below:g}"

    def sentence(self, value):
        infinite = self.zero and isinstance(value, float) and not math.isfinite(value)
        return f"{super().sentence(value)}{' and finite' if infinite else ''}"


@dataclass(eq=False)
class ComplexNumber(ValueRule):
    """A finite number, real or complex."""

    unit: str = ""
    allowed = "a finite number, real or complex"

    def converted(self, value):
        if isinstance(value, bool | str) or getattr(value, "ndim", 0):
            raise TypeError
        number = complex(value)
        if not cmath.isfinite(number):
            raise ValueError
        return number


@dataclass(eq=False)
class Count(ValueRule):
    """An integer of at least ``least`` and at most ``most``."""

    least: int = 1
    most: int = sys.maxsize

    def converted(self, value):
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise TypeError
        if not self.least <= value <= self.most:
            raise ValueError
        return int(value)

    @property
    def allowed(self) -> str:
        ends = f"of at least {self.least}" if self.most == sys.maxsize else f"from {self.least} to {self.most}"
        return f"an integer {ends}"


@dataclass(eq=False)
class Words(ValueRule):
    """One of a few words."""

    words: tuple[str, ...]

    def converted(self, value):
        if not isinstance(value, str) or value not in self.words:
            raise ValueError
        return value

    @property
    def allowed(self) -> str:
        return " or ".join(f'"{word}"' for word in self.words)


@dataclass(eq=False)
class Signs(ValueRule):
    """A text of the allowed signs, at least one."""

    signs: str

    def converted(self, value):
        if not isinstance(value, str) or not value or set(value) - set(self.signs):
            raise ValueError
        return value

    @property
    def allowed(self) -> str:
        return f"a text of the signs {' '.join(self.signs)}"


@dataclass(eq=False)
class Either(ValueRule):
    """What one of two rules allows."""

    rules: tuple[ValueRule, ValueRule]

    def converted(self, value):
        try:
            return self.rules[0].converted(value)
        except (TypeError, ValueError, OverflowError):
            return self.rules[1].converted(value)

    @property
    def allowed(self) -> str:
        return " or ".join(rule.allowed for rule in self.rules)


def positive(key: str, value: Any, unit: str = "", owner: str = "", infinite: bool = False) -> float:
    """Return a positive number as a float, finite unless ``infinite``; an InputError for anything else."""
    return Number(unit, infinite=infinite).checked(key, value, owner)


def non_negative(key: str, value: Any, unit: str = "", owner: str = "") -> float:
    """Return a finite number that is zero or positive as a float; an InputError for anything else."""
    return Number(unit, zero=True).checked(key, value, owner)


def finite(key: str, value: Any, unit: str = "", owner: str = "") -> float:
    """Return a finite number as a float; an InputError for anything else."""
    return Number(unit, negative=True).checked(key, value, owner)


def finite_complex(key: str, value: Any, unit: str = "", owner: str = "") -> complex:
    """Return a finite number, real or complex, as a complex one; an InputError for anything else."""
    return ComplexNumber(unit).checked(key, value, owner)


def count(key: str, value: Any, least: int) -> int:
    """Return an integer of at least ``least``, also of a float such as 1e3; an InputError for anything else."""
    whole = isinstance(value, float) and value.is_integer()
    return Count(least).checked(key, int(value) if whole else value)


def choice(key: str, value: Any, allowed: Sequence[str]) -> str:
    """Return one of a few words; an InputError for anything else."""
    return Words(tuple(allowed)).checked(key, value)


class Checks:
    """Base of what is checked by its methods ``check_...``, each a rule of several fields together."""

    checks: ClassVar[tuple[Callable[[Any], Iterator[tuple[str, str]]], ...]] = ()

    def __init_subclass__(cls) -> None:
        own = tuple(method for name, method in vars(cls).items() if name.startswith("check_"))
        cls.checks = own or cls.checks


_RULES: dict[type, dict[str, tuple[ValueRule, bool]]] = {}  # functools.cache would take no class for mypy


def rules_of(kind: type) -> dict[str, tuple[ValueRule, bool]]:
    """Return the rules that a class of parameters declares, by field, and whether the field may be None."""
    if kind in _RULES:
        return _RULES[kind]
    rules = _RULES[kind] = {}
    for each in fields(kind):
        declared = get_args(each.type)[1:] if get_origin(each.type) is Annotated else ()
        if get_origin(each.type) is Literal:
            declared = (Words(get_args(each.type)),)
        if declared:
            rules[each.name] = declared[0], each.default is None
    return rules


class Parameters(Checks):
    """Base of the classes of parameters: each field is checked by its rule, then several of them together."""

    prefix: ClassVar[str] = ""  # first part of the keys in refusals
    owner: ClassVar[Any] = ""  # name of this one, where there may be several

    def __post_init__(self):
        for name, (rule, optional) in rules_of(type(self)).items():
            value = getattr(self, name)
            if value is not None or not optional:
                object.__setattr__(self, name, rule.checked(self._key(name), value, self.owner))
        for check in self.checks:
            for name, sentence in check(self):
                raise InputError(self._key(name), sentence, owner=self.owner)

    def _key(self, name: str) -> str:
        return ".".join(filter(None, (self.prefix, name)))
