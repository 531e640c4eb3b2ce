"""Eigenpairs at k and -k together, against the companion problem of twice the size."""

import numpy as np

from fem.eigenproblem import companion_modes, opposite_modes


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
