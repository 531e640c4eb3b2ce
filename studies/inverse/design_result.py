"""The result of a design search: text, design.json, the scene at the optimum, a picture."""

from dataclasses import dataclass
from pathlib import Path

from studies.inverse.free_parameters import Parameter
from studies.inverse.goals import LEAST
from studies.record.plots import COLOURS, finished, saved
from studies.record.prefixes import key_axis
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.refusal import writing
from studies.results.content import write_json
from studies.scene.keys import coordinate
from studies.scene.toml import document

NEAR_END = 2e-3  # distance from an end of a range, relative to the range, below which the best value lies at it


@dataclass(frozen=True, kw_only=True, repr=False)
class Design:
    """Result of a design search. A point is a dict of keys of the scene and outcomes."""

    goals: tuple[str, ...]
    columns: tuple[str, ...]  # of a point, one for each goal
    optimum: dict  # the best point (of two goals: the middle of the front)
    front: list[dict]  # points that no other exceeds in both goals; the optimum alone with one goal
    # by key: with this variable 5 % larger or smaller (a whole number by 1, a position by 5 % of a wavelength, an angle
    # by 1 degree), the smallest share of the first goal that is left, and whether all constraints still hold
    robustness: dict
    points: list[dict]  # of the search, in the order of their evaluation
    evaluations: int  # number, with those of the robustness
    variables: tuple[Parameter, ...]  # with their ranges
    table: dict  # TOML document of the scene at the optimum

    rows = property(lambda self: self.points, doc="Former name of ``points``.")

    def to_dict(self) -> dict:
        """Return what design.json holds."""
        whole = {
            "goals": list(self.goals), "optimum": self.optimum, "front": self.front, "robustness": self.robustness,
            "evaluations": self.evaluations,
        }  # fmt: skip
        ends = {each.key: each.end_reached(self.optimum[each.key], NEAR_END) for each in self.variables}
        at_ends = {key: side for key, side in ends.items() if side is not None}
        return whole | ({"at_end_of_range": at_ends} if at_ends else {})

    def __str__(self) -> str:
        """Return what `sawmotor design` prints."""
        rows = [["variable", "best", "if changed by", "goal left", "constraints"]]
        for each in self.variables:
            robust, best = self.robustness[each.key], each.text(self.optimum[each.key], 5)
            constraints = "all kept" if robust["keeps_constraints"] else "not all kept"
            left = f"{100 * robust['least_share_of_goal']:.4g} % or more"
            rows.append([each.key, best, _change_in_words(each), left, constraints])
        notes: list[tuple[str, str | list[str]]] = [("at the best", [
            f"{quantity(name).heading} {quantity(name).text(value)}" for name, value in self.optimum.items()
            if isinstance(value, float) and "." not in name and not name.endswith(quantity.relative_error.column)
        ])]  # fmt: skip
        if {quantity.velocity_m_per_s.column, quantity.conductance_S.column} <= set(self.optimum):  # on a stator
            notes.append(
                ("velocity", "that of the slider's position; mean_velocity is over half a wavelength about it")
            )
        if len(self.front) > 1:
            notes.append(("front", f"{len(self.front)} motors on the Pareto front of {' and '.join(self.goals)}"))
        ends = (each.end_in_words(self.optimum[each.key], NEAR_END) for each in self.variables)
        notes += [("remark", remark) for remarks in ends for remark in remarks]
        notes.append(("evaluations", f"{self.evaluations}"))
        return "\n".join([*table(rows), "", *labelled(notes)])

    def __repr__(self) -> str:
        """Return the goals, the variables of the best motor and the number of evaluations on one line."""
        best = ", ".join(f"{each.key} = {each.text(self.optimum[each.key])}" for each in self.variables)
        return f"Design({' and '.join(self.goals)}: {best}, {self.evaluations} evaluations)"

    def write(self, folder: Path) -> None:
        """Write design.json, optimum.toml and design.png into a directory."""
        with writing(folder, "out"):
            folder.mkdir(parents=True, exist_ok=True)
            write_json(folder / "design.json", self.to_dict())
            goals = " and ".join(self.goals)
            largest = (
                "" if goals.startswith(LEAST) else "largest "
            )  # a goal that is minimised begins with "least" itself
            remark = f"{largest}{goals} of {self.evaluations} evaluations"
            (folder / "optimum.toml").write_text(document(self.table, remarks=(remark,)), encoding="utf-8")
            saved(folder / "design.png", self.draw)

    def draw(self, ax):
        """Draw the goal against the evaluations, or the front of two goals, on an Axes."""
        points = [point for point in self.points if all(point.get(name) is not None for name in self.columns)]
        axes = [
            key_axis(name, self.optimum[name]) if "." in name else (quantity(name).scale, quantity(name).axis)
            for name in self.columns
        ]
        best, label, single = [self.optimum], "best that keeps the constraints", len(self.columns) == 1
        if not single:
            best, label = self.front, "front: no evaluation exceeds these in both"
        series = ((points, ".", "stick", "evaluations"), (best, "o-", "intermittent", label))
        for some, marks, colour, name in series:
            values = [[abs(point[key]) * scale for point in some]
                      for key, (scale, _) in zip(self.columns, axes, strict=True)]  # fmt: skip
            coordinates = [[points.index(point) for point in some], *values] if single else values
            ax.plot(*coordinates, marks, color=COLOURS[colour], markersize=4, label=name)
        return finished(ax, "evaluation" if single else axes[0][1], axes[-1][1], "")


def _change_in_words(variable: Parameter) -> str:
    """Return by how much a variable is changed, up and down, for the robustness."""
    if coordinate(variable.key):
        return "1 degree" if variable.key.endswith("angle") else "5 % of a wavelength"
    return "1" if variable.counted else "5 %"
