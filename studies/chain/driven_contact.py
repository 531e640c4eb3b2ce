"""The contact of any scene with a slider on a moving surface: a given wave, or the wave of a driven stator.

Studies of the contact need the slider and the surface motion under its balls, per unit of the drive.  A given [wave]
states it; a stator is solved for it, at the scene's largest voltage and without a burst.
"""

from collections.abc import Callable
from dataclasses import replace

from studies.chain import run
from studies.chain.bridge import DrivenContact
from studies.scene import Scene
from studies.scene.resolved import resolved

__all__ = ["DrivenContact", "driven_contact"]


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
        return DrivenContact.given(chosen)
    if not chosen.transducer:
        chosen.refuse("transducer", "is missing: this study needs a driven stator or a given [wave]")
    drive = replace(chosen.drive, voltage=(max(chosen.levels),), burst=None)
    record = run(replace(chosen, drive=drive, uncertain=None), tolerance=tolerance, progress=progress)
    found = DrivenContact.of_run(record)
    return replace(found, scene=replace(chosen, drive=replace(chosen.drive, frequency=found.scene.frequency)))
