"""The contacts that a slider stands on: `balls`, which may be flat punches, or `pillars`.

Either module has the same functions, for a slider whose preload and moduli are numbers unless they say otherwise:

- slider_of(slider): the ``contact.Slider``
- prescribed_motion(slider, wave): the orbits at the contacts, or the passing wave, of a prescribed wave of 1 m
- stator_motion(slider, stator, solved, motion): the same on a solved stator for 1 V, its misfit, and |u_z| and |u_x|
- resolved(slider): a slider with numbers, before the moduli of the pair are known
- check(scene): refuse contacts that stand where they cannot
- places(slider): the outermost contacts in words, each with its x and y on the stator in m
- intervals(slider): the intervals (left, right) of x that the contacts cover, m
- lines(model): what ``sawmotor check`` prints of them after mass, preload and moduli
"""

from importlib import import_module
from typing import Any

from studies.scene.slider_keys import Slider


def contacts_of(slider: Slider) -> Any:
    """Return the module of the contacts that a slider stands on."""
    return import_module(f"studies.model.{slider.stands_on}")
