"""High-order elements on a mesh of quadrilaterals: basis functions, and integration of stiffness and inertia.

The basis is integrated Legendre polynomials (scikit-fem's `ElementQuadP`): vertices, edges, insides.  Its odd edge
functions are continuous because neighbours agree on the direction of their edge (`fem.mesh.quad_mesh`).
"""

from functools import cached_property

import numpy as np

from fem.materials.medium import Medium
from fem.mesh.quad_mesh import QuadMesh
from fem.mesh.shape_functions import shape_functions

CHUNK_BYTES = 2e8  # largest memory of the basis functions in a batch of elements
# The scalar matrices of a mesh are kept for other frequencies if they take less memory than this.
KEPT_BYTES = 3e8
LOCATED = 1e-8  # a point lies in an element if it is nearer to it than this fraction of the element's size
NEWTON_STEPS = 8
ROUNDED = 1e-3  # of a piece's width, which is 1e-3 of the stator or more: fem.layout allows 1e-6 of the stator


class QuadSpace:
    """Scalar finite-element space of one order on quadrilaterals; lengths in a unit.

    Attributes
    ----------
    mesh : QuadMesh
    order : int
    unit : float
        m.
    """

    def __init__(self, mesh: QuadMesh, order: int, unit: float):
        from skfem import ElementQuadP, MeshQuad, MeshQuad2
        from skfem.assembly import Dofs

        self.mesh, self.order, self.unit = mesh, order, unit
        kind = MeshQuad if mesh.quads.shape[1] == 4 else MeshQuad2
        self._mesh = kind(np.ascontiguousarray(mesh.points.T / unit), np.ascontiguousarray(mesh.quads.T))
        self._dofs = Dofs(self._mesh, ElementQuadP(order))
        self._scalars: dict[bytes, np.ndarray] = {}

    @property
    def elements(self) -> int:
        """Number of quadrilaterals."""
        return len(self.mesh.quads)

    @property
    def functions(self) -> int:
        """Basis functions of an element."""
        return (self.order + 1) ** 2

    @property
    def rim(self) -> int:
        """Basis functions of an element that its neighbours share: they come first."""
        return 4 * self.order

    @property
    def skeleton(self) -> int:
        """Functions of vertices and edges in the whole mesh: they are numbered first."""
        return int(self._dofs.N - self.elements * (self.order - 1) ** 2)

    @property
    def size(self) -> int:
        """Functions in the whole mesh."""
        return int(self._dofs.N)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Numbers of the functions of every element, shape (elements, functions)."""
        return np.ascontiguousarray(self._dofs.element_dofs.T)

    @cached_property
    def _facets(self) -> dict[tuple[int, int], int]:
        return {(int(a), int(b)): index for index, (a, b) in enumerate(np.sort(self._mesh.facets, axis=0).T)}

    def edge_numbers(self, edges: np.ndarray) -> np.ndarray:
        """Numbers of the functions of directed edges (m, 2): start, stop, inside; shape (m, order + 1)."""
        facets = [self._facets[min(a, b), max(a, b)] for a, b in edges.tolist()]
        ends = self._dofs.nodal_dofs[0][edges]
        return np.hstack([ends, self._dofs.facet_dofs[:, facets].T])

    def edge_values(self, along: np.ndarray) -> np.ndarray:
        """Values of an edge's functions, ordered as in `edge_numbers`, at positions in [0, 1]: (m, order + 1)."""
        return self._line_values(np.asarray(along, dtype=float))[0]

    def locate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Element that contains each point (m, 2), or -1, and the position of the point in its reference square."""
        nodes = self._nodes(slice(None))
        owner, references = np.full(len(points), -1), np.zeros((len(points), 2))
        low, high = nodes.min(axis=1), nodes.max(axis=1)
        room = LOCATED * (high - low).max(axis=1)
        order = np.argsort(points[:, 0], kind="stable")
        first = np.searchsorted(points[order, 0], low[:, 0] - room, side="left")
        last = np.searchsorted(points[order, 0], high[:, 0] + room, side="right")
        for element in range(self.elements):
            at = order[first[element] : last[element]]
            near = abs(points[at, 1] - (low + high)[element, 1] / 2) <= (high - low)[element, 1] / 2 + room[element]
            here = at[near & (owner[at] < 0)]
            if not len(here):
                continue
            reference, error = _inverse(self._kind, nodes[element], points[here])
            inside = (np.abs(reference - 0.5) <= 0.5 + LOCATED).all(axis=1) & (error <= room[element])
            owner[here[inside]], references[here[inside]] = element, np.clip(reference[inside], 0.0, 1.0)
        return owner, references

    def local_values(self, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values and both derivatives of an element's functions at reference positions (m, 2), (m, functions) each."""
        across, along = (self._line_values(reference[:, axis]) for axis in (0, 1))
        pairs = np.array(self._pairs)
        (a, da), (b, db) = ((each[0], each[1]) for each in (across, along))
        i, j = pairs.T
        return a[:, i] * b[:, j], da[:, i] * b[:, j], a[:, i] * db[:, j]

    def _line_values(self, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        from skfem.element.element_line.element_line_pp import ElementLinePp

        element = ElementLinePp(self.order)
        both = [element.lbasis(reference[None], index) for index in range(self.order + 1)]
        return np.stack([each for each, _ in both], axis=1), np.stack([each[0] for _, each in both], axis=1)

    @cached_property
    def _pairs(self) -> list[tuple[int, int]]:
        """Pairs of one-dimensional functions whose products are the element's functions: vertices, edges, inside."""
        more = range(2, self.order + 1)
        edges = [[(k, 0) for k in more], [(1, k) for k in more], [(k, 1) for k in more], [(0, k) for k in more]]
        inside = [(i, j) for i in more for j in more]
        return [(0, 0), (1, 0), (1, 1), (0, 1), *(pair for edge in edges for pair in edge), *inside]

    def slopes(self, elements, reference: np.ndarray) -> np.ndarray:
        """Derivatives of the reference coordinates by x and z at reference positions (m, 2): (..., m, reference, 2)."""
        return np.linalg.inv(_jacobian(self._kind, self._nodes(elements), reference))

    def positions(self, elements, reference: np.ndarray) -> np.ndarray:
        """Points of elements at reference positions (m, 2): (..., m, 2)."""
        return shape_functions(self._kind, reference) @ self._nodes(elements)

    @property
    def _kind(self) -> str:
        return "quad" if self.mesh.quads.shape[1] == 4 else "quad9"

    def _nodes(self, elements) -> np.ndarray:
        """Nodes of elements, length units, (..., 4 or 9, 2)."""
        return self.mesh.points[self.mesh.quads[elements]] / self.unit

    def chunks(self, elements: np.ndarray):
        """Yield elements in parts whose basis functions fit into memory."""
        per_element = self.functions * (self.order + 2) ** 2 * 3 * 8
        count = max(1, int(CHUNK_BYTES / per_element))
        for start in range(0, len(elements), count):
            yield elements[start : start + count]

    def scalar_matrices(self, elements: np.ndarray) -> np.ndarray:
        """Integrals of v_x u_x, v_x u_z, v_z u_x, v_z u_z and v u of some elements, (m, 5, functions, functions)."""
        from skfem import Basis, ElementQuadP

        key = elements.tobytes()
        if key in self._scalars:
            return self._scalars[key]
        # A new ElementQuadP for each call, because it caches values of its last evaluation, which threads would share.
        basis = Basis(self._mesh, ElementQuadP(self.order), elements=elements, intorder=2 * self.order + 2)
        weights = basis.dx[:, None, :]
        value = np.stack([np.array(each[0]) for each in basis.basis], axis=1)
        across, up = (np.stack([each[0].grad[axis] for each in basis.basis], axis=1) for axis in (0, 1))
        weighted = weights * across
        mixed = weighted @ up.swapaxes(1, 2)
        scalars = np.stack(
            [
                weighted @ across.swapaxes(1, 2),
                mixed,
                mixed.swapaxes(1, 2),
                (weights * up) @ up.swapaxes(1, 2),
                (weights * value) @ value.swapaxes(1, 2),
            ],
            axis=1,
        )
        if 40 * self.elements * self.functions**2 < KEPT_BYTES:
            self._scalars[key] = scalars
        return scalars


def _jacobian(kind: str, nodes: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Derivatives of x and z by the reference coordinates, (m, 2, reference); exact for polynomials of degree 2."""
    step = 0.5
    columns = []
    for axis in (0, 1):
        shift = step * np.eye(2)[axis]
        ahead, behind = (shape_functions(kind, reference + sign * shift) @ nodes for sign in (1, -1))
        columns.append((ahead - behind) / (2 * step))
    return np.stack(columns, axis=-1)


def _inverse(kind: str, nodes: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reference positions of points by Newton's method, and the distances that remain."""
    reference = np.full(points.shape, 0.5)
    for _ in range(NEWTON_STEPS):
        gap = shape_functions(kind, reference) @ nodes - points
        reference = reference - np.linalg.solve(_jacobian(kind, nodes, reference), gap[..., None])[..., 0]
        reference = np.clip(reference, -1.0, 2.0)
    return reference, np.abs(shape_functions(kind, reference) @ nodes - points).max(axis=1)


def medium_tables(medium: Medium, angular: float, *, part: str = "all") -> np.ndarray:
    """Coefficients of the five scalar matrices (`QuadSpace.scalar_matrices`) for a medium, (fields, fields, 5).

    ``angular``: omega times the length unit, m/s; ``part`` as in `fem.discretize.element_matrices.element_matrix`.
    """
    inertia = -(angular**2) * np.diag(medium.inertia)
    tables = np.stack([medium.xx, medium.xz, medium.xz.T, medium.zz, inertia], axis=-1)
    return np.imag(tables) if part == "loss" else tables


def medium_block(scalars: np.ndarray, tables: np.ndarray, rows: slice, columns: slice) -> np.ndarray:
    """Block of the matrices of elements of one medium; the functions of each field are contiguous.

    Shape (elements, fields * rows, fields * columns).
    """
    fields = len(tables)
    own = np.ascontiguousarray(scalars[:, :, rows, columns])
    m, _, first, second = own.shape
    own, flat = own.reshape(m, 5, -1), tables.reshape(-1, 5)
    out = np.empty((m, fields, first, fields, second), dtype=tables.dtype)
    parts = ((out.real, flat.real), (out.imag, flat.imag)) if np.iscomplexobj(tables) else ((out, flat),)
    for target, factors in parts:
        blocks = (factors @ own).reshape(m, fields, fields, first, second)
        target[...] = blocks.swapaxes(2, 3)
    return out.reshape(m, fields * first, fields * second)


class TopEdges:
    """Upper boundary of a mesh: the highest boundary edge at each x, and the basis functions there."""

    def __init__(self, space: QuadSpace):
        self.space = space
        edges, points = space.mesh.boundary, space.mesh.points / space.unit
        self.numbers = space.edge_numbers(edges)
        start, stop = points[edges[:, 0]], points[edges[:, 1]]
        middle = 0.5 * (start + stop)
        if space.mesh.quads.shape[1] > 4:
            middles = {}
            for quad in space.mesh.quads.tolist():
                for side, (one, other) in enumerate(((0, 1), (1, 2), (2, 3), (0, 3))):
                    middles[min(quad[one], quad[other]), max(quad[one], quad[other])] = quad[4 + side]
            middle = points[[middles[min(a, b), max(a, b)] for a, b in edges.tolist()]]
        # position = start + t * linear + t^2 * quadratic
        self.start, self.quadratic = start, 2 * (start - 2 * middle + stop)
        self.linear = stop - start - self.quadratic
        low, high = np.minimum(start[:, 0], stop[:, 0]), np.maximum(start[:, 0], stop[:, 0])
        flat = high - low > 1e-9 * np.linalg.norm(stop - start, axis=1)
        self.low, self.high = np.where(flat, low, np.inf), np.where(flat, high, -np.inf)

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (points, order + 1) and values of the functions at the highest boundary point above each x.

        A mesh may end beside the stator's end by a rounding of its file: a point there is moved to the mesh.
        """
        numbers, along = np.empty((len(x), self.numbers.shape[1]), dtype=int), np.empty(len(x))
        lowest, highest = self.low.min(), self.high.max()
        room = 1e-9 * (highest - lowest)
        if np.any(abs(x - np.clip(x, lowest, highest)) > ROUNDED * (highest - lowest)):
            raise ValueError("x must lie on the piece")
        x = np.clip(x, lowest, highest)
        for index, position in enumerate(x):
            here = np.flatnonzero((self.low <= position + room) & (self.high >= position - room))
            if not len(here):
                raise ValueError("x must lie on the piece: it has no surface there")
            a, b, c = self.quadratic[here, 0], self.linear[here, 0], self.start[here, 0] - position
            root = np.sqrt(np.maximum(b**2 - 4 * a * c, 0.0))
            t = np.clip(-2 * c / (b + np.where(b < 0, -root, root)), 0.0, 1.0)
            heights = self.start[here, 1] + t * self.linear[here, 1] + t**2 * self.quadratic[here, 1]
            best = int(np.argmax(heights))
            numbers[index], along[index] = self.numbers[here[best]], t[best]
        return numbers, self.space.edge_values(along)
