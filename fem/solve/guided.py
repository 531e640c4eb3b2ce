"""Guided modes of a bare section at a frequency and a lateral wavenumber, and its free wave, each with its error.

The field of a finite aperture is an integral of fields exp(-i k_y y) over the lateral wavenumber k_y.  At each k_y a
uniform segment has modes exp(-i k_x x); k_x against k_y at one frequency is the slowness curve, and its normal is the
direction in which the mode carries its energy.  The free wave is the mode at k_y = 0 whose motion is concentrated at
the surface (selected by `fem.waveguide.surface_modes`).  In a block of several wavelengths it is the Rayleigh
wave of the half-space, up to a splitting that decays exponentially with the thickness.

Limits: a bare surface.  The kind of absorbing layer at the bottom is selected by the bulk waves of the sagittal plane.
At a large lateral wavenumber modes other than the surface wave may be reflected there, or grow (YZ LiNbO3: 2e-3 of k).
"""

from functools import cache

import numpy as np

from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import absorbs_slowly, refine
from fem.discretize.section import FIELD_COLUMN, Section
from fem.exceptions import refuse_above
from fem.geometry import Stator
from fem.parameters import InputError, positive
from fem.results.segment_modes import FreeWave, SegmentModes
from fem.threads import one_blas_thread
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.guided_modes import guided_modes as modes_of_section

FREE_ORDERS, ORDERS = (4, 6, 8, 10, 12), (6, 8, 10, 12, 14)
GAIN = 10.0  # two orders more divide the error of a wavenumber by far more than this
SLOW_GAIN = 1.4  # where the depth of an absorbing layer decides (`absorbs_slowly`)


