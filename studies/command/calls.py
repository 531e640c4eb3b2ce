"""What each call of the command does, given its parsed arguments; each returns the exit code."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from studies.progress import Progress
from studies.record.files import write_run
from studies.record.text import labelled, print_json
from studies.refusal import InterruptedRunError, SceneError
from studies.results import Origin, ResultDirectory, result_directory
from studies.results.content import write_json
from studies.scene import Scene, SceneFile, read_table, scene_path, shipped_scenes
from studies.scene.numbers import Quantity
from studies.scene.override import axes_given, toml_value
from studies.scene.uncertain import parted


def run(arguments: argparse.Namespace) -> int:
    """Run the chain of a scene; print its answer and leave its files."""
    from studies.chain import run as run_chain
    from studies.record.measured import compared, read_measured, refuse_incomparable
    from studies.record.text import answer
    from studies.report.drawing import Drawing
    from studies.report.explanation import explanation, long_wait, plan

    wanted, scene = tolerance(arguments.tolerance), changed_scene(arguments)
    measured = None if arguments.measured is None else read_measured(arguments.measured)
    if measured is not None:
        refuse_incomparable(scene, measured)
    if arguments.explain:
        planned = plan(scene, tolerance=wanted)
        _show(arguments, planned, explanation(planned))
        return 0
    if arguments.plot:
        from studies.record.plots import pictures, refuse_without_toolkit, show

        refuse_without_toolkit("--plot", "without it the same pictures are files in the result directory")
    for option in ("report", "field"):
        if getattr(arguments, option) and arguments.json and arguments.out is None:
            raise SceneError(f"--{option}", "needs a directory to go to: give --out, or leave --json out")
    if arguments.field and not scene.transducer:
        raise SceneError(
            "--field", "keeps the field of a driven stator, and this scene has no [[transducer]]"
        )
    _say(long_wait(scene, tolerance=wanted))
    with ExitStack() as stack:
        result, out = stack.enter_context(_results(arguments, "run", ""))
        plotted = result is not None and not (arguments.json or arguments.no_plot)
        drawing = stack.enter_context(Drawing()) if plotted else None
        with Progress() as progress:
            record = run_chain(scene, tolerance=wanted, progress=progress)
            if measured is not None and measured.quantity != "velocity":
                from studies.chain.measured_run import beside

                record = replace(record, measured=beside(record, measured, progress=progress))
            elif measured is not None:
                from studies.chain.uncertainty import velocities_at

                progress("velocities at the measured levels")
                predicted = velocities_at(record, measured.levels, progress=progress)
                record = replace(record, measured=compared(measured, predicted))
            whole = record.to_dict()
            if result is not None:
                progress("writing the results")
                write_run(record, result.folder, field=arguments.field)
                result.commit()
                with _pictures(result):
                    if arguments.report:
                        from studies.report.page import write_report

                        write_report(record, result.folder)
                    if drawing is not None:
                        drawing.draw(record, result.folder)
    _show(arguments, whole, f"{answer(record)}\nresults         {out}")
    _warn(record.warnings)
    _say([record.shortfall] if record.shortfall else [])
    if arguments.plot:
        show(*pictures(record).values())
    return record.exit_code


def _origin(kind: str, scene: str) -> Origin:
    """Return what a result of a scene belongs to."""
    path = scene_path(scene)
    ships = path == shipped_scenes().get(path.stem)
    return Origin(kind=kind, name=path.stem, source=None if ships else path)


@contextmanager
def _results(arguments: argparse.Namespace, kind: str, ending: str) -> Iterator[tuple]:
    """Hold the directory that a call's results go to, and its path as given; None with --json alone."""
    origin, out = _origin(kind, arguments.scene), arguments.out
    if out is None and arguments.json:
        yield None, None
        return
    folder = out or Path("results") / f"{origin.name}{ending}"
    with result_directory(folder, origin, chosen=out is not None) as result:
        yield result, folder
    _say(result.notes)


@contextmanager
def _pictures(result: ResultDirectory) -> Iterator[None]:
    """Commit what is drawn; what cannot be drawn is a warning, for the numbers are in place already."""
    try:
        yield
    except KeyboardInterrupt:
        raise InterruptedRunError(f"interrupted while drawing: the numbers are in {result.target}") from None
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        result.notes.append(f"pictures are missing in {result.target}: {reason}")
    result.commit()


def _show(arguments: argparse.Namespace, whole: dict, text: str) -> None:
    """Print an answer as JSON or as text."""
    if arguments.json:
        print_json(whole)
    else:
        print(text)


def _say(sentences) -> None:
    """Say something on stderr."""
    for each in sentences:
        print(f"sawmotor: {each}", file=sys.stderr, flush=True)


def _warn(warnings) -> None:
    _say(f"warning: {each}" for each in warnings)


