"""A case of the stability study and its outcome: one extreme value put to one part of the program.

Every case ends in one of four ways: "right" (two ways that share nothing beyond the model agree within their stated
errors), "flagged" (an answer whose status says that it is not within the tolerance), "refused" (no answer, the reason
given) or "WRONG" (an answer outside its stated error, a NaN, a traceback or no end).
"""

from dataclasses import dataclass

VERDICTS = ("right", "flagged", "refused", "WRONG")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One extreme.

    Attributes
    ----------
    part : str
        "free wave", "stator", "contact" or "chain".
    varied : str
        The quantity, or what it is a corner of.
    value : float
        Its value; of a corner, its number.
    unit : str
        SI, "" for a number.
    """

    part: str
    varied: str
    value: float
    unit: str


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a case.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    guard : str
        What spoke: the status or the sentence of the refusal; "" where the answer stands by itself.
    relative_error : float
        Difference of the two ways, relative as the estimate is; nan where there are not two.
    relative_estimate : float
        Stated error; nan where there is no answer.
    seconds : float
        Processor time taken.
    """

    verdict: str
    guard: str
    relative_error: float
    relative_estimate: float
    seconds: float
