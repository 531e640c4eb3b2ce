r"""The averaged equilibrium of any law, as a cycle that the event-driven solver can go on from.

A slider that is heavy on the wave's time scale keeps height h and velocity v through a cycle. h follows from
<sum P_i> = preload (`solve.riding`), v from <sum Q_i>(v) = R_t v + load. The elastic law's means are in closed
form between events, and `averaged` has found h and v already (`cycle_at`); for the other laws the mean tangential force
comes from a cycle of the event-driven solver (`balanced`). Bracket and rules are those of `averaged`. Error
O((f_n/f)^2) against the full motion.

Held: a contact that can stick for good keeps the deformation it was left with, so the wave alone leaves a whole
interval of mean tractions, from the one it settles to from below to the one from above. If the load lies in it, v is
exactly 0.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.codes import Law
from contact.convergence import ConvergenceError
from contact.kinematics import normal_amplitude
from contact.orbit import Orbit
from contact.problem import Problem, immobile, scaled
from contact.slider import Slider
from contact.solve.averaged import full_slip_speed, way_out
from contact.solve.collocation import collocation
from contact.solve.energy import SUPPORT, TRACTION
from contact.solve.event_driven import TALLY
from contact.solve.motion import Motion
from contact.solve.riding import riding_approach
from contact.solve.roots import bracketed, narrowed, trial

NODES, TRUNCATION = 14, 1e-11


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged steady state, in the units of `problem`; phase 0 is the trough of the first contact."""

    problem: Problem  # With the load against the direction of the unloaded motion
    height: float  # Mean approach h
    speed: float  # v
    held: bool  # True: a sticking contact keeps the slider at rest
    # At the end of a repeating cycle at constant height and velocity; its tally is of that cycle
    motion: Motion
    # (11,) int array: Stretches, halvings, sweeps, cycles computed (`event_driven.STRETCHES` and so on)
    work: np.ndarray

    @property
    def load_sign(self) -> float:
        """+1 or -1: the direction of motion that the load opposes."""
        return -1.0 if self.problem.load < 0.0 else 1.0

    @property
    def support(self) -> float:
        """Mean of the normal forces over the cycle, scaled."""
        return float(self.motion.sums[SUPPORT]) / (2.0 * math.pi)


def balanced(slider: Slider, orbits: tuple[Orbit, ...]) -> Balance:
    """Return the averaged steady state; the crests should drive towards +x (`drive.towards_plus`)."""
    start = trough(orbits)
    problem = scaled(slider, orbits, direction=1.0, start=start)
    high, work = riding_approach(problem), np.zeros(TALLY, np.int64)
    if problem.law != Law.RECIPROCAL:
        return _at_height(slider, orbits, problem, start, high, work)
    # the back force only adds to the support, so the slider rides higher: mean approach below `high`
    every, preload = np.arange(problem.contacts), problem.preload
    low, found = -float(np.max(normal_amplitude(problem.paths, every) + problem.paths.height)), None

    def excess(height):
        nonlocal found
        if height <= low:
            return -preload
        found = _at_height(slider, orbits, problem, start, height, work)
        surplus = found.support - preload
        return surplus if abs(surplus) > 1e-12 * preload else 0.0

    bracketed(excess, low, high, tolerance=1e-14 * (1.0 + abs(high)))
    return found


def cycle_at(
    slider: Slider, orbits: tuple[Orbit, ...], *, height: float, velocity: float, held: bool, load_sign: float
) -> Balance:
    """Return the balance at an approach in m and a velocity in m/s that are known to be in equilibrium.

    `load_sign` as in `answers.sweep.MeanMotion`; the orbits as for `balanced`.
    """
    problem = scaled(slider, orbits, direction=load_sign, start=trough(orbits))
    height, work = height / problem.length, np.zeros(TALLY, np.int64)
    if held:
        return _held(problem, height, _rest_cycles(problem, height, work), work)
    speed = velocity / problem.speed
    _, motion = traction(problem, height, speed, 0.0, work)
    return Balance(problem=problem, height=height, speed=speed, held=False, motion=motion, work=work)


def trough(orbits):
    """Return the phase at which the first contact is parted or slips, so that old deformation is forgotten."""
    return math.pi - float(np.angle(orbits[0].normal)) if orbits[0].normal != 0 else 0.0


