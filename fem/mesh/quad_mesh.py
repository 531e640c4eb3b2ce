"""Any mesh as quadrilaterals, refined towards singular vertices.

Elements that are slender beside a singular vertex are halved first (`fem.mesh.even_corners`).  Every element is then
split into quadrilaterals (vertex, middle of an edge, centre, middle of the other edge), so that every edge of the new
mesh runs from a vertex of the file to the middle of one of its edges, or from there to a centre.  All neighbours then
agree on the direction of their common edge, which hierarchical elements need.  At a singular vertex v a quadrilateral
(v, a, c, b) is split into (v, A, C, B), (A, a, c, C) and (B, C, c, b) with A, B and C at `LAYER_RATIO` of the way, as
often as there are layers: a geometric mesh (Schwab, *p- and hp-Finite Element Methods*, 1998).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fem.mesh.even_corners import with_even_corners
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import ELECTRODE, SectionMesh
from fem.mesh.shape_functions import CORNERS, reference_corners, shape_functions

LAYER_RATIO = 0.15  # as in fem.discretize.element_sizes
STRAIGHT = np.deg2rad(0.5)  # a boundary that turns by less is straight
WEAK = np.deg2rad(30)  # the vertices of an arc that is drawn by edges are re-entrant by less, corners by more
SQUARE_NODES = np.array(  # of the quadratic map: corners, middles of the edges, centre
    [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5], [0.5, 0.5]], dtype=float
)


@dataclass(frozen=True, kw_only=True, eq=False)
class QuadMesh:
    """Quadrilaterals of a section mesh.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        m; the vertices, and behind them what the quadratic maps need.
    quads : ndarray, shape (elements, 4) or, for quadratic maps, (elements, 9)
    solids : ndarray, shape (elements,)
        Group of the surface.
    lines : dict
        Group to directed edges (vertex, vertex), shape (m, 2).
    boundary : ndarray, shape (m, 2)
        Directed outer edges.
    """

    points: np.ndarray = field(repr=False)
    quads: np.ndarray = field(repr=False)
    solids: np.ndarray = field(repr=False)
    lines: dict[str, np.ndarray] = field(repr=False)
    boundary: np.ndarray = field(repr=False)

    def size(self, solid: str) -> float:
        """Longest edge of a solid's quadrilaterals, m."""
        corners = self.points[self.quads[self.solids == solid, :4]]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max())


class _Quad(NamedTuple):
    """A quadrilateral while the mesh is split; layers may be added at its first vertex."""

    owner: tuple[int, int]  # element of the file: block of cells, number in it
    vertices: tuple[int, int, int, int]
    reference: np.ndarray  # of the vertices in the element's reference triangle or square, (4, 2)


Edges = list[tuple[int, int]]


