r"""Error estimates of the answers, one function for each way of computing.

An answer is computed twice, at two resolutions or by two methods, and the functions here turn the difference into the
error that is stated with it (`choice.Answer`). Velocity errors are compared with the *reference speed*
max(|v|, omega |u_x|/10). The true error is at most twice the stated one in 98 of 100 cases, as
`tests/contact/test_calibration.py` and `tests/contact/test_burst_errors.py` measure.

Some errors are completed elsewhere: the effect of an undamped bounce, of a motion that is not reached from rest and of
a slider that is just held is added in `answers.steady` and `averaged.sweep_kernel`, that of an irregular long run in
`periodic.settling`, that of a burst compared with its exact solution in `answers.stepped_burst`, the search of a load
line in `answers.load_and_stall`. The parts of an averaged burst are added up in `averaged.burst`; that of a
slider which tilts or loads the wave is the residual of its equations and `richardson` of the number of harmonics
(`averaged.coupled_motion`).

The functions stand in the order burst, step, steady state (shooting, long run, averaged), threshold and release, stall,
errors of the wave. `ratio` is f_n/f, the contact resonance over the frequency of the wave.
"""

import math

import numpy as np

from contact.jit.compiled import formula
from contact.orbit import as_orbits
from contact.passing_wave import PassingWave, Surface

