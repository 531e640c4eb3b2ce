r"""Choice of the method for a problem of the contact, by its applicability and its estimated error.

The errors are estimated in `error_estimate`. The methods of a burst are the table BURST_METHODS of
`answers/burst_methods.py`, with the rule of "auto" in `run` below it; those of a steady state are the table
STEADY_METHODS of `answers/steady.py`, with their rule above it. `answers.load_and_stall.stall` takes the averaged load
where its error is within the tolerance, and `answers.thresholds` the averaged factor of a slider whose full motion it
does not search (a law or heights other than the simplest). `answers.steps` follows the drive of a step by events if it
is short, otherwise with fixed steps, and `answers.waveforms` takes shooting or a long run. The other answers have one
method each.

`choose` returns the result of the first method, the cheapest, that applies and whose estimated error is within the
tolerance. If a method that the user named misses the tolerance, the exact method replaces it, provided that it is cheap
enough. For steady states `first_to_converge` returns the result of the first method that applies and converges; whether
a method applies may depend on why the one before it failed. Every answer is a number with an error, a status and
reasons. The status is "ok" or "above tolerance" (the stated error is larger than the tolerance).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from contact.error_estimate import relative_to_reference
from contact.exceptions import ConvergenceError
from contact.orbit import Orbits
from contact.passing_wave import PassingWave

OK, ABOVE_TOLERANCE = "ok", "above tolerance"
EXCEEDS = "estimated error"  # begins the reason of an answer that misses its tolerance


@dataclass(frozen=True, kw_only=True)
class Answer:
    """A number with its numerical error.

    Attributes
    ----------
    value : float
        In SI units; inf for a threshold that no amplitude reaches.
    error : float
        Estimated error in the unit of `value`. The exact solution of the model is within twice this error in 98 of 100
        cases.
    status : str
        "ok" or "above tolerance".
    reasons : tuple of str
        How the number was computed, and why its error is not smaller.

    Examples
    --------
    >>> print(Answer(value=0.25, error=1e-3, status="ok", reasons=("cycle means",)))
    0.25 +- 0.001 (ok: cycle means)
    """

    value: float
    error: float
    status: str = OK
    reasons: tuple[str, ...] = ()

    def __post_init__(self):
        if math.isnan(self.value) or math.isnan(self.error) or self.error < 0.0:
            raise ValueError(f"an answer must be a number with an error, got {self.value} +- {self.error}")

    def __str__(self):
        reasons = f": {'; '.join(self.reasons)}" if self.reasons else ""
        return f"{self.value:.6g} +- {self.error:.2g} ({self.status}{reasons})"

    @property
    def why(self) -> str:
        """The reasons as one sentence, without that of the size of the error against the tolerance."""
        return "; ".join(reason for reason in self.reasons if not reason.startswith(EXCEEDS))

    @property
    def message(self) -> str:
        """The reasons as one sentence."""
        return "; ".join(self.reasons)

    def judged(self, tolerance: float, reference: float, advice: str = "") -> "Answer":
        """Return the answer with its status for a tolerance of error over ``reference`` (in the unit of `value`)."""
        relative = self.error / reference if reference > 0.0 else (math.inf if self.error > 0.0 else 0.0)
        if not relative > tolerance:
            return self
        reason = f"{EXCEEDS} {relative:.2g} exceeds {tolerance:.2g}"
        reasons = (*self.reasons, reason, *((advice,) if advice else ()))
        status = ABOVE_TOLERANCE if self.status == OK else self.status
        return Answer(value=self.value, error=self.error, status=status, reasons=reasons)


class HasAnswer:
    """Base of results with an `Answer`: its status and message."""

    answer: Answer

    @property
    def status(self) -> str:
        """Status of the answer."""
        return self.answer.status

    @property
    def message(self) -> str:
        """Reasons of the answer as one sentence: how it was computed, and why its error is not smaller."""
        return self.answer.message


class Answered(HasAnswer):
    """Base of results whose velocity is an `Answer`: relative error, status and message."""

    orbits: Orbits | PassingWave

    @property
    def relative_error(self) -> float:
        """Estimated error of the velocity over max(|v|, omega |u_x|/10)."""
        return relative_to_reference(self.answer.error, self.answer.value, self.orbits)


class Result(NamedTuple):
    """Result of a method in scaled units: its run, the estimated and the allowed error, and its statistics."""

    run: tuple
    error: float
    allowed: float
    statistics: dict


class Method(NamedTuple):
    """A method: `follow(question)` returns the result, `refusals(question)` the reasons why it does not apply."""

    follow: Callable
    refusals: Callable


class Choice(NamedTuple):
    """The selected result, the name of its method, and why this is not the requested one."""

    result: Result
    method: str
    reasons: tuple[str, ...]


def choose(
    methods: dict[str, Method], question, requested: str, *, what: str, exact: bool, way: str, exact_first: bool = False
) -> Choice:
    """Return the first result within its tolerance, or else the one with the smallest error.

    Parameters
    ----------
    methods : dict
        `Method` by name, the cheapest first and "exact" last.
    question
        Problem that is passed to every method.
    requested : str
        "auto", or the only method to try; if this misses the tolerance, the exact method replaces it.
    what : str
        Name of the problem in error messages.
    exact : bool
        True if the exact method is cheap enough to be used although the user did not name it.
    way : str
        Advice in the error message if no method applies.
    exact_first : bool
        True if "auto" tries the exact method first and takes its result whatever the error.

    Raises
    ------
    ConvergenceError
        Status "not applicable" with the reasons of all requested methods, or the error of the exact method,
        or of the first if the exact one was not tried.
    """

    def refusals(*names):
        return {name: methods[name].refusals(question) for name in names}

    if requested == "auto":
        why = refusals(*methods)
        names = [name for name in methods if not why[name]]
        if not exact and len(names) > 1:
            names = [name for name in names if name != "exact"]
    else:
        why = refusals(requested)
        if why[requested]:
            others = [name for name, each in refusals(*methods).items() if name != requested and not each]
            raise refused(what, why, f"use method {' or '.join(others)}" if others else way)
        replaced = exact and requested != "exact" and not methods["exact"].refusals(question)
        names = [requested] + ["exact"] * replaced
    if requested == "auto" and exact_first:
        names.sort(key=lambda name: name != "exact")
    if not names:
        raise refused(what, why, way)
    best: Choice | None = None
    failures: list[ConvergenceError] = []  # that of the exact method first
    reasons: tuple[str, ...] = ()
    for name in names:
        try:
            result = methods[name].follow(question)
        except ConvergenceError as failed:
            if name == requested:
                raise
            failures.insert(0 if name == "exact" else len(failures), failed)
            if name == "exact":
                reasons = (f"the exact method failed: {failed}",)
            continue
        if best is None or result.error <= best.result.error:
            best = Choice(result, name, reasons)
        if result.error <= result.allowed or name == "exact":
            break
        if name == requested:
            reasons = (f"followed exactly, because the {name} method misses the tolerance",)
    if best is None:
        raise failures[0]
    return best


def first_to_converge(methods: dict[str, Method], question):
    """Return the result of the first method that applies and converges.

    Parameters
    ----------
    methods : dict
        In the order in which they are tried.
    question : NamedTuple
        What every method takes; its field `failure` is None, then the error that stopped the method before.

    Raises
    ------
    ConvergenceError
        The error that stopped the last method.
    """
    for method in methods.values():
        if method.refusals(question):
            continue
        try:
            return method.follow(question)
        except ConvergenceError as failed:
            question = question._replace(failure=failed)
    raise question.failure


def refused(what: str, reasons: dict[str, tuple[str, ...]], way: str) -> ConvergenceError:
    """Return the error for a problem to which no method applies, with all reasons and an advice."""
    each = "; ".join(f"method {name}: {', '.join(why)}" for name, why in reasons.items() if why)
    return ConvergenceError("not applicable", f"{what} cannot be followed by {each}; {way}")
