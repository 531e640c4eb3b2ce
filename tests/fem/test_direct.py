"""What the brute-force check refuses; its numbers are compared in test_solution."""

import sys
from types import ModuleType

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from fem.discretize.element_sizes import Resolution
from fem.materials.christoffel import slowest_wavelength
from tests.fem.direct import direct_solution, sparse_solution
from tests.fem.stators import FREQUENCY, comb, cut, plate


def solve(stator):
    return direct_solution(
        stator,
        (comb(stator, "a", 1.0),),
        frequency=FREQUENCY,
        resolution=Resolution(order=2, edge_layers=0),
        wavelength=slowest_wavelength(stator.solid, FREQUENCY),
    )


@pytest.mark.parametrize("rest", [{"bottom": "absorbing"}, {"thickness": np.inf}, {"above": "vacuum"}])
def test_only_real_bottoms(rest):
    with pytest.raises(ValueError, match="takes a stator with a real bottom, nothing above and no meshed pieces"):
        solve(plate(cut("PZT-4", "Z"), length=2.0, **rest))


class OtherSolver:
    """A solver of pypardiso without the private method that is used here."""

    def __init__(self, **given):
        pass


@pytest.mark.parametrize("pardiso", ["as installed", "not installed", "without MKL", "another interface"])
def test_sparse_solution(pardiso, monkeypatch):
    """Complex symmetric, several right-hand sides; SuperLU serves where Pardiso cannot."""
    if pardiso == "not installed":
        monkeypatch.setitem(sys.modules, "pypardiso", None)
    elif pardiso != "as installed":
        stub = ModuleType("pypardiso")
        if pardiso == "another interface":
            stub.PyPardisoSolver = OtherSolver
        monkeypatch.setitem(sys.modules, "pypardiso", stub)
    random = np.random.default_rng(2)
    dense = random.normal(size=(40, 40)) + 1j * random.normal(size=(40, 40))
    dense[abs(dense) < 1.0] = 0
    dense = dense + dense.T + 20 * np.eye(40)
    load = random.normal(size=(40, 3)) + 0j
    assert sparse_solution(csc_matrix(dense), load) == pytest.approx(np.linalg.solve(dense, load), rel=1e-10)


@pytest.mark.parametrize("bottom", ["free", "grounded"])
def test_admittances_are_symmetric(bottom):
    stator = plate(cut("PZT-4", "Z"), length=5.0, bottom=bottom)
    left, right = comb(stator, "a", 1.0), comb(stator, "b", 3.5)
    solution = direct_solution(
        stator,
        (left, right),
        frequency=FREQUENCY,
        resolution=Resolution(order=2, edge_layers=0),
        wavelength=slowest_wavelength(stator.solid, FREQUENCY),
    )
    matrix = solution.admittances
    assert matrix.shape == (2, 2)
    assert abs(matrix[0, 1]) > 1e-3 * abs(matrix[0, 0])
    assert abs(matrix[0, 1] - matrix[1, 0]) < 1e-12 * abs(matrix).max()
