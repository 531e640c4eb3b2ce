r"""Means of the forces of contacts in the plane over one period, under a slider of given height and velocity.

A contact that opens in the period starts separated and needs one period. One that never opens carries its deformation
from period to period. The stop operator is a contraction, so that repetition converges; Newton's method, by the
derivative of the deformation after a period in that before (`cycle_slopes`), finds it in 2 to 4 periods. While a
contact drifts without slip, the periods until it may slip are skipped; one that never slips keeps its deformation.
"""

from enum import IntEnum

import numpy as np

from contact.codes import Regime
from contact.jit.compiled import compiled, native
from contact.plane.cycle_slopes import begin_slopes, end_slopes, in_velocity, to_fixed_point
from contact.plane.disc_contacts import Count, Sum, Total, begin, fill_forces
from contact.plane.heavy_motion import follow_alone
from contact.plane.plane_equations import Body, Surface, fill_surface

MAX_PERIODS = 400  # of a contact that never opens
# Change of its deformation in a period, over c z and the tolerance of a segment, at which it repeats, and below which
# it repeats if it no longer falls: the steps of slip change with the deformation
CLOSE, NOISE = 1e-3, 1e-1
ONWARD = 0.5  # cosine between two ways from which on a contact goes on
GROWTH = 1.5  # of the change where it does, up to which its step has not gone too far
LONGER, SHORTER = 3.0, 0.3  # the next step over the last one, where it goes on, and where that went too far
CREPT, STAYS = 1e-3, 1e-1  # the same over the way of the slider in a period, for a contact that creeps
SLOWEST = 1e-6  # least of that way over c z: contacts that creep more slowly keep some of their deformation


class Extra(IntEnum):
    """Columns behind the sums: how the means were reached."""

    MADE = len(Sum)  # contacts made in the period
    SLIPS = len(Sum) + 1  # slips begun
    PERIODS = len(Sum) + 2
    STUCK = len(Sum) + 3  # 1 where the contact never slips nor opens
    CHANGE = len(Sum) + 4  # of the deformation in the last period, over c z
    X_BY_X = len(Sum) + 5  # derivatives of the mean Q_x and Q_y in the contact's velocity, where asked for
    X_BY_Y = len(Sum) + 6
    Y_BY_X = len(Sum) + 7
    Y_BY_Y = len(Sum) + 8


COLUMNS = len(Sum) + len(Extra)


@compiled
def _clear(i, height, velocity, start, state):
    """Set height, velocity and phase of the body, and clear the sums of contact i."""
    for k in range(4):
        state.q[k] = state.p[k] = 0.0
    state.q[Body.HEIGHT], state.p[Body.X], state.p[Body.Y] = height, velocity[0], velocity[1]
    for k in range(state.sums.shape[1]):
        state.sums[i, k] = 0.0
    for k in range(state.counts.shape[1]):
        state.counts[i, k] = 0
    state.total[Total.PHASE], state.total[Total.MARGIN], state.total[Total.STEP] = start, np.inf, 0.2


@compiled
def _one_period(problem, i, height, velocity, start, period, state, work, wide, slopes, derive):
    """Follow contact i for one period from its present regime; return True where it converges."""
    _clear(i, height, velocity, start, state)
    if derive:
        begin_slopes(state.regime[i] == Regime.SEPARATED, slopes)
    fine = follow_alone(problem, i, start + period, state, work, wide, slopes, derive)
    if derive:
        end_slopes(problem, i, state.regime[i], work.start[i], slopes)
    return fine


