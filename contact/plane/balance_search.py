r"""Newton's method for the velocity and yaw rate at which the mean forces of contacts in the plane balance.

The unknown is u = (V_x, V_y, arm times yaw rate), of which the slider is free along the columns of `basis` B; contact i
moves with G_i u. With the mean force Q_i of contact i, load F and damping R the residual and its derivative are

    r = B^T (sum G_i^T Q_i - F - R u),      dr/du = B^T (sum G_i^T dQ_i/dV_i G_i - R) B.

The derivative is taken by two differences of every contact's mean force; Broyden's updates follow it.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled, native
from contact.plane.cycle import COLUMNS, cycle_means
from contact.plane.disc_contacts import Sum, solve_linear

MAX_NEWTON = 60
STEP = 1e-4  # of the differences, over the surface's largest speed
LINEAR = 1e-4  # of that speed: a step that is taken without comparing the residuals
ROUNDING = 1e-9  # of that speed: a step below which only the rounding of the means is left
HELD = 1e-9  # of that speed, below which a slider is taken as held
SHORT = 1e-3  # of the friction limit: forces of rest that fall short of the load by more do not hold it


class Task(IntEnum):
    """What `seek_balance` does."""

    SEARCH = 0  # from `Search.unknown`
    CONTINUE = 1  # the same, with a derivative that is known
    CHECK = 2  # the means at `Search.unknown`, into `Search.moved`
    REST = 3  # whether rest may carry the load


class Found(IntEnum):
    """What it has found."""

    NOTHING = 0
    BALANCE = 1
    AT_REST = 2
    MOVES = 3


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


class Search(NamedTuple):
    """The unknown, its means, and work arrays."""

    unknown: np.ndarray  # (3,)
    residual: np.ndarray  # (m,)
    matrix: np.ndarray  # (m, m): derivative of the residual
    step: np.ndarray  # (m,): by which `unknown` would still move
    deformation: np.ndarray  # (n, 2): of each contact at the start of a period
    means: np.ndarray  # (n, COLUMNS)
    done: np.ndarray  # (2,), integers: evaluations; 1 where the contacts of the last one repeat
    trial: np.ndarray  # (3,)
    new_residual: np.ndarray  # (m,)
    system: np.ndarray  # (m, m + 1)
    velocity: np.ndarray  # (n, 2)
    moved: np.ndarray  # (n, COLUMNS)
    spare: np.ndarray  # (n, 2)


def search_of(body: HeavyBody, unknown: np.ndarray, deformation: np.ndarray) -> Search:
    """Return a search that begins at an unknown."""
    n, m = body.start.size, body.basis.shape[1]
    return Search(
        np.array(unknown, float), np.zeros(m), np.zeros((m, m)), np.zeros(m), deformation, np.zeros((n, COLUMNS)),
        np.zeros(2, np.int64), np.zeros(3), np.zeros(m), np.zeros((m, m + 1)), np.zeros((n, 2)), np.zeros((n, COLUMNS)),
        np.zeros((n, 2)),
    )  # fmt: skip


@compiled
def _means(problem, body, state, work, wide, search, deformation, means):
    """Fill means at `search.trial`, and the contacts' velocities; return 1 where they repeat."""
    for i in range(body.start.size):
        for axis in range(2):
            search.velocity[i, axis] = 0.0
            for k in range(3):
                search.velocity[i, axis] += body.rigid[i, axis, k] * search.trial[k]
    search.done[0] += 1
    return cycle_means(
        problem, body.height, search.velocity, body.start, body.period, state, work, wide, deformation, means
    )


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
def _evaluate(problem, body, state, work, wide, search, residual):
    """Fill means and residual at `search.trial`."""
    search.done[1] = _means(problem, body, state, work, wide, search, search.deformation, search.means)
    _fill_residual(body, search, search.means, residual)


@compiled
def _may_rest(problem, body, state, work, wide, search):
    """Return False if the forces of rest clearly fall short of the load in the direction of what is left of it.

    Contacts that never open start without deformation, then from their limits against that direction.
    """
    n, size = body.start.size, search.residual.size
    for k in range(3):
        search.trial[k] = 0.0
    for i in range(n):
        search.spare[i, 0] = search.spare[i, 1] = 0.0
    _means(problem, body, state, work, wide, search, search.spare, search.moved)
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
    _means(problem, body, state, work, wide, search, search.spare, search.moved)
    _fill_residual(body, search, search.moved, search.new_residual)
    short = 0.0
    for m in range(size):
        short += search.new_residual[m] * search.residual[m]
    return short <= SHORT * body.friction * left


