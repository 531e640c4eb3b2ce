"""The refusal of an answer that has not converged."""


class ConvergenceError(RuntimeError):
    """A solver has no answer that it can stand behind; the message says why and what to try next."""
