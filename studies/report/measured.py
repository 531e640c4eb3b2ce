"""A measured curve beside the predicted one: slider velocity against drive voltage, or against a given amplitude.

The file is CSV with a line of names. Columns: ``voltage_V`` (or ``normal_amplitude_m``, ``_nm`` for a given wave),
``velocity_m_per_s`` (or ``_mm_per_s``) and perhaps ``velocity_standard_deviation_m_per_s`` or ``error_m_per_s`` (or
``_mm_per_s``), one standard deviation. Other columns are ignored, so that a run's own velocity.csv may be compared with
another run.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from studies.refusal import SceneError, shown

if TYPE_CHECKING:
    from studies.record import Record

__all__ = ["Measured", "MeasuredTable", "compared", "comparison", "read_measured"]

VOLTAGES, LENGTHS = {"V": 1.0}, {"m": 1.0, "nm": 1e-9}  # units of a column's name, in SI units
SPEEDS, TIMES = {"m_per_s": 1.0, "mm_per_s": 1e-3}, {"s": 1.0, "ms": 1e-3}
OPTION = "--measured"


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Measured points, in SI units."""

    name: str  # of the file
    key: str  # ``voltage_V`` or ``normal_amplitude_m``
    level: tuple[float, ...]  # V or m
    velocity: tuple[float, ...]  # m/s
    error: tuple[float, ...] | None  # standard deviations, m/s


