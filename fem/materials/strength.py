"""Limits of the catalogue's solids: contact pressure, dynamic stress and electric field. For warnings, not for design.

Ceramics: compressive strength, rated dynamic tensile strength and AC depoling field (peak, 25 degC) of the
manufacturer's tables, D. Berlincourt, H. H. A. Krueger and C. Near, Properties of Piezoelectricity Ceramics, Technical
Publication TP-226, Morgan Electro Ceramics; those of PIC181 are PZT-4's, another hard ceramic. A Hertz pressure above
the compressive strength is counted as damage, although the material around a contact supports it.

Lithium niobate: plastic flow begins at a contact pressure of 1.6 Y = 0.57 H, Y the yield strength and H = 2.8 Y the
hardness (K. L. Johnson, Contact Mechanics, 1985, sections 6.1 and 6.3), 9.1 GPa on its softest cut, Y (Scripta
Materialia 77 (2014) 56); domains are reversed by 24 MV/m (Phys. Rev. B 69 (2004) 064113).

Steel: 1.5 GPa is the contact pressure of the fatigue limit of hardened bearing steel (ISO 281:2007, annex B).
"""

from dataclasses import dataclass

__all__ = ["Strength", "strength"]


@dataclass(frozen=True, kw_only=True)
class Strength:
    """Limits of a solid; None where no published value is at hand.

    Attributes
    ----------
    contact_pressure : float
        Largest Hertz pressure, Pa.
    tensile_stress : float or None
        Dynamic, peak, Pa.
    field : float or None
        At which a ceramic depoles or a crystal reverses its domains, peak, V/m.
    pressure_source, field_source : str
        Kind of each limit, and its publication.
    """

    contact_pressure: float
    tensile_stress: float | None = None
    field: float | None = None
    pressure_source: str
    field_source: str = ""


def _ceramic(tensile: float, field: float, name: str = "") -> Strength:
    return Strength(
        contact_pressure=517e6,
        tensile_stress=tensile,
        field=field,
        pressure_source=f"compressive strength{name}, Morgan TP-226",
        field_source=f"AC depoling field{name}, Morgan TP-226",
    )


_NIOBATE = Strength(
    contact_pressure=5.2e9,
    field=24e6,
    pressure_source="onset of plastic flow, Scripta Materialia 77 (2014) 56",
    field_source="reversal of domains, Phys. Rev. B 69 (2004) 064113",
)
_STRENGTHS = {
    "PZT-4": _ceramic(24e6, 1.0e6),
    "PZT-8": _ceramic(34e6, 1.5e6),
    "PZT-8 (Near)": _ceramic(34e6, 1.5e6),
    "PZT-5A": _ceramic(28e6, 0.7e6),
    "PZT-5H": _ceramic(28e6, 0.4e6),
    "PIC181": _ceramic(24e6, 1.0e6, " of PZT-4"),
    "LiNbO3 (Warner)": _NIOBATE,
    "LiNbO3 (Ogi)": _NIOBATE,
    "LiNbO3 (Kovacs)": _NIOBATE,
    "steel": Strength(contact_pressure=1.5e9, pressure_source="fatigue limit of hardened bearing steel, ISO 281:2007"),
}


def strength(name: str) -> Strength | None:
    """Return the limits of a solid of the catalogue, by its name; None if none are known.

    Examples
    --------
    >>> strength("steel").contact_pressure
    1500000000.0
    """
    return _STRENGTHS.get(name)
