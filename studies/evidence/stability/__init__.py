"""Where the program stands at the extremes: what is right within its stated error, flagged, refused or WRONG.

Method: each quantity of the free wave, the driven stator, the contact and the whole chain is set to both ends of its
range. For the contact, random combinations of extreme values are added. Each answer is compared with an independent
solution, which the docstrings of free.py, stator.py, extreme_contacts.py and chain.py describe. An answer is WRONG if
its error exceeds twice its stated error, if it is not a number, or if it ends in an unexpected exception or an
arithmetic warning. The reference of the contact is a run in time, which is often less accurate than the answer. There,
the error is the part of the difference that exceeds the error of the reference. Expected: at least 150 cases, none
WRONG.  Run time: about 6 min of one processor.
"""

import logging
import math
from collections import Counter
from importlib import import_module

from studies.evidence.stability.verdict import VERDICTS, cases_of, judge
from studies.record.plots import finished, saved
from studies.record.text import csv_text, markdown
from studies.record.values import Columns
from studies.study_list import Answered, Finding, Panel, StudyRecord, judged, of_record, study

LOGGER = logging.getLogger(__name__)

PARTS = {"free wave": "free", "stator": "stator", "contact": "extreme_contacts", "chain": "chain"}
LEAST = 150
QUICK = {"cases": 1, "parts": ("free wave", "contact")}
STYLES = {
    "right": ("#0072B2", "o", 30),
    "flagged": ("#E69F00", "^", 38),
    "refused": ("#999999", "s", 26),
    "WRONG": ("#D55E00", "X", 90),
}
COLOURS = {"free wave": "#009E73", "stator": "#0072B2", "contact": "#CC79A7", "chain": "#E69F00"}


@study()
def run(*, parts: tuple[str, ...] = tuple(PARTS), cases: int | None = None) -> Answered:
    """Return the verdicts on all cases, with one panel for each part.

    Parameters
    ----------
    parts : tuple of str
        Names in `PARTS`.
    cases : int, optional
        Number of cases of each part, evenly spaced; all cases if None.
    """
    selected = [
        (module, case)
        for part in parts
        for module in [import_module(f"studies.evidence.stability.{PARTS[part]}")]
        for case in _some(cases_of(part, module.VARIED), cases)
    ]
    rows = []
    for number, (module, case) in enumerate(selected, start=1):
        value = f"{case.value:g} {case.unit}".rstrip()
        LOGGER.info(f"stability: {number} of {len(selected)}, {case.part}, {case.varied} {value}")
        rows.append(case_row(case, judge(module, case)))
    return [part_panel(part, [row for row in rows if row.part == part]) for part in parts], (
        atlas_findings(rows, whole=cases is None and {*parts} == {*PARTS})
    )


