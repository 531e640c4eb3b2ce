r"""The averaged motion in the plane: velocity and yaw rate at which the mean forces of one period balance.

A heavy slider keeps height, velocity and yaw rate within a period of the waves. The heights follow from the mean normal
forces alone (`heights`); velocity and yaw rate are the root of

    <sum Q> - F - R_t V = 0,     <sum (X Q_y - Y Q_x)> - M - R_yaw omega = 0,

found by Newton's method; contact i has the velocity V + omega e_z x r_i, so that the derivatives of each contact's mean
force in its own velocity give those in all unknowns. This is first-order averaging, error O((f_n/f)^2).
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact.exceptions import ConvergenceError
from contact.jit.compiled import per_thread
from contact.plane.balance_search import Accuracies, Found, HeavyBody, Task, Tools, find_balance, search_of
from contact.plane.cycle import COLUMNS, Extra, cycle_means, cycle_samples
from contact.plane.cycle_slopes import slopes_of
from contact.plane.disc_contacts import Stage, Sum, state_of, with_nodes, work_of
from contact.plane.heights import NormalMeans, approaches
from contact.plane.plane_equations import PlaneProblem
from contact.plane.plane_waves import SurfaceWaves
from contact.plane.rest import Forces, crept, dragged_against, settled
from contact.plane.scaling import FREE, Scaled, scaled
from contact.slider import Slider

# Nodes and tolerance of a segment: of the answer, and of the check that differs from it in both
ANSWER, CHECK = (8, 1e-7), (6, 1e-6)
SEARCH = (6, 1e-4)  # of the search, whose means err by 1e-9 to 1e-7 of the friction
# Of its first steps, and of the question whether it may rest: they err by up to 8e-4, were in vain in 2 of 300 draws
# of `tests.contact.plane_motors.drawn`, then by up to 3e-5
FIRST = ((3, 3e-2), (4, 1e-3))
# The same for a tolerance of the velocity of 1e-5 or more: errors of 1e-9 to 1e-7 of the friction, in three quarters of
# the time
COARSE_ANSWER, COARSE_CHECK, COARSE = SEARCH, (5, 1e-4), 1e-5
# Least error of the velocity that is stated, fine and coarse. The true error was at most 0.16 (fine) and 0.58 (coarse)
# of twice the stated one in the draws 0 to 59 of `tests/contact/test_plane_drawn.py`, and 0.8 (fine) in 1000 to 1059
LEAST = (2e-9, 2e-8)
# Speed of a creep over the top speed; the forces at 1e-5 differ by up to 1e-3 of the friction in directions in which a
# contact nearly holds, by 1e-4 in others, and at 1e-7 steps of slip are as rough as the way of a period
CREEP = 1e-6
WIDE = 2  # nodes of a segment of stick over those of slip
MAX_BAND, BAND = 30, 1e-8  # steps to the end of a band of forces, and the last one over the friction
FARTHEST_POINTS = 1000  # of the friction forces that are compared with a load before it counts as carried
CREEPS = (1e-2, 1e-3, 1e-4)  # of the top speed: motions of sliders that nearly rest from which they are sought
LEFT_START = 1e-9  # rad from the start of a period


@per_thread
def _arrays(n, how):
    """Return the work arrays of n contacts for nodes and tolerance of a segment."""
    work = work_of(n, *how)
    return Tools(state_of(n), work, with_nodes(work, WIDE * how[0]), slopes_of())


def accuracies(tolerance: float) -> tuple:
    """Return nodes and tolerance of a segment for a tolerance of the velocity: of the answer, and of the check."""
    return (COARSE_ANSWER, COARSE_CHECK) if tolerance >= COARSE else (ANSWER, CHECK)


@per_thread
def _accuracies(n, first, coarse):
    """Return the work arrays of a search for n contacts."""
    answer, check = accuracies(COARSE if coarse else 0.0)
    return Accuracies(*(_arrays(n, how) for how in (first, SEARCH, answer, check)), 2 if coarse else 3)


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
    def of(cls, slider: Slider, waves: SurfaceWaves, yaw: float = 0.0) -> "Averaged":
        """Return the mean forces with the heights under the slider's loads, of a slider that has turned by `yaw`."""
        units = scaled(slider, waves, heavy=True)
        if yaw != 0.0:
            (x, y), c, s = (units.problem.x, units.problem.y), math.cos(yaw), math.sin(yaw)
            units = units._replace(problem=units.problem._replace(x=c * x - s * y, y=s * x + c * y))
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

    @property
    def problem(self) -> PlaneProblem:
        """The scaled problem."""
        return self.scaled.problem

    @property
    def body(self) -> HeavyBody:
        """The slider as the search for its balance takes it."""
        return HeavyBody(
            self.rigid, np.ascontiguousarray(self.basis), self.load, self.damping, self.friction, self.top_speed,
            self.height, self.start, self.scaled.period, bool(self.closed.any()),
        )  # fmt: skip

    def derivative(self, unknown: np.ndarray, how) -> np.ndarray:
        """Return the derivative of the forces that accelerate the body in the free unknowns."""
        contacts, _ = self.contact_means(self.rigid @ unknown, how, self.deformation.copy(), derive=True)
        each = contacts[:, Extra.X_BY_X : Extra.Y_BY_Y + 1].reshape(-1, 2, 2)
        slope = np.einsum("ick,icd,idl->kl", self.rigid, each, self.rigid) - np.diag(self.damping)
        return self.basis.T @ slope @ self.basis

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

    @property
    def creep(self) -> float:
        """Speed of a creep, scaled: it makes no force of its own, but is above what segments resolve."""
        limits = self.problem.limit_slope * np.maximum(self.problem.height - self.height, 0.0)
        return CREEP * max(self.top_speed, float(limits.max()))

    def contact_means(
        self, velocities: np.ndarray, how=SEARCH, deformation=None, *, derive=False
    ) -> tuple[np.ndarray, bool]:
        """Return the means of each contact at its own velocity (n, 2), and their derivatives in it where asked for."""
        n = len(velocities)
        out = np.zeros((n, COLUMNS))
        guess = self.deformation if deformation is None else deformation
        fine = cycle_means(
            self.problem, self.height, np.ascontiguousarray(velocities), self.start, self.scaled.period,
            *_arrays(n, how), int(derive), guess, out,
        )  # fmt: skip
        self.evaluations += 1
        return out, bool(fine)

    def at(self, unknown: np.ndarray, how=SEARCH, deformation=None) -> Means:
        """Return the mean forces at (V_x, V_y, arm times yaw rate)."""
        contacts, fine = self.contact_means(self.rigid @ unknown, how, deformation)
        return Means(contacts, self.total(contacts), fine)

    def samples(self, unknown: np.ndarray, phase: np.ndarray, how=ANSWER) -> tuple[np.ndarray, np.ndarray]:
        """Return the contacts (k, n, len(Stage)) and regimes (k, n) at phases of one period; call `at` before."""
        n, k = len(self.start), len(phase)
        behind = (phase - self.start[:, None]) % self.scaled.period
        # the regime is known once the motion has left the start
        behind[behind < LEFT_START] += self.scaled.period
        order = np.argsort(behind, axis=1)
        out, regimes = np.zeros((n, k, len(Stage))), np.zeros((n, k), np.int64)
        phases = self.start[:, None] + np.take_along_axis(behind, order, axis=1)
        if not cycle_samples(
            self.problem, self.height, np.ascontiguousarray(self.rigid @ unknown), self.start, phases,
            *_arrays(n, how), self.deformation, out, regimes,
        ):  # fmt: skip
            raise ConvergenceError("not converged", "a segment of a cycle in the plane was not solved")
        back = np.argsort(order, axis=1)
        out = np.take_along_axis(out, back[..., None], axis=1)
        return out.swapaxes(0, 1), np.take_along_axis(regimes, back, axis=1).T

    def total(self, contacts: np.ndarray) -> np.ndarray:
        """Return the forces on the body of the contacts' means."""
        each = contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]]
        return np.einsum("ick,ic->k", self.rigid, each)

    def residual(self, means: Means, unknown: np.ndarray) -> np.ndarray:
        """Return the forces that accelerate the body, of its free coordinates."""
        return self.basis.T @ (means.force - self.load - self.damping * unknown)

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
    near_rest: bool = False  # the search came to rest, but friction does not hold the load


