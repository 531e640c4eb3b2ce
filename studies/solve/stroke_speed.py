"""Mean velocity of a slider over its stroke: the range of its centre between transducers, meshed pieces and ends.

The stroke is divided into half wavelengths, whose mean velocities over place (`ripple`) are averaged. Each place has
the steady velocity of a slider that stays there.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from studies.model.free_way import free_way
from studies.model.model import Model
from studies.model.wave_to_contact import Contact
from studies.solve.ripple import Known, NearbyContact, Ripple, ripples
from studies.solve.solved_stator import SolvedStator
from studies.solve.surface_motion import SurfaceMotion

# Half wavelengths of a stroke in which the velocity is computed; over a longer one they are spread evenly. With 60 the
# mean of `twente` is 0.3 % from that of all 243, and takes 3 CPU seconds
MAX_PARTS = 60
CLEAR = 0.5  # wavelengths from the fingers within which no place is taken: the field beside them is less accurate


@dataclass(frozen=True, kw_only=True)
class StrokeSpeed:
    """Steady velocity over a stroke, m/s along +x; ``ripple`` has its mean and range over place."""

    stroke: tuple[float, float]  # ends of the slider's centre, m
    ripple: Ripple
    missing: float  # share of the half wavelengths that has no answer and that the mean leaves out


def slider_range(model: Model, clear: float = 0.0) -> tuple[float, float]:
    """Return the range of the slider's centre in m in which all its contacts stay on the free surface about it.

    ``clear``: least distance from the fingers, m.
    """
    way, center = free_way(model, clear), model.scene.slider.center[0]
    return center + way.low, center + way.high


def stroke_speed(
    driven: Contact, motion: SurfaceMotion, level: float, known: Known, tolerance: float
) -> StrokeSpeed | None:
    """Return the velocity over the stroke of a slider on balls at a level; None if no part of it has an answer.

    ``known``: the motion at the slider's position, as for `ripple.ripples`.
    """
    model, slider = driven.model, driven.scene.slider
    wavelength = abs(motion.wave.phase_velocity) / motion.wave.frequency
    (low, high), (x, y) = slider_range(model, CLEAR * wavelength), slider.center
    low, high = min(low, x), max(high, x)  # a slider that stands nearer to the fingers
    needed = max(1, math.ceil(2.0 * (high - low) / wavelength))
    parts = min(needed, MAX_PARTS)
    found = []
    for x in low + (high - low) * (np.arange(parts) + 0.5) / parts:
        here = model.with_blocks(slider=replace(slider, position=(float(x), y)))
        solved = SolvedStator.of(motion, here.scene.positions, nearby=True)
        nearby = NearbyContact.of(Contact.of_stator(here, solved), tolerance)
        found.append(None if nearby is None else ripples(nearby, {level: known}).get(level))
    answers = [each for each in found if each is not None]
    if not answers:
        return None
    means = np.array([each.mean for each in answers])
    sampling = 0.0 if parts == needed else abs(means[::2].mean() - means[1::2].mean()) / 2.0
    times = [each.mean_over_time for each in answers if each.mean_over_time is not None]
    whole = Ripple(
        mean=float(means.mean()), lowest=min(each.lowest for each in answers),
        highest=max(each.highest for each in answers),
        mean_over_time=float(1.0 / np.mean(1.0 / np.array(times))) if len(times) == len(answers) else None,
        error=float(max(each.error for each in answers) + sampling),
    )  # fmt: skip
    return StrokeSpeed(stroke=slider_range(model), ripple=whole, missing=(parts - len(answers)) / parts)
