"""Meshed piece of the stator: assembly, condensation to its interfaces and electrodes, recovery of the field inside.

The unknowns inside every element are eliminated first, in batches (static condensation), and then those on edges and
vertices, front by front (`fem.condense.fronts`).  On an interface the unknowns of the mesh are P times those of the
section's line (`fem.condense.interface`), so that the condensed matrix is P^T A P, which is complex symmetric.  An
electrode is equipotential: all its vertices share one unknown.  It is a port if the electrode is connected to a
transducer and zero if the electrode is grounded.  If the electrode floats, the unknown is eliminated with zero net
charge.

A piece with one interface is an end of the stator, and a piece without interfaces is the whole stator.  A piece whose
far side meets the line of another section is a step, which the radiation impedance of that section terminates.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.fronts import Dissection, Factor
from fem.condense.interface import line_projection
from fem.condense.piece import Port
from fem.convergence_error import ConvergenceError
from fem.discretize.grading import Resolution
from fem.discretize.quads import QuadSpace, medium_block, medium_tables
from fem.discretize.section import FIELD_COLUMN, Section
from fem.geometry import Stator
from fem.materials import fields as coupled_fields
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import Medium, medium, units
from fem.mesh.layout import MAX_UNKNOWNS
from fem.mesh.piece import FLOATING, GROUNDED, MeshPiece
from fem.mesh.quads import conditions_of, quad_mesh
from fem.mesh.section_mesh import ELECTRODE

# Elements of a mesh relative to those of the section, which are at most one wavelength long: half the size, one order
# less, and one geometric layer more towards singular points.  The motion behind a groove then has the error 1.3e-3 at
# level 1 and 1.6e-4 at level 2 (with the section's order and two more layers: 1.8e-3 and 2e-4), and that behind a plain
# segment 8e-10 at level 3 (with two orders less: 2e-8).
ELEMENT_SHARE = 0.5
ORDERS_LESS = 1
MORE_LAYERS = 1
# Fields that a boundary condition sets to zero.
HELD: dict[str, tuple[str, ...]] = {"clamped": ("u",), "grounded": ("phi",), "free": ()}


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
    _last: dict = field(default_factory=dict, init=False, repr=False)

    def recover(self, sides: np.ndarray) -> "MeshField":
        """Field inside for given lines and ports, shape (len(matrix),)."""
        sides = np.asarray(sides, dtype=complex)
        key = sides.tobytes()
        if key not in self._last:
            self._last.clear()
            self._last[key] = MeshField(piece=self, skeleton=self.skeleton(sides[:, None])[:, 0])
        return self._last[key]

    def skeleton(self, sides: np.ndarray) -> np.ndarray:
        """Unknowns on edges and vertices for lines and ports (len(matrix), m), and a last row of zeros."""
        values = self.factor.unknowns(self.assembly.projection @ sides)
        return np.concatenate([values, np.zeros((1, sides.shape[1]))])[self.assembly.numbers]

    def elements(self, skeleton: np.ndarray):
        """Yield elements of one medium in parts: medium, numbers, unknowns (m, functions, fields, columns)."""
        for (own, elements, numbers), inside in zip(self.assembly.parts, self.insides, strict=True):
            rim = skeleton[numbers]
            both = [
                each.reshape(len(elements), len(own.fields), -1, skeleton.shape[1])
                for each in (rim, inside @ rim)
            ]
            yield own, elements, np.concatenate(both, axis=2).swapaxes(1, 2)

    def inertia(self, sides: np.ndarray) -> np.ndarray:
        """X^T M X of the fields X for lines and ports (len(matrix), m), with A = K - omega^2 M; s^2/rad^2, (m, m)."""
        total = np.zeros((sides.shape[1],) * 2, dtype=self.matrix.dtype)
        for own, elements, values in self.elements(self.skeleton(sides)):
            mass = self.assembly.space.scalar_matrices(elements)[:, 4]
            for column in np.flatnonzero(own.inertia):
                nodal = values[:, :, column]
                moved = (own.inertia[column] * mass) @ nodal
                total += nodal.reshape(-1, len(total)).T @ moved.reshape(-1, len(total))
        return 0.5 * self.assembly.space.unit**2 * (total + total.T)


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

    @property
    def floating_potential(self) -> bool:
        """As of `fem.condense.piece.Piece`."""
        return "phi" in self.fields and not (self.grounded or self.ports)

    @property
    def key(self) -> tuple:
        """Key that is equal for pieces with the same assembly."""
        return self.piece.contents

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
    def dissection(self) -> Dissection:
        """The order in which its unknowns are eliminated."""
        mesh = self.space.mesh
        order = np.concatenate([elements for _, elements, _ in self.parts])
        unknowns = [row for _, _, numbers in self.parts for row in self.numbers[numbers]]
        centers = mesh.points[mesh.quads[order, :4]].mean(axis=1)
        return Dissection(
            unknowns=unknowns, centers=centers, kept=int(self.numbers.max()) + 1 - len(self.projection)
        )

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
            unknowns=self.space.size * len(self.fields),
            factor=factor,
            insides=insides,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshField:
    """Field of a meshed piece for given lines and ports."""

    piece: MeshedPiece = field(repr=False)
    skeleton: np.ndarray = field(repr=False)  # scaled unknowns of edges and vertices, fields innermost

    @property
    def assembly(self) -> Assembly:
        """Part of the piece that does not depend on the frequency."""
        return self.piece.assembly

    @cached_property
    def _surface(self) -> "_TopEdges":
        return _TopEdges(self.assembly.space)

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the highest point of the mesh at places x from the piece's left edge, length units."""
        space, names = self.assembly.space, self.assembly.fields
        left = self.assembly.piece.mesh.extent[0] / space.unit
        numbers, weights = self._surface.at(np.asarray(x, dtype=float) + left)
        nodal = self.skeleton.reshape(-1, len(names))
        return np.stack(
            [np.sum(nodal[numbers, names.index(name)] * weights, axis=1) for name in ("ux", "uz")]
        )

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
        return np.pi * self.piece.frequency * total


