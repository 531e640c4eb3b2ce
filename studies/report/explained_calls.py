"""What ``--explain`` prints for commands other than ``run``: what they compute and about how long it takes.

Nothing is computed, but for automatic periods and frequencies where the plan of a run is printed too.
"""

import inspect
from collections.abc import Sequence
from dataclasses import replace

from studies.model.model import changes_stator
from studies.progress import duration
from studies.record import Record
from studies.record.text import labelled
from studies.report.explanation import (
    BAND,
    SEARCH,
    START,
    TIME_WITHIN,
    expected_seconds,
    explanation,
    plan,
    sweep_seconds,
)
from studies.scene import Scene

EXPECTED = "expected time"
# Time of a datasheet over the expected one of a run; CPU seconds of a 10 MHz motor on 128YX: 26 over 6
DATASHEET_RUNS = 3
FIRST_SCENE = 8.0  # s: half-space, search, and the stator once
DRAWING = 3.0  # s: a picture or a page, with the imports that it needs
TABLES = 15.0  # s: mean forces of a motor for simulators
# s: a half-space with the imports that it needs, the bound waves of layers, and one of several temperatures
HALF_SPACE, LAYERED, TEMPERATURE = 0.4, 0.7, 0.02


def explained_sweep(design, scene: Scene, *, tolerance: float) -> str:
    """Return the plan of a sweep; ``scene`` is that of its first point."""
    axes = " x ".join(f"{' and '.join(each.keys)} ({len(each)})" for each in design.axes) or "one point"
    seconds = sweep_seconds(scene, tolerance=tolerance, stators=design.stators, points=len(design))
    stators = f"{design.stators}" + (
        f", one for each value of {' and '.join(design.question.stator_keys)}" if design.question.stator_keys else ""
    )
    entries = [("points", f"{len(design)}: {axes}"), ("stators", stators), _time(seconds, "in one process")]
    return _with_run(entries, scene, tolerance)


def explained_search(scene: Scene, keys, *, evaluations: str, tolerance: float) -> str:
    """Return the plan of a fit or a design that varies keys of a scene; ``evaluations`` says how many there are."""
    solved = [key for key in keys if changes_stator(key) or key.startswith("slider.position")]
    each = f"solved at each evaluation, for {', '.join(solved)}" if solved and scene.transducer else "solved once"
    entries = [("varied", ", ".join(keys) or "nothing"), ("evaluations", evaluations)]
    return _with_run([*entries, ("stator", each if scene.wave is None else "none")], scene, tolerance)


def datasheet_seconds(scene: Scene, *, tolerance: float) -> float:
    """Return the expected time of a datasheet in s."""
    return DATASHEET_RUNS * expected_seconds(scene, tolerance=tolerance)


def explained_datasheet(scene: Scene, *, tolerance: float) -> str:
    """Return the plan of a datasheet."""
    contents = (
        "the run below, then load lines at three levels, start and stop of a burst, step, limits and power, all on the "
        "same stator"
    )
    seconds = datasheet_seconds(scene, tolerance=tolerance)
    return _with_run([("contents", contents), _time(seconds, "in all")], scene, tolerance)


def explained_study(name: str, documentation: str, seconds: float) -> str:
    """Return the method of a study and its expected time."""
    text = inspect.cleandoc(documentation).splitlines()
    return "\n".join([f"{name}: nothing has been computed", "", *text, "", *labelled([_time(seconds, "in all")])])


def searches(scene: Scene) -> int:
    """Return how many periods or frequencies of the strongest wave a scene lets the program search for."""
    periods = sum(each.period == "auto" for each in scene.transducer)
    return periods + bool(scene.transducer and scene.drive.frequency == "center")


