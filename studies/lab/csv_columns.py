"""Columns of a CSV file by the quantity and the unit in their heads, such as ``x_mm`` or ``u_z_real_nm_per_V``."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.refusal import SceneError, shown

# factors to SI units, by the unit in a head
POSITIONS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
FREQUENCIES = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6}
DISPLACEMENTS = {"m": 1.0, "um": 1e-6, "nm": 1e-9, "pm": 1e-12}
VELOCITIES = {"m_per_s": 1.0, "mm_per_s": 1e-3, "um_per_s": 1e-6}
VOLTAGES = {"V": 1.0}
PHASES = {"rad": 1.0, "deg": np.pi / 180.0}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}


def file_error(path: Path, option: str, rule: str) -> SceneError:
    """Return the error that a file, named by an option of the command, breaks a rule."""
    return SceneError(option, f"{str(path)!r} {rule}")


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
class CsvColumns:
    """The columns of a CSV file as text, with the option of the command that named it.

    Columns that are not read may have any unit.
    """

    path: Path
    option: str
    names: list[str]
    rows: list[list[str]]

    @classmethod
    def read(cls, path: str | Path, option: str) -> "CsvColumns":
        """Read a CSV file; lines that begin with # are ignored."""
        path = Path(path)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise SceneError(option, f"{str(path)!r} cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise SceneError(option, f"{str(path)!r} is no CSV file in UTF-8") from None
        lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        separator = next((sign for sign in ",;\t" if lines and sign in lines[0]), ",")
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
        if len(rows) < 2:
            raise SceneError(option, f"{str(path)!r} must hold a line of names and at least one point")
        return cls(path=path, option=option, names=rows[0], rows=rows[1:])

    def column(self, noun: str, units: dict[str, float]) -> tuple[np.ndarray, str] | None:
        """Return the values of the column ``noun_UNIT`` in SI units and its unit; None where no head begins so.

        Raises
        ------
        SceneError
            If the unit is none of those known, two heads begin so, or a cell is no real number.
        """
        own = [name for name in self.names if name == noun or name.startswith(f"{noun}_")]
        matches = [name for name in own if name.removeprefix(noun).removeprefix("_") in units]
        if not own:
            return None
        if len(matches) != 1:
            rule = f"must have one column {noun}_UNIT with a unit of {', '.join(units)}, got {', '.join(own)}"
            raise self.error(rule)
        at, unit = self.names.index(matches[0]), matches[0].removeprefix(f"{noun}_")
        return np.array([self._number(k, at) for k in range(len(self.rows))]) * units[unit], unit

    def values(self, noun: str, units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the values of the `column`, or None if no head has one of the units; nothing is refused."""
        column = self.column(noun, units) if any(f"{noun}_{unit}" in self.names for unit in units) else None
        return None if column is None else tuple(column[0].tolist())

    def deviation(self, nouns: tuple[str, ...], units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the first of the columns ``nouns`` that exists, in SI units, or None; it must be positive."""
        bare = next((name for name in ("error", "velocity_error", "sigma", "uncertainty") if name in self.names), None)
        if bare is not None:
            heads = " or ".join(f"{nouns[0]}_{unit}" for unit in units)
            raise SceneError(self.option, f"{str(self.path)!r}: the column {bare} has no unit; name it {heads}")
        noun = next((noun for noun in nouns for unit in units if f"{noun}_{unit}" in self.names), None)
        if noun is None:
            return None
        values = self.values(noun, units) or ()
        if min(values) <= 0:
            rule = f"{noun}_{next(iter(units))} must be positive, got {min(values)!r}"
            raise SceneError(self.option, f"{str(self.path)!r}: {rule}")
        return values

    def refuse_uneven(self) -> None:
        """Raise a SceneError for a row with more or fewer values than there are heads."""
        for number, row in enumerate(self.rows, start=1):
            if len(row) != len(self.names):
                raise self.error(f"must have {len(self.names)} values at point {number}, got {len(row)}")

    def error(self, rule: str) -> SceneError:
        """Return the error that this file breaks a rule."""
        return file_error(self.path, self.option, rule)

    def _number(self, row: int, column: int) -> float:
        text = self.rows[row][column] if column < len(self.rows[row]) else ""
        where = f"{str(self.path)!r}, point {row + 1}, {self.names[column]}"
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if np.isfinite(value):
            return value
        hint = ": write a decimal point" if "," in text else ""
        try:
            complex(unit := text.replace("i", "j"))
            hint = ": a complex number goes into two columns, _real_ and _imag_" if "j" in unit else hint
        except ValueError:
            pass
        raise SceneError(self.option, f"{where} must be a finite number, got {shown(text)}{hint}")