class _Splitting:
    """The vertices of a mesh that is being split, numbered in the order in which they are made.

    A key describes how a vertex was made, so that neighbouring elements share the one on their common edge:
    ("middle", a, b) of two vertices a < b, ("centre", ...) of an element or a quadrilateral, ("layer", v, b) on the
    edge from a singular vertex v to b.  The nodes of the file come first.
    """

    def __init__(self, mesh: SectionMesh):
        self.mesh = mesh
        self.number: dict[tuple, int] = {}
        self.made: list[tuple[tuple[int, int], np.ndarray]] = []  # an element that holds it, its reference position

    def vertex(self, key: tuple, owner: tuple[int, int], reference: np.ndarray) -> int:
        """Number of the vertex with a key; a new one if it is the first."""
        if key not in self.number:
            self.number[key] = len(self.mesh.points) + len(self.made)
            self.made.append((owner, reference))
        return self.number[key]

    def middle(self, one: int, other: int) -> int:
        """Number of the middle of two vertices, which has been made."""
        return self.number["middle", min(one, other), max(one, other)]

    def initial(self) -> Iterator[_Quad]:
        """Every element in three or four: (corner, middle of an edge, centre, middle of the other edge)."""
        for block, cells in enumerate(self.mesh.cells):
            count, corners = CORNERS[cells.kind], reference_corners(cells.kind)
            centre_reference = corners.mean(axis=0)
            for element, nodes in enumerate(cells.nodes[:, :count].tolist()):
                owner = block, element
                centre = self.vertex(("centre", *owner), owner, centre_reference)
                middles = []
                for side in range(count):
                    one, other = nodes[side], nodes[(side + 1) % count]
                    reference = 0.5 * (corners[side] + corners[(side + 1) % count])
                    key = "middle", min(one, other), max(one, other)
                    middles.append((self.vertex(key, owner, reference), reference))
                for corner, node in enumerate(nodes):
                    (ahead, at_ahead), (behind, at_behind) = middles[corner], middles[corner - 1]
                    reference = np.array([corners[corner], at_ahead, centre_reference, at_behind])
                    yield _Quad(owner, (node, ahead, centre, behind), reference)

    def halved(self, quads: list[_Quad]) -> list[_Quad]:
        """Every quadrilateral in four."""
        result = []
        for owner, (v, a, c, b), reference in quads:
            edges = ((v, a), (a, c), (b, c), (v, b))
            pv, pa, pc, pb = reference
            p_va, p_ac, p_bc, p_vb = ends = 0.5 * np.array([pv + pa, pa + pc, pb + pc, pv + pb])
            va, ac, bc, vb = (
                self.vertex(("middle", min(edge), max(edge)), owner, reference)
                for edge, reference in zip(edges, ends, strict=True)
            )
            p_o = reference.mean(axis=0)
            o = self.vertex(("centre", v, a, c, b), owner, p_o)
            result += [
                _Quad(owner, (v, va, o, vb), np.array([pv, p_va, p_o, p_vb])),
                _Quad(owner, (va, a, ac, o), np.array([p_va, pa, p_ac, p_o])),
                _Quad(owner, (vb, o, bc, b), np.array([p_vb, p_o, p_bc, pb])),
                _Quad(owner, (o, ac, c, bc), np.array([p_o, p_ac, pc, p_bc])),
            ]
        return result

    def layered(self, quads: list[_Quad], singular: set[int]) -> list[_Quad]:
        """One layer at every quadrilateral that begins at a singular vertex."""
        result = []
        for quad in quads:
            owner, (v, a, c, b), reference = quad
            if v not in singular:
                result.append(quad)
                continue
            pv, pa, pc, pb = reference
            near = [pv + LAYER_RATIO * (p - pv) for p in (pa, pc, pb)]
            A, C, B = (self.vertex(("layer", v, end), owner, at) for end, at in zip((a, c, b), near, strict=True))
            result += [
                _Quad(owner, (v, A, C, B), np.array([pv, *near])),
                _Quad(owner, (A, a, c, C), np.array([near[0], pa, pc, near[1]])),
                _Quad(owner, (B, C, c, b), np.array([near[2], near[1], pc, pb])),
            ]
        return result

    def halved_edges(self, edges: Edges) -> Edges:
        """Every edge in two, in its direction."""
        return [part for a, b in edges for m in [self.middle(a, b)] for part in ((a, m), (m, b))]

    def layered_edges(self, edges: Edges) -> Edges:
        """Edges, those from a singular vertex in two where the layer cuts them."""
        result: Edges = []
        for start, stop in edges:
            near = self.number.get(("layer", start, stop))
            result += [(start, stop)] if near is None else [(start, near), (near, stop)]
        return result

    def positions(self, owners: list[tuple[int, int]], reference: np.ndarray) -> np.ndarray:
        """Positions (m, 2) of reference positions in elements."""
        out = np.empty((len(reference), 2))
        block_of, element_of = np.array(owners, dtype=int).reshape(-1, 2).T
        for block, cells in enumerate(self.mesh.cells):
            here = np.flatnonzero(block_of == block)
            values = shape_functions(cells.kind, reference[here])
            nodes = cells.nodes[element_of[here]]
            out[here] = np.einsum("mn,mnd->md", values, self.mesh.points[nodes])
        return out


