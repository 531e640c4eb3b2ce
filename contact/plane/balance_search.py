r"""Newton's method for the velocity and yaw rate at which the mean forces of contacts in the plane balance.

The unknown is u = (V_x, V_y, arm times yaw rate), of which the slider is free along the columns of `basis` B; contact i
moves with G_i u. With the mean force Q_i of contact i, load F and damping R the residual and its derivative are

    r = B^T (sum G_i^T Q_i - F - R u),      dr/du = B^T (sum G_i^T dQ_i/dV_i G_i - R) B.

The derivative of each contact's mean force comes with the means (`cycle_slopes`).
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled, native
from contact.plane.cycle import COLUMNS, Extra, cycle_means
from contact.plane.cycle_slopes import Slopes
from contact.plane.disc_contacts import State, Sum, Work, solve_linear

MAX_NEWTON = 60
LINEAR = 1e-4  # of the surface's largest speed: a step that is taken without comparing the residuals
LAG = 1e3  # times what a step may leave: the means, and the powers among them, are those before the step
MAX_LAG = 1e-6  # of that speed: the last step of all, so that powers close to about as much
ROUNDING = 1e-9  # of that speed: a step below which only the rounding of the means is left
# What a step leaves, over that speed, at which the search goes over from its first means, and to those of the answer
ROUGH, MIDDLE = 1e-3, 1e-5
HELD = 1e-9  # of that speed, below which a slider is taken as held
FLAT = 1.0 + 1e-6  # times a residual that has not grown but for the rounding of the means
SHORT = 1e-3  # of the friction limit: forces of rest that fall short of the load by more do not hold it


class Task(IntEnum):
    """What `find_balance` does."""

    ALL = 0
    REST = 1  # whether rest may carry the load
    MOTION = 2  # all but that


class Found(IntEnum):
    """What it has found."""

    NOTHING = 0
    BALANCE = 1
    AT_REST = 2  # the search came to rest
    MOVES = 3
    MAY_REST = 4  # contacts that never open may hold the load


class Tools(NamedTuple):
    """Work arrays of means of one accuracy."""

    state: State
    work: Work
    wide: Work  # see `heavy_motion.follow_alone`
    slopes: Slopes


class Accuracies(NamedTuple):
    """Work arrays of the means of a search, by accuracy."""

    first: Tools  # of its first steps, and of rest
    middle: Tools  # of the next ones
    answer: Tools
    check: Tools
    levels: int  # 2: the answer is that of the middle, 3


class HeavyBody(NamedTuple):
    """A heavy slider: what its mean forces depend on besides its velocity, scaled."""

    rigid: np.ndarray  # (n, 2, 3): velocity of contact i = rigid[i] @ u
    basis: np.ndarray  # (3, m): the free motions, orthonormal
    load: np.ndarray  # (3,)
    damping: np.ndarray  # (3,)
    friction: float  # limit of all contacts
    top_speed: float  # beyond which every contact slips all the time against its motion
    height: np.ndarray  # (n,): z_s of each contact
    start: np.ndarray  # (n,): phase of its least approach
    period: float
    closes: bool  # a contact never opens


class Search(NamedTuple):
    """The unknown, its means, and work arrays."""

    unknown: np.ndarray  # (3,)
    residual: np.ndarray  # (m,)
    matrix: np.ndarray  # (m, m): derivative of the residual
    step: np.ndarray  # (m,): by which `unknown` would still move
    sizes: np.ndarray  # (2,): largest component of that step and of the one before
    deformation: np.ndarray  # (n, 2): of each contact at the start of a period
    means: np.ndarray  # (n, COLUMNS)
    done: np.ndarray  # (2,), integers: evaluations; 1 where the contacts of the last one repeat
    trial: np.ndarray  # (3,)
    new_residual: np.ndarray  # (m,)
    system: np.ndarray  # (m, m + 1)
    velocity: np.ndarray  # (n, 2)
    moved: np.ndarray  # (n, COLUMNS)
    spare: np.ndarray  # (n, 2)

    @property
    def left(self) -> float:
        """Estimated part of the last step by which its end still misses the balance.

        Steps fall at least as fast as the last two did. One alone says nothing.
        """
        last, before = self.sizes
        return min(1.0, float(last / before)) if before < np.inf and before > 0.0 else 1.0


def search_of(body: HeavyBody, unknown: np.ndarray, deformation: np.ndarray) -> Search:
    """Return a search that begins at an unknown."""
    n, m = body.start.size, body.basis.shape[1]
    return Search(
        np.array(unknown, float), np.zeros(m), np.zeros((m, m)), np.zeros(m), np.full(2, np.inf), deformation, 
        np.zeros((n, COLUMNS)), np.zeros(2, np.int64), np.zeros(3), np.zeros(m), np.zeros((m, m + 1)),
        np.zeros((n, 2)), np.zeros((n, COLUMNS)), np.zeros((n, 2)),
    )  # fmt: skip


@compiled
def _means(problem, body, tools, derive, search, deformation, means):
    """Fill means at `search.trial`, and the contacts' velocities; return 1 where they repeat."""
    for i in range(body.start.size):
        for axis in range(2):
            search.velocity[i, axis] = 0.0
            for k in range(3):
                search.velocity[i, axis] += body.rigid[i, axis, k] * search.trial[k]
    search.done[0] += 1
    return cycle_means(
        problem, body.height, search.velocity, body.start, body.period, tools.state, tools.work, tools.wide,
        tools.slopes, derive, deformation, means,
    )  # fmt: skip


