"""``sawmotor new``: a first scene of a motor, sized by rules that it states."""

import argparse
from pathlib import Path

from studies.command.options import add_shared
from studies.command.output import say
from studies.progress import Progress
from studies.refusal import refuse_unwritable, writing

HELP = "write a first scene of a motor for a frequency and a material, each line with its rule"
EXAMPLE = 'sawmotor new --frequency "10 MHz" --material 128YX --out my-motor.toml'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--frequency", required=True, metavar="F", help='such as "10 MHz"')
    parser.add_argument("--material", required=True, metavar="M", help='PZT-8, 128YX, "LiNbO3 YZ", or FILE.toml')
    parser.add_argument("--speed", metavar="V", help='wanted without a load, such as "0.2 m/s"')
    parser.add_argument("--thrust", metavar="F", help='wanted at the stall, such as "5 mN"')
    parser.add_argument("--out", metavar="FILE", help="the scene's file; none: stdout")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Print a first scene, or write it into a new file."""
    from studies.inverse.first_scene import first_scene

    if arguments.explain:
        from studies.report.explained_calls import explained_first_scene

        print(explained_first_scene(arguments.frequency, arguments.material))
        return 0
    file = None if arguments.out is None else Path(arguments.out)
    if file is not None:
        refuse_unwritable(file, "--out", new=True)
    with Progress():
        found = first_scene(arguments.frequency, arguments.material, speed=arguments.speed, thrust=arguments.thrust)
    text = str(found)
    say(found.unusual)
    if file is None:
        print(text, end="")
        return 0
    with writing(file, "--out"):
        file.write_text(text, encoding="utf-8")
    print(f"wrote {arguments.out}: sawmotor run {arguments.out}")
    return 0
