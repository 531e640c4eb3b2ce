r"""Explicit Runge-Kutta methods: their tableaux as data, one step of any of them, and integration with error control.

With the coefficients a_ij and b_j of a tableau a step d of y' = f(y) is

    k_i = f(y + d sum_{j < i} a_ij k_j),    y_new = y + d sum_j b_j k_j                                         (1)

(Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.1). A tableau is one array: row i
holds a_ij, and the last row holds b. Kernels and Python take the same functions: f is a field `rates` of a named tuple
or any object, called as `rates(means, y, out)`.
"""

from typing import NamedTuple

import numpy as np

from contact.codes import Status
from contact.jit.compiled import compiled, formula

# The classical method of order 4 (Hairer, Norsett and Wanner, table II.1.2)
CLASSICAL = np.array([[0, 0, 0, 0], [1 / 2, 0, 0, 0], [0, 1 / 2, 0, 0], [0, 0, 1, 0], [1 / 6, 1 / 3, 1 / 3, 1 / 6]])
# Dormand's and Prince's pair of orders 5 and 4 (table II.5.2), whose seventh stage is the first one of the next step.
# Differences of the weights of both orders, and those of the fourth coefficient of the continuous extension (II.6)
DORMAND_PRINCE = np.array(
    [
        [0.0] * 6,
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
ERROR = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
DENSE = np.array(
    [
        -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    ]
)  # fmt: skip
# A step whose error stays above the tolerance is shortened this many times, each time to between 0.2 and 0.9 of it. The
# error falls with the step at least in proportion, so that more rejections mean rates without bound.
MAX_REJECTED = 60


class Stages(NamedTuple):
    """Work arrays of a step of n quantities."""

    rates: np.ndarray  # (7, n): of the stages
    new: np.ndarray  # (n,): quantities of a stage, and at the end of the step


def stages(quantities: int) -> Stages:
    """Return the work arrays of a step."""
    return Stages(np.zeros((7, quantities)), np.zeros(quantities))


@formula
def runge_kutta_step(tableau, means, time, y, d, work):
    """Fill `work.new` with y after a step d, and the rates of the stages, of which the first is given; eq. (1)."""
    new, count = work.new, tableau.shape[1]
    for i in range(1, count + 1):
        share = 0.0
        for j in range(i):
            share += tableau[i, j]
        for m in range(y.size):
            new[m] = y[m]
            for j in range(i):
                new[m] += d * tableau[i, j] * work.rates[j, m]
        if i < count:
            means.rates(means, time + d * share, new, work.rates[i])


@formula
def integrate(means, span, tolerance, time, taken, y, d, work):
    """Integrate y to the end of a span by Dormand's and Prince's pair; return the `Status`.

    Parameters
    ----------
    means : object
        Has the functions ``rates(means, time, y, out)``, which fills f and returns a `Status`, and
        ``sampled(means, number)``, which is called when `span.record[number]` has been filled.
    span : object
        Has the end `stop`, the (k,) instants `at`, increasing, and the `record`, whose first columns are the quantities
        at these instants.
    tolerance : float
        Of every quantity, in one step.
    time : float
        Start.
    taken : int
        Number of instants up to the start, which have their record.
    y : (n,) array
        Quantities at the start, overwritten with those at the end.
    d : float
        First step to try.
    work : Stages
        The first row of its rates holds f at the start.
    """
    rates, new, at, record, stop = work.rates, work.new, span.at, span.record, span.stop
    rejected = 0
    while time < stop:
        d = min(d, stop - time)
        if stop - time - d < 1e-9 * stop:
            d = stop - time
        runge_kutta_step(DORMAND_PRINCE, means, time, y, d, work)
        why, error = means.rates(means, time + d, new, rates[6]), 0.0
        for m in range(y.size):
            difference = 0.0
            for i in range(7):
                difference += d * ERROR[i] * rates[i, m]
            share = abs(difference) / tolerance
            if not share <= error:  # one that is not finite too
                error = share
        if why != Status.DONE:
            return why
        if not np.isfinite(error) or (error > 1.0 and rejected == MAX_REJECTED):
            return Status.UNSETTLED
        if error > 1.0:
            d *= max(0.2, 0.9 * error**-0.2)
            rejected += 1
            continue
        rejected = 0
        while taken < at.size and at[taken] <= time + d * (1.0 + 1e-12):
            for m in range(y.size):
                record[taken, m] = _between(y[m], new[m], d, rates[:, m], (at[taken] - time) / d)
            means.sampled(means, taken)
            taken += 1
        time += d
        for m in range(y.size):
            y[m], rates[0, m] = new[m], rates[6, m]
        d *= min(5.0, 0.9 * max(error, 1e-10) ** -0.2)
    return Status.DONE


@compiled
def _between(y, new, d, rates, s):
    """Return a quantity at the fraction s of a step d from y to y_new, by the continuous extension.

    rise, bend, fourth and last are its coefficients 2 to 5 as in CONTD5 of Hairer and Wanner's program DOPRI5.
    """
    rise = new - y
    bend = d * rates[0] - rise
    fourth, last = rise - d * rates[6] - bend, 0.0
    for i in range(7):
        last += d * DENSE[i] * rates[i]
    return y + s * (rise + (1.0 - s) * (bend + s * (fourth + (1.0 - s) * last)))
