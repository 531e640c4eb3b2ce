"""Whether the true error is at most twice the estimate, in 95 of 100 scenes drawn at random.

Method: a hundred scenes from ``random_scene`` (materials, cuts, sizes, ends, combs, sliders, amplitudes), each run at a
tolerance drawn with it and again for a converged answer at a tenth of the error that the first run states; the
error of every point of the first against the second is divided by the first's estimate.  A scene counts as kept if that
holds at its worst point.  Points at rest in both, whose error and estimate are nothing, do not count.  Expected: at
least 95 of 100 kept, the median estimate within ten times the true error.  Run time: about 10 min on two cores.
"""

import math
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import count
from multiprocessing import get_context

from studies.refusal import RunError, SceneError
from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["Checked", "calibrated", "figure", "run"]

SEED, SCENES = 2026, 100
QUICK = {"seed": 5, "scenes": 1, "workers": 1}
PROMISED, SHARE, MEDIAN = 2.0, 95, 10.0
BETTER = 0.1  # tolerance of the converged answer over the error of the first
FINEST = 3e-7
WORTHLESS = 0.3  # a converged answer whose own error exceeds this part of the first's estimate tells nothing


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A scene's worst point.

    Attributes
    ----------
    index : int
    kind : str
    tolerance : float
    true, estimate : float
        Errors in the sense of the tolerance.
    refusal : str
        Why there is no answer to compare; empty if there is one.
    seconds : float
    """

    index: int
    kind: str
    tolerance: float
    true: float = 0.0
    estimate: float = 0.0
    refusal: str = ""
    seconds: float = 0.0

    @property
    def ratio(self) -> float:
        """True error over its estimate; 0 where there was none to make."""
        return self.true / self.estimate if self.estimate > 0 else (math.inf if self.true > 0 else 0.0)


def calibrated(seed: int, index: int) -> Checked:
    """Return what a scene of a seed shows."""
    from studies.chain import run as run_chain
    from studies.evidence.random_scene import drawn

    begun = time.perf_counter()
    kind, tolerance = "none", math.nan
    try:
        scene, kind, tolerance = drawn(seed, index)
        first = run_chain(scene, tolerance=tolerance)
        finer = _finer(scene, min(first.error.get("relative") or tolerance, tolerance))
    except (RunError, SceneError) as error:
        return Checked(
            index=index,
            kind=kind,
            tolerance=tolerance,
            refusal=str(error),
            seconds=time.perf_counter() - begun,
        )
    pairs = [pair for pair in _pairs(first, finer) if pair[0] > 0 or pair[1] > 0]
    refusal = "" if pairs else (first.shortfall or "every point is at rest")
    known = finer.error.get("relative", math.inf)
    if not refusal and known > WORTHLESS * max(estimate for _, estimate in pairs):
        refusal = f"the converged answer is known to {known:.1e} only"
    true, estimate = max(
        pairs, key=lambda pair: pair[0] / pair[1] if pair[1] else math.inf, default=(0.0, 0.0)
    )
    return Checked(
        index=index, kind=kind, tolerance=tolerance, true=true, estimate=estimate, refusal=refusal,
        seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _finer(scene, stated: float):
    """Return a converged run, as fine as can be had."""
    from studies.chain import run as run_chain

    if scene.wave is not None:
        scene = replace(scene, slider=replace(scene.slider, method="exact"))
    return run_chain(scene, tolerance=max(BETTER * stated, FINEST))


def _pairs(first, finer) -> list[tuple[float, float]]:
    """Return true error and estimate of each point that both runs answer."""
    if not first.points:
        velocity = "phase_velocity_m_per_s"
        return [(abs(first.wave[velocity] / finer.wave[velocity] - 1), first.error["relative"])]
    pairs = []
    omega = 2 * math.pi * first.wave["frequency_Hz"]
    for one, other in zip(first.points, finer.points, strict=True):
        if "relative_error" not in one or "relative_error" not in other:
            continue
        if "velocity_m_per_s" in one:
            speed = max(abs(other["velocity_m_per_s"]), omega * other["tangential_amplitude_m"] / 10)
            true = abs(one["velocity_m_per_s"] - other["velocity_m_per_s"]) / speed
        else:
            true = abs(one["normal_amplitude_m"] / other["normal_amplitude_m"] - 1)
        pairs.append((true, one["relative_error"]))
    return pairs


def run(
    *, seed: int = SEED, scenes: int = SCENES, workers: int = 2, progress: Callable[[str], None] | None = None
) -> StudyRecord:
    """Return the calibration.

    Parameters
    ----------
    seed : int
        Of the scenes.
    scenes : int
        How many that give an answer.
    workers : int
        Processes; 1 for this one.
    progress : callable, optional
        Called with what is being done.
    """
    begun = time.perf_counter()
    say = progress or (lambda text: None)
    checked: list[Checked] = []
    refused: list[Checked] = []
    indices = count()
    with ExitStack() as stack:
        each_of = map
        if workers > 1:
            pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
            each_of = stack.enter_context(pool).map
        while len(checked) < scenes:
            batch = [next(indices) for _ in range(scenes - len(checked))]
            for found in each_of(calibrated, [seed] * len(batch), batch):
                (refused if found.refusal else checked).append(found)
                say(f"calibration: {len(checked)} of {scenes} scenes, {len(refused)} without a comparison")
    return StudyRecord(
        name="calibration",
        panels=(_panel(seed, checked, refused),),
        findings=_findings(seed, checked, refused),
        seconds=time.perf_counter() - begun,
    )


def _panel(seed: int, checked: list[Checked], refused: list[Checked]) -> Panel:
    keys = ("index", "kind", "tolerance", "true", "estimate", "seconds")
    return Panel(
        name="calibration",
        title=f"true error against its estimate, {len(checked)} random scenes (seed {seed})",
        data={key: [getattr(each, key) for each in checked] for key in keys}
        | {"without_comparison": [f"{each.index} ({each.kind}): {each.refusal}" for each in refused]},
    )


def _findings(seed: int, checked: list[Checked], refused: list[Checked]) -> tuple[Finding, ...]:
    kept = sum(each.ratio <= PROMISED for each in checked)
    known = [each.estimate / each.true for each in checked if each.true > 0]
    median = statistics.median(known) if known else math.nan
    broken = ", ".join(
        f"{each.index} {each.kind} {each.ratio:.1f}" for each in checked if each.ratio > PROMISED
    )
    return (
        Finding(
            statement=f"The true error is at most twice the estimate (seed {seed}, {len(refused)} more refused).",
            quantity=f"scenes of {len(checked)}",
            expected=f"at least {SHARE} of 100",
            found=100 * kept / len(checked),
            confirmed=100 * kept >= SHARE * len(checked),
            remark=f"broken by {broken}" if broken else "",
        ),
        Finding(
            statement="The estimate is not much larger than the error.",
            quantity="median of estimate over true error",
            expected=f"1/{MEDIAN:g} to {MEDIAN:g}",
            found=median,
            confirmed=1 / MEDIAN <= median <= MEDIAN,
        ),
    )


@of_record
def figure(record: Panel, ax):
    """Draw true error against estimate, with the promise."""
    from studies.record.plots import COLOURS

    marks = {
        "motor": ("slip", "o"),
        "wave": ("intermittent", "^"),
        "contact": ("second", "s"),
        "free": ("stick", "D"),
    }
    table = record.data
    for kind, (colour, mark) in marks.items():
        rows = [row for row, name in enumerate(table["kind"]) if name == kind and table["true"][row] > 0]
        if rows:
            ax.loglog(
                [table["estimate"][row] for row in rows], [table["true"][row] for row in rows], mark,
                color=COLOURS[colour], label=kind, markersize=5,
            )  # fmt: skip
    ends = ax.get_xlim()
    ax.plot(
        ends,
        [PROMISED * end for end in ends],
        color=COLOURS["line"],
        linewidth=1,
        label="promise: true = 2 estimate",
    )
    ax.plot(
        ends,
        [end / MEDIAN for end in ends],
        color=COLOURS["line"],
        linewidth=1,
        linestyle=":",
        label="true = estimate / 10",
    )
    ax.set_xlabel("estimated relative error (1)")
    ax.set_ylabel("true relative error (1)")
    ax.set_title(record.title, fontsize="medium")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    return ax
