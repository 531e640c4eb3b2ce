"""Bands of the velocity, the threshold and the release that follow from the tolerances of a scene's numbers.

linear: half the difference of the answers at the two ends of each tolerance, added in quadrature (GUM, JCGM 100:2008,
eq. 10, with the secant in place of the derivative).  Where the middle does not lie between the ends (the answer bends:
a resonance, the threshold), the band reaches from the middle to the outermost of the answers at the ends and half way
to them, upwards and downwards, each added in quadrature, and the block says so.  sampled, also where the scene names no
method, the answer bends and no number of the stator is uncertain: percentiles over a Latin hypercube of all numbers at
once (`scipy.stats.qmc`), each normally distributed and cut off where it would change its sign.  All are intervals of
95 %.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.stats import norm, qmc, truncnorm

from studies.chain.predictor import Predictor
from studies.chain.solved_stator import of_stator
from studies.record import Record
from studies.scene.keys import LEVELS, tolerances
from studies.scene.uncertain import DEFAULTS, Tolerance

LEVEL = 0.95
DEVIATIONS = float(norm.ppf(0.5 * (1 + LEVEL)))  # standard deviations in a tolerance
LIMITS = ("threshold", "release")
KEYS = tuple(f"{name}_{unit}" for unit in ("amplitude_m", "voltage_V") for name in LIMITS)  # of the summary
# Distance of the middle from the chord between the ends, over the width of the band, up to which the answer is a line:
# it is off by a tenth of the width then
BEND = 0.1


def with_bands(record: Record, *, progress: Callable[[str], None] | None = None) -> Record:
    """Return the record of a scene with [uncertain] with its bands: two more values of each point, one more block."""
    own = {key: value for key, value in record.scene.uncertain or () if key in DEFAULTS}
    options, numbers = DEFAULTS | own, tolerances(record.scene)
    predictor = Predictor.of_record(record, progress=progress)
    # changes of the answers at the upper and the lower end of each tolerance, (numbers, 2, answers)
    middle, *ends = _answers(predictor, record, [{}, *_moved(numbers, (1.0, -1.0))])
    changes = np.reshape(ends, (len(numbers), 2, len(middle))) - middle
    half = 0.5 * np.abs(changes[:, 0] - changes[:, 1])
    centre, width = _centre(record), np.sqrt(np.sum(half**2, axis=0))
    bends = 0.5 * np.abs(changes.sum(axis=1)) > BEND * width
    if "method" not in own and bends.any() and not any(of_stator(each.key) for each in numbers):
        options = options | {"method": "sampled"}  # follows the bend, and costs no stator
    block: dict = {"method": options["method"], "level": LEVEL}
    block |= {"tolerances": {each.key: each.half_width for each in numbers}}
    if options["method"] == "sampled":
        samples = _answers(predictor, record, _sampled(numbers, options["samples"]))
        low, high = np.percentile(samples, [50 * (1 - LEVEL), 50 * (1 + LEVEL)], axis=0)
        block["samples"] = options["samples"]
    else:
        low, high = centre - width, centre + width
        bent = [each for each, row in zip(numbers, bends, strict=True) if row.any()]
        if bent:
            between = _answers(predictor, record, _moved(bent, (0.5, -0.5))) - middle
            tried = dict(zip([each.key for each in numbers], changes, strict=True))
            for each, pair in zip(bent, between.reshape(len(bent), 2, -1), strict=True):
                tried[each.key] = np.concatenate([tried[each.key], pair])
            up = np.sqrt(sum(np.maximum(each.max(axis=0), 0.0) ** 2 for each in tried.values()))
            down = np.sqrt(sum(np.minimum(each.min(axis=0), 0.0) ** 2 for each in tried.values()))
            at = bends.any(axis=0)
            low[at], high[at] = (centre - down)[at], (centre + up)[at]
            block["bent"] = {
                each.key: int(row[: len(record.points)].sum())
                for each, row in zip(numbers, bends, strict=True)
                if row.any()
            }
    top = int(np.argmax([point[record.level] for point in record.points]))
    if np.all(np.isfinite(half[:, top])):
        block["velocity_half_width_m_per_s"] = dict(
            zip(block["tolerances"], half[:, top].tolist(), strict=True)
        )
    for k, key in enumerate(KEYS, start=len(record.points)):
        if key in record.summary and np.isfinite(low[k] + high[k]):
            block[key] = [float(low[k]), float(high[k])]
    points = tuple(
        point | {"velocity_low_m_per_s": float(a), "velocity_high_m_per_s": float(b)}
        if np.isfinite(a + b) else point
        for point, a, b in zip(record.points, low, high, strict=False)
    )  # fmt: skip
    return replace(record, points=points, uncertainty=block)


def velocities_at(
    record: Record, levels: tuple[float, ...], *, progress: Callable[[str], None] | None = None
) -> list[float | None]:
    """Return the steady velocity of a run's motor at some levels (V or m), m/s; None where there is none.

    A level of the run has its own answer; the others are computed on the same solution of the stator.
    """
    known = {point[record.level]: point.get("velocity_m_per_s") for point in record.points}
    missing = [level for level in dict.fromkeys(levels) if level not in known]
    if missing:
        key = "wave.normal_amplitude" if record.scene.wave is not None else "drive.voltage"
        answers = Predictor.of_record(record, progress=progress).answers([{key: level} for level in missing])
        known |= {
            level: answer.get("velocity_m_per_s") for level, answer in zip(missing, answers, strict=True)
        }
    return [known[level] for level in levels]


def _centre(record: Record) -> np.ndarray:
    """Return the run's own answers: velocities, threshold and release as amplitudes, then as voltages."""
    limits = [record.summary.get(key, np.nan) for key in KEYS]
    return np.array([*(point.get("velocity_m_per_s", np.nan) for point in record.points), *limits])


