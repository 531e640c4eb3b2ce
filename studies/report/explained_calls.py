"""What ``--explain`` prints for commands of many runs: points, stators, about what time, and the plan of one run.

Nothing is computed.
"""

import inspect

from studies.model.model import changes_stator
from studies.progress import duration
from studies.record.text import labelled
from studies.report.explanation import TIME_WITHIN, explanation, plan, sweep_seconds
from studies.scene import Scene

EXPECTED = "expected time"


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


def explained_datasheet(scene: Scene, *, tolerance: float) -> str:
    """Return the plan of a datasheet."""
    contents = (
        "the run below, then load lines at three levels, start and stop of a burst, step, limits and power, all on the "
        "same stator"
    )
    return _with_run([("contents", contents)], scene, tolerance)


def explained_study(name: str, documentation: str, seconds: float) -> str:
    """Return the method of a study and its expected time."""
    text = inspect.cleandoc(documentation).splitlines()
    return "\n".join([f"{name}: nothing has been computed", "", *text, "", *labelled([_time(seconds, "in all")])])


def _time(seconds: float, where: str) -> tuple[str, str]:
    return EXPECTED, f"{duration(seconds)} {where}, within a factor of {TIME_WITHIN:g}"


def _with_run(entries, scene: Scene, tolerance: float) -> str:
    one = explanation(plan(scene, tolerance=tolerance)).splitlines()
    return "\n".join([*labelled(entries), "", "one run of it:", *one])
