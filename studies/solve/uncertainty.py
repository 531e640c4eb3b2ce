"""Uncertainty intervals (95 %) of the velocity, the threshold and the release, from the tolerances of a scene.

There are two methods:

- ``linear``: half of the difference between the answers at the two ends of each tolerance, added in quadrature (GUM,
  JCGM 100:2008, eq. 10, with the secant instead of the derivative). An answer can be strongly nonlinear within a
  tolerance, for example at a resonance or at the threshold. Its interval then uses the largest upward and downward
  changes among the answers at the ends and half way to them, each added in quadrature. The key ``bent`` of the block
  lists these tolerances, each with the number of points whose velocity is nonlinear.
- ``sampled``: percentiles over a Latin hypercube of all uncertain numbers (`scipy.stats.qmc`). Each number is normally
  distributed, truncated so that it keeps its sign.

If the scene names no method, ``sampled`` is used for a nonlinear answer without an uncertain number of the stator,
because the samples then need no further solution of the stator. Otherwise ``linear`` is used.

A preload of "weight" follows an uncertain mass or gravity, as in runs of the changed scene; a tolerance of the preload
then adds to the weight. Uncertain positions are evaluated on one solution of the stator.
"""

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import norm, qmc, truncnorm

from studies.model.model import changes_stator
from studies.record import Record
from studies.record.blocks import UncertaintyBlock
from studies.record.point import Point
from studies.record.values import as_array
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.keys import LEVELS, tolerances
from studies.scene.uncertain import DEFAULTS, Tolerance
from studies.solve.predictor import Predictor

LEVEL = 0.95
DEVIATIONS = float(norm.ppf(0.5 * (1 + LEVEL)))  # a tolerance in standard deviations
LIMITS = ("threshold", "release")
# keys of the summary
KEYS = tuple(f"{name}_{unit}" for unit in ("amplitude_m", "voltage_V") for name in LIMITS)
# Largest nonlinearity for which an answer counts as linear: the distance of the nominal answer from the chord between
# the answers at the ends, over the half-width of the interval. The error of the interval is then a tenth of its width.
BEND = 0.1
MAX_POSITIONS = 4096  # at which one solution of the stator is evaluated


def with_bands(record: Record, written: Scene | Any) -> Record:
    """Return the record of a scene with [uncertain], with intervals at its points and the block ``uncertainty``.

    ``written``: the scene of the record before its automatic values became numbers.
    """
    settings = {key: value for key, value in record.scene.uncertain or () if key in DEFAULTS}
    options, numbers = DEFAULTS | settings, tolerances(record.scene)
    answers, in_one = _Answers(record, written), options["method"] == "sampled"
    answers.share_positions(
        [{}, *_moved(numbers, (1.0, -1.0, 0.5, -0.5)), *(sampled(numbers, options["samples"]) if in_one else ())]
    )
    # changes of the answers at the upper and the lower end of each tolerance, shape (numbers, 2, answers)
    middle, *ends = answers([{}, *_moved(numbers, (1.0, -1.0))])
    changes = np.reshape(ends, (len(numbers), 2, len(middle))) - middle
    half = 0.5 * np.abs(changes[:, 0] - changes[:, 1])
    centre, width = _centre(record), np.sqrt(np.sum(half**2, axis=0))
    bends = 0.5 * np.abs(changes.sum(axis=1)) > BEND * width
    if "method" not in settings and bends.any() and not any(changes_stator(each.key) for each in numbers):
        # represents the nonlinearity without solving the stator again
        options = options | {"method": "sampled"}
    block: dict = {"method": options["method"], "level": LEVEL}
    block["tolerances"] = {each.key: each.half_width for each in numbers}
    if options["method"] == "sampled":
        sets = sampled(numbers, options["samples"])
        answers.share_positions(sets)
        samples = answers(sets)
        low, high = np.percentile(samples, [50 * (1 - LEVEL), 50 * (1 + LEVEL)], axis=0)
        block["samples"] = options["samples"]
    else:
        low, high = centre - width, centre + width
        bent = np.flatnonzero(bends.any(axis=1))
        if bent.size:
            halfway = answers(_moved([numbers[k] for k in bent], (0.5, -0.5))) - middle
            # the changes at the ends are repeated for the other numbers, so that largest and smallest are unchanged
            trial_changes = np.concatenate([changes, changes], axis=1)
            trial_changes[bent, 2:] = halfway.reshape(bent.size, 2, -1)
            upward = np.sqrt(np.sum(np.maximum(trial_changes.max(axis=1), 0.0) ** 2, axis=0))
            downward = np.sqrt(np.sum(np.minimum(trial_changes.min(axis=1), 0.0) ** 2, axis=0))
            nonlinear = bends.any(axis=0)
            low[nonlinear], high[nonlinear] = (centre - downward)[nonlinear], (centre + upward)[nonlinear]
            block["bent"] = {numbers[k].key: int(bends[k, : len(record.points)].sum()) for k in bent}
    top = int(np.argmax([point.level for point in record.points]))
    if np.all(np.isfinite(half[:, top])):
        block["velocity_half_width_m_per_s"] = dict(zip(block["tolerances"], half[:, top].tolist(), strict=True))
    for k, key in enumerate(KEYS, start=len(record.points)):
        if key in record.summary and np.isfinite(low[k] + high[k]):
            block[key] = [float(low[k]), float(high[k])]
    points = tuple(
        point | (Point(velocity_low_m_per_s=float(a), velocity_high_m_per_s=float(b)) if np.isfinite(a + b) else {})
        for point, a, b in zip(record.points, low, high, strict=False)
    )
    scene = record.scene
    if scene.slider is not None:  # so that the stored scene runs to the same intervals
        scene = replace(scene, slider=replace(scene.slider, preload=written.slider.preload))
    return replace(record, scene=scene, points=points, uncertainty=UncertaintyBlock(**block))


