"""The wave field of a run that was left, computed anew from its scene at the run's own resolution."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import fem
from fem import LEVELS, one_blas_thread, solve_driven, surface_beam, surface_wave
from studies.chain import resolve
from studies.chain import run as run_chain
from studies.chain.surface_motion import SurfaceMotion, crossed_motion
from studies.record import Record
from studies.refusal import RunError, SceneError, shown
from studies.scene import Scene

if TYPE_CHECKING:
    from fem.beam.crossed_beam import CrossedBeam
    from fem.results.driven_answer import SurfaceWave


LINES = 16  # per wavelength in the stretches of a driven stator
FREE_WAVELENGTHS = 10  # of a free wave are shown
NO_STATOR = "there is no wave field: the scene of this run gives the surface motion itself and has no stator"


@dataclass(frozen=True, kw_only=True)
class RunField:
    """The wave field of a run with the electrodes and the slider on it."""

    # the field in m per V, or over u_z at the surface of a free wave; keywords ``span`` (m), ``per_wavelength`` and
    # ``energies`` as in `fem.wave_field`
    compute: Callable = field(repr=False)
    length: float  # of what is shown at most, m
    record: Record = field(repr=False)  # of the run
    wavelength: float  # of the surface wave, m
    # edges of the electrodes in m by sign: "+" and "-" the combs, "o" open strips
    fingers: dict = field(repr=False)
    spans: tuple[tuple[float, float], ...]  # from end to end of each transducer, m
    wave: "SurfaceWave | None" = field(default=None, repr=False)  # the fem.SurfaceWave of a driven stator
    crossed: "CrossedBeam | None" = field(
        default=None, repr=False
    )  # the fem.CrossedBeam of turned transducers

    def in_section(self, place: tuple[float, float]) -> float:
        """Where a place (x, y) lies along the section, m."""
        return place[0] if self.crossed is None else float(self.crossed.rows[0].local(*place)[0])

    @property
    def scene(self) -> Scene:
        """The run's, as resolved."""
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
        """Whether it is a free wave, known but for its size."""
        return not self.scene.transducer

    @cached_property
    def beam(self):
        """The beam of a run whose wave spreads in three dimensions, or None."""
        if self.crossed is not None or self.wave is None or not self.scene.stator.diffraction:
            return self.crossed
        return surface_beam(self.wave, mirror_width=self.scene.stator.mirror_width)

    @property
    def radius(self) -> float:
        """Of the balls, m."""
        slider = self.scene.slider
        return 0.0 if slider is None else slider.radius or (slider.pillars.diameter or 0.0) / 2

    @property
    def focus(self) -> tuple[str, float]:
        """What to look at from near: its name and place in m."""
        if self.scene.slider is not None:
            return "slider", self.in_section(self.scene.slider.center)
        return "middle", self.length / 2

    @property
    def drive(self) -> str:
        """What drives the field, and what its numbers refer to."""
        return (
            "free wave" if self.free else f"{', '.join(map(repr, self.scene.drive.driven))} driven, per volt"
        )

    def enlarged(self, factor: float) -> str:
        """How a displacement that is enlarged by a factor is drawn, for a reader."""
        return f"u_z drawn as {factor * 1e6:g} um" if self.free else f"displacement x {factor:g}"

    @property
    def aperture(self) -> float:
        """Width of the beam in m: the narrowest transducer's, or of a free wave the stator's."""
        apertures = [transducer.aperture for transducer in self.scene.transducer]
        return min([*apertures, self.scene.stator.width])

    def surface(self, x: float) -> tuple[complex, complex]:
        """Return u_x and u_z of the surface at a place (m), linear between the lines."""
        top, at = self.field.displacement[:, -1], self.field.x
        tangential, normal = (complex(np.interp(x, at, top[:, axis])) for axis in (0, 2))
        return tangential, normal

    def near_transducer(self, x: np.ndarray) -> np.ndarray:
        """Whether places lie under a transducer or within a quarter wavelength of one."""
        margin = 0.25 * self.wavelength
        inside = [(x >= start - margin) & (x <= stop + margin) for start, stop in self.spans]
        return np.any(inside, axis=0) if inside else np.zeros(len(x), dtype=bool)


