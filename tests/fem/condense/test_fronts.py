"""Nested dissection against the dense Schur complement of the same elements."""

import numpy as np
import pytest

from fem.condense.nested_dissection import Dissection
from fem.exceptions import ConvergenceError


def _grid(across, down, kept_column):
    """Bilinear elements on a grid of vertices: their unknowns, centres and number of unknowns.

    The last column's vertices come last; the first vertex is held; two vertices of the first row are one unknown.
    """
    vertex = np.arange((across + 1) * (down + 1)).reshape(across + 1, down + 1) - 1
    vertex[1, 0] = vertex[2, 0]
    used = np.unique(vertex[vertex >= 0])
    vertex = np.where(vertex >= 0, np.searchsorted(used, vertex), -1)
    i, j = (each.ravel() for each in np.meshgrid(np.arange(across), np.arange(down), indexing="ij"))
    unknowns = np.stack([vertex[i, j], vertex[i + 1, j], vertex[i + 1, j + 1], vertex[i, j + 1]], axis=1)
    return list(unknowns), np.stack([i, j], axis=1) + 0.5, len(used) - kept_column * (down + 1), len(used)


@pytest.mark.parametrize(("across", "down", "kept"), [(2, 1, 1), (5, 3, 1), (4, 9, 1), (3, 3, 0)])
def test_elimination_is_that_of_the_dense_matrix(across, down, kept):
    unknowns, centers, first, total = _grid(across, down, kept)
    rng = np.random.default_rng(across)
    matrices = [each + each.T for each in rng.normal(size=(len(unknowns), 4, 4)) + 1j]
    whole = np.zeros((total, total), dtype=complex)
    for own, matrix in zip(unknowns, matrices, strict=True):
        there = own >= 0
        np.add.at(whole, np.ix_(own[there], own[there]), matrix[np.ix_(there, there)])
    factor = Dissection(unknowns=unknowns, centers=centers, first_kept=first).factor(matrices)
    inner, coupling = whole[:first, :first], whole[:first, first:]
    back = -np.linalg.solve(inner, coupling)
    assert factor.matrix == pytest.approx(whole[first:, first:] + coupling.T @ back, rel=1e-9, abs=1e-9)
    sides = rng.normal(size=(total - first, 2))
    assert factor.unknowns(sides) == pytest.approx(np.concatenate([back @ sides, sides]), rel=1e-8, abs=1e-9)


def test_a_singular_part_is_refused():
    unknowns, centers, first, _ = _grid(4, 4, 1)
    with pytest.raises(ConvergenceError):
        Dissection(unknowns=unknowns, centers=centers, first_kept=first).factor([np.zeros((4, 4))] * 16)
