"""Search for the best point in the unit box of the variables: differential evolution, then COBYQA from its best.

Where each evaluation solves a stator, differential evolution takes the coarsest discretisation (``coarse``); its best
points are evaluated again at the tolerance, and COBYQA goes on there from the best of them.
"""

import numpy as np
from scipy.optimize import differential_evolution, minimize

from studies.inverse.evaluations import Evaluations
from studies.inverse.goals import Constraint, Goal
from studies.inverse.parameters import Parameter

GLOBAL_SHARE, CROWD = 0.7, 8  # evaluations by differential evolution; members of a generation per variable
REPEATED = 8  # best points of the coarse search that are evaluated at the tolerance
RADIUS = 1e-4  # of COBYQA's last trust region, in the unit box
# Added to the value of a point that breaks a constraint, and the sum of excesses of one without an answer; the value of
# a feasible point is at most 0
INFEASIBLE, UNKNOWN = 1.0, 1e6


class Search:
    """The searches of one design.

    ``ask`` evaluates points at the tolerance, ``coarse`` on the stator's coarsest discretisation (None where no
    evaluation solves a stator). ``best_of_each`` is the best value of each goal, once known: from then on a search
    weighs both goals.
    """

    def __init__(
        self, ask: Evaluations, coarse: Evaluations | None, variables: tuple[Parameter, ...],
        constraints: tuple[Constraint, ...], goals: tuple[Goal, ...], seed: int,
    ):  # fmt: skip
        self.ask, self.coarse = ask, coarse
        self.variables, self.constraints, self.goals, self.seed = variables, constraints, goals, seed
        self.best_of_each: list[float] | None = None

    def run(self, weights: list[float], budget: int) -> float:
        """Search with weights of the goals; return the value reached of the goal of largest weight."""
        count = len(self.variables)
        members = max(1, min(CROWD, int(GLOBAL_SHARE * budget) // (4 * count)))  # per variable
        generation = max(5, members * count)
        generations = max(1, int(GLOBAL_SHARE * budget) // generation - 1)  # after the first

        def values(xs):
            return np.array([self.value(point, weights) for point in self.rows(xs.T, self.coarse)])

        result = differential_evolution(
            values, [(0.0, 1.0)] * count, popsize=members, maxiter=generations, rng=np.random.default_rng(self.seed),
            vectorized=True, updating="deferred", polish=False, tol=0.0,
        )  # fmt: skip
        start, left = result.x, budget - generation * (generations + 1)
        if self.coarse is not None:
            start, left = self._repeated(weights), left - REPEATED
        free = [k for k, each in enumerate(self.variables) if not each.counted]
        if free:
            self._local(start, free, weights, left)
        best = min(self.ask.rows, key=lambda point: self.value(point, weights))
        return self.goals[int(np.argmax(weights))].merit(best)

    def rows(self, positions, ask: Evaluations | None = None) -> list[dict]:
        """Return the evaluations at positions in the unit box."""
        return (ask or self.ask)(
            [tuple(each.at(x) for each, x in zip(self.variables, position, strict=True)) for position in positions]
        )

    def broken(self, point: dict) -> float:
        """Return the sum of the relative excesses over the constraints, and `UNKNOWN` where a point has no answer."""
        if point["relative_error"] is None:
            return UNKNOWN
        return sum(max(0.0, each.excess(point)) for each in self.constraints)

    def merit(self, point: dict, weights) -> float:
        """Return the objective: the goal of largest weight, or 1 less the largest weighted shortfall from the best."""
        merits = [goal.merit(point) for goal in self.goals]
        if self.best_of_each is None:
            return merits[int(np.argmax(weights))]
        shares = [1.0 - value / (best or 1.0) for value, best in zip(merits, self.best_of_each, strict=True)]
        return 1.0 - max(weight * share for weight, share in zip(weights, shares, strict=True))

    def value(self, point: dict, weights) -> float:
        """Return the value that the search minimises: infeasible points count as worse than all feasible ones."""
        broken = self.broken(point)
        return INFEASIBLE + broken if broken > 0.0 else -self.merit(point, weights)

    def feasible(self, rows) -> list[dict]:
        """Return the points that keep the constraints."""
        return [point for point in rows if self.broken(point) == 0.0]

    def _repeated(self, weights) -> np.ndarray:
        """Evaluate the best points of the coarse search at the tolerance; return the best of them in the unit box."""
        rows = [] if self.coarse is None else self.coarse.rows
        best = sorted(rows, key=lambda point: self.value(point, weights))[:REPEATED]
        rows = self.ask([tuple(point[each.key] for each in self.variables) for point in best])
        start = min(rows, key=lambda point: self.value(point, weights))
        return np.array([each.share(start[each.key]) for each in self.variables])

    def _local(self, start, free, weights, budget: int) -> None:
        """Improve the best point by COBYQA, which takes the constraints themselves; whole numbers are held."""

        def at(part):
            position = np.array(start, float)
            position[free] = np.clip(part, 0.0, 1.0)
            return self.rows([position])[0]

        # merit of the best feasible point, so that the objective is of the order of 1
        scale = max((self.merit(point, weights) for point in self.feasible(self.ask.rows)), default=1.0) or 1.0

        def size(part):
            point = at(part)
            return INFEASIBLE if self.broken(point) >= UNKNOWN else -self.merit(point, weights) / scale

        limits = [{"type": "ineq", "fun": lambda part, each=each: -each.excess(at(part))} for each in self.constraints]
        radius = RADIUS if self.coarse is None else 10 * RADIUS
        minimize(
            size, np.array(start, float)[free], method="COBYQA", bounds=[(0.0, 1.0)] * len(free), constraints=limits,
            options={"maxfev": max(budget, len(free) + 3), "initial_tr_radius": 0.05, "final_tr_radius": radius},
        )  # fmt: skip
