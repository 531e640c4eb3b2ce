"""``sawmotor study``: a study, or without a name the list of them."""

import argparse

from studies.command.options import add_shared
from studies.command.output import committed_pictures, origin_of, results_folder, say
from studies.command.scene_argument import read_tolerance, say_unused_tolerances
from studies.progress import Progress
from studies.results import Origin, result_directory
from studies.scene import read_table
from studies.scene.override import read_axes

HELP = "run a study, or list the studies"
EXAMPLE = "sawmotor study regime_map twente-contact"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="which study")
    parser.add_argument("scene", nargs="?", metavar="SCENE", help="a path or a shipped name, for studies of a scene")
    add_shared(parser, "--over")
    parser.add_argument("--band", metavar="START:STOP:N", help="network, force_response, reflector: frequencies in MHz")
    parser.add_argument("--z0", metavar="OHM", help="network: reference impedance (50)")
    measured = (
        "network: Touchstone file or an impedance analyser's table; beam, frequency_response: vibrometer's scan; "
    )
    measured += 'drawn over the prediction; roughness: a threshold, e.g. "4.2 V"'
    parser.add_argument("--measured", metavar="FILE", help=measured)
    parser.add_argument("--port", metavar="N", help="network: take this port of the measured file, counted from 1")
    parser.add_argument("--target", metavar="LENGTH", help='positioning: where to go, e.g. "10 um"')
    parser.add_argument(
        "--controller", metavar="NAME", help="positioning: two_phase, dead_zone_pi, burst_length or FILE.py:FUNCTION"
    )
    parser.add_argument(
        "--loop", action="append", metavar="KEY=VALUE",
        help='positioning: sensor, period, preload, load and gains, e.g. resolution="1 nm"; once for each',
    )  # fmt: skip
    parser.add_argument(
        "--tolerance", metavar="T",
        help="bound of the relative error of the last quantity; of the studies of a SCENE all take it but dispersion, "
        "gallery, error_vs_time and calibration",
    )  # fmt: skip
    quick = "run a small version that shows what the study gives; its numbers are no evidence"
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-study[-SCENE])")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Run a study, or list them with their questions."""
    from studies.record.text import labelled
    from studies.report.explanation import announced
    from studies.study_list import COMMAND_OPTIONS, STUDIES, draw_study, expected_seconds, module, question, run_study

    if arguments.name is None:
        print("\n".join(labelled([(name, question(name)) for name in STUDIES], 2 + max(map(len, STUDIES)))))
        return 0
    module(arguments.name)
    if arguments.tolerance is not None:
        arguments.tolerance = read_tolerance(arguments.tolerance)
    origin, name = Origin(kind="study", name=arguments.name), f"{arguments.name}-study"
    if arguments.scene is not None:
        scene = origin_of("study", arguments.scene)
        if arguments.name not in ("voltage_to_velocity", "gallery", "positioning"):
            say_unused_tolerances(read_table(arguments.scene))
        origin = Origin(kind="study", name=f"{arguments.name} of {scene.name}", source=scene.source)
        name = f"{name}-{scene.name}"
    out = results_folder(arguments, name)
    arguments.over = read_axes(arguments.over) or None
    options = {key: value for key in COMMAND_OPTIONS if (value := getattr(arguments, key)) is not None}
    if arguments.explain:
        from studies.report.explained_calls import explained_study

        seconds = expected_seconds(arguments.name, arguments.scene, options)
        print(explained_study(arguments.name, module(arguments.name).__doc__, seconds))
        return 0
    if not arguments.quick:
        say(announced(expected_seconds(arguments.name, arguments.scene, options)))
    with result_directory(out, origin, named_by_user=arguments.out is not None) as result, Progress():
        done = run_study(arguments.name, arguments.scene, result.folder, options=options, quick=arguments.quick)
        result.commit()
        with committed_pictures(result):
            draw_study(arguments.name, done, result.folder)
    print(f"{done}\nresults  {out}")
    say([*result.notes, *([done.remark] if done.remark else [])])
    return done.exit_code
