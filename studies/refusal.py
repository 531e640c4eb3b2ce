"""Errors for a user who gets no answer: one sentence for each fault, with key, rule, value and unit."""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from errno import ENOENT
from importlib import import_module
from os import strerror
from pathlib import Path
from typing import Any

from fem.parameters import refuses
from fem.parameters import shown as shown

# Exit codes of the command
EXIT_INEXACT = 1  # an answer that misses its tolerance, or is refused for its model error
EXIT_BAD_INPUT, EXIT_NO_ANSWER = 2, 3
EXIT_DEFECT = 70  # EX_SOFTWARE of sysexits.h: a defect of the program
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as shells report it
PACKAGES = {"skrf": "scikit-rf"}  # names for pip of modules that have another name
MAX_PROBLEMS = 20  # printed for one scene; a table of numbers with a wrong unit would give 36


class SceneError(ValueError):
    """A scene that breaks a rule; ``problems`` are all its faults, this one first.

    ``path`` is the key, such as ``slider.mass``, or empty; ``rule`` the rest of the sentence: what is allowed and what
    was found; ``location`` where the key stands, such as ``motor.toml, line 12``, or empty.
    """

    exit_code = EXIT_BAD_INPUT

    def __init__(self, path: str, rule: str, location: str = ""):
        sentence = _on_one_line(f"{path} {rule}" if path else rule)
        super().__init__(f"{location}: {sentence}" if location else sentence)
        self.path, self.rule, self.location = path, rule, location
        self.problems: tuple[SceneError, ...] = (self,)

    @classmethod
    def together(cls, problems: Iterable["SceneError"]) -> "SceneError":
        """Return one error that carries several; its text is theirs, separated by semicolons.

        Examples
        --------
        >>> str(SceneError.together([SceneError("a", "is missing"), SceneError("b", "is negative")]))
        'a is missing; b is negative'
        """
        problems = [each for problem in problems for each in problem.problems]
        if len(problems) == 1:
            return problems[0]
        shown_problems = problems[:MAX_PROBLEMS]
        if len(problems) > MAX_PROBLEMS:
            shown_problems.append(cls("", f"and {len(problems) - MAX_PROBLEMS} more"))
        whole = cls("", "; ".join(map(str, shown_problems)))
        whole.path, whole.rule = problems[0].path, problems[0].rule
        whole.problems = tuple(shown_problems)
        return whole

    def moved(self, old: str, new: str) -> "SceneError":
        """Return the same refusal with the start of its path replaced."""
        if len(self.problems) > 1:
            return SceneError.together(problem.moved(old, new) for problem in self.problems)
        if not self.path.startswith(old):
            return self
        return SceneError(new + self.path.removeprefix(old), self.rule, self.location)


def refuse_if(broken: Any, key: str, rule: str) -> None:
    """Raise a SceneError about a key if a condition holds."""
    if broken:
        raise SceneError(key, rule)


@refuses(SceneError)
def refuse_unknown(name: str, known: Collection[str], option: str, rule: str = "") -> Iterator[Any]:
    """Raise a SceneError for a name that is none of the known ones; ``rule`` is followed by the nearest of them."""
    if name not in known:
        yield option, (rule or f"{name!r} does not exist") + nearest(name, known)


@refuses(SceneError)
def refuse_outside(names: Iterable[str], known: Collection[str], option: str, where: str = "") -> Iterator[Any]:
    """Raise a SceneError for the first of several names of an option that is none of the known ones."""
    for name in names:
        if name not in known:
            yield option, f"must be of {', '.join(known)}{where}, got {name!r}"


@refuses(SceneError)
def refuse_repeated(keys: Iterable[str], option: str) -> Iterator[Any]:
    """Raise a SceneError for the first key that an option is given twice."""
    seen: set[str] = set()
    for key in keys:
        if key in seen:
            yield f"{option} {key}", "is given twice"
        seen.add(key)


def misread(key: str, form: str, value: Any, hint: str = "") -> SceneError:
    """Return the error of a value that has not the form which it must have."""
    return SceneError(key, f"must be {form}, got {shown(value)}{hint}")


