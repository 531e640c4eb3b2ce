r"""The steady state by waiting for it: where no stable motion repeats with the wave's period.

A slider whose contact resonates near the wave's frequency or above it may hop once in several cycles, or never the
same way twice. Then the motion is followed event by event until it repeats after a few cycles, until every contact
sticks for good (the mean velocity is then zero, whatever rings), or until there is enough of it for a mean whose
statistical error is stated: batch means over what is left after the first half, and the difference to a second run
from almost the same start, for there may be several motions to settle to.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from contact.convergence import ConvergenceError
from contact.drive import relative_to_reference
from contact.kinematics import at_phase, tangential_amplitude
from contact.orbit import Orbit
from contact.problem import scaled
from contact.slider import Slider
from contact.solve.collocation import collocation
from contact.solve.energy import DISPLACEMENT
from contact.solve.equilibrium import Balance
from contact.solve.event_driven import APPROACH, HALVINGS, STRETCHES
from contact.solve.motion import Motion
from contact.solve.shooting import Periodic

# cycles after which a motion may repeat, and how closely (of the units of the problem)
PERIODS, REPEATS = 12, 1e-9
# distance (of the units of the problem) at which a stable periodic motion is taken to be reached
CLOSE = 1e-5
# largest difference of two velocities, over the reference speed, that are those of one motion
SAME = 1e-3
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
    motion: Motion  # At the end; its tally and sums cover the `cycles`

    @property
    def height(self) -> float:
        """Minus the mean of z_s over some more cycles; u_z itself has none."""
        ahead, at = self.motion.copy(), 2.0 * math.pi * np.arange(1, 65) / 64
        more = [ahead.move(0.0, 2.0 * math.pi, at)[:, 0, APPROACH].mean() for _ in range(self.period or 4)]
        return float(np.mean(more) - self.motion.problem.paths.height[0])


def long_run(
    slider: Slider, orbits: tuple[Orbit, ...], direction: float, near: np.ndarray | None = None
) -> LongRun:
    """Return the mean of the motion from rest, once it repeats, sticks or has gone on for long enough.

    `direction` as in `problem.scaled`; `near`: phase-0 state z_s, z_s', v, ... of a stable periodic motion, at which a
    run that comes close to it ends.
    """
    start = -0.5 * math.pi - float(np.angle(orbits[0].normal))
    problem = scaled(slider, orbits, direction=direction, start=start)
    rate = _relaxation(problem)
    _refuse_unless_affordable(problem, rate)
    begin = _rest(slider, orbits, problem)
    first = _followed(problem, begin, rate, near)
    if first.period or first.sticks:
        return first
    # a push too small to matter to anything but an irregular motion
    second = _followed(problem, begin + 1e-6 * (np.arange(begin.size) == 1), rate, near)
    other = second if second.period or second.sticks else first
    return replace(other, error=max(first.error, second.error, abs(first.speed - second.speed)), starts=2)


def reached_instead(
    slider: Slider, orbits: tuple[Orbit, ...], balance: Balance, found: Periodic
) -> LongRun | None:
    """Return the motion that a slider from rest comes to, None if it is the periodic one that was found."""
    target = found.motion.copy()
    target.move(0.0, 0.5 * math.pi, np.empty(0))  # from the trough of u_z to its upward zero
    run = long_run(slider, orbits, balance.load_sign, near=target.state)
    apart = (abs(run.speed - found.speed) + run.error) * balance.problem.speed
    return None if relative_to_reference(apart, found.speed * balance.problem.speed, orbits) <= SAME else run


def _followed(problem, begin, rate, near):
    """Return the mean of the motion from one start."""
    motion = Motion(problem, grid=collocation(14), truncation=1e-11)
    motion.place(*begin[:3], begin[3:])
    budget = BUDGET / (MEMORY if motion.memory is not None else 1.0)
    block, passed, spent = 1, 0, 0
    rows, quiet = np.empty((0, 3)), 0
    while True:
        motion.begin()
        rows = np.vstack([rows, motion.turn(block, stride=1)])
        passed += block
        spent += int(motion.tally[STRETCHES] + motion.tally[HALVINGS])
        quiet = quiet + 1 if motion.sticks else 0
        if quiet > 1:
            return LongRun(
                speed=0.0, error=0.0, period=0, sticks=True, cycles=block, passed=passed, motion=motion
            )
        period, gap = _period(rows)
        if near is not None and _arrived(rows, near):
            period, gap = 1, 0.0
        if period:
            return _repeating(motion, period, gap, passed)
        if spent > 0.25 * budget or passed > MAX_CYCLES // 4:
            return _mean(motion, max(BATCHES, passed), passed, rate)
        # as many cycles in a block as a twentieth of the budget takes
        block = int(min(max(1, 0.05 * budget * passed / spent), MAX_CYCLES // 20, 2 * block))


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
    late = rows[-4:, :2] - np.array([near[2], near[0]])
    return len(late) == 4 and bool(np.max(np.abs(late)) < CLOSE * (1.0 + np.max(np.abs(near[:3]))))


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


def _repeating(motion, period, gap, passed):
    """Return the mean over one period, its error from the same period at another order."""
    begin = motion.copy()
    motion.begin()
    motion.turn(period)
    coarse = Motion(motion.problem, grid=collocation(10), truncation=1e-8)
    coarse.state[:], coarse.regime[:], coarse.sign[:] = begin.state, begin.regime, begin.sign
    if begin.memory is None:
        coarse.turn(period)
        error = abs(coarse.sums[DISPLACEMENT] - motion.sums[DISPLACEMENT]) / (2.0 * math.pi * period)
    else:  # what a contact remembers is kept on the nodes of its own order
        error = 1e-9
    speed = float(motion.sums[DISPLACEMENT]) / (2.0 * math.pi * period)
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
