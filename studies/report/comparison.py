"""Runs side by side: what differs in their scenes, their answers with errors, and one picture of all velocities."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import contact
from studies.record import Record
from studies.record.plots import COLOURS, PALETTE, finished, saved
from studies.record.prefixes import scaled_unit
from studies.record.quantities import Quantity, quantities, quantity
from studies.record.text import labelled, table
from studies.record.values import as_array
from studies.refusal import SceneError, refuse_ending, refuse_if, writing
from studies.scene.keys import rule_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROUNDING = 1e-12  # relative; numbers of one scene on two machines differ by less
MISSING = "-"
PICTURES = (".png", ".svg", ".pdf")
MARKS = "os^Dv"
ABSENT = object()


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Runs beside the first of them.

    Attributes
    ----------
    names : tuple of str
        One per run: the last part of its directory, or a number.
    records : tuple of Record
    """

    names: tuple[str, ...]
    records: tuple[Record, ...] = field(repr=False)

    @property
    def level(self) -> str:
        """Key of the levels of all runs; empty without a slider."""
        return self.records[0].level if self.records[0].points else ""

    @property
    def scenes(self) -> list[tuple[str, list]]:
        """Keys of the scenes that differ, each with its value in every run; None where a run has none."""
        return _differences([_leaves(record.scene.to_table()) for record in self.records])

    @property
    def numbers(self) -> list[tuple[str, list]]:
        """Numbers of the answers, apart from those of the points, that differ; None where a run has none."""
        blocks = ("wave", "electrical", "summary", "heat", "error")
        known = quantities()
        answers = []
        for record in self.records:
            whole = record.to_dict()
            leaves = {key: value for block in blocks for key, value in _leaves(whole.get(block, {}), f"{block}.")}
            answers.append([(key, value) for key, value in leaves.items() if key in known])
        return _differences(answers)

    @property
    def motions(self) -> tuple[Quantity, ...]:
        """Velocity along x, of the plane also across and the rotation; of sliders on axles the rotation alone."""
        blocks = [record.scene.slider for record in self.records]
        if all(each.axis is not None for each in blocks):
            return (quantity.rotation_rpm,)
        across = (quantity.lateral_velocity_m_per_s,) if all(each.planar for each in blocks) else ()
        turns = (quantity.rotation_rpm,) if all(each.planar and each.turns for each in blocks) else ()
        return (quantity.velocity_m_per_s, *across, *turns)

    def points(self, motion: Quantity | None = None) -> Iterator[tuple[float, list[tuple[float, float] | None]]]:
        """Yield each level with the first motion, or another one, and its error, of every run.

        None where a run has no answer there.
        """
        motion, answers = motion or self.motions[0], []
        for record in self.records:
            columns = record.column(record.level), _column(record, motion), _errors(record, motion)
            rows = zip(*(column.tolist() for column in columns), strict=True)
            answers.append({level: (v, error) for level, v, error in rows if math.isfinite(v)})
        for level in sorted({level for answer in answers for level in answer}):
            yield level, [answer.get(level) for answer in answers]

    def to_dict(self) -> dict:
        """Return what `sawmotor compare --json` prints: plain numbers and text."""
        whole: dict[str, Any] = {
            "runs": list(self.names),
            "scene": {key: values for key, values in self.scenes},
            "answers": {key: values for key, values in self.numbers},
        }
        if self.level:
            first, *others = self.motions
            whole["points"] = self._table(first)
            whole |= {each.column: self._table(each) for each in others}
        return whole

    def _table(self, motion: Quantity) -> list[dict]:
        name = "velocity" if motion is quantity.velocity_m_per_s else motion.column
        return [
            {
                self.level: level,
                name: [None if each is None else each[0] for each in found],
                "error": [None if each is None else each[1] for each in found],
                "change": [_change(found[0], each)[0] for each in found[1:]],
            }
            for level, found in self.points(motion)
        ]

    def __str__(self) -> str:
        """Return the tables as text: scenes, answers, then the velocities and their changes from the first run."""
        heads, lines = ["", *self.names], []
        scenes = [_scene_row(key, values) for key, values in self.scenes]
        lines += ["what differs in the scenes", *table([heads, *scenes])] if scenes else ["the scenes are equal"]
        shown = [(quantity(key), values) for key, values in self.numbers if quantity(key).head]
        answers = [[known.heading, *(_number(known, each) for each in values)] for known, values in shown]
        if answers:
            more = len(self.numbers) - len(answers)
            rest = f" ({more} more numbers: --json)" if more else ""
            lines += ["", f"what differs in the answers{rest}", *table([heads, *answers])]
        if self.level:
            for motion in self.motions:
                lines += ["", *self._velocities(motion)]
        errors = [f"{name} {_percent(record.error.get('relative'))}" for name, record in self._named()]
        seconds = [f"{name} {record.seconds['total']:.2f}" for name, record in self._named()]
        entries = [("relative errors", ", ".join(errors)), ("seconds", ", ".join(seconds))]
        entries += [(name, record.shortfall) for name, record in self._named() if record.shortfall]
        return "\n".join([*lines, "", *labelled(entries)])

    def _named(self):
        return zip(self.names, self.records, strict=True)

    def _velocities(self, speed: Quantity) -> list[str]:
        """Return the table of a motion: the first run's, then every other one's with its change."""
        level, named = quantity(self.level), "velocities"
        if speed is not quantity.velocity_m_per_s:
            named = "rotations" if speed is quantity.rotation_rpm else "velocities across"
        heads = [level.heading, *(f"{name} ({speed.shown})" for name in self.names)]
        heads += [f"change of {name}" for name in self.names[1:]]
        rows, beyond = [heads], False
        for here, found in self.points(speed):
            row = [level.text(here), *(MISSING if each is None else _with_error(speed, *each) for each in found)]
            for each in found[1:]:
                change, sure = _change(found[0], each)
                row.append(MISSING if change is None else f"{_percent(change, '+')}{'*' if sure else ' '}")
                beyond |= sure
            rows.append(row)
        alone = not any(found[0] and any(found[1:]) for _, found in self.points(speed))
        note = f"no {level.head} is that of another run" if alone else "all within the stated errors"
        note = "* by more than both stated errors" if beyond else note
        return [f"{named} and changes from {self.names[0]} ({note})", *table(rows)]

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the velocities of all runs over their level, with their stated errors.

        Raises
        ------
        SceneError
            If the runs have no slider.
        """
        refuse_if(not self.level, "compare", "draws velocities, and these runs have no slider")
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots(layout="constrained")[1]
        across, up = quantity(self.level), self.motions[0]
        for k, (name, record) in enumerate(self._named()):
            x, v = record.column(record.level), _column(record, up)
            colour = COLOURS[PALETTE[k % len(PALETTE)]]
            ax.errorbar(
                x * across.scale, v * up.scale, _errors(record, up) * up.scale, fmt=f"{MARKS[k % len(MARKS)]}-",
                color=colour, markersize=3.5, linewidth=1, capsize=2, label=name,
            )  # fmt: skip
        named = "Rotation" if up is quantity.rotation_rpm else "Velocity"
        return finished(ax, across.axis, up.axis, f"{named} of the slider in each run, with its stated error")


def compare(*runs: Record | str | Path) -> Comparison:
    """Return runs side by side.

    Parameters
    ----------
    *runs : Record or path
        At least two: records, or directories that `sawmotor run` left.

    Raises
    ------
    SceneError
        If there are fewer than two, or their levels are of different kinds (voltages and amplitudes).
    RunError
        If a directory holds no run.

    Examples
    --------
    >>> from studies import Scene, run
    >>> scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": "10 nm"})
    >>> pair = compare(run(scene), run(scene.replace(slider={"friction_coefficient": 0.16})))
    >>> pair.scenes
    [('slider.friction_coefficient', [0.08, 0.16])]
    """
    refuse_if(len(runs) < 2, "compare", f"needs at least two runs, got {len(runs)}")
    records = tuple(each if isinstance(each, Record) else Record.load(each) for each in runs)
    names = _names(runs)
    levels = [record.level if record.points else "" for record in records]
    kinds = [f"over {quantity(each).head}" if each else "without a slider" for each in levels]
    found = ", ".join(f"{name} {kind}" for name, kind in zip(names, kinds, strict=True))
    refuse_if(len(set(levels)) > 1, "compare", f"needs runs over the same level, got {found}")
    return Comparison(names=names, records=records)


def _names(runs: Sequence) -> tuple[str, ...]:
    """Return a short name for each run, the directory's where that is unique."""
    names = [str(k) if isinstance(each, Record) else Path(each).resolve().name for k, each in enumerate(runs, start=1)]
    return tuple(
        name if names.count(name) == 1 else str(run if not isinstance(run, Record) else name)
        for name, run in zip(names, runs, strict=True)
    )


