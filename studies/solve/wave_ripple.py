"""Velocity of a slider on a passing wave over half a wavelength about its position, as `ripple` has it on orbits.

The waves in both directions under the slider are plane ones (`slider_wave`). A displacement d of the slider changes
their phases by k d and -k d, so that the velocity has the period of half a wavelength exactly. It is computed at evenly
spaced displacements, twice as many until the Fourier series through them is complete. The harmonics of a smooth
velocity fall geometrically: those that are left out are estimated by the ratio of the last two pairs, because a pitch
of the pillars near a quarter of a wavelength makes the odd ones small. The misfit of the two waves to the surface
motion is part of the error.
"""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np

import contact
from studies.model.wave_to_contact import Contact
from studies.record.blocks import SummaryBlock
from studies.record.point import Point
from studies.solve.loaded_wave import wave_state
from studies.solve.point_answer import SliderAnswer
from studies.solve.ripple import Ripple

PLACES = (10, 20)  # in half a wavelength
# Ratio of two pairs of harmonics that the estimate takes at least and at most: they fall like powers where the slider
# sticks at some places, or the pillars leave the surface
RATIOS = (0.25, 0.9)
DRAWN = 256  # places of the Fourier series at which its extremes are looked for
# A wave of ratio rho to that from the other side changes the amplitude under each pillar by at most rho to either side
# of its mean; this multiple of rho bounds the range of the velocity, whose sensitivity to the amplitude is 1 to 1.5
# above the threshold
BOUND = 4.0


def wave_ripple(driven: Contact, level: float, velocity: float, tolerance: float) -> tuple[Ripple, float]:
    """Return the ripple at a level, and the reference speed in m/s of its error.

    ``velocity``: at the slider's position, m/s.  Raises contact.ConvergenceError without an answer at a place.
    """
    speeds, near, scale, error = {0.0: velocity}, None, 0.0, 0.0
    for count in PLACES:
        for turn in np.arange(count) / count:  # of half a wavelength
            if turn not in speeds:
                phase = np.exp(-1j * np.pi * turn)
                wave = driven.orbits
                wave = replace(wave, forward=wave.forward * phase, backward=wave.backward / phase)
                near = wave_state(driven, level, near=near, orbits=wave)
                speeds[turn] = near.velocity
                scale = contact.reference_speed(near.velocity, near.orbits)
                error = max(error, near.relative_error)
        values = np.array([speeds[turn] for turn in sorted(speeds)])
        harmonics = np.fft.rfft(values) / count
        left_out = _left_out(abs(harmonics[: (count + 1) // 2]))
        if left_out <= tolerance * scale:
            break
    if values.size % 2 == 0:
        harmonics[-1] *= 0.5
    drawn = np.fft.irfft(harmonics, DRAWN) * DRAWN
    moving = bool(np.all(drawn > 0.0) or np.all(drawn < 0.0))
    ripple = Ripple(
        mean=float(values.mean()), lowest=float(min(drawn.min(), values.min())),
        highest=float(max(drawn.max(), values.max())),
        mean_over_time=float(1.0 / np.mean(1.0 / drawn)) if moving else None, error=left_out + error * scale,
    )  # fmt: skip
    return ripple, scale


def _left_out(sizes: np.ndarray) -> float:
    """Return the sum of the harmonics beyond those of some sizes, if it goes on as a geometric series."""
    last, before = float(sizes[-2:].max()), float(sizes[-4:-2].max())
    ratio = float(np.clip(last / before, *RATIOS)) if before > 0.0 else RATIOS[0]
    return 2.0 * last * ratio / (1.0 - ratio)


def wave_ripple_point(driven: Contact, level: float, point: Point, tolerance: float) -> tuple[Point, float]:
    """Return the ripple as values of a point with an answer, and its range over the reference speed."""
    ripple, reference = wave_ripple(driven, level, point.velocity_m_per_s, tolerance)
    sensitivity = 1.0 if point.amplitude_sensitivity is None else point.amplitude_sensitivity
    from_wave = (driven.stator_error + driven.misfit) * sensitivity
    return ripple.point(reference, from_wave), ripple.range / reference


def mean_velocity(driven: Contact, level: float, velocity: float, tolerance: float) -> float:
    """Return the mean over place in m/s at a level, given that at the slider's position; NaN without an answer."""
    if level == 0.0 or not math.isfinite(velocity):
        return velocity
    try:
        return wave_ripple(driven, level, velocity, tolerance)[0].mean
    except contact.ConvergenceError:
        return math.nan


def with_wave_ripple(answer: SliderAnswer, tolerance: float) -> SliderAnswer:
    """Return the answer of a slider on a passing wave with mean and range of its points, and the ripple in its summary.

    The columns are added if the range exceeds the tolerance at one point or more.
    """
    driven = answer.driven
    wave = driven.orbits
    sizes = sorted((abs(wave.forward), abs(wave.backward)))
    bound = BOUND * sizes[0] / sizes[1] if sizes[1] > 0.0 else 0.0
    answers, found = list(answer.answers), []
    for k, each in enumerate(answer.answers):
        if each.point.answered and each.point.level > 0.0 and bound > tolerance:
            with suppress(contact.ConvergenceError):  # a point without an answer at a place has no ripple
                point, size = wave_ripple_point(driven, each.point.level, each.point, tolerance)
                answers[k] = replace(each, point=each.point | point)
                found.append(size)
    if not found and bound > tolerance:
        return answer
    size = max(found, default=bound)
    quarter, center = 0.25 * wave.wavelength, driven.scene.slider.center[0]
    summary = answer.summary | SummaryBlock(
        velocity_ripple=size, ripple_from_m=center - quarter, ripple_to_m=center + quarter
    )
    return replace(answer, answers=tuple(answers) if size > tolerance else answer.answers, summary=summary)