def balanced(averaged: Averaged, near: np.ndarray | None = None, tolerance: float = 1e-8) -> Root:
    """Return the balance of an averaged motion by Newton's method, from a guess.

    Raises
    ------
    ConvergenceError
        "runaway" where friction does not balance the load, "not converged".
    """
    _refuse_runaway(averaged)
    if averaged.top_speed == 0.0:
        return at_rest(averaged)
    body, guess, before = averaged.body, averaged.guess() if near is None else near, averaged.deformation
    close = max(1e-13, 1e-4 * tolerance)
    for first in FIRST:
        averaged.deformation = before.copy()
        search = search_of(body, guess, averaged.deformation)
        tools = _accuracies(len(averaged.start), first, tolerance >= COARSE)
        found = find_balance(averaged.problem, body, tools, search, close, int(Task.ALL))
        if found == Found.MAY_REST:
            if (held := held_rest(averaged)) is not None:
                return held
            found = find_balance(averaged.problem, body, tools, search, close, int(Task.MOTION))
        averaged.evaluations += int(search.done[0])
        if found == Found.BALANCE and search.done[1]:
            break
    if found != Found.BALANCE:
        held, towards = _rest(averaged)
        if held.held:
            return held
        _refuse_beyond_friction(averaged, held.means.contacts[:, Sum.NORMAL])
        if (turning := _turning_about_a_contact(averaged, tolerance)) is not None:
            return turning
        if (moving := _creeping(averaged, towards, tolerance)) is not None:
            return moving
        if found == Found.AT_REST:
            return held
        raise ConvergenceError("not converged", "the mean forces in the plane were not balanced")
    return _root(averaged, search, tolerance)


