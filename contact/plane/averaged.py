r"""The averaged motion in the plane: velocity and yaw rate at which the mean forces of one period balance.

A heavy slider keeps height, velocity and yaw rate within a period of the waves. The heights follow from the mean normal
forces alone (`heights`); velocity and yaw rate are the root of

    <sum Q> - F - R_t V = 0,     <sum (X Q_y - Y Q_x)> - M - R_yaw omega = 0,

found by Newton's method; contact i has the velocity V + omega e_z x r_i, so that two differences of each contact give
the derivatives in all unknowns. This is first-order averaging, error O((f_n/f)^2).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contact.exceptions import ConvergenceError
from contact.plane.cycle import COLUMNS, cycle_means
from contact.plane.disc_contacts import Sum, state_of, work_of
from contact.plane.heights import NormalMeans, approaches
from contact.plane.plane_equations import PlaneProblem
from contact.plane.plane_waves import SurfaceWaves
from contact.plane.scaling import FREE, Scaled, scaled
from contact.slider import Slider

# Nodes and tolerance of a segment: of the answer, and of the check that differs from it in both
ANSWER, CHECK = (6, 1e-6), (5, 3e-6)
SEARCH = (4, 1e-2)  # of the search, whose means err by 1e-5 of the friction
# The same for a tolerance of the velocity of 1e-5 or more: errors of 1e-9 to 1e-7 of the friction, in three quarters of
# the time
COARSE_ANSWER, COARSE_CHECK, COARSE = (6, 1e-4), (5, 1e-4), 1e-5
# Least error of the velocity that is stated, fine and coarse: of 119 drawn sliders that move one fine and one coarse
# answer were beyond twice the error without it
LEAST = (1e-9, 2e-8)
MAX_NEWTON = 60
STEP = 1e-4  # of the differences, over the surface's largest speed
ROUGH = 1e-4  # of that speed: a step at which the search goes over to the means of the answer
HELD = 1e-9  # of the surface's largest speed, below which a slider is taken as held


class Means(NamedTuple):
    """Mean forces at a velocity, scaled."""

    contacts: np.ndarray  # (n, COLUMNS)
    force: np.ndarray  # (3,): F_x, F_y, moment over the arm
    repeats: bool


@dataclass
class Averaged:
    """Mean forces of a slider on given waves as a function of (V_x, V_y, arm times yaw rate), scaled."""

    slider: Slider
    scaled: Scaled
    height: np.ndarray  # z_s of each contact
    start: np.ndarray
    basis: np.ndarray  # (3, m): the free motions, orthonormal, of (V_x, V_y, arm times yaw rate)
    evaluations: int = 0

    @classmethod
    def of(cls, slider: Slider, waves: SurfaceWaves) -> "Averaged":
        """Return the mean forces with the heights under the slider's loads."""
        units = scaled(slider, waves, heavy=True)
        means = NormalMeans(units)
        force = slider.load if slider.freedom != "x" else (slider.load, 0.0)
        height = approaches(slider, units, means, force)
        return cls(slider, units, height, np.ascontiguousarray(means.lowest()), np.eye(3)[:, FREE[slider.freedom]])

    def __post_init__(self):
        problem = self.scaled.problem
        n = problem.x.size
        self.arm = float(np.hypot(problem.x, problem.y).max()) or 1.0
        # velocity of contact i = rigid[i] @ (V_x, V_y, arm omega)
        self.rigid = np.zeros((n, 2, 3))
        self.rigid[:, 0, 0] = self.rigid[:, 1, 1] = 1.0
        self.rigid[:, 0, 2], self.rigid[:, 1, 2] = -problem.y / self.arm, problem.x / self.arm
        damping = problem.damping
        self.damping = np.array([damping[1], damping[2], damping[3] / self.arm**2])
        self.load = -np.array([problem.force[1], problem.force[2], problem.force[3] / self.arm])
        self.friction = problem.friction * -problem.force[0]
        self.deformation = np.zeros((n, 2))
        self._arrays = {}

    @property
    def problem(self) -> PlaneProblem:
        """The scaled problem."""
        return self.scaled.problem

    @property
    def closed(self) -> np.ndarray:
        """True of each contact that never opens (n,)."""
        problem = self.problem
        angle = problem.ratio[:, None] * self.start
        lowest = (problem.cos[..., 2] * np.cos(angle) + problem.sin[..., 2] * np.sin(angle)).sum(axis=0)
        return problem.height - self.height + lowest > 0.0

    @property
    def top_speed(self) -> float:
        """Speed beyond which every contact slips all the time against its motion, scaled."""
        amplitudes = np.hypot(self.problem.cos, self.problem.sin)
        tangential = np.hypot(amplitudes[..., 0], amplitudes[..., 1]) + self.problem.limit_slope * amplitudes[..., 2]
        return float((self.problem.ratio[:, None] * tangential).sum(axis=0).max())

    def contact_means(self, velocities: np.ndarray, how=SEARCH, deformation=None) -> tuple[np.ndarray, bool]:
        """Return the means of each contact at its own velocity (n, 2)."""
        n = len(velocities)
        if how not in self._arrays:
            self._arrays[how] = state_of(n), work_of(n, *how)
        state, work = self._arrays[how]
        out = np.zeros((n, COLUMNS))
        guess = self.deformation if deformation is None else deformation
        fine = cycle_means(
            self.problem, self.height, np.ascontiguousarray(velocities), self.start, self.scaled.period, state, work,
            guess, out,
        )  # fmt: skip
        self.evaluations += 1
        return out, bool(fine)

    def at(self, unknown: np.ndarray, how=SEARCH, deformation=None) -> Means:
        """Return the mean forces at (V_x, V_y, arm times yaw rate)."""
        contacts, fine = self.contact_means(self.rigid @ unknown, how, deformation)
        return Means(contacts, self.total(contacts), fine)

    def total(self, contacts: np.ndarray) -> np.ndarray:
        """Return the forces on the body of the contacts' means."""
        each = contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]]
        return np.einsum("ick,ic->k", self.rigid, each)

    def residual(self, means: Means, unknown: np.ndarray) -> np.ndarray:
        """Return the forces that accelerate the body, of its free coordinates."""
        return self.basis.T @ (means.force - self.load - self.damping * unknown)

    def derivative(self, means: Means, unknown: np.ndarray, how=SEARCH) -> np.ndarray:
        """Return the derivative of the residual in the free unknowns."""
        velocities, step = self.rigid @ unknown, STEP * self.top_speed
        matrix = np.diag(-self.damping)
        for axis in range(2):
            moved = velocities.copy()
            moved[:, axis] += step
            changed, _ = self.contact_means(moved, how, self.deformation.copy())
            columns = [Sum.ALONG_X, Sum.ALONG_Y]
            slope = (changed - means.contacts)[:, columns] / step  # (n, 2): dQ/dV_axis
            matrix = matrix + np.einsum("ick,ic,im->km", self.rigid, slope, self.rigid[:, axis])
        return self.basis.T @ matrix @ self.basis

    def guess(self) -> np.ndarray:
        """Return the velocity of the surface weighted by the normal force: that of contacts which are viscous."""
        phase = np.linspace(0.0, self.scaled.period, 64 * round(self.scaled.period / (2.0 * np.pi)), endpoint=False)
        problem = self.problem
        angle = problem.ratio * phase[:, None]
        c, s = np.cos(angle), np.sin(angle)
        u_z = np.einsum("pw,wi->pi", c, problem.cos[..., 2]) + np.einsum("pw,wi->pi", s, problem.sin[..., 2])
        speed = np.einsum("pw,wik->pik", -problem.ratio * s, problem.cos[..., :2])
        speed += np.einsum("pw,wik->pik", problem.ratio * c, problem.sin[..., :2])
        pressing = np.maximum(problem.height - self.height + u_z, 0.0) ** 1.5
        weight = problem.stiffness * pressing.sum(axis=0)
        mean = (pressing[..., None] * speed).sum(axis=0) / np.maximum(pressing.sum(axis=0), 1e-300)[:, None]
        rows = (self.rigid * np.sqrt(weight)[:, None, None]).reshape(-1, 3) @ self.basis
        found = np.linalg.lstsq(rows, (mean * np.sqrt(weight)[:, None]).ravel(), rcond=None)[0]
        return 0.85 * self.basis @ found


