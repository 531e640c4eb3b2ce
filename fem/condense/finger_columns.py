"""Superelement of the columns of elements under fingers and gaps, condensed to its two lines and its electrodes.

A transducer is such a superelement: columns (`fem.condense.element_column`) joined in pairs
(`fem.condense.joined_fingers`).  The *sides* of a piece are the vector [u_left, u_right, v] of its unknowns on the left
line, on the right line, and the potentials of its electrodes.  A pair keeps the matrix that expresses its eliminated
middle line by its sides.  The field inside is therefore recovered from the sides of the whole down the tree of pairs:
sides of the parts from those of a pair, level by level, to every column.  Equal columns of a transducer are one object
that occurs several times, and are recovered together.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fem.condense.cascade_piece import ELECTRODES, Blocks, Port
from fem.condense.column_skeleton import Skeleton
from fem.condense.element_column import Column, ColumnField, condensed_column
from fem.discretize.section import Section
from fem.discretize.spectral import gll_nodes, lagrange


@dataclass(frozen=True, kw_only=True, eq=False)
class FingerColumns:
    """A `fem.condense.cascade_piece.Piece` of columns of elements."""

    size: int  # unknowns n of a line
    # shape (2 n + ports, 2 n + ports): over left line, right line and potentials of electrodes; scaled
    matrix: np.ndarray = field(repr=False)
    width: float  # length units
    # the two electrodes, one port for each finger, or none
    ports: tuple[Port, ...] = ELECTRODES
    # how the piece was made, from which the field inside is recovered; None if it is never needed
    inside: "Column | Pair | Restated | LiftedHalf | None" = field(default=None, repr=False)
    floating_potential: bool = False  # as in `fem.condense.cascade_piece.Piece`

    @cached_property
    def at(self) -> Blocks:
        """Slices of the lines and ports in the matrix."""
        return Blocks(self.size)

    @property
    def unknowns(self) -> int:
        """Unknowns of the columns before they were condensed."""
        return 0 if self.inside is None else self.inside.unknowns

    @property
    def column(self) -> Column:
        """The column, if the piece is a single one; a TypeError otherwise."""
        if not isinstance(self.inside, Column):
            raise TypeError("the piece is not one column of elements")
        return self.inside

    @property
    def pair(self) -> "Pair":
        """The two joined parts, before any change of the potentials; a TypeError if the piece was not joined."""
        inside = self.inside
        while isinstance(inside, Restated):
            inside = inside.piece.inside
        if not isinstance(inside, Pair):
            raise TypeError("the piece was not joined of two")
        return inside

    @cached_property
    def surface_reactions(self) -> "SurfaceReactions":
        """Electric reactions at the surface nodes; of a column, or of columns joined without any change.

        Of half a cell on reduced lines they are those of `fem.condense.reaction_moments.finger_reactions`.
        """
        pair = self.inside
        if isinstance(pair, LiftedHalf) and pair.reactions is not None:
            return pair.reactions()
        if isinstance(pair, Pair):
            left, right = pair.left.surface_reactions, pair.right.surface_reactions
            return SurfaceReactions(
                np.concatenate([left.position, pair.left.width + right.position]),
                np.concatenate([left.on_metal, right.on_metal]),
                np.concatenate([pair.from_left(left.rows), pair.from_right(right.rows)]),
            )
        rows, position = self.column.surface_reactions, gll_nodes(self.column.section.order) * self.width
        return SurfaceReactions(position, np.full(len(rows), self.column.electrode is not None), rows)

    def recover(self, sides: np.ndarray) -> "ColumnsField":
        """Field inside for values on lines and potentials, shape (2 n + ports, ...)."""
        return ColumnsField(self, sides)


class SurfaceReactions(NamedTuple):
    """Electric reactions at the surface nodes of a piece; a node that two columns share occurs twice."""

    position: np.ndarray  # (nodes,): from the left edge, length units
    on_metal: np.ndarray  # (nodes,): True if the column has an electrode
    rows: np.ndarray  # (nodes, 2 n + ports): scaled, as functions of the sides


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """Two joined neighbours."""

    left: FingerColumns
    right: FingerColumns
    # T of equation (2) in joined_fingers.py: from the sides to the unknowns of the shared line, shape (n, 2 n + ports)
    middle: np.ndarray = field(repr=False)
    # True: the ports are those of the left part followed by those of the right part; False: both parts share all ports
    own_ports: bool = False

    @cached_property
    def unknowns(self) -> int:
        """Sum over both parts."""
        return self.left.unknowns + self.right.unknowns

    def sides(self, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sides of the left and of the right part from those of the pair, (2 n + ports, ...)."""
        at, shared_line = self.left.at, np.tensordot(self.middle, whole, axes=1)
        left_ports = right_ports = whole[at.ports]
        if self.own_ports:
            left_ports, right_ports = np.split(left_ports, [len(self.left.ports)])
        left = np.concatenate([whole[at.left], shared_line, left_ports])
        return left, np.concatenate([shared_line, whole[at.right], right_ports])

    def from_left(self, rows: np.ndarray) -> np.ndarray:
        """Linear functions (..., 2 n + ports) of the left part's sides as functions of the pair's."""
        at = self.left.at
        whole = rows[..., at.right] @ self.middle
        whole[..., at.left] += rows[..., at.left]
        whole[..., at.ports][..., : len(self.left.ports)] += rows[..., at.ports]
        return whole

    def from_right(self, rows: np.ndarray) -> np.ndarray:
        """Linear functions (..., 2 n + ports) of the right part's sides as functions of the pair's."""
        at = self.right.at
        whole = rows[..., at.left] @ self.middle
        whole[..., at.right] += rows[..., at.right]
        whole[..., whole.shape[-1] - len(self.right.ports) :] += rows[..., at.ports]
        return whole


