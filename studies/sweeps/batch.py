"""A batch of a sweep's points: a row for every one of them, the failed ones with their reason.

A row depends on its own point alone, to the last bit: neither on the other points of the batch, nor on the worker, nor
on the number of threads.
"""

import math
import os
import time
from functools import lru_cache

from studies.chain.changed_contacts import Shared
from studies.chain.predictor import Predictor
from studies.sweeps.plan import Question


def solved_points(
    question: Question, points: list[int], values: list[tuple], threads: int | None
) -> tuple[list[tuple], float, float]:
    """Return the rows of a batch, each a point and its outcomes, the seconds it took, and those of its stators.

    ``threads``: of the compiled loop, None for all processors.
    """
    start_time, predictor = time.perf_counter(), _predictor(question)
    before = predictor.seconds
    if threads is not None:
        from fem import set_workers

        set_workers(threads)
        os.environ["SAWMOTOR_THREADS"] = str(threads)
    many = [dict(zip(question.keys, own, strict=True)) for own in values]
    answers = predictor.answers(many, question.also)
    rows = [
        (point, *(_kept(answer.get(name)) for name in question.outcomes))
        for point, answer in zip(points, answers, strict=True)
    ]
    return rows, time.perf_counter() - start_time, predictor.seconds - before


@lru_cache(2)
def _predictor(question: Question) -> Predictor:
    """Return the predictor of a question, the same for all batches that a process is given."""
    shared = Shared(places=question.places, limits=question.frequencies, slider=question.has_slider)
    return Predictor(question.table, tolerance=question.tolerance, shared=shared, coarse=question.coarse)


def _kept(value):
    """Return a value for the store: None where it is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
