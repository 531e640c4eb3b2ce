"""The seed's motor and its wave, for the tests of the contact."""

from contact import Orbit, Slider

SEED = {
    "radius": 1e-3,
    "mass": 0.089e-3,
    "preload": 0.089e-3 * 9.81,
    "load": 0.0,
    "friction_coefficient": 0.08,
    "effective_modulus": 64e9,
    "tangential_modulus": 12e9,
    "law": "elastic",
    "reciprocal": False,
    "stick_band": 0.0,
    "contact_damping": 0.0,
    "normal_damping": 0.5,
    "tangential_damping": 1e-4,
}
FREQUENCY = 2.2e6


def slider(**changed) -> Slider:
    """Return the seed's slider with one ball, some parameters changed."""
    return Slider(**(SEED | changed))


def orbit(amplitude: float, ratio: float = 0.7, frequency: float = FREQUENCY) -> Orbit:
    """Return the seed's orbit: quadrature, at the crest towards +x."""
    return Orbit(frequency=frequency, normal=amplitude, tangential=-1j * ratio * amplitude)
