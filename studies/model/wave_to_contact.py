"""From the wave to the contact: the surface motion per volt times the voltage is the orbit under each ball.

Both sides use exp(+i omega t), peak amplitudes, x along the surface and z out of it, so nothing changes
sign.  A wave that runs to +x has u_x = +i r u_z; the crests of a prescribed [wave] move towards +x, u_x = -i r u_z.

n contacts that feel one and the same motion behave as one with 1/n of mass, preload, load and viscous
dampers (the Hunt-Crossley coefficient, per contact already, stays): a mere number of contacts is computed
as one.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import contact
from studies.model.contacts_of import contacts_of
from studies.model.model import Model
from studies.record import Record
from studies.record.point import Point
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.slider_keys import Slider

STOPS = (
    'must be "hysteretic" or absent {where}: of samples with a stop for each asperity (law = "elastic") run and sweep '
    "give steady velocities alone, for the solvers of bursts and loads take one force for each ball"
)


def scaled(orbits, level: float):
    """Return orbits, or a passing wave, for a level of 1 at another level, see `Contact`."""
    if isinstance(orbits, contact.PassingWave):
        return orbits.scaled(level)
    return tuple(orbit.scaled(level) for orbit in orbits)


@lru_cache(10_000)  # of a sweep's points many have the same
def contact_slider(slider: Slider):
    """Return the ``contact.Slider`` of a block whose preload and moduli are numbers.

    Of equal contacts that move alike it is one of ``slider.share`` equal parts.
    """
    if slider.planar:
        key = "freedom" if slider.axis is None else "axis"
        slider.refuse(key, "must be absent here: this answer is that of a slider that moves along x alone")
    return contacts_of(slider).slider_of(slider)


@dataclass(frozen=True, kw_only=True)
class Contact:
    """A slider and the surface motion that drives it: the problem that the contact's solvers solve.

    A level is a voltage of the source in V, or the amplitude of a prescribed wave in m.
    """

    model: Model  # of a resolved scene
    # for a level of 1: a contact.Orbit under each contact, or the contact.PassingWave under a slider
    orbits: Any = field(repr=False)
    # |u_z| and |u_x| for a level of 1, m: under the slider's centre; of a slider on pillars the rms over the pillars
    amplitudes: tuple[float, float]
    stator_error: float = 0.0  # of the orbits, relative
    ringing: Any = None  # studies.solve.ring_up.RingUp: growth of the orbits during a burst
    misfit: float = 0.0  # rms misfit of a passing wave to the surface motion, relative to the larger of its two waves
    along: Any = None  # studies.solve.travel.WaveAlong: the orbits along the slider's travel
    record: Record | Any = field(default=None, repr=False)  # of the run that solved the stator
    # studies.solve.solved_stator.SolvedStator; None with a prescribed wave
    solved: Any = field(default=None, repr=False)
    # of a slider in the plane, for a level of 1: what has ``at(x, y)``, the waves at places about its centre
    surface: Any = field(default=None, repr=False)

    @classmethod
    def prescribed(cls, model: Model, record: Record | None = None) -> Self:
        """Return the contact of a resolved scene with a prescribed wave."""
        wave, slider, surface = model.scene.wave, model.scene.slider, None
        if model.scene.planar:
            from studies.model.plane import prescribed_surface

            surface = prescribed_surface(wave)
        orbits = contacts_of(slider).prescribed_motion(slider, wave)
        return cls(model=model, orbits=orbits, amplitudes=(1.0, wave.tangential_ratio), record=record, surface=surface)

    @classmethod
    def of_stator(cls, model: Model, solved: Any, motion: Callable[[], Any] | Any = None) -> Self:
        """Return the contact on a solved stator, or its surface motion where the scene has no slider.

        ``motion()`` returns that of the surface; it is called where the waves under a slider are fitted to it.
        """
        positions, slider = model.scene.positions, model.scene.slider
        orbits, misfit, amplitudes = (), 0.0, solved.at[positions[0]].amplitudes
        if slider is not None:
            orbits, misfit, amplitudes = contacts_of(slider).stator_motion(slider, model.alone.plain, solved, motion)
        return cls(
            model=model, orbits=orbits, solved=solved, misfit=misfit, amplitudes=amplitudes,
            stator_error=max(solved.at[position].relative_error for position in positions),
        )  # fmt: skip

    @property
    def scene(self) -> Scene:
        """The resolved scene."""
        return self.model.scene

    @cached_property
    def slider(self):
        """The `contact.Slider`; refused of samples with a stop for each asperity."""
        if self.surface is not None:
            from studies.model.plane import plane_slider

            return plane_slider(self.scene.slider)
        if self.rough:
            from studies.model.roughness_of_balls import ball_force, largest_amplitude

            if not self.as_law:
                raise SceneError("slider.law", STOPS.format(where="here"))
            force = ball_force(self.scene.slider, largest_amplitude(self.scene.levels, self.orbits))
            return replace(contact_slider(self.scene.slider), normal_law=force)
        return contact_slider(self.scene.slider)

    @property
    def slider_along_x(self):
        """The `contact.Slider` that moves along x alone, on smooth balls."""
        return contact_slider(self.scene.slider.along_x)

    @property
    def rough(self) -> bool:
        """Whether the slider stands on rough balls."""
        return self.scene.slider is not None and self.scene.slider.roughness is not None

    @property
    def as_law(self) -> bool:
        """Whether the force of each rough ball is a normal law with one tangential law, which every method takes."""
        return self.rough and not (self.scene.slider.roughness.sampled and self.scene.slider.law == "elastic")

    @property
    def holding(self) -> bool:
        """Whether it stands on balls whose adhesion holds on beyond the touch."""
        slider = self.scene.slider
        return slider is not None and slider.adhesion is not None and slider.adhesion.holds

    @property
    def heavy(self) -> bool:
        """Whether its limits are those of a heavy slider: rough balls, and adhesion that holds on."""
        return self.rough or self.holding

    @property
    def contacts(self) -> int:
        """Number of contacts that are computed."""
        return self.slider.count if self.passing else len(self.orbits)

    @property
    def passing(self) -> bool:
        """Whether the slider stands on waves that pass below it, which it may load."""
        return isinstance(self.orbits, contact.PassingWave)

    @property
    def moving_slider(self):
        """The `contact.Slider` with the mass of the scene, for a motion in time."""
        return replace(self.slider, mass=self.scene.slider.mass / self.scene.slider.share)

    @property
    def level(self) -> float:
        """First level of the scene."""
        return self.scene.levels[0]

    @property
    def amplitude(self) -> float:
        """Normal amplitude |u_z| of `amplitudes`, m."""
        return self.amplitudes[0]

    @property
    def refusal(self) -> str:
        """Why the stator's motion is not known under a contact; empty where it is."""
        if self.solved is None:
            return ""
        return next((each for position in self.scene.positions if (each := self.solved.at[position].refusal)), "")

    def amplitudes_at(self, level: float) -> Point:
        """Return the amplitudes of the surface under the slider at a level as values of a point."""
        normal, tangential = self.amplitudes
        return Point(normal_amplitude_m=normal * level, tangential_amplitude_m=tangential * level)

    @property
    def levels(self) -> tuple[float, ...]:
        """The scene's levels above 0, rising."""
        return tuple(sorted({level for level in self.scene.levels if level > 0.0}))

    def at(self, level: float):
        """Return the orbits, or the passing wave, at a level."""
        return scaled(self.orbits, level)

    def surface_at(self, level: float):
        """Return the waves of a slider in the plane at a level."""
        from studies.model.plane import Sum

        return Sum(parts=((self.surface, level),))

    def moves(self, level: float) -> bool:
        """Return whether a slider on a passing wave moves at a level."""
        try:
            return contact.steady(self.slider, self.at(level), tolerance=1.0, method="averaged").velocity != 0.0
        except contact.ConvergenceError:
            return False

    def above(self, factor: float) -> tuple[float, ...]:
        """Return the levels above a multiple of the threshold, where the slider starts to move; refuse if none is."""
        if self.passing:  # how much of the wave the slider takes depends on the level
            limit, moving = "", [self.moves(level / factor) for level in self.levels]
        else:
            threshold = factor * contact.threshold_factor(self.slider, self.orbits)
            limit, moving = f", {self.scene.named(threshold)}", [level > threshold for level in self.levels]
        if not any(moving):
            what = "the threshold" if factor == 1.0 else f"{factor:g} times the threshold"
            self.scene.refuse(self.scene.level_key, f"must hold a value above {what}{limit}: nothing moves below")
        return tuple(level for level, own in zip(self.levels, moving, strict=True) if own)

    def spread(self, factor: float, count: int) -> list[float]:
        """Return at most ``count`` of the levels that `above` returns, evenly spaced, the last included."""
        moving = self.above(factor)
        return sorted({moving[round(k * (len(moving) - 1) / count)] for k in range(1, count + 1)})
