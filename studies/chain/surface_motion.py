"""Motion of the surface under the slider, per volt: of the finite aperture where that is known, else of the section.

The section knows x alone.  The beam (`fem.surface_beam`) spreads the section's charges over the aperture, so that the
amplitude depends on x and y and a motion u_y arises beside the axis.  `surface_motion` decides which of the two stands
for a scene: every answer that needs an orbit takes it from there.
"""

from dataclasses import dataclass, field, replace

__all__ = ["SurfaceMotion", "surface_motion", "wanted_diffraction"]

PER_WAVELENGTH = (
    24  # places where the beam's standing wave is looked at; a minimum between them is missed by 1 %
)


@dataclass(frozen=True, kw_only=True)
class SurfaceMotion:
    """Motion of a driven stator's surface.

    Attributes
    ----------
    wave : fem.SurfaceWave
        Of the section.
    beam : fem.SurfaceBeam or None
        Of the finite aperture; None where the section stands for it.
    reason : str
        Why it cannot be computed, at all or at some place; empty where it is, or is not wanted.
    """

    wave: object = field(repr=False)
    beam: object = field(default=None, repr=False)
    reason: str = ""

    def at(self, places):
        """Return u_x, u_y and u_z in m per V at places (x, y) in m, complex, shape (3, places).

        Each by itself, so that an answer depends on its own place alone to the last bit.
        """
        import numpy as np

        return np.array([self._at(place) for place in places]).T

    def _at(self, place: tuple[float, float]):
        import fem

        if self.beam is not None:
            try:
                return self.beam.motion(*place)
            except fem.BeamError:
                pass  # beside the fingers; `reason` says so
        tangential, normal = self.wave.motion(place[0])
        return tangential, 0j, normal

    def along(self, x, y: float):
        """Return u_x, u_y and u_z at many x in m on a line of constant y, complex, shape (3, len(x))."""
        import numpy as np

        import fem

        if self.beam is not None:
            try:
                return self.beam.motion(x, y)
            except fem.BeamError:
                pass
        return self.at([(each, y) for each in np.asarray(x, dtype=float).tolist()])

    def relative_error(self, places) -> float:
        """Return the largest estimated error at places (x, y) over max(|u_x|, |u_z|) there."""
        return max(self._error(place) for place in places)

    def _error(self, place: tuple[float, float]) -> float:
        import fem

        if self.beam is not None:
            try:
                return float(self.beam.relative_error(*place))
            except fem.BeamError:
                pass
        return self.wave.relative_error

    def surface_mode_at(self, place: tuple[float, float]) -> complex:
        """Return the surface mode's part of u_z at a place (x, y) beside the transducers."""
        import numpy as np

        if self.beam is None:
            return complex(self.wave.rayleigh_motion(place[0])[1])
        source = self.beam.source
        piece = next(each for each in self.wave.pieces if hasattr(each, "rayleigh"))
        kept = np.isin(source.wavenumbers, piece.wavenumbers[piece.rayleigh])
        parts = {
            name: getattr(source, name)[kept]
            for name in ("wavenumbers", "amplitudes", "tangential", "normal")
        }
        return complex(replace(self.beam, source=replace(source, static=0.0, **parts)).motion(*place)[2])

    def standing_wave_ratio(self, place: tuple[float, float]) -> float:
        """Return the largest over the smallest |u_z| within a wavelength either side of a place (x, y)."""
        import numpy as np

        import fem

        x, y = place
        if self.beam is not None:
            reach = (
                self.wave.phase_velocity / self.wave.frequency * np.linspace(-1, 1, 2 * PER_WAVELENGTH + 1)
            )
            along = x + reach[(x + reach >= 0) & (x + reach <= self.wave.length)]
            try:
                size = abs(self.beam.motion(along, y)[2])
            except fem.BeamError:
                pass  # fingers within reach
            else:
                return float(size.max() / size.min())
        return self.wave.standing_wave_ratio(x)


def surface_motion(wave, places, diffraction: bool | None) -> SurfaceMotion:
    """Return what stands for the motion of a solved stator at some places.

    Parameters
    ----------
    wave : fem.SurfaceWave
    places : sequence of (float, float)
        x and y in m, where it is needed.
    diffraction : bool or None
        True: the finite aperture; False: the plane section; None: the finite aperture where it can be computed.

    Raises
    ------
    fem.BeamError
        If diffraction is True and it cannot be computed there.
    """
    import fem

    if diffraction is False:
        return SurfaceMotion(wave=wave)
    beam, reason = None, ""
    try:
        beam = fem.surface_beam(wave)
        for place in places:
            beam.motion(*place)
    except fem.BeamError as error:
        if diffraction:
            raise
        reason = str(error)
    return SurfaceMotion(wave=wave, beam=beam, reason=reason)


def wanted_diffraction(given: bool | None, has_slider: bool) -> bool | None:
    """Return what a scene's ``stator.diffraction`` means: absent, it is tried under a slider."""
    return given if given is not None or has_slider else False
