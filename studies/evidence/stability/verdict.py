"""The verdict on a case of the stability study, from the comparison with a reference or from an exception.

An answer is WRONG if its error exceeds twice its estimate and also a hundredth of the tolerance. Smaller errors are
accepted, because estimates are not required to be accurate there. A warning of the arithmetic (overflow, invalid value)
makes the case WRONG for any answer.
"""

import math
import time
import warnings
from collections.abc import Callable

import contact
import fem
from studies.evidence.stability.case import Outcome
from studies.refusal import RunError, SceneError

PROMISED = 2.0  # largest permitted ratio of true error to estimate
UNASKED = 1e-2  # error over tolerance below which the estimate is not judged


class NoWitness(RuntimeError):
    """There is an answer, but no reference to compare it with."""


def judged(posed: Callable[[], tuple[float, float, bool | str]], tolerance: float) -> Outcome:
    """Return the outcome of a case.

    Parameters
    ----------
    posed : callable
        Function that computes answer and reference and returns the error, its estimate, and True or the status of an
        answer that does not meet the tolerance.
    tolerance : float
        Requested relative tolerance.
    """
    start_time = time.process_time()

    def outcome(verdict: str, guard: str = "", error: float = math.nan, estimate: float = math.nan) -> Outcome:
        return Outcome(
            verdict=verdict,
            guard=" ".join(guard.split()),
            relative_error=error,
            relative_estimate=estimate,
            seconds=time.process_time() - start_time,
        )

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            error, estimate, kept = posed()
    except NoWitness as lacking:
        return outcome("flagged", f"answered, but no witness: {lacking}")
    except (
        SceneError,
        RunError,
        fem.ConvergenceError,
        contact.ConvergenceError,
        fem.InputError,
        contact.InputError,
    ) as refusal:
        return outcome("refused", str(refusal))
    except Exception as defect:
        return outcome("WRONG", f"{type(defect).__name__}: {defect}")
    sound = math.isfinite(error) and math.isfinite(estimate)
    if not sound or error > max(PROMISED * estimate, UNASKED * tolerance):
        return outcome("WRONG", "" if kept is True else str(kept), error, estimate)
    if kept is not True or estimate > tolerance:
        said = f"it states an error of {estimate:.1e}" if kept is True else str(kept)
        return outcome("flagged", said, error, estimate)
    return outcome("right", "", error, estimate)
