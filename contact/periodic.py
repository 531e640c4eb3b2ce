r"""The periodic motion of the full equations: fixed point of the map of one wave cycle.

The map takes (z_s, z_s', v, x_i) at the trough of the first contact to the same a cycle later, event-exactly. Newton's
method starts from the averaged balance, with the Jacobian of the map by differences; the deformations are forgotten
within a cycle in which the contact slips or parts, so they are simply carried over.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.balance import Balance
from contact.collocation import collocation
from contact.convergence import ConvergenceError
from contact.motion import Motion


@dataclass(frozen=True, kw_only=True)
class Periodic:
    """Periodic motion, in the units of the balance's problem.

    Attributes
    ----------
    speed : float
        Mean of v over the cycle.
    support : float
        Mean of the elastic normal forces.
    state : (3,) array
        z_s, z_s', v at phase 0.
    deformations : (n,) array
        x_i at phase 0.
    jacobian : (3, 3) array
        Derivative of the cycle map with respect to `state`; its eigenvalues are the multipliers.
    step : float
        Last Newton step: how far the fixed point may still be.
    motion : Motion
        After the last cycle, its tally of that cycle.
    work : (10,) int array
        As in `Balance`.
    """

    speed: float
    support: float
    state: np.ndarray
    deformations: np.ndarray
    jacobian: np.ndarray
    step: float
    motion: Motion
    work: np.ndarray


def periodic(balance: Balance, *, nodes: int, truncation: float, near: Periodic | None = None) -> Periodic:
    """Return the periodic motion at one order of collocation, started from the balance or a motion near it."""
    motion = Motion(balance.problem, table=collocation(nodes), truncation=truncation)
    work = np.zeros(10, np.int64)

    def cycle(y, x):
        motion.tally[:], motion.sums[:] = 0, 0.0
        motion.place(*y, x)
        motion.turn(1)
        work[:] += motion.tally
        return motion.state[:3].copy(), motion.state[3:].copy()

    if near is None:
        y, x = np.array([-balance.height, 0.0, balance.speed]), balance.motion.state[3:].copy()
        jacobian = _jacobian(cycle, y, x)
    else:
        y, x, jacobian = near.state.copy(), near.deformations.copy(), near.jacobian
    newton = np.linalg.inv(jacobian - np.eye(3))
    least = math.inf
    for count in range(40):
        y_next, x_next = cycle(y, x)
        step = newton @ (y - y_next)
        size = float(max(np.max(np.abs(step)), np.max(np.abs(x_next - x))))
        if size < 1e-12 or (count > 2 and size >= 0.5 * least and least < 1e-10):
            break
        least = min(least, size)
        y, x = y + step, x_next
    else:
        raise ConvergenceError(
            "not converged",
            f"the cycle map's fixed point was not reached (last step {size:.2g}); follow a burst with method exact",
        )
    turn = 2.0 * math.pi
    return Periodic(
        speed=motion.sums[2] / turn + step[2], support=motion.sums[1] / turn, state=y, deformations=x,
        jacobian=jacobian, step=size, motion=motion, work=work,
    )  # fmt: skip


def _jacobian(cycle, y, x):
    """Return the derivative of the cycle map by forward differences, after a cycle that settles x."""
    _, x = cycle(y, x)
    base, _ = cycle(y, x)
    columns = []
    for k in range(3):
        moved = y.copy()
        moved[k] += 1e-7
        columns.append((cycle(moved, x)[0] - base) / 1e-7)
    return np.array(columns).T
