"""``sawmotor sweep``: many points of one scene, here, on processes or on a Dask cluster."""

import argparse
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from studies.command.options import add_shared
from studies.command.output import print_answer, results_folder, say
from studies.command.scene_argument import changed_file, read_tolerance
from studies.progress import Progress
from studies.refusal import EXIT_INEXACT, EXIT_NO_ANSWER, RunError, SceneError, needed
from studies.scene import scene_path
from studies.scene.override import read_axes

HELP = "compute many points of one scene, in this process, in several, or on a Dask cluster"
EXAMPLE = 'sawmotor sweep twente --voltage 20 --over "slider.preload=1 mN:4 mN:4"'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene", "--voltage", "--set", "--over")
    parser.add_argument("--points", metavar="FILE", help="a CSV file of points, keys in its first line")
    parser.add_argument(
        "--also", default="", metavar="LIST",
        help="beside the velocity at the position: ripple (mean over place and range within half a wavelength), limits "
        "(threshold, release), thrust (blocked), efficiency, pressure, step (cycle), start-up (time to 63 %% of the "
        "velocity)",
    )  # fmt: skip
    add_shared(parser, "--tolerance", "--workers")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler, e.g. tcp://127.0.0.1:8786")
    parser.add_argument("--out", metavar="DIR", help="where the points are kept (results/NAME-sweep)")
    add_shared(parser, "--netcdf", "--explain")
    parser.add_argument("--json", action="store_true", help="the summary as JSON on stdout")


def call(arguments: argparse.Namespace) -> int:
    """Compute the missing points of a sweep, and print a summary of all."""
    from studies.record.status import Status
    from studies.sweeps import sweep
    from studies.sweeps.axes import refuse_bad_values

    table, over = changed_file(arguments).table, read_axes(arguments.over)
    refuse_bad_values(over)
    tolerance = read_tolerance(arguments.tolerance)
    also = tuple(filter(None, map(str.strip, arguments.also.split(","))))
    axes = over if arguments.points is None else [Path(arguments.points), over]
    if arguments.netcdf:
        needed("xarray", "--netcdf")
    say(_moving_periods(table, over))
    if arguments.explain:
        from studies.report.explained_calls import explained_sweep

        design, first = _first_point(table, axes, tolerance, also)
        print(explained_sweep(design, first, tolerance=tolerance))
        return 0
    say(_expected_time(table, axes, tolerance))
    folder = results_folder(arguments, f"{scene_path(arguments.scene).stem}-sweep")
    with Progress() as progress:
        result = sweep(
            table, axes, tolerance=tolerance, also=also, progress=progress.points,
            out=folder,
            workers=arguments.scheduler or arguments.workers,
        )  # fmt: skip
    if arguments.netcdf:
        from studies.record.files import write_netcdf

        write_netcdf(result.to_xarray(), folder / "points.nc")
    print_answer(arguments, result.summary, str(result))
    if not result.failed:
        return 0
    first = result.summary["reasons"][0]
    say([f"{result.failed} of {result.points} points have no answer within the tolerance; point "
         f"{first['first_point']}: {first['status']}"])  # fmt: skip
    answered = sum(result.counts.get(kind, 0) for kind in (Status.OK, Status.ABOVE_TOLERANCE))
    return EXIT_INEXACT if answered else EXIT_NO_ANSWER


def _first_point(table: dict, over: Any, tolerance: float, also=()):
    """Return the design of a sweep and the scene of its first point."""
    from studies.model.changed_scenes import ChangedScenes
    from studies.sweeps.plan import designed

    design = designed(table, over, tolerance=tolerance, also=also)
    (first,) = design.values([0])
    return design, ChangedScenes(table).scene(dict(zip(design.question.keys, first, strict=True)))


def _expected_time(table: dict, over: Any, tolerance: float) -> tuple[str, ...]:
    """Return a sentence on the expected time of a sweep that takes more than a minute."""
    from studies.report.explanation import long_sweep

    with suppress(SceneError, RunError):  # the sweep raises the same error
        design, scene = _first_point(table, over, tolerance)
        return long_sweep(scene, tolerance=tolerance, stators=design.stators, points=len(design))
    return ()


def _moving_periods(table: dict, over: dict) -> Iterator[str]:
    """Yield a remark if the frequency is varied and the transducers' periods follow it."""
    transducers = table.get("transducer", ()) if "drive.frequency" in over else ()
    automatic = [k for k, each in enumerate(transducers) if each.get("period", "auto") == "auto"]
    keys = [key for key in (f"transducer.{k}.period" for k in automatic) if key not in over]
    if keys:
        yield (
            'every frequency gets its own transducers, for their period is "auto"; a number at '
            f"{' and '.join(keys)}, such as that in the scene.toml of a run, keeps them and makes one band of all"
        )
