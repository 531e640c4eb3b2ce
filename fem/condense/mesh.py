"""Meshed piece of the stator: assembly, condensation to its interfaces and electrodes, recovery of the field inside.

The unknowns inside every element are eliminated first, in batches (static condensation), and then those on edges and
vertices, front by front (`fem.condense.fronts`).  On an interface the unknowns of the mesh are P times those of the
section's line (`fem.condense.interface`), so that the condensed matrix is P^T A P, which is complex symmetric.  An
electrode is equipotential: all its vertices share one unknown.  It is a port if the electrode is connected to a
transducer and zero if the electrode is grounded.  If the electrode floats, the unknown is eliminated with zero net
charge.

On a half-space the mesh is continued down to the section's absorbing layer (`fem.mesh.deepened`), and the layer by its
own elements below the mesh (`fem.condense.layer_columns`).

A piece with one interface is an end of the stator, and a piece without interfaces is the whole stator.  A piece whose
far side meets the line of another section is a step, which the radiation impedance of that section terminates.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fem.condense.fronts import Dissection, Factor
from fem.condense.layer_columns import LayerColumns
from fem.condense.mesh_field import MeshField, TopEdges
from fem.condense.mesh_unknowns import MeshUnknowns
from fem.condense.piece import Port
from fem.discretize.grading import Resolution
from fem.discretize.quads import QuadSpace, medium_block, medium_tables
from fem.discretize.section import Section
from fem.exceptions import ConvergenceError
from fem.geometry import Stator
from fem.materials import fields as coupled_fields
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import Medium, medium, units
from fem.mesh.deepened import deepened
from fem.mesh.piece import MAX_UNKNOWNS, MeshPiece
from fem.mesh.quads import conditions_of, quad_mesh

# Elements of a mesh relative to those of the section, which are at most one wavelength long: half the size, one order
# less, and one geometric layer more towards singular points.  The motion behind a groove then has the error 1.3e-3 at
# level 1 and 1.6e-4 at level 2 (with the section's order and two more layers: 1.8e-3 and 2e-4), and that behind a plain
# segment 6e-10 at level 3.
ELEMENT_SHARE = 0.5
ORDERS_LESS = 1
MORE_LAYERS = 1
# A mesh whose elements are all smaller than this share of the largest allowed takes one order less still: elements of
# 0.35 wavelengths and order 5 have the phase error of those of 0.5 wavelengths and order 6 (Ainsworth, SIAM J. Numer.
# Anal. 42 (2004) 553, equation 3.7).  The motion behind a groove then errs by 6.5e-5 instead of 5.4e-5 at level 2.
# On a plain piece itself it would err by 2e-8 instead of 9e-10 at level 3: sections of an order above FINER_ORDER keep
# theirs.
FINER_SHARE, FINER_ORDER = 0.75, 7


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshedPiece:
    """A piece of the stator condensed from a mesh at one frequency."""

    assembly: "Assembly" = field(repr=False)
    frequency: float  # Hz
    sides: tuple[str, ...]  # interfaces in their order in the matrix
    size: int  # unknowns of a line of the stator
    matrix: np.ndarray = field(repr=False)
    width: float  # length units
    ports: tuple[Port, ...]
    floating_potential: bool
    grounded: bool  # whether a group or an electrode holds its potential
    unknowns: int  # of the mesh
    factor: Factor = field(repr=False)
    insides: list[np.ndarray] = field(repr=False)  # of every part of `Assembly.parts`: inside from rim
    layer: list[np.ndarray] = field(repr=False)  # of every element of `Assembly.layer`: its nodes from its unknowns
    _last: dict = field(default_factory=dict, init=False, repr=False)

    def recover(self, sides: np.ndarray) -> MeshField:
        """Field inside for given lines and ports, shape (len(matrix),)."""
        sides = np.asarray(sides, dtype=complex)
        key = sides.tobytes()
        if key not in self._last:
            self._last.clear()
            self._last[key] = MeshField(
                assembly=self.assembly, skeleton=self.skeleton(sides[:, None])[:, 0], condense=lambda: self
            )
        return self._last[key]

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
            mass = self.assembly.space.scalar_matrices(elements)[:, 4]
            for column in np.flatnonzero(own.inertia):
                nodal = np.ascontiguousarray(values[:, :, column])
                moved = (mass @ nodal.view(float)).view(nodal.dtype)  # real times complex: half the products
                total += own.inertia[column] * (nodal.reshape(-1, len(total)).T @ moved.reshape(-1, len(total)))
        total = self.assembly.space.unit**2 * total
        if self.assembly.layer is not None:
            total = total + self.assembly.layer.inertia(self.layer, skeleton, self.frequency)
        return 0.5 * (total + total.T)


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
    grounded: bool  # whether a group or an electrode holds its potential
    layer: LayerColumns | None = field(default=None, repr=False)  # absorbing layer below the mesh

    @property
    def floating_potential(self) -> bool:
        """As of `fem.condense.piece.Piece`."""
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
        unknowns = [row for _, _, numbers in self.parts for row in self.numbers[numbers]]
        centers = mesh.points[mesh.quads[order, :4]].mean(axis=1)
        if self.layer is not None:
            unknowns += [self.numbers[numbers] for numbers in self.layer.numbers]
            centers = np.concatenate([centers, self.layer.centers])
        return Dissection(unknowns=unknowns, centers=centers, kept=int(self.numbers.max()) + 1 - len(self.projection))

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

    def condensed(self, frequency: float) -> MeshedPiece:
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


def assembled(
    piece: MeshPiece,
    stator: Stator,
    section: Section,
    sections: dict[str, Section],
    *,
    frequency: float,
    resolution: Resolution,
) -> Assembly:
    """Assemble a meshed piece: its elements, boundary conditions and interfaces at one resolution.

    ``section``: of the stator; ``sections``: the section at each side that has an interface; ``frequency`` in Hz limits
    the size of the elements.

    Raises
    ------
    ConvergenceError
        If the mesh has more unknowns than can be solved for.
    """
    unit = section.length_unit
    names = coupled_fields(stator.solid)
    solids = {"stator": stator.solid} | dict(piece.solids)
    share = ELEMENT_SHARE * resolution.element_size
    largest = {name: share * slowest_wavelength(solids[name], frequency) for name in piece.mesh.solids}
    if stator.absorbs_below:
        depth = -float(section.breakpoints[section.bottom // section.order]) * unit
        piece = replace(piece, mesh=deepened(piece.mesh, depth, max(2 * largest["stator"], piece.mesh.longest_edge)))
    layers, conditions = resolution.edge_layers + MORE_LAYERS, conditions_of(piece, stator.bottom)
    mesh = quad_mesh(piece.mesh, layers=layers, largest=largest, conditions=conditions)
    small = all(mesh.size(name) <= FINER_SHARE * size for name, size in largest.items())
    finer = small and resolution.order <= FINER_ORDER
    space = QuadSpace(mesh, resolution.order - ORDERS_LESS - finer, unit)
    if space.size * len(names) > MAX_UNKNOWNS:
        raise ConvergenceError(
            f'the piece "{piece.name}" has {space.size * len(names):.2g} unknowns at order {space.order}, at most '
            f"{MAX_UNKNOWNS:.0g} are solved for: ask for a looser tolerance, or draw its mesh coarser"
        )
    media = {}
    for name in piece.mesh.solids:
        own = tuple(each for each in names if each != "phi" or solids[name].is_piezoelectric)
        media[name] = medium(solids[name], own, scales=units(stator.solid))
    layer = LayerColumns(section=section, space=space, names=names) if stator.absorbs_below else None
    unknowns = MeshUnknowns(piece, stator, space, media, names, layer)
    sides = tuple(side for side in ("left", "right") if side in sections)
    numbers, projection = unknowns.numbered({side: sections[side] for side in sides})
    return Assembly(
        piece=piece,
        space=space,
        media=media,
        fields=names,
        sides=sides,
        lines=tuple(sections[side].size for side in sides),
        ports=unknowns.ports,
        numbers=numbers,
        projection=projection,
        grounded=unknowns.grounded,
        layer=layer,
    )
