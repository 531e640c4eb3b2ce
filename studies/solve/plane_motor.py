"""A slider that moves in the plane at one level of the drive, as `contact.plane` solves it.

A load that is a number acts against the velocity that the slider has without it; where it rests, against the one with
which larger waves would start it.
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
# Level over the threshold at which the direction of the start is taken: one ball on one wave runs at 1.4 % of the
# surface's speed there, and at 0.7 and 3 % at 1.05 and 1.2
STARTED = 1.1
TOWARDS_X = np.array([1.0, 0.0])  # the direction of a slider that no wave drives


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
        motor = cls.unloaded(driven, level, SHARE * tolerance)
        if not driven.scene.slider.opposes:
            return motor
        free = motor.state().velocity
        return motor.loaded(free if free.any() else _start(driven))

    @classmethod
    def at_threshold(cls, driven: Contact) -> "PlaneMotor":
        """Return the motor at a level of 1 with a load of a number against the motion with which the waves start it."""
        motor = cls.unloaded(driven, 1.0, SHARE)
        return motor.loaded(_start(driven)) if driven.scene.slider.opposes else motor

    @classmethod
    def unloaded(cls, driven: Contact, level: float, tolerance: float) -> "PlaneMotor":
        """Return the motor without a load of a number; ``tolerance``: of the contact."""
        return cls(slider=driven.slider, surface=driven.surface_at(level), scene=driven.scene, tolerance=tolerance)

    def loaded(self, velocity: np.ndarray) -> "PlaneMotor":
        """Return the motor with its load of a number against a velocity (2,)."""
        slider = self.scene.slider
        return replace(self, slider=opposing(self.slider, slider.scalar_load / slider.share, velocity))

    @property
    def waves(self) -> plane.SurfaceWaves:
        """The waves at the contacts."""
        return waves_at(self.surface, self.slider)

    def state(
        self, waves: plane.SurfaceWaves | None = None, slider: contact.Slider | None = None,
        near: plane.PlaneState | None = None, method: str | None = None,
    ):  # fmt: skip
        """Return the steady `contact.plane.PlaneState`, by default at the slider's place and by the scene's method.

        ``near``: a state near it.
        """
        method = method or method_of(self.scene, "the steady state", STEADY_METHODS)
        slider = self.slider if slider is None else slider
        with slider_keys():
            return plane.steady(
                slider, waves_at(self.surface, slider) if waves is None else waves, tolerance=self.tolerance,
                method=method, near=near,
            )  # fmt: skip


def _start(driven: Contact) -> np.ndarray:
    """Return the velocity (2,) of the unloaded slider just above its threshold; +x where no wave drives it."""
    try:
        with slider_keys():
            threshold = plane.threshold_factor(driven.slider, driven.surface_at(1.0))
        if not 0.0 < threshold < math.inf:
            return TOWARDS_X
        velocity = PlaneMotor.unloaded(driven, STARTED * threshold, SHARE).state().velocity
    except contact.ConvergenceError:
        return TOWARDS_X
    return velocity if velocity.any() else TOWARDS_X


def waves_at(surface, slider: contact.Slider, shift: tuple[float, float] = (0.0, 0.0)) -> plane.SurfaceWaves:
    """Return the waves at the contacts of a slider that is shifted by (x, y) in m."""
    return surface.at(np.atleast_1d(slider.x) + shift[0], np.atleast_1d(slider.y) + shift[1])


def contact_speed(slider: contact.Slider, velocity: np.ndarray, yaw_rate: float) -> float:
    """Return the largest speed of a contact over the surface, m/s."""
    x, y = np.atleast_1d(slider.x), np.atleast_1d(slider.y)
    return float(np.hypot(velocity[0] - yaw_rate * y, velocity[1] + yaw_rate * x).max())


def friction_torque(slider: contact.Slider) -> float:
    """Return the torque of contacts that all slip at rest, each across its arm, N m."""
    arms = np.hypot(np.atleast_1d(slider.x) - slider.axis[0], np.atleast_1d(slider.y) - slider.axis[1])
    return float(slider.friction_coefficient * slider.preload * arms.mean())
