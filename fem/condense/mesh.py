"""A piece of the stator from a mesh: assembled, condensed to its interfaces and electrodes, recovered.

The inside of every element is eliminated in batches (static condensation), then the edges and vertices between them by
a sparse Schur complement.  On an interface the mesh's unknowns are P times those of the section's line
(`fem.condense.interface`), so that the condensed matrix is P^T A P and stays complex symmetric.  An electrode is
equipotential: the potential of its vertices is one unknown, which a connection makes a port, ground makes zero, and
which is eliminated, without net charge, where the electrode floats.

A piece with one interface is an end of the stator.  One whose far side is another section's line is a step: its far
side is closed by that section's radiation impedance.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.interface import line_projection
from fem.condense.piece import Port
from fem.condense.sparse import schur_complement, sparse_solution
from fem.convergence import ConvergenceError
from fem.discretize.grading import Resolution
from fem.discretize.quads import QuadSpace, medium_matrices
from fem.discretize.section import FIELD_COLUMN, Section
from fem.geometry import Stator
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import Medium, medium, units
from fem.mesh.piece import FLOATING, GROUNDED, MeshPiece
from fem.mesh.quads import conditions_of, quad_mesh
from fem.mesh.section_mesh import ELECTRODE, MeshError

# Layers towards corners beyond those towards finger edges.  On a user's 70 triangles the admittance errs by 6e-5, 3e-6
# and 6e-7 at (order, layers) = (5, 2), (6, 3), (7, 4).
MORE_LAYERS = 2
MAX_UNKNOWNS = 2_000_000
MAX_AMPLIFICATION = 1e9  # of the condensed matrix over that of the elements: seven digits are left
HELD = {"clamped": ("u",), "grounded": ("phi",), "free": ()}


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
    unknowns: int  # of the mesh
    reduced: object = field(repr=False)  # sparse matrix over free unknowns, lines and ports
    _last: dict = field(default_factory=dict, init=False, repr=False)

    def recover(self, sides: np.ndarray) -> "MeshField":
        """Field inside for given lines and ports, shape (len(matrix),)."""
        sides = np.asarray(sides, dtype=complex)
        key = sides.tobytes()
        if key not in self._last:
            free = self.reduced.shape[0] - len(sides)
            inside = np.zeros(free, dtype=complex)
            if free:
                load = -(self.reduced[:free, free:] @ sides)
                inside = sparse_solution(self.reduced[:free, :free], load[:, None])[:, 0]
            values = self.assembly.expansion @ np.concatenate([inside, sides])
            self._last.clear()
            self._last[key] = MeshField(assembly=self.assembly, frequency=self.frequency, skeleton=values)
        return self._last[key]


@dataclass(frozen=True, kw_only=True, eq=False)
class Assembly:
    """What of a meshed piece does not depend on the frequency: elements, media, conditions and interfaces."""

    piece: MeshPiece
    space: QuadSpace = field(repr=False)
    media: dict[str, Medium] = field(repr=False)  # by surface group
    fields: tuple[str, ...]  # of the stator
    sides: tuple[str, ...]  # "left", "right" or one of them
    lines: tuple[int, ...]  # unknowns of the section's line on each side
    ports: tuple[Port, ...]
    # shape (skeleton unknowns, free unknowns + lines + ports): unknowns on edges and vertices from those that remain
    expansion: object = field(repr=False)
    floating_potential: bool

    @property
    def kept(self) -> int:
        """Unknowns of lines and ports: the last columns of ``expansion``."""
        return sum(self.lines) + len(self.ports)

    def solids(self):
        """Yield the solids' names, media and elements."""
        for name, own in self.media.items():
            chosen = np.flatnonzero(self.space.mesh.solids == name)
            if len(chosen):
                yield name, own, chosen

    def unknowns(self, own: Medium, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Skeleton unknowns on the rim of elements (m, rim * fields); local order of rim and inside."""
        columns = np.array([self.fields.index(name) for name in own.fields])
        numbers = self.space.numbers[elements][:, : self.space.rim]
        return (numbers[:, :, None] * len(self.fields) + columns).reshape(len(elements), -1)

    def condensed(self, frequency: float) -> MeshedPiece:
        """Condense the piece at a frequency in Hz."""
        from scipy.sparse import coo_matrix

        rows, columns, values = [], [], []
        for _, own, chosen in self.solids():
            rim = self.space.rim * len(own.fields)
            for elements in self.space.chunks(chosen):
                full = medium_matrices(self.space.scalar_matrices(elements), own, self._angular(frequency))
                outer, _ = _eliminated(full, rim)
                numbers = self.unknowns(own, elements)
                rows.append(np.repeat(numbers, rim, axis=1).ravel())
                columns.append(np.tile(numbers, (1, rim)).ravel())
                values.append(outer.ravel())
        count = self.expansion.shape[0]
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        skeleton = coo_matrix(entries, shape=(count, count)).tocsr()
        reduced = (self.expansion.T @ skeleton @ self.expansion).tocsr()
        matrix = schur_complement(reduced, self.kept)
        scale = abs(skeleton.data).max()
        if not abs(matrix).max() < MAX_AMPLIFICATION * scale:
            raise ConvergenceError(
                f'the piece "{self.piece.name}", clamped at its interfaces, resonates at this very frequency: change '
                "the frequency by a part in a million, or give the solid a mechanical_quality"
            )
        low, high = self.piece.extent
        return MeshedPiece(
            assembly=self,
            frequency=frequency,
            sides=self.sides,
            size=self.lines[0] if self.lines else 0,
            matrix=matrix,
            width=(high - low) / self.space.unit,
            ports=self.ports,
            floating_potential=self.floating_potential,
            unknowns=self.space.size * len(self.fields),
            reduced=reduced,
        )

    def _angular(self, frequency: float) -> float:
        return 2 * np.pi * frequency * self.space.unit


def _eliminated(full: np.ndarray, rim: int) -> tuple[np.ndarray, np.ndarray]:
    """Condensed matrices of elements (m, rim, rim), and their insides from their rims, (m, inside, rim)."""
    inside = -np.linalg.solve(full[:, rim:, rim:], full[:, rim:, :rim])
    outer = full[:, :rim, :rim] + full[:, :rim, rim:] @ inside
    return 0.5 * (outer + outer.swapaxes(1, 2)), inside


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshField:
    """Field of a meshed piece for given lines and ports."""

    assembly: Assembly = field(repr=False)
    frequency: float  # Hz
    skeleton: np.ndarray = field(repr=False)  # scaled unknowns of edges and vertices, fields innermost

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
        """Scaled u_x, u_y, u_z and phi at points (m, 2) from the left edge and the surface, length units.

        Values and their derivatives along x and z, (m, 4) each, zero outside the mesh; and whether a point lies in it.
        """
        space, _names = self.assembly.space, self.assembly.fields
        shift = np.array([self.assembly.piece.mesh.extent[0] / space.unit, 0.0])
        owner, places = space.locate(np.asarray(points) + shift)
        out = np.zeros((3, len(points), 4), dtype=complex)
        for _, own, chosen in self.assembly.solids():
            columns = [FIELD_COLUMN[name] for name in own.fields]
            for elements, _, values in self.elements(own, np.intersect1d(chosen, owner)):
                for element, unknowns in zip(elements, values, strict=True):
                    here = np.flatnonzero(owner == element)
                    value, by_first, by_second = space.local_values(places[here])
                    nodal = unknowns.reshape(-1, len(own.fields))
                    slopes = space.slopes(element, places[here])
                    reference = np.stack([by_first @ nodal, by_second @ nodal], axis=1)
                    out[0][np.ix_(here, columns)] = value @ nodal
                    for axis in (0, 1):
                        out[1 + axis][np.ix_(here, columns)] = np.einsum(
                            "mr,mrf->mf", slopes[:, :, axis], reference
                        )
        return *out, owner >= 0

    def elements(self, own: Medium, chosen: np.ndarray):
        """Yield elements of one medium in parts: numbers, scalar matrices, all unknowns (m, functions * fields)."""
        assembly = self.assembly
        angular = 2 * np.pi * self.frequency * assembly.space.unit
        rim = assembly.space.rim * len(own.fields)
        for elements in assembly.space.chunks(chosen):
            scalars = assembly.space.scalar_matrices(elements)
            _, inside = _eliminated(medium_matrices(scalars, own, angular), rim)
            outer = self.skeleton[assembly.unknowns(own, elements)]
            values = np.concatenate([outer, (inside @ outer[:, :, None])[:, :, 0]], axis=1)
            yield elements, scalars, values

    def loss(self) -> float:
        """Power lost inside, scaled, (omega / 2) sum u^H Im(A) u, from the imaginary moduli element by element."""
        total = 0.0
        for _, own, chosen in self.assembly.solids():
            if not np.iscomplexobj(own.xx):
                continue
            for _, scalars, values in self.elements(own, chosen):
                matrices = medium_matrices(scalars, own, 0.0, part="loss")
                total += float(np.einsum("ei,eij,ej->", values.conj(), matrices, values).real)
        return np.pi * self.frequency * total


class _TopEdges:
    """The upper border of a mesh: which outer edge is highest at a place x, and the functions there."""

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
        """Functions (places, order + 1) and their values at the highest outer point above each place."""
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
    """Elements, conditions and interfaces of a meshed piece on one discretisation.

    ``sections``: of the line on each side that has an interface; ``frequency`` in Hz sets the largest element.

    Raises
    ------
    MeshError
        If a solid, an electrode or a condition does not fit the stator.
    ConvergenceError
        If the mesh has more unknowns than can be solved for.
    """
    unit = (
        next(iter(sections.values())).length_unit if sections else slowest_wavelength(stator.solid, frequency)
    )
    names = fields_of(stator)
    solids = {"stator": stator.solid} | dict(piece.solids)
    space = QuadSpace(
        quad_mesh(
            piece.mesh,
            layers=resolution.edge_layers + MORE_LAYERS,
            largest={
                name: resolution.element_size * slowest_wavelength(solids[name], frequency)
                for name in piece.mesh.solids
            },
            conditions=conditions_of(piece, stator.bottom),
        ),
        resolution.order,
        unit,
    )
    if space.size * len(names) > MAX_UNKNOWNS:
        raise ConvergenceError(
            f'the piece "{piece.name}" has {space.size * len(names):.2g} unknowns at order {resolution.order}, at most '
            f"{MAX_UNKNOWNS:.0g} are solved for: draw its mesh coarser, the program refines corners itself and raises "
            "the order"
        )
    media = {}
    for name in piece.mesh.solids:
        own = tuple(each for each in names if each != "phi" or solids[name].is_piezoelectric)
        media[name] = medium(solids[name], own, scales=units(stator.solid))
    constraints = _Constraints(piece, stator, space, media, names)
    sides = tuple(side for side in ("left", "right") if side in sections)
    expansion = constraints.expansion({side: sections[side] for side in sides})
    return Assembly(
        piece=piece,
        space=space,
        media=media,
        fields=names,
        sides=sides,
        lines=tuple(sections[side].size for side in sides),
        ports=constraints.ports,
        expansion=expansion,
        floating_potential="phi" in names and not constraints.holds_potential,
    )


def fields_of(stator: Stator) -> tuple[str, ...]:
    """Fields of the stator's section."""
    from fem.materials import fields

    return fields(stator.solid)


class _Constraints:
    """Which unknowns of a mesh are held, tied to an electrode, or the section's line's."""

    def __init__(self, piece: MeshPiece, stator: Stator, space: QuadSpace, media: dict, names: tuple):
        self.piece, self.space, self.names = piece, space, names
        count = len(names)
        self.exists = np.zeros((space.skeleton, count), dtype=bool)
        for name, own in media.items():
            numbers = np.unique(space.numbers[space.mesh.solids == name][:, : space.rim])
            self.exists[np.ix_(numbers, [names.index(each) for each in own.fields])] = True
        self.zero = np.zeros((space.skeleton, count), dtype=bool)
        self.tied = np.full((space.skeleton, count), -1)  # number of the electrode
        lines, self.holds_potential = space.mesh.lines, False
        for group, word in (("bottom", stator.bottom), ("clamped", "clamped"), ("grounded", "grounded")):
            if group in lines:
                held = HELD.get(word, ())
                columns = [k for k, name in enumerate(names) if ("phi" if name == "phi" else "u") in held]
                numbers = np.unique(space.edge_numbers(lines[group]))
                self.zero[np.ix_(numbers, columns)] = True
                self.holds_potential |= "phi" in held and "phi" in names
        self.electrodes = [name for name in piece.mesh.electrodes if "phi" in names]
        self.ports = tuple(
            Port(kind="voltage", name=piece.connection(name))
            for name in self.electrodes
            if piece.connection(name) not in (FLOATING, GROUNDED)
        )
        for index, name in enumerate(self.electrodes):
            self._tie(index, name)
        self.holds_potential |= bool(self.ports)

    def _tie(self, index: int, name: str) -> None:
        phi = self.names.index("phi")
        edges = self.space.mesh.lines[ELECTRODE + name]
        numbers = self.space.edge_numbers(edges)
        vertices, bubbles = np.unique(numbers[:, :2]), np.unique(numbers[:, 2:])
        if not self.exists[vertices, phi].any():
            raise MeshError(f'the electrode "{name}" touches no piezoelectric solid')
        if (self.tied[vertices, phi] >= 0).any():
            other = self.electrodes[int(self.tied[vertices, phi].max())]
            raise MeshError(f'the electrodes "{name}" and "{other}" touch: give them one name')
        for side in ("left", "right"):
            if (
                side in self.space.mesh.lines
                and np.isin(vertices, self.space.edge_numbers(self.space.mesh.lines[side])).any()
            ):
                raise MeshError(f'the electrode "{name}" reaches the interface {side}: it must end before it')
        self.zero[bubbles, phi] = True
        if self.piece.connection(name) == GROUNDED:
            self.zero[vertices, phi] = True
            self.holds_potential = True
        else:
            self.tied[vertices, phi] = index

    def expansion(self, sections: dict[str, Section]):
        """All skeleton unknowns from the free ones, the lines' and the ports'."""
        from scipy.sparse import coo_matrix

        count = len(self.names)
        free = self.exists & ~self.zero & (self.tied < 0)
        parts = []  # (rows, local columns, values, block)
        for side, section in sections.items():
            edges = self.space.mesh.lines[side]
            for column, name in enumerate(self.names):
                own, projection = line_projection(self.space, edges, section, name, free[:, column])
                free[own, column] = False
                rows, lines = np.nonzero(projection)
                parts.append((own[rows] * count + column, lines, projection[rows, lines], side))
        numbers = np.flatnonzero(free.ravel())
        floating = [
            index for index, name in enumerate(self.electrodes) if self.piece.connection(name) == FLOATING
        ]
        wired = [
            index
            for index, name in enumerate(self.electrodes)
            if self.piece.connection(name) not in (FLOATING, GROUNDED)
        ]
        first: dict = {}
        total = len(numbers) + len(floating)
        for side, section in sections.items():
            first[side] = total
            total += section.size
        of_electrode = {index: len(numbers) + k for k, index in enumerate(floating)}
        of_electrode |= {index: total + k for k, index in enumerate(wired)}
        total += len(wired)
        tied = np.flatnonzero((self.tied >= 0).ravel())
        rows = [numbers, tied] + [each[0] for each in parts]
        columns = [
            np.arange(len(numbers)),
            np.array([of_electrode[index] for index in self.tied.ravel()[tied]], dtype=int),
        ] + [first[side] + lines for _, lines, _, side in parts]
        values = [np.ones(len(numbers)), np.ones(len(tied))] + [each[2] for each in parts]
        matrix = coo_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(self.space.skeleton * count, total),
        ).tocsr()
        return matrix
