"""Options that several commands share, as argparse takes them."""

from argparse import ArgumentParser


def add_scene(parser: ArgumentParser) -> None:
    """Add the scene."""
    parser.add_argument("scene", metavar="SCENE", help="a path or a shipped name")


def add_voltage(parser: ArgumentParser) -> None:
    """Add voltages."""
    parser.add_argument("--voltage", metavar="LIST", help="peak voltages: START:STOP:N or a list with commas")


def add_changes(parser: ArgumentParser) -> None:
    """Add changes of keys."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help='change one key, e.g. slider.mass=1e-4 or transducer.1.center="900 mm"',
    )


def add_axes(parser: ArgumentParser) -> None:
    """Add axes."""
    parser.add_argument(
        "--over",
        action="append",
        default=[],
        metavar="KEY=VALUES",
        help='an axis: START:STOP:N, START:STOP:N:log or a list, e.g. slider.preload="1 mN:100 mN:50"',
    )


def add_tolerance(parser: ArgumentParser) -> None:
    """Add the tolerance of the slider velocity."""
    parser.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the slider velocity (1e-3)"
    )


def add_workers(parser: ArgumentParser) -> None:
    """Add processes."""
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="processes on this machine (1: this one)"
    )


def add_no_plot(parser: ArgumentParser) -> None:
    """Add the option that draws nothing."""
    parser.add_argument("--no-plot", action="store_true", help="draw nothing")
