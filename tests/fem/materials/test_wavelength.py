"""The slowest bulk wave against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from fem.materials import isotropic, material
from fem.materials.christoffel import slowest_wavelength


def test_isotropic_solid_has_its_shear_wave():
    solid = isotropic(name="glass", youngs_modulus=7.31e10, poisson_ratio=0.2, density=2203.0)
    assert slowest_wavelength(solid, 2e6) == pytest.approx(np.sqrt(7.31e10 / 2.4 / 2203.0) / 2e6, rel=1e-12)


def test_hexagonal_solid():
    """Along the axes quasi-shear sqrt(c44/rho); u_y, slower at sqrt(c66/rho) across, is not coupled."""
    solid = material("PZT-4")
    slowest = np.sqrt(solid.stiffness[3, 3] / solid.density)
    assert slowest_wavelength(solid, 1.0) <= slowest * (1 + 1e-12)
    softer = solid.stiffness.copy()
    softer[5, 5] *= 0.01
    assert slowest_wavelength(replace(solid, stiffness=softer), 1.0) == slowest_wavelength(solid, 1.0)
