"""Extreme cases of the free wave in a section without transducers, compared with partial waves.

Half-spaces are compared with the surface impedance method of fem.analytic.half_space, which needs no mesh. Plates are
compared with Lamb's equations in `tests/validation`. If all moduli have the same loss factor, the wavenumber is the
lossless one over sqrt(1 + i / Q).
"""

import math
from dataclasses import replace

import numpy as np

import fem
from studies.evidence.stability.verdict import Case, Comparison

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
    "Poisson's ratio": ("", NEAR_HALF),
    "stiffness": ("times", (1e-6, 1e-3, 1e3, 1e6)),
    "density": ("times", (1e-3, 1e3)),
    "permittivity": ("times", (1e-3, 1e-1, 1e1, 1e3)),
    "coupling": ("times", (1e-9, 1e-3, 3.0, 10.0)),
    "frequency": ("Hz", (1e-3, 1e3, 1e9, 1e13)),
    "mechanical quality": ("", (2.0, 5.0, 20.0, 1e3, 1e9)),
    "cut": ("", tuple(range(len(CUTS)))),
    "tolerance, half-space": ("", (1e-1, 1e-3, 1e-5, 1e-6, 1e-8, 1e-12)),
}
TOLERANCE = 1e-4
YOUNG, DENSITY = 70e9, 2700.0


def compared(case: Case, tolerance: float) -> Comparison:
    """Return error, estimate and status of a case."""
    if case.varied.startswith("Poisson"):
        return _isotropic(tolerance, poisson=case.value)
    if case.varied == "mechanical quality":
        return _isotropic(tolerance, quality=case.value)
    return _crystal(case.varied, case.value, tolerance)


def _isotropic(tolerance: float, *, poisson: float = 0.3, quality: float = math.inf) -> Comparison:
    """Compare an isotropic half-space."""
    solid = fem.isotropic(
        name="isotropic", youngs_modulus=YOUNG, poisson_ratio=poisson, density=DENSITY, mechanical_quality=quality
    )  # fmt: skip
    block = fem.Stator(solid=solid, length=1.0, thickness=math.inf, bottom="absorbing", ends="absorbing")
    wave = fem.free_wave(block, frequency=FREQUENCY, tolerance=tolerance)
    lossless = fem.rayleigh(replace(solid, mechanical_quality=math.inf), "open").velocity
    k = 2 * np.pi * FREQUENCY / lossless / np.sqrt(1 + 1j / quality)
    error = abs(wave.velocity * k.real / (2 * np.pi * FREQUENCY) - 1)
    return float(max(error, abs(wave.attenuation + k.imag) / abs(k))), wave.relative_error, True


def _crystal(name: str, value: float, tolerance: float) -> Comparison:
    material, orientation = CUTS[int(value)] if name == "cut" else CUTS[0]
    solid = replace(fem.rotated(fem.material(material), orientation), mechanical_quality=math.inf, dielectric_loss=0.0)
    if name in ("stiffness", "density", "permittivity", "coupling"):
        solid = replace(solid, **{name: getattr(solid, name) * value})
    frequency = value if name == "frequency" else FREQUENCY
    block = fem.Stator(solid=solid, length=1.0, thickness=math.inf, bottom="free", ends="absorbing")
    wave = fem.free_wave(block, frequency=frequency, tolerance=tolerance)
    error = abs(wave.velocity / fem.rayleigh(solid, "open").velocity - 1)
    return float(error), wave.relative_error, True
