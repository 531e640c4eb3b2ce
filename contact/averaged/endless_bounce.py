r"""Mean velocity of a slider whose undamped bounce never ends.

A slider that starts from rest moves towards its riding height and oscillates about it. With the mean approach h, the
mean velocity V and cycle means <> at constant height and velocity,

    h'' = p - <sum P>(h),    0 = mean over the bounce of [<sum Q>(h, V) - d_t V - q].

Without normal damping h oscillates between two turning points, the approach at rest and the point at which
h'^2/2 = int (p - <sum P>) dh vanishes again. V then differs from the velocity of the periodic motion, whose height is
constant. This is first-order averaging with an error of O((f_n/f)^2).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import cycle
from contact.averaged.cycle_pieces import BACKWARD, FORWARD, Cycle, Mean, cycle_arrays
from contact.averaged.equilibrium import balanced_speed, full_slip_speed, net_force
from contact.averaged.riding import Rule, quadrature
from contact.codes import Status
from contact.events.collocation import SMOOTH, collocation
from contact.problem import Problem, load_direction
from contact.roots import bracketed

NODES = 32  # between the two turning points
# Longest bounce over the distance from the start to the riding height. The nodes do not resolve the contact of a longer
# one: the energy is negative between them.
MAX_FLIGHT = 1e6


class Heights(NamedTuple):
    """Heights at which cycle means are taken, and their weights in the mean over the bounce."""

    heights: np.ndarray
    weights: np.ndarray
    rule: Rule
    work: Cycle
    net_force: Callable


def _net_force(problem, means, v, before=FORWARD):
    """Return the mean tangential force less load and damper, averaged over the heights; `before` as in `cycle`."""
    mean = 0.0
    for h, weight in zip(means.heights, means.weights, strict=True):
        cycle(problem, float(h), v, before, means.rule, means.work)
        mean += weight * float(means.work.means[Mean.TANGENTIAL])
    return net_force(problem, mean, v)


def speed_lost(problem: Problem, rest: float, level: float) -> float:
    """Return the change of the mean velocity by an undamped bounce, scaled; NaN if it cannot be computed.

    `rest` is the approach at rest, where the bounce starts. `level` is the mean approach of the periodic motion. The
    contact law is the elastic one.
    """
    if abs(level - rest) < 1e-9 * (abs(level) + abs(rest)):
        return 0.0  # the riding height is the height at rest: there is no bounce
    rule = quadrature(12)
    work = cycle_arrays(1)

    def acceleration(h):
        cycle(problem, h, 0.0, FORWARD, rule, work)
        return problem.preload - float(work.means[Mean.NORMAL])

    half_bounce = _half_bounce(acceleration, rest, level)
    if half_bounce is None:
        return math.nan
    heights, weights = half_bounce
    at_level = Heights(np.array([level]), np.ones(1), rule, work, _net_force)
    return _speed(problem, Heights(heights, weights, rule, work, _net_force)) - _speed(problem, at_level)


def _speed(problem, means):
    """Return the velocity at which the mean tangential force balances damper and load, NaN if the search fails."""
    least, largest = (_net_force(problem, means, 0.0, before) + problem.load for before in (FORWARD, BACKWARD))
    loaded = problem._replace(load=problem.load * load_direction(largest))
    search = balanced_speed(loaded, means, least, largest, full_slip_speed(problem.paths, problem.limit_slope), 1e-9)
    return search.velocity if search.status == Status.DONE else math.nan


def _half_bounce(force, rest, level):
    """Return (heights between the turning points, fractions of time spent there), or None without a turning point."""
    grid = collocation(NODES)
    tau, areas = grid.tau[SMOOTH], grid.integrals[SMOOTH, 0]

    def bounce(far):
        heights = rest + (far - rest) * tau
        forces = np.array([force(height) for height in heights])
        return heights, forces, (far - rest) * (forces @ areas)

    far = 2.0 * level - rest
    while bounce(far)[2][-1] > 0.0:  # a light preload lets the slider fly far
        far += far - level
        if abs(far) > MAX_FLIGHT * abs(level - rest):
            return None
    far = bracketed(lambda far: bounce(far)[2][-1], level, far, tolerance=1e-12 * abs(level - rest))
    heights, forces, energy = bounce(far)
    if not np.all(energy[1:-1] > 0.0):
        return None
    # dt = dh/h' with h = rest + (far - rest) (1 - cos theta)/2. At the ends both dh/dtheta and h' are proportional to
    # sin theta, and their ratio follows from the force there.
    weights = np.sin(np.linspace(0.0, np.pi, NODES))
    weights[1:-1] /= np.sqrt(energy[1:-1])
    weights[[0, -1]] = 1.0 / np.sqrt(np.abs((far - rest) * forces[[0, -1]]))
    return heights, weights / np.sum(weights)
