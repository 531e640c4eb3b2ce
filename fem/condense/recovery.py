"""Back into a condensed column: the field at all its nodes, and the power that is lost in it.

The faces between the elements follow from the sides and the electrode, the inside of an element from its own
boundary.  The loss is summed element by element from the imaginary parts of the moduli (c'' |S|^2 and eps'' |E|^2),
apart from everything the solution was made with, so that

    power in at the electrodes = power out through the two lines + power lost between them

is an audit of the whole solve, and not an identity of one matrix.
"""

from functools import cached_property

import numpy as np

from fem.condense.join import alike_columns
from fem.condense.superelement import (
    Column,
    ElementSets,
    Superelement,
    electrode_dofs,
    element_dofs,
    element_kind,
)
from fem.discretize.forms import element_matrix
from fem.discretize.section import FIELD_COLUMN
from fem.discretize.spectral import gll_nodes, lagrange


class ColumnField:
    """Recovery of one kind of column; made once, used for each place where the column stands."""

    def __init__(self, column: Column):
        self.column = column

    def _elements(self, sides: np.ndarray):
        """Values of every element from the bottom up, in its own order of nodes and fields; places last."""
        section, column = self.column.section, self.column
        values = np.concatenate([sides, column.faces_from @ sides])
        if column.electrode is not None:
            values[electrode_dofs(section, column.faces)] = sides[2 * section.size + column.electrode]
        for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
            dofs = element_dofs(section, element, column.faces)
            sets = ElementSets(section.order, len(medium.fields))
            rim = np.where((dofs >= 0)[:, None], values[dofs], 0.0)
            full = np.empty((len(sets.rim) + len(sets.inside), sides.shape[-1]), dtype=complex)
            full[sets.rim] = rim
            full[sets.inside] = column.inside_from[element_kind(height, medium)] @ rim
            yield element, height, medium, full

    def loss(self, sides: np.ndarray) -> float:
        """Power lost in all places together, scaled, (omega / 2) sum u^H Im(A) u; what an absorbing layer takes too."""
        column, order = self.column, self.column.section.order
        angular = 2 * np.pi * column.frequency * column.section.length_unit
        total = 0.0
        for _, height, medium, values in self._elements(sides):
            if height.imag:
                whole = element_matrix(medium, column.width, height, order, angular)
                total += float(np.vdot(values, whole @ values).imag)
            elif np.iscomplexobj(medium.xx):
                loss = element_matrix(medium, column.width, height.real, order, angular, part="loss")
                total += float(np.vdot(values, loss @ values).real)
        return np.pi * column.frequency * total

    def values(self, sides: np.ndarray) -> np.ndarray:
        """Fields at the nodes, shape (order + 1 along x, nodes along z, 4 fields, places); zero where absent."""
        section, order = self.column.section, self.column.section.order
        out = np.zeros((order + 1, len(section.dofs), 4, sides.shape[-1]), dtype=complex)
        for element, _, medium, values in self._elements(sides):
            columns = [FIELD_COLUMN[name] for name in medium.fields]
            shaped = values.reshape(order + 1, order + 1, len(columns), -1)
            out[:, element * order : (element + 1) * order + 1, columns] = shaped
        return out

    def surface_motion(self, sides: np.ndarray) -> np.ndarray:
        """u_x and u_z at the surface's nodes, shape (order + 1, 2, places)."""
        section, fields = self.column.section, [FIELD_COLUMN["ux"], FIELD_COLUMN["uz"]]
        corner = section.dofs[section.surface, fields]
        between = self.column.faces[section.surface // section.order][:, fields] - len(sides)
        inside = self.column.faces_from[between] @ sides
        return np.concatenate([sides[None, corner], inside, sides[None, corner + section.size]])


class ColumnsField:
    """Field of a superelement of columns for given lines and electrode potentials; lengths in the section's unit."""

    def __init__(self, superelement: Superelement, sides: np.ndarray):
        kinds: dict[tuple, tuple] = {}
        for part, starts, own in alike_columns(superelement, sides):
            _column, places, values = kinds.setdefault(
                (part.width, part.column.electrode), (part.column, [], [])
            )
            places.append(starts)
            values.append(own)
        # recovery, left edges from that of the superelement (places,), sides (2 n + 2, places)
        self.kinds = [
            (ColumnField(column), np.concatenate(places), np.concatenate(values, axis=-1))
            for column, places, values in kinds.values()
        ]

    def loss(self) -> float:
        """Power lost between the lines, scaled."""
        return sum(recovery.loss(sides) for recovery, _, sides in self.kinds)

    def in_row(self, of) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns from left to right: left edges and widths, fields (columns, ...).

        ``of``: recovery and sides of some columns -> their fields, shape (..., columns).
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


def finger_dipole(cell: Superelement) -> np.ndarray:
    """First moment of the reactions on a cell's only finger about its middle, length units, (2 n + 1,).

    As a function of the lines and the finger's potential.
    """
    left, right, back = cell.parts
    moments = (finger_moment(half, side) for side, half in enumerate((left, right)))
    return rows_of_parts(*moments, back)[:-1]


def finger_moment(half: Superelement, side: int) -> np.ndarray:
    """First moment of the reactions on half a finger about the end of its cell's left (0) or right half, (2 n + 2,).

    All nodes of bare surface but that at the other end are free of charge.
    """
    if half.moment is not None:
        return half.moment
    column = half
    while column.parts:
        column = column.parts[0]
    corner = column.column.section.surface_dofs["phi"]
    if side:
        return _moment(half, 0.0) - half.width * half.matrix[half.size + corner]
    return _moment(half, -half.width) + half.width * half.matrix[corner]


def _moment(piece: Superelement, start: float) -> np.ndarray:
    if not piece.parts:
        column = piece.column
        return (start + gll_nodes(column.section.order) * piece.width) @ column.surface_reactions
    left, right, back = piece.parts
    return rows_of_parts(_moment(left, start), _moment(right, start + left.width), back)


def rows_of_parts(left: np.ndarray, right: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Sum of two functions of the sides of two neighbours as one of the sides of both, (..., 2 n + potentials)."""
    n = len(back)
    return (left[..., n : 2 * n] + right[..., :n]) @ back + np.concatenate(
        [left[..., :n], right[..., n : 2 * n], left[..., 2 * n :] + right[..., 2 * n :]], axis=-1
    )