def quad_mesh(mesh: SectionMesh, *, layers: int, largest: dict[str, float], conditions: dict[str, str]) -> QuadMesh:
    """Split a mesh into quadrilaterals of at most a size, with layers towards its singular vertices.

    ``largest``: largest edge in m, by solid; ``conditions``: boundary condition by line group, as a word.  Where it
    changes along the boundary, the field is singular.
    """
    counts = {vertex: corner_layers(turn, layers) for vertex, turn in singular_vertices(mesh, conditions).items()}
    mesh = with_even_corners(mesh, {vertex for vertex, count in counts.items() if count})
    splitting = _Splitting(mesh)
    quads = list(splitting.initial())
    groups = {name: nodes.tolist() for name, nodes in mesh.lines.items()} | {"": mesh.boundary}
    lines: dict[str, Edges] = {  # edges run from the nodes of the file to the middles
        name: [(node, splitting.middle(*pair)) for pair in pairs for node in pair] for name, pairs in groups.items()
    }
    for _ in range(_halvings(splitting, quads, largest)):
        quads = splitting.halved(quads)
        lines = {name: splitting.halved_edges(edges) for name, edges in lines.items()}
    for layer in range(layers):
        quads = splitting.layered(quads, {vertex for vertex, count in counts.items() if count > layer})
        lines = {name: splitting.layered_edges(edges) for name, edges in lines.items()}
    return _finished(splitting, quads, lines)


def _halvings(splitting: _Splitting, quads: list[_Quad], largest: dict[str, float]) -> int:
    """Number of halvings of every quadrilateral after which none is too large."""
    owners = [quad.owner for quad in quads for _ in range(4)]
    corners = splitting.positions(owners, np.concatenate([quad.reference for quad in quads])).reshape(-1, 4, 2)
    sizes = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)
    allowed = np.array([largest[splitting.mesh.cells[quad.owner[0]].solid] for quad in quads])
    return max(0, int(np.ceil(np.log2(np.max(sizes / allowed)) - 1e-9)))


def _finished(splitting: _Splitting, quads: list[_Quad], lines: dict[str, Edges]) -> QuadMesh:
    """The mesh with its vertices renumbered, without those that belong to no quadrilateral."""
    mesh = splitting.mesh
    made = splitting.positions(
        [owner for owner, _ in splitting.made], np.array([reference for _, reference in splitting.made])
    )
    points, vertices = np.concatenate([mesh.points, made]), np.array([quad.vertices for quad in quads])
    if any(cells.kind not in ("triangle", "quad") for cells in mesh.cells):
        corners_reference = np.array([quad.reference for quad in quads])
        reference = np.einsum("nk,ekd->end", shape_functions("quad", SQUARE_NODES[4:]), corners_reference)
        extra = splitting.positions([quad.owner for quad in quads for _ in range(5)], reference.reshape(-1, 2))
        numbers = len(points) + np.arange(len(extra)).reshape(-1, 5)
        points, vertices = np.concatenate([points, extra]), np.hstack([vertices, numbers])
    corners = np.unique(vertices[:, :4])
    used = np.concatenate([corners, np.setdiff1d(np.unique(vertices), corners)])
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    return QuadMesh(
        points=points[used],
        quads=number[vertices],
        solids=np.array([mesh.cells[quad.owner[0]].solid for quad in quads]),
        lines={name: number[np.array(edges).reshape(-1, 2)] for name, edges in lines.items() if name},
        boundary=number[np.array(lines[""]).reshape(-1, 2)],
    )


def corner_layers(turn: float, layers: int) -> int:
    """Number of layers towards a corner at which the body's angle exceeds pi by ``turn``, rad.

    ``layers``: their number at a sharp corner.

    The displacement varies as r^e there, with e = 1 - 2 turn / pi for a small turn (Williams, J. Appl. Mech. 19 (1952)
    526), which pi / (pi + 2 turn) continues to larger ones.  Its singular part is proportional to the turn.  The error
    is of second order in that part.  An arc that is drawn by edges has the more vertices the less they turn, so that
    the sum of their errors is proportional to the turn; a layer divides it by `LAYER_RATIO`^(-2 e).  The returned
    number leaves the same error as ``layers`` layers at a turn of pi / 2.

    The reflection of a groove 0.8 mm wide and 0.2 mm deep whose bottom is drawn by 4, 8 or 16 edges (turns of 27, 13
    and 7 degrees) then errs by 3.4e-6, 3.1e-6 and 1.7e-6 at level 2; with all layers by 2.8e-6, 3.0e-6 and 1.1e-6;
    with none by 2.4e-4, 7e-5 and 2.6e-5.
    """
    if turn >= WEAK:
        return layers
    exponent = np.pi / (np.pi + 2 * turn)
    weaker = 0.5 * np.log(np.pi / 2 / turn) / np.log(1 / LAYER_RATIO)
    return max(0, int(np.ceil((0.5 * layers - weaker) / exponent)))


