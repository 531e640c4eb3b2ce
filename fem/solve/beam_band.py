"""Beams of finite apertures at many frequencies of a band: charges and circuit from the reduced section.

At every frequency the reduced model (`fem.reduce.reduced_model`) gives the section's fields and the charges on the
fingers, which change slowly enough to be interpolated with the half cells.  The change of a transducer's potentials by
its own finite aperture is interpolated over the band too (`fem.beam.reception.aperture_solver`).  From these charges
the beam is computed at each frequency as for a single one: its integral over the lateral wavenumber is not
interpolated, and has its own error.

The errors of the reduction are those of beams against beams of full solutions, at frequencies where the band has no
nodes and at the requested positions, scaled to the sharpest resonance (`fem.solve.band_solution`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from fem.beam.beam_of_section import beam_refusal, surface_beam
from fem.beam.reception import aperture_solver
from fem.beam.surface_beam import SECTION_SHARE, BeamError, SurfaceBeam
from fem.circuit import Drive
from fem.exceptions import refuse_above
from fem.geometry import Stator, Transducer
from fem.materials import isotropic_about_normal
from fem.results.driven_answer import surface_wave
from fem.results.stator_solution import driven_solution
from fem.solve.band_solution import Band, frequency_band, reduction_growth, resonant_amplification
from fem.solve.driven_stator import solve_driven
from fem.threads import one_blas_thread, side_by_side
from fem.waveguide.port_fields import PortFields, StatorCascade

# Frequencies at which the band is compared with full solutions, from -1 to 1 over omega^2 of the band: where
# polynomials through four Chebyshev nodes err most, without the middle, which the section's band checks.
CHECKED = (-np.sqrt(0.5), np.sqrt(0.5))
ROUNDS = 2  # bands that are tried: the tolerance bounds the section's motion, and its beams may need a smaller one


@dataclass(frozen=True, kw_only=True)
class BeamBand:
    """Beams of a driven stator at any frequency of a band; make it with `beam_band`.

    Attributes
    ----------
    band : Band
        Of the section, whose `relative_error` and `admittance_error` are without those of the beams below.
    mirror_width : float or None
        Distance in m of two reflecting side faces.
    relative_error, admittance_error : float
        Of the beams' motion at the requested positions and of the admittance by the reduction, at the worst frequency.
    """

    band: Band
    mirror_width: float | None
    relative_error: float = 0.0
    admittance_error: float = 0.0
    _apertures: Callable[[StatorCascade], PortFields] | None = field(default=None, repr=False)

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency in Hz."""
        return self.band.limits

    def beam(self, frequency: float, drive: str | Drive) -> SurfaceBeam:
        """Beam at a frequency of the band (Hz); the error of its section includes those of the reduction."""
        solution = driven_solution(self.band.port_fields(frequency), drive)
        wave = surface_wave(
            solution,
            relative_error=self.band.relative_error + self.relative_error,
            admittance_error=self.band.admittance_error + self.admittance_error,
        )
        return surface_beam(wave, mirror_width=self.mirror_width, apertures=self._apertures)


@one_blas_thread
def beam_band(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    lowest: float,
    highest: float,
    drive: str | Drive,
    tolerance: float,
    places: tuple[tuple[float, float], ...],
    mirror_width: float | None = None,
) -> BeamBand:
    """Prepare the beams of a driven stator for the frequencies of a band.

    Parameters
    ----------
    stator : Stator
        Its solid must be isotropic about z; without meshed pieces and layers.
    transducers : tuple of Transducer
        As of `fem.frequency_band`.
    lowest, highest : float
        Hz.
    drive : str or Drive
        The error is estimated for this drive; `BeamBand.beam` takes any other.
    tolerance : float
        Relative, of the section's motion at the x of ``places``, and of what the reduction changes in the beams' motion
        there.
    places : tuple of (float, float)
        (x, y) in m, not under a transducer.
    mirror_width : float, optional
        As of `fem.surface_beam`.

    Raises
    ------
    BeamError
        If the stator is none of these, or as `fem.surface_beam` does.
    ConvergenceError
        If a tolerance is not met.
    """
    refusal = beam_refusal(stator)
    if not refusal and not isotropic_about_normal(stator.solid):
        refusal = "a band of beams needs a solid isotropic about z: solve one frequency at a time"
    if refusal:
        raise BeamError(refusal)
    section_tolerance = tolerance
    for _ in range(ROUNDS):
        band = frequency_band(
            stator,
            transducers,
            lowest=lowest,
            highest=highest,
            drive=drive,
            tolerance=section_tolerance,
            places=tuple(dict.fromkeys(x for x, _ in places)),
            charges=True,
        )
        apertures = aperture_solver(stator, mirror_width, limits=band.limits)
        found = _with_errors(BeamBand(band=band, mirror_width=mirror_width, _apertures=apertures), places, drive)
        if found.relative_error <= tolerance:
            return found
        section_tolerance *= 0.5 * tolerance / found.relative_error
    what, advice = "the motion of the band's beams is", "ask for less, or solve one frequency at a time"
    refuse_above(found.relative_error, tolerance, what, advice=advice, reached=found)
    return found


def _with_errors(beams: BeamBand, places: tuple[tuple[float, float], ...], drive: str | Drive) -> BeamBand:
    """Return a band with the errors of its beams against those of full solutions at `CHECKED`."""
    band, model = beams.band, beams.band.model
    lowest, highest = band.limits
    middle, half = (highest**2 + lowest**2) / 2, (highest**2 - lowest**2) / 2

    def compared(frequency: float) -> tuple[float, float]:
        solution = solve_driven(
            model.stator, model.transducers, frequency=frequency, drive=drive, resolution=model.resolution
        )
        wave = surface_wave(solution, relative_error=0.0, admittance_error=0.0)
        full = surface_beam(wave, mirror_width=beams.mirror_width)
        growth = reduction_growth(*resonant_amplification(solution, band.limits))
        of_motion, of_admittance = beam_differences(full, beams.beam(frequency, drive), np.array(places).T)
        return growth * of_motion, growth * of_admittance

    errors = side_by_side(compared, [float(np.sqrt(middle + half * each)) for each in CHECKED])
    of_motion, of_admittance = (float(max(each)) for each in zip(*errors, strict=True))
    return replace(beams, relative_error=of_motion, admittance_error=of_admittance)


def beam_differences(fine: SurfaceBeam, coarse: SurfaceBeam, places: np.ndarray) -> tuple[float, float]:
    """Largest relative differences of the motion at places (x, y) in m, (2, n), and of the sources' admittances.

    The motion's is over the amplitude there, or over a share of the section's where beams interfere, as the section's
    error in `SurfaceBeam.relative_error`.
    """
    motions = [each.motion(*places) for each in (fine, coarse)]
    section = abs(fine.wave.motion(places[0])).max(axis=0)
    size = np.maximum(abs(motions[0][[0, 2]]).max(axis=0), SECTION_SHARE * section)
    of_motion = float(np.max(abs(motions[0] - motions[1]).max(axis=0) / size))
    ratios = coarse.circuit.source_admittances / fine.circuit.source_admittances
    return of_motion, float(np.max(abs(ratios - 1)))
