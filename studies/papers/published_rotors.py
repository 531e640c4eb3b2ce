"""Published rotors in the model: a sphere that rolls in place, and rings of contacts about an axle over beams.

Every function takes a case: the inputs of one prediction by the names of ``published_motors.toml``, in SI units.  The
rotors are heavy, and their contacts stand on a ring of `CONTACTS`, which a ring of many approaches.
"""

import math

import numpy as np

import contact
from contact import plane

CONTACTS = 8  # of a ring, none on the line between the beams
TOLERANCE = 1e-2
PER_MINUTE = 60.0 / (2.0 * math.pi)
TANGENTIAL_OVER_NORMAL = 12.0 / 64.0  # G*/E* of steel on hard PZT (Feenstra and Breedveld); 0.21 on lithium niobate


def rolling_speed(case: dict) -> float:
    """Return the speed in turns per minute of a sphere that the wave below it turns about a horizontal axis."""
    ball = _slider(case, load=0.0)
    orbit = contact.Orbit(
        frequency=case["frequency"], normal=case["amplitude"], tangential=-1j * case["ratio"] * case["amplitude"]
    )
    speed = abs(contact.steady(ball, orbit, tolerance=TOLERANCE, method="averaged").velocity)
    return PER_MINUTE * speed / case["radius"]


def rotor_speed(case: dict) -> float:
    """Return the speed in turns per minute of a ring of contacts over two beams that run against each other.

    With ``beams = "one"`` the other half of the ring stands on a surface at rest.
    """
    return PER_MINUTE * abs(_turning(case).yaw_rate)


def run_up_time(case: dict) -> float:
    """Return the time in s in which the stall torque would give the rotor its steady speed: the least of its run-up."""
    rotor, waves = _ring(case)
    torque = abs(plane.stall_torque(rotor, waves).value)
    return case["mass"] * case["arm"] ** 2 * abs(_turning(case).yaw_rate) / torque


def _turning(case: dict) -> plane.PlaneState:
    return plane.steady(*_ring(case), tolerance=TOLERANCE, method="averaged")


def _ring(case: dict) -> tuple[contact.Slider, plane.SurfaceWaves]:
    """Return the rotor and the waves under its contacts."""
    angle = 2.0 * math.pi * (np.arange(CONTACTS) + 0.5) / CONTACTS
    x, y = case["arm"] * np.cos(angle), case["arm"] * np.sin(angle)
    rotor = _slider(case, x=x, y=y, freedom="axle", load=(0.0, 0.0))
    drives = np.where(y > 0.0, -1.0, 1.0 if case["beams"] == "two" else 0.0)
    amplitudes = np.zeros((1, CONTACTS, 3), complex)
    amplitudes[0, :, 0] = -1j * case["ratio"] * case["amplitude"] * drives
    amplitudes[0, :, 2] = case["amplitude"] * np.abs(drives)
    return rotor, plane.SurfaceWaves(frequencies=[case["frequency"]], amplitudes=amplitudes)


def _slider(case: dict, **own) -> contact.Slider:
    return contact.Slider(
        radius=case["radius"], mass=math.inf, preload=case["preload"], friction_coefficient=case["friction"],
        effective_modulus=case["modulus"], tangential_modulus=TANGENTIAL_OVER_NORMAL * case["modulus"], law="elastic",
        reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, **own,
    )  # fmt: skip
