"""Surface beam of a solved section: charges received by the apertures, and forces on strips beside transducers.

A force on a strip |y - y_0| < W / 2 at x_j is a sheet of one node (beam_of_charges.py) with N/m for its charge.
Transducers scatter and receive its waves.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from fem.beam.beam_of_charges import ChargeSheet, Strip
from fem.beam.cut_source import cut_source
from fem.beam.electrode_charges import all_charges
from fem.beam.faces import faces, with_all_displacements
from fem.beam.line_source import Load, ModeSource, line_source
from fem.beam.reception import refuse_short_apertures, with_apertures
from fem.beam.surface_beam import BeamError, SurfaceBeam
from fem.exceptions import InputError
from fem.geometry import Stator
from fem.materials import isotropic_about_normal
from fem.parameters import refuses
from fem.results.driven_answer import SurfaceWave
from fem.results.stator_solution import Solution, driven_solution
from fem.waveguide.guided_modes import full_modes
from fem.waveguide.port_fields import PortFields, StatorCascade

TINY = 1e-300  # avoids division by zero


def beam_refusal(stator: Stator) -> str:
    """Sentence that says why a stator's field in three dimensions cannot be computed; empty if it can."""
    if stator.pieces:
        return "the field in three dimensions of a stator with meshed pieces is not computed"
    if stator.layers:
        return "the field in three dimensions of a stator with layers is not computed"
    if stator.ends != "absorbing" and not isotropic_about_normal(stator.solid):
        return f"in this cut the field in three dimensions needs stator.ends = 'absorbing', got {stator.ends!r}"
    return ""


def surface_beam(
    wave: SurfaceWave,
    *,
    mirror_width: float | None = None,
    apertures: Callable[[StatorCascade], PortFields] | None = None,
) -> SurfaceBeam:
    """Field in three dimensions of a stator that voltages or forces drive, from the section's solution.

    Parameters
    ----------
    wave : SurfaceWave
        Result of `fem.driven_wave`, or of `fem.forced_wave` for forces of finite width.  With free or clamped ends, or
        if the solid is not isotropic about z, the first evaluation takes some seconds, because a problem is solved at
        every lateral wavenumber, and the transducers receive each other's waves as in the section.
    mirror_width : float, optional
        Distance in m of two side faces that reflect like mirrors (u_y = 0, no shear traction).  By default the stator
        is infinitely wide.  A real stator has free faces, for which neither holds: the difference of both answers shows
        how much the width can matter.  In cuts without the symmetry y -> -y the images repeat the field, unmirrored.

    apertures : callable, optional
        `fem.beam.reception.aperture_solver` of this stator and ``mirror_width``, for many waves of one band.

    Returns
    -------
    SurfaceBeam

    Raises
    ------
    BeamError
        If the stator has meshed pieces, if its ends are free or clamped and the solid is not isotropic about z or
        forces act, if an aperture or a strip exceeds ``mirror_width``, or if a transducer lies beside the line y = 0
        although there are mirrors or the solid is not isotropic about z, or a strip although there are mirrors.
    InputError
        If an aperture is less than half a wavelength, or the width of a force is infinite.

    Examples
    --------
    The beam of a normal force of 1 N on a strip of 2 mm, 30 mm away and on its axis:

    >>> from fem import LineForce, Stator, forced_wave, isotropic, surface_beam
    >>> glass = isotropic(name="glass", density=2500.0, youngs_modulus=70e9, poisson_ratio=0.25)
    >>> block = Stator(solid=glass, length=60e-3, thickness=float("inf"), ends="absorbing")
    >>> push = LineForce(name="tip", position=10e-3, amplitude=1 / 2e-3, width=2e-3)
    >>> wave = forced_wave(block, (), (push,), frequency=2e6, tolerance=1e-3, places=(40e-3,))
    >>> u_x, u_y, u_z = surface_beam(wave).motion(40e-3, 0.0)
    >>> f"{abs(u_z) * 1e9:.2f} nm"
    '0.96 nm'
    """
    solution = wave.solution
    _refuse(wave, mirror_width)
    fields = apertures(solution.fields) if apertures else with_apertures(solution.fields, mirror_width)
    if fields is not solution.fields:
        solution = driven_solution(fields, solution.circuit.drive, solution.forces)
    beam = aperture_beam(wave, solution, mirror_width)
    if not (beam.strips and beam.charges):
        return beam
    if not isotropic_about_normal(fields.stator.solid):
        solution = driven_solution(with_scattering(beam), solution.circuit.drive, solution.forces)
        beam = replace(beam, solution=solution, charges=all_charges(solution))
    return with_reciprocal_currents(beam)


@refuses(BeamError)
def _refuse(wave: SurfaceWave, mirror_width: float | None) -> Iterator[Any]:
    """Raise a BeamError or an InputError for what `surface_beam` does not cover."""
    solution, stator = wave.solution, wave.solution.fields.stator
    transducers = solution.fields.transducers
    refusal = beam_refusal(stator)
    if not refusal and solution.forces is not None and stator.ends != "absorbing":
        refusal = f"the field of forces in three dimensions needs stator.ends = 'absorbing', got {stator.ends!r}"
    if refusal:
        yield refusal
    refuse_short_apertures(transducers, wave.phase_velocity / wave.frequency)
    strips = sheets_of_forces(solution)
    widths = [each.aperture for each in transducers] + [each.length for each in strips]
    if mirror_width is not None and not max(widths) <= mirror_width < np.inf:
        yield (f"mirror_width must be at least the largest aperture, {max(widths):g} m, got {mirror_width!r}")
    symmetric = mirror_width is None and isotropic_about_normal(stator.solid)
    if any(each.center_y for each in transducers) and not symmetric:
        yield "transducers beside the middle line need a solid isotropic about z and absorbing sides"
    if any(each.center for each in strips) and mirror_width is not None:
        yield "forces beside the middle line need absorbing sides"


