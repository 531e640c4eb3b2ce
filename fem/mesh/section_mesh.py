"""A mesh of a piece of the section as its file holds it, read by meshio and checked.

The file lies in the plane (x, z): its first coordinate is x, its second z, and z = 0 is the stator's surface.  Its
physical groups say what is what.  Groups of surfaces: ``stator``, or a name that the scene gives a material.  Groups
of lines: ``left`` and ``right`` (the vertical lines where the piece meets the uniform stator), ``bottom`` (takes the
stator's condition), ``clamped``, ``grounded``, ``electrode:NAME`` and ``surface``; every other outer line is bare: no
traction, D_n = 0.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fem.mesh.gmsh_file import ELECTRODE, Cells, MeshError, check_groups, grouped, parsed, where
from fem.mesh.shape_functions import CORNERS
from fem.parameters import refuses

MIN_AREA = 1e-9  # over the square of the element's longest edge; smaller ones are refused
MAX_OFF_PLANE = 1e-9  # variation of the third coordinate over the extent of the mesh
FARTHEST = 1e3  # m: no stator is that long, and squares of lengths stay finite
SAME = 1e-6  # of the height: points nearer than this are one


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionMesh:
    """Mesh of a piece of the section, lengths in m; two are equal if file and unit are.

    Attributes
    ----------
    name : str
        Of the file, without its folder and suffix.
    digest : str
        SHA-256 of the file's content and of the unit.
    unit : float
        Of the file's numbers, m.
    points : ndarray, shape (n, 2)
        x and z in m.
    cells : tuple of Cells
        Corners anticlockwise.
    lines : dict
        Group to the nodes of its lines, shape (m, 2).
    """

    name: str
    digest: str
    unit: float
    points: np.ndarray = field(repr=False)
    cells: tuple[Cells, ...] = field(repr=False)
    lines: dict[str, np.ndarray] = field(repr=False)

    def __eq__(self, other):
        return self.digest == other.digest if isinstance(other, SectionMesh) else NotImplemented

    def __hash__(self):
        return hash(self.digest)

    @property
    def solids(self) -> tuple[str, ...]:
        """Names of the surface groups."""
        return tuple(dict.fromkeys(each.solid for each in self.cells))

    @property
    def electrodes(self) -> tuple[str, ...]:
        """Names of the electrodes."""
        return tuple(name.removeprefix(ELECTRODE) for name in sorted(self.lines) if name.startswith(ELECTRODE))

    @property
    def extent(self) -> tuple[float, float]:
        """Smallest and largest x of the mesh in m."""
        return float(self.points[:, 0].min()), float(self.points[:, 0].max())

    @cached_property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Spans of x in m without plain surface: the upper side is not at z = 0 there, or of another solid."""
        tolerance, spans = SAME * float(np.ptp(self.points[:, 1])), []
        for one, other in self.boundary:
            ((block, _),) = self.edges[one, other]
            (x, z), (end, foot) = self.points[one], self.points[other]
            # The body lies on the left of an edge, so that an edge of the upper side runs towards -x.
            if self.cells[block].solid == "stator" and end < x and max(abs(z), abs(foot)) <= tolerance:
                spans.append((float(end), float(x)))
        at, last = self.extent
        gaps = []
        for low, high in [*sorted(spans), (last, last)]:
            if low > at + tolerance:
                gaps.append((at, low))
            at = max(at, high)
        return tuple(gaps)

    @property
    def depth_range(self) -> tuple[float, float]:
        """Smallest and largest z of the stator's own material in m."""
        z = self.points[np.concatenate([each.nodes.ravel() for each in self.cells if each.solid == "stator"]), 1]
        return float(z.min()), float(z.max())

    @property
    def longest_edge(self) -> float:
        """Length in m of the longest edge between two corners."""
        return float(np.linalg.norm(np.diff(self.points[list(self.edges)], axis=1), axis=-1).max())

    @cached_property
    def foot(self) -> np.ndarray:
        """Directed outer edges at the smallest z of the mesh, from left to right, shape (m, 2)."""
        z, edges = self.points[:, 1], np.array(self.boundary)
        low = (z[edges] <= z.min() + SAME * np.ptp(z)).all(axis=1)
        return edges[low][np.argsort(self.points[edges[low, 0], 0])]

    def interface(self, side: str) -> tuple[float, float, float] | None:
        """Position x, height and upper end z of a vertical line of the interface, m; None where the piece is an end."""
        if side not in self.lines:
            return None
        ends = self.points[np.unique(self.lines[side])]
        return float(ends[:, 0].mean()), float(np.ptp(ends[:, 1])), float(ends[:, 1].max())

    def border(self, side: str) -> float:
        """Length in m of the vertical outer edges of the stator's own material at the mesh's smallest or largest x."""
        x = self.extent[side == "right"]
        total = 0.0
        for one, other in self.boundary:
            ((block, _),) = self.edges[one, other]
            ends = self.points[[one, other]]
            height = abs(float(np.diff(ends[:, 1])[0]))
            if self.cells[block].solid == "stator" and np.max(abs(ends[:, 0] - x)) <= SAME * height:
                total += height
        return total

    @cached_property
    def edges(self) -> dict[tuple[int, int], list[tuple[int, int]]]:
        """Directed edges (corner, corner) of all elements, by their corners in order: [(block, element), ...]."""
        owners: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for block, cells in enumerate(self.cells):
            count = CORNERS[cells.kind]
            for element, nodes in enumerate(cells.nodes[:, :count].tolist()):
                for one, other in zip(nodes, [*nodes[1:], nodes[0]], strict=True):
                    owners.setdefault((one, other), []).append((block, element))
        return owners

    @cached_property
    def boundary(self) -> list[tuple[int, int]]:
        """Edges of one element alone, with the body on their left."""
        return [edge for edge in self.edges if edge[::-1] not in self.edges]


