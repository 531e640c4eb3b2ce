"""Travel of a slider along the wave field during a burst, with orbits that change with its position.

The displacement X and the velocity v of a slider of mass m obey

    dX/dt = v,    m dv/dt = Q(X, v) - R_t v - q,

where Q is the mean tangential force of first-order averaging (`contact.mean_traction`) for the orbits at the positions
of the balls plus X, and q is the load.  The change of the wave's phase with X is neglected: it changes the frequency
under the balls by v/c, 1e-4.  The bounce is assumed to be steady, because it settles a thousand times faster than the
field changes.

The equation is solved twice, with the slider's travel and with X = 0, and the difference is added to a burst that was
computed at a fixed position.  Start, bounce and ring-up are therefore those of that burst, and a slow slider has the
same answer.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

import contact
from studies.chain.surface_motion import SurfaceMotion
from studies.scene.slider import Slider

MIN_TRAVEL = 0.1  # wavelengths: a shorter travel is neglected
PER_WAVELENGTH = 12  # displacements in the table; the period of a standing wave is half a wavelength
# Speeds in the table, from rest to beyond the speed of the surface, where the force has kinks.  With 33 speeds the
# error is 2e-3 of v.
SPEEDS = 129
STEP = 0.05  # wavelengths of travel in one time step, at the speed of the surface
MIN_STEPS = 400
MARGIN = 1.3  # reach of the first table over the travel of the burst at a fixed position


@dataclass(frozen=True, kw_only=True)
class WaveAlong:
    """Orbits under a slider's balls as functions of its displacement along x."""

    wavelength: float  # m
    limits: tuple[float, float]  # displacements in m between which all balls stay on the stator
    orbits: Callable = field(repr=False)  # displacements in m, (k,), to k tuples of `contact.Orbit` per volt

    @classmethod
    def under(cls, slider: Slider, motion: SurfaceMotion) -> Self:
        """Return the orbits under a slider on the motion of a stator's surface."""
        wave, positions = motion.wave, slider.contact_positions

        def orbit(u_x, u_z):
            return contact.Orbit(frequency=wave.frequency, normal=complex(u_z), tangential=complex(u_x))

        def orbits(displacements):
            balls = np.array([motion.along(x + displacements, y) for x, y in positions])
            return [tuple(orbit(u_x, u_z) for u_x, _, u_z in at) for at in np.moveaxis(balls, 2, 0)]

        limits = -min(x for x, _ in positions), wave.length - max(x for x, _ in positions)
        return cls(wavelength=wave.phase_velocity / wave.frequency, limits=limits, orbits=orbits)

    def scaled(self, factor: float) -> "WaveAlong":
        """Return the field with all amplitudes multiplied by a factor."""

        def orbits(displacements):
            return [tuple(orbit.scaled(factor) for orbit in balls) for balls in self.orbits(displacements)]

        return replace(self, orbits=orbits)


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Motion of a slider along the wave field."""

    time: np.ndarray  # s
    velocity: np.ndarray  # m/s along +x
    displacement: np.ndarray  # from the beginning, m
    velocity_without_travel: np.ndarray  # velocity by the same equation with X = 0, m/s
    ended: bool  # True if a ball reached the stator's end, where the solution stops
    # error of the change of velocity at the end, m/s, estimated with half as many displacements, speeds and steps
    error: float

    @property
    def change(self) -> float:
        """Change of the final velocity by the travel, m/s."""
        return float(self.velocity[-1] - self.velocity_without_travel[-1])


class _Table:
    """The acceleration, interpolated over displacement and velocity, with a table for either direction of motion.

    ``reach``: smallest and largest displacement, m; ``coarser``: factor on the spacings.
    """

    def __init__(self, slider, wave: WaveAlong, level: float, reach: tuple[float, float], coarser: int):
        from scipy.interpolate import RectBivariateSpline

        self.reach, (low, high) = reach, reach
        step = coarser * wave.wavelength / PER_WAVELENGTH
        displacements = np.linspace(low, high, max(4, int(np.ceil((high - low) / step)) + 1))
        balls = [tuple(orbit.scaled(level) for orbit in orbits) for orbits in wave.orbits(displacements)]
        self.top_speed = 1.2 * max(orbit.omega * abs(orbit.tangential) for orbits in balls for orbit in orbits)
        speeds = np.linspace(0.0, self.top_speed, (SPEEDS - 1) // coarser + 1)
        # At rest a sticking contact bears any force between two limits, so that each side of v = 0 has its own table.
        least = np.where(speeds == 0.0, np.finfo(float).tiny, speeds)
        forces = np.array([contact.mean_traction(slider, orbits, np.append(least, -least)) for orbits in balls])
        sides = {1: forces[:, : speeds.size], -1: forces[:, speeds.size :]}
        self._splines = {
            sign: RectBivariateSpline(displacements, speeds, side / slider.mass) for sign, side in sides.items()
        }
        self._damping, self._load = slider.tangential_damping / slider.mass, 0.0
        # the load opposes the direction in which the wave alone drives the slider from rest
        self._load = slider.load / slider.mass * float(np.sign(self.acceleration(0.0, 0.0)))

    def _by_wave(self, displacement: float, speed: float, side: int) -> float:
        """Return the acceleration by the wave on one side of v = 0, m/s^2."""
        return float(self._splines[side](displacement, min(abs(speed), self.top_speed))[0, 0])

    def acceleration(self, displacement: float, velocity: float) -> float:
        """Return dv/dt, m/s^2; 0 at rest where friction holds the slider."""
        if velocity == 0.0:
            forward, backward = (self._by_wave(displacement, 0.0, side) - self._load for side in (1, -1))
            return forward if forward > 0 else min(backward, 0.0)
        side = 1 if velocity > 0 else -1
        return self._by_wave(displacement, velocity, side) - self._damping * velocity - self._load


def _followed(table: _Table, duration: float, steps: int, moves: bool) -> np.ndarray:
    """Return time, velocity and displacement, shape (3, k), by the classical Runge-Kutta method.

    The solution ends where the displacement leaves the table.  ``moves``: False for X = 0.
    """
    h, v, x, (low, high) = duration / steps, 0.0, 0.0, table.reach
    states = [(0.0, 0.0, 0.0)]

    def rate(x, v):
        return (v if moves else 0.0), table.acceleration(x, v)

    for number in range(1, steps + 1):
        x1, a1 = rate(x, v)
        if not v == a1 == 0.0:
            x2, a2 = rate(x + h / 2 * x1, v + h / 2 * a1)
            x3, a3 = rate(x + h / 2 * x2, v + h / 2 * a2)
            x4, a4 = rate(x + h * x3, v + h * a3)
            next_v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            x += h / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
            v = next_v if next_v * v >= 0 else 0.0  # the slider stops before it reverses: friction may hold it
        states.append((number * h, v, x))
        if not low <= x <= high:
            break
    return np.array(states).T


def travelled(slider, wave: WaveAlong, level: float, duration: float, expected: float) -> Travel:
    """Return the motion of a slider along the field during a burst from rest.

    ``level``: V; ``duration``: s; ``expected``: travel in m of the burst at a fixed position, with its sign.  Raises
    contact.ConvergenceError if averaging does not apply.
    """
    span = MARGIN * abs(expected) + 2 * wave.wavelength
    while True:
        ahead, behind = (span, 2 * wave.wavelength) if expected >= 0 else (2 * wave.wavelength, span)
        reach = max(-behind, wave.limits[0]), min(ahead, wave.limits[1])
        solutions = []
        for coarser in (1, 2):
            table = _Table(slider, wave, level, reach, coarser)
            fastest = duration * table.top_speed / (STEP * wave.wavelength)
            steps = int(np.ceil(max(MIN_STEPS, fastest) / coarser))
            solutions.append([_followed(table, duration, steps, moves) for moves in (True, False)])
        (moving, fixed), (coarse, coarse_fixed) = solutions
        final = moving[2, -1]
        at_limit = not reach[0] < final < reach[1]
        if not at_limit or abs(final) >= abs(wave.limits[1] if final > 0 else wave.limits[0]):
            break
        span *= 2
    time, velocity, displacement = moving
    without_travel = fixed[1, : len(time)]
    change = velocity[-1] - without_travel[-1]
    coarse_change = np.interp(time[-1], *coarse[:2]) - np.interp(time[-1], *coarse_fixed[:2])
    return Travel(
        time=time, velocity=velocity, displacement=displacement, velocity_without_travel=without_travel,
        ended=bool(at_limit), error=float(abs(change - coarse_change)),
    )  # fmt: skip


def with_travel(trajectory, travel: Travel):
    """Return a `contact.Trajectory` with the change of velocity added, and the slide after the burst adapted to it."""
    time, velocity = trajectory.time, np.array(trajectory.velocity)
    on = time <= trajectory.duration * (1 + 1e-12)
    velocity[on] += np.interp(time[on], travel.time, travel.velocity - travel.velocity_without_travel)
    end = trajectory.velocity_at_burst_end
    new_end = end + travel.change
    if not on.all():
        slide = np.append(end, trajectory.velocity[~on])
        velocity[~on] = _slide(time[~on] - trajectory.duration, slide, new_end)
    return replace(trajectory, velocity=velocity, answer=replace(trajectory.answer, value=float(new_end)))


def _slide(after, velocity, start: float):
    """Return a decaying velocity with another start, at the times ``after`` (k,) from the end of the burst.

    ``velocity`` (k + 1,), at 0 and at these times, is shifted in time; higher speeds are extrapolated with its slope.
    """
    time, speed = np.append(0.0, after), abs(velocity)
    if speed[0] == 0.0 or speed[-1] >= speed[0]:
        return velocity[1:] + (start - velocity[0])
    half = int(np.argmax(speed <= 0.5 * speed[0])) or len(speed) - 1
    slope = (speed[half] - speed[0]) / time[half]
    below = int(np.argmax(speed <= abs(start)))
    if abs(start) >= speed[0] or below == 0:
        shift = (abs(start) - speed[0]) / slope
    else:
        shift = np.interp(-abs(start), -speed[below - 1 : below + 1], time[below - 1 : below + 1])
    at = after + shift
    beyond = np.minimum(at, 0.0) + (np.maximum(at - time[-1], 0.0) if speed[-1] > 0.05 * speed[0] else 0.0)
    return np.interp(at, time, velocity) + np.sign(start) * slope * beyond
