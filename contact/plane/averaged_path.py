"""The averaged motion of a slider in the plane through time: pose and rates under the mean forces of one period.

    m V' = <sum Q> - F - R_t V,      J omega' = <sum (X_i Q_y,i - Y_i Q_x,i)> - M - R_yaw omega,

with the means on the waves at the contacts' present places. On a surface at rest the contacts brake the slider until it
stops, and stays where friction holds its load.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp

from contact.exceptions import ConvergenceError
from contact.plane.averaged import Averaged, dragged, held_rest
from contact.plane.plane_waves import Surface, SurfaceWaves, places, surface_under
from contact.plane.scaling import FREE, inertia_of
from contact.plane.wave_shape import WaveShape
from contact.slider import Slider

STOPPED = 1e-6  # of the energy with which a coast begins; at it the slider stops, 1e-6 of its way before it would
STORED = 0.6  # energy of a contact at its limit over mu P c z, at most
RELEASE = 1e-3  # of a part of a burst: to which the time is known at which waves that grow move the slider
POSE, RATES = slice(0, 3), slice(3, 6)


def turned(slider: Slider, yaw: float) -> Slider:
    """Return a slider after a turn by `yaw` (rad) about its centre or its axle, in the axes of the stator."""
    if yaw == 0.0:
        return slider
    x, y = places(slider, (0.0, 0.0, yaw))
    return replace(slider, x=x, y=y)


class Rest(NamedTuple):
    """A time in which friction holds the slider, as a solution of the equations of motion."""

    t_min: float
    t_max: float
    state: np.ndarray  # (6,)

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the states at times (k,): (6, k)."""
        return np.tile(self.state[:, None], (1, len(t)))


class Stretch(NamedTuple):
    """States at some instants, and where the motion ended."""

    time: np.ndarray  # (k,) s
    state: np.ndarray  # (k, 6): pose and rates
    end: np.ndarray  # (6,)
    stopped: float  # time at which the slider stopped, s; inf where it did not


