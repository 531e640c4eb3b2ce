"""Published sets of constants, in crystal axes: axis 3 is the poling direction or the trigonal axis.

c^E in GPa, e in C/m2, eps^S relative to vacuum, density in kg/m3.  The tables show which entries symmetry
ties together (IEEE 176-1987, table 8).  Sets of one material differ between authors by more than numerical
errors do, so an entry carries its author; the two sets of PZT-8 invert different published s12, s13 and must
not be mixed.
"""

from difflib import get_close_matches
from functools import cache

import numpy as np

from fem.exceptions import InputError
from fem.materials.solids import VACUUM_PERMITTIVITY, Solid, isotropic

_TRIGONAL = """c11  c12 c13  c14  0   0
               c12  c11 c13 -c14  0   0
               c13  c13 c33   0   0   0
               c14 -c14  0   c44  0   0
                0    0   0    0  c44 c14
                0    0   0    0  c14 c66"""
# Constants of each symmetry class in the order of the tables below, and which of them stands where; "-" turns the sign,
# c66 is (c11 - c12)/2.
_CLASSES = {
    "6mm": (
        "c11 c12 c13 c33 c44 e31 e33 e15 eps11 eps33",
        """c11 c12 c13  0   0   0
           c12 c11 c13  0   0   0
           c13 c13 c33  0   0   0
            0   0   0  c44  0   0
            0   0   0   0  c44  0
            0   0   0   0   0  c66""",
        """ 0   0   0   0  e15  0
            0   0   0  e15  0   0
           e31 e31 e33  0   0   0""",
    ),
    "3m": (
        "c11 c12 c13 c14 c33 c44 e15 e22 e31 e33 eps11 eps33",
        _TRIGONAL,
        """  0    0   0   0  e15 -e22
           -e22  e22  0  e15  0    0
            e31  e31 e33  0   0    0""",
    ),
    "32": (
        "c11 c12 c13 c14 c33 c44 e11 e14 eps11 eps33",
        _TRIGONAL,
        """e11 -e11 0 e14   0    0
            0    0  0  0  -e14 -e11
            0    0  0  0    0    0""",
    ),
}


def _tables(symmetry: str, constants: tuple[float, ...]) -> dict:
    """Tables of a crystal of a symmetry class, SI."""
    names, stiffness, coupling = _CLASSES[symmetry]
    value = dict(zip(names.split(), constants, strict=True)) | {"0": 0.0}
    value["c66"] = (value["c11"] - value["c12"]) / 2

    def table(text: str) -> np.ndarray:
        rows = [
            [value[entry.lstrip("-")] * (-1) ** entry.count("-") for entry in row.split()] for row in text.splitlines()
        ]
        return np.array(rows)

    return {
        "stiffness": table(stiffness) * 1e9,
        "coupling": table(coupling),
        "permittivity": np.diag([value["eps11"], value["eps11"], value["eps33"]]) * VACUUM_PERMITTIVITY,
    }


_BERLINCOURT = "Berlincourt, Curran and Jaffe; IEEE 176"
_NEAR = "Berlincourt and Krueger, revised by Near (Morgan Electro Ceramics, TP-226)"
_PIC181 = "PI Ceramic data sheet, as used by Awrejcewicz et al."

# name: c11 c12 c13 c33 c44 | e31 e33 e15 | eps11 eps33, density, Qm, tan delta, source
_CERAMICS = {
    "PZT-4": ((139, 77.8, 74.3, 115, 25.6, -5.2, 15.1, 12.7, 730, 635), 7500, 500, 0.004, _BERLINCOURT),
    "PZT-8": (
        (146.9, 81.1, 81.1, 131.7, 31.35, -3.88, 13.91, 10.34, 904, 562),
        7600,
        1000,
        0.004,
        "Berlincourt; inverted from s^E, d, eps^T",
    ),
    "PZT-8 (Near)": ((137, 69.7, 71.6, 124, 31.3, -4.0, 13.8, 10.3, 900, 582), 7600, 1000, 0.004, _NEAR),
    "PZT-5A": ((121, 75.9, 75.4, 111, 21.1, -5.4, 15.8, 12.3, 916, 830), 7750, 70, 0.02, "Berlincourt"),
    "PZT-5H": ((126, 79.5, 84.1, 117, 23.0, -6.5, 23.3, 17.0, 1700, 1470), 7500, 65, 0.02, "Berlincourt"),
    "PIC181": ((152.3, 89.1, 85.5, 134, 28.3, -4.5, 14.7, 11.0, 740, 634), 7850, 2000, 0.003, _PIC181),
}

