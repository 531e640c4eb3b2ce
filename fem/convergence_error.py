"""The refusal of an answer that has not converged."""


class ConvergenceError(RuntimeError):
    """A solver has no answer that it can stand behind; the message says why and what to try next.

    Attributes
    ----------
    reached : object or None
        The best answer found, with its error, where one is known.
    """

    def __init__(self, message: str, *, reached: object = None):
        super().__init__(message)
        self.reached = reached


def refuse_above(
    error: float, tolerance: float, what: str, *, advice: str = "ask for less", reached: object = None
) -> None:
    """Raise a ConvergenceError if an error exceeds the tolerance; ``what``: "the admittances are", for instance."""
    if error > tolerance:
        raise ConvergenceError(
            f"{what} known to {error:.1e} only, {tolerance:.1e} was asked for: {advice}", reached=reached
        )
