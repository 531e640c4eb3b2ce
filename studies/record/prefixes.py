"""Numbers with SI prefixes, in sentences and on axes."""

import math

from studies.scene.keys import rule_at, unit_of

PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def si(value: float, unit: str, digits: int = 5) -> str:
    """Return a number with an SI prefix.

    Examples
    --------
    >>> si(2.394e-10, "m/V"), si(0.0, "N"), si(-1.5, "m/s"), si(3e-25, "J")
    ('239.4 pm/V', '0 N', '-1.5 m/s', '3e-25 J')
    """
    if value == 0:
        return f"0 {unit}"
    power, letter = prefixed(abs(value))
    return f"{value / 10.0**power:.{digits}g} {letter}{unit}"


def prefixed(size: float) -> tuple[int, str]:
    """Return the power of ten and the SI prefix for a positive number; (0, "") if no prefix fits.

    Examples
    --------
    >>> prefixed(2.4e-10), prefixed(3e-25)
    ((-12, 'p'), (0, ''))
    """
    power = 3 * math.floor(math.log10(size) / 3 + 1e-12)
    return (power, PREFIXES[power]) if power in PREFIXES else (0, "")


def key_axis(key: str, largest: float) -> tuple[float, str]:
    """Return the factor and the label of an axis of a scene's number, with a prefix that suits its largest value (SI).

    Examples
    --------
    >>> key_axis("slider.preload", 3e-3), key_axis("slider.friction_coefficient", 0.2)
    ((1000.0, 'preload (mN)'), (1.0, 'friction coefficient'))
    """
    factor, unit = scaled_unit(largest, unit_of(rule_at(key)))
    name = key.rpartition(".")[2].replace("_", " ")
    return factor, f"{name} ({unit})" if unit else name


def scaled_unit(size: float, unit: str | None) -> tuple[float, str]:
    """Return the factor from SI units and the unit with a prefix that suits a size; compound units get no prefix.

    Examples
    --------
    >>> scaled_unit(2e-3, "N"), scaled_unit(9e-5, "kg"), scaled_unit(1e-4, "N s/m")
    ((1000.0, 'mN'), (1000000.0, 'mg'), (1.0, 'N s/m'))
    """
    factor = 1e3 if unit == "kg" else 1.0
    unit = "g" if unit == "kg" else unit or ""
    if not unit or not size or set(" /") & set(unit):
        return factor, unit
    power, letter = prefixed(abs(size) * factor)
    return factor * 10.0**-power, letter + unit
