"""Assembly of a meshed piece: its elements, boundary conditions, electrodes and interfaces at one resolution.

On an interface the unknowns of the mesh are P times those of the section's line (`fem.condense.mortar_interface`).  An
electrode is equipotential: all its vertices share one unknown (`fem.condense.electrode_conditions`).

On a half-space the mesh is continued down to the section's absorbing layer (`fem.mesh.deepened`), and the layer by its
own elements below the mesh (`fem.condense.layer_columns`).
"""

from dataclasses import replace

import numpy as np

from fem.block_matrix import block_diagonal
from fem.condense.condensed_mesh import Assembly
from fem.condense.electrode_conditions import MeshElectrodes
from fem.condense.layer_columns import LayerColumns
from fem.condense.mortar_interface import line_projection
from fem.discretize.element_sizes import Resolution
from fem.discretize.quad_elements import QuadSpace
from fem.discretize.section import Section
from fem.exceptions import ConvergenceError
from fem.geometry import Stator
from fem.materials import fields as coupled_fields
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import Medium, medium, units
from fem.mesh.deepened import deepened
from fem.mesh.mesh_piece import MAX_UNKNOWNS, MeshPiece
from fem.mesh.quad_mesh import conditions_of, quad_mesh

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
# Fields that a boundary condition sets to zero.
HELD: dict[str, tuple[str, ...]] = {"clamped": ("u",), "grounded": ("phi",), "free": ()}


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
        ports=unknowns.electrodes.ports,
        numbers=numbers,
        projection=projection,
        grounded=unknowns.grounded,
        layer=layer,
    )


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
        self.electrodes = MeshElectrodes(piece, space, names)
        self.grounded |= self.electrodes.grounded
        for functions in self.electrodes.held:
            self.held[functions, names.index("phi")] = True
        self.tied = np.full(self.held.shape, -1)  # number of the electrode that a function is tied to
        for index, functions in self.electrodes.tied.items():
            self.tied[functions, names.index("phi")] = index

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
        for electrode in self.electrodes.floating:
            numbers[tied == electrode], total = total, total + 1
        for interface in interfaces:
            numbers[interface], total = total + np.arange(len(interface)), total + len(interface)
        for electrode in self.electrodes.connected:
            numbers[tied == electrode], total = total, total + 1
        return numbers, block_diagonal(*projections, np.eye(len(self.electrodes.ports)))
