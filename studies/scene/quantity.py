"""A number in SI units, or a string with a unit, read as one SI number.

The units of everyday scenes are in a table of powers of ten, read with decimal arithmetic: ``"0.089 g"`` is
exactly the float 8.9e-05, without an import.  Any other unit is converted by pint, which is imported for it
(0.3 s); the table is tested against pint.
"""

import math
import re
from decimal import Decimal, InvalidOperation
from functools import cache

from studies.refusal import SceneError, resembling, shown

# By SI unit: what it measures, an example, and the usual units of its dimension as powers of ten
UNITS: dict[str, tuple[str, str, dict[str, int]]] = {
    "m": ("a length", "5 mm", {"m": 0, "cm": -2, "mm": -3, "um": -6, "µm": -6, "nm": -9, "pm": -12}),
    "s": ("a time", "20 ms", {"s": 0, "ms": -3, "us": -6, "µs": -6, "ns": -9}),
    "Hz": ("a frequency", "2.2 MHz", {"Hz": 0, "kHz": 3, "MHz": 6, "GHz": 9}),
    "kg": ("a mass", "0.1 g", {"kg": 0, "g": -3, "mg": -6, "ug": -9}),
    "N": ("a force", "5 mN", {"kN": 3, "N": 0, "mN": -3, "uN": -6, "nN": -9}),
    "V": ("a voltage", "10 V", {"kV": 3, "V": 0, "mV": -3}),
    "ohm": ("an impedance", "50 ohm", {"ohm": 0, "kohm": 3, "Mohm": 6}),
    "W": ("a power", "1 W", {"kW": 3, "W": 0, "mW": -3, "uW": -6}),
    "H": ("an inductance", "2.6 uH", {"H": 0, "mH": -3, "uH": -6, "µH": -6, "nH": -9}),
    "F": ("a capacitance", "1 nF", {"F": 0, "uF": -6, "µF": -6, "nF": -9, "pF": -12}),
    "Pa": ("a stiffness", "64 GPa", {"Pa": 0, "kPa": 3, "MPa": 6, "GPa": 9}),
    "m/s": ("a velocity", "1 mm/s", {"m/s": 0, "mm/s": -3, "um/s": -6}),
    "m/s^2": ("an acceleration", "9.81 m/s^2", {"m/s^2": 0, "m/s**2": 0}),
    "s/m": ("a damping per velocity", "0.1 s/m", {"s/m": 0}),
    "N s/m": ("a viscous damping", "1 mN s/m", {"N s/m": 0, "mN s/m": -3, "N*s/m": 0}),
    "kg m^2": ("a moment of inertia", "2 g mm^2", {"kg m^2": 0, "g mm^2": -9, "kg mm^2": -6, "g cm^2": -7}),
    "N m": ("a torque", "1 uN m", {"N m": 0, "mN m": -3, "uN m": -6, "nN m": -9, "N*m": 0}),
    "kg/m^3": ("a density", "7.6 g/cm^3", {"kg/m^3": 0, "g/cm^3": 3}),
    "1/m": ("a curvature", "0.01 1/m", {"1/m": 0, "1/mm": 3}),
    "J/m^2": ("a work of adhesion", "0.05 J/m^2", {"J/m^2": 0, "mJ/m^2": -3}),
    "N/m": ("a surface tension", "0.072 N/m", {"N/m": 0, "mN/m": -3}),
    "1/m^2": ("a number per area", "2 1/um^2", {"1/m^2": 0, "1/mm^2": 6, "1/um^2": 12, "1/µm^2": 12}),
    "1/Pa": ("a compliance", "2.5e-12 1/Pa", {"1/Pa": 0, "1/GPa": -9}),
    "C/m^2": ("a piezoelectric stress constant", "12 C/m^2", {"C/m^2": 0}),
    "C/N": ("a piezoelectric strain constant", "300 pC/N", {"C/N": 0, "pC/N": -12, "m/V": 0, "pm/V": -12}),
    "N/m^3": ("a stiffness per area", "1e15 N/m^3", {"N/m^3": 0, "Pa/m": 0, "MPa/mm": 9, "GPa/m": 9}),
    "F/m": ("a permittivity", "5.6 nF/m", {"F/m": 0, "nF/m": -9, "pF/m": -12}),
    "W/(m K)": ("a thermal conductivity", "1.25 W/(m K)", {"W/(m K)": 0, "W/m/K": 0}),
    "J/(kg K)": ("a heat capacity", "420 J/(kg K)", {"J/(kg K)": 0, "J/kg/K": 0}),
    "W/(m^2 K)": ("a heat transfer coefficient", "10 W/(m^2 K)", {"W/(m^2 K)": 0, "W/m^2/K": 0}),
    "1/K": ("a temperature coefficient", "-75e-6 1/K", {"1/K": 0}),
    "degC": ("a temperature", "60 degC", {"degC": 0, "°C": 0}),
    "deg": ("an angle", "90 deg", {"deg": 0}),
    "": ("a plain number", "", {}),
}
DIMENSIONS = {unit: (noun, example) for unit, (noun, example, _) in UNITS.items()}
POWERS = {unit: names for unit, (_, _, names) in UNITS.items() if unit}
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\S.*?)?\s*", re.ASCII)
# Names and brackets with a power of one digit (pint would compute 9^9^9^9), a 1 above a slash, and what joins them
_POWER = r"(?:(?:\^|\*\*)-?\d)?"
UNIT_PART = re.compile(rf"[A-Za-zΩµÅ°]+(?:_[A-Za-z]+)*(?:_?0)?{_POWER}|\){_POWER}|\b1(?=\s*/)|[ */(]")
MAX_UNIT = 40  # characters
# Signs of equal meaning: both micro signs, both signs of ohm and of angstrom, points between units, superscripts
SIGNS = str.maketrans("\u03bc\u2126\u212b\u00b7\u22c5⁻⁰¹²³⁴", "µΩÅ**-01234")
SHORT_POWER = re.compile(r"(?<=[A-Za-zΩµÅ)])(-?[1-9])(?!\d)")  # of m/s2, mm-1 and m/s²


