"""The admittance matrix of a stator's ports with its error, at one frequency or over a band, and its S-parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fem.beam.reception import aperture_solver
from fem.circuit import Drive
from fem.convergence_error import refuse_above
from fem.discretize.refinement import refine_stator
from fem.geometry import Stator, Transducer
from fem.input_error import InputError
from fem.solve.band import frequency_band
from fem.solve.harmonic import check_driven
from fem.threads import one_blas_thread
from fem.waveguide.port_fields import PortFields, solve_ports

BAND_ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class PortAdmittance:
    """Short-circuit admittances of a stator's ports: I = Y V, currents into the positive electrodes.

    Attributes
    ----------
    names : tuple of str
        Transducers with two electrodes, from left to right: the ports.
    frequency : ndarray, shape (...)
        Hz.
    matrix : ndarray, shape (..., ports, ports)
        Y in S, symmetric.
    relative_error : float
        Largest, of any entry over the largest entry.
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
    """Admittance matrix of the ports, whatever drives or terminates them.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Those with two electrodes are the ports.
    frequency : float or sequence of float
        Hz; several are solved as one band.
    tolerance : float
        Relative, of the entries, over the largest of them.
    finite_apertures : bool
        Whether transducers receive the mean of one another's beams (`fem.surface_beam`), not the section's waves.
    mirror_width : float, optional
        Of the beams' two reflecting side faces, m.

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
    >>> found = port_admittance(stator, (left,), frequency=2.2e6, tolerance=1e-2)
    >>> found.names, found.matrix.shape, bool(found.matrix[0, 0].real > 0)
    (('left',), (1, 1), True)
    """
    at = np.asarray(frequency, dtype=float)
    limits = (float(at.min()), float(at.max())) if at.size > 1 else None
    solve = aperture_solver(stator, mirror_width, limits=limits) if finite_apertures else None
    if at.size > 1:
        return _over_band(stator, transducers, at, tolerance, solve)
    check_driven(stator, transducers, float(at.item()), tolerance)
    _check_ports(transducers)

    def at_level(resolution) -> PortFields:
        return solve_ports(
            stator, transducers, frequency=float(at.item()), resolution=resolution, solve=solve
        )

    refined = refine_stator(stator, at_level, differences=_difference, tolerance=tolerance)
    fields, error = refined.answer, refined.errors[0]
    matrix = fields.admittances.reshape(*at.shape, *fields.admittances.shape)
    found = PortAdmittance(names=fields.names, frequency=at, matrix=matrix, relative_error=error)
    refuse_above(error, tolerance, "the admittances are", reached=found)
    return found


def _difference(fine: PortFields, coarse: PortFields) -> tuple[float]:
    change = abs(fine.admittances - coarse.admittances).max()
    return (float(change / abs(fine.admittances).max()),)


def _check_ports(transducers: tuple[Transducer, ...]) -> tuple[str, ...]:
    names = tuple(each.name for each in transducers if {"+", "-"} <= set(each.signs))
    if not names:
        raise InputError("transducer", "must have two electrodes, at least one of them, and none has")
    return names


def _over_band(stator, transducers, at: np.ndarray, tolerance: float, solve) -> PortAdmittance:
    drive = Drive(sources=dict.fromkeys(_check_ports(transducers), 1.0))
    goal, limits = tolerance, {"lowest": float(at.min()), "highest": float(at.max())}
    for _ in range(BAND_ROUNDS):  # a band promises its motion; the admittances may ask for more
        band = frequency_band(stator, transducers, **limits, drive=drive, tolerance=goal)
        if band.admittance_error <= tolerance:
            break
        goal *= 0.5 * tolerance / band.admittance_error
    found = PortAdmittance(
        names=band.port_names,
        frequency=at,
        matrix=band.admittances(at.reshape(-1), solve).reshape(*at.shape, len(band.port_names), -1),
        relative_error=band.admittance_error,
    )
    advice = "ask for less, or solve one frequency at a time"
    refuse_above(band.admittance_error, tolerance, "the band's admittances are", advice=advice, reached=found)
    return found
