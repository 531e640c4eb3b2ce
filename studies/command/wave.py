"""``sawmotor wave``: the half-space Rayleigh wave of a material, without a mesh and without loss."""

import argparse

import fem
from studies.command.options import add_shared
from studies.command.output import print_answer
from studies.refusal import refuse_if
from studies.scene.override import toml_value
from studies.scene.rule import choice
from studies.scene.stator_keys import ORIENTATION, TEMPERATURE

HELP = "compute the Rayleigh wave of a half-space, bare or under layers, without a mesh and without loss"
EXAMPLE = 'sawmotor wave "LiNbO3 (Kovacs)" 128YX --temperature 20:80:7'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("material", metavar="MATERIAL", help="a catalogue name, such as PZT-8, or FILE.toml")
    orientation = "Z, X, YZ, 128YX, 64YX, X112Y, ST-X or three angles phi,theta,psi in degrees (Z)"
    parser.add_argument("cut", nargs="?", metavar="CUT", help="as --orientation")
    parser.add_argument("--orientation", metavar="O", help=orientation)
    convention = "convention of three angles: SAW, COMSOL or sawsim (SAW)"
    parser.add_argument("--euler-convention", default="SAW", metavar="C", help=convention)
    parser.add_argument("--surface", default="vacuum", metavar="S", help="vacuum (or free), open, metallised (vacuum)")
    parser.add_argument(
        "--layer", action="append", default=[], metavar="L", help='a layer, from the half-space up, once for each: '
        '"SiO2, 0.05 lambda", "LiNbO3 (Kovacs) 128YX, 2 um", "AlN.toml, 500 nm"'
    )  # fmt: skip
    parser.add_argument("--frequency", metavar="F", help='of layers with a thickness in metres, such as "10 MHz"')
    parser.add_argument(
        "--temperature", metavar="T", help="temperatures in degC, START:STOP:N or a list with commas, such as 20:80:7"
    )
    parser.add_argument("--json", action="store_true", help="the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help="draw the crystal axes in the x-z section into a PNG file")
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Print the half-space Rayleigh wave of a material and its cut; with --plot draw the crystal axes."""
    from studies.report.free_surface import half_space_answer, half_space_wave

    refuse_if(
        arguments.cut is not None and arguments.orientation is not None,
        "--orientation",
        "must be absent where the cut stands behind the material",
    )
    orientation = arguments.cut or arguments.orientation or "Z"
    if "," in orientation:
        orientation = toml_value(f"[{orientation.strip('[]')}]")
    orientation, convention = ORIENTATION.read("--orientation", orientation), arguments.euler_convention
    if not isinstance(orientation, str):
        convention = choice(*fem.CONVENTIONS).read("--euler-convention", convention)
        orientation = fem.euler_angles(orientation, convention)
    for name in ("layer", "plot") if arguments.temperature is not None else ():
        refuse_if(getattr(arguments, name), f"--{name}", "must be absent with --temperature, which is of one solid")
    refuse_if(
        arguments.layer and arguments.plot is not None,
        "--plot", "must be absent with --layer: it draws the crystal axes of one solid",
    )  # fmt: skip
    temperatures = None if arguments.temperature is None else _temperatures(arguments.temperature)
    if arguments.explain:
        return _explain(arguments, temperatures)
    if temperatures is not None:
        return _warm(arguments, orientation, temperatures)
    if arguments.layer:
        return _layered(arguments, orientation)
    answer = half_space_wave(arguments.material, orientation=orientation, surface=arguments.surface)
    print_answer(arguments, answer, half_space_answer(answer))
    if arguments.plot is not None:
        from studies.report.free_surface import save_axes

        save_axes(answer, arguments.plot)
    return 0


def _temperatures(text: str) -> tuple[float, ...]:
    """Return the temperatures in degC that a range or a list with commas names."""
    from studies.scene.numbers import Listed

    wanted = text if ":" in text else [toml_value(each) for each in text.split(",")]
    return Listed(TEMPERATURE, ranged=True).read("--temperature", wanted)


def _explain(arguments: argparse.Namespace, temperatures: tuple[float, ...] | None) -> int:
    """Print what would be computed; refuse an unknown material and layers that are none."""
    from studies.model.scene_errors import input_errors
    from studies.model.solid_of_material import named_solid
    from studies.report.explained_calls import explained_wave
    from studies.report.layered_surface import read_layer

    with input_errors():
        named_solid(arguments.material)
    for text in arguments.layer:
        read_layer(text)
    number = 0 if temperatures is None else len(temperatures)
    picture = arguments.plot is not None
    print(explained_wave(arguments.material, layers=arguments.layer, temperatures=number, picture=picture))
    return 0


def _warm(arguments: argparse.Namespace, orientation, temperatures: tuple[float, ...]) -> int:
    """Print the wave at several temperatures."""
    from studies.report.warm_surface import warm_answer, warm_half_space

    answer = warm_half_space(arguments.material, temperatures, orientation=orientation, surface=arguments.surface)
    print_answer(arguments, answer, warm_answer(answer))
    return 0


def _layered(arguments: argparse.Namespace, orientation) -> int:
    """Print the bound waves of layers on a half-space."""
    from studies.report.layered_surface import layered_answer, layered_surface_wave
    from studies.scene.quantity import si_value

    frequency = None
    if arguments.frequency is not None:
        frequency = si_value("--frequency", toml_value(arguments.frequency), "Hz")
    options = {"orientation": orientation, "surface": arguments.surface, "frequency": frequency}
    answer = layered_surface_wave(arguments.material, arguments.layer, **options)
    print_answer(arguments, answer, layered_answer(answer))
    return 0
