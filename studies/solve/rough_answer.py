"""The answer at one level of a slider on rough balls: of a mean field, or of a sample with the scatter of eight."""

import math

import numpy as np

import contact
from studies.model.roughness_of_balls import largest_amplitude, limits_of, orbits_of_each, rough_balls
from studies.model.scene_errors import as_run_errors, slider_keys
from studies.model.wave_to_contact import Contact, scaled
from studies.record.point import Point
from studies.record.status import Status
from studies.scene.roughness_keys import STARTS
from studies.solve.point_answer import PointAnswer
from studies.solve.refinement import SHARE
from studies.solve.velocity_error import held_height_error, judged, velocity_sensitivities

# Fraction of the tolerance for the ball on a stator.  A smaller one than that of smooth balls (`SHARE`), whose error is
# far below their share: with the stator's error near the tolerance it would ask for a second stator, which costs more
SHARE_BESIDE_STATOR = 0.1
SCATTER = 3e-3  # tolerance of the other samples, whose scatter is far larger


def rough_answer(driven: Contact, level: float, tolerance: float, *, balance: bool = True) -> PointAnswer:
    """Return the steady velocity at a level; of a sample also the velocities of seven others, its scatter.

    ``balance``: whether the residual of its energies, which takes about as long as the velocity, and the motion of the
    slider's face are computed.
    """
    orbits = scaled(orbits_of_each(driven.scene.slider, driven.orbits), level)
    with slider_keys():
        own = _balls(driven)[0]
        state = own.motion(orbits, tolerance=_share(driven) * tolerance)
        face = _face_normal(own, orbits, state) if balance and level > 0.0 else None
        residual = None
        if balance and state.answer.value != 0.0:
            residual = contact.rough_ledger(own, orbits, state).relative_residual
    velocity, speed = state.answer.value, contact.reference_speed(state.answer.value, orbits)

    shift = velocity - (own.coarse_velocity(orbits) if driven.stator_error > 0 else 0.0)

    def nearby(some):
        return own.coarse_velocity(some) + shift

    by_amplitude, by_orbit = velocity_sensitivities(velocity, orbits, driven.stator_error, nearby)
    from_stator = driven.stator_error * by_orbit
    from_contact = state.answer.error / speed if speed > 0.0 else 0.0
    if level > 0.0:
        from_contact += held_height_error(own.slider, orbits)
    point = Point(
        velocity_m_per_s=velocity, regime=state.regime,
        amplitude_sensitivity=float(by_amplitude) if driven.stator_error > 0 else None,
        ledger_relative_residual=residual, face_normal_m=face,
    )  # fmt: skip
    point |= sample_scatter(driven, level, velocity)
    why = "" if state.answer.status == Status.OK else state.answer.why
    point |= judged(tolerance, from_stator, from_contact, why)
    return PointAnswer(point=point, from_stator=from_stator, from_contact=from_contact)


def _face_normal(own: contact.RoughBalls, orbits: tuple, state: contact.RoughMotion) -> float:
    """Return the normal amplitude of the slider's face in m: its mass under the first harmonic of the forces."""
    first = contact.rough_first_normal(own, orbits, state.heights)
    return float(abs(first.sum())) / (own.slider.mass * orbits[0].omega ** 2)


def sample_scatter(driven: Contact, level: float, velocity: float) -> Point:
    """Return lowest, median and highest of a sample's velocity and those of seven others; empty of a mean field."""
    if not driven.scene.slider.roughness.sampled:
        return Point()
    orbits = scaled(orbits_of_each(driven.scene.slider, driven.orbits), level)
    with slider_keys():
        samples = [
            velocity, *(each.velocity(orbits, tolerance=SCATTER).value for each in _balls(driven)[1:])
        ]  # fmt: skip
    return Point(
        sample_lowest_m_per_s=min(samples), sample_median_m_per_s=float(np.median(samples)),
        sample_highest_m_per_s=max(samples),
    )  # fmt: skip


def rough_ledger(driven: Contact, level: float, tolerance: float):
    """Return the `contact` ledger of a cycle of all balls at a level, J."""
    slider = driven.scene.slider
    orbits, own = scaled(orbits_of_each(slider, driven.orbits), level), _balls(driven)[0]
    with slider_keys():
        return contact.rough_ledger(own, orbits, own.motion(orbits, tolerance=_share(driven) * tolerance))


def rough_limits(driven: Contact) -> tuple[float, float]:
    """Return the factors on the orbits at which the slider runs at `STARTS`, and at which its first ball leaves.

    Of a sample they are those of the scene's own; without a level they are infinite.
    """
    level = max(driven.scene.levels)
    if level <= 0.0:
        return math.inf, math.inf
    with slider_keys(), as_run_errors(f"slider.roughness: the amplitude for {1e3 * STARTS:g} mm/s:"):
        ((threshold, release),) = limits_of(
            driven.scene.slider, driven.orbits, _amplitude(driven), STARTS, tolerance=SCATTER, count=1
        )
    return threshold, release


def _share(driven: Contact) -> float:
    """Return the fraction of the tolerance for the ball."""
    return SHARE_BESIDE_STATOR if driven.stator_error > 0 else SHARE


def _balls(driven: Contact) -> tuple:
    """Return the balls of the scene's own sample first, or of its mean field."""
    return rough_balls(driven.scene.slider, _amplitude(driven))


def _amplitude(driven: Contact) -> float:
    """Return the amplitude in m for which balls are made."""
    return largest_amplitude(driven.scene.levels, driven.orbits)