@dataclass(frozen=True, kw_only=True)
class MeasuredTable:
    """The columns of a CSV file, as text."""

    path: Path
    option: str  # of the command, for refusals
    names: list[str]  # of the columns
    rows: list[list[str]]

    @classmethod
    def read(cls, path: str | Path, option: str) -> "MeasuredTable":
        """Read a file; lines that begin with # are ignored."""
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

    def column(self, noun: str, units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the column ``noun_unit`` in SI units; None where there is none."""
        for unit, factor in units.items():
            if f"{noun}_{unit}" in self.names:
                at = self.names.index(f"{noun}_{unit}")
                return tuple(self._number(row, at) * factor for row in range(len(self.rows)))
        return None

    def deviation(self, nouns: tuple[str, ...], units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the standard deviations of the first of these columns, positive, in SI units; or None."""
        bare = next(
            (name for name in ("error", "velocity_error", "sigma", "uncertainty") if name in self.names), None
        )
        if bare is not None:
            rule = f"the column {bare} has no unit; name it " + " or ".join(
                f"{nouns[0]}_{unit}" for unit in units
            )
            raise SceneError(self.option, f"{str(self.path)!r}: {rule}")
        noun = next((noun for noun in nouns for unit in units if f"{noun}_{unit}" in self.names), None)
        if noun is None:
            return None
        values = self.column(noun, units)
        if min(values) <= 0:
            rule = f"{str(self.path)!r}: {noun}_{next(iter(units))} must be positive, got {min(values)!r}"
            raise SceneError(self.option, rule)
        return values

    def _number(self, row: int, column: int) -> float:
        text = self.rows[row][column] if column < len(self.rows[row]) else ""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            where = f"{str(self.path)!r}, point {row + 1}, {self.names[column]}"
            hint = ": write a decimal point" if "," in text else ""
            raise SceneError(self.option, f"{where} must be a finite number, got {shown(text)}{hint}")
        return value


def read_measured(path: str | Path) -> Measured:
    """Read a file of measured points.

    Raises
    ------
    SceneError
        If it cannot be read, lacks a column, or holds what is no number.
    """
    table = MeasuredTable.read(path, OPTION)
    level, key = table.column("voltage", VOLTAGES), "voltage_V"
    if level is None:
        level, key = table.column("normal_amplitude", LENGTHS), "normal_amplitude_m"
    velocity = table.column("velocity", SPEEDS)
    if level is None or velocity is None:
        wanted = "voltage_V (or normal_amplitude_m) and velocity_m_per_s (or velocity_mm_per_s)"
        raise SceneError(
            OPTION, f"{str(table.path)!r} must have the columns {wanted}, got {', '.join(table.names)}"
        )
    error = table.deviation(("error", "velocity_standard_deviation"), SPEEDS)
    return Measured(name=table.path.name, key=key, level=level, velocity=velocity, error=error)


def compared(record: "Record", measured: Measured) -> dict:
    """Return the block ``measured`` of run.json: each point beside the prediction, and how far they are apart.

    The prediction is interpolated linearly between the run's points; measured points outside them are listed without
    one. Speeds measured without a sign are given the prediction's.

    Raises
    ------
    SceneError
        If the run has no slider, another drive, or no point at which both are known.
    """
    import numpy as np

    if record.scene.slider is None:
        raise SceneError(OPTION, "needs a scene with a [slider]: there is no velocity to compare with")
    if measured.key != record.level:
        raise SceneError(OPTION, f"must have the column {record.level} for this scene, got {measured.key}")
    known = sorted((p[record.level], p["velocity_m_per_s"]) for p in record.points if "velocity_m_per_s" in p)
    if not known:
        raise SceneError(OPTION, "has nothing to be compared with: no point of the run has a velocity")
    at, speeds = np.array(known).T
    level, velocity = np.array(measured.level), np.array(measured.velocity)
    unsigned = bool(np.all(velocity >= 0) and np.all(speeds <= 0) and np.any(speeds < 0))
    if unsigned:
        velocity = -velocity
    inside = (level >= at[0]) & (level <= at[-1])
    if not inside.any():
        ends = f"{at[0]:.4g} to {at[-1]:.4g}"
        raise SceneError(OPTION, f"has no point within the run's {record.level}, {ends}")
    predicted = np.interp(level, at, speeds)
    points = []
    for k in range(len(level)):
        point = {record.level: float(level[k]), "velocity_m_per_s": float(velocity[k]) + 0.0}
        if measured.error is not None:
            point["error_m_per_s"] = measured.error[k]
        if inside[k]:
            point["predicted_m_per_s"] = float(predicted[k])
        points.append(point)
    gap = (velocity - predicted)[inside]
    rms, largest = float(np.sqrt(np.mean(gap**2))), float(abs(predicted[inside]).max())
    block = {
        "file": measured.name,
        "points": points,
        "compared": int(inside.sum()),
        "sign_of_prediction_given": unsigned,
        "rms_deviation_m_per_s": rms,
        "mean_deviation_m_per_s": float(gap.mean()),
    }
    if largest > 0:
        square = float(np.sum(predicted[inside] ** 2))
        block["rms_deviation_relative"] = rms / largest
        block["measured_over_predicted"] = float(np.sum((velocity * predicted)[inside]) / square)
    if measured.error is not None:
        ratios = gap / np.array(measured.error)[inside]
        block["within_one_error"] = int(np.sum(abs(ratios) <= 1))
        block["chi_square_per_point"] = float(np.mean(ratios**2))
    return block


def comparison(block: dict):
    """Yield what a run prints of a comparison, as rows of a name and a line."""
    if not block:
        return
    rms, mean = (block[f"{kind}_deviation_m_per_s"] * 1e3 for kind in ("rms", "mean"))
    relative = block.get("rms_deviation_relative")
    share = "" if relative is None else f" ({100 * relative:.2g} % of the largest predicted)"
    yield "measured", f"{block['compared']} of {len(block['points'])} points of {block['file']} compared"
    yield "", f"deviation {rms:.3g} mm/s rms{share}, mean {mean:+.3g} mm/s"
    if "measured_over_predicted" in block:
        yield "", f"measured / predicted {block['measured_over_predicted']:.3g} (least squares)"
    if "within_one_error" in block:
        within = f"{block['within_one_error']} of {block['compared']} within their error"
        yield "", f"{within}, chi^2 per point {block['chi_square_per_point']:.3g}"
    if block["sign_of_prediction_given"]:
        yield "", "measured without a sign: taken to run as predicted"
