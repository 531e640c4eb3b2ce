"""Goals, constraints and variables of a design search, as the command names them."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from studies.inverse.free_parameters import Parameter, read_parameter
from studies.record.quantities import quantity
from studies.refusal import SceneError, misread, nearest, refuse_if, resembling
from studies.scene.keys import rule_at
from studies.scene.quantity import si_value
from studies.scene.ranges import is_number

TRANSLATIONS = ("velocity", "mean_velocity", "thrust")
SYNONYMS = {"speed": "velocity", "force": "thrust", "resolution": "step_resolution"}  # for a hint
# by goal: quantities of a point, of which the first that has a value is taken, and True if less is better
GOALS = {
    "velocity": ((quantity.velocity_m_per_s,), False),  # at the slider's position
    "mean_velocity": ((quantity.mean_velocity_m_per_s,), False),  # over half a wavelength about it
    "thrust": ((quantity.thrust_N,), False),
    "rotation": ((quantity.rotation_rpm,), False),
    "torque": ((quantity.stall_torque_N_m,), False),
    "efficiency": ((quantity.motor_efficiency, quantity.contact_efficiency), False),
    "step_resolution": ((quantity.step_m,), True),
}
# outcomes that a constraint may name, beside keys of the scene
BOUNDED = {
    "velocity": quantity.velocity_m_per_s, "mean_velocity": quantity.mean_velocity_m_per_s,
    "lateral_velocity": quantity.lateral_velocity_m_per_s, "rotation": quantity.rotation_rpm,
    "torque": quantity.stall_torque_N_m, "ripple": quantity.velocity_ripple, "thrust": quantity.thrust_N,
    "contact_pressure": quantity.contact_pressure_Pa,
    "stick_margin": quantity.stick_margin, "normal_amplitude": quantity.normal_amplitude_m,
    "power_W": quantity("sweep.power_W"),
}  # fmt: skip
SIGNED = tuple(
    BOUNDED[name].column for name in ("velocity", "mean_velocity", "lateral_velocity", "rotation", "torque")
)  # their size is compared with the bound
MINIMISED = (
    "power_W",
    "ripple",
    "contact_pressure",
    "normal_amplitude",
)  # of BOUNDED, what may be minimised beside keys
LEAST = "least "  # before the name of what is minimised


@dataclass(frozen=True, kw_only=True)
class Goal:
    """What a search maximises or minimises."""

    name: str  # of GOALS, or LEAST and what is minimised
    columns: tuple[str, ...]  # of a point, of which the first that has a value is taken
    less: bool = False  # True: minimised

    @property
    def argument(self) -> str:
        """The argument of `studies.design` that names it, and its name, for messages."""
        name = self.name.removeprefix(LEAST)
        return f"goals {name}" if name == self.name else f"minimise {name}"

    def column(self, point: dict) -> str | None:
        """Return the first column that has a value at a point; None without an answer."""
        return next((name for name in self.columns if point.get(name) is not None), None)

    def merit(self, point: dict) -> float:
        """Return the size of the quantity, or its inverse where less is better; 0 without an answer."""
        column = self.column(point)
        value = 0.0 if column is None else abs(point[column])
        return (1.0 / value if value > 0.0 else 0.0) if self.less else value


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """A bound on an outcome or on a key of the scene, in SI units."""

    text: str
    column: str
    upper: bool
    bound: float

    def excess(self, point: dict) -> float:
        """Return by how much a point is beyond the bound, relative to it; negative within, 1 without an answer."""
        value = point.get(self.column)
        if value is None:
            return 1.0
        value = abs(value) if self.column in SIGNED else value
        return (value - self.bound) * (1.0 if self.upper else -1.0) / (abs(self.bound) or 1.0)


def read_goals(texts: list[str], variables: tuple[Parameter, ...]) -> tuple[Goal, ...]:
    """Read one or two different goals: names of ``GOALS``, or "least" and an outcome or one of the varied keys.

    Examples
    --------
    >>> [each.columns for each in read_goals(["velocity", "least power_W"], ())]
    [('velocity_m_per_s',), ('power_W',)]
    """
    least = {name: BOUNDED[name].column for name in MINIMISED} | {each.key: each.key for each in variables}
    goals = []
    for text in texts:
        name = text.removeprefix(LEAST)
        if text in GOALS:
            shown, less = GOALS[text]
            goals.append(Goal(name=text, columns=tuple(each.column for each in shown), less=less))
        elif text != name and name in least:
            goals.append(Goal(name=text, columns=(least[name],), less=True))
        elif text != name:
            raise SceneError(f"minimise {name}", f"must be of {', '.join(least)}")
        elif text in least:
            raise SceneError(f"goals {text}", "can only be minimised")
        else:
            raise SceneError(
                f"goals {text}", f"is none of {', '.join(GOALS)}{resembling(SYNONYMS.get(text, text), GOALS)}"
            )
    rule = f"must be one or two different ones of {', '.join(GOALS)}, got {', '.join(texts) or 'none'}"
    refuse_if(not 1 <= len(goals) == len(set(texts)) == len(texts) <= 2, "goals", rule)
    return tuple(goals)


def refuse_on_axle(goals: Iterable[Goal], table: dict) -> None:
    """Raise a SceneError for a goal that is zero for every motor of the scene's table, whose slider is on an axle."""
    if table.get("slider", {}).get("axis") is None:
        return
    for goal in goals:
        rule = "is zero for a slider on an axle, slider.axis: its goals are rotation and torque"
        refuse_if(goal.name in TRANSLATIONS, f"goals {goal.name}", rule)


def read_variable(text: str | Parameter) -> Parameter:
    """Read ``KEY=LOW:HIGH`` of a number or a count of the scene; a parameter is returned as it is."""
    return read_parameter(text, "variables", design=True)


def read_constraint(text: str | Constraint) -> Constraint:
    """Read ``NAME <= VALUE`` or ``NAME >= VALUE``, the name an outcome or a key of the scene; or return a constraint.

    Examples
    --------
    >>> read_constraint("contact_pressure <= 400 MPa").bound
    400000000.0
    """
    if isinstance(text, Constraint):
        return text
    match = re.fullmatch(r"\s*([\w.]+)\s*(<=|>=)\s*(.+?)\s*", text)
    if match is None:
        raise misread("constraints", "NAME <= VALUE or NAME >= VALUE", text)
    name, sign, value = match.groups()
    bound: float | str | tuple
    if name in BOUNDED:
        column, unit = BOUNDED[name].column, BOUNDED[name].unit.removeprefix("1")
        bound = float(value) if is_number(value) else si_value(f"constraints {name}", value, unit)
    elif "." in name:
        column, bound = name, rule_at(name).read(name, float(value) if is_number(value) else value)
        if isinstance(bound, tuple):
            bound = bound[0]
    else:
        raise SceneError(f"constraints {name}", f"is no outcome and no key of a scene{nearest(name, BOUNDED)}")
    if isinstance(bound, bool) or not isinstance(bound, (int, float)) or not math.isfinite(bound):
        raise misread(f"constraints {name}", "compared with a number", value)
    return Constraint(text=" ".join(text.split()), column=column, upper=sign == "<=", bound=float(bound))