@compiled
def _fill_residual(body, search, means, residual):
    """Fill the residual of means at `search.trial`."""
    for m in range(residual.size):
        residual[m] = 0.0
        for k in range(3):
            force = -body.load[k] - body.damping[k] * search.trial[k]
            for i in range(body.start.size):
                force += body.rigid[i, 0, k] * means[i, Sum.ALONG_X] + body.rigid[i, 1, k] * means[i, Sum.ALONG_Y]
            residual[m] += body.basis[k, m] * force


@compiled
def _evaluate(problem, body, tools, derive, search, residual):
    """Fill means and residual at `search.trial`, and the derivative where asked for."""
    search.done[1] = _means(problem, body, tools, derive, search, search.deformation, search.means)
    _fill_residual(body, search, search.means, residual)


@compiled
def _may_rest(problem, body, tools, search):
    """Return False if the forces of rest clearly fall short of the load in the direction of what is left of it.

    Contacts that never open start without deformation, then from their limits against that direction.
    """
    n, size = body.start.size, search.residual.size
    for k in range(3):
        search.trial[k] = 0.0
    for i in range(n):
        search.spare[i, 0] = search.spare[i, 1] = 0.0
    _means(problem, body, tools, 0, search, search.spare, search.moved)
    _fill_residual(body, search, search.moved, search.residual)
    left = _norm(search.residual)
    if left <= SHORT * body.friction:
        return True
    for i in range(n):
        for axis in range(2):
            search.spare[i, axis] = 0.0
            for k in range(3):
                for m in range(size):
                    search.spare[i, axis] -= body.rigid[i, axis, k] * body.basis[k, m] * search.residual[m]
        factor = 1e3 / (np.hypot(search.spare[i, 0], search.spare[i, 1]) + 1e-300)
        for axis in range(2):
            search.spare[i, axis] *= factor
    _means(problem, body, tools, 0, search, search.spare, search.moved)
    _fill_residual(body, search, search.moved, search.new_residual)
    short = 0.0
    for m in range(size):
        short += search.new_residual[m] * search.residual[m]
    return short <= SHORT * body.friction * left


@compiled
def _fill_matrix(body, search):
    """Fill the derivative of the residual from those of the contacts' means."""
    size = search.residual.size
    for m in range(size):
        for j in range(size):
            search.matrix[m, j] = 0.0
            for k in range(3):
                search.matrix[m, j] -= body.basis[k, m] * body.damping[k] * body.basis[k, j]
    for i in range(body.start.size):
        own = search.means[i]
        for axis in range(2):
            slope_x = own[Extra.X_BY_X] if axis == 0 else own[Extra.X_BY_Y]
            slope_y = own[Extra.Y_BY_X] if axis == 0 else own[Extra.Y_BY_Y]
            for m in range(size):
                force = 0.0
                for k in range(3):
                    force += body.basis[k, m] * (body.rigid[i, 0, k] * slope_x + body.rigid[i, 1, k] * slope_y)
                for j in range(size):
                    for k in range(3):
                        search.matrix[m, j] += force * body.rigid[i, axis, k] * body.basis[k, j]


@compiled
def _step(search):
    """Fill the step of Newton's method and return its largest component."""
    size, scale = search.residual.size, 0.0
    for m in range(size):
        for j in range(size):
            scale = max(scale, abs(search.matrix[m, j]))
    for m in range(size):
        for j in range(size):
            search.system[m, j] = search.matrix[m, j]
        # friction alone does not resist along its direction: the step is the least one there
        search.system[m, m] -= 1e-12 * scale
        search.system[m, size] = -search.residual[m]
    if not solve_linear(search.system):
        return np.inf
    largest = 0.0
    for m in range(size):
        search.step[m] = search.system[m, size]
        largest = max(largest, abs(search.step[m]))
    return largest


