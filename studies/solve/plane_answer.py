"""The answer of a slider that moves in the plane at one level of the drive: velocity, yaw rate, torque, drift.

The error of the stator becomes one of the velocity by the changes of `velocity_error`: of all amplitudes, of those
along the surface alone, and of their phase against u_z. Of waves of one frequency that cross, the phase between them at
the slider decides the direction: an error of a wave over its amplitude is as large an error of its phase in rad, and
each wave but the first is changed by it.

The velocity is that of the pose; a wavelength of travel turns the phase through all values (`plane_ripple`).
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
from contact import plane
from studies.model.plane import StatorSurface
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.status import Status
from studies.scene.plane_keys import AXLE
from studies.solve.plane_burst import followed_in_plane
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor, contact_speed
from studies.solve.point_answer import PointAnswer
from studies.solve.velocity_error import judged

ALIKE = 1e-2  # of the reference speed: averaged motions that are as near to the full one stand for its changes
WEAKEST_FIRST = ("separated", "stick", "slip", "intermittent")


def plane_threshold(driven: Contact) -> float:
    """Return the level at which the slider starts to move; inf where its waves beat too slowly for one."""
    try:
        motor = PlaneMotor.at_threshold(driven)
        with slider_keys():
            return plane.threshold_factor(motor.slider, motor.surface)
    except contact.ConvergenceError:
        return math.inf


def plane_point_answer(driven: Contact, level: float, tolerance: float, *, bursting: bool = True) -> PointAnswer:
    """Return the answer at one level, for `contact_at_level.point_answer`."""
    if level == 0.0:
        return PointAnswer(point=_at_rest(driven))
    motor = PlaneMotor.of(driven, level, tolerance)
    bursting = bursting and driven.scene.burst is not None
    try:
        state = motor.state()
    except contact.ConvergenceError:
        if bursting and plane.beats_slowly(motor.slider, motor.waves):
            return _burst_alone(driven, motor, level, tolerance)
        raise
    from_contact, answer, trajectory = state.relative_error, state.answer, None
    by_amplitude, from_stator = _stator_part(motor, state, driven, level)
    point = moving_point(motor, state) | _derivatives(motor, state)
    point |= Point(amplitude_sensitivity=by_amplitude if driven.stator_error else None)
    if bursting:
        speed = contact_speed(motor.slider, state.velocity, state.yaw_rate)
        with slider_keys():
            trajectory, moved = followed_in_plane(driven, motor.slider, level, speed, motor.tolerance)
        point |= moved
        from_stator += 0.0 if driven.ringing is None else driven.ringing.error
        if trajectory.relative_error > from_contact or answer.status == Status.OK:
            from_contact, answer = max(from_contact, trajectory.relative_error), trajectory.answer
    point |= judged(tolerance, from_stator, from_contact, "" if answer.status == Status.OK else answer.why)
    return PointAnswer(
        point=point, from_stator=from_stator, from_contact=from_contact, trajectory=trajectory, averaged=True
    )


def _burst_alone(driven: Contact, motor: PlaneMotor, level: float, tolerance: float) -> PointAnswer:
    """Return the answer of a burst of waves whose steady motion is not found: they beat slowly."""

    def followed(some: float):
        with slider_keys():
            return followed_in_plane(driven, motor.slider, some, motor.waves.peak_speed, motor.tolerance)

    trajectory, point = followed(level)
    from_stator, error = 0.0 if driven.ringing is None else driven.ringing.error, driven.stator_error
    if error > 0.0:
        step = max(error, contact.MIN_WAVE_STEP)
        end = trajectory.burst_end
        other, _ = followed((1.0 + step) * level)
        change = other.rates[end] - trajectory.rates[end]
        moved = contact_speed(motor.slider, change[:2], float(change[2])) / (step * trajectory.reference)
        # as much again for the errors of u_x alone and of the phases
        from_stator += 2.0 * moved * error
    point |= judged(tolerance, from_stator, trajectory.relative_error, trajectory.answer.why)
    return PointAnswer(
        point=point, from_stator=from_stator, from_contact=trajectory.relative_error, trajectory=trajectory,
        averaged=False,
    )  # fmt: skip


def _at_rest(driven: Contact) -> Point:
    turning = Point(yaw_rate_rad_per_s=0.0, rotation_rpm=0.0) if driven.scene.slider.turns else Point()
    resting = Point(velocity_m_per_s=0.0, lateral_velocity_m_per_s=0.0, regime="stick", relative_error=0.0)
    return resting | turning | Point(status=Status.OK.value)


def moving_point(motor: PlaneMotor, state) -> Point:
    """Return velocity, yaw rate, torque and regimes of a steady state as values of a point."""
    along, across = (float(each) for each in state.velocity)
    regimes = tuple(state.regimes)
    point = Point(
        velocity_m_per_s=along, lateral_velocity_m_per_s=across,
        regime=max(regimes, key=WEAKEST_FIRST.index),
        contact_regimes=" ".join(regimes) if len(regimes) > 1 else None,
        friction_power_W=float(state.slip_power) * motor.scene.slider.share,
    )  # fmt: skip
    if motor.scene.slider.turns:
        rate = float(state.yaw_rate)
        return point | Point(yaw_rate_rad_per_s=rate, rotation_rpm=PER_MINUTE * rate)
    return point | Point(torque_N_m=float(state.torque) if len(regimes) > 1 else None)


def _derivatives(motor: PlaneMotor, state) -> Point:
    """Return the drift by a slope, and how the yaw rate changes with yaw."""
    point = Point()
    if motor.slider.freedom != AXLE and motor.scene.slider.gravity > 0.0:
        gravity, waves = motor.scene.slider.gravity, motor.waves
        if plane.beats_slowly(motor.slider, waves):
            return point  # no averaged motion has these derivatives
        along, across = (
            plane.drift_per_degree(motor.slider, waves, direction, gravity=gravity)
            for direction in ((1.0, 0.0), (0.0, 1.0))
        )
        point |= Point(drift_m_per_s_per_deg=(float(along), float(across)))
    if motor.slider.freedom == "xy yaw":
        known = state if state.method == "averaged" else None
        point |= Point(yaw_stability_per_s=float(plane.yaw_stability(motor.slider, motor.surface, state=known)))
    return point


def _stator_part(motor: PlaneMotor, state, driven: Contact, level: float) -> tuple[float, float]:
    """Return the relative change of the velocity over that of all amplitudes, and the error that the stator's makes."""
    error = driven.stator_error
    if error == 0.0:
        return 0.0, 0.0
    waves, step = motor.waves, max(error, contact.MIN_WAVE_STEP)
    reference = contact.speed_scale(contact_speed(motor.slider, state.velocity, state.yaw_rate), waves.peak_speed)
    state, method = _with_cheap_changes(motor, state, reference)

    def change(amplitudes: np.ndarray) -> float:
        other = motor.state(replace(waves, amplitudes=amplitudes), method=method)
        return _apart(motor, other, state) / (step * reference)

    larger, smaller = (change(waves.amplitudes * factor) for factor in (1.0 + step, 1.0 - step))
    tangential, phase = (
        change(waves.amplitudes * np.array([factor, factor, 1.0])) for factor in (1.0 + step, np.exp(1j * step))
    )
    between = sum(change(each) for each in _phases_between(driven, level, motor.slider, waves, step))
    return max(larger, smaller), (max(larger, smaller) + math.hypot(tangential, phase) + between) * error


