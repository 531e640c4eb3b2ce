r"""Event-driven motion of contacts in the plane: stick in closed form, the angle of slip by Radau's collocation.

While contact i sticks, its deformation follows the surface, e' = w. While it slips, e = c z n and

    lambda = n.w - c z' >= 0,      c z alpha' = t.w,      n = (cos alpha, sin alpha),   t = e_z x n,                 (1)

(Moreau's sweeping process with a disc of radius c z; the first is eq. 3 of Feenstra and Breedveld). Equation (1) is
stiff where z is small: its rate is |w|/(c z). A segment ends where a contact

    touches        z = 0, rising: it slips at once with n = w/|w| where |w| > c z', else it sticks with e = 0
    opens          z = 0, falling
    begins to slip |e| = c z
    sticks         lambda = 0
    passes         the least |e| of stick (e.w = 0), where |e| is small: the force bends there

The slider's coordinates follow by fixed-point iteration of the same collocation: its own motion is slow.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.codes import Regime
from contact.jit.compiled import compiled, formula, native
from contact.law.elastic import back_load, spring_force
from contact.law.normal import load
from contact.plane.last_period import (
    Ended,
    LastPeriod,
    Place,
    expected_event,
    expected_phase,
    keep_event,
    keep_step,
    last_period_of,
    regimes_of,
)
from contact.plane.plane_equations import Body, PlaneProblem, Surface, fill_surface, turned_by
from contact.plane.radau import Map, Nodes, radau

TURN = 2.0 * np.pi
NEAR = 0.3  # |e| over c z below which a least |e| ends a segment
# Of an event, in phase: forces are continuous there, their integrals err by its square; over the tolerance, and at most
CLOSE, CLOSE_SHARE, FAR = 1e-9, 1e-3, 1e-5
ANGLE_SHARE = 1e-3  # the same of lambda, known no better than the angle at the nodes
BEYOND = 0.25  # of that: how far behind an event a segment is to end
BEND = 1e-4  # the same of a least |e|, where the force bends
ENDS = 1e-8  # approach below which a contact that opens has opened where slip and stick alternate; its force is 1e-12
NEGATIVE = 1e-12  # of a guard beyond zero; phases of 300 cycles are rounded to 2e-13
NEARLY = 0.98  # of a segment: a shorter one that ends at a guard's least value must end before this
PASSED = 2.0 * BEND  # phase from the start of a segment within which a least |e| has been met
MAX_STEP = 0.6  # rad of the fastest wave
MAX_PER_NODE = 0.2  # the same for each node, where it is more and the events of the last period are known
MAX_FLIGHT = 0.4  # the same while all contacts are open: z is looked at in the nodes
LEAST_STEP = 1e-3  # rad, of the first trial of a segment
SMALL_ANGLE = 0.02  # rad: cosine and sine by their series, to 1e-13
MAX_TURN = 3.0  # rad of angle per rad of phase, of the guess at the start of a segment
ALIKE = 0.02  # change of a segment's length up to which the turning at the nodes of the last trial is the guess
MAX_TRIES = 60  # trials of the length of one segment
PICARD = 1e-13  # change of the body's rates by one more iteration of its motion, below which it ends
MAX_LAG = 1e-9  # of the last change, by which the forces lag behind the motion
LAG_SHARE = 1e-5  # of the tolerance, by which the forces of the first iteration may lag behind it
CARELESS = 1e-2  # rad: a segment after which regimes no longer alternate, see `Work.careful`
LATE = 0.25  # of a segment, beyond which an event that was expected at its end is no longer looked for
MAX_NEWTON = 4  # of them by Newton's method towards an event
MAX_SEGMENTS = 200_000  # of one call
ALTERNATIONS = 6  # events at one instant, after which a contact that opens and alternates between slip and stick opens
MAX_IDLE = 20  # events of a contact at one instant


class RegimeEnd(IntEnum):
    """What ends the regime of a contact."""

    NONE = 0
    TOUCH = 1
    OPEN = 2
    SLIP = 3
    STICK = 4
    PASS = 5


class Stage(IntEnum):
    """Columns of `Work.stage`: a contact at a node."""

    Z = 0
    Z_RATE = 1
    W_X = 2
    W_Y = 3
    E_X = 4
    E_Y = 5
    N_X = 6  # direction of the force
    N_Y = 7
    P = 8
    Q_X = 9
    Q_Y = 10
    LAMBDA = 11
    TURNING = 12  # d alpha/ds
    ARM_X = 13  # R r
    ARM_Y = 14


class Sum(IntEnum):
    """Integrals over the phase, of each contact; forces and powers."""

    NORMAL = 0
    ALONG_X = 1
    ALONG_Y = 2
    MOMENT = 3  # of the tangential force
    SLIP = 4  # mu P lambda
    WAVE_TANGENTIAL = 5  # Q.u_t'
    WAVE_NORMAL = 6  # P u_z'
    LEAK = 7  # -W_z z'
    DAMPER = 8  # chi P z'^2
    CONTACT = 9  # 1 in contact
    STUCK = 10  # 1 in stick


class Count(IntEnum):
    """Events of a contact since the counts were cleared."""

    MADE = 0
    OPENED = 1
    SLIPS = 2


class Total(IntEnum):
    """Index of `State.total`."""

    PHASE = 0
    STEP = 1  # proposed length of the next segment
    STEPS = 2
    SOLVES = 3
    LOST_NORMAL = 4  # energy lost in the body's damper of the height, and in the others
    LOST_TANGENTIAL = 5
    MARGIN = 6  # least c z - |e| of stick in the period of a heavy slider


class State(NamedTuple):
    """Body and contacts at a phase, and the integrals since they were cleared."""

    q: np.ndarray  # (4,)
    p: np.ndarray  # (4,)
    regime: np.ndarray  # (n,), integers
    begins: np.ndarray  # (n,): 1 in the segment that begins at the touch
    e: np.ndarray  # (n, 2)
    alpha: np.ndarray  # (n,)
    sums: np.ndarray  # (n, len(Sum))
    counts: np.ndarray  # (n, len(Count))
    total: np.ndarray  # (len(Total),)


class Work(NamedTuple):
    """Work arrays of a segment with s nodes."""

    nodes: Nodes
    tolerance: float  # of the force in a segment over the friction limit
    phase: np.ndarray  # (s,)
    rate: np.ndarray  # (s,): d phase/ds
    q: np.ndarray  # (s, 4)
    p: np.ndarray  # (s, 4)
    a: np.ndarray  # (s, 4): accelerations
    stage: np.ndarray  # (s, n, len(Stage))
    surface: np.ndarray  # (s, n, 6)
    before: np.ndarray  # (n, 6): surface at the start of the segment
    start: np.ndarray  # (n, len(Stage)): contacts at the start
    spot: np.ndarray  # (n, 6): surface at any phase
    point: np.ndarray  # (n, len(Stage)): contacts there
    matrix: np.ndarray  # (s, s + 1)
    slope_matrix: np.ndarray  # (s, s + 3), see `cycle_slopes`
    trend: np.ndarray  # (4,): rate of the accelerations at the end of the last segment
    bend: np.ndarray  # (n,): second derivative of the contacts' angles there
    careful: np.ndarray  # (1,), integer: 1 where events are located to rounding, without what the last period tells
    kept: LastPeriod


def state_of(n: int) -> State:
    """Return the state of a body at rest above the surface."""
    total = np.zeros(len(Total))
    total[Total.STEP] = 0.1
    return State(
        np.zeros(4), np.zeros(4), np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros((n, 2)), np.zeros(n),
        np.zeros((n, len(Sum))), np.zeros((n, len(Count)), np.int64), total,
    )  # fmt: skip


def work_of(n: int, nodes: int, tolerance: float, period: float = 0.0) -> Work:
    """Return work arrays for n contacts; `period` of the waves, from one to the next of which events are kept."""
    s = nodes
    return Work(
        radau(nodes), tolerance, np.empty(s), np.empty(s), np.empty((s, 4)), np.empty((s, 4)), np.zeros((s, 4)),
        np.zeros((s, n, len(Stage))), np.empty((s, n, 6)), np.empty((n, 6)), np.zeros((n, len(Stage))),
        np.empty((n, 6)), np.zeros((n, len(Stage))), np.empty((s, s + 1)), np.empty((s, s + 3)),
        np.zeros(4), np.zeros(n), np.array([int(period == 0.0)]),
        last_period_of(n, period),
    )  # fmt: skip


def with_nodes(work: Work, nodes: int) -> Work:
    """Return the work arrays with another number of nodes; what a segment knows of its start is shared."""
    own = work_of(work.start.shape[0], nodes, work.tolerance)
    return own._replace(before=work.before, start=work.start, spot=work.spot, point=work.point)


@formula
def size_of(x, y):
    """Return the length of a vector of scaled numbers: `hypot` guards against an overflow that they do not have."""
    return np.sqrt(x * x + y * y)


@compiled
def solve_linear(matrix):
    """Solve a linear system in place, its right sides in the columns behind it; return False where it is singular."""
    n, columns = matrix.shape
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if matrix[best, k] == 0.0 or not np.isfinite(matrix[best, k]):
            return False
        if best != k:
            for j in range(k, columns):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        for i in range(k + 1, n):
            f = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, columns):
                matrix[i, j] -= f * matrix[k, j]
    for side in range(n, columns):
        for k in range(n - 1, -1, -1):
            value = matrix[k, side]
            for j in range(k + 1, n):
                value -= matrix[k, j] * matrix[j, side]
            matrix[k, side] = value / matrix[k, k]
    return True


@compiled
def fill_kinematics(problem, i, surface, q, p, row):
    """Fill approach and surface speed of contact i at a node."""
    c, s = (1.0, 0.0) if q[Body.YAW] == 0.0 else (np.cos(q[Body.YAW]), np.sin(q[Body.YAW]))
    x, y = c * problem.x[i] - s * problem.y[i], s * problem.x[i] + c * problem.y[i]
    row[Stage.ARM_X], row[Stage.ARM_Y] = x, y
    row[Stage.Z] = problem.height[i] + surface[Surface.Z] - q[Body.HEIGHT]
    row[Stage.Z_RATE] = surface[Surface.Z_RATE] - p[Body.HEIGHT]
    row[Stage.W_X] = surface[Surface.X_RATE] - p[Body.X] + p[Body.YAW] * y
    row[Stage.W_Y] = surface[Surface.Y_RATE] - p[Body.Y] - p[Body.YAW] * x


@compiled
def angle_equation(problem, i, row, rate):
    """Return (n.w, t.w, c z over the rate) of eq. (1) at a node of a segment, whose direction is filled."""
    cos, sin = row[Stage.N_X], row[Stage.N_Y]
    along, across = cos * row[Stage.W_X] + sin * row[Stage.W_Y], cos * row[Stage.W_Y] - sin * row[Stage.W_X]
    # at the end of a segment that ends at z = 0 the equation is t.w = 0; where only the map stands still, K = 0
    stands = rate == 0.0
    opens = row[Stage.Z] < 1e-12
    inertia = problem.limit_slope[i] * max(row[Stage.Z], 0.0) / rate if not stands else (0.0 if opens else 1.0)
    if stands and not opens:
        along = across = 0.0
    return along, across, inertia


@compiled
def _slip_angles(problem, i, alpha, phase, known, work):
    """Solve eq. (1) for contact i at the nodes of a segment by Newton's method; return True where it converges.

    `known`: True where the turning of a longer segment, in this one's nodes, stands there as a guess. Else the guess is
    that of the start.
    """
    nodes, stage, matrix, c = work.nodes, work.stage, work.matrix, problem.limit_slope[i]
    n, close = nodes.weight.size, max(1e-6, 0.1 * work.tolerance)
    if not known:
        start, turning = work.start[i], 0.0
        if start[Stage.Z] > 0.0:
            turning = (start[Stage.N_X] * start[Stage.W_Y] - start[Stage.N_Y] * start[Stage.W_X]) / (c * start[Stage.Z])
        for j in range(n):
            guess = turning + work.bend[i] * (work.phase[j] - phase)
            stage[j, i, Stage.TURNING] = max(-MAX_TURN, min(MAX_TURN, guess)) * work.rate[j]
    for j in range(n):
        angle = alpha
        for k in range(n):
            angle += nodes.integral[j, k] * stage[k, i, Stage.TURNING]
        stage[j, i, Stage.N_X], stage[j, i, Stage.N_Y] = np.cos(angle), np.sin(angle)
    for _ in range(25):
        for j in range(n):
            row = stage[j, i]
            along, across, inertia = angle_equation(problem, i, row, work.rate[j])
            for k in range(n):
                matrix[j, k] = along * nodes.integral[j, k]
            matrix[j, j] += inertia
            matrix[j, n] = across - inertia * row[Stage.TURNING]
        if not solve_linear(matrix):
            return False
        change = 0.0
        for j in range(n):
            change = max(change, abs(matrix[j, n]))
        factor = 1.0 if change < 2.0 else 2.0 / change
        for j in range(n):
            row, turn = stage[j, i], 0.0
            for k in range(n):
                turn += nodes.integral[j, k] * matrix[k, n]
            row[Stage.TURNING] += factor * matrix[j, n]
            _turn(row, factor * turn)
        if change < close:  # quadratic: the last change leaves its square
            return True
    return False


@compiled
def _turn(row, angle):
    """Turn the direction of a contact's force at a node by an angle."""
    if abs(angle) < SMALL_ANGLE:
        square = angle * angle
        c = 1.0 - square * (0.5 - square / 24.0)
        s = angle * (1.0 - square * (1.0 - square / 20.0) / 6.0)
    else:
        c, s = np.cos(angle), np.sin(angle)
    cos, sin = row[Stage.N_X], row[Stage.N_Y]
    row[Stage.N_X], row[Stage.N_Y] = c * cos - s * sin, s * cos + c * sin


