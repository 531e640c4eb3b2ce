"""The design of a sweep: axes multiplied, every point with a number, and the question asked at each.

Points are numbered with the last axis running fastest.  Without an axis of voltage or amplitude the scene's own
list of them is the last axis.  A design is never spelled out: a million points cost the memory of their axes.
"""

import hashlib
import json
import math
from dataclasses import dataclass, field, replace
from itertools import islice, product

import numpy as np

from studies.refusal import SceneError
from studies.scene.keys import rule_at
from studies.scene.numbers import as_pair
from studies.sweep.axes import Axis, axis, latin_axis, level_key, point_axis

ALSO = ("limits", "thrust", "efficiency", "pressure", "step")
MOST = 100_000_000
PLACES = 4096  # of contacts up to which one answer of the stator serves all
FEWEST = 6  # frequencies from which a band is cheaper than one solution each
PLACE_KEYS = ("slider.position", "slider.contacts")


@dataclass(frozen=True, kw_only=True)
class Question:
    """What is asked at every point: all that a worker needs beside a point's own values."""

    table: dict  # TOML document of the scene
    keys: tuple[str, ...]  # of the point's values
    tolerance: float
    also: tuple[str, ...] = ()  # more than the velocity: of ``ALSO``
    source_keys: tuple[str, ...] = ()  # those keys that the stator's answer depends on
    # Of all contacts of all points, x and y in m; empty where each point has its own
    places: tuple[tuple[float, float], ...] = ()
    frequencies: tuple[float, ...] = ()  # lowest and highest in Hz, where there are enough of them for a band
    # Whether the stator's coarsest discretisation will do: for a search, whose best points are computed again
    coarse: bool = False

    @property
    def kind(self) -> str:
        """What moves: "given", "driven", or "free", the wave alone."""
        if "wave" in self.table:
            return "given"
        return "driven" if self.table.get("transducer") else "free"

    @property
    def has_slider(self) -> bool:
        """Whether a velocity is asked for."""
        return "slider" in self.table or any(key.startswith("slider.") for key in self.keys)

    @property
    def outcomes(self) -> tuple[str, ...]:
        """The columns that a point is answered with."""
        if self.kind == "free":
            return (
                "phase_velocity_m_per_s",
                "surface_ratio",
                "attenuation_per_m",
                "relative_error",
                "status",
            )
        names = ["normal_amplitude_m", "tangential_amplitude_m"]
        if self.kind == "driven":
            names += ["frequency_Hz", "conductance_S", "susceptance_S", "power_W"]
        if self.has_slider:
            burst = "burst" in self.table.get("wave" if self.kind == "given" else "drive", {})
            burst = burst or any(key.endswith(".burst") for key in self.keys)
            names += ["velocity_m_per_s", *(["velocity_at_burst_end_m_per_s"] if burst else []), "regime"]
            names += ["threshold_factor", "release_factor"] if "limits" in self.also else []
            names += ["thrust_N"] if "thrust" in self.also else []
            names += ["contact_pressure_Pa", "stick_margin"] if "pressure" in self.also else []
            names += ["step_m"] if "step" in self.also else []
            names += ["contact_efficiency"] if "efficiency" in self.also else []
            names += ["motor_efficiency"] if "efficiency" in self.also and self.kind == "driven" else []
        return (*names, "relative_error", "status")

    def source(self, values: tuple) -> str:
        """Return the name of the stator's answer that a point's values need."""
        return json.dumps({key: values[self.keys.index(key)] for key in self.source_keys})


@dataclass(frozen=True, kw_only=True)
class Design:
    """The points of a sweep."""

    question: Question
    axes: tuple[Axis, ...] = field(repr=False)

    def __len__(self):
        return math.prod(len(each) for each in self.axes)

    def values(self, points) -> list[tuple]:
        """Return the values of the keys at points, given by an array of their numbers."""
        if not self.axes:
            return [()] * len(points)
        columns = []
        at = np.unravel_index(points, tuple(len(each) for each in self.axes))
        for each, rows in zip(self.axes, at, strict=True):
            places = rows.tolist()
            columns += [[column[place] for place in places] for column in each.columns]
        return list(zip(*columns, strict=True))

    @property
    def identity(self) -> dict[str, str]:
        """What makes two sweeps the same one: digests of scene, axes, tolerance and what is also asked."""
        parts = {
            "scene": self.question.table,
            "tolerance": self.question.tolerance,
            "also": self.question.also,
        }
        parts |= {f"axis {'+'.join(each.keys)}": each.columns for each in self.axes}
        parts |= {"order of axes": self.question.keys}
        return {name: _digest(part) for name, part in parts.items()}

    def distinct(self, keys) -> "list[tuple]":
        """Return the distinct values of some keys over the whole design, at most ``PLACES + 1`` of them."""
        return list(islice(_distinct(self.axes, keys), PLACES + 1))


