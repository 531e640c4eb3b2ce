"""The waves of each source alone below a slider in the plane, their sum, and maps of them for a slider that travels."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import fem
from contact import plane
from studies.model.model import Model
from studies.model.plane import StatorSurface, Sum
from studies.model.wave_to_contact import Contact
from studies.solve.refinement import SHARE
from studies.solve.surface_motion import solved_motion

# Lines of a map per wavelength, lines beyond its edge, and its size in wavelengths; splines of order 5 between 9 lines
# per wavelength miss 3e-5 of the largest amplitude (fem/beam/crossed_beam.py)
PER_WAVELENGTH, MARGIN, SIZE = 10, 9, 2
ORDER = 5


@dataclass(frozen=True, kw_only=True)
class Mapped:
    """A surface motion of one frequency, interpolated on square maps that are made where they are used."""

    surface: Any  # what has ``at(x, y)``
    wavelength: float  # m
    maps: dict = field(default_factory=dict, repr=False)  # spline coefficients by place of the map

    def at(self, x: np.ndarray, y: np.ndarray) -> plane.SurfaceWaves:
        """Return the waves at places in m from the slider's first place."""
        from scipy.ndimage import map_coordinates

        size = SIZE * self.wavelength
        amplitudes = np.empty((len(x), 3), dtype=complex)
        for k, (a, b) in enumerate(zip(x, y, strict=True)):
            corner = int(np.floor(a / size)), int(np.floor(b / size))
            frequency, coefficients = self._map(corner)
            step = self.wavelength / PER_WAVELENGTH
            at = [[each / step - corner[axis] * SIZE * PER_WAVELENGTH + MARGIN] for axis, each in enumerate((a, b))]
            amplitudes[k] = [
                map_coordinates(each, at, order=ORDER, mode="nearest", prefilter=False)[0] for each in coefficients
            ]
        return plane.SurfaceWaves(frequencies=(frequency,), amplitudes=amplitudes[None])

    def _map(self, corner: tuple[int, int]) -> tuple[float, np.ndarray]:
        """Return the frequency and the spline coefficients, (3, lines, lines), of the map of a corner."""
        from scipy.ndimage import spline_filter

        if corner not in self.maps:
            count, step = SIZE * PER_WAVELENGTH, self.wavelength / PER_WAVELENGTH
            lines = [step * (np.arange(-MARGIN, count + MARGIN + 1) + each * count) for each in corner]
            x, y = (each.ravel() for each in np.meshgrid(*lines, indexing="ij"))
            waves = self.surface.at(x, y)
            shape = (len(lines[0]), len(lines[1]))
            parts = [spline_filter(each.reshape(shape), order=ORDER, output=complex) for each in waves.amplitudes[0].T]
            self.maps[corner] = waves.frequencies[0], np.array(parts)
        return self.maps[corner]


def waves_of_sources(driven: Contact, tolerance: float) -> dict[str, Any]:
    """Return the surface motion of each source alone for a level of 1, by name; of prescribed waves by number.

    ``tolerance``: of the velocity, of which the stator takes a share.
    """
    scene = driven.scene
    if scene.wave is not None:
        waves = driven.surface.waves
        return {f"wave {number}": replace(driven.surface, waves=(each,)) for number, each in enumerate(waves, start=1)}
    return {name: _of_source(driven.model, name, tolerance) for name, size in scene.drive.driven.items() if size}


def _of_source(model: Model, name: str, tolerance: float) -> Mapped:
    """Return the surface motion of one source of a stator per volt, the other sources at 0 V."""
    scene, drive = model.scene, model.scene.drive
    frequency = dict(drive.source_frequencies or ()).get(name, scene.frequency)
    alone = drive.at_frequency(frequency)
    alone = replace(alone, sources=tuple((each, size if each == name else 0.0) for each, size in alone.driven.items()))
    solve = fem.one_blas_thread(solved_motion)
    stator = model.alone_with(alone)
    motion = solve(stator, scene.positions, tolerance=SHARE * tolerance, slider=True, missed=True)
    surface = StatorSurface(center=scene.slider.center, frequencies=(frequency,), motions=(lambda: motion,))
    return Mapped(surface=surface, wavelength=abs(motion.wave.phase_velocity) / motion.wave.frequency)


def travelled(driven: Contact, level: float) -> Sum:
    """Return the waves at a level for a slider that travels: of a stator from maps."""
    surface = driven.surface
    if not isinstance(surface, StatorSurface):
        return Sum(parts=((surface, level),))
    parts = []
    for frequency, motion in zip(surface.frequencies, surface.motions, strict=True):
        one, wave = replace(surface, frequencies=(frequency,), motions=(motion,)), motion().wave
        parts.append((Mapped(surface=one, wavelength=abs(wave.phase_velocity) / wave.frequency), level))
    return Sum(parts=tuple(parts))


def driven_by(sources: Mapping[str, Any], levels: Mapping[str, float]) -> Sum:
    """Return the surface motion of some sources, each at its level."""
    return Sum(parts=tuple((sources[name], level) for name, level in levels.items()))
