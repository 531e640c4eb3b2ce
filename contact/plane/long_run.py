r"""The mean motion of a light slider in the plane that does not repeat with the waves: a long run from rest.

A slider whose contacts resonate near or above the frequency of the waves may hop with a period of several cycles, or
irregularly. As along x (`contact.periodic.settling`) every event is then followed from rest until velocity and yaw rate
have settled, and as long again: the answer is the mean of that second part. Its error is that of batch means, and the
difference from a second run. All rates are 1e-6 at the start of the one and -1e-6 at that of the other, for a motion
along a line may be unstable to either side: one ball whose contact resonates at 1.2 of the frequency sways across its
wave with twice the period.

The waves under the contacts are those of the start, and so is the yaw.
"""

import math
from typing import NamedTuple

import numpy as np

from contact.codes import Regime
from contact.error_estimate import BATCHES, batch_mean_error
from contact.exceptions import ConvergenceError
from contact.plane.disc_contacts import TURN, Total
from contact.plane.from_rest import SAME, followed_in_place, speed_of
from contact.plane.full_motion import FullMotion, followed_from_rest
from contact.plane.plane_equations import PlaneProblem
from contact.plane.plane_waves import SurfaceWaves
from contact.slider import Slider

# Nodes and tolerance of a segment. Where the motion is regular its velocity then errs by up to 1.2e-8 of the reference
# speed in six motions of one ball that repeat after 2, 4 or 6 cycles; with a tolerance of 3e-4 by 1.2e-6
HOW = (6, 1e-6)
OF_SEGMENTS = 1e-7  # of the reference speed: that error
LEAST_CYCLES, MAX_CYCLES = 480, 10_000  # before the mean is taken
REGULAR, LONGER = 1e-4, 8  # range of the batches, over that speed, beyond which a run goes on for so much longer
# Trials of segments after which a run ends with the batches at hand, a second or two
BUDGET = 200_000
DECAYED = 8.0  # relaxation times after which a velocity has settled
APART = 1e-6  # rates at the starts of the two runs, scaled
STEP = 8  # cycles, in whole periods of the waves, after which the slider is turned back to its yaw


class LongRun(NamedTuple):
    """Means over the last part of a long motion."""

    rates: np.ndarray  # (3,): v_x, v_y in m/s and yaw rate in rad/s
    error: np.ndarray  # (3,)
    sums: np.ndarray  # (n, len(Sum)): means of forces and powers, scaled
    counts: np.ndarray  # (n, len(Count)): events
    lost: float  # mean power in the dampers of the body, scaled
    sticks: bool  # True if every contact sticks
    cycles: int  # of the fastest wave, in the mean
    passed: int  # before


def long_run(slider: Slider, waves: SurfaceWaves, period: float, reference: float, arm: float) -> LongRun:
    """Return the mean of the motion from rest.

    Parameters
    ----------
    period : float
        After which the waves repeat, s.
    reference : float
        Speed to which relative errors refer, m/s.
    arm : float
        By which a yaw rate becomes a speed, m.

    Raises
    ------
    ConvergenceError
        "out of reach" where the slider takes too long to settle, "not settled" where it drifts on, "not converged".
    """

    def followed(apart):
        def follow(motion):
            motion.state.p[motion.units.problem.inverse > 0.0] += apart
            return _followed(motion, period, reference, arm)

        return followed_from_rest(follow, slider, waves, HOW, rise=0.0, stop=math.inf)

    first, second = followed(APART), followed(-APART)
    if first.sticks and second.sticks:
        return first
    error = np.maximum(np.maximum(first.error, second.error), np.abs(first.rates - second.rates))
    return first._replace(error=error, sticks=False)


def relaxation_rate(problem: PlaneProblem) -> float:
    """Return the slowest rate per radian at which a velocity relaxes: damper, and friction over the surface's speed."""
    amplitudes = np.hypot(problem.cos, problem.sin)[..., :2]
    reach = float((problem.ratio[:, None, None] * amplitudes).sum(axis=(0, 2)).max()) + 1e-300
    by_friction = 0.3 * problem.friction * -problem.force[0] / reach
    squares = float(np.mean(problem.x**2 + problem.y**2))
    resistance = problem.damping[1:] + by_friction * np.array([1.0, 1.0, squares])
    rates = problem.inverse[1:] * resistance
    return float(rates[rates > 0.0].min())


