"""Constants that no solid has, and the unit or form that was probably meant.

The limits hold from polymers to diamond, osmium and relaxor crystals, with a margin: density 50 to 25 000 kg/m3
(osmium 22 590), stiffness 1 MPa to 1.4 TPa (three times the bulk modulus of diamond is 1.33 TPa), permittivity 1 to
10^5, piezoelectric constants 10^-4 to 100 C/m2, and e^2/(c eps) up to 20 (k = 0.976; relaxor crystals reach k = 0.95).
"""

from collections.abc import Iterator

import numpy as np

from fem.exceptions import InputError
from fem.materials.solids import VACUUM_PERMITTIVITY, Solid

DENSITY = (50.0, 25e3)  # kg/m3
STIFFNESS = (1e6, 1.4e12)  # Pa, of the largest eigenvalue
YOUNGS_MODULUS = (1e4, 1.3e12)  # Pa; diamond has 1.14 TPa
PERMITTIVITY = (1.0, 1e5)  # relative to vacuum, of every eigenvalue
COUPLING = (1e-4, 100.0)  # C/m2, of the largest entry
COUPLED_ENERGY = 20.0  # largest e^2/(c eps) of any strain


def refuse_impossible(solid: Solid, youngs_modulus: float | None = None) -> None:
    """Raise an InputError for constants that no solid has; it names the probable unit.

    ``youngs_modulus``: in Pa, of an isotropic solid; it is then judged in place of the stiffness, which grows beyond
    all bounds towards a Poisson ratio of 0.5.
    """
    for key, rule in impossible(solid, youngs_modulus):
        raise InputError(key, rule)


def impossible(solid: Solid, youngs_modulus: float | None = None) -> Iterator[tuple[str, str]]:
    """Yield table and rule of each constant that no solid has; arguments as of `refuse_impossible`."""
    low, high = DENSITY
    if not low <= solid.density <= high:
        hint = _density_hint(solid.density)
        yield "density", f"must be {low:g} to {high:g} kg/m^3, as of any solid, got {solid.density:.6g} kg/m^3{hint}"
    if youngs_modulus is not None:
        low, high = YOUNGS_MODULUS
        if not low <= youngs_modulus <= high:
            hint = f': is it in GPa? Then write "{youngs_modulus:g} GPa"' if youngs_modulus <= high / 1e9 else ""
            rule = f"must be {low:g} to {high:g} Pa, as of any solid, got {youngs_modulus:.6g} Pa{hint}"
            yield "youngs_modulus", rule
        return
    largest = float(np.linalg.eigvalsh(solid.stiffness)[-1])
    low, high = STIFFNESS
    if not low <= largest <= high:
        rule = f"must have a largest eigenvalue of {low:g} to {high:g} Pa, as of any solid, got {largest:.4g} Pa"
        yield "stiffness", rule + _stiffness_hint(largest)
    relative = np.linalg.eigvalsh(solid.permittivity) / VACUUM_PERMITTIVITY
    low, high = PERMITTIVITY
    if relative[0] < low - 1e-9 or relative[-1] > high:
        wrong = relative[0] if relative[0] < low else relative[-1]
        rule = f"must be {low:g} to {high:g} times that of vacuum in every direction, got {wrong:.4g}"
        yield "permittivity", rule + _permittivity_hint(wrong)
        return
    entry = float(abs(solid.coupling).max())
    low, high = COUPLING
    if entry and not low <= entry <= high:
        rule = f"must have a largest entry of {low:g} to {high:g} C/m^2, as of any solid, got {entry:.4g} C/m^2"
        yield "coupling", rule + _coupling_hint(entry)
    elif entry:
        energy = coupled_energy(solid)
        if energy > COUPLED_ENERGY:
            rule = f"must be such that e^2/(c eps) is at most {COUPLED_ENERGY:g} for every strain, got {energy:.4g}"
            yield "coupling", f"{rule}: a unit or an entry of stiffness, coupling or permittivity is wrong"


def coupled_energy(solid: Solid) -> float:
    """Return the largest e^2/(c eps) of any strain: electric over elastic energy, k^2/(1 - k^2)."""
    electric = solid.coupling.T @ np.linalg.solve(solid.permittivity, solid.coupling)
    return float(np.linalg.eigvals(np.linalg.solve(solid.stiffness, electric)).real.max())


def _density_hint(density: float) -> str:
    if 0.05 <= density <= 25.0:
        return f': is it in g/cm^3? Then write "{density:g} g/cm^3"'
    if density > 25e3:
        return ": is it in g/m^3 or mg/cm^3?"
    return ""


def _stiffness_hint(largest: float) -> str:
    """Words on the probable unit of a table whose largest eigenvalue was taken for Pa."""
    if largest < 1e-6:
        return ': are these compliances, in 1/Pa? Then write form = "strain-charge", with d and the permittivity at \
constant stress'
    if largest <= STIFFNESS[1] / 1e9:
        return ': is it in GPa? Then write units = { stiffness = "GPa" }'
    if largest < STIFFNESS[0]:
        return ': is it in MPa? Then write units = { stiffness = "MPa" }'
    return ': is it in dyn/cm^2? Then write units = { stiffness = "dyn/cm^2" }'


def _permittivity_hint(relative: float) -> str:
    """Words on the probable unit of numbers that were taken for relative ones."""
    if 0.99 <= relative / VACUUM_PERMITTIVITY <= PERMITTIVITY[1]:
        return ': is it in F/m? Then write units = { permittivity = "F/m" }'
    if 0.99 <= relative * 1e-12 / VACUUM_PERMITTIVITY:
        return ': is it in pF/m? Then write units = { permittivity = "pF/m" }'
    return ": is it a multiple of that of vacuum, at constant strain?"


def _coupling_hint(entry: float) -> str:
    """Words on the probable form of a table that was taken for e in C/m2."""
    if entry < 1e-7:
        return ': are these d, in C/N? Then write form = "strain-charge", with the compliances and the permittivity at \
constant stress'
    if entry > COUPLING[1]:
        return ': are these d, in pC/N? Then write form = "strain-charge" and units = { coupling = "pC/N" }'
    return ""
