"""``sawmotor export``: a run or a scene as a file for other programs."""

import argparse
import re
from contextlib import nullcontext
from importlib import import_module
from pathlib import Path
from typing import Any

from studies.command.options import add_shared
from studies.command.output import committed_pictures, results_folder, say
from studies.command.scene_argument import changed_scene, read_tolerance
from studies.export.exported import Exported
from studies.progress import Progress
from studies.refusal import SceneError, refuse_if, refuse_unwritable, resembling
from studies.results import Origin, read_manifest, result_directory
from studies.scene import Scene

HELP = "export a run or a scene: a motor for simulators, a mask, or what laboratory instruments would record"
EXAMPLE = "sawmotor export twente --format gds --out mask.gds"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "scene", metavar="RUN_OR_SCENE", help="a directory that `sawmotor run` left, a path or a shipped name"
    )
    parser.add_argument("--format", metavar="FORMAT", help="fmu, c, gds, dxf, uff, touchstone, csv, vtu")
    parser.add_argument("--fmi", metavar="VERSION", help="fmu: 3 or 2 (3)")
    parser.add_argument(
        "--size", action="append", default=[], metavar="KEY=VALUE",
        help='gds, dxf: busbar, end_gap, pad, mark, margin or grid, e.g. grid="5 nm"; once for each',
    )  # fmt: skip
    parser.add_argument("--scan", metavar="WAY", help="uff, csv: x, y, xy or frequency (x)")
    parser.add_argument("--band", metavar="START:STOP:N", help="touchstone, --scan frequency: frequencies in MHz")
    parser.add_argument("--z0", metavar="OHM", help="touchstone: reference impedance (50)")
    noise = "uff, csv, touchstone: standard deviation over the largest value, e.g. 1e-2 or 1%%"
    parser.add_argument("--noise", metavar="SHARE", help=noise)
    parser.add_argument("--seed", type=int, metavar="N", help="of the noise")
    parser.add_argument(
        "--bandwidth", metavar="FREQUENCY", help='csv, of a burst: low-pass filter of the encoder, e.g. "500 Hz"'
    )
    parser.add_argument(
        "--sampling", metavar="TIME", help='csv, of a burst: time over which each reading is averaged, e.g. "1 ms"'
    )
    add_shared(parser, "--voltage", "--set", "--tolerance")
    out = "a directory, or a file such as net.s2p where there is one (results/NAME-export-FORMAT)"
    parser.add_argument("--out", metavar="PATH", help=out)
    add_shared(parser, "--explain", "--no-plot")


def call(arguments: argparse.Namespace) -> int:
    """Write a run or a scene in a format of other programs."""
    from studies.record.text import labelled
    from studies.report.explanation import long_wait

    checked(arguments)
    source, name = arguments.scene, Path(arguments.scene).stem
    arguments.scene = scene_of(source)
    tolerance, scene = read_tolerance(arguments.tolerance), changed_scene(arguments)
    out = results_folder(arguments, f"{name}-export-{arguments.format}")
    origin, named = Origin(kind="export", name=f"{arguments.format} of {name}"), arguments.out is not None
    alone = named and names_file(out, arguments, scene)
    with Progress():
        contents, seconds = expected_export(arguments, scene, tolerance=tolerance)
    if arguments.explain:
        from studies.report.explained_calls import explained_export

        print(explained_export(arguments.format, contents, seconds))
        return 0
    say(long_wait(seconds))
    target = nullcontext() if alone else result_directory(out, origin, named_by_user=named)
    with target as result, Progress(seconds):
        done = exported(arguments, scene, name, tolerance=tolerance)
        if result is None:
            done.write_alone(out)
        else:
            done.write(result.folder)
            result.commit()
            if done.pictures and not arguments.no_plot:
                from studies.record.plots import leave_out_property_tables, saved

                leave_out_property_tables()
                with committed_pictures(result):
                    for file, draw in done.pictures.items():
                        saved(result.folder / file, draw)
    say([] if result is None else result.notes)
    print("\n".join([*labelled(done.answer, 16), f"{'results':<16}{out}"]))
    say(done.remarks)
    return 0


RECORDED = ("uff", "csv", "touchstone")  # formats of instruments
# by format: pattern of file endings, module of studies.export that writes it, and its options in addition to those of
# the scene
FORMATS = {
    "fmu": (r"\.fmu", "simulators", ("fmi",)),
    "c": (r"\.[ch]", "simulators", ()),
    "gds": (r"\.gds", "mask_files", ("size",)),
    "dxf": (r"\.dxf", "mask_files", ("size",)),
    "uff": (r"\.uff", "instruments", ("scan", "band", "noise", "seed")),
    "csv": (r"\.csv", "instruments", ("scan", "band", "noise", "seed", "bandwidth", "sampling")),
    "touchstone": (r"\.s\d+p", "instruments", ("band", "z0", "noise", "seed")),
    "vtu": (r"\.vtu", "instruments", ()),
}


