"""The best motor within ranges: a global search, then a local one, every evaluation kept and the search resumable.

Differential evolution (`scipy.optimize.differential_evolution`) over logarithms of positive numbers, then COBYQA from
its best point (`studies.inverse.search`).  Where numbers of the stator are searched, the global search takes the
stator's coarsest discretisation, and its best points are evaluated again at the tolerance.  With two goals the search
is repeated for weights between them (weighted Chebyshev distance from the best of each), and the front holds the points
that no other exceeds in both.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fem.parameters import refuses
from studies.inverse.design_result import Design
from studies.inverse.evaluations import Evaluations, Options, planned
from studies.inverse.free_parameters import Parameter, ranges
from studies.inverse.goals import LEAST, Constraint, Goal, read_constraint, read_goals, read_variable, refuse_on_axle
from studies.inverse.search import UNKNOWN, Search
from studies.model.resolve import build
from studies.progress import reported_to
from studies.refusal import RunError, SceneError, all_answers, refuse_if
from studies.scene import Scene
from studies.scene.keys import coordinate
from studies.scene.override import replaced
from studies.solve.requested_quantities import keywords, motions_in_plane

DEFAULT = Options()
# Change of each variable for the robustness: a share of it, of a position that of a wavelength, of an angle in degrees
CHANGE, TURN = 0.05, 1.0


def design(
    scene: Scene | str | Path | dict,
    goals: str | Sequence[str] = (),
    variables: Sequence | Parameter | dict = (),
    constraints: Sequence | Constraint = (),
    *,
    minimise: str | Sequence[str] = (),
    options: Options = DEFAULT,
    progress: Callable[[str], None] | None = None,
) -> Design:
    """Search for the best motor.

    Parameters
    ----------
    scene : Scene, path, name of a shipped scene, or its TOML document
        With a slider; of several voltages or amplitudes the largest is taken.
    goals : str or list of str
        Of ``GOALS``, to be maximised; "least power_W" is the same as ``minimise="power_W"``.
    variables : str, Parameter, list or dict
        Texts ``"slider.preload=1 mN:20 mN"`` or `Parameter` objects, or a dict of a key's range.
    constraints : str, Constraint or list
        Texts ``"stick_margin <= 0"`` or `Constraint` objects.
    minimise : str or list of str
        To be minimised: power_W, contact_pressure, normal_amplitude or a key of ``variables``.  There are one or two
        goals in all.
    options : Options
    progress : callable, optional
        Called with a few words about each step, as it is logged.

    Raises
    ------
    SceneError
        For a goal, variable or constraint that does not exist, or a store of another search.
    RunError
        If no evaluation satisfies the constraints.
    """
    with reported_to(progress):
        table = scene if isinstance(scene, dict) else Scene.load(scene).to_table()
        names = [*_listed(goals), *(LEAST + each for each in _listed(minimise))]
        readers = [partial(read_variable, each) for each in ranges(variables)]
        constraints = [constraints] if isinstance(constraints, (str, Constraint)) else constraints
        read = all_answers([*readers, *(partial(read_constraint, each) for each in constraints)])
        varied, bounds = tuple(read[: len(readers)]), tuple(read[len(readers) :])
        aims = read_goals(names, varied)
        refuse_on_axle(aims, table)
        refuse_if(not varied, "variables", "is required: KEY=LOW:HIGH")
        budget = options.budget(len(varied))
        min_budget = 4 * len(varied) + 8
        refuse_if(budget < min_budget, "evaluations", f"must be at least {min_budget}, got {budget}")
        also = keywords([*(column for goal in aims for column in goal.columns), *(each.column for each in bounds)])
        also = _available(also, table)
        plan = planned(table, varied, also=tuple(sorted(also)), tolerance=options.tolerance)
        _refuse_absent({*plan.question.keys, *plan.question.outcomes}, aims, bounds)
        # part of the identity of the store: another search in the same directory is refused
        search = {"goals": names, "subject": [each.text for each in bounds], "evaluations": budget,
                  "seed": options.seed, "ranges": [[each.key, each.low, each.high] for each in varied]}  # fmt: skip
        with ExitStack() as stack:
            evaluate, coarse = stack.enter_context(Evaluations(plan, search, options)), None
            if plan.question.stator_keys:  # of the stator, or the slider's position
                coarse = stack.enter_context(Evaluations(plan, search, options, coarse=True))
            searcher = Search(evaluate=evaluate, coarse=coarse, variables=varied, constraints=bounds, goals=aims,
                              seed=options.seed)  # fmt: skip
            searcher.run(budget)
            front = _front(searcher)
            optimum = front[len(front) // 2]
            points = [*(coarse.points if coarse else ()), *evaluate.points]
            robustness = _robustness(searcher, optimum, _changes(table, varied, optimum))
            evaluations = len(evaluate.points) + (len(coarse.points) if coarse else 0)
        for variable in varied:
            table = replaced(table, variable.key, optimum[variable.key])
        return Design(
            goals=tuple(names), columns=tuple(str(each.column(optimum)) for each in aims), optimum=optimum,
            front=front, robustness=robustness, points=points, evaluations=evaluations, variables=varied, table=table,
        )  # fmt: skip


def _available(also: tuple[str, ...], table: dict) -> tuple[str, ...]:
    """Return the keywords that have an answer for the scene's slider; goals of the others are refused by their name."""
    if not motions_in_plane(table.get("slider", {})):
        return also
    from studies.solve.plane_quantities import OF_PLANE  # a slider along x imports nothing of the plane

    return tuple(each for each in also if each in OF_PLANE)