@dataclass(frozen=True, kw_only=True, eq=False)
class Restated:
    """Origin of a piece that differs from ``piece`` in its potentials only: reordered, fewer, or eliminated."""

    piece: FingerColumns
    sides: Callable[[np.ndarray], np.ndarray] = field(repr=False)  # sides of ``piece`` from the new ones

    @property
    def unknowns(self) -> int:
        """Unknowns of ``piece``."""
        return self.piece.unknowns


@dataclass(frozen=True, kw_only=True, eq=False)
class LiftedHalf:
    """Origin of half a finger's cell whose lines are reduced to a basis.

    The field inside is recovered from the same half on lines with all unknowns, which is condensed on first use.
    """

    side: int  # 0: from the middle of the gap to the middle of the finger, 1: the other half
    # (side, sides on reduced lines) -> (the half on lines with all unknowns, its sides there)
    full: Callable[[int, np.ndarray], tuple[FingerColumns, np.ndarray]] = field(repr=False)
    moment: np.ndarray = field(repr=False)  # `fem.condense.reaction_moments.finger_moment`, (2 n + 2,)
    unknowns: int
    # `fem.condense.reaction_moments.finger_reactions` of the half; None where they are not interpolated
    reactions: Callable[[], SurfaceReactions] | None = field(default=None, repr=False)


def condensed(
    section: Section, frequency: float, *, width: float, electrode: int | None, skeleton: Skeleton | None = None
) -> FingerColumns:
    """Condense one column (`condensed_column`) as a piece."""
    column = condensed_column(section, frequency, width=width, electrode=electrode, skeleton=skeleton)
    return FingerColumns(size=section.size, matrix=column.matrix, width=width, inside=column)


class EqualColumns(NamedTuple):
    """All columns of a piece that have the same width and electrode."""

    recovery: ColumnField
    starts: np.ndarray  # (columns,): left edges relative to the piece's
    sides: np.ndarray  # (2 n + 2, ..., columns)


