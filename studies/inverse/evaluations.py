"""Evaluations of a search: points of a sweep that are requested one generation after the other and kept in its store.

A search requests its points in an order that depends only on its options and on earlier answers.  A search that was
interrupted therefore requests the same points again, reads them from the store and goes on.
"""

import json
import logging
from dataclasses import dataclass, replace
from pathlib import Path

from studies.inverse.free_parameters import Parameter
from studies.model.model import POSITION_KEYS
from studies.progress import Countdown
from studies.record.values import Columns
from studies.refusal import RunError
from studies.scene.override import replaced, value_at
from studies.sweeps.axes import Axis, level_key
from studies.sweeps.driver import Driver
from studies.sweeps.plan import Design as SweepDesign
from studies.sweeps.plan import designed
from studies.sweeps.store import Store
from studies.sweeps.workers import workers

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Options:
    """How a search is made."""

    evaluations: int | None = None  # budget of each search; 60 for each variable when absent
    seed: int = 0  # of the random numbers
    tolerance: float = 3e-2  # of the velocity
    out: Path | None = None  # directory of the store; in memory without one
    workers: int = 1  # processes

    def budget(self, variables: int) -> int:
        """Return the evaluations of each search of a number of variables."""
        return 60 * variables if self.evaluations is None else self.evaluations


def planned(table: dict, variables: tuple[Parameter, ...], *, also, tolerance: float) -> SweepDesign:
    """Return the sweep whose points a search requests; of several voltages or amplitudes it takes the largest."""
    level, keys = level_key(table), [each.key for each in variables]
    if level is not None and level not in keys:
        levels = value_at(table, level)
        table = replaced(table, level, max(levels) if isinstance(levels, (list, tuple)) else levels)
    plan = designed(table, {each.key: [each.low, each.high] for each in variables}, tolerance=tolerance, also=also)
    if any(key in POSITION_KEYS for key in keys):  # each point has its own contact positions
        plan = replace(plan, question=replace(plan.question, positions=()))
    return plan


class Evaluations:
    """Answers at the points of a search; a context manager, which holds the store.

    ``search``: what decides, beside the sweep, which points are requested: goals, constraints, budget, seed.
    ``coarse``: True takes the stator's coarsest discretisation.
    """

    def __init__(self, plan: SweepDesign, search: dict, options: Options, *, coarse: bool = False):
        self.question = replace(plan.question, coarse=coarse)
        self.expected = 0  # largest number of points that the search requests; 0: unknown
        self._countdown: Countdown | None = None
        self.points: list[Columns] = []  # keys and outcomes of each point, in the order of the requests
        self.fixed = tuple(column[0] for axis in plan.axes if len(axis) == 1 for column in axis.columns)
        identity = plan.identity | {"search": json.dumps(search | {"coarse": coarse}, sort_keys=True)}
        axis = Axis(self.question.keys, tuple([] for _ in self.question.keys))  # grows with each request
        self.index: dict[tuple, int] = {}  # of the point with these values
        self.requested = SweepDesign(question=self.question, axes=(axis,))
        folder = None if options.out is None else Path(options.out)
        self.store = Store(folder / "coarse" if coarse and folder else folder, self.requested, identity)
        self.workers = workers(options.workers)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.workers.close()
        self.store.close()

    def __call__(self, values: list[tuple[float, ...]]) -> list[Columns]:
        """Return the points, with keys and outcomes, at some values of the keys; no point is computed twice."""
        first = len(self.requested)
        for own in values:
            if own not in self.index:
                self.index[own] = len(self.requested)
                for column, value in zip(self.requested.axes[0].columns, (*own, *self.fixed), strict=True):
                    column.append(value)
        if len(self.requested) > first:
            Driver(self.requested, self.store, self.workers, self._report).run()
            self._read(first)
        return [self.points[self.index[own]] for own in values]

    def _read(self, first: int) -> None:
        for point in self.store.rows(first, len(self.requested)):
            (expected,) = self.requested.values([point["point"]])
            if tuple(point[key] for key in self.question.keys) != expected:
                raise RunError(
                    f"point {point['point']} of the store is not the one that this search requests: "
                    "name another directory"
                )
            self.points.append(point)

    def _report(self, _total: int, done: int, failed: int, _seconds: float) -> None:
        failures = "" if self.question.coarse else f", {failed} without an answer within the tolerance"
        if self._countdown is None:
            parts = f"{'coarse ' if self.question.coarse else ''}evaluations"
            self._countdown = Countdown("design", self.expected, parts)
        LOGGER.info(f"{self._countdown.text(done)}{failures}")
