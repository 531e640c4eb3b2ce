"""Whether the true error of a scene's answer is at most twice the estimate, in 95 of 100 variations of the scene.

Method: the scene with its frequency, levels, sizes, loads and constants changed at random by up to the factors in
`VARIED`, each variation run at a tolerance drawn with it and again for a converged answer at a tenth of the error that
the first run states.  The true error of a point is the difference between the two runs; its ratio to the estimate of
the first run is formed at every point.  A variation keeps the promise if the ratio at its worst point is at most 2.
Points at rest in both runs, whose error and estimate are zero, do not count.  Expected: at least 95 of 100 variations
keep the promise, and the median estimate is within a factor of ten of the true error. Materials, cuts, ends and layouts
drawn at random too: `tests/studies/test_calibration.py`.  Run time: about 5 min on two cores for ``twente-contact``,
twice that for ``twente``.
"""

import logging
import math
import statistics
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import count
from multiprocessing import get_context

import numpy as np

import contact
from studies.record.plots import COLOURS, finished
from studies.refusal import RunError, SceneError
from studies.runs import run as run_chain
from studies.scene import Scene
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

SEED, DRAWS = 2026, 100
QUICK = {"seed": 5, "draws": 1, "workers": 1}
TOLERANCES = (3e-2, 1e-2, 3e-3, 1e-3)
# factors up to which a key's value is multiplied or divided, where the scene has a number there
VARIED = {
    "drive.frequency": 1.01, "drive.voltage": 3.0, "wave.frequency": 2.0, "wave.normal_amplitude": 3.0,
    "stator.thickness": 1.2, "slider.radius": 2.0, "slider.mass": 2.0, "slider.preload": 2.0,
    "slider.friction_coefficient": 1.5, "slider.effective_modulus": 1.5, "slider.tangential_modulus": 1.5,
}  # fmt: skip
# Promised largest true error over its estimate; per cent of the variations that must keep the promise; largest factor
# between the median estimate and the true error, either way
PROMISED, SHARE, MEDIAN = 2.0, 95, 10.0
BETTER = 0.1  # tolerance of the converged answer over the error of the first
FINEST = 3e-7  # smallest tolerance of a converged answer
WORTHLESS = 0.3  # a converged answer whose own error exceeds this part of the first's estimate is no reference
MAX_REFUSED = 3  # variations without a comparison for each one with it, before the study gives up


@dataclass(frozen=True, kw_only=True)
class Checked:
    """The worst point of a variation: that of the largest ratio of true error to estimate."""

    index: int  # of the variation
    tolerance: float
    # relative errors: of the velocity over max(|v|, omega |u_x|/10), or of the amplitude or the free wave's velocity
    true: float = 0.0
    estimate: float = 0.0
    refusal: str = ""  # reason why no errors can be compared; empty if they can
    seconds: float = 0.0

    @property
    def ratio(self) -> float:
        """True error over its estimate; 0 without a true error, infinite if only the estimate is 0."""
        return self.true / self.estimate if self.estimate > 0 else (math.inf if self.true > 0 else 0.0)


def drawn(scene: Scene, seed: int, index: int) -> tuple[Scene, float]:
    """Return a variation of a scene and a tolerance; both depend on `seed` and `index` only.

    Raises
    ------
    SceneError
        If the variation is refused.
    """
    rng = np.random.default_rng([seed, index])
    table = scene.to_table()
    for path, most in VARIED.items():
        block, key = path.split(".")
        factor = float(most ** rng.uniform(-1.0, 1.0))
        value = table.get(block, {}).get(key)
        if isinstance(value, list):
            table[block][key] = [factor * each for each in value]
        elif isinstance(value, int | float) and not isinstance(value, bool):
            table[block][key] = factor * value
    return Scene.from_table("", table), float(rng.choice(TOLERANCES))


def compared(scene: Scene, tolerance: float, *, index: int = 0) -> Checked:
    """Return the worst point of a scene run at a tolerance, against a converged answer."""
    start_time = time.perf_counter()
    true = estimate = 0.0
    try:
        first = run_chain(scene, tolerance=tolerance)
        finer = _finer(scene, min(first.error.relative or tolerance, tolerance))
    except (RunError, SceneError) as error:
        refusal = str(error)
    else:
        pairs = [pair for pair in _pairs(first, finer) if pair[0] > 0 or pair[1] > 0]
        refusal = "" if pairs else (first.shortfall or "every point is at rest")
        own_error = math.inf if finer.error.relative is None else finer.error.relative
        if not refusal and own_error > WORTHLESS * max(estimate for _, estimate in pairs):
            refusal = f"the converged answer is known to {own_error:.1e} only"
        true, estimate = max(pairs, key=lambda p: p[0] / p[1] if p[1] else math.inf, default=(0.0, 0.0))
    return Checked(
        index=index, tolerance=tolerance, true=true, estimate=estimate, refusal=refusal,
        seconds=time.perf_counter() - start_time,
    )  # fmt: skip


