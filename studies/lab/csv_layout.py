"""Where the table of a CSV file stands: its separator, its line of heads, and the lines of an instrument above."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from studies.lab.column_heads import head_of_column, unit_in_head

SEPARATORS = ("\t", ";", ",", r"\s{2,}", r"\s+")
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
THOUSANDS = re.compile(r"[+-]?\d{1,3},\d{3}")
NO_UNIT = ("", "1", "-")  # cells of a line of units
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True, kw_only=True)
class CsvLayout:
    """The layout of a text.

    Attributes
    ----------
    start : int
        Number of the line of heads among those given.
    separator : str
        A sign, or a regular expression of blanks.
    units : list of str
        Of the columns, from a line of units below the heads; empty without one.
    """

    start: int
    separator: str
    units: list[str] = field(default_factory=list)


def cells_of(text: str, separator: str) -> list[str]:
    """Return the cells of a line."""
    if len(separator) > 1:
        return re.split(separator, text.strip())
    return [cell.strip() for cell in next(csv.reader([text], delimiter=separator), [])]


def layout_of(lines: Sequence[str]) -> CsvLayout:
    """Return where the table begins: the heads have as many cells as the first line of two numbers or more below them.

    Without such a line the first one holds the heads.

    Examples
    --------
    >>> layout_of(["Oscilloscope; 64 averages", "U (V);v (mm/s)", "10,0;-31,2"])
    CsvLayout(start=1, separator=';', units=[])
    """
    for separator in SEPARATORS:
        rows: list[list[str]] = []
        for line in lines:
            row = cells_of(line, separator)
            if len(row) > 1 and any(row) and all(not cell or _is_number(cell) for cell in row):
                found = _above(rows, len(row))
                if found is not None:
                    return CsvLayout(start=found[0], separator=separator, units=found[1])
                break
            rows.append(row)
    first = lines[0] if lines else ""
    return CsvLayout(start=0, separator=next((sign for sign in ",;\t" if sign in first), ","))


def _above(rows: list[list[str]], count: int) -> tuple[int, list[str]] | None:
    """Return the number of the heads' row among those above a row of numbers, and the units in a row between them."""
    # a cell that begins with a digit is a value, such as a date, or "1 mm" in a table of points for a sweep
    heads = [
        k for k, row in enumerate(rows) if len(row) == count and all(cell and not cell[0].isdigit() for cell in row)
    ]
    if not heads:
        return None
    above, last = [k for k in heads if k < len(rows) - 1], rows[-1]
    units = [unit_in_head(cell) for cell in last] if len(last) == count else []
    bare = (unit or cell.strip("()[]") in NO_UNIT for unit, cell in zip(units, last, strict=False))
    if above and any(units) and all(bare):
        return above[-1], units
    stated = (k for k in heads if any(head_of_column(head) != head or _ends_in_unit(head) for head in rows[k]))
    return next(stated, heads[0]), []


def _ends_in_unit(head: str) -> bool:
    return any(unit_in_head(head[each.end() :]) for each in re.finditer("_", head))


def _is_number(cell: str) -> bool:
    return bool(NUMBER.fullmatch(cell) or DECIMAL_COMMA.fullmatch(cell))


def with_points(rows: list[list[str]], separator: str) -> list[list[str]]:
    """Return rows whose decimal commas, if they have any, are points.

    Between commas as separators "1,250" in quotes may be a thousand: it is left as it is, unless another number shows
    that the commas are decimal ones.
    """
    commas = [cell for row in rows for cell in row if DECIMAL_COMMA.fullmatch(cell)]
    if not commas or (separator == "," and all(map(THOUSANDS.fullmatch, commas))):
        return rows
    return [[cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell for cell in row] for row in rows]
