"""Line elements against closed forms: nodes, basis, and integrals of polynomials."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial, legendre

from fem.discretize.spectral import gll_nodes, lagrange, reference_matrices

ORDERS = (1, 2, 3, 4, 5, 8, 13, 20)


@pytest.mark.parametrize(
    ("order", "inner"),
    [
        (1, []),
        (2, [0.0]),
        (3, [-np.sqrt(1 / 5), np.sqrt(1 / 5)]),
        (4, [-np.sqrt(3 / 7), 0.0, np.sqrt(3 / 7)]),
        (
            5,
            [sign * np.sqrt((7 + other * 2 * np.sqrt(7)) / 21) for sign, other in ((-1, 1), (-1, -1), (1, -1), (1, 1))],
        ),
    ],
)
def test_nodes_have_their_closed_forms(order, inner):
    """Abramowitz and Stegun, table 25.6."""
    expected = (np.array([-1.0, *inner, 1.0]) + 1) / 2
    assert np.abs(gll_nodes(order) - expected).max() < 2e-16


@pytest.mark.parametrize("order", ORDERS)
def test_nodes_are_the_lobatto_rule(order):
    """Weights 1/(n (n + 1) P_n^2) on [0, 1] integrate every degree up to 2 n - 1."""
    nodes = gll_nodes(order)
    top = legendre.legval(2 * nodes - 1, np.eye(order + 1)[order])
    weights = 1 / (order * (order + 1) * top**2)
    moments = [weights @ nodes**degree for degree in range(2 * order)]
    assert np.abs(np.array(moments) * np.arange(1, 2 * order + 1) - 1).max() < 1e-13
    assert np.array_equal(nodes, np.sort(nodes))
    assert np.abs(nodes + nodes[::-1] - 1).max() < 2e-16


def test_no_order_below_one():
    with pytest.raises(ValueError, match="order must be an integer of at least 1, got 0"):
        gll_nodes(0)


@pytest.mark.parametrize("order", ORDERS)
def test_basis_is_nodal_and_sums_to_one(order):
    values, _ = lagrange(order, gll_nodes(order))
    assert np.abs(values - np.eye(order + 1)).max() < 1e-13
    points = np.linspace(0, 1, 23)
    values, slopes = lagrange(order, points)
    assert np.abs(values.sum(axis=1) - 1).max() < 1e-13
    assert np.abs(slopes.sum(axis=1)).max() < 1e-13 * order**2


@pytest.mark.parametrize("order", ORDERS)
def test_basis_and_slopes_reproduce_polynomials(order):
    points = np.linspace(0, 1, 17)
    values, slopes = lagrange(order, points)
    p = Polynomial(np.cos(1.0 + np.arange(order + 1)))
    assert np.abs(values @ p(gll_nodes(order)) - p(points)).max() < 1e-12
    assert np.abs(slopes @ p(gll_nodes(order)) - p.deriv()(points)).max() < 1e-11 * max(1, order)


@pytest.mark.parametrize("order", ORDERS)
def test_matrices_integrate_exactly(order):
    """Of powers: int x^i x^j = 1/(i+j+1); of the slopes i j/(i+j-1); int (x^i)' x^j = i/(i+j)."""
    matrices = reference_matrices(order)
    powers = np.arange(order + 1)
    monomials = gll_nodes(order)[:, None] ** powers
    i, j = np.meshgrid(powers, powers, indexing="ij")
    below = np.where(i + j > 1, i + j - 1, 1)
    cases = (
        (matrices.mass, 1 / (i + j + 1)),
        (matrices.stiffness, i * j / below),
        (matrices.advection, i / np.maximum(i + j, 1)),
    )
    for matrix, expected in cases:
        assert np.abs(monomials.T @ matrix @ monomials - expected).max() < 1e-12 * (1 + expected.max())


def test_cached_arrays_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        reference_matrices(4).mass[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        gll_nodes(4)[0] = 1.0
