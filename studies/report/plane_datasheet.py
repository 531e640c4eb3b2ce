"""Rows of the datasheet of a slider in the plane: speed, direction, rotation, stall force and torque, start, stop."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
from contact import plane
from studies.model.plane import Sum
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.point import Point
from studies.report.datasheet_rows import Row
from studies.scene.plane_keys import AXLE
from studies.solve.mapped_surface import travelled
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor
from studies.solve.plane_path import Leg, legs_of
from studies.solve.plane_quantities import stall_force

SETTLED = 0.95  # part of the steady speed at which a start is over
PATH_TOLERANCE = 1e-2  # of the start and the stop, relative
SAMPLES = 60  # instants of the start, and of the stop
SLOW = 1e-3  # m/s: speed up to which a slider has no start and stop to speak of
TIME_CONSTANTS = 8.0  # of the start: duration of the burst over momentum by stall force


def plane_rows(record: Record, driven: Contact, rated: float) -> tuple[tuple[Row, ...], tuple[str, ...]]:
    """Return the rows at the rated level without a load, and remarks on those that are missing."""
    motor = PlaneMotor.of(driven, rated, record.tolerance)
    motor = replace(motor, slider=replace(motor.slider, load=(0.0, 0.0), torque=0.0))
    point = next(each for each in record.points if each.level == rated)
    rows, remarks = [*_speeds(driven, point)], []
    try:
        rows += _forces(motor, driven)
        rows += _start_and_stop(motor, travelled(driven, rated), point)
    except contact.ConvergenceError as error:
        remarks.append(f"the datasheet is incomplete: {' '.join(str(error).split())}")
    if record.electrical:
        power, inexact = record.electrical.power_W_per_V2 * rated**2, record.electrical.admittance_relative_error
        rows.append(Row("power", "electrical power", power, "W", inexact, "mean, of all sources"))
    rows.append(Row("power", "lost by slip", point.friction_power_W or 0.0, "W", None, "no load"))
    return tuple(rows), tuple(remarks)


def _speeds(driven: Contact, point: Point) -> Iterator[Row]:
    slider, error, model = driven.scene.slider, point.relative_error, point.model_relative_error
    if slider.turns:
        where = "at the position" if point.mean_rotation_rpm is not None else ""
        yield Row("speed", "rotation", point.rotation_rpm, "1/min", error, f"no load, steady {where}".rstrip(), model)
        if point.mean_rotation_rpm is not None:
            over = "over a turn" if slider.freedom == AXLE else "over places within a wavelength"
            mean_error = point.mean_velocity_relative_error
            yield Row("speed", "mean rotation", point.mean_rotation_rpm, "1/min", mean_error, f"no load, {over}")
    if slider.freedom == AXLE:
        return
    for name, along, across, own in (
        ("", point.velocity_m_per_s, point.lateral_velocity_m_per_s, error),
        ("mean ", point.mean_velocity_m_per_s, point.mean_lateral_velocity_m_per_s, point.mean_velocity_relative_error),
    ):
        if along is None or across is None:
            continue
        angle, where = math.degrees(math.atan2(across, along)), "over places within a wavelength" if name else "steady"
        yield Row("speed", f"{name}speed", math.hypot(along, across), "m/s", own, f"no load, {where}", model)
        yield Row("speed", f"{name}direction", angle, "deg", None, "from x towards y")
    if point.drift_m_per_s_per_deg is not None:
        for name, drift in zip(("along x", "along y"), point.drift_m_per_s_per_deg, strict=True):
            yield Row("speed", f"drift {name}", drift, "m/s", None, f"by a slope of 1 deg {name}")
    if point.yaw_stability_per_s is not None:
        stable = "a turned slider turns back" if point.yaw_stability_per_s < 0.0 else "a turned slider goes on to turn"
        yield Row("speed", "stability of yaw", point.yaw_stability_per_s, "1/s", None, stable)


def _forces(motor: PlaneMotor, driven: Contact) -> Iterator[Row]:
    slider, share = motor.slider, driven.scene.slider.share
    holding = share * slider.friction_coefficient * slider.preload
    if slider.freedom != AXLE:
        stall = stall_force(motor)
        error = stall.error / abs(stall.value) + 2.0 * driven.stator_error if stall.value else None
        yield Row("force", "stall force", share * stall.value, "N", error, "against the motion, free across it")
        yield Row("force", "holding force", holding, "N", None, "drive off: friction coefficient times preload")
    if driven.scene.slider.turns:
        torque = plane.stall_torque(slider, motor.waves)
        error = torque.error / abs(torque.value) + 2.0 * driven.stator_error if torque.value else None
        yield Row("force", "stall torque", abs(torque.value), "N m", error, "that keeps it from turning")


def _start_and_stop(motor: PlaneMotor, surface: Sum, point: Point) -> Iterator[Row]:
    """Yield time and way, or angle, of a start from rest and of the coast to rest after it."""
    slider, axle = motor.slider, motor.slider.freedom == AXLE
    speed = _speed_of(point, axle)
    force = abs(plane.stall_torque(slider, motor.waves).value) if axle else stall_force(motor).value
    if not speed > 0.0 or not force > 0.0 or (not axle and speed <= SLOW):
        return
    inertia = slider.inertia if axle else slider.mass
    surface = plane.from_upward_zero(slider, surface)
    motion = plane.burst(
        slider, surface, duration=TIME_CONSTANTS * inertia * speed / force, after=math.inf, tolerance=PATH_TOLERANCE,
        samples=SAMPLES, method="averaged",
    )  # fmt: skip
    start, stop = legs_of("start", motion)
    reached = _speeds_of(start, axle) >= SETTLED * _speeds_of(start, axle)[-1]
    for name, leg, last in (("start", start, int(np.argmax(reached))), ("stop", stop, -1)):
        until = f"to {SETTLED:.0%} of the speed" if name == "start" else "drive off, by friction"
        yield Row("positioning", f"{name} time", float(leg.time[last] - leg.time[0]), "s", None, until)
        yield _way(name, leg, last, axle, until)


def _way(name: str, leg: Leg, last: int, axle: bool, until: str) -> Row:
    if axle:
        angle = abs(float(leg.pose[last, 2] - leg.pose[0, 2]))
        return Row("positioning", f"{name} angle", math.degrees(angle), "deg", None, until)
    way = float(np.hypot(*(leg.pose[last, :2] - leg.pose[0, :2])))
    return Row("positioning", f"{name} distance", way, "m", leg.error / way if way > 0.0 else None, until)


def _speed_of(point: Point, axle: bool) -> float:
    if axle:
        return abs(point.rotation_rpm or 0.0) / PER_MINUTE
    return math.hypot(point.velocity_m_per_s or 0.0, point.lateral_velocity_m_per_s or 0.0)


def _speeds_of(leg: Leg, axle: bool) -> np.ndarray:
    return np.abs(leg.rates[:, 2]) if axle else np.hypot(*leg.rates[:, :2].T)
