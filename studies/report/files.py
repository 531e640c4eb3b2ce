"""The files of a run, from its record: run.json, tables, field, and the scene that runs again."""

import csv
import json
from pathlib import Path
from typing import TYPE_CHECKING

from studies.report.surface_map import surface_map
from studies.scene.toml import document

if TYPE_CHECKING:
    from studies.record import Record

__all__ = ["write_run", "write_table"]


def write_run(record: "Record", folder: Path, *, field: bool) -> None:
    """Write a run's files into a directory.

    Parameters
    ----------
    record : Record
    folder : Path
        Exists and is empty.
    field : bool
        Whether the interior field is rebuilt and kept.
    """
    text = json.dumps(record.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    (folder / "run.json").write_text(text + "\n", encoding="utf-8")
    remark = f"as resolved; sawmotor run scene.toml --tolerance {record.tolerance!r} gives the same numbers"
    scene = document(record.scene.to_table(), remarks=(remark,))
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    if record.scene.slider is not None:
        keys = list(dict.fromkeys(key for point in record.points for key in point))
        write_table(
            folder / "velocity.csv", keys, [[point.get(key, "") for key in keys] for point in record.points]
        )
    if record.surface:
        name = "surface.csv" if record.scene.transducer else "profile.csv"
        write_columns(folder / name, record.surface)
    if record.trajectories:
        rows = [
            (level, *instant)
            for level, motion in record.trajectories
            for instant in zip(
                motion.time.tolist(), motion.velocity.tolist(), motion.position.tolist(), strict=True
            )
        ]
        keys = [record.level, "time_s", "velocity_m_per_s", "normal_position_m"]
        write_table(folder / "trajectory.csv", keys, rows)
    if field and record.surface_wave is not None:
        import fem

        fem.write_vtu(fem.wave_field(record.surface_wave), folder / "field.vtu")
        if record.surface_motion.beam is not None:
            x, y, motion = surface_map(record.surface_motion.beam, record.scene.stator)
            fem.write_surface(x, y, motion, folder / "surface_map.vtu")
            columns = {"x_m": x.repeat(y.size), "y_m": y[None].repeat(x.size, axis=0).ravel()}
            columns |= {f"u_{name}_m_per_V": each.ravel() for name, each in zip("xyz", motion, strict=True)}
            write_columns(folder / "surface_map.csv", columns)


def write_columns(path: Path, columns: dict) -> None:
    """Write arrays as columns; a complex one becomes two, ``..._re`` and ``..._im``."""
    keys, values = [], []
    for name, array in columns.items():
        if array.dtype.kind == "c":
            keys += [f"{name}_re", f"{name}_im"]
            values += [array.real, array.imag]
        else:
            keys.append(name)
            values.append(array)
    write_table(path, keys, zip(*(column.tolist() for column in values), strict=True))


def write_table(path: Path, keys, rows) -> None:
    """Write a table as CSV, numbers to the last digit."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(keys)
        writer.writerows(rows)
