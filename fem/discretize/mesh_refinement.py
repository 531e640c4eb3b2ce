"""Error estimate of the stator from two discretisations, and the loop that refines until it meets the tolerance.

Let a_h be the answer at one level of discretisation, a_H that at the level before, and g the least factor (the gain) by
which a level divides the error.  Then |a_h - a| <= |a_h - a_H| / (g - 1), which is the stated error of an answer at one
frequency in the plane section.  Beams (beam/surface_beam.py), bands of frequencies (solve/band_solution.py) and bursts
(solve/burst_envelope.py) have further errors, which are estimated there.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from fem.discretize.absorber import absorber_kind, backwardness
from fem.discretize.element_sizes import Resolution
from fem.exceptions import ActivePortError, ConvergenceError
from fem.geometry import Stator
from fem.parameters import InputError, positive

# From coarse to fine, measured on Feenstra and Breedveld's stator: both errors, admittance and motion, fall together.
LEVELS = (
    Resolution(order=5, edge_layers=0, absorber=0),
    Resolution(order=6, edge_layers=1, absorber=1),
    Resolution(order=7, edge_layers=2, absorber=2),
    Resolution(order=8, edge_layers=3, absorber=3),
    Resolution(order=9, edge_layers=4, absorber=4),
    Resolution(order=10, edge_layers=5, absorber=5),
)

# Error at each level on an ordinary motor, by which the first levels are selected.
EXPECTED = (np.inf, 5e-3, 2e-4, 2e-5, 2e-6, 3e-7)
GAIN = 8.0  # a level divides the error by more: 6.7 per edge layer, and more by the order (11 to 25 seen)
# The error of a viscous layer falls only as the inverse square of its depth.  That of a selective layer falls slowly
# too if its waves are backward beyond MAX_BACKWARDNESS (Z quartz: 1e-3 at a depth of 2 and of 3 wavelengths).
SLOW_GAIN, MAX_BACKWARDNESS = 1.5, 0.03


def absorbs_slowly(stator: Stator) -> bool:
    """True if the error of an absorbing bottom falls slowly with its depth."""
    if not stator.absorbs_below or absorber_kind(stator.solid) == "matched":
        return False
    return absorber_kind(stator.solid) == "viscous" or backwardness(stator.solid) > MAX_BACKWARDNESS


# Beside a line force a level divides the error by 3.8 to 5 (tests/fem/solve/test_near_force.py); a wavelength away the
# logarithmic field is gone.
GAIN_NEAR_FORCE, NEAR_FORCE = 3.0, 1.0


# Between reflecting ends a wave comes back to an absorbing bottom again and again, as far as the solid's own loss lets
# it.  What the layer leaves of waves that graze it adds up, and the two answers of an estimate share that error.  True
# error over |fine - coarse| / 7 in stators of 20 to 50 wavelengths (tests/fem/discretize/test_error_estimate.py):
# 1.5 to 31 with a selective layer on lossless lithium niobate and 17 with a quality of 1000, 16 with a matched layer on
# lossless quartz; 0.8 with a quality of 1000 there, 0.3 to 1.6 on eight ceramics (PZT-5H has 65).
RESONANT_GAIN, RESONANT_QUALITY = 1.4, 100.0


def resonates_over_absorber(stator: Stator) -> bool:
    """True if waves go to and fro between reflecting ends above an absorbing bottom, with little loss in the solid."""
    if not stator.absorbs_below or stator.ends == "absorbing":
        return False
    matched = absorber_kind(stator.solid) == "matched"
    return stator.solid.mechanical_quality > (np.finfo(float).max if matched else RESONANT_QUALITY)


def level_gain(stator: Stator) -> float:
    """Least factor by which one level more divides the error."""
    if resonates_over_absorber(stator):
        return RESONANT_GAIN
    return SLOW_GAIN if absorbs_slowly(stator) else GAIN


def first_level(tolerance: float) -> int:
    """Coarser one of the two levels that are solved first for a tolerance."""
    enough = [level for level, error in enumerate(EXPECTED) if error <= tolerance]
    return (enough[0] if enough else len(EXPECTED) - 1) - 1


def planned_levels(stator: Stator, tolerance: float) -> range:
    """Levels at which an ordinary layout on this stator is solved; another one follows if the error is too large."""
    first = first_level(tolerance)
    slower = (GAIN - 1) / (level_gain(stator) - 1)  # factor on the estimates, by the denominator g - 1
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
    """Solve at finer and finer levels until the estimated error meets the tolerance, or the levels end.

    Parameters
    ----------
    at_level : callable
        Returns the answer at a level, or raises a ConvergenceError; after an ActivePortError the next level is tried.
    levels : sequence
        Levels from coarse to fine.
    start : int
        Index of the coarser of the first two levels.  If the finer one has no answer, the search starts one level
        lower.  If negative, only the coarsest level is solved, and its errors are infinite.
    differences : callable
        Relative differences of a finer and a coarser answer; the first one is compared with the tolerance.
    gain : float
        Least factor, above 1, by which a level divides the error.
    tolerance : float
        Relative.

    Returns
    -------
    Refined
        If the differences grow towards the last level, it has the answer before, and ``obstacle`` says why.

    Raises
    ------
    ConvergenceError
        If no two neighbouring levels have an answer.

    Examples
    --------
    The trapezoidal rule for the integral of exp(x) from 0 to 1, whose error is divided by four:

    >>> import numpy as np
    >>> def integral(points):
    ...     x = np.linspace(0, 1, points)
    ...     return np.trapezoid(np.exp(x), x)
    >>> refined = refine(
    ...     integral, (3, 5, 9, 17, 33), differences=lambda a, b: (abs(a - b),), gain=4.0, tolerance=1e-3
    ... )
    >>> refined.level, bool(refined.errors[0] < 1e-3), bool(abs(refined.answer - np.e + 1) < 1.01 * refined.errors[0])
    (3, True, True)
    """
    positive("tolerance", tolerance, infinite=True)
    if start < 0:
        return Refined(answer=at_level(levels[0]), level=0, errors=(np.inf, np.inf), obstacle="")
    coarse: Answer | None = None
    best: Refined[Answer] | None = None

    def compared(fine: Answer, coarse: Answer, level: int) -> Refined[Answer]:
        errors = tuple(float(each) / (gain - 1) for each in differences(fine, coarse))
        return Refined(answer=fine, level=level, errors=errors, obstacle="")

    for level in range(start, len(levels)):
        try:
            answer = at_level(levels[level])
        except ConvergenceError as error:
            if isinstance(error, ActivePortError) and coarse is None:  # the level's error exceeds the conductance
                if level + 2 < len(levels):
                    continue
                raise
            if best is not None:
                return replace(best, obstacle=str(error))
            if start == 0:
                raise
            return refine(  # from a coarser pair, whose answer shows the error that is reached
                at_level, levels, start=start - 1, differences=differences, gain=gain, tolerance=tolerance
            )
        if coarse is not None:
            latest = compared(answer, coarse, level)
            if latest.errors[0] <= tolerance:
                return latest
            if best is None and level == len(levels) - 1 and start > 0:  # the only pair: do the differences grow?
                with suppress(ConvergenceError):
                    best = compared(coarse, at_level(levels[start - 1]), start)
            grows = best is not None and latest.errors[0] >= best.errors[0]
            best = _before_rounding(best, latest) if best and grows else latest
        coarse = answer
    if best is None:
        raise InputError("levels", "must hold at least two from the start on", len(levels) - start)
    return best


def _before_rounding(before: Refined[Answer], latest: Refined[Answer]) -> Refined[Answer]:
    """Answer before the latest one, whose difference has grown by rounding, with the larger errors of both."""
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
    least_gain: float = np.inf,
) -> Refined[Answer]:
    """Refine an answer of a stator over `LEVELS`, with the first level of the tolerance and the gain of the stator.

    ``least_gain``: of what is asked for besides, by which a level divides the error if that is less.
    """
    return refine(
        at_level,
        LEVELS,
        start=first_level(tolerance),
        differences=differences,
        gain=min(level_gain(stator), least_gain),
        tolerance=tolerance,
    )