@compiled
def fill_forces(problem, i, regime, row):
    """Fill the forces of contact i at a node from its approach and deformation."""
    z, friction, c, kappa = row[Stage.Z], problem.friction, problem.limit_slope[i], problem.stiffness[i]
    row[Stage.P] = row[Stage.Q_X] = row[Stage.Q_Y] = 0.0
    if regime == Regime.SEPARATED or z <= 0.0:
        return
    elastic = kappa * load(z, problem.normal)
    row[Stage.P] = elastic * (1.0 + problem.contact_damping * row[Stage.Z_RATE])
    if regime == Regime.SLIP:
        q = friction * elastic
    else:
        size = size_of(row[Stage.E_X], row[Stage.E_Y])
        if size == 0.0 or c == 0.0:
            row[Stage.N_X], row[Stage.N_Y] = 1.0, 0.0
            return
        row[Stage.N_X], row[Stage.N_Y] = row[Stage.E_X] / size, row[Stage.E_Y] / size
        q = spring_force(z, min(size, c * z), friction * kappa, c, problem.normal)
    row[Stage.Q_X], row[Stage.Q_Y] = q * row[Stage.N_X], q * row[Stage.N_Y]


@compiled
def _guard(problem, i, regime, which, row):
    """Return a guard of contact i, positive inside its regime."""
    if which == RegimeEnd.TOUCH:
        return -row[Stage.Z]
    if which == RegimeEnd.OPEN:
        return row[Stage.Z]
    if which == RegimeEnd.STICK:
        return row[Stage.LAMBDA]
    size = size_of(row[Stage.E_X], row[Stage.E_Y])
    if which == RegimeEnd.SLIP:
        return problem.limit_slope[i] * row[Stage.Z] - size
    speed = size_of(row[Stage.W_X], row[Stage.W_Y])
    return -(row[Stage.E_X] * row[Stage.W_X] + row[Stage.E_Y] * row[Stage.W_Y]) / (speed + 1e-300)