def datasheet(arguments: argparse.Namespace) -> int:
    """Compute a motor's datasheet; print its table and leave its page and numbers."""
    from studies.report.datasheet import datasheet as computed
    from studies.report.datasheet_page import page, table

    wanted, scene = tolerance(arguments.tolerance), changed_scene(arguments)
    with _results(arguments, "datasheet", "-datasheet") as (result, out), Progress() as progress:
        sheet = computed(scene, tolerance=wanted, progress=progress)
        if result is not None:
            write_json(result.folder / "datasheet.json", sheet.to_dict())
            result.commit()
            with _pictures(result):
                (result.folder / "datasheet.html").write_text(page(sheet), encoding="utf-8")
    _show(arguments, sheet.to_dict(), f"{table(sheet)}\nresults  {out}")
    _warn(sheet.record.warnings)
    return 0


def wave(arguments: argparse.Namespace) -> int:
    """Print the half-space Rayleigh wave of a material and its cut; draw the crystal axes if asked."""
    from studies.report.free_surface import half_space_answer, half_space_wave

    orientation = arguments.orientation
    if "," in orientation:
        orientation = toml_value(f"[{orientation.strip('[]')}]")
    answer = half_space_wave(arguments.material, orientation=orientation, surface=arguments.surface)
    _show(arguments, answer, half_space_answer(answer))
    if arguments.plot is not None:
        from studies.report.free_surface import save_axes

        save_axes(answer, arguments.plot)
    return 0


def study(arguments: argparse.Namespace) -> int:
    """Run a study, or list them with their questions."""
    from studies.study import STUDIES, draw_study, module, question, run_study

    if arguments.name is None:
        print("\n".join(labelled([(name, question(name)) for name in STUDIES], 2 + max(map(len, STUDIES)))))
        return 0
    module(arguments.name)
    origin = Origin(kind="study", name=arguments.name)
    out = arguments.out or Path("results") / f"{arguments.name}-study"
    if arguments.scene is not None:
        scene = _origin("study", arguments.scene)
        if arguments.name not in ("voltage_to_velocity", "gallery"):
            _without_bands(read_table(arguments.scene))
        origin = Origin(kind="study", name=f"{arguments.name} of {scene.name}", source=scene.source)
        out = arguments.out or Path("results") / f"{arguments.name}-study-{scene.name}"
    with result_directory(out, origin, chosen=arguments.out is not None) as result, Progress() as progress:
        done = run_study(
            arguments.name,
            arguments.scene,
            result.folder,
            progress=progress,
            over=axes_given(arguments.over),
            options={
                name: value
                for name in ("band", "z0", "measured")
                if (value := getattr(arguments, name)) is not None
            },
            quick=arguments.quick,
        )
        result.commit()
        with _pictures(result):
            draw_study(arguments.name, done, result.folder, progress=progress)
    print(f"{done}\nresults  {out}")
    _say([*result.notes, *([done.remark] if done.remark else [])])
    return done.exit_code


def view(arguments: argparse.Namespace) -> int:
    """Show a run in a window, or draw it into files and name them."""
    from studies.view import view as show
    from studies.view.options import Wanted

    wanted = Wanted.read(arguments)

    with Progress() as progress:
        show(arguments.run, wanted, progress=progress, note=lambda text: _say([text]))
    print("\n".join(wanted.files.values()), end="\n" if wanted.files else "")
    return 0


def help(arguments: argparse.Namespace) -> int:
    """Print what a word of the output means, or the list of the words."""
    from studies.command.glossary import entries, meaning

    print(", ".join(entries()) if arguments.word is None else meaning(arguments.word))
    return 0


def export(arguments: argparse.Namespace) -> int:
    """Write a run or a scene in a format of others."""
    from studies.command.export import checked, exported, scene_of

    ending, _ = checked(arguments)
    given, name = arguments.scene, Path(arguments.scene).stem
    arguments.scene = scene_of(given)
    wanted, scene = tolerance(arguments.tolerance), changed_scene(arguments)
    alone = bool(ending) and arguments.out is not None and Path(arguments.out).suffix.lower() == ending
    if alone and Path(arguments.out).exists():
        raise SceneError("--out", f"{arguments.out!r} exists already, and is not replaced")
    with Progress() as progress:
        done = exported(arguments, scene, name, tolerance=wanted, progress=progress)
        out = Path(arguments.out or Path("results") / f"{name}-export-{arguments.format}")
        if alone:
            done.write_alone(out)
        else:
            origin = Origin(kind="export", name=f"{arguments.format} of {name}")
            with result_directory(out, origin, chosen=arguments.out is not None) as result:
                done.write(result.folder)
                result.commit()
                if done.pictures and not arguments.no_plot:
                    from studies.record.plots import saved

                    with _pictures(result):
                        for file, draw in done.pictures.items():
                            saved(result.folder / file, draw)
            _say(result.notes)
    print("\n".join([*labelled(done.answer, 16), f"{'results':<16}{out}"]))
    _say(done.remarks)
    return 0


def schema(arguments: argparse.Namespace) -> int:
    """Print the JSON Schema of a scene."""
    from studies.scene.schema import schema_text

    print(schema_text(), end="")
    return 0


