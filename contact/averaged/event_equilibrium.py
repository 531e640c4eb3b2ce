r"""Averaged equilibrium of any contact law, with a cycle from which the event-driven solver can continue.

For the elastic law `steady_sweep.mean_motion` computes height h and velocity v, because its cycle means have closed
forms between events; `cycle_at` adds the event-driven cycle at this h and v. For the other laws `balanced` computes h
and v: the mean tangential force comes from a cycle of the event-driven solver, and `equilibrium.balanced_speed`
searches v. The docstring of `answers.steady` states when a slider is held. The error with respect to the full motion is
O((f_n/f)^2).

At rest the mean tangential force is not unique: a contact that sticks all the time keeps the deformation that its
history left. It lies between two values, those after an approach from far behind and from far ahead, which push each
contact to the smallest and to the largest deformation that its slip limits allow.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contact.averaged.equilibrium import balanced_speed, full_slip_speed, net_force
from contact.averaged.riding import riding_approach, riding_height
from contact.body import normal_amplitude
from contact.codes import Status, Tangential
from contact.events.collocation import collocation
from contact.events.energy import EnergySum
from contact.events.motion import Motion
from contact.exceptions import RUNAWAY, ConvergenceError
from contact.orbit import Orbits, as_orbits
from contact.problem import Problem, full_friction, immobile, load_direction, scaled
from contact.roots import bracketed
from contact.slider import Slider

NODES, TRUNCATION = 14, 1e-11  # of a segment in the cycles
CLOSE = 1e-12  # tolerance of the velocity, relative to the velocity of full slip


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged equilibrium in the units of `problem`; phase 0 is the trough of the first contact."""

    problem: Problem  # its load opposes the unloaded motion
    height: float  # mean approach h
    speed: float  # v
    held: bool  # True if a sticking contact keeps the slider at rest
    # after a repeating cycle at constant height and velocity; its tally and sums cover that cycle; None before
    followed: Motion | None = None

    @cached_property
    def motion(self) -> Motion:
        """The motion after a repeating cycle, as `followed`."""
        if self.followed is not None:
            return self.followed
        return mean_tangential_force(self.problem, self.height, self.speed, 0.0)[1]

    @property
    def load_sign(self) -> float:
        """Direction of motion that the load opposes, +1 or -1."""
        return -1.0 if self.problem.load < 0.0 else 1.0


def balanced(slider: Slider, orbits) -> Balance:
    """Return the averaged equilibrium; the wave crests must drive towards +x (`orbit.towards_plus`)."""
    orbits = as_orbits(orbits)
    problem = scaled(slider, orbits, direction=1.0, start=trough(orbits))
    elastic_height = _riding_height(slider, orbits, problem)
    if problem.law.kind != Tangential.RECIPROCAL:
        return _at_height(problem, elastic_height)
    # The reciprocal force adds to the support, so that the mean approach is smaller than without it. At the lower bound
    # no contact touches in the whole cycle.
    every, preload = np.arange(problem.contacts), problem.preload
    no_contact = -float(np.max(normal_amplitude(problem.paths, every) + problem.paths.height))
    balances: list[Balance] = []  # at the heights that the search has tried

    def excess(height):
        """Return the mean normal force less the preload."""
        if height <= no_contact:
            return -preload
        balances.append(_at_height(problem, height))
        surplus = float(balances[-1].motion.sums[EnergySum.NORMAL_FORCE]) / (2.0 * math.pi) - preload
        return surplus if abs(surplus) > 1e-12 * preload else 0.0

    bracketed(excess, no_contact, elastic_height, tolerance=1e-14 * (1.0 + abs(elastic_height)))
    return balances[-1]


def _riding_height(slider, orbits, problem):
    """Return the mean approach at which the mean elastic and attractive forces carry the preload."""
    if problem.normal.hold is None:
        return riding_approach(problem)
    return riding_height(slider, orbits) / problem.length


def cycle_at(
    slider: Slider, orbits: Orbits, *, height: float, velocity: float, held: bool, load_sign: float
) -> Balance:
    """Return the equilibrium at a known mean approach in m and a known velocity in m/s.

    `load_sign` is that of `steady_sweep.MeanMotion`; the orbits are those of `balanced`.
    """
    problem = scaled(slider, orbits, direction=load_sign, start=trough(orbits))
    height, speed = height / problem.length, velocity / problem.speed
    if held:
        return _held(problem, height, _rest_cycles(problem, height))
    return Balance(problem=problem, height=height, speed=speed, held=False)