# Event-driven motion. TRUNCATION: smallest error that is stated, over the reference speed and the truncation error
# allowed in a segment, because two orders may agree by chance. DRIFT: rounding per cycle, over the reference speed.
# SCATTER: rounding over the root of the number of segments, in units of `Problem.speed`; segments add and subtract
# lengths of order one, so that a wave with little u_x leaves few digits. Against runs of 20 nodes the error in this
# measure was up to 4e-16 in 140 of 150 draws of `tests.motors.aimed` with the tolerance 1e-10, and within twice the
# stated one in all.
TRUNCATION, DRIFT, SCATTER = 3e-6, 1e-15, 4e-16
# Periodic motion. EPSILON: rounding of one segment in `shooting_rounding`. AGREEMENT: smallest error stated for a
# cycle's impulse, over that of the preload in a radian, as two orders may agree by chance. In 400 draws of
# `tests/benchmarks/shooting_error.py` none is off by twice what is stated; with half of it one, with a fiftieth nine.
EPSILON, AGREEMENT = 2.2e-16, 1e-10
# Order of convergence of fixed time steps that is assumed. Spheres converge with order 1.5 to 2, punches and contact
# dampers with order 1. Both may converge more slowly between two neighbouring step sizes.
STEPPED_ORDER = 1
# Every estimate is increased by this fraction of the error expected for the step, because two runs may agree by chance.
FLOOR = 0.01
# Orbits along a track that are held for a cycle in the event-driven motion and change at its end. Error of the velocity
# over the reference speed and the largest change; it was 0.14 in `tests/contact/test_track.py` for two wavelengths.
HELD_ORBITS = 0.5
# Factors of a burst's error in fixed steps, of which only the first cycles were checked. CALIBRATION: on the ratio of
# true and stated error there; LEAST_SHARE: the least of that product, 1 for the coarsest two step sizes (level 1 of
# `stepped_burst.STEPS`), which agree by chance most easily; BEYOND: on the estimate of the whole burst; UNCHECKED: on
# an estimate without check. `tests/benchmarks/stepped_error.py` measured them.
CALIBRATION, LEAST_SHARE, BEYOND, UNCHECKED = 3.0, 0.5, 1.5, 5.0
# The same for an averaged burst, and AVERAGED_FLOOR: smallest error of its step size and quadrature over the tolerance
# that they were chosen for, because two runs may agree by chance. `tests/benchmarks/averaging_error.py` measured them.
AVERAGED_CALIBRATION, AVERAGED_BEYOND, AVERAGED_FLOOR = 5.0, 0.8, 0.003
# Second-order averaging of a burst: the error that second order leaves. LEFT_OF_FIRST: over its difference from first
# order; LEFT_OF_RATIO: over (f_n/f)^2 times the reference speed; both are added. With these values and the three above
# no averaged burst of `tests/benchmarks/averaging_error.py` is more than twice its stated error off: 16 of its
# own difficult ones (at most 0.4 times), 47 aimed ones and 243 of the calibration (at most 0.96 times, in the median
# 0.11 times).
LEFT_OF_FIRST, LEFT_OF_RATIO = 0.12, 0.05
# Larger over smaller amplitude up to which the smaller one's relative error grows; least relative change of a wave that
# is tried, because a difference over a smaller one would measure rounding
MAX_AXIS_RATIO, MIN_WAVE_STEP = 1e3, 1e-4
# Travel. FIXED_STEPS: smallest error of a travel in fixed steps, over the travel. The difference of 64 and 96 steps per
# cycle misses slips and contacts that are shorter than a step: of 140 draws of `tests/benchmarks/envelope_error.py` 5
# are beyond twice the stated error without this one (up to 6 times), 1 (2.2 times) with it, 1 (2.6 times) with half of
# it and none with twice. LEAST_TRAVEL_ERROR: over the travel; two levels may agree by chance, and the finer one has
# errors up to 3e-11 (90 draws of `tests.motors.aimed`). MEMORY_SHIFT: shift of the final position by partial slip
# of hysteretic contacts over the amplitude of the ring; it was 0.07 to 0.37 in `tests/contact/test_stall_and_steps.py`
# and in five similar scenes. CUT: largest change of the final position over the amplitude at which a ring-down is cut;
# it was up to 4.2, in the median 0.25, in 40 random motors of one to three contacts that were cut at amplitudes of 1e-5
# to 3e-3.
FIXED_STEPS, LEAST_TRAVEL_ERROR, MEMORY_SHIFT, CUT = 1e-5, 2e-11, 0.5, 5.0
# number of batch means of a long run, and Student's factor for 95 % with one degree of freedom less
BATCHES, STUDENT = 16, 2.13
# First-order averaging: relative errors over (f_n/f)^2. The true values were, of the velocity, 0.1 to 1.9 at amplitudes
# from 0.75 to 20 nm and 12 just above the threshold (`tests/benchmarks/contact_ways.py`); of a threshold 0.5 to 1.4
# (`tests/contact/test_threshold_answers.py`), up to 1.9 in draws with unequal balls or the hysteretic law; of the load
# at the stall 1.8 (`tests/contact/test_thrust.py`).
OF_VELOCITY, OF_THRESHOLD, OF_STALL = 3.0, 2.0, 3.0
# The same of waves with several frequencies, whose slowest beat moves the slider: over (f_n/beat)^2. The true values of
# the velocity were 0.002 to 0.19 in 76 draws of two and three frequencies at beats of 25 to 200 kHz. Of 31 others, by
# `tests/benchmarks/beat_error.py` when it stood, the largest was 0.33 and none beyond twice the stated error.
OF_BEAT = 0.2
# A slider that averaging says is held must not move on a larger wave either. LARGER_WAVE: relative increase of the
# wave over (f_n/f)^2; MAX_LARGER_WAVE: its largest value.
LARGER_WAVE, MAX_LARGER_WAVE = 12.0, 0.5
# Second-order averaging of a steady state. CORRECTION_ERROR: smallest error over the difference from first order.
# LEAST_ERROR: smallest error over the velocity, because the periodic motion of the full equations, with which it is
# compared, is itself known to some 1e-10 (`tests/contact/test_calibration.py`).
CORRECTION_ERROR, LEAST_ERROR = 1e-4, 1e-9
# Error of the velocity by the harmonics left out, over the largest of the last three kept ones and times
# (harmonics + 1)^2. With 2, the true error of none of 263 random motors up to f_n/f = 0.3 is more than twice the stated
# one; with 1 that of one motor is, and with 1 and the last tangential harmonic alone that of five.
TAIL_SHARE = 2.0
# Error of the finer of two quadratures over their difference. The true ratio is 1/70 with 16 and 24 nodes per smooth
# piece of a cycle and an elliptic orbit of general phase.
RULE_ERROR = 0.1
# Smallest relative error of a threshold or release between two bounds, which may agree by chance; bisection of the full
# motion at f_n/f = 0.2 differs by 5e-7.
LEAST_DISTANCE = 1e-6


def reference_speed(velocity: float, orbits: Surface) -> float:
    """Return the reference speed max(|v|, omega |u_x|/10) in m/s, with the largest |u_x| of the orbits or the waves."""
    surface = orbits if isinstance(orbits, PassingWave) else as_orbits(orbits)
    return speed_scale(velocity, surface.peak_speed)


def speed_scale(velocity: float, surface_speed: float) -> float:
    """Return the `reference_speed` where the peak speed of the surface along x, omega |u_x| in m/s, is known."""
    return max(abs(velocity), surface_speed / 10.0)


def relative_to_reference(difference: float, velocity: float, orbits: Surface) -> float:
    """Return a velocity difference over the reference speed, or 1 for a nonzero difference if that speed is zero."""
    reference = reference_speed(velocity, orbits) or abs(difference)
    return float(abs(difference) / reference) if reference > 0.0 else 0.0


