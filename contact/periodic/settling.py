r"""The steady state by waiting for it: where no stable motion repeats with the wave's period.

A slider whose contact resonates near the wave's frequency or above it may hop once in several cycles, or never the
same way twice. Then the motion is followed event by event until it repeats after a few cycles, until every contact
sticks for good (the mean velocity is then zero, whatever rings), or until there is enough of it for a mean whose
statistical error is stated: batch means over what is left after the first half, and the difference to a second run
from almost the same start, for there may be several motions to settle to.

A stable motion that repeats with the wave's period need not be the one that a slider from rest comes to. It counts as
reached where a start from rest, and one a little beside it, come to it side by side. Where a light damper
takes longer than can be followed event by event, fixed steps follow the bounce until it has died. What is then still
open is stated as a doubt: the difference in velocity between the periodic motion and the one that was seen.
"""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from contact.averaged.event_cycle import Balance
from contact.body import at_phase, tangential_amplitude
from contact.codes import Count, Tangential
from contact.convergence_error import ConvergenceError
from contact.events.collocation import collocation
from contact.events.energy import Sum
from contact.events.motion import Motion
from contact.events.segment import Column, Sample
from contact.orbit import Orbit
from contact.periodic.shooting import MULTIPLIER_ERROR, Periodic
from contact.problem import largest_resonance, scaled
from contact.slider import Slider
from contact.stepping.time_stepping import steps

# cycles after which a motion may repeat, and how closely (of the units of the problem)
PERIODS, REPEATS = 12, 1e-9
# distance (of the units of the problem) at which a stable periodic motion is taken to be reached
CLOSE = 1e-5
# largest difference of two velocities, over the reference speed, that are those of one motion
SAME = 1e-3
# Cycles within which a transient is no matter of chance, and within which an irregular one has ended for two starts, so
# that it hardly lasts ten times as long for a third; e-foldings after which a departure has died out, and the slowest
# that is waited for, cycles (a second in fixed steps)
REGULAR, IRREGULAR, SURELY, MAX_SETTLING = 200, 1000, 8.0, 100_000
# cycles without any slip after which every contact sticks for good: some periods of the bounce
STUCK_CYCLES = 64
# fixed steps for that: per cycle, and the largest change of the contact's oscillation in one
STEPS_PER_CYCLE, MAX_STEP = 64, 0.2
# segments that a run may take (some seconds), and cycles
BUDGET, MAX_CYCLES = 600_000, 30_000
MEMORY = 10.0  # cost of a segment with the hysteretic law
BATCHES, STUDENT = 16, 2.13  # of the mean, and the factor for 95 % with 15 degrees of freedom
# as fast against the wave as this a contact follows the surface from the start
SLOW = 5.0


