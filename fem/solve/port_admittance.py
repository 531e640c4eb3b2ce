"""Admittance matrix of a stator's ports with its error, at one frequency or over a band, and its S-parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fem.beam.reception import aperture_solver
from fem.circuit import Drive
from fem.condense.electrode_conditions import is_port
from fem.discretize.mesh_refinement import refine_stator
from fem.exceptions import ConvergenceError, InputError, refuse_above
from fem.geometry import Stator, Transducer, strips_of
from fem.solve.band_solution import Band, frequency_band
from fem.solve.driven_stator import check_driven
from fem.threads import one_blas_thread
from fem.waveguide.port_fields import PortFields, StatorCascade, stator_cascade

BAND_ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class PortAdmittance:
    """Short-circuit admittances of a stator's ports: I = Y V, currents into the positive electrodes.

    Attributes
    ----------
    names : tuple of str
        The ports, from left to right: transducers with two electrodes.
    frequency : ndarray, shape (...)
        Hz.
    matrix : ndarray, shape (..., ports, ports)
        Y in S, symmetric.
    relative_error : float
        Largest error of an entry over the largest entry.
    """

    names: tuple[str, ...]
    frequency: np.ndarray
    matrix: np.ndarray = field(repr=False)
    relative_error: float

    def scattering(self, impedance: float) -> np.ndarray:
        """Return the S-parameters (1 - z Y) (1 + z Y)^-1 for a real reference impedance in ohm, shape of the matrix.

        Pozar, *Microwave Engineering*, 4th ed., 2012, section 4.3.
        """
        unit = np.eye(len(self.names))
        return (unit - impedance * self.matrix) @ np.linalg.inv(unit + impedance * self.matrix)


@one_blas_thread
def port_admittance(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float | Sequence[float],
    tolerance: float,
    finite_apertures: bool = False,
    mirror_width: float | None = None,
) -> PortAdmittance:
    """Admittance matrix of the ports; it does not depend on sources and terminations.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Those with two electrodes are the ports.
    frequency : float or sequence of float
        Hz; several are solved as one band.
    tolerance : float
        Of every entry, relative to the largest one.
    finite_apertures : bool
        If true, a transducer receives the mean of another's beam over its aperture (`fem.surface_beam`), not the plane
        wave of the section.
    mirror_width : float, optional
        Distance of the beams' two reflecting side faces, m.

    Raises
    ------
    ValueError
        For a geometry or a solid without ports, or too wide a range of frequencies.
    ConvergenceError
        If the finest discretisation does not reach the tolerance.

    Examples
    --------
    >>> from fem import Stator, Transducer, material, port_admittance
    >>> stator = Stator(solid=material("PZT-8"), length=6e-3, thickness=1e-3, ends="free")
    >>> left = Transducer(
    ...     name="left", center=2e-3, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=20e-3
    ... )
    >>> ports = port_admittance(stator, (left,), frequency=2.2e6, tolerance=1e-2)
    >>> ports.names, ports.matrix.shape, bool(ports.matrix[0, 0].real > 0)
    (('left',), (1, 1), True)
    """
    if not all(each.uniform_along_y for each in transducers):
        if finite_apertures:
            raise InputError("transducer", "must be uniform along y with finite apertures: strips receive plane waves")
        return _of_strips(stator, transducers, frequency, tolerance)
    frequencies = np.asarray(frequency, dtype=float)
    limits = (float(frequencies.min()), float(frequencies.max())) if frequencies.size > 1 else None
    apertures = aperture_solver(stator, mirror_width, limits=limits) if finite_apertures else None
    solve = apertures or StatorCascade.solved
    if frequencies.size > 1:
        return _over_band(stator, transducers, frequencies, tolerance, solve)
    (single,) = frequencies.reshape(-1).tolist()
    check_driven(stator, transducers, single, tolerance)
    _check_ports(transducers)

    def at_level(resolution) -> PortFields:
        return solve(stator_cascade(stator, transducers, frequency=single, resolution=resolution))

    refined = refine_stator(stator, at_level, differences=_difference, tolerance=tolerance)
    fields, error = refined.answer, refined.errors[0]
    matrix = fields.admittances.reshape(*frequencies.shape, *fields.admittances.shape)
    result = PortAdmittance(names=fields.names, frequency=frequencies, matrix=matrix, relative_error=error)
    refuse_above(error, tolerance, "the admittances are", reached=result)
    return result


def _of_strips(stator, transducers, frequency, tolerance: float) -> PortAdmittance:
    """Sum of the admittances of strips (`fem.beam.strip_beam`, equation 1)."""
    frequencies, names = np.asarray(frequency, dtype=float), _check_ports(transducers)
    names = tuple(each.name for each in sorted(transducers, key=lambda each: each.center) if each.name in names)
    matrix, errors = np.zeros((*frequencies.shape, len(names), len(names)), dtype=complex), 0.0
    for strip in strips_of(transducers):
        if not any(map(is_port, strip.transducers)):
            continue
        part = port_admittance(stator, strip.transducers, frequency=frequency, tolerance=tolerance)
        at = [names.index(name) for name in part.names]
        rows, columns = np.ix_(at, at)
        matrix[..., rows, columns] += part.matrix
        errors += part.relative_error * abs(part.matrix).max()
    error = float(errors / abs(matrix).max())
    return PortAdmittance(names=names, frequency=frequencies, matrix=matrix, relative_error=error)


def _difference(fine: PortFields, coarse: PortFields) -> tuple[float]:
    change = abs(fine.admittances - coarse.admittances).max()
    return (float(change / abs(fine.admittances).max()),)


def _check_ports(transducers: tuple[Transducer, ...]) -> tuple[str, ...]:
    names = tuple(each.name for each in transducers if is_port(each))
    if not names:
        raise InputError("transducer", "must have two electrodes, at least one of them, and none has")
    return names


def _over_band(stator, transducers, frequencies: np.ndarray, tolerance: float, solve) -> PortAdmittance:
    drive = Drive(sources=dict.fromkeys(_check_ports(transducers), 1.0))
    limits = {"lowest": float(frequencies.min()), "highest": float(frequencies.max())}
    motion_tolerance = tolerance
    for _ in range(BAND_ROUNDS):  # the band's tolerance bounds the motion; the admittances may need a smaller one
        try:
            band = frequency_band(stator, transducers, **limits, drive=drive, tolerance=motion_tolerance)
        except ConvergenceError as error:
            if not isinstance(error.reached, Band):
                raise
            band = error.reached  # its admittances may still meet theirs
        if band.admittance_error <= tolerance:
            break
        motion_tolerance *= 0.5 * tolerance / band.admittance_error
    matrices = band.admittances(frequencies.reshape(-1), solve)
    result = PortAdmittance(
        names=band.port_names,
        frequency=frequencies,
        matrix=matrices.reshape(*frequencies.shape, *matrices.shape[1:]),
        relative_error=band.admittance_error,
    )
    advice = "ask for less, or solve one frequency at a time"
    refuse_above(band.admittance_error, tolerance, "the band's admittances are", advice=advice, reached=result)
    return result
