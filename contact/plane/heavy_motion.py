r"""The motion of one contact under a heavy slider, whose height and velocity are constant within a period.

Approach z and surface speed w are then known functions of the phase, and so is the deformation in stick. What ends a
segment is a root of one of them:

    touches, opens    z = 0
    begins to slip    c z - |e| = 0
    least |e|         e.w = 0, where |e| is small: the force bends there

They are bracketed on a grid of phases, with their least or largest values between two of its points, and solved to
rounding. The end of slip, lambda = 0 in eq. (1) of `disc_contacts`, is a root of the collocation
polynomial; the segment is then solved again up to it. Regimes, forces and sums are those of `disc_contacts`.
"""

from enum import IntEnum

import numpy as np

from contact.codes import Regime
from contact.jit.compiled import compiled
from contact.plane.cycle_slopes import add_slopes, pass_slopes
from contact.plane.disc_contacts import (
    LEAST_STEP,
    MAX_TRIES,
    NEAR,
    TURN,
    RegimeEnd,
    Stage,
    Total,
    begin,
    fill_kinematics,
    finish_segment,
    guard_rate,
    pass_event,
    segment_error,
    shorter,
    solve_segment,
)
from contact.plane.plane_equations import Body, Surface, fill_surface
from contact.plane.radau import Map

GRID = TURN / 24.0  # rad of the fastest wave: of the phases at which z is bracketed
STICK_GRID = TURN / 48.0
ROOT = 1e-13  # rad: width of a root's bracket
TOUCHING = 1e-12  # |z|, scaled, that rounding and the width of its bracket leave at a root of z
BEND = 1e-7  # the same of a least |e|, which only parts two rules of quadrature
PASSED = 1e-6  # rad from the start of a segment within which a least |e| has been met
AT_LIMIT = 1e-13  # c z - |e|, scaled, up to which stick has just begun at the limit
SLIP_END = 1e-9  # rad: of the end of slip, in which the force is continuous and its rate too
# Length of the next trial over that of a segment of slip whose polynomial falls below zero where the motion up to there
# slips on.  With 3 nodes that is so at 3 % of the velocities of one ball under two waves
TOO_LONG = 0.3
MAX_SEGMENTS = 100_000
LONGEST = 1.6  # rad: of a segment


class Value(IntEnum):
    """Function of the phase whose root is sought."""

    APPROACH = 0
    APPROACH_RATE = 1
    MARGIN = 2  # c z - |e| in stick
    MARGIN_RATE = 3
    STRETCHING = 4  # e.w in stick


@compiled
def _value(problem, i, which, phase, state, work):
    """Return a function of the phase; in stick the deformation is that since `work.before`."""
    surface, row = work.spot, work.point[i]
    fill_surface(problem, i, i + 1, phase, surface)
    fill_kinematics(problem, i, surface[i], state.q, state.p, row)
    if which == Value.APPROACH:
        return row[Stage.Z]
    if which == Value.APPROACH_RATE:
        return row[Stage.Z_RATE]
    since = phase - state.total[Total.PHASE]
    x = state.e[i, 0] + (surface[i, Surface.X] - work.before[i, Surface.X]) - state.p[Body.X] * since
    y = state.e[i, 1] + (surface[i, Surface.Y] - work.before[i, Surface.Y]) - state.p[Body.Y] * since
    along = x * row[Stage.W_X] + y * row[Stage.W_Y]
    row[Stage.E_X], row[Stage.E_Y], row[Stage.LAMBDA] = x, y, along
    if which == Value.STRETCHING:
        return along
    if which == Value.MARGIN:
        return problem.limit_slope[i] * row[Stage.Z] - np.hypot(x, y)
    return _margin_rate(problem, i, row)


@compiled
def _margin_rate(problem, i, row):
    """Return the rate of c z - |e| of a contact in stick."""
    size = np.hypot(row[Stage.E_X], row[Stage.E_Y])
    speed = row[Stage.LAMBDA] / size if size > 0.0 else np.hypot(row[Stage.W_X], row[Stage.W_Y])
    return problem.limit_slope[i] * row[Stage.Z_RATE] - speed


