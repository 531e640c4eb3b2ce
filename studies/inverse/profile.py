"""Profile likelihood intervals: each number is fixed at a series of values while all others are fitted again.

An end of the interval is where the sum of squares exceeds its minimum by the quantile of chi^2 with one degree of
freedom (of F, where the standard deviations come from the residuals themselves).  The
square root of the excess is nearly linear in the number, so that a few refits locate the end.  An end is open where the
number's range ends before it, or where another number has reached an end of its range: then the ranges would determine
the interval, and not the data.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, f

from studies.inverse.directions import LEVEL
from studies.inverse.least_squares import Problem

AGREES = 3e-3  # of the interval's half width
MAX_REFITS = 24
AT_END = 1e-4  # of the range: nearer to an end than this is at it
BETTER = 1e-3  # a sum of squares lower by more than this is a better minimum


@dataclass(frozen=True)
class End:
    """One end of an interval."""

    x: np.ndarray  # all inner values there
    closed: bool  # whether the data determine this end
    because: str = ""  # why it is open


class BetterMinimumError(Exception):
    """A refit found a lower sum of squares; ``x`` is where."""

    def __init__(self, x):
        super().__init__()
        self.x = x


def allowed_excess(degrees: int | None) -> float:
    """Return the excess of the sum of squares at an end; `degrees` of freedom where the deviations are estimated."""
    return float(chi2.ppf(LEVEL, 1) if degrees is None else f.ppf(LEVEL, 1, degrees))


def profile(problem: Problem, minimum: tuple, least: float, j: int, *, sign: float, step: float, allowed: float) -> End:
    """Return the end of the interval of component j, downwards (``sign`` -1) or upwards.

    ``minimum``: where the profile begins, and the sum of squares there; ``least``: that from which the excess counts;
    ``step``: expected distance of the end; ``allowed``: excess there.  Raises BetterMinimumError.
    """
    (best, first_square), target = minimum, np.sqrt(allowed)
    wall = problem.high[j] if sign > 0 else problem.low[j]
    room, at = abs(wall - best[j]), {0.0: (best, first_square)}  # refits by their distance

    def gap(distance):
        """Return by how much the square root of the excess is beyond its end."""
        if distance not in at:
            nearest = max((each for each in at if each < distance), default=0.0)
            at[distance] = problem.minimum(_between(at[nearest][0], best, j, best[j] + sign * distance), fixed=j)
        here, squares = at[distance]
        if squares < least - BETTER * max(1.0, least):
            raise BetterMinimumError(here)
        return np.sqrt(max(squares - least, 0.0)) - target

    inner, outer = 0.0, min(max(step, 1e-6 * room), room)
    while (beyond := gap(outer)) < 0.0:
        if outer >= room:
            ending = problem.parameters[j].outer(wall)
            return End(at[outer][0], False, f"its range ends at {ending:.4g}")
        slope = (beyond - gap(0.0)) / outer
        further = -gap(0.0) / slope / outer if slope > 0.0 else 3.0
        inner, outer = outer, min(outer * float(np.clip(1.02 * further, 1.2, 3.0)), room)
    x, _ = at[brentq(gap, inner, outer, xtol=AGREES * outer, maxiter=MAX_REFITS, disp=False)]
    near = AT_END * (problem.high - problem.low)
    for k, parameter in enumerate(problem.parameters):
        if k != j and min(x[k] - problem.low[k], problem.high[k] - x[k]) < near[k]:
            return End(x, False, f"{parameter.key} is at the end of its range")
    return End(x, True)


def _between(x, best, j, value):
    """Return the start of a refit: on the line from the minimum through the last refit."""
    start = x.copy()
    moved = x[j] - best[j]
    if moved:
        start = best + (x - best) * (value - best[j]) / moved
    start[j] = value
    return start
