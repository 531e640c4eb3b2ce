"""Ladders of lumped elements between a source and a transducer, and the L-section that matches the two.

An element in series has an impedance Z, one across the line an admittance 1/Z; L: i omega L (1 - i/Q), C:
(1 + i/Q) / (i omega C), both with a series resistance; R.  Voltage and current are transformed from the transducer's
electrodes to the source, element by element, with the power lost in each (Pozar, *Microwave Engineering*, 4th ed.,
2012, section 4.4; matching by an L-section: section 5.1).
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from fem.parameters import Number, Parameters, Words, refuse_if

EQUAL = 1e-9  # relative difference of stored energies that is rounding


@dataclass(frozen=True, kw_only=True)
class Element(Parameters):
    """A lumped element of a ladder.

    Attributes
    ----------
    place : str
        "series" or "shunt" (across the line).
    kind : str
        "L", "C" or "R".
    value : float
        H, F or ohm; positive.
    quality : float
        Reactance over series resistance of L or C, at the frequency of evaluation.
    """

    prefix = "element"
    place: Annotated[str, Words(("series", "shunt"))]
    kind: Annotated[str, Words(("L", "C", "R"))]
    value: Annotated[float, Number()]
    quality: Annotated[float, Number(infinite=True)] = np.inf

    def impedance(self, omega: float) -> complex:
        """Impedance in ohm at an angular frequency in rad/s."""
        if self.kind == "R":
            return complex(self.value)
        reactance = omega * self.value if self.kind == "L" else -1 / (omega * self.value)
        return complex(abs(reactance) / self.quality, reactance)


Ladder = tuple[Element, ...]


def carried(ladder: Ladder, omega: float, voltage, current) -> tuple:
    """Transform voltage and current (V, A; scalars or arrays) from the transducer's end of a ladder to the source's.

    Returns
    -------
    voltage, current
        At the source's end.
    lost : float or ndarray
        Mean power taken by the elements, W.
    """
    lost = 0.0
    for element in reversed(ladder):
        impedance = element.impedance(omega)
        if element.place == "series":
            lost = lost + 0.5 * impedance.real * abs(current) ** 2
            voltage = voltage + impedance * current
        else:
            through = voltage / impedance
            lost = lost + 0.5 * impedance.real * abs(through) ** 2
            current = current + through
    return voltage, current, lost


def best_match(source: complex, admittance: complex, frequency: float) -> Ladder:
    """Return the lossless L-section that matches a source to a load at one frequency.

    Up to four sections deliver all available power to the load.  The one that stores the least energy is returned: it
    has the widest band and loses least in real elements.  Ties are frequent: two sections of inductors alone (or of
    capacitors alone) both store exactly the excess of source and load, and between two resistances each section has a
    dual.  A tie goes to a section without a series capacitor, which suppresses harmonics, then to the smaller elements.

    Parameters
    ----------
    source : complex
        Impedance of the source, ohm.
    admittance : complex
        Of the load, S.
    frequency : float
        Hz.

    Returns
    -------
    tuple of Element
        From the source to the load.

    Raises
    ------
    ValueError
        If the source has no resistance or the load takes no power.

    Examples
    --------
    >>> from fem import best_match
    >>> for element in best_match(50 + 0j, 7.27e-3 + 26.98e-3j, 2.2e6):
    ...     print(f"{element.place}_{element.kind} {element.value:.4g}")
    shunt_L 1.73e-06
    series_L 1.092e-06
    """
    refuse_if(not source.real > 0, "match", "needs a source with a resistance", source, "ohm")
    refuse_if(not admittance.real > 0, "match", f"needs a load that takes power, got an admittance of {admittance:g} S")
    omega, sections = 2 * np.pi * frequency, []
    # The input impedance of section and load must be the conjugate of the source's impedance.
    for susceptance in _imaginary_parts(admittance.real, source.real):  # shunt at the load, then series
        inner = 1 / complex(admittance.real, susceptance)
        sections.append((("series", -source.imag - inner.imag), ("shunt", susceptance - admittance.imag)))
    load, source_admittance = 1 / admittance, 1 / source
    for reactance in _imaginary_parts(load.real, source_admittance.real):  # series at the load, then shunt
        inner = 1 / complex(load.real, reactance)
        sections.append((("shunt", -source_admittance.imag - inner.imag), ("series", reactance - load.imag)))
    ladders = [_ladder(section, omega) for section in sections]
    stored = {ladder: _stored(ladder, omega, admittance) for ladder in ladders}
    least = min(stored.values())
    tied = [ladder for ladder in stored if stored[ladder] <= least * (1 + EQUAL)]
    return min(tied, key=_tie_breaker)


def _tie_breaker(ladder: Ladder) -> tuple[bool, float]:
    """Sort key of sections that store the same energy: a series capacitor, then the largest element."""
    capacitor = any((each.place, each.kind) == ("series", "C") for each in ladder)
    return capacitor, max((each.value for each in ladder), default=0.0)


def _imaginary_parts(real: float, inverse_real: float) -> tuple[float, ...]:
    """Return x of both signs with Re 1/(real + i x) = inverse_real; empty if there is none."""
    square = real / inverse_real - real**2
    return () if square < 0 else (np.sqrt(square), -np.sqrt(square))


def _ladder(pair, omega: float) -> Ladder:
    """Elements with these reactances (series, ohm) and susceptances (shunt, S); those of value 0 are left out."""
    elements = []
    for place, value in pair:
        if value == 0:
            continue
        inductive = (value > 0) == (place == "series")
        size = abs(value) if place == "series" else 1 / abs(value)
        kind, amount = ("L", size / omega) if inductive else ("C", 1 / (omega * size))
        elements.append(Element(place=place, kind=kind, value=float(amount)))
    return tuple(elements)


def _stored(ladder: Ladder, omega: float, admittance: complex) -> float:
    """Return the reactive power of all elements for unit power in the load."""
    voltage = np.sqrt(2 / admittance.real)
    total, current = 0.0, voltage * admittance
    for element in reversed(ladder):
        reactance = abs(element.impedance(omega))
        total += abs(current) ** 2 * reactance if element.place == "series" else abs(voltage) ** 2 / reactance
        voltage, current, _ = carried((element,), omega, voltage, current)
    return total
