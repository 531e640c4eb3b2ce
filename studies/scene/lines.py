"""Line numbers of the keys of a TOML document (tomllib keeps none).

The document must be valid TOML: it is scanned after ``tomllib`` has read it.
"""

from collections import Counter

__all__ = ["key_lines", "line_of"]

QUOTES = ('"""', "'''", '"', "'")


def key_lines(text: str) -> dict[str, int]:
    r"""Return the line (from 1) of every key, block and list entry by its dotted path.

    Examples
    --------
    >>> key_lines('title = "a"\n[drive]\nvoltage = [1,\n 2]\n')["drive.voltage.1"]
    4
    """
    return _Scanner(text).lines


def line_of(path: str, lines: dict[str, int]) -> int | None:
    """Return the line of a path, or of the nearest block around it that the document has."""
    while path:
        if path in lines:
            return lines[path]
        path = path.rpartition(".")[0]
    return None


class _Scanner:
    """One pass over a document; ``at`` is the index of the next character."""

    def __init__(self, text: str):
        self.text, self.at, self.lines = text, 0, {}
        self.entries: Counter[str] = Counter()  # of every list of blocks, so far
        self.block = ""
        while self._skip_blank():
            if self.text[self.at] == "[":
                self._header()
            else:
                line = self._line()
                path = self._resolved(self.block, self._dotted("="))
                self.lines.setdefault(path, line)
                self.at += 1
                self._value(path)

    def _line(self) -> int:
        return self.text.count("\n", 0, self.at) + 1

    def _skip_blank(self) -> bool:
        """Skip spaces, line ends and comments; return whether anything follows."""
        while self.at < len(self.text):
            if self.text[self.at] == "#":
                end = self.text.find("\n", self.at)
                self.at = len(self.text) if end < 0 else end
            elif self.text[self.at].isspace():
                self.at += 1
            else:
                return True
        return False

    def _header(self) -> None:
        line, many = self._line(), self.text.startswith("[[", self.at)
        self.at += 2 if many else 1
        *outer, last = self._dotted("]")
        path = self._resolved("", outer)
        path = f"{path}.{last}" if path else last
        if many:
            self.entries[path] += 1
            self.lines.setdefault(path, line)
        self.block = self._resolved("", [*outer, last])
        self.lines.setdefault(self.block, line)
        self.at += 2 if many else 1

    def _resolved(self, block: str, keys: list[str]) -> str:
        """Return the path of keys inside a block, with the latest entry of every list of blocks on the way."""
        path = block
        for key in keys:
            path = f"{path}.{key}" if path else key
            if path in self.entries:
                path = f"{path}.{self.entries[path] - 1}"
        return path

    def _dotted(self, end: str) -> list[str]:
        """Read a dotted key up to a character that ends it."""
        keys, key = [], ""
        while self.text[self.at] != end:
            sign = self.text[self.at]
            if sign in "\"'":
                begin = self.at
                self._string()
                key += self.text[begin + 1 : self.at - 1]
                continue
            if sign == ".":
                keys.append(key)
                key = ""
            elif not sign.isspace():
                key += sign
            self.at += 1
        return [*keys, key]

    def _value(self, path: str) -> None:
        """Skip a value, noting the line of each entry of a list."""
        counters: list[int | None] = []  # one per open bracket; None for an inline table
        entry_expected = False
        while self.at < len(self.text):
            sign = self.text[self.at]
            if sign == "\n" and not counters:
                return
            if sign == "#":
                end = self.text.find("\n", self.at)
                self.at = len(self.text) if end < 0 else end
                continue
            if entry_expected and not sign.isspace() and sign != "]":
                if None not in counters:
                    self.lines[".".join([path, *map(str, counters)])] = self._line()
                entry_expected = False
            if sign in "\"'":
                self._string()
                continue
            if sign in "[{":
                counters.append(0 if sign == "[" else None)
                entry_expected = sign == "["
            elif sign in "]}":
                counters.pop()
                entry_expected = False
            elif sign == "," and counters and counters[-1] is not None:
                counters[-1] += 1
                entry_expected = True
            self.at += 1

    def _string(self) -> None:
        """Skip a string of any of the four kinds."""
        quote = next(each for each in QUOTES if self.text.startswith(each, self.at))
        self.at += len(quote)
        while not self.text.startswith(quote, self.at):
            self.at += 2 if self.text[self.at] == "\\" and quote[0] == '"' else 1
        self.at += len(quote)
        while len(quote) == 3 and self.text.startswith(quote[0], self.at):
            self.at += 1  # up to two quotes may stand before the closing three
