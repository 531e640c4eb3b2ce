"""A case of the stability study, which sets a quantity of one part of the program to an extreme value.

There are four verdicts:

- "right": two solutions that share only the model agree within their stated errors;
- "flagged": there is an answer, and its status says that it does not meet the tolerance;
- "refused": there is no answer, and a message states the reason;
- "WRONG": the answer is outside its stated error, NaN, or an unexpected exception.
"""

from dataclasses import dataclass

VERDICTS = ("right", "flagged", "refused", "WRONG")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One extreme value of one quantity.

    Attributes
    ----------
    part : str
        "free wave", "stator", "contact" or "chain".
    varied : str
        Name of the quantity, or "corner" for a random combination of extreme values.
    value : float
        Value of the quantity, or number of the corner.
    unit : str
        SI unit; "" for a dimensionless quantity.
    """

    part: str
    varied: str
    value: float
    unit: str


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The outcome of a case.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    guard : str
        Status of the answer or message of the refusal; "" for an answer without a remark.
    relative_error : float
        Difference between answer and reference, normalised as the estimate; nan without a reference.
    relative_estimate : float
        Stated relative error; nan without an answer.
    seconds : float
        Processor time.
    """

    verdict: str
    guard: str
    relative_error: float
    relative_estimate: float
    seconds: float


def cases_of(part: str, varied: dict[str, tuple]) -> list[Case]:
    """Return the cases of quantities by name, each a tuple that begins with its unit and its values."""
    return [
        Case(part=part, varied=name, value=float(value), unit=unit)
        for name, (unit, values, *_) in varied.items()
        for value in values
    ]
