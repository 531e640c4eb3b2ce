"""The best motor within ranges: a global search, then a local one, every evaluation kept and the search resumable.

Differential evolution (`scipy.optimize.differential_evolution`) over logarithms of positive numbers, then COBYQA from
its best point.  A point that breaks a constraint counts as worse than any that keeps them, by how much it breaks them
(Deb, Comput. Methods Appl. Mech. Eng. 186 (2000) 311).  Where numbers of the stator are searched, the global search
takes the stator's coarsest discretisation, and its best points are evaluated again at the tolerance.  With two goals
the search is repeated for weights between them (weighted Chebyshev distance from the best of each), and the front is
what no evaluation at the tolerance beats in both.
"""

import logging
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

from studies.chain.outcomes import keywords
from studies.inverse.design_result import Design
from studies.inverse.evaluations import Evaluations, Options, planned
from studies.inverse.goals import LEAST, read_constraint, read_goals, read_variable
from studies.inverse.parameters import ranges
from studies.inverse.search import UNKNOWN, Search
from studies.progress import reported_to
from studies.refusal import RunError, SceneError, all_answers
from studies.scene import Scene
from studies.scene.override import replaced

LOGGER = logging.getLogger(__name__)
WEIGHTS = (0.25, 0.5, 0.75)  # of the second goal, between the searches for each alone
DEFAULT = Options()
CHANGE = 0.05  # of each variable, for the robustness


def design(
    scene: Scene | str | Path | dict,
    goals: str | Sequence[str] = (),
    variables: Sequence | dict = (),
    constraints: Sequence = (),
    *,
    minimise: str | Sequence[str] = (),
    options: Options = DEFAULT,
    progress: Callable[[str], None] | None = None,
) -> Design:
    """Search for the best motor.

    Parameters
    ----------
    scene : Scene, path, name of a shipped scene, or its TOML document
        With a slider; of several voltages or amplitudes the largest counts.
    goals : str or list of str
        Of ``GOALS``, to be maximised; "least power_W" is the same as ``minimise="power_W"``.
    variables : list or dict
        Texts ``"slider.preload=1 mN:20 mN"`` or `Parameter` objects, or a dict of a key's range.
    constraints : list
        Texts ``"stick_margin <= 0"`` or `Constraint` objects.
    minimise : str or list of str
        What is to be as small as it can: power_W, contact_pressure, normal_amplitude or one of the varied keys.
        There are one or two goals in all.
    options : Options
    progress : callable, optional
        Called with a few words about each step, as it is logged.

    Raises
    ------
    SceneError
        For a goal, variable or constraint that does not exist, or a store of another search.
    RunError
        If no evaluation keeps the constraints.
    """
    with reported_to(progress):
        if isinstance(scene, (str, Path)):
            scene = Scene.load(scene)
        table = scene.to_table() if isinstance(scene, Scene) else scene
        names = [*_listed(goals), *(LEAST + each for each in _listed(minimise))]
        readers = [partial(read_variable, each) for each in ranges(variables)]
        read = all_answers([*readers, *(partial(read_constraint, each) for each in constraints)])
        varied, bounds = tuple(read[: len(readers)]), tuple(read[len(readers) :])
        budget = 60 * len(varied) if options.evaluations is None else options.evaluations
        aims = read_goals(names, varied)
        if not varied:
            raise SceneError("variables", "is required: KEY=LOW:HIGH")
        if budget < 4 * len(varied) + 8:
            raise SceneError("evaluations", f"must be at least {4 * len(varied) + 8}, got {budget}")
        also = keywords([*(column for goal in aims for column in goal.columns), *(each.column for each in bounds)])
        plan = planned(table, varied, also=tuple(sorted(also)), tolerance=options.tolerance)
        search = {"goals": names, "subject": [each.text for each in bounds], "evaluations": budget,
                  "seed": options.seed, "ranges": [[each.key, each.low, each.high] for each in varied]}  # fmt: skip
        shared = plan, search, options
        with ExitStack() as stack:
            ask, coarse = stack.enter_context(Evaluations(*shared)), None
            if plan.question.stator_keys:  # of the stator, or the slider's place
                coarse = stack.enter_context(Evaluations(*shared, coarse=True))
            searcher = Search(ask, coarse, varied, bounds, aims, options.seed)
            best_of_each = [searcher.run(weights, budget) for weights in np.eye(len(aims)).tolist()]
            if len(aims) == 2:
                searcher.best_of_each = best_of_each
                for weight in WEIGHTS:
                    searcher.run([1.0 - weight, weight], budget)
            feasible = searcher.feasible(ask.rows)
            if not feasible:
                raise RunError(
                    f"none of {len(ask.rows)} evaluations keeps all constraints: {_closest(searcher, ask.rows)}"
                )
            front = _front(feasible, searcher)
            optimum = front[len(front) // 2]
            rows = [*([] if coarse is None else coarse.rows), *ask.rows]
            robustness = _robustness(searcher, optimum)
            best = table
            for variable in varied:
                best = replaced(best, variable.key, optimum[variable.key])
            evaluations = len(ask.rows) + (0 if coarse is None else len(coarse.rows))
            return Design(
                goals=tuple(names), columns=tuple(str(each.column(optimum)) for each in aims), optimum=optimum,
                front=front, robustness=robustness, rows=rows, evaluations=evaluations, variables=varied, table=best,
            )  # fmt: skip


def _listed(names: str | Sequence[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _front(feasible: list[dict], searcher: Search) -> list[dict]:
    """Return the Pareto front: the points that no other point exceeds in all goals; with one goal the best point."""
    rows = {tuple(goal.merit(point) for goal in searcher.goals): point for point in reversed(feasible)}
    values = np.array(list(rows))
    beaten = {each: np.any(np.all(values >= each, axis=1) & np.any(values > each, axis=1)) for each in rows}
    return [rows[each] for each in sorted(rows, reverse=True) if not beaten[each]]


def _robustness(searcher: Search, optimum: dict) -> dict:
    """Return the share of the first goal that is left with each variable 5 % off, or a whole number 1 off."""
    goal = searcher.goals[0]
    base, robustness = goal.merit(optimum), {}
    own = [optimum[each.key] for each in searcher.variables]
    for k, each in enumerate(searcher.variables):
        change = 1 if each.counted else CHANGE * own[k]
        ends = [end for end in (own[k] - change, own[k] + change) if end > 0]
        rows = searcher.ask([(*own[:k], end, *own[k + 1 :]) for end in ends])
        broken = [searcher.broken(point) for point in rows]
        left = [goal.merit(point) / base if size < UNKNOWN else 0.0 for point, size in zip(rows, broken, strict=True)]
        robustness[each.key] = {"least_share_of_goal": min(left, default=0.0), "keeps_constraints": not any(broken)}
    return robustness


def _closest(searcher: Search, rows: list[dict]) -> str:
    point = min(rows, key=searcher.broken)
    broken = ", ".join(each.text for each in searcher.constraints if each.excess(point) > 0.0)
    return point["status"] if searcher.broken(point) >= UNKNOWN else f"{broken} is broken by the closest"
