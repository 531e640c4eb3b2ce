"""Runs of one burst at ever finer levels of resolution, until the estimated error is within the tolerance."""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from contact.choice import Result


def refined(burst, follow, error, levels, least):
    """Return (level, run, result) of the first level of resolution whose estimated error is within the tolerance.

    The error is estimated from the difference to the run at the previous level. The run at the last level is returned
    whatever its error.

    Parameters
    ----------
    follow : callable
        Takes a level and returns the run, a tuple. Its first entry holds the velocities to compare; the last of these
        is the velocity at the end of the burst.
    error : callable
        Takes (level, run, largest difference of these velocities, reference speed) and returns the estimated error,
        all scaled.
    levels : tuple of tuple
        Resolutions from coarse to fine, such as `STEPS`. The last entry of each is the smallest tolerance for which
        it is fine enough.
    least : int
        The first level to run is the coarsest one that is fine enough for the tolerance, but not below this one.
    """
    serving = (k for k, (*_, down_to) in enumerate(levels) if burst.tolerance >= down_to)
    level = max(next(serving, len(levels) - 1), least)
    coarse, fine = _both(follow, level - 1, level)
    while True:
        velocity = float(fine[0][-1])
        apart = difference_along if burst.track is not None else largest_difference
        estimate = error(level, fine, apart(coarse[0], fine[0]), burst.reference(velocity))
        if estimate <= burst.allowed(velocity) or level == len(levels) - 1:
            return level, fine, Result((), estimate, burst.allowed(velocity), {})
        level += 1
        coarse, fine = fine, follow(level)


def largest_difference(coarse, fine):
    """Return the largest difference of two runs' velocities."""
    return float(np.max(np.abs(fine - coarse)))


def difference_along(coarse, fine):
    """Return the largest difference of two runs' velocities in the second half of what both followed, and at the end.

    The last entry of each is that at the end, which is earlier where the slider came to an end of the track.
    """
    common = min(len(coarse), len(fine)) - 1
    apart = np.abs(coarse[:common] - fine[:common])[common // 2 :]
    return float(max(np.max(apart, initial=0.0), abs(coarse[-1] - fine[-1])))


def _both(work, first, second):
    """Return work(first) and work(second), computed in two threads; the kernels release the interpreter lock."""
    if os.environ.get("SAWMOTOR_THREADS") == "1":
        return work(first), work(second)
    with ThreadPoolExecutor(1) as aside:
        job = aside.submit(work, first)
        result = work(second)
        return job.result(), result
