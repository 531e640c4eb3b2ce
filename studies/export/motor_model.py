"""The averaged motor: a slider moved by the cycle means of the contact forces, and its state over time."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import contact
from studies.export import reduced_motor as model
from studies.export.reduced_motor import index
from studies.refusal import RunError, refuse_if
from studies.scene import Scene

RING_NODES = 24  # of the energy of a ring; 1e-5 of the velocity
RESPONSE_STEP = 2.5e-7  # s; half of the cycle at 2 MHz


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A drive in one direction: a transducer at 1 V of its source, or a prescribed wave of 1 m."""

    name: str  # of the transducer; "wave"
    orbits: tuple = field(repr=False)  # contact.Orbit of each contact for a level of 1
    # step response of the surface under the slider over its steady motion, every `response_step`; None: immediate
    response: np.ndarray | None = field(default=None, repr=False)
    response_step: float = RESPONSE_STEP  # s
    settling: float = 0.0  # s to within 1 %
    power: float = 0.0  # into the transducer, W per V^2
    warmth: float = 0.0  # steady mean rise of the stator, K per V^2
    thermal_time: float = 0.0  # s, of that rise; 0: the temperature is not known
    error: float = 0.0  # relative, of the orbits
    mirrored: bool = False  # mirror image of the first drive; the two share tables

    @property
    def amplitude(self) -> float:
        """Largest |u_z| of the contacts for a level of 1, m."""
        return max(abs(orbit.normal) for orbit in self.orbits)

    def saturation(self, slider) -> float:
        """Return v_1: from the slider velocity v_1 |u_z| on, friction has one direction throughout the cycle."""
        fastest = max(abs(each.tangential) + slider.limit_slope * abs(each.normal) for each in self.orbits)
        return self.orbits[0].omega * fastest / self.amplitude


@dataclass(frozen=True, kw_only=True)
class OfScene:
    """An averaged motor as the flat arrays of its equations, and the scene from which it was made."""

    scene: Scene = field(repr=False)  # as resolved
    parameters: np.ndarray = field(repr=False)
    tables: np.ndarray = field(repr=False)

    @property
    def title(self) -> str:
        """Of the scene."""
        return self.scene.title or "untitled"

    @property
    def unit(self) -> str:
        """Unit of the levels: V, or m for prescribed waves."""
        return "V" if self.scene.wave is None else "m"


@dataclass(frozen=True, kw_only=True)
class AveragedMotor(OfScene):
    """A motor whose slider follows the cycle means of the contact forces, for exports and the position loop."""

    # for the contact's solvers: one ball if all balls have the same motion
    slider: contact.Slider = field(repr=False)
    share: int  # forces on the real slider over those on ``slider``
    drives: tuple[Drive, ...]  # of positive levels, and if there are two, of negative levels
    levels: tuple[float, ...]  # of the scene, rising
    # Error of the mean tangential force over mu preload at random points of the tables: largest (at kinks), and 99 %
    # quantile
    interpolation_error: tuple[float, float]
    # Largest change of the steady velocity over the scene's levels, relative to max(|v|, omega |u_x|/10): by
    # second-order averaging, and by the interpolation
    averaging_error: float
    velocity_error: float
    left_out: tuple[str, ...]  # neglected effects, with their size if it is known
    law: Any = field(default=None, repr=False)  # `law_contact.LawContact` of tables with depths

    @property
    def preload(self) -> float:
        """Preload of the real slider, N."""
        return self.slider.preload * self.share

    @property
    def load(self) -> float:
        """Load of the scene as a force along +x on the real slider, N: against the first drive's motion."""
        return -float(np.copysign(self.slider.load, self.direction)) * self.share + 0.0

    @property
    def direction(self) -> float:
        """Mean force in N of the largest wave along +x on a slider at rest without a load, whose sign counts."""
        if self.parameters[index.DEPTHS] < 0.5:
            return push(self.slider, self.orbits_at(self.levels[-1]))
        size, p, tables = self.levels[-1] * self.drives[0].amplitude, self.parameters, self.tables
        height = model.steady_approach(p, tables, 0, size, self.slider.preload, 0)
        load = model.mean_load(p, tables, 0, height, size)
        return sum(model.friction_force(p, tables, 0, height, size, load, side, 0.0) for side in (0, 1))

    @property
    def slip_deformation(self) -> float:
        """Tangential deformation of the contacts at which they slip on a surface at rest, m."""
        return self.slider.limit_slope * model.rest_approach(self.parameters, self.tables, self._repulsion)

    @property
    def ring_speed(self) -> float:
        """Largest velocity in m/s of the tangential ringing of a slider that sticks on a surface at rest.

        The energy stored in the contacts at the limit of slip, the integral of their spring's force, becomes kinetic
        energy m v^2/2.
        """
        point, weight = np.polynomial.legendre.leggauss(RING_NODES)
        depth = model.rest_approach(self.parameters, self.tables, self._repulsion)
        shares = [model.spring_share(self.parameters, self.tables, 0.5 * (1.0 + u), depth) for u in point]
        force = self.slider.friction_coefficient * self._repulsion * 0.5 * float(weight @ shares)
        return float(np.sqrt(2.0 * force * self.slip_deformation / self.slider.mass))

    @property
    def _repulsion(self) -> float:
        """Repulsion of the contacts under the preload without a wave, which friction feels, N."""
        p, tables, preload = self.parameters, self.tables, self.slider.preload
        height = model.steady_approach(p, tables, 0, 0.0, preload, 0)
        return model.steady_load(p, tables, 0, height, 0.0, preload)

    def orbits_at(self, level: float) -> tuple:
        """Return the contacts' orbits at a level of the first drive."""
        return tuple(orbit.scaled(level) for orbit in self.drives[0].orbits)

    def start(self, *, force: float = 0.0, preload: float | None = None) -> "MotorState":
        """Return the motor at rest; forces in N are those of the real slider."""
        state = np.zeros(index.STATE_SIZE)
        preload = self.preload if preload is None else preload
        model.begin(self.parameters, self.tables, state, preload / self.share, force / self.share)
        return MotorState(motor=self, numbers=state)


