"""Words that people write for a key of a scene, and the key that they mean."""

SYNONYMS = {
    "amplitude": ("normal_amplitude", "voltage"),
    "angle": ("orientation",),
    "balls": ("contacts", "ball"),
    "cut": ("orientation",),
    "damper": ("damping",),
    "duty": ("metallisation",),
    "e": ("effective_modulus", "youngs_modulus"),
    "electrode": ("transducer",),
    "f": ("frequency",),
    "fingers": ("finger_pairs",),
    "finger": ("finger_pairs",),
    "force": ("preload", "load"),
    "friction": ("friction_coefficient",),
    "g": ("gravity", "tangential_modulus"),
    "height": ("thickness",),
    "hertz": ("effective_modulus",),
    "idt": ("transducer",),
    "impedance": ("source_impedance", "termination"),
    "metal": ("metallisation",),
    "metalli": ("metallisation",),
    "mu": ("friction_coefficient",),
    "mue": ("friction_coefficient",),
    "nu": ("poisson_ratio",),
    "overlap": ("aperture",),
    "pairs": ("finger_pairs",),
    "pitch": ("period",),
    "poisson": ("poisson_ratio",),
    "poling": ("orientation",),
    "q": ("mechanical_quality",),
    "quality": ("mechanical_quality",),
    "rho": ("density",),
    "rotor": ("slider",),
    "substrate": ("stator", "material"),
    "tan_delta": ("dielectric_loss",),
    "tangential_amplitude": ("tangential_ratio",),
    "wavelength": ("period",),
    "weight": ("mass", "preload"),
    "youngs": ("youngs_modulus",),
}


def meant(word: str, known) -> str | None:
    """Return the known key that a word stands for, or None.

    Examples
    --------
    >>> meant("metallized", ["method", "metallisation"]), meant("mu", ["friction_coefficient"])
    ('metallisation', 'friction_coefficient')
    """
    lowered = str(word).lower()
    for start in sorted(SYNONYMS, key=len, reverse=True):
        if lowered == start or (len(start) > 4 and lowered.startswith(start)):
            for key in SYNONYMS[start]:
                if key in known:
                    return key
    return None
