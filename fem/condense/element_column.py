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
from typing import NamedTuple

import numpy as np

from fem.condense.cascade_piece import Blocks, Port
from fem.condense.electrode_conditions import equipotential
from fem.discretize.element_matrices import element_matrix
from fem.discretize.section import FIELD_COLUMN, Section
from fem.exceptions import ConvergenceError
from fem.materials.medium import Medium

# Ports of every column of a transducer: the potentials of its two electrodes.
ELECTRODES = (Port(kind="voltage", name="+"), Port(kind="voltage", name="-"))
MAX_AMPLIFICATION = 1e9  # of the field inside a piece over that at its sides: seven digits are left


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
    # shape (face unknowns, 2 n + 2): faces from sides and electrode potentials
    faces_from: np.ndarray = field(repr=False)
    inside_from: dict = field(repr=False)  # by kind of element (height, medium): its inside from its boundary
    # shape (order + 1, 2 n + 2 + unknowns on the surface): electric reactions at the surface nodes, from left to right,
    # as functions of sides and surface, before the nodes are tied to the electrode; None without a potential
    surface_rows: np.ndarray | None = field(repr=False)

    @property
    def unknowns(self) -> int:
        """Unknowns that the column adds to a transducer."""
        return self.section.order * self.section.size

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
        return out + rest @ self.faces_from[: rest.shape[1]]


class ElementSets:
    """Indices of an element's unknowns, ``fields`` at each node: on its four edges, all of these, inside."""

    def __init__(self, order: int, fields: int):
        grid = np.arange((order + 1) ** 2 * fields).reshape(order + 1, order + 1, fields)
        self.left, self.right = grid[0].reshape(-1), grid[-1].reshape(-1)
        self.bottom, self.top = grid[1:-1, 0].reshape(-1), grid[1:-1, -1].reshape(-1)
        self.inside = grid[1:-1, 1:-1].reshape(-1)
        self.rim = np.concatenate([self.left, self.right, self.bottom, self.top])


class Skeleton(NamedTuple):
    """A column condensed to its sides, two empty ports and its surface; the same with and without an electrode.

    ``faces`` and ``inside_from`` are those of `Column`.
    """

    matrix: np.ndarray
    faces: np.ndarray
    faces_from: np.ndarray  # the faces below and above the surface from the unknowns of ``matrix``
    inside_from: dict


def condensed_column(
    section: Section, frequency: float, *, width: float, electrode: int | None, skeleton: Skeleton | None = None
) -> Column:
    """Condense a column of elements, its width in length units, to its sides and the finger's electrode, if any.

    ``skeleton``: result of `column_skeleton` for this width, if it is known already.
    """
    whole, faces, other_faces_from, inside_from = skeleton or column_skeleton(section, frequency, width)
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
    surface_from = np.zeros((len(whole) - sides, sides), dtype=back.dtype)
    surface_from[drop - sides] = back
    others_from = other_faces_from[:, :sides] + other_faces_from[:, sides:] @ surface_from
    if electrode is not None:
        port, corners = at.ports.start + electrode, tied[tied < sides]
        surface_from[tied[tied >= sides] - sides, port] = 1.0
        others_from[:, port] += other_faces_from[:, tied].sum(axis=1)
        others_from[:, corners] = 0.0
    faces_from = np.concatenate([surface_from, others_from])
    return Column(
        section=section,
        width=width,
        frequency=frequency,
        electrode=electrode,
        matrix=matrix,
        faces=faces,
        faces_from=faces_from,
        inside_from=inside_from,
        surface_rows=surface_rows,
    )


