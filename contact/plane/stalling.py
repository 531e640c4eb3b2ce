r"""Loads that stop a slider in the plane.

Across the wave there is no threshold: a slider that slips along x yields to any force along y. Stall along a direction
d is therefore the load F d at which the velocity along d is zero, while the slider stays free across and in yaw: what a
motor that pushes along d can hold. F(d) over all directions is the stall curve.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from contact.choice import Answer
from contact.error_estimate import averaged_stall_error, beat_error
from contact.exceptions import InputError
from contact.plane.averaged import ANSWER, CHECK, Averaged, Root, balanced, dragged, least_at_rest
from contact.plane.plane_waves import Surface, SurfaceWaves, places, surface_under
from contact.plane.scaling import refuse_slow_beat, resonance_ratios
from contact.plane.state import PlaneState
from contact.plane.steady_state import refuse, steady
from contact.slider import Slider


def _unloaded(slider, surface):
    refuse(slider)
    waves = surface_under(slider, surface)
    refuse_slow_beat(slider, waves)
    return Averaged.of(slider, waves), waves


def _averaging_error(slider, waves):
    if slider.mass == math.inf:
        return 0.0
    ratio, of_beat = resonance_ratios(slider, waves)
    return min(averaged_stall_error(ratio) + beat_error(of_beat), 1.0)


def _require_freedom(slider: Slider, allowed: tuple[str, str], purpose: str) -> None:
    if slider.freedom not in allowed:
        one, other = allowed
        raise InputError("slider.freedom", f'must be "{one}" or "{other}" for {purpose}', slider.freedom)


def stall(slider: Slider, surface: Surface, direction) -> Answer:
    """Return the load in N along a direction (2,) at which the velocity along it is zero; the slider's own is left out.

    Negative where the waves drive the other way.
    """
    towards = np.asarray(direction, float)
    if towards.shape != (2,) or not np.linalg.norm(towards) > 0.0:
        raise InputError("direction", "must be a vector of two numbers, not both zero", str(direction))
    _require_freedom(slider, ("xy", "xy yaw"), "a stall along a direction")
    along = np.append(towards / np.linalg.norm(towards), 0.0)
    averaged, waves = _unloaded(replace(slider, load=(0.0, 0.0)), surface)
    across = np.array([-along[1], along[0], 0.0])
    averaged.basis = np.array([across] if slider.freedom == "xy" else [across, [0.0, 0.0, 1.0]]).T
    root = balanced(averaged)
    force, other = _held_back(averaged, root, along)
    value = (force - float(averaged.damping * root.unknown @ along)) * averaged.scaled.force
    error = abs(other - force) * averaged.scaled.force + _averaging_error(slider, waves) * abs(value)
    return Answer(value=value, error=error, reasons=("load along the direction at which the averaged motion stops",))


def _held_back(averaged: Averaged, root: Root | None, along: np.ndarray) -> tuple[float, float]:
    """Return the force along a unit vector (3,) of a slider held there, scaled, and that of other means.

    ``root``: its balance otherwise; None, or at rest: the least that rest can carry.
    """
    if root is None or not root.unknown.any():
        return least_at_rest(averaged, along, ANSWER), least_at_rest(averaged, along, CHECK)
    check = averaged.at(root.unknown, CHECK, averaged.deformation.copy())
    return float(root.means.force @ along), float(check.force @ along)


@dataclass(frozen=True, kw_only=True)
class StallCurve:
    """Stall over the direction.

    Attributes
    ----------
    angle : (k,) array
        Directions of the load, rad from x to y.
    load, error : (k,) array
        N.
    """

    angle: np.ndarray
    load: np.ndarray
    error: np.ndarray


def stall_curve(slider: Slider, surface: Surface, *, points: int = 24) -> StallCurve:
    """Return the stall along evenly spaced directions."""
    angle = np.linspace(0.0, 2.0 * math.pi, points, endpoint=False)
    answers = [stall(slider, surface, (math.cos(each), math.sin(each))) for each in angle]
    return StallCurve(
        angle=angle, load=np.array([each.value for each in answers]), error=np.array([each.error for each in answers])
    )


def stall_torque(slider: Slider, surface: Surface) -> Answer:
    """Return the torque in N m that keeps the slider from turning, under its load; its own torque is left out."""
    _require_freedom(slider, ("xy yaw", "axle"), "a stall torque")
    averaged, waves = _unloaded(replace(slider, torque=0.0), surface)
    averaged.basis = averaged.basis[:, :-1]
    turning = np.array([0.0, 0.0, 1.0])
    root = balanced(averaged) if averaged.basis.size else None
    torque, other = _held_back(averaged, root, turning)
    if torque < 0.0 and (root is None or not root.unknown.any()):
        torque, other = (-each for each in _held_back(averaged, root, -turning))
    unit = averaged.scaled.force * averaged.scaled.length * averaged.arm
    value = torque * unit
    error = abs(other - torque) * unit + _averaging_error(slider, waves) * abs(value)
    return Answer(value=value, error=error, reasons=("torque at which the averaged yaw stops",))


def drift_per_degree(slider: Slider, surface: Surface, direction=(0.0, 1.0), *, gravity: float = 9.81) -> float:
    """Return the speed in m/s along a direction that one degree of tilt of the stator adds, of a slider of finite mass.

    It is dV/dF times m g pi/180: the slope of the velocity in a force at the slider's own load.
    """
    if slider.mass == math.inf:
        raise InputError("slider.mass", "must be finite for its weight on a tilted stator", slider.mass, "kg")
    averaged, _ = _unloaded(slider, surface)
    root = balanced(averaged)
    towards = np.append(np.asarray(direction, float) / np.linalg.norm(direction), 0.0)
    if not root.unknown.any():
        return 0.0
    slope = averaged.derivative(root.unknown, CHECK)
    rate = -towards @ averaged.basis @ np.linalg.solve(slope, averaged.basis.T @ towards)
    force = slider.mass * gravity * math.pi / 180.0
    return float(rate) * averaged.scaled.speed * force / averaged.scaled.force


def yaw_stability(
    slider: Slider, surface: Surface, *, step: float = 1e-4, state: PlaneState | None = None
) -> float:  # fmt: skip
    """Return d omega/d psi in 1/s: the yaw rate that a small yaw of the slider under its beam adds, per rad.

    Negative: the yaw returns. The surface must be known at every place. A slider without another yaw rate than that of
    its place turns away from psi = 0 where it is positive. With the residual r of the balance and its derivative J in
    the motion, d omega/d psi = -[J^-1 (r(psi) - r(-psi))/(2 psi)] of the yaw. A slider that turns about a contact which
    sticks is balanced at both yaws. ``state``: the averaged steady motion, where it is known.

    Raises
    ------
    InputError
        Of a motion that is given at the contacts alone.
    """
    if isinstance(surface, SurfaceWaves):
        raise InputError("surface", "must be known at every place: give an object with .at(x, y)")
    state = steady(slider, surface, tolerance=1e-6, method="averaged") if state is None else state
    if state.held:
        return 0.0
    at = [places(slider, (0.0, 0.0, psi)) for psi in (-step, step)]
    if "stick" in state.regimes:
        turning = [steady(replace(slider, x=x, y=y), surface.at(x, y), tolerance=1e-6).yaw_rate for x, y in at]
        return (turning[1] - turning[0]) / (2.0 * step)
    averaged, _ = _unloaded(slider, surface)
    motion, force = _units(averaged)
    rates = np.array([*state.velocity, state.yaw_rate])
    before, after = (
        _force_left(Averaged.of(slider, surface.at(x, y), psi), rates) / force
        for (x, y), psi in zip(at, (-step, step), strict=True)
    )
    averaged.deformation = dragged(averaged, rates / motion)
    derivative = averaged.derivative(rates / motion, ANSWER)
    change = averaged.basis @ np.linalg.solve(derivative, averaged.basis.T @ (after - before)) / (2.0 * step)
    return -float(change[2] * motion[2])


def _units(averaged: Averaged) -> tuple[np.ndarray, np.ndarray]:
    """Return the units of (V_x, V_y, yaw rate) and of (F_x, F_y, moment)."""
    own = averaged.scaled
    motion = np.array([own.speed, own.speed, own.omega / averaged.arm])
    return motion, own.force * np.array([1.0, 1.0, averaged.arm * own.length])


def _force_left(averaged: Averaged, motion: np.ndarray) -> np.ndarray:
    """Return the forces and the moment that accelerate a slider at a motion, N and N m."""
    speeds, forces = _units(averaged)
    unknown = motion / speeds
    means = averaged.at(unknown, ANSWER, dragged(averaged, unknown))
    return forces * (averaged.basis @ averaged.residual(means, unknown))


def spin_moment(slider: Slider, state: PlaneState) -> np.ndarray:
    """Return the moment in N m by which each contact resists full spin about its own axis, left out of the motion.

    It is the integral of mu p r over the contact: (3 pi/16) mu P a for the pressure of Hertz, (pi/4) mu P a for that of
    a flat punch (Johnson, *Contact Mechanics*, eqs 4.22 and 3.34; Contensou 1963). The radius is that of the mean
    approach: a contact that opens has a larger one while it touches.
    """
    radius = slider.contact_radius(np.maximum(state.heights, 0.0))
    share = math.pi / 4.0 if slider.shape == "punch" else 3.0 * math.pi / 16.0
    return share * slider.friction_coefficient * state.normal_loads * radius