def richardson(difference: float, refinement: float, order: int) -> float:
    """Return the error of the finer of two runs, by Richardson's extrapolation of their difference.

    `refinement` is the ratio of their step sizes or numbers of harmonics, `order` the order of convergence.
    """
    return difference / (refinement**order - 1.0)


def event_driven_error(
    difference: float, *, truncation: float, reference: float, cycles: int, segments: float, moves: bool
) -> float:
    """Return the error of the velocity of an event-driven burst.

    `difference` is that of two collocation orders, `truncation` the truncation error allowed in a segment of the finer
    one, `segments` the number of segments per cycle. If the slider never `moves`, its velocity is not a sum over the
    segments and has no rounding error.
    """
    scatter = SCATTER * math.sqrt(cycles * segments) if moves else 0.0
    return max(difference, TRUNCATION * truncation * reference) + DRIFT * cycles * reference + scatter


def stepped_error(difference: float, fine: int, coarse: int, expected: float = 0.0) -> float:
    """Return the error of the finer of two runs with fixed time steps; `fine`, `coarse`: steps per cycle.

    The difference may vanish by chance, since events fall anywhere in a step: pass the largest of many. `expected` is
    the smallest error for which the finer number of steps was seen to be enough (`answers.stepped_burst.STEPS`, times
    the reference speed).
    """
    return richardson(difference, fine / coarse, STEPPED_ORDER) + FLOOR * expected


def held_orbits_error(change: float, reference: float) -> float:
    """Return the error by orbits that are held for a cycle, from their largest relative `change` between two cycles."""
    return HELD_ORBITS * change * reference


def calibrated_error(
    estimate: float, true: float | None, stated: float, calibration: float = CALIBRATION, beyond: float = BEYOND,
    least: float = 1.0,
) -> float:  # fmt: skip
    """Return the error of a burst whose first cycles have also been computed by the event-driven method.

    `estimate` is that of the whole burst, `stated` that of the first cycles and `true` their largest deviation from the
    event-driven motion, None if this is not known. `estimate` is scaled by `calibration` times their ratio, but by
    `least` or more, and by `beyond`.
    """
    if true is None:
        return UNCHECKED * estimate
    return max(beyond * estimate * max(least, calibration * true / (stated + 1e-300)), true)


def averaged_burst_error(estimate: float, true: float | None, stated: float) -> float:
    """Return the error of an averaged burst; the arguments as for `calibrated_error`."""
    return calibrated_error(estimate, true, stated, AVERAGED_CALIBRATION, AVERAGED_BEYOND)


def averaged_steps_error(difference, expected: float):
    """Return the error of an averaged burst by its steps and quadrature, from the difference of a run at half of them.

    The steps of the bounce are those of a midpoint rule. `expected` is the error that they were chosen for.
    """
    return richardson(difference, 2.0, 2) + AVERAGED_FLOOR * expected


def second_order_burst_error(difference: float, ratio: float, reference: float) -> float:
    """Return the error of second-order averaging in v(t); `difference` is that of first and second order."""
    return LEFT_OF_FIRST * difference + LEFT_OF_RATIO * ratio**2 * reference


def travel_error(difference: float, steps: list[tuple[int, int]], *, scale: float, ring: float, cut: float) -> float:
    """Return the error in m of the travel of a burst and of the motion after it.

    `difference` is the largest one of two levels, of the final positions and on the way in fixed steps.
    `steps`: fixed steps per cycle of the finer and the coarser level, for each part of the motion that uses them; the
    other parts are event-driven. `scale`: largest of the travels and of the slip limit at rest. `ring`: amplitude of
    the remaining ring of hysteretic contacts. `cut`: amplitude of the wave at which its ring-down is cut. All but the
    steps in m.
    """
    levels = max((stepped_error(difference, *pair) + FIXED_STEPS * scale for pair in steps), default=difference)
    return levels + LEAST_TRAVEL_ERROR * scale + MEMORY_SHIFT * ring + CUT * cut


def two_orders_error(difference: float, unseen: float = 0.0) -> float:
    """Return the error of an event-driven motion from two collocation orders and what their difference does not show.

    The motion has spectral accuracy, so that the difference is the error of the lower order.
    """
    return difference + unseen


def shooting_rounding(amplified: np.ndarray, sizes: np.ndarray, segments: int) -> float:
    """Return the rounding error of the velocity of a periodic motion.

    The rounding errors of the segments add up like a random walk, and the cycles amplify the sum by 1/(1 - multiplier):
    `amplified` is the row of the velocity in the inverse of the cycle map's Jacobian less the identity. `sizes` are
    those of the numbers whose rounding changes each quantity of the state in a segment.
    """
    return EPSILON * math.sqrt(max(1, segments)) * float(np.abs(amplified) @ sizes)