@compiled
def _root(problem, i, which, low, at_low, high, at_high, close, state, work):
    """Return a root between two phases with values of opposite signs, by the Illinois method."""
    side = 0
    for _ in range(100):
        if high - low < close:
            break
        phase = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < phase < high:
            phase = 0.5 * (low + high)
        if phase <= low or phase >= high:
            break
        value = _value(problem, i, which, phase, state, work)
        if value == 0.0:
            return phase
        if (value > 0.0) == (at_high > 0.0):
            high, at_high = phase, value
            if side == 1:
                at_low *= 0.5
            side = 1
        else:
            low, at_low = phase, value
            if side == -1:
                at_high *= 0.5
            side = -1
    return high if abs(at_high) < abs(at_low) else low


@compiled
def _next_contact_end(problem, i, closed, until, state, work):
    """Return (phase, True) at which contact i opens, or touches where not `closed`; (until, False) without either."""
    sign = 1.0 if closed else -1.0  # sign z > 0 at first
    row = work.point[i]
    old, at_old = state.total[Total.PHASE], max(sign * work.start[i, Stage.Z], 0.0)
    rate_old = sign * work.start[i, Stage.Z_RATE]
    if rate_old > 0.0 and at_old < TOUCHING:
        at_old = 0.0  # it has just begun: this root of z is not its end
    while old < until:
        new = min(old + GRID, until)
        at_new = sign * _value(problem, i, Value.APPROACH, new, state, work)
        rate = sign * row[Stage.Z_RATE]
        if at_new > 0.0 and rate_old < 0.0 < rate:
            least = _root(problem, i, Value.APPROACH_RATE, old, sign * rate_old, new, sign * rate, BEND, state, work)
            at_least = sign * _value(problem, i, Value.APPROACH, least, state, work)
            if at_least < 0.0:
                new, at_new = least, at_least
        if at_new <= 0.0 and (at_old > 0.0 or rate_old <= 0.0 or old > state.total[Total.PHASE]):
            if at_old <= 0.0:
                return old, True
            return _root(problem, i, Value.APPROACH, old, sign * at_old, new, sign * at_new, ROOT, state, work), True
        if at_new <= 0.0:
            # it rises from zero and falls again before the first phase: look nearer
            part = new - old
            for _ in range(40):
                part *= 0.5
                at_part = sign * _value(problem, i, Value.APPROACH, old + part, state, work)
                if at_part > 0.0:
                    break
            if at_part <= 0.0:
                return old, True
            new, at_new, rate = old + part, at_part, sign * row[Stage.Z_RATE]
        old, at_old, rate_old = new, at_new, rate
    return until, False


@compiled
def _next_of_stick(problem, i, until, state, work):
    """Return (phase, guard) of what contact i meets first in stick: SLIP, PASS, or NONE at `until`."""
    row, total = work.point[i], state.total
    begun = old = total[Total.PHASE]
    at_old = _value(problem, i, Value.MARGIN, old, state, work)
    stretch_old, rate_old, step = row[Stage.LAMBDA], _margin_rate(problem, i, row), STICK_GRID
    if at_old <= 1e-15 and rate_old < -10.0 * SLIP_END:
        return old, RegimeEnd.SLIP
    while old < until:
        new = min(old + step, until)
        at_new = _value(problem, i, Value.MARGIN, new, state, work)
        stretch, rate = row[Stage.LAMBDA], _margin_rate(problem, i, row)
        if at_new <= 0.0 and at_old <= 1e-15 and old == begun:
            # it rises from zero and falls again before the first phase: look nearer
            if step < 1e-9:
                return old, RegimeEnd.SLIP
            step *= 0.25
            continue
        if at_new > 0.0 and rate_old < 0.0 < rate and (old > begun or at_old > AT_LIMIT):
            least = _root(problem, i, Value.MARGIN_RATE, old, rate_old, new, rate, BEND, state, work)
            at_least = _value(problem, i, Value.MARGIN, least, state, work)
            if at_least < 0.0:
                new, at_new, stretch = least, at_least, stretch_old
        if stretch_old < 0.0 < stretch:
            least = _root(problem, i, Value.STRETCHING, old, stretch_old, new, stretch, BEND, state, work)
            at_least = _value(problem, i, Value.MARGIN, least, state, work)
            near = np.hypot(row[Stage.E_X], row[Stage.E_Y]) < NEAR * problem.limit_slope[i] * row[Stage.Z]
            if near and at_least > 0.0 and least > begun + PASSED:
                return least, RegimeEnd.PASS
        if at_new <= 0.0:
            total[Total.MARGIN] = 0.0
            return _root(problem, i, Value.MARGIN, old, at_old, new, at_new, ROOT, state, work), RegimeEnd.SLIP
        total[Total.MARGIN] = min(total[Total.MARGIN], at_new)
        old, at_old, stretch_old, rate_old, step = new, at_new, stretch, rate, STICK_GRID
    return until, RegimeEnd.NONE


