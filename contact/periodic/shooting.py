r"""The periodic motion of the full equations: fixed point of the map of one wave cycle.

The map takes (z_s, z_s', v, x_i) at the trough of the first contact to the same a cycle later, event-exactly. Newton's
method starts from the averaged balance, with the Jacobian of the map by differences. A contact that slips or parts
forgets its deformation, so those columns are mostly zero.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.averaged.event_cycle import Balance
from contact.codes import Count
from contact.convergence_error import ConvergenceError
from contact.events.collocation import collocation
from contact.events.energy import Sum
from contact.events.motion import Motion

# no motion that is worth searching leaves this many length units
BOUND = 1e6
# of a Floquet multiplier, from differences of the cycle map
MULTIPLIER_ERROR = 1e-6
# of the state, for differences; contacts up to which every column of the Jacobian is a difference of its own
STEP, FEW_CONTACTS = 1e-7, 8
# share of a change of a contact's deformation that is left after a cycle, from which on the contact remembers it
FORGOTTEN = 1e-3


@dataclass(frozen=True, kw_only=True)
class Periodic:
    """Periodic motion, in the units of the balance's problem."""

    speed: float  # mean of v over the cycle
    state: np.ndarray  # (3 + n,): z_s, z_s', v and the deformations x_i at phase 0
    jacobian: np.ndarray  # (3 + n, 3 + n): of the cycle map; its eigenvalues are the multipliers
    step: float  # last Newton step: how far the fixed point may still be
    motion: Motion  # after the last cycle, its tally and sums of that cycle

    @property
    def growth(self) -> float:
        """Largest magnitude of a Floquet multiplier: above one the motion is unstable."""
        return float(np.max(np.abs(np.linalg.eigvals(self.jacobian))))

    @property
    def stable(self) -> bool:
        """Whether no multiplier is above one, but for the error of the Jacobian's differences."""
        return self.growth <= 1.0 + MULTIPLIER_ERROR

    @property
    def rounding(self) -> float:
        """Error of the speed by rounding: those of the segments add up at random, 1/(1 - multiplier) enlarges them."""
        enlarged = np.abs(np.linalg.inv(self.jacobian - np.eye(self.state.size))[2]) @ np.abs(self.state)
        return 2.2e-16 * math.sqrt(max(1, self.motion.tally[Count.SEGMENTS])) * float(enlarged)


def periodic(
    balance: Balance, *, nodes: int, truncation: float, near: Periodic | None = None, settle: int = 0
) -> Periodic:
    """Return the periodic motion at one order of collocation, from a balance or from the motion `near` it.

    `truncation` as in `Motion`; `settle`: cycles to follow the motion from the balance before the search.
    """
    cycle = _CycleMap(balance.problem, nodes, truncation)
    if near is None:
        y = np.concatenate(([-balance.height, 0.0, balance.speed], balance.motion.state[3:]))
        y[3:] = cycle(y)[3:]  # the full motion's own deformations
        for _ in range(settle):
            y = cycle(y)
        jacobian = cycle.jacobian(y)
    else:
        y, jacobian = near.state.copy(), near.jacobian
    y, jacobian, step = _fixed_point(cycle, y, jacobian)
    size, turn, motion = float(np.max(np.abs(step))), 2.0 * math.pi, cycle.motion
    if not size < 1e-6:
        raise ConvergenceError(
            "not converged",
            f"the cycle map's fixed point was not reached (last step {size:.2g}); follow a burst with method exact",
        )
    return Periodic(
        speed=motion.sums[Sum.DISPLACEMENT] / turn + step[2],
        state=y,
        jacobian=jacobian,
        step=size,
        motion=motion,
    )


class _CycleMap:
    """The map of one wave cycle; `motion` has made the last one."""

    def __init__(self, problem, nodes, truncation):
        self.motion = self.base = Motion(problem, grid=collocation(nodes), truncation=truncation)

    def __call__(self, y, keep=True):
        if self.motion.memory is not None:  # a contact that does not forget starts from what it remembers
            self.motion = self.base.copy()
        motion = self.motion
        motion.place(*y[:3], y[3:])
        motion.begin()
        motion.turn(1)
        if not np.max(np.abs(motion.state)) < BOUND:
            raise ConvergenceError(
                "not finite",
                "the cycle map throws the slider off; lower the contact damping or follow a burst",
            )
        if keep:
            self.base = motion
        return motion.state.copy()

    def jacobian(self, y):
        """Return the derivative by differences; deformations are moved towards zero.

        Of many contacts most forget their deformation within the cycle: where it ends they depend on the slider's state
        s alone, and the blocks of the matrix are [[A, B], [C, 0]]. Its eigenvalues, and Newton's method, know B through
        the product B C alone; so B is taken as (B C) C^+, from one difference for each column of C.
        """
        start = self(y, keep=False)
        towards = np.where(np.arange(y.size) < 3, 1.0, np.where(y < 0.0, 1.0, -1.0))

        def change(direction):
            return (self(y + STEP * direction, keep=False) - start) / STEP

        columns = np.zeros((y.size, y.size))
        keeps = np.arange(y.size)
        if y.size - 3 > FEW_CONTACTS:
            kept = change(np.where(np.arange(y.size) < 3, 0.0, towards))
            keeps = np.flatnonzero((np.arange(y.size) < 3) | (kept * towards > FORGOTTEN))
        for k in keeps:
            columns[:, k] = towards[k] * change(towards[k] * np.eye(y.size)[k])
        forgets = np.setdiff1d(np.arange(y.size), keeps)
        if forgets.size:
            left, sizes, _ = np.linalg.svd(columns[forgets, :3], full_matrices=False)
            for shape, size in zip(left.T, sizes, strict=True):
                if size > 1e-9 * sizes[0]:
                    direction = np.zeros(y.size)
                    direction[forgets] = shape / np.max(np.abs(shape))
                    answer = change(direction) * np.max(np.abs(shape))
                    columns[:, forgets] += np.outer(answer, shape)
            columns[np.ix_(forgets, forgets)] = 0.0
        return columns


def _fixed_point(cycle, y, jacobian):
    """Return (state, Jacobian, last step) of Newton's method for the map's fixed point."""
    least = math.inf
    for count in range(40):
        if count % 10 == 9:  # slow: close to an edge, where the map bends
            jacobian = cycle.jacobian(y)
        residual = y - cycle(y)
        try:
            step = np.linalg.solve(jacobian - np.eye(y.size), residual)
        except np.linalg.LinAlgError:
            raise ConvergenceError(
                "not converged", "the cycle map leaves some state as it is, so that no one motion repeats"
            ) from None
        size = float(np.max(np.abs(step)))
        if size < 1e-12 or (count > 2 and size >= 0.5 * least and least < 1e-10):
            break
        least = min(least, size)
        # far from the fixed point the map bends: no state moves by more than half its size
        y = y + step * min(1.0, 0.5 / float(np.max(np.abs(step) / (1.0 + np.abs(y)))))
    return y, jacobian, step
