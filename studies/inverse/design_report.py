"""What a design search leaves: its answer as text, design.json, the scene at the optimum, a picture."""

from pathlib import Path
from typing import TYPE_CHECKING

from studies.inverse.goals import GOALS
from studies.record.plots import COLOURS, finished, saved
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.report.intermediate import si
from studies.results.content import write_json
from studies.scene.keys import rule_at, unit_of
from studies.scene.toml import document

if TYPE_CHECKING:
    from studies.inverse.optimum import Design


def write_design(design: "Design", folder: Path) -> None:
    """Write design.json, optimum.toml and design.png into a directory."""
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "design.json", design.to_dict())
    remark = f"largest {' and '.join(design.goals)} of {design.evaluations} evaluations"
    (folder / "optimum.toml").write_text(document(design.table, remarks=(remark,)), encoding="utf-8")


def draw_design(design: "Design", path: Path) -> None:
    """Draw the goal against the evaluations, or the front of two goals, into a PNG file."""
    columns = [next(name for name in GOALS[goal][0] if design.optimum.get(name) is not None) for goal in design.goals]
    rows = [row for row in design.rows if all(row.get(name) is not None for name in columns)]

    single, axes = len(columns) == 1, [quantity(name) for name in columns]
    best, label = [design.optimum], "best that keeps the constraints"
    if not single:
        best, label = design.front, "front: no evaluation beats these in both"

    def drawn(ax):
        looks = ((rows, ".", "stick", "evaluations"), (best, "o-", "intermittent", label))
        for some, marks, colour, name in looks:
            values = [[abs(row[name]) * each.scale for row in some] for name, each in zip(columns, axes, strict=True)]
            at = [[rows.index(row) for row in some], *values] if single else values
            ax.plot(*at, marks, color=COLOURS[colour], markersize=4, label=name)
        finished(ax, "evaluation" if single else axes[0].axis, axes[-1].axis, "")

    saved(path, drawn)


def design_answer(design: "Design") -> str:
    """Return what a search prints."""
    rows = [["variable", "best", "5 % off leaves", "constraints"]]
    for key, robust in design.robustness.items():
        kept = "kept" if robust["keeps_constraints"] else "broken"
        best = si(design.optimum[key], unit_of(rule_at(key)) or "").rstrip()
        rows.append([key, best, f"{100 * robust['least_share_of_goal']:.4g} %", kept])
    notes: list[tuple[str, str | list[str]]] = [("at the best", [
        f"{quantity(name).heading} {quantity(name).text(value)}" for name, value in design.optimum.items()
        if isinstance(value, float) and "." not in name and name != "relative_error"
    ])]  # fmt: skip
    if len(design.front) > 1:
        goals = " and ".join(design.goals)
        notes.append(("front", f"{len(design.front)} motors that none beats in {goals}"))
    notes.append(("evaluations", f"{design.evaluations}"))
    return "\n".join([*table(rows), "", *labelled(notes)])
