"""Propagation of an error of the surface motion to the slider's velocity, by solving the contact for changed orbits.

The stator's relative error bounds the error of both complex amplitudes of an orbit, relative to the larger one.  A
common phase is excluded because the steady velocity does not depend on it.  Three changes of the size of the error
are tried: of all amplitudes, of the ratio of the two, and of their phase difference.  The caller adds the resulting
changes of velocity in quadrature.  All amplitudes are both raised and lowered, because near the threshold the slider
may stick on one side and slip on the other.
"""

import cmath
from collections.abc import Callable
from dataclasses import replace

import contact
from studies.record.point import Point
from studies.record.status import Status

# Larger over smaller amplitude of an orbit; of a more slender orbit the relative error of the smaller amplitude is
# taken as at this ratio.
MAX_AXIS_RATIO = 1e3
MIN_STEP = 1e-4  # relative; a difference over a smaller step would measure the contact solver's rounding


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
    velocity: float, orbits: tuple, relative_error: float, solve: Callable[[tuple], float]
) -> tuple[float, float, float]:
    """Return the changes of the velocity, over the reference speed, for a relative change of 1 of the orbits.

    The three changes are those of all amplitudes (the larger of an increase and a decrease), of their ratio, and of
    their phase; all are zero without an error or a reference speed.

    Parameters
    ----------
    velocity : float
        Steady velocity in m/s with these orbits.
    orbits : tuple of contact.Orbit
    relative_error : float
        Of the orbits; the changes that are tried have this size.
    solve : callable
        Returns the steady velocity of other orbits, m/s.
    """
    speed = contact.reference_speed(velocity, orbits)
    if relative_error == 0 or speed == 0:
        return 0.0, 0.0, 0.0
    step = max(relative_error, MIN_STEP)
    changed_orbits = (
        tuple(orbit.scaled(1 + step) for orbit in orbits),
        tuple(orbit.scaled(1 - step) for orbit in orbits),
        tuple(_with_tangential(orbit, 1 + step * _slenderness(orbit)) for orbit in orbits),
        tuple(_with_tangential(orbit, cmath.exp(1j * step * _slenderness(orbit))) for orbit in orbits),
    )
    larger, smaller, ratio, phase = (abs(solve(each) - velocity) / (step * speed) for each in changed_orbits)
    return max(larger, smaller), ratio, phase


def _slenderness(orbit) -> float:
    """Return the larger amplitude over the smaller, at most MAX_AXIS_RATIO.

    The error is relative to the larger amplitude, so that the relative error of the smaller one is this factor larger.
    """
    small, large = sorted((abs(orbit.normal), abs(orbit.tangential)))
    return min(large / small, MAX_AXIS_RATIO) if small > 0 else 1.0


def _with_tangential(orbit, factor: complex):
    """Return an orbit with its tangential amplitude multiplied by a factor."""
    return replace(orbit, tangential=orbit.tangential * factor)
