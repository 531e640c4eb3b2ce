"""Unknowns on the edges and vertices of a meshed piece: boundary conditions, electrodes and interfaces."""

import numpy as np

from fem.block_matrix import block_diagonal
from fem.condense.interface import line_projection
from fem.condense.layer_columns import LayerColumns
from fem.condense.piece import Port
from fem.discretize.quads import QuadSpace
from fem.discretize.section import Section
from fem.geometry import Stator
from fem.materials.medium import Medium
from fem.mesh.piece import FLOATING, GROUNDED, MeshPiece
from fem.mesh.section_mesh import ELECTRODE

# Fields that a boundary condition sets to zero.
HELD: dict[str, tuple[str, ...]] = {"clamped": ("u",), "grounded": ("phi",), "free": ()}


class MeshUnknowns:
    """Unknowns on a piece's edges and vertices: fixed at zero, tied to an electrode, on an interface, or free."""

    def __init__(
        self,
        piece: MeshPiece,
        stator: Stator,
        space: QuadSpace,
        media: dict[str, Medium],
        names: tuple[str, ...],
        layer: LayerColumns | None = None,
    ):
        self.space, self.names, self.layer = space, names, layer
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
        if layer is not None:
            self.held = np.concatenate([self.held, layer.held])
            self.grounded |= "phi" in names  # phi is zero below an absorbing layer
        electrodes = [name for name in piece.mesh.electrodes if "phi" in names]
        connections = [piece.connection(name) for name in electrodes]
        self.ports = tuple(Port(kind="voltage", name=each) for each in connections if each not in (FLOATING, GROUNDED))
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
            if self.layer is not None:  # its line is the section's own
                unknowns, dofs = self.layer.line(side)
                own, parts = np.append(own, unknowns), (*parts, np.eye(section.size)[dofs])
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
        return numbers, block_diagonal(*projections, np.eye(len(self.ports)))
