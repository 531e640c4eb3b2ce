"""The call ``sawmotor sweep``: progress on stderr, what the points came to on stdout."""

import sqlite3
import sys
from argparse import Namespace
from pathlib import Path

from studies.progress import Progress, duration
from studies.report.answer import print_json
from studies.report.answer import table as aligned
from studies.sweep import Sweep, sweep

REASONS = 5  # shown; all are in the rows
SHOWN = ("velocity_m_per_s", "normal_amplitude_m", "thrust_N", "contact_efficiency", "motor_efficiency")


def run_sweep(arguments: Namespace, table: dict, over: dict, tolerance: float, out: str | Path) -> int:
    """Run the sweep of a call and print its answer; return the exit code."""
    notice = _moving_periods(table, over)
    if notice:
        print(f"sawmotor: {notice}", file=sys.stderr)
    with Progress() as progress:
        found = sweep(
            table,
            over if arguments.points is None else [Path(arguments.points), over],
            samples=None if arguments.samples is None else (arguments.samples, arguments.seed),
            tolerance=tolerance,
            also=tuple(word.strip() for word in arguments.also.split(",") if word.strip()),
            out=out,
            workers=arguments.scheduler or arguments.workers,
            progress=progress.points,
        )
    whole = summary(found)
    if arguments.json:
        print_json(whole)
    else:
        print(sweep_answer(found, whole))
    if found.failed:
        first = whole["reasons"][0]
        print(
            f"sawmotor: {found.failed} of {found.points} points have no answer within the tolerance; point "
            f"{first['first_point']}: {first['status']}",
            file=sys.stderr,
        )
    return 1 if found.failed else 0


def summary(found: Sweep) -> dict:
    """Return what a sweep came to: counts, ranges of its outcomes, reasons of its failures, cost."""
    with sqlite3.connect(found.path) as connection:
        names = [row[1] for row in connection.execute("pragma table_info(points)")]
        ranges = {}
        for name in (name for name in SHOWN if name in names):
            low, high = connection.execute(f'select min("{name}"), max("{name}") from points').fetchone()
            if low is not None:
                ranges[name] = [low, high]
        worst = connection.execute("select max(relative_error) from points where status = 'ok'").fetchone()[0]
        reasons = connection.execute(
            "select status, count(*), min(point) from points where status != 'ok' group by status"
            " order by 2 desc, 3 limit ?",
            (REASONS,),
        ).fetchall()
    connection.close()
    return {
        "store": str(found.path),
        "points": found.points,
        "counts": found.counts,
        "ranges": ranges,
        "largest_relative_error": worst,
        "reasons": [{"status": s, "points": n, "first_point": k} for s, n, k in reasons],
        "seconds": found.seconds,
        "work_seconds": found.cost,
    }


def sweep_answer(found: Sweep, whole: dict) -> str:
    """Return a sweep's answer as text."""
    kinds = ", ".join(f"{number} {kind}" for kind, number in found.counts.items())
    lines = [f"points          {found.points}: {kinds}"]
    rows = [[name, f"{low:.5g}", "to", f"{high:.5g}"] for name, (low, high) in whole["ranges"].items()]
    lines += aligned(rows) if rows else []
    if whole["largest_relative_error"] is not None:
        lines.append(f"relative error  {whole['largest_relative_error']:.1e} at most, where ok")
    lines += [f"not ok          {each['points']} (first: point {each['first_point']}): {each['status']}"
              for each in whole["reasons"]]  # fmt: skip
    lines.append(f"seconds         {found.seconds:.2f}, {duration(found.cost)} of work")
    lines.append(f"results         {found.path}")
    return "\n".join(lines)


def _moving_periods(table: dict, over: dict) -> str:
    """Return what is to be known where the frequency moves and takes the transducers' periods with it."""
    if "drive.frequency" not in over:
        return ""
    moving = [
        f"transducer.{k}.period"
        for k, each in enumerate(table.get("transducer", ()))
        if each.get("period", "auto") == "auto" and f"transducer.{k}.period" not in over
    ]
    if not moving:
        return ""
    from studies.refusal import SceneError
    from studies.scene import Scene
    from studies.scene.resolved import resolved

    try:
        blocks = resolved(Scene.from_table("", table)).transducer
    except SceneError:
        return ""
    settings = " ".join(f"--set {key}={blocks[int(key.split('.')[1])].period:.9g}" for key in moving)
    return (
        'every frequency gets its own transducers, for their period is "auto"; to keep those of the scene, and solve '
        f"all frequencies as one band: {settings}"
    )
