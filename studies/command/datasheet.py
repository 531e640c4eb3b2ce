"""``sawmotor datasheet``: one page with a motor's speed, force, steps, power and limits."""

import argparse

from studies.command.options import add_shared
from studies.command.output import committed_pictures, print_answer, results_of, say, warn, warn_of_scene
from studies.command.scene_argument import changed_scene, read_tolerance
from studies.progress import Progress

HELP = "compute the datasheet of a motor: one page with speed, force, steps, power and limits"
EXAMPLE = "sawmotor datasheet twente --out results/sheet"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene", "--voltage", "--set", "--tolerance")
    parser.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-datasheet)")
    parser.add_argument("--json", action="store_true", help="the numbers on stdout; files only with --out")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Compute a motor's datasheet; print its table and write its page and numbers."""
    from studies.report.datasheet_page import page
    from studies.report.explained_calls import datasheet_seconds, explained_datasheet
    from studies.report.explanation import long_wait
    from studies.report.motor_datasheet import datasheet as computed
    from studies.results.content import write_json

    tolerance, scene = read_tolerance(arguments.tolerance), changed_scene(arguments)
    if arguments.explain:
        with Progress():
            text = explained_datasheet(scene, tolerance=tolerance)
        print(text)
        return 0
    with Progress():
        expected = datasheet_seconds(scene, tolerance=tolerance)
    warned = warn_of_scene(scene)
    say(long_wait(expected))
    with results_of(arguments, "datasheet", "-datasheet") as (result, out), Progress(expected):
        sheet = computed(scene, tolerance=tolerance)
        if result is not None:
            write_json(result.folder / "datasheet.json", sheet.to_dict())
            result.commit()
            with committed_pictures(result):
                (result.folder / "datasheet.html").write_text(page(sheet), encoding="utf-8")
    print_answer(arguments, sheet.to_dict(), f"{sheet}\nresults  {out}")
    warn(each for each in sheet.record.warnings if each not in warned)
    return 0