def _centre(record: Record) -> np.ndarray:
    """Return the answers of the run: velocities, then threshold and release as amplitudes and as voltages."""
    return np.array([*record.velocity, *as_array(record.summary.get(key) for key in KEYS)])


def _moved(numbers, fractions: tuple[float, ...]) -> list[dict[str, float]]:
    """Return the changes of one number at a time by fractions of its tolerance."""
    return [{each.key: each.value + fraction * each.half_width} for each in numbers for fraction in fractions]


def sampled(numbers: tuple[Tolerance, ...], count: int) -> list[dict[str, float]]:
    """Return sets of values by key: a Latin hypercube over the normal distributions, none of which changes its sign."""
    unit = qmc.LatinHypercube(len(numbers), rng=np.random.default_rng(0)).random(count)
    columns = []
    for each, share in zip(numbers, unit.T, strict=True):
        deviation = each.half_width / DEVIATIONS
        truncation = abs(each.value) / deviation
        deviations = truncnorm.ppf(share, -truncation, truncation) if truncation else norm.ppf(share)
        columns.append(each.value + deviation * deviations)
    keys = [each.key for each in numbers]
    return [dict(zip(keys, map(float, sample), strict=True)) for sample in zip(*columns, strict=True)]


def without_level(changed: dict[str, float]) -> tuple[float, dict[str, float]]:
    """Return the factor on all levels in a set of changed numbers, and the other numbers.

    A tolerance of the level multiplies all levels; one of the power multiplies their squares.
    """
    factor = float(np.prod([changed.get(each, 1.0) for each in LEVELS]))
    others = {key: value for key, value in changed.items() if key not in LEVELS}
    return factor**0.5 if "drive.power" in changed else factor, others


class _Answers:
    """The answers of a run's scene for sets of changed numbers.

    ``written``: the scene before its automatic values became numbers.
    """

    def __init__(self, record: Record, written: Scene) -> None:
        self.record, self.predictor = record, Predictor.of_record(record, written)
        self.weighed = record.scene.slider is not None and written.slider.preload == "weight"

    def __call__(self, changes: list[dict]) -> np.ndarray:
        """Return the answers in the order of `_centre` for each set of changed numbers; NaN for missing answers."""
        key, levels = self.record.scene.level_key, [point.level for point in self.record.points]
        points, tops, factors = [], [], []
        top = max(levels) or 1.0
        for changed in changes:
            factor, other_changes = without_level(self._with_weight(changed))
            factors.append(factor)
            points += [other_changes | {key: level * factor} for level in levels]
            tops.append(other_changes | {key: top})
        answers = self.predictor.answers(points, quick=True)
        velocities = as_array(each.point.velocity_m_per_s for each in answers)
        limits = []
        for answer, factor in zip(self.predictor.answers(tops, ("limits",), quick=True), factors, strict=True):
            point = answer.point
            *ratios, amplitude = as_array([point.threshold_factor, point.release_factor, point.normal_amplitude_m])
            limits.append([*(np.array(ratios) * amplitude), *(np.array(ratios) * top / factor)])
        return np.column_stack([np.reshape(velocities, (len(changes), len(levels))), np.array(limits)])

    def _with_weight(self, changed: dict[str, float]) -> dict[str, float]:
        """Return a set of changed numbers in which a changed preload adds to the weight of a changed mass."""
        weighed = [f"slider.{name}" for name in ("mass", "gravity")]
        if not (self.weighed and "slider.preload" in changed and any(key in changed for key in weighed)):
            return changed
        slider = self.record.scene.slider
        mass, gravity = (changed.get(key, getattr(slider, key.partition(".")[2])) for key in weighed)
        return changed | {"slider.preload": changed["slider.preload"] + mass * gravity - slider.mass * slider.gravity}

    def share_positions(self, changes: list[dict]) -> None:
        """Let one solution of the stator serve the positions of all sets of numbers, unless these change the stator."""
        positions: dict = {}
        if self.record.surface_motion is None or any(changes_stator(key) for each in changes for key in each):
            return
        for changed in changes:
            with suppress(SceneError):  # refused again where it is answered
                positions |= dict.fromkeys(self.predictor.scene(without_level(changed)[1]).positions)
        new = not set(positions) <= {*self.record.scene.positions, *self.predictor.stators.positions}
        if new and len(positions) <= MAX_POSITIONS:
            self.predictor.stators.positions = tuple(positions)
