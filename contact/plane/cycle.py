r"""Means of the forces of contacts in the plane over one period, under a slider of given height and velocity.

A contact that opens in the period starts separated and needs one period. One that never opens carries its deformation
from period to period: the stop operator is a contraction, so that repetition converges (3 to 24 periods in most cases);
Aitken's extrapolation helps where little slips in each. A contact that never slips keeps its deformation.
"""

from enum import IntEnum

import numpy as np

from contact.codes import Regime
from contact.jit.compiled import compiled, native
from contact.plane.disc_contacts import Count, Sum, Total, advance
from contact.plane.plane_equations import Body, Surface, fill_surface

MAX_PERIODS = 400  # of a contact that never opens
CLOSE = 1e-11  # change of its deformation in a period, over c z, at which it repeats
NOISE = 1e-7  # change below which it repeats if it no longer falls: events are located to rounding only


class Extra(IntEnum):
    """Columns behind the sums: how the means were reached."""

    MADE = len(Sum)  # contacts made in the period
    SLIPS = len(Sum) + 1  # slips begun
    PERIODS = len(Sum) + 2
    STUCK = len(Sum) + 3  # 1 where the contact never slips nor opens
    CHANGE = len(Sum) + 4  # of the deformation in the last period, over c z


COLUMNS = len(Sum) + len(Extra)


@compiled
def _one_period(problem, i, height, velocity, start, period, state, work):
    """Follow contact i for one period from its present regime; return True where it converges."""
    for k in range(4):
        state.q[k] = state.p[k] = 0.0
    state.q[Body.HEIGHT], state.p[Body.X], state.p[Body.Y] = height, velocity[0], velocity[1]
    for k in range(state.sums.shape[1]):
        state.sums[i, k] = 0.0
    for k in range(state.counts.shape[1]):
        state.counts[i, k] = 0
    state.total[Total.PHASE] = start
    return advance(problem, i, i + 1, start + period, state, work)


@native(
    "t f1 f2 f1 f t t f2 f2",
    {
        "problem.x": "n", "problem.limit_slope": "n", "problem.cos": "w n 3", "problem.sin": "w n 3", "height": "n",
        "velocity": "n 2", "start": "n", "state.e": "n 2", "state.regime": "n", "work.start": "n 15",
        "deformation": "n 2", "out": "n 16",
    },
)  # fmt: skip
def cycle_means(problem, height, velocity, start, period, state, work, deformation, out):
    """Fill the means `Sum` and `Extra` of each contact; return 1 where all of them repeat, else 0.

    `height`: z_s for each contact; `start`: the phase of its least approach; `deformation`: a guess of e there, which
    the found one replaces.
    """
    fine = 1
    for i in range(height.size):
        fill_surface(problem, i, i + 1, start[i], work.before)
        z, c = problem.height[i] + work.before[i, Surface.Z] - height[i], problem.limit_slope[i]
        state.begins[i] = 0
        opens = z <= 0.0
        state.regime[i] = Regime.SEPARATED if opens else Regime.STICK
        state.total[Total.STEP] = 0.2
        state.e[i, 0] = state.e[i, 1] = 0.0
        limit, periods, change, lost = c * max(z, 0.0), 0, 0.0, False
        if not opens:
            size = np.hypot(deformation[i, 0], deformation[i, 1])
            factor = 1.0 if size <= limit else limit / size
            state.e[i, 0], state.e[i, 1] = factor * deformation[i, 0], factor * deformation[i, 1]
        old_x = old_y = 0.0  # the change of the period before
        while periods < MAX_PERIODS:
            before_x, before_y = state.e[i, 0], state.e[i, 1]
            if not _one_period(problem, i, height[i], velocity[i], start[i], period, state, work):
                lost = True
                break
            periods += 1
            if opens:
                break
            x, y = state.e[i, 0] - before_x, state.e[i, 1] - before_y
            last, change = change, np.hypot(x, y) / (limit + 1e-300)
            if change < CLOSE or (change < NOISE and periods > 1 and change >= last):
                break
            if periods % 4 == 0 and change > NOISE:
                # Aitken: the changes shrink by one factor per period; without a slip they do not shrink
                d_x, d_y = x - old_x, y - old_y
                share = -(x * d_x + y * d_y) / (d_x * d_x + d_y * d_y + 1e-300)
                if 0.0 < share < 1e3 and state.counts[i, Count.SLIPS] > 0:
                    state.e[i, 0] += share * x
                    state.e[i, 1] += share * y
                    size = np.hypot(state.e[i, 0], state.e[i, 1])
                    if size > limit:
                        state.e[i, 0] *= limit / size
                        state.e[i, 1] *= limit / size
                    state.regime[i] = Regime.STICK
            old_x, old_y = x, y
        deformation[i, 0], deformation[i, 1] = state.e[i, 0], state.e[i, 1]
        for k in range(state.sums.shape[1]):
            out[i, k] = state.sums[i, k] / period
        out[i, Extra.MADE], out[i, Extra.SLIPS] = state.counts[i, Count.MADE], state.counts[i, Count.SLIPS]
        out[i, Extra.PERIODS], out[i, Extra.CHANGE] = periods, change
        slipped = out[i, Sum.SLIP] > 0.0 or opens
        out[i, Extra.STUCK] = 0.0 if slipped else 1.0
        if lost or change > NOISE:
            fine = 0
    return fine