def _some(cases, number: int | None):
    """Return a number of evenly spaced cases."""
    cases = list(cases)
    return cases if number is None else cases[:: max(len(cases) // number, 1)][:number]


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the text files of the study: all cases, and a summary with a row for each quantity."""
    rows = [row for panel in record.panels for row in panel.rows()]
    return {"cases.csv": csv_text(rows), "summary.md": summary(rows)}


def summary(rows: list[Columns]) -> str:
    """Return a markdown table with one row for each varied quantity."""
    head = ["part", "varied", "from", "to", "cases", *VERDICTS, "worst error / estimate", "seconds", "guard"]
    table = []
    for part, varied in dict.fromkeys((row.part, row.varied) for row in rows):
        selected = [row for row in rows if (row.part, row.varied) == (part, varied)]
        verdicts = Counter(row.verdict for row in selected)
        guards = Counter(row.guard for row in selected if row.guard)
        ratios = [ratio for ratio in map(_ratio, selected) if ratio is not None]
        unit = f" {selected[0]['unit']}".rstrip()
        table.append([
            part, varied, f"{selected[0]['value']}{unit}", f"{selected[-1]['value']}{unit}", str(len(selected)),
            *(str(verdicts[verdict] or "") for verdict in VERDICTS), f"{max(ratios):.2g}" if ratios else "",
            f"{sum(row.seconds for row in selected):.1f}",
            guards.most_common(1)[0][0][:110].replace("|", "/") if guards else "",
        ])  # fmt: skip
    total = Counter(row.verdict for row in rows)
    counts = ", ".join(f"{total[verdict]} {verdict}" for verdict in VERDICTS)
    return "\n".join([*markdown(head, table), "", f"{len(rows)} cases: {counts}"]) + "\n"


@of_record
def figure(record: Panel, ax):
    """Draw the verdicts of a part: one line for each quantity, with its values in order."""
    rows = record.rows()
    names = list(dict.fromkeys((row.varied, row.unit) for row in rows))
    for line, (varied, unit) in enumerate(names):
        selected = [row for row in rows if row.varied == varied]
        for index, row in enumerate(selected):
            colour, mark, size = STYLES[row.verdict]
            x = index / max(len(selected) - 1, 1)
            ax.scatter(x, line, color=colour, marker=mark, s=size if len(selected) < 40 else size / 3, zorder=3)
        ax.plot([0, 1], [line, line], color="#dddddd", linewidth=0.8, zorder=1)
        for x, row, side in ((-0.02, selected[0], "right"), (1.02, selected[-1], "left"))[: len(selected)]:
            ax.text(x, line, f"{row.value} {unit}".rstrip(), ha=side, va="center", fontsize="x-small")
    for verdict, (colour, mark, size) in STYLES.items():
        count = sum(row.verdict == verdict for row in rows)
        ax.scatter([], [], color=colour, marker=mark, s=size, label=f"{verdict} ({count})")
    ax.set_yticks(range(len(names)), [varied for varied, _ in names], fontsize="small")
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_xlim(-0.22, 1.22)
    ax.set_xticks([0, 1], ["first value", "last value"])
    ax.spines[["top", "right", "left"]].set_visible(False)
    across = "values in the order of the cases (unit beside them)"
    return finished(ax, across, "quantity taken to its ends", record.title, grid=False)


def against_estimate(panels: tuple[Panel, ...], ax):
    """Draw the true error of every answer against its stated error."""
    for panel in panels:
        pairs = [
            (row.relative_estimate, row.relative_error)
            for row in panel.rows()
            if row.relative_error is not None and row.relative_estimate is not None
        ]
        drawn = [(max(estimate, 1e-16), max(error, 1e-16)) for estimate, error in pairs]
        style = {"color": COLOURS[panel.name], "markersize": 4, "alpha": 0.7}
        ax.loglog(*zip(*drawn, strict=True), "o", **style, label=f"{panel.name} ({len(drawn)})")
    ends = [1e-16, 1.0]
    ax.loglog(ends, [2 * end for end in ends], "-", color="black", linewidth=1, label="twice the estimate")
    title = "Stated errors and differences from the reference"
    return finished(ax, "stated relative error (1)", "difference from the reference (1)", title)


def draw(record: StudyRecord, folder) -> None:
    """Draw the verdicts of each part, and true against stated errors."""
    for panel in record.panels:
        LOGGER.info(f"drawing {panel.name}")
        height = 0.3 * len(dict.fromkeys(panel.data["varied"])) + 1.6
        name = panel.name.replace(" ", "_")
        saved(folder / f"{name}.png", lambda ax, panel=panel: figure(panel, ax), size=(9.0, height))
    saved(folder / "error_against_estimate.png", lambda ax: against_estimate(record.panels, ax), size=(6.5, 5.5))


def case_row(case, outcome) -> Columns:
    """Return a case and its outcome as JSON-compatible data, with None instead of NaN."""

    def finite(number: float) -> float | None:
        return float(number) if math.isfinite(number) else None

    return Columns(
        part=case.part, varied=case.varied, value=f"{case.value:g}", unit=case.unit, verdict=outcome.verdict,
        relative_error=finite(outcome.relative_error), relative_estimate=finite(outcome.relative_estimate),
        seconds=float(outcome.seconds), guard=outcome.guard,
    )  # fmt: skip


def part_panel(part: str, rows: list[Columns]) -> Panel:
    """Return the rows of the cases of one part as columns of a panel."""
    return Panel.of_rows(part, f"{part}: {len(rows)} extreme cases", rows)


def _ratio(row: Columns) -> float | None:
    """Return the ratio of error to estimate, or None if one of them is missing."""
    error, estimate = row.relative_error, row.relative_estimate
    if error is None or estimate is None or not estimate > 1e-12:
        return None
    return error / estimate


def atlas_findings(rows: list[Columns], *, whole: bool = True) -> tuple[Finding, ...]:
    """Return the findings on all rows: enough cases, and none of them wrong.

    ``whole``: False for a part of the study, whose number of cases is not judged.
    """
    total = Counter(row.verdict for row in rows)
    wrong = [row for row in rows if row.verdict == "WRONG"]
    worst = "; ".join(f"{row.part}, {row.varied} {row.value}: {row.guard[:80]}" for row in wrong[:5])
    referenced = [row for row in rows if row.relative_error is not None]
    counts = ", ".join(f"{total[verdict]} {verdict}" for verdict in VERDICTS)
    remark = f"{counts}; {len(referenced)} answers compared with a reference"
    return (
        judged("The study covers enough cases.", "cases", len(rows), low=LEAST - 1, holds=True if whole else None,
               expected=f"at least {LEAST} in the whole study", remark=remark),
        judged("No answer is wrong.", "cases that are WRONG", len(wrong), high=1, expected="0", remark=worst),
    )  # fmt: skip