class Root(NamedTuple):
    """The balance of an averaged motion, scaled."""

    unknown: np.ndarray  # (V_x, V_y, arm times yaw rate)
    means: Means
    derivative: np.ndarray
    error: np.ndarray  # (3,) of the unknowns
    held: bool


def balanced(averaged: Averaged, near: np.ndarray | None = None, tolerance: float = 1e-8) -> Root:
    """Return the balance of an averaged motion by Newton's method, from a guess.

    Raises
    ------
    ConvergenceError
        "runaway" where friction does not balance the load, "not converged".
    """
    _refuse_runaway(averaged)
    top, basis = averaged.top_speed, averaged.basis
    if top == 0.0:
        return _at_rest(averaged)
    if averaged.closed.any() and (held := _at_rest(averaged)).held:
        return held
    unknown = averaged.guess() if near is None else np.array(near)
    means = averaged.at(unknown)
    residual = averaged.residual(means, unknown)
    matrix = averaged.derivative(means, unknown)
    fresh = True
    for _ in range(MAX_NEWTON):
        step = _newton_step(matrix, residual)
        size, factor = np.abs(step).max(), 1.0
        if size > 0.7 * top:
            step *= 0.7 * top / size
        for _ in range(8):
            new = unknown + factor * basis @ step
            new_means = averaged.at(new)
            new_residual = averaged.residual(new_means, new)
            better = np.linalg.norm(new_residual) < 0.9 * np.linalg.norm(residual) or size < ROUGH * top
            if better or not fresh:
                break
            factor *= 0.4
        if not better and not fresh:
            matrix, fresh = averaged.derivative(means, unknown), True
            continue
        moved = factor * step
        slow = np.linalg.norm(new_residual) > 0.3 * np.linalg.norm(residual)
        matrix = _updated(matrix, new_residual - residual, moved)
        unknown, means, residual, fresh = new, new_means, new_residual, False
        if np.abs(unknown).max() < HELD * top:
            return _at_rest(averaged)
        if np.abs(_newton_step(matrix, residual)).max() < ROUGH * top:
            break
        if slow:
            matrix, fresh = averaged.derivative(means, unknown), True
    else:
        held = _at_rest(averaged)
        if held.held:
            return held
        raise ConvergenceError("not converged", "the mean forces in the plane were not balanced")
    unknown = unknown + basis @ _newton_step(matrix, residual)
    return _refined(averaged, unknown, matrix, tolerance)


