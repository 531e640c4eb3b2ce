"""The slider and the wave of the seed paper's simulation."""

import contact
from studies.model.balls import prescribed_orbits
from studies.model.resolve import resolved
from studies.model.wave_to_contact import contact_slider, scaled
from studies.scene import Scene

TOLERANCE = 1e-3  # relative tolerance of steady velocities


class Seed:
    """The paper's slider and wave, and solutions that its figures share; ``steps``: amplitudes of bursts in m."""

    def __init__(self, *, steps: tuple[float, ...] = ()):
        scene = resolved(Scene.load("twente-contact"))
        self.steps = steps
        self.slider = contact_slider(scene.slider)
        self.shape = prescribed_orbits(scene.wave)
        self.levels = scene.levels

    def orbits(self, amplitude: float) -> tuple:
        """Return the wave of a normal amplitude in m."""
        return scaled(self.shape, amplitude)

    def steady(self, amplitude: float):
        """Return the steady state at a normal amplitude in m."""
        return contact.steady(self.slider, self.orbits(amplitude), tolerance=TOLERANCE)

    def history(self, amplitude: float, **span):
        """Return the history of the contact at a normal amplitude in m."""
        return contact.contact_history(self.slider, self.orbits(amplitude), **span)
