"""The wave field along the way of a slider: its orbits there, and where the way ends.

In a burst the slider is followed with the orbits of its own position (`contact.Track`), with its bounce and with the
turn of the wave's phase from place to place.
"""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

import contact
from studies.model.free_way import FreeWay, free_way
from studies.model.model import Model
from studies.solve.surface_motion import SurfaceMotion

PER_WAVELENGTH = 32  # nodes of the field; the error of the motion between them is 3e-7
LEAST_WAY = 1e-9  # m: a slider nearer to fingers than this cannot travel


@dataclass(frozen=True, kw_only=True)
class WaveAlong:
    """Orbits under a slider's balls as functions of its displacement along x."""

    frequency: float  # Hz
    wavelength: float  # m
    way: FreeWay
    track: contact.Track = field(repr=False)  # per volt

    @classmethod
    def under(cls, model: Model, motion: SurfaceMotion) -> Self | None:
        """Return the orbits under the slider of a resolved scene on the motion of its stator's surface.

        None where the slider cannot travel because it stands at the end of its way.
        """
        wave, positions, way = motion.wave, model.scene.slider.contact_positions, free_way(model)
        wavelength = abs(wave.phase_velocity) / wave.frequency

        def amplitudes(displacements):
            balls = [motion.along(x + displacements, y)[[0, 2]] for x, y in positions]
            return np.stack(balls, axis=1)

        if min(-way.low, way.high) < LEAST_WAY:
            return None
        track = contact.Track(
            amplitudes=amplitudes, spacing=wavelength / PER_WAVELENGTH, limits=(way.low, way.high)
        )  # fmt: skip
        return cls(frequency=wave.frequency, wavelength=wavelength, way=way, track=track)

    def scaled(self, factor: float) -> Self:
        """Return the field with all amplitudes multiplied by a factor."""
        return replace(self, track=self.track.scaled(factor))

    def orbits(self, displacements) -> list[tuple]:
        """Return the orbits of the balls per volt at displacements in m."""
        return self.track.orbits(displacements, self.frequency)

    def end(self, displacement: float) -> str:
        """Return in words what the slider meets at the end of its way on the side of a displacement."""
        return self.way.at_high if displacement > 0 else self.way.at_low
