"""The call ``sawmotor sweep``: progress on stderr, what the points came to on stdout."""

import sys
from argparse import Namespace
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

from studies.chain.changed_scenes import ChangedScenes
from studies.progress import Progress, duration
from studies.record.quantities import quantity
from studies.record.status import Status
from studies.record.text import labelled, print_json
from studies.record.text import table as aligned
from studies.refusal import EXIT_INEXACT, EXIT_NO_ANSWER, RunError, SceneError
from studies.report.explanation import long_sweep
from studies.sweeps import Sweep, sweep
from studies.sweeps.plan import designed

REASONS = 5  # shown; all are in the rows
SHOWN = ("velocity_m_per_s", "normal_amplitude_m", "thrust_N", "contact_efficiency", "motor_efficiency")


def run_sweep(arguments: Namespace, table: dict, over: dict, tolerance: float, out: str | Path) -> int:
    """Run the sweep of a call and print its answer; return the exit code."""
    notice = _moving_periods(table, over)
    if notice:
        print(f"sawmotor: {notice}", file=sys.stderr)
    axes = over if arguments.points is None else [Path(arguments.points), over]
    for sentence in _expected_time(table, axes, tolerance):
        print(f"sawmotor: {sentence}", file=sys.stderr, flush=True)
    with Progress() as progress:
        result = sweep(
            table,
            axes,
            tolerance=tolerance,
            also=tuple(word.strip() for word in arguments.also.split(",") if word.strip()),
            out=out,
            workers=arguments.scheduler or arguments.workers,
            progress=progress.points,
        )
    whole = summary(result)
    if arguments.json:
        print_json(whole)
    else:
        print(sweep_answer(result, whole))
    if result.failed:
        first = whole["reasons"][0]
        print(
            f"sawmotor: {result.failed} of {result.points} points have no answer within the tolerance; point "
            f"{first['first_point']}: {first['status']}",
            file=sys.stderr,
        )
    if not result.failed:
        return 0
    answered = sum(result.counts.get(kind, 0) for kind in (Status.OK, Status.ABOVE_TOLERANCE))
    return EXIT_INEXACT if answered else EXIT_NO_ANSWER


def summary(result: Sweep) -> dict:
    """Return what a sweep came to: counts, ranges of its outcomes, reasons of its failures, cost."""
    columns = result.columns()
    known = {name: [each for each in columns.get(name, ()) if each is not None] for name in SHOWN}
    errors, statuses = columns["relative_error"], columns["status"]
    failures = Counter(status for status in statuses if status != Status.OK).most_common(REASONS)
    return {
        "store": str(result.path),
        "points": result.points,
        "counts": result.counts,
        "ranges": {name: [min(values), max(values)] for name, values in known.items() if values},
        "largest_relative_error": max(
            (error for error, status in zip(errors, statuses, strict=True) if status == Status.OK), default=None
        ),
        "reasons": [
            {"status": status, "points": count, "first_point": statuses.index(status)} for status, count in failures
        ],
        "seconds": result.seconds,
        "work_seconds": result.cost,
    }


def sweep_answer(result: Sweep, whole: dict) -> str:
    """Return a sweep's answer as text."""
    kinds = ", ".join(f"{number} {kind}" for kind, number in result.counts.items())
    ranges = [
        [each.heading, each.text(low), "to", each.text(high)]
        for each, (low, high) in ((quantity(name), ends) for name, ends in whole["ranges"].items())
    ]
    notes = [
        ("not ok", f"{each['points']} (first: point {each['first_point']}): {each['status']}")
        for each in whole["reasons"]
    ]
    if whole["largest_relative_error"] is not None:
        notes.insert(0, ("relative error", f"{whole['largest_relative_error']:.1e} at most, where ok"))
    notes += [("seconds", f"{result.seconds:.2f}, {duration(result.cost)} of work"), ("results", f"{result.path}")]
    points = labelled([("points", f"{result.points}: {kinds}")])
    return "\n".join([*points, *(aligned(ranges) if ranges else []), *labelled(notes)])


def _expected_time(table: dict, over: Any, tolerance: float) -> tuple[str, ...]:
    """Return a sentence on the expected time of a sweep that takes more than a minute."""
    with suppress(SceneError, RunError):  # which the sweep says itself
        design = designed(table, over, tolerance=tolerance)
        (first,) = design.values([0])
        question = design.question
        scene = ChangedScenes(table).scene(dict(zip(question.keys, first, strict=True)))
        return long_sweep(scene, tolerance=tolerance, stators=design.stators, points=len(design))
    return ()


def _moving_periods(table: dict, over: dict) -> str:
    """Return what is to be known where the frequency moves and takes the transducers' periods with it."""
    row = table.get("transducer", ()) if "drive.frequency" in over else ()
    keys = [f"transducer.{k}.period" for k, each in enumerate(row) if each.get("period", "auto") == "auto"]
    keys = [key for key in keys if key not in over]
    if not keys:
        return ""
    return (
        'every frequency gets its own transducers, for their period is "auto"; a number at '
        f"{' and '.join(keys)}, such as that in the scene.toml of a run, keeps them and makes one band of all"
    )
