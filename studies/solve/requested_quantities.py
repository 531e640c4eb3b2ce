"""Quantities of a sweep point other than the velocity: amplitudes, power, thresholds, thrust, efficiency."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

import contact
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.refusal import refuse_outside
from studies.solve.crest_pressure import contact_load
from studies.solve.electrical import source_power
from studies.solve.heavy_limits import heavy_limits
from studies.solve.point_answer import PointAnswer
from studies.solve.ripple import Known, NearbyContact, ripple_point, ripples
from studies.solve.slider_burst import QUASI_STATIC
from studies.solve.wave_ripple import wave_ripple_point

RISE = 1.0 - 0.36787944117144233  # fraction 1 - 1/e of the final velocity, which defines the start-up time

# columns of a sweep, by the keyword that requests them
ALSO = {
    "ripple": (
        "mean_velocity_m_per_s", "lowest_velocity_m_per_s", "highest_velocity_m_per_s", "mean_velocity_relative_error",
        "velocity_ripple",
    ),
    "limits": ("threshold_factor", "release_factor"),
    "thrust": ("thrust_N",),
    "torque": ("stall_torque_N_m",),
    "pressure": ("contact_pressure_Pa", "stick_margin"),
    "start-up": ("start_up_time_s",),
    "step": ("step_m",),
    "efficiency": ("contact_efficiency", "motor_efficiency"),
}  # fmt: skip
# keywords of ALSO that apply to a slider on pillars
OF_PILLARS = ("ripple", "pressure", "thrust", "start-up", "efficiency")
FREE = ("phase_velocity_m_per_s", "surface_ratio", "attenuation_per_m")
AMPLITUDES = ("normal_amplitude_m", "tangential_amplitude_m")
ELECTRICAL = ("frequency_Hz", "conductance_S", "susceptance_S", "power_W")


def keywords(columns: Iterable[str]) -> tuple[str, ...]:
    """Return the keywords of ``ALSO`` that request columns of a sweep, each once; the velocity needs none.

    Examples
    --------
    >>> keywords(["velocity_m_per_s", "threshold_factor", "thrust_N", "release_factor"])
    ('limits', 'thrust')
    """
    words = (word for column in columns for word, requested in ALSO.items() if column in requested)
    return tuple(dict.fromkeys(words))


def motions_in_plane(slider: dict) -> tuple[str, ...]:
    """Return the columns of the motion of a slider that moves in the plane; none of one that moves along x.

    ``slider``: the block of a scene's document.

    Examples
    --------
    >>> motions_in_plane({"axis": [0, 0]}), motions_in_plane({"freedom": "xy"}), motions_in_plane({})
    (('rotation_rpm',), ('velocity_m_per_s', 'lateral_velocity_m_per_s'), ())
    """
    if "axis" in slider:
        return ("rotation_rpm",)
    freedom = slider.get("freedom", "x")
    along = ("velocity_m_per_s", "lateral_velocity_m_per_s") if freedom != "x" else ()
    return (*along, "rotation_rpm") if freedom == "xy yaw" else along


def amplitudes(driven: Contact) -> Point:
    """Return the amplitudes at a point and, for a stator, the driven transducer's admittance and the sources' power."""
    point, solved = driven.amplitudes_at(driven.level), driven.solved
    if solved is None:
        return point
    return point | Point(
        frequency_Hz=solved.frequency, conductance_S=solved.admittance.real, susceptance_S=solved.admittance.imag,
        power_W=solved.power * driven.level**2,
    )  # fmt: skip


def requested_quantities(
    also, tolerance: float, driven: Contact, answer: PointAnswer, *, averaged: bool = False
) -> Point:
    """Return the quantities that the keywords in ``also`` (keys of ``ALSO``) request of an answer with a velocity.

    Forces and powers are totals over all contacts. ``averaged``: True computes the start-up by averaging wherever that
    is applicable, whatever its error.
    """
    if driven.scene.planar:
        from studies.solve.plane_quantities import plane_quantities

        return plane_quantities(also, tolerance, driven, answer)
    point = _ripple(driven, answer, tolerance) if "ripple" in also else Point()
    if driven.heavy and "limits" in also:
        if driven.level > 0.0:
            threshold, release = heavy_limits(driven)
            point |= Point(threshold_factor=threshold / driven.level, release_factor=release / driven.level)
        if not set(also) - {"limits", "ripple"}:
            return point
    slider, orbits, known = driven.slider, driven.at(driven.level), answer.point
    limited = {"limits", "pressure"} & set(also) and not driven.passing
    threshold = contact.threshold_factor(slider, orbits) if limited else 0.0
    if "limits" in also and limited:
        point |= Point(threshold_factor=threshold, release_factor=contact.release_factor(slider, orbits))
    if "pressure" in also:
        own = Point(contact_pressure_Pa=known.contact_pressure_Pa)
        point |= contact_load(slider, orbits, threshold) if limited else own
    with suppress(contact.ConvergenceError):
        if "step" in also:
            point |= Point(step_m=abs(contact.step(driven.moving_slider, orbits, cycles=1).displacement))
    if not {"thrust", "efficiency", "start-up"} & set(also):
        return point
    # `driven.slider` is one of `share` equal parts of the slider
    share, thrust = driven.scene.slider.share, answer.thrust
    try:
        thrust = _thrust(slider, orbits, known.velocity_m_per_s) if thrust is None else thrust
    except contact.ConvergenceError:
        return point  # start-up and efficiency need the thrust
    point |= Point(thrust_N=thrust * share)
    # each is suppressed separately, so that one is returned where the other has no answer
    if "start-up" in also:
        with suppress(contact.ConvergenceError):
            final = abs(answer.point.velocity_m_per_s)
            time = start_up_time(driven.moving_slider, orbits, final, thrust, tolerance, averaged=averaged)
            point |= Point(start_up_time_s=time)
    if "efficiency" in also:
        with suppress(contact.ConvergenceError):
            power_out, efficiency = half_thrust(slider, orbits, thrust, tolerance)
            point |= _efficiencies(driven, power_out * share, efficiency)
    return point


def _thrust(slider, orbits, velocity: float) -> float:
    """Return the blocked thrust in N; 0 where the wave does not move the slider."""
    passes_in_vain = isinstance(orbits, contact.PassingWave) and velocity == 0.0
    return 0.0 if passes_in_vain else max(contact.blocked_thrust(slider, orbits)[0], 0.0)


def _ripple(driven: Contact, answer: PointAnswer, tolerance: float) -> Point:
    """Return mean and range of the velocity over half a wavelength; along a prescribed wave all places are alike."""
    if driven.solved is None or (driven.passing and driven.level == 0.0):
        return _alike(answer.point)
    if driven.passing:
        with suppress(contact.ConvergenceError):
            point, size = wave_ripple_point(driven, driven.level, answer.point, tolerance)
            return point | Point(velocity_ripple=size)
        return Point()
    nearby, level = NearbyContact.of(driven, tolerance), driven.level
    share = answer.point.relative_error / driven.stator_error if driven.stator_error else 0.0
    found = {} if nearby is None else ripples(nearby, {level: Known(answer.point.velocity_m_per_s, share)})
    if level not in found:
        return Point()
    point, size = ripple_point(found[level], driven.at(level))
    return point | Point(velocity_ripple=size)


def _alike(point: Point) -> Point:
    """Return the columns of the keyword ripple where all places are alike."""
    velocity = point.velocity_m_per_s
    return Point(
        mean_velocity_m_per_s=velocity, lowest_velocity_m_per_s=velocity, highest_velocity_m_per_s=velocity,
        mean_velocity_relative_error=point.relative_error, velocity_ripple=0.0,
    )  # fmt: skip


def _efficiencies(driven: Contact, power: float, efficiency: float) -> Point:
    """Return the efficiency of the contact and that of the motor: mechanical ``power`` in W over that of the source."""
    solved = driven.solved
    electrical = 0.0 if solved is None else source_power(driven.scene.drive, solved) * driven.level**2
    return Point(contact_efficiency=efficiency, motor_efficiency=power / electrical if electrical > 0.0 else None)


def half_thrust(slider, orbits: tuple, thrust: float, tolerance: float) -> tuple[float, float]:
    """Return the mechanical power in W under half of the blocked ``thrust`` (N), and its ratio to the wave's power."""
    if not thrust > 0.0:
        return 0.0, 0.0
    state = contact.steady(replace(slider, load=0.5 * thrust), orbits, tolerance=tolerance)
    wave = orbits if isinstance(orbits, contact.PassingWave) else orbits[0]
    power_out, power_in = 0.5 * thrust * abs(state.velocity), state.ledger.wave * wave.frequency
    return power_out, power_out / power_in if power_in > 0.0 else 0.0


