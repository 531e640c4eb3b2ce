"""The plan of a run as text: equations, sizes, what is left out, what it is expected to cost."""

from studies.report import cost
from studies.report.answer import table
from studies.report.parts import Part
from studies.report.plan import Plan

__all__ = ["explanation"]

HEAD = (
    "order", "edge layers", "elements in depth", "line, modes", "columns", "condensed", "joins", "unknowns", "s", "MB",
)  # fmt: skip


def explanation(plan: Plan) -> str:
    """Return what ``sawmotor run --explain`` prints."""
    lines = [plan.scene.title or "no title", "what a run would compute; nothing has been computed", ""]
    for part in plan.parts:
        lines += [*_part(part), ""]
    lines.append(f"{'left out':<18}" + f"\n{'':<18}".join(plan.left_out))
    parts = ", ".join(f"{part.name} {part.seconds:.2g}" for part in plan.parts)
    lines += [
        f"{'error':<18}at most {plan.tolerance:.1e} is asked for",
        f"{'expected time':<18}{plan.seconds:.2g} s within a factor of {cost.TIME_WITHIN:g} ({parts})",
        f"{'expected memory':<18}{plan.bytes / 1e6:.0f} MB within a factor of {cost.MEMORY_WITHIN:g}, pictures apart",
    ]
    if plan.speed:
        share = f"{plan.speed / 1e9:.0f} Gflop/s of this machine (just measured), {cost.SOLVER_SHARE:g} of it reached"
        lines.append(f"{'':<18}from counted operations: {share}")
    lines.append(f"{'':<18}the contact, imports: constants of one 2-core machine")
    return "\n".join(lines)


def _part(part: Part) -> list[str]:
    lines = [f"{part.name if index == 0 else '':<18}{text}" for index, text in enumerate(_sentences(part))]
    if part.levels:
        rows = [list(HEAD)]
        for level in part.levels:
            row = [level.order, level.edge_layers, level.elements, level.line, level.columns, level.condensed]
            row += [level.joins, level.unknowns, f"{level.seconds:.2g}", f"{level.megabytes:.2g}"]
            rows.append([str(value) for value in row])
        if part.levels[0].columns == 0:  # a mode of the depth alone
            keep = [HEAD.index(name) for name in ("order", "elements in depth", "unknowns", "s", "MB")]
            rows = [[row[column] for column in keep] for row in rows]
        lines += [f"{'':<18}{line}" for line in table(rows)]
    return lines


def _sentences(part: Part) -> tuple[str, ...]:
    return (*part.equations, *part.facts)
