"""Exceptions: an argument that breaks a rule, and an answer that has not converged.

The error of an answer is estimated in `contact/error_estimate.py`.
"""

# of the status "runaway"
RUNAWAY = (
    "friction cannot balance the load at any speed and no tangential damping bounds it; "
    "lower slider.load or give slider.damping.tangential"
)


class InputError(ValueError):
    """An argument that breaks a rule; as text ``key rule``, such as ``slider.mass must be positive, got -1 kg``.

    Attributes
    ----------
    key : str
        Name of the argument or of the field, such as ``slider.mass``.
    rule : str
        The rest of the sentence: what is allowed, the value and its unit.
    value : object
        The value received; None where the rule itself says it.
    """

    def __init__(self, key: str, rule: str, value: object = None, unit: str = ""):
        super().__init__(key, rule, value, unit)
        self.key, self.value = key, value
        shown = repr(value) if isinstance(value, str) else value
        self.rule = rule if value is None else f"{rule}, got {shown} {unit}".rstrip()

    def __str__(self):
        return f"{self.key} {self.rule}"


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
