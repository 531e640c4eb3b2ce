"""The charges of fingers on a plate against the capacitance of two strips in closed form."""

import numpy as np
import pytest
from scipy.special import ellipk

from tests.oracles.fem_charged_plate import VACUUM, ChargedPlate
from tests.oracles.fem_plate_field import PlateField


@pytest.mark.parametrize("vacuum", [False, True])
def test_two_strips_on_a_thick_dielectric(vacuum):
    """Two strips of width w, s apart: eps / 2 K(k') / K(k), k = s / (s + 2 w), eps of both sides (Wen 1969)."""
    strip, gap, relative, frequency, thickness = 0.1e-3, 0.06e-3, 9.0, 1e6, 30e-3
    plate = PlateField(
        stiffness=(np.diag([3.0, 3.0, 3.0, 1.0, 1.0, 1.0]) + np.pad(np.ones((3, 3)), (0, 3))) * 3e10 * (1 + 0.02j),
        coupling=np.zeros((3, 6)),
        permittivity=np.eye(3) * relative * VACUUM + 0j,
        density=7000.0,
        thickness=thickness,
        frequency=frequency,
    )
    fingers = ChargedPlate(
        plate=plate,
        thickness=thickness,
        frequency=frequency,
        quality=50.0,
        slowest=4e3,
        centers=np.array([-1.0, 1.0]) * (strip + gap) / 2,
        half_width=strip / 2,
        signs="+-",
        vacuum=vacuum,
    )
    modulus = (gap / (gap + 2 * strip)) ** 2
    expected = (relative + vacuum) * VACUUM / 2 * ellipk(1 - modulus) / ellipk(modulus)
    charges = fingers.charges()
    assert charges[:, 0].real == pytest.approx(np.array([1, -1]) * expected, rel=2e-5)
    assert fingers.admittance(charges, 0.01).imag == pytest.approx(2 * np.pi * frequency * 0.01 * expected, rel=2e-5)
