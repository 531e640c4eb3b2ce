"""The design of a sweep: the product of its axes, the numbers of its points, and the question at each point.

Points are numbered with the last axis running fastest.  Without an axis of voltage or amplitude the scene's own
list of them is the last axis.  The points are not stored: a million of them take 8 MB and the memory of their axes.
"""

import hashlib
import json
import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy as np

from studies.model.changed_scenes import ChangedScenes
from studies.model.model import POSITION_KEYS, changes_stator
from studies.record.quantities import quantity
from studies.refusal import SceneError, refuse_if, refuse_outside, refuse_repeated
from studies.scene.keys import rule_at
from studies.solve.requested_quantities import ALSO, AMPLITUDES, ELECTRICAL, FREE, motions_in_plane, refuse_of_pillars
from studies.sweeps.axes import Axis, axis, level_key, point_axis

MAX_POINTS = 10_000_000
MAX_POSITIONS = 4096  # combinations of slider positions at which one solution of the stator is evaluated
MIN_BAND_FREQUENCIES = 6  # from which a band is cheaper than one solution each


@dataclass(frozen=True, kw_only=True)
class Question:
    """What every point of a sweep shares: all that a worker needs beside a point's own values."""

    document: str  # TOML document of the scene, as JSON
    keys: tuple[str, ...]  # of the point's values
    tolerance: float
    also: tuple[str, ...] = ()  # further outcomes, of ``ALSO``
    # (x, y) in m of all contacts of all points; empty where the stator is solved for each point's own
    positions: tuple[tuple[float, float], ...] = ()
    frequencies: tuple[float, ...] = ()  # lowest and highest in Hz, where there are enough of them for a band
    frequency_count: int = 0  # of different frequencies
    # True takes the stator's coarsest discretisation: for a search, whose best points are computed again
    coarse: bool = False

    @cached_property
    def table(self) -> dict:
        """The scene's TOML document."""
        return json.loads(self.document)

    @property
    def kind(self) -> str:
        """Kind of wave: "prescribed" by the scene, "driven" by a transducer, or "free", a surface wave alone."""
        if "wave" in self.table:
            return "prescribed"
        return "driven" if self.table.get("transducer") else "free"

    @property
    def has_slider(self) -> bool:
        """Whether the points have a slider, and so a velocity."""
        changed = any(key.startswith("slider.") for key in self.keys)
        return self.kind != "free" and ("slider" in self.table or changed)

    @property
    def stator_keys(self) -> tuple[str, ...]:
        """The keys whose every value needs a stator of its own."""
        own = (key for key in self.keys if changes_stator(key) or (key in POSITION_KEYS and not self.positions))
        return tuple(own) if self.kind == "driven" else ()

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Columns of a point's answer."""
        names = list(FREE) if self.kind == "free" else [*AMPLITUDES]
        if self.kind == "driven":
            names += ELECTRICAL
        if self.has_slider:
            burst = "burst" in self.table.get("wave" if self.kind == "prescribed" else "drive", {})
            burst = burst or any(key.endswith(".burst") for key in self.keys)
            motion = motions_in_plane(self.table.get("slider", {})) or (quantity.velocity_m_per_s.column,)
            names += [*motion, *(["velocity_at_burst_end_m_per_s"] if burst else []), "regime"]
            for word, columns in ALSO.items():
                names += columns if word in self.also else []
            if self.kind == "prescribed" and "motor_efficiency" in names:
                names.remove("motor_efficiency")
        return (*names, "relative_error", "status")


@dataclass(frozen=True, kw_only=True)
class Design:
    """The points of a sweep."""

    question: Question
    axes: tuple[Axis, ...] = field(repr=False)

    def __len__(self):
        return math.prod(len(each) for each in self.axes)

    @property
    def stators(self) -> int:
        """Number of stators to be solved, a band of frequencies as one for each geometry."""
        question, count = self.question, 1
        for each in self.axes:
            banded = question.frequencies and each.keys == ("drive.frequency",)
            count *= len(each) if set(each.keys) & set(question.stator_keys) and not banded else 1
        return count

    def values(self, points) -> list[tuple]:
        """Return the values of the keys at the points of an array of point numbers."""
        if not self.axes:
            return [()] * len(points)
        columns = []
        at = np.unravel_index(points, tuple(len(each) for each in self.axes))
        for each, indices in zip(self.axes, at, strict=True):
            columns += [[column[index] for index in indices.tolist()] for column in each.columns]
        return list(zip(*columns, strict=True))

    def order(self):
        """Return the numbers of all points, ordered so that the points of one stator are consecutive."""
        ranks, orders = [], []
        for each in self.axes:
            own = {k: key for k, key in enumerate(each.keys) if key in self.question.stator_keys}
            # geometries are slowest, then frequencies, of which many make a band
            ranks.append(0 if not own else 1 if "drive.frequency" in own.values() else 2)
            texts = [[str(each.columns[k][index]) for k in own] for index in range(len(each))]
            orders.append(sorted(range(len(each)), key=texts.__getitem__))
        numbers = np.arange(len(self)).reshape([len(each) for each in self.axes])
        slowest = sorted(range(len(ranks)), key=lambda k: -ranks[k])
        return numbers[np.ix_(*orders)].transpose(slowest).ravel() if self.axes else numbers.ravel()

    @property
    def identity(self) -> dict[str, str]:
        """Digests of scene, files, axes, tolerance and further outcomes; two sweeps with equal digests are the same."""
        parts = {"scene": self.question.table, "tolerance": self.question.tolerance, "also": self.question.also}
        parts |= {f"axis {'+'.join(each.keys)}": each.columns for each in self.axes}
        parts |= {"order of axes": self.question.keys}
        parts |= {f"file {path}": content for path, content in _files(self.question.table)}
        return {name: _digest(part) for name, part in parts.items()}