def left_run(folder: str | Path) -> Record:
    """Return the record of a run; refuse a directory that holds none."""
    try:
        return Record.load(folder)
    except (RunError, TypeError):
        raise SceneError("", f"{shown(str(folder))} is no directory that sawmotor run left") from None


def run_field(run: str | Path | Record, *, progress: Callable[[str], None]) -> RunField:
    """Return the field of a run, computed anew.

    Parameters
    ----------
    run : str, Path or Record
        What ``sawmotor run`` left, or its record.
    progress : callable
        Told what is being done.

    Raises
    ------
    SceneError
        If the directory holds no run, or the run has no stator.
    """
    record = run if isinstance(run, Record) else left_run(run)
    if record.scene.stator is None:
        raise SceneError("", NO_STATOR)
    progress("computing the field")
    return _driven(record, progress) if record.scene.transducer else _free(record)


def _driven(record: Record, progress) -> RunField:
    scene, motion = record.scene, motion_again(record, progress=progress)
    wave, crossed = motion.wave, motion.beam if isinstance(motion.beam, fem.CrossedBeam) else None
    rows = resolve.transducers(scene) if crossed is None else crossed.rows[0].transducers
    slider = scene.slider
    below = [(scene.stator.length / 2, 0.0)] if slider is None else [slider.center, *slider.places]
    places = tuple(dict.fromkeys(map(motion.in_section, below)))

    whole = resolve.whole_stator(scene).placement.whole

    def strips(row, sign: str):
        """Edges of a transducer's fingers, as the mesh of a whole stator draws them."""
        return row.strips(sign) if whole is None else whole.strips(row.name + sign)

    def compute(*, per_wavelength: float = LINES, **wanted):
        return fem.wave_field(wave, places=places, per_wavelength=per_wavelength, **wanted)

    return RunField(
        compute=compute,
        length=wave.length,
        record=record,
        wavelength=record.wave["phase_velocity_m_per_s"] / scene.frequency,
        fingers={sign: [tuple(edges) for row in rows for edges in strips(row, sign)] for sign in "+-o"},
        spans=tuple(tuple(row.extent) for row in rows),
        wave=wave,
        crossed=crossed,
    )


def motion_again(record: Record, *, progress) -> SurfaceMotion:
    """Return the section of a run, or its crossing beams, at the resolution that run.json tells; else run again."""
    scene, named = record.scene, record.wave.get("resolution")
    level = [each for each in LEVELS if named == f"order {each.order}, {each.edge_layers} edge layers"]
    if not level:
        bare = replace(scene, slider=None)
        motion = run_chain(bare, tolerance=record.tolerance, progress=progress).surface_motion
        return motion if scene.crossed else SurfaceMotion(wave=motion.wave)

    def solve(stator, row, drive, _places=()):
        return surface_wave(
            one_blas_thread(solve_driven)(
                stator, row, frequency=scene.frequency, drive=drive, resolution=level[0]
            ),
            relative_error=record.error["relative"],
            admittance_error=record.electrical["admittance_relative_error"],
        )

    if scene.crossed:
        return crossed_motion(scene, (), solve)
    whole = resolve.whole_stator(scene), resolve.transducers(scene), resolve.drive(scene)
    return SurfaceMotion(wave=solve(*whole))


def _free(record: Record) -> RunField:
    scene, stator = record.scene, resolve.whole_stator(record.scene)
    try:
        wave = fem.free_wave(stator, frequency=scene.frequency, tolerance=record.tolerance)
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None
    wavelength = wave.velocity / wave.frequency
    return RunField(
        compute=partial(fem.free_field, wave),
        length=min(scene.stator.length, FREE_WAVELENGTHS * wavelength),
        record=record,
        wavelength=wavelength,
        fingers={},
        spans=(),
    )
