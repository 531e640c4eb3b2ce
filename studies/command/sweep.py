"""``sawmotor sweep``: many points of one scene, here, on processes or on a Dask cluster."""

import argparse

from studies.command.options import add_shared
from studies.command.output import results_folder
from studies.command.scene_argument import changed_file, read_tolerance
from studies.scene import scene_path
from studies.scene.override import read_axes

HELP = "compute many points of one scene, in this process, in several, or on a Dask cluster"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene", "--voltage", "--set", "--over")
    parser.add_argument("--points", metavar="FILE", help="a CSV file of points, keys in its first line")
    parser.add_argument(
        "--also",
        default="",
        metavar="LIST",
        help="beside the velocity: limits (threshold, release), thrust (blocked), efficiency, pressure, step (cycle), "
        "start-up (time to 63 %% of the velocity)",
    )
    add_shared(parser, "--tolerance", "--workers")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler, e.g. tcp://127.0.0.1:8786")
    parser.add_argument("--out", metavar="DIR", help="where the points are kept (results/NAME-sweep)")
    parser.add_argument("--json", action="store_true", help="the summary as JSON on stdout")


def call(arguments: argparse.Namespace) -> int:
    """Compute what is missing of a sweep's points, and say what they came to."""
    from studies.sweeps.answer import run_sweep

    table = changed_file(arguments).table
    out = results_folder(arguments, f"{scene_path(arguments.scene).stem}-sweep")
    return run_sweep(arguments, table, read_axes(arguments.over), read_tolerance(arguments.tolerance), out)
