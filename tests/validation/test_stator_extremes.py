"""The stator and the free wave at their extremes against strips of charge and Lamb's plates."""

import numpy as np
import pytest

import fem
from studies.evidence.stability.stator import TOLERANCE, VARIED, Motor, small_motor
from tests.fem.stators import constants
from tests.oracles.fem_lamb import surface_share, wavenumbers
from tests.oracles.fem_plate_response import PlateResponse
from tests.validation.strip_charges import StripCharges

FREQUENCY, YOUNG, DENSITY = 2.2e6, 70e9, 2700.0
# quantities of the stability study whose stators are infinite plates to their transducer
STRIPS = (
    "mechanical quality", "dielectric loss", "metallisation", "thickness", "length", "length, long", "finger pairs",
    "permittivity", "coupling",
)  # fmt: skip


def strips(motor: Motor) -> tuple[complex, np.ndarray]:
    """Admittance and motion by charges on the fingers of an infinite plate, exact partial waves."""
    solid = motor.stator.solid
    plate = PlateResponse(
        **constants(solid), thickness=motor.stator.thickness, frequency=motor.frequency,
    )  # fmt: skip
    (transducer,) = motor.transducers
    found = StripCharges(
        plate=plate, centers=transducer.fingers.mean(axis=1), half_width=transducer.finger_width / 2, terms=10
    )
    owner = np.array([int(sign == "-") for sign in transducer.signs])
    charges, coefficients = found.charges(owner, {0: 0.5, 1: -0.5})
    admittance = 2j * np.pi * motor.frequency * transducer.aperture * charges[0]
    return complex(admittance), found.motion(coefficients, motor.position)


def compare(motor: Motor) -> None:
    wave = motor.wave(TOLERANCE)
    admittance, motion = strips(motor)
    turn = np.exp(1j * np.angle(np.sum(np.conj(motion) * wave.motion(motor.position))))
    off = abs(wave.motion(motor.position) - turn * motion).max() / abs(motion).max()
    assert off < max(2 * wave.relative_error, TOLERANCE / 100)
    assert abs(wave.admittance / admittance - 1) < max(2 * wave.admittance_error, TOLERANCE / 100)


@pytest.mark.slow  # test_strip_charges.py has another small motor by default
def test_the_small_motor_is_that_of_the_strips():
    compare(small_motor())


@pytest.mark.slow
@pytest.mark.parametrize(("name", "value"), [(name, value) for name in STRIPS for value in VARIED[name][1]])
def test_an_extreme_stator_is_that_of_the_strips(name, value):
    compare(VARIED[name][2](value))


@pytest.mark.parametrize(
    ("poisson", "wavelengths", "tolerance"),
    [(0.3, 0.2, 1e-4), *(pytest.param(*each, marks=pytest.mark.slow) for each in (
        (-0.9, 10.0, 1e-4), (0.0, 10.0, 1e-4), (0.45, 10.0, 1e-4), (0.499, 10.0, 1e-4), (0.4999999, 10.0, 1e-4),
        (0.3, 0.1, 1e-4), (0.3, 0.5, 1e-4), (0.3, 1.0, 1e-4), (0.3, 5.0, 1e-4), (0.3, 20.0, 1e-4), (0.3, 50.0, 1e-4),
        (0.3, 2.5, 1e-4), (0.3, 2.5 * (1 + 1e-14), 1e-4), (0.3, 2.5 * (1 - 1e-9), 1e-4), (0.3, 2.5 * (1 + 1e-4), 1e-4),
        (0.3, 3.0, 1e-1), (0.3, 3.0, 1e-8), (0.3, 3.0, 1e-12),
    ))],
)  # fmt: skip
def test_the_free_wave_of_a_plate_solves_lamb_s_equations(poisson, wavelengths, tolerance):
    """Thickness in wavelengths of shear: at 2.5 of them a mode is at its cut-off."""
    mu = YOUNG / (2 * (1 + poisson))
    shear = np.sqrt(mu / DENSITY)
    longitudinal = shear * np.sqrt(2 * (1 - poisson) / (1 - 2 * poisson))
    solid = fem.isotropic(name="isotropic", youngs_modulus=YOUNG, poisson_ratio=poisson, density=DENSITY)
    depth = wavelengths * shear / FREQUENCY
    plate = fem.Stator(solid=solid, length=1.0, thickness=depth, ends="absorbing")
    try:
        wave = fem.free_wave(plate, frequency=FREQUENCY, tolerance=tolerance)
    except fem.ConvergenceError:
        assert tolerance < 1e-10 or poisson > 0.499  # refused, not wrong
        return
    omega, sizes = (2 * np.pi * FREQUENCY, {"longitudinal": longitudinal, "shear": shear, "half_thickness": depth / 2})
    pair = [wavenumbers(omega, symmetric=each, **sizes) for each in (True, False)]
    # two modes of nearly one velocity are one surface wave, of their mean by their shares at the surface
    last = [pair[0][-1], pair[1][-1]]
    share = [surface_share(k, omega, symmetric=each, **sizes) for k, each in zip(last, (True, False), strict=True)]
    known = np.concatenate([*pair, [np.average(last, weights=share)]])
    assert np.min(abs(wave.velocity * known / omega - 1)) < max(2 * wave.relative_error, tolerance / 100)
