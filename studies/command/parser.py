"""The command line: one module of this package for each command, with its arguments and what it does."""

import argparse
import re
from collections.abc import Mapping
from contextlib import nullcontext
from importlib import import_module

from studies.refusal import SceneError, resembling, suggestion

# in the order of the help; each is a module of this package
COMMANDS = tuple(
    "run new wave sweep scenes materials schema check datasheet study fit design compare help export view".split()
)
EXIT_CODES = (
    "Exit codes: 0 an answer within its tolerance; 1 one that misses it, or is refused for its model error; 2 bad "
    "input; 3 no answer; 70 a defect of sawmotor; 130 interrupted, 143 by SIGTERM."
)

INVALID_CHOICE = re.compile(r"invalid choice: '?([^']*)'? \(choose from (.*)\)")  # message of argparse
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9-]*)")

# option of the command for each argument of `studies.design`, `studies.fit` and `studies.sweep`
OPTIONS = {
    "goals": "--maximise", "minimise": "--minimise", "variables": "--over", "constraints": "--subject",
    "measurements": "--data", "parameters": "--free", "also": "--also", "evaluations": "--evaluations",
    "out": "--out", "over": "--over", "points": "--points", "scheduler": "--scheduler", "workers": "--workers",
}  # fmt: skip


def with_options(error: SceneError) -> SceneError:
    """Return an error about an argument of a Python function as an error about the option of the command.

    Examples
    --------
    >>> print(with_options(SceneError("variables slider.mass", "is given twice")))
    --over slider.mass is given twice
    """
    if len(error.problems) > 1:
        return SceneError.together(map(with_options, error.problems))
    word, space, rest = error.path.partition(" ")
    return SceneError(OPTIONS.get(word, word) + space + rest, error.rule, error.location)


def refused(error: SceneError, arguments: argparse.Namespace) -> SceneError:
    """Return an error of a call with the options, the file and the line that it is about."""
    file = getattr(arguments, "scene_file", None)
    try:
        with nullcontext() if file is None else file.located():
            raise with_options(error)
    except SceneError as located:
        return located


class Call(argparse.ArgumentParser):
    """A parser whose errors are one sentence without usage text."""

    calls: Mapping[str, "Call"] = {}  # of the commands
    example = ""  # a call of the command

    def error(self, message: str):
        """Raise a SceneError instead of printing the usage and exiting."""
        invalid = INVALID_CHOICE.search(message)
        if invalid is not None:
            message += resembling(invalid[1], re.findall(r"[\w.-]+", invalid[2]))
        if self.example and "did you mean" not in message:
            message += f"; an example: {self.example}"
        raise SceneError("", f"{message} (see {self.prog} --help)")

    def parse_args(self, words=None, namespace=None):  # type: ignore[override]
        """Return the parsed arguments; unknown options are refused with the nearest ones of the same command."""
        arguments, unknown = self.parse_known_args(words, namespace)
        if unknown:
            command = self.calls.get(arguments.call, self)
            known = OPTION.findall(command.format_help())
            words = [OPTION.match(word) for word in unknown]
            similar = [suggestion(word[1], known) for word in words if word is not None]
            meant = ", ".join(f"--{word}" for word in dict.fromkeys(similar) if word is not None)
            hint = f"; did you mean {meant}?" if meant else ""
            message = f"unrecognized arguments: {' '.join(unknown)}{hint}"
            command.error(message)
        return arguments


class Version(argparse.Action):
    """Option that prints the version."""

    def __call__(self, parser, *_):
        """Print the version and exit."""
        from importlib.metadata import version

        print(f"sawmotor {version('sawmotor')}")
        parser.exit()


def parser(wanted: str | None = None) -> Call:
    """Return the parser of the whole command; if ``wanted`` is a command, with the arguments of that one only."""
    top = Call(
        prog="sawmotor",
        description="Surface-acoustic-wave motors from drive voltage to slider velocity.",
        epilog=EXIT_CODES,
        allow_abbrev=False,
    )
    top.add_argument("--version", action=Version, nargs=0, help="print the version and leave")
    calls = top.add_subparsers(dest="call", metavar="COMMAND", parser_class=Call)
    for name in COMMANDS:
        if wanted in COMMANDS and name != wanted:
            calls.add_parser(name)
            continue
        command = import_module(f"studies.command.{name}")
        description = f"{command.HELP[0].upper()}{command.HELP[1:]}."
        epilog = f"Example: {command.EXAMPLE}"
        own = calls.add_parser(name, help=command.HELP, description=description, epilog=epilog, allow_abbrev=False)
        own.example = command.EXAMPLE
        command.add_arguments(own)
        own.set_defaults(function=command.call)
    top.calls = calls.choices
    return top
