"""Maps of the waves below a slider in the plane, for a slider that travels."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from contact import plane
from studies.model.plane import StatorSurface, Sum
from studies.model.wave_to_contact import Contact

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
