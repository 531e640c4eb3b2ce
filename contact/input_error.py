"""The refusal of an argument that breaks a rule."""


class InputError(ValueError):
    """An argument that breaks a rule; as text ``key rule``, such as ``slider.mass must be positive, got -1 kg``.

    Attributes
    ----------
    key : str
        Name of the argument or of the field, such as ``slider.mass``.
    rule : str
        The rest of the sentence: what is allowed, what was given and its unit.
    value : object
        What was given; None where the rule itself says it.
    """

    def __init__(self, key: str, rule: str, value: object = None, unit: str = ""):
        super().__init__(key, rule, value, unit)
        self.key, self.value = key, value
        shown = repr(value) if isinstance(value, str) else value
        self.rule = rule if value is None else f"{rule}, got {shown} {unit}".rstrip()

    def __str__(self):
        return f"{self.key} {self.rule}"
