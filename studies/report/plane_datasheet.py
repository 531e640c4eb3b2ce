"""Rows of the datasheet of a slider in the plane: speed, direction, rotation, stall force and torque, start, stop."""

import logging
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import contact
from contact import plane
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.point import Point
from studies.record.prefixes import si
from studies.report.datasheet_rows import Row
from studies.scene.plane_keys import AXLE
from studies.solve.mapped_surface import travelled
from studies.solve.plane_burst import on_free_surface
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor
from studies.solve.plane_path import Leg, legs_of
from studies.solve.plane_quantities import stall_force

LOGGER = logging.getLogger(__name__)
SETTLED = 0.95  # part of the steady speed at which a start is over
PATH_TOLERANCE = 1e-3  # of the start and the stop, relative
SAMPLES = 200  # instants of the start, and of the stop
WEAK = 0.8  # of the waves at the position: waves that are smaller where the start ends do not bring it to its speed
SLOW = 1e-3  # m/s: speed up to which a slider has no start and stop to speak of
TIME_CONSTANTS = 8.0  # of the start: duration of the burst over momentum by stall force


def plane_rows(record: Record, driven: Contact, rated: float) -> tuple[tuple[Row, ...], tuple[str, ...]]:
    """Return the rows at the rated level without a load, and remarks on those that are missing."""
    motor = PlaneMotor.of(driven, rated, record.tolerance)
    motor = replace(motor, slider=replace(motor.slider, load=(0.0, 0.0), torque=0.0))
    point = next(each for each in record.points if each.level == rated)
    rows = [*_speeds(driven, point)]
    remarks: list[str] = []
    try:
        LOGGER.info("stall force and torque")
        rows += _forces(motor, driven)
        LOGGER.info("start and stop")
        start = start_of(motor, driven, rated, point)
        if start is not None:
            rows += start_and_stop(start, driven)
            remarks += _room(start, motor, driven, rated) if motor.slider.freedom != AXLE else ()
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


class Start(NamedTuple):
    """A start from rest up to `SETTLED` of the steady speed, and the coast to rest from the end of the burst."""

    slider: contact.Slider
    motion: plane.PlaneTrajectory
    legs: tuple[Leg, Leg]
    reached: int  # instant of the first leg from which on it is faster; 0 where it never is
    share: float  # of the way from the instant before to that one


def start_of(motor: PlaneMotor, driven: Contact, level: float, point: Point) -> Start | None:
    """Return start and stop of a slider without a load; None where it is too slow to have them.

    A rotor turns over its waves. The waves and the arms of a slider that moves on stay those of its place, as of its
    steady speed: the way to that speed may be longer than the free surface.
    """
    slider, axle = motor.slider, motor.slider.freedom == AXLE
    speed = _speed_of(point, axle)
    force = abs(plane.stall_torque(slider, motor.waves).value) if axle else stall_force(motor).value
    if not speed > 0.0 or not force > 0.0 or (not axle and speed <= SLOW):
        return None
    surface = plane.from_upward_zero(slider, travelled(driven, level)) if axle else motor.waves
    motion = plane.burst(
        slider, surface, duration=TIME_CONSTANTS * (slider.inertia if axle else slider.mass) * speed / force,
        after=math.inf, tolerance=PATH_TOLERANCE, samples=SAMPLES, method="averaged", in_place=not axle,
        start=(np.zeros(3), np.zeros(3)),
    )  # fmt: skip
    legs = legs_of("start", motion)
    speeds, goal = _speeds_of(legs[0], axle), SETTLED * speed
    reached = int(np.argmax(speeds >= goal))
    share = (goal - speeds[reached - 1]) / (speeds[reached] - speeds[reached - 1]) if reached else 0.0
    return Start(slider, motion, (legs[0], legs[-1]), reached, float(share))


