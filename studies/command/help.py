"""``sawmotor help``: what a word of the output means, from ``studies/glossary.md``, the only list of these words."""

import argparse
import re
from importlib.resources import files

from studies.refusal import SceneError, resembling

HELP = "explain a term of the output, or list the terms that are explained"
EXAMPLE = "sawmotor help stick margin"
ENTRY = re.compile(r"^- \*\*(?P<word>[^*]+)\*\*: (?P<text>.*?)(?=^- \*\*|\Z)", re.MULTILINE | re.DOTALL)


def entries() -> dict[str, str]:
    """Return every word of the glossary with its meaning on one line.

    Examples
    --------
    >>> entries()["aperture"]
    'length of a finger along y, across the beam.'
    """
    text = (files("studies") / "glossary.md").read_text(encoding="utf-8")
    return {entry["word"]: " ".join(entry["text"].split()) for entry in ENTRY.finditer(text)}


def meaning(word: str) -> str:
    """Return the entry of a word, in capitals or not, or of the entries that contain it.

    Raises
    ------
    SceneError
        For a word that no entry has, with one that resembles it.
    """
    known, key = entries(), word.strip().lower()
    several = [name for name in known if key == name.lower()] or [
        name for name in known if key in re.split(r"\W+", name.lower()) or (" " in key and key in name.lower())
    ]
    if not several:
        raise SceneError("help", f"knows no word {word!r}{resembling(key, known)} (sawmotor help lists the words)")
    return "\n".join(f"{name}: {known[name]}" for name in several)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("word", nargs="*", metavar="WORD", help="such as ledger, or stick margin")


def call(arguments: argparse.Namespace) -> int:
    """Print what a word of the output means, or the list of the words."""
    print(meaning(" ".join(arguments.word)) if arguments.word else ", ".join(entries()))
    return 0