@compiled
def guard_rate(problem, i, which, length, kind, work):
    """Return the rate of a guard at the end of a segment."""
    stage = work.stage
    row = stage[stage.shape[0] - 1, i]
    if which == RegimeEnd.TOUCH:
        return -row[Stage.Z_RATE]
    if which == RegimeEnd.OPEN:
        return row[Stage.Z_RATE]
    if which == RegimeEnd.SLIP:
        along = row[Stage.N_X] * row[Stage.W_X] + row[Stage.N_Y] * row[Stage.W_Y]
        return problem.limit_slope[i] * row[Stage.Z_RATE] - along
    if which == RegimeEnd.PASS:
        return -size_of(row[Stage.W_X], row[Stage.W_Y])
    rate = 0.0
    for j in range(stage.shape[0]):
        rate += work.nodes.slope[kind, j] * stage[j, i, Stage.LAMBDA]
    return rate / length


@compiled
def _fill_contact(problem, i, known, state, work):
    """Fill contact i at all nodes of a segment; return True where its equations are solved."""
    stage, regime = work.stage, state.regime[i]
    n = stage.shape[0]
    for j in range(n):
        fill_kinematics(problem, i, work.surface[j, i], work.q[j], work.p[j], stage[j, i])
    if regime == Regime.SLIP:
        opens = stage[n - 1, i, Stage.Z] < -_closeness(work)
        for j in range(n - 1):
            opens = opens or stage[j, i, Stage.Z] <= 0.0
        if opens:  # before the end: the caller shortens the segment, to where the height with these forces tells
            for j in range(n):
                row = stage[j, i]
                if not known:
                    row[Stage.N_X], row[Stage.N_Y] = work.start[i, Stage.N_X], work.start[i, Stage.N_Y]
                row[Stage.LAMBDA] = 1.0
                fill_forces(problem, i, regime, row)
            return True
        if not _slip_angles(problem, i, state.alpha[i], state.total[Total.PHASE], known, work):
            return False
    for j in range(n):
        _fill_deformation(problem, i, j, state, work)
        fill_forces(problem, i, regime, stage[j, i])
    return True


