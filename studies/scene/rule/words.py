"""Words: one of a few, free text, rows of signs, true or false."""

import re
from dataclasses import dataclass

from studies.refusal import SceneError, nearest, shown
from studies.scene.rule.protocol import Rule


@dataclass(frozen=True)
class Choice(Rule):
    """One of a few words."""

    words: tuple[str, ...]

    def read(self, path, value):
        """Return the word."""
        if not isinstance(value, str) or value not in self.words:
            allowed = self.expected
            hint = nearest(value, self.words) if isinstance(value, str) and len(self.words) > 1 else ""
            raise SceneError(path, f"must be {allowed}, got {shown(value)}{hint if 'mean' in hint else ''}")
        return value

    @property
    def expected(self):
        return " or ".join(f'"{word}"' for word in self.words)

    def schema(self):
        return {"enum": list(self.words)}


@dataclass(frozen=True)
class Text(Rule):
    """Free text on one line."""

    def read(self, path, value):
        """Return the text."""
        if not isinstance(value, str) or not value.isprintable():
            raise SceneError(path, f"must be text on one line, got {shown(value)}")
        return value

    @property
    def expected(self):
        return "text on one line"

    def schema(self):
        return {"type": "string"}


@dataclass(frozen=True)
class Signs(Rule):
    """A row of signs, at least one."""

    allowed: str

    def read(self, path, value):
        """Return the text."""
        if not isinstance(value, str) or not value or set(value) - set(self.allowed):
            signs = " ".join(self.allowed)
            raise SceneError(path, f"must be a text of the signs {signs}, got {shown(value)}")
        return value

    @property
    def expected(self):
        return f"a text of the signs {' '.join(self.allowed)}"

    def schema(self):
        return {"type": "string", "pattern": f"^[{re.escape(self.allowed)}]+$"}


@dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def read(self, path, value):
        """Return the boolean."""
        if not isinstance(value, bool):
            raise SceneError(path, f"must be true or false, got {shown(value)}")
        return value

    @property
    def expected(self):
        return "true or false"

    def schema(self):
        return {"type": "boolean"}
