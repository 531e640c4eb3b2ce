"""Construction of a reduced model from full solutions at some frequencies of a band: snapshots, bases, projection."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fem.circuit import Drive
from fem.condense.condensed_mesh import MeshedPiece
from fem.condense.finger_columns import SurfaceReactions
from fem.condense.reaction_moments import finger_moment, finger_reactions
from fem.condense.transducer import Condensation, FingerShape, half_cells
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.discretize.spectral import chebyshev_nodes
from fem.geometry import Stator, Transducer
from fem.reduce.basis import (
    WALL_WIDTH,
    Directions,
    ReducedSection,
    bases_of,
    containing,
    decomposed,
    even_transducers,
    parity_groups,
    snapshots,
)
from fem.reduce.piece_band import piece_of_cascade
from fem.reduce.reduced_model import HalfCell, ReducedModel
from fem.results.stator_solution import Solution, driven_solution
from fem.threads import side_by_side
from fem.waveguide.end_conditions import end_walls
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.port_fields import joined_cascade
from fem.waveguide.stator_meshes import StatorMeshes

PIECE_SHARE = 0.3  # of the tolerance, for the interpolation of meshed pieces
AMPLITUDE_SHARE = 1e-2  # smallest relative amplitude that the basis must represent, over the tolerance
# (Largest relative width of the band, number of nodes): the interpolation then errs by 1e-6.
NODES = ((0.12, 4), (0.25, 5), (0.5, 7))
# For these and larger tolerances one node fewer suffices, with an error of 1e-4; (absorbing, reflecting ends), between
# which resonances amplify it
LOOSE = 3e-4, 3e-3
# For these and smaller ones a node more is taken: the seed's stator with free ends errs by 9e-6 with four nodes.
TIGHT = 2e-6, 2e-5


@dataclass(frozen=True, kw_only=True)
class BandProblem:
    """Stator, band, tolerance, and the drive and positions at which the error is checked."""

    stator: Stator
    transducers: tuple[Transducer, ...]  # from left to right
    limits: tuple[float, float]  # lowest and highest frequency, Hz
    drive: str | Drive
    tolerance: float
    positions: np.ndarray  # m
    # True: a node more, and one more solution of the whole stator
    more_nodes: bool = False
    charges: bool = False  # True: the charges at the nodes on the fingers are interpolated too

    @property
    def nodes(self) -> np.ndarray:
        """Chebyshev nodes of the band in omega^2, (rad/s)^2."""
        lowest, highest = self.limits
        width = 2 * (highest - lowest) / (highest + lowest)
        count = next((count for widest, count in NODES if width <= widest), None)
        if count is None:
            raise ValueError(
                f"a band must not be wider than {NODES[-1][0]:g} of its middle, got {lowest:g} to {highest:g} Hz: "
                "split it"
            )
        reflecting = self.stator.ends != "absorbing"
        if self.tolerance >= LOOSE[reflecting]:
            count -= not self.more_nodes
        else:
            count += self.more_nodes + (self.tolerance <= TIGHT[reflecting])
        return chebyshev_nodes((2 * np.pi * lowest) ** 2, (2 * np.pi * highest) ** 2, count)

    @property
    def between_nodes(self) -> float:
        """Frequency in Hz near the middle of the band where an interpolation over its nodes has the largest error."""
        (lowest, highest), count = self.limits, len(self.nodes)
        node = np.cos(np.pi * (count // 2 + count % 2) / count)
        return float(np.sqrt((lowest**2 + highest**2) / 2 + node * (highest**2 - lowest**2) / 2))


@dataclass(frozen=True, kw_only=True)
class NodeSolutions:
    """Superelements and fields on full lines at the nodes of a band."""

    section: Section
    resolution: Resolution
    # by finger shape: at every node the matrices of the rising and, unless it is its mirror image, of the falling half,
    # their moments below
    half_cells: dict = field(repr=False)
    reactions: dict = field(repr=False)  # by finger shape: at every node those on each half of the finger, or none
    walls: list = field(repr=False)  # at every node, or empty
    # of the fields on the lines at mid-gap and at mid-finger, by group of unknowns
    decompositions: list[tuple[Directions, Directions]] = field(repr=False)
    solutions: list[Solution] = field(repr=False)  # at some of the nodes
    meshes: StatorMeshes = field(repr=False)
    # distinct meshed pieces at all nodes, and at those added for their own interpolation
    pieces: dict[tuple, list[MeshedPiece]] = field(repr=False)


class _Node(NamedTuple):
    """Superelements at one node, and a solution if the whole stator is solved there; no walls for absorbing ends."""

    matrices: dict  # by finger shape: half cells as in `NodeSolutions`
    reactions: dict  # by finger shape
    walls: np.ndarray | None
    fields: tuple | None
    solution: Solution | None
    pieces: dict[tuple, MeshedPiece]


def solve_at_nodes(problem: BandProblem, resolution: Resolution) -> NodeSolutions:
    """Condense half cells and ends at every node, and solve the whole stator at three of them."""
    stator, transducers = problem.stator, problem.transducers
    unit = stator.slowest_wavelength(problem.limits[1])
    scale = min(transducer.finger_width / 2 for transducer in transducers)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    squares = problem.nodes
    solved = {0, len(squares) - 1}  # nodes at which the whole stator is solved
    if problem.more_nodes:
        solved.add(len(squares) // 2)
    shapes = dict.fromkeys(FingerShape.of(each, unit) for each in transducers)
    meshes = StatorMeshes(stator, section, resolution, problem.limits[1])
    distinct = 2 if section.odd is None else 1  # halves of a cell that are not each other's mirror image

    def at_node(index: int) -> _Node:
        frequency = float(np.sqrt(squares[index]) / (2 * np.pi))
        condensed = meshes.condensed(frequency)
        make = Condensation(section, frequency)
        halves = {shape: half_cells(make, shape, resolution) for shape in shapes}
        walls = fields = solution = None
        if stator.ends != "absorbing":
            ends = end_walls(section, frequency, stator, resolution, width=WALL_WIDTH)
            walls = np.stack([end.matrix for end in ends])
        if index in solved:
            modes = guided_modes(section, frequency)
            port_fields = joined_cascade(
                stator,
                transducers,
                even_transducers(make, transducers, lambda shape: make.joined(*halves[shape], 0)),
                modes=modes,
                resolution=resolution,
                pieces=meshes.arranged(condensed, modes),
            ).solved()
            fields = snapshots(port_fields, halves, AMPLITUDE_SHARE * problem.tolerance)
            solution = driven_solution(port_fields, problem.drive)
        matrices = {
            shape: tuple(
                np.vstack([half.matrix, finger_moment(half, side)]) for side, half in enumerate(pair[:distinct])
            )
            for shape, pair in halves.items()
        }
        reactions = {
            shape: tuple(finger_reactions(half) for half in pair[:distinct]) if problem.charges else ()
            for shape, pair in halves.items()
        }
        return _Node(matrices, reactions, walls, fields, solution, condensed)

    nodes = side_by_side(at_node, range(len(squares)))
    fields = [node.fields for node in nodes if node.fields is not None]
    gaps = np.hstack([gap for gap, _ in fields] + [section.constant_potential[:, None]])
    fingers = np.hstack([finger for _, finger in fields])
    return NodeSolutions(
        section=section,
        resolution=resolution,
        half_cells={shape: [node.matrices[shape] for node in nodes] for shape in shapes},
        reactions={shape: [node.reactions[shape] for node in nodes] for shape in shapes},
        walls=[node.walls for node in nodes if node.walls is not None],
        decompositions=decomposed((gaps, fingers), parity_groups(section, stator.ends == "clamped")),
        solutions=[node.solution for node in nodes if node.solution is not None],
        meshes=meshes,
        pieces={key: [node.pieces[key] for node in nodes] for key in meshes.assemblies},
    )


def project(problem: BandProblem, nodes: NodeSolutions, truncation: float) -> ReducedModel:
    """Project the nodes' superelements on bases of the lines' fields.

    Singular values below ``truncation`` times the largest are left out.
    """
    section = nodes.section
    gap, finger = bases_of(nodes.decompositions, section.size, truncation)
    bases = containing(gap, section.constant_potential) if section.floating_potential else gap, finger
    odd = None
    if section.odd is not None:
        odd = np.array([section.odd[np.argmax(abs(column))] for column in bases[0].T])
    walls = [bases[0].T @ pair @ bases[0] for pair in nodes.walls]
    reduced = ReducedSection(full=section, basis=bases[0], odd=odd)
    rational = {
        key: piece_of_cascade(pieces, reduced, nodes.solutions, problem.limits, PIECE_SHARE * problem.tolerance)
        for key, pieces in nodes.pieces.items()
    }
    return ReducedModel(
        stator=problem.stator,
        transducers=problem.transducers,
        limits=problem.limits,
        resolution=nodes.resolution,
        section=reduced,
        finger_basis=bases[1],
        half_cells={
            shape: _projected_halves(pairs, nodes.reactions[shape], bases, shape.half_finger + shape.half_gaps[0])
            for shape, pairs in nodes.half_cells.items()
        },
        nodes=problem.nodes,
        walls=np.stack(walls) if walls else None,
        meshes=nodes.meshes,
        pieces={key: piece for key, (piece, _) in rational.items()},
        piece_error=max((error for _, error in rational.values()), default=0.0),
    )


def _projected_halves(halves: list[tuple], reactions: list[tuple], bases, width: float) -> HalfCell:
    gap, finger = bases
    lines = (gap, finger), (finger, gap)  # left and right one of the rising and of the falling half

    def projected(half: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        *matrix, moment = half
        once = _onto_lines(_onto_lines(np.array(matrix), left, right).T, left, right).T
        return np.vstack([once, _onto_lines(moment[:, None], left, right).T])

    def projected_reactions(at_nodes: tuple[SurfaceReactions, ...], left, right) -> SurfaceReactions:
        return at_nodes[0]._replace(rows=np.stack([_onto_lines(each.rows.T, left, right).T for each in at_nodes]))

    rising, *falling = zip(*halves, strict=True)
    return HalfCell(
        rising=np.stack([projected(half, gap, finger) for half in rising]),
        falling=np.stack([projected(half, finger, gap) for half in falling[0]]) if falling else None,
        width=width,
        reactions=tuple(
            projected_reactions(each, *both) for each, both in zip(zip(*reactions, strict=True), lines, strict=False)
        ),
    )


def _onto_lines(matrix: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Project the rows of a matrix on the bases of both lines; the rows of the electrodes stay."""
    # a product of real matrices takes half the time; without loss and absorbing layers the matrix itself is real
    rows = np.ascontiguousarray(matrix).view(float)
    size = len(left)
    return np.vstack([left.T @ rows[:size], right.T @ rows[size : 2 * size], rows[2 * size :]]).view(matrix.dtype)
