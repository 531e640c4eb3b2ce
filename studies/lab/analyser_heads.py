"""Heads of the tables of analysers: a quantity and its unit, such as ``|Z| (kOhm)`` or ``S11 Phase (deg)``."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from studies.lab.column_heads import FREQUENCIES, PHASES, spelled_alike

IMPEDANCES = {"ohm": 1.0, "kohm": 1e3, "Mohm": 1e6, "mohm": 1e-3}
ADMITTANCES = {"S": 1.0, "mS": 1e-3, "uS": 1e-6, "nS": 1e-9}
DECIBELS = {"dB": 1.0}
# Quantities by the letters of their heads, without signs and blanks: the kind of parameter and its part
NAMES = {
    ("frequency", ""): ("f", "freq", "frequency", "frequenz"),
    ("z", "magnitude"): ("z", "absz", "magz", "zmag", "zabs", "zmagnitude", "modz", "impedance", "impedancemagnitude",
                         "impedanz", "betragz", "impedanzbetrag"),
    ("z", "real"): ("r", "rs", "rez", "zre", "zreal", "realz", "z'", "resistance"),
    ("z", "imag"): ("x", "xs", "imz", "zim", "zimag", "imagz", "z''", 'z"', "reactance"),
    ("y", "magnitude"): ("y", "absy", "magy", "ymag", "yabs", "ymagnitude", "admittance"),
    ("y", "real"): ("g", "gp", "rey", "yre", "yreal", "realy", "conductance"),
    ("y", "imag"): ("b", "bp", "imy", "yim", "yimag", "imagy", "susceptance"),
    ("s", "magnitude"): ("s11", "abss11", "mags11", "s11mag", "s11abs", "s11magnitude", "s11logmag", "logmags11",
                         "s11linmag", "linmags11", "dbs11", "s11db", "reflectionmagnitude"),
    ("s", "real"): ("res11", "s11re", "s11real", "reals11"),
    ("s", "imag"): ("ims11", "s11im", "s11imag", "imags11"),
    ("z", "phase"): ("phasez", "zphase", "thetaz", "argz", "anglez", "zangle", "phiz", "impedancephase",
                     "impedanzphase"),
    ("y", "phase"): ("phasey", "yphase", "thetay", "argy", "angley", "yangle"),
    ("s", "phase"): ("phases11", "s11phase", "args11", "angs11", "s11ang", "s11angle", "s11arg",
                     "reflectionphase"),
    ("", "phase"): ("phase", "theta", "angle", "phi", "phasewinkel"),
}  # fmt: skip
QUANTITIES = {name: quantity for quantity, names in NAMES.items() for name in names}
UNITS = {"frequency": FREQUENCIES, "z": IMPEDANCES, "y": ADMITTANCES, "s": {}}


@dataclass(frozen=True, kw_only=True)
class Head:
    """What a column holds."""

    text: str
    kind: str  # "frequency", "z", "y", "s"; empty for a phase of any of them
    part: str  # "magnitude", "phase", "real", "imag"
    unit: str  # empty if none is stated
    sign: float  # -1 for a head that begins with a minus sign


def unit_of(text: str) -> str:
    """Return a unit as this module writes it; an empty text for what is none.

    Examples
    --------
    >>> unit_of("kΩ"), unit_of("MHZ"), unit_of("°"), unit_of("mOhm"), unit_of("mm")
    ('kohm', 'MHz', 'deg', 'mohm', '')
    """
    plain = spelled_alike(text)
    return plain if plain in FREQUENCIES | PHASES | IMPEDANCES | ADMITTANCES | DECIBELS else ""


def head_of(cell: str) -> Head | None:
    """Return what a head says, or None for a column of something else."""
    text, unit = cell.strip().strip('"').strip(), ""
    bracketed = re.fullmatch(r"(.*?)\s*[(\[]\s*([^()\[\]]+?)\s*[)\]]", text)
    trailing = re.fullmatch(r"(.*?)\s*(?:[/_,]|\s)\s*([^\s/_,()\[\]]+)", text)
    for matched in (bracketed, trailing):
        if matched and unit_of(matched[2]):
            text, unit = matched[1], unit_of(matched[2])
            break
    sign = -1.0 if text.startswith(("-", "−")) else 1.0
    word = (
        re.sub(r"[\s_.\-−|()\[\]{}<>:∠]", "", text)
        .lower()
        .replace("θ", "theta")
        .replace("φ", "phi")
        .replace("ϕ", "phi")
    )
    word = word.replace("″", "''").replace("′", "'")
    word = re.sub(r"trace\d*|(?:trc|tr|ch)\d+", "", word)  # names of an instrument's traces
    if word not in QUANTITIES:
        return None
    kind, part = QUANTITIES[word]
    if part == "magnitude" and unit in PHASES:
        part = "phase"
    if kind == "s" and part == "magnitude" and not unit and ("log" in word or "db" in word):
        unit = "dB"
    if unit and unit not in _units(kind, part):
        return None
    return Head(text=cell.strip(), kind=kind, part=part, unit=unit, sign=sign)


def _units(kind: str, part: str) -> Iterable[str]:
    if part == "phase":
        return PHASES
    if kind == "s":
        return DECIBELS if part == "magnitude" else {}
    return UNITS[kind]
