"""Profile likelihood intervals: each number fixed in turn, all others fitted again.

An end of the interval is where the sum of squares exceeds its minimum by the quantile of chi^2 with one degree of
freedom (of F, times the estimated variance, where the standard deviations come from the residuals themselves).  The
square root of the excess is nearly linear in the number: a few refits find the end.  An end is open where the range
ends before, and where another number has come to an end of its range: the range would then make the interval, not the
data.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, f

from studies.inverse.directions import LEVEL
from studies.inverse.least_squares import Problem

AGREES = 1e-2  # of the square root of the excess, relative: of the interval's half width
MAX_REFITS = 24
AT_END = 1e-4  # of the range: nearer to an end than this is at it
BETTER = 1e-3  # a sum of squares lower by more than this is a better minimum


@dataclass(frozen=True)
class End:
    """One end of an interval."""

    x: np.ndarray  # all inner values there
    excess: float  # of the sum of squares
    closed: bool  # whether the data make this end
    because: str = ""  # why it is open


class BetterMinimumError(Exception):
    """A refit found a lower sum of squares; ``x`` is where."""

    def __init__(self, x):
        super().__init__()
        self.x = x


def allowed_excess(variance: float, degrees: int | None) -> float:
    """Return the excess of the sum of squares at an end; `degrees` of freedom where the variance is estimated."""
    if degrees is None:
        return float(chi2.ppf(LEVEL, 1))
    return variance * float(f.ppf(LEVEL, 1, degrees))


def profile(
    problem: Problem, minimum: tuple, least: float, j: int, *, sign: float, step: float, allowed: float
) -> End:
    """Return the end of the interval of component j, downwards (``sign`` -1) or upwards.

    ``minimum``: where the profile begins, and the sum of squares there; ``least``: that from which the excess counts;
    ``step``: expected distance of the end; ``allowed``: excess there.  Raises BetterMinimumError.
    """
    best, begun = minimum
    wall = problem.high[j] if sign > 0 else problem.low[j]
    room, target = abs(wall - best[j]), np.sqrt(allowed)
    first = np.sqrt(max(begun - least, 0.0)) - target
    inner, inner_x, outer = (0.0, first), best, None  # (distance, sqrt(excess) - target)
    distance = min(max(step, 1e-6 * room), room)
    here = best
    for _ in range(MAX_REFITS):
        start = _between(inner_x, best, j, best[j] + sign * distance)
        here, squares = problem.minimum(start, fixed=j)
        if squares < least - BETTER * max(1.0, least):
            raise BetterMinimumError(here)
        excess = max(squares - least, 0.0)
        gap = np.sqrt(excess) - target
        if abs(gap) < AGREES * target:
            break
        if gap < 0.0:
            if distance >= room:
                return End(here, excess, False, f"its range ends at {_shown(problem, j, wall)}")
            inner, inner_x = (distance, gap), here
        else:
            outer = (distance, gap)
        if outer is None:
            slope = (gap - first) / distance
            further = -first / slope / distance if slope > 0 else 3.0
            distance = min(distance * float(np.clip(further, 1.2, 3.0)), room)
        else:
            span = outer[0] - inner[0]
            share = float(np.clip(-inner[1] / (outer[1] - inner[1]), 0.1, 0.9))
            if span < 1e-9 * room:
                break
            distance = inner[0] + share * span
    stopped = _at_an_end(problem, here, j)
    if stopped is not None:
        return End(here, excess, False, f"{problem.parameters[stopped].key} is at the end of its range")
    return End(here, excess, True)


def _between(x, best, j, value):
    """Return where a refit begins: along the line from the minimum through the last refit."""
    start = x.copy()
    moved = x[j] - best[j]
    if moved:
        start = best + (x - best) * (value - best[j]) / moved
    start[j] = value
    return start


def _at_an_end(problem: Problem, x, j: int) -> int | None:
    low, high = problem.low, problem.high
    for k in range(len(problem.parameters)):
        if k != j and min(x[k] - low[k], high[k] - x[k]) < AT_END * (high[k] - low[k]):
            return k
    return None


def _shown(problem: Problem, j: int, x: float) -> str:
    return f"{problem.parameters[j].outer(x):.4g}"