def column_skeleton(section: Section, frequency: float, width: float) -> Skeleton:
    """Condense a column, its width in length units, to its sides and the plane of the fingers."""
    order, sides = section.order, Blocks(section.size).ports.start + len(ELECTRODES)
    faces = _face_dofs(section, first=sides)
    dtype = np.result_type(section.heights, *(medium.xx for medium in section.media))
    matrix = np.zeros((int(max(faces.max(initial=-1), sides - 1)) + 1,) * 2, dtype=dtype)
    angular = 2 * np.pi * frequency * section.length_unit
    done: dict[tuple, np.ndarray] = {}
    inside_from: dict[tuple, np.ndarray] = {}
    for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
        kind = element_kind(height, medium)
        if kind not in done:
            sets = ElementSets(order, len(medium.fields))
            full = element_matrix(medium, width, height, order, angular)
            done[kind], inside_from[kind] = schur(full, sets.rim, sets.inside)
        dofs = element_dofs(section, element, faces)
        exists = np.flatnonzero(dofs >= 0)
        matrix[np.ix_(dofs[exists], dofs[exists])] += done[kind][np.ix_(exists, exists)]
    # the unknowns in the plane of the fingers come first of all faces
    outer = np.arange(sides + np.count_nonzero(faces[section.plane // order] >= 0))
    matrix, faces_from = schur(matrix, outer, np.arange(len(outer), len(matrix)))
    return Skeleton(matrix, faces, faces_from, inside_from)


def element_kind(height: complex, medium: Medium) -> tuple:
    """Key of an element: elements with equal keys have equal matrices."""
    return round(complex(height).real, 12), round(complex(height).imag, 12), id(medium)


def element_dofs(section: Section, element: int, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of an element in the order left, right, bottom, top; -1 where there is none."""
    n, order = section.size, section.order
    columns = [FIELD_COLUMN[name] for name in section.media[element].fields]
    line = section.dofs[element * order : (element + 1) * order + 1][:, columns].reshape(-1)
    other = np.where(line >= 0, line + n, -1)
    below, above = (faces[element + side][:, columns].reshape(-1) for side in (0, 1))
    return np.concatenate([line, other, below, above])


def _face_dofs(section: Section, *, first: int) -> np.ndarray:
    """Unknowns on the faces between elements: a node on a face has the fields of the line's node at that height.

    They are numbered from ``first`` on, those in the plane of the fingers before all others.
    """
    exists = section.dofs[:: section.order] >= 0
    exists = np.repeat(exists[:, None, :], section.order - 1, axis=1)
    plane_first = np.argsort(np.arange(len(exists)) != section.plane // section.order, kind="stable")
    numbers = np.cumsum(exists[plane_first]).reshape(exists.shape) + first - 1
    dofs = np.empty(exists.shape, dtype=int)
    dofs[plane_first] = np.where(exists[plane_first], numbers, -1)
    return dofs


def electrode_dofs(section: Section, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of phi in the plane of the fingers: left corner, right corner, nodes between."""
    corner = section.finger_potential
    if corner is None:
        raise ValueError("the plane of the fingers has no potential")
    between = faces[section.plane // section.order][:, FIELD_COLUMN["phi"]]
    return np.concatenate([[corner, corner + section.size], between])


def schur(matrix, keep, drop):
    """Schur complement onto ``keep``, symmetrised against rounding, and the matrix from ``keep`` to ``drop``."""
    coupling = matrix[np.ix_(drop, keep)]
    remaining = matrix[np.ix_(keep, keep)]
    if not len(drop):
        return remaining, coupling
    back = sides_to_inside(matrix[np.ix_(drop, drop)], coupling)
    reduced = remaining + coupling.T @ back
    return 0.5 * (reduced + reduced.T), back


def sides_to_inside(inside: np.ndarray, coupling: np.ndarray) -> np.ndarray:
    """Matrix from the fields at the sides to those inside, minus the inverse of ``inside`` times ``coupling``.

    Each decade of amplification costs a digit of the answer.  A piece that resonates between clamped lines makes its
    condensation singular, though not the stator's problem; it raises a ConvergenceError.
    """
    try:
        back = -np.linalg.solve(inside, coupling)
    except np.linalg.LinAlgError:
        back = np.array(np.inf)
    if not abs(back).max(initial=0.0) < MAX_AMPLIFICATION:
        raise ConvergenceError(
            "a piece of the transducer, clamped at its sides, resonates at this very frequency: "
            "change the frequency by a part in a million, or give the solid a mechanical_quality"
        )
    return back


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
            full[sets.inside] = column.inside_from[element_kind(height, medium)] @ rim
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
