"""A column of elements: condensation to its two sides and its electrode, and recovery of the field inside.

A column is one element wide and the whole section deep.  Its matrix is a sum of Kronecker products; the unknowns
inside an element, then those on the faces between elements, are eliminated (static condensation, Guyan 1965), so
that what remains relates the nodal fluxes on the left and right lines and the charge of an electrode on top to the
displacements and potentials there:

    [g_left, g_right, q+, q-] = A [u_left, u_right, V+, V-],      A complex symmetric.

g is the outward nodal flux (-f on the left, +f on the right) and q = int grad psi . D = -Q, the charge with its sign
reflected.  A finger is equipotential: phi on its surface nodes, corners included, is the potential of its electrode.

Recovery goes backwards: the faces follow from the sides and the electrode, the inside of an element from its boundary.
The loss is summed element by element from the imaginary parts of the moduli (c'' |S|^2 and eps'' |E|^2), independently
of the matrices used in the solution.  The balance

    power in at the electrodes = power out through the two lines + power lost between them

is therefore a check of the whole solution, not an identity of one matrix.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.cascade_piece import ELECTRODES, Blocks
from fem.condense.column_skeleton import (
    ElementSets,
    Skeleton,
    column_skeleton,
    electrode_dofs,
    element_dofs,
    element_kind,
)
from fem.condense.electrode_conditions import equipotential
from fem.condense.elimination import schur
from fem.discretize.element_matrices import element_matrix
from fem.discretize.section import FIELD_COLUMN, Section


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """One condensed column of elements, with the matrices that recover the field inside."""

    section: Section
    width: float  # length units
    frequency: float  # Hz
    electrode: int | None  # 0 or 1 for a finger on top, None for a bare surface
    # shape (2 n + 2, 2 n + 2): over left line, right line and the potentials of both electrodes; scaled
    matrix: np.ndarray = field(repr=False)
    # shape (elements + 1, order - 1, 4): number of the unknown on a face between elements by node and field,
    # -1 where there is none
    faces: np.ndarray = field(repr=False)
    skeleton: Skeleton = field(repr=False)
    # shape (unknowns in the plane of the fingers, 2 n + 2): these from sides and electrode potentials
    plane_from: np.ndarray = field(repr=False)
    # shape (order + 1, 2 n + 2 + unknowns on the surface): electric reactions at the surface nodes, from left to right,
    # as functions of sides and surface, before the nodes are tied to the electrode; None without a potential
    surface_rows: np.ndarray | None = field(repr=False)

    @property
    def unknowns(self) -> int:
        """Unknowns that the column adds to a transducer."""
        return self.section.order * self.section.size

    @cached_property
    def faces_from(self) -> np.ndarray:
        """Matrix to the unknowns on the faces from sides and electrode potentials, shape (face unknowns, 2 n + 2)."""
        sides, from_skeleton = len(self.matrix), self.skeleton.faces_from()
        others_from = from_skeleton[:, :sides] + from_skeleton[:, sides:] @ self.plane_from
        if self.electrode is not None:  # the corners' potential is the electrode's
            corners = electrode_dofs(self.section, self.faces)[:2]
            others_from[:, Blocks(self.section.size).ports.start + self.electrode] += from_skeleton[:, corners].sum(
                axis=1
            )
            others_from[:, corners] = 0.0
        return np.concatenate([self.plane_from, others_from])

    @cached_property
    def surface_reactions(self) -> np.ndarray:
        """Scaled electric reactions at the surface nodes as functions of the sides, shape (order + 1, 2 n + 2)."""
        first = Blocks(self.section.size).ports.start
        sides = first + len(ELECTRODES)
        if self.surface_rows is None:
            raise ValueError("a column without a potential has no electric reactions")
        out, rest = self.surface_rows[:, :sides].copy(), self.surface_rows[:, sides:]
        if self.electrode is not None:  # the corners' potential is the electrode's
            corners = electrode_dofs(self.section, self.faces)[:2]
            out[:, first + self.electrode] += out[:, corners].sum(axis=1)
            out[:, corners] = 0.0
        return out + rest @ self.plane_from


def condensed_column(
    section: Section, frequency: float, *, width: float, electrode: int | None, skeleton: Skeleton | None = None
) -> Column:
    """Condense a column of elements, its width in length units, to its sides and the finger's electrode, if any.

    ``skeleton``: result of `column_skeleton` for this width, if it is known already.
    """
    skeleton = skeleton or column_skeleton(section, frequency, width)
    whole, faces = skeleton.matrix, skeleton.faces
    at = Blocks(section.size)
    sides = at.ports.start + len(ELECTRODES)
    drop = np.arange(sides, len(whole))
    tied, surface_rows = np.empty(0, dtype=int), None
    if section.finger_potential is not None:
        left, right, *between = electrode_dofs(section, faces)
        surface_rows = whole[[left, *between, right]]
    if electrode is not None:
        # The corners remain as empty rows of the sides; their potential is that of the electrode.
        tied = electrode_dofs(section, faces)
        whole = equipotential(whole, tied, at.ports.start + electrode)
        drop = drop[~np.isin(drop, tied)]
    matrix, back = schur(whole, np.arange(sides), drop)
    plane_from = np.zeros((len(whole) - sides, sides), dtype=back.dtype)
    plane_from[drop - sides] = back
    if electrode is not None:
        plane_from[tied[tied >= sides] - sides, at.ports.start + electrode] = 1.0
    return Column(
        section=section,
        width=width,
        frequency=frequency,
        electrode=electrode,
        matrix=matrix,
        faces=faces,
        skeleton=skeleton,
        plane_from=plane_from,
        surface_rows=surface_rows,
    )


class ColumnField:
    """Recovery of the field in all occurrences of one column."""

    def __init__(self, column: Column):
        self.column = column

    def _elements(self, sides: np.ndarray):
        """Values of every element from the bottom up, in its own order of nodes and fields; occurrences last."""
        section, column = self.column.section, self.column
        values = np.concatenate([sides, column.faces_from @ sides])
        if column.electrode is not None:
            values[electrode_dofs(section, column.faces)] = sides[Blocks(section.size).ports][column.electrode]
        for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
            dofs = element_dofs(section, element, column.faces)
            sets = ElementSets(section.order, len(medium.fields))
            rim = np.where((dofs >= 0)[:, None], values[dofs], 0.0)
            full = np.empty((len(sets.rim) + len(sets.inside), sides.shape[-1]), dtype=complex)
            full[sets.rim] = rim
            full[sets.inside] = column.skeleton.inside_from[element_kind(height, medium)]() @ rim
            yield element, height, medium, full

    def loss(self, sides: np.ndarray) -> float:
        """Power lost in all occurrences, scaled, (omega / 2) sum u^H Im(A) u, absorbing layers included."""
        column, order = self.column, self.column.section.order
        angular = 2 * np.pi * column.frequency * column.section.length_unit
        total = 0.0
        for _, height, medium, values in self._elements(sides):
            if height.imag:
                whole = element_matrix(medium, column.width, height, order, angular)
                total += float(np.vdot(values, whole @ values).imag)
            elif np.iscomplexobj(medium.xx):
                loss = element_matrix(medium, column.width, height.real, order, angular, part="loss")
                both = np.hstack([values.real, values.imag])  # a product of real matrices takes half the time
                total += float(np.vdot(both, loss @ both))
        return np.pi * column.frequency * total

    def values(self, sides: np.ndarray) -> np.ndarray:
        """Fields at the nodes, shape (order + 1 along x, nodes along z, 4 fields, occurrences); zero where absent."""
        section, order = self.column.section, self.column.section.order
        out = np.zeros((order + 1, len(section.dofs), 4, sides.shape[-1]), dtype=complex)
        for element, _, medium, values in self._elements(sides):
            columns = [FIELD_COLUMN[name] for name in medium.fields]
            shaped = values.reshape(order + 1, order + 1, len(columns), -1)
            out[:, element * order : (element + 1) * order + 1, columns] = shaped
        section.fill_bonds(np.moveaxis(out, -1, 0))
        return out

    def surface_motion(self, sides: np.ndarray) -> np.ndarray:
        """u_x and u_z at the surface's nodes, shape (order + 1, 2, occurrences)."""
        section, fields = self.column.section, [FIELD_COLUMN["ux"], FIELD_COLUMN["uz"]]
        corner = section.dofs[section.surface, fields]
        between = self.column.faces[section.surface // section.order][:, fields] - len(sides)
        inside = self.column.faces_from[between] @ sides
        return np.concatenate([sides[None, corner], inside, sides[None, corner + section.size]])
