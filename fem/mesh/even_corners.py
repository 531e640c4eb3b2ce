"""Triangles of even size around singular vertices.

Geometric layers towards a singular vertex keep the shapes of the elements there.  If an edge at the vertex is much
longer than the shortest one there, or another edge much longer than its distance from the vertex, no layer resolves the
field between the two lengths, and a level divides the error by 1.3 to 2 instead of 8.  Long edges are therefore halved
first, by longest-edge bisection, which keeps the mesh conforming and its angles above half of the smallest (Rivara,
Int. J. Numer. Methods Eng. 20 (1984) 745).
"""

from dataclasses import replace

import numpy as np

from fem.mesh.section_mesh import Cells, SectionMesh
from fem.mesh.shape_functions import CORNERS, shape_functions

EVEN = 6.0  # ratio of the lengths; grooves meshed with ratios of 16 and 40 then converge by 8 a level, as even meshes


def with_even_corners(mesh: SectionMesh, singular: set[int]) -> SectionMesh:
    """Halve edges that are long beside their distance from a singular vertex; nodes keep their numbers."""
    if not _long_edges(mesh.points, list(mesh.edges), singular):
        return mesh
    triangles = _Triangles(mesh)
    while edges := _long_edges(triangles.points, triangles.edges, singular):
        for edge in edges:
            triangles.halve(*edge)
    return triangles.mesh()


def _long_edges(points, edges: list[tuple[int, int]], singular: set[int]) -> list[tuple[int, int]]:
    """Edges longer than `EVEN` times the length allowed at one of their ends.

    It is the shortest edge at a singular vertex, and elsewhere the distance to the nearest singular vertex.
    """
    from scipy.spatial import cKDTree

    if not singular:
        return []
    positions, ends = np.asarray(points), np.array(edges)
    lengths = np.linalg.norm(positions[ends[:, 0]] - positions[ends[:, 1]], axis=1)
    corners = np.array(sorted(singular))
    allowed, _ = cKDTree(positions[corners]).query(positions)
    allowed[corners] = np.inf
    for column in (0, 1):
        at_corner = np.isin(ends[:, column], corners)
        np.minimum.at(allowed, ends[at_corner, column], lengths[at_corner])
    return [edges[k] for k in np.flatnonzero(lengths > EVEN * allowed[ends].min(axis=1))]


