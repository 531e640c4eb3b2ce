"""Quantities of a sweep point of a slider in the plane other than its velocity: stall force, stall torque, ripple."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

import numpy as np

import contact
from contact import plane
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.refusal import refuse_outside
from studies.scene.plane_keys import AXLE
from studies.solve.plane_motor import PlaneMotor
from studies.solve.plane_ripple import differs, ripple_of
from studies.solve.point_answer import PointAnswer

OF_PLANE = ("ripple", "thrust", "torque", "pressure")  # keywords that have an answer in the plane


def refuse_in_plane(also: Iterable[str]) -> None:
    """Raise a SceneError for a keyword that has no answer in the plane."""
    refuse_outside(also, OF_PLANE, "also", " for a slider in the plane")


def plane_quantities(also: Iterable[str], tolerance: float, driven: Contact, answer: PointAnswer) -> Point:
    """Return the quantities that keywords request of an answer; those that have none are absent."""
    words, point, known = set(also), Point(), answer.point
    refuse_in_plane(words)
    if driven.level == 0.0:
        return point
    if "ripple" in words and differs(driven):
        point |= ripple_of(driven, driven.level, tolerance, answer)
    if "pressure" in words:
        point |= Point(contact_pressure_Pa=known.contact_pressure_Pa)
    if not {"thrust", "torque"} & words:
        return point
    motor = PlaneMotor.of(driven, driven.level, tolerance)
    free = replace(motor.slider, load=(0.0, 0.0), torque=0.0)
    if "thrust" in words and free.freedom != AXLE:
        with suppress(contact.ConvergenceError):
            point |= Point(thrust_N=stall_force(replace(motor, slider=free)).value * driven.scene.slider.share)
    if "torque" in words and driven.scene.slider.turns:
        with suppress(contact.ConvergenceError):
            point |= Point(stall_torque_N_m=plane.stall_torque(free, motor.waves).value)
    return point


def stall_force(motor: PlaneMotor) -> contact.Answer:
    """Return the force against the unloaded motion under which the slider keeps its place along it, N."""
    velocity = motor.state().velocity
    if not np.any(velocity):
        return contact.Answer(value=0.0, error=0.0, reasons=("the wave does not move the slider",))
    return plane.stall(motor.slider, motor.waves, velocity)
