"""Ends of the stator: the modes that an end sends back for each that arrives there."""

from dataclasses import dataclass

import numpy as np

from fem.waveguide.modes import GuidedModes


@dataclass(frozen=True, kw_only=True)
class Walls:
    """Ends of the stator as condensed pieces: their matrices on the lines where they begin.

    Attributes
    ----------
    matrices : tuple of ndarray, shape (n, n)
        Outward nodal flux of the left piece on its right line, of the right piece on its left line, per unknown.
    """

    matrices: tuple[np.ndarray, np.ndarray]

    def sent_back(self, modes: GuidedModes, side: int, arriving: np.ndarray) -> np.ndarray:
        """Amplitudes of all modes sent back for each that arrives at the line: (E - X_back) q = -(E + X_on) p."""
        wall = self.matrices[side]
        on, back = (modes.left_end, modes.right_end) if side == 0 else (modes.right_end, modes.left_end)
        shapes = (modes.left if side == 0 else modes.right)[:, arriving]
        returned = -np.linalg.solve(wall - back, (wall + on) @ shapes)
        return modes.right_amplitudes(returned) if side == 0 else modes.left_amplitudes(returned)


def end_reflection(modes: GuidedModes, ends: str | Walls, side: int, arriving: np.ndarray) -> np.ndarray:
    """Amplitudes of all modes sent back by an end for each mode that arrives there.

    Parameters
    ----------
    modes : GuidedModes
    ends : str or Walls
        "free": no traction, D_n = 0; "clamped": u = 0, D_n = 0.
    side : int
        0 for the left end, 1 for the right one.
    arriving : ndarray of int
        Modes that arrive.

    Returns
    -------
    ndarray, shape (n, arriving)
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
