"""Exception for an answer that has not converged; the error itself is estimated in fem/discretize/error_estimate.py."""


class ConvergenceError(RuntimeError):
    """Raised if a solver does not reach the tolerance; the message says why and what to try next.

    Attributes
    ----------
    reached : object or None
        The best answer with its error, if there is one.
    """

    def __init__(self, message: str, *, reached: object = None):
        super().__init__(message)
        self.reached = reached


def refuse_above(
    error: float, tolerance: float, what: str, *, advice: str = "ask for less", reached: object = None
) -> None:
    """Raise a ConvergenceError if an error exceeds the tolerance; ``what`` begins it, as in "the modes are"."""
    if error > tolerance:
        raise ConvergenceError(
            f"{what} known to {error:.1e} only, {tolerance:.1e} was asked for: {advice}", reached=reached
        )
