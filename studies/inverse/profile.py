"""Profile likelihood intervals: each number is fixed at a series of values while all others are fitted again.

At an end of the interval the sum of squares exceeds its minimum by the quantile of chi^2 with one degree of freedom, or
of F if the standard deviations are estimated from the residuals.  The square root of the excess is nearly linear in the
number, so that a few refits locate the end.  An end is open if the number's range ends before it, or if another number
has reached an end of its range, because then the ranges would determine the interval and not the data.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, f

from studies.inverse.directions import LEVEL
from studies.inverse.least_squares import Problem

AGREES = 3e-3  # tolerance of an end, relative to its distance from the minimum
MAX_REFITS = 24  # between the two distances that bracket an end
AT_END = 1e-4  # distance from an end of the range, relative to the range, below which a number has reached that end
BETTER = 1e-3  # decrease of the sum of squares that counts as a better minimum


@dataclass(frozen=True)
class End:
    """One end of an interval."""

    x: np.ndarray  # solvers' variables there
    closed: bool  # True if the data determine this end
    because: str = ""  # why it is open


class BetterMinimumError(Exception):
    """A refit reached a lower sum of squares, at ``x``."""

    def __init__(self, x):
        super().__init__()
        self.x = x


def allowed_excess(degrees: int | None) -> float:
    """Return the excess of the sum of squares at an end; ``degrees`` of freedom where the deviations are estimated."""
    return float(chi2.ppf(LEVEL, 1) if degrees is None else f.ppf(LEVEL, 1, degrees))


def profile(problem: Problem, minimum: tuple, least: float, j: int, *, sign: float, step: float, allowed: float) -> End:
    """Return the end of the interval of component j, downwards (``sign`` -1) or upwards.

    ``minimum``: where the profile begins, and the sum of squares there; ``least``: the sum of squares from which the
    excess is counted; ``step``: expected distance of the end; ``allowed``: excess there.  Raises BetterMinimumError.
    """
    (best, first_square), allowed_root = minimum, np.sqrt(allowed)
    bound = problem.high[j] if sign > 0 else problem.low[j]
    longest = abs(bound - best[j])
    refits = {0.0: (best, first_square)}  # x and sum of squares by the distance from the minimum

    def beyond_end(distance):
        """Return the square root of the excess at a distance, less its value at the end."""
        if distance not in refits:
            nearest = max(each for each in refits if each < distance)
            start = _on_line(best, refits[nearest][0], j, best[j] + sign * distance)
            refits[distance] = problem.minimum(start, fixed=j)
        x, squares = refits[distance]
        if squares < least - BETTER * max(1.0, least):
            raise BetterMinimumError(x)
        return np.sqrt(max(squares - least, 0.0)) - allowed_root

    # bracket the end between ``inner`` and ``outer``
    inner, outer = 0.0, min(max(step, 1e-6 * longest), longest)
    while (value := beyond_end(outer)) < 0.0:
        if outer >= longest:
            ending = problem.parameters[j].outer(bound)
            return End(refits[outer][0], False, f"its range ends at {ending:.4g}")
        # linear extrapolation from the minimum, as a factor on ``outer``
        slope = (value - beyond_end(0.0)) / outer
        factor = -beyond_end(0.0) / slope / outer if slope > 0.0 else 3.0
        inner, outer = outer, min(outer * float(np.clip(1.02 * factor, 1.2, 3.0)), longest)
    x, _ = refits[brentq(beyond_end, inner, outer, xtol=AGREES * outer, maxiter=MAX_REFITS, disp=False)]
    near = AT_END * (problem.high - problem.low)
    for k, parameter in enumerate(problem.parameters):
        if k != j and min(x[k] - problem.low[k], problem.high[k] - x[k]) < near[k]:
            return End(x, False, f"{parameter.key} is at the end of its range")
    return End(x, True)


def _on_line(best, x, j, value):
    """Return the start of a refit: the point on the line from the minimum through x at which component j is a value."""
    moved = x[j] - best[j]
    start = best + (x - best) * (value - best[j]) / moved if moved else x.copy()
    start[j] = value
    return start