@refuses(SceneError)
def refuse_other(value: str, known: Iterable[str], option: str) -> Iterator[Any]:
    """Raise a SceneError for the value of an option that is none of the known ones."""
    if value not in known:
        yield option, f"{one_of(known)}, got {value!r}"


def one_of(known: Iterable[str]) -> str:
    """Return the rule of a word that is one of the known ones."""
    return f"must be one of {', '.join(known)}"


@refuses(SceneError)
def refuse_ending(file: "str | Path", allowed: tuple[str, ...], option: str) -> Iterator[Any]:
    """Raise a SceneError for a file of an option whose name has none of the allowed endings."""
    if Path(file).suffix.lower() not in allowed:
        one = f"one of {', '.join(allowed)}" if len(allowed) > 2 else " or ".join(allowed)
        yield option, f"must end in {one}, got {str(file)!r}"


@contextmanager
def reading(file: "str | Path", option: str) -> Iterator[None]:
    """Turn a failure to read a file of an option into a SceneError."""
    try:
        yield
    except OSError as error:
        raise SceneError(option, f"{str(file)!r} cannot be read: {error.strerror or error}") from None


@contextmanager
def writing(file: "str | Path", option: str) -> Iterator[None]:
    """Turn a failure to write a file of an option, or to make a new one, into a SceneError."""
    try:
        yield
    except FileExistsError:
        raise SceneError(option, f"{str(file)!r} exists already, and is not replaced") from None
    except OSError as error:
        raise SceneError(option, f"cannot write {str(file)!r}: {error.strerror or error}") from None


def refuse_unwritable(file: "str | Path", option: str, *, new: bool = False) -> None:
    """Raise the SceneError of `writing` before anything is computed: no such folder, or, of a ``new`` file, one."""
    with writing(file, option):
        if new and Path(file).exists():
            raise FileExistsError
        if not Path(file).absolute().parent.is_dir():
            raise FileNotFoundError(ENOENT, strerror(ENOENT))


def all_answers(calls: Iterable[Callable[[], Any]]) -> list[Any]:
    """Return what each call without arguments returns; the refusals of all of them are raised as one SceneError."""
    problems, answers = [], []
    for call in calls:
        try:
            answers.append(call())
        except SceneError as error:
            problems.append(error)
    if problems:
        raise SceneError.together(problems)
    return answers


class RunError(RuntimeError):
    """A run of a sound scene that could not give an answer; the text says why and what to try."""

    exit_code = EXIT_NO_ANSWER


class InterruptedRunError(RunError):
    """A run that the user has interrupted; the text says what is kept."""

    exit_code = EXIT_INTERRUPTED


def _on_one_line(text: str) -> str:
    """Return a sentence with the characters that do not print, as in the name of a key, as escapes."""
    return "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in text)


def suggestion(word: str, known: Any) -> str | None:
    """Return the known word that a word resembles: the same start, one of its parts, or nearly the same letters.

    Examples
    --------
    >>> suggestion("friction", ["position", "friction_coefficient"]), suggestion("centre", ["center", "period"])
    ('friction_coefficient', 'center')
    """
    word = str(word).lower()
    lowered = {str(name).lower(): str(name) for name in reversed(list(known))}
    if len(word) >= 3:
        for starts in (lambda name: name.startswith(word), lambda name: word.rstrip("s") in name.split("_")):
            matches = [name for name in lowered if starts(name)]
            if len(matches) == 1:
                return lowered[matches[0]]
    close = get_close_matches(word, lowered, n=1)
    return lowered[close[0]] if close else None


def nearest(word: str, known: Any) -> str:
    """Return ``; did you mean ...?`` for the known word that this one resembles, else a list of the known words."""
    known = [str(name) for name in known]
    return resembling(word, known) or (f"; known: {', '.join(known)}" if known else "")


def resembling(word: str, known: Any) -> str:
    """Return ``; did you mean ...?`` for the known word that this one resembles, else an empty text."""
    similar = suggestion(word, known)
    return "" if similar is None else f"; did you mean {similar}?"


def needed(module: str, what: str) -> Any:
    """Import an optional package; a `RunError` that names it where it is missing."""
    try:
        return import_module(module)
    except ImportError:
        package = PACKAGES.get(module, module)
        raise RunError(f"{what} needs {package}, which is not installed: pip install {package}") from None
