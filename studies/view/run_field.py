"""The wave field of a saved run, computed again from its scene at the resolution of the run."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import fem
from fem import LEVELS, one_blas_thread, solve_driven, surface_beam, surface_wave
from studies.model.model import model_of
from studies.model.scene_errors import as_run_errors
from studies.record import Record
from studies.record.files import DamagedRunError
from studies.refusal import RunError, SceneError, shown
from studies.runs import run as run_chain
from studies.scene import Scene
from studies.solve.surface_motion import SurfaceMotion, crossed_motion

if TYPE_CHECKING:
    from fem.beam.crossed_beam import CrossedBeam
    from fem.results.driven_answer import SurfaceWave

LOGGER = logging.getLogger(__name__)

LINES = 16  # nodes per wavelength in the uniform parts of a driven stator
FREE_WAVELENGTHS = 10  # largest shown length of a free wave, in wavelengths
NO_STATOR = "there is no wave field: the scene of this run gives the surface motion itself and has no stator"


@dataclass(frozen=True, kw_only=True)
class RunField:
    """The wave field of a run, with the positions of electrodes and slider."""

    # function that returns the field, in m per V or, for a free wave, relative to u_z at the surface; its keywords
    # ``span`` (m), ``per_wavelength`` and ``energies`` are those of `fem.wave_field`
    compute: Callable = field(repr=False)
    length: float  # largest length that can be shown, m
    record: Record = field(repr=False)
    wavelength: float  # of the surface wave, m
    # edges (left, right) of the fingers in m, by sign: "+" and "-" for the two electrodes, "o" for open strips
    fingers: dict = field(repr=False)
    spans: tuple[tuple[float, float], ...]  # first and last x of each transducer, m
    wave: "SurfaceWave | None" = field(default=None, repr=False)  # None for a free wave
    crossed: "CrossedBeam | None" = field(default=None, repr=False)  # None unless transducers are rotated

    def in_section(self, position: tuple[float, float]) -> float:
        """Return the coordinate of a point (x, y) along the section in m."""
        return position[0] if self.crossed is None else float(self.crossed.rows[0].local(*position)[0])

    @property
    def scene(self) -> Scene:
        """The resolved scene of the run."""
        return self.record.scene

    @cached_property
    def field(self):
        """The whole field, without strain energy and power flow."""
        return self.compute(span=(0.0, self.length), energies=False)

    @cached_property
    def with_energies(self):
        """The whole field with strain energy and power flow."""
        return self.compute(span=(0.0, self.length), energies=True)

    @property
    def free(self) -> bool:
        """True for a free wave, whose amplitude is arbitrary."""
        return not self.scene.transducer

    @cached_property
    def beam(self):
        """The beam of a run whose wave spreads in three dimensions, or None."""
        if self.crossed is not None:
            return self.crossed
        if self.wave is None or not self.scene.stator.diffraction:
            return None
        return surface_beam(self.wave, mirror_width=self.scene.stator.mirror_width)

    @property
    def radius(self) -> float:
        """Radius of the balls or of the pillars, m; 0 without a slider or if it is unknown."""
        slider = self.scene.slider
        return 0.0 if slider is None else slider.radius or (slider.pillars.diameter or 0.0) / 2

    @property
    def focus(self) -> tuple[str, float]:
        """Centre of enlarged views: its name and its position along the section in m."""
        if self.scene.slider is not None:
            return "slider", self.in_section(self.scene.slider.center)
        return "middle", self.length / 2

    @property
    def drive(self) -> str:
        """Text on the excitation of the field and the normalisation of its values."""
        return "free wave" if self.free else f"{', '.join(map(repr, self.scene.drive.driven))} driven, per volt"

    def enlarged(self, factor: float) -> str:
        """Return a text on the magnification of the displacement."""
        return f"u_z drawn as {factor * 1e6:g} um" if self.free else f"displacement x {factor:g}"

    @property
    def aperture(self) -> float:
        """Width of the beam in m: the smallest aperture of the transducers, at most the width of the stator."""
        apertures = [transducer.aperture for transducer in self.scene.transducer]
        return min([*apertures, self.scene.stator.width])

    def surface(self, x: float) -> tuple[complex, complex]:
        """Return u_x and u_z of the surface at x (m), by linear interpolation between the nodes."""
        top, at = self.field.displacement[:, -1], self.field.x
        tangential, normal = (complex(np.interp(x, at, top[:, axis])) for axis in (0, 2))
        return tangential, normal

    def near_transducer(self, x: np.ndarray) -> np.ndarray:
        """Return whether positions lie under a transducer or within a quarter wavelength of one."""
        margin = 0.25 * self.wavelength
        inside = [(x >= start - margin) & (x <= stop + margin) for start, stop in self.spans]
        return np.any(inside, axis=0) if inside else np.zeros(len(x), dtype=bool)


def saved_run(folder: str | Path) -> Record:
    """Return the record of a run; raise an error if the directory contains none, or a damaged one."""
    try:
        return Record.load(folder)
    except DamagedRunError as error:
        raise SceneError("", str(error)) from None
    except (RunError, TypeError):
        raise SceneError("", f"{shown(str(folder))} is no directory that sawmotor run left") from None


def run_field(run: str | Path | Record) -> RunField:
    """Compute the field of a run again.

    Parameters
    ----------
    run : str, Path or Record
        Directory written by ``sawmotor run``, or its record.

    Raises
    ------
    SceneError
        If the directory contains no run, or the scene has no stator.
    """
    record = run if isinstance(run, Record) else saved_run(run)
    if record.scene.stator is None:
        raise SceneError("", NO_STATOR)
    LOGGER.info("computing the field")
    return _driven(record) if record.scene.transducer else _free(record)


def _driven(record: Record) -> RunField:
    model, motion = model_of(record.scene), recomputed_motion(record)
    wave = motion.wave
    crossed = motion.beam if isinstance(motion.beam, fem.CrossedBeam) else None
    transducers = model.transducers if crossed is None else crossed.rows[0].transducers
    positions = tuple(dict.fromkeys(map(motion.in_section, model.scene.positions)))
    whole_mesh = model.stator.placement.whole  # a mesh of the whole stator defines its fingers

    def fingers(transducer, sign: str):
        """Return the edges of the fingers of one sign."""
        return transducer.strips(sign) if whole_mesh is None else whole_mesh.strips(transducer.name + sign)

    def compute(*, per_wavelength: float = LINES, **wanted):
        return fem.wave_field(wave, places=positions, per_wavelength=per_wavelength, **wanted)

    return RunField(
        compute=compute,
        length=wave.length,
        record=record,
        wavelength=record.wave.phase_velocity_m_per_s / model.scene.frequency,
        fingers={sign: [tuple(edges) for each in transducers for edges in fingers(each, sign)] for sign in "+-o"},
        spans=tuple(tuple(each.extent) for each in transducers),
        wave=wave,
        crossed=crossed,
    )


def recomputed_motion(record: Record, frequency: float | None = None) -> SurfaceMotion:
    """Return the section or the crossing beams of a run at the resolution in run.json.

    If run.json names no known resolution, the chain is run again without the slider. ``frequency``: one of those of the
    sources in Hz, by default the first.
    """
    scene = record.scene
    if scene.drive.source_frequencies:
        scene = replace(scene, drive=scene.drive.at_frequency(frequency or scene.drive.frequencies[0]))
    resolution_name = (record.wave.resolution or "").replace(" 1 edge layers", " 1 edge layer")  # of older runs
    named = [each for each in LEVELS if resolution_name == each.name]
    if not named:
        without_slider = replace(scene, slider=None)
        motion = run_chain(without_slider, tolerance=record.tolerance).surface_motion
        return motion if scene.crossed else SurfaceMotion(wave=motion.wave)

    def solve(stator, transducers, drive, _places=()):  # the signature that `crossed_motion` calls
        solution = one_blas_thread(solve_driven)(
            stator, transducers, frequency=scene.frequency, drive=drive, resolution=named[0]
        )
        return surface_wave(
            solution, relative_error=record.error.relative, admittance_error=record.electrical.admittance_relative_error
        )

    model = model_of(scene)
    if scene.crossed:
        return crossed_motion(model, (), solve)
    wave = solve(model.stator, model.transducers, model.drive)
    return SurfaceMotion(wave=wave)


def _free(record: Record) -> RunField:
    scene, stator = record.scene, model_of(record.scene).stator
    with as_run_errors():
        wave = fem.free_wave(stator, frequency=scene.frequency, tolerance=record.tolerance)
    wavelength = wave.velocity / wave.frequency
    return RunField(
        compute=partial(fem.free_field, wave),
        length=min(scene.stator.length, FREE_WAVELENGTHS * wavelength),
        record=record,
        wavelength=wavelength,
        fingers={},
        spans=(),
    )