def _local_fields(space: QuadSpace, elements, places: np.ndarray, nodal: np.ndarray) -> np.ndarray:
    """Fields and their derivatives along x and z at reference positions (m, 2) of elements: (3, ..., m, fields).

    ``elements``: one index or an array of them; ``nodal``: their unknowns, (..., functions, fields).
    """
    value, by_first, by_second = space.local_values(places)
    slopes = np.stack([by_first @ nodal, by_second @ nodal], axis=-2)  # (..., m, reference, fields)
    along = np.moveaxis(space.slopes(elements, places).swapaxes(-1, -2) @ slopes, -2, 0)
    return np.concatenate([(value @ nodal)[None], along])


class _TopEdges:
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
        """Numbers (points, order + 1) and values of the functions at the highest boundary point above each x."""
        numbers, along = np.empty((len(x), self.numbers.shape[1]), dtype=int), np.empty(len(x))
        room = 1e-9 * (self.high[np.isfinite(self.high)].max() - self.low[np.isfinite(self.low)].min())
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


def assembled(
    piece: MeshPiece,
    stator: Stator,
    sections: dict[str, Section],
    *,
    frequency: float,
    resolution: Resolution,
) -> Assembly:
    """Assemble a meshed piece: its elements, boundary conditions and interfaces at one resolution.

    ``sections``: the section at each side that has an interface; ``frequency`` in Hz limits the size of the elements.

    Raises
    ------
    ConvergenceError
        If the mesh has more unknowns than can be solved for.
    """
    unit = (
        next(iter(sections.values())).length_unit if sections else slowest_wavelength(stator.solid, frequency)
    )
    names = coupled_fields(stator.solid)
    solids = {"stator": stator.solid} | dict(piece.solids)
    space = QuadSpace(
        quad_mesh(
            piece.mesh,
            layers=resolution.edge_layers + MORE_LAYERS,
            largest={
                name: ELEMENT_SHARE * resolution.element_size * slowest_wavelength(solids[name], frequency)
                for name in piece.mesh.solids
            },
            conditions=conditions_of(piece, stator.bottom),
        ),
        resolution.order - ORDERS_LESS,
        unit,
    )
    if space.size * len(names) > MAX_UNKNOWNS:
        raise ConvergenceError(
            f'the piece "{piece.name}" has {space.size * len(names):.2g} unknowns at order {space.order}, at most '
            f"{MAX_UNKNOWNS:.0g} are solved for: ask for a looser tolerance, or draw its mesh coarser"
        )
    media = {}
    for name in piece.mesh.solids:
        own = tuple(each for each in names if each != "phi" or solids[name].is_piezoelectric)
        media[name] = medium(solids[name], own, scales=units(stator.solid))
    unknowns = _Unknowns(piece, stator, space, media, names)
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
    )


