"""Scenes drawn at random from what users may ask for: materials, cuts, sizes, ends, combs, sliders and amplitudes.

Drives are set by a first, rough answer: some of the levels lie near the threshold, where an error of the surface
motion grows most on its way to the velocity, others far above it.
"""

import math

import numpy as np

from studies.refusal import RunError, SceneError
from studies.scene import Scene

__all__ = ["LEVELS", "TOLERANCES", "drawn", "levelled"]

CUTS = (
    ("PZT-8", "Z"),
    ("PZT-8", "X"),
    ("PZT-4", "Z"),
    ("PZT-5H", "Z"),
    ("PIC181", "Z"),
    ("LiNbO3 (Kovacs)", "128YX"),
    ("LiNbO3 (Warner)", "YZ"),
    ("quartz (Bechmann)", "ST-X"),
)
BOTTOMS = ("free", "grounded", "clamped", "absorbing")
SLOW = ("PZT-5H", "LiNbO3 (Kovacs)", "quartz (Bechmann)")  # absorbing bottoms here: minutes for a converged answer
KINDS = (("motor", 0.6), ("wave", 0.75), ("contact", 0.92), ("free", 1.0))  # cumulative shares
TOLERANCES = (3e-2, 1e-2, 1e-2, 3e-3, 3e-3, 1e-3)
LEVELS = (0.7, 1.15, 1.6, 4.0, 9.0)  # of the threshold
ROUGH = 0.1


def drawn(seed: int, index: int) -> tuple[Scene, str, float]:
    """Return the scene of a number, its kind and a tolerance.

    Parameters
    ----------
    seed, index : int
        The same give the same scene.

    Raises
    ------
    SceneError, RunError
        If what was drawn is refused.
    """
    rng = np.random.default_rng([seed, index])
    share = rng.uniform()
    kind = next(name for name, upto in KINDS if share <= upto)
    tolerance = float(rng.choice(TOLERANCES))
    if kind == "contact":
        return levelled(Scene.from_table("", _given(rng))), kind, tolerance
    table = _block(rng)
    place = table.pop("place")
    if kind == "free":
        del table["transducer"]
        table["drive"] = {"frequency": table["drive"]["frequency"]}
        return Scene.from_table("", table), kind, tolerance
    if kind == "motor":
        table["slider"] = _slider(rng, table["drive"]["frequency"])
        table["slider"]["position"] = place
        return levelled(Scene.from_table("", table)), kind, tolerance
    return Scene.from_table("", table), kind, tolerance


def _log(rng, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _block(rng) -> dict:
    """Return stator, transducers and drive; ``place`` is where a slider may stand."""
    import fem

    material, cut = CUTS[rng.integers(len(CUTS))]
    frequency = _log(rng, 0.5e6, 50e6)
    speed = fem.rayleigh(fem.rotated(fem.material(material), cut), "open").velocity
    wavelength = speed / frequency
    pairs = int(rng.integers(2, 13))
    gap, free = rng.uniform(2, 8), rng.uniform(12, 60)  # wavelengths: beside the combs, between them
    both = rng.uniform() < 0.5
    length = 2 * gap + pairs + free + (pairs if both else 0.0)
    centre = gap + pairs / 2
    comb = {
        "name": "left",
        "center": centre * wavelength,
        "finger_pairs": pairs,
        "period": wavelength * rng.uniform(0.97, 1.03),
        "metallisation": rng.uniform(0.3, 0.7),
        "aperture": 20 * wavelength,
    }
    combs = [comb]
    if both:
        loads = ("open", "short", "50 ohm")
        other = {"name": "right", "center": (length - centre) * wavelength}
        combs.append(comb | other | {"termination": loads[rng.integers(3)]})
    thickness = "half-space" if rng.uniform() < 0.2 else rng.uniform(1.2, 2.5) * wavelength
    bottom = "free" if thickness == "half-space" else str(rng.choice(BOTTOMS))
    if material in SLOW and (thickness == "half-space" or bottom == "absorbing"):
        thickness, bottom = 2.0 * wavelength, "free"
    return {
        "stator": {
            "material": material,
            "orientation": cut,
            "length": length * wavelength,
            "thickness": thickness,
            "width": 30 * wavelength,
            "ends": str(rng.choice(["absorbing", "absorbing", "absorbing", "free", "free", "clamped"])),
            "bottom": bottom,
            "above": str(rng.choice(["none", "none", "vacuum"])),
        },
        "transducer": combs,
        "drive": {
            "frequency": frequency,
            "transducer": "left",
            "voltage": [10.0],
            "source_impedance": float(rng.choice([0.0, 50.0])),
        },
        "place": (2 * gap + pairs + free * rng.uniform(0.2, 0.8)) * wavelength
        if not both
        else (gap + pairs + free * rng.uniform(0.2, 0.8)) * wavelength,
    }


def _slider(rng, frequency: float) -> dict:
    """Return a slider whose contact resonates well below the wave, as in a SAW motor."""
    return {
        "radius": _log(rng, 0.3e-3, 3e-3),
        "mass": _log(rng, 0.03e-3, 3e-3) * min(1.0, 10e6 / frequency),
        "preload": _log(rng, 0.1e-3, 30e-3),
        "contacts": int(rng.choice([1, 1, 3])),
        "friction_coefficient": _log(rng, 0.04, 0.5),
        "effective_modulus": _log(rng, 30e9, 120e9),
        "tangential_modulus": _log(rng, 8e9, 40e9),
        "damping": {"normal": _log(rng, 0.1, 2.0), "tangential": _log(rng, 1e-5, 1e-3)},
    }


def _given(rng) -> dict:
    frequency = _log(rng, 0.5e6, 50e6)
    return {
        "wave": {"frequency": frequency, "normal_amplitude": [1e-9], "tangential_ratio": rng.uniform(0.4, 1.2)},
        "slider": _slider(rng, frequency) | {"method": "averaged"},
    }


def levelled(scene: Scene) -> Scene:
    """Return the scene with levels about its threshold."""
    from studies.runs import run

    rough = run(scene, tolerance=ROUGH)
    given = scene.wave is not None
    threshold = rough.summary.get("threshold_amplitude_m" if given else "threshold_voltage_V")
    if threshold is None:
        raise RunError("the slider never moves")
    levels = [float(threshold * level) for level in LEVELS]
    table = scene.to_table()
    if given:
        table["wave"]["normal_amplitude"] = levels
    else:
        table["drive"]["voltage"] = levels
    try:
        return Scene.from_table("", table)
    except SceneError as error:
        raise RunError(str(error)) from None
