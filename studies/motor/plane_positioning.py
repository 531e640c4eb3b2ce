"""Steps of a slider in the plane along both axes, and what a step along one axis does along the other.

Each source alone, then all together, drive the slider from rest for bursts of several durations; it then slides to
rest. The decoupling is the part of a step that goes across the source's own direction, and its turn. A move to a target
is planned by each source's own steps, one after the other, and its miss is what the coupling leaves.
"""

import logging
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from contact import plane
from studies.model.wave_to_contact import Contact
from studies.record.plots import COLOURS, curve, family, finished, logarithmic
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.solve.plane_sources import driven_by, waves_of_sources
from studies.study_list import Answered, Panel, judged

LOGGER = logging.getLogger(__name__)

DURATIONS = (5e-4, 1e-3, 2e-3, 4e-3)  # s
SAMPLES = 20  # instants of a burst, and of the slide after it
COUPLED = 0.1  # part of a step that goes across
NONE_ACROSS = 1e-6  # part of a step below which nothing goes across
FAR_BELOW = 1e-3  # of the error of a miss: a component that is smaller is printed as 0
STEPS, MOVE = "steps_in_plane", "move_in_plane"  # panels


@dataclass(frozen=True, kw_only=True)
class Shifted:
    """A surface as seen from another place."""

    surface: Any  # what has ``at(x, y)``
    place: tuple[float, float]  # m

    def at(self, x: np.ndarray, y: np.ndarray) -> plane.SurfaceWaves:
        """Return the waves at places in m from the new one."""
        return self.surface.at(np.asarray(x) + self.place[0], np.asarray(y) + self.place[1])


def step_of(driven: Contact, surface: Any, duration: float, tolerance: float, pose=(0.0, 0.0, 0.0)):
    """Return the motion of a slider at rest at a pose, through a burst and to its stop."""
    slider = plane.turned(driven.slider, float(pose[2]))
    there = Shifted(surface=surface, place=(float(pose[0]), float(pose[1])))
    return plane.burst(
        slider,
        plane.from_upward_zero(slider, there),
        duration=duration,
        after=math.inf,
        tolerance=tolerance,
        samples=SAMPLES,
        method="averaged",
    )


def plane_positioning(driven: Contact, distance: float, tolerance: float) -> Answered:
    """Return steps by bursts of each source and of all, and a move by a distance (m) along each source's axis."""
    sources, level = waves_of_sources(driven, tolerance), max(driven.scene.levels)
    levels = {name: {name: level} for name in sources}
    if len(sources) > 1:
        levels[" and ".join(sources)] = dict.fromkeys(sources, level)
    steps = {}
    for name, driving in levels.items():
        LOGGER.info(f"steps by {name}")
        surface = driven_by(sources, driving)
        steps[name] = [step_of(driven, surface, each, tolerance) for each in DURATIONS]
    poses = {name: np.array([each.pose[-1] for each in motions]) for name, motions in steps.items()}
    errors = {name: np.array([each.pose_error for each in motions]) for name, motions in steps.items()}
    LOGGER.info("move to the target")
    legs, target = _move(driven, sources, level, poses, distance, tolerance)
    title = f"{driven.scene.title}: {driven.scene.named(level)}"
    data = {
        "duration_s": np.array(DURATIONS), "pose": poses, "error": errors,
        "own_m": {name: np.hypot(*poses[name][:, :2].T) for name in poses},
        "across_m": {name: _across(poses[name]) for name in sources},
    }  # fmt: skip
    move = {
        quantity.x_m.column: {name: np.append(at[0], at[0] + leg.pose[:, 0]) for name, (at, _, leg) in legs.items()},
        "y_m": {name: np.append(at[1], at[1] + leg.pose[:, 1]) for name, (at, _, leg) in legs.items()},
        "target_m": target,
    }
    panels = [Panel(name=STEPS, title=title, data=data), Panel(name=MOVE, title=title, data=move)]
    return panels, _findings(sources, poses, errors), [*_words(levels, poses, errors), *_move_words(legs, target)]


def _across(pose: np.ndarray) -> np.ndarray:
    """Return the smaller of both components of each step, that across a source along x or y, m."""
    return np.abs(pose[:, :2]).min(axis=1)