def designed(table: dict, over, *, samples=None, tolerance, also=()) -> Design:
    """Return the design of a sweep of a scene's TOML document; the other arguments are those of `studies.sweep`.

    Raises
    ------
    SceneError
        For what is wrong whatever the point.
    """
    for word in also:
        if word not in ALSO:
            raise SceneError("--also", f"must be of {', '.join(ALSO)}, got {word!r}")
    axes, sides = [], {}
    for part in over if isinstance(over, list) else [over or {}]:
        if not isinstance(part, dict):
            axes.append(point_axis(part))
            continue
        for key, values in part.items():
            found = axis(key, values)
            if isinstance(found, Axis):
                axes.append(found)
            else:
                sides[key] = found
    if sides:
        axes.append(latin_axis(sides, *(samples if isinstance(samples, tuple) else (samples, 0))))
    elif samples is not None:
        raise SceneError("--samples", "is of a latin range, START:STOP:latin, and there is none")
    keys = [key for each in axes for key in each.keys]
    for key in keys:
        if keys.count(key) > 1:
            raise SceneError(f"--over {key}", "is given twice")
    level = level_key(table)
    if level is not None and level not in keys:
        block, name = level.split(".")
        axes.append(axis(level, list(rule_at(level).read(level, table.get(block, {}).get(name)))))
    design = Design(question=_question(table, tuple(axes), tolerance, tuple(also)), axes=tuple(axes))
    if len(design) > MOST:
        raise SceneError("--over", f"must make at most {MOST} points, got {len(design)}")
    return design


def _question(table, axes, tolerance, also) -> Question:
    keys = tuple(key for each in axes for key in each.keys)
    question = Question(table=table, keys=keys, tolerance=tolerance, also=also)
    if question.kind != "driven":
        return question
    own = tuple(
        key
        for key in keys
        if key.startswith(("stator.", "transducer.", "drive."))
        and key not in ("drive.voltage", "drive.power", "drive.burst")
    )
    design = Design(question=question, axes=axes)
    moved = tuple(key for key in PLACE_KEYS if key in keys)
    places = _places(table, moved, design.distinct(moved))
    columns = dict(zip(keys, (column for each in axes for column in each.columns), strict=True))
    frequencies = set(columns.get("drive.frequency", ()))
    if not places:
        own, places = own + moved, places if not moved else ()
    usable = sorted(each for each in frequencies if isinstance(each, float) and each > 0)
    band = (usable[0], usable[-1]) if len(usable) >= FEWEST else ()
    return replace(question, source_keys=own, places=places, frequencies=band)


def _places(table, moved, rows) -> tuple[tuple[float, float], ...]:
    """Return the places of all contacts; none where they are too many, or where there is no slider."""
    slider = table.get("slider", {})
    if len(rows) > PLACES:
        return ()
    found = {}
    for row in rows:
        here = slider | {key.split(".")[1]: value for key, value in zip(moved, row, strict=True)}
        for place in contact_places(here):
            found[place] = None
    return tuple(found)


def contact_places(slider: dict) -> tuple[tuple[float, float], ...]:
    """Return the places (x, y) of a slider and its contacts from its table, m; none if it breaks a rule."""
    try:
        position = rule_at("slider.position").read("slider.position", slider.get("position"))
        contacts = rule_at("slider.contacts").read("slider.contacts", slider.get("contacts", 1))
    except SceneError:
        return ()
    (x, y), offsets = as_pair(position), contacts if isinstance(contacts, tuple) else ()
    return tuple(dict.fromkeys((x + along, y + across) for along, across in map(as_pair, (0.0, *offsets))))


def _distinct(axes, keys):
    parts = []
    for each in axes:
        chosen = [k for k, key in enumerate(each.keys) if key in keys]
        if chosen:
            parts.append(list(dict.fromkeys(zip(*(each.columns[k] for k in chosen), strict=True))))
    order = [key for each in axes for key in each.keys if key in keys]
    for row in product(*parts):
        flat = [value for part in row for value in part]
        yield tuple(flat[order.index(key)] for key in keys)


def _digest(part) -> str:
    return hashlib.sha256(json.dumps(part, sort_keys=True, default=str).encode()).hexdigest()[:16]
