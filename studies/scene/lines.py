"""Line numbers of the keys of a TOML document (tomllib keeps none): each statement is read alone, line by line."""

import tomllib
from collections import Counter
from collections.abc import Iterator

from studies.scene.override import walk

CLOSINGS = ("", "]", "]]", "]]]", '"""', '"""]', "'''", "''']")  # of an unfinished statement of several lines


def key_lines(text: str) -> dict[str, int]:
    r"""Return the line (from 1) of every key, block and list entry of a valid document by its dotted path.

    Examples
    --------
    >>> key_lines('title = "a"\n[drive]\nvoltage = [1,\n 2]\n')["drive.voltage.1"]
    4
    """
    lines: dict[str, int] = {}
    entries: Counter[str] = Counter()  # number of blocks so far in every list of blocks
    block = statement = ""
    for number, line in enumerate(text.split("\n"), 1):
        statement += f"{line}\n"
        for closing in CLOSINGS:
            try:
                table = tomllib.loads(statement + closing)
            except tomllib.TOMLDecodeError:
                continue
            if line.lstrip().startswith("[") and statement == f"{line}\n":
                block = ""
                for key, counted in _header(table):
                    block += f".{key}" if block else key
                    lines.setdefault(block, number)
                    entries[block] += counted
                    block += f".{entries[block] - 1}" if entries[block] else ""
                lines.setdefault(block, number)
            else:
                for path, _ in walk(table, block):
                    lines.setdefault(path, number)
            statement = statement if closing else ""
            break
    return lines


def line_of(path: str, lines: dict[str, int]) -> int | None:
    """Return the line of a path, or of the nearest block around it that the document has."""
    while path and path not in lines:
        path = path.rpartition(".")[0]
    return lines.get(path)


def _header(table: dict) -> Iterator[tuple[str, bool]]:
    """Yield the keys of a header, and whether each begins an entry of a list of blocks."""
    while table:
        ((key, inner),) = table.items()
        yield key, isinstance(inner, list)
        table = inner[0] if isinstance(inner, list) else inner
