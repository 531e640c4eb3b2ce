"""What the model does not know, for a scene: said with every report."""

from studies.scene import Scene

__all__ = ["model_limits"]


def model_limits(scene: Scene) -> tuple[str, ...]:
    """Return the limits of the model that bear on a scene, a sentence each."""
    limits = []
    if scene.stator is not None:
        limits += [
            "The beam is that of an endlessly wide stator, or of mirrors at its sides: no lateral modes of the width."
            if scene.stator.diffraction
            else "The section is two-dimensional: no beam spreading, no edges of the aperture, no lateral modes of the "
            "width.",
            "Linear piezoelectricity: no heating, no depoling, no change of the constants with the drive.",
            "The material's constants are taken as exact; sets of one material differ between authors by more than "
            "the numerical errors here.",
        ]
    if scene.transducer:
        limits.append(
            "Electrodes have no mass, no stiffness and no resistance; edges are straight and exact."
        )
    if scene.slider is not None:
        limits += [
            "The balls are rigid but for the contact (the first mode of a 1 mm steel ball lies above 1 MHz) and their "
            "centres move along x and z alone: no rolling, no tilt.",
            "One friction coefficient; dry, clean, smooth and wear-free contact; no adhesion, no air film.",
            "The slider's load on the wave (damping, scattering) is not fed back.",
        ]
    if (
        scene.slider is not None
        and scene.stator is not None
        and (scene.burst is None or scene.slider.travel is False)
    ):
        limits.append(
            "The amplitude is that at the slider's position, however far the slider travels along the attenuating, "
            "rippled field."
        )
    if scene.wave is not None:
        limits.append("The surface motion is given: that a transducer can make it is not asked.")
    return tuple(limits)
