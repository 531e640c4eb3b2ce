"""Heads of the columns of a CSV file: a noun and a unit, as ``velocity_mm_per_s``, ``Velocity (mm/s)`` or ``U / V``."""

import re

import numpy as np

# factors to SI units, by the unit in a head
POSITIONS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
FREQUENCIES = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}
DISPLACEMENTS = {"m": 1.0, "um": 1e-6, "nm": 1e-9, "pm": 1e-12}
VELOCITIES = {"m_per_s": 1.0, "mm_per_s": 1e-3, "um_per_s": 1e-6, "nm_per_s": 1e-9}
# g: standard gravity (CGPM 1901)
ACCELERATIONS = {"m_per_s2": 1.0, "mm_per_s2": 1e-3, "km_per_s2": 1e3, "g": 9.80665}
VOLTAGES = {"V": 1.0, "mV": 1e-3, "kV": 1e3}
PHASES = {"rad": 1.0, "deg": np.pi / 180.0}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
YAW_RATES = {"rad_per_s": 1.0}
ROTATIONS = {"rpm": 2.0 * np.pi / 60.0}  # yaw rates in turns per minute

MOTIONS = DISPLACEMENTS | VELOCITIES | ACCELERATIONS
UNITS = {
    *(POSITIONS | FREQUENCIES | MOTIONS | VOLTAGES | PHASES | TIMES | YAW_RATES | ROTATIONS),
    *(f"{unit}_per_V" for unit in MOTIONS),
}
# nouns of instruments' heads for those that are read, with the units that they have then
NOUNS = (
    ("voltage", ("u", "v", "drive_voltage", "spannung"), VOLTAGES),
    ("velocity", ("v", "geschwindigkeit"), VELOCITIES),
    ("time", ("t", "zeit"), TIMES),
    ("frequency", ("f", "frequenz"), FREQUENCIES),
    ("position", ("weg",), POSITIONS),
    ("rotation", ("drehzahl",), ROTATIONS),
    # of a standard deviation that does not say of what
    (
        "velocity_standard_deviation",
        "std standard_deviation std_dev stdev sd sigma uncertainty error standardabweichung unsicherheit".split(),
        VELOCITIES,
    ),
)
BRACKETED = re.compile(r"(.+?)\s*[(\[]\s*([^()\[\]]+?)\s*[)\]]")
SLASHED = re.compile(r"(.+?)\s+/\s+(.+)")  # as DIN 1313 writes a quantity over its unit
PLAIN = re.compile(r"[^\s()\[\]/]+")  # as the program writes heads


def unit_in_head(text: str) -> str:
    """Return a unit as heads write it; an empty text for what is none.

    Examples
    --------
    >>> unit_in_head("mm/s"), unit_in_head("µm"), unit_in_head("m/s²"), unit_in_head("°"), unit_in_head("Vpp")
    ('mm_per_s', 'um', 'm_per_s2', 'deg', '')
    """
    plain = text.strip().strip("()[]").replace("µ", "u").replace("μ", "u").replace("²", "2").replace("^2", "2")
    plain = {"°": "deg", "1/min": "rpm", "min-1": "rpm"}.get(plain, plain).replace("/", "_per_")
    return plain if plain in UNITS else ""


def head_of_column(text: str, unit: str = "") -> str:
    """Return the head of a column as noun and unit, as ``velocity_mm_per_s``; one without a known unit stays as it is.

    Parameters
    ----------
    text : str
        As the file has it.
    unit : str
        Of a line of units below the heads, as `unit_in_head` returns it.

    Examples
    --------
    >>> head_of_column("Velocity (mm/s)"), head_of_column("U / V"), head_of_column("u_z magnitude [nm/V]")
    ('velocity_mm_per_s', 'voltage_V', 'u_z_magnitude_nm_per_V')
    >>> head_of_column("Zeit", "ms"), head_of_column("velocity_mm/s"), head_of_column("slider.preload")
    ('time_ms', 'velocity_mm_per_s', 'slider.preload')
    >>> head_of_column("V (mV)"), head_of_column("v (mm/s)"), head_of_column("u (nm)")
    ('voltage_mV', 'velocity_mm_per_s', 'u_nm')
    """
    text, noun = text.strip(), ""
    if not unit and not PLAIN.fullmatch(text):
        noun, unit = _parts(text)
    if not unit:
        return text
    noun = re.sub(r"[\s\-]+", "_", re.sub(r"[.:,]", " ", noun or text).strip()).lower()
    noun = next((ours for ours, theirs, units in NOUNS if noun in theirs and unit in units), noun)
    return f"{noun}_{unit}"


def _parts(text: str) -> tuple[str, str]:
    """Return noun and unit of a head; two empty texts where its end is no unit."""
    matches = (pattern.fullmatch(text) for pattern in (BRACKETED, SLASHED))
    ends = [(each[1], each[2]) for each in matches if each]
    ends += [(text[: each.start()], text[each.end() :]) for each in re.finditer(r"[\s_]+", text)]
    return next(((noun, unit_in_head(unit)) for noun, unit in ends if unit_in_head(unit)), ("", ""))
