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
        wave, places = motion.wave, slider.contact_positions

        def orbit(u_x, u_z):
            return contact.Orbit(frequency=wave.frequency, normal=complex(u_z), tangential=complex(u_x))

        def orbits(displacements):
            balls = np.array([motion.along(x + displacements, y) for x, y in places])
            return [tuple(orbit(u_x, u_z) for u_x, _, u_z in at) for at in np.moveaxis(balls, 2, 0)]

        behind, ahead = min(x for x, _ in places), max(x for x, _ in places)
        limits = -behind, wave.length - ahead
        return cls(wavelength=wave.phase_velocity / wave.frequency, limits=limits, orbits=orbits)

    def scaled(self, factor: float) -> "WaveAlong":
        """Return the orbits multiplied by a factor."""
        return replace(
            self, orbits=lambda places: [tuple(ball.scaled(factor) for ball in each) for each in self.orbits(places)]
        )


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Motion of a slider along the wave field."""

    time: np.ndarray  # s
    velocity: np.ndarray  # m/s along +x
    place: np.ndarray  # displacement from the beginning, m
    held_velocity: np.ndarray  # velocity by the same equation with X = 0, m/s
    ended: bool  # True if a ball reached the stator's end, where the solution stops
    # error of the change of velocity at the end, m/s, estimated with half as many displacements, speeds and steps
    error: float

    @property
    def change(self) -> float:
        """Change of the final velocity by the travel, m/s."""
        return float(self.velocity[-1] - self.held_velocity[-1])


class _Table:
    """Table of the acceleration over displacement and velocity, for either direction of motion, and at rest."""

    def __init__(self, slider, wave: WaveAlong, level: float, reach: tuple[float, float], coarser: int):
        from scipy.interpolate import RectBivariateSpline

        step = coarser * wave.wavelength / PER_WAVELENGTH
        low, high = reach
        self.places = np.linspace(low, high, max(4, int(np.ceil((high - low) / step)) + 1))
        rows = [tuple(each.scaled(level) for each in orbits) for orbits in wave.orbits(self.places)]
        self.top = 1.2 * max(each.omega * abs(each.tangential) for orbits in rows for each in orbits)
        speeds = np.linspace(0.0, self.top, (SPEEDS - 1) // coarser + 1)
        # At rest a sticking contact bears any force between two limits, so that each side of v = 0 has its own table.
        least = np.where(speeds == 0.0, np.finfo(float).tiny, speeds)
        forces = np.array([contact.mean_traction(slider, orbits, np.append(least, -least)) for orbits in rows])
        sides = {1: forces[:, : speeds.size], -1: forces[:, speeds.size :]}
        self._splines = {
            sign: RectBivariateSpline(self.places, speeds, side / slider.mass) for sign, side in sides.items()
        }
        self._damping = slider.tangential_damping / slider.mass
        self._load = slider.load / slider.mass

    def _driven(self, place: float, speed: float, side: int) -> float:
        """Return the acceleration by the wave on one side of v = 0, m/s^2."""
        return float(self._splines[side](place, min(abs(speed), self.top))[0, 0])

    def toward(self, place: float) -> float:
        """Return the direction in which the wave drives a slider from rest without a load; 0 if friction holds it."""
        return 1.0 if self._driven(place, 0.0, 1) > 0 else -1.0 if self._driven(place, 0.0, -1) < 0 else 0.0

    def acceleration(self, place: float, speed: float, load_sign: float) -> float:
        """Return dv/dt, m/s^2."""
        load = self._load * load_sign
        if speed == 0.0:
            forward, backward = (self._driven(place, 0.0, side) - load for side in (1, -1))
            return forward if forward > 0 else min(backward, 0.0)
        return self._driven(place, speed, 1 if speed > 0 else -1) - self._damping * speed - load


def _followed(table: _Table, duration: float, steps: int, moves: bool, reach) -> np.ndarray:
    """Return time, velocity and displacement, shape (3, k), by the classical Runge-Kutta method.

    The solution ends where the displacement leaves ``reach``.  ``moves``: False for X = 0.
    """
    sign = table.toward(0.0)
    h, speed, place = duration / steps, 0.0, 0.0
    rows = [(0.0, 0.0, 0.0)]

    def rate(x, v):
        return (v if moves else 0.0), table.acceleration(x, v, sign)

    for number in range(1, steps + 1):
        x1, a1 = rate(place, speed)
        if speed == 0.0 and a1 == 0.0:
            new, further = 0.0, place
        else:
            x2, a2 = rate(place + h / 2 * x1, speed + h / 2 * a1)
            x3, a3 = rate(place + h / 2 * x2, speed + h / 2 * a2)
            x4, a4 = rate(place + h * x3, speed + h * a3)
            new = speed + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            further = place + h / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
            if new * speed < 0:
                new = 0.0  # the slider stops before it reverses, because friction may hold it
        speed, place = new, further
        rows.append((number * h, speed, place))
        if not reach[0] <= place <= reach[1]:
            break
    return np.array(rows).T


def travelled(slider, wave: WaveAlong, level: float, duration: float, expected: float) -> Travel:
    """Return the motion of a slider along the field during a burst from rest.

    ``level``: V; ``duration``: s; ``expected``: travel in m of the burst at a fixed position, with its sign.  Raises
    contact.ConvergenceError if averaging does not apply.
    """
    span = MARGIN * abs(expected) + 2 * wave.wavelength
    while True:
        ahead, behind = (span, 2 * wave.wavelength) if expected >= 0 else (2 * wave.wavelength, span)
        reach = max(-behind, wave.limits[0]), min(ahead, wave.limits[1])
        runs = []
        for coarser in (1, 2):
            table = _Table(slider, wave, level, reach, coarser)
            fastest = duration * table.top / (STEP * wave.wavelength)
            steps = int(np.ceil(max(MIN_STEPS, fastest) / coarser))
            runs.append([_followed(table, duration, steps, moves, reach) for moves in (True, False)])
        (moving, held), (coarse, coarse_held) = runs
        at_limit = not reach[0] < moving[2, -1] < reach[1]
        end = wave.limits[1] if moving[2, -1] > 0 else wave.limits[0]
        if not at_limit or abs(moving[2, -1]) >= abs(end):
            break
        span *= 2
    time, velocity, place = moving
    change = velocity[-1] - held[1, len(time) - 1]
    same = np.interp(time[-1], coarse[0], coarse[1]) - np.interp(time[-1], coarse_held[0], coarse_held[1])
    return Travel(
        time=time,
        velocity=velocity,
        place=place,
        held_velocity=held[1, : len(time)],
        ended=bool(at_limit),
        error=float(abs(change - same)),
    )


def with_travel(trajectory, travel: Travel):
    """Return a `contact.Trajectory` with the change of velocity added, and the slide after the burst adapted to it."""
    time, velocity = trajectory.time, np.array(trajectory.velocity)
    end = trajectory.velocity_at_burst_end
    on = time <= trajectory.duration * (1 + 1e-12)
    velocity[on] += np.interp(time[on], travel.time, travel.velocity - travel.held_velocity)
    new_end = end + travel.change
    after = time[~on] - trajectory.duration
    if after.size:
        # The slide has the same curve of speed, shifted in time; higher speeds are extrapolated with the first slope.
        old = np.append(end, trajectory.velocity[~on])
        known = np.append(0.0, after)
        velocity[~on] = _slide(known, old, new_end, after)
    return replace(trajectory, velocity=velocity, answer=replace(trajectory.answer, value=float(new_end)))


def _slide(known, old, start: float, after):
    """Return a decaying speed with another start: the same curve shifted in time and extrapolated with its slope."""
    size = abs(old)
    if size[0] == 0.0 or size[-1] >= size[0]:
        return old[1:] + (start - old[0])
    half = int(np.argmax(size <= 0.5 * size[0])) or len(size) - 1
    slope = (size[half] - size[0]) / known[half]
    below = int(np.argmax(size <= abs(start)))
    if abs(start) >= size[0] or below == 0:
        shift = (abs(start) - size[0]) / slope
    else:
        shift = np.interp(-abs(start), -size[below - 1 : below + 1], known[below - 1 : below + 1])
    at = after + shift
    shifted = np.interp(at, known, old)
    beyond = np.minimum(at, 0.0) + (np.maximum(at - known[-1], 0.0) if size[-1] > 0.05 * size[0] else 0.0)
    return shifted + np.sign(start) * slope * beyond
