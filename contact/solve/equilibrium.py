r"""The averaged steady state: cycle means in balance at constant height and velocity.

A slider that is heavy on the wave's time scale keeps height h and velocity v through a cycle. h follows from
<sum P_i> = preload (`limits.riding_height`), v from <sum Q_i>(v) = R_t v + load, with the mean between exact events.
Error O((f_n/f)^2) against the full motion.

Held: a contact that can stick for good keeps the deformation it was left with, so the wave alone leaves a whole
interval of mean tractions, from the one it settles to from below to the one from above. If the load lies in it, v is
exactly 0.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import scaling
from contact.convergence import ConvergenceError
from contact.orbit import Orbit
from contact.slider import Slider
from contact.solve.collocation import collocation
from contact.solve.energy import SUPPORT, TRACTION
from contact.solve.event_driven import TALLY
from contact.solve.limits import riding_height
from contact.solve.motion import Motion

NODES, TRUNCATION = 14, 1e-11


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged steady state, in the units of `problem`; phase 0 is the trough of the first contact.

    Attributes
    ----------
    problem : scaling.Scaled
        With the load against the direction of the unloaded motion.
    height : float
        Mean approach h.
    speed : float
        v.
    held : bool
        True: a sticking contact keeps the slider at rest.
    motion : Motion
        At the end of a repeating cycle at constant height and velocity; its tally is of that cycle.
    work : (11,) int array
        Stretches, halvings, sweeps, cycles computed (`event_driven.STRETCHES` and so on).
    """

    problem: scaling.Scaled
    height: float
    speed: float
    held: bool
    motion: Motion
    work: np.ndarray

    @property
    def support(self) -> float:
        """Mean of the normal forces over the cycle, scaled."""
        return float(self.motion.sums[SUPPORT]) / (2.0 * math.pi)


def balanced(slider: Slider, orbits: tuple[Orbit, ...]) -> Balance:
    """Return the averaged steady state; the crests should drive towards +x (`drive.towards_plus`)."""
    # at the trough the contact is parted or slips, and old deformation is forgotten
    start = math.pi - float(np.angle(orbits[0].normal)) if orbits[0].normal != 0 else 0.0
    problem = scaling.scaled(slider, orbits, direction=1.0, start=start)
    high = riding_height(slider, orbits) / problem.length
    work = np.zeros(TALLY, np.int64)
    found = _at_height(slider, orbits, problem, start, high, work)
    if problem.parameters[scaling.LAW] != scaling.RECIPROCAL:
        return found
    # the back force only adds to the support, so the slider rides higher: mean approach below `high`
    preload = problem.parameters[scaling.PRELOAD]
    low = -max(abs(orbit.normal) for orbit in orbits) / problem.length
    above, below = found.support - preload, -preload
    for count in range(100):
        middle = high - above * (high - low) / (above - below)
        if not low < middle < high or count % 8 == 7:
            middle = 0.5 * (low + high)
        found = _at_height(slider, orbits, problem, start, middle, work)
        excess = found.support - preload
        if abs(excess) < 1e-12 * preload or high - low < 1e-14 * (1.0 + abs(high)):
            break
        if excess > 0.0:
            high, above, below = middle, excess, below * 0.5
        else:
            low, below, above = middle, excess, above * 0.5
    return found


def _at_height(slider, orbits, problem, start, height, work):
    """Return the balance of the tractions at one mean approach."""
    far = 10.0 * (1.0 + abs(height)) * (1.0 + slider.limit_slope)
    low, low_motion = traction(problem, height, 0.0, -far, work)
    high, high_motion = traction(problem, height, 0.0, far, work)
    rounding = 1e-13 * problem.parameters[scaling.MU] * problem.parameters[scaling.PRELOAD]
    if high < 0.0 and slider.load > 0.0:  # this wave drives against its crests
        problem = scaling.scaled(slider, orbits, direction=-1.0, start=start)
    load = problem.parameters[scaling.LOAD]
    if low > load + rounding:
        speed, motion = _balance(problem, height, 1.0, low, load, work)
        return Balance(problem=problem, height=height, speed=speed, held=False, motion=motion, work=work)
    if high < load - rounding:
        speed, motion = _balance(problem, height, -1.0, high, load, work)
        return Balance(problem=problem, height=height, speed=speed, held=False, motion=motion, work=work)
    below, above = low_motion.state[3:], high_motion.state[3:]
    motion = low_motion
    a, b = 0.0, 1.0
    for _ in range(50 if high > low + rounding else 0):
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
    problem = scaling.scaled(slider, orbits, direction=1.0, start=0.0)
    height = riding_height(slider, orbits) / problem.length
    far = 10.0 * (1.0 + abs(height)) * (1.0 + slider.limit_slope)
    highest, _ = traction(problem, height, 0.0, far, np.zeros(TALLY, np.int64))
    return -1.0 if highest < 0.0 else 1.0


def traction(problem, height, speed, deformations, work):
    """Return (<sum Q>, motion) of a repeating cycle at constant height and velocity, from given deformations."""
    motion = Motion(scaling.unmoved(problem), table=collocation(NODES), truncation=TRUNCATION)
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


def _balance(problem, height, way, rest_traction, load, work):
    """Return (v, motion) at <sum Q>(v) = d_t v + load; v has the sign `way`. Regula falsi, Anderson-Bjorck."""
    damping = problem.parameters[scaling.TANGENTIAL_DAMPING]
    top = 1.05 * max(float(np.hypot(*wave[2:])) for wave in problem.waves)
    a, fa = 0.0, rest_traction - load
    b, fb, motion = way * top, fa, None
    deformation = 0.0
    for _ in range(60):
        fb, motion = traction(problem, height, b, deformation, work)
        fb -= damping * b + load
        if fb * way < 0.0 or damping == 0.0:
            break
        b *= 2.0  # a load that drags the slider along is only bounded by the damper
    if fb * way >= 0.0:
        raise ConvergenceError(
            "runaway",
            "friction cannot balance the load at any speed and no tangential damping bounds it; "
            "lower slider.load or give slider.damping.tangential",
        )
    v = b
    for count in range(100):
        width = abs(b - a)
        v = b - fb * (b - a) / (fb - fa)
        if not min(a, b) < v < max(a, b) or count % 12 == 11:
            v = 0.5 * (a + b)
        f, motion = traction(problem, height, v, motion.state[3:], work)
        f -= damping * v + load
        if (f > 0.0) == (fb > 0.0):
            kept = 1.0 - f / fb
            fa *= kept if kept > 0.0 else 0.5
            b, fb = v, f
        else:
            a, fa, b, fb = b, fb, v, f
        if f == 0.0 or abs(f) < 1e-12 * abs(rest_traction) or abs(b - a) < 1e-12 * top or width == 0.0:
            break
    return v, motion
