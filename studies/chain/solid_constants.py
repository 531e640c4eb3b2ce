"""The solid of a scene's material: a name of the catalogue, or a table in any form, order and unit."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

import fem
from studies.scene import Scene
from studies.scene.blocks import IsotropicSolid, PiezoelectricSolid
from studies.scene.quantity import si_value

LOSSES = ("mechanical_quality", "dielectric_loss")
COMPLIANT = 1e-6  # of a table's largest entry: a smaller one is a compliance in 1/Pa, whatever its key


@lru_cache(64)
def crystal(material: str | PiezoelectricSolid | IsotropicSolid):
    """Return the ``fem.Solid`` of a name of the catalogue or of a table, in the crystal's frame.

    An `fem.InputError` names the table and the probable unit of constants that no solid has.
    """
    if isinstance(material, str):
        return fem.material(material)
    if isinstance(material, IsotropicSolid):
        own = {name: getattr(material, name) for name in ("mechanical_quality",) if getattr(material, name) is not None}
        solid = fem.isotropic(
            name=material.name, youngs_modulus=material.youngs_modulus, poisson_ratio=material.poisson_ratio,
            density=material.density, **own,
        )  # fmt: skip
        fem.refuse_impossible(solid, material.youngs_modulus)
    else:
        stiffness, coupling, permittivity = _stress_charge(material)
        own = {name: getattr(material, name) for name in LOSSES if getattr(material, name) is not None}
        solid = fem.anisotropic(
            name=material.name, stiffness=stiffness, coupling=coupling, density=material.density,
            permittivity=permittivity / fem.VACUUM_PERMITTIVITY, **own,
        )  # fmt: skip
        fem.refuse_impossible(solid)
    return solid


def _stress_charge(material: PiezoelectricSolid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return c^E in Pa, e in C/m2 and eps^S in F/m of a table."""
    key = "stiffness" if material.compliance is None else "compliance"
    elastic, coupling, permittivity = (_in_si(material, name) for name in (key, "coupling", "permittivity"))
    elastic, coupling = (fem.in_order(each, material.order) for each in (elastic, coupling))
    if material.form == "strain-charge":
        if key == "stiffness" and abs(elastic).max() > COMPLIANT:
            elastic = np.linalg.inv(elastic)
        return fem.from_strain_charge(elastic, coupling, permittivity)
    if material.stiffness_at == "constant D":
        elastic = fem.at_constant_field(elastic, coupling, permittivity)
    if material.permittivity_at == "constant stress":
        permittivity = fem.at_constant_strain(elastic, coupling, permittivity)
    return elastic, coupling, permittivity


def _in_si(material: PiezoelectricSolid, key: str) -> np.ndarray:
    """Return a table in SI units."""
    usual = "relative" if key == "permittivity" else material.table_units[key]
    unit = dict(material.units or ()).get(key, usual)
    factor = fem.VACUUM_PERMITTIVITY if unit == "relative" else si_value(key, f"1 {unit}", material.table_units[key])
    return np.array(getattr(material, key), dtype=float) * factor


def solid_remarks(scene: Scene) -> Iterator[str]:
    """Yield remarks about a scene's tables of constants: what is possible, and probably a mistake."""
    solids = [] if scene.stator is None else [("stator.material", scene.stator.material)]
    solids += [
        (f"piece.{index}.materials.{name}", material)
        for index, piece in enumerate(scene.piece)
        for name, material in piece.materials or ()
    ]
    for path, material in solids:
        if not isinstance(material, str):
            yield from (f"{path}: {remark}" for remark in fem.plausibility(crystal(material)))
