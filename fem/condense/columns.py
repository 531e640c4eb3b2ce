"""Superelement of the columns of elements under fingers and gaps, condensed to its two sides and its electrodes.

A transducer is such a superelement: columns (`fem.condense.column`) joined in pairs (`fem.condense.join`).  It keeps
the matrices that express each eliminated line by the sides, so that the field is recovered from the sides of the
whole, level by level, down to every column.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.column import ELECTRODES, Column, ColumnField, condensed_column
from fem.condense.piece import Blocks, Port
from fem.discretize.section import Section
from fem.discretize.spectral import lagrange


@dataclass(frozen=True, kw_only=True, eq=False)
class FingerColumns:
    """A `fem.condense.piece.Piece` of columns of elements."""

    size: int  # unknowns n of a line
    # shape (2 n + ports, 2 n + ports): over left line, right line and potentials of electrodes; scaled
    matrix: np.ndarray = field(repr=False)
    width: float  # length units
    # the two electrodes, one port for each finger, or none
    ports: tuple[Port, ...] = ELECTRODES
    # how the piece was made, from which the field inside is recovered; None if it is never needed
    inside: "Column | Pair | Restated | LiftedHalf | None" = field(default=None, repr=False)
    floating_potential: bool = False  # as in `fem.condense.piece.Piece`

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
        """The two joined pieces, before any change of the potentials; a TypeError if the piece was not joined."""
        inside = self.inside
        while isinstance(inside, Restated):
            inside = inside.piece.inside
        if not isinstance(inside, Pair):
            raise TypeError("the piece was not joined of two")
        return inside

    def recover(self, sides: np.ndarray) -> "ColumnsField":
        """Field inside for given lines and potentials, shape (2 n + ports, ...)."""
        return ColumnsField(self, sides)


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """Two joined neighbours."""

    left: FingerColumns
    right: FingerColumns
    middle: np.ndarray = field(repr=False)  # the shared line as a function of the sides, shape (n, 2 n + ports)
    # True: the ports are those of the left part followed by those of the right part; False: both parts share all ports
    own_ports: bool = False

    @cached_property
    def unknowns(self) -> int:
        """Sum over both parts."""
        return self.left.unknowns + self.right.unknowns

    def sides(self, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sides of the left and of the right part from those of the pair, (2 n + ports, ...)."""
        at, middle = self.left.at, np.tensordot(self.middle, whole, axes=1)
        left = right = whole[at.ports]
        if self.own_ports:
            left, right = np.split(left, [len(self.left.ports)])
        return (np.concatenate([whole[at.left], middle, left]), np.concatenate([middle, whole[at.right], right]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Restated:
    """A piece with reordered, fewer, or eliminated potentials; its lines are unchanged."""

    piece: FingerColumns
    sides: Callable[[np.ndarray], np.ndarray] = field(repr=False)  # sides of ``piece`` from the new ones

    @property
    def unknowns(self) -> int:
        """Unknowns of ``piece``."""
        return self.piece.unknowns


@dataclass(frozen=True, kw_only=True, eq=False)
class LiftedHalf:
    """Half a finger's cell on lines reduced to a basis; the same half on full lines is condensed on first use."""

    side: int  # 0: gap to mid-finger, 1: mid-finger to gap
    # (side, sides on reduced lines) -> (the half on full lines, its sides)
    full: Callable[[int, np.ndarray], tuple[FingerColumns, np.ndarray]] = field(repr=False)
    moment: np.ndarray = field(repr=False)  # `fem.condense.moments.finger_moment`, (2 n + 2,)
    unknowns: int


def condensed(section: Section, frequency: float, *, width: float, electrode: int | None) -> FingerColumns:
    """Condense one column (`condensed_column`) as a piece."""
    column = condensed_column(section, frequency, width=width, electrode=electrode)
    return FingerColumns(size=section.size, matrix=column.matrix, width=width, inside=column)


class ColumnsField:
    """Field of columns for given lines and electrode potentials; lengths in the section's unit."""

    def __init__(self, piece: FingerColumns, sides: np.ndarray):
        kinds: dict[tuple, tuple] = {}
        for part, starts, own in distinct_columns(piece, sides):
            key = part.width, part.column.electrode
            _, places, values = kinds.setdefault(key, (part.column, [], []))
            places.append(starts)
            values.append(own)
        # recovery, left edges relative to the piece's (places,), sides (2 n + 2, places)
        self.kinds = [
            (ColumnField(column), np.concatenate(places), np.concatenate(values, axis=-1))
            for column, places, values in kinds.values()
        ]

    def loss(self) -> float:
        """Power lost between the lines, scaled."""
        return sum(recovery.loss(sides) for recovery, _, sides in self.kinds)

    def in_row(self, of: Callable[[ColumnField, np.ndarray], np.ndarray]) -> tuple[np.ndarray, ...]:
        """Left edges, widths and fields (columns, ...) of all columns from left to right.

        ``of``: function of a recovery and the sides of equal columns that returns their fields, (..., columns).
        """
        starts, widths, values = [], [], []
        for recovery, left, sides in self.kinds:
            starts.append(left)
            widths.append(np.full(len(left), recovery.column.width))
            values.append(np.moveaxis(of(recovery, sides), -1, 0))
        in_row = np.argsort(np.concatenate(starts))
        return tuple(np.concatenate(each)[in_row] for each in (starts, widths, values))

    @cached_property
    def surface_nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the columns, and u_x and u_z at their surface nodes, (columns, order + 1, 2)."""
        start, width, values = self.in_row(ColumnField.surface_motion)
        return np.append(start, start[-1] + width[-1]), values

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the surface at places x from the left edge, shape (2, places)."""
        edges, values = self.surface_nodes
        columns = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(values) - 1)
        local = (x - edges[columns]) / (edges[columns + 1] - edges[columns])
        basis, _ = lagrange(values.shape[1] - 1, local)
        return np.einsum("pi,pif->fp", basis, values[columns])


def lines(
    piece: FingerColumns, sides: np.ndarray, start: float = 0.0, *, finest: float = 0.0
) -> list[tuple[float, FingerColumns, np.ndarray]]:
    """Columns of a piece from left to right, each with its left edge and its sides."""
    columns = [
        (begin, column, own[..., place])
        for column, starts, own in distinct_columns(piece, sides, start, finest=finest)
        for place, begin in enumerate(starts)
    ]
    return sorted(columns, key=lambda each: each[0])


def distinct_columns(
    piece: FingerColumns, sides: np.ndarray, start: float = 0.0, *, finest: float = 0.0
) -> list[tuple[FingerColumns, np.ndarray, np.ndarray]]:
    """Distinct columns of a piece: column, left edges of all its occurrences (places,), sides (2 n + 2, ..., places).

    ``sides``: left line, right line and electrode potentials, shape (2 n + 2, ...); in the returned ones a finger is
    always on electrode 0.  ``start``: x of the left line, length units.  Parts of width ``finest`` or less are
    returned whole.
    """
    level, columns = _Occurrences(), _Occurrences()
    level.add(piece, np.array([start]), sides[..., None])
    while level.by_piece:
        above, level = level, _Occurrences()
        for each, starts, own in above.concatenated():
            part, own = _original(each, own)
            if not isinstance(part.inside, Pair) or part.width <= finest:
                columns.add(part, starts, own)
                continue
            pair = part.pair
            left, right = pair.sides(own)
            level.add(pair.left, starts, left)
            level.add(pair.right, starts + pair.left.width, right)
    return columns.concatenated()


class _Occurrences:
    """Left edges and sides of all occurrences of each distinct piece."""

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


def _original(piece: FingerColumns, sides: np.ndarray) -> tuple[FingerColumns, np.ndarray]:
    """The piece on full lines before any change of its potentials, and its sides."""
    inside = piece.inside
    while isinstance(inside, Restated | LiftedHalf):
        if isinstance(inside, Restated):
            piece, sides = inside.piece, inside.sides(sides)
        else:
            piece, sides = inside.full(inside.side, sides)
        inside = piece.inside
    return piece, sides
