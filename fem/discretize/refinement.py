"""Levels of discretisation, and the one loop that refines until two of them agree.

With the answers a_h of a level and a_H of the level before, and a gain g by which a level divides the error at least,
|a_h - a| <= |a_h - a_H| / (g - 1): that is the error stated with every answer.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from fem.convergence_error import ConvergenceError
from fem.discretize.absorber import absorber_kind, backwardness
from fem.discretize.grading import Resolution
from fem.geometry import Stator

# From coarse to fine: measured on Feenstra and Breedveld's stator (admittance and surface motion move together).
LEVELS = (
    Resolution(order=5, edge_layers=0, absorber=0),
    Resolution(order=6, edge_layers=1, absorber=1),
    Resolution(order=7, edge_layers=2, absorber=2),
    Resolution(order=8, edge_layers=3, absorber=3),
    Resolution(order=9, edge_layers=4, absorber=4),
    Resolution(order=10, edge_layers=5, absorber=5),
)

# Estimate at each level on an ordinary motor: where to begin.
EXPECTED = (np.inf, 5e-3, 2e-4, 2e-5, 2e-6, 3e-7)
GAIN = 8.0  # a level divides the error by more: 6.7 per edge layer, and more by the order (11 to 25 seen)
# Where a viscous layer stands for the half-space its depth decides, squared; so does that of a selective layer
# whose waves are backward beyond MAX_BACKWARDNESS (Z quartz: 1e-3 at a depth of 2 and of 3 wavelengths).
SLOW_GAIN, MAX_BACKWARDNESS = 1.5, 0.03


def absorbs_slowly(stator: Stator) -> bool:
    """True if the error of an absorbing bottom falls slowly with its depth."""
    if not stator.absorbs_below or absorber_kind(stator.solid) == "matched":
        return False
    return absorber_kind(stator.solid) == "viscous" or backwardness(stator.solid) > MAX_BACKWARDNESS


def level_gain(stator: Stator) -> float:
    """By how much a level divides the error, at least."""
    return SLOW_GAIN if absorbs_slowly(stator) else GAIN


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
    # why a finer level was not solved or not taken; empty if the tolerance is met or the levels ended
    obstacle: str


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
    alone, its errors unknown; ``gain``: least factor, above 1, by which a level divides the error.  Where the
    differences grow towards the last level the answer before is kept, and ``obstacle`` says so.  A ConvergenceError if
    no two neighbouring levels have an answer.

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
    coarse = best = None

    def compared(fine: Answer, coarse: Answer, level: int) -> Refined[Answer]:
        errors = tuple(float(each) / (gain - 1) for each in differences(fine, coarse))
        return Refined(answer=fine, level=level, errors=errors, obstacle="")

    for level in range(start, len(levels)):
        try:
            answer = at_level(levels[level])
        except ConvergenceError as error:
            if best is not None:
                return replace(best, obstacle=str(error))
            if start == 0:
                raise
            return refine(  # a coarser pair says how far it got
                at_level, levels, start=start - 1, differences=differences, gain=gain, tolerance=tolerance
            )
        if coarse is not None:
            latest = compared(answer, coarse, level)
            if latest.errors[0] <= tolerance:
                return latest
            if (
                best is None and level == len(levels) - 1 and start > 0
            ):  # the only pair: do the differences grow?
                with suppress(ConvergenceError):
                    best = compared(coarse, at_level(levels[start - 1]), start)
            grows = best is not None and latest.errors[0] >= best.errors[0]
            best = _kept(best, latest) if grows else latest
        coarse = answer
    return best


def _kept(before: Refined[Answer], latest: Refined[Answer]) -> Refined[Answer]:
    """Answer of a level from which the next one differs more than from the one before, with the larger errors."""
    return replace(
        before,
        errors=tuple(map(max, before.errors, latest.errors)),
        obstacle=f"level {latest.level} differs more from level {before.level} (error {latest.errors[0]:.1e}) than "
        f"that from the one before ({before.errors[0]:.1e}): rounding decides there",
    )


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
