"""Elements of the vacuum: the charge that they carry, against eps_0 |k|, and the reach of a plate's static field."""

import numpy as np
import pytest
from scipy.integrate import quad

from fem.discretize.mesh_refinement import LEVELS
from fem.discretize.spectral import reference_matrices
from fem.discretize.vacuum import GROWTH, LAST_ALONG, needed_height, plate_reach
from fem.geometry import Stator
from fem.materials import VACUUM_PERMITTIVITY, fields
from fem.materials.medium import medium
from tests.fem.stators import FREQUENCY, cut, plate, section

PLATE = plate(cut("PZT-4", "Z"), above="vacuum", thickness=0.4)


def charge(depth, k: float) -> float:
    """Charge over potential at the surface by the elements above it, over the permittivity of vacuum."""
    first, order, line = depth.surface // depth.order, depth.order, reference_matrices(depth.order)
    media = depth.media[first:]
    size = len(media) * order + 1
    matrix, unit = np.zeros((size, size)), media[0].zz[0, 0]
    for number, (height, part) in enumerate(zip(depth.heights[first:].real, media, strict=True)):
        here = slice(number * order, (number + 1) * order + 1)
        across, along = part.zz[0, 0] / unit, part.xx[0, 0] / unit
        matrix[here, here] += across * line.stiffness / height + along * k**2 * height * line.mass
    return float(matrix[0, 0] - matrix[0, 1:] @ np.linalg.solve(matrix[1:, 1:], matrix[1:, 0]))


@pytest.mark.parametrize(("level", "error"), [(0, 2e-5), (1, 1e-6), (2, 1e-7)])
def test_charge_is_that_of_the_vacuum(level, error):
    """eps_0 |k| over four decades, from 20 over the height to twice the wavenumber of the slowest wave."""
    depth = section(PLATE, order=LEVELS[level].order, layers=LEVELS[level].edge_layers)
    for k in np.geomspace(80 / depth.breakpoints[-1], 4 * np.pi, 25):
        assert charge(depth, k) == pytest.approx(k, rel=error)


def test_last_element_ends_the_static_field_of_a_dipole():
    """The integral of k^2 / Y - k is 0; with Y = k tanh(k H), of a column of vacuum alone, it is pi^2 / 12 H^2."""
    index = np.sqrt(LAST_ALONG)

    def integrand(k, index):
        below, last = np.tanh(k), np.tanh(k * (GROWTH - 1) * index)  # heights in that below the last element
        return k * ((1 + index * below * last) / (below + index * last) - 1)

    column, ours = (quad(integrand, 1e-9, 30.0, args=(each,), limit=200)[0] for each in (1.0, index))
    assert column == pytest.approx(np.pi**2 / 12 / GROWTH**2, rel=1e-7)
    assert abs(ours) < 1e-8


@pytest.mark.parametrize("bottom", ["free", "clamped"])
@pytest.mark.parametrize("orientation", ["X", "Z", (10.0, 20.0, 30.0)])
def test_reach_is_the_permittivity_along_the_plate(bottom, orientation):
    """Against the section: phi = x and its effect w through the depth, K0 w = -K1^T c; flux c^T (K2 c + K1 w)."""
    solid = cut("LiNbO3 (Kovacs)", orientation, quality=80.0)
    stator = plate(solid, thickness=0.37, bottom=bottom)
    depth = section(stator, order=9)
    second, first, zeroth = depth.matrices(FREQUENCY)
    constant = depth.constant_potential
    own = np.linalg.lstsq(zeroth, -first.T @ constant, rcond=None)[0]
    flux = constant @ (second @ constant + first @ own) * depth.solid.stress_unit / depth.solid.potential_unit**2
    static = medium(solid, fields(solid))
    schur = static.xx[-1, -1] - static.xz[-1] @ np.linalg.solve(static.zz, static.xz[-1])
    at_rest = schur * 0.37 * depth.solid.stress_unit / depth.solid.potential_unit**2
    expected = max(abs(flux), abs(at_rest)) / VACUUM_PERMITTIVITY
    assert plate_reach(stator, static, depth.length_unit, stator.thickness) == pytest.approx(expected, rel=1e-7)


def test_height_is_part_of_the_refinement():
    solid = PLATE.solid
    heights = [needed_height(PLATE, [medium(solid, fields(solid))], level, 1e-3)[0] for level in LEVELS]
    assert np.diff(np.log2(heights)) == pytest.approx(np.ones(5))
    closed = Stator(solid=solid, length=0.05, thickness=1e-3, ends="free", above="vacuum")
    assert needed_height(closed, [medium(solid, fields(solid))], LEVELS[0], 1e-3) == (pytest.approx(200.0), True)
