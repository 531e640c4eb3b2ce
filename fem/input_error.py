"""The refusal of an argument that breaks a rule."""


class InputError(ValueError):
    """An argument that breaks a rule; as text ``key rule``, such as ``stator.length must be positive, got -1 m``.

    Attributes
    ----------
    key : str
        Name of the argument or of the field, such as ``stator.length``.
    rule : str
        The rest of the sentence: what is allowed, the value and its unit.
    value : object
        The value; None where the rule itself says it.
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
