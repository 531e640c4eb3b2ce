"""Reduced model of a stator over a band: interpolated superelements of half cells, on lines reduced to a basis.

Two quantities change slowly with frequency.

1. A half cell (half a gap and half a finger, a quarter of a wavelength) has no resonance of its own in the band.  Its
   condensed matrix is well approximated by a polynomial in omega^2 of low degree, so it is condensed at a few Chebyshev
   nodes and interpolated.
2. The fields on the interface lines between the halves, of all fingers, all ports and all incident waves, span few
   dimensions.  Full solutions at some of the nodes give a basis (proper orthogonal decomposition; basis.py), one for
   the lines at the middle of gaps and one for those at the middle of fingers.

After projection on the basis the pieces are joined, the modes computed and the ends attached as on full lines, with a
tenth of the unknowns.  The field inside a finger's cell or beside an end needs full lines: those pieces are condensed
again at that frequency, and the reduced lines are lifted to them.
"""

from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from fem.condense.cascade_piece import Blocks
from fem.condense.finger_columns import FingerColumns, LiftedHalf, SurfaceReactions
from fem.condense.interpolated_piece import RationalPiece
from fem.condense.transducer import Condensation, FingerShape, half_cells
from fem.discretize.element_sizes import Resolution
from fem.discretize.spectral import lagrange_weights
from fem.geometry import Stator, Transducer
from fem.reduce.basis import WALL_WIDTH, ReducedSection, even_transducers
from fem.waveguide.end_conditions import Wall, end_walls
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import StatorCascade, joined_cascade
from fem.waveguide.stator_meshes import StatorMeshes


@dataclass(frozen=True, kw_only=True)
class HalfCell:
    """Projected half cells of one kind of finger at the nodes, electrode 0, with the row of the finger's moment.

    ``rising`` and ``falling``: shape (nodes, 2 r + 3, 2 r + 2).  ``reactions``: of each half
    those of `fem.condense.reaction_moments.finger_reactions`, with rows of shape (nodes, points, 2 r + 2); empty if the
    problem does not ask for them.
    """

    rising: np.ndarray = field(repr=False)
    falling: np.ndarray | None = field(repr=False)
    width: float
    reactions: tuple[SurfaceReactions, ...] = field(default=(), repr=False)


class FullPieces:
    """Superelements on full lines at one frequency of a band (Hz), each condensed on first use."""

    def __init__(self, model: "ReducedModel", frequency: float):
        self.model, self.frequency = model, frequency
        self._halves: dict[FingerShape, tuple[FingerColumns, FingerColumns]] = {}
        self._ends: tuple[Wall, Wall] | None = None

    def half_cell(self, shape: FingerShape, side: int, sides: np.ndarray) -> tuple[FingerColumns, np.ndarray]:
        """Return the rising (0) or falling (1) half of a finger's cell, and its sides from the reduced ones."""
        model, full = self.model, self.model.section.full
        if shape not in self._halves:
            self._halves[shape] = half_cells(Condensation(full, self.frequency), shape, model.resolution)
        gap, finger = model.section.basis, model.finger_basis
        at, lines = Blocks(model.section.size), (gap, finger) if side == 0 else (finger, gap)
        left, right = (
            np.tensordot(basis, sides[line], axes=1) for basis, line in zip(lines, (at.left, at.right), strict=True)
        )
        lifted = np.concatenate([left, right, sides[at.ports]])
        return self._halves[shape][side], lifted

    def end(self, side: int, line: np.ndarray):
        """Return the field in the columns beside the left (0) or right (1) end, from the reduced inner line."""
        model, full = self.model, self.model.section.full
        if self._ends is None:
            self._ends = end_walls(full, self.frequency, model.stator, model.resolution, width=WALL_WIDTH)
        return self._ends[side].recover(model.section.lift(line))


@dataclass(frozen=True, kw_only=True)
class ReducedModel:
    """A stator on reduced lines, interpolated over a band of frequencies."""

    stator: Stator
    transducers: tuple[Transducer, ...]  # from left to right
    limits: tuple[float, float]  # lowest and highest frequency in Hz
    resolution: Resolution
    section: ReducedSection  # its basis is that of the lines in mid-gap
    finger_basis: np.ndarray = field(repr=False)  # shape (n, r): of the lines in mid-finger
    half_cells: dict = field(repr=False)  # `HalfCell` by finger shape
    nodes: np.ndarray = field(repr=False)  # omega^2 of the interpolation's nodes, (rad/s)^2
    # projected end pieces at the nodes, shape (nodes, 2, r, r); None for absorbing ends
    walls: np.ndarray | None = field(repr=False)
    meshes: StatorMeshes = field(repr=False)
    pieces: dict[tuple, RationalPiece] = field(repr=False)  # distinct meshed pieces of the cascade
    piece_error: float  # relative error of their interpolation, of the fields on their interface lines

    def cascade(self, frequency: float, forces: tuple[LineForce, ...] = ()) -> StatorCascade:
        """Cascade at a frequency of the band (Hz), with line forces on the bare surface."""
        weights = lagrange_weights(self.nodes, (2 * np.pi * frequency) ** 2)
        full = FullPieces(self, frequency)
        make = Condensation(self.section, frequency)
        pieces = even_transducers(make, self.transducers, lambda shape: self._cell(make, shape, weights, full))
        modes = guided_modes(self.section, frequency)
        arranged = self.meshes.arranged({key: piece.at(frequency) for key, piece in self.pieces.items()}, modes)
        if self.walls is not None:
            plain = [isinstance(end, str) for end in arranged.ends]
            matrices = np.tensordot(weights, self.walls, axes=1)
            left, right = (
                Wall(matrix=matrix, recover=partial(full.end, side)) if plain[side] else arranged.ends[side]
                for side, matrix in enumerate(matrices)
            )
            arranged = replace(
                arranged,
                ends=(left, right),
                start=arranged.start + WALL_WIDTH * plain[0],
                stop=arranged.stop - WALL_WIDTH * plain[1],
            )
        return joined_cascade(
            self.stator,
            self.transducers,
            pieces,
            modes=modes,
            resolution=self.resolution,
            pieces=arranged,
            forces=forces,
        )

    def _cell(self, make, shape: FingerShape, weights: np.ndarray, full: FullPieces) -> FingerColumns:
        """Cell of a finger from its interpolated halves; ``weights``: of the nodes."""
        halves, section = self.half_cells[shape], self.section

        def interpolated(stack: np.ndarray, side: int) -> FingerColumns:
            *matrix, moment = np.tensordot(weights, stack, axes=1)
            known = halves.reactions[side] if halves.reactions else None
            reactions = known and cache(lambda: known._replace(rows=np.tensordot(weights, known.rows, axes=1)))
            inside = LiftedHalf(
                side=side,
                full=lambda side, sides: full.half_cell(shape, side, sides),
                moment=moment,
                unknowns=self.resolution.order * section.size,
                reactions=reactions,
            )
            return FingerColumns(size=section.size, matrix=np.array(matrix), width=halves.width, inside=inside)

        rising = interpolated(halves.rising, 0)
        falling = make.mirrored(rising) if halves.falling is None else interpolated(halves.falling, 1)
        return make.joined(rising, falling)
