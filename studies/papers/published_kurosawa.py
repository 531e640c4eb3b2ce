"""Kurosawa, Takahashi and Higuchi's motor in the model: a steel ball on the Rayleigh wave of 128YX lithium niobate.

Every function takes a case: the values of what the paper states loosely or not at all, by the names of `published`.
"""

import math
from dataclasses import replace

from scipy.optimize import brentq

import contact
import fem
from studies.papers.published import KUROSAWA, NORMAL_DAMPING, TANGENTIAL_OVER_NORMAL

TOLERANCE = 1e-3
STATOR_TOLERANCE = 3e-2


def ratio(material: str) -> float:
    """Return |u_x/u_z| of the Rayleigh wave on a 128YX half-space."""
    return fem.rayleigh(fem.rotated(fem.material(material), "128YX"), "open").surface_ratio


def ball(case: dict):
    """Return Kurosawa's ball and the orbit under it."""
    published = KUROSAWA.published
    slider = contact.Slider(
        radius=case.get("radius", published["radius_m"]), mass=case.get("mass", published["mass_kg"]),
        preload=case["preload"], load=0.0, friction_coefficient=case["friction"], effective_modulus=case["modulus"],
        tangential_modulus=TANGENTIAL_OVER_NORMAL * case["modulus"], law=case["law"], reciprocal=False, stick_band=0.0,
        contact_damping=0.0, normal_damping=NORMAL_DAMPING, tangential_damping=case["air"],
    )  # fmt: skip
    amplitude = case["amplitude"]
    orbit = contact.Orbit(frequency=case["frequency"], normal=amplitude, tangential=-1j * case["ratio"] * amplitude)
    return slider, orbit


def speed(case: dict) -> float:
    """Return the steady speed, m/s."""
    return abs(contact.steady(*ball(case), tolerance=TOLERANCE).velocity)


def thrust(case: dict) -> float:
    """Return the load at which the motor stalls, N."""
    return contact.blocked_thrust(*ball(case))[0]


def needed_amplitude(case: dict) -> float:
    """Return the normal amplitude in m at which the steady speed equals the published one."""
    wanted = KUROSAWA.published["velocity_m_per_s"]
    return brentq(lambda size: speed(case | {"amplitude": size}) - wanted, 3e-9, 1e-7, xtol=1e-11)


def contact_radius(case: dict) -> float:
    """Return a = pi p0 R / 2 E*, Hertz (Johnson 1985, eq. 4.22 to 4.24)."""
    published = KUROSAWA.published
    return math.pi * published["pressure_Pa"] * published["radius_m"] / (2 * case["modulus"])


def per_volt(*, pairs: int, material: str) -> float:
    """Return |u_z| in m per volt of a transducer with ``pairs`` finger pairs on a 128YX half-space."""
    solid = fem.rotated(fem.material(material), "128YX")
    frequency = KUROSAWA.published["frequency_Hz"]
    stator = fem.Stator(solid=solid, length=1.0, thickness=math.inf, ends="absorbing")
    row = fem.Transducer(name="driven", center=0.5, finger_pairs=pairs, period=1.0, metallisation=0.5, aperture=9e-3)
    period = fem.best_period(stator, row, frequency)
    length = (pairs + 20) * period
    stator = replace(stator, length=length)
    transducer = replace(row, period=period, center=(pairs / 2 + 2) * period)
    place = length - 5 * period
    wave = fem.driven_wave(
        stator, (transducer,), frequency=frequency, drive="driven", tolerance=STATOR_TOLERANCE, places=(place,)
    )
    return float(abs(wave.normal_at(place)))