@compiled
def _stick(problem, i, until, state, work, slopes, derive):
    """Follow stick to its end, to the least |e| or to a phase; return True where its segments are solved.

    `work` is that with many nodes: what moves is known, and a stick is one piece of quadrature or two. `derive`: see
    `follow_alone`.
    """
    total = state.total
    end, guard = _next_of_stick(problem, i, until, state, work)
    for _ in range(MAX_SEGMENTS):
        left = end - total[Total.PHASE]
        if left <= ROOT:
            break
        length = left if left < LONGEST else 0.5 * left
        for _ in range(MAX_TRIES):
            if not solve_segment(problem, i, i + 1, length, Map.BOTH, False, state, work):
                return False
            error = segment_error(problem, i, i + 1, state, work)
            if error <= work.tolerance or length < 1e-7:
                break
            length *= shorter(error, work)
        if derive:
            add_slopes(problem, i, state, work, slopes)
        finish_segment(problem, i, i + 1, state, work)
    if guard == RegimeEnd.SLIP:
        if derive:
            pass_slopes(problem, i, guard, state.begins[i] == 1, work.start[i], slopes)
        pass_event(problem, i, guard, state, work.start[i])
    return True


@compiled
def _slip_until(problem, i, work):
    """Return s of 0 to 1 at which the polynomial of lambda through the nodes of a segment falls below zero; 2 if none.

    It is looked at in the nodes and between them.
    """
    nodes, n = work.nodes, work.phase.size
    for m in range(n):
        work.matrix[0, m] = 0.0
        for k in range(n):
            work.matrix[0, m] += (m + 1) * nodes.power[k, m] * work.stage[k, i, Stage.LAMBDA]
    low, node = 0.0, 0.0
    for j in range(2 * n):
        high = nodes.phase[Map.LINEAR, j // 2]
        if j % 2 == 0:
            high = 0.5 * (node + high)
        else:
            node = high
        if _polynomial(work.matrix[0], n, high) < -1e-13:
            for _ in range(16):  # the segment is solved again up to there, and corrected
                middle = 0.5 * (low + high)
                if _polynomial(work.matrix[0], n, middle) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        low = high
    return 2.0


@compiled
def _polynomial(coefficients, n, s):
    """Return the value of a polynomial with n coefficients."""
    value = 0.0
    for m in range(n - 1, -1, -1):
        value = value * s + coefficients[m]
    return value


@compiled
def _mapped(kind, s):
    """Return the phase of s over the length of a segment."""
    if kind == Map.BEGIN:
        return s * s
    return s * (2.0 - s) if kind == Map.END else s


@compiled
def _shorten(i, share, kind, work):
    """Set the turning at the nodes of a segment to that of the solved one, of which it is a share."""
    nodes, n, stage, slope = work.nodes, work.phase.size, work.stage, work.matrix[0]
    share = np.sqrt(share) if kind == Map.BEGIN else share
    for m in range(n):
        slope[m] = 0.0
        for k in range(n):
            slope[m] += (m + 1) * nodes.power[k, m] * stage[k, i, Stage.TURNING]
    for j in range(n):
        stage[j, i, Stage.TURNING] = share * _polynomial(slope, n, share * nodes.phase[Map.LINEAR, j])


@compiled
def _slip_segment(problem, i, left, opens, state, work, slopes, derive):
    """Solve the next segment of slip, at most `left` long, after which the contact may open.

    Return 0 where none is solved, 1 where slip goes on, 2 where it ends with the segment.
    """
    total, begins = state.total, state.begins[i] == 1
    length = min(max(total[Total.STEP], LEAST_STEP), LONGEST)
    length = left if length > 0.7 * left else length
    sticks, shifts, solved, solved_kind, whole = False, 0, 0.0, Map.LINEAR, length
    for _ in range(MAX_TRIES):
        kind = Map.BEGIN if begins else Map.LINEAR
        if length == left and opens and not sticks:
            if begins:
                length *= 0.5
            else:
                kind = Map.END
        known = solved > 0.0 and kind == solved_kind
        if known:
            _shorten(i, length / solved, kind, work)
        if not solve_segment(problem, i, i + 1, length, kind, known, state, work):
            length, sticks, solved = 0.4 * length, False, 0.0
            continue
        solved, solved_kind = length, kind
        error = segment_error(problem, i, i + 1, state, work)
        if error > work.tolerance and length > 1e-7:
            length, sticks = length * shorter(error, work), False
            continue
        if sticks:
            rate = guard_rate(problem, i, RegimeEnd.STICK, length, kind, work)
            at_end = work.stage[work.phase.size - 1, i, Stage.LAMBDA]
            if at_end > SLIP_END and (rate >= 0.0 or at_end > -rate * (left - length)):
                length, sticks, shifts, solved = TOO_LONG * whole, False, 0, 0.0
                continue
            shift = -at_end / rate if rate < 0.0 else 0.0
            if abs(shift) < SLIP_END or shifts > 5 or not -length < shift < left - length:
                break
            length, shifts = length + shift, shifts + 1
            continue
        s = _slip_until(problem, i, work)
        if s > 1.0:
            break
        whole, length, sticks = length, max(length * _mapped(kind, s), 1e-15), True
    else:
        return 0
    if derive:
        add_slopes(problem, i, state, work, slopes)
    finish_segment(problem, i, i + 1, state, work)
    if not sticks:
        grow = 0.9 * (work.tolerance / (error + 1e-300)) ** (1.0 / work.phase.size)
        total[Total.STEP] = length * max(0.3, min(2.5, grow))
    return 2 if sticks else 1


@compiled
def _slip(problem, i, until, state, work, slopes, derive):
    """Follow slip to its end, to the opening of the contact or to a phase; return True where it is solved."""
    end, opens = _next_contact_end(problem, i, True, until, state, work)
    for _ in range(MAX_SEGMENTS):
        left = end - state.total[Total.PHASE]
        if left <= ROOT:
            if opens:
                pass_event(problem, i, RegimeEnd.OPEN, state, work.start[i])
            return True
        done = _slip_segment(problem, i, left, opens, state, work, slopes, derive)
        if done == 2:
            if derive:
                pass_slopes(problem, i, RegimeEnd.STICK, False, work.start[i], slopes)
            pass_event(problem, i, RegimeEnd.STICK, state, work.start[i])
        if done != 1:
            return done == 2
    return False


@compiled
def _fly(problem, i, until, state, work, slopes, derive):
    """Move a contact that is open to its next touch, or to a phase."""
    end, touches = _next_contact_end(problem, i, False, until, state, work)
    for k in range(4):
        state.q[k] += state.p[k] * (end - state.total[Total.PHASE])
    state.total[Total.PHASE] = end
    begin(problem, i, i + 1, state, work)
    if touches:
        if derive:
            pass_slopes(problem, i, RegimeEnd.TOUCH, True, work.start[i], slopes)
        pass_event(problem, i, RegimeEnd.TOUCH, state, work.start[i])


@compiled
def follow_alone(problem, i, until, state, work, wide, slopes, derive):
    """Move contact i of a heavy slider up to a phase; return True where all segments converge.

    `wide`: the same work arrays with more nodes, for stick. `derive`: True if `slopes` are moved too.
    """
    begin(problem, i, i + 1, state, work)
    for _ in range(MAX_SEGMENTS):
        if until - state.total[Total.PHASE] <= ROOT:
            return True
        if state.regime[i] == Regime.SEPARATED:
            _fly(problem, i, until, state, work, slopes, derive)
        elif state.regime[i] == Regime.STICK:
            if not _stick(problem, i, until, state, wide, slopes, derive):
                return False
        elif not _slip(problem, i, until, state, work, slopes, derive):
            return False
    return False
