"""Guided modes of a uniform segment at a frequency and a lateral wavenumber, with the error of the surface wave.

A finite aperture is a sum of fields exp(-i k_y y) over the lateral wavenumber k_y.  At each of them a uniform segment
has modes exp(-i k_x x); k_x against k_y at one frequency is the slowness curve, and its normal is the direction in
which the mode carries its energy.

Limits: a bare surface.  Whether an absorbing bottom is a perfectly matched or a viscous layer is decided by the bulk
waves of the sagittal plane: at a large lateral wavenumber other modes than the surface wave may be reflected there.
"""

from functools import cache

import numpy as np

from fem.convergence import ConvergenceError
from fem.discretize.grading import Resolution
from fem.discretize.refinement import refine
from fem.discretize.section import FIELD_COLUMN, discretise
from fem.geometry import Stator
from fem.materials.christoffel import slowest_wavelength, stretch_absorbs
from fem.results.segment_modes import SegmentModes
from fem.threads import one_blas_thread
from fem.waveguide.modes import GuidedModes
from fem.waveguide.modes import guided_modes as modes_of_section

ORDERS = (6, 8, 10, 12, 14)
GAIN = 10.0  # two orders more divide the error of a wavenumber by far more than this
LOSSY_GAIN = 1.4  # where a viscous layer stands for the half-space: its depth grows with the order, squared


@one_blas_thread
def guided_modes(
    stator: Stator, *, frequency: float, lateral_wavenumber: float = 0.0, tolerance: float
) -> SegmentModes:
    """Modes of a uniform segment of a stator, as many as two discretisations agree on.

    Parameters
    ----------
    stator : Stator
        Its solid, thickness, bottom and what lies above; its length and ends do not matter.
    frequency : float
        Hz.
    lateral_wavenumber : float
        k_y in rad/m; fields vary as exp(-i k_y y).
    tolerance : float
        Of the surface wave's k_x, relative to sqrt(k_x^2 + k_y^2).

    Returns
    -------
    SegmentModes

    Raises
    ------
    ValueError
        For a frequency, wavenumber or tolerance that is not finite, or not positive where it must be.
    ConvergenceError
        If no surface wave propagates, or the highest order does not reach the tolerance.

    Examples
    --------
    In a ceramic poled along the normal all directions are alike, and k_x^2 + k_y^2 is the square of the wavenumber:

    >>> import numpy as np
    >>> import fem
    >>> plate = fem.Stator(
    ...     solid=fem.rotated(fem.material("PZT-8"), "Z"), length=1e-2, thickness=2e-3, ends="absorbing"
    ... )
    >>> along, oblique = (
    ...     fem.guided_modes(plate, frequency=2.2e6, lateral_wavenumber=k_y, tolerance=1e-6) for k_y in (0.0, 2000.0)
    ... )
    >>> bool(np.isclose(oblique.surface_velocity, along.surface_velocity, rtol=1e-6))
    True
    """
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"tolerance must be positive and finite, got {tolerance!r}")
    if not (np.isfinite(frequency) and frequency > 0):
        raise ValueError(f"frequency must be positive and finite, got {frequency!r} Hz")
    if not np.isfinite(lateral_wavenumber):
        raise ValueError(f"lateral_wavenumber must be finite, got {lateral_wavenumber!r} rad/m")
    unit = slowest_wavelength(stator.solid, frequency)

    @cache
    def at_order(order: int) -> GuidedModes:
        section = discretise(
            stator,
            Resolution(order=order, edge_layers=0, lossy_elements=order + 2),
            wavelength=unit,
            surface_scale=np.inf,
            lateral=lateral_wavenumber != 0,
        )
        return modes_of_section(section, frequency, lateral_wavenumber * unit)

    def difference(fine: GuidedModes, coarse: GuidedModes) -> tuple[float]:
        ours, theirs = (np.mean(each.wavenumbers[each.rayleigh]) for each in (fine, coarse))
        return (float(abs(ours - theirs) / np.hypot(ours.real, lateral_wavenumber * unit)),)

    refined = refine(
        at_order,
        ORDERS,
        differences=difference,
        gain=LOSSY_GAIN if stator.absorbs_below and not stretch_absorbs(stator.solid) else GAIN,
        tolerance=tolerance,
    )
    (error,) = refined.errors
    if error > tolerance:
        raise ConvergenceError(
            f"the surface wave's wavenumber is known to {error:.1e} only, {tolerance:.1e} was asked for: "
            f"ask for less{', or ' + refined.obstacle if refined.obstacle else ''}"
        )
    return _result(refined.answer, at_order(ORDERS[refined.level - 1]), stator, error, tolerance)


def _result(
    modes: GuidedModes,
    coarse: GuidedModes,
    stator: Stator,
    error: float,
    tolerance: float,
) -> SegmentModes:
    """Return the modes of which the coarser discretisation has one with the same wavenumber."""
    section, unit = modes.section, modes.section.length_unit
    lateral = modes.lateral_wavenumber
    scale = np.sqrt(abs(modes.wavenumbers) ** 2 + lateral**2)
    nearest = abs(modes.wavenumbers[:, None] - coarse.wavenumbers).min(axis=1)
    known = (nearest <= max(tolerance, 10 * error) * scale) | np.isin(np.arange(len(scale)), modes.rayleigh)
    chosen = np.flatnonzero(known)
    chosen = chosen[
        np.lexsort((-abs(modes.wavenumbers.real[chosen]), -modes.wavenumbers.imag[chosen].round(9)))
    ]
    shapes = np.zeros((len(chosen), len(section.dofs), 4), dtype=complex)
    exists = section.dofs >= 0
    shapes[:, exists] = modes.right[section.dofs[exists]][:, chosen].T
    if lateral and section.solid.mirror_y is not None:
        odd = [
            FIELD_COLUMN[name]
            for name, changes in zip(section.solid.fields, section.solid.mirror_y, strict=True)
            if changes
        ]
        shapes[..., odd] *= 1j
    shapes[..., FIELD_COLUMN["phi"]] *= section.solid.potential_unit
    body = slice(section.bottom, section.surface + 1)
    shapes = shapes[:, body]
    moved = shapes[..., :3].reshape(len(chosen), -1)
    largest = moved[np.arange(len(chosen)), abs(moved).argmax(axis=1)]
    return SegmentModes(
        frequency=float(modes.frequency),
        lateral_wavenumber=float(lateral / unit),
        wavenumbers=modes.wavenumbers[chosen] / unit,
        surface=np.flatnonzero(np.isin(chosen, modes.rayleigh)),
        depth=section.nodes[body],
        shapes=shapes / np.where(largest == 0, 1.0, largest)[:, None, None],
        solid=stator.solid,
        relative_error=error,
        unknowns=section.size,
    )
