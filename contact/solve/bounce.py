r"""A bounce that nothing damps, and the slider's mean velocity while it goes on.

A slider that starts from rest falls towards its riding height and swings about it. With h the mean approach, V the mean
velocity and <> the cycle means at constant height and velocity,

    h'' = p - <sum P>(h),    0 = mean over the bounce of <sum Q>(h, V) - d_t V - q:

without normal damping h swings for ever between the approach at rest and its counterpart, h'^2/2 = int (p - <sum P>) dh
(V then is not that of the periodic motion, whose height is constant). First-order averaging: error O((f_n/f)^2).
"""

import math

import numpy as np

from contact.kinematics import tangential_amplitude
from contact.problem import Problem
from contact.solve.collocation import SMOOTH, collocation
from contact.solve.cycle_mean import NORMAL, TANGENTIAL, cycle, cycle_room
from contact.solve.riding import quadrature
from contact.solve.roots import bracketed

NODES = 32  # from one turning point to the other


def speed_lost(problem: Problem, rest: float, level: float, near: float) -> float:
    """Return by how much a bounce that goes on for ever changes the mean velocity, scaled, or NaN.

    `rest`: approach at rest, where the bounce begins; `level` and `near`: mean approach and velocity of the periodic
    motion. The law is the elastic one.
    """
    if abs(level - rest) < 1e-9 * (abs(level) + abs(rest)):
        return 0.0  # the slider rides where it rests
    rule, work = quadrature(12), cycle_room(1)

    def means(height, speed):
        cycle(problem, height, speed, rule, work)
        return float(work.means[NORMAL]), float(work.means[TANGENTIAL])

    found = _half_bounce(lambda h: problem.preload - means(h, 0.0)[0], rest, level)
    if found is None:
        return math.nan
    heights, weights = found
    still = _balanced_speed(problem, means, [level], [1.0], near)
    return _balanced_speed(problem, means, heights, weights, near) - still


def _balanced_speed(problem, means, heights, weights, near):
    """Return the velocity at which the mean tangential force over some heights balances damper and load, or NaN."""

    def excess(speed):
        mean = sum(w * means(h, speed)[1] for h, w in zip(heights, weights, strict=True))
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
