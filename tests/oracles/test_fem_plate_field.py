"""The oracle of a plate of any cut against the one of ceramics poled along the normal."""

import numpy as np

from tests.fem.stators import constants, cut
from tests.oracles.fem_plate_field import PlateField
from tests.oracles.fem_plate_response import PlateResponse


def test_response_in_all_directions_of_an_isotropic_plane():
    solid = cut("PZT-8", "Z", quality=60.0)
    constants = {
        "stiffness": solid.stiffness_lossy,
        "coupling": solid.coupling,
        "permittivity": solid.permittivity_lossy,
        "density": solid.density,
        "thickness": 1.3e-3,
        "frequency": 2.3e6,
    }
    k, angle = np.linspace(100.0, 15000.0, 9), 0.6
    expected = PlateResponse(**constants).surface(k)
    found = PlateField(**constants).response(k * np.cos(angle), k * np.sin(angle))
    along = found[:, 0] * np.cos(angle) + found[:, 1] * np.sin(angle)
    np.testing.assert_allclose(np.stack([along, found[:, 2], found[:, 3]], axis=1), expected, rtol=1e-11)
    across = found[:, 1] * np.cos(angle) - found[:, 0] * np.sin(angle)
    assert abs(across).max() < 1e-12 * abs(along).max()


def test_reciprocity_in_a_cut_without_symmetry():
    """The potential of a charge is the same at -k: G(-k) = G(k)^T."""
    solid = cut("LiNbO3 (Kovacs)", (10, 35, 20), quality=40.0)
    field = PlateField(**constants(solid), thickness=1e-3, frequency=5e6)
    kx, ky = np.array([3e3, -5e3, 7e3]), np.array([1e3, 4e3, -2e3])
    np.testing.assert_allclose(field.response(kx, ky)[:, 3], field.response(-kx, -ky)[:, 3], rtol=1e-9)
