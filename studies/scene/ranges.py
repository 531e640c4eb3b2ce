"""Parse a range ``START:STOP:N`` or ``START:STOP:N:log``: values of a sweep, or the frequencies of a band.

`studies.chain.passband.band_frequencies` adds what a band has of its own: MHz without a unit, and its limits.
"""

import math
from dataclasses import dataclass

from studies.refusal import SceneError, shown
from studies.scene.quantity import si_value

MAX_COUNT = 10_000_000


@dataclass(frozen=True)
class Range:
    """Evenly or logarithmically spaced numbers between two ends, in SI units."""

    low: float
    high: float
    count: int
    logarithmic: bool

    def at(self, part: float, of: float = 1.0) -> float:
        """Return the number at the fraction ``part / of`` of the range; the two ends are exact."""
        if part in (0, of):
            return self.high if part else self.low
        if self.logarithmic:
            return self.low * (self.high / self.low) ** (part / of)
        return self.low + (self.high - self.low) * part / of

    @property
    def values(self) -> list[float]:
        """All numbers, evenly spaced."""
        return [self.at(k, max(self.count - 1, 1)) for k in range(self.count)]


def read_range(path: str, text: str, unit: str, *, bare: float = 1.0) -> Range:
    """Parse a range; ``bare`` is the factor to SI units of numbers without a unit.

    Examples
    --------
    >>> read_range("drive.voltage", "5:60:12", "V").values[:3]
    [5.0, 10.0, 15.0]
    """
    parts = [part.strip() for part in text.split(":")]
    logarithmic = len(parts) == 4 and parts[3] == "log"
    if len(parts) != 3 and not logarithmic:
        wanted = "must be START:STOP:N, with :log after it for even steps of the logarithm"
        raise SceneError(path, f"{wanted}, or a list, got {shown(text)}")
    plain = [is_number(part) for part in parts[:2]]
    ends = [
        bare * float(part) if number else si_value(path, part, unit) for number, part in zip(plain, parts, strict=False)
    ]
    if plain[0] != plain[1] and ends[plain.index(True)] != 0:
        raise SceneError(path, f"must have a unit at both ends or at neither, got {shown(text)}")
    if logarithmic and not min(ends) > 0:
        raise SceneError(path, f"must lie above 0 for even steps of the logarithm, got {shown(text)}")
    number = parts[2]
    if not (number.isascii() and number.isdigit() and 1 <= int(number[:9]) <= MAX_COUNT):
        raise SceneError(path, f"must ask for 1 to {MAX_COUNT} values, got {shown(number)}")
    if int(number) == 1 and ends[0] != ends[1]:
        raise SceneError(path, f"must ask for at least 2 values between different ends, got {shown(text)}")
    return Range(ends[0], ends[1], int(number), logarithmic)


def is_number(text) -> bool:
    """Return whether a text is a finite number without a unit."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
