"""From the wave to the contact: the surface motion per volt times the voltage is the orbit under each ball.

Both sides use exp(+i omega t), peak amplitudes, x along the surface and z out of it, so nothing changes
sign.  A wave that runs to +x has u_x = +i r u_z; a given [wave] moves its crest towards +x, u_x = -i r u_z.

n contacts that feel one and the same motion behave as one with 1/n of mass, preload, load and viscous
dampers (the Hunt-Crossley coefficient, per contact already, stays): a mere number of contacts is computed
as one.
"""

import fem
from studies.scene import Scene, resolved
from studies.scene.slider import Slider, Wave


def driven_section(scene: Scene, *, tolerance: float, places=(), progress=None):
    """Return the `fem.SurfaceWave` of a scene's driven section; `places` are x in m."""
    return fem.driven_wave(
        resolved.stator(scene.stator),
        resolved.section_row(scene),
        frequency=scene.frequency,
        drive=resolved.drive(scene),
        tolerance=tolerance,
        places=tuple(places),
        progress=progress,
    )


def orbits_per_volt(motion, slider: Slider) -> tuple:
    """Return the contact.Orbit under each ball for 1 V of the source (peak), one for a mere number of contacts.

    ``motion``: a `studies.chain.surface_motion.SurfaceMotion`.
    """
    from contact import Orbit

    tangential, _, normal = motion.at(slider.places)
    return tuple(
        Orbit(frequency=motion.wave.frequency, normal=complex(u_z), tangential=complex(u_x))
        for u_x, u_z in zip(tangential, normal, strict=True)
    )


def wave_along(motion, slider: Slider):
    """Return the orbits under a slider that moves along x, a `studies.chain.travel.WaveAlong`, per volt."""
    from contact import Orbit
    from studies.chain.travel import WaveAlong

    wave, places = motion.wave, slider.places

    def orbits(displacements):
        balls = [motion.along(x + displacements, y) for x, y in places]
        return [
            tuple(
                Orbit(frequency=wave.frequency, normal=complex(each[2, k]), tangential=complex(each[0, k]))
                for each in balls
            )
            for k in range(len(displacements))
        ]

    behind, ahead = min(x for x, _ in places), max(x for x, _ in places)
    return WaveAlong(
        wavelength=wave.phase_velocity / wave.frequency, limits=(-behind, wave.length - ahead), orbits=orbits
    )


def given_orbits(wave: Wave) -> tuple:
    """Return the orbit of a given wave for a normal amplitude of 1 m: a shape, to be scaled."""
    from contact import Orbit

    return (Orbit(frequency=wave.frequency, normal=1.0, tangential=-1j * wave.tangential_ratio),)


def scaled(orbits: tuple, level: float) -> tuple:
    """Return the orbits at a voltage in V, or of a given shape at an amplitude in m."""
    return tuple(orbit.scaled(level) for orbit in orbits)


def contact_slider(slider: Slider):
    """Return the ``contact.Slider`` of a block whose preload and moduli are numbers."""
    import contact

    share = len(slider.offsets) if isinstance(slider.contacts, int) else 1
    return contact.Slider(
        radius=slider.radius,
        mass=slider.mass / share,
        preload=slider.preload / share,
        load=slider.load / share,
        friction_coefficient=slider.friction_coefficient,
        effective_modulus=slider.effective_modulus,
        tangential_modulus=slider.tangential_modulus,
        law=slider.law,
        reciprocal=slider.reciprocal,
        stick_band=slider.stick_band,
        contact_damping=slider.damping.contact,
        normal_damping=slider.damping.normal / share,
        tangential_damping=slider.damping.tangential / share,
        shape=slider.shape,
        heights=slider.heights or (),
    )