def _root(averaged, search, tolerance):
    """Return the root that a search has found."""
    if not search.done[1]:
        raise ConvergenceError("not converged", "a contact did not repeat its motion within the periods allowed")
    means = Means(search.means, averaged.total(search.means), True)
    error = _error(averaged, search, means, tolerance)
    return Root(search.unknown + averaged.basis @ search.step, means, search.matrix, error, False)


def _moving_near(averaged: Averaged, unknown: np.ndarray, tolerance: float) -> Root | None:
    """Return the balance of a motion that is found from one near it, None where there is none."""
    search = search_of(averaged.body, unknown, dragged(averaged, unknown))
    tools = _accuracies(len(averaged.start), SEARCH, tolerance >= COARSE)
    close = max(1e-13, 1e-4 * tolerance)
    found = find_balance(averaged.problem, averaged.body, tools, search, close, int(Task.MOTION))
    averaged.evaluations += int(search.done[0])
    return _root(averaged, search, tolerance) if found == Found.BALANCE else None


def _error(averaged, search, means, tolerance):
    """Return the error of a root against means that differ, those in `search.moved`."""
    basis = averaged.basis
    change, *_ = np.linalg.lstsq(search.matrix, basis.T @ (averaged.total(search.moved) - means.force), rcond=1e-12)
    error = np.abs(basis @ change) + search.left * np.abs(basis @ search.step)
    # two computations may agree by chance
    least = LEAST[tolerance >= COARSE] * max(np.linalg.norm(search.unknown), 0.1 * averaged.top_speed)
    return error + least * np.abs(basis).max(axis=1)


def _refuse_runaway(averaged):
    """Raise where even full friction of all contacts does not hold the load and no damper does."""
    projector = averaged.basis @ averaged.basis.T
    load, most = projector @ averaged.load, averaged.friction
    arms = np.hypot(averaged.problem.x, averaged.problem.y) / averaged.arm
    if np.linalg.norm(load[:2]) >= most and load[:2].any() and averaged.damping[0] == 0.0:
        raise ConvergenceError("runaway", "the load exceeds the friction of all contacts and no damper balances it")
    if abs(load[2]) >= most * arms.max() and load[2] != 0.0 and averaged.damping[2] == 0.0:
        raise ConvergenceError("runaway", "the torque exceeds the friction of all contacts and no damper balances it")


def _refuse_beyond_friction(averaged: Averaged, loads: np.ndarray) -> None:
    """Raise where load and torque together exceed what friction carries at contacts with these mean loads (n,).

    The friction forces on the body, each contact's within a disc of radius mu P, are a convex set. Its point nearest to
    the load is approached by the method of Frank and Wolfe; if the farthest point in the direction of what is left
    falls short of the load, no motion balances it. Damped motions balance any load.
    """
    free = averaged.basis[:, averaged.damping @ averaged.basis**2 == 0.0]
    if not free.size:
        return
    load, point = free.T @ averaged.load, np.zeros(free.shape[1])
    for _ in range(FARTHEST_POINTS):
        left = load - point
        velocities = averaged.rigid @ (free @ left)
        speed = np.linalg.norm(velocities, axis=1)
        unit = np.divide(velocities, speed[:, None], out=np.zeros_like(velocities), where=speed[:, None] > 0.0)
        farthest = free.T @ np.einsum("i,ic,ick->k", averaged.problem.friction * loads, unit, averaged.rigid)
        if farthest @ left < load @ left:
            raise ConvergenceError(
                "runaway", "load and torque together exceed the friction of all contacts and no damper balances them"
            )
        step = farthest - point
        if not step.any():
            return
        point = point + step * min(1.0, float(left @ step / (step @ step)))