@compiled
def _fill_deformation(problem, i, j, state, work):
    """Fill the deformation of contact i at a node of a segment, and lambda, from the motion of surface and body."""
    row, surface, before, c = work.stage[j, i], work.surface[j, i], work.before[i], problem.limit_slope[i]
    if state.regime[i] == Regime.STICK:
        turn_x, turn_y = turned_by(problem, i, state.q[Body.YAW], work.q[j, Body.YAW])
        row[Stage.E_X] = state.e[i, 0] + (surface[Surface.X] - before[Surface.X])
        row[Stage.E_Y] = state.e[i, 1] + (surface[Surface.Y] - before[Surface.Y])
        row[Stage.E_X] -= (work.q[j, Body.X] - state.q[Body.X]) + turn_x
        row[Stage.E_Y] -= (work.q[j, Body.Y] - state.q[Body.Y]) + turn_y
    elif state.regime[i] == Regime.SLIP:
        row[Stage.E_X] = c * row[Stage.Z] * row[Stage.N_X]
        row[Stage.E_Y] = c * row[Stage.Z] * row[Stage.N_Y]
        row[Stage.LAMBDA] = row[Stage.N_X] * row[Stage.W_X] + row[Stage.N_Y] * row[Stage.W_Y] - c * row[Stage.Z_RATE]


@compiled
def solve_segment(problem, first, last, length, kind, known, state, work):
    """Solve one segment of a length in phase for contacts `first` to `last`; return True where it converges.

    `known`: see `_slip_angles`.
    """
    nodes, n = work.nodes, work.phase.size
    begin = state.total[Total.PHASE]
    state.total[Total.SOLVES] += 1.0
    moves = False
    for k in range(4):
        moves = moves or problem.inverse[k] > 0.0
    for j in range(n):
        work.phase[j], work.rate[j] = begin + length * nodes.phase[kind, j], length * nodes.rate[kind, j]
        fill_surface(problem, first, last, work.phase[j], work.surface[j])
    last_change = np.inf
    for count in range(40):
        _integrate(problem, length, kind, state, work)
        for i in range(first, last):
            if not _fill_contact(problem, i, known or count > 0, state, work):
                return False
        if not moves:
            return True
        change = 0.0
        for j in range(n):
            total_x = total_y = total_z = moment = 0.0
            for i in range(first, last):
                row = work.stage[j, i]
                total_z += row[Stage.P]
                total_x += row[Stage.Q_X]
                total_y += row[Stage.Q_Y]
                moment += row[Stage.ARM_X] * row[Stage.Q_Y] - row[Stage.ARM_Y] * row[Stage.Q_X]
            for k in range(4):
                total = total_z if k == 0 else total_x if k == 1 else total_y if k == 2 else moment
                new = problem.inverse[k] * (total + problem.force[k] - problem.damping[k] * work.p[j, k])
                change = max(change, abs(new - work.a[j, k]) * (1.0 if k < 3 else _reach(problem)))
                work.a[j, k] = new
        left = change * length
        if count == 0 and work.careful[0] == 0 and left * length < LAG_SHARE * work.tolerance:
            _integrate(problem, length, kind, state, work)
            return True
        if left < PICARD or (count > 0 and left < MAX_LAG and left * min(change / last_change, 1.0) < PICARD):
            _integrate(problem, length, kind, state, work)
            return True
        last_change = change
    return False


@compiled
def _integrate(problem, length, kind, state, work):
    """Fill the body's rates and coordinates at the nodes from its accelerations there."""
    nodes, n = work.nodes, work.phase.size
    for k in range(4):
        moves = problem.inverse[k] > 0.0
        for j in range(n):
            speed = way = 0.0
            if moves:
                for i in range(n):
                    speed += nodes.speed[kind, j, i] * work.a[i, k]
                    way += nodes.way[kind, j, i] * work.a[i, k]
            work.p[j, k] = state.p[k] + length * speed
            work.q[j, k] = state.q[k] + length * (nodes.phase[kind, j] * state.p[k] + length * way)


@compiled
def _reach(problem):
    """Return the largest distance of a contact from the axis of rotation."""
    reach = 0.0
    for i in range(problem.x.size):
        reach = max(reach, size_of(problem.x[i], problem.y[i]))
    return reach


@compiled
def _rate_between(problem, i, which, row):
    """Return the rate of a guard at a node; 0 of a guard that is not looked at between two nodes."""
    if which == RegimeEnd.TOUCH:
        return -row[Stage.Z_RATE]
    if which != RegimeEnd.SLIP:
        return 0.0
    size = size_of(row[Stage.E_X], row[Stage.E_Y])
    along = row[Stage.E_X] * row[Stage.W_X] + row[Stage.E_Y] * row[Stage.W_Y]
    speed = along / size if size > 0.0 else size_of(row[Stage.W_X], row[Stage.W_Y])
    return problem.limit_slope[i] * row[Stage.Z_RATE] - speed