def _with_cheap_changes(motor: PlaneMotor, state, reference: float) -> tuple:
    """Return the state whose changes are taken, and the method: the averaged motion where it is near the state.

    Its changes differ from those of the motion that repeats by about as much, relative, as the motions do.
    """
    if state.method == "averaged":
        return state, None
    try:
        averaged = motor.state(method="averaged")
    except contact.ConvergenceError:
        return state, None
    near = _apart(motor, averaged, state) <= ALIKE * reference
    return (averaged, averaged.method) if near else (state, None)


def _apart(motor: PlaneMotor, one, other) -> float:
    """Return the largest speed of a contact by which two steady states differ, m/s."""
    return contact_speed(motor.slider, one.velocity - other.velocity, one.yaw_rate - other.yaw_rate)


def _phases_between(driven: Contact, level: float, slider: contact.Slider, waves, step: float) -> Iterator[np.ndarray]:
    """Yield the amplitudes with the phase changed by ``step`` (rad) of each wave that crosses one of its frequency."""
    if isinstance(driven.surface, StatorSurface):
        for number, beam in driven.surface.beams(np.atleast_1d(slider.x), np.atleast_1d(slider.y)):
            amplitudes = waves.amplitudes.copy()
            amplitudes[number] += (np.exp(1j * step) - 1.0) * level * beam
            yield amplitudes