@refuses(SceneError)
def _refuse_absent(known: set[str], goals: tuple[Goal, ...], constraints: tuple[Constraint, ...]) -> Iterator[Any]:
    """Raise a SceneError for a goal or a constraint whose columns no point of the search has."""
    columns = {each.argument: each.columns for each in goals}
    columns |= {f"constraints {each.column}": (each.column,) for each in constraints}
    for argument, names in columns.items():
        if not known.intersection(names):
            yield argument, "is neither varied nor an outcome of this scene"


def _listed(names: str | Sequence[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _front(searcher: Search) -> list[dict]:
    """Return the Pareto front: the points that no other point exceeds in all goals; with one goal the best point."""
    points = {tuple(goal.merit(point) for goal in searcher.goals): point for point in reversed(searcher.feasible)}
    if not points:
        raise RunError(_why_none(searcher))
    merits = np.array(list(points))
    if not merits.any():
        goals = " and ".join(each.name for each in searcher.goals)
        raise RunError(f"no evaluation that satisfies the constraints has a {goals} other than 0: widen the ranges")
    dominated = {each: np.any(np.all(merits >= each, axis=1) & np.any(merits > each, axis=1)) for each in points}
    return [points[each] for each in sorted(points, reverse=True) if not dominated[each]]


def _changes(table: dict, variables: tuple[Parameter, ...], optimum: dict) -> dict[str, float]:
    """Return by how much each variable is changed for the robustness: a coordinate by no share of it."""
    changes = {each.key: 1 if each.counted else CHANGE * optimum[each.key] for each in variables}
    for key in filter(coordinate, changes):
        changes[key] = TURN
        if not key.endswith("angle"):
            best = table
            for each in variables:
                best = replaced(best, each.key, optimum[each.key])
            model = build(Scene.from_table("", best))
            length = model.scene.wave.wavelength if model.scene.stator is None else model.wavelength
            changes[key] = CHANGE * (length or optimum[key])
    return changes


def _robustness(searcher: Search, optimum: dict, changes: dict[str, float]) -> dict:
    """Return the share of the first goal that is left with each variable changed up and down."""
    goal = searcher.goals[0]
    base, robustness = goal.merit(optimum) or math.inf, {}
    own = [optimum[each.key] for each in searcher.variables]
    for k, each in enumerate(searcher.variables):
        change = changes[each.key]
        ends = [end for end in (own[k] - change, own[k] + change) if end > 0 or coordinate(each.key)]
        points = searcher.evaluate([(*own[:k], end, *own[k + 1 :]) for end in ends])
        violations = [searcher.violation(point) for point in points]
        left = [goal.merit(point) / base if size < UNKNOWN else 0.0
                for point, size in zip(points, violations, strict=True)]  # fmt: skip
        robustness[each.key] = {
            "least_share_of_goal": min(left, default=0.0), "keeps_constraints": not any(violations)
        }  # fmt: skip
    return robustness


def _why_none(searcher: Search) -> str:
    """Return why no point is feasible: what the point nearest to all constraints breaks."""
    points = searcher.evaluate.points
    point = min(points, key=searcher.violation)
    if searcher.violation(point) >= UNKNOWN:
        return f"none of {len(points)} evaluations has an answer; the first one: {points[0]['status']}"
    broken = ", ".join(each.text for each in searcher.constraints if each.excess(point) > 0.0)
    return f"none of {len(points)} evaluations satisfies all constraints: {broken} is broken by the closest"