def trough(orbits):
    """Return the phase of the trough of u_z, where the first contact is separated or slips.

    A cycle starts there because the deformation at its start is then forgotten. Without normal motion it is 0.
    """
    return math.pi - float(np.angle(orbits.normal[0])) if orbits.normal[0] != 0 else 0.0


def _rest_cycles(problem, height):
    """Return (mean tangential force, motion) at v = 0 for the smallest and for the largest possible deformations."""
    far = 10.0 * (1.0 + abs(height)) * (1.0 + problem.limit_slope)  # beyond every slip limit
    return mean_tangential_force(problem, height, 0.0, -far), mean_tangential_force(problem, height, 0.0, far)


def _at_height(problem, height):
    """Return the equilibrium of the tangential forces at one mean approach."""
    rest = _rest_cycles(problem, height)
    (least, _), (largest, _) = rest
    # the sign of the load changes if the wave drives against its crests
    problem, means = problem._replace(load=problem.load * load_direction(largest)), EventCycles(height)
    fastest = full_slip_speed(problem.paths, problem.limit_slope)
    search = balanced_speed(problem, means, least, largest, fastest, CLOSE)
    if search.status == Status.RUNAWAY:
        raise ConvergenceError("runaway", RUNAWAY)
    if search.way == 0.0:
        return _held(problem, height, rest)
    return Balance(problem=problem, height=height, speed=search.velocity, held=False, followed=means.motion)


def _held(problem, height, rest):
    """Return the equilibrium of a held slider, for which bisection yields deformations whose force carries the load.

    The deformations are interpolated between the smallest and the largest ones of `rest` (`_rest_cycles`).
    """
    (least, motion), (largest, largest_motion) = rest
    smallest_x, largest_x = motion.carried.deformation, largest_motion.carried.deformation
    rounding, a, b = 1e-13 * full_friction(problem), 0.0, 1.0
    if largest > least + rounding:
        for _ in range(50):
            middle = 0.5 * (a + b)
            start = (1.0 - middle) * smallest_x + middle * largest_x
            mean, motion = mean_tangential_force(problem, height, 0.0, start)
            if abs(mean - problem.load) < 1e3 * rounding:
                break
            a, b = (a, middle) if mean > problem.load else (middle, b)
    return Balance(problem=problem, height=height, speed=0.0, held=True, followed=motion)


def event_rest_forces(problem: Problem) -> tuple[float, float]:
    """Return the extreme mean tangential forces of a cycle at rest, as `equilibrium.rest_forces`, of any law."""
    (least, _), (largest, _) = _rest_cycles(problem, riding_approach(problem))
    return float(least), float(largest)


def event_tangential_forces(problem: Problem, speeds: np.ndarray) -> np.ndarray:
    """Return the mean tangential forces at constant velocities, as `equilibrium.mean_tangential_forces`, of any law."""
    height = riding_approach(problem)
    return np.array([mean_tangential_force(problem, height, float(v), 0.0)[0] for v in speeds])


def opposed(slider: Slider, orbits: Orbits) -> float:
    """Return the direction of motion that a load opposes (`problem.load_direction`)."""
    if slider.load == 0.0 or slider.static_coefficient * slider.preload == 0.0:
        return 1.0
    problem = scaled(slider, orbits, direction=1.0, start=0.0)
    _, (largest, _) = _rest_cycles(problem, _riding_height(slider, orbits, problem))
    return load_direction(largest)


def mean_tangential_force(problem, height, speed, deformations):
    """Return (<sum Q>, motion) of a repeating cycle at constant height and velocity, started from `deformations`."""
    motion = Motion(immobile(problem), grid=collocation(NODES), truncation=TRUNCATION)
    motion.set_state(-height, 0.0, speed, deformations)
    for turn in range(6):
        before = motion.carried.deformation.copy()
        motion.tally[:], motion.sums[:] = 0, 0.0
        motion.turn(1, mobile=False)
        # the memory of a hysteretic contact becomes periodic one cycle after its deformation
        settled = turn > 1 or motion.memory is None
        if settled and np.max(np.abs(motion.carried.deformation - before)) < 1e-13:
            break
    return motion.sums[EnergySum.TANGENTIAL_FORCE] / (2.0 * math.pi), motion


class EventCycles:
    """Cycle means of the event-driven solver at one height; each cycle starts from the deformations of the last."""

    def __init__(self, height: float):
        self.height, self.motion = height, None

    @staticmethod
    def net_force(problem: Problem, means: "EventCycles", v: float) -> float:
        """Return the mean tangential force less load and damper, which accelerates the slider at the velocity v."""
        deformations = 0.0 if means.motion is None else means.motion.carried.deformation
        mean, means.motion = mean_tangential_force(problem, means.height, v, deformations)
        return net_force(problem, mean, v)
