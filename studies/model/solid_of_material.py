"""The solid of a scene's material: a name of the catalogue, or a table in any form, order and unit."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

import fem
from studies.model.scene_errors import stator_keys
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.quantity import si_value
from studies.scene.stator_keys import MATERIAL, IsotropicSolid, PiezoelectricSolid, Stator

LOSSES = ("mechanical_quality", "dielectric_loss")


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
            density=material.density, conducting=material.conducting, **own,
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


@lru_cache(64)
def thermal_table(material: str | PiezoelectricSolid | IsotropicSolid) -> dict[str, Any]:
    """Return the table of a stator's material as in the files of the catalogue, with its thermal constants."""
    return fem.catalogue_table(material) if isinstance(material, str) else material.to_table()


def frequency_coefficient(block: Stator) -> float | None:
    """Return the temperature coefficient of the frequency in 1/K that stands for those of the constants, if given."""
    if block.temperature_coefficient is not None:
        return block.temperature_coefficient
    if block.layer:
        return None
    return thermal_table(block.material).get("velocity_coefficient")


def knows_temperature(block: Stator) -> bool:
    """Return whether the effect of the temperature on the stator's wave is known."""
    if frequency_coefficient(block) is not None:
        return True
    return all(
        "temperature" in thermal_table(each) for each in (block.material, *(own.material for own in block.layer))
    )


def reference_temperature(block: Stator) -> float:
    """Return the temperature in degC at which the constants of a stator hold: without coefficients the ambient one."""
    known = frequency_coefficient(block) is None and "temperature" in thermal_table(block.material)
    return float(thermal_table(block.material)["temperature"]["reference"] if known else block.ambient)


@lru_cache(256)
def crystal_at(block: Stator, temperature: float, layer: int | None = None) -> tuple[Any, float]:
    """Return the ``fem.Solid`` of a stator at a temperature in degC, in the crystal's frame, and its stretch along x.

    With a coefficient of the frequency alone the density carries it, and the stretch is 0.  ``layer``: number of the
    layer whose solid it is; a layer is stretched along x as the stator's material, and the stress of that in it is left
    out.
    """
    own, key = (block.material, "stator.temperature") if layer is None else (
        block.layer[layer].material, f"stator.layer.{layer}.material"
    )  # fmt: skip
    coefficient = frequency_coefficient(block)
    if coefficient is not None:
        cold = crystal(own)
        growth = 1.0 + coefficient * (temperature - reference_temperature(block))
        if not growth > 0.0:
            rule = f"must be nearer to {reference_temperature(block):g} degC"
            raise SceneError("stator.temperature", f"{rule}: no frequency is left at {temperature:g} degC")
        return replace(cold, density=cold.density / growth**2), 0.0
    if "temperature" not in thermal_table(own):
        rule = "needs coefficients" if layer is None else "needs temperature coefficients for stator.temperature"
        rule = f"{rule}, and {crystal(own).name} has none: give stator.temperature_coefficient"
        raise SceneError(key, f"{rule}, or a material with a block temperature")
    table = thermal_table(block.material)
    with stator_keys(key):
        return solid_at(own, temperature), fem.expansion_along(table, block.cut, temperature)


def solid_at(material: str | PiezoelectricSolid | IsotropicSolid, temperature: float):
    """Return the ``fem.Solid`` of a material with temperature coefficients at a temperature in degC."""
    if isinstance(material, str):
        return fem.solid_at(material, temperature)
    table = fem.table_at(thermal_table(material), temperature)
    return crystal(type(material).from_table("stator.material", table))


def named_solid(name: str) -> tuple:
    """Return a material as a scene takes it, and its ``fem.Solid``.

    ``name``: of the catalogue, or a file of constants.
    """
    material = MATERIAL.read("material", name)
    return material, crystal(material)


def _stress_charge(material: PiezoelectricSolid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return c^E in Pa, e in C/m2 and eps^S in F/m of a table."""
    compliant = material.form == "strain-charge"
    if material.constants is None:
        key = "stiffness" if material.compliance is None else "compliance"
        tables = (getattr(material, name) for name in (key, "coupling", "permittivity"))
        elastic, coupling, permittivity = (np.array(each, dtype=float) for each in tables)
    else:
        key = "compliance" if compliant else "stiffness"
        elastic, coupling, permittivity = fem.class_tables(
            str(material.crystal_class), dict(material.constants), compliant=compliant
        )
    return fem.stress_charge(
        elastic * _factor(material, key), coupling * _factor(material, "coupling"),
        permittivity * _factor(material, "permittivity"), form=material.form, order=material.order,
        stiffness_at=material.stiffness_at, permittivity_at=material.permittivity_at,
    )  # fmt: skip


def _factor(material: PiezoelectricSolid, key: str) -> float:
    """Return the SI unit of a table's numbers."""
    usual = "relative" if key == "permittivity" else material.table_units[key]
    unit = dict(material.units or ()).get(key, usual)
    return fem.VACUUM_PERMITTIVITY if unit == "relative" else si_value(key, f"1 {unit}", material.table_units[key])


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
