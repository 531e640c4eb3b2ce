r"""Steady state by a long run from rest, for sliders that shooting cannot treat alone.

A slider whose contact resonance is near or above the wave frequency may hop with a period of several cycles, or
irregularly. `long_run` then follows every event until one of three conditions holds:

- the motion repeats after a few cycles;
- every contact sticks permanently, so that the mean velocity is zero even if the slider still rings;
- the run is long enough for a mean with a statistical error. The error is that of batch means over the last part of
  the run plus the difference to a second run from almost the same start, since several steady motions may exist.

A stable motion that repeats with the wave's period is not necessarily reached from rest. `reached` checks this with two
runs, from rest and from a slightly different state. The motion counts as reached if both runs come to it together. If
weak damping makes the transient too long for the event-driven solver, fixed time steps follow the bounce until it has
decayed. Whatever remains uncertain is reported as a doubt: the difference in velocity between the periodic motion and
the motion that was observed.
"""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from contact.averaged.event_equilibrium import Balance
from contact.body import at_phase, tangential_amplitude
from contact.codes import At, Recorded, Tangential, WorkCount
from contact.error_estimate import BATCHES, batch_mean_error, two_orders_error, two_starts_error
from contact.events.collocation import collocation
from contact.events.energy import EnergySum
from contact.events.motion import Motion, rest_state
from contact.exceptions import ConvergenceError
from contact.orbit import Orbits, as_orbits
from contact.periodic.shooting import MULTIPLIER_ERROR, Periodic
from contact.problem import full_friction, largest_resonance, scaled
from contact.slider import Slider
from contact.stepping.time_stepping import steps

# largest period in cycles that is tested for, and largest difference of a repeating motion (in units of the problem)
PERIODS, REPEATS = 12, 1e-9
# distance (in units of the problem) at which a stable periodic motion counts as reached
CLOSE = 1e-5
# two mean velocities belong to the same motion if they differ by less than this times the reference speed
SAME = 1e-3
# A transient of at most this many cycles is regular: it is accepted from a single run.
MAX_REGULAR = 200
# If irregular transients from two starts both end within this many cycles, one from a third start is unlikely to last
# ten times as long.
MAX_IRREGULAR = 1000
# number of e-foldings after which a perturbation has decayed
DECAYED = 8.0
# longest decay time in cycles that is followed with fixed time steps (about one second)
MAX_DECAY_CYCLES = 100_000
# After this many cycles without slip (several bounce periods) every contact counts as sticking permanently.
STUCK_CYCLES = 64
# fixed time steps per cycle for the slow decay of a bounce, and the largest omega_n dt for which they are used
STEPS_PER_CYCLE, MAX_STEP = 64, 0.2
# largest number of segments (some seconds) and of cycles in a run
BUDGET, MAX_CYCLES = 600_000, 30_000
MEMORY = 4.0  # cost of a segment with the hysteretic law over that with the elastic law: 2.0 to 4.0 in four bursts
# A contact with a tangential resonance above this times the wave frequency moves with the surface from the start.
SLOW = 5.0


