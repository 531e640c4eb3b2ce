"""The files of a run, written from a record and read back: run.json, tables, field, and the resolved scene."""

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import fem
from studies.record.quantities import described, quantity
from studies.record.surface_map import surface_map
from studies.record.values import Columns
from studies.refusal import EXIT_BAD_INPUT, RunError
from studies.results.content import write_json
from studies.scene import Scene
from studies.scene.toml import document

PAIRS = ("tilt_rad",)  # of a point: lists of two numbers in run.json that are not complex numbers

if TYPE_CHECKING:
    import xarray as xr

    from studies.record import Record


def write_run(record: "Record", folder: Path, *, field: bool) -> None:
    """Write a run's files into an empty directory; ``field``: also the interior field, which is rebuilt for it."""
    write_json(folder / "run.json", record.to_dict())
    remark = f"as resolved; sawmotor run scene.toml --tolerance {record.tolerance!r} gives the same numbers"
    scene = document(record.scene.to_table(), remarks=(remark,))
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    if record.scene.slider is not None:
        points = [flat(point) for point in record.points]
        keys = list(dict.fromkeys(key for point in points for key in point))
        write_table(folder / "velocity.csv", keys, [[point.get(key, "") for key in keys] for point in points])
    for name in ("pillars", "slider_wave"):
        if getattr(record, name):
            write_columns(folder / f"{name}.csv", getattr(record, name))
    if record.surface:
        name = "surface.csv" if record.scene.transducer else "profile.csv"
        write_columns(folder / name, record.surface)
    if record.trajectories:
        tables = [(level, _instants(motion)) for level, motion in record.trajectories]
        if record.scene.slider.axis is not None:  # which holds the place
            tables = [(level, {k: v for k, v in table.items() if k not in OF_PLACE}) for level, table in tables]
        rows = [(level, *instant) for level, table in tables for instant in zip(*table.values(), strict=True)]
        write_table(folder / "trajectory.csv", [record.level, *tables[0][1]], rows)
    if field and record.surface_wave is not None:
        fem.write_vtu(fem.wave_field(record.surface_wave), folder / "field.vtu")
        if record.surface_motion.beam is not None:
            x, y, motion = surface_map(record.surface_motion.beam, record.scene.stator)
            fem.write_surface(x, y, motion, folder / "surface_map.vtu")
            columns = dict(x_m=x.repeat(y.size), y_m=y[None].repeat(x.size, axis=0).ravel())
            columns |= {f"u_{name}_m_per_V": each.ravel() for name, each in zip("xyz", motion, strict=True)}
            write_columns(folder / "surface_map.csv", columns)


def flat(values: Mapping) -> Columns:
    """Return numbers or arrays by name: complex ones as ``..._re`` and ``..._im``, lists as ``..._0``, ``..._1``."""
    columns = Columns()
    for key, value in values.items():
        if isinstance(value, (list, tuple)):
            columns |= {f"{key}_{index}": each for index, each in enumerate(value)}
        elif np.iscomplexobj(value):
            columns |= {f"{key}_re": value.real, f"{key}_im": value.imag}
        else:
            columns[key] = value
    return columns


def labelled_column(key: str, values: list) -> tuple[np.ndarray, dict[str, str]]:
    """Return a column as an array, of texts where one value is a text, and its attributes in xarray."""
    if any(isinstance(value, str) for value in values):
        return np.array([value or "" for value in values], dtype=str), described(key)
    return np.array(values, dtype=float), {"units": "1"} | described(key)


def write_columns(path: Path, columns: dict) -> None:
    """Write arrays as columns; a complex one becomes two, as in `flat`."""
    columns = flat(columns)
    write_table(path, columns, zip(*(each.tolist() for each in columns.values()), strict=True))


def write_netcdf(dataset: "xr.Dataset", path: Path) -> None:
    """Write a dataset of real numbers and texts as netCDF 3, which needs no further package than scipy.

    xarray's engines scipy and netcdf4 open it, and so do Octave, Julia, ncdump and Panoply; h5netcdf reads netCDF 4
    alone.
    """
    dataset.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")


def write_table(path: Path, keys, rows) -> None:
    """Write a table as CSV, numbers with all digits."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(keys)
        writer.writerows(rows)


class Motion(NamedTuple):
    """Motion of the slider over a burst, as in ``trajectory.csv``; arrays of shape (k,)."""

    time: np.ndarray  # s from the start of the burst
    velocity: np.ndarray  # m/s
    position: np.ndarray  # of the slider along z, m


class PlaneMotion(NamedTuple):
    """Motion in the plane over a burst, as in ``trajectory.csv``."""

    time: np.ndarray  # (k,) s from the start of the burst
    pose: np.ndarray  # (k, 3): x, y and yaw from the start, m and rad
    rates: np.ndarray  # (k, 3) of the pose
    height: np.ndarray  # (k,) of the slider along z, m

    @property
    def velocity(self) -> np.ndarray:
        """(k, 2), m/s."""
        return self.rates[:, :2]


PLANE_COLUMNS = tuple(
    each.column
    for each in (
        quantity.velocity_m_per_s, quantity.lateral_velocity_m_per_s, quantity.yaw_rate_rad_per_s, quantity.x_m,
        quantity.y_m, quantity.yaw_rad,
    )
)  # fmt: skip


OF_PLACE = tuple(each for each in PLANE_COLUMNS if "yaw" not in each)


def _instants(motion) -> dict[str, list]:
    """Return the columns of a burst's motion by name."""
    time_at = {quantity.time_s.column: motion.time.tolist()}
    if hasattr(motion, "pose"):
        values = np.concatenate([motion.rates, motion.pose], axis=1).T.tolist()
        return time_at | dict(zip(PLANE_COLUMNS, values, strict=True)) | {"normal_position_m": motion.height.tolist()}
    own = {quantity.velocity_m_per_s.column: motion.velocity.tolist(), "normal_position_m": motion.position.tolist()}
    return time_at | own


