"""Reading the files of a run: the reverse of ``files``."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from studies.refusal import RunError
from studies.scene import Scene

if TYPE_CHECKING:
    import numpy as np

__all__ = ["Motion", "read_run"]


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Motion of the slider over a burst, as ``trajectory.csv`` keeps it.

    Attributes
    ----------
    time : ndarray, shape (k,)
        s from the start of the burst.
    velocity : ndarray, shape (k,)
        Of the slider, m/s.
    position : ndarray, shape (k,)
        Normal position of the slider, m.
    """

    time: "np.ndarray"
    velocity: "np.ndarray"
    position: "np.ndarray"


def read_run(folder: Path) -> dict:
    """Return the fields of the record that a run left in a directory.

    Raises
    ------
    RunError
        If the directory holds no run.
    """
    try:
        whole = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        scene = Scene.from_table("", whole["scene"])
    except FileNotFoundError:
        raise RunError(f"{str(folder)!r} holds no run.json: name a directory that a run left") from None
    except (OSError, ValueError, KeyError) as error:
        raise RunError(f"{str(folder / 'run.json')!r} cannot be read: {error}") from None
    fields = {
        key: whole[key]
        for key in ("tolerance", "summary", "uncertainty", "measured", "error", "seconds", "shortfall")
        if key in whole
    }
    fields |= {block: _complex(whole.get(block, {})) for block in ("wave", "electrical")}
    for key in ("points", "left_out", "model_error", "warnings"):
        fields[key] = tuple(whole.get(key, ()))
    fields |= {"scene": scene, "versions": whole.get("provenance", {})}
    for name in ("surface.csv", "profile.csv"):
        if (folder / name).exists():
            fields["surface"] = _columns(folder / name)
    if (folder / "trajectory.csv").exists():
        fields["trajectories"] = _trajectories(folder / "trajectory.csv")
    return fields


def _complex(value):
    """Return a value of run.json, its pairs of numbers as complex ones."""
    if isinstance(value, dict):
        return {key: _complex(each) for key, each in value.items()}
    return complex(*value) if isinstance(value, list) and len(value) == 2 else value


def _table(path: Path) -> dict:
    """Return the columns of a table of numbers as arrays."""
    import numpy as np

    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, dtype=float).reshape(len(rows), len(head)).T, strict=True))


def _columns(path: Path) -> dict:
    """Return the columns of a table, ``..._re`` and ``..._im`` joined to one complex column."""
    table, columns = _table(path), {}
    for name, values in table.items():
        if name.endswith("_re") and f"{name[:-3]}_im" in table:
            columns[name[:-3]] = values + 1j * table[f"{name[:-3]}_im"]
        elif not (name.endswith("_im") and f"{name[:-3]}_re" in table):
            columns[name] = values
    return columns


def _trajectories(path: Path) -> tuple:
    """Return level and motion of each burst."""
    table = list(_table(path).values())
    levels, time, velocity, position = table
    return tuple(
        (float(level), Motion(time=time[at], velocity=velocity[at], position=position[at]))
        for level in dict.fromkeys(levels.tolist())
        for at in [levels == level]
    )
