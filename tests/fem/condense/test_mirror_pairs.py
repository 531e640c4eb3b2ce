"""Parities of a piece that is its own mirror image, against the matrices themselves."""

import numpy as np
import pytest

from fem.condense.mirror_pairs import MirrorPairs

RANDOM = np.random.default_rng(5)
# pairs in any order, with unknowns that are their own image, even and odd
ROWS = MirrorPairs(np.array([4, 1, 3, 2, 0, 5]), np.array([True, False, False, False, True, True]))
COLUMNS = MirrorPairs(np.array([1, 0, 2, 3]), np.array([False, False, True, False]))


def reflected(rows, columns, matrix):
    """The matrix of the mirrored piece."""
    return rows.signs[:, None] * matrix[np.ix_(rows.images, columns.images)] * columns.signs


@pytest.mark.parametrize("first", [0, 1])
def test_a_matrix_is_the_sum_of_its_parities(first):
    """Eigenvalues of both parts are those of the matrix, which is put together again; of complex matrices too."""
    draw = RANDOM.normal(size=(6, 6)) + 1j * first * RANDOM.normal(size=(6, 6))
    matrix = draw + reflected(ROWS, ROWS, draw)
    parts = ROWS.split(matrix)
    assert [len(each) for each in parts] == [3, 3]
    values = np.concatenate([np.linalg.eigvals(each) for each in parts])
    np.testing.assert_allclose(np.sort_complex(values), np.sort_complex(np.linalg.eigvals(matrix)), rtol=1e-12)
    np.testing.assert_allclose(ROWS.joined(parts, ROWS), matrix, rtol=1e-13)


def test_each_parity_is_solved_alone():
    """A x = B with B from other unknowns: the solutions of both parts, put together, are the solution."""
    draw, right = RANDOM.normal(size=(6, 6)), RANDOM.normal(size=(6, 4))
    matrix = draw + reflected(ROWS, ROWS, draw) + 9 * np.eye(6)
    right = right + reflected(ROWS, COLUMNS, right)
    solution = np.linalg.solve(matrix, right)
    parts = []
    for chosen, sign in zip(ROWS.chosen, (1.0, -1.0), strict=True):
        unit = np.eye(6)[:, chosen] + sign * ROWS.signs[:, None] * np.eye(6)[ROWS.images][:, chosen]
        unit /= np.linalg.norm(unit, axis=0)  # even or odd combinations as columns
        own = COLUMNS.chosen[0 if sign > 0 else 1]
        other = np.eye(4)[:, own] + sign * COLUMNS.signs[:, None] * np.eye(4)[COLUMNS.images][:, own]
        other /= np.linalg.norm(other, axis=0)
        parts.append(np.linalg.solve(unit.T @ matrix @ unit, unit.T @ right @ other))
    np.testing.assert_allclose(ROWS.joined(parts, COLUMNS), solution, rtol=1e-12, atol=1e-14)


def test_consecutive_unknowns_are_a_part():
    part = MirrorPairs(np.array([1, 0, 2, 4, 3]), np.array([False, False, True, True, True])).part(slice(2, None))
    assert part.images.tolist() == [0, 2, 1]
    assert part.signs.tolist() == [-1.0, -1.0, -1.0]
    assert [place.tolist() for place in part.places] == [[-1, 0, -1], [1, 0, -1]]
