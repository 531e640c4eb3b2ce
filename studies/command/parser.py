"""The command line: calls, options and their help, as tables of text.

A line ``NAME METAVAR | help`` is an argument: ``name?`` may be absent, ``--name=3`` has a default, ``--name*`` may be
given again and ``--name+`` takes several, metavariables are separated by commas, ``N`` is an integer, and what has no
metavariable is a flag.  A line of names alone takes them from `COMMON`.
"""

import argparse
import re

from studies.refusal import SceneError

COMMON = """
scene SCENE | a path or a shipped name
--voltage LIST | peak voltages: START:STOP:N or a list with commas
--set* KEY=VALUE | change one key, e.g. slider.mass=1e-4 or transducer.1.center="900 mm"
--over* KEY=VALUES | an axis: START:STOP:N, START:STOP:N:log or a list, e.g. slider.preload="1 mN:100 mN:50"
--tolerance T | bound of the relative error of the slider velocity (1e-3)
--workers=1 N | processes on this machine (1: this one)
--no-plot | draw nothing
"""
CALLS = {
    "run": """a scene: just the chain that it needs, up to the slider's velocity for each voltage
scene?=twente SCENE | a path or a shipped name (twente)
--voltage --set
--tolerance T | bound of the relative error of the last quantity (1e-3)
--out DIR | where the results go (results/NAME)
--json | run.json on stdout; no pictures, files only with --out
--field | keep the whole wave field in field.vtu, and the surface in surface_map.vtu and .csv
--no-plot
--plot | show the pictures in windows when the run has ended
--measured FILE | measured velocities (voltage_V, velocity_m_per_s), scan (x_m, u_z_...) or trace (time_s), CSV or UFF
--report | write report.html too: everything about the run on one self-contained page
--explain | say what would be computed, its size, time and memory, and stop
""",
    "wave": """the half-space Rayleigh wave of a material, without a mesh and without loss
material MATERIAL | a catalogue name, such as PZT-8
--orientation=Z O | Z, X, YZ, 128YX, ST-X or three angles phi,theta,psi in degrees (Z)
--surface=vacuum S | vacuum (or free), open, metallised (vacuum)
--json | the answer as JSON
--plot FILE | draw the crystal axes in the x-z section into a PNG file
""",
    "sweep": """many points of one scene, here, on processes or on a Dask cluster
scene --voltage --set --over
--points FILE | a CSV file of points, keys in its first line
--also= LIST | beside the velocity: limits (threshold, release), thrust (blocked), efficiency, pressure, step (cycle)
--tolerance T | bound of the relative error of the last quantity (1e-3)
--workers
--scheduler ADDRESS | of a Dask scheduler, e.g. tcp://127.0.0.1:8786
--out DIR | where the points are kept (results/NAME-sweep)
--json | the summary as JSON on stdout
""",
    "scenes": """the scenes that ship, or a copy of one to start from
--copy NAME,FILE | write a scene that ships into a new file
""",
    "schema": "the JSON Schema of a scene, for completion and checks in an editor",
    "check": """a scene's text, material and layout, without running it
scene --voltage --set
""",
    "datasheet": """a motor's datasheet: one page with speed, force, steps, power and limits
scene --voltage --set --tolerance
--out DIR | where the results go (results/NAME-datasheet)
--json | the numbers on stdout; files only with --out
""",
    "study": """a study, or without a name the list of them
name? NAME | which study
scene? SCENE | a path or a shipped name, for studies of a scene
--over
--band START:STOP:N | network: frequencies in MHz
--z0 OHM | network: reference impedance (50)
--measured FILE | network: Touchstone file; beam, frequency_response: vibrometer's scan, CSV or UFF; drawn over
--quick | a small version of it, to see what it gives: no evidence
--out DIR | where the results go (results/NAME-study[-SCENE])
""",
    "fit": """numbers of a scene from measured curves, and what the data cannot tell
scene
--data*+ FILE.csv,KEY=VALUE | measured points, and keys of this file alone, e.g. systematic=0.02; once for each file
--free+ KEY=LOW:HIGH | a number to be fitted; also amplitude_per_volt (m/V, given wave), amplitude_factor (computed)
--voltage --set --tolerance
--out DIR | where the results go (results/NAME-fit)
--json | fit.json on stdout; files only with --out
--no-plot
""",
    "design": """the best motor within ranges: a search that can be interrupted and goes on
scene
--maximise* GOAL | velocity, thrust, efficiency or step_resolution; twice for the front of two goals
--over+ KEY=LOW:HIGH | a number of the scene to be chosen
--subject+ 'NAME <= VALUE' | on a key, velocity, thrust, contact_pressure, stick_margin, normal_amplitude or power_W
--evaluations N | of each search (60 for each number)
--seed=0 N | of the random numbers (0)
--voltage --set
--tolerance T | of the velocity at each evaluation (3e-2)
--workers
--out DIR | where evaluations and results are kept (results/NAME-design)
--json | design.json on stdout
""",
    "help": """what a word of the output means, or without one the words that are explained
word? WORD | such as ledger, or "stick margin"
""",
    "export": """a run or a scene for others: a motor for simulators, a mask, what a lab's instruments would record
scene RUN_OR_SCENE | a directory that `sawmotor run` left, a path or a shipped name
--format FORMAT | fmu, c, gds, dxf, uff, touchstone, csv, vtu
--fmi VERSION | fmu: 3 or 2 (3)
--size* KEY=VALUE | gds, dxf: busbar, end_gap, pad, mark, margin or grid, e.g. grid="5 nm"; once for each
--scan WAY | uff, csv: x, y, xy or frequency (x)
--band START:STOP:N | touchstone, --scan frequency: frequencies in MHz
--z0 OHM | touchstone: reference impedance (50)
--noise SHARE | uff, csv, touchstone: standard deviation over the largest value, e.g. 1e-2 or 1%
--seed N | of the noise
--voltage --set --tolerance
--out PATH | a directory, or the file where there is one (results/NAME-export-FORMAT)
--no-plot
""",
    "view": """the wave field of a run, in a window, as a picture, a movie, a page or data
run RUN_DIR | a directory that `sawmotor run` left
--screenshot FILE | draw off screen into a PNG file
--movie FILE | one period of the wave as .gif or .mp4
--html FILE | a page that moves and zooms in any browser, offline
--data FILE | .vtu (complex field), .pvd (instants of a period) or .csv of the field
--surface | --data FILE.csv of the surface alone
--show WHAT | field, solid (the whole width), beam (from above) or contact (field)
--quantity=u_z Q | what colours it: u_z, u_x, u_y, potential, strain_energy, power_flow (u_z)
--phase=0 DEGREES | the instant, omega t (0)
--span SPAN | whole, slider, wavelength or START:STOP in mm
--scale TIMES | by which the displacement is enlarged (so that it is seen)
--size WxH | pixels of the picture or movie
--frames COUNT | pictures of a movie (24), instants of a .pvd (12)
--voltage V | of the contact; of a given wave its amplitude in m (the largest)
""",
}
LINE = re.compile(
    r"(?P<name>[-\w]+)(?P<marks>[?*+]*)(?:=(?P<default>\S*))?(?: (?P<metavar>[^|]+))? \| (?P<help>.*)"
)


