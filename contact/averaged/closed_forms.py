r"""Steady states in closed form: no wave, no friction, a slider that follows a slow wave, and one dragged by its load.

*Carried.* If both contact resonances are far above the wave frequency, the slider follows the surface. The tangential
force, from m omega^2 |u_x|, R_t omega |u_x| and the load, must stay well below the friction limit. This limit is mu
times the preload less the normal force from m omega^2 |u_z| and R_n omega |u_z|.

*Dragged.* If the load exceeds the friction limit and pulls the slider faster than any surface motion, every contact
slips in the same direction all the time. <sum Q> then equals mu times the mean normal force of the springs, whatever
the bounce is, and v follows from the damper alone.
"""

import math

import numpy as np

from contact.averaged.riding import riding_height
from contact.exceptions import ConvergenceError
from contact.law.elastic import back_load
from contact.law.normal import load
from contact.orbit import as_orbits, drive_direction
from contact.roots import bracketed
from contact.slider import Slider

# A slider is carried if both resonances exceed FASTER times the wave frequency and the forces stay below INSIDE times
# their limits.
FASTER, INSIDE = 20.0, 0.5
# A slider is dragged if its speed exceeds the fastest surface motion this many times. The mean speed alone would need
# more than 1; the rest is a margin for the bounce, which varies the speed. It was not tuned.
DRAGGED_RATIO = 4.0


def closed_form(slider: Slider, orbits) -> dict | None:
    """Return a dictionary of velocity, regime, height and reason ("why"), or None if no closed form applies."""
    orbits = as_orbits(orbits)
    friction = slider.static_friction(len(orbits))
    still = orbits.still
    dragged = _dragged(slider, orbits)
    if not still and friction > 0.0 and not dragged:
        return _carried(slider, orbits)
    hold = slider.profile.hold
    if hold is not None and not still:
        return None  # without friction or preload: `averaged.adhesive_motion` refuses it
    height = slider.rest_approach(len(orbits)) if still else riding_height(slider, orbits)
    mean = height + slider.offsets(len(orbits))
    parted = bool(np.any(np.abs(mean) < orbits.normal_size))
    regime = "intermittent" if parted else "slip"
    if still:
        why, regime = "no wave", "stick" if slider.load <= friction else regime
    elif dragged:
        why = "dragged by the load"
    else:
        why = "no friction force" if slider.static_coefficient == 0.0 else "no preload"
    # the load drags the slider against the direction in which the wave drives
    velocity = -drive_direction(orbits) * _pulled(slider, len(orbits)) if slider.load > friction else 0.0
    return {"velocity": velocity, "regime": regime, "height": height, "why": why}


def _pulled(slider, contacts):
    """Return the speed in m/s of a slider whose load exceeds the friction limit."""
    friction = slider.static_friction(contacts)
    if slider.tangential_damping == 0.0:
        raise ConvergenceError(
            "runaway",
            f"a load of {slider.load:.6g} N exceeds the friction limit {friction:.6g} N and no tangential damping "
            "bounds the speed; lower slider.load or give slider.damping.tangential",
        )
    if slider.friction is not None and friction > 0.0:
        return _dragged_speed(slider, contacts)
    return (slider.load - _sliding(slider)) / slider.tangential_damping


def _sliding(slider):
    """Return mu times the mean elastic normal force of contacts that always slip, N."""
    friction = slider.friction_coefficient * slider.preload
    # the reciprocal force of a slipping contact is proportional to P and carries a part of the preload
    law = slider.profile
    share = back_load(1.0, 0.0, law) / load(1.0, law)
    back = share * slider.friction_coefficient * slider.slope_unit
    return friction / (1.0 + back) if slider.reciprocal and slider.law == "elastic" else friction


def _dragged_speed(slider, contacts):
    """Return the least speed in m/s at which damper and sliding friction carry the load, without a wave."""

    def net_force(speed):
        return slider.load - slider.tangential_damping * speed - slider.sliding_friction(contacts, speed)

    speeds = slider.load / slider.tangential_damping * np.linspace(0.0, 1.0, 400) ** 2
    falls = next(k for k, speed in enumerate(speeds) if net_force(speed) <= 0.0)
    return bracketed(net_force, speeds[falls - 1], speeds[falls])


def _dragged(slider, orbits):
    """Return True if the load pulls the slider so fast that no contact can stick."""
    if (
        slider.profile.pull > 0.0 or slider.profile.hold is not None
    ):  # the mean attraction depends on the part of the cycle in contact
        return False
    if slider.friction is not None:  # the sliding force depends on the wave, so that there is no closed form
        return False
    if slider.reciprocal and np.ptp(slider.limit_slope) > 0.0:  # so does then the reciprocal forces' share of the load
        return False
    surplus = slider.load - slider.friction_coefficient * slider.preload
    fastest = float(np.max(orbits.omega * (orbits.tangential_size + slider.slope_unit * orbits.normal_size)))
    return surplus > 0.0 and surplus > DRAGGED_RATIO * slider.tangential_damping * fastest and fastest > 0.0


def _carried(slider, orbits):
    """Return the steady state of a slider that follows a slow surface, or None if it does not follow."""
    contacts, omega, frequency = len(orbits), orbits.omega, orbits.frequency
    if slider.friction is not None and slider.tangential_law.bent:
        return None
    if slider.law != "elastic":  # an annulus slips under any change of force, which may move the slider
        return None
    resonance = min(slider.normal_resonance(contacts), slider.tangential_resonance(contacts))
    if resonance < FASTER * frequency or not orbits.alike or not slider.level:
        return None
    lift = math.hypot(slider.mass * omega**2, slider.normal_damping * omega) * orbits.normal_size[0]
    pull = math.hypot(slider.mass * omega**2, slider.tangential_damping * omega) * orbits.tangential_size[0]
    least_limit = slider.static_coefficient * (slider.preload - lift)
    if lift > INSIDE * slider.preload or pull + slider.load > INSIDE * least_limit:
        return None
    return {
        "velocity": 0.0, "regime": "stick", "height": slider.rest_approach(contacts),
        "why": f"carried along by a wave {resonance / frequency:.3g} times as slow as the contact",
    }  # fmt: skip