@dataclass(frozen=True, kw_only=True)
class MotorState:
    """State of a motor; `advance` changes it in place."""

    motor: AveragedMotor = field(repr=False)
    numbers: np.ndarray = field(repr=False)

    def advance(self, duration: float, level: float, *, force: float = 0.0, preload: float | None = None) -> None:
        """Advance by a duration in s under constant inputs.

        Parameters
        ----------
        level : float
            Of the drive, V or m; negative for the second drive.
        force : float
            External, along +x, N.
        preload : float, optional
            N, positive; the scene's when absent.

        Raises
        ------
        SceneError
            For a negative level without a second drive, or a preload that is not positive.
        RunError
            If the motion is not finite.
        """
        motor = self.motor
        refuse_if(
            level < 0.0 and len(motor.drives) == 1,
            "level",
            f"must be zero or positive: nothing drives the other way, got {level!r}",
        )
        preload = motor.preload if preload is None else preload
        refuse_preload(preload)
        inputs = float(level), force / motor.share, preload / motor.share, float(duration)
        if model.advance(motor.parameters, motor.tables, self.numbers, *inputs):
            raise RunError("the averaged motion is not finite: check level, force and preload")

    time = property(lambda self: float(self.numbers[index.TIME]))
    position = property(lambda self: float(self.numbers[index.POSITION]))
    velocity = property(lambda self: float(self.numbers[index.VELOCITY]))
    deformation = property(lambda self: model.deformation(self.motor.parameters, self.motor.tables, self.numbers))
    surface_amplitude = property(lambda self: float(self.numbers[index.SURFACE]))
    temperature_rise = property(lambda self: float(self.numbers[index.TEMPERATURE]))
    sticks = property(lambda self: bool(self.numbers[index.STICKS]))

    def copy(self) -> "MotorState":
        """Return an independent copy."""
        return replace(self, numbers=self.numbers.copy())


def refuse_preload(preload: float) -> None:
    """Raise a SceneError for a preload in N that is not positive."""
    refuse_if(not preload > 0.0, "preload", f"must be positive, got {preload!r} N")


def force_exponent(slider: contact.Slider) -> float:
    """Return the exponent e of the normal force over the approach: 3/2 of spheres, 1 of flat punches."""
    return 1.5 if slider.shape == "sphere" else 1.0


def push(slider: contact.Slider, orbits: tuple) -> float:
    """Return the mean force of the wave along +x on a slider at rest without a load, N."""
    return float(contact.mean_traction(replace(slider, load=0.0), orbits, np.zeros(1))[0])
