r"""Path of a slider in the plane under bursts: its slow motion by the mean forces of a cycle at its pose and velocity.

    m V' = F(V, omega; x, y, psi) - R_t V - load,      J omega' = M(V, omega; x, y, psi) - torque,

with the cycle means F and M of the contacts on the waves of the place.  Waves begin and end with the burst: their
ring-up is left out, as is the ring of the slider in its contacts after a stop.  The last burst is followed by a coast,
where the contacts slip on a surface at rest until the slider stops.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.model.plane import turned

STOPPED = 1e-3  # m/s: speed at which a slider that coasts is taken to have stopped, 1 um before it does
LOOSE, TIGHT = 0.1, 0.02  # tolerances of two integrations over that of the path; their difference is its error
SAMPLES = 60  # instants of each burst, and of the coast, in the record
LONGEST_COAST = 10.0  # s
X, Y, YAW, V_X, V_Y, RATE = range(6)


@dataclass(frozen=True, kw_only=True)
class Leg:
    """The motion in one burst, or in the coast after the last one."""

    name: str
    time: np.ndarray  # (k,) s
    state: np.ndarray  # (k, 6): x, y, yaw and their rates
    error: float  # of the place at its end, m

    @property
    def end(self) -> np.ndarray:
        """Pose and rates at its end."""
        return self.state[-1]


class _Stop:
    """The event of a slider that becomes slower than `STOPPED`, at which the integration ends."""

    terminal, direction = True, -1.0

    def __init__(self, speed: Callable[[np.ndarray], float]) -> None:
        self.speed = speed

    def __call__(self, _: float, state: np.ndarray) -> float:
        return self.speed(state) - STOPPED


@dataclass(frozen=True, kw_only=True)
class Body:
    """The slider with what its slow motion needs; one of ``share`` equal parts."""

    slider: contact.Slider
    tolerance: float  # relative, of the integration and of the mean forces

    def path(self, surface: Any, start: np.ndarray, begin: float, duration: float, name: str, *, coasts: bool) -> Leg:
        """Return the motion from a state on a surface; ``coasts``: it ends where the slider stops."""
        loose, tight = (
            self._followed(surface, start, begin, duration, tolerance, coasts=coasts)
            for tolerance in (LOOSE * self.tolerance, TIGHT * self.tolerance)
        )
        error = float(np.hypot(*(loose[1][-1, :2] - tight[1][-1, :2])))
        return Leg(name=name, time=tight[0], state=tight[1], error=error)

    def _followed(self, surface, start, begin: float, duration: float, tolerance: float, *, coasts: bool):
        """Return instants from the start to the end, to which the slider may coast before the time is over, and states.

        Shapes (k,) and (k, 6).
        """
        from scipy.integrate import solve_ivp

        stops = _Stop(self._speed)
        speed, reach = max(self._speed(start), 1e-3), self._reach()
        scale = np.array([1e-4, 1e-4, 1e-4 / reach, speed, speed, speed / reach])
        solution = solve_ivp(
            lambda _, state: self.rates(surface, state), (begin, begin + duration), start, method="RK23",
            rtol=tolerance, atol=tolerance * scale, events=stops if coasts else None,
            dense_output=True,
        )  # fmt: skip
        if not solution.success:
            raise contact.ConvergenceError("path", f"the path cannot be followed: {solution.message}")
        time = np.linspace(begin, solution.t[-1], SAMPLES + 1)
        return time, solution.sol(time).T

    def rates(self, surface: Any, state: np.ndarray) -> np.ndarray:
        """Return the rates of pose, velocity and yaw rate."""
        slider = turned(self.slider, float(state[YAW]))
        waves = surface.at(np.atleast_1d(slider.x) + state[X], np.atleast_1d(slider.y) + state[Y])
        velocity, rate = state[[V_X, V_Y]], float(state[RATE])
        mean = plane.mean_forces(slider, waves, velocity, rate)
        acceleration, turning = np.zeros(2), 0.0
        if slider.freedom == "axle":  # the torque is about the axle, which holds the centre
            turning = (mean.torque - slider.torque) / slider.inertia
        else:
            acceleration = (mean.force - np.array(slider.load) - slider.tangential_damping * velocity) / slider.mass
            if slider.freedom == "xy yaw":
                turning = (mean.torque - slider.torque) / slider.inertia
        return np.array([velocity[0], velocity[1], rate, acceleration[0], acceleration[1], turning])

    def _speed(self, state: np.ndarray) -> float:
        return math.hypot(state[V_X], state[V_Y]) + self._reach() * abs(state[RATE])

    def _reach(self) -> float:
        """Return the largest distance of a contact from what the slider turns about, m; 1 of a single ball."""
        a, b = self.slider.axis if self.slider.freedom == "axle" else (0.0, 0.0)
        return float(np.hypot(np.atleast_1d(self.slider.x) - a, np.atleast_1d(self.slider.y) - b).max()) or 1.0


def at_rest() -> np.ndarray:
    """Return the state of a slider at rest at its place."""
    return np.zeros(6)
