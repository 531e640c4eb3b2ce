"""``sawmotor compare``: what differs in the scenes and answers of several runs, and one picture of their velocities."""

import argparse

from studies.command.options import add_shared
from studies.command.output import print_answer

HELP = "show what differs in the scenes and the answers of several runs"
EXAMPLE = "sawmotor compare results/twente results/light --picture both.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("runs", nargs="+", metavar="RUN_DIR", help="directories that `sawmotor run` left")
    parser.add_argument("--picture", metavar="FILE", help="draw all velocities with their errors: .png, .svg or .pdf")
    parser.add_argument("--json", action="store_true", help="the comparison as JSON")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Print runs side by side; draw their velocities into a file."""
    from studies.report.comparison import compare, drawn

    if arguments.explain:
        from studies.report.explained_calls import explained_comparison

        print(explained_comparison(arguments.runs))
        return 0
    compared = compare(*arguments.runs)
    if arguments.picture is not None:
        drawn(compared, arguments.picture)
    print_answer(arguments, compared.to_dict(), str(compared))
    return 0
