"""Absorbing layer below a meshed piece: columns of the section's own elements, one below each edge of the mesh's foot.

The mesh ends where the absorbing layer of the section begins.  Below it the section's elements are repeated over the
width of the piece.  Through the depth they are those of the section, so that the lines at the interfaces are the
section's own and need no projection.  Along x their functions on the edge of the mesh are those of the mesh: with w the
nodal values there and m the mesh's unknowns on the edge,

    w = S m,        A_mesh = S^T A S,                                                                       (1)

in which S holds the values of the mesh's functions at the nodes.  S is exact, as the order of the section is at least
that of the mesh.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.column_skeleton import ElementSets
from fem.condense.elimination import schur
from fem.discretize.element_matrices import element_matrix
from fem.discretize.quad_elements import QuadSpace
from fem.discretize.section import FIELD_COLUMN, Section
from fem.discretize.spectral import gll_nodes
from fem.mesh.section_mesh import SAME


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerColumns:
    """Columns of the section's absorbing layer below a mesh.

    Their nodes are numbered behind the skeleton functions of the mesh: lines from left to right, each from the bottom
    up without the mesh's vertex on top, then the inner nodes on the lower face of every element.
    """

    section: Section = field(repr=False)
    space: QuadSpace = field(repr=False)
    names: tuple[str, ...]  # fields of the stator

    @property
    def layers(self) -> int:
        """Elements of a column."""
        return self.section.bottom // self.section.order

    @property
    def functions(self) -> int:
        """Nodes of all columns on lines and faces, without those of the mesh."""
        columns, inner = len(self.widths), self.section.order - 1
        return (columns + 1) * self.section.bottom + columns * self.layers * inner

    @cached_property
    def _foot(self) -> tuple[np.ndarray, np.ndarray]:
        """Directed lower edges of the mesh from left to right, shape (m, 2), and x of their ends, length units."""
        mesh = self.space.mesh
        z = mesh.points[mesh.boundary, 1]
        edges = mesh.boundary[(abs(z - z.min()) <= SAME * np.ptp(z)).all(axis=1)]
        x = mesh.points[edges, 0] / self.space.unit
        order = np.argsort(x.min(axis=1))
        return edges[order], x[order]

    @cached_property
    def widths(self) -> np.ndarray:
        """Widths of the columns, length units."""
        return np.ptp(self._foot[1], axis=1)

    @property
    def held(self) -> np.ndarray:
        """True if a field is zero at a node, or absent: shape (functions, fields)."""
        columns = [FIELD_COLUMN[name] for name in self.names]
        absent, order = self.section.dofs[: self.section.bottom, columns] < 0, self.section.order
        faces = np.repeat(absent[::order], order - 1, axis=0)
        count = len(self.widths)
        return np.concatenate([np.tile(absent, (count + 1, 1)), np.tile(faces, (count, 1))])

    def line(self, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns (function times fields plus field) of the left or right line, and the section's for each."""
        columns = [FIELD_COLUMN[name] for name in self.names]
        dofs, number = self.section.dofs[: self.section.bottom, columns], len(self.widths) if side == "right" else 0
        unknowns = self._line(number)[:-1, None] * len(self.names) + np.arange(len(self.names))
        return unknowns[dofs >= 0], dofs[dofs >= 0]

    def _line(self, number: int) -> np.ndarray:
        """Functions on a line from the bottom up; the last is the vertex of the mesh."""
        edges, x = self._foot
        edge = min(number, len(edges) - 1)
        ends = edges[edge][np.argsort(x[edge])]
        vertex = self.space.edge_numbers(ends[None])[0, int(number == len(edges))]
        return np.append(self.space.skeleton + number * self.section.bottom + np.arange(self.section.bottom), vertex)

    @cached_property
    def elements(self) -> list[tuple[int, int]]:
        """Column and layer of every element."""
        return [(column, layer) for column in range(len(self.widths)) for layer in range(self.layers)]

    @cached_property
    def centers(self) -> np.ndarray:
        """Centres of the elements in m, shape (elements, 2)."""
        z, x = self.section.breakpoints[: self.layers + 1], self._foot[1].mean(axis=1)
        middle = (z[1:] + z[:-1]) / 2
        return np.array([(x[column], middle[layer]) for column, layer in self.elements]) * self.space.unit

    @cached_property
    def numbers(self) -> list[np.ndarray]:
        """Skeleton unknowns of every element in the order left, right, lower and upper face, fields innermost."""
        order, fields = self.section.order, np.arange(len(self.names))
        lines = [self._line(number) for number in range(len(self.widths) + 1)]
        first = self.space.skeleton + len(lines) * self.section.bottom
        faces = first + np.arange(len(self.elements) * (order - 1)).reshape(len(self.widths), self.layers, order - 1)
        inside = self.space.edge_numbers(self._foot[0])[:, 2:]
        result = []
        for column, layer in self.elements:
            left, right = (lines[column + k][layer * order : (layer + 1) * order + 1] for k in (0, 1))
            above = faces[column, layer + 1] if layer + 1 < self.layers else inside[column]
            rim = np.concatenate([left, right, faces[column, layer], above])
            result.append((rim[:, None] * len(self.names) + fields).ravel())
        return result

    def _on_rim(self, column: int, layer: int) -> np.ndarray | None:
        """S of equation (1): nodal values on an element's rim from its functions; None where they are the same."""
        if layer + 1 < self.layers:
            return None
        order = self.section.order
        x = self._foot[1][column]
        along = gll_nodes(order)[1:-1]
        values = self.space.edge_values(along if x[0] < x[1] else 1 - along)
        ends = values[:, :2] if x[0] < x[1] else values[:, 1::-1]
        inner = self.space.order - 1
        out = np.zeros((4 * order, 3 * order + 1 + inner))
        out[: 3 * order + 1, : 3 * order + 1] = np.eye(3 * order + 1)
        out[3 * order + 1 :, [order, 2 * order + 1]] = ends
        out[3 * order + 1 :, 3 * order + 1 :] = values[:, 2:]
        return np.kron(out, np.eye(len(self.names)))

    def _matrix(self, column: int, layer: int, frequency: float) -> np.ndarray:
        """Matrix of an element at a frequency in Hz, without condensation."""
        section = self.section
        angular = 2 * np.pi * frequency * section.length_unit
        height, medium = section.heights[layer], section.media[layer]
        return element_matrix(medium, self.widths[column], height, section.order, angular)

    def _kind(self, column: int, layer: int) -> tuple:
        """Key of an element: elements with equal keys have equal matrices over their `numbers`."""
        start, stop = self._foot[1][column]
        return round(float(self.widths[column]), 12), layer, bool(start < stop)

    def condensed(self, frequency: float) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Matrix of every element over its `numbers`, and all its nodes from them, at a frequency in Hz."""
        sets = ElementSets(self.section.order, len(self.names))
        done: dict[tuple, tuple[np.ndarray, np.ndarray]] = {}
        for column, layer in self.elements:
            kind = self._kind(column, layer)
            if kind in done:
                continue
            own, back = schur(self._matrix(column, layer, frequency), sets.rim, sets.inside)
            on_rim = self._on_rim(column, layer)
            on_rim = np.eye(len(sets.rim)) if on_rim is None else on_rim
            whole = np.empty((len(sets.rim) + len(sets.inside), on_rim.shape[1]), dtype=back.dtype)
            whole[sets.rim], whole[sets.inside] = on_rim, back @ on_rim
            done[kind] = on_rim.T @ own @ on_rim, whole
        both = [done[self._kind(column, layer)] for column, layer in self.elements]
        return [matrix for matrix, _ in both], [nodes for _, nodes in both]

    def _nodal(self, nodes: list[np.ndarray], skeleton: np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """Column, layer and values at all nodes of every element."""
        for (column, layer), numbers, own in zip(self.elements, self.numbers, nodes, strict=True):
            yield column, layer, own @ skeleton[numbers]

    def loss(self, nodes: list[np.ndarray], skeleton: np.ndarray, frequency: float) -> float:
        """Sum of u^H Im(A) u over the elements: what a matched layer absorbs too; ``nodes`` of `condensed`."""
        total = 0.0
        for column, layer, values in self._nodal(nodes, skeleton[:, None]):
            total += float(np.vdot(values, self._matrix(column, layer, frequency) @ values).imag)
        return total

    def inertia(self, nodes: list[np.ndarray], skeleton: np.ndarray, frequency: float) -> np.ndarray:
        """X^T M X of fields X, shape (columns of X,) * 2, with A = K - omega^2 M; s^2/rad^2."""
        total = np.zeros((skeleton.shape[1],) * 2, dtype=complex)
        for column, layer, values in self._nodal(nodes, skeleton):
            mass = self._matrix(column, layer, 0.0) - self._matrix(column, layer, frequency)
            total += values.T @ mass @ values
        return total / (2 * np.pi * frequency) ** 2
