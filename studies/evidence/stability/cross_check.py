r"""An independent check of a steady velocity: the limit of runs in time that start at the answer.

The motion is computed in time from the mean height and the velocity of the answer. Fixed steps are used where they are
applicable, and the event-driven method where they are not or where they leave too large an error. Height, its rate and
velocity are what a slider may keep for up to 10^6 cycles: a heavy slider its velocity, a bouncing one its bounce, and
one with a strong contact damper its height. What is compared is therefore not the end of a run but the fixed point to
which runs tend.

In each run, a and b are the means of (z_s, z_s', v) over the second and over the last quarter, with a smooth weight
that suppresses what changes within a few cycles. Runs with an offset of each of the three give the matrix
P = (b_i - b)(a_i - a)^-1, which takes a deviation from the second to the last quarter. It is zero for what the slider
forgets before the second quarter. The limit of a run is a + (I - P)^-1 (b - a). Then the motion starts again at the
limit, until the limits agree: they are the result, and their spread is its error, together with that of the
resolutions. A right answer is a fixed point of these runs: they stay where they start, however slowly the slider
settles. From a wrong answer they lead to the right one. There is no cross-check if a deviation grows (an eigenvalue of
P reaches 1: the answer is unstable, or nothing decides it), or if the error stays large. A height that grows but does
not act on the velocity, as in free flight, is left out; what it does to the velocity is in the spread of the limits.

A slider that sticks is followed from rest, and from a hundredth of the reference speed to either side. A heavy slider
leaves a wrong answer of zero as slowly as it comes to rest, so that its velocity from rest says nothing. What decides
is whether it is slowed on both sides. If it is faster at the end than at the start, it moves, at least that fast.

The check uses no part of the steady-state solvers: no averaging, no Newton iteration and no cycle map.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import contact
from contact.answers.rest_motion import rest_problem
from contact.answers.steady import SteadyState
from contact.answers.stepped_burst import stepped_refusals
from contact.body import normal_amplitude, tangential_amplitude
from contact.codes import Recorded
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.exceptions import ConvergenceError
from contact.orbit import towards_plus
from contact.passing_wave import prescribed
from contact.problem import Problem
from contact.stepping.time_stepping import steps

# Steps per cycle and collocation nodes of the two methods. The last gives the velocity, all give its error.
STEPS, NODES = (64, 90, 128), (9, 14)
# Cycles with fixed steps; for the event-driven method the least number of cycles, and the usual and the largest number
# of segments (5 s per run)
STEPPED_CYCLES, LEAST_CYCLES, EXACT_SEGMENTS, MAX_SEGMENTS = 20_000, 64, 60_000, 200_000
# Offsets of the other starts, over the wave's amplitude, its product with the contact resonance, and the reference
# speed, and the first of the three quantities that count; in the order in which they are tried. A smaller offset where
# the larger leads to another motion; the velocity alone where a height that grows or wanders does not act on it.
TRIALS = ((1e-2, 0), (1e-4, 0), (1e-2, 2))
FORGOTTEN = 1e-3  # share of an offset below which it is forgotten in the second quarter
# Attempts to start at the mean height, and its error over the wave's amplitude that ends them
STARTS, SAME_HEIGHT = 6, 1e-6
# Largest number of starts at a limit; errors over the reference speed that end them, and that are no cross-check
RESTARTS, SETTLED, MAX_ERROR = 6, 1e-3, 1e-2
# Speeds over the reference: at which a slider that sticks starts to either side, below which it comes to rest, and the
# least change that is noticed
PUSH, STUCK, NOTICED = 1e-2, 5e-3, 1e-8


@dataclass(frozen=True, kw_only=True)
class CrossCheck:
    """A steady velocity from runs in time."""

    velocity: float  # m/s
    error: float  # estimated, m/s, from the resolutions and the remaining settling
    method: str  # "stepped" or "exact"
    cycles: int  # number of cycles of a run


def cross_check(state: SteadyState) -> CrossCheck:
    """Return the steady velocity to which runs in time from an answer extrapolate.

    Parameters
    ----------
    state : SteadyState
        Steady state of a moving or a sticking slider.

    Raises
    ------
    ConvergenceError
        If the motion cannot be computed, moves away from the answer, or does not settle.
    """
    slider, orbits = prescribed(state.slider, state.orbits)
    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    begin = np.zeros(3 + len(driven))
    begin[0], begin[2] = -state.height / problem.length, side * state.velocity / problem.speed
    reference = contact.reference_speed(state.velocity, driven) / problem.speed
    amplitude = max(normal_amplitude(problem.paths, np.arange(problem.contacts))) or abs(begin[0]) or 1.0
    climb = amplitude * slider.normal_resonance(len(driven)) / driven.frequency
    units = np.array([amplitude, climb or 1.0, reference or 1.0])

    # the event-driven method may resolve what the steps do not
    methods = ("exact",) if stepped_refusals(slider, problem, STEPS[0]) else ("stepped", "exact")
    for method in methods:
        try:
            runs = _Runs(problem, method == "stepped", _cycle_count(problem, method), units)
            velocity, error = _sticking(slider, runs, begin) if state.velocity == 0.0 else _moving(runs, begin)
        except ConvergenceError as failed:
            failure = failed
        else:
            return CrossCheck(
                velocity=float(side * velocity * problem.speed), error=float(error * problem.speed), method=method,
                cycles=runs.cycles,
            )  # fmt: skip
    raise failure


def _moving(runs, begin):
    """Return (velocity, error), scaled, of a slider that moves."""
    begin = runs.at_mean_height(begin)
    coarse, *finer = runs.resolutions
    means = runs.quarters(begin, coarse)
    secant, beside = _deviations(runs, begin, means)
    limits = [secant.limit(each) for each in (means, *beside)]
    target = limits[0]
    for _ in range(RESTARTS):
        begin = runs.offset(begin, secant.inverse @ (target - means.early))
        means = runs.quarters(begin, coarse)
        target = secant.limit(means)
        limits.append(target)
        settled = max(abs(target - each)[2] for each in limits[-4:-1])
        if settled < SETTLED:
            break
    velocities = [target[2], *(secant.limit(runs.quarters(begin, each))[2] for each in finer)]
    resolved = max(abs(velocities[-1] - each) for each in velocities[:-1])
    if not settled + resolved <= MAX_ERROR:
        raise ConvergenceError(
            "not settled",
            f"runs of {runs.cycles} cycles leave {settled + resolved:.2g} of the velocity open, {settled:.2g} of it "
            "because the slider does not settle",
        )
    return velocities[-1] * runs.units[2], (settled + resolved) * runs.units[2]


def _deviations(runs, begin, means):
    """Return the secant of the means of a run from `begin`, and the means of three runs beside it."""
    for size, first in TRIALS:
        beside = [runs.quarters(runs.offset(begin, size * each), runs.resolutions[0]) for each in np.eye(3)]
        secant = _secant(means, beside, size, first)
        if secant.growth < 1.0 and secant.effect(means, beside[:first]) < SETTLED * size:
            return secant, beside
    raise ConvergenceError(
        "not settled",
        f"a deviation from the answer is {_secant(means, beside, size, 0).growth:.6g} times as large after "
        f"{runs.cycles // 2} more cycles",
    )


def _sticking(slider, runs, begin):
    """Return (velocity, error), scaled, of a slider that sticks: a displacement within its elastic limit is allowed."""
    every = np.arange(runs.problem.contacts)
    reach = slider.limit_slope * (abs(begin[0]) + max(normal_amplitude(runs.problem.paths, every)))
    reach += max(tangential_amplitude(runs.problem.paths, every))
    late = runs.quarters(begin, runs.resolutions[-1]).late
    within_reach = 2.0 * reach / (2.0 * math.pi * (runs.cycles // 4))
    reference = runs.units[2]
    if not any(tangential_amplitude(runs.problem.paths, every)):
        return late[2] * reference, within_reach
    pushed, error = _pushed(runs, begin)
    if pushed:
        return pushed * reference, error * reference
    return late[2] * reference, min(within_reach, STUCK * reference) if error == STUCK else error * reference


def _pushed(runs, begin):
    """Return (velocity, error), over the reference speed, of a slider that starts at PUSH to either side.

    The velocity is 0 if it is slowed on both sides, and the error STUCK if it comes below that, otherwise PUSH: a heavy
    slider takes longer than a run. From rest it would leave a wrong answer as slowly.
    """
    sides, both = (-1.0, 1.0), []
    for side in sides:
        means = runs.quarters(runs.offset(begin, np.array([0.0, 0.0, PUSH * side])), runs.resolutions[0])
        both.append((side * means.early[2], side * means.late[2]))
    for side, (early, late) in zip(sides, both, strict=True):
        if late >= max(early, PUSH) + NOTICED:
            return side * late, NOTICED
    for early, late in both:
        if not (abs(late) <= STUCK or 0.0 < late <= early - NOTICED):
            raise ConvergenceError(
                "not settled",
                f"a slider that starts at {PUSH:g} of the reference speed has {late:.2g} of it after "
                f"{runs.cycles} cycles",
            )
    return 0.0, STUCK if all(abs(late) <= STUCK for _, late in both) else PUSH


class _Means(NamedTuple):
    """Means of (z_s, z_s', v) over two quarters of a run, in the units of `_Runs`."""

    early: np.ndarray  # (3,): second quarter
    late: np.ndarray  # (3,): last quarter


class _Secant(NamedTuple):
    """What is left of small deviations from a motion, from runs beside it."""

    inverse: np.ndarray  # (3, 3): offset of the start that makes a deviation in the second quarter
    change: np.ndarray  # (3, 3): P, deviation in the last quarter that follows from one in the second

    @property
    def growth(self):
        return float(np.max(np.abs(np.linalg.eigvals(self.change))))

    def limit(self, means):
        """Return the fixed point to which a run tends."""
        return means.early + np.linalg.solve(np.eye(3) - self.change, means.late - means.early)

    def effect(self, means, others):
        """Return the largest change of the limit of the velocity from a run to others."""
        return max((abs(self.limit(each) - self.limit(means))[2] for each in others), default=0.0)


def _secant(means, beside, size, first):
    """Return the secant of the means of a run and those of three runs, each with one quantity offset by `size`.

    Quantities before the `first` are left out: P is zero for them.
    """
    early = np.column_stack([each.early - means.early for each in beside]) / size
    late = np.column_stack([each.late - means.late for each in beside]) / size
    early[:first] = early[:, :first] = late[:first] = 0.0
    left, sizes, right = np.linalg.svd(early)
    inverse = (right.T * [1.0 / each if each > FORGOTTEN else 0.0 for each in sizes]) @ left.T
    return _Secant(inverse, late @ inverse)


class _Runs(NamedTuple):
    """Runs of one problem in time, over the same number of cycles."""

    problem: Problem
    stepped: bool
    cycles: int
    units: np.ndarray  # (3,): of z_s, z_s' and v in offsets and means

    @property
    def resolutions(self):
        return STEPS if self.stepped else NODES

    def offset(self, begin, change):
        """Return a start with a change of z_s, z_s' and v, in their units."""
        return np.concatenate((begin[:3] + self.units * change, begin[3:]))

    def quarters(self, begin, resolution):
        """Return the means of a run over its second and its last quarter, weighted by sin^4."""
        quarter = self.cycles // 4
        weight = np.sin(np.pi * (np.arange(quarter) + 0.5) / quarter) ** 4
        weight /= np.sum(weight)
        record = self._record(begin, resolution)
        position = record[:, Recorded.POSITION]
        climb = np.gradient(position) / (2.0 * math.pi)
        rows = np.column_stack((position, climb, record[:, Recorded.MEAN_VELOCITY])) / self.units
        return _Means(weight @ rows[quarter : 2 * quarter], weight @ rows[-quarter:])

    def at_mean_height(self, begin):
        """Return a start from which the second cycle has the mean -z_s of `begin`; `begin` if none is found.

        A strong contact damper moves the slider up and down with the wave, but lets it forget its height only in 10^5
        cycles. The position at phase 0, from which a run starts, is then not the mean one of the answer.
        """
        start = begin.copy()
        for _ in range(STARTS):
            motion = self._motion(start, NODES[0])
            motion.turn(1)
            motion.begin()
            motion.turn(1)
            above = motion.mean_height(1) + begin[0]
            if abs(above) < SAME_HEIGHT * self.units[0]:
                return start
            start[0] += above
        return begin

    def _record(self, begin, resolution):
        """Return a row (`Recorded`) for every cycle from a state, in fixed steps or from event to event."""
        if self.stepped:
            return steps(self.problem, begin.copy(), self.cycles, resolution)
        return self._motion(begin, resolution).turn(self.cycles, stride=1)

    def _motion(self, begin, nodes):
        motion = Motion(self.problem, grid=collocation(nodes), truncation=10.0 ** (1 - nodes))
        motion.set_state(*begin[:3], begin[3:])
        return motion


def _cycle_count(problem, method):
    if method == "stepped":
        return STEPPED_CYCLES
    segments_per_cycle = max(24.0, problem.segments)
    cycles = max(LEAST_CYCLES, int(EXACT_SEGMENTS / segments_per_cycle))
    if cycles * segments_per_cycle > MAX_SEGMENTS:
        raise ConvergenceError(
            "out of reach",
            f"a cycle takes {segments_per_cycle:.3g} segments of the motion: too many to follow {LEAST_CYCLES} of them",
        )
    return cycles