def _refined_modes(
    stator: Stator, frequency: float, lateral_wavenumber: float, tolerance: float, orders, difference
) -> tuple[GuidedModes, GuidedModes, float]:
    """Modes of the finest section that was needed, of the one before, and the error from their ``difference``."""
    positive("tolerance", tolerance)
    unit = stator.slowest_wavelength(frequency)

    @cache
    def at_order(order: int) -> GuidedModes:
        section = discretise(
            stator,
            Resolution(order=order, edge_layers=0, absorber=(order - 4) // 2),
            wavelength=unit,
            surface_scale=np.inf,
            lateral=lateral_wavenumber != 0,
        )
        return modes_of_section(section, frequency, lateral_wavenumber * unit)

    refined = refine(
        at_order,
        orders,
        differences=lambda fine, coarse: (difference(fine, coarse),),
        gain=SLOW_GAIN if absorbs_slowly(stator) else GAIN,
        tolerance=tolerance,
    )
    (error,) = refined.errors
    advice = f"ask for less{', or ' + refined.obstacle if refined.obstacle else ''}"
    refuse_above(error, tolerance, "the guided modes' wavenumbers are", advice=advice)
    return refined.answer, at_order(orders[refined.level - 1]), error


def _surface_wavenumber(modes: GuidedModes) -> complex:
    """Mean of the surface wave's modes, weighted by their share at the surface, rad/m.

    Two equal faces guide two modes with equal shares.  Unequal faces (vacuum above only) guide one wave each, and the
    lower face's wave has almost no share at the upper surface.
    """
    waves = modes.wavenumbers[modes.rayleigh]
    share = modes.section.surface_share(modes.right[:, modes.rayleigh])
    return complex(share @ waves / share.sum() / modes.section.length_unit)


def _velocity_difference(fine: GuidedModes, coarse: GuidedModes) -> float:
    """Relative difference of the surface waves' velocities."""
    return abs(_surface_wavenumber(coarse).real / _surface_wavenumber(fine).real - 1)


def _surface_wave_difference(fine: GuidedModes, coarse: GuidedModes) -> float:
    """Difference of the surface waves' k_x over the wavenumber."""
    k, before = _surface_wavenumber(fine), _surface_wavenumber(coarse)
    return float(abs(k - before) / np.hypot(k.real, fine.lateral_wavenumber / fine.section.length_unit))


def _propagating_difference(fine: GuidedModes, coarse: GuidedModes) -> float:
    """Largest difference of the propagating modes' k_x over the surface wave's wavenumber."""
    k = fine.wavenumbers[fine.propagating]
    nearest = abs(k[:, None] - coarse.wavenumbers).min(axis=1)
    scale = np.hypot(_surface_wavenumber(fine).real * fine.section.length_unit, fine.lateral_wavenumber)
    return float(nearest.max() / scale)


@one_blas_thread
def free_wave(stator: Stator, *, frequency: float, tolerance: float) -> FreeWave:
    """Rayleigh wave of a bare section at a frequency.

    Parameters
    ----------
    stator : Stator
    frequency : float
        Hz.
    tolerance : float
        Relative, of the velocity.

    Raises
    ------
    ConvergenceError
        If the highest order does not reach the tolerance.
    """
    modes, _, error = _refined_modes(stator, frequency, 0.0, tolerance, FREE_ORDERS, _velocity_difference)
    section, wavenumber = modes.section.full, _surface_wavenumber(modes)
    shape = _upper_face_wave(modes.right[:, modes.rayleigh], section)
    profile = section.on_nodes(shape[:, None])[0] * section.field_units
    profile /= profile[-1, FIELD_COLUMN["uz"]]
    return FreeWave(
        frequency=frequency,
        velocity=2 * np.pi * frequency / wavenumber.real,
        attenuation=float(-wavenumber.imag),
        surface_ratio=float(abs(profile[-1, FIELD_COLUMN["ux"]])),
        depth=section.nodes[section.body],
        profile=profile,
        order=section.order,
        solid=stator.solid,
        solids=section.solids_of_elements(stator.solids),
        relative_error=float(error),
        unknowns=section.size,
    )


def _upper_face_wave(shapes: np.ndarray, section: Section) -> np.ndarray:
    """Combination of one or two modes of (nearly) equal velocity with u_z = 1 at the surface and the least motion.

    Two equal faces guide two such modes, and any linear combination of them is a solution.  The one of least motion
    leaves the lower face at rest.
    """
    top = shapes[section.surface_dofs["uz"]]
    motion = shapes[section.mechanical]
    weights = np.linalg.solve(motion.conj().T @ motion, top.conj())
    return shapes @ (weights / (top @ weights))


@one_blas_thread
def guided_modes(
    stator: Stator, *, frequency: float, lateral_wavenumber: float = 0.0, tolerance: float, propagating: bool = False
) -> SegmentModes:
    """Modes of a uniform segment of a stator: those on which two discretisations agree.

    Parameters
    ----------
    stator : Stator
        Its solid, thickness, bottom and what lies above; its length and ends do not matter.
    frequency : float
        Hz.
    lateral_wavenumber : float
        k_y in rad/m; fields vary as exp(-i k_y y).
    tolerance : float
        Of the surface wave's k_x, relative to its sqrt(k_x^2 + k_y^2).
    propagating : bool
        If true, the tolerance bounds the error of every propagating mode, not only of the surface wave.

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
    positive("frequency", frequency, "Hz")
    if not np.isfinite(lateral_wavenumber):
        raise InputError("lateral_wavenumber", "must be finite", lateral_wavenumber, "rad/m")
    modes, coarse, error = _refined_modes(
        stator,
        frequency,
        lateral_wavenumber,
        tolerance,
        ORDERS,
        _propagating_difference if propagating else _surface_wave_difference,
    )
    checked = modes.propagating if propagating else modes.rayleigh
    resolved = _resolved(modes, coarse, max(tolerance, 10 * error), checked)
    section, unit = modes.section.full, modes.section.length_unit
    return SegmentModes(
        frequency=float(modes.frequency),
        lateral_wavenumber=float(modes.lateral_wavenumber.real / unit),  # here k_y is real
        wavenumbers=modes.wavenumbers[resolved] / unit,
        surface=np.flatnonzero(np.isin(resolved, modes.rayleigh)),
        depth=section.nodes[section.body],
        shapes=_shapes(modes, resolved),
        surface_share=section.surface_share(modes.right[:, resolved]) / unit,
        solid=stator.solid,
        relative_error=error,
        unknowns=section.size,
    )


def _shapes(modes: GuidedModes, numbers: np.ndarray) -> np.ndarray:
    """u_x, u_y, u_z and phi of some modes at the body's nodes, (modes, nodes, 4); the largest displacement is 1."""
    section = modes.section.full
    shapes = section.on_nodes(modes.right[:, numbers]) * section.field_units
    if modes.lateral_wavenumber and section.solid.mirror_y is not None:
        odd = [
            FIELD_COLUMN[name]
            for name, changes in zip(section.solid.fields, section.solid.mirror_y, strict=True)
            if changes
        ]
        shapes[..., odd] *= 1j
    motion = shapes[..., :3].reshape(len(numbers), -1)
    largest = motion[np.arange(len(numbers)), abs(motion).argmax(axis=1)]
    return shapes / np.where(largest == 0, 1.0, largest)[:, None, None]


def _resolved(modes: GuidedModes, coarse: GuidedModes, tolerance: float, checked: np.ndarray) -> np.ndarray:
    """Indices of the ``checked`` modes and of those that the coarser section has too, least decaying first."""
    k = modes.wavenumbers
    scale = np.sqrt(abs(k) ** 2 + modes.lateral_wavenumber**2)
    nearest = abs(k[:, None] - coarse.wavenumbers).min(axis=1)
    resolved = np.flatnonzero((nearest <= tolerance * scale) | np.isin(np.arange(len(k)), checked))
    return resolved[np.lexsort((-abs(k.real[resolved]), -k.imag[resolved].round(9)))]
