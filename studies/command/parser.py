"""The command line: calls, options and their help."""

import argparse

from studies.refusal import SceneError

SCENE = "a path or a shipped name"
VELOCITY = "bound of the relative error of the slider velocity (1e-3)"


class Call(argparse.ArgumentParser):
    """A parser that refuses with one sentence and no usage text."""

    def error(self, message: str):
        """Raise instead of printing usage and leaving."""
        raise SceneError("", f"{message} (see {self.prog} --help)")

    def value(self, name: str, metavar, text: str, **more) -> None:
        """Add an argument, or an option with a value."""
        self.add_argument(name, metavar=metavar, help=text, **more)

    def values(self, name: str, metavar, text: str, action: str = "extend", **more) -> None:
        """Add an option whose values are collected."""
        nargs = {"nargs": "+"} if action == "extend" else {}
        self.add_argument(name, metavar=metavar, help=text, action=action, default=[], **(nargs | more))

    def flag(self, name: str, text: str) -> None:
        """Add an option without a value."""
        self.add_argument(name, action="store_true", help=text)

    def changes(self) -> None:
        """Add the options that change a scene."""
        self.value("--voltage", "LIST", "peak voltages: START:STOP:N or a list with commas")
        text = 'change one key, e.g. slider.mass=1e-4 or transducer.1.center="900 mm"'
        self.values("--set", "KEY=VALUE", text, "append")

    def axes(self) -> None:
        """Add the axes of a sweep."""
        text = 'an axis: START:STOP:N, START:STOP:N:log or a list, e.g. slider.preload="1 mN:100 mN:50"'
        self.values("--over", "KEY=VALUES", text, "append")


class Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(self, parser, *_):
        """Print and leave."""
        from importlib.metadata import version

        print(f"sawmotor {version('sawmotor')}")
        parser.exit()


def parser() -> Call:
    """Return the parser of the whole command."""
    top = Call(
        prog="sawmotor",
        description="Surface-acoustic-wave motors from drive voltage to slider velocity.",
        epilog="Exit code 0: an answer within its tolerance; 1: the run could not give one; 2: bad input.",
        allow_abbrev=False,
    )
    top.add_argument("--version", action=Version, nargs=0, help="print the version and leave")
    calls = top.add_subparsers(dest="call", metavar="COMMAND", parser_class=Call)
    for name, (text, fill) in CALLS.items():
        call = calls.add_parser(
            name, help=text, description=text[0].upper() + text[1:] + ".", allow_abbrev=False
        )
        fill(call)
    return top


def _run(call: Call) -> None:
    call.value("scene", "SCENE", "a path or a shipped name (twente)", nargs="?", default="twente")
    call.changes()
    call.value("--tolerance", "T", "bound of the relative error of the last quantity (1e-3)")
    call.value("--out", "DIR", "where the results go (results/NAME)")
    call.flag("--json", "run.json on stdout; no pictures, files only with --out")
    text = "keep the whole wave field in field.vtu, and the surface in surface_map.vtu and .csv"
    call.flag("--field", text)
    call.flag("--no-plot", "draw nothing")
    call.flag("--plot", "show the pictures in windows when the run has ended")
    text = "CSV of measured points (voltage_V, velocity_m_per_s, perhaps error_m_per_s) to compare with"
    call.value("--measured", "FILE", text)
    call.flag("--report", "write report.html too: everything about the run on one self-contained page")
    call.flag("--explain", "say what would be computed, its size, time and memory, and stop")


def _wave(call: Call) -> None:
    call.value("material", "MATERIAL", "a catalogue name, such as PZT-8")
    text = "Z, X, YZ, 128YX, ST-X or three angles phi,theta,psi in degrees (Z)"
    call.value("--orientation", "O", text, default="Z")
    call.value("--surface", "S", "vacuum (or free), open, metallised (vacuum)", default="vacuum")
    call.flag("--json", "the answer as JSON")
    call.value("--plot", "FILE", "draw the crystal axes in the x-z section into a PNG file")


def _sweep(call: Call) -> None:
    call.value("scene", "SCENE", SCENE)
    call.changes()
    call.axes()
    call.value("--points", "FILE", "a CSV file of points, keys in its first line")
    call.value("--samples", "N", "points of the Latin hypercube of START:STOP:latin", type=int)
    call.value("--seed", "N", "of the Latin hypercube (0)", type=int, default=0)
    text = "beside the velocity: limits (threshold, release), thrust (blocked), efficiency, pressure, "
    call.value("--also", "LIST", text + "step (of one cycle)", default="")
    call.value("--tolerance", "T", "bound of the relative error of the last quantity (1e-3)")
    call.value("--workers", "N", "processes on this machine (1: this one)", type=int, default=1)
    call.value("--scheduler", "ADDRESS", "of a Dask scheduler, e.g. tcp://127.0.0.1:8786")
    call.value("--out", "DIR", "where the points are kept (results/NAME-sweep)")
    call.flag("--json", "the summary as JSON on stdout")


def _scenes(call: Call) -> None:
    call.value("--copy", ("NAME", "FILE"), "write a scene that ships into a new file", nargs=2)


