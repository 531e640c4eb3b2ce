"""From the roughness of a scene's balls to their mean field, or to samples of asperities.

Without ``seed`` and ``file`` the balls are the mean field of many asperities (`contact.MeanField`). The tangential law,
unless the scene says another, is the memory of Mindlin and Deresiewicz in the normal force of the whole ball
(`contact.RoughBalls`). A scene whose balls touch with fewer than `FEWEST` asperities is refused, for no two of such
balls are alike.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

import contact
from studies.lab.afm_patch import AfmPatch, read_patch
from studies.model.scene_errors import as_run_errors, slider_keys
from studies.refusal import SceneError, refuses
from studies.scene.roughness_keys import Roughness
from studies.scene.slider_keys import Slider

MOST = 20_000  # asperities drawn for a ball; of these at most 2500 may touch (`contact.Asperities`)
FEWEST = 10.0  # asperities in contact below which the mean field is not that of one ball
SAMPLES = 8  # balls, or places on a patch, whose velocities are the scatter of an answer
STEP = 1.5  # largest amplitudes go by steps of this factor, so that neighbouring scenes share their tables
DEPTH = 3.0  # approach of a tabulated force over that of smooth balls at rest and the roughness, beside the wave
STRIDE = 10_000  # between the seeds of the samples; balls of one slider have seeds one after another


def roughness_of(block: Roughness) -> contact.Roughness:
    """Return the `contact.Roughness` of a block without a file."""
    given = {} if block.asperity_radius is None else {"asperity_radius": block.asperity_radius}
    with slider_keys():
        return contact.Roughness(rms=block.rms, density=block.density, **given)


@lru_cache(64)  # of a sweep's points many have the same
def _field(radius: float, modulus: float, block: Roughness) -> contact.MeanField:
    return contact.MeanField(radius, modulus, roughness_of(block))


@refuses(SceneError)
def check_roughness(slider: Slider) -> Iterator[Any]:
    """Refuse roughness beyond sense, a mean field of few asperities, and a file that cannot be read.

    Preload and moduli are numbers.
    """
    block = slider.roughness
    if block is None:
        return
    for key, value in (("preload", slider.preload_force), ("friction_coefficient", slider.static_coefficient)):
        if value <= 0.0:
            yield f"slider.{key}", "must be positive with slider.roughness: without it no wave moves the slider"
            return
    radius = f"at most the ball's radius of {slider.radius:.4g} m"
    if block.asperity_radius is not None and block.asperity_radius > slider.radius:
        yield "slider.roughness.asperity_radius", f"must be {radius}, got {block.asperity_radius:.4g} m"
        return
    if realised_rms(block) > slider.radius:
        given = f"{realised_rms(block):.4g} m" + (f" in {patch_of(block).name}" if block.file else "")
        key = "rms" if block.file is None else "file"
        yield f"slider.roughness.{key}", f"must have heights with an rms of {radius}, got {given}"
        return
    if block.sampled:
        yield from _crowd(slider, 0.0)
        return
    carrying = touching(slider)
    if carrying < FEWEST:
        carry = f"{carrying:.0f} asperities carry" if carrying >= 1.5 else "one asperity or none carries"
        given = f"{block.rms * 1e9:.3g} nm" if block.density is None else f"{block.density:.3g} 1/m^2"
        rule = f"of {given}: {carry} a ball: the mean field does not apply"
        key = "rms" if block.density is None else "density"
        yield f"slider.roughness.{key}", f"{rule}; give a seed, the answer is that of one ball"


@lru_cache(1000)  # of a sweep's points many have the same
def touching(slider: Slider) -> float:
    """Return the asperities of the mean field that carry one ball at rest."""
    block, balls = slider.roughness, len(slider.offsets)
    smooth = contact_body(slider).rest_approach(balls)
    field = _field(slider.radius, slider.effective_modulus, block)
    within = field.roughness.density * math.pi * field.reach(smooth) ** 2
    if within < FEWEST:  # the rough ball's mean plane lies hardly deeper than the smooth one's
        return within
    with as_run_errors(f"slider.roughness with an rms of {block.rms * 1e9:.3g} nm:"):
        return field.under(slider.preload_force / balls).touching


def drawn_asperities(slider: Slider, amplitude: float) -> float:
    """Return about how many asperities a sample has within reach on a wave of an amplitude in m."""
    block = slider.roughness
    if block.file is None:
        density = roughness_of(block).density
    else:
        patch = patch_of(block)
        density = patch.peaks().shape[1] / math.prod(patch.size)
    return density * math.pi * reach_of(slider, amplitude) ** 2


def _crowd(slider: Slider, amplitude: float) -> Iterator[Any]:
    """Yield a refusal of samples of more than `MOST` asperities within reach on a wave of an amplitude in m."""
    number = drawn_asperities(slider, amplitude)
    if number > MOST:
        key = "seed" if slider.roughness.file is None else "file"
        yield f"slider.roughness.{key}", f"must draw at most {MOST} asperities for a ball, got about {number:.2g}"


@lru_cache(8)
def patch_of(block: Roughness) -> AfmPatch:
    """Return the patch of a block's file."""
    return read_patch(str(block.file), block.step)