@compiled
def _differentiate(problem, body, state, work, wide, search):
    """Fill the derivative of the residual, whose means and contacts' velocities are known."""
    n, size, step = body.start.size, search.residual.size, STEP * body.top_speed
    for m in range(size):
        for j in range(size):
            search.matrix[m, j] = 0.0
            for k in range(3):
                search.matrix[m, j] -= body.basis[k, m] * body.damping[k] * body.basis[k, j]
    for axis in range(2):
        for i in range(n):
            search.velocity[i, axis] += step
            search.spare[i, 0], search.spare[i, 1] = search.deformation[i, 0], search.deformation[i, 1]
        search.done[0] += 1
        cycle_means(
            problem, body.height, search.velocity, body.start, body.period, state, work, wide, search.spare,
            search.moved,
        )  # fmt: skip
        for i in range(n):
            search.velocity[i, axis] -= step
            slope_x = (search.moved[i, Sum.ALONG_X] - search.means[i, Sum.ALONG_X]) / step
            slope_y = (search.moved[i, Sum.ALONG_Y] - search.means[i, Sum.ALONG_Y]) / step
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
def _update(search, factor):
    """Take the new residual, and correct the derivative by Broyden's update over `factor` times the step."""
    size, length = search.residual.size, factor * factor * _norm(search.step) ** 2
    for m in range(size):
        change = search.new_residual[m] - search.residual[m]
        for j in range(size):
            change -= factor * search.matrix[m, j] * search.step[j]
        for j in range(size):
            search.matrix[m, j] += change * factor * search.step[j] / length
    for m in range(size):
        search.residual[m] = search.new_residual[m]


@native("t t t t t t f i")
def seek_balance(problem, body, state, work, wide, search, close, task):
    """Do a `Task`; return what is `Found`.

    A search moves `search.unknown` until its next step, `search.step`, is below `close` times the top speed, or no
    longer falls below `ROUNDING` of it.
    """
    for k in range(3):
        search.trial[k] = search.unknown[k]
    if task == Task.CHECK:
        for i in range(body.start.size):
            search.spare[i, 0], search.spare[i, 1] = search.deformation[i, 0], search.deformation[i, 1]
        _means(problem, body, state, work, wide, search, search.spare, search.moved)
        return Found.BALANCE
    if task == Task.REST:
        return Found.AT_REST if _may_rest(problem, body, state, work, wide, search) else Found.MOVES
    top, size = body.top_speed, search.residual.size
    _evaluate(problem, body, state, work, wide, search, search.residual)
    fresh = task == Task.SEARCH
    if fresh:
        _differentiate(problem, body, state, work, wide, search)
    last = np.inf
    for _ in range(MAX_NEWTON):
        largest = _step(search)
        if largest < close * top or (largest < ROUNDING * top and largest > 0.5 * last):
            return Found.BALANCE
        if not largest < np.inf:
            return Found.NOTHING
        last = largest
        old, factor, better = _norm(search.residual), min(1.0, 0.7 * top / largest), False
        for _ in range(8):
            for k in range(3):
                search.trial[k] = search.unknown[k]
                for m in range(size):
                    search.trial[k] += factor * body.basis[k, m] * search.step[m]
            _evaluate(problem, body, state, work, wide, search, search.new_residual)
            new = _norm(search.new_residual)
            better = new < 0.9 * old or largest < LINEAR * top
            if better or not fresh:
                break
            factor *= 0.4
        if not better and not fresh:
            for k in range(3):
                search.trial[k] = search.unknown[k]
            _evaluate(problem, body, state, work, wide, search, search.residual)
            _differentiate(problem, body, state, work, wide, search)
            fresh = True
            continue
        _update(search, factor)
        speed = 0.0
        for k in range(3):
            search.unknown[k] = search.trial[k]
            speed = max(speed, abs(search.unknown[k]))
        if speed < HELD * top:
            return Found.AT_REST
        fresh = new > 0.3 * old and largest > LINEAR * top
        if fresh:
            _differentiate(problem, body, state, work, wide, search)
    return Found.NOTHING