def shooting_agreement(normal: float, along: float) -> float:
    """Return the smallest error of the velocity of a periodic motion that is stated for two orders that agree.

    `normal`, `along`: impulses of preload and full friction in a radian times their amplification, as above.
    """
    return AGREEMENT * (abs(normal) + abs(along))


def two_starts_error(first, second) -> float:
    """Return the error of the mean velocity from two `settling.LongRun` that started at almost the same state."""
    return max(first.error, second.error, abs(first.speed - second.speed))


def batch_mean_error(means: np.ndarray, settled: float) -> tuple[float, float, float]:
    """Return (error, 95 % spread, drift) of the mean of `BATCHES` batch means of a velocity.

    The drift is the change from the first to the second half of the batches. Of the change that remains it shows only
    the share `settled`.
    """
    spread = STUDENT * float(np.std(means, ddof=1)) / math.sqrt(BATCHES)
    half = BATCHES // 2
    drift = abs(float(np.mean(means[half:]) - np.mean(means[:half])))
    return (spread + drift) / settled if settled > 0.0 else math.inf, spread, drift


def first_order_error(ratio: float) -> float:
    """Return the relative error of a velocity by first-order averaging."""
    return OF_VELOCITY * ratio**2


def beat_error(ratio: float) -> float:
    """Return the relative error of a velocity averaged over a beat; `ratio`: contact resonance over the beat."""
    return OF_BEAT * ratio**2


@formula
def larger_wave(ratio):
    """Return the factor on the wave at which a slider that averaging says is held must not move.

    Its velocity on the larger wave is the error of the velocity zero, because averaging may misjudge the threshold.
    """
    return 1.0 + min(LARGER_WAVE * ratio**2, MAX_LARGER_WAVE)


@formula
def second_order_error(tail, residual, quadrature, v, first_order):
    """Return the error of a velocity v by second-order averaging, in the unit of v.

    It is the largest of the errors by harmonics left out (`tail`), by the residual and by `quadrature`, of a share of
    the second-order correction, and of rounding.
    """
    error = max(tail, residual, quadrature, LEAST_ERROR * abs(v))
    return max(error, CORRECTION_ERROR * abs(v - first_order))


@formula
def tail_error(largest, harmonics):
    """Return the error of the velocity by the harmonics left out, from the largest of the last three that are kept.

    The forces' harmonics fall as n^-5/2 (spheres) or n^-2 (punches, a contact's damper) and the fast motion as n^-2
    times that. The harmonics left out act on the mean through one more such factor. One harmonic may vanish by chance.
    """
    return TAIL_SHARE * largest / (harmonics + 1.0) ** 2


@formula
def quadrature_error(difference):
    """Return the error of the velocity by the finer of two quadratures, from their difference."""
    return RULE_ERROR * abs(difference)


def averaged_threshold_error(ratio, accuracy: float):
    """Return the relative error of an averaged threshold or release that was searched to an accuracy."""
    return np.minimum(OF_THRESHOLD * ratio**2, 1.0) + accuracy


def bounds_error(lower: float, upper: float) -> float:
    """Return the error of the mean of a lower and an upper bound of a threshold or release."""
    return abs(lower - upper) + LEAST_DISTANCE * lower


@formula
def averaged_stall_error(ratio):
    """Return the relative error of the averaged load at which the motor stalls."""
    return min(OF_STALL * ratio**2, 1.0)


def search_error(change: float, low: float, high: float) -> float:
    """Return the error of a root searched in a bracket; `change` is that of the last two estimates."""
    return min(change, 0.5 * (high - low))


@formula
def axis_ratio(normal, tangential):
    """Return the larger of two amplitudes over the smaller, at most `MAX_AXIS_RATIO`; 1 if the smaller is zero.

    An error of the wave is relative to the larger amplitude, so that the relative error of the smaller one is this
    factor larger.
    """
    small, large = min(normal, tangential), max(normal, tangential)
    return min(large / small, MAX_AXIS_RATIO) if small > 0.0 else 1.0


@formula
def changed_waves_error(larger, smaller, other_ratio, other_phase):
    """Return the change of a velocity by a change of the wave, from the changes by four single changes of this size.

    They are those by both amplitudes larger, both smaller, another ratio u_x/u_z and another phase between them.
    """
    return np.sqrt(max(larger, smaller) ** 2 + (other_ratio**2 + other_phase**2))
