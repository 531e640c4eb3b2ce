"""Mean and range of the velocity of a slider in the plane over places within a wavelength, or over a turn of a rotor.

Where waves cross or meet, the velocity depends on the place: a wavelength of travel turns a drive to one side into one
to the other.  The places are points of two lattices of rank 1 on a square of one wavelength, whose means are exact for
low harmonics of x, y, x + y and x - y; those of a rotor are yaw angles at equal steps, twice.  At each the slider is
solved as if it stayed there.  The difference of both means is the error of the mean of all.

Where the averaged motion is not within the tolerance, the full motion that repeats differs from it by nearly the same
velocity everywhere: it is solved at the slider's place and at those of the most different velocities.  Their mean
difference corrects the averaged motions of all places, and the spread of the differences is an error.  On
`twente-planar` the differences are 3e-4 of the speed and their spread is 1e-4 (24 places, 20 to 60 V).
"""

import logging
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
from contact import plane
from studies.model.plane import StatorSurface
from studies.model.wave_to_contact import Contact
from studies.progress import counted
from studies.record.point import Point
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor, contact_speed, waves_at
from studies.solve.point_answer import PointAnswer, SliderAnswer

# points (k, step k)/count of each lattice: primes, so that x, y, x + y and x - y take as many values each; of a turn
# no part of the pitch of usual rings, so that the phases under the balls differ
LATTICES = ((11, 3), (13, 5))
COMPARED = 2  # places besides the slider's at which both motions are solved
MAX_SPREAD = 0.25  # of the tolerance: differences of both motions that spread further are not taken as one

LOGGER = logging.getLogger(__name__)


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
        nearby, by_method = _rates_nearby(driven, motor, answer.point, tolerance)
    except contact.ConvergenceError:
        return Point()
    along, across, rates = nearby.T
    reference = _reference(motor, nearby)
    errors = [_apart(each) + spread for each, spread in zip(nearby.T, by_method, strict=True)]
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


def _rates_nearby(driven: Contact, motor: PlaneMotor, point: Point, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and yaw rate (k, 3) at the places of `states_nearby`, and their errors (3,) by the method.

    ``point``: the answer at the first of them, the slider's.
    """
    places = _places(driven, motor)
    try:
        averaged = [motor.state(waves, body, method="averaged") for waves, body in _counted(places)]
    except contact.ConvergenceError:
        averaged = []
    if not averaged or motor.scene.slider.method == "exact" or any(each.status != "ok" for each in averaged):
        found = _corrected(motor, places, averaged, point, tolerance) if averaged else None
        return found or (_rates_of(motor.state(*each) for each in _counted(places)), np.zeros(3))
    return _rates_of(averaged), np.zeros(3)


def _corrected(
    motor: PlaneMotor, places: list, averaged: list, point: Point, tolerance: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return rates (k, 3) of averaged motions with their mean difference from the full one, and its spread (3,).

    None where the differences are not alike.
    """
    rates = _rates_of(averaged)
    reference, chosen = _reference(motor, rates), [0]
    here = [point.velocity_m_per_s, point.lateral_velocity_m_per_s, point.yaw_rate_rad_per_s]
    full = [np.array([each or 0.0 for each in here])]
    for _ in range(COMPARED):
        away = [min(_speed(motor, each - rates[k]) for k in chosen) for each in rates]
        chosen.append(int(np.argmax(away)))
        full.append(_rates_of([motor.state(*places[chosen[-1]])])[0])
    differences = np.array(full) - rates[chosen]
    spread = np.ptp(differences, axis=0)
    if _speed(motor, spread) > MAX_SPREAD * tolerance * reference:
        return None
    return rates + differences.mean(axis=0), spread


def _counted(places: list) -> Iterator:
    return counted(LOGGER, "velocity at other places", places)


def _rates_of(states) -> np.ndarray:
    return np.array([[*each.velocity, each.yaw_rate] for each in states])


def _speed(motor: PlaneMotor, rates: np.ndarray) -> float:
    return contact_speed(motor.slider, rates[:2], float(rates[2]))


def _reference(motor: PlaneMotor, rates: np.ndarray) -> float:
    """Return the speed to which a relative error refers, of rates (k, 3) at several places."""
    return contact.speed_scale(float(np.mean([_speed(motor, each) for each in rates])), motor.waves.peak_speed)


def states_nearby(driven: Contact, motor: PlaneMotor) -> list:
    """Return the steady states at places within a wavelength, or over a turn of a rotor; first at the slider's own."""
    return [motor.state(*each) for each in _counted(_places(driven, motor))]


def _places(driven: Contact, motor: PlaneMotor) -> list[tuple]:
    """Return waves and slider at each place, first at the slider's own."""
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


def _of_places(motor: PlaneMotor, length: float) -> list[tuple]:
    """Return the waves under the slider, and it, at the places of both lattices within a wavelength."""
    shares = [(k / count, step * k / count) for count, step in LATTICES for k in range(count)]
    shifts = [((a + 0.5) % 1.0 - 0.5, (b + 0.5) % 1.0 - 0.5) for a, b in shares]
    waves = [waves_at(motor.surface, motor.slider, (a * length, b * length)) for a, b in shifts]
    return [(each, motor.slider) for each in waves]


def _of_turn(motor: PlaneMotor) -> list[tuple]:
    """Return the waves under a rotor, and it, at equal steps of its turn."""
    bodies = [plane.turned(motor.slider, 2.0 * np.pi * k / count) for count, _ in LATTICES for k in range(count)]
    return [(waves_at(motor.surface, each), each) for each in bodies]