def start_and_stop(start: Start, driven: Contact) -> Iterator[Row]:
    """Yield time and way, or angle, of a start from rest and of the coast to rest after it."""
    axle, (leg, coast) = driven.scene.slider.axis is not None, start.legs
    if start.reached:
        last = slice(start.reached - 1, start.reached + 1)
        weights = 1.0 - start.share, start.share
        time, acceleration = np.average(leg.time[last], weights=weights), np.ptp(_speeds_of(leg, axle)[last])
        acceleration /= float(np.ptp(leg.time[last]))
        until = f"from rest to {SETTLED:.0%} of the {'mean rotation' if axle else 'speed on the waves at the position'}"
        late = _speed_error(start.motion, axle) / acceleration
        moved = np.average(leg.pose[last], axis=0, weights=weights)
        yield Row("positioning", "start time", float(time), "s", late / time, until)
        yield _way("start", start, moved, time, late * _speeds_of(leg, axle)[start.reached], until)
    until, time = "from the end of the start, drive off, by friction", float(np.ptp(coast.time))
    error = _speed_error(start.motion, axle) / _speeds_of(coast, axle)[0]
    yield Row("positioning", "stop time", time, "s", error, until)
    swing = plane.spring_back(start.slider)
    springs = float(swing[2] if axle else np.hypot(*swing[:2]))
    yield _way("stop", start, coast.pose[-1] - coast.pose[0], time, springs, until)


def _way(name: str, start: Start, moved: np.ndarray, time: float, further: float, until: str) -> Row:
    """Return the row of a way, or an angle: its error is that of the speed over the time, and a further one."""
    axle = start.slider.freedom == AXLE
    if axle:
        way, kind, factor, unit = abs(float(moved[2])), "angle", math.degrees(1.0), "deg"
    else:
        way, kind, factor, unit = float(np.hypot(*moved[:2])), "distance", 1.0, "m"
    error = (_speed_error(start.motion, axle) * time + further) / way if way > 0.0 else None
    return Row("positioning", f"{name} {kind}", factor * way, unit, error, until)


def _room(start: Start, motor: PlaneMotor, driven: Contact, level: float) -> tuple[str, ...]:
    """Return the remark on a start that does not reach its speed: its contacts leave the free surface, or the waves."""
    leg, last = start.legs[0], start.reached
    _, left = on_free_surface(driven, start.slider, start.motion)
    if left is not None and not (last and left >= leg.time[last]):
        last, why = int(np.searchsorted(leg.time, left)), "there it comes to fingers or an edge of the stator"
    elif last:
        share = _mean_size(motor, start.slider, leg.pose[last]) / _mean_size(motor, start.slider, np.zeros(3))
        if share >= WEAK:
            return ()
        why = f"the waves there have {share:.0%} of their size at slider.position"
    else:
        return ()
    way = si(float(np.hypot(*leg.pose[last, :2])), "m", 3)
    taken = f"a start from rest at {driven.scene.named(level)} takes {way} or more"
    return (f"{taken}, and {why}: the slider does not reach its speed from slider.position",)


def _mean_size(motor: PlaneMotor, slider: contact.Slider, pose: np.ndarray) -> float:
    """Return the mean normal amplitude of the waves under the contacts of a slider at a pose, m."""
    waves = motor.surface.at(*plane.places(slider, pose))
    return float(np.abs(waves.amplitudes[..., 2]).mean())


def _speed_error(motion: plane.PlaneTrajectory, axle: bool) -> float:
    """Return the error of a speed in m/s, or of an axle's yaw rate in rad/s."""
    return float(motion.error[2] if axle else np.hypot(*motion.error[:2]))


def _speed_of(point: Point, axle: bool) -> float:
    """Return the steady speed in m/s, or the yaw rate of a rotor in rad/s: its mean over a turn."""
    if axle:
        return abs(point.mean_rotation_rpm or point.rotation_rpm or 0.0) / PER_MINUTE
    return math.hypot(point.velocity_m_per_s or 0.0, point.lateral_velocity_m_per_s or 0.0)


def _speeds_of(leg: Leg, axle: bool) -> np.ndarray:
    return np.abs(leg.rates[:, 2]) if axle else np.hypot(*leg.rates[:, :2].T)