def _updated(matrix, change, moved):
    """Return the derivative after Broyden's update by a change of the residual over a step."""
    size = moved @ moved
    return matrix + np.outer(change - matrix @ moved, moved) / size if size > 0.0 else matrix


def _newton_step(matrix, residual):
    step, *_ = np.linalg.lstsq(matrix, -residual, rcond=1e-12)
    return step


def _refined(averaged, unknown, matrix, tolerance):
    """Return the root of the finer means from that of the search, and its error against means that differ."""
    basis, top = averaged.basis, averaged.top_speed
    answer, check_how = (COARSE_ANSWER, COARSE_CHECK) if tolerance >= COARSE else (ANSWER, CHECK)
    close = max(3e-11, 1e-4 * tolerance)
    means = averaged.at(unknown, answer)
    residual = averaged.residual(means, unknown)
    for _ in range(30):
        step = _newton_step(matrix, residual)
        if np.abs(step).max() < close * top:
            break
        new = unknown + basis @ step
        means = averaged.at(new, answer)
        changed = averaged.residual(means, new)
        matrix = _updated(matrix, changed - residual, step)
        unknown, residual = new, changed
    check = averaged.at(unknown, check_how, averaged.deformation.copy())
    error = np.abs(basis @ _newton_step(matrix, basis.T @ (check.force - means.force))) + np.abs(basis @ step)
    # two computations may agree by chance
    least = LEAST[tolerance >= COARSE] * max(np.linalg.norm(unknown), 0.1 * top)
    error = error + least * np.abs(basis).max(axis=1)
    if not means.repeats:
        raise ConvergenceError("not converged", "a contact did not repeat its motion within the periods allowed")
    return Root(unknown, means, matrix, error, False)


def _refuse_runaway(averaged):
    """Raise where even full friction of all contacts does not hold the load and no damper does."""
    projector = averaged.basis @ averaged.basis.T
    load, most = projector @ averaged.load, averaged.friction
    arms = np.hypot(averaged.problem.x, averaged.problem.y) / averaged.arm
    if np.linalg.norm(load[:2]) >= most and load[:2].any() and averaged.damping[0] == 0.0:
        raise ConvergenceError("runaway", "the load exceeds the friction of all contacts and no damper balances it")
    if abs(load[2]) >= most * arms.max() and load[2] != 0.0 and averaged.damping[2] == 0.0:
        raise ConvergenceError("runaway", "the torque exceeds the friction of all contacts and no damper balances it")


def rest_force(averaged: Averaged, towards: np.ndarray, how=ANSWER) -> Means:
    """Return the mean forces on a slider at rest that came to rest from a motion towards (V_x, V_y, arm omega).

    Contacts that never open are dragged to their limit against that motion, then slip back to what the least approach
    allows; their force is the end of the band of forces that rest can carry.
    """
    return averaged.at(np.zeros(3), how, dragged(averaged, towards))


def dragged(averaged: Averaged, towards: np.ndarray) -> np.ndarray:
    """Return deformations beyond every limit against a motion towards (V_x, V_y, arm omega)."""
    velocities = averaged.rigid @ towards
    speed = np.linalg.norm(velocities, axis=1, keepdims=True)
    return -1e3 * np.divide(velocities, speed, out=np.zeros_like(velocities), where=speed > 0.0)


def _at_rest(averaged):
    """Return the balance at rest; not `held` where no force of the band is the load.

    The forces of rest are a convex set. It holds the load if in no direction its farthest point falls short of it; the
    direction in which it does is sought along the force that is left.
    """
    basis, towards = averaged.basis, np.zeros(3)
    means = rest_force(averaged, towards)
    held = False
    for _ in range(40):
        left = averaged.residual(means, np.zeros(3))
        if np.linalg.norm(left) <= 1e-9 * averaged.friction:
            held = True
            break
        new = basis @ left / np.linalg.norm(left)
        means = rest_force(averaged, new)
        # dragged towards what is left, the contacts resist as much as they can
        if averaged.residual(means, np.zeros(3)) @ (basis.T @ new) <= 1e-10 * averaged.friction:
            held = True
            break
        if np.abs(new - towards).max() < 1e-9:
            break
        towards = new
    return Root(np.zeros(3), means, np.zeros((basis.shape[1],) * 2), np.zeros(3), held)
