"""Ends of the stator: reflection of guided modes by free or clamped ends, and by condensed pieces at the end.

At a free or clamped end the boundary condition is imposed on the sum of all guided modes.  If the unknowns of a line
are reduced to a basis, which does not contain the fields near the end, the end is a superelement of some columns of
elements instead.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, reduce

import numpy as np

from fem.condense.cascade_piece import Piece, RecoveredField
from fem.condense.finger_columns import condensed
from fem.condense.joined_fingers import joined
from fem.discretize.element_sizes import CORNER_RATIO, Resolution, graded
from fem.discretize.section import LineSpace, Section
from fem.geometry import Stator
from fem.parameters import refuse_if
from fem.waveguide.guided_modes import GuidedModes

END_COLUMNS = 2


@dataclass(frozen=True, kw_only=True)
class Wall:
    """End of the stator as a condensed piece with one line."""

    matrix: np.ndarray  # shape (n, n): nodal flux out of the piece on its line, per unknown
    # returns the piece's field (`fem.condense.cascade_piece.RecoveredField`) for the unknowns of the line
    recover: Callable[[np.ndarray], object] = field(repr=False)
    floating_potential: bool = False  # as in `Piece`; the mean potential is then set to zero
    beyond: "Beyond | None" = field(default=None, repr=False)  # the uniform stator behind a step of thickness

    def reflection(self, modes: GuidedModes, side: int, arriving: np.ndarray) -> np.ndarray:
        """Amplitudes q of all reflected modes for each incident mode p at the line: (E - X_back) q = -(E + X_on) p."""
        impedances = modes.left_impedance, modes.right_impedance
        on, back = impedances if side == 0 else impedances[::-1]
        shapes = (modes.left if side == 0 else modes.right)[:, arriving]
        system = self.matrix - back
        if self.floating_potential:
            system = with_gauge(system, modes.section.constant_potential)
        returned = -np.linalg.solve(system, (self.matrix + on) @ shapes)
        return modes.right_amplitudes(returned) if side == 0 else modes.left_amplitudes(returned)


@dataclass(frozen=True, kw_only=True)
class Beyond:
    """Semi-infinite uniform stator of another thickness behind a step."""

    modes: GuidedModes
    position: float  # x at which it begins, length units
    far_line: np.ndarray = field(repr=False)  # matrix from the line of the wall to its line, (n of beyond, n)


End = str | Wall  # "absorbing", "free", "clamped", or a condensed piece


def with_gauge(system: np.ndarray, constant: np.ndarray) -> np.ndarray:
    """Make a system regular whose null vector is the constant potential: the mean potential becomes zero.

    With S c = 0 and a load orthogonal to c, (S + w w^T) u = b has the solution with w^T u = 0.
    """
    weights = np.zeros(len(system))
    weights[: len(constant)] = constant / np.linalg.norm(constant)
    return system + abs(system).max() * np.outer(weights, weights)


def held_at_end(section: LineSpace, end: str) -> np.ndarray:
    """Numbers of the unknowns of a line that a reflecting end holds at zero; an InputError for any other word."""
    held = {"free": np.zeros(0, dtype=int), "clamped": section.mechanical}
    refuse_if(end not in held, "ends", f"must be {' or '.join(held)} to reflect", end)
    return held[end]


def end_reflection(modes: GuidedModes, ends: End, side: int, arriving: np.ndarray) -> np.ndarray:
    """Amplitudes of all modes that an end reflects, for a unit of each incident mode, shape (n, arriving).

    ``ends``: "free" (no traction, D_n = 0), "clamped" (u = 0, D_n = 0) or a wall; ``side``: 0 for the left end, 1 for
    the right.
    """
    if isinstance(ends, Wall):
        return ends.reflection(modes, side, arriving)
    shapes = (modes.left, modes.right) if side == 0 else (modes.right, modes.left)
    fluxes = (modes.left_flux, modes.right_flux) if side == 0 else (modes.right_flux, modes.left_flux)
    held = np.zeros(modes.section.size, dtype=bool)
    held[held_at_end(modes.section, ends)] = True
    arrive, leave = (np.where(held[:, None], shape, flux) for shape, flux in zip(shapes, fluxes, strict=True))
    constant = np.flatnonzero(modes.wavenumbers == 0)
    if len(constant):
        # The constant potential has no flux, and no mode has a net flux of D.  The column of the constant potential is
        # therefore replaced by one that sets its amplitude to zero.
        leave = leave.copy()
        leave[:, constant] = modes.section.constant_potential[:, None]
    return -np.linalg.solve(leave, arrive[:, arriving])


def closed(piece: Piece, near: np.ndarray, far: np.ndarray, impedance=0.0) -> tuple[Wall, np.ndarray]:
    """Piece whose far line is terminated, as an end of the stator.

    Parameters
    ----------
    piece : Piece
    near, far : ndarray of int
        Numbers in its matrix A of the unknowns of the line that meets the stator, and of those of the other line that
        are not held at zero.
    impedance : ndarray or float
        X of what lies behind the far line; 0 if that is free.

    Returns
    -------
    Wall
    ndarray
        T = -(A_ff - X)^-1 A_fn, the far line from the near one; the wall's matrix is A_nn + A_nf T.
    """
    matrix = piece.matrix
    line = -np.linalg.solve(matrix[np.ix_(far, far)] - impedance, matrix[np.ix_(far, near)])
    inner = matrix[np.ix_(near, near)] + matrix[np.ix_(near, far)] @ line

    def recover(values: np.ndarray) -> RecoveredField:
        sides = np.zeros(len(matrix), dtype=complex)
        sides[near], sides[far] = values, line @ values
        return piece.recover(sides)

    wall = Wall(matrix=0.5 * (inner + inner.T), recover=recover, floating_potential=piece.floating_potential)
    return wall, line


def end_walls(
    section: Section, frequency: float, stator: Stator, resolution: Resolution, *, width: float
) -> tuple[Wall, Wall]:
    """Condense columns beside both ends, graded towards corners where a clamped face meets a free one.

    ``width`` of an end piece in length units; the stator's ends are free or clamped.
    """
    layers = resolution.edge_layers if "clamped" in (stator.ends, stator.bottom) else 0
    widths = graded(width, layers, largest=width / END_COLUMNS, ratio=CORNER_RATIO)
    columns = {each: condensed(section, frequency, width=each, electrode=None) for each in np.unique(widths)}
    lines = np.arange(2 * section.size).reshape(2, -1)
    held = held_at_end(section, stator.ends)

    @cache
    def end(side: int) -> Wall:
        piece = reduce(joined, [columns[each] for each in widths[:: 1 if side else -1]])
        return closed(piece, lines[1 - side], np.delete(lines[side], held))[0]

    right = end(1)
    if section.odd is None:
        return end(0), right
    line = np.where(section.odd, -1.0, 1.0)
    mirrored = line[:, None] * right.matrix * line
    return replace(right, matrix=mirrored, recover=lambda values: end(0).recover(values)), right
