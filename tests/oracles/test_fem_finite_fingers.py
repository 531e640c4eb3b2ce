"""The oracle of fingers of finite length: against a published constant, another oracle, a dense system, and itself."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.fem_finite_fingers import VACUUM, Field, FiniteFingers, Pair, PlaneResponse
from tests.oracles.fem_plate_beam import plate_beam
from tests.oracles.fem_plate_response import PlateResponse

PERIOD = 0.99e-3
SHAPE = {"pitch": PERIOD / 2, "half_width": PERIOD / 8}


def plate(quality: float = 1000.0, loss: float = 0.004, thickness: float = 5e-3) -> PlateResponse:
    """Hard PZT (PZT-8, Berlincourt) poled along the normal, at 2.2 MHz."""
    stiffness, coupling = np.zeros((6, 6)), np.zeros((3, 6))
    stiffness[:3, :3] = [[146.9, 81.1, 81.1], [81.1, 146.9, 81.1], [81.1, 81.1, 131.7]]
    stiffness[[3, 4, 5], [3, 4, 5]] = 31.35, 31.35, (146.9 - 81.1) / 2
    coupling[2, :3], coupling[0, 4], coupling[1, 3] = (-3.88, -3.88, 13.91), 10.34, 10.34
    return PlateResponse(
        stiffness=stiffness * 1e9 * (1 + 1j / quality),
        coupling=coupling,
        permittivity=np.diag([904.0, 904.0, 562.0]) * VACUUM * (1 - 1j * loss),
        density=7600.0,
        thickness=thickness,
        frequency=2.2e6,
    )


def response(**given) -> PlaneResponse:
    return PlaneResponse(surface=plate(**given).surface, wavenumber=2 * np.pi * 2.2e6 / 2000.0)


def test_capacitance_of_a_square():
    """Oracle: 0.36678959 times 4 pi eps L in free space (Hwang and Mascagni, J. Appl. Phys. 95 (2004) 3798)."""

    def dielectric(k):
        return np.stack([0 * k, 0 * k, 1 / (2 * VACUUM * k)], axis=1)

    side, both = 0.01, {"half_width": 0.005, "half_length": 0.005}
    free = PlaneResponse(surface=dielectric, wavenumber=2 / side)
    square = FiniteFingers(response=free, count=1, pitch=1.0, across=9, along=5, panel=60.0, depth=30.0, **both)
    size = square.size
    matrix = square.blocks[0, :, :].transpose(0, 2, 1, 3).reshape(size, size)
    unit = np.eye(size)[0]
    charge = np.linalg.solve(matrix / abs(matrix).max(), unit)[0] / abs(matrix).max()
    assert charge == pytest.approx(0.36678959 * 4 * np.pi * VACUUM * side, rel=3e-4)


@pytest.mark.slow
def test_hankel_functions_of_a_rational_response():
    """Oracle: the sum over the plane of real wave vectors (fem_plate_beam.py), which finds no poles."""
    lossy = {"quality": 40.0, "loss": 0.02, "thickness": 2e-3}
    length, places = 3e-3, np.array([[6e-3, 1e-3], [9e-3, 4e-3]])
    expected = plate_beam(plate(**lossy).surface, 7000.0, np.zeros(2), np.array([1.0, 0.5]), length, places)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    charges = 1.5 * weights * length / 2
    field = Field(response(**lossy), 3e-3, 12e-3)
    found = field.motion(*places.T, np.zeros(24), nodes * length / 2, charges)[:3]
    np.testing.assert_allclose(found, expected, atol=1e-4 * abs(expected[2]).max())


@pytest.mark.slow
def test_functions_and_paths_change_nothing():
    """Fingers of 3 mm: all numbers of the method moved at once."""
    base = FiniteFingers(response=response(), count=4, half_length=1.5e-3, across=3, along=16, **SHAPE)
    finer = replace(base, across=4, along=24, points=12, depth=150.0, smoothing=1.3, highest=11.0, longest=30.0)
    volts, together = [0.5, -0.5, 0.5, -0.5], np.ones((1, 4))
    one, other = (each.charges(each.constant(volts), together) for each in (base, finer))
    net = other[:, 0, 0]
    np.testing.assert_allclose(one[:, 0, 0], net, atol=5e-5 * abs(net).max())
    x, y, places = np.array([0.01, 0.03, 0.03]), np.array([0.0, 0.0, 0.003]), (2e-3, 0.04)
    wider = PlaneResponse(surface=plate().surface, wavenumber=1.15 * base.response.wavenumber)
    found = Field(base.response, *places).motion(x, y, *base.point_charges(one))
    expected = Field(wider, *places, step=1e-5).motion(x, y, *finer.point_charges(other))
    assert (abs(found - expected)[:3] / abs(expected[2])).max() < 1e-4


@pytest.mark.slow
def test_two_transducers_as_one_row_with_fingers_left_out():
    """Coupling by Hankel functions against the dense system of both, whose blocks are integrals over wavenumbers."""
    row = FiniteFingers(response=response(), count=12, half_length=1e-3, across=2, along=8, **SHAPE)
    pair = replace(row, count=2)
    places, size = np.array([0, 1, 10, 11]), row.size
    own = (-1.0) ** np.arange(row.across)
    matrix = np.empty((4, size, 4, size), dtype=complex)
    for i, j in np.ndindex(4, 4):
        apart = places[i] - places[j]
        block = row.blocks[abs(apart)] * (np.outer(own, own)[:, :, None, None] if apart < 0 else 1.0)
        matrix[i, :, j] = block.transpose(0, 2, 1, 3).reshape(size, size)
    matrix = matrix.reshape(4 * size, 4 * size)
    loads = np.zeros((4, size, 3))  # potentials, then units on both transducers, the second short-circuited
    loads[:2, 0, 0] = 0.5, -0.5
    loads[[0, 1, 2, 3], 0, [1, 1, 2, 2]] = 1.0
    loads = loads.reshape(4 * size, 3)
    solved = np.linalg.solve(matrix / abs(matrix).max(), loads) / abs(matrix).max()
    constraint = loads[:, 1:].T
    lift = np.linalg.solve(constraint @ solved[:, 1:], constraint @ solved[:, 0])
    expected = (solved[:, 0] - solved[:, 1:] @ lift).reshape(4, row.across, row.along)[:, 0, 0]
    coupled = Pair(pair, Field(row.response, 2e-3, 8e-3), 10 * SHAPE["pitch"], 40)
    charges = np.concatenate(coupled.charges([0.5, -0.5], np.ones((1, 2))))[:, 0, 0]
    np.testing.assert_allclose(charges[:2], expected[:2], rtol=1e-6)
    np.testing.assert_allclose(charges[2:], expected[2:], rtol=5e-4)  # the near field is faded out: 2e-4
