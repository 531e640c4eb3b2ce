"""Words that users write instead of a key of a scene, and the keys that they may stand for."""

TABLE = """
amplitude: normal_amplitude voltage; angle cut poling: orientation; balls: contacts ball;
damper: damping; duty metal metalli: metallisation; e: effective_modulus youngs_modulus;
electrode idt: transducer; f: frequency; fingers finger pairs: finger_pairs; force: preload load;
friction mu mue: friction_coefficient; g: gravity tangential_modulus; height: thickness;
hertz: effective_modulus; impedance: source_impedance termination; nu poisson: poisson_ratio;
overlap: aperture; pitch wavelength: period; q quality: mechanical_quality; rho: density; rotor: slider;
substrate: stator material; tan_delta: dielectric_loss; tangential_amplitude: tangential_ratio;
weight: mass preload; youngs: youngs_modulus
"""
SYNONYMS = {
    word: keys.split() for words, keys in (each.split(":") for each in TABLE.split(";")) for word in words.split()
}


def key_for(word: str, known) -> str | None:
    """Return the known key that a word stands for, or None.

    Examples
    --------
    >>> key_for("metallized", ["method", "metallisation"]), key_for("mu", ["friction_coefficient"])
    ('metallisation', 'friction_coefficient')
    """
    lowered = str(word).lower()
    for start in sorted(SYNONYMS, key=len, reverse=True):
        if lowered == start or (len(start) > 4 and lowered.startswith(start)):
            for key in SYNONYMS[start]:
                if key in known:
                    return key
    return None