def _move(driven, sources, level, poses, distance: float, tolerance: float):
    """Return place, duration and motion of one burst of each source, and the target (x, y) in m."""
    place, target, legs = np.zeros(3), np.zeros(2), {}
    for name in sources:
        own = np.hypot(*poses[name][:, :2].T)
        axis = int(np.argmax(np.abs(poses[name][-1, :2])))
        target[axis] = math.copysign(distance, poses[name][-1, axis])
        duration = float(np.exp(np.interp(math.log(distance), np.log(own), np.log(DURATIONS))))
        surface = driven_by(sources, {name: level})
        for _ in range(2):  # a step grows with the square of its duration
            leg = step_of(driven, surface, duration, tolerance, place)
            duration *= math.sqrt(distance / abs(float(leg.pose[-1, axis])))
        leg = step_of(driven, surface, duration, tolerance, place)
        legs[name] = place.copy(), duration, leg
        place = place + leg.pose[-1]
    return legs, target


def _findings(sources, poses, errors):
    """Judge the part of each source's steps that goes across, and whether steps along both axes add up."""
    for name in sources:
        across, own = _across(poses[name]), np.hypot(*poses[name][:, :2].T)
        error = float(np.hypot(*errors[name][-1, :2]) / own[-1])
        yield judged(
            f"A step by {name} goes along its own direction.", "part of the step across it, at most",
            float((across / own).max()), low=-1.0, high=COUPLED, remark=f"+-{error:.1g} of the longest step",
        )  # fmt: skip
    if len(sources) > 1:
        together = list(poses)[-1]
        added = sum(poses[name][-1, :2] for name in sources)
        miss = float(np.hypot(*(poses[together][-1, :2] - added)) / np.hypot(*added))
        error = sum(float(np.hypot(*errors[name][-1, :2])) for name in poses) / float(np.hypot(*added))
        yield judged(
            "Driven together, the sources make the sum of their steps.", "miss over the sum, longest burst", miss,
            holds=None, expected="0 if the axes were decoupled", remark=f"+-{error:.1g}",
        )  # fmt: skip


def _words(levels, poses, errors):
    for name in levels:
        lines = []
        for duration, (x, y, yaw), error in zip(DURATIONS, poses[name], errors[name], strict=True):
            at = f"({si(float(x), 'm', 4)}, {si(float(y), 'm', 4)}), {math.degrees(yaw):.3g} deg"
            lines.append(f"{si(duration, 's', 3)}: {at} +-{si(float(np.hypot(*error[:2])), 'm', 1)}")
        yield from zip((name, *[""] * (len(lines) - 1)), lines, strict=True)


def _move_words(legs, target):
    place = np.zeros(3)
    for name, (at, duration, leg) in legs.items():
        place = at + leg.pose[-1]
        yield f"move by {name}", f"{si(duration, 's', 4)}, rests after {si(float(leg.stopped), 's', 3)}"
    miss, error = place[:2] - target, sum(np.hypot(*leg.pose_error[:2]) for _, _, leg in legs.values())
    missed = [0.0 if abs(each) < FAR_BELOW * error else float(each) for each in miss]
    at = f"({si(missed[0], 'm', 3)}, {si(missed[1], 'm', 3)})"
    wanted = f"({si(float(target[0]), 'm', 4)}, {si(float(target[1]), 'm', 4)})"
    yield "target", f"{wanted}: missed by {at} +-{si(float(error), 'm', 1)}, turned by {math.degrees(place[2]):.3g} deg"


def draw(record: Panel, ax):
    """Draw the steps along and across against the burst's duration, or the move to the target."""
    data = record.data
    if record.name == MOVE:
        up = quantity.travelled_m
        for name, x, colour in family(data[quantity.x_m.column]):
            curve(ax, np.asarray(x) * up.scale, np.asarray(data["y_m"][name]) * up.scale, ".-", colour, name)
        ax.plot(*(np.asarray(data["target_m"]) * up.scale), "+", color=COLOURS["line"], markersize=10, label="target")
        ax.set_aspect("equal", adjustable="datalim")
        return finished(ax, f"x: {up.axis}", f"y: {up.axis}", record.title)
    time, up = quantity.time_s, quantity.travelled_m
    at = np.asarray(data["duration_s"]) * time.scale
    for name, own, colour in family(data["own_m"]):
        curve(ax, at, np.asarray(own) * up.scale, "o-", colour, name)
        if name in data["across_m"]:
            across = np.asarray(data["across_m"][name])
            if across.max() > NONE_ACROSS * np.max(own):
                curve(ax, at, across * up.scale, "x--", colour, f"{name}, across")
    logarithmic(ax.xaxis)
    logarithmic(ax.yaxis)
    return finished(ax, f"duration of the burst ({time.shown})", f"step ({up.shown})", record.title, columns=3)
