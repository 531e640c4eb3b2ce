"""The words that the program prints: entries of ``studies/glossary.md``, which is the only list of them."""

import re
from importlib.resources import files

from studies.refusal import SceneError, nearest

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
        For a word that no entry has, with the nearest one.
    """
    known, key = entries(), word.strip().lower()
    several = [name for name in known if key == name.lower()] or [
        name
        for name in known
        if key in re.split(r"\W+", name.lower()) or (" " in key and key in name.lower())
    ]
    if not several:
        raise SceneError("help", f"knows no word {word!r}{nearest(key, known)} (sawmotor help lists them)")
    return "\n".join(f"{name}: {known[name]}" for name in several)