def read_mesh(path: str | Path, unit: float) -> SectionMesh:
    """Read a gmsh file (2.2 or 4.1) whose numbers are in a length unit of so many metres.

    Raises
    ------
    MeshError
        With what is wrong in the file.
    """
    path = Path(path)
    try:
        return _read(path, float(unit))
    except MeshError as error:
        raise MeshError(f'"{path.name}": {error}') from None


@refuses(MeshError)
def _check_coordinates(points: np.ndarray, unit: float) -> Iterator[Any]:
    """Refuse coordinates that are not finite, too large for a stator, or of a body in space."""
    if not np.isfinite(points).all():
        yield "the file has a coordinate that is no finite number"
    if (farthest := abs(points).max(initial=0.0) * unit) > FARTHEST:
        yield f"the file has a coordinate of {farthest:.3g} m, at most {FARTHEST:g} m: is its length unit right?"
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > MAX_OFF_PLANE * max(np.ptp(points, axis=0).max(), 1e-300):
        yield "the file's third coordinate is not constant: a section has two, x and z"


def _read(path: Path, unit: float) -> SectionMesh:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise MeshError(f"the file cannot be read from {path.parent}: {error.strerror}") from None
    file = parsed(path, content)
    points = np.asarray(file.points, dtype=float)
    _check_coordinates(points, unit)
    surfaces, lines = grouped(file)
    names, corners = list(file.field_data), [each.nodes[:, : CORNERS[each.kind]] for each in surfaces]
    for what, groups in (
        ("surface", [(each.solid, nodes) for each, nodes in zip(surfaces, corners, strict=True)]),
        ("line", list(lines.items())),
    ):
        check_groups(what, groups, names, points * unit)
    used = np.unique(np.concatenate([cells.nodes.ravel() for cells in surfaces]))
    for name, nodes in lines.items():
        bare = nodes[~np.isin(nodes, used).all(axis=1)]
        if len(bare):
            raise MeshError(_no_element(name, points * unit, bare[0]))
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points = points[used, :2] * unit
    cells = tuple(_anticlockwise(each, number, points) for each in surfaces)
    import hashlib  # 3 ms, which a stator without meshes does not spend

    mesh = SectionMesh(
        name=path.stem,
        digest=hashlib.sha256(content + repr(unit).encode()).hexdigest(),
        unit=unit,
        points=points,
        cells=cells,
        lines={name: number[nodes] for name, nodes in lines.items()},
    )
    _check_topology(mesh)
    for side in ("left", "right"):
        if side in mesh.lines:
            _check_interface(mesh, side)
    return mesh


def _anticlockwise(cells: Cells, number: np.ndarray, points: np.ndarray) -> Cells:
    """Elements in the mesh's own numbers with their corners anticlockwise; those without an area are refused."""
    nodes = number[cells.nodes]
    count = CORNERS[cells.kind]
    x, z = np.moveaxis(points[nodes[:, :count]], -1, 0)
    area = 0.5 * np.sum(x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z, axis=1)
    size = np.hypot(x - np.roll(x, 1, axis=1), z - np.roll(z, 1, axis=1)).max(axis=1)
    flat = np.flatnonzero(abs(area) <= MIN_AREA * size**2)
    if len(flat):
        raise MeshError(f"{_many(len(flat), cells)} no area, the first at {where(points, nodes[flat[0]])}")
    nodes = np.where((area < 0)[:, None], nodes[:, _mirror(cells.kind)], nodes)
    turns = _corner_turns(points[nodes[:, :count]])
    bent = np.flatnonzero((turns <= 0).any(axis=1))
    if len(bent):
        raise MeshError(
            f"{len(bent)} quadrilaterals are inverted (a corner points inwards), the first at "
            f"{where(points, nodes[bent[0]])}"
        )
    return Cells(kind=cells.kind, solid=cells.solid, nodes=nodes)