def _refuse_in_plane(table: dict, also) -> None:
    """Raise a SceneError for a quantity that has no answer for a slider in the plane."""
    if table["slider"].get("axis") is not None or table["slider"].get("freedom", "x") != "x":
        from studies.solve.plane_quantities import refuse_in_plane

        refuse_in_plane(also)


def designed(table: dict, over, *, tolerance, also=()) -> Design:
    """Return the design of a sweep of a scene's TOML document; the other arguments are those of `studies.sweeps`.

    Raises
    ------
    SceneError
        For a fault of all points.
    """
    refuse_outside(also, ALSO, "also")
    if "pillars" in table.get("slider", {}):
        refuse_of_pillars(also)
    elif also and not {"freedom", "axis"}.isdisjoint(table.get("slider", {})):
        _refuse_in_plane(table, also)
    axes = []
    for part in over if isinstance(over, list) else [over or {}]:
        axes += [axis(key, values) for key, values in part.items()] if isinstance(part, dict) else [point_axis(part)]
    keys = [key for each in axes for key in each.keys]
    refuse_repeated(keys, "over")
    level = level_key(table)
    if level is not None and level not in keys:
        block, name = level.split(".")
        axes.append(axis(level, list(rule_at(level).read(level, table.get(block, {}).get(name)))))
    design = Design(question=_question(table, tuple(axes), tolerance, tuple(also)), axes=tuple(axes))
    refuse_if(len(design) > MAX_POINTS, "over", f"must make at most {MAX_POINTS} points, got {len(design)}")
    return design


def _question(table, axes, tolerance, also) -> Question:
    keys = tuple(key for each in axes for key in each.keys)
    columns = dict(zip(keys, (column for each in axes for column in each.columns), strict=True))
    question = Question(document=json.dumps(table), keys=keys, tolerance=tolerance, also=also)
    if question.kind != "driven":
        return question
    frequencies = {each for each in columns.get("drive.frequency", ()) if isinstance(each, float) and each > 0}
    # a band has one geometry: no period may follow from the frequency
    fixed = not any(isinstance(each.get("period", "auto"), str) for each in table["transducer"])
    band = fixed and not any(key.endswith(".period") for key in keys) and len(frequencies) >= MIN_BAND_FREQUENCIES
    limits = (min(frequencies), max(frequencies)) if band else ()
    positions = _positions(table, columns)
    return replace(question, positions=positions, frequencies=limits, frequency_count=len(frequencies))


def _positions(table: dict, columns: dict) -> tuple[tuple[float, float], ...]:
    """Return the positions (x, y) of all contacts, m; none where they are too many, or where there is no slider."""
    moved = {key: dict.fromkeys(columns[key]) for key in POSITION_KEYS if key in columns}
    if math.prod(map(len, moved.values())) > MAX_POSITIONS:
        return ()
    scenes = ChangedScenes(table)
    positions: dict[tuple[float, float], None] = {}
    first = {key: column[0] for key, column in columns.items()}
    for values in product(*moved.values()):
        with suppress(SceneError):  # refused at its point
            slider = scenes.scene(first | dict(zip(moved, values, strict=True))).slider
            positions |= dict.fromkeys(() if slider is None else (slider.center, *slider.contact_positions))
    return tuple(positions)


def _files(part):
    """Yield the files that a scene's table names, a mesh or a law, and digests of what they hold."""
    if isinstance(part, dict | list):
        for each in part.values() if isinstance(part, dict) else part:
            yield from _files(each)
    elif isinstance(part, str) and Path(part).suffix and Path(part).is_file():
        yield part, hashlib.sha256(Path(part).read_bytes()).hexdigest()


def _digest(part) -> str:
    return hashlib.sha256(json.dumps(part, sort_keys=True, default=str).encode()).hexdigest()[:16]
