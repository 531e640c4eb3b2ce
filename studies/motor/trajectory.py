"""Path of a slider in the plane under bursts of its transducers, with its yaw.

Method: the slider of a scene that moves in the plane (``twente-planar`` by default) at its largest voltage. Each source
drives it alone for `DURATION`, one after the other; then all together; then it coasts to rest. The slow motion follows
the mean forces of a cycle at each pose (`contact.plane.burst`), on the waves of the place. Expected: each burst
adds a motion along its own wave; with sources of different frequencies the velocity under all of them is within a
quarter of the sum of those under each (the decoupling of the axes); friction stops the slider within v^2/(2 mu g).
A slider on an axle turns: its yaw takes the part of the path, and its sources the whole of one motor.
Run time: about 10 s, plus the time of a stator for each source.
"""

import logging
import math

import numpy as np

from contact import plane
from studies.record.plane_pictures import draw_path
from studies.record.plots import curve, family, finished
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.scene.plane_keys import AXLE
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor, friction_torque, waves_at
from studies.solve.plane_path import Leg, legs_of
from studies.solve.plane_sources import driven_by, waves_of_sources
from studies.study_list import Answered, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

DURATION = 0.02  # s of each burst
QUICK = {"duration": 0.004}
SAMPLES = 60  # instants of each burst, and of the coast
ROUNDING = 1e-11  # of the largest speed or way of a leg: a component below it is rounding
SLOW = 1e-3  # m/s: speed from which on the way of the coast is compared
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
    bursts = [(name, {name: level}) for name in sources]
    if len(bursts) > 1:
        bursts.append((" and ".join(sources), dict.fromkeys(sources, level)))
    legs: list[Leg] = []
    start, begin = None, 0.0
    for number, (name, levels) in enumerate(bursts, start=1):
        LOGGER.info(f"burst of {name}")
        surface = plane.from_upward_zero(driven.slider, driven_by(sources, levels))
        motion = plane.burst(
            driven.slider, surface, duration=duration, samples=SAMPLES, tolerance=tolerance,
            after=math.inf if number == len(bursts) else 0.0, start=start, method="averaged",
        )  # fmt: skip
        legs += legs_of(name, motion, start, begin)
        start, begin = legs[-1].end, float(legs[-1].time[-1])
    if driven.slider.freedom == AXLE:
        return _panels(driven, legs)[1:], _findings_of_turn(driven, legs), _answer_of_turn(legs)
    return _panels(driven, legs), _findings(driven, sources, level, legs, tolerance), _answer(legs, driven)


def _panels(driven, legs: list[Leg]) -> list[Panel]:
    title = f"{driven.scene.title}: {driven.scene.named(max(driven.scene.levels))}"
    velocity, lateral = quantity.velocity_m_per_s.column, quantity.lateral_velocity_m_per_s.column
    data: dict = {}
    for key, table, k in (
        ("x_m", "pose", 0), ("y_m", "pose", 1), ("yaw_rad", "pose", 2), (velocity, "rates", 0), (lateral, "rates", 1),
        ("yaw_rate_rad_per_s", "rates", 2),
    ):  # fmt: skip
        data[key] = {each.name: getattr(each, table)[:, k] for each in legs}
    data |= {"time_s": {each.name: each.time for each in legs}}
    data["contacts_m"] = np.column_stack([np.atleast_1d(driven.slider.x), np.atleast_1d(driven.slider.y)])
    return [Panel(name=name, title=title, data=data) for name in ("path", "yaw")]


