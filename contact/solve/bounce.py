r"""A bounce that nothing damps, and the slider's mean velocity while it goes on.

A slider that starts from rest falls towards its riding height and swings about it. With h the mean approach, V the mean
velocity and <> the cycle means at constant height and velocity,

    h'' = p - <sum P>(h),    0 = mean over the bounce of <sum Q>(h, V) - d_t V - q:

without normal damping h swings for ever between the approach at rest and its counterpart, and V is another than that of
the periodic motion, whose height is constant. First-order averaging: error O((f_n/f)^2).
"""

import math

import numpy as np

from contact.kinematics import tangential_amplitude
from contact.problem import Problem
from contact.solve.cycle_mean import NORMAL, TANGENTIAL, cycle, cycle_room
from contact.solve.riding import quadrature
from contact.solve.roots import bracketed

# steps of the classical Runge-Kutta method per period of the small bounce, and at most in half a bounce
PER_PERIOD, MAX_STEPS = 48, 4000


class CycleMeans:
    """Cycle means of the elastic law at constant height and velocity."""

    def __init__(self, problem: Problem):
        self.problem, self.rule, self.work = problem, quadrature(12), cycle_room(1)

    def forces(self, height: float, speed: float) -> tuple[float, float]:
        """Return (<sum P>, <sum Q>)."""
        cycle(self.problem, height, speed, self.rule, self.work)
        return float(self.work.means[NORMAL]), float(self.work.means[TANGENTIAL])


def speed_lost(problem: Problem, heights: tuple[float, float], ratio: float, near: float) -> float:
    """Return by how much a bounce from rest that goes on for ever changes the mean velocity, scaled, or NaN.

    `heights`: approach at rest, where the bounce begins, and mean approach of the periodic motion; `ratio`: contact
    resonance over the frequency of the wave; `near`: velocity of the periodic motion. The law is the elastic one.
    """
    means = CycleMeans(problem)
    steady = _balanced_speed(means, [heights[1]], [1.0], near)
    bounce = _half_bounce(means, heights[0], 2.0 * math.pi / (ratio * PER_PERIOD))
    return _balanced_speed(means, *bounce, near) - steady


def _balanced_speed(means, heights, weights, near):
    """Return the velocity at which the mean tangential force over some heights balances damper and load, or NaN."""
    problem = means.problem

    def excess(speed):
        mean = sum(w * means.forces(h, speed)[1] for h, w in zip(heights, weights, strict=True))
        return mean - problem.tangential_damping * speed - problem.load

    reach = 1.05 * float(np.max(tangential_amplitude(problem.paths, np.arange(problem.contacts))))
    step = 0.05 * max(abs(near), 0.1 * reach)
    low = high = near
    for _ in range(40):
        if excess(low) < 0.0:
            low -= step
        elif excess(high) > 0.0:
            high += step
        else:
            return bracketed(excess, low, high, tolerance=1e-9 * reach)
        step *= 2.0
    return math.nan


def _half_bounce(means, rest, step):
    """Return heights from one turning point to the other and their weights in time, which sum to one."""
    preload = means.problem.preload

    def fall(height):
        return preload - means.forces(height, 0.0)[0]

    h, w = rest, 0.0
    heights, times = [h], [0.0]
    falling = fall(h) < 0.0
    for _ in range(MAX_STEPS):
        a1 = fall(h)
        a2 = fall(h + 0.5 * step * w)
        a3 = fall(h + 0.5 * step * (w + 0.5 * step * a1))
        a4 = fall(h + step * (w + 0.5 * step * a2))
        new_h = h + step * w + step**2 / 6.0 * (a1 + a2 + a3)
        new_w = w + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        if (new_w > 0.0) == falling and len(heights) > 1:
            last = step * w / (w - new_w)
            heights.append(h + 0.5 * last * w)
            times.append(times[-1] + last)
            break
        h, w = new_h, new_w
        heights.append(h)
        times.append(times[-1] + step)
    time = np.array(times)
    weights = np.zeros(time.size)
    gaps = np.diff(time)
    weights[:-1] += 0.5 * gaps
    weights[1:] += 0.5 * gaps
    return heights, weights / time[-1]