def _rest_cycles(problem, height, work):
    """Return (mean tangential force, motion) at rest of the least and of the largest deformations."""
    far = 10.0 * (1.0 + abs(height)) * (1.0 + problem.limit_slope)
    return traction(problem, height, 0.0, -far, work), traction(problem, height, 0.0, far, work)


def _at_height(slider, orbits, problem, start, height, work):
    """Return the balance of the tractions at one mean approach."""
    rest = _rest_cycles(problem, height, work)
    (least, _), (largest, _) = rest
    way, load = way_out(least, largest, problem.load, problem.friction * problem.preload)
    if load < 0.0:  # this wave drives against its crests
        problem = scaled(slider, orbits, direction=-1.0, start=start)
    if way == 0.0:
        return _held(problem, height, rest, work)
    speed, motion = _balance(problem, height, way, least if way > 0.0 else largest, work)
    return Balance(problem=problem, height=height, speed=speed, held=False, motion=motion, work=work)


def _held(problem, height, rest, work):
    """Return the balance of a slider at rest: deformations between the extreme ones that carry the load."""
    (least, low_motion), (largest, high_motion) = rest
    load, rounding = problem.load, 1e-13 * problem.preload
    rounding *= problem.friction
    below, above = low_motion.state[3:], high_motion.state[3:]
    motion = low_motion
    a, b = 0.0, 1.0
    for _ in range(50 if largest > least + rounding else 0):
        middle = 0.5 * (a + b)
        mean, motion = traction(problem, height, 0.0, (1.0 - middle) * below + middle * above, work)
        if abs(mean - load) < 1e3 * rounding:
            break
        a, b = (a, middle) if mean > load else (middle, b)
    return Balance(problem=problem, height=height, speed=0.0, held=True, motion=motion, work=work)


def opposed(slider: Slider, orbits: tuple[Orbit, ...]) -> float:
    """Return +1 or -1, the direction of motion that a load opposes: that in which the unloaded wave drives at rest."""
    if slider.load == 0.0 or slider.friction_coefficient * slider.preload == 0.0:
        return 1.0
    problem = scaled(slider, orbits, direction=1.0, start=0.0)
    height = riding_approach(problem)
    _, (largest, _) = _rest_cycles(problem, height, np.zeros(TALLY, np.int64))
    return -1.0 if largest < 0.0 else 1.0


def traction(problem, height, speed, deformations, work):
    """Return (<sum Q>, motion) of a repeating cycle at constant height and velocity, from given deformations."""
    motion = Motion(immobile(problem), grid=collocation(NODES), truncation=TRUNCATION)
    motion.place(-height, 0.0, speed, deformations)
    for turn in range(6):
        before = motion.state[3:].copy()
        motion.tally[:], motion.sums[:] = 0, 0.0
        motion.turn(1, mobile=False)
        work += motion.tally
        # a memory repeats a cycle after the deformation does
        settled = turn > 1 or motion.memory is None
        if settled and np.max(np.abs(motion.state[3:] - before)) < 1e-13:
            break
    return motion.sums[TRACTION] / (2.0 * math.pi), motion


def _balance(problem, height, way, rest_traction, work):
    """Return (v, motion) at <sum Q>(v) = d_t v + load; v has the sign `way`."""
    damping, load = problem.tangential_damping, problem.load
    top = full_slip_speed(problem)

    def excess(v, deformation):
        mean, motion = traction(problem, height, v, deformation, work)
        return mean - damping * v - load, motion

    a, fa, b = 0.0, rest_traction - load, way * top
    fb, motion = excess(b, 0.0)
    if fb * way >= 0.0:  # full friction does not balance the load: the damper has to
        if damping == 0.0:
            raise ConvergenceError(
                "runaway",
                "friction cannot balance the load at any speed and no tangential damping bounds it; "
                "lower slider.load or give slider.damping.tangential",
            )
        b += 1.000001 * fb / damping
        fb, motion = excess(b, 0.0)
    v = b
    for count in range(100):
        width = abs(b - a)
        v = trial(a, fa, b, fb, count)
        f, motion = excess(v, motion.state[3:])
        a, fa, b, fb = narrowed(a, fa, b, fb, v, f)
        if f == 0.0 or abs(f) < 1e-12 * abs(rest_traction) or abs(b - a) < 1e-12 * top or width == 0.0:
            break
    return v, motion
