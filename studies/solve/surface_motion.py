"""Motion of the surface under the slider, per volt: with the finite aperture if possible, else of the plane section.

The motion of the section depends on x alone.  The beam (`fem.surface_beam`) distributes the section's charges over the
aperture, so that the amplitude depends on x and y and a motion u_y arises off the axis.  `surface_motion` chooses
between the two for all answers.  Rotated transducers have a section for each group of parallel ones
(`fem.crossed_beam`); the section of the motion is then that of the driven group whose waves run nearest to x.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

import fem
from studies.model.fem_objects import section_reason
from studies.model.model import Model
from studies.model.scene_errors import as_run_errors
from studies.scene.stator_keys import Stator

if TYPE_CHECKING:
    from fem.beam.crossed_beam import CrossedBeam
    from fem.beam.strip_beam import StripBeam
    from fem.beam.surface_beam import SurfaceBeam
    from fem.results.driven_answer import SurfaceWave

# samples of the beam's standing wave; they miss a minimum between them by 1 %
PER_WAVELENGTH = 24


@dataclass(frozen=True, kw_only=True)
class SurfaceMotion:
    """Motion of a driven stator's surface."""

    wave: "SurfaceWave" = field(repr=False)  # of the section
    # Of the finite aperture, or of strips along y; None where one section is used instead
    beam: "SurfaceBeam | CrossedBeam | StripBeam | None" = field(default=None, repr=False)
    reason: str = ""  # why no waves spread as beams; empty where they do
    # Motion and error by position (x, y), of those that have been evaluated
    evaluated: dict = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def spreads(self) -> bool:
        """Whether the waves spread as beams of finite apertures."""
        return self.beam is not None and not self.reason

    @property
    def circuit(self):
        """The `fem.circuit.Circuit` that belongs to this motion, per volt of the source."""
        return (self.beam or self.wave).circuit

    @property
    def power(self):
        """The `fem.results.power_balance.PowerBalance` that belongs to it."""
        return (self.beam or self.wave).power

    def at(self, positions):
        """Return u_x, u_y and u_z in m per V at positions (x, y) in m, complex, shape (3, positions)."""
        return np.array([each for each, _ in self._evaluated_at(positions)]).T

    def beams_at(self, positions) -> list:
        """Return the motion of the beam of each direction at positions (x, y) in m, each as `at`."""
        if isinstance(self.beam, fem.CrossedBeam):
            return self.beam.motions(*np.transpose(positions))
        return [self.at(positions)]

    def along(self, x, y: float):
        """Return u_x, u_y and u_z at many x in m on a line of constant y, complex, shape (3, len(x))."""
        return self._both(x, y)[0]

    def errors(self, positions):
        """Return the estimated error at positions (x, y) over max(|u_x|, |u_z|) at each."""
        return [error for _, error in self._evaluated_at(positions)]

    def relative_error(self, positions) -> float:
        """Return the largest of these errors."""
        return float(max(self.errors(positions)))

    def in_section(self, position: tuple[float, float]) -> float:
        """Return the coordinate of a position (x, y) along the section, m."""
        return position[0] if self.beam is None else self.beam.in_section(*position)

    def covered(self, position: tuple[float, float]) -> bool:
        """Whether a position lies under a transducer or on a meshed piece of the section."""
        return self.wave.covered(self.in_section(position))

    def unresolved(self, positions) -> str:
        """Return why the beam model does not resolve the field at one of some positions, otherwise an empty string."""
        for x, y in positions:
            if isinstance(self.beam, fem.SurfaceBeam) and self.beam.unresolved(x, y):
                wavelength = abs(self.wave.phase_velocity) / self.wave.frequency
                return (
                    f"in this cut the field beside the fingers and within a wavelength, {wavelength:.4g} m, of their "
                    f"ends is not known, and a contact lies there, at ({x:g}, {y:g}) m: choose another slider.position"
                )
        return ""

    def _evaluated_at(self, positions) -> list:
        """Return motion and error at each position; those that are new are computed together."""
        new = [position for position in dict.fromkeys(positions) if position not in self.evaluated]
        if new:
            motions, errors = self._both(*zip(*new, strict=True))
            self.evaluated.update(zip(new, zip(motions.T, map(float, errors), strict=True), strict=True))
        return [self.evaluated[position] for position in positions]

    def _both(self, x, y):
        if self.beam is not None:
            return self.beam.motion_and_error(x, y)
        tangential, normal = self.wave.motion(np.asarray(x, dtype=float))
        motion = np.array([tangential, np.zeros_like(normal), normal])
        return motion, np.full(np.shape(normal), self.wave.relative_error)

    def surface_mode_at(self, position: tuple[float, float]) -> complex:
        """Return the surface mode's part of u_z at a position (x, y) beside the transducers."""
        if self.beam is None or self.reason:
            return complex(self.wave.rayleigh_motion(position[0])[1])
        return complex(self.beam.surface_mode.motion(*position)[2])

    def standing_wave_ratio(self, position: tuple[float, float]) -> float:
        """Return the largest over the smallest |u_z| within a wavelength either side of a position (x, y)."""
        x, y = position
        if self.beam is None:
            return self.wave.standing_wave_ratio(x)
        reach = abs(self.wave.phase_velocity) / self.wave.frequency * np.linspace(-1, 1, 2 * PER_WAVELENGTH + 1)
        along = x + reach[(x + reach >= 0) & (x + reach <= self.beam.length)]
        return fem.standing_wave_ratio(self.beam.motion(along, y)[2])


