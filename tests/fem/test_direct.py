"""What the brute-force check refuses; its numbers are compared in test_solution."""

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from fem.direct import direct_solution, sparse_solution
from fem.discretize.grading import Resolution
from fem.materials.christoffel import slowest_wavelength
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
    with pytest.raises(ValueError, match="takes a stator with a real bottom and nothing above"):
        solve(plate(cut("PZT-4", "Z"), length=2.0, **rest))


def test_sparse_solution():
    """Complex symmetric, several right-hand sides."""
    random = np.random.default_rng(2)
    dense = random.normal(size=(40, 40)) + 1j * random.normal(size=(40, 40))
    dense[abs(dense) < 1.0] = 0
    dense = dense + dense.T + 20 * np.eye(40)
    load = random.normal(size=(40, 3)) + 0j
    assert sparse_solution(csc_matrix(dense), load) == pytest.approx(np.linalg.solve(dense, load), rel=1e-10)


def test_charges_are_symmetric():
    solution = solve(plate(cut("PZT-4", "Z"), length=2.0))
    stator = plate(cut("PZT-4", "Z"), length=3.0, bottom="grounded")
    grounded = solve(stator)
    assert solution.charges.shape == (1, 1)
    assert grounded.charges.shape == (2, 2)
    assert np.abs(grounded.charges - grounded.charges.T).max() < 1e-12 * np.abs(grounded.charges).max()
