r"""Periodic motion of the full equations for sticking contacts, by harmonic balance.

If no event occurs in a cycle, the forces are smooth and the motion follows from their harmonics,

    z_s = -h + sum N_n exp(i n phi)/(-n^2 + i n d_n),    N the normal force on the slider,

where h is such that the mean of N equals the preload. The tangential motion follows in the same way from Q. A slider
that is heavy on the wave's time scale moves little within a cycle. Hence fixed-point iteration converges in a few
steps, each of which reduces the error by a factor of about (f_n/f)^2. The normal motion is valid up to the amplitude at
which the first contact separates, whether or not contacts slip. The tangential motion is valid up to the first slip.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from contact.body import Coordinates, approach, approach_rate, at_phase, contact_force, harmonic_response
from contact.exceptions import ConvergenceError
from contact.law.normal import load, slope
from contact.law.protocol import slip_limit
from contact.problem import Problem, contact_parameters

# maximum number of iterations, and relative change at which they stop
MAX_ITERATIONS, CLOSE = 60, 1e-13


class NormalMotion(NamedTuple):
    """Normal motion at m evenly spaced phases of a cycle."""

    phases: np.ndarray  # (m,)
    approaches: np.ndarray  # (n, m), by contact


def normal_motion(problem: Problem, height: float, samples: int) -> NormalMotion:
    """Return the periodic normal motion, iterated from the mean approach `height`.

    It is accurate only if no contact separates for a large part of the cycle.
    """
    phases, every = 2.0 * math.pi * np.arange(samples) / samples, np.arange(problem.contacts)[:, None]
    u_z, u_z_rate, _, _ = at_phase(problem.paths, every, np.cos(phases), np.sin(phases))
    contact, h = contact_parameters(problem, every), height
    fast: Any = np.zeros(samples)
    fast_rate: Any = np.zeros(samples)
    for _ in range(MAX_ITERATIONS):
        z = approach(problem.paths, every, u_z, Coordinates(fast - h, 0.0))
        rate = approach_rate(u_z_rate, Coordinates(fast_rate, 0.0))
        normal_force = contact_force(contact, contact.stiffness * load(z, contact.normal), rate).sum(axis=0)
        normal_force = normal_force - (contact.stiffness * contact.normal.pull).sum()
        rise = float((contact.stiffness * slope(z, contact.normal)).sum(axis=0).mean())
        step = (problem.preload - normal_force.mean()) / rise
        moved, fast_rate = _driven(normal_force, problem.normal_damping)
        change, h, fast = float(np.max(np.abs(moved - fast))) + abs(step), h + step, moved
        if not change < 1e6:
            break
        if change < CLOSE * (1.0 + abs(h)):
            return NormalMotion(phases, z)
    raise ConvergenceError("not converged", "the slider answers too strongly within a cycle")


class Room(NamedTuple):
    """Distance to slip of contacts that stick, with the largest or the smallest possible offsets of u_x."""

    forward: np.ndarray  # (n,): by this much each deformation may grow before the contact slips
    backward: np.ndarray  # (n,): by this much it may decrease
    tangential_force: float  # mean of sum Q


def room_to_stick(problem: Problem, motion: NormalMotion, side: float) -> Room:
    """Return the room of contacts that always stick, each with the offset nearest to slip in the direction `side`."""
    z, every = motion.approaches, np.arange(problem.contacts)[:, None]
    contact = contact_parameters(problem, every)
    limit = slip_limit(contact, z)
    _, _, u_x, _ = at_phase(problem.paths, every, np.cos(motion.phases), np.sin(motion.phases))
    fast = np.zeros(z.shape[1])
    for _ in range(MAX_ITERATIONS):
        relative = u_x - fast  # of the surface to the slider
        forward, backward = least(limit - relative), least(limit + relative)
        offset = forward if side > 0.0 else -backward
        x = relative + offset[:, None]
        total = (np.sign(x) * contact.stiffness * contact.law.stuck(contact, z, abs(x))).sum(axis=0)
        moved, _ = _driven(total, problem.tangential_damping)
        change, fast = float(np.max(np.abs(moved - fast))), moved
        if change < CLOSE * (1.0 + float(np.max(np.abs(u_x)))):
            return Room(forward, backward, float(total.mean()))
        if not change < 1e6:
            break
    raise ConvergenceError("not converged", "the slider answers too strongly within a cycle")


def least(values: np.ndarray) -> np.ndarray:
    """Return the minimum of each periodic function, from a parabola through the least sample and its neighbours."""
    contacts, at = np.arange(len(values)), np.argmin(values, axis=1)
    low, mid, high = (values[contacts, (at + k) % values.shape[1]] for k in (-1, 0, 1))
    bend = low - 2.0 * mid + high
    return mid - np.divide((high - low) ** 2, 8.0 * bend, out=np.zeros_like(mid), where=bend > 0.0)


def _driven(force, damping):
    """Return (displacement, rate) of the slider under the alternating part of a force."""
    harmonics = np.fft.rfft(force)
    n = np.arange(harmonics.size)
    n[0] = 1
    harmonics[0] = 0.0
    moved = harmonics * harmonic_response(n, damping)
    return np.fft.irfft(moved, force.size), np.fft.irfft(1j * n * moved, force.size)
