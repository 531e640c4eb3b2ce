"""Meshed piece of the stator: condensation to its interfaces and electrodes, and the field inside.

The unknowns inside every element are eliminated first, in batches (static condensation), and then those on edges and
vertices (the skeleton; of one element: its rim), front by front (`fem.condense.nested_dissection`).  On an interface
the unknowns of the mesh are P times those of the section's line (`fem.condense.mesh_assembly`), so that the condensed
matrix is P^T A P, which is complex symmetric.

A piece with one interface is an end of the stator, and a piece without interfaces is the whole stator.  A piece whose
far side meets the line of another section is a step, which the radiation impedance of that section terminates.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.cascade_piece import Port
from fem.condense.layer_columns import LayerColumns
from fem.condense.nested_dissection import Dissection, Factor
from fem.discretize.quad_elements import QuadSpace, TopEdges, medium_block, medium_tables
from fem.discretize.section import FIELD_COLUMN
from fem.exceptions import ConvergenceError
from fem.materials.medium import Medium
from fem.mesh.mesh_piece import MeshPiece


@dataclass(frozen=True, kw_only=True, eq=False)
class Assembly:
    """Part of a meshed piece that does not depend on the frequency: elements, media, conditions and interfaces."""

    piece: MeshPiece
    space: QuadSpace = field(repr=False)
    media: dict[str, Medium] = field(repr=False)  # by surface group
    fields: tuple[str, ...]  # of the stator
    sides: tuple[str, ...]  # "left", "right" or one of them
    lines: tuple[int, ...]  # unknowns of the section's line on each side
    ports: tuple[Port, ...]
    # shape (skeleton functions * fields,): number of the unknown, -1 where it is held at zero
    numbers: np.ndarray = field(repr=False)
    # shape (interface functions + ports, lines + ports): P, from the unknowns of the lines to those that are kept
    projection: np.ndarray = field(repr=False)
    grounded: bool  # True if a group or an electrode holds its potential
    layer: LayerColumns | None = field(default=None, repr=False)  # absorbing layer below the mesh

    @property
    def floating_potential(self) -> bool:
        """As of `fem.condense.cascade_piece.Piece`."""
        return "phi" in self.fields and not (self.grounded or self.ports)

    @cached_property
    def parts(self) -> list[tuple[Medium, np.ndarray, np.ndarray]]:
        """Batches of elements of one medium, limited in memory: medium, elements, skeleton unknowns of their rims."""
        result = []
        for name, own in self.media.items():
            columns = np.array([self.fields.index(each) for each in own.fields])
            for elements in self.space.chunks(np.flatnonzero(self.space.mesh.solids == name)):
                functions = self.space.numbers[elements][:, None, : self.space.rim]
                numbers = functions * len(self.fields) + columns[:, None]
                result.append((own, elements, numbers.reshape(len(elements), -1)))
        return result

    @cached_property
    def surface(self) -> TopEdges:
        """Upper boundary of the mesh."""
        return TopEdges(self.space)

    @cached_property
    def dissection(self) -> Dissection:
        """The order in which its unknowns are eliminated."""
        mesh = self.space.mesh
        order = np.concatenate([elements for _, elements, _ in self.parts])
        unknowns = [of_element for _, _, numbers in self.parts for of_element in self.numbers[numbers]]
        centers = mesh.points[mesh.quads[order, :4]].mean(axis=1)
        if self.layer is not None:
            unknowns += [self.numbers[numbers] for numbers in self.layer.numbers]
            centers = np.concatenate([centers, self.layer.centers])
        return Dissection(
            unknowns=unknowns, centers=centers, first_kept=int(self.numbers.max()) + 1 - len(self.projection)
        )

    @property
    def unknowns(self) -> int:
        """Unknowns of the mesh."""
        return self.space.size * len(self.fields)

    @property
    def operations(self) -> float:
        """Multiplications and additions of `condensed`, complex ones, without those in an absorbing layer."""
        inner = [(len(own.fields) * (self.space.order - 1) ** 2, numbers) for own, _, numbers in self.parts]
        blocks = [(size, numbers.shape[1], len(numbers)) for size, numbers in inner]
        blocks += [(len(front.eliminated), len(front.passed_on), 1) for front in self.dissection.fronts]
        return sum(count * (2 / 3 * n**3 + 2 * n**2 * m + 2 * n * m**2) for n, m, count in blocks)

    @property
    def block_bytes(self) -> int:
        """Memory of the blocks that a condensed piece keeps to recover its field."""
        inside = sum(numbers.size * len(own.fields) * (self.space.order - 1) ** 2 for own, _, numbers in self.parts)
        fronts = sum(len(front.eliminated) * len(front.passed_on) for front in self.dissection.fronts)
        return (inside + fronts) * 16

    def condensed(self, frequency: float) -> "MeshedPiece":
        """Condense the piece at a frequency in Hz."""
        rim, inner = slice(self.space.rim), slice(self.space.rim, None)
        outer, insides = [], []
        for own, elements, _ in self.parts:
            tables = medium_tables(own, 2 * np.pi * frequency * self.space.unit)
            scalars = self.space.scalar_matrices(elements)
            coupling = medium_block(scalars, tables, inner, rim)
            insides.append(-np.linalg.solve(medium_block(scalars, tables, inner, inner), coupling))
            own_rim = medium_block(scalars, tables, rim, rim) + coupling.swapaxes(1, 2) @ insides[-1]
            outer += list(own_rim)
        layer: list[np.ndarray] = []
        if self.layer is not None:
            own_rims, layer = self.layer.condensed(frequency)
            outer += own_rims
        try:
            factor = self.dissection.factor(outer)
        except ConvergenceError:
            clamped = ", clamped at its interfaces," if self.sides else ""
            raise ConvergenceError(
                f'the piece "{self.piece.name}"{clamped} resonates at this very frequency: change the frequency by a '
                "part in a million, or give the solid a mechanical_quality"
            ) from None
        matrix = self.projection.T @ factor.matrix @ self.projection
        low, high = self.piece.extent
        return MeshedPiece(
            assembly=self,
            frequency=frequency,
            sides=self.sides,
            size=self.lines[0] if self.lines else 0,
            matrix=0.5 * (matrix + matrix.T),
            width=(high - low) / self.space.unit,
            ports=self.ports,
            floating_potential=self.floating_potential,
            grounded=self.grounded,
            unknowns=self.unknowns,
            factor=factor,
            insides=insides,
            layer=layer,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshedPiece:
    """A piece of the stator condensed from a mesh at one frequency."""

    assembly: Assembly = field(repr=False)
    frequency: float  # Hz
    sides: tuple[str, ...]  # interfaces in their order in the matrix
    size: int  # unknowns of a line of the stator
    matrix: np.ndarray = field(repr=False)
    width: float  # length units
    ports: tuple[Port, ...]
    floating_potential: bool
    grounded: bool  # True if a group or an electrode holds its potential
    unknowns: int  # of the mesh
    factor: Factor = field(repr=False)
    insides: list[np.ndarray] = field(repr=False)  # of every part of `Assembly.parts`: inside from rim
    layer: list[np.ndarray] = field(repr=False)  # of every element of `Assembly.layer`: its nodes from its unknowns
    _last: dict = field(default_factory=dict, init=False, repr=False)  # unknowns on edges and vertices, by the sides

    def recover(self, sides: np.ndarray) -> "MeshField":
        """Field inside for values on lines and ports, shape (len(matrix),)."""
        sides = np.asarray(sides, dtype=complex)
        key = sides.tobytes()
        if key not in self._last:
            self._last.clear()
            self._last[key] = self.skeleton(sides[:, None])[:, 0]
        # the field refers to the piece, which must not refer to the field: a cycle would keep the factors in memory
        return MeshField(assembly=self.assembly, skeleton=self._last[key], condense=lambda: self)

    def skeleton(self, sides: np.ndarray) -> np.ndarray:
        """Unknowns on edges and vertices for lines and ports (len(matrix), m), and a last row of zeros."""
        values = self.factor.unknowns(self.assembly.projection @ sides)
        return np.concatenate([values, np.zeros((1, sides.shape[1]))])[self.assembly.numbers]

    def elements(self, skeleton: np.ndarray):
        """Yield elements of one medium in parts: medium, numbers, unknowns (m, functions, fields, columns)."""
        for (own, elements, numbers), inside in zip(self.assembly.parts, self.insides, strict=True):
            rim = skeleton[numbers]
            both = [each.reshape(len(elements), len(own.fields), -1, skeleton.shape[1]) for each in (rim, inside @ rim)]
            yield own, elements, np.concatenate(both, axis=2).swapaxes(1, 2)

    def inertia(self, sides: np.ndarray) -> np.ndarray:
        """X^T M X of the fields X for lines and ports (len(matrix), m), with A = K - omega^2 M; s^2/rad^2, (m, m)."""
        total = np.zeros((sides.shape[1],) * 2, dtype=self.matrix.dtype)
        skeleton = self.skeleton(sides)
        for own, elements, values in self.elements(skeleton):
            mass = self.assembly.space.scalar_matrices(elements)[:, 4]  # integrals of v u
            for column in np.flatnonzero(own.inertia):
                nodal = np.ascontiguousarray(values[:, :, column])
                moved = (mass @ nodal.view(float)).view(nodal.dtype)  # real times complex: half the products
                total += own.inertia[column] * (nodal.reshape(-1, len(total)).T @ moved.reshape(-1, len(total)))
        total = self.assembly.space.unit**2 * total
        if self.assembly.layer is not None:
            total = total + self.assembly.layer.inertia(self.layer, skeleton, self.frequency)
        return 0.5 * (total + total.T)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshField:
    """Field of a meshed piece for values on lines and ports."""

    assembly: Assembly = field(repr=False)
    skeleton: np.ndarray = field(repr=False)  # scaled unknowns of edges and vertices, fields innermost
    condense: Callable[[], MeshedPiece] = field(repr=False)  # for the insides of the elements; called on first use

    @cached_property
    def piece(self) -> MeshedPiece:
        """The condensed piece."""
        return self.condense()

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the highest point of the mesh at positions x from the piece's left edge, length units."""
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
        owner, references = space.locate(np.asarray(points) + self._origin)
        order = np.argsort(owner, kind="stable")
        first = np.searchsorted(owner[order], np.arange(space.elements + 1))
        out = np.zeros((3, len(points), 4), dtype=complex)
        for own, elements, values in self.piece.elements(self.skeleton[:, None]):
            columns = np.array([FIELD_COLUMN[name] for name in own.fields])
            for element, nodal in zip(elements, values[..., 0], strict=True):
                here = order[first[element] : first[element + 1]]
                if len(here):
                    out[:, here[:, None], columns] = _local_fields(space, element, references[here], nodal)
        return *out, np.where(owner >= 0, space.mesh.solids[owner], "")

    @property
    def _origin(self) -> np.ndarray:
        """The left edge at the surface in the mesh's own axes, length units."""
        return np.array([self.assembly.piece.mesh.extent[0] / self.assembly.space.unit, 0.0])

    def on_elements(self, references: np.ndarray):
        """Yield the field at reference positions (m, 2) of every element, in batches of elements of one solid.

        Each batch has the name of the solid's group; the points, measured from the left edge and the surface in length
        units, (elements, m, 2); and scaled u_x, u_y, u_z and phi with their derivatives along x and z,
        (3, elements, m, 4).
        """
        space = self.assembly.space
        for own, elements, values in self.piece.elements(self.skeleton[:, None]):
            out = np.zeros((3, len(elements), len(references), 4), dtype=complex)
            out[..., [FIELD_COLUMN[name] for name in own.fields]] = _local_fields(
                space, elements, references, values[..., 0]
            )
            yield space.mesh.solids[elements[0]], space.positions(elements, references) - self._origin, out

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


def _local_fields(space: QuadSpace, elements, references: np.ndarray, nodal: np.ndarray) -> np.ndarray:
    """Fields and their derivatives along x and z at reference positions (m, 2) of elements: (3, ..., m, fields).

    ``elements``: one index or an array of them; ``nodal``: their unknowns, (..., functions, fields).
    """
    value, by_first, by_second = space.local_values(references)
    slopes = np.stack([by_first @ nodal, by_second @ nodal], axis=-2)  # (..., m, reference, fields)
    along = np.moveaxis(space.slopes(elements, references).swapaxes(-1, -2) @ slopes, -2, 0)
    return np.concatenate([(value @ nodal)[None], along])
