"""Path of a slider in the plane under bursts of its transducers, with its yaw.

Method: the slider of a scene that moves in the plane (``twente-planar`` by default) at its largest voltage. Each source
drives it alone for `DURATION`, one after the other; then all together; then it coasts to rest. The slow motion follows
the mean forces of a cycle at each pose (`studies.solve.plane_path`), on the waves of the place. Expected: each burst
adds a motion along its own wave; with sources of different frequencies the velocity under all of them is within a
quarter of the sum of those under each (the decoupling of the axes); friction stops the slider within v^2/(2 mu g).
Run time: about a minute, plus the time of a stator for each source.
"""

import logging
import math

import numpy as np

from studies.model.plane import rotated
from studies.record.plots import COLOURS, curve, family, finished
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve.plane_answer import PlaneMotor, waves_at
from studies.solve.plane_path import LONGEST_COAST, RATE, STOPPED, V_X, V_Y, YAW, Body, Leg, X, Y, at_rest
from studies.solve.plane_sources import driven_by, waves_of_sources
from studies.study_list import Answered, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

DURATION = 0.02  # s of each burst
QUICK = {"duration": 0.004}
SMALLEST = 1e-12  # m: length of a path that is none
COUPLED = 0.25  # relative change of a velocity by the other source, below which the axes count as decoupled


@study("twente-planar")
def run(scene: Scene, *, duration: float = DURATION, tolerance: float = 1e-2) -> Answered:
    """Return the path and the yaw against time.

    Parameters
    ----------
    duration : float
        Of each burst, s.
    tolerance : float
        Relative, of the motion in a burst; of the slider velocity where the stator is solved.
    """
    driven = driven_contact(scene, tolerance=tolerance, planar=True)
    sources, level = waves_of_sources(driven, tolerance), max(driven.scene.levels)
    body = Body(slider=driven.slider, tolerance=tolerance)
    bursts = [(name, {name: level}) for name in sources]
    if len(bursts) > 1:
        bursts.append((" and ".join(sources), dict.fromkeys(sources, level)))
    legs: list[Leg] = []
    for name, levels in bursts:
        LOGGER.info(f"burst of {name}")
        start, begin = (legs[-1].end, float(legs[-1].time[-1])) if legs else (at_rest(), 0.0)
        legs.append(body.path(driven_by(sources, levels), start, begin, duration, name, coasts=False))
    LOGGER.info("coast")
    still = driven_by(sources, dict.fromkeys(sources, level)).at_rest()
    last = legs[-1]
    legs.append(body.path(still, last.end, float(last.time[-1]), LONGEST_COAST, "coast", coasts=True))
    return _panels(driven, legs), _findings(driven, sources, body, level, legs, tolerance), _answer(legs)


def _panels(driven, legs: list[Leg]) -> list[Panel]:
    title = f"{driven.scene.title}: {driven.scene.named(max(driven.scene.levels))}"
    names = [each.name for each in legs]
    columns = {"x_m": X, "y_m": Y, "yaw_rad": YAW, "yaw_rate_rad_per_s": RATE}
    columns |= {quantity.velocity_m_per_s.column: V_X, quantity.lateral_velocity_m_per_s.column: V_Y}
    data: dict = {
        key: dict(zip(names, (each.state[:, at] for each in legs), strict=True)) for key, at in columns.items()
    }
    data |= {"time_s": dict(zip(names, (each.time for each in legs), strict=True))}
    data["contacts_m"] = np.column_stack([np.atleast_1d(driven.slider.x), np.atleast_1d(driven.slider.y)])
    return [Panel(name=name, title=title, data=data) for name in ("path", "yaw")]


def _findings(driven, sources, body: Body, level: float, legs: list[Leg], tolerance: float):
    """Judge where friction stops the slider, how far the axes are coupled, and the error of the path."""
    if len(sources) > 1:
        motor = PlaneMotor.of(driven, level, tolerance)
        velocities = [
            motor.state(waves_at(driven_by(sources, levels), motor.slider)).velocity
            for levels in (*({name: level} for name in sources), dict.fromkeys(sources, level))
        ]
        apart, together = sum(velocities[:-1]), velocities[-1]
        yield judged(
            "Each source moves the slider along its own wave, whatever the others do.",
            "steady velocity under all sources less the sum of those under each, over that sum",
            float(np.hypot(*(together - apart)) / np.hypot(*apart)), low=-1.0, high=COUPLED,
            remark="; ".join(f"{name}: ({si(v[0], 'm/s', 4)}, {si(v[1], 'm/s', 4)})"
                             for name, v in zip((*sources, "all"), velocities, strict=True)),
        )  # fmt: skip
    coast, last = legs[-1], legs[-2].end
    speed, way = float(np.hypot(*last[[V_X, V_Y]])), float(np.hypot(*(coast.end[[X, Y]] - last[[X, Y]])))
    braking = body.slider.friction_coefficient * body.slider.preload / body.slider.mass
    moves = speed > STOPPED and braking > 0.0
    yield judged(
        "Friction stops a slider that does not turn within v^2/(2 a), a = mu times preload over mass.",
        "way of the coast over it", way / (speed**2 / (2.0 * braking)) if moves else 0.0, low=0.5, high=2.0,
        holds=True if moves else None, remark="turning adds to the way, since it takes a part of the friction",
    )  # fmt: skip
    yield judged(
        "The error of the path is small.", "largest error of a leg's end over the length of the path",
        max(each.error for each in legs) / max(sum(_length(each) for each in legs), SMALLEST), low=-1.0, high=0.05,
    )  # fmt: skip


def _length(leg: Leg) -> float:
    return float(np.hypot(*np.diff(leg.state[:, [X, Y]], axis=0).T).sum())


def _answer(legs: list[Leg]) -> list[tuple[str, str]]:
    lines = []
    for each in legs:
        x, y, yaw, v_x, v_y, rate = each.end
        where = f"({si(x, 'm', 4)}, {si(y, 'm', 4)}), yaw {math.degrees(yaw):.4g} deg"
        how = f"({si(v_x, 'm/s', 4)}, {si(v_y, 'm/s', 4)}), {rate:.4g} rad/s"
        lines.append(
            (each.name, f"{si(float(np.ptp(each.time)), 's', 3)}: to {where} at {how}, +-{si(each.error, 'm', 1)}")
        )
    return lines


@of_record
def figure(record: Panel, ax):
    """Draw the path of the centre with the contacts at its ends, or the yaw against time."""
    data = record.data
    if record.name == "yaw":
        time, up = quantity.time_s, quantity.yaw_rad
        for name, values, colour in family(data["yaw_rad"]):
            curve(ax, np.asarray(data["time_s"][name]) * time.scale, np.asarray(values) * up.scale, "-", colour, name)
        return finished(ax, time.axis, up.axis, record.title)
    along, across = quantity.x_m, quantity.y_m
    for name, x, colour in family(data["x_m"]):
        curve(ax, np.asarray(x) * along.scale, np.asarray(data["y_m"][name]) * across.scale, "-", colour, name)
        a, b = rotated(data["contacts_m"][:, 0], data["contacts_m"][:, 1], float(data["yaw_rad"][name][-1]))
        balls = (a + x[-1]) * along.scale, (b + data["y_m"][name][-1]) * across.scale
        ax.fill(*balls, facecolor="none", edgecolor=COLOURS[colour], linewidth=0.8, alpha=0.6)
        ax.plot(*balls, "o", color=COLOURS[colour], markersize=3)
    ax.set_aspect("equal", adjustable="datalim")
    return finished(ax, along.axis, across.axis, record.title)
