"""Propagation of an error of the surface motion to the slider's velocity, by solving the contact for changed orbits.

The stator's relative error bounds the error of both complex amplitudes of an orbit, relative to the larger one.  A
common phase is excluded because the steady velocity does not depend on it.  Three changes of the size of the error
are tried: of all amplitudes, of the ratio of the two, and of their phase difference; `contact.changed_waves_error`
adds the resulting changes of velocity.  All amplitudes are both raised and lowered, because near the threshold the
slider may stick on one side and slip on the other.
"""

import cmath
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import contact
from studies.record.point import Point
from studies.record.status import Status

WAVE_STEP = 1e-3  # relative change of a passing wave
BOUNCE = 3.0  # bounces of the squared ratio of resonance and frequency that a held height leaves out


def held_height_error(slider: contact.Slider, orbits: tuple) -> float:
    """Return the error of a velocity, over the reference speed, whose slider was held at one height and speed.

    The mean over a cycle leaves out the bounce, of the order of (f_n/f)^2 with the contact's resonance f_n. Of sliders
    of 1e-6 to 1e-9 kg on balls of JKR the exact motion differed by up to 2.4 times that, most near the threshold.
    """
    return BOUNCE * (slider.normal_resonance(len(orbits)) / orbits[0].frequency) ** 2


def judged(tolerance: float, of_stator: float, of_contact: float, why: str = "") -> Point:
    """Return error and status of a velocity whose error has two parts, over the reference speed.

    ``why``: reasons for the contact's part, which follow the sizes of both in the status.
    """
    error, status = of_stator + of_contact, Status.OK.value
    if error > tolerance:
        sizes = f"stator {of_stator:.1e}, contact {of_contact:.1e}"
        status = Status.ABOVE_TOLERANCE.because(f"{sizes}; {why}" if why else sizes)
    return Point(relative_error=error, status=status)


def velocity_sensitivities(
    velocity: float, orbits: tuple | Any, relative_error: float, solve: Callable[[Any], float]
) -> tuple[float, float]:
    """Return two changes of the velocity, over the reference speed, for a relative change of 1 of the orbits.

    They are that of all amplitudes (the larger of an increase and a decrease), and that of all changes together; both
    are zero without an error or a reference speed.

    Parameters
    ----------
    velocity : float
        Steady velocity in m/s with these orbits.
    orbits : tuple of contact.Orbit or contact.PassingWave
        Of a passing wave, the amplitude alone is changed, by WAVE_STEP.
    relative_error : float
        Of the orbits; the changes that are tried have this size.
    solve : callable
        Returns the steady velocity of other orbits, m/s.
    """
    speed = contact.reference_speed(velocity, orbits)
    if isinstance(orbits, contact.PassingWave):
        change = abs(solve(orbits.scaled(1.0 + WAVE_STEP)) - velocity) if velocity != 0.0 else 0.0
        by_amplitude = change / (WAVE_STEP * speed) if speed else 0.0
        return by_amplitude, by_amplitude
    if relative_error == 0 or speed == 0:
        return 0.0, 0.0
    step = max(relative_error, contact.MIN_WAVE_STEP)
    changed_orbits = (
        tuple(orbit.scaled(1 + step) for orbit in orbits),
        tuple(orbit.scaled(1 - step) for orbit in orbits),
        tuple(_with_tangential(orbit, 1 + step * _axis_ratio(orbit)) for orbit in orbits),
        tuple(_with_tangential(orbit, cmath.exp(1j * step * _axis_ratio(orbit))) for orbit in orbits),
    )
    larger, smaller, ratio, phase = (abs(solve(each) - velocity) / (step * speed) for each in changed_orbits)
    return max(larger, smaller), float(contact.changed_waves_error(larger, smaller, ratio, phase))


def _axis_ratio(orbit) -> float:
    return contact.axis_ratio(abs(orbit.normal), abs(orbit.tangential))


def _with_tangential(orbit, factor: complex):
    """Return an orbit with its tangential amplitude multiplied by a factor."""
    return replace(orbit, tangential=orbit.tangential * factor)
