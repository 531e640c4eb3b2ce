"""The contact of any scene with a slider on a moving surface: a given wave, or the wave of a driven stator.

Studies of the contact need the slider and the surface motion under its balls, per unit of the drive.  A given [wave]
states it; a stator is solved for it, at the scene's largest voltage and without a burst.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from studies.chain import bridge
from studies.record import Record
from studies.scene import Scene
from studies.scene.resolved import resolved


@dataclass(frozen=True, kw_only=True)
class DrivenContact:
    """A slider and the surface motion that drives it."""

    scene: Scene  # as resolved
    slider: object = field(repr=False)
    # Under the balls for a level of 1: 1 V of the source, or 1 m of given amplitude
    orbits: tuple = field(repr=False)
    amplitude: float  # normal amplitude |u_z| under the slider's centre for a level of 1, m
    stator_error: float  # relative error of the orbits; 0 for a given wave
    record: Record | None = field(repr=False)  # of the run that solved the stator; None where none was needed

    @classmethod
    def of_run(cls, record: Record) -> "DrivenContact":
        """Return the contact of a run that has a slider."""
        scene = record.scene
        if scene.wave is not None:
            return given_contact(scene, record)
        return cls(
            scene=scene,
            slider=bridge.contact_slider(scene.slider),
            orbits=bridge.orbits_per_volt(record.surface_motion, scene.slider),
            amplitude=abs(complex(record.wave["normal_m_per_V"])),
            stator_error=float(record.wave["relative_error"]),
            record=record,
        )

    @property
    def levels(self) -> tuple[float, ...]:
        """The scene's voltages in V or given amplitudes in m, above 0 and rising."""
        return tuple(sorted({level for level in self.scene.levels if level > 0.0}))

    @property
    def level_key(self) -> str:
        """Key of the levels in a scene."""
        return "wave.normal_amplitude" if self.scene.wave is not None else "drive.voltage"

    def at(self, level: float) -> tuple:
        """Return the orbits at a voltage in V or a given amplitude in m."""
        return bridge.scaled(self.orbits, level)

    def named(self, level: float) -> str:
        """Return a level with its unit."""
        return f"{level * 1e9:.4g} nm" if self.scene.wave is not None else f"{level:.4g} V"

    def above(self, factor: float) -> tuple[float, ...]:
        """Return the levels above a multiple of the threshold, at which the slider starts to move.

        Raises
        ------
        SceneError
            If there is none.
        """
        import contact

        threshold = factor * contact.threshold_factor(self.slider, self.orbits)
        moving = tuple(level for level in self.levels if level > threshold)
        if not moving:
            what = "the threshold" if factor == 1.0 else f"{factor:g} times the threshold"
            self.scene.refuse(
                self.level_key,
                f"must hold a value above {what}, {self.named(threshold)}: nothing moves below",
            )
        return moving

    def spread(self, factor: float, count: int) -> list[float]:
        """Return at most a count of the levels above a multiple of the threshold, evenly chosen, the last included."""
        moving = self.above(factor)
        return sorted({moving[round(k * (len(moving) - 1) / count)] for k in range(1, count + 1)})


def driven_contact(
    scene: str | Scene, *, tolerance: float = 1e-3, progress: Callable[[str], None] | None = None
) -> DrivenContact:
    """Return the contact of a scene with a slider, its stator solved if it has one.

    ``tolerance``: of the slider velocity at the largest voltage; it sets how finely the stator is solved.

    Examples
    --------
    >>> driven_contact("twente-contact").named(1e-8)
    '10 nm'
    """
    chosen = resolved(scene if isinstance(scene, Scene) else Scene.load(scene))
    if chosen.slider is None:
        chosen.refuse("slider", "is missing: this study needs a slider")
    if chosen.wave is not None:
        return given_contact(chosen)
    if not chosen.transducer:
        chosen.refuse("transducer", "is missing: this study needs a driven stator or a given [wave]")
    from studies.chain import run

    drive = replace(chosen.drive, voltage=(max(chosen.levels),), burst=None)
    record = run(replace(chosen, drive=drive, uncertain=None), tolerance=tolerance, progress=progress)
    found = DrivenContact.of_run(record)
    return replace(found, scene=replace(chosen, drive=replace(chosen.drive, frequency=found.scene.frequency)))


def given_contact(scene: Scene, record: Record | None = None) -> DrivenContact:
    """Return the contact of a resolved scene with a given wave."""
    return DrivenContact(
        scene=scene,
        slider=bridge.contact_slider(scene.slider),
        orbits=bridge.given_orbits(scene.wave),
        amplitude=1.0,
        stator_error=0.0,
        record=record,
    )