def scenes(arguments: argparse.Namespace) -> int:
    """Print the scenes that ship, a line each, or copy one of them."""
    if arguments.copy is not None:
        from studies.scene.file import copied

        name, file = arguments.copy
        print(f"{copied(name, Path(file))}: sawmotor check {file}, sawmotor run {file}")
        return 0
    rows = [(name, Scene.load(name).title) for name in shipped_scenes()]
    print("\n".join(labelled(rows, 2 + max(map(len, shipped_scenes())))))
    return 0


def check(arguments: argparse.Namespace) -> int:
    """Check a scene without running it and print what a run would do."""
    from studies.chain.resolve import resolved
    from studies.chain.scene_warnings import scene_warnings
    from studies.report.contents import contents

    file = changed_file(arguments)
    with file.located():
        scene = resolved(Scene.from_file(file))
    print(f"{arguments.scene}: {scene.title or 'no title'}")
    print("\n".join(f"  {line}" for line in labelled(contents(scene), 12)))
    _warn(scene_warnings(scene))
    return 0


def sweep(arguments: argparse.Namespace) -> int:
    """Compute what is missing of a sweep's points, and say what they came to."""
    from studies.sweeps.answer import run_sweep

    table = changed_file(arguments).table
    out = arguments.out or Path("results") / f"{scene_path(arguments.scene).stem}-sweep"
    return run_sweep(arguments, table, axes_given(arguments.over), tolerance(arguments.tolerance), out)


def fit(arguments: argparse.Namespace) -> int:
    """Fit numbers of a scene to measurements; print what they say and leave the fitted scene."""
    from fem import blas_on_one_thread
    from studies.inverse import fit as fitted
    from studies.inverse import read_measurement, read_parameter
    from studies.inverse.fit_report import draw_fit, fit_answer, write_fit

    wanted, scene = tolerance(arguments.tolerance), changed_scene(arguments)
    measurements = [read_measurement(file, tuple(settings)) for file, *settings in arguments.data]
    parameters = [read_parameter(text) for text in arguments.free]
    with _results(arguments, "fit", "-fit") as (result, out), Progress() as progress, blas_on_one_thread():
        found = fitted(scene, measurements, parameters, tolerance=wanted, progress=progress)
        if result is not None:
            write_fit(found, result.folder)
            result.commit()
            if not (arguments.no_plot or arguments.json):
                with _pictures(result):
                    draw_fit(found, result.folder / "fit.png")
    _show(arguments, found.to_dict(), f"{fit_answer(found)}\n{'results':<16}{out}")
    return 0


def design(arguments: argparse.Namespace) -> int:
    """Search for the best motor within ranges; print it and leave its scene beside all evaluations."""
    from studies.inverse.design_report import design_answer, draw_design, write_design
    from studies.inverse.goals import read_constraint, read_variable
    from studies.inverse.optimum import Options
    from studies.inverse.optimum import design as search

    wanted = tolerance(arguments.tolerance or "3e-2")
    table = changed_scene(arguments).to_table()
    variables = [read_variable(text) for text in arguments.over]
    out = Path(arguments.out or Path("results") / f"{scene_path(arguments.scene).stem}-design")
    with Progress() as progress:
        found = search(
            table,
            arguments.maximise,
            variables,
            [read_constraint(text) for text in arguments.subject],
            options=Options(
                **{key: getattr(arguments, key) for key in ("evaluations", "seed", "workers")},
                tolerance=wanted,
                out=out,
            ),
            progress=progress,
        )
        write_design(found, out)
        draw_design(found, out / "design.png")
    _show(arguments, found.to_dict(), f"{design_answer(found, variables)}\n{'results':<16}{out}")
    return 0


def changed_scene(arguments: argparse.Namespace) -> Scene:
    """Return the scene of a call with its ``--set`` and ``--voltage`` applied."""
    return Scene.from_file(changed_file(arguments))


def changed_file(arguments: argparse.Namespace) -> SceneFile:
    """Return the document of a call's scene, with its ``--set`` and ``--voltage`` applied."""
    file = SceneFile.read(arguments.scene)
    for setting in arguments.set:
        file = file.assigned(setting)
    if arguments.voltage is not None:
        if not isinstance(file.table.get("drive"), dict):
            raise SceneError("--voltage", "needs a scene with a [drive]; this one has none")
        values = [toml_value(part.strip()) for part in arguments.voltage.split(",")]
        file = file.replaced("drive.voltage", values if len(values) > 1 else values[0])
    if arguments.call in ("sweep", "fit", "design"):
        _without_bands(file.table)
    return file


def _without_bands(table: dict) -> None:
    """Say that the tolerances of a scene are not looked at, if it has any."""
    if "uncertain" in parted(table):
        _say(["[uncertain] is not used here: its bands are those of sawmotor run"])


def tolerance(text: str | None) -> float:
    """Return the tolerance of a call, 1e-3 when absent."""
    return Quantity(below=1.0).read("--tolerance", 1e-3 if text is None else toml_value(text))