def _followed(motion: FullMotion, period: float, reference: float, arm: float) -> LongRun:
    cycle, rate = period * motion.units.omega, relaxation_rate(motion.units.problem)
    settling = DECAYED / rate / TURN
    if settling > 4.0 * MAX_CYCLES:
        raise ConvergenceError(
            "out of reach",
            f"no stable motion repeats with the waves, and the slider takes {settling:.3g} cycles to settle, too many "
            "to follow; follow a burst",
        )
    step = math.ceil(STEP * TURN / cycle) * cycle
    cycles, passed = max(LEAST_CYCLES, min(settling, MAX_CYCLES)), 0
    while True:
        while passed * step < cycles * TURN and _trials(motion) < BUDGET:
            motion, _ = followed_in_place(motion, step)
            passed += 1
        size = math.ceil(passed / BATCHES)
        motion, found = _batches(motion, step, size)
        cycles *= LONGER
        irregular = speed_of(np.ptp(found.rates, axis=0), arm) > REGULAR * reference
        if found.sticks or not irregular or cycles > MAX_CYCLES or _trials(motion) > BUDGET:
            break
        passed += BATCHES * size
    span = BATCHES * size * step
    rates = found.rates.mean(axis=0)
    error = np.zeros(3) if found.sticks else _error(found.rates, rate * 0.5 * span, reference, arm)
    return LongRun(
        rates, error, found.sums / span, found.counts, found.lost / span, found.sticks, round(span / TURN),
        round(passed * step / TURN),
    )  # fmt: skip


class _Batches(NamedTuple):
    """A part of a motion in `BATCHES` batches."""

    rates: np.ndarray  # (BATCHES, 3): their means, m/s and rad/s
    sums: np.ndarray  # what forces and powers have summed
    counts: np.ndarray
    lost: float
    sticks: bool  # True if nothing has happened in the last batch, in which every contact sticks


def _batches(motion, step, size):
    """Return the motion after batches of so many steps, and the batches."""
    begun, rates, sticks = _sums_of(motion), np.zeros((BATCHES, 3)), False
    for k in range(BATCHES):
        events = motion.state.counts.copy()
        for _ in range(size):
            motion, way = followed_in_place(motion, step)
            rates[k] += way * (motion.units.omega / (size * step))
        sticks = bool((motion.state.counts == events).all() and (motion.state.regime == Regime.STICK).all())
    sums = (now - then for now, then in zip(_sums_of(motion), begun, strict=True))
    return motion, _Batches(rates * (not sticks), *sums, sticks)


def _trials(motion):
    return motion.state.total[Total.SOLVES]


def _sums_of(motion):
    """Return what a motion has summed since its start: of the contacts, their events, lost in the body's dampers."""
    total = motion.state.total
    lost = float(total[Total.LOST_NORMAL] + total[Total.LOST_TANGENTIAL])
    return motion.state.sums.copy(), motion.state.counts.copy(), lost


def _error(means, decay, reference, arm):
    """Return the error of the mean of batches (k, 3) of a motion that relaxes by a decay in half of them."""
    settled, units, error = -math.expm1(-decay), np.array([1.0, 1.0, arm]), np.zeros(3)
    for k in range(3):
        error[k], spread, drift = batch_mean_error(means[:, k], settled)
        if drift * units[k] > max(3.0 * spread * units[k], SAME * reference):
            raise ConvergenceError(
                "not settled", f"the slider's speed still drifts by {drift * units[k]:.2g} m/s; follow a burst"
            )
    speed = max(reference, speed_of(means.mean(axis=0), arm))
    return error + OF_SEGMENTS * speed / units * (np.abs(means).max(axis=0) > 0.0)
