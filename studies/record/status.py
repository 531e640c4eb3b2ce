"""The status of a point: in run.json, in the rows of a sweep, and in the counts of both."""

from enum import StrEnum


class Status(StrEnum):
    """Kind of a status; the text of a status is the kind alone, or the kind, a colon and a reason.

    Examples
    --------
    >>> Status.REFUSED.because("slider.mass must be positive")
    'refused: slider.mass must be positive'
    """

    OK = "ok"
    ABOVE_TOLERANCE = "above tolerance"
    REFUSED = "refused"  # the scene of the point breaks a rule
    NO_ANSWER = "no answer"
    LOST = "lost"  # with its worker; the next driver of the sweep tries it again

    def because(self, reason: str) -> str:
        """Return the text of a status with its reason."""
        return f"{self.value}: {reason}"

    @staticmethod
    def reason_in(status: str) -> str:
        """Return the reason in the text of a status; empty if there is none.

        Examples
        --------
        >>> Status.reason_in("no answer: runaway: it has no bound"), Status.reason_in("ok")
        ('runaway: it has no bound', '')
        """
        return status.partition(": ")[2]