def singular_vertices(mesh: SectionMesh, conditions: dict[str, str]) -> dict[int, float]:
    """Vertices of the file at which stress or charge is singular, and how far the body's angle there exceeds pi, rad.

    They are re-entrant corners of the boundary and, with an infinite angle, ends and corners of electrodes, vertices of
    the boundary at which the condition changes, and vertices at which solids meet at a corner or at the boundary.
    """
    angle = np.zeros(len(mesh.points))
    touching: list[dict[str, float]] = [{} for _ in mesh.points]
    for cells in mesh.cells:
        count = CORNERS[cells.kind]
        for nodes, own in zip(cells.nodes[:, :count].tolist(), _corner_angles(mesh, cells), strict=True):
            for node, value in zip(nodes, own, strict=True):
                angle[node] += value
                touching[node][cells.solid] = touching[node].get(cells.solid, 0.0) + value
    sharp: set[int] = set()
    turns: dict[int, float] = {}
    outer = {node for edge in mesh.boundary for node in edge}
    faces = {node for name in ("left", "right") if name in mesh.lines for node in mesh.lines[name].ravel()}
    for node, solids in enumerate(touching):
        if node in outer and angle[node] > np.pi + STRAIGHT:
            turns[node] = float(angle[node] - np.pi)
        if node in outer:
            meets = len(solids) > 1
        else:
            meets = len(solids) > 2 or (len(solids) == 2 and abs(next(iter(solids.values())) - np.pi) > STRAIGHT)
        if meets:
            sharp.add(node)
    group_at: dict[tuple[int, int], str] = {}
    for name, nodes in mesh.lines.items():
        for one, other in nodes.tolist():
            group_at[min(one, other), max(one, other)] = conditions.get(name, "")
        if name.startswith(ELECTRODE):
            sharp |= _ends_and_corners(mesh, nodes)
    conditions_at: dict[int, set[str]] = {}
    for one, other in mesh.boundary:
        condition = group_at.get((min(one, other), max(one, other)), "")
        for node in (one, other):
            conditions_at.setdefault(node, set()).add(condition)
    sharp |= {node for node, words in conditions_at.items() if len(words) > 1 and node not in faces}
    return turns | {int(node): np.inf for node in sharp}


def _ends_and_corners(mesh: SectionMesh, lines: np.ndarray) -> set[int]:
    """Nodes at which lines end, branch, or turn."""
    neighbours: dict[int, list[int]] = {}
    for one, other in lines.tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    nodes = set()
    for node, others in neighbours.items():
        if len(others) != 2:
            nodes.add(node)
            continue
        directions = mesh.points[others] - mesh.points[node]
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        if directions[0] @ directions[1] > -np.cos(STRAIGHT):
            nodes.add(node)
    return nodes


def _corner_angles(mesh: SectionMesh, cells) -> np.ndarray:
    """Angles of the elements at their corners, towards the nodes beside them, shape (elements, corners)."""
    count = CORNERS[cells.kind]
    corners = mesh.points[cells.nodes[:, :count]]
    ahead, behind = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
    if cells.nodes.shape[1] > count:  # the tangent of a quadratic edge at its end
        middles = mesh.points[cells.nodes[:, count : 2 * count]]
        ahead = 4 * middles - ahead - 2 * corners
        behind = 4 * np.roll(middles, 1, axis=1) - behind - 2 * corners
    one, other = ahead - corners, behind - corners
    cross = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return np.mod(np.arctan2(cross, np.sum(one * other, axis=-1)), 2 * np.pi)


def conditions_of(piece: MeshPiece, bottom: str) -> dict[str, str]:
    """Boundary condition on the lines of each group, as a word; ``bottom``: the stator's condition there."""
    words = {"bottom": "" if bottom == "free" else bottom, "surface": ""}
    for name in piece.mesh.lines:
        words.setdefault(name, name)
    return words
