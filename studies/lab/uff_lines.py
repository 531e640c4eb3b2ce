"""Lines of a Universal File, with their numbers: text between delimiters of -1, and numbers in any columns."""

import re
from functools import partial
from pathlib import Path

from studies.lab.csv_columns import finite_numbers
from studies.lab.input_file import InputFile
from studies.refusal import SceneError, reading

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d{1,3})?")


class UffLines(InputFile):
    """A file that is being read: its bytes, the position, and refusals that name the line."""

    def __init__(self, path: Path, option: str):
        with reading(path, option):
            self.content = path.read_bytes()
        super().__init__(path, option)
        self.at, self.number = 0, 0

    def line(self) -> str | None:
        """Return the next line, or None at the end."""
        if self.at >= len(self.content):
            return None
        end = self.content.find(b"\n", self.at)
        end = len(self.content) if end < 0 else end + 1
        text, self.at, self.number = self.content[self.at : end], end, self.number + 1
        return text.decode("utf-8", errors="replace").rstrip("\r\n")

    def error(self, rule: str, line: int | None = None) -> SceneError:
        """Return the refusal of a line, by default of the one that was read last."""
        return super().error(rule, self.number if line is None else line)


def is_delimiter(text: str) -> bool:
    """Return whether a line begins or ends a dataset."""
    return text.strip() == "-1" and len(text.rstrip()) <= 6


def body(reading: UffLines, first: int, kind: int) -> list[tuple[int, str]]:
    """Return the lines of a dataset of text, with their numbers, up to its closing -1."""
    lines: list[tuple[int, str]] = []
    while (text := reading.line()) is not None:
        if is_delimiter(text):
            return lines
        lines.append((reading.number, text))
    raise reading.error(f"the dataset {kind} that begins in line {first} is cut off: its closing -1 is missing")


def numbers(reading: UffLines, lines: list[tuple[int, str]]) -> list[float]:
    """Return all numbers of lines of text; anything else between them is refused."""
    decimal_comma = not any("." in text for _, text in lines)
    values: list[float] = []
    for number, text in lines:
        plain = text.replace(",", "." if decimal_comma else " ")
        rest = NUMBER.sub("", plain).split()
        words = rest or [each.upper().replace("D", "E") for each in NUMBER.findall(plain)]
        values += finite_numbers(words, text.strip(), partial(reading.error, line=number))
    return values