def names_file(out: Path, arguments: argparse.Namespace, scene: Scene) -> bool:
    """Return whether --out names the only file of an export, not a directory.

    Raises
    ------
    SceneError
        If the file exists, has another format, or would be one of several.
    """
    suffix, file_format = out.suffix.lower(), arguments.format
    formats = [name for name, (pattern, *_) in FORMATS.items() if re.fullmatch(pattern, suffix)]
    if not formats or (out.is_dir() and read_manifest(out)):
        return False
    rule = f"names a file of the format {formats[0]}, not of {file_format}, got {str(out)!r}"
    refuse_if(file_format not in formats, "--out", rule)
    shaped = file_format == "fmu" and scene.source is not None and scene.source.waveform is not None
    several = file_format == "csv" and arguments.scan is None and scene.slider is not None
    more = "; --scan x gives one" if file_format == "csv" and scene.transducer else ""
    refuse_if(
        file_format == "c" or shaped or several,
        "--out",
        f"must be a directory, as there are several files, got {str(out)!r}{more}",
    )
    ports = sum(each.has_two_electrodes for each in scene.transducer)
    rule = f"must end in .s{ports}p, as the scene has {ports} ports, or be a directory, got {str(out)!r}"
    refuse_if(file_format == "touchstone" and 0 < ports and suffix != f".s{ports}p", "--out", rule)
    refuse_unwritable(out, "--out", new=True)
    return True


def exported(arguments: argparse.Namespace, scene: Scene, name: str, *, tolerance: float) -> Exported:
    """Return the export of a call without writing it; SceneError for options that the format does not take."""
    options = {"recording": recording_of(arguments)} if arguments.format in RECORDED else given_options(arguments)
    module = import_module(f"studies.export.{FORMATS[arguments.format][1]}")
    return getattr(module, f"{arguments.format}_files")(scene, name, tolerance=tolerance, **options)


def given_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the options of a call that its format takes and that are given, by key."""
    return {key: value for key in checked(arguments) if (value := getattr(arguments, key)) not in (None, [])}


def recording_of(arguments: argparse.Namespace):
    """Return what an instrument records."""
    from studies.export import instruments  # with SciPy's integration: a mask needs neither

    return instruments.Recording(**given_options(arguments))


def expected_export(arguments: argparse.Namespace, scene: Scene, *, tolerance: float) -> tuple[str, float]:
    """Return what an export holds, and the expected time in s."""
    from studies.report.explained_calls import field_seconds, mask_seconds, motor_seconds

    file_format = arguments.format
    if file_format in ("gds", "dxf"):
        return "layout of the transducers: the stator is not solved", mask_seconds(scene)
    if file_format in ("fmu", "c") or (file_format == "csv" and arguments.scan is None and scene.slider is not None):
        contents = "stator over a band for its ring-up, and tables of mean forces"
        return contents, motor_seconds(scene, tolerance=tolerance)
    if file_format == "touchstone" or arguments.scan == "frequency":
        from studies.export import instruments

        seconds = instruments.expected_seconds(scene, recording_of(arguments), tolerance)
        return "admittances, or motions, over a band of frequencies", seconds
    return "motion at the surface: the stator is solved once", field_seconds(scene, tolerance=tolerance)


def checked(arguments: argparse.Namespace) -> tuple[str, ...]:
    """Return the option names of the format; SceneError for a wrong format or an option of another one."""
    file_format = arguments.format
    refuse_if(file_format is None, "--format", f"is missing; known: {', '.join(FORMATS)}")
    if file_format not in FORMATS:
        rule = f"{file_format!r} is not one of {', '.join(FORMATS)}{resembling(file_format, FORMATS)}"
        raise SceneError("--format", rule)
    *_, own = FORMATS[file_format]
    every = {option for *_, options in FORMATS.values() for option in options}
    for option in sorted(every - set(own)):
        refuse_if(
            getattr(arguments, option) not in (None, []), f"--{option}", f"is not taken by the format {file_format}"
        )
    return own


def scene_of(word: str) -> str:
    """Return the scene of a run's directory, or the word itself.

    Raises
    ------
    SceneError
        If a directory holds no run.
    """
    if not Path(word).is_dir():
        return word
    scene = Path(word) / "scene.toml"
    refuse_if(not scene.is_file(), "export", f"{word!r} holds no run: scene.toml is missing")
    return str(scene)
