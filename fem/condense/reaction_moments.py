"""Reactions on fingers and their first moments, as functions of the sides of a piece."""

import numpy as np

from fem.condense.element_column import Column
from fem.condense.finger_columns import FingerColumns, LiftedHalf, Pair, SurfaceReactions
from fem.discretize.spectral import gll_nodes

SAME_NODE = 1e-9  # length units: nodes of neighbouring columns that are nearer to each other are one node


def finger_dipole(cell: FingerColumns) -> np.ndarray:
    """First moment of the reactions on a cell's only finger about its middle, length units, (2 n + 1,).

    As a function of the lines and the finger's potential.
    """
    pair = cell.pair
    return (pair.from_left(finger_moment(pair.left, 0)) + pair.from_right(finger_moment(pair.right, 1)))[:-1]


def finger_moment(half: FingerColumns, side: int) -> np.ndarray:
    """First moment of the reactions on half a finger about the end of its cell's left (0) or right half, (2 n + 2,).

    All nodes of bare surface, except the one at the other end of the half, carry no charge.
    """
    if isinstance(half.inside, LiftedHalf):
        return half.inside.moment
    first = half
    while isinstance(first.inside, Pair):
        first = first.inside.left
    corner = first.column.section.finger_potential
    line = half.matrix[half.at.right if side else half.at.left]
    start = 0.0 if side else -half.width
    return _moment(half, start) + (-half.width if side else half.width) * line[corner]


def finger_reactions(half: FingerColumns) -> SurfaceReactions:
    """Reactions at the nodes on half a finger and in the middle of the gap; of two columns that meet, their sum."""
    position, on_metal, rows = half.surface_reactions
    starts = np.flatnonzero(np.diff(position, prepend=-np.inf) > SAME_NODE)
    covered = np.logical_or.reduceat(on_metal, starts)
    kept = covered.copy()
    kept[[0, -1]] = True  # a bare node between two fingers tells them apart
    return SurfaceReactions(position[starts][kept], covered[kept], np.add.reduceat(rows, starts)[kept])


def _moment(piece: FingerColumns, start: float) -> np.ndarray:
    if isinstance(piece.inside, Column):
        return (start + gll_nodes(piece.inside.section.order) * piece.width) @ piece.inside.surface_reactions
    pair = piece.pair
    return pair.from_left(_moment(pair.left, start)) + pair.from_right(_moment(pair.right, start + pair.left.width))
