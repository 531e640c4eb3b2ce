"""What is said to a user who gets no answer: one sentence, naming key, rule, value and unit."""

from difflib import get_close_matches

__all__ = ["RunError", "SceneError", "nearest", "shown"]


class SceneError(ValueError):
    """A scene that breaks a rule.

    Parameters
    ----------
    path : str
        Key in the scene file, such as ``slider.mass``; empty when the whole scene is meant.
    rule : str
        The rest of the sentence: what is allowed and what was given.
    """

    def __init__(self, path: str, rule: str):
        super().__init__(_on_one_line(f"{path} {rule}" if path else rule))
        self.path, self.rule = path, rule

    def moved(self, old: str, new: str) -> "SceneError":
        """Return the same refusal with the start of its path replaced."""
        return SceneError(new + self.path.removeprefix(old), self.rule)


class RunError(RuntimeError):
    """A run of a sound scene that could not give an answer; the text says why and what to try."""


def _on_one_line(text: str) -> str:
    """Return a sentence in which what does not print, as in the name of a key, is written out."""
    return "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in text)


def nearest(word: str, known) -> str:
    """Return ``; did you mean ...?`` when a known word resembles this one, else a list of those known."""
    known = [str(name) for name in known]
    lowered = {name.lower(): name for name in reversed(known)}
    found = get_close_matches(str(word).lower(), lowered, n=1, cutoff=0.5)
    if found:
        return f"; did you mean {lowered[found[0]]}?"
    return f"; known: {', '.join(known)}" if known else ""


def shown(value) -> str:
    """Return a value as an error quotes it: on one line and short."""
    try:
        text = repr(value)
    except (
        ValueError,
        RecursionError,
    ):  # an integer of more digits than Python prints, or nesting without end
        text = f"a {type(value).__name__} too large to print"
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."
