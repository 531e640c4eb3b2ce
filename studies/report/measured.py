"""A measured curve beside the predicted one: slider velocity against drive voltage, or against a given amplitude.

The file is CSV with a line of names. Columns: ``voltage_V`` (or ``normal_amplitude_m``, ``_nm`` for a given wave),
``velocity_m_per_s`` (or ``_mm_per_s``) and perhaps ``error_m_per_s`` (or ``_mm_per_s``), one standard deviation. Other
columns are ignored, so that a run's own velocity.csv may be compared with another run.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from studies.record import Record
from studies.refusal import SceneError, shown

__all__ = ["Measured", "compared", "comparison_lines", "read_measured"]

LEVELS = {"voltage_V": ("voltage_V", 1.0), "normal_amplitude_m": ("normal_amplitude_m", 1.0)}
LEVELS["normal_amplitude_nm"] = ("normal_amplitude_m", 1e-9)
SPEEDS = {"m_per_s": 1.0, "mm_per_s": 1e-3}
OPTION = "--measured"


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Measured points, in SI units.

    Attributes
    ----------
    name : str
        Of the file.
    key : str
        ``voltage_V`` or ``normal_amplitude_m``.
    level, velocity : tuple of float
        V or m, and m/s.
    error : tuple of float, or None
        Standard deviations, m/s.
    """

    name: str
    key: str
    level: tuple[float, ...]
    velocity: tuple[float, ...]
    error: tuple[float, ...] | None


def read_measured(path: str | Path) -> Measured:
    """Read a file of measured points.

    Raises
    ------
    SceneError
        If it cannot be read, lacks a column, or holds what is no number.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise SceneError(OPTION, f"{str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SceneError(OPTION, f"{str(path)!r} is no CSV file in UTF-8") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator = next((sign for sign in ",;\t" if lines and sign in lines[0]), ",")
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
    if len(rows) < 2:
        raise SceneError(OPTION, f"{str(path)!r} must hold a line of names and at least one point")
    names = rows[0]
    level = next((name for name in names if name in LEVELS), None)
    speed = next((f"velocity_{unit}" for unit in SPEEDS if f"velocity_{unit}" in names), None)
    if level is None or speed is None:
        wanted = "voltage_V (or normal_amplitude_m) and velocity_m_per_s (or velocity_mm_per_s)"
        raise SceneError(OPTION, f"{str(path)!r} must have the columns {wanted}, got {', '.join(names)}")
    bare = next((name for name in ("error", "velocity_error", "sigma", "uncertainty") if name in names), None)
    if bare is not None:
        raise SceneError(
            OPTION, f"{str(path)!r}: the column {bare} has no unit; name it error_m_per_s or error_mm_per_s"
        )
    error = next((f"error_{unit}" for unit in SPEEDS if f"error_{unit}" in names), None)
    key, factor = LEVELS[level]
    columns = {name: [_number(path, rows, row, names.index(name)) for row in range(1, len(rows))]
               for name in (level, speed, error) if name is not None}  # fmt: skip
    errors = None
    if error is not None:
        errors = tuple(value * SPEEDS[error.removeprefix("error_")] for value in columns[error])
        if min(errors) <= 0:
            raise SceneError(OPTION, f"{str(path)!r}: {error} must be positive, got {min(columns[error])!r}")
    return Measured(
        name=path.name,
        key=key,
        level=tuple(value * factor for value in columns[level]),
        velocity=tuple(value * SPEEDS[speed.removeprefix("velocity_")] for value in columns[speed]),
        error=errors,
    )


def _number(path: Path, rows, row: int, column: int) -> float:
    text = rows[row][column] if column < len(rows[row]) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        where = f"{str(path)!r}, point {row}, {rows[0][column]}"
        hint = ": write a decimal point" if "," in text else ""
        raise SceneError(OPTION, f"{where} must be a finite number, got {shown(text)}{hint}")
    return value


def compared(record: Record, measured: Measured) -> dict:
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


def comparison_lines(block: dict) -> list[str]:
    """Return what a run prints of a comparison."""
    rms, mean = (block[f"{kind}_deviation_m_per_s"] * 1e3 for kind in ("rms", "mean"))
    relative = block.get("rms_deviation_relative")
    share = "" if relative is None else f" ({100 * relative:.2g} % of the largest predicted)"
    lines = [
        f"measured        {block['compared']} of {len(block['points'])} points of {block['file']} compared"
    ]
    lines.append(f"                deviation {rms:.3g} mm/s rms{share}, mean {mean:+.3g} mm/s")
    if "measured_over_predicted" in block:
        lines.append(
            f"                measured / predicted {block['measured_over_predicted']:.3g} (least squares)"
        )
    if "within_one_error" in block:
        chi = block["chi_square_per_point"]
        lines.append(
            f"                {block['within_one_error']} of {block['compared']} within their error, "
            f"chi^2 per point {chi:.3g}"
        )
    if block["sign_of_prediction_given"]:
        lines.append("                measured without a sign: taken to run as predicted")
    return lines