class _Triangles:
    """Triangles that are halved one by one: corners and, in quadratic meshes, the middles of the three edges."""

    def __init__(self, source: SectionMesh):
        self.source = source
        self.points = list(source.points)
        self.quadratic = any(cells.kind not in ("triangle", "quad") for cells in source.cells)
        self.nodes: dict[int, tuple[int, ...]] = {}
        self.solid: dict[int, str] = {}
        self.owners: dict[tuple[int, int], set[int]] = {}  # of an edge
        self.middle: dict[tuple[int, int], int] = {}  # node in the middle of an edge
        self.cut: dict[tuple[int, int], int] = {}  # vertex that halves an edge
        self.made = 0
        for cells in source.cells:
            for own in cells.nodes.tolist():
                for nodes in self._split(cells.kind, own):
                    self._add(nodes, cells.solid)

    def _split(self, kind: str, own: list[int]) -> list[tuple[int, ...]]:
        """An element as triangles; a quadrilateral along its shorter diagonal."""
        count = CORNERS[kind]
        corners, sides = own[:count], own[count : 2 * count]
        if count == 3:
            return [tuple(own)] if len(own) == 3 or self.quadratic else [tuple(corners)]
        a, b, c, d = corners
        first = self.length(a, c) <= self.length(b, d)
        halves = [((a, b, c), (0, 1)), ((c, d, a), (2, 3))] if first else [((b, c, d), (1, 2)), ((d, a, b), (3, 0))]
        if not sides:
            return [nodes for nodes, _ in halves]
        center = shape_functions(kind, np.array([[0.5, 0.5]]))[0] @ self.source.points[own]
        diagonal = self._node(center)
        return [(*nodes, sides[k], sides[m], diagonal) for nodes, (k, m) in halves]

    def _node(self, position) -> int:
        self.points.append(np.asarray(position))
        return len(self.points) - 1

    def _add(self, nodes: tuple[int, ...], solid: str) -> None:
        self.nodes[self.made], self.solid[self.made] = nodes, solid
        for k in range(3):
            edge = _key(nodes[k], nodes[(k + 1) % 3])
            self.owners.setdefault(edge, set()).add(self.made)
            if len(nodes) == 6:
                self.middle[edge] = nodes[3 + k]
        self.made += 1

    def length(self, one: int, other: int) -> float:
        return float(np.linalg.norm(self.points[one] - self.points[other]))

    @property
    def edges(self) -> list[tuple[int, int]]:
        """Edges of all triangles."""
        return [edge for edge, owners in self.owners.items() if owners]

    def _longest(self, triangle: int) -> tuple[int, int]:
        corners = self.nodes[triangle][:3]
        edges = [_key(corners[k], corners[(k + 1) % 3]) for k in range(3)]
        return max(edges, key=lambda edge: (self.length(*edge), edge))

    def halve(self, one: int, other: int) -> None:
        """Halve an edge, and before it every longer one of its triangles."""
        edge = _key(one, other)
        while self.owners[edge]:
            longer = [self._longest(each) for each in self.owners[edge]]
            ahead = next((each for each in longer if each != edge), None)
            if ahead is not None:
                self.halve(*ahead)
                continue
            for triangle in sorted(self.owners[edge]):
                self._halve_triangle(triangle, edge)

    def _halve_triangle(self, triangle: int, edge: tuple[int, int]) -> None:
        """Replace a triangle by two, cut from the middle of an edge to the opposite corner."""
        nodes, solid = self.nodes.pop(triangle), self.solid.pop(triangle)
        first = next(k for k in range(3) if _key(nodes[k], nodes[(k + 1) % 3]) == edge)
        turn = [first, (first + 1) % 3, (first + 2) % 3]
        a, b, c = (nodes[k] for k in turn)
        for k in range(3):
            self.owners[_key(nodes[k], nodes[(k + 1) % 3])].discard(triangle)
        if len(nodes) == 3:
            if edge not in self.cut:
                self.cut[edge] = self._node(0.5 * (self.points[a] + self.points[b]))
            m = self.cut[edge]
            self._add((a, m, c), solid)
            self._add((m, b, c), solid)
            return
        ab, bc, ca = (nodes[3 + k] for k in turn)
        own = np.array([self.points[each] for each in (a, b, c, ab, bc, ca)])
        m = self.cut[edge] = ab

        def half(end: int, x: float, y: float) -> int:
            key = _key(end, m)
            if key not in self.middle:
                self.middle[key] = self._node(shape_functions("triangle6", np.array([[x, y]]))[0] @ own)
            return self.middle[key]

        am, mb, mc = half(a, 0.25, 0.0), half(b, 0.75, 0.0), half(c, 0.25, 0.5)
        self._add((a, m, c, am, mc, ca), solid)
        self._add((m, b, c, mb, bc, mc), solid)

    def mesh(self) -> SectionMesh:
        """The triangles as a mesh, the lines of its groups halved with their edges."""

        def parts(one: int, other: int) -> list[tuple[int, int]]:
            middle = self.cut.get(_key(one, other))
            return [(one, other)] if middle is None else parts(one, middle) + parts(middle, other)

        kind = "triangle6" if self.quadratic else "triangle"
        cells = tuple(
            Cells(kind=kind, solid=solid, nodes=np.array([self.nodes[k] for k in self.nodes if self.solid[k] == solid]))
            for solid in dict.fromkeys(self.solid.values())
        )
        lines = {
            name: np.array([half for line in own.tolist() for half in parts(*line)])
            for name, own in self.source.lines.items()
        }
        return replace(self.source, points=np.array(self.points), cells=cells, lines=lines)


def _key(one: int, other: int) -> tuple[int, int]:
    return (one, other) if one < other else (other, one)
