r"""A bounce that nothing damps, and the slider's mean velocity while it goes on.

A slider that starts from rest falls towards its riding height and swings about it. With h the mean approach, V the mean
velocity and <> the cycle means at constant height and velocity,

    h'' = p - <sum P>(h),    0 = mean over the bounce of <sum Q>(h, V) - d_t V - q:

without normal damping h swings for ever between the approach at rest and its counterpart, h'^2/2 = int (p - <sum P>) dh
(V then is not that of the periodic motion, whose height is constant). First-order averaging: error O((f_n/f)^2).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import Cycle, Mean, cycle, cycle_room
from contact.averaged.equilibrium import balanced_speed, force_left, full_slip_speed, way_out
from contact.averaged.riding import Rule, quadrature
from contact.codes import Status
from contact.events.collocation import SMOOTH, collocation
from contact.problem import Problem
from contact.roots import bracketed

NODES = 32  # from one turning point to the other


class Heights(NamedTuple):
    """Means over cycles at several heights, with weights."""

    heights: np.ndarray
    weights: np.ndarray
    rule: Rule
    work: Cycle
    left: Callable


def _left(problem, means, v):
    mean = 0.0
    for h, weight in zip(means.heights, means.weights, strict=True):
        cycle(problem, float(h), v, means.rule, means.work)
        mean += weight * float(means.work.means[Mean.TANGENTIAL])
    return force_left(problem, mean, v)


def speed_lost(problem: Problem, rest: float, level: float) -> float:
    """Return by how much a bounce that goes on for ever changes the mean velocity, scaled, or NaN.

    `rest`: approach at rest, where the bounce begins; `level`: mean approach of the periodic motion. The law is the
    elastic one.
    """
    if abs(level - rest) < 1e-9 * (abs(level) + abs(rest)):
        return 0.0  # the slider rides where it rests
    rule = quadrature(12)
    work = cycle_room(1)

    def push(h):
        cycle(problem, h, 0.0, rule, work)
        return problem.preload - float(work.means[Mean.NORMAL])

    found = _half_bounce(push, rest, level)
    if found is None:
        return math.nan
    heights, weights = found
    still = Heights(np.array([level]), np.ones(1), rule, work, _left)
    return _speed(problem, Heights(heights, weights, rule, work, _left)) - _speed(problem, still)


def _speed(problem, means):
    """Return the velocity at which the mean tangential force over some heights balances damper and load, or NaN."""
    least, largest = (_left(problem, means, v) + problem.load for v in (0.0, -1e-300))
    way, load = way_out(least, largest, problem.load, problem.friction * problem.preload)
    if way == 0.0:
        return 0.0
    at_rest = least if way > 0.0 else largest
    found = balanced_speed(problem._replace(load=load), means, way, at_rest, full_slip_speed(problem), 1e-9)
    return found.velocity if found.status == Status.DONE else math.nan


def _half_bounce(force, rest, level):
    """Return heights from one turning point to the other and their shares of the time; None if it does not turn."""
    grid = collocation(NODES)
    tau, areas = grid.tau[SMOOTH], grid.integrals[SMOOTH, 0]

    def bounce(far):
        heights = rest + (far - rest) * tau
        forces = np.array([force(height) for height in heights])
        return heights, forces, (far - rest) * (forces @ areas)

    far = 2.0 * level - rest
    while bounce(far)[2][-1] > 0.0:
        far += level - rest
    far = bracketed(lambda far: bounce(far)[2][-1], level, far, tolerance=1e-12 * abs(level - rest))
    heights, forces, energy = bounce(far)
    if not np.all(energy[1:-1] > 0.0):
        return None
    # dt = dh/h' with h = rest + (far - rest) (1 - cos theta)/2; at the ends h' vanishes with sin theta
    weights = np.sin(np.linspace(0.0, np.pi, NODES))
    weights[1:-1] /= np.sqrt(energy[1:-1])
    weights[[0, -1]] = 1.0 / np.sqrt(np.abs((far - rest) * forces[[0, -1]]))
    return heights, weights / np.sum(weights)
