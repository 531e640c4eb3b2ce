"""Forces on strips of the surface beside transducers of finite aperture: what these scatter and what they receive.

A force on a strip |y - y_0| < W / 2 at x_j is a sheet of one node (surface_beam.py) with N/m for its charge.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fem.beam.cut_source import CutSource
from fem.beam.electrode_charges import ChargeSheet, all_charges
from fem.beam.line_source import LineSource
from fem.input_error import InputError
from fem.results.solution import Solution, driven_solution
from fem.waveguide.port_fields import PortFields

if TYPE_CHECKING:
    from fem.beam.surface_beam import SurfaceBeam

TINY = 1e-300  # avoids division by zero


class Strip(NamedTuple):
    """A force on a strip of the surface: a sheet of one node with N/m for its charge, and the stator's response."""

    sheet: ChargeSheet
    source: LineSource | CutSource


def sheets_of_forces(solution: Solution) -> list[ChargeSheet]:
    """Strips of the forces of a solution, with N/m in place of charges."""
    if solution.forces is None:
        return []
    unit, ports = solution.fields.section.length_unit, solution.fields.network.ports
    forces = [each for each in ports if each.kind == "force"]
    for each in forces:
        if not np.isfinite(each.width):
            raise InputError("force.width", "must be finite in three dimensions", each.width, "m", owner=each.name)
    return [
        ChargeSheet(
            x=np.array([each.place * unit]),
            charge=np.array([amplitude]),
            finger=np.zeros(1, dtype=int),
            length=each.width * unit,
            center=each.center * unit,
        )
        for each, amplitude in zip(forces, solution.forces, strict=True)
    ]


def with_scattering(beam: "SurfaceBeam") -> PortFields:
    """Fields in which each transducer answers the mean of every strip's beam over its aperture, at its centre.

    The section's answers to a force that is the same all along y are multiplied by the mean of the surface wave's u_z
    over its value at k_y = 0, on the bare surface.
    """
    fields, ports = beam.solution.fields, len(beam.solution.fields.names)
    places = np.array([each.center for each in fields.transducers])
    shares = np.ones((len(places), ports + len(beam.strips)), dtype=complex)
    for column, strip in enumerate(beam.strips, start=ports):
        unit = replace(strip.sheet, charge=np.ones(1))
        alone = replace(beam, charges=(), apertures=(), centers=(), strips=(Strip(unit, strip.source),)).surface_mode
        (emitter,) = alone.emitters
        plane = emitter.plane_waves(places, beam.wavelength)
        for index, (aperture, center) in enumerate(zip(beam.apertures, beam.centers, strict=True)):
            y, weights = _points_across(beam, center, aperture)
            shares[index, column] = alone.motion(places[index], y)[2] @ weights / plane[index, 2]
    named = [index for index, each in enumerate(fields.transducers) if each.name in fields.names]
    return replace(
        fields,
        sides=tuple(
            sides if owner is None else sides * shares[owner]
            for owner, sides in zip(fields.owners, fields.sides, strict=True)
        ),
        received=fields.received * shares[named, ports:],
    )


def with_reciprocal_currents(beam: "SurfaceBeam") -> "SurfaceBeam":
    """Beam whose transducers receive, by reciprocity, what they send to the strips.

    The current into a shorted port per newton is the velocity along the force, averaged over the strip, per volt at
    the port.  The charges of `reception` take the waves of a strip at each finger, but across a finger as if they ran
    along x; those of `with_scattering` at the centre of the transducer, as if their phase fronts were straight along
    it.  The currents of these charges are 1 % and up to 36 % off beside transducers of 20 fingers; the difference is
    the error of the scattered waves.
    """
    solution, fields = beam.solution, beam.solution.fields
    forces = [each for each in fields.network.ports if each.kind == "force"]
    received, coarser = np.empty_like(fields.received), np.empty_like(fields.received)
    for row in range(len(fields.names)):
        circuit = replace(solution.circuit, voltages=np.eye(len(fields.names))[row])
        unit = replace(solution, circuit=circuit, forces=None)
        sent = replace(beam, solution=unit, charges=all_charges(unit), strips=(), complete=False)
        for column, (force, strip) in enumerate(zip(forces, beam.strips, strict=True)):
            y, weights = _points_across(beam, strip.sheet.center, strip.sheet.length)
            rules = sent.motion_by_rules(strip.sheet.x[0], y)[:2]
            fine, half = (each["xyz".index(force.component)] @ weights for each in rules)
            rate = 2j * np.pi * fields.frequency * strip.sheet.length
            received[row, column], coarser[row, column] = rate * fine, rate * half
    # of open strips alone no current tells how much is missed: their waves are in doubt as a whole
    missed, error = 1.0, 0.0
    if fields.names:
        currents, by_charges = received @ solution.forces, fields.received @ solution.forces
        largest = max(abs(currents).max(), TINY)
        missed = abs(by_charges - currents).max() / largest
        error = abs(coarser @ solution.forces - currents).max() / largest
    solution = driven_solution(replace(fields, received=received), solution.circuit.drive, solution.forces)
    return replace(
        beam,
        solution=solution,
        charges=all_charges(solution),
        scattering_error=float(missed),
        received_error=float(error + beam.wave.relative_error),
    )


def _points_across(beam: "SurfaceBeam", center: float, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Points across a strip of the surface in m, and weights of the mean over it."""
    s, weights = np.polynomial.legendre.leggauss(int(8 + 4 * length / abs(beam.wavelength)))
    return center + length / 2 * s, weights / 2
