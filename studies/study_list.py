"""A study: one question to the models, answered by panels (the numbers of pictures) and findings (checks of theory).

Each study is a file named by its question.  Its docstring states question, method, expected answer and run
time; ``run(...)`` returns a record; ``figure(record, ax)`` draws the record, or one of its panels.
"""

import logging
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from importlib import import_module
from inspect import Signature, cleandoc, signature
from pathlib import Path
from typing import Any

from studies.model.model import Model
from studies.model.resolve import build
from studies.model.scene_errors import as_run_errors
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.files import write_run
from studies.record.plots import saved
from studies.record.text import labelled
from studies.record.values import Columns
from studies.refusal import SceneError, refuse_if, refuse_unknown
from studies.report.explanation import plan
from studies.results.content import plain, provenance, write_json
from studies.runs import solved_contact
from studies.scene import Scene

LOGGER = logging.getLogger(__name__)

COMMON_ARGUMENTS = """\
``scene`` is a path, a shipped name or a `Scene` with the blocks that the study needs."""
# Every study, in the order of the list that a user sees: its package, and its seconds on one processor, on its default
# scene or on all its own scenes
STUDIES = {
    "voltage_to_velocity": ("motor", 3),
    "rayleigh": ("evidence", 10),
    "seed_figures": ("papers", 15),
    "admittance": ("stator", 25),
    "beam": ("stator", 4),
    "frequency_response": ("stator", 5),
    "dispersion": ("stator", 5),
    "regime_map": ("motor", 1),
    "load_line": ("motor", 2),
    "roughness": ("motor", 50),
    "stroke": ("motor", 7),
    "step_planner": ("motor", 7),
    "positioning": ("motor", 20),
    "trajectory": ("motor", 60),
    "heating": ("motor", 6),
    "design_map": ("motor", 8),
    "sensitivity": ("inverse", 10),
    "cell_parameters": ("stator", 10),
    "p_matrix": ("stator", 8),
    "reflector": ("stator", 6),
    "force_response": ("stator", 8),
    "network": ("stator", 25),
    "gallery": ("motor", 75),
    "published_motors": ("papers", 60),
    "published_stators": ("papers", 5),
    "error_vs_time": ("evidence", 85),
    "calibration": ("evidence", 570),
    "stability": ("evidence", 360),
    "left_out": ("evidence", 20),
}
COMMAND_OPTIONS = ("over", "band", "z0", "measured", "port", "target", "controller", "loop", "tolerance")
# former names of studies: each is a part of another now
ALIASES = {"contact_error_vs_time": "error_vs_time", "fem_error_vs_time": "error_vs_time"}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A statement and the number that confirms or contradicts it; its fields are keys of study.json."""

    statement: str  # a sentence of the paper in quotation marks, or of the theory
    quantity: str  # what was computed, with its unit
    expected: str  # the number or the range that confirms it
    found: float  # the number that was computed
    confirmed: bool | None  # None where the statement does not apply
    remark: str = ""

    def __str__(self):
        verdict = {True: "confirmed", False: "contradicted", None: "not judged"}[self.confirmed]
        remark = f"\n    {self.remark}" if self.remark else ""
        numbers = f"{self.quantity}: {self.found:.6g}, expected {self.expected}: {verdict}"
        return f"{self.statement}\n    {numbers}{remark}"


def judged(statement, quantity, value, *, low=-math.inf, high=math.inf, holds=True, expected="", remark="") -> Finding:
    """Return the finding that a number lies between two bounds, both excluded, and that ``holds`` is true.

    With None for ``holds`` the number is stated and not judged.
    """
    bounds = f"below {high:g}" if low == -math.inf else f"above {low:g}"
    if math.isfinite(low) and math.isfinite(high):
        bounds = f"between {low:g} and {high:g}"
    return Finding(
        statement=statement, quantity=quantity, expected=expected or bounds, found=float(value),
        confirmed=None if holds is None else bool(low < value < high and holds), remark=remark,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Panel:
    """The numbers of one picture."""

    name: str  # of its file
    title: str
    data: Columns | Any = field(repr=False)  # arrays and numbers in SI units, named with their unit; from a dict

    def __post_init__(self) -> None:
        object.__setattr__(self, "data", Columns(self.data))

    @classmethod
    def of_rows(cls, name: str, title: str, rows: Sequence[dict]) -> "Panel":
        """Return a panel of rows with the same keys."""
        return cls(name=name, title=title, data={key: [row[key] for row in rows] for key in rows[0]})

    def rows(self) -> list[Columns]:
        """Return its columns as rows."""
        return [Columns(zip(self.data, values, strict=True)) for values in zip(*self.data.values(), strict=True)]


@dataclass(frozen=True, kw_only=True)
class StudyRecord:
    """The result of a study: its answer in words, its panels, and checks of what the theory expects."""

    name: str
    panels: tuple[Panel, ...]
    findings: tuple[Finding, ...]
    seconds: float
    answer: tuple[tuple[str, str], ...] = ()  # label and text of each line

    def panel(self, name: str | None = None) -> Panel:
        """Return the panel of a name, by default the first."""
        panels = {panel.name: panel for panel in self.panels}
        if name is None:
            return self.panels[0]
        refuse_unknown(name, panels, "panel")
        return panels[name]

    @property
    def remark(self) -> str:
        """Warning of the checks that are contradicted; empty without any."""
        contradicted = [finding for finding in self.findings if finding.confirmed is False]
        if not contradicted:
            return ""
        first = f"{contradicted[0].quantity} is {contradicted[0].found:.6g}, expected {contradicted[0].expected}"
        return f"warning: {len(contradicted)} of {len(self.findings)} checks are contradicted: {first}"

    exit_code = 0  # a contradicted check is a remark; a study without an answer raises

    def to_dict(self) -> dict:
        """Return what study.json holds."""
        whole = {
            "name": self.name, "question": question(self.name), "answer": [list(line) for line in self.answer],
            "findings": [vars(finding) for finding in self.findings],
            "panels": {panel.name: {"title": panel.title, **panel.data} for panel in self.panels},
            "seconds": self.seconds, "provenance": provenance(),
        }  # fmt: skip
        return {key: plain(key, value) for key, value in whole.items() if value or key != "answer"}

    def __str__(self):
        lines = [question(self.name), ""]
        if self.answer:
            lines += [*labelled(list(self.answer), 2 + max(len(label) for label, _ in self.answer)), ""]
        lines += map(str, self.findings)
        return "\n".join([*lines, "", f"seconds  {self.seconds:.1f}"])


# what a study's ``run`` returns: panels, findings and, if there is one, the answer in words as label and text
Answered = (
    tuple[Iterable[Panel], Iterable[Finding]] | tuple[Iterable[Panel], Iterable[Finding], Iterable[tuple[str, str]]]
)


def driven_contact(scene: str | Scene, *, tolerance: float = 1e-3, planar: bool | None = False) -> Contact:
    """Return the contact of a scene with a slider on balls; the arguments are those of `contact_of_study`.

    Examples
    --------
    >>> driven_contact("twente-contact").scene.named(1e-8)
    '10 nm'
    """
    scene = Scene.load(scene)
    known = "run, sweep, fit, design, datasheet, load_line and sensitivity take them"
    scene.refuse_pillars(f"are not supported by this study: {known}")
    return contact_of_study(scene, tolerance=tolerance, planar=planar)


def contact_of_study(scene: str | Scene, *, tolerance: float = 1e-3, planar: bool | None = False) -> Contact:
    """Return the contact of a scene with a slider, its stator solved at the largest voltage and without a burst.

    ``tolerance``: of the slider velocity there, which sets the discretisation of the stator.  ``planar``: True if the
    study takes sliders that move in the plane alone, None if it takes both.
    """
    model = build(Scene.load(scene))
    resolved_scene = model.scene
    if resolved_scene.slider is None:
        resolved_scene.refuse("slider", "is missing: this study needs a slider")
    if planar is not None and resolved_scene.planar is not planar:
        refuse_freedom(resolved_scene)
    if resolved_scene.wave is not None:
        return Contact.prescribed(model)
    if not resolved_scene.transducer:
        resolved_scene.refuse("transducer", "is missing: this study needs a driven stator or a prescribed [wave]")
    steady = resolved_scene.at_level(max(resolved_scene.levels)).with_source(burst=None)
    driven = solved_contact(steady, tolerance=tolerance)
    return replace(driven, model=Model(resolved_scene.with_source(frequency=driven.scene.frequency)))


def refuse_freedom(scene: Scene) -> None:
    """Raise a SceneError about a slider that moves in the plane, or does not."""
    if not scene.planar:
        scene.refuse("slider.freedom", 'must be "xy" or "xy yaw", or slider.axis given: this study follows the plane')
    key = "slider.freedom" if scene.slider.axis is None else "slider.axis"
    taking = "run, sweep, fit, design, datasheet, study load_line, trajectory and positioning"
    rule = f"must be absent here, the answer is that of motion along x; {taking} take sliders in the plane"
    scene.refuse(key, rule)


def module(name: str):
    """Return the module of a study; refuse a name that no study has."""
    name = ALIASES.get(name, name)
    refuse_unknown(name, STUDIES, "study")
    return import_module(f"studies.{STUDIES[name][0]}.{name}")


def question(name: str) -> str:
    """Return the question of a study: the first line of its docstring, read without running the module."""
    folder = Path(__file__).parent / STUDIES[name][0]
    (file,) = (each for each in (folder / f"{name}.py", folder / name / "__init__.py") if each.is_file())
    return file.read_text(encoding="utf-8").partition("\n")[0].strip('"')


def expected_seconds(name: str, scene: str | None, options: dict) -> float:
    """Return the run time of a study in s: that on its default scene, times the ratio of the stators' run times.

    A study whose number of solutions depends on its ``options``, such as ``band``, has its own ``expected_seconds``,
    which returns None where this ratio holds.
    """
    default = signature(module(name).run).parameters.get("scene")
    _, seconds = STUDIES[ALIASES.get(name, name)]
    own = getattr(module(name), "expected_seconds", None)
    if own is not None and default is not None:
        options = {key: value for key, value in options.items() if key in signature(own).parameters}
        if scene is not None or options:
            known = own(Scene.load(scene or default.default), **options)
            if known is not None:
                return known
    if scene is None or default is None:
        return seconds
    own, usual = (plan(Scene.load(each), tolerance=1e-3)["expected"]["seconds"] for each in (scene, default.default))
    return seconds * own / usual


def of_record(draw: Callable) -> Callable:
    """Let a function that draws a panel also take a `StudyRecord`, of which it draws the first or a named panel.

    Examples
    --------
    >>> @of_record
    ... def figure(panel, ax):
    ...     return panel.title
    >>> panels = (Panel(name="a", title="A", data={}), Panel(name="b", title="B", data={}))
    >>> record = StudyRecord(name="rayleigh", panels=panels, findings=(), seconds=0.0)
    >>> figure(record, None), figure(record, None, panel="b"), figure(panels[1], None)
    ('A', 'B', 'B')
    """

    @wraps(draw)
    def figure(record: StudyRecord | Panel, ax, *, panel: str | None = None):
        if isinstance(record, StudyRecord):
            record = record.panel(panel)
        elif not isinstance(record, Panel):
            raise TypeError(f"figure draws what the study's run returned, got a {type(record).__name__}")
        return draw(record, ax)

    return figure


def study(default: str | None = None) -> Callable[[Callable[..., Answered]], Callable[..., StudyRecord]]:
    """Return the decorator of a study's ``run``, which makes a `StudyRecord` of what the function returns.

    The record has the name of the module and the run time.  With a ``default`` the study takes a scene: a path, a
    shipped name or a `Scene`, which the function gets as a `Scene`.  Without a default the study has its own scenes.
    """

    def decorated(run: Callable[..., Answered]) -> Callable[..., StudyRecord]:
        @wraps(run)
        def timed(*scene: str | Scene, **options: Any) -> StudyRecord:
            start_time = time.perf_counter()
            if default is not None:
                scene = (Scene.load(scene[0] if scene else options.pop("scene", default)),)
            with as_run_errors():
                panels, findings, *answer = run(*scene, **options)
            return StudyRecord(
                name=run.__module__.rpartition(".")[2], panels=tuple(panels), findings=tuple(findings),
                seconds=time.perf_counter() - start_time, answer=tuple(answer[0]) if answer else (),
            )  # fmt: skip

        parameters = list(signature(run).parameters.values())
        if default is not None:
            timed.__doc__ = f"{cleandoc(run.__doc__ or '')}\n\n{COMMON_ARGUMENTS}"
            parameters[0] = parameters[0].replace(default=default, annotation=str | Scene)
        timed.__signature__ = Signature(parameters, return_annotation=StudyRecord)  # type: ignore[attr-defined]
        return timed

    return decorated


def run_study(
    name: str, scene: str | None, folder: Path, *, options: dict | None = None, quick: bool = False
) -> StudyRecord | Record:
    """Run a study, write its numbers into an empty directory and return its record.

    ``scene`` and ``options`` of the command line are refused by studies that do not take them; ``quick`` runs the small
    version, with the arguments in the module's ``QUICK``.
    """
    study_module, options = module(name), dict(options or {})
    taken = signature(study_module.run).parameters
    for option in options:
        if option not in taken:
            known = [each for each in COMMAND_OPTIONS if each in taken]
            rule = f", which takes --{', --'.join(known)}" if known else ", which takes no options"
            raise SceneError(f"--{option}", f"is not taken by the study {name}{rule}")
    if scene is not None:
        refuse_if("scene" not in taken, "study", f"{name} has its own scenes and takes none")
        options["scene"] = scene
    record = study_module.run(**(study_module.QUICK if quick else {}) | options)
    if isinstance(record, Record):
        write_run(record, folder, field=False)
        return record
    write_json(folder / "study.json", record.to_dict())
    for file, content in getattr(study_module, "tables", lambda record: {})(record).items():
        (folder / file).write_text(content, encoding="utf-8")
    return record


def draw_study(name: str, record: StudyRecord | Record, folder: Path) -> None:
    """Draw the pictures of a study into a directory."""
    LOGGER.info("drawing")
    study_module = module(name)
    if hasattr(study_module, "draw"):
        study_module.draw(record, folder)
        return
    panels = {name: record} if isinstance(record, Record) else {each.name: each for each in record.panels}
    for file, panel in panels.items():
        saved(folder / f"{file}.png", lambda ax, panel=panel: study_module.figure(panel, ax))
