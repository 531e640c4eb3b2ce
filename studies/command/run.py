"""``sawmotor run``: the parts of the chain that a scene needs, up to the slider's velocity at each voltage."""

import argparse
import logging
from contextlib import ExitStack, nullcontext
from dataclasses import replace

from studies.command.options import add_shared
from studies.command.output import committed_pictures, print_answer, results_of, say, warn, warn_of_scene
from studies.command.scene_argument import changed_scene, read_tolerance
from studies.progress import Progress
from studies.refusal import needed, refuse_if

LOGGER = logging.getLogger(__name__)

HELP = "compute a scene, up to the slider's velocity at each voltage"
EXAMPLE = "sawmotor run twente --voltage 20,40 --set slider.mass=1e-4 --out results/light"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("scene", nargs="?", default="twente", metavar="SCENE", help="a path or a shipped name (twente)")
    add_shared(parser, "--voltage", "--set", "--tolerance")
    parser.add_argument("--out", metavar="DIR", help="where the results go (results/NAME)")
    parser.add_argument("--json", action="store_true", help="run.json on stdout; no pictures, files only with --out")
    field = "keep the whole wave field in field.vtu, and the surface in surface_map.vtu and .csv"
    parser.add_argument("--field", action="store_true", help=field)
    add_shared(parser, "--netcdf", "--no-plot")
    parser.add_argument("--plot", action="store_true", help="show the pictures in windows when the run has ended")
    measured = "measured velocities (voltage_V, velocity_m_per_s), a burst's trace or a vibrometer's scan"
    parser.add_argument("--measured", metavar="FILE", help=measured)
    parser.add_argument(
        "--report",
        nargs="?",
        const="html",
        choices=("html", "pdf"),
        help="also write report.html, the whole run on one self-contained page; pdf: report.pdf, one page A4",
    )
    add_shared(parser, "--explain")


def _compiled_aside(scene):
    """Return a context in which a kernel that the scene needs is compiled aside, while the stator is solved."""
    if scene.slider is None or scene.slider.tangential_law != "elastic":
        return nullcontext()
    from contact import compiled_aside

    return compiled_aside()


def call(arguments: argparse.Namespace) -> int:
    """Run the chain of a scene; print its answer and write its files."""
    from studies.record.files import write_netcdf, write_run
    from studies.record.text import answer
    from studies.report.drawing import Drawing
    from studies.report.explanation import expected_seconds, explanation, long_wait, plan
    from studies.runs import run as run_chain

    tolerance, scene = read_tolerance(arguments.tolerance), changed_scene(arguments)
    measured = None
    if arguments.measured is not None:
        from studies.lab.measurement_csv import read_measured
        from studies.record.velocity_comparison import refuse_incomparable

        measured = read_measured(arguments.measured)
        refuse_incomparable(scene, measured)
    if arguments.explain:
        with Progress():
            planned = plan(scene, tolerance=tolerance)
        print_answer(arguments, planned, explanation(planned))
        return 0
    if arguments.plot:
        from studies.record.plots import refuse_without_toolkit, show
        from studies.record.run_pictures import pictures

        refuse_without_toolkit("--plot", "without it the same pictures are files in the result directory")
    if arguments.netcdf:
        needed("xarray", "--netcdf")
    for option in ("report", "field", "netcdf"):
        refuse_if(
            getattr(arguments, option) and arguments.json and arguments.out is None,
            f"--{option}",
            "needs a directory to go to: give --out, or leave --json out",
        )
    refuse_if(
        arguments.field and not scene.transducer,
        "--field",
        "keeps the field of a driven stator, and this scene has no [[transducer]]",
    )
    with Progress():
        expected = expected_seconds(scene, tolerance=tolerance)
    warned = warn_of_scene(scene)
    say(long_wait(expected))
    with ExitStack() as stack:
        result, out = stack.enter_context(results_of(arguments, "run", ""))
        plotted = result is not None and not (arguments.json or arguments.no_plot)
        drawing = stack.enter_context(Drawing()) if plotted else None
        with Progress(expected), _compiled_aside(scene):
            record = run_chain(scene, tolerance=tolerance)
            if measured is not None:
                from studies.solve.measured_run import measured_block

                record = replace(record, measured=measured_block(record, measured))
            whole = record.to_dict()
            if result is not None:
                LOGGER.info("writing the results")
                write_run(record, result.folder, field=arguments.field)
                if arguments.netcdf:
                    write_netcdf(record.to_xarray(), result.folder / "run.nc")
                result.commit()
                with committed_pictures(result):
                    if arguments.report == "pdf":
                        from studies.report.printed import FILE, write_pdf

                        write_pdf(record, result.folder / FILE)
                    elif arguments.report:
                        from studies.report.page import TEMPLATE, report

                        (result.folder / TEMPLATE).write_text(
                            report(record, arguments.scene_file.table), encoding="utf-8"
                        )
                    if drawing is not None:
                        drawing.draw(record, result.folder)
    print_answer(arguments, whole, f"{answer(record)}\nresults         {out}")
    warn(each for each in record.warnings if each not in warned)
    say([record.shortfall] if record.shortfall else [])
    if arguments.plot:
        show(*pictures(record).values())
    return record.exit_code
