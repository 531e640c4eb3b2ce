r"""The averaged equilibrium of any law, as a cycle that the event-driven solver can go on from.

The elastic law's means are in closed form between events, and its height h and velocity v are known (`cycle_at`); for
the other laws the mean tangential force comes from a cycle of the event-driven solver (`balanced`), the search for v is
that of `equilibrium`. `answers.steady` says when a slider is held. Error O((f_n/f)^2) against the full motion.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.averaged.equilibrium import balanced_speed, force_left, full_slip_speed, load_direction, way_out
from contact.averaged.riding import riding_approach
from contact.body import normal_amplitude
from contact.codes import Status, Tangential
from contact.convergence_error import ConvergenceError
from contact.events.collocation import collocation
from contact.events.energy import Sum
from contact.events.motion import Motion
from contact.orbit import Orbit
from contact.problem import Problem, immobile, scaled
from contact.roots import bracketed
from contact.slider import Slider

NODES, TRUNCATION = 14, 1e-11
CLOSE = 1e-12  # last step of the search for the velocity, over its range
RUNAWAY = (
    "friction cannot balance the load at any speed and no tangential damping bounds it; "
    "lower slider.load or give slider.damping.tangential"
)


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged steady state, in the units of `problem`; phase 0 is the trough of the first contact."""

    problem: Problem  # with the load against the direction of the unloaded motion
    height: float  # mean approach h
    speed: float  # v
    held: bool  # True: a sticking contact keeps the slider at rest
    motion: Motion  # at the end of a repeating cycle at constant height and velocity, its tally and sums of that cycle

    @property
    def load_sign(self) -> float:
        """+1 or -1: the direction of motion that the load opposes."""
        return -1.0 if self.problem.load < 0.0 else 1.0


def balanced(slider: Slider, orbits: tuple[Orbit, ...]) -> Balance:
    """Return the averaged steady state; the crests should drive towards +x (`drive.towards_plus`)."""
    problem = scaled(slider, orbits, direction=1.0, start=trough(orbits))
    high = riding_approach(problem)
    if problem.law.kind != Tangential.RECIPROCAL:
        return _at_height(problem, high)
    # the back force only adds to the support, so the slider rides higher: mean approach below `high`
    every, preload = np.arange(problem.contacts), problem.preload
    low, found = -float(np.max(normal_amplitude(problem.paths, every) + problem.paths.height)), None

    def excess(height):
        nonlocal found
        if height <= low:
            return -preload
        found = _at_height(problem, height)
        surplus = float(found.motion.sums[Sum.SUPPORT]) / (2.0 * math.pi) - preload
        return surplus if abs(surplus) > 1e-12 * preload else 0.0

    bracketed(excess, low, high, tolerance=1e-14 * (1.0 + abs(high)))
    return found


def cycle_at(
    slider: Slider, orbits: tuple[Orbit, ...], *, height: float, velocity: float, held: bool, load_sign: float
) -> Balance:
    """Return the balance at an approach in m and a velocity in m/s that are known to be in equilibrium.

    `load_sign` as in `sweep.MeanMotion`; the orbits as for `balanced`.
    """
    problem = scaled(slider, orbits, direction=load_sign, start=trough(orbits))
    height, speed = height / problem.length, velocity / problem.speed
    if held:
        return _held(problem, height, _rest_cycles(problem, height))
    _, motion = traction(problem, height, speed, 0.0)
    return Balance(problem=problem, height=height, speed=speed, held=False, motion=motion)


def trough(orbits):
    """Return the phase at which the first contact is parted or slips, so that old deformation is forgotten."""
    return math.pi - float(np.angle(orbits[0].normal)) if orbits[0].normal != 0 else 0.0


def _rest_cycles(problem, height):
    """Return (mean tangential force, motion) at rest of the least and of the largest deformations."""
    far = 10.0 * (1.0 + abs(height)) * (1.0 + problem.limit_slope)
    return traction(problem, height, 0.0, -far), traction(problem, height, 0.0, far)


def _at_height(problem, height):
    """Return the balance of the tractions at one mean approach."""
    rest = _rest_cycles(problem, height)
    (least, _), (largest, _) = rest
    way, load = way_out(least, largest, problem.load, problem.friction * problem.preload)
    problem = problem._replace(load=load)  # its sign is turned where the wave drives against its crests
    if way == 0.0:
        return _held(problem, height, rest)
    means = EventCycles(height)
    at_rest = least if way > 0.0 else largest
    found = balanced_speed(problem, means, way, at_rest, full_slip_speed(problem), CLOSE)
    if found.status == Status.RUNAWAY:
        raise ConvergenceError("runaway", RUNAWAY)
    return Balance(problem=problem, height=height, speed=found.velocity, held=False, motion=means.motion)


def _held(problem, height, rest):
    """Return the balance of a slider at rest: deformations between the extreme ones that carry the load."""
    (least, motion), (largest, high_motion) = rest
    below, above = motion.state[3:], high_motion.state[3:]
    rounding, a, b = 1e-13 * problem.preload * problem.friction, 0.0, 1.0
    for _ in range(50 if largest > least + rounding else 0):
        middle = 0.5 * (a + b)
        mean, motion = traction(problem, height, 0.0, (1.0 - middle) * below + middle * above)
        if abs(mean - problem.load) < 1e3 * rounding:
            break
        a, b = (a, middle) if mean > problem.load else (middle, b)
    return Balance(problem=problem, height=height, speed=0.0, held=True, motion=motion)


def opposed(slider: Slider, orbits: tuple[Orbit, ...]) -> float:
    """Return the direction of motion that a load opposes (`equilibrium.load_direction`)."""
    if slider.load == 0.0 or slider.static_coefficient * slider.preload == 0.0:
        return 1.0
    problem = scaled(slider, orbits, direction=1.0, start=0.0)
    _, (largest, _) = _rest_cycles(problem, riding_approach(problem))
    return load_direction(largest)


def traction(problem, height, speed, deformations):
    """Return (<sum Q>, motion) of a repeating cycle at constant height and velocity, from given deformations."""
    motion = Motion(immobile(problem), grid=collocation(NODES), truncation=TRUNCATION)
    motion.place(-height, 0.0, speed, deformations)
    for turn in range(6):
        before = motion.state[3:].copy()
        motion.tally[:], motion.sums[:] = 0, 0.0
        motion.turn(1, mobile=False)
        # a memory repeats a cycle after the deformation does
        settled = turn > 1 or motion.memory is None
        if settled and np.max(np.abs(motion.state[3:] - before)) < 1e-13:
            break
    return motion.sums[Sum.TRACTION] / (2.0 * math.pi), motion


class EventCycles:
    """Cycle means of the event-driven solver at one height, each from the deformations of the last one."""

    def __init__(self, height: float):
        self.height, self.motion = height, None

    @staticmethod
    def left(problem: Problem, means: "EventCycles", v: float) -> float:
        """Return the mean tangential force that is left to accelerate the slider at a velocity."""
        deformations = 0.0 if means.motion is None else means.motion.state[3:]
        mean, means.motion = traction(problem, means.height, v, deformations)
        return force_left(problem, mean, v)