@compiled
def _first_event(problem, first, last, length, kind, state, work):
    """Return (contact, guard, phase from the start, crossing) of the earliest event of a segment.

    `crossing`: 1 where it lies before the segment's last node, 2 at the last node, 0 where there is no event.
    """
    nodes, n = work.nodes, work.phase.size
    found, what, at, crossing = -1, 0, length, 0
    for i in range(first, last):
        regime = state.regime[i]
        for turn in range(2):
            if regime == Regime.SEPARATED:
                which = RegimeEnd.TOUCH
            elif regime == Regime.SLIP:
                which = RegimeEnd.OPEN if turn == 0 else RegimeEnd.STICK
            else:
                which = RegimeEnd.SLIP if turn == 0 else RegimeEnd.PASS
            if regime == Regime.SEPARATED and turn == 1:
                continue
            old, phase_old = _guard(problem, i, regime, which, work.start[i]), 0.0
            x_old, y_old = work.start[i, Stage.E_X], work.start[i, Stage.E_Y]
            rate_old = _rate_between(problem, i, which, work.start[i])
            if state.begins[i] == 1:
                if which == RegimeEnd.PASS:
                    continue
                if which != RegimeEnd.STICK:
                    old = 0.0
            if which == RegimeEnd.TOUCH and old <= 0.0 and work.start[i, Stage.Z_RATE] <= 0.0:
                old = 0.0  # it has just opened
            for j in range(n):
                row = work.stage[j, i]
                new, phase = _guard(problem, i, regime, which, row), length * nodes.phase[kind, j]
                if phase_old > at:
                    break
                if which == RegimeEnd.TOUCH and old == 0.0 and new < 0.0 and row[Stage.Z_RATE] < 0.0:
                    continue
                share = old / (old - new) if new < 0.0 < old else 0.0
                place = phase_old + share * (phase - phase_old)
                passes = new < -NEGATIVE
                if which == RegimeEnd.PASS and passes:
                    x, y, limit = row[Stage.E_X], row[Stage.E_Y], problem.limit_slope[i] * row[Stage.Z]
                    d_x, d_y = x - x_old, y - y_old
                    # the chord between both nodes must come near zero between them; else w itself has turned
                    between = x_old * d_x + y_old * d_y < 0.0 < x * d_x + y * d_y
                    near = abs(x_old * y - y_old * x) <= NEAR * limit * size_of(d_x, d_y)
                    passes = between and near and old > 1e-11 and place > PASSED
                if passes:
                    if place < at or found < 0:
                        found, what, at, crossing = i, which, place, 1 if j < n - 1 else 2
                    break
                rate = _rate_between(problem, i, which, row)
                if rate_old < 0.0 < rate:
                    # between two nodes the gap may close, or slip begin: aim at the guard's least value
                    share = rate_old / (rate_old - rate)
                    place = phase_old + share * (phase - phase_old)
                    if old + 0.5 * rate_old * share * (phase - phase_old) < -NEGATIVE and place < NEARLY * length:
                        if place < at or found < 0:
                            found, what, at, crossing = i, RegimeEnd.NONE, place, 1
                        break
                old, phase_old, rate_old = new, phase, rate
                x_old, y_old = row[Stage.E_X], row[Stage.E_Y]
    return found, what, at, crossing


@compiled
def segment_error(problem, first, last, state, work):
    """Return the error of a segment's forces over the friction limit, by a rule without one of the nodes."""
    nodes, error = work.nodes, 0.0
    for i in range(first, last):
        if state.regime[i] == Regime.SEPARATED:
            continue
        p = x = y = top = angle = 0.0
        for j in range(nodes.weight.size):
            row, d = work.stage[j, i], nodes.difference[j]
            p += d * work.rate[j] * row[Stage.P]
            x += d * work.rate[j] * row[Stage.Q_X]
            y += d * work.rate[j] * row[Stage.Q_Y]
            angle += d * row[Stage.TURNING] if state.regime[i] == Regime.SLIP else 0.0
            top = max(top, row[Stage.P])
        scale = problem.stiffness[i] * load(1.0, problem.normal)
        own = (abs(p) + size_of(x, y) / problem.friction + abs(angle) * top) / scale
        error = max(error, own)
    return error


@compiled
def _rises(problem, i, which, state, work):
    """Return True if a guard rises at the start of a segment, or does not fall there beyond rounding."""
    row = work.start[i]
    if which == RegimeEnd.OPEN:
        return row[Stage.Z_RATE] > 0.0
    if which != RegimeEnd.SLIP:
        return False
    # where slip has just ended the rate is zero, and the guard rises with the second order
    return _rate_between(problem, i, which, row) > -2.0 * CLOSE


@compiled
def shorter(error, work):
    """Return the factor on a segment that is too long for its error."""
    return max(0.15, min(0.8, grown(error, work)))


@compiled
def grown(error, work):
    """Return the factor on a segment's length that makes its error the tolerance."""
    return 0.9 * (work.tolerance / (error + 1e-300)) ** (1.0 / work.phase.size)