def refuse_of_pillars(also: Iterable[str]) -> None:
    """Raise a SceneError for a keyword of ``ALSO`` that has no answer for a slider on pillars."""
    refuse_outside(also, OF_PILLARS, "also", " for a slider on pillars")


def start_up_time(
    slider: "contact.Slider", orbits: tuple, final: float, thrust: float, tolerance: float, *, averaged: bool = False
) -> float | None:
    """Return the time in s from rest to 63 % of the steady velocity ``final``, or None if the burst does not reach it.

    The burst is four times as long as the blocked ``thrust`` less the load would need to reach ``final``. ``averaged``
    is for differences between nearly equal times: the error of averaging cancels, and the exact motion takes 100 times
    as long to compute.
    """
    from scipy.interpolate import CubicSpline

    force = thrust - slider.load
    if not (final > 0.0 and force > 0.0):
        return None
    duration = 4.0 * slider.mass * final / force
    options: dict[str, Any] = {"duration": duration, "after": 0.0, "tolerance": tolerance, "samples": 400}
    if isinstance(orbits, contact.PassingWave):
        averaged, options = False, options | {"method": QUASI_STATIC}
    else:
        options["method"] = "averaged" if averaged else "auto"
    try:
        motion = contact.burst(slider, orbits, **options)
    except contact.ConvergenceError:
        if not averaged:
            raise
        motion = contact.burst(slider, orbits, **options | {"method": "auto"})
    excess = CubicSpline(motion.time, np.abs(motion.velocity) / final - RISE)
    times = [root for root in excess.roots(extrapolate=False) if root > 0.0]
    return float(times[0]) if times else None
