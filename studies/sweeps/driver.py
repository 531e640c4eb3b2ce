"""The driver of a sweep: submits batches of points to workers and stores their rows as they come.

A row depends on its own point alone, to the last bit: neither on the other points of its batch, nor on the worker, nor
on the number of threads.  Points of one stator follow one another, so that a worker solves it once for many of them.
If a worker's process dies, its batch is halved and submitted again; a single point is given up after ``MAX_ATTEMPTS``
workers have died with it.
"""

import math
import os
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, replace
from functools import lru_cache

from fem import set_workers
from studies.record.status import Status
from studies.refusal import RunError
from studies.solve.predictor import Predictor
from studies.solve.stators import Shared
from studies.sweeps.plan import Design, Question
from studies.sweeps.store import Store
from studies.sweeps.workers import Workers

BATCH_SECONDS, MAX_BATCH_POINTS = 0.5, 8192
BAND_STATORS = 64  # frequencies of a band in one batch; a batch has one stator where each is solved alone
MAX_ATTEMPTS = 3  # workers that may die with a batch of one point


@dataclass(frozen=True, kw_only=True)
class _Batch:
    points: tuple[int, ...]
    values: tuple[tuple, ...]
    attempts_left: int = MAX_ATTEMPTS


class Driver:
    """Submits the points of one sweep to workers and stores their rows.

    ``progress`` is called with (points, of them stored, of those failed, seconds of work).
    """

    def __init__(self, design: Design, store: Store, workers: Workers, progress: Callable):
        self.design, self.store, self.workers, self.progress = design, store, workers, progress
        self.batch_points = 4  # of the next batch

    def run(self) -> None:
        """Compute the points that the store does not hold."""
        done, question, order = self.store.done(len(self.design)), self.design.question, self.design.order()
        cost, stored = self.store.cost(), int(done.sum())
        failed = stored - self.store.counts().get(Status.OK, 0)
        self.progress(len(self.design), stored, failed, cost)
        for finished in self._finished(self._batches(order[~done[order]])):
            rows, batches = [], []
            for batch, answer in finished:
                if answer is None:
                    reason = Status.LOST.because(f"{MAX_ATTEMPTS} workers that computed it vanished")
                    blank = (None,) * (len(question.outcomes) - 1)
                    rows.append((batch.points[0], *batch.values[0], *blank, reason))
                    continue
                values = dict(zip(batch.points, batch.values, strict=True))
                outcomes_of_points, seconds, stator_seconds = answer
                rows += [(point, *values[point], *outcomes) for point, *outcomes in outcomes_of_points]
                batches.append((len(outcomes_of_points), seconds))
                self._adapt(len(outcomes_of_points), seconds - stator_seconds, stator_seconds)
            self.store.write(rows, batches)
            stored += len(rows)
            failed += sum(row[-1] != Status.OK for row in rows)
            cost += sum(seconds for _, seconds in batches)
            self.progress(len(self.design), stored, failed, cost)

    def _adapt(self, points: int, seconds: float, stator_seconds: float) -> None:
        """Size the next batch so that its contacts take BATCH_SECONDS, or as long as the stators of this one did."""
        fitting = points * max(BATCH_SECONDS, stator_seconds) / max(seconds, 1e-6)
        self.batch_points = int(min(max(fitting, self.batch_points / 4, 1), 8 * self.batch_points, MAX_BATCH_POINTS))

    def _batches(self, points) -> Iterator[_Batch]:
        question, first = self.design.question, 0
        stator_columns = [question.keys.index(key) for key in question.stator_keys]
        while first < len(points):
            left = len(points) - first
            fair = -(-left // self.workers.slots)  # so that the last batches end together
            some, stators, count = points[first : first + max(1, min(self.batch_points, fair))], set(), 0
            values = self.design.values(some)
            for each in values:
                stators.add(str([each[k] for k in stator_columns]))
                if len(stators) > (BAND_STATORS if question.frequencies else 1):
                    break
                count += 1
            yield _Batch(points=tuple(some[:count].tolist()), values=tuple(values[:count]))
            first += count

    def _finished(self, batches: Iterator[_Batch]) -> Iterator[list[tuple]]:
        """Yield lists of (batch, answer) as they come; the answer is None where a single point is lost for good."""
        workers, question = self.workers, self.design.question
        running: dict[Future, _Batch] = {}
        again: deque[_Batch] = deque()
        while True:
            while len(running) < workers.slots:
                batch = again.popleft() if again else next(batches, None)
                if batch is None:
                    break
                future = workers.submit(solved_points, question, batch.points, batch.values, workers.threads)
                running[future] = batch
            if not running:
                return
            answers, lost = [], []
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                batch = running.pop(future)
                try:
                    answers.append((batch, future.result()))
                except workers.lost:
                    lost.append(batch)
                except ImportError as error:
                    raise RunError(f"a worker cannot import what it needs ({error}): install sawmotor there") from None
                except CancelledError:
                    raise RunError("the Dask scheduler is gone; the same command goes on from there") from None
            if lost:
                workers.renew()
            for batch in lost:
                half = len(batch.points) // 2
                parts = (slice(None, half), slice(half, None))
                if half:
                    again += [replace(batch, points=batch.points[k], values=batch.values[k]) for k in parts]
                elif batch.attempts_left > 1:
                    again.append(replace(batch, attempts_left=batch.attempts_left - 1))
                else:
                    answers.append((batch, None))
            if answers:
                yield answers


def solved_points(
    question: Question, points: list[int], values: list[tuple], threads: int | None
) -> tuple[list[tuple], float, float]:
    """Return point and outcomes of each point of a batch, the seconds it took, and those of its stators.

    ``threads``: of the compiled loop, None for all processors.
    """
    start_time, predictor = time.perf_counter(), _predictor(question)
    before = predictor.stators.seconds
    if threads is not None:
        set_workers(threads)
        os.environ["SAWMOTOR_THREADS"] = str(threads)
    changes = [dict(zip(question.keys, each, strict=True)) for each in values]
    answers = predictor.answers(changes, question.also, quick=True)
    names = question.outcomes
    rows = [
        (point, *[_finite(getattr(answer.point, name)) for name in names])
        for point, answer in zip(points, answers, strict=True)
    ]
    return rows, time.perf_counter() - start_time, predictor.stators.seconds - before


@lru_cache(2)
def _predictor(question: Question) -> Predictor:
    """Return the predictor of a question, one for all batches of a process."""
    shared = Shared(
        positions=question.positions, limits=question.frequencies, frequencies=question.frequency_count,
        slider=question.has_slider,
    )  # fmt: skip
    return Predictor(question.table, tolerance=question.tolerance, shared=shared, coarse=question.coarse)


def _finite(value):
    """Return a value of the store: None for a number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
