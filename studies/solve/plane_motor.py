"""A slider that moves in the plane at one level of the drive, as `contact.plane` solves it.

A load that is a number acts against the velocity that the slider has without it.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.model.plane import opposing
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact
from studies.scene import Scene
from studies.solve.refinement import SHARE
from studies.solve.slider_burst import STEADY_METHODS, method_of

PER_MINUTE = 60.0 / (2.0 * math.pi)  # turns per minute of 1 rad/s


@dataclass(frozen=True, kw_only=True)
class PlaneMotor:
    """A slider in the plane at one level of the drive."""

    slider: contact.Slider  # one of `share` equal parts, with the load of a number
    surface: Any  # what has ``at(x, y)``
    scene: Scene
    tolerance: float  # of the contact

    @classmethod
    def of(cls, driven: Contact, level: float, tolerance: float) -> "PlaneMotor":
        """Return the motor of a contact; ``tolerance``: of the velocity over its reference speed."""
        motor = cls(
            slider=driven.slider, surface=driven.surface_at(level), scene=driven.scene, tolerance=SHARE * tolerance
        )
        load = driven.scene.slider.load
        if isinstance(load, tuple) or load == 0.0:
            return motor
        free = motor.state()
        return replace(motor, slider=opposing(motor.slider, load / driven.scene.slider.share, free.velocity))

    @property
    def waves(self) -> plane.SurfaceWaves:
        """The waves at the contacts."""
        return waves_at(self.surface, self.slider)

    def state(self, waves: plane.SurfaceWaves | None = None, slider: contact.Slider | None = None):
        """Return the steady `contact.plane.PlaneState`, by default at the slider's place."""
        method = method_of(self.scene, "the steady state", STEADY_METHODS)
        slider = self.slider if slider is None else slider
        with slider_keys():
            return plane.steady(
                slider, waves_at(self.surface, slider) if waves is None else waves, tolerance=self.tolerance,
                method=method,
            )  # fmt: skip


def waves_at(surface, slider: contact.Slider, shift: tuple[float, float] = (0.0, 0.0)) -> plane.SurfaceWaves:
    """Return the waves at the contacts of a slider that is shifted by (x, y) in m."""
    return surface.at(np.atleast_1d(slider.x) + shift[0], np.atleast_1d(slider.y) + shift[1])


def contact_speed(slider: contact.Slider, velocity: np.ndarray, yaw_rate: float) -> float:
    """Return the largest speed of a contact over the surface, m/s."""
    x, y = np.atleast_1d(slider.x), np.atleast_1d(slider.y)
    return float(np.hypot(velocity[0] - yaw_rate * y, velocity[1] + yaw_rate * x).max())
