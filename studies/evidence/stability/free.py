"""Extreme cases of the free wave: a section without transducers against closed forms and partial waves.

Isotropic half-spaces against Rayleigh's cubic, isotropic plates against Lamb's equations (lamb.py), piezoelectric
half-spaces against the surface impedance of partial waves (fem.analytic.half_space), which has neither mesh nor order.
With one loss factor on all moduli the wavenumber is the lossless one over sqrt(1 + i / Q).
"""

import math
from dataclasses import replace

from studies.evidence.stability.case import Case, Outcome
from studies.evidence.stability.verdict import judged

__all__ = ["free_cases", "judge"]

PART = "free wave"
FREQUENCY = 2.2e6
CUTS = (
    ("PZT-8", "Z"),
    ("PZT-8", "X"),
    ("PIC181", "Z"),
    ("LiNbO3 (Warner)", "YZ"),
    ("LiNbO3 (Warner)", "128YX"),
    ("quartz (Bechmann)", "ST-X"),
    ("PZT-8", (10.0, 20.0, 30.0)),
    ("LiNbO3 (Warner)", (10.0, 20.0, 30.0)),
)
NEAR_HALF = (-0.9, 0.0, 0.25, 0.45, 0.499, 0.49999, 0.4999999)
VARIED = {
    "Poisson's ratio, half-space": ("", NEAR_HALF),
    "Poisson's ratio, plate of 10 wavelengths": ("", NEAR_HALF),
    "thickness": ("wavelengths", (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 50.0)),
    "distance from a cut-off": ("", (-1e-4, -1e-9, 0.0, 1e-14, 1e-9, 1e-4)),
    "stiffness": ("times", (1e-6, 1e-3, 1e3, 1e6)),
    "density": ("times", (1e-3, 1e3)),
    "permittivity": ("times", (1e-3, 1e-1, 1e1, 1e3)),
    "coupling": ("times", (1e-9, 1e-3, 3.0, 10.0)),
    "frequency": ("Hz", (1e-3, 1e3, 1e9, 1e13)),
    "mechanical quality": ("", (2.0, 5.0, 20.0, 1e3, 1e9)),
    "cut": ("", tuple(range(len(CUTS)))),
    "tolerance, half-space": ("", (1e-1, 1e-3, 1e-5, 1e-6, 1e-8, 1e-12)),
    "tolerance, plate": ("", (1e-1, 1e-3, 1e-5, 1e-8, 1e-12)),
}
TOLERANCE = 1e-4
YOUNG, DENSITY = 70e9, 2700.0


def free_cases() -> tuple[Case, ...]:
    """Return the cases of the free wave."""
    return tuple(
        Case(part=PART, varied=name, value=float(value), unit=unit)
        for name, (unit, values) in VARIED.items()
        for value in values
    )


def judge(case: Case) -> Outcome:
    """Return what became of a case."""
    name, value = case.varied, case.value
    tolerance = value if name.startswith("tolerance") else TOLERANCE

    def posed():
        if name.startswith("Poisson"):
            return _isotropic(
                poisson=value, thickness=math.inf if "half" in name else 10.0, tolerance=tolerance
            )
        if name == "thickness":
            return _isotropic(thickness=value, tolerance=tolerance)
        if name == "distance from a cut-off":
            return _isotropic(thickness=2.5 * (1 + value), tolerance=tolerance)
        if name == "mechanical quality":
            return _isotropic(quality=value, thickness=math.inf, tolerance=tolerance)
        if name == "tolerance, plate":
            return _isotropic(thickness=3.0, tolerance=tolerance)
        return _crystal(name, value, tolerance)

    return judged(posed, tolerance)


def _isotropic(*, poisson=0.3, quality=math.inf, thickness, tolerance) -> tuple[float, float, bool]:
    """Error, its estimate and whether it kept its tolerance; thickness in wavelengths of shear."""
    import numpy as np

    import fem
    from studies.evidence.stability.lamb import bulk_velocities, plate_wavenumbers, rayleigh_velocity

    solid = fem.isotropic(
        name="isotropic",
        youngs_modulus=YOUNG,
        poisson_ratio=poisson,
        density=DENSITY,
        mechanical_quality=quality,
    )
    longitudinal, shear = bulk_velocities(YOUNG, poisson, DENSITY)
    depth = thickness * shear / FREQUENCY
    bottom = "free" if math.isfinite(thickness) else "absorbing"
    block = fem.Stator(solid=solid, length=1.0, thickness=depth, bottom=bottom, ends="absorbing")
    wave = fem.free_wave(block, frequency=FREQUENCY, tolerance=tolerance)
    omega = 2 * np.pi * FREQUENCY
    if bottom == "absorbing":
        k = omega / rayleigh_velocity(longitudinal, shear) / np.sqrt(1 + 1j / quality)
        error = abs(wave.velocity * k.real / omega - 1)
        found = max(error, abs(wave.attenuation + k.imag) / abs(k))
    else:
        plate = {"longitudinal": longitudinal, "shear": shear, "half_thickness": depth / 2}
        pair = [plate_wavenumbers(omega, **plate, symmetric=each) for each in (True, False)]
        # two modes of nearly one velocity are one surface wave, of the mean wavenumber
        known = np.concatenate([*pair, [(pair[0][-1] + pair[1][-1]) / 2]])
        found = np.min(abs(wave.velocity * known / omega - 1))
    return float(found), wave.relative_error, True


def _crystal(name: str, value: float, tolerance: float) -> tuple[float, float, bool]:
    import fem

    material, orientation = CUTS[int(value)] if name == "cut" else CUTS[0]
    solid = replace(
        fem.rotated(fem.material(material), orientation), mechanical_quality=math.inf, dielectric_loss=0.0
    )
    if name in ("stiffness", "density", "permittivity", "coupling"):
        solid = replace(solid, **{name: getattr(solid, name) * value})
    frequency = value if name == "frequency" else FREQUENCY
    block = fem.Stator(solid=solid, length=1.0, thickness=math.inf, bottom="free", ends="absorbing")
    wave = fem.free_wave(block, frequency=frequency, tolerance=tolerance)
    known = fem.rayleigh(solid, "open")
    error = abs(wave.velocity / known.velocity - 1)
    return float(error), wave.relative_error, True
