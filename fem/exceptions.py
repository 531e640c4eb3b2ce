"""Exceptions: an argument that breaks a rule, and an answer that has not converged.

The error of an answer is estimated in `fem/discretize/error_estimate.py`.
"""


class InputError(ValueError):
    """An argument that breaks a rule; as text ``key rule``, such as ``stator.length must be positive, got -1 m``.

    Attributes
    ----------
    key : str
        Name of the argument or of the field, such as ``stator.length``.
    rule : str
        The rest of the sentence: what is allowed, the value and its unit.
    value : object
        The value; None if the rule contains it.
    owner : str
        Which of several transducers the key belongs to, by its name; empty where there is one object alone.

    Examples
    --------
    >>> error = InputError("transducer.period", "must be positive", -1, "m", owner="left")
    >>> print(error, error.key, error.value, sep=" | ")
    transducer 'left'.period must be positive, got -1 m | transducer.period | -1
    """

    def __init__(self, key: str, rule: str, value: object = None, unit: str = "", owner: str = ""):
        super().__init__(key, rule, value, unit, owner)
        self.key, self.value, self.owner = key, value, owner
        shown = repr(value) if isinstance(value, str) else value
        self.rule = rule if value is None else f"{rule}, got {shown} {unit}".rstrip()

    def __str__(self):
        kind, dot, name = self.key.partition(".")
        key = f"{kind} {self.owner!r}{dot}{name}" if self.owner else self.key
        return f"{key} {self.rule}"


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


def refuse_unless_positive(key: str, value: float, unit: str = "", owner: str = "") -> None:
    """Raise an InputError for a value that is not positive and finite."""
    if not 0 < value < float("inf"):
        raise InputError(key, "must be positive and finite", value, unit, owner=owner)


def refuse_above(
    error: float, tolerance: float, what: str, *, advice: str = "ask for less", reached: object = None
) -> None:
    """Raise a ConvergenceError if an error exceeds the tolerance; ``what`` begins it, as in "the modes are"."""
    if error > tolerance:
        raise ConvergenceError(
            f"{what} known to {error:.1e} only, {tolerance:.1e} was asked for: {advice}", reached=reached
        )