# name: c11 c12 c13 c14 c33 c44 | e15 e22 e31 e33 | eps11 eps33, density, source
_NIOBATES = {
    "LiNbO3 (Warner)": (
        (203, 53, 75, 9, 245, 60, 3.7, 2.5, 0.2, 1.3, 44, 29),
        4700,
        "Warner, Onoe and Coquin, J. Acoust. Soc. Am. 42 (1967) 1223",
    ),
    "LiNbO3 (Ogi)": (
        (199.5, 55.27, 67.67, 8.70, 235.2, 59.48, 3.65, 2.39, 0.31, 1.72, 45.05, 26.2),
        4640,
        "Ogi, Kawasaki, Hirao and Ledbetter, J. Appl. Phys. 92 (2002) 2451",
    ),
    "LiNbO3 (Kovacs)": (
        (198.39, 54.72, 65.13, 7.88, 227.9, 59.65, 3.69, 2.42, 0.30, 1.77, 45.6, 26.3),
        4628,
        "Kovacs et al., IEEE Ultrasonics Symposium (1990) 435",
    ),
}

# c11 c12 c13 c14 c33 c44 | e11 e14 | eps11 eps33 (3.921e-11 and 4.103e-11 F/m)
_QUARTZ = (86.74, 6.99, 11.91, -17.91, 107.2, 57.94, 0.171, -0.0406)
_QUARTZ_PERMITTIVITY = (3.921e-11 / VACUUM_PERMITTIVITY, 4.103e-11 / VACUUM_PERMITTIVITY)

# name: Young's modulus in Pa, Poisson ratio, density
_ISOTROPIC = {
    "steel": (210e9, 0.30, 7850, "handbook values of bearing balls"),
    "aluminium": (70e9, 0.34, 2700, "handbook values"),
    "silicon": (162e9, 0.22, 2330, "isotropic average"),
}


@cache
def _solids() -> dict[str, Solid]:
    solids = []
    for name, (constants, density, quality, loss, source) in _CERAMICS.items():
        tables = _tables("6mm", constants)
        solids.append(
            Solid(name=name, source=source, density=density, mechanical_quality=quality, dielectric_loss=loss, **tables)
        )
    for name, (numbers, density, source) in _NIOBATES.items():
        solids.append(Solid(name=name, source=source, density=density, **_tables("3m", numbers)))
    tables = _tables("32", (*_QUARTZ, *_QUARTZ_PERMITTIVITY))
    source = "Bechmann, Phys. Rev. 110 (1958) 1060"
    solids.append(Solid(name="quartz (Bechmann)", source=source, density=2649, **tables))
    for name, (modulus, ratio, density, source) in _ISOTROPIC.items():
        solids.append(isotropic(name=name, source=source, youngs_modulus=modulus, poisson_ratio=ratio, density=density))
    return {solid.name: solid for solid in solids}


def catalogue() -> dict[str, Solid]:
    """Return the solids that ship, by name, in the crystal frame."""
    return dict(_solids())


def material(name: str) -> Solid:
    """Return a solid of the catalogue in the crystal frame; a ValueError for another name offers one like it."""
    solids = _solids()
    if name in solids:
        return solids[name]
    by_folded = {known.casefold(): known for known in solids}
    close = get_close_matches(str(name).casefold(), by_folded, n=1)
    nearest = f"; the nearest known one is {by_folded[close[0]]!r}" if close else ""
    raise InputError("material", f"must be in the catalogue ({', '.join(solids)}), got {name!r}{nearest}")