def aperture_beam(wave: SurfaceWave, solution: Solution, mirror_width: float | None = None) -> SurfaceBeam:
    """Beam of the charges and forces of a solution; its circuit may be a part of a larger one (`crossed_beam`)."""
    fields, transducers, stator = solution.fields, solution.fields.transducers, solution.fields.stator
    in_cut = None if isotropic_about_normal(stator.solid) else cut_source(fields)

    # free and clamped ends reflect all modes, of which reduced lines have a part
    modes = fields.modes if stator.ends == "absorbing" else full_modes(fields.modes)

    def source(load: Load) -> ModeSource:
        if in_cut is not None:
            return in_cut.loaded(load)
        own = line_source(modes, load)
        return own.with_shear(with_all_displacements(fields), fields.frequency) if load == "x" else own

    forces = [each for each in fields.network.ports if each.kind == "force"] if solution.forces is not None else []
    by_load = {load: source(load) for load in {each.component for each in forces}}
    of_charges = source("charge") if transducers else next(iter(by_load.values()))
    return SurfaceBeam(
        wave=wave,
        solution=solution,
        source=of_charges,
        faces=None if stator.ends == "absorbing" else faces(fields, modes, line_source(modes, "charge")),
        charges=all_charges(solution),
        apertures=tuple(each.aperture for each in transducers),
        centers=tuple(each.center_y for each in transducers),
        mirror_width=mirror_width,
        strips=tuple(
            Strip(sheet, by_load[force.component])
            for force, sheet in zip(forces, sheets_of_forces(solution), strict=True)
        ),
    )


def sheets_of_forces(solution: Solution) -> list[ChargeSheet]:
    """Strips of the forces of a solution, with N/m instead of charges."""
    if solution.forces is None:
        return []
    unit, ports = solution.fields.section.length_unit, solution.fields.network.ports
    forces = [each for each in ports if each.kind == "force"]
    for each in forces:
        if not np.isfinite(each.width):
            raise InputError("force.width", "must be finite in three dimensions", each.width, "m", owner=each.name)
    return [
        ChargeSheet(
            x=np.array([each.position * unit]),
            charge=np.array([amplitude]),
            finger=np.zeros(1, dtype=int),
            length=each.width * unit,
            center=each.center * unit,
        )
        for each, amplitude in zip(forces, solution.forces, strict=True)
    ]


def with_scattering(beam: SurfaceBeam) -> PortFields:
    """Fields in which each transducer answers the mean of every strip's beam over its aperture, at its centre.

    The section's answers to a force that is the same all along y are multiplied by the mean of the surface wave's u_z
    over its value at k_y = 0, on the bare surface.
    """
    fields, ports = beam.solution.fields, len(beam.solution.fields.names)
    middles = np.array([each.center for each in fields.transducers])
    shares = np.ones((len(middles), ports + len(beam.strips)), dtype=complex)
    for column, strip in enumerate(beam.strips, start=ports):
        unit = replace(strip.sheet, charge=np.ones(1))
        alone = replace(beam, charges=(), apertures=(), centers=(), strips=(Strip(unit, strip.source),)).surface_mode
        (emitter,) = alone.emitters
        plane = emitter.plane_waves(middles, beam.wavelength)
        for index, (aperture, center) in enumerate(zip(beam.apertures, beam.centers, strict=True)):
            y, weights = _points_across(beam, center, aperture)
            shares[index, column] = alone.motion(middles[index], y)[2] @ weights / plane[index, 2]
    named = [index for index, each in enumerate(fields.transducers) if each.name in fields.names]
    return replace(
        fields,
        sides=tuple(
            sides if owner is None else sides * shares[owner]
            for owner, sides in zip(fields.owners, fields.sides, strict=True)
        ),
        received=fields.received * shares[named, ports:],
    )


def with_reciprocal_currents(beam: SurfaceBeam) -> SurfaceBeam:
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
    for port in range(len(fields.names)):
        circuit = replace(solution.circuit, voltages=np.eye(len(fields.names))[port])
        unit = replace(solution, circuit=circuit, forces=None)
        sent = replace(beam, solution=unit, charges=all_charges(unit), strips=(), complete=False)
        for column, (force, strip) in enumerate(zip(forces, beam.strips, strict=True)):
            y, weights = _points_across(beam, strip.sheet.center, strip.sheet.length)
            rules = sent.motion_by_rules(strip.sheet.x[0], y)[:2]
            fine, half = (each["xyz".index(force.component)] @ weights for each in rules)
            rate = 2j * np.pi * fields.frequency * strip.sheet.length
            received[port, column], coarser[port, column] = rate * fine, rate * half
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


def _points_across(beam: SurfaceBeam, center: float, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Points across a strip of the surface in m, and weights of the mean over it."""
    s, weights = np.polynomial.legendre.leggauss(int(8 + 4 * length / abs(beam.wavelength)))
    return center + length / 2 * s, weights / 2