@dataclass(frozen=True, kw_only=True)
class LongRun:
    """Mean of a long motion in the units of its problem; at phase 0 the first u_z crosses zero upwards."""

    speed: float  # mean of v
    error: float  # estimated error of `speed`
    period: int  # number of cycles after which the motion repeats; 0 if no repetition was observed
    sticks: bool  # True if every contact sticks permanently, so that the speed is exactly zero
    cycles: int  # number of cycles in the mean
    passed: int  # number of cycles before them
    starts: int = 1  # number of runs from different starts
    arrived: bool = False  # True if the run came to the known periodic motion
    velocities: np.ndarray = field(default_factory=lambda: np.zeros(1), repr=False)  # v after each cycle in `passed`
    eventual: float = math.nan  # mean of v after a slow bounce has decayed; NaN if it was not computed
    motion: Motion  # at the end of the run; its tally and sums cover the `cycles`

    @property
    def transient(self) -> float:
        """Mean of v over the second half of the transient, the `passed` cycles."""
        return float(np.mean(self.velocities[self.velocities.size // 2 :]))

    @property
    def height(self) -> float:
        """Minus the mean of z_s."""
        return self.motion.mean_height(self.cycles)


class Reached(NamedTuple):
    """Result of the check whether a slider from rest reaches a periodic motion; velocities in units of the problem."""

    instead: LongRun | None = None  # another steady motion that is reached instead; None if there is none
    doubt: float = 0.0  # possible difference in velocity between the periodic motion and the one from rest
    reason: str = ""  # reason for the doubt
    speed: float | None = None  # velocity of the observed motion if it differs from the periodic one


def long_run(slider: Slider, orbits: Orbits, direction: float) -> LongRun:
    """Return the mean of the motion from rest, when it repeats, sticks or has run for long enough.

    `direction` is that of `problem.scaled`.
    """
    problem, begin = start_at_rest(slider, orbits, direction)
    rate = relaxation_rate(problem)
    _refuse_unless_affordable(problem, rate)
    first = run_from(problem, begin, rate)
    settled = first.period or first.sticks
    if settled and first.passed <= MAX_REGULAR:
        return first
    second = run_from(problem, _perturbed(begin), rate)
    difference = abs(first.speed - second.speed)
    if not settled:
        better = second if second.period or second.sticks else first
        return replace(better, error=two_starts_error(first, second), starts=2)
    if _together(first, second, _same_speed(first.speed, problem)):
        return first
    # the transient is irregular, or several steady motions exist: a start may keep the mean velocity of the transient
    doubt = max(abs(first.transient - first.speed), abs(second.transient - first.speed), difference)
    return replace(first, error=first.error + doubt, starts=2)


def mean_from_rest(slider: Slider, orbits: Orbits, direction: float, cycles: int) -> float:
    """Return the mean velocity in m/s over the second half of `cycles` cycles from rest, by the event-driven solver."""
    problem, begin = start_at_rest(slider, orbits, direction)
    _refuse_unless_affordable(problem, math.inf)
    motion = Motion(problem, grid=collocation(10), truncation=1e-7)
    position, normal_velocity, velocity = begin[:3]
    motion.set_state(position, normal_velocity, velocity, begin[3:])
    record = motion.turn(cycles, stride=1)
    return float(np.mean(record[cycles // 2 :, Recorded.MEAN_VELOCITY])) * problem.speed


def _same_speed(speed, problem):
    """Return the largest difference of two mean velocities that count as those of the same motion, scaled."""
    reach = float(np.max(tangential_amplitude(problem.paths, np.arange(problem.contacts))))
    return SAME * max(abs(speed), reach / 10.0)


def reached(slider: Slider, orbits: Orbits, balance: Balance, target: Periodic) -> Reached:
    """Check whether a slider from rest reaches the stable periodic motion `target`.

    Two runs are followed, from rest and from a slightly different state. If both come to the target together, it is
    reached. If only one does, or both at very different times, it is a matter of chance, which is a doubt. If neither
    does, the motion that they come to is reached instead, or, if the bounce has not decayed by then, the difference is
    a doubt.
    """
    motion = target.motion.copy()
    motion.move(0.0, 0.5 * math.pi, np.empty(0))  # from the trough of u_z to its upward zero
    problem, begin = start_at_rest(slider, orbits, balance.load_sign)
    same = _same_speed(target.speed, problem)
    reference_speed, near = same / SAME, Near(motion.state, target.speed, same, target.growth)
    rate = relaxation_rate(problem)
    try:
        _refuse_unless_affordable(problem, math.inf)
        first = run_from(problem, begin, rate, near)
        # A second start is needed unless the first one soon arrives: an irregular transient may end much earlier or
        # later from another start.
        soon = first.arrived and first.passed <= MAX_REGULAR
        second = first if soon else run_from(problem, _perturbed(begin), rate, near)
    except ConvergenceError as failed:
        return Reached(doubt=reference_speed, reason=f"whether a slider from rest comes to it was not seen: {failed}")
    if first.arrived and second.arrived:  # both
        if _together(first, second, near.same):
            return Reached()
        slower, faster = (first, second) if first.passed > second.passed else (second, first)
        return _matter_of_chance(slower, faster, reference_speed, target.speed)
    if first.arrived or second.arrived:  # one of them
        absent, arrived = (second, first) if first.arrived else (first, second)
        return _matter_of_chance(absent, arrived, reference_speed, target.speed)
    # neither: what they do instead
    run = second if second.period or second.sticks else first
    run = replace(run, error=two_starts_error(first, second), starts=2)
    difference = abs(run.speed - target.speed) + run.error
    if difference <= near.same:
        return Reached()
    if run.period or run.sticks or run.passed + run.cycles > DECAYED * near.decay_cycles:
        return Reached(instead=run)
    reason = f"a start from rest still bounces after {run.passed + run.cycles} cycles"
    decayed = [each.eventual for each in (first, second) if not math.isnan(each.eventual)]  # by fixed time steps
    doubt = max([difference, *(abs(speed - target.speed) for speed in decayed)])
    return Reached(doubt=doubt, reason=reason, speed=decayed[0] if decayed else run.speed)


def _together(first, second, same):
    """Return True if two runs from almost the same start stay together or soon reach the same motion."""
    common = min(first.velocities.size, second.velocities.size)
    difference = float(np.max(np.abs(first.velocities[:common] - second.velocities[:common])))
    soon = max(first.passed, second.passed) <= MAX_IRREGULAR and abs(first.speed - second.speed) <= same
    return difference <= same or (soon and bool(second.period or second.sticks))


def _matter_of_chance(slower, faster, reference_speed, speed):
    """Return the doubt if two neighbouring starts reach a motion after very different times, or `slower` never does.

    The doubt is the difference of `slower`'s mean velocity during the transient from the motion's, `speed`.
    """
    doubt = max(abs(slower.transient - speed), SAME * reference_speed)
    until = "has not come to it" if not slower.arrived else "comes to it"
    reason = (
        f"a start from rest {until} after {slower.passed} cycles of irregular motion, another after {faster.passed}: "
        "how long it takes is a matter of chance"
    )
    return Reached(doubt=doubt, reason=reason, speed=slower.transient)


class Near(NamedTuple):
    """A stable periodic motion that a run from rest may reach, scaled."""

    state: np.ndarray  # at phase 0: z_s, z_s', v, ...
    speed: float  # mean of v
    same: float  # largest difference of two mean velocities that count as those of the same motion
    growth: float  # largest Floquet multiplier

    @property
    def decay_cycles(self) -> float:
        """Number of cycles in which a small perturbation decays to 1/e; inf if it does not decay."""
        return 1.0 / -math.log(self.growth) if self.growth < 1.0 - MULTIPLIER_ERROR else math.inf


def start_at_rest(slider, orbits, direction):
    """Return the scaled problem and the state (3 + contacts,) of a slider at rest, in its units.

    Where the wave is slow for the contacts, the slider moves with the surface from the start. At phase 0 u_z of the
    first contact crosses zero upwards. `direction` is that of `problem.scaled`.
    """
    orbits = as_orbits(orbits)
    problem = scaled(slider, orbits, direction=direction, start=orbits[0].upward_zero)
    begin = rest_state(slider, problem)
    if slider.tangential_resonance(problem.contacts) >= SLOW * orbits.frequency:
        u_z, z_rate, _, x_rate = at_phase(problem.paths, np.arange(problem.contacts), 1.0, 0.0)
        begin[: At.DEFORMATIONS] += np.mean(u_z), np.mean(z_rate), np.mean(x_rate)
    return problem, begin


def _perturbed(begin):
    """Return a slightly different start; the normal velocity changes too little to affect a regular motion."""
    return begin + 1e-6 * (np.arange(begin.size) == 1)


def run_from(problem, begin, rate, near=None):
    """Return the mean of the motion from the scaled state `begin`, as a `LongRun`.

    `rate` is that of `relaxation_rate`. The run proceeds in blocks of cycles, each at most twice as long as the one
    before. After each block it ends if every contact has stuck for long enough, if it has come close to the motion
    `near`, if it repeats, or if a quarter of the budget is spent; the mean is then taken over the cycles to come.
    """
    motion = Motion(problem, grid=collocation(14), truncation=1e-11)
    motion.set_state(*begin[:3], begin[3:])
    budget = BUDGET / (MEMORY if motion.memory is not None else 1.0)
    block, passed, spent = 1, 0, 0
    record, stuck, eventual = np.empty((0, 3)), 0, None
    while True:
        motion.begin()
        record = np.vstack([record, motion.turn(block, stride=1)])
        passed += block
        spent += int(motion.tally[WorkCount.SEGMENTS] + motion.tally[WorkCount.HALVINGS])
        stuck = stuck + block if motion.sticks else 0
        if stuck >= STUCK_CYCLES:
            return LongRun(
                speed=0.0, error=0.0, period=0, sticks=True, cycles=block, passed=passed, motion=motion,
                velocities=record[:, Recorded.VELOCITY],
            )  # fmt: skip
        if near is not None and _arrived(record, near):
            return _arrival(motion, record, passed, near)
        period, gap = _period(record)
        if period:
            run = _repeating(motion, begin, period, gap, passed)
            close = near is not None and abs(run.speed - near.speed) <= near.same
            return replace(run, arrived=close, velocities=record[:, Recorded.VELOCITY])
        if near is not None and passed > MAX_REGULAR and eventual is None:
            eventual = _eventual(problem, motion, near)
            if abs(eventual - near.speed) <= near.same:
                return _arrival(motion, record, passed, near)
        if spent > 0.25 * budget or passed > MAX_CYCLES // 4:
            run = _mean(motion, max(BATCHES, passed), passed, rate)
            return replace(
                run, velocities=record[:, Recorded.VELOCITY], eventual=math.nan if eventual is None else eventual
            )
        # the next block takes at most a twentieth of the budget
        block = int(min(max(1, 0.05 * budget * passed / spent), MAX_CYCLES // 20, 2 * block))


def _arrival(motion, record, passed, near):
    """Return the result of a run that has reached the known motion."""
    return LongRun(
        speed=near.speed, error=near.same, period=1, sticks=False, cycles=1, passed=passed, motion=motion,
        arrived=True, velocities=record[:, Recorded.VELOCITY],
    )  # fmt: skip


def _eventual(problem, motion, near):
    """Return the mean velocity after a slow bounce has decayed, by fixed time steps.

    The mean covers the last tenth of the steps. It is NaN if the decay is fast enough for the event-driven solver, if
    it takes too long, or if fixed time steps do not apply.
    """
    if not MAX_REGULAR < near.decay_cycles < MAX_DECAY_CYCLES:
        return math.nan
    if problem.law.kind != Tangential.ELASTIC or problem.stick_band:
        return math.nan
    if 2.0 * math.pi / STEPS_PER_CYCLE * largest_resonance(problem) > MAX_STEP or problem.limit_slope == 0.0:
        return math.nan
    cycles = int(DECAYED * near.decay_cycles)
    record = steps(problem, motion.state.copy(), cycles, STEPS_PER_CYCLE)
    return float(np.mean(record[-max(1, cycles // 10) :, Recorded.MEAN_VELOCITY]))


def relaxation_rate(problem):
    """Return the rate per radian at which v relaxes: damper, plus friction force over the range of surface speeds."""
    reach = float(np.max(tangential_amplitude(problem.paths, np.arange(problem.contacts)))) + 1e-300
    return problem.tangential_damping + 0.3 * full_friction(problem) / reach


def _refuse_unless_affordable(problem, rate):
    """Raise if a long run would take too many segments or cycles."""
    segments = problem.segments
    if segments > BUDGET / 30:
        raise ConvergenceError(
            "out of reach",
            f"a cycle takes {segments:.3g} stretches of the motion, for contact or dampers are so much faster than "
            "the wave; raise the mass or lower the dampers",
        )
    cycles = 2.0 / (2.0 * math.pi * rate)  # in two relaxation times
    if cycles > min(MAX_CYCLES, BUDGET / max(segments, 16.0)) / 4:
        raise ConvergenceError(
            "out of reach",
            f"no stable motion repeats with the wave's period, and the slider takes {cycles:.3g} cycles to settle, too "
            "many to follow; follow a burst by method stepped",
        )


def _arrived(record, near):
    """Return True if the last four cycles ended within `CLOSE` of the known motion."""
    late = np.abs(record[-4:, :2] - near.state[[At.VELOCITY, At.POSITION]])  # Recorded.VELOCITY, Recorded.POSITION
    close = CLOSE * (1.0 + np.max(np.abs(near.state[:3])))
    return len(late) == 4 and bool(np.max(late[:, 0]) < min(close, near.same) and np.max(late[:, 1]) < close)


def _period(record):
    """Return (period in cycles or 0, estimated distance from the periodic motion).

    The samples of the last three periods are compared with those one period before. `ratio` is this difference over
    the same difference two periods earlier, and the distance is the sum of a geometric series with this ratio.
    """
    for period in range(1, PERIODS + 1):
        if len(record) < 6 * period:
            break
        late = record[-3 * period :] - record[-4 * period : -period]
        early = record[-5 * period : -2 * period] - record[-6 * period : -3 * period]
        scale = 1.0 + np.max(np.abs(record[-3 * period :]))
        gap, former = float(np.max(np.abs(late))), float(np.max(np.abs(early)))
        if gap > REPEATS * scale:
            continue
        ratio = gap / former if former > 0.0 else 0.0
        rounding = 1e-13 * scale
        if gap <= rounding or ratio < 0.9:
            return period, gap * ratio / (1.0 - min(ratio, 0.9)) + rounding
    return 0, math.inf


def _repeating(motion, begin, period, gap, passed):
    """Return the mean over one period; its error is the difference to the same period at a lower order."""
    before = motion.copy()
    motion.begin()
    motion.turn(period)
    coarse = Motion(motion.problem, grid=collocation(10), truncation=1e-8)
    if motion.memory is None:
        coarse.state[:], coarse.regime[:], coarse.sign[:] = before.state, before.regime, before.sign
    else:  # the memory is stored on the nodes of one order: repeat the whole run at the lower order
        coarse.set_state(*begin[:3], begin[3:])
        coarse.turn(passed)
        coarse.begin()
    coarse.turn(period)
    difference = abs(coarse.sums[EnergySum.DISPLACEMENT] - motion.sums[EnergySum.DISPLACEMENT]) / (
        2.0 * math.pi * period
    )
    speed = float(motion.sums[EnergySum.DISPLACEMENT]) / (2.0 * math.pi * period)
    return LongRun(
        speed=speed, error=two_orders_error(difference, gap), period=period, sticks=False, cycles=period, passed=passed,
        motion=motion,
    )  # fmt: skip


def _mean(motion, cycles, passed, rate):
    """Return the mean over `cycles` more cycles from batch means, during which v relaxes with `rate`."""
    motion.begin()
    batch_cycles = max(1, cycles // BATCHES)
    velocities = motion.turn(batch_cycles * BATCHES, stride=1)[:, Recorded.MEAN_VELOCITY]
    means = velocities.reshape(BATCHES, batch_cycles).mean(axis=1)
    settled = -math.expm1(-rate * 2.0 * math.pi * 0.5 * BATCHES * batch_cycles)
    error, spread, drift = batch_mean_error(means, settled)
    if drift > 3.0 * spread or settled < 0.2:
        raise ConvergenceError(
            "not settled",
            f"after {passed + BATCHES * batch_cycles} cycles the slider's speed still drifts by "
            f"{drift * motion.problem.speed:.2g} m/s; raise the dampers or follow a burst",
        )
    return LongRun(
        speed=float(np.mean(means)), error=error, period=0, sticks=False,
        cycles=batch_cycles * BATCHES, passed=passed, motion=motion,
    )  # fmt: skip
