"""Surface motion of a driven stator at many frequencies of a range, from bands instead of one solution each.

With the plane section the bands are those of `studies.solve.spectrum`, with finite apertures those of `fem.beam_band`.
"""

import logging
from collections.abc import Callable, Sequence
from itertools import pairwise

import fem
from studies.model.model import Model
from studies.solve.spectrum import band_edges, response, takes_bands
from studies.solve.surface_motion import SurfaceMotion, beam_motion

LOGGER = logging.getLogger(__name__)
# Frequencies from which bands of beams are cheaper than one solution each: of ``twente`` the set-up takes as much
# processor time as 7, and each frequency an eighth of a solution
MIN_FREQUENCIES = 8


def solved_in_bands(
    model: Model, positions: tuple[tuple[float, float], ...], *, slider: bool, frequencies: int
) -> bool:
    """Return whether a stator is solved in bands for contacts at positions (x, y), m, at so many frequencies.

    Not with rotated, apodised or slanted transducers or meshed pieces; with finite apertures not in other solids than
    those isotropic about the normal, not for fewer than MIN_FREQUENCIES, and not for a slider in the plane, each of
    whose frequencies is solved alone.
    """
    scene = model.scene
    if scene.crossed or scene.in_strips or scene.piece:
        return False
    if not model.spreads(positions if slider else None):
        return True
    if frequencies < MIN_FREQUENCIES or scene.planar:
        return False
    isotropic = fem.isotropic_about_normal(model.stator.solid)
    return isotropic and takes_bands(model.stator, model.transducers, _along(positions))


def motion_bands(
    model: Model, limits: Sequence[float], positions: tuple[tuple[float, float], ...], *, tolerance: float, slider: bool
) -> Callable[[float], SurfaceMotion]:
    """Return a function of the frequency (Hz) that gives the surface motion of a stator of `solved_in_bands`.

    Parameters
    ----------
    model : Model
        Resolved, at any frequency.
    limits : sequence of float
        Lowest and highest frequency, Hz.
    positions : tuple of (float, float)
        (x, y) in m of the contacts.
    tolerance : float
        Relative, of the section's motion there.
    slider : bool
        True if the motion is to drive a slider.

    Raises
    ------
    fem.ConvergenceError
        If the beams of a band miss the tolerance.
    """
    block, lowest, highest = model.scene.stator, limits[0], limits[-1]
    reason = model.section_reason(positions if slider else None)
    if reason:
        over_band = response(model, lowest, highest, positions=_along(positions), tolerance=tolerance)
        return lambda frequency: SurfaceMotion(wave=over_band.wave(frequency, model.drive), reason=reason)
    bands = []
    for low, high in pairwise(band_edges(lowest, highest)):
        LOGGER.info(f"stator: beams of the band {low / 1e6:.4g} to {high / 1e6:.4g} MHz")
        bands.append(
            fem.beam_band(
                model.stator, model.transducers, lowest=low, highest=high, drive=model.drive, tolerance=tolerance,
                places=positions, mirror_width=block.mirror_width,
            )
        )  # fmt: skip

    def motion(frequency: float) -> SurfaceMotion:
        band = next(each for each in bands if each.limits[0] <= frequency <= each.limits[1])
        return beam_motion(band.beam(frequency, model.drive), block, positions)

    return motion


def _along(positions: tuple[tuple[float, float], ...]) -> tuple[float, ...]:
    return tuple(dict.fromkeys(x for x, _ in positions))
