"""``sawmotor wave``: the half-space Rayleigh wave of a material, without a mesh and without loss."""

import argparse

from studies.command.output import print_answer
from studies.scene.override import toml_value

HELP = "compute the Rayleigh wave of a half-space, without a mesh and without loss"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("material", metavar="MATERIAL", help="a catalogue name, such as PZT-8")
    orientation = "Z, X, YZ, 128YX, ST-X or three angles phi,theta,psi in degrees (Z)"
    parser.add_argument("--orientation", default="Z", metavar="O", help=orientation)
    parser.add_argument("--surface", default="vacuum", metavar="S", help="vacuum (or free), open, metallised (vacuum)")
    parser.add_argument("--json", action="store_true", help="the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help="draw the crystal axes in the x-z section into a PNG file")


def call(arguments: argparse.Namespace) -> int:
    """Print the half-space Rayleigh wave of a material and its cut; with --plot draw the crystal axes."""
    from studies.report.free_surface import half_space_answer, half_space_wave

    orientation = arguments.orientation
    if "," in orientation:
        orientation = toml_value(f"[{orientation.strip('[]')}]")
    answer = half_space_wave(arguments.material, orientation=orientation, surface=arguments.surface)
    print_answer(arguments, answer, half_space_answer(answer))
    if arguments.plot is not None:
        from studies.report.free_surface import save_axes

        save_axes(answer, arguments.plot)
    return 0
