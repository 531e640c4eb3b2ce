"""The oracle of plate modes against limits that have closed forms."""

import numpy as np
import pytest

from tests.oracles.fem_isotropic_rayleigh import velocity_over_shear
from tests.oracles.fem_lamb import determinant, group_velocity, wavenumbers

NU = 0.31
SHEAR = 3130.0
LONGITUDINAL = SHEAR * np.sqrt(2 * (1 - NU) / (1 - 2 * NU))
H = 0.7e-3
PLATE = {"longitudinal": LONGITUDINAL, "shear": SHEAR, "half_thickness": H}


def test_long_waves_stretch_the_plate():
    """S0: c^2 = E/(rho (1 - nu^2)) = 4 c_S^2 (1 - c_S^2/c_L^2), corrections (k h)^2."""
    omega = 0.002 * SHEAR / H
    (k,) = wavenumbers(omega, symmetric=True, **PLATE)
    assert omega / k == pytest.approx(2 * SHEAR * np.sqrt(1 - (SHEAR / LONGITUDINAL) ** 2), rel=1e-6)


def test_long_waves_bend_the_plate():
    """A0: omega = k^2 h c_plate/sqrt(3), corrections (k h)^2; its group velocity is twice the phase velocity."""
    plate_speed = 2 * SHEAR * np.sqrt(1 - (SHEAR / LONGITUDINAL) ** 2)
    omega = 1e-5 * SHEAR / H
    (k,) = wavenumbers(omega, symmetric=False, **PLATE)
    assert omega == pytest.approx(k**2 * H * plate_speed / np.sqrt(3), rel=1e-4)
    faster = 1e-3 * SHEAR / H
    (k,) = wavenumbers(faster, symmetric=False, **PLATE)
    assert group_velocity(k, faster, symmetric=False, **PLATE) == pytest.approx(2 * faster / k, rel=4e-3)


def test_short_waves_are_rayleigh_waves():
    omega = 25.0 * SHEAR / H
    for symmetric in (True, False):
        k = wavenumbers(omega, symmetric=symmetric, **PLATE)
        assert omega / k[-1] == pytest.approx(velocity_over_shear(NU) * SHEAR, rel=1e-6)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_lame_modes(number):
    """Equivoluminal plane waves at 45 degrees: omega = sqrt(2) c_S k with k h = (n + 1/2) pi, symmetric."""
    k = (number + 0.5) * np.pi / H
    roots = wavenumbers(np.sqrt(2) * SHEAR * k, symmetric=True, **PLATE)
    assert np.abs(roots / k - 1).min() < 1e-12


def test_first_symmetric_mode_starts_backwards():
    """Between the minimum of S1 and the longitudinal cut-off of S2, two S roots more, one of them backward."""
    cut_off = np.pi * SHEAR / H  # S1-S2: shear c_S/h at k = 0, for c_L < 2 c_S
    below = 0.985 * np.pi / 2 * LONGITUDINAL / H
    omega = min(cut_off, below)
    speeds = [group_velocity(k, omega, symmetric=True, **PLATE) for k in wavenumbers(omega, symmetric=True, **PLATE)]
    assert sum(speed < 0 for speed in speeds) == 1
    assert sum(speed > 0 for speed in speeds) == 2


def test_roots_are_roots():
    omega = 6.2 * SHEAR / H
    for symmetric in (True, False):
        for k in wavenumbers(omega, symmetric=symmetric, **PLATE):
            around = determinant(k * np.array([1 - 1e-4, 1, 1 + 1e-4]), omega, symmetric=symmetric, **PLATE)
            assert abs(around[1]) < 1e-8 * np.abs(around[[0, 2]]).min()
            assert around[0] * around[2] < 0
