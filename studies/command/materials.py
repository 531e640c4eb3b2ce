"""``sawmotor materials``: the catalogue of materials, or one of them with its constants and the waves of usual cuts."""

import argparse

from studies.command.output import print_answer, warn

HELP = "list the catalogue of materials, or show one or a file of constants"
EXAMPLE = "sawmotor materials PZT-8 --copy my-ceramic.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("material", nargs="?", metavar="NAME", help="a catalogue name or FILE.toml (none: the list)")
    parser.add_argument("--copy", metavar="FILE", help="write the file of a catalogue material, to change it")
    parser.add_argument("--json", action="store_true", help="the answer as JSON")


def call(arguments: argparse.Namespace) -> int:
    """List the materials, or show one with class, constants, velocities and source."""
    from studies.report.material_page import copied, listed, material_answer, material_text

    if arguments.material is None:
        answer, text = listed()
        print_answer(arguments, answer, text)
        return 0
    if arguments.copy is not None:
        print(f"wrote {copied(arguments.material, arguments.copy)}")
        return 0
    answer = material_answer(arguments.material)
    warn(answer["probable_mistakes"])
    print_answer(arguments, answer, material_text(answer))
    return 0