class ColumnsField:
    """Field of columns for values on lines and electrode potentials; lengths in the section's unit."""

    def __init__(self, piece: FingerColumns, sides: np.ndarray):
        groups: dict[tuple, tuple] = {}
        for part, starts, part_sides in distinct_columns(piece, sides):
            key = part.width, part.column.electrode
            _, all_starts, all_sides = groups.setdefault(key, (part.column, [], []))
            all_starts.append(starts)
            all_sides.append(part_sides)
        self.equal_columns = [
            EqualColumns(ColumnField(column), np.concatenate(starts), np.concatenate(part_sides, axis=-1))
            for column, starts, part_sides in groups.values()
        ]

    def loss(self) -> float:
        """Power lost between the lines, scaled."""
        return sum(each.recovery.loss(each.sides) for each in self.equal_columns)

    def in_order(self, of: Callable[[ColumnField, np.ndarray], np.ndarray]) -> tuple[np.ndarray, ...]:
        """Left edges, widths and fields (columns, ...) of all columns from left to right.

        ``of``: function of a recovery and the sides of equal columns that returns their fields, (..., columns).
        """
        starts, widths, values = [], [], []
        for recovery, left_edges, sides in self.equal_columns:
            starts.append(left_edges)
            widths.append(np.full(len(left_edges), recovery.column.width))
            values.append(np.moveaxis(of(recovery, sides), -1, 0))
        order = np.argsort(np.concatenate(starts))
        return tuple(np.concatenate(each)[order] for each in (starts, widths, values))

    @cached_property
    def surface_nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the columns, and u_x and u_z at their surface nodes, (columns, order + 1, 2)."""
        start, width, values = self.in_order(ColumnField.surface_motion)
        return np.append(start, start[-1] + width[-1]), values

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the surface at positions x from the left edge, shape (2, positions)."""
        edges, values = self.surface_nodes
        columns = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(values) - 1)
        local = (x - edges[columns]) / (edges[columns + 1] - edges[columns])
        basis, _ = lagrange(values.shape[1] - 1, local)
        return np.einsum("pi,pif->fp", basis, values[columns])


def columns_from_left(
    piece: FingerColumns, sides: np.ndarray, *, finest: float = 0.0
) -> list[tuple[float, FingerColumns, np.ndarray]]:
    """Columns of a piece from left to right, each with its left edge and its sides; arguments of `distinct_columns`."""
    columns = [
        (left_edge, column, column_sides[..., number])
        for column, starts, column_sides in distinct_columns(piece, sides, finest=finest)
        for number, left_edge in enumerate(starts)
    ]
    return sorted(columns, key=lambda each: each[0])


def distinct_columns(
    piece: FingerColumns, sides: np.ndarray, *, finest: float = 0.0
) -> list[tuple[FingerColumns, np.ndarray, np.ndarray]]:
    """Distinct columns of a piece: column, left edges (occurrences,), sides (2 n + 2, ..., occurrences).

    Edges are measured from the piece's left line, in length units.  ``sides``: shape (2 n + 2, ...); in the returned
    ones a finger is always on electrode 0.  Parts of width ``finest`` or less are returned whole, and
    on their reduced lines if their reactions there are known.
    """
    level, columns = _Occurrences(), _Occurrences()
    level.add(piece, np.zeros(1), sides[..., None])
    while level.by_piece:
        next_level = _Occurrences()
        for each, starts, each_sides in level.concatenated():
            part, part_sides = _original(each, each_sides, finest)
            if not isinstance(part.inside, Pair) or part.width <= finest:
                columns.add(part, starts, part_sides)
                continue
            pair = part.pair
            left, right = pair.sides(part_sides)
            next_level.add(pair.left, starts, left)
            next_level.add(pair.right, starts + pair.left.width, right)
        level = next_level
    return columns.concatenated()


class _Occurrences:
    """Left edges and sides of all occurrences of each distinct piece, which are recovered as one array."""

    def __init__(self):
        self.by_piece: dict[int, tuple[FingerColumns, list, list]] = {}

    def add(self, piece: FingerColumns, starts: np.ndarray, sides: np.ndarray) -> None:
        _, all_starts, all_sides = self.by_piece.setdefault(id(piece), (piece, [], []))
        all_starts.append(starts)
        all_sides.append(sides)

    def concatenated(self) -> list[tuple[FingerColumns, np.ndarray, np.ndarray]]:
        return [
            (piece, np.concatenate(starts), np.concatenate(sides, axis=-1))
            for piece, starts, sides in self.by_piece.values()
        ]


def _original(piece: FingerColumns, sides: np.ndarray, finest: float) -> tuple[FingerColumns, np.ndarray]:
    """The piece before any change of its potentials (`Restated`) or of its lines (`LiftedHalf`), and its sides."""
    inside = piece.inside
    while isinstance(inside, Restated | LiftedHalf):
        if isinstance(inside, LiftedHalf) and inside.reactions is not None and piece.width <= finest:
            break
        if isinstance(inside, Restated):
            piece, sides = inside.piece, inside.sides(sides)
        else:
            piece, sides = inside.full(inside.side, sides)
        inside = piece.inside
    return piece, sides
