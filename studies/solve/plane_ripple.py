"""Mean and range of the velocity of a slider in the plane over places within a wavelength, or over a turn of a rotor.

Where waves cross or meet, the velocity depends on the place: a wavelength of travel turns a drive to one side into one
to the other.  The places are points of two lattices of rank 1 on a square of one wavelength, whose means are exact for
low harmonics of x, y, x + y and x - y; those of a rotor are yaw angles at equal steps, twice.  At each the slider is
solved as if it stayed there.  The difference of both means is the error of the mean of all.
"""

from dataclasses import replace

import numpy as np

import contact
from contact import plane
from studies.model.plane import StatorSurface
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor, contact_speed, waves_at
from studies.solve.point_answer import PointAnswer, SliderAnswer

# points (k, step k)/count of each lattice: primes, so that x, y, x + y and x - y take as many values each; of a turn
# no part of the pitch of usual rings, so that the phases under the balls differ
LATTICES = ((11, 3), (13, 5))


def with_plane_ripple(answer: SliderAnswer, tolerance: float) -> SliderAnswer:
    """Return the answers with mean and range of the velocity, where the waves differ from place to place."""
    driven = answer.driven
    if not differs(driven):
        return answer
    answers = []
    for each in answer.answers:
        level = each.point.level
        found = ripple_of(driven, level, tolerance, each) if each.point.answered and level > 0.0 else Point()
        answers.append(replace(each, point=each.point | found))
    return replace(answer, answers=tuple(answers))


def differs(driven: Contact) -> bool:
    """Whether the velocity depends on the place: on a stator, on several waves, and under a rotor's balls."""
    several = driven.scene.wave is None or len(driven.scene.wave.sources or ()) > 1
    return several or driven.scene.slider.axis is not None


def ripple_of(driven: Contact, level: float, tolerance: float, answer: PointAnswer) -> Point:
    """Return mean and range of the velocity at a level; empty where a place has no answer."""
    motor = PlaneMotor.of(driven, level, tolerance)
    if plane.beats_slowly(motor.slider, motor.waves):
        return Point()  # a beat passes through all phases, and each of its motions is followed cycle by cycle
    try:
        states = states_nearby(driven, motor)
    except contact.ConvergenceError:
        return Point()
    along, across = np.array([state.velocity for state in states]).T
    rates = np.array([state.yaw_rate for state in states])
    speeds = [contact_speed(motor.slider, state.velocity, state.yaw_rate) for state in states]
    reference = contact.speed_scale(float(np.mean(speeds)), motor.waves.peak_speed)
    errors = [_apart(each) for each in (along, across, rates)]
    error = contact_speed(motor.slider, np.array(errors[:2]), errors[2])
    turn = Point()
    if driven.scene.slider.turns:
        mean, lowest, highest = (PER_MINUTE * float(each) for each in (rates.mean(), rates.min(), rates.max()))
        turn = Point(mean_rotation_rpm=mean, lowest_rotation_rpm=lowest, highest_rotation_rpm=highest)
    relative = Point(mean_velocity_relative_error=float(answer.point.relative_error + error / reference))
    if motor.slider.freedom == "axle":
        return turn | relative
    point = Point(
        mean_velocity_m_per_s=float(along.mean()), mean_lateral_velocity_m_per_s=float(across.mean()),
        lowest_velocity_m_per_s=float(along.min()), highest_velocity_m_per_s=float(along.max()),
        lowest_lateral_velocity_m_per_s=float(across.min()), highest_lateral_velocity_m_per_s=float(across.max()),
    )  # fmt: skip
    return point | relative | turn


def states_nearby(driven: Contact, motor: PlaneMotor) -> list:
    """Return the steady states at places within a wavelength, or over a turn of a rotor."""
    return _of_turn(motor) if motor.slider.freedom == "axle" else _of_places(motor, wavelength(driven))


def _apart(values: np.ndarray) -> float:
    """Return the difference of the means over both lattices."""
    first = LATTICES[0][0]
    return abs(float(values[:first].mean() - values[first:].mean()))


def wavelength(driven: Contact) -> float:
    """Return the wavelength of the waves in m, that of the first frequency."""
    if isinstance(driven.surface, StatorSurface):
        wave = driven.surface.motions[0]().wave
        return abs(wave.phase_velocity) / wave.frequency
    return driven.surface.waves[0].wavelength


def _of_places(motor: PlaneMotor, length: float) -> list:
    """Return the steady states at the places of both lattices within a wavelength."""
    shares = [(k / count, step * k / count) for count, step in LATTICES for k in range(count)]
    shifts = [((a + 0.5) % 1.0 - 0.5, (b + 0.5) % 1.0 - 0.5) for a, b in shares]
    return [motor.state(waves_at(motor.surface, motor.slider, (a * length, b * length))) for a, b in shifts]


def _of_turn(motor: PlaneMotor) -> list:
    """Return the steady states of a rotor at equal steps of its turn."""
    bodies = [plane.turned(motor.slider, 2.0 * np.pi * k / count) for count, _ in LATTICES for k in range(count)]
    return [motor.state(slider=each) for each in bodies]
