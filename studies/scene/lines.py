"""Line numbers of the keys of a TOML document (tomllib keeps none).

The document must be valid TOML: it is read after ``tomllib`` has read it.
"""

import re
from collections import Counter
from collections.abc import Iterator

TOKEN = re.compile(
    r'''"""(?:\\.|[^\\])*?"{3,5}|\'{3}.*?\'{3,5}|"(?:\\.|[^"\\])*"|'[^']*'|\#[^\n]*|\n|[\[\]{},=]|[^\s"'\#\[\]{},=]+''',
    re.DOTALL,
)
Token = tuple[str, int]  # with its line


def key_lines(text: str) -> dict[str, int]:
    r"""Return the line (from 1) of every key, block and list entry by its dotted path.

    Examples
    --------
    >>> key_lines('title = "a"\n[drive]\nvoltage = [1,\n 2]\n')["drive.voltage.1"]
    4
    """
    lines: dict[str, int] = {}
    entries: Counter[str] = Counter()  # of every list of blocks, so far
    block = ""

    def resolved(path: str, keys: list[str]) -> str:
        """Return the path of keys inside a block, with the latest entry of every list of blocks on the way."""
        for key in keys:
            path = f"{path}.{key}" if path else key
            path += f".{entries[path] - 1}" if path in entries else ""
        return path

    for statement in _statements(text):
        words, line = [word for word, _ in statement], statement[0][1]
        if words[0] == "[":
            many = words[1] == "["
            *outer, last = _dotted(words[2:-2] if many else words[1:-1])
            path = ".".join(filter(None, (resolved("", outer), last)))
            if many:
                entries[path] += 1
                lines.setdefault(path, line)
            block = resolved("", [*outer, last])
            lines.setdefault(block, line)
        else:
            equals = words.index("=")
            path = resolved(block, _dotted(words[:equals]))
            lines.setdefault(path, line)
            _entries(path, statement[equals + 1 :], lines)
    return lines


def line_of(path: str, lines: dict[str, int]) -> int | None:
    """Return the line of a path, or of the nearest block around it that the document has."""
    while path:
        if path in lines:
            return lines[path]
        path = path.rpartition(".")[0]
    return None


def _statements(text: str) -> Iterator[list[Token]]:
    """Yield the tokens of each header and of each key with its value."""
    line, depth, statement = 1, 0, []
    for match in TOKEN.finditer(f"{text}\n"):
        word = match[0]
        if word == "\n" and depth == 0 and statement:
            yield statement
            statement = []
        elif word != "\n" and word[0] != "#":
            statement.append((word, line))
            depth += (word in ("[", "{")) - (word in ("]", "}"))
        line += word.count("\n")


def _dotted(words: list[str]) -> list[str]:
    """Return the keys of a dotted key."""
    keys = [""]
    for word in words:
        if word[0] in "\"'":
            keys[-1] += word[1:-1]
        else:
            first, *others = word.split(".")
            keys[-1] += first
            keys += others
    return keys


def _entries(path: str, value: list[Token], lines: dict[str, int]) -> None:
    """Note the line of each entry of a list, and of the lists in it."""
    counters: list[int | None] = []  # one per open bracket; None for an inline table
    expected = False
    for word, line in value:
        if expected and word != "]" and None not in counters:
            lines[".".join([path, *map(str, counters)])] = line
        expected = word == "["
        if word in ("[", "{"):
            counters.append(0 if word == "[" else None)
        elif word in ("]", "}"):
            counters.pop()
        elif word == "," and counters and counters[-1] is not None:
            counters[-1] += 1
            expected = True