class _Unknowns:
    """Unknowns on a piece's edges and vertices: fixed at zero, tied to an electrode, on an interface, or free."""

    def __init__(
        self,
        piece: MeshPiece,
        stator: Stator,
        space: QuadSpace,
        media: dict[str, Medium],
        names: tuple[str, ...],
    ):
        self.space, self.names = space, names
        self.held = np.ones((space.skeleton, len(names)), dtype=bool)  # fixed at zero, or in no element
        for solid, own in media.items():
            numbers = np.unique(space.numbers[space.mesh.solids == solid][:, : space.rim])
            self.held[numbers[:, None], [names.index(name) for name in own.fields]] = False
        lines, self.grounded = space.mesh.lines, False
        for group, condition in (("bottom", stator.bottom), ("clamped", "clamped"), ("grounded", "grounded")):
            if group in lines:
                zero = [("phi" if name == "phi" else "u") in HELD[condition] for name in names]
                self.held[np.unique(space.edge_numbers(lines[group]))] |= zero
                self.grounded |= "phi" in names and condition == "grounded"
        electrodes = [name for name in piece.mesh.electrodes if "phi" in names]
        connections = [piece.connection(name) for name in electrodes]
        self.ports = tuple(
            Port(kind="voltage", name=each) for each in connections if each not in (FLOATING, GROUNDED)
        )
        # Number of the electrode that a function is tied to.  The functions inside its edges are zero, because the
        # potential is constant.
        self.tied = np.full(self.held.shape, -1)
        for index, name in enumerate(electrodes):
            numbers, phi = space.edge_numbers(lines[ELECTRODE + name]), names.index("phi")
            self.held[np.unique(numbers[:, 2:]), phi] = True
            if connections[index] == GROUNDED:
                self.held[np.unique(numbers[:, :2]), phi] = True
                self.grounded = True
            else:
                self.tied[np.unique(numbers[:, :2]), phi] = index
        self.floating = [k for k, each in enumerate(connections) if each == FLOATING]
        self.wired = [k for k, each in enumerate(connections) if each not in (FLOATING, GROUNDED)]

    def numbered(self, sections: dict[str, Section]) -> tuple[np.ndarray, np.ndarray]:
        """``numbers`` and ``projection`` of the `Assembly`.

        Unknowns to be eliminated (free ones and floating electrodes) come first, then the interfaces and the ports.
        """
        count, tied = len(self.names), self.tied.ravel()
        prescribed = self.held | (self.tied >= 0)
        free = ~prescribed.ravel()
        interfaces, projections = [], []  # unknowns of an interface, and these from the section's line
        for side, section in sections.items():
            by_field = line_projection(
                self.space,
                self.space.mesh.lines[side],
                section,
                {name: prescribed[:, column] for column, name in enumerate(self.names)},
            )
            functions, parts = zip(*(by_field[name] for name in self.names), strict=True)
            own = np.concatenate([each * count + column for column, each in enumerate(functions)])
            interfaces.append(own)
            projections.append(np.concatenate(parts))
            free[own] = False
        numbers, total = np.full(free.shape, -1), int(free.sum())
        numbers[free] = np.arange(total)
        for electrode in self.floating:
            numbers[tied == electrode], total = total, total + 1
        for interface in interfaces:
            numbers[interface], total = total + np.arange(len(interface)), total + len(interface)
        for electrode in self.wired:
            numbers[tied == electrode], total = total, total + 1
        from scipy.linalg import block_diag  # a run without meshed pieces spares this import, 0.15 s

        return numbers, block_diag(*projections, np.eye(len(self.ports)))
