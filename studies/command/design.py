"""``sawmotor design``: a search for the best motor within ranges, which can be interrupted and continued."""

import argparse

from studies.command.options import add_shared
from studies.command.output import print_answer, results_folder
from studies.command.scene_argument import changed_scene, read_tolerance
from studies.progress import Progress
from studies.scene import scene_path

HELP = "search for the best motor within ranges; an interrupted search can be continued"
EXAMPLE = 'sawmotor design twente-contact --maximise velocity --over "slider.preload=1 mN:9 mN"'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene")
    parser.add_argument(
        "--maximise", action="append", default=[], metavar="GOAL",
        help="velocity (at the slider's position), mean_velocity (over half a wavelength about it), thrust, "
        "efficiency, step_resolution, or of a slider that turns rotation and torque (stall); twice for the front of "
        "two goals",
    )  # fmt: skip
    parser.add_argument(
        "--minimise", action="append", default=[], metavar="GOAL",
        help="power_W, ripple, contact_pressure, normal_amplitude or a key of --over: with --subject "
        "'velocity >= 50 mm/s' the least that reaches a velocity",
    )  # fmt: skip
    parser.add_argument(
        "--over", action="extend", nargs="+", default=[], metavar="KEY=LOW:HIGH",
        help="a number of the scene that is varied, and its range",
    )  # fmt: skip
    parser.add_argument(
        "--subject", action="extend", nargs="+", default=[], metavar="'NAME <= VALUE'",
        help="a constraint on a key, velocity, mean_velocity, lateral_velocity, rotation, torque, ripple, thrust, "
        "contact_pressure, stick_margin, normal_amplitude or power_W",
    )  # fmt: skip
    parser.add_argument(
        "--evaluations", type=int, metavar="N", help="number of evaluations of each search (60 for each varied number)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random numbers (0)")
    add_shared(parser, "--voltage", "--set")
    parser.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the velocity at each evaluation (3e-2)"
    )
    add_shared(parser, "--workers")
    parser.add_argument("--out", metavar="DIR", help="where evaluations and results are kept (results/NAME-design)")
    parser.add_argument("--json", action="store_true", help="design.json on stdout")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Search for the best motor within ranges; print it and write its scene and all evaluations."""
    from studies.inverse.optimum import Options
    from studies.inverse.optimum import design as search

    tolerance, scene = read_tolerance(arguments.tolerance or "3e-2"), changed_scene(arguments)
    table = scene.to_table()
    out = results_folder(arguments, f"{scene_path(arguments.scene).stem}-design")
    options = {key: getattr(arguments, key) for key in ("evaluations", "seed", "workers")}
    if arguments.explain:
        from studies.inverse.goals import read_variable
        from studies.report.explained_calls import explained_search

        keys = [read_variable(each).key for each in arguments.over]
        budget = Options(**options).budget(len(keys))
        evaluations = f"{budget} in each search, as many on the coarsest discretisation where the stator varies"
        print(explained_search(scene, keys, evaluations=evaluations, tolerance=tolerance))
        return 0
    with Progress():
        optimum = search(
            table, arguments.maximise, arguments.over, arguments.subject, minimise=arguments.minimise,
            options=Options(**options, tolerance=tolerance, out=out),
        )  # fmt: skip
        optimum.write(out)
    print_answer(arguments, optimum.to_dict(), f"{optimum}\n{'results':<16}{out}")
    return 0