def least_at_rest(averaged: Averaged, towards: np.ndarray, how=SEARCH, known: Forces | None = None) -> float:
    """Return the least force along a unit vector (3,) that a slider at rest can carry beside its load across it.

    A slider that creeps that way meets less: it also moves across. Each load that is not carried has a way on which the
    forces of rest fall short of it; the next one is that which they reach there. ``known``: see `rest.settled`.
    """
    free = np.eye(3)[:, FREE[averaged.slider.freedom]]
    contacts, _ = crept(averaged, averaged.rigid @ towards, how)
    least = float(averaged.total(contacts) @ towards)
    if not np.allclose(free @ (free.T @ towards), towards):
        return least  # held along it, by an axle
    across, known = averaged.load - (averaged.load @ towards) * towards, Forces.none() if known is None else known
    for _ in range(MAX_BAND):
        rest = settled(averaged, across + least * towards, free, how, known=known)
        along = float(rest.left @ towards)
        if rest.held or along <= 0.0:
            break
        step = (-rest.most - float(across @ rest.left)) / along - least
        least += max(step, 0.0)
        if step < BAND * averaged.friction:
            break
    return least


def dragged(averaged: Averaged, towards: np.ndarray) -> np.ndarray:
    """Return deformations beyond every limit against a motion towards (V_x, V_y, arm omega)."""
    return dragged_against(averaged.rigid @ towards)


def held_rest(averaged: Averaged) -> Root | None:
    """Return the balance at rest of a slider that friction holds, else None."""
    if not averaged.closed.any():
        return None
    rest = at_rest(averaged)
    return rest if rest.held else None


def at_rest(averaged: Averaged) -> Root:
    """Return the balance at rest; not `held` where friction does not carry the load."""
    return _rest(averaged)[0]


def _rest(averaged):
    """Return the balance at rest, and the force that is left where it is not held."""
    rest = settled(averaged, averaged.load, averaged.basis, SEARCH)
    contacts, _ = averaged.contact_means(np.zeros((len(averaged.start), 2)), ANSWER, rest.deformation)
    if rest.held:
        averaged.deformation = rest.deformation
        contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]] = rest.contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]]
    size = averaged.basis.shape[1]
    means = Means(contacts, averaged.total(contacts), True)
    return Root(np.zeros(3), means, np.zeros((size, size)), np.zeros(3), rest.held, not rest.held), rest.left


def _creeping(averaged: Averaged, towards: np.ndarray, tolerance: float) -> Root | None:
    """Return the balance of a slow motion that is found from one towards (3,), None where there is none."""
    for speed in CREEPS:
        moving = _moving_near(averaged, speed * averaged.top_speed / np.linalg.norm(towards) * towards, tolerance)
        if moving is not None:
            return moving
    return None


def _turning_about_a_contact(averaged: Averaged, tolerance: float) -> Root | None:
    """Return the balance of a slider that turns about a contact which never slips, None where there is none.

    Where the contact does not carry what the others leave, it creeps: the search for that motion begins there.
    """
    if averaged.basis.shape[1] < 3:
        return None
    for i in np.flatnonzero(averaged.closed):
        fixed = averaged.rigid[i]
        about = np.linalg.svd(fixed)[2][2]  # the motion that leaves the contact in its place
        turning = replace(averaged, basis=about[:, None])
        try:
            root = balanced(turning, tolerance=tolerance)
        except ConvergenceError:
            continue
        if root.held or root.near_rest:
            continue
        others = root.means.contacts.copy()
        others[i, [Sum.ALONG_X, Sum.ALONG_Y]] = 0.0
        left = averaged.load + averaged.damping * root.unknown - averaged.total(others)
        carried, *_ = np.linalg.lstsq(fixed.T, left, rcond=None)
        rest = settled(averaged, fixed.T @ carried, np.linalg.svd(fixed)[2][:2].T, SEARCH, only=i)
        averaged.evaluations += turning.evaluations
        if rest.held:
            contacts = others
            contacts[i] = rest.contacts[i]
            means = Means(contacts, averaged.total(contacts), root.means.repeats)
            turning.deformation[i] = rest.deformation[i]
            averaged.deformation = turning.deformation
            return root._replace(means=means)
        short = rest.contacts[i, [Sum.ALONG_X, Sum.ALONG_Y]] - carried
        creep, *_ = np.linalg.lstsq(fixed, short / np.linalg.norm(short), rcond=None)
        for speed in CREEPS:
            moving = _moving_near(averaged, root.unknown + speed * averaged.top_speed * creep, tolerance)
            if moving is not None:
                return moving
    return None
