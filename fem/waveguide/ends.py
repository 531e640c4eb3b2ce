"""Ends of the stator: the modes that an end sends back for each that arrives there.

A free or clamped end is either the condition on the guided modes themselves, or, where the lines are reduced to a basis
that does not hold the fields at the end, a superelement of some columns of elements.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from fem.condense.join import joined
from fem.condense.superelement import Superelement, condensed
from fem.discretize.grading import CORNER_RATIO, Resolution, graded
from fem.discretize.section import Section
from fem.geometry import Stator
from fem.waveguide.modes import GuidedModes

END_COLUMNS = 2


@dataclass(frozen=True, kw_only=True)
class Walls:
    """Ends of the stator as superelements."""

    # shape (n, n): outward nodal flux of the left piece on its right line, of the right piece on its left
    # line, per unknown
    matrices: tuple[np.ndarray, np.ndarray]
    width: float  # of a piece, length units
    # side (0 left, 1 right) and unknowns of the inner line -> superelement of the end and its sides
    recover: Callable[[int, np.ndarray], tuple[Superelement, np.ndarray]] = field(repr=False)

    def sent_back(self, modes: GuidedModes, side: int, arriving: np.ndarray) -> np.ndarray:
        """Amplitudes of all modes sent back for each that arrives at the line: (E - X_back) q = -(E + X_on) p."""
        wall = self.matrices[side]
        impedances = modes.left_impedance, modes.right_impedance
        on, back = impedances if side == 0 else impedances[::-1]
        shapes = (modes.left if side == 0 else modes.right)[:, arriving]
        returned = -np.linalg.solve(wall - back, (wall + on) @ shapes)
        return modes.right_amplitudes(returned) if side == 0 else modes.left_amplitudes(returned)


def end_reflection(modes: GuidedModes, ends: str | Walls, side: int, arriving: np.ndarray) -> np.ndarray:
    """Amplitudes of all modes sent back by an end for each of some modes that arrive there, shape (n, arriving).

    ``ends``: "free" (no traction, D_n = 0), "clamped" (u = 0, D_n = 0) or walls; ``side``: 0 for the left end, 1 for
    the right.
    """
    if isinstance(ends, Walls):
        return ends.sent_back(modes, side, arriving)
    shapes = (modes.left, modes.right) if side == 0 else (modes.right, modes.left)
    fluxes = (modes.left_flux, modes.right_flux) if side == 0 else (modes.right_flux, modes.left_flux)
    held = np.zeros(modes.section.size, dtype=bool)
    if ends == "clamped":
        held[modes.section.mechanical] = True
    arrive, leave = (np.where(held[:, None], shape, flux) for shape, flux in zip(shapes, fluxes, strict=True))
    constant = np.flatnonzero(modes.wavenumbers == 0)
    if len(constant):
        # The constant potential has no flux; no mode has a net flux of D, so its row is free to fix it at zero.
        leave = leave.copy()
        leave[:, constant] = modes.section.constant_potential[:, None]
    return -np.linalg.solve(leave, arrive[:, arriving])


@dataclass(frozen=True, kw_only=True)
class EndPieces:
    """Columns of elements beside the free or clamped ends."""

    section: Section
    superelements: tuple[Superelement, Superelement] = field(repr=False)  # of the left and the right end
    clamped: bool

    def _lines(self, side: int) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns of the outer line that are not held, and those of the inner line, in the superelement's order."""
        n = self.section.size
        free = np.arange(n)
        if self.clamped:
            free = np.setdiff1d(free, self.section.mechanical)
        return (free, n + np.arange(n)) if side == 0 else (n + free, np.arange(n))

    def _outer(self, side: int) -> np.ndarray:
        """Unknowns of the outer line as a function of those of the inner line."""
        piece, (outer, inner) = self.superelements[side].matrix, self._lines(side)
        return -np.linalg.solve(piece[np.ix_(outer, outer)], piece[np.ix_(outer, inner)])

    def matrix(self, side: int) -> np.ndarray:
        """Outward nodal flux on the inner line per unknown there, shape (n, n)."""
        piece, (outer, inner) = self.superelements[side].matrix, self._lines(side)
        return piece[np.ix_(inner, inner)] + piece[np.ix_(inner, outer)] @ self._outer(side)

    def sides(self, side: int, line: np.ndarray) -> np.ndarray:
        """Both lines and two empty electrodes for given unknowns of the inner line, shape (2 n + 2,)."""
        outer, inner = self._lines(side)
        out = np.zeros(len(self.superelements[side].matrix), dtype=complex)
        out[inner] = line
        out[outer] = self._outer(side) @ line
        return out


def end_pieces(
    section: Section, frequency: float, stator: Stator, resolution: Resolution, *, width: float
) -> EndPieces:
    """Condense columns beside both ends, graded towards corners where a clamped face meets a free one.

    ``width`` of an end piece in length units; the stator's ends are free or clamped.
    """
    layers = resolution.edge_layers if "clamped" in (stator.ends, stator.bottom) else 0
    widths = graded(width, layers, largest=width / END_COLUMNS, ratio=CORNER_RATIO)
    columns = {each: condensed(section, frequency, width=each, electrode=None) for each in widths}
    return EndPieces(
        section=section,
        superelements=tuple(
            reduce(joined, [columns[each] for each in order]) for order in (widths[::-1], widths)
        ),
        clamped=stator.ends == "clamped",
    )