@dataclass(frozen=True, kw_only=True)
class LongRun:
    """Mean of a long motion, in the units of its problem; phase 0 is where the first u_z rises through zero."""

    speed: float  # Mean of v
    error: float  # Estimated, of `speed`
    period: int  # Cycles after which the motion repeats; 0 if it was not seen to
    sticks: bool  # Whether every contact sticks for good, so that the speed is exactly zero
    # Over which the mean is taken, and those before
    cycles: int
    passed: int
    starts: int = 1  # From which the motion was followed
    arrived: bool = False  # Whether it came to a motion that was known before
    # v at the ends of the cycles before, and its mean when a slow bounce has died (NaN: not asked)
    velocities: np.ndarray = field(default_factory=lambda: np.zeros(1), repr=False)
    eventual: float = math.nan
    motion: Motion  # At the end; its tally and sums cover the `cycles`

    @property
    def transient(self) -> float:
        """Mean of v over the second half of the cycles before."""
        return float(np.mean(self.velocities[self.velocities.size // 2 :]))

    @property
    def height(self) -> float:
        """Minus the mean of z_s over some more cycles; u_z itself has none."""
        motion, phases = self.motion.copy(), 2.0 * math.pi * np.arange(1, 65) / 64
        approaches = [
            motion.move(0.0, 2.0 * math.pi, phases)[:, 0, Sample.APPROACH].mean()
            for _ in range(self.period or 4)
        ]
        return float(np.mean(approaches) - self.motion.problem.paths.height[0])


class Reached(NamedTuple):
    """What a start from rest says of a stable periodic motion; velocities in the units of the balance's problem."""

    instead: LongRun | None = None  # another motion, which is the answer
    doubt: float = 0.0  # how far the velocity of a start from rest may be from that of the periodic motion
    reason: str = ""  # why there is a doubt
    speed: float | None = None  # velocity of the motion that was seen, where it is another


def long_run(slider: Slider, orbits: tuple[Orbit, ...], direction: float) -> LongRun:
    """Return the mean of the motion from rest, once it repeats, sticks or has gone on for long enough.

    `direction` as in `problem.scaled`.
    """
    problem, begin = _started(slider, orbits, direction)
    rate = _relaxation(problem)
    _refuse_unless_affordable(problem, rate)
    first = _followed(problem, begin, rate)
    settled = first.period or first.sticks
    if settled and first.passed <= REGULAR:
        return first
    second = _followed(problem, _beside(begin), rate)
    apart = abs(first.speed - second.speed)
    if not settled:
        other = second if second.period or second.sticks else first
        return replace(other, error=max(first.error, second.error, apart), starts=2)
    if _together(first, second, _same(first.speed, problem)):
        return first
    # an irregular transient, or several motions to settle to: the mean before is what a start may go on with
    doubt = max(abs(first.transient - first.speed), abs(second.transient - first.speed), apart)
    return replace(first, error=first.error + doubt, starts=2)


def mean_from_rest(slider: Slider, orbits: tuple[Orbit, ...], direction: float, cycles: int) -> float:
    """Return the mean velocity in m/s over the second half of so many cycles from rest, followed event by event."""
    problem, begin = _started(slider, orbits, direction)
    _refuse_unless_affordable(problem, math.inf)
    motion = Motion(problem, grid=collocation(10), truncation=1e-7)
    height, climb, speed = begin[:3]
    motion.place(height, climb, speed, begin[3:])
    rows = motion.turn(cycles, stride=1)
    return float(np.mean(rows[cycles // 2 :, Column.MEAN_VELOCITY])) * problem.speed


def _same(speed, problem):
    """Return the difference of two mean velocities that are those of one motion, scaled."""
    reach = float(np.max(tangential_amplitude(problem.paths, np.arange(problem.contacts))))
    return SAME * max(abs(speed), reach / 10.0)


def reached(slider: Slider, orbits: tuple[Orbit, ...], balance: Balance, found: Periodic) -> Reached:
    """Return whether a slider from rest comes to a stable periodic motion, or to which else."""
    target = found.motion.copy()
    target.move(0.0, 0.5 * math.pi, np.empty(0))  # from the trough of u_z to its upward zero
    problem, begin = _started(slider, orbits, balance.load_sign)
    same = _same(found.speed, problem)
    unit, near = same / SAME, Near(target.state, found.speed, same, found.growth)
    rate = _relaxation(problem)
    try:
        _refuse_unless_affordable(problem, math.inf)
        first = _followed(problem, begin, rate, near)
        # an irregular transient ends when it happens to: from another start much earlier or later
        again = first.passed > REGULAR or not first.arrived
        second = _followed(problem, _beside(begin), rate, near) if again else first
    except ConvergenceError as failed:
        return Reached(doubt=unit, reason=f"whether a slider from rest comes to it was not seen: {failed}")
    if first.arrived and second.arrived:
        if _together(first, second, near.same):
            return Reached()
        late = first if first.passed > second.passed else second
        return _irregular(late, second.passed + first.passed - late.passed, unit, found.speed)
    if first.arrived or second.arrived:
        run = second if first.arrived else first
        return _irregular(run, first.passed + second.passed - run.passed, unit, found.speed)
    run = second if second.period or second.sticks else first
    run = replace(run, error=max(first.error, second.error, abs(first.speed - second.speed)), starts=2)
    apart = abs(run.speed - found.speed) + run.error
    if apart <= near.same:
        return Reached()
    if run.period or run.sticks or run.passed + run.cycles > SURELY * near.decay_cycles:
        return Reached(instead=run)
    reason = f"a start from rest still bounces after {run.passed + run.cycles} cycles"
    later = [each.eventual for each in (first, second) if not math.isnan(each.eventual)]
    doubt = max([apart, *(abs(speed - found.speed) for speed in later)])
    return Reached(doubt=doubt, reason=reason, speed=later[0] if later else run.speed)


def _together(first, second, same):
    """Return whether two runs from almost the same start settle to one motion, side by side or before long."""
    both = min(first.velocities.size, second.velocities.size)
    apart = float(np.max(np.abs(first.velocities[:both] - second.velocities[:both])))
    soon = max(first.passed, second.passed) <= IRREGULAR and abs(first.speed - second.speed) <= same
    return apart <= same or (soon and bool(second.period or second.sticks))


def _irregular(run, other, unit, speed):
    """Return the doubt of a motion that two neighbouring starts reach at very different times, or one not at all."""
    doubt = max(abs(run.transient - speed), SAME * unit)
    until = "has not come to it" if not run.arrived else "comes to it"
    reason = (
        f"a start from rest {until} after {run.passed} cycles of irregular motion, another after {other}: how long it "
        "takes is a matter of chance"
    )
    return Reached(doubt=doubt, reason=reason, speed=run.transient)


class Near(NamedTuple):
    """A stable periodic motion, to which a run from rest may come; scaled."""

    state: np.ndarray  # at phase 0: z_s, z_s', v, ...
    speed: float  # mean of v
    same: float  # difference of two mean velocities that are those of one motion
    growth: float  # largest Floquet multiplier

    @property
    def decay_cycles(self) -> float:
        """Cycles in which a small departure falls to 1/e; inf where nothing damps it."""
        return 1.0 / -math.log(self.growth) if self.growth < 1.0 - MULTIPLIER_ERROR else math.inf


def _started(slider, orbits, direction):
    """Return (problem, state at rest) where u_z of the first contact rises through zero."""
    start = -0.5 * math.pi - float(np.angle(orbits[0].normal))
    problem = scaled(slider, orbits, direction=direction, start=start)
    return problem, _rest(slider, orbits, problem)


def _beside(begin):
    """Return almost the same start: a push too small to matter to anything but an irregular motion."""
    return begin + 1e-6 * (np.arange(begin.size) == 1)


def _followed(problem, begin, rate, near=None):
    """Return the mean of the motion from one start; `near`: a motion at which a run that comes close to it ends."""
    motion = Motion(problem, grid=collocation(14), truncation=1e-11)
    motion.place(*begin[:3], begin[3:])
    budget = BUDGET / (MEMORY if motion.memory is not None else 1.0)
    block, passed, spent = 1, 0, 0
    rows, quiet, eventual = np.empty((0, 3)), 0, None
    while True:
        motion.begin()
        rows = np.vstack([rows, motion.turn(block, stride=1)])
        passed += block
        spent += int(motion.tally[Count.SEGMENTS] + motion.tally[Count.HALVINGS])
        quiet = quiet + block if motion.sticks else 0
        if quiet >= STUCK_CYCLES:
            return LongRun(
                speed=0.0, error=0.0, period=0, sticks=True, cycles=block, passed=passed, motion=motion,
                velocities=rows[:, Column.VELOCITY],
            )  # fmt: skip
        if near is not None and _arrived(rows, near):
            return _arrival(motion, rows, passed, near)
        period, gap = _period(rows)
        if period:
            run = _repeating(motion, begin, period, gap, passed)
            close = near is not None and abs(run.speed - near.speed) <= near.same
            return replace(run, arrived=close, velocities=rows[:, Column.VELOCITY])
        if near is not None and passed > REGULAR and eventual is None:
            eventual = _eventual(problem, motion, near)
            if abs(eventual - near.speed) <= near.same:
                return _arrival(motion, rows, passed, near)
        if spent > 0.25 * budget or passed > MAX_CYCLES // 4:
            run = _mean(motion, max(BATCHES, passed), passed, rate)
            return replace(
                run, velocities=rows[:, Column.VELOCITY], eventual=math.nan if eventual is None else eventual
            )
        # as many cycles in a block as a twentieth of the budget takes
        block = int(min(max(1, 0.05 * budget * passed / spent), MAX_CYCLES // 20, 2 * block))


def _arrival(motion, rows, passed, near):
    """Return the run that has come to a known motion."""
    return LongRun(
        speed=near.speed, error=near.same, period=1, sticks=False, cycles=1, passed=passed, motion=motion,
        arrived=True, velocities=rows[:, Column.VELOCITY],
    )  # fmt: skip


def _eventual(problem, motion, near):
    """Return the mean velocity, by fixed steps, when a bounce that dies out too slowly to be followed exactly has died.

    The mean is over the last tenth. NaN where the decay is fast, or takes too long, or fixed steps do not serve.
    """
    if (
        not REGULAR < near.decay_cycles < MAX_SETTLING
        or problem.law.kind != Tangential.ELASTIC
        or problem.stick_band
    ):
        return math.nan
    if 2.0 * math.pi / STEPS_PER_CYCLE * largest_resonance(problem) > MAX_STEP or problem.limit_slope == 0.0:
        return math.nan
    cycles = int(SURELY * near.decay_cycles)
    rows = steps(problem, motion.state.copy(), cycles, STEPS_PER_CYCLE)
    return float(np.mean(rows[-max(1, cycles // 10) :, Column.MEAN_VELOCITY]))


def _relaxation(problem):
    """Return the rate per radian at which v settles: damper, and friction force over the range of speeds."""
    reach = float(np.max(tangential_amplitude(problem.paths, np.arange(problem.contacts)))) + 1e-300
    return problem.tangential_damping + 0.3 * problem.friction * problem.preload / reach


def _refuse_unless_affordable(problem, rate):
    segments = problem.segments
    if segments > BUDGET / 30:
        raise ConvergenceError(
            "out of reach",
            f"a cycle takes {segments:.3g} stretches of the motion, for contact or dampers are so much faster than "
            "the wave; raise the mass or lower the dampers",
        )
    cycles = 2.0 / (2.0 * math.pi * rate)
    if cycles > min(MAX_CYCLES, BUDGET / max(segments, 16.0)) / 4:
        raise ConvergenceError(
            "out of reach",
            f"no stable motion repeats with the wave's period, and the slider takes {cycles:.3g} cycles to settle, too "
            "many to follow; follow a burst by method stepped",
        )


def _rest(slider, orbits, problem):
    """Return (z_s, z_s', v, x) at phase 0: at rest, or carried along by a surface that is slow for the contact."""
    depth = slider.rest_approach(len(orbits)) / problem.length
    x = math.copysign(1.0, problem.load) * slider.rest_deformations(len(orbits)) / problem.length
    if slider.tangential_resonance(len(orbits)) < SLOW * orbits[0].frequency:
        return np.array([-depth, 0.0, 0.0, *x])
    u_z, z_rate, _, x_rate = at_phase(problem.paths, np.arange(problem.contacts), 1.0, 0.0)
    return np.array([np.mean(u_z) - depth, np.mean(z_rate), np.mean(x_rate), *x])


def _arrived(rows, near):
    """Return whether the last cycles ended within `CLOSE` of a stable motion."""
    late = np.abs(rows[-4:, :2] - np.array([near.state[2], near.state[0]]))
    close = CLOSE * (1.0 + np.max(np.abs(near.state[:3])))
    return len(late) == 4 and bool(np.max(late[:, 0]) < min(close, near.same) and np.max(late[:, 1]) < close)


def _period(rows):
    """Return (cycles after which the motion repeats or 0, what is left to settle)."""
    for period in range(1, PERIODS + 1):
        if len(rows) < 6 * period:
            break
        late = rows[-3 * period :] - rows[-4 * period : -period]
        early = rows[-5 * period : -2 * period] - rows[-6 * period : -3 * period]
        scale = 1.0 + np.max(np.abs(rows[-3 * period :]))
        gap, former = float(np.max(np.abs(late))), float(np.max(np.abs(early)))
        if gap > REPEATS * scale:
            continue
        left = gap / former if former > 0.0 else 0.0
        rounding = 1e-13 * scale
        if gap <= rounding or left < 0.9:
            return period, gap * left / (1.0 - min(left, 0.9)) + rounding
    return 0, math.inf


def _repeating(motion, begin, period, gap, passed):
    """Return the mean over one period, its error from the same period at another order."""
    before = motion.copy()
    motion.begin()
    motion.turn(period)
    coarse = Motion(motion.problem, grid=collocation(10), truncation=1e-8)
    if motion.memory is None:
        coarse.state[:], coarse.regime[:], coarse.sign[:] = before.state, before.regime, before.sign
    else:  # what a contact remembers is kept on the nodes of its own order, and made by the whole run
        coarse.place(*begin[:3], begin[3:])
        coarse.turn(passed)
        coarse.begin()
    coarse.turn(period)
    error = abs(coarse.sums[Sum.DISPLACEMENT] - motion.sums[Sum.DISPLACEMENT]) / (2.0 * math.pi * period)
    speed = float(motion.sums[Sum.DISPLACEMENT]) / (2.0 * math.pi * period)
    return LongRun(
        speed=speed,
        error=error + gap,
        period=period,
        sticks=False,
        cycles=period,
        passed=passed,
        motion=motion,
    )


def _mean(motion, cycles, passed, rate):
    """Return the mean over as many cycles again, in batches; what is left to settle counts as an error."""
    motion.begin()
    each = max(1, cycles // BATCHES)
    means = motion.turn(each * BATCHES, stride=1)[:, 2].reshape(BATCHES, each).mean(axis=1)
    spread = STUDENT * float(np.std(means, ddof=1)) / math.sqrt(BATCHES)
    half = BATCHES // 2
    drift = abs(float(np.mean(means[half:]) - np.mean(means[:half])))
    settled = -math.expm1(-rate * 2.0 * math.pi * 0.5 * BATCHES * each)
    if drift > 3.0 * spread or settled < 0.2:
        raise ConvergenceError(
            "not settled",
            f"after {passed + BATCHES * each} cycles the slider's speed still drifts by "
            f"{drift * motion.problem.speed:.2g} m/s; raise the dampers or follow a burst",
        )
    return LongRun(
        speed=float(np.mean(means)), error=(spread + drift) / settled, period=0, sticks=False,
        cycles=each * BATCHES, passed=passed, motion=motion,
    )  # fmt: skip
