"""The driver of a sweep: tasks given out to workers, their answers kept as they come.

In windows of points: the stator's answers that are not known yet, then batches of points, then again for those that
turned out to need a better stator.  A task that vanished with its worker is halved and given out again, until a single
point has taken ``LIVES`` workers with it.
"""

import json
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, wait
from dataclasses import dataclass, replace

import numpy as np

from studies.refusal import RunError
from studies.sweep.batch import solved_points
from studies.sweep.design import Design, Question
from studies.sweep.source import Source
from studies.sweep.source_solver import STEPS, serves_band, solved_sources
from studies.sweep.store import LOST, Store

WINDOW = 50_000  # points in hand at a time: what bounds the driver's memory
BATCH_SECONDS, LARGEST_BATCH = 0.5, 8192
CHUNK = 64  # frequencies of one band in one task
LIVES = 3  # workers that a task may take with it


@dataclass(frozen=True, kw_only=True)
class _Task:
    """Work for one worker: points with their values, or names of the stator's answers."""

    points: tuple[int, ...] = ()
    values: tuple[tuple, ...] = ()
    names: tuple[str, ...] = ()
    step: int = 0
    lives: int = LIVES


class Driver:
    """Gives out the tasks of one sweep and keeps what comes back."""

    def __init__(self, design: Design, store: Store, staff, progress):
        self.design, self.store, self.staff, self.progress = design, store, staff, progress
        self.question: Question = design.question
        self.size = 4  # points in the next batch
        self.sources: dict[tuple[str, int], Source] = {}

    def run(self) -> None:
        """Compute what is missing, a window of points after the other."""
        done = self.store.done(len(self.design))
        counts = self.store.counts()
        self.kept, self.failed = int(done.sum()), sum(counts.values()) - counts.get("ok", 0)
        self.failed -= counts.get(LOST.rstrip(": "), 0)
        self.cost = self.store.cost()
        self.progress(len(self.design), self.kept, self.failed, self.cost)
        for first in range(0, len(self.design), WINDOW):
            missing = first + np.flatnonzero(~done[first : first + WINDOW])
            if missing.size:
                self._window(missing)

    def _window(self, missing) -> None:
        todo = dict(zip(missing.tolist(), self.design.values(missing), strict=True))
        driven = self.question.kind == "driven"
        for step in range(STEPS):
            if driven:
                self._solve_sources(dict.fromkeys(self.question.source(own) for own in todo.values()), step)
            finer = self._solve_points(todo)
            todo = {point: todo[point] for point in sorted(finer)}
            if not todo:
                break

    def _solve_sources(self, names, step: int) -> None:
        """See that the stator's answers of these names are known at a step, where the step before is one."""
        self.sources |= self.store.sources(name for name in names if (name, step) not in self.sources)
        wanted = [name for name in names if (name, step) not in self.sources]
        chunk = 1
        if serves_band(self.question):
            chunk = CHUNK
            wanted.sort(key=_geometry)
        tasks = (_Task(names=tuple(wanted[k : k + chunk]), step=step) for k in range(0, len(wanted), chunk))
        for finished in self._finished(tasks):
            kept = []
            for task, answer in finished:
                if answer is None:
                    found, seconds = [_lost_source(name, step) for name in task.names], 0.0
                else:
                    found, seconds = answer
                    self.store.keep([], found, [(0, seconds)])
                kept += found
                self.cost += seconds
            self.sources |= {(source.name, source.step): source for source in kept}
            self.progress(len(self.design), self.kept, self.failed, self.cost)

    def _solve_points(self, todo: dict[int, tuple]) -> list[int]:
        """Keep a row for every point but those that need a better stator, which are returned."""
        finer = []
        for finished in self._finished(self._batches(todo)):
            rows, batches = [], []
            for task, answer in finished:
                if answer is None:
                    reason = f"{LOST}{LIVES} workers that computed it vanished"
                    blank = (None,) * (len(self.question.outcomes) - 1)
                    rows += [(task.points[0], *task.values[0], *blank, reason)]
                    continue
                own = dict(zip(task.points, task.values, strict=True))
                found, again, seconds = answer
                rows += [(row[0], *own[row[0]], *row[1:]) for row in found]
                batches.append((len(found), seconds))
                finer += again
                self._adapt(len(task.points), seconds)
            self.store.keep(rows, [], batches)
            self.kept += len(rows)
            self.failed += sum(row[-1] != "ok" for row in rows)
            self.cost += sum(seconds for _, seconds in batches)
            self.progress(len(self.design), self.kept, self.failed, self.cost)
        return finer

    def _adapt(self, points: int, seconds: float) -> None:
        """Choose the next batch so that it takes about BATCH_SECONDS."""
        fitting = points * BATCH_SECONDS / max(seconds, 1e-6)
        self.size = int(min(max(fitting, self.size / 4, 1), 8 * self.size, LARGEST_BATCH))

    def _batches(self, todo: dict[int, tuple]) -> Iterator[_Task]:
        points, at, alone = list(todo), 0, self.staff.slots == 1
        while at < len(points):
            left = len(points) - at
            fair = left if alone else -(-left // (2 * self.staff.size))  # the last batches end together
            some = tuple(points[at : at + max(1, min(self.size, fair))])
            yield _Task(points=some, values=tuple(todo[point] for point in some))
            at += len(some)

    def _submit(self, task: _Task):
        if task.names:
            return self.staff.submit(solved_sources, self.question, task.names, task.step, self.staff.threads)
        needed = {}
        if self.question.kind == "driven":
            for name in dict.fromkeys(self.question.source(own) for own in task.values):
                needed[name] = self._best(name)
        return self.staff.submit(
            solved_points, self.question, list(task.points), list(task.values), needed, self.staff.threads
        )

    def _best(self, name: str) -> Source:
        """Return the finest answer of the stator, as the last one to be had where the next has failed."""
        best = self.sources[name, 0]
        for step in range(1, STEPS):
            found = self.sources.get((name, step))
            if found is None:
                break
            if found.reason:
                return replace(best, step=STEPS - 1)
            best = found
        return best

    def _finished(self, tasks) -> Iterator[list[tuple]]:
        """Yield lists of (task, answer) as they come; the answer is None where a single point is lost for good."""
        running, again, tasks = {}, deque(), iter(tasks)
        while True:
            while len(running) < self.staff.slots:
                task = again.popleft() if again else next(tasks, None)
                if task is None:
                    break
                running[self._submit(task)] = task
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            answers, lost = [], []
            for future in done:
                task = running.pop(future)
                try:
                    answers.append((task, future.result()))
                except self.staff.lost:
                    lost.append(task)
                except ImportError as error:
                    raise RunError(
                        f"a worker cannot import what it needs ({error}): install sawmotor there"
                    ) from None
                except CancelledError:
                    raise RunError(
                        "the Dask scheduler is gone; the same command goes on from there"
                    ) from None
            if lost:
                self.staff.renew()
                for task in lost:
                    again += _retried(task)
                    if task.lives == 1 and len(task.points or task.names) == 1:
                        answers.append((task, None))
            if answers:
                yield answers


def _geometry(name: str) -> str:
    """Return what a stator's answer depends on but for the frequency."""
    return json.dumps({key: value for key, value in json.loads(name).items() if key != "drive.frequency"})


def _retried(task: _Task) -> list[_Task]:
    """Return what is to be tried again of a task that was lost with its worker: halves, then the point alone."""
    items = task.points or task.names
    if len(items) == 1:
        return [replace(task, lives=task.lives - 1)] if task.lives > 1 else []
    parts = (slice(None, len(items) // 2), slice(len(items) // 2, None))
    return [
        replace(task, points=task.points[part], values=task.values[part], names=task.names[part])
        for part in parts
    ]


def _lost_source(name: str, step: int) -> Source:
    return Source(name=name, step=step, reason=f"{LOST}{LIVES} workers that computed its stator vanished")
