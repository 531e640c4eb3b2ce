"""A case of the stability study, and the verdict on it from the comparison with a reference or from an exception.

A case sets a quantity of one part of the program to an extreme value. There are four verdicts:

- "right": two solutions that share only the model agree within their stated errors;
- "flagged": there is an answer, and its status says that it does not meet the tolerance;
- "refused": there is no answer, and a message states the reason;
- "WRONG": the answer is outside its stated error, NaN, or an unexpected exception.

An answer is WRONG if its error exceeds twice its estimate and also a hundredth of the tolerance. Smaller errors are
accepted, because estimates are not required to be accurate there. A warning of the arithmetic (overflow, invalid value)
makes the case WRONG for any answer.
"""

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import contact
import fem
from studies.refusal import RunError, SceneError

VERDICTS = ("right", "flagged", "refused", "WRONG")
PROMISED = 2.0  # largest permitted ratio of true error to estimate
NEGLIGIBLE = 1e-2  # error over tolerance below which the estimate is not judged
REFUSALS = (SceneError, RunError, fem.ConvergenceError, contact.ConvergenceError, fem.InputError, contact.InputError)
# error, its estimate, and True or the status of an answer that does not meet the tolerance
Comparison = tuple[float, float, bool | str]


class NoReference(RuntimeError):
    """There is an answer, but no reference to compare it with."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One extreme value of one quantity."""

    part: str  # "free wave", "stator", "contact" or "chain"
    varied: str  # name of the quantity, or "corner" for a random combination of extreme values
    value: float  # of the quantity, or number of the corner
    unit: str  # SI unit; "" for a dimensionless quantity


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The outcome of a case."""

    verdict: str  # one of `VERDICTS`
    guard: str  # status of the answer or message of the refusal; "" for an answer without a remark
    relative_error: float  # difference of answer and reference, normalised as the estimate; nan without a reference
    relative_estimate: float  # stated relative error; nan without an answer
    seconds: float  # processor time


def cases_of(part: str, varied: dict[str, tuple]) -> list[Case]:
    """Return the cases of quantities by name, each a tuple that begins with its unit and its values."""
    return [
        Case(part=part, varied=name, value=float(value), unit=unit)
        for name, (unit, values, *_) in varied.items()
        for value in values
    ]


def judge(part: ModuleType, case: Case) -> Outcome:
    """Return the outcome of a case of a part: a module with ``TOLERANCE``, ``VARIED`` and ``compared``."""
    tolerance = case.value if case.varied.startswith("tolerance") else part.TOLERANCE
    return judged(lambda: part.compared(case, tolerance), tolerance)


def judged(compared: Callable[[], Comparison], tolerance: float) -> Outcome:
    """Return the outcome of a function that computes answer and reference for a relative tolerance."""
    start_time = time.process_time()

    def outcome(verdict: str, guard: str = "", error: float = math.nan, estimate: float = math.nan) -> Outcome:
        return Outcome(
            verdict=verdict, guard=" ".join(guard.split()), relative_error=error, relative_estimate=estimate,
            seconds=time.process_time() - start_time,
        )  # fmt: skip

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            error, estimate, status = compared()
    except NoReference as reason:
        return outcome("flagged", f"answered, but without a reference: {reason}")
    except REFUSALS as refusal:
        return outcome("refused", str(refusal))
    except Exception as defect:
        return outcome("WRONG", f"{type(defect).__name__}: {defect}")
    sound = math.isfinite(error) and math.isfinite(estimate)
    if not sound or error > max(PROMISED * estimate, NEGLIGIBLE * tolerance):
        return outcome("WRONG", "" if status is True else str(status), error, estimate)
    if status is not True or estimate > tolerance:
        guard = f"it states an error of {estimate:.1e}" if status is True else str(status)
        return outcome("flagged", guard, error, estimate)
    return outcome("right", "", error, estimate)