def si_value(path: str, value, unit: str) -> float:
    """Return a number in the SI unit, or text such as ``"2.2 MHz"``, as a finite number in that unit.

    ``path``: key of the quantity, for the refusal; ``unit``: a key of ``DIMENSIONS``, "" for a plain number.

    Examples
    --------
    >>> si_value("slider.mass", "0.089 g", "kg")
    8.9e-05
    """
    if isinstance(value, str) and unit:
        number = _from_text(path, value, unit)
    elif isinstance(value, bool) or not hasattr(value, "__float__"):
        raise SceneError(path, f"{_wanted(unit)}, got {shown(value)}")
    else:
        try:
            number = float(value)
        except (OverflowError, TypeError, ValueError):
            number = math.inf
    if not math.isfinite(number):
        raise SceneError(path, f"must be finite, got {shown(value)}{f' {unit}' if unit else ''}".rstrip())
    return number


def _wanted(unit: str) -> str:
    noun, example = DIMENSIONS[unit]
    return f'must be {noun}, a number in {unit} or a string such as "{example}"' if unit else f"must be {noun}"


def _from_text(path: str, text: str, unit: str) -> float:
    def refusal(hint: str) -> SceneError:
        return SceneError(path, f"{_wanted(unit)}, got {shown(text)}{hint}")

    match = NUMBER.fullmatch(text)
    if re.fullmatch(r"\s*[+-]?\d+,\d+\s*\S.*", text):
        raise refusal(f": write a decimal point, {text.replace(',', '.')!r}")
    if match is None:
        raise refusal("")
    number, name = match[1], match[2]
    if name is None:
        raise refusal(", which has no unit")
    name = SHORT_POWER.sub(r"^\1", name.translate(SIGNS))
    if name in POWERS[unit]:
        return float(Decimal(number).scaleb(POWERS[unit][name]))
    swapped = name[0].swapcase() + name[1:]
    if swapped in POWERS[unit] and unit != "ohm":  # 10^9 apart, as mHz and MHz: no motor has the other one
        raise refusal(f"; did you mean {number} {swapped}?")
    for other, names in POWERS.items():
        if name in names:
            raise refusal(f", {DIMENSIONS[other][0]}")
    try:
        return float(Decimal(number)) * _factor(name, unit)
    except (LookupError, InvalidOperation) as error:
        raise refusal(f": {error.args[0]}") from None


@cache
def _factor(name: str, unit: str) -> float:
    """Return the factor of a unit to the SI unit, by pint; LookupError with the reason where there is none."""
    if UNIT_PART.sub("", name) or len(name) > MAX_UNIT:
        raise LookupError(f"{shown(name)} is no unit")
    import pint
    from pint.util import to_units_container

    try:
        if unit == "degC":  # kelvin and fahrenheit have another zero, which no factor gives
            raise LookupError("write it in degC; 293.15 K are 20 degC")
        units = _registry().parse_units(name)
        _, roots = _registry().get_root_units(units)
        if unit == "deg":
            if str(roots) != "radian":
                raise LookupError(f"{shown(name)} is no angle")
        elif any(not _registry().get_dimensionality(root) for root in to_units_container(roots)):
            # pint takes a radian for 1: "1 rad/s" would pass for 1 Hz, wrong by 2 pi
            raise LookupError(f"{shown(name)} counts angles or parts")
        return float(_registry().Quantity(1.0, units).to(unit.replace(" ", "*")).magnitude)
    except pint.DimensionalityError:
        raise LookupError(f"{shown(name)} has another dimension") from None
    except LookupError:
        raise
    except Exception:  # pint's parser lets tokenizer, type and arithmetic errors through
        raise LookupError(f"{shown(name)} is no known unit{resembling(name, POWERS[unit])}") from None


@cache
def _registry():
    import pint

    return pint.UnitRegistry()
