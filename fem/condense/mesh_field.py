"""Field of a meshed piece: motion of its upper boundary, and the interior at any point or on its elements."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fem.discretize.quads import QuadSpace, medium_tables
from fem.discretize.section import FIELD_COLUMN

if TYPE_CHECKING:
    from fem.condense.mesh import Assembly, MeshedPiece


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshField:
    """Field of a meshed piece for given lines and ports."""

    assembly: "Assembly" = field(repr=False)
    skeleton: np.ndarray = field(repr=False)  # scaled unknowns of edges and vertices, fields innermost
    condense: "Callable[[], MeshedPiece]" = field(repr=False)  # for the insides of the elements; called on first use

    @cached_property
    def piece(self) -> "MeshedPiece":
        """The condensed piece."""
        return self.condense()

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the highest point of the mesh at places x from the piece's left edge, length units."""
        space, names = self.assembly.space, self.assembly.fields
        left = self.assembly.piece.mesh.extent[0] / space.unit
        numbers, weights = self.assembly.surface.at(np.asarray(x, dtype=float) + left)
        nodal = self.skeleton.reshape(-1, len(names))
        return np.stack([np.sum(nodal[numbers, names.index(name)] * weights, axis=1) for name in ("ux", "uz")])

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Scaled u_x, u_y, u_z and phi at points (m, 2), measured from the left edge and the surface in length units.

        Returns the values and their derivatives along x and z, (m, 4) each, zero outside the mesh; and the name of the
        solid's group at each point, empty outside the mesh.
        """
        space = self.assembly.space
        owner, places = space.locate(np.asarray(points) + self._origin)
        order = np.argsort(owner, kind="stable")
        first = np.searchsorted(owner[order], np.arange(space.elements + 1))
        out = np.zeros((3, len(points), 4), dtype=complex)
        for own, elements, values in self.piece.elements(self.skeleton[:, None]):
            columns = np.array([FIELD_COLUMN[name] for name in own.fields])
            for element, nodal in zip(elements, values[..., 0], strict=True):
                here = order[first[element] : first[element + 1]]
                if len(here):
                    out[:, here[:, None], columns] = _local_fields(space, element, places[here], nodal)
        return *out, np.where(owner >= 0, space.mesh.solids[owner], "")

    @property
    def _origin(self) -> np.ndarray:
        """The left edge at the surface in the mesh's own axes, length units."""
        return np.array([self.assembly.piece.mesh.extent[0] / self.assembly.space.unit, 0.0])

    def on_elements(self, places: np.ndarray):
        """Yield the field at reference positions (m, 2) of every element, in batches of elements of one solid.

        Each batch has the name of the solid's group; the points, measured from the left edge and the surface in length
        units, (elements, m, 2); and scaled u_x, u_y, u_z and phi with their derivatives along x and z,
        (3, elements, m, 4).
        """
        space = self.assembly.space
        for own, elements, values in self.piece.elements(self.skeleton[:, None]):
            out = np.zeros((3, len(elements), len(places), 4), dtype=complex)
            out[..., [FIELD_COLUMN[name] for name in own.fields]] = _local_fields(
                space, elements, places, values[..., 0]
            )
            yield space.mesh.solids[elements[0]], space.positions(elements, places) - self._origin, out

    def loss(self) -> float:
        """Power lost inside, scaled, (omega / 2) sum u^H Im(A) u, from the imaginary moduli element by element."""
        total = 0.0
        for own, elements, unknowns in self.piece.elements(self.skeleton[:, None]):
            if not np.iscomplexobj(own.xx):
                continue
            values, tables = unknowns[..., 0], medium_tables(own, 0.0, part="loss")
            scalars = self.assembly.space.scalar_matrices(elements)
            forms = values.conj().swapaxes(1, 2)[:, None] @ (scalars @ values[:, None])
            total += float(np.einsum("mpij,ijp->", forms, tables).real)
        if self.assembly.layer is not None:
            total += self.assembly.layer.loss(self.piece.layer, self.skeleton, self.piece.frequency)
        return np.pi * self.piece.frequency * total


def _local_fields(space: QuadSpace, elements, places: np.ndarray, nodal: np.ndarray) -> np.ndarray:
    """Fields and their derivatives along x and z at reference positions (m, 2) of elements: (3, ..., m, fields).

    ``elements``: one index or an array of them; ``nodal``: their unknowns, (..., functions, fields).
    """
    value, by_first, by_second = space.local_values(places)
    slopes = np.stack([by_first @ nodal, by_second @ nodal], axis=-2)  # (..., m, reference, fields)
    along = np.moveaxis(space.slopes(elements, places).swapaxes(-1, -2) @ slopes, -2, 0)
    return np.concatenate([(value @ nodal)[None], along])


ROUNDED = 1e-3  # of a piece's width, which is 1e-3 of the stator or more: fem.layout allows 1e-6 of the stator


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

        A mesh may end beside the stator's end by a rounding of its file: a place there is moved to the mesh.
        """
        numbers, along = np.empty((len(x), self.numbers.shape[1]), dtype=int), np.empty(len(x))
        lowest, highest = self.low.min(), self.high.max()
        room = 1e-9 * (highest - lowest)
        if np.any(abs(x - np.clip(x, lowest, highest)) > ROUNDED * (highest - lowest)):
            raise ValueError("x must lie on the piece")
        x = np.clip(x, lowest, highest)
        for index, place in enumerate(x):
            here = np.flatnonzero((self.low <= place + room) & (self.high >= place - room))
            if not len(here):
                raise ValueError("x must lie on the piece: it has no surface there")
            a, b, c = self.quadratic[here, 0], self.linear[here, 0], self.start[here, 0] - place
            root = np.sqrt(np.maximum(b**2 - 4 * a * c, 0.0))
            t = np.clip(-2 * c / (b + np.where(b < 0, -root, root)), 0.0, 1.0)
            heights = self.start[here, 1] + t * self.linear[here, 1] + t**2 * self.quadratic[here, 1]
            best = int(np.argmax(heights))
            numbers[index], along[index] = self.numbers[here[best]], t[best]
        return numbers, self.space.edge_values(along)
