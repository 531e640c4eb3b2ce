"""The command line: calls, options and their help."""

import argparse

from studies.refusal import SceneError

__all__ = ["parser"]


class OneSentence(argparse.ArgumentParser):
    """A parser that refuses with one sentence and no usage text."""

    def error(self, message: str):
        """Raise instead of printing usage and leaving."""
        raise SceneError("", f"{message} (see {self.prog} --help)")


class Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(self, parser, *_):
        """Print and leave."""
        from importlib.metadata import version

        print(f"sawmotor {version('sawmotor')}")
        parser.exit()


def parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command."""
    top = OneSentence(
        prog="sawmotor",
        description="Surface-acoustic-wave motors from drive voltage to slider velocity.",
        epilog="Exit code 0: an answer within its tolerance; 1: the run could not give one; 2: bad input.",
        allow_abbrev=False,
    )
    top.add_argument("--version", action=Version, nargs=0, help="print the version and leave")
    calls = top.add_subparsers(dest="call", metavar="COMMAND", parser_class=OneSentence)

    run = _call(
        calls, "run", "a scene: just the chain that it needs, up to the slider's velocity for each voltage"
    )
    run.add_argument(
        "scene", metavar="SCENE", nargs="?", default="twente", help="a path or a shipped name (twente)"
    )
    _changes(run)
    run.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the last quantity (1e-3)"
    )
    run.add_argument("--out", metavar="DIR", help="where the results go (results/NAME)")
    run.add_argument(
        "--json", action="store_true", help="run.json on stdout; no pictures, files only with --out"
    )
    run.add_argument(
        "--field",
        action="store_true",
        help="keep the whole wave field in field.vtu, and the surface in surface_map.vtu and .csv",
    )
    run.add_argument("--no-plot", action="store_true", help="draw nothing")
    run.add_argument(
        "--plot", action="store_true", help="show the pictures in windows when the run has ended"
    )
    run.add_argument(
        "--measured",
        metavar="FILE",
        help="CSV of measured points (voltage_V, velocity_m_per_s, perhaps error_m_per_s) to compare with",
    )
    run.add_argument(
        "--report",
        action="store_true",
        help="write report.html too: everything about the run on one self-contained page",
    )
    run.add_argument(
        "--explain",
        action="store_true",
        help="say what would be computed, its size, time and memory, and stop",
    )

    wave = _call(calls, "wave", "the half-space Rayleigh wave of a material, without a mesh and without loss")
    wave.add_argument("material", metavar="MATERIAL", help="a catalogue name, such as PZT-8")
    wave.add_argument(
        "--orientation",
        metavar="O",
        default="Z",
        help="Z, X, YZ, 128YX, ST-X or three angles phi,theta,psi in degrees (Z)",
    )
    wave.add_argument(
        "--surface",
        metavar="S",
        default="vacuum",
        help="vacuum (or free), open, metallised (vacuum)",
    )
    wave.add_argument("--json", action="store_true", help="the answer as JSON")
    wave.add_argument(
        "--plot", metavar="FILE", help="draw the crystal axes in the x-z section into a PNG file"
    )

    _sweep(_call(calls, "sweep", "many points of one scene, here, on processes or on a Dask cluster"))
    scenes = _call(calls, "scenes", "the scenes that ship, or a copy of one to start from")
    scenes.add_argument(
        "--copy", metavar=("NAME", "FILE"), nargs=2, help="write a scene that ships into a new file"
    )
    _call(calls, "schema", "the JSON Schema of a scene, for completion and checks in an editor")
    check = _call(calls, "check", "a scene's text, material and layout, without running it")
    check.add_argument("scene", metavar="SCENE", help="a path or a shipped name")
    _changes(check)

    sheet = _call(
        calls, "datasheet", "a motor's datasheet: one page with speed, force, steps, power and limits"
    )
    sheet.add_argument("scene", metavar="SCENE", help="a path or a shipped name")
    _changes(sheet)
    sheet.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the slider velocity (1e-3)"
    )
    sheet.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-datasheet)")
    sheet.add_argument("--json", action="store_true", help="the numbers on stdout; files only with --out")

    study = _call(calls, "study", "a study, or without a name the list of them")
    study.add_argument("name", metavar="NAME", nargs="?", help="which study")
    study.add_argument(
        "scene", metavar="SCENE", nargs="?", help="a path or a shipped name, for studies of a scene"
    )
    _axes(study)
    study.add_argument("--band", metavar="START:STOP:N", help="network: frequencies in MHz")
    study.add_argument("--z0", metavar="OHM", help="network: reference impedance (50)")
    study.add_argument(
        "--measured", metavar="FILE", help="network: Touchstone file to draw over the prediction"
    )
    study.add_argument(
        "--quick", action="store_true", help="a small version of it, to see what it gives: no evidence"
    )
    study.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-study[-SCENE])")

    _fit(_call(calls, "fit", "numbers of a scene from measured curves, and what the data cannot tell"))
    _design(
        _call(calls, "design", "the best motor within ranges: a search that can be interrupted and goes on")
    )
    _view(_call(calls, "view", "the wave field of a run, in a window, as a picture, a movie, a page or data"))
    return top


def _fit(call: argparse.ArgumentParser) -> None:
    call.add_argument("scene", metavar="SCENE", help="a path or a shipped name")
    call.add_argument(
        "--data",
        metavar=("FILE.csv", "KEY=VALUE"),
        nargs="+",
        action="append",
        default=[],
        help="measured points, and keys that hold for this file alone, such as slider.preload=5e-3 or systematic=0.02 "
        "(a common error of 2 %%); once for each file",
    )
    call.add_argument(
        "--free",
        metavar="KEY=LOW:HIGH",
        nargs="+",
        action="extend",
        default=[],
        help="a number of the scene to be fitted, with its range; also amplitude_per_volt (m/V, a given wave) and "
        "amplitude_factor (on a stator's computed amplitude)",
    )
    _changes(call)
    call.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the slider velocity (1e-3)"
    )
    call.add_argument("--out", metavar="DIR", help="where the results go (results/NAME-fit)")
    call.add_argument("--json", action="store_true", help="fit.json on stdout; files only with --out")
    call.add_argument("--no-plot", action="store_true", help="draw nothing")


def _design(call: argparse.ArgumentParser) -> None:
    call.add_argument("scene", metavar="SCENE", help="a path or a shipped name")
    call.add_argument(
        "--maximise",
        metavar="GOAL",
        action="append",
        default=[],
        help="velocity, thrust, efficiency or step_resolution; twice for the front of two goals",
    )
    call.add_argument(
        "--over",
        metavar="KEY=LOW:HIGH",
        nargs="+",
        action="extend",
        default=[],
        help="a number of the scene to be chosen",
    )
    call.add_argument(
        "--subject",
        metavar="'NAME <= VALUE'",
        nargs="+",
        action="extend",
        default=[],
        help="a bound on a key of the scene or on velocity, thrust, contact_pressure, stick_margin, normal_amplitude, "
        "power_W",
    )
    call.add_argument("--evaluations", metavar="N", type=int, help="of each search (60 for each number)")
    call.add_argument("--seed", metavar="N", type=int, default=0, help="of the random numbers (0)")
    _changes(call)
    call.add_argument("--tolerance", metavar="T", help="of the velocity at each evaluation (3e-2)")
    call.add_argument(
        "--workers", metavar="N", type=int, default=1, help="processes on this machine (1: this one)"
    )
    call.add_argument(
        "--out", metavar="DIR", help="where evaluations and results are kept (results/NAME-design)"
    )
    call.add_argument("--json", action="store_true", help="design.json on stdout")


def _view(call: argparse.ArgumentParser) -> None:
    call.add_argument("run", metavar="RUN_DIR", help="a directory that `sawmotor run` left")
    call.add_argument("--screenshot", metavar="FILE", help="draw off screen into a PNG file")
    call.add_argument("--movie", metavar="FILE", help="one period of the wave as .gif or .mp4")
    call.add_argument("--html", metavar="FILE", help="a page that moves and zooms in any browser, offline")
    call.add_argument(
        "--data",
        metavar="FILE",
        help=".vtu (complex field), .pvd (instants of a period) or .csv of the field",
    )
    call.add_argument("--surface", action="store_true", help="--data FILE.csv of the surface alone")
    call.add_argument(
        "--show", metavar="WHAT", help="field, solid (the whole width), beam (from above) or contact (field)"
    )
    call.add_argument(
        "--quantity",
        metavar="Q",
        default="u_z",
        help="what colours it: u_z, u_x, u_y, potential, strain_energy, power_flow (u_z)",
    )
    call.add_argument("--phase", metavar="DEGREES", default="0", help="the instant, omega t (0)")
    call.add_argument("--span", metavar="SPAN", help="whole, slider, wavelength or START:STOP in mm")
    call.add_argument(
        "--scale", metavar="TIMES", help="by which the displacement is enlarged (so that it is seen)"
    )
    call.add_argument("--size", metavar="WxH", help="pixels of the picture or movie")
    call.add_argument("--frames", metavar="N", help="pictures of a movie (24), instants of a .pvd (12)")
    call.add_argument(
        "--voltage", metavar="V", help="of the contact; of a given wave its amplitude in m (the largest)"
    )


def _call(calls, name: str, text: str) -> argparse.ArgumentParser:
    return calls.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".", allow_abbrev=False)


def _sweep(call: argparse.ArgumentParser) -> None:
    call.add_argument("scene", metavar="SCENE", help="a path or a shipped name")
    _changes(call)
    _axes(call)
    call.add_argument("--points", metavar="FILE", help="a CSV file of points, keys in its first line")
    call.add_argument(
        "--samples", metavar="N", type=int, help="points of the Latin hypercube of START:STOP:latin"
    )
    call.add_argument("--seed", metavar="N", type=int, default=0, help="of the Latin hypercube (0)")
    call.add_argument(
        "--also",
        metavar="LIST",
        default="",
        help="beside the velocity: limits (threshold, release), thrust (blocked), efficiency, pressure, "
        "step (of one cycle)",
    )
    call.add_argument(
        "--tolerance", metavar="T", help="bound of the relative error of the last quantity (1e-3)"
    )
    call.add_argument(
        "--workers", metavar="N", type=int, default=1, help="processes on this machine (1: this one)"
    )
    call.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler, e.g. tcp://127.0.0.1:8786")
    call.add_argument("--out", metavar="DIR", help="where the points are kept (results/NAME-sweep)")
    call.add_argument("--json", action="store_true", help="the summary as JSON on stdout")


def _axes(call: argparse.ArgumentParser) -> None:
    call.add_argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help='an axis: START:STOP:N, START:STOP:N:log or a list, e.g. slider.preload="1 mN:100 mN:50"',
    )


def _changes(call: argparse.ArgumentParser) -> None:
    call.add_argument("--voltage", metavar="LIST", help="peak voltages: START:STOP:N or a list with commas")
    call.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help='change one key, e.g. slider.mass=1e-4 or transducer.1.center="900 mm"',
    )