def _findings(driven, sources, level: float, legs: list[Leg], tolerance: float):
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
            remark="; ".join(f"{name}: {_pair(v, 'm/s', float(np.hypot(*v)))}"
                             for name, v in zip((*sources, "all"), velocities, strict=True)),
        )  # fmt: skip
    coast, slider = legs[-1], driven.slider
    speed, way = (float(np.hypot(*each)) for each in (coast.rates[0, :2], coast.pose[-1, :2] - coast.pose[0, :2]))
    braking = slider.friction_coefficient * slider.preload / slider.mass
    moves = speed > SLOW and braking > 0.0
    yield judged(
        "Friction stops a slider that does not turn within v^2/(2 a), a = mu times preload over mass.",
        "way of the coast over it", way / (speed**2 / (2.0 * braking)) if moves else 0.0, low=0.5, high=2.0,
        holds=True if moves else None, remark="turning adds to the way, since it takes a part of the friction",
    )  # fmt: skip
    yield judged(
        "The error of the path is small.", "largest error of a leg's end over the length of the path",
        max(each.error for each in legs) / max(sum(_length(each) for each in legs), SMALLEST), low=-1.0, high=0.05,
    )  # fmt: skip


def _findings_of_turn(driven, legs: list[Leg]):
    """Judge within which angle friction stops a rotor, and the error of its yaw."""
    coast, slider = legs[-1], driven.slider
    rate, turn = abs(float(coast.rates[0, 2])), abs(float(coast.pose[-1, 2] - coast.pose[0, 2]))
    arm = float(np.hypot(slider.x - slider.axis[0], slider.y - slider.axis[1]).max())
    braking, moves = friction_torque(slider) / slider.inertia, rate * arm > SLOW
    yield judged(
        "Friction stops a rotor within omega^2/(2 a), a = the torque of contacts that slip over the moment of inertia.",
        "angle of the coast over it", turn / (rate**2 / (2.0 * braking)) if moves else 0.0, low=0.5, high=2.0,
        holds=None if not moves else True,
    )  # fmt: skip
    whole = max(sum(float(np.abs(np.diff(each.pose[:, 2])).sum()) for each in legs), SMALLEST)
    yield judged(
        "The error of the yaw is small.", "largest error of a leg's end over the angle turned",
        max(each.yaw_error for each in legs) / whole, low=-1.0, high=0.05,
    )  # fmt: skip


def _answer_of_turn(legs: list[Leg]) -> list[tuple[str, str]]:
    lines = []
    for each in legs:
        (_, _, yaw), (_, _, rate) = each.end
        where = f"yaw {math.degrees(yaw):.4g} deg at {PER_MINUTE * rate:.4g} 1/min"
        error = f"+-{math.degrees(each.yaw_error):.1g} deg"
        lines.append((each.name, f"{si(float(np.ptp(each.time)), 's', 3)}: to {where}, {error}"))
    return lines


def _length(leg: Leg) -> float:
    return float(np.hypot(*np.diff(leg.pose[:, :2], axis=0).T).sum())


def _pair(values, unit: str, scale: float) -> str:
    """Return both components; one that is rounding against a scale is 0."""
    return f"({', '.join(si(0.0 if abs(each) < ROUNDING * scale else float(each), unit, 4) for each in values)})"


def _answer(legs: list[Leg], driven) -> list[tuple[str, str]]:
    lines, arm = [], float(np.hypot(driven.slider.x, driven.slider.y).max())
    for each in legs:
        (x, y, yaw), (v_x, v_y, rate) = each.end
        way, speed = (float(np.hypot(*part.T).max()) for part in (each.pose[:, :2], each.rates[:, :2]))
        yaw, rate = (0.0 if abs(arm * turn) < ROUNDING * whole else turn for turn, whole in ((yaw, way), (rate, speed)))
        where = f"{_pair((x, y), 'm', way)}, yaw {math.degrees(yaw):.4g} deg"
        how = f"{_pair((v_x, v_y), 'm/s', speed)}, {rate:.4g} rad/s"
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
    for name, x, colour in family(data["x_m"]):
        pose = np.column_stack([x, data["y_m"][name], data["yaw_rad"][name]])
        draw_path(ax, name, pose, np.asarray(data["contacts_m"]), colour)
    ax.set_aspect("equal", adjustable="datalim")
    return finished(ax, quantity.x_m.axis, quantity.y_m.axis, record.title)