def _moved(numbers, shares: tuple[float, ...]) -> list[dict[str, float]]:
    """Return the changes of one number after the other by shares of its tolerance."""
    return [{each.key: each.value + share * each.half_width} for each in numbers for share in shares]


def _sampled(numbers: tuple[Tolerance, ...], count: int) -> list[dict[str, float]]:
    """Return the samples of a Latin hypercube over the numbers' normal distributions."""
    unit = qmc.LatinHypercube(len(numbers), rng=np.random.default_rng(0)).random(count)
    columns = []
    for each, share in zip(numbers, unit.T, strict=True):
        size = each.half_width / DEVIATIONS
        cut = abs(each.value) / size
        drawn = truncnorm.ppf(share, -cut, cut) if cut else norm.ppf(share)
        columns.append(each.value + size * drawn)
    keys = [each.key for each in numbers]
    return [dict(zip(keys, map(float, row), strict=True)) for row in zip(*columns, strict=True)]


def _answers(predictor: Predictor, record: Record, many: list[dict]) -> np.ndarray:
    """Return what `_centre` does, for each set of changed numbers; NaN where there is no answer."""
    key = "wave.normal_amplitude" if record.scene.wave is not None else "drive.voltage"
    levels = [point[record.level] for point in record.points]
    points, tops, factors = [], [], []
    top = max(levels) or 1.0
    for changed in many:
        # a tolerance of the level is a common factor of all levels, of the power its square
        factor = float(np.prod([changed.get(each, 1.0) for each in LEVELS]))
        factors.append(factor**0.5 if "drive.power" in changed else factor)
        own = {each: value for each, value in changed.items() if each not in LEVELS}
        points += [own | {key: level * factors[-1]} for level in levels]
        tops.append(own | {key: top})
    rows = predictor.answers(points)
    velocities = np.array([row.get("velocity_m_per_s", np.nan) for row in rows]).reshape(
        len(many), len(levels)
    )
    limits = []
    for row, factor in zip(predictor.answers(tops, ("limits",)), factors, strict=True):
        ratios = np.array([row.get(f"{name}_factor", np.nan) for name in LIMITS])
        limits.append([*(ratios * row.get("normal_amplitude_m", np.nan)), *(ratios * top / factor)])
    return np.column_stack([velocities, np.array(limits)])
