r"""The periodic motion of a slider whose contacts do not slip, in harmonics of the wave: the full equations.

Without an event the forces of a cycle are smooth, and the motion follows from their harmonics,

    z_s = -h + sum N_n exp(i n phi)/(-n^2 + i n d_n),    N the normal force on the slider,

with h such that the mean of N is the preload; the travel follows from Q likewise. A slider that is heavy on the wave's
time scale hardly answers, so that the fixed point of this map is reached in a few rounds, each of which gains a factor
of about (f_n/f)^2. The normal motion holds up to the amplitude at which the first contact parts, whether contacts slip
or not; the tangential one up to that at which the first contact slips.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from contact.body import Coordinates, approach, approach_rate, at_phase, contact_force
from contact.convergence_error import ConvergenceError
from contact.law.elastic import tangential_force
from contact.law.normal import load, slope
from contact.problem import Problem

ROUNDS, CLOSE = 60, 1e-13


class NormalMotion(NamedTuple):
    """The normal motion at evenly spaced phases of a cycle."""

    phases: np.ndarray  # (m,)
    approaches: np.ndarray  # (n, m): of the contacts


def normal_motion(problem: Problem, height: float, samples: int) -> NormalMotion:
    """Return the periodic normal motion, from a mean approach near `height`; contacts are not parted for long."""
    phases, every = 2.0 * math.pi * np.arange(samples) / samples, np.arange(problem.contacts)[:, None]
    u_z, u_z_rate, _, _ = at_phase(problem.paths, every, np.cos(phases), np.sin(phases))
    h = height
    fast: Any = np.zeros(samples)
    fast_rate: Any = np.zeros(samples)
    for _ in range(ROUNDS):
        z = approach(problem.paths, every, u_z, Coordinates(fast - h, 0.0))
        rate = approach_rate(u_z_rate, Coordinates(fast_rate, 0.0))
        push = contact_force(problem, problem.stiffness * load(z, problem.shape), rate).sum(axis=0)
        step = (problem.preload - push.mean()) / float(
            problem.stiffness * slope(z, problem.shape).sum(axis=0).mean()
        )
        moved, fast_rate = _answer(push, problem.normal_damping)
        change, h, fast = float(np.max(np.abs(moved - fast))) + abs(step), h + step, moved
        if not change < 1e6:
            break
        if change < CLOSE * (1.0 + abs(h)):
            return NormalMotion(phases, z)
    raise ConvergenceError("not converged", "the slider answers too strongly within a cycle")


class Room(NamedTuple):
    """What is left to contacts that stick with the largest or the least offsets."""

    forward: np.ndarray  # (n,): by which the deformations may grow until slip
    backward: np.ndarray  # by which they may fall
    traction: float  # mean of sum Q


def room_to_stick(problem: Problem, motion: NormalMotion, side: float) -> Room:
    """Return the room of contacts that stick all the time, each as far towards `side` as it can without slip."""
    z, every, c = motion.approaches, np.arange(problem.contacts)[:, None], problem.limit_slope
    _, _, u_x, _ = at_phase(problem.paths, every, np.cos(motion.phases), np.sin(motion.phases))
    fast, friction = np.zeros(z.shape[1]), problem.friction * problem.stiffness
    for _ in range(ROUNDS):
        way = u_x - fast
        forward, backward = least(c * z - way), least(c * z + way)
        offset = forward if side > 0.0 else -backward
        pull = tangential_force(way + offset[:, None], z, friction, c, problem.shape).sum(axis=0)
        moved, _ = _answer(pull, problem.tangential_damping)
        change, fast = float(np.max(np.abs(moved - fast))), moved
        if change < CLOSE * (1.0 + float(np.max(np.abs(u_x)))):
            return Room(forward, backward, float(pull.mean()))
        if not change < 1e6:
            break
    raise ConvergenceError("not converged", "the slider answers too strongly within a cycle")


def least(values: np.ndarray) -> np.ndarray:
    """Return the least values of periodic rows, by a parabola through the least sample and its neighbours."""
    rows, at = np.arange(len(values)), np.argmin(values, axis=1)
    low, mid, high = (values[rows, (at + k) % values.shape[1]] for k in (-1, 0, 1))
    bend = low - 2.0 * mid + high
    return mid - np.divide((high - low) ** 2, 8.0 * bend, out=np.zeros_like(mid), where=bend > 0.0)


def _answer(force, damping):
    """Return the motion that the alternating part of a force drives, and its rate."""
    harmonics = np.fft.rfft(force)
    n = np.arange(harmonics.size)
    n[0] = 1
    harmonics[0] = 0.0
    moved = harmonics / (-(n**2) + 1j * n * damping)
    return np.fft.irfft(moved, force.size), np.fft.irfft(1j * n * moved, force.size)
