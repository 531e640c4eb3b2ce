"""Condensed pieces of the stator: a column of elements reduced to its two sides and its electrode.

A column is one element wide and the whole section deep.  Its matrix is a sum of Kronecker products; the unknowns
inside an element, then those on the faces between elements, are eliminated (static condensation, Guyan 1965), so
that what remains relates the nodal fluxes on the left and right lines and the charge of an electrode on top to the
displacements and potentials there:

    [g_left, g_right, q+, q-] = A [u_left, u_right, V+, V-],      A complex symmetric.

g is the outward nodal flux (-f on the left, +f on the right) and q = int grad psi . D = -Q, the charge with its sign
turned.  A finger is equipotential: phi on its surface nodes, corners included, is the potential of its comb.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.forms import Medium
from fem.section import FIELD_COLUMN, Section
from fem.spectral import reference_matrices

PORTS = 2  # potentials of the positive and the negative comb


@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """A piece of stator condensed to its sides.

    Attributes
    ----------
    size : int
        Unknowns n of a line.
    matrix : ndarray, shape (2 n + 2, 2 n + 2)
        Over left line, right line, potential of the positive and of the negative comb; scaled.
    width : float
        Length units.
    parts : tuple
        The two blocks it was joined of and the line between them as a function of the sides, (n, 2 n + 2); or empty.
    column : Column or None
        What it was condensed from, for a single column.
    """

    size: int
    matrix: np.ndarray = field(repr=False)
    width: float
    parts: tuple = field(default=(), repr=False)
    column: "Column | None" = field(default=None, repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """One column of elements before condensation.

    Attributes
    ----------
    section : Section
    width : float
        Length units.
    frequency : float
        Hz.
    comb : int or None
        0 or 1 for a finger on top, None for a bare surface.
    reversed : bool
        Whether x runs the other way inside (a mirrored piece).
    """

    section: Section
    width: float
    frequency: float
    comb: int | None


def element_matrix(
    medium: Medium, width: float, height: complex, order: int, angular: float, *, part: str = "all"
) -> np.ndarray:
    """Matrix of one rectangular element, nodes x-major then z, fields innermost.

    Parameters
    ----------
    medium : Medium
    width, height : float or complex
        Length units.
    order : int
    angular : float
        omega times the length unit, m/s.
    part : str
        "all", or "loss": only the imaginary part of the moduli, as a real matrix.

    Returns
    -------
    ndarray, shape ((order + 1)**2 * fields,) * 2
    """
    line = reference_matrices(order)
    xx, xz, zz, inertia = medium.xx, medium.xz, medium.zz, np.diag(medium.inertia)
    if part == "loss":
        xx, xz, zz, inertia = (np.imag(table) for table in (xx, xz, zz, inertia))
    across = np.kron(line.advection, line.advection.T)
    return (
        np.kron(np.kron(line.stiffness / width, height * line.mass), xx)
        + np.kron(across, xz)
        + np.kron(across.T, xz.T)
        + np.kron(np.kron(width * line.mass, line.stiffness / height), zz)
        - angular**2 * np.kron(np.kron(width * line.mass, height * line.mass), inertia)
    )


class _Elimination:
    """Index sets of an element with ``fields`` unknowns a node: sides, faces, inside."""

    def __init__(self, order: int, fields: int):
        grid = np.arange((order + 1) ** 2 * fields).reshape(order + 1, order + 1, fields)
        self.left, self.right = grid[0].reshape(-1), grid[-1].reshape(-1)
        self.bottom, self.top = grid[1:-1, 0].reshape(-1), grid[1:-1, -1].reshape(-1)
        self.inside = grid[1:-1, 1:-1].reshape(-1)


def condensed(column: Column) -> Block:
    """Condense a column of elements to its sides and its electrode.

    Parameters
    ----------
    column : Column

    Returns
    -------
    Block
    """
    skeleton, faces = skeleton_matrix(column)
    sides = 2 * column.section.size + PORTS
    keep, drop = np.arange(sides), np.arange(sides, len(skeleton))
    if column.comb is not None:
        skeleton, keep, drop = _tied(column, skeleton, faces, keep, drop)
    matrix = _schur(skeleton, keep, drop)
    return Block(size=column.section.size, matrix=matrix, width=column.width, column=column)


def skeleton_matrix(column: Column) -> tuple[np.ndarray, np.ndarray]:
    """Matrix of a column over its sides, two empty ports and the faces between its elements.

    Returns
    -------
    matrix : ndarray
    faces : ndarray, shape (elements + 1, order - 1, 4)
        Number of the unknown on a face by node and field, -1 where there is none.
    """
    section, order = column.section, column.section.order
    n = section.size
    faces = _face_dofs(section, first=2 * n + PORTS)
    matrix = np.zeros((int(max(faces.max(), 2 * n + PORTS - 1)) + 1,) * 2, dtype=_dtype(section))
    angular = 2 * np.pi * column.frequency * section.length_unit
    done: dict[tuple, np.ndarray] = {}
    for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
        sets = _Elimination(order, len(medium.fields))
        keep = np.concatenate([sets.left, sets.right, sets.bottom, sets.top])
        key = (complex(height), id(medium))
        if key not in done:
            full = element_matrix(medium, column.width, height, order, angular)
            done[key] = _schur(full, keep, sets.inside) if len(sets.inside) else full[np.ix_(keep, keep)]
        dofs = element_dofs(section, element, faces)
        exists = np.flatnonzero(dofs >= 0)
        matrix[np.ix_(dofs[exists], dofs[exists])] += done[key][np.ix_(exists, exists)]
    return matrix, faces


def element_dofs(section: Section, element: int, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of an element in the order left, right, bottom, top; -1 where there is none."""
    n, order = section.size, section.order
    columns = [FIELD_COLUMN[name] for name in section.media[element].fields]
    line = section.dofs[element * order : (element + 1) * order + 1][:, columns].reshape(-1)
    other = np.where(line >= 0, line + n, -1)
    below, above = (faces[element + side][:, columns].reshape(-1) for side in (0, 1))
    return np.concatenate([line, other, below, above])