def _check(call: Call) -> None:
    call.value("scene", "SCENE", SCENE)
    call.changes()


def _datasheet(call: Call) -> None:
    call.value("scene", "SCENE", SCENE)
    call.changes()
    call.value("--tolerance", "T", VELOCITY)
    call.value("--out", "DIR", "where the results go (results/NAME-datasheet)")
    call.flag("--json", "the numbers on stdout; files only with --out")


def _study(call: Call) -> None:
    call.value("name", "NAME", "which study", nargs="?")
    call.value("scene", "SCENE", "a path or a shipped name, for studies of a scene", nargs="?")
    call.axes()
    call.value("--band", "START:STOP:N", "network: frequencies in MHz")
    call.value("--z0", "OHM", "network: reference impedance (50)")
    call.value("--measured", "FILE", "network: Touchstone file to draw over the prediction")
    call.flag("--quick", "a small version of it, to see what it gives: no evidence")
    call.value("--out", "DIR", "where the results go (results/NAME-study[-SCENE])")


def _fit(call: Call) -> None:
    call.value("scene", "SCENE", SCENE)
    text = "measured points, and keys that hold for this file alone, such as slider.preload=5e-3 or systematic=0.02 "
    text += "(a common error of 2 %%); once for each file"
    call.values("--data", ("FILE.csv", "KEY=VALUE"), text, "append", nargs="+")
    text = (
        "a number of the scene to be fitted, with its range; also amplitude_per_volt (m/V, a given wave) and "
    )
    call.values("--free", "KEY=LOW:HIGH", text + "amplitude_factor (on a stator's computed amplitude)")
    call.changes()
    call.value("--tolerance", "T", VELOCITY)
    call.value("--out", "DIR", "where the results go (results/NAME-fit)")
    call.flag("--json", "fit.json on stdout; files only with --out")
    call.flag("--no-plot", "draw nothing")


def _design(call: Call) -> None:
    call.value("scene", "SCENE", SCENE)
    text = "velocity, thrust, efficiency or step_resolution; twice for the front of two goals"
    call.values("--maximise", "GOAL", text, "append")
    call.values("--over", "KEY=LOW:HIGH", "a number of the scene to be chosen")
    text = "a bound on a key of the scene or on velocity, thrust, contact_pressure, stick_margin, normal_amplitude, "
    call.values("--subject", "'NAME <= VALUE'", text + "power_W")
    call.value("--evaluations", "N", "of each search (60 for each number)", type=int)
    call.value("--seed", "N", "of the random numbers (0)", type=int, default=0)
    call.changes()
    call.value("--tolerance", "T", "of the velocity at each evaluation (3e-2)")
    call.value("--workers", "N", "processes on this machine (1: this one)", type=int, default=1)
    call.value("--out", "DIR", "where evaluations and results are kept (results/NAME-design)")
    call.flag("--json", "design.json on stdout")


def _view(call: Call) -> None:
    call.value("run", "RUN_DIR", "a directory that `sawmotor run` left")
    call.value("--screenshot", "FILE", "draw off screen into a PNG file")
    call.value("--movie", "FILE", "one period of the wave as .gif or .mp4")
    call.value("--html", "FILE", "a page that moves and zooms in any browser, offline")
    call.value("--data", "FILE", ".vtu (complex field), .pvd (instants of a period) or .csv of the field")
    call.flag("--surface", "--data FILE.csv of the surface alone")
    call.value("--show", "WHAT", "field, solid (the whole width), beam (from above) or contact (field)")
    text = "what colours it: u_z, u_x, u_y, potential, strain_energy, power_flow (u_z)"
    call.value("--quantity", "Q", text, default="u_z")
    call.value("--phase", "DEGREES", "the instant, omega t (0)", default="0")
    call.value("--span", "SPAN", "whole, slider, wavelength or START:STOP in mm")
    call.value("--scale", "TIMES", "by which the displacement is enlarged (so that it is seen)")
    call.value("--size", "WxH", "pixels of the picture or movie")
    call.value("--frames", "N", "pictures of a movie (24), instants of a .pvd (12)")
    call.value("--voltage", "V", "of the contact; of a given wave its amplitude in m (the largest)")


CALLS = {
    "run": ("a scene: just the chain that it needs, up to the slider's velocity for each voltage", _run),
    "wave": ("the half-space Rayleigh wave of a material, without a mesh and without loss", _wave),
    "sweep": ("many points of one scene, here, on processes or on a Dask cluster", _sweep),
    "scenes": ("the scenes that ship, or a copy of one to start from", _scenes),
    "schema": ("the JSON Schema of a scene, for completion and checks in an editor", lambda call: None),
    "check": ("a scene's text, material and layout, without running it", _check),
    "datasheet": ("a motor's datasheet: one page with speed, force, steps, power and limits", _datasheet),
    "study": ("a study, or without a name the list of them", _study),
    "fit": ("numbers of a scene from measured curves, and what the data cannot tell", _fit),
    "design": ("the best motor within ranges: a search that can be interrupted and goes on", _design),
    "view": ("the wave field of a run, in a window, as a picture, a movie, a page or data", _view),
}
