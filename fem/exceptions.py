"""Exceptions: an argument that breaks a rule (`fem.parameters`), and an answer that has not converged.

The error of an answer is estimated in `fem/discretize/mesh_refinement.py`.
"""

from fem.parameters import InputError as InputError


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


class ActivePortError(ConvergenceError):
    """Raised if the computed admittances of passive transducers give out power: the discretisation is too coarse."""


def refuse_above(
    error: float, tolerance: float, what: str, *, advice: str = "ask for less", reached: object = None
) -> None:
    """Raise a ConvergenceError if an error exceeds the tolerance; ``what`` begins it, as in "the modes are"."""
    if error > tolerance:
        raise ConvergenceError(
            f"{what} known to {error:.1e} only, {tolerance:.1e} was asked for: {advice}", reached=reached
        )