@native(
    "t f1 f2 f1 f t t t t i f2 f2",
    {
        "problem.x": "n", "problem.limit_slope": "n", "problem.cos": "w n 3", "problem.sin": "w n 3", "height": "n",
        "velocity": "n 2", "start": "n", "state.e": "n 2", "state.regime": "n", "work.start": "n 15",
        "deformation": "n 2", "out": "n 20",
    },
)  # fmt: skip
def cycle_means(problem, height, velocity, start, period, state, work, wide, slopes, derive, deformation, out):
    """Fill the means `Sum` and `Extra` of each contact; return 1 where all of them repeat, else 0.

    `height`: z_s for each contact; `start`: the phase of its least approach; `deformation`: a guess of e there, which
    the found one replaces. `wide`, `slopes`: see `heavy_motion.follow_alone`; `derive`: 1 to fill the derivatives.
    """
    fine, close, rough = 1, CLOSE * work.tolerance, NOISE * work.tolerance
    for i in range(height.size):
        fill_surface(problem, i, i + 1, start[i], work.before)
        z, c = problem.height[i] + work.before[i, Surface.Z] - height[i], problem.limit_slope[i]
        opens, limit, periods, change = z <= 0.0, c * max(z, 0.0), 0, 0.0
        state.begins[i] = 0
        state.e[i, 0], state.e[i, 1] = (0.0, 0.0) if opens else (deformation[i, 0], deformation[i, 1])
        drift = np.hypot(velocity[i, 0], velocity[i, 1]) * period / (limit + 1e-300)
        enough, noise = close, rough
        if drift > 0.0:
            enough, noise = min(close, CREPT * max(drift, SLOWEST)), min(rough, STAYS * max(drift, SLOWEST))
        last_e, last_way, reach, moved = (0.0, 0.0), (0.0, 0.0), np.inf, 0.0
        while periods < MAX_PERIODS:
            _cut(state.e[i], limit)
            e = state.e[i, 0], state.e[i, 1]
            state.regime[i] = Regime.SEPARATED if opens else Regime.STICK
            if not _one_period(
                problem,
                i,
                height[i],
                velocity[i],
                start[i],
                period,
                state,
                work,
                wide,
                slopes,
                derive == 1 or not opens,
            ):
                fine, periods = 0, MAX_PERIODS
                break
            periods += 1
            if opens:
                break
            way, last = (state.e[i, 0] - e[0], state.e[i, 1] - e[1]), change
            change = np.hypot(way[0], way[1]) / (limit + 1e-300)
            along = way[0] * last_way[0] + way[1] * last_way[1]
            goes_on = along > ONWARD * change * last * limit * limit
            if change < enough or (change < noise and periods > 1 and change >= last and not goes_on):
                break
            if state.counts[i, Count.SLIPS] == 0:
                skipped = max(np.floor(state.total[Total.MARGIN] / np.hypot(way[0], way[1])) - 1.0, 0.0)
                state.e[i, 0] += skipped * way[0]
                state.e[i, 1] += skipped * way[1]
                moved = 0.0
            elif moved > 0.0 and change >= (GROWTH if goes_on else 1.0) * last:  # the last step went too far
                reach = moved = SHORTER * min(reach, moved)
                if along < 0.0:
                    _go_between(last_e, last_way, e, way, state.e[i])
            else:
                # along the arc that one instant of the period leaves it a contact creeps far: steps grow
                reach = max(reach, LONGER * moved) if goes_on else reach
                moved = to_fixed_point(e, way, reach, state.e[i], slopes)
            last_e, last_way = e, way
        deformation[i, 0], deformation[i, 1] = state.e[i, 0], state.e[i, 1]
        for k in range(state.sums.shape[1]):
            out[i, k] = state.sums[i, k] / period
        out[i, Extra.MADE], out[i, Extra.SLIPS] = state.counts[i, Count.MADE], state.counts[i, Count.SLIPS]
        out[i, Extra.PERIODS], out[i, Extra.CHANGE] = periods, change
        out[i, Extra.STUCK] = 0.0 if out[i, Sum.SLIP] > 0.0 or opens else 1.0
        if derive == 1:
            in_velocity(period, slopes, out[i, Extra.X_BY_X :])
        if change > noise:
            fine = 0
    return fine


@native(
    "t f1 f2 f1 f2 t t t t f2 f3 i2",
    {
        "problem.x": "n", "problem.limit_slope": "n", "problem.cos": "w n 3", "problem.sin": "w n 3", "height": "n",
        "velocity": "n 2", "start": "n", "phases": "n k", "state.e": "n 2", "state.regime": "n", "work.start": "n 15",
        "deformation": "n 2", "out": "n k 15", "regimes": "n k",
    },
)  # fmt: skip
def cycle_samples(problem, height, velocity, start, phases, state, work, wide, slopes, deformation, out, regimes):
    """Fill the contacts (`Stage`) and their regimes at phases that ascend from `start`; return 1 where all are solved.

    `deformation`: e at `start`, as `cycle_means` leaves it.
    """
    for i in range(height.size):
        fill_surface(problem, i, i + 1, start[i], work.before)
        opens = problem.height[i] + work.before[i, Surface.Z] - height[i] <= 0.0
        state.begins[i] = 0
        state.e[i, 0], state.e[i, 1] = (0.0, 0.0) if opens else (deformation[i, 0], deformation[i, 1])
        state.regime[i] = Regime.SEPARATED if opens else Regime.STICK
        _clear(i, height[i], velocity[i], start[i], state)
        for j in range(phases.shape[1]):
            if not follow_alone(problem, i, phases[i, j], state, work, wide, slopes, False):
                return 0
            begin(problem, i, i + 1, state, work)
            fill_forces(problem, i, state.regime[i], work.start[i])
            for k in range(out.shape[2]):
                out[i, j, k] = work.start[i, k]
            regimes[i, j] = state.regime[i]
    return 1


@compiled
def _cut(e, limit):
    """Cut a deformation to its limit."""
    size = np.hypot(e[0], e[1])
    if size > limit:
        e[0] *= limit / size
        e[1] *= limit / size


@compiled
def _go_between(before, way_before, e, way, new):
    """Fill the deformation between two where the way of a period, linear between them, is least; and go that way."""
    d_x, d_y = way_before[0] - way[0], way_before[1] - way[1]
    share = (way_before[0] * d_x + way_before[1] * d_y) / (d_x * d_x + d_y * d_y)
    share = min(max(share, 0.0), 1.0)
    for k in range(2):
        new[k] = (1.0 - share) * (before[k] + way_before[k]) + share * (e[k] + way[k])
