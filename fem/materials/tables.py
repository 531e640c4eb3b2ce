"""The catalogue: published sets of constants, one file for each in the folder ``catalogue``.

A file is a material as a scene takes it (TOML): name and source; the constants of a crystal class, or Young's modulus
and Poisson's ratio; density, losses; ``aliases``, names by which the set is found as well; ``axes`` and ``remark`` in
words; ``confirmed``, published values that a test computes from the set; ``temperature``, coefficients of the constants
(`fem.materials.temperature`). Sets of one material differ between authors by more than numerical errors do, so that an
entry carries its author; the two sets of PZT-8 invert different published s12, s13 and must not be mixed.
"""

import re
import tomllib
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from fem.exceptions import InputError
from fem.materials.class_tables import class_tables
from fem.materials.forms import stress_charge
from fem.materials.solids import VACUUM_PERMITTIVITY, Solid, isotropic

FOLDER = Path(__file__).with_name("catalogue")
# Factors to SI units of the units that the catalogue's files use
FACTORS = {"Pa": 1.0, "GPa": 1e9, "1/TPa": 1e-12, "C/m^2": 1.0, "pC/N": 1e-12, "pF/m": 1e-12}
FACTORS |= {"relative": VACUUM_PERMITTIVITY}


def solid_of(table: dict[str, Any]) -> Solid:
    """Return the solid of the table of a file of the catalogue."""
    own: dict[str, Any] = {key: table[key] for key in ("name", "source", "density")}
    own |= {key: table[key] for key in ("mechanical_quality", "dielectric_loss", "conducting") if key in table}
    if "youngs_modulus" in table:
        return isotropic(youngs_modulus=table["youngs_modulus"], poisson_ratio=table["poisson_ratio"], **own)
    form = table.get("form", "stress-charge")
    compliant, units = form == "strain-charge", table.get("units", {})
    elastic, coupling, permittivity = class_tables(table["crystal_class"], table["constants"], compliant=compliant)
    key, usual = ("compliance", "1/TPa") if compliant else ("stiffness", "GPa")
    stiffness, piezoelectric, clamped = stress_charge(
        elastic * FACTORS[units.get(key, usual)],
        coupling * FACTORS[units.get("coupling", "pC/N" if compliant else "C/m^2")],
        permittivity * FACTORS[units.get("permittivity", "relative")],
        form=form, stiffness_at=table.get("stiffness_at", "constant E"), permittivity_at=table.get("permittivity_at"),
    )  # fmt: skip
    return Solid(stiffness=stiffness, coupling=piezoelectric, permittivity=clamped, **own)


def file_of(name: str) -> Path:
    """Return the file of a set of constants, by its name."""
    return FOLDER / f"{re.sub(r'[^a-z0-9]+', '-', name.casefold()).strip('-')}.toml"


@cache
def catalogue_tables() -> dict[str, dict[str, Any]]:
    """Return the tables of the catalogue's files by name."""
    tables = [tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(FOLDER.glob("*.toml"))]
    return {table["name"]: table for table in tables}


@cache
def _solid(path: Path) -> Solid:
    return solid_of(tomllib.loads(path.read_text(encoding="utf-8")))


@cache
def _names() -> dict[str, str]:
    """Names by what is searched for: without case, blanks and hyphens; the aliases included."""
    tables = catalogue_tables()
    aliases = {_plain(alias): name for name, table in tables.items() for alias in table.get("aliases", ())}
    return aliases | {_plain(name): name for name in tables}


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]+", "", str(name)).casefold()


def catalogue() -> dict[str, Solid]:
    """Return the solids that ship, by name, in the crystal frame."""
    return {name: _solid(file_of(name)) for name in catalogue_tables()}


def material_names() -> tuple[str, ...]:
    """Return the names and aliases of the solids that ship."""
    return tuple(alias for name, table in catalogue_tables().items() for alias in (name, *table.get("aliases", ())))


def catalogue_table(name: str) -> dict[str, Any]:
    """Return the table of the file of a solid, by its name or an alias; an InputError for another name."""
    return catalogue_tables()[material(name).name]


def catalogue_text(name: str) -> str:
    """Return the text of the file of a solid, by its name or an alias; an InputError for another name."""
    return file_of(material(name).name).read_text(encoding="utf-8")


def material(name: str) -> Solid:
    """Return a solid of the catalogue in the crystal frame; a ValueError for another name offers one like it.

    Names are found without regard to case, blanks and hyphens, and by the aliases of the files.
    """
    path = file_of(str(name))
    if path.is_file() and _solid(path).name == name:
        return _solid(path)  # without reading the other files
    names, wanted = _names(), _plain(name)
    if wanted in names:
        return _solid(file_of(names[wanted]))
    close = get_close_matches(wanted, names, n=1)
    nearest = f"; the nearest known one is {names[close[0]]!r}" if close else ""
    raise InputError("material", f"must be in the catalogue ({', '.join(catalogue_tables())}), got {name!r}{nearest}")
