"""What the tolerances of a scene's numbers make of its answer: bands of the velocity, the threshold and the release.

linear: half the difference of the answers at the two ends of each tolerance, added in quadrature (GUM, JCGM 100:2008,
eq. 10, with the secant in place of the derivative).  sampled: percentiles over a Latin hypercube of all numbers at once
(`scipy.stats.qmc`), each normally distributed and cut off where it would change its sign.  Both are intervals of 95 %.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.stats import norm, qmc, truncnorm

from studies.inverse.prediction import MeasurementPredictor, steady_velocities
from studies.record import Record
from studies.scene.keys import LEVELS, tolerances
from studies.scene.uncertain import DEFAULTS

LEVEL = 0.95
DEVIATIONS = float(norm.ppf(0.5 * (1 + LEVEL)))  # standard deviations in a tolerance
LIMITS = ("threshold", "release")
KEYS = tuple(f"{name}_{unit}" for unit in ("amplitude_m", "voltage_V") for name in LIMITS)  # of the summary


def with_bands(record: Record, *, progress: Callable[[str], None] | None = None) -> Record:
    """Return the record of a scene with [uncertain] with its bands: two more values of each point, one more block."""
    options = DEFAULTS | {key: value for key, value in record.scene.uncertain if key in DEFAULTS}
    numbers = tolerances(record.scene)
    predictor = MeasurementPredictor(
        replace(record.scene, uncertain=None), tolerance=record.tolerance, progress=progress
    )
    predictor.take(record)
    ends = [{each.key: each.value + sign * each.half_width} for each in numbers for sign in (1.0, -1.0)]
    answers = _answers(predictor, record, ends)
    half = 0.5 * np.abs(answers[0::2] - answers[1::2])
    centre = _centre(record)
    if options["method"] == "linear":
        width = np.sqrt(np.sum(half**2, axis=0))
        low, high = centre - width, centre + width
    else:
        samples = _answers(predictor, record, _sampled(numbers, options["samples"]))
        low, high = np.percentile(samples, [50 * (1 - LEVEL), 50 * (1 + LEVEL)], axis=0)
    count = len(record.points)
    block = {"method": options["method"], "level": LEVEL}
    block |= {"tolerances": {each.key: each.half_width for each in numbers}}
    if options["method"] == "sampled":
        block["samples"] = options["samples"]
    top = int(np.argmax([point[record.level] for point in record.points]))
    if np.all(np.isfinite(half[:, top])):
        block["velocity_half_width_m_per_s"] = dict(
            zip(block["tolerances"], half[:, top].tolist(), strict=True)
        )
    for k, key in enumerate(KEYS, start=count):
        if key in record.summary and np.isfinite(low[k] + high[k]):
            block[key] = [float(low[k]), float(high[k])]
    points = tuple(
        point | {"velocity_low_m_per_s": float(a), "velocity_high_m_per_s": float(b)}
        if np.isfinite(a + b) else point
        for point, a, b in zip(record.points, low, high, strict=False)
    )  # fmt: skip
    return replace(record, points=points, uncertainty=block)


def _centre(record: Record) -> np.ndarray:
    """Return the run's own answers: velocities, threshold and release as amplitudes, then as voltages."""
    limits = [record.summary.get(key, np.nan) for key in KEYS]
    return np.array([*(point.get("velocity_m_per_s", np.nan) for point in record.points), *limits])


def _sampled(numbers, count: int) -> list[dict[str, float]]:
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


def _answers(predictor: MeasurementPredictor, record: Record, changes: list[dict]) -> np.ndarray:
    """Return what `_centre` does, for each set of changed numbers; NaN where there is no answer."""
    import contact

    levels = np.array([point[record.level] for point in record.points])
    asked, limits = [], []
    for changed in changes:
        level = np.prod([changed.get(key, 1.0) for key in LEVELS]) ** (
            0.5 if "drive.power" in changed else 1.0
        )
        driven = predictor.contact({key: value for key, value in changed.items() if key not in LEVELS})
        asked += [(driven, each * level) for each in levels.tolist()]
        factors = [getattr(contact, f"{name}_factor")(driven.slider, driven.orbits) for name in LIMITS]
        limits.append(
            [*(factor * driven.amplitude for factor in factors), *(factor / level for factor in factors)]
        )
    velocities = steady_velocities(asked).reshape(len(changes), len(levels))
    return np.column_stack([velocities, np.array(limits)])