def _leaves(value, path: str = "") -> list[tuple[str, Any]]:
    """Return the numbers, words and lists of them in nested tables, each with its dotted key."""
    if isinstance(value, dict):
        start = path if path.endswith(".") or not path else f"{path}."
        return [leaf for key, each in value.items() for leaf in _leaves(each, f"{start}{key}")]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [leaf for k, each in enumerate(value) for leaf in _leaves(each, f"{path}.{k}")]
    return [(path, value)]


def _differences(answers: Sequence[Sequence[tuple[str, Any]]]) -> list[tuple[str, list]]:
    """Return the keys whose values are not equal to rounding, each with all values, None where there is none."""
    tables = [dict(answer) for answer in answers]
    keys = dict.fromkeys(key for each in tables for key in each)
    rows = [(key, [each.get(key, ABSENT) for each in tables]) for key in keys]
    return [
        (key, [None if each is ABSENT else each for each in values])
        for key, values in rows
        if any(not _same(values[0], each) for each in values[1:])
    ]


def _same(one, other) -> bool:
    """Return whether two values are equal to rounding."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, (int, float)) and isinstance(other, (int, float)) and not isinstance(one, bool):
        return math.isclose(one, other, rel_tol=ROUNDING)
    return bool(one == other)


def _column(record: Record, motion: Quantity) -> np.ndarray:
    """Return a motion at each point, NaN where a point has no answer."""
    return as_array(point.get(motion.column) for point in record.points)


def _errors(record: Record, motion: Quantity) -> np.ndarray:
    """Return the stated error of each velocity in m/s, or of each rotation in turns per minute.

    It is relative to the speed: that of the slider, or of the farthest contact from an axle.
    """
    surface = 2.0 * math.pi * record.scene.frequency * np.abs(record.tangential_amplitude)
    slider, turns, speed = record.scene.slider, 1.0, record.velocity
    if slider.planar:
        from studies.solve.plane_motor import PER_MINUTE

        about = slider.axis or (0.0, 0.0)
        arm = max(math.dist(each, about) for each in slider.offsets) or 1.0
        across = np.nan_to_num(_column(record, quantity.lateral_velocity_m_per_s))
        turns = PER_MINUTE / arm  # per minute, of 1 m/s of the farthest contact
        rotation = np.nan_to_num(_column(record, quantity.rotation_rpm))
        speed = np.abs(rotation / turns) if slider.axis is not None else np.hypot(speed, across)
    scales = np.array(list(map(contact.speed_scale, speed.tolist(), surface.tolist())))
    return record.relative_error * scales * (turns if motion is quantity.rotation_rpm else 1.0)


def _change(one: tuple[float, float] | None, other: tuple[float, float] | None) -> tuple[float | None, bool]:
    """Return the relative change from one velocity to the other, and whether it is beyond both errors.

    The change is None where one has no answer, or the first is at rest and the other is not.
    """
    if one is None or other is None:
        return None, False
    beyond = abs(other[0] - one[0]) > one[1] + other[1]
    if one[0] == 0.0:
        return (0.0 if other[0] == 0.0 else None), beyond
    return other[0] / one[0] - 1.0, beyond


def _with_error(motion: Quantity, value: float, error: float) -> str:
    """Return a motion with its stated error as text; without one that is zero, of a slider at rest."""
    return motion.text(value) + (f" ± {error * motion.scale:.2g}" if error else "")


def _percent(value: float | None, sign: str = "") -> str:
    return MISSING if value is None else f"{100.0 * value:{sign}.3g} %"


def _scene_row(key: str, values: list) -> list[str]:
    """Return a key of the scenes with its unit, and its values in this unit as text."""
    try:
        unit = rule_at(key).unit
    except SceneError:
        unit = ""  # a number of a table that a scene holds, such as a material
    largest = max((abs(each) for value in values for each in _numbers(value)), default=None)
    factor, shown = (1.0, "") if largest is None else scaled_unit(largest, unit)
    return [f"{key} ({shown})" if shown else key, *(_shown(value, factor, shown) for value in values)]


def _numbers(value) -> Iterator[float]:
    """Yield the numbers in a value of a scene."""
    if isinstance(value, list):
        for each in value:
            yield from _numbers(each)
    elif isinstance(value, float):
        yield value


def _shown(value, factor: float, unit: str) -> str:
    """Return a value of a scene as text, a long list by its ends, a number without the unit of the others as such."""
    if value is None:
        return MISSING
    if isinstance(value, list):
        if len(value) > 3:
            return f"{_shown(value[0], factor, unit)} ... {_shown(value[-1], factor, unit)} ({len(value)})"
        shown = [_shown(each, factor, unit) for each in value]
        return ", ".join(
            f"[{text}]" if isinstance(each, list) else text for each, text in zip(value, shown, strict=True)
        )
    if isinstance(value, float):
        return f"{value * factor:.6g}"
    return f"{value} (number)" if unit and type(value) is int else str(value)


def _number(known: Quantity, value) -> str:
    """Return a number of the answers as text."""
    if value is None:
        return MISSING
    return known.text(complex(*value) if isinstance(value, list) else value)


def drawn(compared: Comparison, file: str | Path) -> None:
    """Draw the velocities of all runs into a .png, .svg or .pdf file.

    Raises
    ------
    SceneError
        If the runs have no slider, or the file has another ending or cannot be written.
    """
    refuse_ending(file, PICTURES, "--picture")
    with writing(file, "--picture"):
        saved(file, compared.plot)
