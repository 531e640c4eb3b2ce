"""A row of a datasheet, as the table and the page show it."""

from typing import NamedTuple

from studies.record.prefixes import si


class Row(NamedTuple):
    """One line of the datasheet."""

    group: str  # key of `GROUPS`
    name: str
    value: float  # in SI units
    unit: str
    error: float | None = None  # relative; None for an input of the scene or a count
    condition: str = ""  # conditions in addition to the rated level
    model_error: float | None = None  # relative, due to neglected effects; None if unknown

    def texts(self) -> dict[str, str]:
        """Return name, value, error and condition as the table and the page show them."""
        value = si(self.value, self.unit, 4)
        if self.unit == "1":
            value = f"{100 * self.value:.3g} %" if self.value > 1e-3 else f"{self.value:.3g}"
        error = "" if self.error is None else "< 0.0001 %"
        if self.error and self.error > 5e-7:
            error = f"\u00b1 {float(f'{100 * self.error:.1g}'):g} %"  # without an exponent: 30 instead of 3e+01
        if self.model_error:
            error += f", model {float(f'{100 * self.model_error:.2g}'):g} %"
        return {"name": self.name, "value": value, "error": error, "condition": self.condition}
