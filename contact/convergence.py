"""The one error of this package for an answer that could not be reached."""


class ConvergenceError(RuntimeError):
    """No trustworthy answer was reached; the message says why and what to try next.

    Attributes
    ----------
    status : str
        One word: "runaway", "unstable", "stiff", "not finite", "too many events", "not converged".
    """

    def __init__(self, status: str, message: str):
        super().__init__(f"{status}: {message}")
        self.status = status
