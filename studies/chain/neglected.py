"""What the stator's problem is solved without, and why: lines of ``left_out``."""

import fem
from studies.scene import Scene, resolved


def driven_left_out(stator: "fem.Stator", frequency: float) -> tuple[str, ...]:
    """Return what a driven stator is solved without at a frequency in Hz, and why."""
    names, reasons = fem.fields(stator.solid), []
    if "uy" not in names:
        reasons.append("out-of-plane displacement: uncoupled in this orientation")
    if fem.medium(stator.solid, names).parity is not None:
        reasons.append("half of the guided-mode problem: x -> -x is a symmetry of this orientation")
    if stator.above == "none":
        reasons.append("field in the vacuum above: D_n = 0 on the bare surface")
    if stator.thickness * frequency < _surface_speed(stator):
        reasons.append(
            "a Rayleigh wave: the plate is thinner than a wavelength, what is named so is a plate mode"
        )
    reasons.append("elements in the uniform stretches: sums of guided modes instead")
    reasons.append("interior field: only the surface was asked for")
    return tuple(reasons)


def diffraction_left_out(scene: Scene, spreads: bool, reason: str) -> tuple[str, ...]:
    """Return where and why the wave does not spread in the answer of a driven stator."""
    if spreads:
        return _of_the_section(scene)
    if reason:
        return (f"diffraction, the wave is that of the plane section: {reason}",)
    said = "is false" if scene.stator.diffraction is False else "is absent, and the scene has no slider"
    return (f"diffraction, the wave is that of the plane section: stator.diffraction {said}",)


def _of_the_section(scene: Scene) -> tuple[str, ...]:
    where = "the interior field" if scene.driven_obliquely else "surface.csv and the interior field"
    reasons = [f"diffraction in {where}: of the plane section; --field adds surface_map.csv"]
    if scene.burst is not None and scene.slider is not None:
        reasons.append("diffraction in the shape of the burst's ring-up: that of the plane section")
    if scene.crossed:
        reasons.append("what the metal of a transducer scatters of a beam that crosses its own line")
    if scene.stator.ends != "absorbing":
        reasons.append(
            "spreading of what comes back to the transducers: their circuit is that of the plane section"
        )
    elif len(scene.transducer) > 1 and not fem.isotropic_about_normal(resolved.solid(scene.stator)):
        reasons.append("spreading between the transducers: in this cut they receive as in the plane section")
    return tuple(reasons)


def free_left_out(stator: "fem.Stator") -> tuple[str, ...]:
    """Return what the free wave is solved without, and why."""
    names = fem.fields(stator.solid)
    reasons = [
        "electrodes: the scene has no transducer",
        "elements along x: the wave is a mode of the section",
    ]
    if "uy" not in names:
        reasons.append("out-of-plane displacement: uncoupled in this orientation")
    if "phi" not in names:
        reasons.append("electric potential: the solid is not piezoelectric in this orientation")
    return tuple(reasons)


def _surface_speed(stator: "fem.Stator") -> float:
    """Velocity of the half-space's Rayleigh wave, m/s; 0 where the cut has none."""
    try:
        return fem.rayleigh(stator.solid, "open").velocity
    except fem.ConvergenceError:
        return 0.0
