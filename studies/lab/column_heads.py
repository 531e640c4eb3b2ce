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
# of a sine; read as its peak value, from peak to peak and from root mean square
KINDS_OF_VOLTAGE = {"": 1.0, "pp": 0.5, "rms": np.sqrt(2.0)}
VOLTAGES = {
    f"{prefix}V{kind}": size * share
    for kind, share in KINDS_OF_VOLTAGE.items()
    for prefix, size in (("", 1.0), ("m", 1e-3), ("k", 1e3))
}
PHASES = {"rad": 1.0, "deg": np.pi / 180.0}
SHARES = {"": 1.0, "percent": 1e-2}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
YAW_RATES = {"rad_per_s": 1.0}
ROTATIONS = {"rpm": 2.0 * np.pi / 60.0}  # yaw rates in turns per minute

MOTIONS = DISPLACEMENTS | VELOCITIES | ACCELERATIONS
UNITS = {
    *(POSITIONS | FREQUENCIES | MOTIONS | VOLTAGES | PHASES | TIMES | YAW_RATES | ROTATIONS),
    "percent",
    *(f"{unit}_per_V" for unit in MOTIONS),
}
# other spellings in small letters; capital letters say nothing in these, but tell mV from MV and s from S
SPELLINGS = {unit.lower(): unit for unit in (*FREQUENCIES, *PHASES, "dB")} | {
    "°": "deg", "degree": "deg", "degrees": "deg", "grad": "deg", "1/min": "rpm", "min-1": "rpm", "%": "percent",
    "siemens": "S",
}  # fmt: skip
# nouns of instruments' heads for those that are read, with the units that they have then
NOUNS = (
    ("voltage", ("u", "v", "drive_voltage", "v_drive", "u_drive", "spannung"), VOLTAGES),
    ("velocity", ("v", "speed", "slider_speed", "slider_velocity", "geschwindigkeit"), VELOCITIES),
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
WITHOUT_UNIT = ("amplitude",)
# units of voltages as instruments write them, and what heads write before the unit V for the same
VOLTAGE_UNIT = re.compile(
    r"(?P<prefix>[mk]?)V[_ ]?(?:(?P<pp>(?i:p-?p|pk-?pk|ss))|(?P<rms>(?i:rms|eff))|(?i:p|pk|peak))"
)
KIND_IN_NOUN = re.compile(
    r"(?:^|_|(?<=^[uv]))(?:(?P<pp>peak_to_peak|pk_pk|p_p|pp|ss)|(?P<rms>rms|eff|effective))(?=_|$)"
)
BRACKETED = re.compile(r"(.+?)\s*[(\[]\s*([^()\[\]]+?)\s*[)\]]")
SLASHED = re.compile(r"(.+?)\s+/\s+(.+)")  # as DIN 1313 writes a quantity over its unit
PLAIN = re.compile(r"[^\s()\[\]/]+")  # as the program writes heads


def spelled_alike(text: str) -> str:
    """Return a unit in the one spelling in which it is looked up; a text that is none comes back much as it is.

    Examples
    --------
    >>> [spelled_alike(unit) for unit in ("( mm/s² )", "µm", "MHZ", "Degrees", "kΩ", "1/min", "%")]
    ['mm_per_s2', 'um', 'MHz', 'deg', 'kohm', 'rpm', 'percent']
    """
    plain = text.strip("()[] \t").replace("µ", "u").replace("μ", "u").replace("²", "2").replace("^2", "2")
    plain = re.sub("(?i)ohms?$|[\u03a9\u2126]$", "ohm", plain).replace("Kohm", "kohm")  # both signs of the ohm
    return SPELLINGS.get(plain.lower(), plain).replace("/", "_per_")


def unit_in_head(text: str) -> str:
    """Return a unit as heads write it; an empty text for what is none.

    Examples
    --------
    >>> unit_in_head("mm/s"), unit_in_head("µm"), unit_in_head("m/s²"), unit_in_head("°"), unit_in_head("mVp-p")
    ('mm_per_s', 'um', 'm_per_s2', 'deg', 'mVpp')
    >>> unit_in_head("velocity")
    ''
    """
    plain = spelled_alike(text)
    voltage = VOLTAGE_UNIT.fullmatch(plain)
    plain = plain if voltage is None else f"{voltage['prefix']}V{_kind(voltage)}"
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
    >>> head_of_column("V (mV)"), head_of_column("v (mm/s)"), head_of_column("Speed [mm/s]"), head_of_column("u (nm)")
    ('voltage_mV', 'velocity_mm_per_s', 'velocity_mm_per_s', 'u_nm')
    >>> head_of_column("Voltage (Vpp)"), head_of_column("U_pp / V"), head_of_column("Vrms"), head_of_column("Amplitude")
    ('voltage_Vpp', 'voltage_Vpp', 'voltage_Vrms', 'amplitude')
    """
    text, noun = text.strip(), ""
    if not unit and text not in ("V", "mV", "kV") and unit_in_head(text) in VOLTAGES:  # these say no more than a unit
        return f"voltage_{unit_in_head(text)}"
    if not unit and (not PLAIN.fullmatch(text) or KIND_IN_NOUN.search(text.lower())):
        noun, unit = _parts(text)
    if not unit:
        return text.lower() if text.lower() in WITHOUT_UNIT else text
    noun = re.sub(r"[\s\-]+", "_", re.sub(r"[.:,]", " ", noun or text).strip()).lower()
    kind = KIND_IN_NOUN.search(noun)
    if kind is not None and f"{unit}{_kind(kind)}" in VOLTAGES:
        noun, unit = KIND_IN_NOUN.sub("", noun).strip("_") or "voltage", f"{unit}{_kind(kind)}"
    noun = next((ours for ours, theirs, units in NOUNS if noun in theirs and unit in units), noun)
    return f"{noun}_{unit}"


def _kind(found: re.Match[str]) -> str:
    """Return the kind of a voltage, of `KINDS_OF_VOLTAGE`, that the named groups of a match hold."""
    return next((kind for kind in ("pp", "rms") if found[kind]), "")


def _parts(text: str) -> tuple[str, str]:
    """Return noun and unit of a head; two empty texts where its end is no unit."""
    matches = (pattern.fullmatch(text) for pattern in (BRACKETED, SLASHED))
    ends = [(each[1], each[2]) for each in matches if each]
    ends += [(text[: each.start()], text[each.end() :]) for each in re.finditer(r"[\s_]+", text)]
    return next(((noun, unit_in_head(unit)) for noun, unit in ends if unit_in_head(unit)), ("", ""))
