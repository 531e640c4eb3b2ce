"""A slider that moves in the plane, and the waves below it, as objects of ``contact``.

A prescribed wave whose crests move the slider in a direction runs against it, as a Rayleigh wave does. Places of
`StatorSurface.at` are those of `contact.plane`: in the axes of the stator, from where the slider's centre starts.
"""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.scene.drive import Wave
from studies.scene.slider_keys import Slider

SOME_LENGTH = 1.0  # m: wavelength of prescribed waves under contacts that are all at one place


@lru_cache(10_000)  # of a sweep's points many have the same
def plane_slider(slider: Slider) -> contact.Slider:
    """Return the ``contact.Slider`` of a resolved block whose slider moves in the plane, without a scalar load.

    Of contacts that are all at the centre it is one of ``slider.share`` equal parts.
    """
    share = slider.share
    places = np.array(slider.offsets if share == 1 else slider.offsets[:1])
    force = contact_load(slider)
    return contact.Slider(
        radius=slider.radius, x=places[:, 0], y=places[:, 1], heights=slider.heights or 0.0,
        mass=slider.mass / share, preload=slider.preload_force / share, load=(force[0] / share, force[1] / share),
        friction_coefficient=slider.static_coefficient, effective_modulus=slider.effective_modulus,
        tangential_modulus=slider.tangential_modulus, law="elastic", reciprocal=slider.reciprocal, stick_band=0.0,
        contact_damping=slider.damping.contact, normal_damping=slider.damping.normal / share,
        tangential_damping=slider.damping.tangential / share, shape=slider.shape, tilt=slider.tilt,
        freedom=slider.freedom, axis=slider.axis or (0.0, 0.0),
        inertia=inertia(slider) if slider.turns else None, torque=slider.torque,
        normal_law=slider.normal_law and contact.UserForce(slider.normal_law.name, slider.normal_law.source),
    )  # fmt: skip


def inertia(slider: Slider) -> float:
    """Return the moment of inertia in kg m2 about centre or axle; by default that of the mass at the contacts."""
    if slider.inertia is not None:
        return slider.inertia
    x, y = slider.axis or (0.0, 0.0)
    squares = [(a - x) ** 2 + (b - y) ** 2 for a, b in slider.offsets]
    return slider.mass * sum(squares) / len(squares)


def contact_load(slider: Slider) -> tuple[float, float]:
    """Return the force in N against +x and +y: a load that is a vector, and the weight on an inclined surface."""
    x, y = slider.load if isinstance(slider.load, tuple) else (0.0, 0.0)
    slopes = slider.incline or (0.0, 0.0)
    along, across = (slider.mass * slider.gravity * math.sin(math.radians(each)) for each in slopes)
    return x + along, y + across


def opposing(slider: contact.Slider, load: float, velocity: np.ndarray) -> contact.Slider:
    """Return the slider with a further load of a size in N against a velocity (2,)."""
    speed = math.hypot(*velocity)
    if load == 0.0 or speed == 0.0:
        return slider
    x, y = (own + load * float(each) / speed for own, each in zip(slider.load, velocity, strict=True))
    return replace(slider, load=(x, y))


def rotated(x: np.ndarray, y: np.ndarray, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Return positions after a turn by ``yaw`` (rad) about the origin."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * x - sin * y, sin * x + cos * y


def prescribed_surface(wave: Wave) -> plane.PlaneWaves:
    """Return the prescribed waves for a normal amplitude of 1 m of the first one."""
    if not wave.sources:
        return plane.PlaneWaves(waves=(_plane_wave(wave, 1.0, wave.tangential_ratio, 0.0, wave.frequency),))
    first = wave.sources[0].normal_amplitude or 1.0
    waves = [
        _plane_wave(
            wave,
            (each.normal_amplitude or 1.0) / first * cmath.rect(1.0, math.radians(each.phase)),
            each.tangential_ratio or wave.tangential_ratio,
            each.direction,
            each.frequency or wave.frequency,
        )
        for each in wave.sources
    ]
    return plane.PlaneWaves(waves=tuple(waves))


def _plane_wave(wave: Wave, normal: complex, ratio: float, drives: float, frequency: float) -> plane.PlaneWave:
    """Return the wave that moves the slider in a direction in degrees; the velocity of all waves is the same."""
    length = (wave.wavelength or SOME_LENGTH) * wave.frequency / frequency
    return plane.PlaneWave(
        frequency=frequency, wavelength=length, direction=math.radians(drives + 180.0), normal=normal, ratio=ratio
    )


@dataclass(frozen=True, kw_only=True)
class StatorSurface:
    """The motion of a stator's surface about a slider, for a level of 1 V."""

    center: tuple[float, float]  # of the slider, (x, y) in m on the stator
    frequencies: tuple[float, ...]  # Hz
    # of each frequency: returns what has ``at(positions)``, u_x, u_y and u_z per volt, (3, positions)
    motions: tuple[Callable[[], Any], ...]

    def at(self, x: np.ndarray, y: np.ndarray) -> plane.SurfaceWaves:
        """Return the waves at places in m from the slider's first place."""
        a, b = self.center
        places = [(float(each + a), float(other + b)) for each, other in zip(x, y, strict=True)]
        amplitudes = [motion().at(places).T for motion in self.motions]
        return plane.SurfaceWaves(frequencies=self.frequencies, amplitudes=np.array(amplitudes))

    def beams(self, x: np.ndarray, y: np.ndarray) -> list[tuple[int, np.ndarray]]:
        """Return (number of the frequency, amplitudes (n, 3)) of each beam that crosses another of its frequency."""
        a, b = self.center
        places = [(float(each + a), float(other + b)) for each, other in zip(x, y, strict=True)]
        found = []
        for number, motion in enumerate(self.motions):
            beams = motion().beams_at(places)
            found += [(number, each.T) for each in beams[1:]]  # the phase of the first one is that of all
        return found


@dataclass(frozen=True, kw_only=True)
class Sum:
    """The sum of several surface motions, each times a factor."""

    parts: tuple[tuple[Any, float], ...]  # what has ``at(x, y)``, and its factor

    def at_rest(self) -> "Sum":
        """Return the surface without a drive."""
        return Sum(parts=tuple((surface, 0.0) for surface, _ in self.parts))

    def at(self, x: np.ndarray, y: np.ndarray) -> plane.SurfaceWaves:
        """Return the waves at places in m from the slider's first place; those of one frequency are added."""
        together: dict[float, Any] = {}
        for surface, factor in self.parts:
            waves = surface.at(x, y)
            for frequency, amplitudes in zip(waves.frequencies, waves.amplitudes, strict=True):
                together[frequency] = together.get(frequency, 0.0) + factor * amplitudes
        return plane.SurfaceWaves(frequencies=list(together), amplitudes=np.array(list(together.values())))