class NoRunError(RunError):
    """A directory that holds no run, or one that cannot be read."""

    exit_code = EXIT_BAD_INPUT


class DamagedRunError(NoRunError):
    """A run.json that is no JSON: cut off, or changed by hand."""


def read_run(folder: Path) -> dict:
    """Return the fields of the record that a run left in a directory.

    Raises
    ------
    NoRunError
        If the directory holds no run; `DamagedRunError` if its run.json is cut off.
    """
    try:
        whole = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        scene = Scene.from_table("", whole["scene"])
    except FileNotFoundError:
        raise NoRunError(f"{str(folder)!r} holds no run.json: name a directory that a run left") from None
    except NotADirectoryError:
        raise NoRunError(f"{str(folder)!r} is a file: name a directory that a run left") from None
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}: {error.msg}"
        raise DamagedRunError(f"{str(folder / 'run.json')!r} is damaged or cut off: {where}") from None
    except (OSError, ValueError, KeyError) as error:
        raise NoRunError(f"{str(folder / 'run.json')!r} cannot be read: {error}") from None
    fields = {
        key: whole[key]
        for key in ("tolerance", "summary", "heat", "uncertainty", "measured", "error", "seconds", "shortfall")
        if key in whole
    }
    fields |= {block: _complex(whole.get(block, {})) for block in ("wave", "electrical")}
    if "measured" in fields:
        measured = fields["measured"]
        measured |= {key: _arrays(measured[key]) for key in ("scan", "line", "trace") if key in measured}
    fields["points"] = tuple(
        {key: value if key in PAIRS else _complex(value) for key, value in point.items()}
        for point in whole.get("points", ())
    )
    for key in ("left_out", "model_error", "warnings"):
        fields[key] = tuple(whole.get(key, ()))
    fields |= {"scene": scene, "versions": whole.get("provenance", {})}
    for name in ("surface", "profile", "pillars", "slider_wave"):
        if (folder / f"{name}.csv").exists():
            fields["surface" if name == "profile" else name] = _columns(folder / f"{name}.csv")
    if (folder / "trajectory.csv").exists():
        fields["trajectories"] = _trajectories(folder / "trajectory.csv")
    return fields


def _complex(value):
    """Return a value of run.json, its pairs of numbers as complex ones."""
    if isinstance(value, dict):
        return {key: _complex(each) for key, each in value.items()}
    return complex(*value) if isinstance(value, list) and len(value) == 2 else value


def _arrays(columns: dict) -> Columns:
    """Return columns of numbers of run.json as arrays, their pairs of numbers as complex ones."""
    arrays = {name: np.array(values, dtype=float) for name, values in columns.items()}
    return Columns((key, each if each.ndim == 1 else each[:, 0] + 1j * each[:, 1]) for key, each in arrays.items())


def _table(path: Path) -> Columns:
    """Return the columns of a table of numbers as arrays."""
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return Columns(zip(head, np.array(rows, dtype=float).reshape(len(rows), len(head)).T, strict=True))


def _columns(path: Path) -> Columns:
    """Return the columns of a table, ``..._re`` and ``..._im`` joined to one complex column."""
    table, columns = _table(path), Columns()
    for name, values in table.items():
        if name.endswith("_re") and f"{name[:-3]}_im" in table:
            columns[name[:-3]] = values + 1j * table[f"{name[:-3]}_im"]
        elif not (name.endswith("_im") and f"{name[:-3]}_re" in table):
            columns[name] = values
    return columns


def _trajectories(path: Path) -> tuple:
    """Return level and motion of each burst."""
    table = _table(path)
    levels, times, *columns = table.values()

    def motion(own: np.ndarray) -> Motion | PlaneMotion:
        if "yaw_rad" not in table:
            return Motion(times[own], *(column[own] for column in columns))
        still = np.zeros(len(times))  # what an axle holds is left out
        rates_and_pose = np.array([table.get(name, still)[own] for name in PLANE_COLUMNS]).T
        return PlaneMotion(times[own], rates_and_pose[:, 3:], rates_and_pose[:, :3], table["normal_position_m"][own])

    return tuple((level, motion(levels == level)) for level in dict.fromkeys(levels.tolist()))
