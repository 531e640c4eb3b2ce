r"""The steady motion of a slider in the plane by shooting: the full motion that repeats after one period of the waves.

The map of one period takes height, velocity, yaw rate and the deformations of the contacts that touch to those one
period later; Newton's method finds its fixed point from the averaged equilibrium. Place and yaw of the slider are those
of the start: the waves under the contacts are given.
"""

from typing import NamedTuple

import numpy as np

from contact.codes import Regime
from contact.exceptions import ConvergenceError
from contact.plane.averaged import Averaged, Root
from contact.plane.disc_contacts import Sum, Total
from contact.plane.full_motion import FullMotion, clipped, with_heights
from contact.plane.plane_equations import Body, Surface, fill_surface
from contact.plane.plane_waves import SurfaceWaves
from contact.plane.scaling import scaled

EXACT, CHECK = (6, 1e-6), (5, 1e-5)  # nodes and tolerance of a segment: of the answer, and of the check
DIFFERENCE = 1e-6  # of the state, over its scale, for the derivatives of the map
MAX_NEWTON = 25
SETTLING = 3  # periods before the search, in which the contacts take their deformations


class Periodic(NamedTuple):
    """A motion that repeats, scaled."""

    motion: FullMotion  # after one period, its sums over that period
    velocity: np.ndarray  # (3,): mean of x', y', psi'
    multipliers: np.ndarray  # Floquet multipliers, largest first
    change: float  # of the velocity by the last step


class _Map:
    """The map of one period in the variables that it changes."""

    def __init__(self, averaged: Averaged, waves: SurfaceWaves, how):
        slider = averaged.slider
        self.units = with_heights(slider, waves, scaled(slider, waves, heavy=False))
        problem = self.units.problem
        self.how, self.period, self.count = how, self.units.period, problem.x.size
        self.moving = np.flatnonzero(problem.inverse > 0.0)  # HEIGHT first
        surface = np.zeros((self.count, 6))
        fill_surface(problem, 0, self.count, 0.0, surface)
        self.lift = problem.height + surface[:, Surface.Z]
        arm = averaged.arm
        self.scale = np.concatenate([[1.0], np.where(self.moving == Body.YAW, 1.0 / arm, 1.0)])

    def start(self, state):
        """Return the motion at a state (z_s, rates, deformations)."""
        k = 1 + self.moving.size
        motion = FullMotion.at_rest(self.units, self.how)
        body, own = state[:k] * self.scale, motion.state
        own.q[Body.HEIGHT], own.p[self.moving] = body[0], body[1:]
        approach = self.lift - body[0]
        own.regime[:] = np.where(approach > 0.0, Regime.STICK, Regime.SEPARATED)
        limit = self.units.problem.limit_slope * np.maximum(approach, 0.0)
        own.e[:] = clipped(state[k:].reshape(-1, 2), limit)
        motion.begun = motion.energy()
        return motion

    def state(self, motion):
        """Return the state of a motion."""
        own = motion.state
        return np.concatenate([np.concatenate([own.q[:1], own.p[self.moving]]) / self.scale, own.e.ravel()])

    def __call__(self, state):
        """Return (state after a period, motion)."""
        motion = self.start(state)
        motion.follow(self.period)
        return self.state(motion), motion


def periodic(averaged: Averaged, root: Root, waves: SurfaceWaves, how=EXACT, near=None) -> tuple[Periodic, np.ndarray]:
    """Return the motion that repeats and its state at the start of a period, from an averaged equilibrium or a state.

    Raises
    ------
    ConvergenceError
        "not converged" where Newton's method finds no fixed point, "unstable" where the motion does not come back.
    """
    period_map = _Map(averaged, waves, how)
    if near is None:
        mean = averaged.problem.height - averaged.height
        z_s = float(np.mean(period_map.units.problem.height - mean))
        rates = np.concatenate([[0.0], root.unknown])  # arm times yaw rate, as the state has it
        state = np.concatenate([[z_s], rates[period_map.moving], np.zeros(2 * period_map.count)])
        for _ in range(SETTLING):
            state = np.concatenate(
                [state[: 1 + period_map.moving.size], period_map(state)[0][1 + period_map.moving.size :]]
            )
    else:
        state = near
    size, top = state.size, averaged.top_speed
    steps = DIFFERENCE * np.concatenate(
        [[1.0], np.full(period_map.moving.size, 10.0 * top), np.full(2 * period_map.count, 0.1)]
    )
    matrix, change = np.zeros((size, size)), np.inf
    for count in range(MAX_NEWTON):
        image, motion = period_map(state)
        if count < 3 or count % 3 == 0:
            for k in range(size):
                moved = state.copy()
                moved[k] += steps[k]
                matrix[:, k] = (period_map(moved)[0] - image) / steps[k]
        step, *_ = np.linalg.lstsq(np.eye(size) - matrix, image - state, rcond=1e-14)
        rates = np.abs(step[1 : 1 + period_map.moving.size]).max()
        factor = min(1.0, 0.3 * top / rates) if rates > 0.0 else 1.0
        state = state + factor * step
        change = float(rates)
        if change < 1e-11 * top:
            break
    if not change < 1e-7 * top:
        raise ConvergenceError("not converged", "no motion in the plane that repeats with the waves was found")
    image, motion = period_map(state)
    multipliers = np.linalg.eigvals(matrix)
    multipliers = multipliers[np.argsort(-np.abs(multipliers))]
    if np.abs(multipliers[0]) > 1.0 + 1e-6:
        raise ConvergenceError("unstable", "the motion in the plane that repeats with the waves is not stable")
    return Periodic(motion, motion.state.q[1:] / period_map.period, multipliers, change), state


def sums_of(found: Periodic) -> np.ndarray:
    """Return the means over the period (n, len(Sum)), scaled."""
    return found.motion.state.sums / found.motion.state.total[Total.PHASE]


def lost_in_dampers(found: Periodic) -> float:
    """Return the mean power lost in the dampers of body and contacts, scaled."""
    total = found.motion.state.total
    lost = total[Total.LOST_NORMAL] + total[Total.LOST_TANGENTIAL]
    return float(lost / total[Total.PHASE] + sums_of(found)[:, Sum.DAMPER].sum())