@compiled
def finish_segment(problem, first, last, state, work):
    """Add the integrals of a solved segment and move body and contacts to its end."""
    nodes, n, sums = work.nodes, work.phase.size, state.sums
    between = work.phase[n - 1] - work.phase[n - 2]  # 0 in a segment that is short beside the rounding of its phase
    for i in range(first, last):
        regime, c = state.regime[i], problem.limit_slope[i]
        for j in range(n if regime != Regime.SEPARATED else 0):
            row, d = work.stage[j, i], nodes.weight[j] * work.rate[j]
            z = row[Stage.Z]
            if z <= 0.0:
                continue
            q_x, q_y, surface = row[Stage.Q_X], row[Stage.Q_Y], work.surface[j, i]
            sums[i, Sum.NORMAL] += d * row[Stage.P]
            sums[i, Sum.ALONG_X] += d * q_x
            sums[i, Sum.ALONG_Y] += d * q_y
            sums[i, Sum.MOMENT] += d * (row[Stage.ARM_X] * q_y - row[Stage.ARM_Y] * q_x)
            sums[i, Sum.WAVE_TANGENTIAL] += d * (q_x * surface[Surface.X_RATE] + q_y * surface[Surface.Y_RATE])
            sums[i, Sum.WAVE_NORMAL] += d * row[Stage.P] * surface[Surface.Z_RATE]
            elastic = problem.stiffness[i] * load(z, problem.normal)
            sums[i, Sum.DAMPER] += d * problem.contact_damping * elastic * row[Stage.Z_RATE] ** 2
            sums[i, Sum.CONTACT] += d
            size = c * z
            if regime == Regime.SLIP:
                sums[i, Sum.SLIP] += d * problem.friction * elastic * row[Stage.LAMBDA]
            else:
                size = size_of(row[Stage.E_X], row[Stage.E_Y])
                sums[i, Sum.STUCK] += d
            if c > 0.0:
                back = problem.friction * problem.stiffness[i] * c * back_load(z, z - size / c, problem.normal)
                sums[i, Sum.LEAK] -= d * back * row[Stage.Z_RATE]
        row = work.stage[n - 1, i]
        # the body has moved on since the forces were filled, by up to `MAX_LAG`: the next segment begins where it is
        fill_kinematics(problem, i, work.surface[n - 1, i], work.q[n - 1], work.p[n - 1], row)
        _fill_deformation(problem, i, n - 1, state, work)
        work.bend[i] = 0.0
        if regime == Regime.SLIP:
            for j in range(n):
                state.alpha[i] += nodes.weight[j] * work.stage[j, i, Stage.TURNING]
            if work.rate[n - 1] > 0.0 and between > 0.0:
                last = work.stage[n - 2, i, Stage.TURNING] / work.rate[n - 2]
                work.bend[i] = (row[Stage.TURNING] / work.rate[n - 1] - last) / between
        if regime != Regime.SEPARATED:
            state.e[i, 0], state.e[i, 1] = row[Stage.E_X], row[Stage.E_Y]
        state.begins[i] = 0
        for k in range(15):
            work.start[i, k] = row[k]
        for k in range(6):
            work.before[i, k] = work.surface[n - 1, i, k]
    for k in range(4):
        state.q[k], state.p[k] = work.q[n - 1, k], work.p[n - 1, k]
        for j in range(n):
            lost = problem.damping[k] * work.p[j, k] ** 2
            which = Total.LOST_NORMAL if k == 0 else Total.LOST_TANGENTIAL
            state.total[which] += nodes.weight[j] * work.rate[j] * lost
        work.trend[k] = (work.a[n - 1, k] - work.a[n - 2, k]) / between if between > 0.0 else 0.0
    state.total[Total.PHASE] = work.phase[n - 1]
    state.total[Total.STEPS] += 1.0


@compiled
def pass_event(problem, i, which, state, row):
    """Move contact i beyond its guard; `row` is the contact at the event."""
    c, counts = problem.limit_slope[i], state.counts
    if which == RegimeEnd.TOUCH:
        speed = size_of(row[Stage.W_X], row[Stage.W_Y])
        state.begins[i] = 1
        counts[i, Count.MADE] += 1
        state.e[i, 0] = state.e[i, 1] = 0.0
        if speed > c * row[Stage.Z_RATE]:
            state.regime[i], state.alpha[i] = Regime.SLIP, np.arctan2(row[Stage.W_Y], row[Stage.W_X])
            counts[i, Count.SLIPS] += 1
        else:
            state.regime[i] = Regime.STICK
    elif which == RegimeEnd.OPEN or (which != RegimeEnd.PASS and row[Stage.Z] < ENDS and row[Stage.Z_RATE] <= 0.0):
        # at the very end of a contact slip and stick are one
        state.regime[i] = Regime.SEPARATED
        state.e[i, 0] = state.e[i, 1] = 0.0
        counts[i, Count.OPENED] += 1
    elif which == RegimeEnd.SLIP:
        at_once = state.begins[i] == 1  # e = 0
        along_x, along_y = (row[Stage.W_X], row[Stage.W_Y]) if at_once else (row[Stage.E_X], row[Stage.E_Y])
        state.regime[i], state.alpha[i] = Regime.SLIP, np.arctan2(along_y, along_x)
        counts[i, Count.SLIPS] += 1
    elif which == RegimeEnd.STICK:
        size, limit = size_of(row[Stage.E_X], row[Stage.E_Y]), c * row[Stage.Z]
        if size > 0.0:
            state.e[i, 0], state.e[i, 1] = limit * row[Stage.E_X] / size, limit * row[Stage.E_Y] / size
        state.regime[i] = Regime.STICK
    work_e_x, work_e_y = state.e[i, 0], state.e[i, 1]
    row[Stage.E_X], row[Stage.E_Y] = work_e_x, work_e_y
    if state.regime[i] == Regime.SLIP:
        n_x, n_y = np.cos(state.alpha[i]), np.sin(state.alpha[i])
        row[Stage.N_X], row[Stage.N_Y] = n_x, n_y
        row[Stage.LAMBDA] = n_x * row[Stage.W_X] + n_y * row[Stage.W_Y] - c * row[Stage.Z_RATE]


@compiled
def begin(problem, first, last, state, work):
    """Fill what a segment knows of its start."""
    fill_surface(problem, first, last, state.total[Total.PHASE], work.before)
    for i in range(first, last):
        row, work.bend[i] = work.start[i], 0.0
        fill_kinematics(problem, i, work.before[i], state.q, state.p, row)
        row[Stage.E_X], row[Stage.E_Y] = state.e[i, 0], state.e[i, 1]
        row[Stage.N_X], row[Stage.N_Y] = np.cos(state.alpha[i]), np.sin(state.alpha[i])
        row[Stage.LAMBDA] = (
            row[Stage.N_X] * row[Stage.W_X]
            + row[Stage.N_Y] * row[Stage.W_Y]
            - (problem.limit_slope[i] * row[Stage.Z_RATE])
        )