@dataclass
class AveragedPath:
    """The averaged equations of motion of a slider on waves with a factor `level(t, after)`, or with a shape.

    `after`: True after the burst. Without rise time and shape the factor is 1 during a burst and 0 after it.
    """

    slider: Slider
    surface: Surface
    level: Callable[[float, bool], float]
    how: tuple[int, float]  # nodes and tolerance of the means
    tolerance: float  # of the integration, relative
    rise_time: float  # s
    scale: np.ndarray  # (6,) of pose and rates, to which the tolerance refers
    shape: WaveShape | None = None  # takes the place of `level`
    in_place: bool = False  # True: the mean forces stay those at the first pose
    evaluations: int = field(default=0, init=False)
    after: bool = field(default=False, init=False)
    # Level and pose of the mean forces that were found last, and these
    known: tuple | None = field(default=None, init=False)

    def __post_init__(self):
        mass = self.slider.unit_mass
        self.masses = np.array([mass, mass, inertia_of(self.slider) if 2 in FREE[self.slider.freedom] else math.inf])
        self.moving = list(FREE[self.slider.freedom])

    def means_at(self, t: float, pose: np.ndarray) -> Averaged:
        """Return the mean forces of the slider on the waves at its place."""
        slider, shape = self.slider, self.shape
        level = 1.0 if shape is not None else self.level(t, self.after)
        pose = np.zeros(3) if self.in_place else pose
        at = (level, *((t, self.after) if shape is not None else ()))
        at += tuple((pose[2:] if isinstance(self.surface, SurfaceWaves) else pose).tolist())
        if self.known is None or self.known[0] != at:
            waves = surface_under(slider, self.surface, pose)
            waves = waves.scaled(level) if shape is None else shape.on(waves, t, self.after)
            self.known = at, Averaged.of(slider, waves, float(pose[2]))
        return self.known[1]

    def derivative(self, t: float, state: np.ndarray) -> np.ndarray:
        """Return the rates of pose and rates."""
        averaged = self.means_at(t, state[POSE])
        own = averaged.scaled
        unknown = state[RATES] / [own.speed, own.speed, own.omega / averaged.arm]
        averaged.deformation = dragged(averaged, unknown)
        means = averaged.at(unknown, self.how)
        self.evaluations += 1
        if not means.repeats:
            raise ConvergenceError("not applicable", 'a contact keeps its deformation: method = "exact"')
        force = averaged.basis @ averaged.residual(means, unknown)
        force *= own.force * np.array([1.0, 1.0, averaged.arm * own.length])
        return np.concatenate([state[RATES], force / self.masses])

    def height(self, t: float, pose: np.ndarray, after: bool) -> float:
        """Return the mean position z_s of the contacts at a time, m."""
        self.after = after
        averaged = self.means_at(t, pose)
        return float(averaged.height.mean()) * averaged.scaled.length

    def holds(self, t: float, pose: np.ndarray) -> bool:
        """Return whether friction holds the slider at a pose."""
        return held_rest(self.means_at(t, pose)) is not None

    def follow(
        self, start: np.ndarray, span: tuple[float, float], at: np.ndarray | int, *, after: bool = False,
        coasts: bool = False,
    ) -> Stretch:  # fmt: skip
        """Return the motion from a state to the end of a time span, s, at instants, or at so many to the end.

        With `coasts` the surface is at rest: the motion ends where the slider stops, and stays there.
        """
        self.after = after
        begin, end = span
        parts: list[OdeSolution | Rest] = []
        if self.shape is not None and not isinstance(at, int) and not coasts:
            return self._shaped(start, self.shape.parts(*span), at, parts)
        if (after or self.rise_time == 0.0 or begin > 0.0) and self.rests(begin, start):
            at = np.linspace(begin, end, at + 1)[1:] if isinstance(at, int) else at
            start = np.append(start[POSE], np.zeros(3))
            return Stretch(at, np.tile(start, (len(at), 1)), start, begin)
        if coasts:
            last, until = self._coast(start, span, parts)
            stopped = until if until < end and self.holds(until, last[POSE]) else math.inf
            if until < end and stopped == math.inf:  # the load moves it on
                last, until = self._integrated(last, (until, end), parts), end
        else:
            last, until, stopped = self._integrated(start, span, parts), end, math.inf
        if isinstance(at, int):
            at = np.linspace(begin, until, at + 1)[1:]
        states = _states(parts, at, last)
        if stopped < math.inf:
            last = np.append(last[POSE], np.zeros(3))
            states[at >= stopped] = last
        return Stretch(at, states, last, stopped)

    def _shaped(self, start: np.ndarray, times: np.ndarray, at: np.ndarray, parts: list) -> Stretch:
        """Return the motion through times on waves that may become too weak to move the slider, and move it again."""
        last = start
        for part in pairwise(times.tolist()):
            last = self._through(last, part, parts)
        return Stretch(at, _states(parts, at, last), last, math.inf)

    def _through(self, state: np.ndarray, span: tuple[float, float], parts: list) -> np.ndarray:
        """Return the state at the end of a part of the burst in which the waves change little."""
        (t, end), watched = span, True
        while t < end:
            if self.rests(t, state):
                state, until = np.append(state[POSE], np.zeros(3)), self._released(t, end, state[POSE])
                parts.append(Rest(t, until, state))
                t = until
                if t == end:
                    break
            state = self._integrated(state, (t, end), parts, stops=watched)
            # once it is slow and not held there, it is followed on
            t, watched = float(parts[-1].t_max), False
        return state

    def _released(self, begin: float, end: float, pose: np.ndarray) -> float:
        """Return the first time up to `end` at which friction no longer holds a slider that it holds at `begin`, s."""
        if self.holds(end, pose):
            return end
        held, free = begin, end
        while free - held > RELEASE * (end - begin):
            middle = 0.5 * (held + free)
            held, free = (middle, free) if self.holds(middle, pose) else (held, middle)
        return free

    def _coast(self, start: np.ndarray, span: tuple[float, float], parts: list) -> tuple[np.ndarray, float]:
        """Return the state and the time at which the slider has lost all but `STOPPED` of its energy, or the end.

        Steps as long as the error allows would jump over the stop: each stretch is half of the time to it.
        """
        t, state, least = span[0], start, STOPPED * self.energy(start)
        while t < span[1] and self.energy(state) > least:
            push = self.masses[self.moving] * self.derivative(t, state)[RATES][self.moving]
            power = float(push @ state[RATES][self.moving])
            to_stop = -2.0 * self.energy(state) / power if power < 0.0 else math.inf
            until = min(t + 0.5 * to_stop, span[1])
            state, t = self._integrated(state, (t, until), parts), until
        return state, t

    def energy(self, state: np.ndarray) -> float:
        """Return the kinetic energy, J."""
        return 0.5 * float(self.masses[self.moving] @ state[RATES][self.moving] ** 2)

    def rests(self, t: float, state: np.ndarray) -> bool:
        """Return whether friction holds a slider whose contacts can store its energy before they slip.

        A contact of a sphere stores 3/5 mu P c z at its limit, a punch 1/2.
        """
        return self.energy(state) <= self.stored and self.holds(t, state[POSE])

    @cached_property
    def stored(self) -> float:
        """The energy that the contacts store at their limits, J."""
        slider = self.slider
        limits = slider.contacts(slider.count).limit_slope * slider.rest_approaches(slider.count)
        return STORED * slider.friction_coefficient * slider.preload * float(np.mean(limits))

    def _integrated(
        self, start: np.ndarray, span: tuple[float, float], parts: list, *, stops: bool = False
    ) -> np.ndarray:  # fmt: skip
        """Return the state at the end of a time span; its interpolation is appended to the parts.

        ``stops``: it ends where the slider has become so slow that friction may hold it.
        """

        def slows(_: float, state: np.ndarray) -> float:
            return self.energy(state) - self.stored

        vars(slows).update(terminal=True, direction=-1)
        # the first step must not jump over the rise
        first = min(0.1 * self.rise_time, 0.5 * (span[1] - span[0])) or None
        found = solve_ivp(
            self.derivative, span, start, method="RK23", rtol=max(self.tolerance, 1e-9),
            atol=self.tolerance * self.scale, dense_output=True, first_step=first,
            events=slows if stops else None,
        )  # fmt: skip
        if not found.success or not np.isfinite(found.y).all():
            raise ConvergenceError("not converged", "the averaged motion in the plane was not followed; method exact")
        parts.append(found.sol)
        return found.y[:, -1]


def _states(parts: list, at: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return the states (k, 6) at instants; outside the parts the slider rests at the last place."""
    states = np.tile(np.append(last[POSE], np.zeros(3)), (len(at), 1))
    for solution in parts:
        inside = (at >= solution.t_min) & (at <= solution.t_max)
        states[inside] = solution(at[inside]).T if inside.any() else states[inside]
    return states
