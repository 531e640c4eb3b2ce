"""Columns of a CSV file by the quantity and the unit in their heads, such as ``x_mm`` or ``u_z_real_nm_per_V``."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.lab.column_heads import head_of_column
from studies.lab.csv_layout import cells_of, layout_of, with_points
from studies.lab.input_file import InputFile, file_lines
from studies.refusal import SceneError, shown

VOLTAGES_READ = {"pp": "peak-to-peak voltages halved", "rms": "rms voltages as sqrt(2) times as large peak values"}


def csv_text(columns: dict[str, np.ndarray], remarks: tuple[str, ...] = ()) -> str:
    """Return columns by head as CSV, from which the same numbers are read, below lines of remarks.

    Examples
    --------
    >>> print(csv_text({"x_m": np.array([0.1, 0.25])}, ("made up",)), end="")
    # made up
    x_m
    0.1
    0.25
    """
    rows = [",".join(repr(float(value)) for value in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([*(f"# {each}" for each in remarks), ",".join(columns), *rows]) + "\n"


@dataclass(frozen=True, kw_only=True)
class CsvColumns(InputFile):
    """The columns of a CSV file as text, with the option of the command that named it.

    Columns that are not read may have any unit.
    """

    path: Path
    option: str
    names: list[str]
    rows: list[list[str]]
    lines: list[int]  # number of each row's line in the file

    remarks: tuple[str, ...] = ()  # on what was read otherwise than the file has it

    @classmethod
    def read(cls, path: str | Path, option: str) -> "CsvColumns":
        """Read a CSV file; lines that begin with # and those of an instrument above the heads are ignored."""
        path = Path(path)
        return cls.of_lines(file_lines(path, option), path, option)

    @classmethod
    def of_lines(cls, lines: list[str], path: Path, option: str) -> "CsvColumns":
        """Return the columns of a file's lines."""
        numbered = [
            (number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
        ]
        layout = layout_of([line for _, line in numbered])
        above, numbered = numbered[: layout.start], numbered[layout.start :]
        if len(layout.separator) > 1:
            rows = [cells_of(line, layout.separator) for _, line in numbered]
        else:
            read = csv.reader((line for _, line in numbered), delimiter=layout.separator)
            rows = [[cell.strip() for cell in row] for row in read]
        first = 2 if layout.units else 1  # row of values
        InputFile(path, option).refuse_if(len(rows) <= first, "must hold a line of names and at least one point")
        # a quoted cell may span lines: the numbers are then those of other rows, and none is said
        numbers = [number for number, _ in numbered] if len(rows) == len(numbered) else [0] * len(rows)
        heads, values = rows[0], with_points(rows[first:], layout.separator)
        names = list(map(head_of_column, heads, layout.units or [""] * len(heads)))
        remarks = [
            f"{len(above)} lines above the heads left out" if len(above) > 1 else "a line above the heads left out"
        ]
        remarks = remarks if above else []
        changed = [f"{head!r} as {name}" for head, name in zip(heads, names, strict=True) if head != name]
        remarks += [f"columns read: {', '.join(changed)}"] if changed else []
        remarks += [said for kind, said in VOLTAGES_READ.items() if any(name.endswith(f"V{kind}") for name in names)]
        remarks += ["decimal commas"] if values != rows[first:] else []
        return cls(
            path=path, option=option, names=names, rows=values, lines=numbers[first:],
            remarks=("; ".join(remarks),) if remarks else (),
        )  # fmt: skip

    def column(self, noun: str, units: dict[str, float]) -> tuple[np.ndarray, str] | None:
        """Return the values of the column ``noun_UNIT`` in SI units and its unit; None where no head begins so.

        The unit "" is that of a column ``noun``.

        Raises
        ------
        SceneError
            If the unit is none of those known, two heads begin so, or a cell is no real number.
        """
        own = [name for name in self.names if name == noun or name.startswith(f"{noun}_")]
        matches = [name for name in own if name.removeprefix(noun).removeprefix("_") in units]
        if not own:
            return None
        rule = f"must have one column {noun}_UNIT with a unit of {', '.join(units)}, got {', '.join(own)}"
        self.refuse_if(len(matches) != 1, rule)
        at, unit = self.names.index(matches[0]), matches[0].removeprefix(noun).removeprefix("_")
        return np.array([self._number(k, at) for k in range(len(self.rows))]) * units[unit], unit

    def values(self, noun: str, units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the values of the `column`, or None if no head has one of the units; nothing is refused."""
        column = self.column(noun, units) if any(f"{noun}_{unit}" in self.names for unit in units) else None
        return None if column is None else tuple(column[0].tolist())

    def deviation(self, nouns: tuple[str, ...], units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the first of the columns ``nouns`` that exists, in SI units, or None; it must be positive."""
        bare = next((name for name in ("error", "velocity_error", "sigma", "uncertainty") if name in self.names), None)
        heads = " or ".join(f"{nouns[0]}_{unit}" for unit in units)
        self.refuse_if(bare is not None, f"must name the unit of the column {bare}, as in {heads}")
        noun = next((noun for noun in nouns for unit in units if f"{noun}_{unit}" in self.names), None)
        if noun is None:
            return None
        self.refuse_signs(noun, units, zero=False)
        return self.values(noun, units)

    def refuse_signs(self, noun: str, units: dict[str, float], *, zero: bool) -> None:
        """Raise a SceneError for the first negative value of the column ``noun_UNIT``, and unless ``zero`` for a zero.

        The value is quoted with the file's line, head and unit.
        """
        unit = next((unit for unit in units if f"{noun}_{unit}" in self.names), None)
        if unit is None:
            return
        at = self.names.index(f"{noun}_{unit}")
        for row in range(len(self.rows)):
            value = self._number(row, at)
            if value < 0.0 or (value == 0.0 and not zero):
                rule = f"{noun}_{unit} must be {'zero or ' * zero}positive"
                raise self.error(f"{self.line(row)}{rule}, got {value:g} {written(unit)}")

    def refuse_falling(self, noun: str, values: Sequence[float] | np.ndarray, unit: str) -> None:
        """Raise a SceneError for the first value of a column, in an SI unit, that is not above the one before."""
        row = next((k for k in range(1, len(values)) if values[k] <= values[k - 1]), None)
        if row is not None:
            got = f"got {values[row]:g} {unit} after {values[row - 1]:g} {unit}"
            raise self.error(f"{self.line(row)}{noun} must rise from line to line, {got}")

    def refuse_uneven(self) -> None:
        """Raise a SceneError for a row with more or fewer values than there are heads."""
        for number, row in enumerate(self.rows):
            if len(row) != len(self.names):
                raise self.error(self.line(number) + other_number(len(self.names), len(row)))

    def lacking(self, wanted: str, hint: str = "") -> SceneError:
        """Return the error that the file has not the columns that are wanted."""
        return self.error(f"must have the columns {wanted}; got {', '.join(self.names)}{hint}")

    def line(self, row: int) -> str:
        """Return the words for a row that begin the refusal of one of its values."""
        return f"line {self.lines[row]}, " if self.lines[row] else f"point {row + 1}, "

    def _number(self, row: int, column: int) -> float:
        values = self.rows[row]
        if any(values[len(self.names) :]):
            hint = ": decimal commas need semicolons or tabs between the columns"
            raise self.error(self.line(row) + other_number(len(self.names), len(values)) + hint)
        text = values[column] if column < len(values) else ""
        value = finite_number(text)
        if value is not None:
            return value
        hint = ": write a decimal point and no thousands separator" if "," in text else ""
        try:
            complex(unit := text.replace("i", "j"))
            hint = ": a complex number goes into two columns, _real_ and _imag_" if "j" in unit else hint
        except ValueError:
            pass
        where = f"{self.line(row)}{self.names[column]}"
        raise self.error(f"{where} {no_number(text)}{hint}")


def finite_number(text: str) -> float | None:
    """Return the number of a text; None where it is no finite one."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def no_number(text: str) -> str:
    """Return the rule that a text breaks which is no finite number."""
    return f"must be a finite number, got {shown(text)}"


def other_number(wanted: int, got: int) -> str:
    """Return the rule that a line breaks with more or fewer values than are wanted."""
    return f"must have {wanted} values, got {got}"


def finite_numbers(words: list[str], line: str, error: Callable[[str], SceneError]) -> list[float]:
    """Return the numbers of the words of a line; what ``error`` makes of the rule that they break is raised."""
    values = []
    for word in words:
        try:
            values.append(float(word))
        except ValueError:
            raise error(f"must hold numbers, got {shown(word)}") from None
    if not np.all(np.isfinite(values)):
        raise error(f"must hold finite numbers only, got {shown(line)}")
    return values


def above_zero(frequency: np.ndarray, error: Callable[[str], SceneError]) -> np.ndarray:
    """Return where frequencies are above 0 Hz; what ``error`` makes of the rule is raised for negative ones or none."""
    if np.any(frequency < 0.0) or not np.any(frequency > 0.0):
        raise error("must have frequencies above 0 Hz")
    return frequency > 0.0


def written(unit: str) -> str:
    """Return the unit of a head as it is written in a text.

    Examples
    --------
    >>> written("mm_per_s_per_V"), written("m_per_s2")
    ('mm/s/V', 'm/s^2')
    """
    return unit.replace("_per_", "/").replace("s2", "s^2")
