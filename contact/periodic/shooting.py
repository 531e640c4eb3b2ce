r"""Periodic motion of the full equations by the shooting method.

The cycle map takes the state (z_s, z_s', v, x_i) at the trough of the first contact to the state one wave cycle later,
with every event resolved. A periodic motion is a fixed point of this map. Newton's method finds it, starting from the
averaged equilibrium, with a Jacobian by finite differences. The Jacobian is the monodromy matrix; its eigenvalues are
the Floquet multipliers. A contact that slips or separates forgets its deformation, so that most columns of the
deformations x_i are zero.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contact.averaged.event_equilibrium import Balance
from contact.codes import At, Regime, WorkCount
from contact.error_estimate import EPSILON, shooting_agreement, shooting_rounding
from contact.events.collocation import collocation
from contact.events.energy import EnergySum
from contact.events.motion import Motion
from contact.exceptions import ConvergenceError
from contact.law import hysteretic
from contact.periodic.averaged_map import averaged_jacobian
from contact.problem import largest_resonance

# Nodes per segment, truncation error of a segment, its longest length over that of the problem, and the largest Newton
# step that ends a search: for an answer and for the estimate of its error. QUICK serves tolerances from QUICK_TOLERANCE
# on: its two levels differ as those of `event_driven_burst.ORDERS`. Of 351 drawn motors none is off by more than is
# stated, and the energies of 349 balance to 1e-10 (`tests/benchmarks/shooting_error.py`). With 12 nodes, 1e-9 and a
# last step of 1e-10 a search takes 3 % less time, and those of 4 in 100 motors with adhesion miss 1e-10. QUICK_MANY is
# for many contacts; its velocities were within 8e-11 and 2e-8 of that of FINE for 1 to 300 balls at 3 to 10 nm.
# MANY_CLOSE: of these, the largest step over the tolerance, and its largest value. The speed has the last step, which
# is also a part of its error.
FINE, COARSE = (16, 1e-12, 1.0, 1e-12), (10, 1e-8, 1.0, 1e-12)
QUICK, QUICK_TOLERANCE = ((14, 1e-10, 1.0, 1e-11), (8, 1e-5, 0.8, 1e-10)), 1e-8
QUICK_MANY = (12, 1e-9, 1.0, 1e-10), (8, 1e-5, 0.8, 1e-10)
MANY_CLOSE = 1e-2, 1e-8
# Share of a step of the deformations that counts for its size: their effect on the speed is in the same step
DEFORMATION_SHARE = 0.1
# Largest number of cycles to follow before the search if it fails from the averaged equilibrium. It failed at first in
# 3 of 190 searches for drawn motors; two of these searches ended after 191 and 200 cycles.
SETTLE = 200
# largest number of Newton steps of a search
MAX_STEPS = 40
# the search stops if the state exceeds this many units of length
BOUND = 1e6
# error of a Floquet multiplier that is due to the finite differences
MULTIPLIER_ERROR = 1e-6
# STEP: step of the state for finite differences.
# FEW_CONTACTS: up to this number of contacts, every column of the Jacobian is computed by its own difference.
STEP, FEW_CONTACTS = 1e-7, 8
# A contact remembers its deformation if more than this fraction of a change is left after one cycle.
FORGOTTEN = 1e-3


class CycleJacobian(NamedTuple):
    """Jacobian J = L R^T of a cycle map of n + 3 quantities, of the rank r of what a cycle remembers.

    Inverse and eigenvalues follow from those of r by r matrices (Woodbury; Golub and Van Loan, *Matrix Computations*,
    section 2.1.4): (I - L R^T)^-1 = I + L (I - R^T L)^-1 R^T.
    """

    left: np.ndarray  # (3 + n, r): L
    right: np.ndarray  # (3 + n, r): R
    averaged: bool = False  # True: of `averaged_map`, which leaves out how the deformations follow the slider

    @property
    def growth(self) -> float:
        """Largest magnitude of the eigenvalues, the Floquet multipliers."""
        return float(np.max(np.abs(np.linalg.eigvals(self.right.T @ self.left))))

    def newton_step(self, residual: np.ndarray) -> np.ndarray:
        """Return the solution of (J - I) step = residual; raise `LinAlgError` if there is none."""
        small = np.eye(self.left.shape[1]) - self.right.T @ self.left
        return -residual - self.left @ np.linalg.solve(small, self.right.T @ residual)

    def amplification(self, row: int) -> np.ndarray:
        """Return a row of the inverse of J - I: what a change of each quantity in a cycle makes of one quantity."""
        small = np.eye(self.left.shape[1]) - self.left.T @ self.right
        inverse = -self.right @ np.linalg.solve(small, self.left[row])
        inverse[row] -= 1.0
        return inverse


@dataclass(frozen=True, kw_only=True)
class Periodic:
    """Periodic motion, in the units of the scaled problem."""

    speed: float  # mean of v over the cycle
    state: np.ndarray  # (3 + n,): z_s, z_s', v and the deformations x_i at phase 0
    jacobian: CycleJacobian  # of the cycle map
    step: float  # size of the last Newton step, an estimate of the distance to the fixed point
    motion: Motion  # after the last cycle, its tally and sums of that cycle

    @cached_property
    def growth(self) -> float:
        """Largest magnitude of the Floquet multipliers; the motion is unstable if it exceeds one."""
        return self.jacobian.growth

    @property
    def stable(self) -> bool:
        """True if no multiplier exceeds one by more than the error of the finite differences."""
        return self.growth <= 1.0 + MULTIPLIER_ERROR

    @cached_property
    def unseen_error(self) -> float:
        """Error of the speed that another order need not show: last Newton step, rounding, agreement by chance."""
        amplified, problem = self.jacobian.amplification(At.VELOCITY), self.motion.problem
        rounding = shooting_rounding(amplified, self._rounded, self.motion.tally[WorkCount.SEGMENTS])
        friction = problem.friction * problem.preload
        chance = shooting_agreement(amplified[At.NORMAL_VELOCITY] * problem.preload, amplified[At.VELOCITY] * friction)
        return self.step + rounding + EPSILON * abs(self.speed) + chance

    @property
    def _rounded(self):
        """Sizes of what rounding changes in a segment: the approach at most, and with it the forces; the deformations.

        What the segment adds to position and velocities is summed without rounding (`segment.advance_slider`).
        """
        problem, size = self.motion.problem, np.abs(self.state)
        force = largest_resonance(problem) ** 2 * (1.0 + size[At.POSITION])
        size[At.POSITION] = force + size[At.NORMAL_VELOCITY]
        size[At.NORMAL_VELOCITY] = force + problem.normal_damping * size[At.NORMAL_VELOCITY]
        size[At.VELOCITY] = force + problem.tangential_damping * size[At.VELOCITY]
        return size


def periodic(
    balance: Balance, *, nodes: int, truncation: float, longest: float = 1.0, close: float = 1e-12,
    near: Periodic | None = None, settle: int = 0, energies: bool = True,
) -> Periodic:  # fmt: skip
    """Return the periodic motion at one order of collocation.

    Newton's method starts from the averaged equilibrium `balance`, or from the motion `near` if there is one.
    `truncation` is that of `Motion`, `longest` the largest length of a segment over that of the problem. The search
    ends at a step below `close`. Before it the full motion is followed for `settle` cycles. `energies`: whether the
    motion counts those of its cycle.
    """
    problem = balance.problem
    cycle = CycleMap(problem._replace(longest=longest * problem.longest), nodes, truncation)
    change = None
    if near is None:
        deformations = np.zeros(problem.contacts)
        if balance.followed is not None:
            deformations = balance.followed.carried.deformation
        y = np.concatenate(([-balance.height, 0.0, balance.speed], deformations))
        y[3:] += cycle(y)[3:]  # the averaged deformations are not those of the full motion
        for _ in range(settle):
            y = y + cycle(y)
        quick = averaged_jacobian(balance, y[3:]) if problem.contacts > FEW_CONTACTS else None
        jacobian, change = cycle.jacobian(y) if quick is None else (CycleJacobian(*quick, averaged=True), None)
    else:
        y, jacobian = near.state.copy(), near.jacobian
    y, jacobian, step = _fixed_point(cycle, y, jacobian, close, change)
    if energies:
        cycle.count_energies(y)
    size, turn, motion = _size(step), 2.0 * math.pi, cycle.motion
    motion.problem = problem
    if not size < 1e-6:
        raise ConvergenceError(
            "not converged",
            f"the cycle map's fixed point was not reached (last step {size:.2g}); follow a burst with method exact",
        )
    return Periodic(
        speed=motion.sums[EnergySum.DISPLACEMENT] / turn + step[2], state=y, jacobian=jacobian, step=size, motion=motion
    )


def quick_periodic(balance: Balance, tolerance: float) -> tuple[Periodic, Periodic] | None:
    """Return the periodic motion at both levels QUICK, the finer one first; None if it is not found, or not stable.

    The coarser one is found first, and the finer one from it with the same Jacobian: their multipliers differ by 1e-8.
    """
    if balance.problem.law.guard is hysteretic.guard or tolerance < QUICK_TOLERANCE:
        return None
    try:
        finer, coarser = _quick_levels(balance, tolerance)
        coarse = search_at(coarser, balance, energies=False)
        fine = search_at(finer, balance, near=coarse)
    except ConvergenceError:
        return None
    return (fine, coarse) if fine.stable else None


def _quick_levels(balance, tolerance):
    """Return the levels QUICK, for many contacts QUICK_MANY with the largest Newton step that the tolerance allows."""
    if balance.problem.contacts <= FEW_CONTACTS:
        return QUICK
    close = min(MANY_CLOSE[0] * tolerance, MANY_CLOSE[1])
    return tuple((*level[:3], max(level[3], close)) for level in QUICK_MANY)


def search_at(level: tuple, balance: Balance, **options) -> Periodic:
    """Return the periodic motion at a level such as FINE."""
    nodes, truncation, longest, close = level
    return periodic(balance, nodes=nodes, truncation=truncation, longest=longest, close=close, **options)


def fine_periodic(balance: Balance) -> Periodic:
    """Return the periodic motion at the order FINE; after a failed search, some cycles are followed before a second."""
    try:
        return search_at(FINE, balance)
    except ConvergenceError:
        # about 30 000 segments at most
        settle = int(min(SETTLE, 5.0 + 5000.0 * balance.problem.longest))
        return search_at(FINE, balance, settle=settle)


def coarse_periodic(balance: Balance, fine: Periodic) -> Periodic:
    """Return the same periodic motion at the order COARSE; its difference from the fine one estimates the error."""
    return search_at(COARSE, balance, near=fine, energies=False)


class CycleMap:
    """Change of the state over one wave cycle; `motion` is the motion after the last evaluation.

    Newton's method takes the change, with what rounding cuts off from the state: the velocity of a heavy slider relaxes
    by as little as 1e-8 of itself in a cycle, so that a difference of two rounded states would show 1e-8 of it.
    """

    def __init__(self, problem, nodes, truncation):
        self.motion = self.base = Motion(problem, grid=collocation(nodes), truncation=truncation)
        self.warm = False

    def __call__(self, y, keep=True):
        """Return the change of the state in the cycle after y; `keep`: later copies with memory start from this one."""
        if self.motion.memory is not None:  # the memory of a hysteretic contact is part of the state
            self.motion = self.base.copy()
        motion = self.motion
        motion.set_state(*y[:3], y[3:])
        if motion.memory is not None:
            motion.begin()
        else:
            motion.tally[:], motion.sums[:] = 0, 0.0
        # each evaluation starts from the pattern of the last one
        motion.turn(1, warm=self.warm)
        self.warm = motion.memory is None
        if not np.max(np.abs(motion.state)) < BOUND:
            raise ConvergenceError(
                "not finite", "the cycle map throws the slider off; lower the contact damping or follow a burst"
            )
        if keep:
            self.base = motion
        change = motion.state - y
        change[: At.DEFORMATIONS] += motion.lost
        return change

    def keep_slipping(self, y):
        """Set the deformations of contacts that slipped at the end of the last cycle to the slip limits of a state."""
        motion = self.motion
        slips = motion.regime == Regime.SLIP
        limits = motion.problem.limit_slope * motion.problem.factors.limit_slope * motion.approaches(y[At.POSITION])
        y[At.DEFORMATIONS :] = np.where(slips, motion.sign * limits, y[At.DEFORMATIONS :])

    def count_energies(self, y):
        """Give the motion after its cycle from the state y the energies at the start of that cycle."""
        if self.motion.memory is None:
            start = self.motion.copy()
            start.set_state(*y[:3], y[3:])
            start.count_energies()
            self.motion.begun = start.begun

    def jacobian(self, y):
        """Return the map's Jacobian by differences that move each deformation towards zero, and the change from y.

        If there are many contacts, most of them forget their deformation within the cycle. Their final deformations
        then depend only on the slider's state (z_s, z_s', v), and the Jacobian has the blocks [[A, B], [C, 0]]. Its
        nonzero eigenvalues and the Newton step depend on B only through the product B C. Hence B is replaced by
        (B C) C^+, which takes one difference for each singular vector of C.
        """
        start = self(y, keep=False)
        towards = np.where(np.arange(y.size) < 3, 1.0, np.where(y < 0.0, 1.0, -1.0))

        def derivative(direction):
            return direction + (self(y + STEP * direction, keep=False) - start) / STEP

        keeps = np.arange(y.size)
        if y.size - 3 > FEW_CONTACTS:
            kept = derivative(np.where(np.arange(y.size) < 3, 0.0, towards))
            keeps = np.flatnonzero((np.arange(y.size) < 3) | (kept * towards > FORGOTTEN))
        left, right = [], []
        for k in keeps:
            unit = np.zeros(y.size)
            unit[k] = towards[k]
            left.append(derivative(unit))
            right.append(unit)
        forgets = np.delete(np.arange(y.size), keeps)
        if forgets.size:
            shapes, sizes, _ = np.linalg.svd(
                np.column_stack([towards[k] * left[k][forgets] for k in range(3)]), full_matrices=False
            )
            for shape, size in zip(shapes.T, sizes, strict=True):
                if size > 1e-9 * sizes[0]:
                    direction = np.zeros(y.size)
                    direction[forgets] = shape / np.max(np.abs(shape))
                    column = derivative(direction) * np.max(np.abs(shape))
                    column[forgets] = 0.0
                    left.append(column)
                    right.append(direction * np.max(np.abs(shape)))
        return CycleJacobian(np.column_stack(left), np.column_stack(right)), start


def _size(step):
    """Return the size of a Newton step: of the slider's motion, and a share of the deformations'."""
    own, deformations = np.abs(step[: At.DEFORMATIONS]), np.abs(step[At.DEFORMATIONS :])
    return float(max(np.max(own), DEFORMATION_SHARE * np.max(deformations)))


def _fixed_point(cycle, y, jacobian, close, change):
    """Return (state, Jacobian, last step) of Newton's method for the fixed point of the cycle map.

    The last cycle is that from the state. `change` is that from y if it is known. It is computed again if y is the
    answer, or with a memory, which it changes.
    """
    least = math.inf
    for count in range(MAX_STEPS):
        if count % 10 == 9:  # slow convergence near a kink of the map: update the Jacobian
            jacobian, _ = cycle.jacobian(y)
        known = count == 0 and change is not None and cycle.motion.memory is None
        change = change if known else cycle(y)
        try:
            step = jacobian.newton_step(-change)
        except np.linalg.LinAlgError:
            raise ConvergenceError(
                "not converged", "the cycle map leaves some state as it is, so that no one motion repeats"
            ) from None
        size = _size(step)
        rounding = count > 2 and size >= 0.5 * least and least < 1e-10
        if not known and (size < close or rounding or count == MAX_STEPS - 1):
            break
        least = min(least, size)
        # the map is nonlinear far from the fixed point: limit the change of each component to half its size
        y = y + step * min(1.0, 0.5 / float(np.max(np.abs(step) / (1.0 + np.abs(y)))))
        if jacobian.averaged:
            cycle.keep_slipping(y)
    return y, jacobian, step