def solved_motion(
    model: Model, positions, *, tolerance: float, slider: bool | None = None, missed: bool = False
) -> SurfaceMotion:
    """Return the motion of a driven stator, its section solved to a tolerance at positions (x, y) in m.

    ``slider``: True if the motion is to drive a slider; by default, if the scene has one.  ``missed``: True returns a
    motion that misses the tolerance, with its error, instead of raising RunError.  A refusal of the beam becomes one of
    the key ``stator.diffraction``.
    """
    scene = model.scene
    slider = scene.slider is not None if slider is None else slider

    def solve(stator, transducers, drive, x):
        try:
            return fem.driven_wave(
                stator, transducers, frequency=scene.frequency, drive=drive, tolerance=tolerance, places=x
            )
        except fem.ConvergenceError as error:
            if error.reached is None or not missed:
                raise
            return error.reached

    try:
        with as_run_errors():
            if scene.crossed:
                return crossed_motion(model, positions, solve)
            if scene.in_strips:
                return strip_motion(model, positions, solve, slider=slider)
            wave = solve(model.stator, model.transducers, model.drive, tuple(dict.fromkeys(x for x, _ in positions)))
            return surface_motion(wave, scene.stator, positions, slider=slider)
    except fem.BeamError as error:
        scene.refuse("stator.diffraction", f"must be false or absent: {error}")
    except fem.InputError as error:
        index = [each.name for each in scene.transducer].index(error.owner)
        scene.refuse(error.key.replace("transducer", f"transducer.{index}", 1), error.rule)


def crossed_motion(model: Model, positions, solve) -> SurfaceMotion:
    """Return the motion of a scene with rotated transducers; ``solve`` as for `fem.crossed_beam`."""
    beam = fem.crossed_beam(
        model.stator, model.transducers, width=model.scene.stator.width, frequency=model.scene.frequency,
        drive=model.drive, solve=solve, places=tuple(positions),
    )  # fmt: skip
    return SurfaceMotion(wave=beam.wave, beam=beam)


def strip_motion(model: Model, positions, solve, *, slider: bool) -> SurfaceMotion:
    """Return the motion of a scene with apodised or slanted transducers, a sum over strips along y.

    The strips' waves spread as beams under the conditions of `surface_motion`.
    """
    scene = model.scene
    reason = section_reason(scene.stator, model.stator, positions if slider else None, scene.transducer)
    beam = fem.strip_beam(
        model.stator, model.transducers, frequency=scene.frequency, drive=model.drive, solve=solve,
        places=tuple(dict.fromkeys(x for x, _ in positions)), spreads=not reason,
    )  # fmt: skip
    return SurfaceMotion(wave=beam.wave, beam=beam, reason=reason)


def surface_motion(wave, block: Stator, positions, *, slider: bool = True) -> SurfaceMotion:
    """Return the motion of a solved stator (fem.SurfaceWave) at positions (x, y) in m: that of the beam or the section.

    ``stator.diffraction`` is True: the finite aperture (fem.BeamError where it cannot be computed); False: the plane
    section; None: the finite aperture under a slider, unless `fem_objects.section_reason` states a reason against it or
    the error that it adds to the section's is larger than what it changes.
    """
    fields = wave.solution.fields
    reason = section_reason(block, fields.stator, positions if slider else None, fields.transducers)
    if reason:
        return SurfaceMotion(wave=wave, reason=reason)
    return beam_motion(fem.surface_beam(wave, mirror_width=block.mirror_width), block, positions)


def beam_motion(beam: "SurfaceBeam", block: Stator, positions) -> SurfaceMotion:
    """Return the motion of a beam or, by the rule of `surface_motion`, of its section."""
    wave = beam.wave
    spread = SurfaceMotion(wave=wave, beam=beam)
    if block.diffraction is None:
        here, there = spread.at(positions)[[0, 2]], wave.motion(np.array([x for x, _ in positions]))
        changed = float((abs(here - there).max(axis=0) / abs(here).max(axis=0)).max())
        added = spread.relative_error(positions) - wave.relative_error
        if added > changed:
            reason = f"the beam's own error, {added:.1e}, would exceed what it changes, {changed:.1e}"
            reason = f"stator.diffraction is absent and {reason}; true computes it nevertheless"
            return SurfaceMotion(wave=wave, reason=reason)
    return spread
