"""``sawmotor fit``: numbers of a scene from measured curves, and which of them the data determine."""

import argparse
from functools import partial

from studies.command.options import add_shared
from studies.command.output import committed_pictures, print_answer, results_of
from studies.command.scene_argument import changed_scene, read_tolerance
from studies.progress import Progress
from studies.refusal import all_answers

HELP = "fit numbers of a scene to measured curves, and report which of them the data determine"
EXAMPLE = "sawmotor fit twente --data measured.csv --free slider.friction_coefficient=0.02:0.3"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene")
    parser.add_argument(
        "--data", action="append", nargs="+", default=[], metavar=("FILE.csv", "KEY=VALUE"),
        help="measured points, and keys of this file alone, e.g. systematic=0.02; once for each file",
    )  # fmt: skip
    parser.add_argument(
        "--free", action="extend", nargs="+", default=[], metavar="KEY=LOW:HIGH",
        help="a number to be fitted; also amplitude_per_volt (m/V, prescribed wave), amplitude_factor (computed)",
    )  # fmt: skip
    parser.add_argument(
        "--next", action=argparse.BooleanOptionalAction, default=None,
        help="rank further measurements; the default, but of a slider on pillars or in the plane: it doubles the time",
    )  # fmt: skip
    add_shared(parser, "--voltage", "--set", "--tolerance")
    parser.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-fit)")
    parser.add_argument("--json", action="store_true", help="fit.json on stdout; files only with --out")
    add_shared(parser, "--explain", "--no-plot")


def call(arguments: argparse.Namespace) -> int:
    """Fit numbers of a scene to measurements; print the result and write the fitted scene."""
    from fem import blas_on_one_thread
    from studies.inverse import fit as fitted
    from studies.inverse import read_measurement, read_parameter
    from studies.inverse.fit_picture import draw_fit

    files = [partial(read_measurement, file, tuple(settings)) for file, *settings in arguments.data]
    free = [partial(read_parameter, text) for text in arguments.free]
    of_scene = (partial(read_tolerance, arguments.tolerance), partial(changed_scene, arguments))
    tolerance, scene, *read = all_answers([*of_scene, *files, *free])
    measurements, parameters = read[: len(files)], read[len(files) :]
    if arguments.explain:
        from studies.report.explained_calls import explained_search

        points = sum(len(each.values) for each in measurements)
        evaluations = f"of {points} measured values, {len(parameters) + 1} or more for each step of the search"
        keys = [each.key for each in parameters]
        print(explained_search(scene, keys, evaluations=evaluations, tolerance=tolerance))
        return 0
    with results_of(arguments, "fit", "-fit") as (result, out), Progress(), blas_on_one_thread():
        result_of_fit = fitted(scene, measurements, parameters, tolerance=tolerance, next_measurements=arguments.next)
        if result is not None:
            result_of_fit.write(result.folder)
            result.commit()
            if not (arguments.no_plot or arguments.json):
                with committed_pictures(result):
                    draw_fit(result_of_fit, result.folder / "fit.png")
    print_answer(arguments, result_of_fit.to_dict(), f"{result_of_fit}\n{'results':<16}{out}")
    return 0