@compiled
def _norm(vector):
    """Return the Euclidean norm."""
    total = 0.0
    for m in range(vector.size):
        total += vector[m] * vector[m]
    return np.sqrt(total)


@compiled
def _along_step(search, residual):
    """Return the component of a residual along the step, times its length."""
    total = 0.0
    for m in range(residual.size):
        total += residual[m] * search.step[m]
    return total


@compiled
def _seek(problem, body, tools, search, close, answers):
    """Move `search.unknown` until what the next step leaves is below `close` times the top speed (`Search.left`).

    Or until steps no longer fall below `ROUNDING` of it. `answers`: the derivative of coarser means near this balance
    is kept while the steps fall fast.
    """
    for k in range(3):
        search.trial[k] = search.unknown[k]
    top, derive = body.top_speed, 0 if answers else 1
    lag = LAG * close if close >= MIDDLE else min(LAG * close, MAX_LAG)
    reach = 0.7 * top  # of a step; farther while steps go on as far
    _evaluate(problem, body, tools, derive, search, search.residual)
    for _ in range(MAX_NEWTON):
        if derive == 1:
            _fill_matrix(body, search)
        last, largest = search.sizes[0], _step(search)
        search.sizes[0], search.sizes[1] = largest, last
        left = largest * min(largest / last, 1.0) if last < np.inf else largest
        if (left < close * top and largest < lag * top) or (largest < ROUNDING * top and largest > 0.5 * last):
            return Found.BALANCE
        if not largest < np.inf:
            return Found.NOTHING
        derive = 0 if answers and largest < 0.1 * last else 1
        old, factor = _norm(search.residual), min(1.0, reach / largest)
        rate = _along_step(search, search.residual)
        reach *= 2.0 if factor < 1.0 else 1.0
        for _ in range(8):
            for k in range(3):
                search.trial[k] = search.unknown[k]
                for m in range(search.residual.size):
                    search.trial[k] += factor * body.basis[k, m] * search.step[m]
            _evaluate(problem, body, tools, derive, search, search.new_residual)
            new = _norm(search.new_residual)
            if new < 0.9 * old or largest < LINEAR * top:
                break
            # dry friction hardly changes beyond the surface's speed: there a step ends where the force left turns
            if new < FLAT * old and rate > 0.0 and _along_step(search, search.new_residual) > 0.0:
                break
            factor, reach = 0.4 * factor, 0.7 * top
        speed = 0.0
        for k in range(3):
            search.unknown[k] = search.trial[k]
            speed = max(speed, abs(search.unknown[k]))
        for m in range(search.residual.size):
            search.residual[m] = search.new_residual[m]
        if speed < HELD * top:
            return Found.AT_REST
    return Found.NOTHING


@compiled
def _go_on(body, search):
    """Take the last step of a search: the means that follow are finer."""
    for k in range(3):
        for m in range(search.residual.size):
            search.unknown[k] += body.basis[k, m] * search.step[m]


@native("t t t t f i")
def find_balance(problem, body, accuracies, search, close, task):
    """Do a `Task`; return what is `Found`.

    A balance is `search.unknown` and the step that would follow, `search.step`; its means are in `search.means`, those
    of the check at the same place in `search.moved`.
    """
    if task != Task.MOTION and body.closes and _may_rest(problem, body, accuracies.first, search):
        return Found.MAY_REST
    if task == Task.REST:
        return Found.MOVES
    found = _seek(problem, body, accuracies.first, search, ROUGH, False)
    if found == Found.BALANCE:
        _go_on(body, search)
        enough = close if accuracies.levels == 2 else MIDDLE
        found = _seek(problem, body, accuracies.middle, search, enough, False)
    if found == Found.BALANCE and accuracies.levels == 3:
        _go_on(body, search)
        found = _seek(problem, body, accuracies.answer, search, close, True)
    if found == Found.BALANCE:
        for k in range(3):
            search.trial[k] = search.unknown[k]
        for i in range(body.start.size):
            search.spare[i, 0], search.spare[i, 1] = search.deformation[i, 0], search.deformation[i, 1]
        _means(problem, body, accuracies.check, 0, search, search.spare, search.moved)
    return found
