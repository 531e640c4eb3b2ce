"""The one error of this package for an answer that could not be reached."""


class ConvergenceError(RuntimeError):
    """No trustworthy answer was reached; the message says why and what to try next.

    Attributes
    ----------
    status : str
        What kept the answer away, in a few words, such as "runaway", "unstable", "stiff", "not finite", "too many
        events", "not converged"; the functions that raise it name others.
    """

    def __init__(self, status: str, message: str):
        super().__init__(f"{status}: {message}")
        self.status = status