def realised_rms(block: Roughness) -> float:
    """Return the standard deviation of the heights in m: the given one, or that of the levelled patch."""
    return block.rms if block.file is None else patch_of(block).rms


def reach_of(slider: Slider, amplitude: float) -> float:
    """Return the distance from a ball's middle in m up to which asperities may touch on a wave of an amplitude in m."""
    rms = realised_rms(slider.roughness)
    rest = contact_body(slider).rest_approach(len(slider.offsets))
    return math.sqrt(2.0 * slider.radius * (2.0 * amplitude + rest + 8.0 * rms))


@lru_cache(16)
def contact_body(slider: Slider) -> contact.Slider:
    """Return the smooth slider on all its balls, with the tangential law that its rough balls take."""
    return contact.Slider(
        radius=slider.radius, mass=slider.mass, preload=slider.preload_force, load=slider.load,
        friction_coefficient=slider.static_coefficient, effective_modulus=slider.effective_modulus,
        tangential_modulus=slider.tangential_modulus, law=slider.tangential_law, reciprocal=False, stick_band=0.0,
        contact_damping=slider.damping.contact, normal_damping=slider.damping.normal,
        tangential_damping=slider.damping.tangential,
    )  # fmt: skip


@lru_cache(4)
def rough_balls(slider: Slider, amplitude: float) -> tuple[contact.RoughBalls, ...]:
    """Return the slider on the mean field of its balls, or on its own sample and further ones, `SAMPLES` in all.

    ``amplitude``: largest of the waves, m. Of a mean field, balls that move alike are one of ``slider.share`` equal
    parts; samples have every ball.
    """
    block, body = slider.roughness, contact_body(slider)
    if not block.sampled:
        parts = ("mass", "preload", "load", "normal_damping", "tangential_damping")
        part = replace(body, **{name: getattr(body, name) / slider.share for name in parts})
        field = _field(slider.radius, slider.effective_modulus, block)
        return (contact.RoughBalls(part, (field,) * slider.computed_contacts, amplitude),)
    refuses(SceneError)(_crowd)(slider, amplitude)
    first, balls, reach = block.seed or 0, range(len(slider.offsets)), reach_of(slider, amplitude)
    return tuple(
        contact.RoughBalls(body, [_sample(block, first + STRIDE * k + ball, reach) for ball in balls], amplitude)
        for k in range(SAMPLES)
    )


def limits_of(
    slider: Slider, orbits: tuple, amplitude: float, speed: float, *, tolerance: float, count: int | None = None
) -> list[tuple[float, float]]:
    """Return threshold and release of the first of `rough_balls`, or of all, as levels on orbits for a level of 1.

    The threshold is the level at which the slider runs at a ``speed`` in m/s. The search starts with balls for waves of
    an ``amplitude`` in m, and again with a larger one until their asperities reach as far as the limits.

    Parameters
    ----------
    count : int, optional
        1 for the first of the balls alone.
    """
    orbits, size = orbits_of_each(slider, orbits), max(abs(each.normal) for each in orbits)
    while True:
        largest = amplitude / size
        waves = tuple(each.scaled(largest) for each in orbits)
        found = [
            (largest * balls.threshold(waves, speed, tolerance=tolerance), largest * balls.release(waves))
            for balls in rough_balls(slider, amplitude)[:count]
        ]
        furthest = size * float(np.max(found))
        if furthest <= amplitude or not math.isfinite(furthest):
            return found
        amplitude = furthest


@lru_cache(16)
def ball_force(slider: Slider, amplitude: float) -> contact.TabulatedForce:
    """Return the normal force of one ball as a law: of the mean field, or of the mean of the balls' samples.

    ``amplitude``: largest of the waves, m.
    """
    with slider_keys(), as_run_errors("slider.roughness:"):
        if not slider.roughness.sampled:
            return _field(slider.radius, slider.effective_modulus, slider.roughness).tabulated()
        (own, *_), balls, rms = rough_balls(slider, amplitude), len(slider.offsets), realised_rms(slider.roughness)
        deepest = 2.0 * amplitude + DEPTH * (contact_body(slider).rest_approach(balls) + rms)
        return contact.sample_force(
            own.samples, slider.radius, slider.effective_modulus, share=slider.preload_force / balls, deepest=deepest
        )


def largest_amplitude(levels: tuple, orbits: tuple) -> float:
    """Return the amplitude in m for which balls are made, at least the largest of the levels of orbits."""
    largest = max(levels) * max(abs(each.normal) for each in orbits)
    return STEP ** math.ceil(math.log(max(largest, 1e-12), STEP))


def orbits_of_each(slider: Slider, orbits: tuple) -> tuple:
    """Return the orbit of each ball of `rough_balls`; a mere number of balls moves alike."""
    return tuple(orbits) * (slider.share if slider.roughness.sampled else 1)


def _sample(block: Roughness, seed: int, reach: float) -> contact.Asperities:
    if block.file is None:
        return roughness_of(block).drawn(seed, reach)
    patch = patch_of(block)
    # the first ball of a scene without a seed stands on the middle of the patch
    places = np.random.default_rng(seed).uniform(-0.5, 0.5, 2) * patch.size if seed else (0.0, 0.0)
    return patch.asperities(reach, shift=(float(places[0]), float(places[1])))