def _face_dofs(section: Section, *, first: int) -> np.ndarray:
    """Unknowns on the faces between elements: a node on a face has the fields of the line's node at that height."""
    exists = section.dofs[:: section.order] >= 0
    exists = np.repeat(exists[:, None, :], section.order - 1, axis=1)
    dofs = np.full(exists.shape, -1)
    dofs[exists] = first + np.arange(exists.sum())
    return dofs


def electrode_dofs(section: Section, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of phi on a column's surface: left corner, right corner, nodes between."""
    corner = section.surface_dofs["phi"]
    between = faces[section.surface // section.order][:, FIELD_COLUMN["phi"]]
    return np.concatenate([[corner, corner + section.size], between])


def _tied(column, skeleton, faces, keep, drop):
    """Tie phi of the electrode's nodes to its comb; the corners stay behind as empty rows of the sides."""
    tied = electrode_dofs(column.section, faces)
    port = 2 * column.section.size + column.comb
    tied_matrix = _folded(skeleton, tied, port)
    return tied_matrix, keep, np.setdiff1d(drop, tied)


def _folded(matrix, tied, port):
    """Add rows and columns of tied unknowns to the port's and empty them."""
    matrix = matrix.copy()
    matrix[port] += matrix[tied].sum(axis=0)
    matrix[tied] = 0.0
    matrix[:, port] += matrix[:, tied].sum(axis=1)
    matrix[:, tied] = 0.0
    return matrix


def folded(block: Block, side: int, phi: int, comb: int) -> np.ndarray:
    """Matrix of a block whose left (0) or right (1) surface node lies on a finger of the comb."""
    return _folded(block.matrix, np.array([side * block.size + phi]), 2 * block.size + comb)


def _schur(matrix, keep, drop):
    """Schur complement onto ``keep``, symmetrised against rounding."""
    from scipy.linalg import lu_factor, lu_solve

    coupling = matrix[np.ix_(drop, keep)]
    solved = lu_solve(lu_factor(matrix[np.ix_(drop, drop)], check_finite=False), coupling, check_finite=False)
    reduced = matrix[np.ix_(keep, keep)] - coupling.T @ solved
    return 0.5 * (reduced + reduced.T)


def _dtype(section: Section):
    return np.result_type(section.heights, *(medium.xx for medium in section.media))
