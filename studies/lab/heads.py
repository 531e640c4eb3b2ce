"""Columns of a CSV file by the quantity and the unit in their heads, such as ``x_mm`` or ``u_z_real_nm_per_V``."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.refusal import SceneError, shown

# factors to SI units, by the unit as a head spells it
PLACES = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
FREQUENCIES = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6}
DISPLACEMENTS = {"m": 1.0, "um": 1e-6, "nm": 1e-9, "pm": 1e-12}
VELOCITIES = {"m_per_s": 1.0, "mm_per_s": 1e-3, "um_per_s": 1e-6}
VOLTAGES = {"V": 1.0}
PHASES = {"rad": 1.0, "deg": np.pi / 180.0}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}


def file_error(path: Path, option: str, rule: str) -> SceneError:
    """Return the error that a file, named by an option of the command, breaks a rule."""
    return SceneError(option, f"{str(path)!r} {rule}")


@dataclass(frozen=True, kw_only=True)
class Heads:
    """The columns of a file as text, with the option of the command that named it."""

    path: Path
    option: str
    names: list[str]
    rows: list[list[str]]

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
            complex(text.replace("i", "j"))
            hint = ": a complex number goes into two columns, _real_ and _imag_" if text else ""
        except ValueError:
            pass
        raise SceneError(self.option, f"{where} must be a finite number, got {shown(text)}{hint}")
