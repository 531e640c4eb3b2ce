"""Back into a condensed column: the field at all its nodes, and the power that is lost in it.

The faces between the elements follow from the sides and the electrode, the inside of an element from its own
boundary.  The loss is summed element by element from the imaginary parts of the moduli (c'' |S|^2 and eps'' |E|^2),
apart from everything the solution was made with, so that

    power in at the combs = power out through the two lines + power lost between them

is an audit of the whole solve, and not an identity of one matrix.
"""

import numpy as np

from fem.cell import (
    PORTS,
    Column,
    _Elimination,
    electrode_dofs,
    element_dofs,
    element_matrix,
    skeleton_matrix,
)
from fem.section import FIELD_COLUMN


class ColumnField:
    """Recovery of one kind of column; made once, used for each place where the column stands."""

    def __init__(self, column: Column):
        from scipy.linalg import lu_factor, lu_solve

        section, order = column.section, column.section.order
        self.column = column
        skeleton, self._faces = skeleton_matrix(column)
        sides = 2 * section.size
        self._tied = (
            electrode_dofs(section, self._faces) if column.comb is not None else np.empty(0, dtype=int)
        )
        unknown = np.setdiff1d(np.arange(sides + PORTS, len(skeleton)), self._tied)
        known = np.setdiff1d(np.arange(len(skeleton)), unknown)
        factor = lu_factor(skeleton[np.ix_(unknown, unknown)], check_finite=False)
        self._known, self._unknown = known, unknown
        self._faces_from = -lu_solve(factor, skeleton[np.ix_(unknown, known)], check_finite=False)
        self._size = len(skeleton)
        self._inside: dict[tuple, tuple] = {}
        angular = 2 * np.pi * column.frequency * section.length_unit
        for height, medium in zip(section.heights, section.media, strict=True):
            key = (complex(height), id(medium))
            if key in self._inside:
                continue
            full = element_matrix(medium, column.width, height, order, angular)
            loss = element_matrix(medium, column.width, height, order, angular, part="loss")
            sets = _Elimination(order, len(medium.fields))
            rim = np.concatenate([sets.left, sets.right, sets.bottom, sets.top])
            inner = lu_factor(full[np.ix_(sets.inside, sets.inside)], check_finite=False)
            inside_from = -lu_solve(inner, full[np.ix_(sets.inside, rim)], check_finite=False)
            self._inside[key] = (rim, sets.inside, inside_from, loss)

    def _elements(self, sides: np.ndarray):
        """Values of every element, in its own order of nodes and fields, for places along the last axis."""
        section, column = self.column.section, self.column
        values = np.zeros((self._size, sides.shape[-1]), dtype=complex)
        values[: len(sides)] = sides
        if column.comb is not None:
            values[self._tied] = sides[2 * section.size + column.comb]
        values[self._unknown] = self._faces_from @ values[self._known]
        for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
            dofs = element_dofs(section, element, self._faces)
            rim, inside, inside_from, loss = self._inside[complex(height), id(medium)]
            own = np.where((dofs >= 0)[:, None], values[dofs], 0.0)
            full = np.zeros((len(loss), sides.shape[-1]), dtype=complex)
            full[rim] = own
            full[inside] = inside_from @ own
            yield element, medium, full, loss

    def loss(self, sides: np.ndarray) -> float:
        """Power lost in all places together, scaled: (omega / 2) sum u^H Im(A) u."""
        total = 0.0
        for _, _, values, loss in self._elements(sides):
            total += float(np.sum(np.real(np.conj(values) * (loss @ values))))
        return np.pi * self.column.frequency * total

    def values(self, sides: np.ndarray) -> np.ndarray:
        """Fields at the nodes, shape (order + 1 along x, nodes along z, 4 fields, places); zero where absent."""
        section, order = self.column.section, self.column.section.order
        out = np.zeros((order + 1, len(section.dofs), 4, sides.shape[-1]), dtype=complex)
        for element, medium, values, _ in self._elements(sides):
            columns = [FIELD_COLUMN[name] for name in medium.fields]
            shaped = values.reshape(order + 1, order + 1, len(columns), -1)
            out[:, element * order : (element + 1) * order + 1, columns] = shaped
        return out