@compiled
def _next_length(length, at, crossing, step, falls, tries, bracket):
    """Return the length of the next trial of a segment that is to end at a guard's zero.

    `bracket`: lengths without and with a crossing, and the guard there (0: unknown). Newton's `step` serves where the
    guard `falls` at the end; after some trials the secant of the bracket, by the Illinois method, or its middle: near
    z = 0 the slope of the polynomial through lambda may err by half.
    """
    low, at_low, high, at_high = bracket
    if tries > MAX_NEWTON and high < np.inf:
        if at_low > 0.0 > at_high:
            return (low * at_high - high * at_low) / (at_high - at_low)
        return 0.5 * (low + high)
    new = at if crossing == 1 else length + step
    if not (low < new < high) or not falls:
        new = at if crossing == 1 and low < at < high else 0.5 * (low + min(high, 2.0 * length))
    return new


@compiled
def _narrowed(bracket, length, crossing, value):
    """Return the bracket of a guard's zero, narrowed by a trial, see `_next_length`."""
    low, at_low, high, at_high = bracket
    if crossing == 1:
        return low, at_low, length, 0.0
    if value < 0.0:
        return low, (0.5 * at_low if at_high < 0.0 else at_low), length, value
    return length, value, high, (0.5 * at_high if at_low > 0.0 else at_high)


@compiled
def _closeness(work):
    """Return how near an event a segment has to end, in phase."""
    if work.careful[0] == 1:
        return CLOSE
    return max(CLOSE, min(CLOSE_SHARE * work.tolerance, FAR))


@compiled
def _map_to(guard, work):
    """Return the map of a segment that ends at an event: the force has a square root where a contact opens or slips."""
    ends = guard == RegimeEnd.OPEN or guard == RegimeEnd.SLIP or work.careful[0] == 1
    return Map.END if ends else Map.LINEAR


@compiled
def _guess_accelerations(length, kind, state, work):
    """Fill the accelerations of the body at the nodes of a segment by those of the last one."""
    n = work.phase.size
    for k in range(4):
        end = work.a[n - 1, k]
        for j in range(n):
            work.a[j, k] = end + (1 - work.careful[0]) * work.trend[k] * length * work.nodes.phase[kind, j]


@compiled
def _solve_next(problem, first, last, left, state, work):
    """Solve the next segment of at most a length, up to the first event in it.

    The events of the last period tell the length of its first trial. Return (its length, the contact of the event, its
    guard, error). The length is 0 where the event lies at the start and negative where no segment is solved; the
    contact is -1 without an event.
    """
    n, begun, flies = work.phase.size, Map.LINEAR, True
    for i in range(first, last):
        if state.begins[i] == 1:
            begun = Map.BEGIN
        flies = flies and state.regime[i] == Regime.SEPARATED
    most = MAX_STEP if work.careful[0] == 1 else max(MAX_STEP, (MAX_FLIGHT if flies else MAX_PER_NODE) * n)
    length = min(max(state.total[Total.STEP], LEAST_STEP), most)
    everything = 0.0, 0.0, np.inf, 0.0
    kind, target, guard, tries, bracket = begun, -1, 0, 0, everything
    phase, kept = state.total[Total.PHASE], work.kept
    next_event = expected_event(kept, regimes_of(state, first, last), phase)
    ahead = np.inf
    if next_event >= 0 and work.careful[0] == 0:
        ahead = expected_phase(kept, next_event) - phase
    if ahead < left:
        row = 1 - kept.place[Place.PRESENT]
        at_end = kept.reach[row, next_event]
        if ahead > 1.05 * at_end > 0.0:  # the last segment has square roots removed, and is short
            length = (ahead - at_end) / max(np.ceil((ahead - at_end) / length - 0.1), 1.0)
        else:
            parts = max(np.ceil(ahead / length - 0.1), 2.0 if begun == Map.BEGIN else 1.0)
            length = ahead / parts
            if parts == 1.0:
                target, guard = kept.contact[row, next_event], kept.guard[row, next_event]
                kind, length = _map_to(guard, work), length + BEYOND * _closeness(work)
    elif length > 0.8 * left:
        length = left
    foretold, solved, solved_kind = target >= 0, 0.0, kind
    _guess_accelerations(length, kind, state, work)
    for _ in range(MAX_TRIES):
        known = kind == solved_kind and abs(length - solved) < ALIKE * length
        if not solve_segment(problem, first, last, length, kind, known, state, work):
            length, kind, target, solved = 0.4 * length, begun, -1, 0.0
            continue
        solved, solved_kind = length, kind
        i, which, at, crossing = _first_event(problem, first, last, length, kind, state, work)
        if i < 0 and foretold:
            value = _guard(problem, target, state.regime[target], guard, work.stage[n - 1, target])
            rate = guard_rate(problem, target, guard, length, kind, work)
            if not (rate < 0.0 and -NEGATIVE <= value < -LATE * length * rate):
                target = -1
        foretold = False
        if i < 0 and target < 0:
            error = segment_error(problem, first, last, state, work)
            if error <= work.tolerance or length < 1e-7:
                return length, -1, 0, error
            length = length * shorter(error, work)
            kind = begun
            continue
        if i >= 0 and which == RegimeEnd.NONE:  # a gap that closes between two nodes
            length, kind, target = at, begun, -1
            continue
        if i >= 0 and at < 1e-11 and length > 1e-8 and _rises(problem, i, which, state, work):
            # the guard rises from zero and falls again before the first node
            length, kind, target = 0.2 * length, begun, -1
            continue
        if i >= 0 and begun == Map.BEGIN and kind == Map.BEGIN and at > 1e-9:
            # both ends of a segment are singular: two segments
            length, target = 0.5 * at, -1
            continue
        if i >= 0 and (i != target or which != guard):
            target, guard, tries, bracket = i, which, 0, everything
        tries += 1
        value = _guard(problem, target, state.regime[target], guard, work.stage[n - 1, target])
        rate = guard_rate(problem, target, guard, length, kind, work)
        step = -value / rate if rate < 0.0 else 0.0
        bracket = _narrowed(bracket, length, crossing, value)
        # a contact that has touched with z < 0 would slip at once, for |e| > c z
        parted = bracket[2] - bracket[0] >= (NEGATIVE if guard == RegimeEnd.TOUCH else CLOSE)
        # an event is passed on its far side, else what it ends would begin again
        close = _closeness(work)
        near = abs(step) < close
        if work.careful[0] == 0 or guard == RegimeEnd.TOUCH:
            near = rate < 0.0 and abs(step) < (NEGATIVE if value > 0.0 else close)
        least = -max(close, ANGLE_SHARE * work.tolerance) if guard == RegimeEnd.STICK else -close
        ends = crossing != 1 and value > least and (near or abs(value) < 1e-15 or not parted)
        if guard == RegimeEnd.PASS:  # a bend of the force, not an event: near is enough
            ends = ends or (crossing != 1 and (tries > 4 or (abs(step) < BEND and work.careful[0] == 0)))
        elif not parted and abs(value) > 1e3 * CLOSE and length > 1e3 * CLOSE:
            # the guard falls between two nodes alone, in a segment that is too long for it
            length, kind, target = 0.5 * length, begun, -1
            continue
        if ends or (crossing != 1 and tries == 1 and kind == _map_to(guard, work)):
            error = segment_error(problem, first, last, state, work)
            if error > work.tolerance and length > 1e-7:
                length, kind, target = length * shorter(error, work), begun, -1
                continue
            if ends:
                kept.ended[Ended.BEHIND] = step if abs(step) < max(close, BEND) else 0.0
                kept.ended[Ended.REACH] = length * min(2.5, 0.7 * grown(error, work)) if kind == Map.END else 0.0
                return length, target, guard, error
        if i >= 0 and (at < 1e-11 or (not parted and length < 1e3 * CLOSE)):
            return 0.0, target, guard, 0.0
        new = _next_length(
            length, at, crossing, step + BEYOND * close * (1 - work.careful[0]), rate < 0.0, tries, bracket
        )
        length, kind = min(new, left), _map_to(guard, work)
    return -1.0, -1, 0, 0.0


