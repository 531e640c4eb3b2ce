"""Constants of a solid at a temperature.

A table of the catalogue, or a user's of the same form, may have a block ``temperature``: relative coefficients of the
first to third order about a reference temperature T_0, and expansions along the crystal's axes,

    c(T) = c(T_0) (1 + c_1 t + c_2 t^2 + c_3 t^3),    l_i(T) = l_i(T_0) (1 + a_1 t + a_2 t^2 + a_3 t^3),    t = T - T_0

and the density falls with the volume (Bechmann, Ballato and Lukaszek, Proc. IRE 50 (1962) 1812; Smith and Welsh,
J. Appl. Phys. 42 (1971) 2219). A constant without a coefficient keeps its value. In the classes where
c66 = (c11 - c12)/2 the coefficient of c66 may stand for that of c12. The turn of the cut that an anisotropic expansion
makes (below 0.1 ppm/K for ST quartz) is left out.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fem.exceptions import InputError
from fem.materials.rotation import Orientation, rotation_matrix
from fem.materials.solids import Solid
from fem.materials.tables import catalogue_table, solid_of

COEFFICIENT_ORDERS = ("first", "second", "third")  # keys of the coefficients, in 1/K, 1/K^2 and 1/K^3
ELASTIC = ("youngs_modulus", "poisson_ratio")  # constants of an isotropic table, which has no ``constants``


def table_at(table: Mapping[str, Any], temperature: float) -> dict[str, Any]:
    """Return a material's table with its constants at a temperature in degC, without its block ``temperature``.

    Parameters
    ----------
    table : mapping
        As in the files of the catalogue.
    temperature : float
        degC.

    Raises
    ------
    InputError
        If the table has no coefficients.
    """
    name = table.get("name", "")
    if "temperature" not in table:
        raise InputError("temperature", f"needs coefficients, and {name or 'the material'} has none")
    block = table["temperature"]
    rise = temperature - block["reference"]
    factors: dict[str, float] = {}
    for power, order in enumerate(COEFFICIENT_ORDERS, start=1):
        for constant, coefficient in dict(block.get(order, ())).items():
            factors[constant] = factors.get(constant, 1.0) + coefficient * rise**power
    warm = {key: value for key, value in table.items() if key != "temperature"}
    warm["density"] = table["density"] / float(np.prod(1.0 + expansions(table, temperature)))
    constants = dict(table["constants"]) if "constants" in table else {key: table[key] for key in ELASTIC}
    scaled = {key: value * factors.get(key, 1.0) for key, value in constants.items()}
    if "c66" in factors and "c66" not in constants:  # of the classes where c66 = (c11 - c12)/2
        scaled["c12"] = scaled["c11"] - (constants["c11"] - constants["c12"]) * factors["c66"]
    return warm | ({"constants": scaled} if "constants" in table else scaled)


def expansions(table: Mapping[str, Any], temperature: float) -> np.ndarray:
    """Return the relative change of length along the crystal's axes from the reference temperature, shape (3,)."""
    block = table["temperature"]
    rise = temperature - block["reference"]
    keys = ("expansion", *(f"expansion_{order}" for order in COEFFICIENT_ORDERS[1:]))
    return sum(np.array(block.get(key) or (0.0, 0.0, 0.0)) * rise**power for power, key in enumerate(keys, start=1))


def expansion_along(table: Mapping[str, Any], orientation: Orientation, temperature: float) -> float:
    """Return the relative change of length along the propagation of a cut from the reference temperature."""
    along = rotation_matrix(orientation)[0]
    return float(along**2 @ expansions(table, temperature))


def solid_at(material: str | Mapping[str, Any], temperature: float) -> Solid:
    """Return a solid with its constants at a temperature, in the crystal frame.

    Parameters
    ----------
    material : str or mapping
        A name of the catalogue, or a table as its files have.
    temperature : float
        degC.

    Raises
    ------
    InputError
        If the material has no temperature coefficients, or is not stable there.

    Examples
    --------
    >>> warm = solid_at("LiNbO3 (Kovacs)", 125.0)
    >>> round(float(warm.stiffness[0, 0]) / 1e9, 3), round(warm.density, 1)
    (194.938, 4610.2)
    """
    table = catalogue_table(material) if isinstance(material, str) else material
    return solid_of(table_at(table, temperature))


def in_cold_lengths(solid: Solid, stretch: float) -> Solid:
    """Return the solid that gives an expanded body's answers when solved in its lengths before the expansion.

    With all lengths l(1 + e), e = ``stretch``: gradients fall by (1 + e), areas and volumes grow by its square and
    cube, so that in the old lengths c, e and eps appear times (1 + e) and rho times (1 + e)^3, with the same frequency,
    displacement, voltage, charge and power. The expansion along the propagation stands for that of all axes.
    """
    grown = 1.0 + stretch
    return replace(
        solid, stiffness=grown * solid.stiffness, coupling=grown * solid.coupling,
        permittivity=grown * solid.permittivity, density=grown**3 * solid.density,
    )  # fmt: skip