def explained_check(scene: Scene) -> str:
    """Return what ``sawmotor check`` does with a scene."""
    entries = [
        ("checks", "keys, units, ranges, files, material and layout; what a run computes: sawmotor run --explain")
    ]
    if count := searches(scene):
        entries += [("searches", f"{count}, for the period or the frequency of the strongest wave")]
    return _nothing("check", [*entries, _time(START + SEARCH * count, "in all")])


def explained_first_scene(frequency: str, material: str) -> str:
    """Return what ``sawmotor new`` does."""
    entries = [
        ("sizes", f"a motor of {frequency} on {material}, by rules that stand beside its lines"),
        ("wave", "that of the half-space, without a mesh: the wavelength, in which all lengths are sized"),
        ("stator", "solved once to 1e-2 after a search for the period: the voltage of a wanted amplitude"),
        _time(FIRST_SCENE, "in all"),
    ]
    return _nothing("new", entries)


def explained_wave(material: str, *, layers: Sequence[str] = (), temperatures: int = 0, picture: bool = False) -> str:
    """Return what ``sawmotor wave`` does; ``temperatures``: number of them, 0 for the constants as they are."""
    entries = [("half-space", f"{material}, without a mesh and without loss")]
    entries += [("layers", "; ".join(layers))] if layers else []
    entries += [("temperatures", f"{temperatures}, a wave and its derivatives at each")] if temperatures else []
    entries += [("picture", "the crystal axes")] if picture else []
    seconds = (LAYERED if layers else HALF_SPACE) + TEMPERATURE * temperatures + DRAWING * picture
    return _nothing("wave", [*entries, _time(seconds, "in all")])


def explained_comparison(runs: Sequence[str]) -> str:
    """Return what ``sawmotor compare`` does."""
    entries = [("reads", f"run.json of {', '.join(map(str, runs))}"), ("solves", "nothing"), _time(START, "in all")]
    return _nothing("compare", entries)


def field_seconds(scene: Scene, *, tolerance: float) -> float:
    """Return the expected time in s of the field of a scene alone, with a picture of it."""
    if not scene.transducer:
        return START + DRAWING
    surface = replace(scene, slider=None)
    return START + DRAWING + SEARCH * searches(scene) + plan(surface, tolerance=tolerance)["expected"]["stator_seconds"]


def mask_seconds(scene: Scene) -> float:
    """Return the expected time in s of a mask."""
    return START + DRAWING + SEARCH * searches(scene)


def explained_view(record: Record, show: str, files: Sequence[str]) -> str:
    """Return what ``sawmotor view`` does with a run; ``show``: field, solid, beam or contact."""
    field = "solved again as in the run, which keeps no field" if record.scene.stator is not None else "none"
    contact = [("contact", "followed through one cycle")] if show == "contact" else []
    entries = [("shows", show), ("stator", field), *contact, ("files", ", ".join(files) or "none: a window")]
    return _nothing("view", [*entries, _time(field_seconds(record.scene, tolerance=record.tolerance), "in all")])


def motor_seconds(scene: Scene, *, tolerance: float) -> float:
    """Return the expected time in s of a motor for simulators: its stator over a band, and its tables of forces."""
    stator = 0.0 if scene.wave is not None else 2.0 * plan(scene, tolerance=tolerance)["expected"]["stator_seconds"]
    return START + TABLES + BAND * stator


def explained_export(file_format: str, contents: str, seconds: float) -> str:
    """Return what ``sawmotor export`` does."""
    return _nothing("export", [("format", file_format), ("contents", contents), _time(seconds, "in all")])


def _nothing(command: str, entries) -> str:
    return "\n".join([f"sawmotor {command}: nothing has been computed", *labelled(entries)])


def _time(seconds: float, where: str) -> tuple[str, str]:
    return EXPECTED, f"{duration(seconds)} {where}, within a factor of {TIME_WITHIN:g}"


def _with_run(entries, scene: Scene, tolerance: float) -> str:
    one = explanation(plan(scene, tolerance=tolerance)).splitlines()
    return "\n".join([*labelled(entries), "", "one run of it:", *one])
