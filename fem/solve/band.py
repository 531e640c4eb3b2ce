"""Many frequencies in the time of one: condensed finger halves interpolated over a band, on reduced lines.

Two things change slowly with frequency.  A half cell (half a gap, half a finger: a quarter of a wavelength) has no
resonance of its own in the band, so that its condensed matrix is a polynomial in omega^2 of low degree: it is condensed
at a few Chebyshev nodes and interpolated.  And the fields that ever stand on the lines between the halves - those of
all fingers, all ports and all waves that arrive - span few dimensions: a basis of them is taken from full solutions at
some of the nodes (proper orthogonal decomposition), one basis for lines in mid-gap and one for lines in mid-finger.
Projected on it, pieces are joined, modes found and ends closed as before, at a tenth of the size.

The reduction is checked where it was not fitted: between the nodes, against the full solution.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from fem.condense.join import joined
from fem.condense.superelement import PORTS, Block
from fem.discretize.section import Resolution
from fem.geometry import Stator, Transducer
from fem.results.evaluation import surface_wave
from fem.results.surface import Covered, SurfaceWave
from fem.solution import Solution, assembled
from fem.solve.reduced_basis import (
    WALL_WIDTH,
    ReducedSection,
    even_row,
    finger_key,
    no_bare_cells,
)
from fem.threads import side_by_side
from fem.waveguide.ends import Walls
from fem.waveguide.modes import guided_modes


def _barycentric(nodes: np.ndarray, at: float) -> np.ndarray:
    """Lagrange weights of distinct nodes at a place."""
    return np.array(
        [np.prod((at - np.delete(nodes, k)) / (node - np.delete(nodes, k))) for k, node in enumerate(nodes)]
    )


@dataclass(frozen=True, kw_only=True)
class HalfCell:
    """Projected half cells of one kind of finger at the nodes, comb 0: shape (nodes, 2 r + 2, 2 r + 2) each."""

    rising: np.ndarray = field(repr=False)
    falling: np.ndarray | None = field(repr=False)
    width: float


@dataclass(frozen=True, kw_only=True)
class Band:
    """A driven stator prepared for any frequency of a band.

    Attributes
    ----------
    stator : Stator
    transducers : tuple of Transducer
        From left to right.
    limits : tuple of float
        Lowest and highest frequency in Hz.
    resolution : Resolution
    section : ReducedSection
    half_cells : dict
        By finger width and gap (m).
    nodes : ndarray
        omega^2 of the interpolation's nodes, (rad/s)^2.
    walls : ndarray or None
        Projected end pieces at the nodes, shape (nodes, 2, r, r); None for absorbing ends.
    relative_error, admittance_error : float
        Of the surface motion and of the admittance, worst of the frequencies where they were checked against full
        solutions of this and of a finer discretisation.
    seconds : float
        Set-up.
    """

    stator: Stator
    transducers: tuple[Transducer, ...]
    limits: tuple[float, float]
    resolution: Resolution
    section: ReducedSection
    half_cells: dict = field(repr=False)
    nodes: np.ndarray = field(repr=False)
    walls: np.ndarray | None = field(repr=False)
    relative_error: float = float("inf")
    admittance_error: float = float("inf")
    seconds: float = 0.0

    def solution(self, frequency: float, *, driven: str, source_impedance: complex = 0.0) -> Solution:
        """Solve at a frequency of the band (Hz).

        Raises
        ------
        ValueError
            Outside the band.
        """
        low, high = self.limits
        if not low <= frequency <= high:
            raise ValueError(f"frequency must lie in the band, {low:g} to {high:g} Hz, got {frequency!r} Hz")
        weights = _barycentric(self.nodes, (2 * np.pi * frequency) ** 2)
        made: dict[tuple, Block] = {}
        blocks = []
        for transducer in self.transducers:
            key = (*finger_key(transducer), transducer.signs)
            if key not in made:
                halves = self.half_cells[finger_key(transducer)]
                cell = self._cell(halves, weights)
                made[key] = even_row(transducer, lambda cell=cell: cell, no_bare_cells)
            blocks.append(made[key])
        return assembled(
            self.stator,
            self.transducers,
            blocks,
            modes=guided_modes(self.section, frequency),
            driven=driven,
            source_impedance=source_impedance,
            resolution=self.resolution,
            walls=None
            if self.walls is None
            else Walls(matrices=tuple(np.tensordot(weights, self.walls, axes=1))),
            inset=0.0 if self.walls is None else WALL_WIDTH,
        )

    def waves(
        self, frequencies: np.ndarray, *, driven: str, source_impedance: complex = 0.0
    ) -> list[SurfaceWave]:
        """Surface motion at many frequencies of the band (Hz), in their order, side by side."""

        def at(frequency: float) -> SurfaceWave:
            return self.wave(float(frequency), driven=driven, source_impedance=source_impedance)

        return side_by_side(at, frequencies)

    def _cell(self, halves: HalfCell, weights: np.ndarray) -> Block:
        size = self.section.size

        def block(stack: np.ndarray) -> Block:
            matrix = np.tensordot(weights, stack, axes=1)
            return Block(size=size, matrix=matrix, width=halves.width)

        rising = block(halves.rising)
        if halves.falling is None:
            falling = _reflected(rising, self.section.odd, bool(self._phi_odd))
        else:
            falling = block(halves.falling)
        return joined(rising, falling)

    @property
    def _phi_odd(self) -> bool:
        names = self.section.solid.fields
        parity = self.section.solid.parity
        return parity is not None and bool(parity[names.index("phi")])

    def wave(self, frequency: float, *, driven: str, source_impedance: complex = 0.0) -> SurfaceWave:
        """Surface motion at a frequency of the band, without the places under a transducer and the interior."""
        begun = time.perf_counter()
        solution = self.solution(frequency, driven=driven, source_impedance=source_impedance)
        wave = surface_wave(solution)
        pieces = tuple(
            replace(piece, recover=_not_rebuilt) if isinstance(piece, Covered) else piece
            for piece in wave.pieces
        )
        return replace(
            wave,
            pieces=pieces,
            solution=None,
            relative_error=self.relative_error,
            admittance_error=self.admittance_error,
            seconds=time.perf_counter() - begun,
        )


def _not_rebuilt() -> np.ndarray:
    raise ValueError(
        "a band of frequencies does not rebuild the motion under a transducer: solve one frequency"
    )


def _reflected(block: Block, odd: np.ndarray, phi_odd: bool) -> Block:
    n = block.size
    signs = np.where(odd, -1.0, 1.0)
    order = np.r_[n : 2 * n, 0:n, 2 * n : 2 * n + PORTS]
    signs = np.concatenate([signs, signs, np.full(PORTS, -1.0 if phi_odd else 1.0)])
    matrix = signs[:, None] * block.matrix[np.ix_(order, order)] * signs
    return Block(size=n, matrix=matrix, width=block.width)
