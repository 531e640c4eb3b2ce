"""Short summary of a scene, printed by ``sawmotor check``."""

import cmath
import math
from collections.abc import Iterator

from studies.model.contacts_of import contacts_of
from studies.model.model import model_of
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.scene.stator_keys import Stator


def contents(scene: Scene) -> Iterator[tuple[str, list[str]]]:
    """Yield a name and its lines of text for each part of a resolved scene."""
    model = model_of(scene).before_heat
    scene = model.scene
    if scene.stator is not None:
        yield "stator", [section(scene.stator)]
    for each in scene.transducer:
        amplitude = scene.drive.driven.get(each.name)
        driven = f"not driven ({each.termination})" if amplitude is None else "driven"
        if amplitude not in (None, 1):
            driven += f" by {abs(amplitude):g} at {math.degrees(cmath.phase(amplitude)):g} deg"
        kind = each.pattern or ("split fingers" if each.split else each.cell)
        kind += " mirrored" if each.mirrored else ""
        kind += f", chirp {each.chirp:g}" if each.chirp else ""
        pairs = f"{each.finger_pairs} pairs, {kind}, period {each.wavelength * 1e3:.6g} mm"
        yield "transducer", [f"{each.name}: {pairs}, {driven}"]
    for piece in scene.piece:
        positions = ", ".join(f"{position * 1e3:g}" for position in piece.position)
        yield "piece", [f"{piece.label}: its x = 0 at {positions} mm"]
    yield "frequency", [f"{scene.frequency / 1e6:g} MHz"]
    if scene.levels:
        shown = quantity(scene.level_column)
        low, high = (f"{level * shown.scale:g}" for level in (min(scene.levels), max(scene.levels)))
        several = f"{len(scene.levels)} values, {low} to {high}"
        name = "voltage" if scene.wave is None else "amplitude"
        yield name, [f"{several if len(scene.levels) > 1 else high} {shown.shown}"]
    if scene.drive is not None and (powers := scene.drive.available_powers):
        low, high = (si(power, "W") for power in (min(powers), max(powers)))
        yield "power", [f"{high if low == high else f'{low} to {high}'}, what the sources give to matched loads"]
    if scene.slider is not None:
        slider = scene.slider
        moduli = f"E* {slider.effective_modulus / 1e9:.4g} GPa, G* {slider.tangential_modulus / 1e9:.4g} GPa"
        weight = f"{slider.mass * 1e3:g} g, preload {si(slider.preload_force, 'N')}"
        yield "slider", contacts_of(slider).lines(model, weight, moduli)


def section(block: Stator) -> str:
    """Return material, cut, length and thickness of a stator as text."""
    thickness = block.thickness if isinstance(block.thickness, str) else f"{block.thickness * 1e3:g} mm"
    name = block.material if isinstance(block.material, str) else block.material.name
    return f"{name}, {block.orientation}, {block.length * 1e3:g} mm x {thickness}"
