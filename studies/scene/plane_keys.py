"""Keys of a slider that moves in the plane, and of the several waves that drive it.

x and y lie in the surface, yaw is positive from x towards y. A load, a torque and a slope act against positive motion.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.scene.block import Block
from studies.scene.numbers import FixedList, Quantity

AXLE = "axle"  # the freedom of a slider with an axis
FREEDOMS = ("x", "xy", "xy yaw", AXLE)
VECTOR = FixedList((Quantity("N", negative=True),) * 2, "[F_x, F_y] in N")
SLOPES = FixedList((Quantity("deg", above=-90.0, below=90.0),) * 2, "[along x, along y] in deg")
ON_A_LINE = 1e-9  # of the square of the contacts' spread: twice the area of their triangles, up to rounding
ONLY_IN_PLANE = ("inertia", "torque", "incline")
TURNING = 'choose slider.freedom = "xy yaw"'

Refused = Iterator[tuple[str, str]]


@dataclass(frozen=True, kw_only=True)
class WaveSource(Block):
    """One of several prescribed waves; an absent key is that of [wave]."""

    block: ClassVar[str] = "wave.sources"
    normal_amplitude: Annotated[
        float | None,
        Quantity("m"),
        "Peak of u_z. Only its ratio to that of the first source counts, whose levels are wave.normal_amplitude; in all"
        " sources or in none.",
    ] = None
    tangential_ratio: Annotated[float | None, Quantity(), "Amplitude ratio of the motion along direction over u_z."] = (
        None
    )
    direction: Annotated[
        float, Quantity("deg", negative=True), "Direction from x towards y in which the crests move the slider."
    ] = 0.0
    phase: Annotated[float, Quantity("deg", negative=True), "Phase by which the wave is ahead, at the centre."] = 0.0
    frequency: Annotated[float | None, Quantity("Hz"), "Frequency of this wave."] = None


def check_slider(slider: Any) -> Refused:
    """Yield the keys of a slider that do not go with its freedom, and their rules."""
    if not slider.planar:
        for key in ONLY_IN_PLANE:
            if getattr(slider, key) not in (None, 0.0):
                freer = _freer() if key == "incline" else f"{TURNING}, or give slider.axis"
                yield key, f"must be absent where the slider moves along x: {freer}"
        if isinstance(slider.load, tuple):
            yield "load", f"must be a number where the slider moves along x, got a vector: {_freer()}"
        return
    if slider.axis is not None and slider.freedom != AXLE:
        yield "freedom", "must be absent with slider.axis: the slider turns about its axle"
    if slider.axis is None and slider.freedom == AXLE:
        yield "axis", "is required and missing: the place of the axle, [x, y] from the slider's centre in m"
    if slider.freedom == AXLE and slider.opposes:
        yield "load", "must be [F_x, F_y] or absent with slider.axis, whose axle carries it: give slider.torque"
    if slider.travel is not None:
        yield "travel", "must be absent in the plane: a burst follows the slider there"
    if slider.pillars is not None:
        yield "pillars", 'must be absent with a slider that moves in the plane: choose slider.freedom = "x"'
    else:
        yield from _places(slider)
    if not slider.turns:
        for key in ("inertia", "torque"):
            if getattr(slider, key) not in (None, 0.0):
                yield key, f"must be absent where the slider does not turn: {TURNING}"


def _freer() -> str:
    return 'choose slider.freedom = "xy"'


def _places(slider: Any) -> Refused:
    """Yield what the positions of the contacts do not allow: yaw of one ball, or tilts that three do not fix."""
    places = set(slider.offsets)
    if slider.freedom == AXLE:
        if places == {slider.axis}:
            yield "axis", "needs a contact away from the axle: one on it turns nothing"
    elif slider.turns and len(places) < 2:
        yield "freedom", "needs two contacts apart: one ball has no yaw stiffness"
    if slider.tilt == "free" and _on_a_line(list(places)):
        yield "tilt", 'must be "held": balls on a line do not fix the tilt; hold it with slider.tilt = "held"'


def _on_a_line(places: list[tuple[float, float]]) -> bool:
    (x, y), *others = places
    if not others:
        return True
    far = max(others, key=lambda each: math.hypot(each[0] - x, each[1] - y))
    along, across = far[0] - x, far[1] - y
    areas = (abs(along * (b - y) - across * (a - x)) for a, b in others)
    return max(areas) <= ON_A_LINE * (along**2 + across**2)


def check_scene(scene: Any) -> Refused:
    """Yield what needs a slider that moves in the plane: several prescribed waves, and sources at own frequencies."""
    planar = scene.slider is not None and scene.slider.planar
    if scene.wave is not None and scene.wave.sources and not planar:
        yield "wave.sources", f"needs a slider in the plane: {_freer()}"
    if scene.drive is not None and scene.drive.source_frequencies and not planar:
        yield "drive.source_frequencies", f"must be absent where nothing moves in the plane: {_freer()}"
