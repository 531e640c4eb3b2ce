"""A slider in the plane over its waves, and the parameters of `reduced_plane` that do not depend on its mean forces."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.export.motor_model import force_exponent
from studies.export.reduced_plane import plane_index as index

TURN_STEPS = 13  # of a rotor: a prime, no part of the pitch of usual rings


@dataclass(frozen=True, kw_only=True)
class Body:
    """A slider over its waves, as elements whose mean forces move it: its contacts, or one of a rotor."""

    slider: contact.Slider  # one of `share` equal parts, without a load
    share: int
    surfaces: tuple[Any, ...] = field(repr=False)  # of each drive for a level of 1: what has ``at(x, y)``

    @property
    def freedom(self) -> str:
        """Freedom of the slider."""
        return self.slider.freedom

    @property
    def arm(self) -> float:
        """Largest distance of a contact from the axle, m; 1 m where all stand on it."""
        x, y = (np.atleast_1d(getattr(self.slider, name)) - self.slider.axis[k] for k, name in enumerate("xy"))
        return float(np.hypot(x, y).max()) or 1.0

    @property
    def places(self) -> list[tuple[float, float]]:
        """Places of the elements from the centre, or from the axle, m."""
        slider = self.slider
        if self.freedom == "axle":
            return [(0.0, -self.arm)]
        n = slider.count
        return list(zip(*(np.broadcast_to(each, n).tolist() for each in (slider.x, slider.y)), strict=True))

    def turned(self) -> list[contact.Slider]:
        """Return the slider at the yaws over which forces are averaged."""
        count = TURN_STEPS if self.freedom == "axle" else 1
        return [plane.turned(self.slider, 2.0 * np.pi * k / count) for k in range(count)]

    def waves(self, slider: contact.Slider) -> list[plane.SurfaceWaves]:
        """Return the waves of each drive under a slider, for a level of 1."""
        return [each.at(np.atleast_1d(slider.x), np.atleast_1d(slider.y)) for each in self.surfaces]

    def waves_at(self, levels: np.ndarray) -> plane.SurfaceWaves:
        """Return the waves of all drives together under the slider at their levels, of which one is not 0."""
        driven = [(each, level) for each, level in zip(self.waves(self.slider), levels, strict=True) if level > 0.0]
        return plane.SurfaceWaves(
            frequencies=np.concatenate([each.frequencies for each, _ in driven]),
            amplitudes=np.concatenate([each.scaled(level).amplitudes for each, level in driven]),
        )

    def amplitudes(self) -> list[float]:
        """Return the largest |u_z| of each drive under the contacts for a level of 1, m."""
        several = [[float(abs(each.amplitudes[..., 2]).max()) for each in self.waves(one)] for one in self.turned()]
        return [max(column) for column in zip(*several, strict=True)]

    @property
    def rest_approach(self) -> float:
        """Approach under the preload without a wave, h in m."""
        return float((self.slider.preload / self.stiffness) ** (1.0 / force_exponent(self.slider)))

    @property
    def stiffness(self) -> float:
        """K of all contacts, N/m^e."""
        return float(np.broadcast_to(self.slider.normal_stiffness, self.slider.count).sum())


def common_parameters(
    body: Body, amplitudes: list[float], elements: int, *, creep: float, steps: tuple[float, float], rise: float
) -> np.ndarray:
    """Return the parameters of body, drives and integration; ``steps``: the longest and the fast one, s."""
    slider = body.slider
    p = np.zeros(index.FIRST_ELEMENT + elements * index.ELEMENT_SIZE)
    turns, moves = body.freedom in ("xy yaw", "axle"), body.freedom in ("xy", "xy yaw")
    p[index.MASS], p[index.INERTIA] = slider.mass * body.share, slider.inertia if turns else 1.0
    p[index.DAMPING], p[index.YAW_DAMPING] = slider.tangential_damping * body.share, slider.yaw_damping
    p[index.FRICTION], p[index.STIFFNESS] = slider.friction_coefficient, body.stiffness * body.share
    p[index.EXPONENT] = force_exponent(slider)
    p[index.MOVES], p[index.TURNS], p[index.ARMS_TURN] = moves, turns, body.freedom == "xy yaw"
    p[index.ELEMENTS], p[index.DRIVES], p[index.CREEP] = elements, len(body.surfaces), creep
    (p[index.MAX_STEP], p[index.FAST_STEP]), p[index.RISE] = steps, rise
    p[index.AMPLITUDE : index.AMPLITUDE + len(amplitudes)] = amplitudes
    return p