def _variation(scene: Scene, seed: int, index: int) -> Checked:
    """Return the worst point of a variation of a scene."""
    try:
        variation, tolerance = drawn(scene, seed, index)
    except SceneError as error:
        return Checked(index=index, tolerance=math.nan, refusal=str(error))
    return compared(variation, tolerance, index=index)


def _finer(scene, stated: float):
    """Return a converged run, by the exact method on a prescribed wave."""
    if scene.wave is not None:
        scene = replace(scene, slider=replace(scene.slider, method="exact"))
    return run_chain(scene, tolerance=max(BETTER * stated, FINEST))


def _pairs(first, finer) -> list[tuple[float, float]]:
    """Return true error and estimate of each point for which both runs have an answer."""
    if not first.points:
        true = abs(first.wave.phase_velocity_m_per_s / finer.wave.phase_velocity_m_per_s - 1)
        return [(true, first.error.relative)]
    pairs = []
    omega = 2 * math.pi * first.wave.frequency_Hz
    for one, other in zip(first.points, finer.points, strict=True):
        if not (one.answered and other.answered):
            continue
        if one.velocity_m_per_s is not None:
            speed = contact.speed_scale(other.velocity_m_per_s, omega * other.tangential_amplitude_m)
            true = abs(one.velocity_m_per_s - other.velocity_m_per_s) / speed
        else:
            true = abs(one.normal_amplitude_m / other.normal_amplitude_m - 1)
        pairs.append((true, one.relative_error))
    return pairs


@study("twente")
def run(scene: Scene, *, seed: int = SEED, draws: int = DRAWS, workers: int = 2) -> Answered:
    """Return the calibration of a scene.

    Parameters
    ----------
    seed : int
        Of the variations.
    draws : int
        Number of variations that can be compared.
    workers : int
        Number of processes; 1: this one.
    """
    checked: list[Checked] = []
    refused: list[Checked] = []
    indices = count()
    with ExitStack() as stack:
        each_of: Callable[..., Iterator[Checked]] = map
        if workers > 1:
            pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
            each_of = stack.enter_context(pool).map
        while len(checked) < draws:
            if len(refused) > MAX_REFUSED * draws:
                raise RunError(f"variations of this scene cannot be compared: {refused[-1].refusal}")
            batch = [next(indices) for _ in range(draws - len(checked))]
            for outcome in each_of(_variation, [scene] * len(batch), [seed] * len(batch), batch):
                (refused if outcome.refusal else checked).append(outcome)
                LOGGER.info(f"calibration: {len(checked)} of {draws} variations, {len(refused)} without a comparison")
    return (_panel(seed, checked, refused),), findings(seed, checked, refused)


def _panel(seed: int, checked: list[Checked], refused: list[Checked]) -> Panel:
    keys = ("index", "tolerance", "true", "estimate", "seconds")
    return Panel(
        name="calibration",
        title=f"true error against its estimate, {len(checked)} variations (seed {seed})",
        data={key: [getattr(each, key) for each in checked] for key in keys}
        | {"without_comparison": [f"{each.index}: {each.refusal}" for each in refused]},
    )


def findings(seed: int, checked: list[Checked], refused: list[Checked]) -> tuple[Finding, ...]:
    """Return whether enough variations keep the promise, and whether the estimates are close."""
    fulfilled = sum(each.ratio <= PROMISED for each in checked)
    ratios = [each.estimate / each.true for each in checked if each.true > 0]
    median = statistics.median(ratios) if ratios else math.nan
    broken = ", ".join(f"{each.index} {each.ratio:.1f}" for each in checked if each.ratio > PROMISED)
    return (
        judged(
            f"The true error is at most twice the estimate (seed {seed}, {len(refused)} more refused).",
            f"per cent of {len(checked)} variations", 100 * fulfilled / len(checked), low=SHARE - 1e-9,
            expected=f"at least {SHARE} of 100", remark=f"broken by {broken}" if broken else "",
        ),
        judged(
            "The estimate is not much larger than the error.", "median of estimate over true error",
            median, low=1 / MEDIAN, high=MEDIAN,
        ),
    )  # fmt: skip


@of_record
def figure(record: Panel, ax):
    """Draw true error against estimate, with the promise."""
    table = record.data
    rows = [row for row, true in enumerate(table["true"]) if true > 0]
    x, y = ([table[key][row] for row in rows] for key in ("estimate", "true"))
    ax.loglog(x, y, "o", color=COLOURS["slip"], markersize=5, label="a variation's worst point")
    ends = ax.get_xlim()
    for factor, style, label in ((PROMISED, "-", "true = 2 estimate"), (1 / MEDIAN, ":", "true = estimate / 10")):
        ax.plot(ends, [factor * end for end in ends], style, color=COLOURS["line"], linewidth=1, label=label)
    return finished(ax, "estimated relative error (1)", "true relative error (1)", record.title)
