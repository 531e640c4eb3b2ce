"""``sawmotor view``: the wave field of a run, in a window, as a picture, a movie, a page or data."""

import argparse

from studies.command.options import add_shared
from studies.command.output import say
from studies.progress import Progress

HELP = "show the wave field of a run: in a window, or as a picture, movie, page or data file"
EXAMPLE = "sawmotor view results/twente --screenshot wave.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("run", metavar="RUN_DIR", help="a directory that `sawmotor run` left")
    parser.add_argument("--screenshot", metavar="FILE", help="draw off screen into a PNG file")
    parser.add_argument("--movie", metavar="FILE", help="one period of the wave as .gif or .mp4")
    parser.add_argument("--html", metavar="FILE", help="a page that moves and zooms in any browser, offline")
    parser.add_argument(
        "--data", metavar="FILE", help=".vtu (complex field), .pvd (instants of a period) or .csv of the field"
    )
    parser.add_argument("--surface", action="store_true", help="--data FILE.csv of the surface alone")
    parser.add_argument(
        "--show", metavar="WHAT", help="field, solid (the whole width), beam (from above) or contact (field)"
    )
    parser.add_argument(
        "--quantity",
        default="u_z",
        metavar="Q",
        help="what colours it: u_z, u_x, u_y, potential, strain_energy, power_flow (u_z)",
    )
    parser.add_argument("--phase", default="0", metavar="DEGREES", help="the instant, omega t (0)")
    parser.add_argument("--span", metavar="SPAN", help="whole, slider, wavelength or START:STOP in mm")
    parser.add_argument("--scale", metavar="TIMES", help="by which the displacement is enlarged (so that it is seen)")
    parser.add_argument("--size", metavar="WxH", help="pixels of the picture or movie")
    parser.add_argument("--frames", metavar="COUNT", help="pictures of a movie (24), instants of a .pvd (12)")
    parser.add_argument(
        "--voltage", metavar="V", help="of the contact; of a prescribed wave its amplitude in m (the largest)"
    )
    add_shared(parser, "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Show a run in a window, or draw it into files and name them."""
    from studies.record.plots import leave_out_property_tables

    leave_out_property_tables()
    from studies.report.explained_calls import explained_view, field_seconds
    from studies.view import view as show
    from studies.view.run_field import saved_run
    from studies.view.view_options import Wanted

    wanted = Wanted.read(arguments)
    record = saved_run(arguments.run)
    if arguments.explain:
        shown = wanted.show or ("field" if record.scene.stator is not None else "contact")
        print(explained_view(record, shown, tuple(wanted.files.values())))
        return 0
    with Progress(field_seconds(record.scene, tolerance=record.tolerance)):
        show(record, wanted, note=lambda text: say([text]))
    print("\n".join(wanted.files.values()), end="\n" if wanted.files else "")
    return 0
