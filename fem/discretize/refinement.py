"""Levels of discretisation, and the one loop that refines until two of them agree.

With the answers a_h of a level and a_H of the level before, and a gain g by which a level divides the error at least,
|a_h - a| <= |a_h - a_H| / (g - 1): that is the error stated with every answer.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from fem.convergence import ConvergenceError
from fem.discretize.grading import Resolution
from fem.geometry import Stator
from fem.materials.christoffel import stretch_absorbs

# From coarse to fine: measured on the seed's stator (admittance and surface motion move together).
LEVELS = (
    Resolution(order=5, edge_layers=0, lossy_elements=5),
    Resolution(order=6, edge_layers=1, lossy_elements=6),
    Resolution(order=7, edge_layers=2, lossy_elements=8),
    Resolution(order=8, edge_layers=3, lossy_elements=10),
    Resolution(order=9, edge_layers=4, lossy_elements=12),
    Resolution(order=10, edge_layers=5, lossy_elements=14),
)

# Estimate at each level on an ordinary motor: where to begin.
EXPECTED = (np.inf, 5e-3, 2e-4, 2e-5, 2e-6, 3e-7)
GAIN = 8.0  # a level divides the error by more: 6.7 per edge layer, and more by the order (11 to 25 seen)
LOSSY_GAIN = 1.5  # where a lossy layer stands for the half-space its thickness decides, squared


def level_gain(stator: Stator) -> float:
    """By how much a level divides the error, at least."""
    if stator.absorbs_below and not stretch_absorbs(stator.solid):
        return LOSSY_GAIN
    return GAIN


def first_level(tolerance: float) -> int:
    """Coarser of the two levels to begin with."""
    enough = [level for level, error in enumerate(EXPECTED) if error <= tolerance]
    return (enough[0] if enough else len(EXPECTED) - 1) - 1


def planned_levels(stator: Stator, tolerance: float) -> range:
    """Levels that an ordinary layout on this stator is solved at; where the estimate demands it one more follows."""
    first = first_level(tolerance)
    slower = (GAIN - 1) / (level_gain(stator) - 1)
    enough = [level for level, error in enumerate(EXPECTED) if error * slower <= tolerance]
    return range(first, max(first + 1, enough[0] if enough else len(LEVELS) - 1) + 1)


Answer = TypeVar("Answer")
Level = TypeVar("Level")


@dataclass(frozen=True, kw_only=True)
class Refined(Generic[Answer]):
    """Finest answer that was reached, with its errors."""

    answer: Answer  # of ``at_level``
    level: int  # of the answer
    # one for each of the differences; the first is the one that the tolerance bounds
    errors: tuple[float, ...]
    obstacle: str  # why no finer level was solved; empty if the tolerance is met or the levels ended


def refine(
    at_level: Callable[[Level], Answer],
    levels: Sequence[Level],
    *,
    start: int = 0,
    differences: Callable[[Answer, Answer], tuple[float, ...]],
    gain: float,
    tolerance: float,
) -> Refined[Answer]:
    """Solve at finer and finer levels until the estimated error meets the tolerance, or as far as they go.

    ``differences``: finer answer, coarser answer -> relative differences, the first of which is bounded; ``start``: the
    coarser of the two levels to begin with, one lower if the finer one has no answer, below 0 for the coarsest level
    alone, its errors unknown; ``gain``: least factor, above 1, by which a level divides the error.  A ConvergenceError
    if no two neighbouring levels have an answer.

    Examples
    --------
    The trapezoidal rule for the integral of exp(x) from 0 to 1, whose error is divided by four:

    >>> import numpy as np
    >>> def integral(points):
    ...     x = np.linspace(0, 1, points)
    ...     return np.trapezoid(np.exp(x), x)
    >>> found = refine(
    ...     integral, (3, 5, 9, 17, 33), differences=lambda a, b: (abs(a - b),), gain=4.0, tolerance=1e-3
    ... )
    >>> found.level, bool(found.errors[0] < 1e-3), bool(abs(found.answer - np.e + 1) < 1.01 * found.errors[0])
    (3, True, True)
    """
    if start < 0:
        return Refined(answer=at_level(levels[0]), level=0, errors=(np.inf, np.inf), obstacle="")
    coarse = reached = None
    for level in range(start, len(levels)):
        try:
            answer = at_level(levels[level])
        except ConvergenceError as error:
            if reached is not None:
                return Refined(
                    answer=reached.answer, level=reached.level, errors=reached.errors, obstacle=str(error)
                )
            if start == 0:
                raise
            return refine(  # a coarser pair says how far it got
                at_level, levels, start=start - 1, differences=differences, gain=gain, tolerance=tolerance
            )
        if coarse is not None:
            errors = tuple(float(each) / (gain - 1) for each in differences(answer, coarse))
            reached = Refined(answer=answer, level=level, errors=errors, obstacle="")
            if errors[0] <= tolerance:
                break
        coarse = answer
    return reached


def refine_stator(
    stator: Stator,
    at_level: Callable[[Resolution], Answer],
    *,
    differences: Callable[[Answer, Answer], tuple[float, ...]],
    tolerance: float,
) -> Refined[Answer]:
    """Refine an answer of a stator over `LEVELS`, from the level and at the rate that its solid and ends promise."""
    return refine(
        at_level,
        LEVELS,
        start=first_level(tolerance),
        differences=differences,
        gain=level_gain(stator),
        tolerance=tolerance,
    )
