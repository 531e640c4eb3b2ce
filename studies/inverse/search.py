"""Search for the best point in the unit box of the variables: differential evolution, then COBYQA from its best.

Where each evaluation solves a stator, differential evolution takes the coarsest discretisation (``coarse``); its best
points are evaluated again at the tolerance, and COBYQA starts from the best of them.  A point that breaks a constraint
counts as worse than any feasible one, by how much it breaks it (Deb, Comput. Methods Appl. Mech. Eng. 186 (2000) 311).
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import differential_evolution, minimize

from studies.inverse.evaluations import Evaluations
from studies.inverse.free_parameters import Parameter
from studies.inverse.goals import Constraint, Goal
from studies.record.values import Columns

WEIGHTS = (0.25, 0.5, 0.75)  # of the second goal, between the searches for each alone
GLOBAL_SHARE, CROWD = 0.7, 8  # evaluations by differential evolution; members of a generation per variable
REPEATED = 8  # best points of the coarse search that are evaluated at the tolerance
RADIUS = 1e-4  # of COBYQA's last trust region, in the unit box
# Added to the value of a point that breaks a constraint, and the sum of excesses of one without an answer; the value of
# a feasible point is at most 0
INFEASIBLE, UNKNOWN = 1.0, 1e6


@dataclass(kw_only=True)
class Search:
    """The searches of one design."""

    evaluate: Evaluations  # at the tolerance
    coarse: Evaluations | None  # on the stator's coarsest discretisation; None where no evaluation solves a stator
    variables: tuple[Parameter, ...]
    constraints: tuple[Constraint, ...]
    goals: tuple[Goal, ...]
    seed: int
    best_of_each: list[float] | None = None  # best value of each of two goals; once known, a search weighs both

    def run(self, budget: int) -> None:
        """Search for the best of each goal; with two goals also for the best of weights between them.

        Each search takes about ``budget`` evaluations.
        """
        self.evaluate.expected = budget * (len(self.goals) + (len(WEIGHTS) if len(self.goals) == 2 else 0))
        best_of_each = [self._run(weights, budget) for weights in np.eye(len(self.goals)).tolist()]
        if len(self.goals) == 2:
            self.best_of_each = best_of_each
            for weight in WEIGHTS:
                self._run([1.0 - weight, weight], budget)

    @property
    def feasible(self) -> list[Columns]:
        """The points, evaluated at the tolerance, that satisfy all constraints."""
        return [point for point in self.evaluate.points if self.violation(point) == 0.0]

    def violation(self, point: Columns) -> float:
        """Return the sum of the relative excesses over the constraints, and `UNKNOWN` where a point has no answer."""
        if point.relative_error is None:
            return UNKNOWN
        return sum(max(0.0, each.excess(point)) for each in self.constraints)

    def _run(self, weights: list[float], budget: int) -> float:
        """Search with weights of the goals; return the value reached of the goal of largest weight."""
        count = len(self.variables)
        members = max(1, min(CROWD, int(GLOBAL_SHARE * budget) // (4 * count)))  # per variable
        generation = max(5, members * count)
        generations = max(1, int(GLOBAL_SHARE * budget) // generation - 1)  # after the first
        value = partial(self._value, weights=weights)

        def values(shares):
            return np.array([value(point) for point in self._points(shares.T, self.coarse or self.evaluate)])

        result = differential_evolution(
            values, [(0.0, 1.0)] * count, popsize=members, maxiter=generations, rng=np.random.default_rng(self.seed),
            vectorized=True, updating="deferred", polish=False, tol=0.0,
        )  # fmt: skip
        start, left = result.x, budget - generation * (generations + 1)
        if self.coarse is not None:
            best = sorted(self.coarse.points, key=value)[:REPEATED]
            repeated = self.evaluate([tuple(point[each.key] for each in self.variables) for point in best])
            first = min(repeated, key=value)
            start, left = np.array([each.share(first[each.key]) for each in self.variables]), left - REPEATED
        free = [k for k, each in enumerate(self.variables) if not each.counted]
        if free:
            self._local(start, free, weights, left)
        return self.goals[int(np.argmax(weights))].merit(min(self.evaluate.points, key=value))

    def _points(self, shares, evaluate: Evaluations) -> list[Columns]:
        """Return the evaluated points at shares of the ranges, (m, n)."""
        return evaluate([tuple(each.at(x) for each, x in zip(self.variables, own, strict=True)) for own in shares])

    def _merit(self, point: Columns, weights) -> float:
        """Return the goal of largest weight, or 1 less the largest weighted shortfall from the best of each goal."""
        merits = [goal.merit(point) for goal in self.goals]
        if self.best_of_each is None:
            return merits[int(np.argmax(weights))]
        shortfalls = [1.0 - merit / (best or 1.0) for merit, best in zip(merits, self.best_of_each, strict=True)]
        return 1.0 - max(weight * shortfall for weight, shortfall in zip(weights, shortfalls, strict=True))

    def _value(self, point: Columns, weights) -> float:
        """Return the value that the search minimises."""
        violation = self.violation(point)
        return INFEASIBLE + violation if violation > 0.0 else -self._merit(point, weights)

    def _local(self, start, free: list[int], weights, budget: int) -> None:
        """Improve a point by COBYQA, which takes the constraints themselves; whole numbers are held."""

        def at(part):
            shares = np.array(start, float)
            shares[free] = np.clip(part, 0.0, 1.0)
            return self._points([shares], self.evaluate)[0]

        # merit of the best feasible point, so that the objective is of the order of 1
        scale = max((self._merit(point, weights) for point in self.feasible), default=1.0) or 1.0

        def objective(part):
            point = at(part)
            return INFEASIBLE if self.violation(point) >= UNKNOWN else -self._merit(point, weights) / scale

        limits = [{"type": "ineq", "fun": lambda part, each=each: -each.excess(at(part))} for each in self.constraints]
        radius = RADIUS if self.coarse is None else 10 * RADIUS
        minimize(
            objective, np.array(start, float)[free], method="COBYQA", bounds=[(0.0, 1.0)] * len(free),
            constraints=limits,
            options={"maxfev": max(budget, len(free) + 3), "initial_tr_radius": 0.05, "final_tr_radius": radius},
        )  # fmt: skip
