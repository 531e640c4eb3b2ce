"""Approach, deformation, forces and regime of the contacts of a slider in the plane over one period of the waves."""

import math
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.answers.waveforms import REGIMES
from contact.exceptions import ConvergenceError
from contact.plane.averaged import ANSWER, CHECK, Averaged, balanced, dragged
from contact.plane.disc_contacts import Stage
from contact.plane.plane_waves import Surface, surface_under
from contact.plane.scaling import refuse_slow_beat
from contact.plane.steady_state import refuse, rigid_motion
from contact.slider import Slider


@dataclass(frozen=True, kw_only=True)
class ContactCycle:
    """Steady motion of n contacts at k times within one common period of the waves.

    Attributes
    ----------
    time : (k,) array
        s; ends with the period. Zero is an upward zero crossing of u_z of the first contact, of the fastest wave.
    displacement : (k, n, 3) array
        Displacement of the surface under each contact, m.
    approach, limit : (k, n) arrays
        Approach z, negative where the contact is separated, and largest deformation c z, m.
    deformation : (k, n, 2) array
        Tangential deformation (e_x, e_y), m.
    normal_force : (k, n) array
        P, N.
    tangential_force : (k, n, 2) array
        (Q_x, Q_y) on the slider, N.
    regime : (k, n) array of str
        "separated", "stick" or "slip".
    surface_velocity : (k, n, 2) array
        Tangential velocity of the surface, m/s.
    contact_velocity : (n, 2) array
        Velocity of the slider at each contact, m/s; constant within the period.
    velocity : (2,) array
        Of the slider's centre, m/s.
    yaw_rate : float
        rad/s.
    mean_force : (2,) array
        Sum of the contacts' mean tangential forces, N: what load and damper take.
    force_error : (2,) array
        Estimated error of `mean_force`, N, as a balance of the slider's load: from means with other nodes and another
        tolerance, and from the error of the velocity.
    """

    time: np.ndarray
    displacement: np.ndarray
    approach: np.ndarray
    limit: np.ndarray
    deformation: np.ndarray
    normal_force: np.ndarray
    tangential_force: np.ndarray
    regime: np.ndarray
    surface_velocity: np.ndarray
    contact_velocity: np.ndarray
    velocity: np.ndarray
    yaw_rate: float
    mean_force: np.ndarray
    force_error: np.ndarray


def contact_cycle(slider: Slider, surface: Surface, *, points_per_cycle: int, tolerance: float = 1e-6) -> ContactCycle:
    """Return the contacts of a slider in steady averaged motion over one period of the waves.

    Height, velocity and yaw rate are constant within the period: they are those of `steady` with method "averaged".

    Parameters
    ----------
    slider, surface
        As for `steady`.
    points_per_cycle : int
        Number of times per cycle of the fastest wave, at least 1.
    tolerance : float
        As for `steady`.

    Raises
    ------
    InputError
        If the parameters contradict each other.
    ConvergenceError
        As `steady`, and with status "not applicable" for a slider at rest: what its contacts carry depends on how it
        came to rest.

    Examples
    --------
    >>> from contact.plane import SurfaceWaves
    >>> slider = Slider(
    ...     radius=1e-3, mass=math.inf, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    ... )
    >>> both = [[-6.7e-9j, 6.7e-9, 10e-9 + 10e-9j]]  # a wave along x and one along y, a quarter of a period ahead
    >>> cycle = contact_cycle(slider, SurfaceWaves(frequencies=[2.2e6], amplitudes=[both]), points_per_cycle=8)
    >>> print(*cycle.regime[:, 0])
    slip stick slip separated separated separated separated separated
    """
    parameter_check.count("points_per_cycle", points_per_cycle, 1)
    parameter_check.positive("tolerance", tolerance, "")
    waves = surface_under(slider, surface)
    refuse(slider)
    refuse_slow_beat(slider, waves)
    averaged = Averaged.of(slider, waves)
    root = balanced(averaged, tolerance=tolerance)
    if root.held or root.near_rest:
        raise ConvergenceError(
            "not applicable", "friction holds the slider, whose contacts carry what brought it to rest"
        )
    # a contact that never opens is dragged to its limit against its motion
    averaged.deformation = dragged(averaged, root.unknown)
    fine = averaged.at(root.unknown, ANSWER)
    coarse = averaged.at(root.unknown, CHECK, averaged.deformation.copy())
    if not fine.repeats:
        raise ConvergenceError("not converged", "a contact did not repeat its motion within the periods allowed")
    basis, units, problem = averaged.basis, averaged.scaled, averaged.problem
    error = np.abs(fine.force - coarse.force)
    error += np.abs(basis) @ np.abs(root.derivative) @ np.abs(basis.T) @ root.error
    count = points_per_cycle * round(units.period / (2.0 * math.pi))
    phase = waves.upward_zero + units.period * np.arange(1, count + 1) / count
    stage, regime = averaged.samples(root.unknown, phase)
    angle = problem.ratio * phase[:, None]
    cos, sin = (np.einsum("kw,wni->kni", function(angle), part)
                for function, part in ((np.cos, problem.cos), (np.sin, problem.sin)))  # fmt: skip
    at_contact = averaged.rigid @ root.unknown
    velocity, yaw_rate = rigid_motion(averaged, root.unknown)
    approach = stage[..., Stage.Z] * units.length
    return ContactCycle(
        time=(phase - phase[-1] + units.period) / units.omega, displacement=(cos + sin) * units.length,
        approach=approach, limit=problem.limit_slope * np.maximum(approach, 0.0),
        deformation=stage[..., [Stage.E_X, Stage.E_Y]] * units.length,
        normal_force=stage[..., Stage.P] * units.force,
        tangential_force=stage[..., [Stage.Q_X, Stage.Q_Y]] * units.force, regime=REGIMES[regime],
        surface_velocity=(stage[..., [Stage.W_X, Stage.W_Y]] + at_contact) * units.speed,
        contact_velocity=at_contact * units.speed, velocity=velocity, yaw_rate=yaw_rate,
        mean_force=fine.force[:2] * units.force, force_error=error[:2] * units.force,
    )  # fmt: skip
