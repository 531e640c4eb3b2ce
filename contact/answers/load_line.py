r"""The load line of a motor: steady velocity against a constant load, blocked thrust, mechanical efficiency.

The blocked thrust is the load that holds the slider at rest: the mean traction at v = 0, from below the load at which
the motor just stalls. Where a contact sticks at rest the load line ends in a jump to zero, and the slider is held over
a whole interval of loads. Efficiency is the work against the load over the work of the wave, per cycle, by the ledger.
"""

from dataclasses import dataclass, replace

import numpy as np

from contact import bounds
from contact.answers.averaged import STIFFEST_STEADY, refuse_unless_applicable
from contact.answers.steady import steady
from contact.answers.sweep import mean_motion
from contact.convergence import ConvergenceError
from contact.drive import towards_plus
from contact.orbit import Orbit, as_orbits
from contact.problem import scaled
from contact.slider import Slider
from contact.solve import averaged


@dataclass(frozen=True, kw_only=True)
class LoadLine:
    """Velocity, power and efficiency against load.

    Attributes
    ----------
    load : (k,) array
        N, against the direction in which the unloaded slider is driven.
    velocity : (k,) array
        m/s, positive in that direction.
    power : (k,) array
        Mechanical, load times velocity, W.
    efficiency : (k,) array
        Power over what the wave gives the contacts, 0 where the slider is held.
    blocked_thrust : float
        N, the load at which the motor stalls.
    """

    load: np.ndarray
    velocity: np.ndarray
    power: np.ndarray
    efficiency: np.ndarray
    blocked_thrust: float


def blocked_thrust(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> tuple[float, float]:
    """Return (stalling load, largest load held) in N: the mean tractions of a cycle at rest (averaged).

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's own load is not used.

    Raises
    ------
    ConvergenceError
        Status "not applicable" where the averaged way does not apply.
    """
    _, problem, unit = _unloaded(slider, orbits)
    low, high = averaged.rest_tractions(problem)
    # driven forwards: stalls at the lower traction, holds up to the upper; driven against its crests: mirrored
    return (
        (float(low * unit), float(high * unit)) if high > -low else (float(-high * unit), float(-low * unit))
    )


def mean_traction(slider: Slider, orbits: Orbit | tuple[Orbit, ...], velocities: np.ndarray) -> np.ndarray:
    """Return the mean tangential force of the surface on a slider that runs at given velocities, N along +x (averaged).

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's load and tangential damping are not used.
    velocities : ndarray, shape (k,)
        m/s along +x.

    Returns
    -------
    ndarray, shape (k,)

    Raises
    ------
    ConvergenceError
        Status "not applicable" where the averaged way does not apply.
    """
    side, problem, unit = _unloaded(slider, orbits)
    speeds = side * np.asarray(velocities, float) / problem.speed
    return side * averaged.tractions(problem, speeds) * unit


def _unloaded(slider: Slider, orbits: Orbit | tuple[Orbit, ...]):
    """Return drive direction, problem driven towards +x without the slider's load, and its unit of force in N."""
    listed = as_orbits(orbits)
    free = replace(slider, load=0.0)
    refuse_unless_applicable(free, listed, STIFFEST_STEADY)
    side, driven = towards_plus(listed)
    problem = scaled(free, driven, direction=1.0, start=0.0)
    return side, problem, slider.mass * problem.omega**2 * problem.length


def load_line(
    slider: Slider, orbits: Orbit | tuple[Orbit, ...], *, points: int, tolerance: float
) -> LoadLine:
    """Return the load line from no load to the blocked thrust.

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's own load is not used.
    points : int
        Loads, evenly spaced; at least 2.
    tolerance : float
        As for `steady`.
    """
    listed = as_orbits(orbits)
    bounds.count("points", points, 2)
    stall, _ = blocked_thrust(slider, listed)
    if stall <= 0.0:
        raise ConvergenceError(
            "held", "the wave does not move the unloaded slider; raise the amplitude above the threshold"
        )
    direction = np.sign(mean_motion(replace(slider, load=0.0), listed).velocity)
    loads = stall * np.linspace(0.0, 1.0, points)
    velocity, wave_power = np.zeros(points), np.zeros(points)
    for k, load in enumerate(loads[:-1]):
        state = steady(replace(slider, load=float(load)), listed, tolerance=tolerance)
        velocity[k] = direction * state.velocity
        wave_power[k] = state.ledger.wave * listed[0].frequency
    power = loads * velocity
    efficiency = np.divide(power, wave_power, out=np.zeros(points), where=wave_power > 0.0)
    return LoadLine(load=loads, velocity=velocity, power=power, efficiency=efficiency, blocked_thrust=stall)