class Call(argparse.ArgumentParser):
    """A parser that refuses with one sentence and no usage text."""

    def error(self, message: str):
        """Raise instead of printing usage and leaving."""
        raise SceneError("", f"{message} (see {self.prog} --help)")

    def add_lines(self, lines: list[str]) -> None:
        """Add the arguments of a call's table."""
        common = {LINE.fullmatch(line)["name"]: line for line in COMMON.strip().split("\n")}
        for line in lines:
            if " | " not in line:
                self.add_lines([common[name] for name in line.split()])
                continue
            name, marks, default, metavar, text = LINE.fullmatch(line).groups()
            if metavar is None:
                self.add_argument(name, action="store_true", help=text)
                continue
            metavars = tuple(metavar.split(","))
            several = {"*": "append", "+": "extend", "*+": "append"}.get(marks)
            more = {"action": several, "default": []} if several else {"default": default}
            if "N" in metavars:
                more |= {"type": int, "default": int(default) if default else None}
            nargs = (
                "+" if "+" in marks else "?" if "?" in marks else len(metavars) if len(metavars) > 1 else None
            )
            metavars = metavars if len(metavars) > 1 else metavars[0]
            self.add_argument(name, metavar=metavars, help=text, nargs=nargs, **more)


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
    for name, table in CALLS.items():
        text, *lines = table.rstrip("\n").split("\n")
        description = text[0].upper() + text[1:] + "."
        calls.add_parser(name, help=text, description=description, allow_abbrev=False).add_lines(lines)
    return top
