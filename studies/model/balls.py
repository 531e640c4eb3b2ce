"""From a scene to balls or flat punches, each with its own place; see `contacts_of`."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import contact
from studies.model.contact_moduli import direction_dependence
from studies.model.model import Model
from studies.model.scene_errors import slider_keys
from studies.scene import Scene
from studies.scene.drive import Wave
from studies.scene.friction import Friction, LawText
from studies.scene.slider_keys import Slider


def slider_of(slider: Slider):
    """Return the ``contact.Slider``; of equal contacts that move alike one of ``slider.share`` equal parts."""
    share = slider.share
    with slider_keys():
        return contact.Slider(
            radius=slider.radius, mass=slider.mass / share, preload=slider.preload_force / share,
            load=slider.scalar_load / share, friction_coefficient=slider.static_coefficient,
            effective_modulus=slider.effective_modulus,
            tangential_modulus=slider.tangential_modulus, law="hysteretic" if slider.remembers else "elastic",
            reciprocal=slider.reciprocal,
            stick_band=slider.stick_band, contact_damping=slider.damping.contact,
            normal_damping=slider.damping.normal / share, tangential_damping=slider.damping.tangential / share,
            shape=slider.shape, heights=slider.heights or (), friction=_friction(slider),
            normal_law=slider.normal_law and contact.UserForce(slider.normal_law.name, slider.normal_law.source),
            adhesion=_adhesion(slider),
        )  # fmt: skip


def prescribed_motion(slider: Slider, wave: Wave) -> tuple:
    """Return the orbits at the balls of a prescribed wave for a normal amplitude of 1 m."""
    return prescribed_orbits(wave) * (slider.computed_contacts if slider.planar else 1)


def prescribed_orbits(wave: Wave) -> tuple:
    """Return the orbit of a prescribed wave for a normal amplitude of 1 m."""
    return _unit_orbits(wave.frequency, wave.tangential_ratio)


@lru_cache(1000)  # of a sweep's points many have the same
def _unit_orbits(frequency: float, tangential_ratio: float) -> tuple:
    return (contact.Orbit(frequency=frequency, normal=1.0, tangential=-1j * tangential_ratio),)


def stator_motion(slider: Slider, stator, solved, motion: Callable[[], Any]) -> tuple:
    """Return the orbits at the balls for 1 V, their misfit of 0, and the amplitudes under the slider's centre.

    In the plane the amplitudes are those under the first ball: a rotor has none at its centre.
    """
    place = slider.contact_positions[0] if slider.planar else slider.center
    return solved.orbits(slider.contact_positions), 0.0, solved.at[place].amplitudes


def _adhesion(slider: Slider):
    """Return the ``contact`` object of an attraction, None for none."""
    if slider.adhesion is None:
        return None
    own = slider.adhesion.arguments(contact.Adhesion)
    return contact.Adhesion(**own | {"contact_angle": math.radians(slider.adhesion.contact_angle)})


def _friction(slider: Slider):
    """Return the ``contact`` object of a friction law other than Coulomb's, None for Coulomb's."""
    law, mu = slider.tangential_law, slider.friction_coefficient
    if isinstance(law, LawText):
        return contact.UserLaw(law.name, law.source)
    if isinstance(mu, Friction):
        return contact.FallingFriction(**mu.arguments(contact.FallingFriction))
    return None


def resolved(slider: Slider) -> Slider:
    """Return the slider: its contacts have no numbers of their own."""
    return slider


def check(scene: Scene) -> None:
    """Refuse a normal law that no contact has, and a roughness that cannot be computed.

    The blocks of the scene refuse contacts beyond the stator.
    """
    if scene.slider.normal_law is not None:
        slider_of(scene.slider)
    if scene.slider.roughness is not None:
        from studies.model.roughness_of_balls import check_roughness

        check_roughness(scene.slider)


def places(slider: Slider) -> list[tuple[str, float, float]]:
    """Return the contacts in words, with their x and y in m."""
    positions = slider.contact_positions
    if len(positions) == 1:
        return [("the contact", *positions[0])]
    return [(f"contact {number}", *position) for number, position in enumerate(positions, start=1)]


def intervals(slider: Slider) -> list[tuple[float, float]]:
    """Return the x of each contact, m."""
    return [(x, x) for x, _ in slider.contact_positions]


def lines(model: Model, weight: str, moduli: str) -> list[str]:
    """Return the contacts in words, after the weight of the slider and the moduli of the pair."""
    scene, slider = model.scene, model.scene.slider
    shape = "radius" if slider.shape == "sphere" else f"{slider.shape} radius"
    told = [f"{weight}, contacts {len(slider.offsets)}, {shape} {slider.radius * 1e3:g} mm, {moduli}"]
    if scene.stator is not None and (spread := direction_dependence(model.solid)):
        told.append(f"E* and G* are means over the directions in the surface: {spread}")
    return told