def _many(count: int, cells: Cells) -> str:
    what = "triangle" if CORNERS[cells.kind] == 3 else "quadrilateral"
    return f"1 {what} has" if count == 1 else f"{count} {what}s have"


def _no_element(name: str, points: np.ndarray, nodes) -> str:
    """Message about a line of a group that is no edge of an element: mostly the border of a hole."""
    return (
        f"no element has the line at {where(points[:, :2], nodes)} of the group {name} as an edge: either the mesh has "
        "a hole there (gmsh writes only surfaces that are in a physical group), or the line is none of the body's"
    )


def _corner_turns(corners: np.ndarray) -> np.ndarray:
    """Cross products of the two edges at each corner, shape (elements, corners)."""
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]


def _mirror(kind: str) -> list[int]:
    """Order of an element's nodes seen from behind."""
    return {
        "triangle": [0, 2, 1],
        "triangle6": [0, 2, 1, 5, 4, 3],
        "quad": [0, 3, 2, 1],
        "quad8": [0, 3, 2, 1, 7, 6, 5, 4],
        "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8],
    }[kind]


@refuses(MeshError)
def _check_topology(mesh: SectionMesh) -> Iterator[Any]:
    """Refuse folded meshes, parts that do not touch, holes, and lines that are no edges."""
    for edge, owners in mesh.edges.items():
        if len(owners) > 1:
            place = where(mesh.points, list(edge))
            yield f"elements overlap or are inverted: two lie on the same side of the edge at {place}"
    for name, nodes in mesh.lines.items():
        for one, other in nodes.tolist():
            if (one, other) not in mesh.edges and (other, one) not in mesh.edges:
                yield _no_element(name, mesh.points, [one, other])
    corners = np.unique(list(mesh.edges))
    parts = _components(list(mesh.edges), len(mesh.points))
    others = corners[parts[corners] != parts[corners[0]]]
    if len(others):
        count = len(np.unique(parts[corners]))
        yield (
            f"the mesh has {count} parts that share no nodes, the second at {where(mesh.points, others[0])}: "
            "gmsh joins touching surfaces by BooleanFragments or Coherence"
        )
    on_boundary = np.unique(mesh.boundary)
    loops = _components(mesh.boundary, len(mesh.points))
    outer = loops[on_boundary[np.argmin(mesh.points[on_boundary, 0])]]
    named = {node for nodes in mesh.lines.values() for node in nodes.ravel().tolist()}
    for loop in np.unique(loops[on_boundary]):
        inside = on_boundary[loops[on_boundary] == loop]
        if loop != outer and not named.intersection(inside.tolist()):
            yield (
                f"the mesh has a hole at {where(mesh.points, inside)}: gmsh writes only surfaces that are in a "
                "physical group; put the lines of an intended hole into the group surface"
            )


def _components(edges: list, count: int) -> np.ndarray:
    """Number of the connected part that each node belongs to, shape (count,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    one, other = np.array(edges).T
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)[1]


@refuses(MeshError)
def _check_interface(mesh: SectionMesh, side: str) -> Iterator[Any]:
    """Refuse a line of an interface that is not one vertical outer line of the stator's own material."""
    lines = mesh.lines[side]
    ends = mesh.points[lines]
    x, height = ends[..., 0], float(np.ptp(ends[..., 1]))
    if height == 0 or np.ptp(x) > SAME * height:
        yield (
            f"the line group {side} is not one vertical line: x runs from {x.min() * 1e3:.6g} to {x.max() * 1e3:.6g} mm"
        )
    spans = np.sort(ends[..., 1], axis=1)
    spans = spans[np.argsort(spans[:, 0])]
    for below, above in itertools.pairwise(spans):
        if above[0] - below[1] > SAME * height:
            yield (
                f"the group {side} has a gap from z = {below[1] * 1e3:.4g} to {above[0] * 1e3:.4g} mm; "
                "gmsh writes only surfaces that are in a physical group"
            )
    for one, other in lines.tolist():
        owners = mesh.edges.get((one, other), []) + mesh.edges.get((other, one), [])
        if len(owners) > 1:
            yield f"the line group {side} lies inside the mesh: it must be its {side} border"
        solid = mesh.cells[owners[0][0]].solid
        if solid != "stator":
            yield (f'the group {side} crosses "{solid}": a layer that goes on beyond the piece is not supported')
    low, high = mesh.extent
    if (side == "left" and x.min() > low + SAME * height) or (side == "right" and x.max() < high - SAME * height):
        yield (
            f"the line group {side} must be the mesh's {side} border: it stands at x = {x.mean() * 1e3:.6g} mm, "
            f"the mesh reaches from {low * 1e3:.6g} to {high * 1e3:.6g} mm"
        )