@compiled
def advance(problem, first, last, until, state, work):
    """Move body and contacts `first` to `last` up to a phase; return True where all segments converge."""
    n, total = work.phase.size, state.total
    begin(problem, first, last, state, work)
    idle, fresh = 0, False  # events since the last segment; True behind an event
    for _ in range(MAX_SEGMENTS):
        left = until - total[Total.PHASE]
        if left <= 1e-12:
            return True
        length, target, guard, error = _solve_next(problem, first, last, left, state, work)
        if length < 0.0 or idle > MAX_IDLE * (last - first):
            if work.careful[0] == 1:
                return False
            work.careful[0], idle = 1, 0
            continue
        if length < 1e-11 and target >= 0:
            row = work.start[target]
            if (
                idle >= ALTERNATIONS
                and row[Stage.Z_RATE] < 0.0
                and row[Stage.Z] < (ANGLE_SHARE * work.tolerance) ** 0.4
            ):
                guard = RegimeEnd.OPEN  # what is left of its impulse, some z^2.5, is within what lambda is known to
            pass_event(problem, target, guard, state, row)
            idle += 1
            continue
        idle = 0
        if length > CARELESS and work.kept.period > 0.0:
            work.careful[0] = 0
        regimes = regimes_of(state, first, last)
        finish_segment(problem, first, last, state, work)
        proposed = length * max(0.3, min(2.5, grown(error, work)))
        if error == 0.0 and work.careful[0] == 0:
            proposed = MAX_FLIGHT * n
        if fresh:
            keep_step(work.kept, proposed if target < 0 else max(proposed, total[Total.STEP]))
        fresh = target >= 0
        # a segment that an event has cut says little about the next one
        total[Total.STEP] = max(proposed, 0.5 * total[Total.STEP] if target >= 0 else LEAST_STEP)
        if target >= 0:
            step = keep_event(work.kept, regimes, target, guard, total[Total.PHASE])
            total[Total.STEP] = step if step > 0.0 else total[Total.STEP]
            pass_event(problem, target, guard, state, work.start[target])
            for i in range(first, last):  # events of equal contacts
                if i != target:
                    _pass_simultaneous(problem, i, state, work)
    return False


@compiled
def _pass_simultaneous(problem, i, state, work):
    """Move contact i beyond a guard that has come to zero at the same instant."""
    row, regime = work.start[i], state.regime[i]
    if regime == Regime.SEPARATED:
        which, rising = RegimeEnd.TOUCH, row[Stage.Z_RATE] > 0.0
    elif regime == Regime.SLIP:
        which, rising = RegimeEnd.OPEN, row[Stage.Z_RATE] < 0.0
    else:
        which = RegimeEnd.SLIP
        along = row[Stage.N_X] * row[Stage.W_X] + row[Stage.N_Y] * row[Stage.W_Y]
        rising = along > problem.limit_slope[i] * row[Stage.Z_RATE]
    if rising and abs(_guard(problem, i, regime, which, row)) < _closeness(work):
        pass_event(problem, i, which, state, row)


@native("t i i f t t")
def follow(problem, first, last, until, state, work):
    """Move body and contacts up to a phase; return 1 where all segments converge."""
    return 1 if advance(problem, first, last, until, state, work) else 0


__all__ = ["Count", "PlaneProblem", "Regime", "RegimeEnd", "State", "Sum", "Total", "Work", "advance", "follow"]
