"""The range ``START:STOP:N`` or ``START:STOP:N:log``: levels of a scene, values of a sweep, frequencies of a band.

`studies.solve.passband.band_frequencies` adds what a band has of its own: MHz without a unit, and its limits.
"""

import math

from studies.refusal import SceneError, shown
from studies.scene.quantity import si_value

MAX_COUNT = 10_000_000


def read_range(path: str, text: str, unit: str, *, bare: float = 1.0) -> list[float]:
    """Return the numbers of a range in SI units, evenly spaced, with exact ends.

    ``bare``: factor to SI units of numbers without a unit.

    Examples
    --------
    >>> read_range("drive.voltage", "5:60:12", "V")[:3]
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
    number, (low, high) = parts[2], ends
    if not (number.isascii() and number.isdigit() and 1 <= int(number[:9]) <= MAX_COUNT):
        raise SceneError(path, f"must ask for 1 to {MAX_COUNT} values, got {shown(number)}")
    steps = int(number) - 1
    if steps == 0 and low != high:
        raise SceneError(path, f"must ask for at least 2 values between different ends, got {shown(text)}")
    if logarithmic:
        between = [low * (high / low) ** (k / steps) for k in range(1, steps)]
    else:
        between = [low + (high - low) * k / steps for k in range(1, steps)]
    return [low, *between, high] if steps else [low]


def is_number(text) -> bool:
    """Return whether a text is a finite number without a unit."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
