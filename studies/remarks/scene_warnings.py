"""Warnings about a scene before any computation: unusual sizes, probable unit errors and overlapping contacts."""

import math
from collections.abc import Iterator
from itertools import combinations

from studies.model.solid_of_material import solid_remarks
from studies.scene import Scene
from studies.scene.pillar_keys import SEED
from studies.scene.slider_keys import Slider

LIFTED = 0.999  # relative to the weight; a preload contains the weight, so that a smaller preload is suspicious
MAX_USUAL_LENGTH = 1.0  # m; a longer stator is probably a unit error
MIN_USUAL_FREQUENCY = 10e3  # Hz, of a prescribed wave; audible ones are probably a unit error
MAX_USUAL_RADIUS = 0.02  # m; limit for the radius of a ball in a scene without a stator
MAX_USUAL_WORK = 5.0  # J/m^2: twice the surface energy of clean metals; of oxides in air 0.02 to 0.1
MAX_USUAL_FRICTION = 1.5  # dry contacts in air; only clean metals in vacuum exceed it
# m/s, surface waves from soft polymers to diamond with a margin; beyond them a unit is wrong
USUAL_VELOCITIES = (200.0, 20e3)
# Radius of the contact area at rest over the wavelength. Above it, the surface under a contact is not flat and not in
# phase, as the contact model assumes.
MAX_CONTACT_SHARE = 0.05
_BALLS = {"sphere": "balls", "punch": "punches"}
MAX_BALLS_COMPARED = 1000  # only the first contacts are checked for overlap, because the cost is quadratic


def scene_warnings(scene: Scene) -> Iterator[str]:
    """Yield the warnings about a scene, each with key, value, unit and advice."""
    stator, slider = scene.stator, scene.slider
    if stator is not None and stator.length > MAX_USUAL_LENGTH:
        yield f"stator.length is {stator.length:g} m: a number without a unit is in m"
    yield from solid_remarks(scene)
    if scene.wave is not None and scene.wave.frequency < MIN_USUAL_FREQUENCY:
        yield (
            f"wave.frequency is {scene.wave.frequency:g} Hz, and the waves of motors have "
            f"{MIN_USUAL_FREQUENCY / 1e3:g} kHz or more: a number without a unit is in Hz"
        )
    yield from _velocities(scene)
    if slider is None:
        return
    yield from _sizes(scene, slider)
    for each in scene.transducer if slider.position is not None else ():
        half = each.half_length if isinstance(each.period, float) and not each.turned else 0.0
        if abs(slider.center[0] - each.center_xy[0]) < half:
            yield f"the slider lies over the fingers of transducer {each.name}: its balls would rub on the metal"
    weight = slider.mass * slider.gravity
    if isinstance(slider.preload, float) and 0.0 < slider.preload < LIFTED * weight:
        yield (
            f"slider.preload, {slider.preload * 1e3:.4g} mN, is less than the weight of the slider's "
            f"{slider.mass * 1e3:.4g} g, {weight * 1e3:.4g} mN, which it includes: something lifts the slider, or a "
            "unit is wrong"
        )
    if isinstance(slider.contacts, int) and slider.contacts > 1:
        yield (
            f"contacts = {slider.contacts} means {slider.contacts} balls at one position, moved by the same wave: "
            'give their offsets along x instead, such as contacts = ["-5 mm", "5 mm"]'
        )


def _velocities(scene: Scene) -> Iterator[str]:
    """Yield a warning for each transducer whose period is not that of a surface wave at the drive's frequency."""
    frequency, (low, high) = getattr(scene.drive, "frequency", None), USUAL_VELOCITIES
    if not isinstance(frequency, float):
        return
    for each in scene.transducer:
        if isinstance(each.period, float) and not low <= (velocity := frequency * each.period) <= high:
            yield (
                f"drive.frequency, {frequency:g} Hz, and the period of transducer {each.name}, {each.period:g} m, mean "
                f"a wave of {velocity:.3g} m/s, and surface waves have {low:g} to {high:g} m/s: a number without a "
                "unit is in Hz or m"
            )


def _pillars(slider: Slider) -> Iterator[str]:
    """Yield warnings about the heights of pillars, and about dampers that do not act on them."""
    block = slider.pillars
    if block.height_scatter > 0.0 and block.seed == SEED:
        yield f"the heights scatter with the seed {block.seed}, the default of slider.pillars.seed"
    if block.seed is not None and not block.height_scatter:
        yield f"slider.pillars.seed = {block.seed} has no effect: slider.pillars.height_scatter is 0 m"
    if slider.damping.normal or slider.damping.contact:
        yield "slider.damping.normal and contact have no effect: the averaged slider on pillars does not bounce"


def _sizes(scene: Scene, slider: Slider) -> Iterator[str]:
    """Yield warnings about an unusual radius, distance, friction coefficient or work of adhesion."""
    if slider.adhesion is not None and (work := slider.adhesion.work or 0.0) > MAX_USUAL_WORK:
        yield f"slider.adhesion.work is {work:g} J/m^2: solids have 0.01 to {MAX_USUAL_WORK:g}"
    if slider.static_coefficient > MAX_USUAL_FRICTION:
        yield (
            f"slider.friction_coefficient is {slider.static_coefficient:g}: dry contacts have 0.05 to "
            f"{MAX_USUAL_FRICTION:g}"
        )
    if slider.pillars is not None:
        yield from _pillars(slider)
        return
    diameter, stator, balls = 2 * slider.radius, scene.stator, _BALLS[slider.shape]
    if stator is None:
        if slider.radius > MAX_USUAL_RADIUS:
            yield f"slider.radius is {slider.radius:g} m, {balls} of {diameter:g} m: a number without a unit is in m"
    elif diameter > (across := min(stator.length, stator.width or math.inf)):
        yield (
            f"slider.radius = {slider.radius:g} m means {balls} of {diameter:g} m on a stator whose surface is "
            f"{across:g} m across: a number without a unit is in m"
        )
    waves = [each.period for each in scene.transducer if isinstance(each.period, float)]
    if waves and (area := _area_radius(slider)) > MAX_CONTACT_SHARE * min(waves):
        yield (
            f"the area of contact has a radius of {area * 1e6:.3g} um at rest, {area / min(waves):.2g} wavelengths: "
            "the model takes the surface under a contact as flat and in phase: a smaller slider.radius, or less "
            "preload"
        )
    distance, first, second = _nearest(slider)
    if distance < diameter * (1 - 1e-12):
        yield (
            f"{balls} of {diameter * 1e3:g} mm overlap: slider.contacts {first + 1} and {second + 1} are "
            f"{distance * 1e3:.4g} mm apart: a smaller slider.radius, or positions further apart"
        )


def _area_radius(slider: Slider) -> float:
    """Return the radius of the contact area at rest in m, of a ball by Hertz; all contacts carry the same force."""
    if slider.shape == "punch":
        return slider.radius
    if slider.effective_modulus is None:
        return 0.0
    force = slider.preload_force / len(slider.offsets)
    return (0.75 * force * slider.radius / slider.effective_modulus) ** (1 / 3)


def _nearest(slider: Slider) -> tuple[float, int, int]:
    """Return the smallest distance between two contacts in m (inf if only their number is stated) and their indices."""
    if isinstance(slider.contacts, int):
        return math.inf, 0, 0
    offsets = slider.offsets[:MAX_BALLS_COMPARED]
    pairs = ((math.dist(p, q), i, j) for (i, p), (j, q) in combinations(enumerate(offsets), 2))
    return min(pairs, default=(math.inf, 0, 0))
