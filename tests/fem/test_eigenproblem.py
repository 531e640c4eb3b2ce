"""Eigenpairs at k and -k together, against the companion problem of twice the size; modes of fine layers."""

import numpy as np

from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.eigenproblem import companion_modes, even_odd_modes, opposite_modes
from tests.fem.stators import FREQUENCY, cut, plate


def test_opposite_modes_are_those_of_the_companion_problem():
    rng = np.random.default_rng(3)
    second, zeroth, skew = rng.normal(size=(3, 9, 9)) + 0.3j * rng.normal(size=(3, 9, 9))
    second, zeroth, skew = second @ second.T + 9 * np.eye(9), 40 * (zeroth + zeroth.T), skew - skew.T
    found, shapes = opposite_modes(second, skew, zeroth)
    expected, _ = companion_modes(second, skew, zeroth)
    np.testing.assert_array_equal(found[:9], -found[9:])
    nearest = abs(np.subtract.outer(expected, found)).argmin(axis=1)
    assert sorted(nearest) == list(range(18))
    np.testing.assert_allclose(found[nearest], expected, rtol=1e-9)
    left = second @ shapes * found**2 + skew @ shapes * found + zeroth @ shapes
    assert abs(left).max() < 1e-9 * abs(zeroth @ shapes).max()


def test_fast_decaying_modes_of_fine_layers_are_right_to_many_digits():
    """Each mode of a section with four edge layers leaves a small part of its own terms, in scaled unknowns."""
    stator = plate(cut("PZT-4", "Z"), thickness=0.9)
    layers = Resolution(order=8, edge_layers=4)
    section = discretise(stator, layers, wavelength=stator.slowest_wavelength(FREQUENCY), surface_scale=1e-4)
    second, first, zeroth = section.matrices(FREQUENCY)
    wavenumbers, shapes = even_odd_modes(second, first - first.T, zeroth, section.odd)
    assert abs(wavenumbers).max() > 1e6  # radians per wavelength
    fast = abs(wavenumbers) > 1e3
    squared, mixed = second @ shapes * wavenumbers**2, 1j * (first - first.T) @ shapes * wavenumbers
    scale = 1 / np.sqrt(abs(np.diag(second)))[:, None]
    left, size = (abs(scale * each).max(axis=0)[fast] for each in (squared + mixed + zeroth @ shapes, squared))
    assert len(size) > 50
    assert np.median(left / size) < 3e-10
