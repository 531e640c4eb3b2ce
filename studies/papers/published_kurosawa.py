"""Kurosawa, Takahashi and Higuchi's motor in the model: a steel ball on the Rayleigh wave of 128YX lithium niobate.

Every function takes a case: the inputs of one prediction by the names of ``published_motors.toml``, in SI units.
"""

import math
from dataclasses import replace
from functools import cache

from scipy.optimize import brentq

import contact
import fem

TOLERANCE = 1e-3
STATOR_TOLERANCE = 3e-2
APERTURE = 9e-3  # m
TANGENTIAL_OVER_NORMAL = 0.21  # G*/E* of steel on lithium niobate
NORMAL_DAMPING = 0.16  # N s/m: damps the bounce of the start and hardly changes the steady speed


@cache
def surface_ratio(material: str) -> float:
    """Return |u_x/u_z| of the Rayleigh wave on a 128YX half-space."""
    return fem.rayleigh(fem.rotated(fem.material(material), "128YX"), "open").surface_ratio


def ball(case: dict) -> tuple[contact.Slider, contact.Orbit]:
    """Return the ball and the orbit under it."""
    slider = contact.Slider(
        radius=case["radius"], mass=case["mass"], preload=case["preload"], load=0.0,
        friction_coefficient=case["friction"], effective_modulus=case["modulus"],
        tangential_modulus=TANGENTIAL_OVER_NORMAL * case["modulus"], law=case["law"], reciprocal=False, stick_band=0.0,
        contact_damping=0.0, normal_damping=NORMAL_DAMPING, tangential_damping=case["air"],
    )  # fmt: skip
    normal, ratio = case["amplitude"], surface_ratio(case["wave_material"])
    return slider, contact.Orbit(frequency=case["frequency"], normal=normal, tangential=-1j * ratio * normal)


def speed(case: dict) -> float:
    """Return the steady speed, m/s."""
    return abs(contact.steady(*ball(case), tolerance=TOLERANCE).velocity)


def surface_speed(case: dict) -> float:
    """Return the largest speed of the surface along x, m/s."""
    return 2 * math.pi * case["frequency"] * surface_ratio(case["wave_material"]) * case["amplitude"]


def thrust(case: dict) -> float:
    """Return the load at which the motor stalls, N."""
    return contact.blocked_thrust(*ball(case))[0]


def needed_amplitude(case: dict) -> float:
    """Return the normal amplitude in m at which the steady speed is ``velocity``."""
    return brentq(lambda size: speed(case | {"amplitude": size}) - case["velocity"], 3e-9, 1e-7, xtol=1e-11)


def contact_radius(case: dict) -> float:
    """Return a = pi p0 R / 2 E*, Hertz (Johnson 1985, eq. 4.22 to 4.24)."""
    return math.pi * case["pressure"] * case["radius"] / (2 * case["modulus"])


def driven_amplitude(case: dict) -> float:
    """Return |u_z| in m that the voltage gives."""
    return case["voltage"] * per_volt(case["pairs"], case["material"], case["nominal_frequency"])


@cache
def per_volt(pairs: int, material: str, frequency: float) -> float:
    """Return |u_z| in m per volt of a transducer with ``pairs`` finger pairs on a 128YX half-space."""
    solid = fem.rotated(fem.material(material), "128YX")
    stator = fem.Stator(solid=solid, length=1.0, thickness=math.inf, ends="absorbing")
    transducer = fem.Transducer(
        name="driven", center=0.5, finger_pairs=pairs, period=1.0, metallisation=0.5, aperture=APERTURE
    )
    period = fem.best_period(stator, transducer, frequency)
    length = (pairs + 20) * period
    stator = replace(stator, length=length)
    transducer = replace(transducer, period=period, center=(pairs / 2 + 2) * period)
    x = length - 5 * period
    wave = fem.driven_wave(
        stator, (transducer,), frequency=frequency, drive="driven", tolerance=STATOR_TOLERANCE, places=(x,)
    )
    return float(abs(wave.normal_at(x)))
