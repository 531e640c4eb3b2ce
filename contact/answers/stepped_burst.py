"""Method "stepped" of a burst: fixed time steps, with an error that the event-driven method measures.

A long burst is computed once, and its errors are measured in parts of it. Others are refined from level to level, and
the estimated error is calibrated in a window of the first cycles.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.answers.burst_question import Burst, compared_velocities
from contact.answers.event_driven_burst import EXACT_CYCLES, ORDERS, every_event, exact_refusals
from contact.answers.refined_run import refined
from contact.answers.rest_motion import rest, times
from contact.choice import Result
from contact.codes import At, Recorded
from contact.error_estimate import FLOOR, LEAST_SHARE, calibrated_error, stepped_error
from contact.exceptions import ConvergenceError
from contact.law.normal import load
from contact.problem import largest_resonance
from contact.stepping.along_track import steps_along
from contact.stepping.time_stepping import steps

# Fixed time steps. Numbers of steps per cycle, and the smallest tolerance for which each was seen to be fine enough.
STEPS = ((24, 2e-3), (32, 4e-4), (56, 4e-5), (80, 1e-5), (128, 1.5e-6), (192, 2e-7), (256, 0.0))
# largest omega_n dt (contact resonance times step)
MAX_STEP = 0.2
# largest relative change of velocity in one step by the contact damper
MAX_DAMPING = 5e-3

# A burst of more than EXACT_CYCLES in fixed steps, without envelope and track, is computed once. From its states at
# STEPPED_PARTS of its length the event-driven method at the level CHECK (nodes, truncation, longest segment over the
# problem's) follows it over PART_PERIODS / 2 pi periods of the contact resonance, but PART_CYCLES (least, most). The
# errors of a cycle there are added over the burst and enlarged by STEPPED_FACTOR; without it the true error was up to
# 1.46 times that (`tests/benchmarks/stepped_error.py`, `--parts`).
CHECK = (10, 1e-7, 0.8)
STEPPED_PARTS, PART_PERIODS, PART_CYCLES, STEPPED_FACTOR = (0.0, 0.25, 0.5, 1.0), 3.0, (256, 1500), 1.5
# A level of so many times the coarsest one's steps is chosen by the errors from the states of a run at the coarsest.
COARSE_SHARE = 3

# Errors of the fixed time steps are calibrated by the exact method in this many first cycles.
WINDOW = 1000


def stepped_burst(burst):
    """Run fixed time steps, refined until the estimated error is within the tolerance."""
    checked = steps_checked_in_parts(burst)
    if checked is not None:
        return checked
    window = Window.of(burst)

    def follow(level):
        return _every_step(burst, level)

    def levels_error(level, difference, reference):
        return stepped_error(difference, STEPS[level][0], STEPS[level - 1][0], STEPS[level][1] * reference)

    def in_window(level):
        coarse, fine = (_every_step(window.burst, k)[2][:, Recorded.VELOCITY] for k in (level - 1, level))
        return fine, levels_error(level, float(np.max(np.abs(fine - coarse))), 0.0)

    def error(level, run, difference, reference):
        estimate = levels_error(level, difference, reference)
        # without motion of the surface along x, and with the slider at rest, there is no error to state
        # under an envelope or along a track the first cycles of the burst are not those of the check
        same = burst.envelope is None and burst.track is None
        least = LEAST_SHARE if same and level > 1 else 1.0
        return window.error(estimate, lambda: in_window(level), least) if reference > 0.0 else 0.0

    small = [k for k, (number, _) in enumerate(STEPS) if not stepped_refusals(burst.slider, burst.problem, number)]
    # the coarsest level with small enough steps is run for comparison only
    level, (_, motion, record, *way), result = refined(burst, follow, error, STEPS, small[1])
    every = burst.compared_per_returned_sample
    way = [each._replace(displacement=each.displacement[every - 1 :: every]) for each in way]
    return result._replace(run=(motion, record[every - 1 :: every], *way), statistics=_statistics(burst, level))


def stepped_refusals(slider, problem, per_cycle) -> tuple[str, ...]:
    """Return the reasons why fixed time steps cannot follow this motion; empty if they can."""
    why: tuple[str, ...] = ()
    if slider.stick_band > 0.0:
        why += ("slider.stick_band needs the events",)
    if slider.law != "elastic" or slider.reciprocal:
        why += ("it knows the elastic law without its reciprocal force only",)
    if slider.slope_unit == 0.0:
        why += ("there is no friction",)
    step = 2.0 * math.pi / per_cycle
    turn = step * largest_resonance(problem)
    if turn > MAX_STEP:
        why += (
            f"the contact resonance is too fast: omega_n dt = {turn:.3g} with {per_cycle} steps "
            f"per cycle, more than {MAX_STEP}",
        )
    # the Hunt-Crossley force depends on the approach rate, which the scheme resolves to first order in the step only
    stiffness = problem.stiffness * float(problem.factors.stiffness.max())
    if step * problem.contact_damping * stiffness * load(2.0, problem.normal) > MAX_DAMPING:
        why += (f"the contact's damper is too fast for {per_cycle} steps per cycle",)
    if step * max(problem.normal_damping, problem.tangential_damping) > MAX_STEP:
        why += (f"the dampers are too fast for {per_cycle} steps per cycle",)
    return why


def _statistics(burst, level):
    """Return the statistics of a run with the fixed time steps of a level of `STEPS`."""
    return {
        "steps_per_cycle": STEPS[level][0], "cycles": burst.cycles,
        "omega_n_dt": largest_resonance(burst.problem) * 2.0 * math.pi / STEPS[level][0],
    }  # fmt: skip


def steps_checked_in_parts(burst: Burst) -> Result | None:
    """Return the result of one run in fixed steps whose errors the event-driven method sees in parts of the burst.

    None if it is not a burst for this (`STEPPED_PARTS`), or if the event-driven method fails. The run at the finest
    level is returned whatever its error.
    """
    if burst.cycles <= EXACT_CYCLES or burst.envelope is not None or burst.track is not None:
        return None
    small = [k for k, (number, _) in enumerate(STEPS) if not stepped_refusals(burst.slider, burst.problem, number)]
    levels = [k for k in small[1:] if STEPS[k][1] <= burst.tolerance] or small[-1:]
    part = int(np.clip(PART_PERIODS / largest_resonance(burst.problem), *PART_CYCLES))
    growth = STEPPED_FACTOR * burst.cycles / (part * len(STEPPED_PARTS))  # from the sum of errors to that of the burst
    begun = rest(burst.slider, burst.orbits, burst.problem, nodes=16, truncation=1e-12).state
    fastest = burst.orbits.peak_speed / burst.problem.speed
    try:
        first, others = _Part.of(burst, begun, part), []
        if STEPS[levels[0]][0] >= COARSE_SHARE * STEPS[small[0]][0]:
            motion, _, states = _steps_with_states(burst, small[0], part)
            fastest = float(motion.state[At.VELOCITY])
            others = [_Part.of(burst, state, part) for state in states]
        for level in levels:
            at_first = first.error(burst, level)
            expected = at_first + sum(other.error(burst, level) for other in others)
            if growth * expected > burst.allowed(fastest) and level != levels[-1]:
                continue  # no need to run the whole burst
            motion, record, states = _steps_with_states(burst, level, part)
            others = [_Part.of(burst, state, part) for state in states]
            velocity = fastest = float(motion.state[At.VELOCITY])
            reference = burst.reference(velocity)
            error = growth * (at_first + sum(other.error(burst, level) for other in others))
            error += FLOOR * STEPS[level][1] * reference
            if error <= burst.allowed(velocity) or level == levels[-1]:
                break
    except ConvergenceError:
        return None
    error = error if reference > 0.0 else 0.0  # no motion along x at all
    return Result((motion, record), error, burst.allowed(velocity), _statistics(burst, level))


def _steps_with_states(burst, level, part):
    """Return (motion, record, states) of one run in fixed steps; states where the parts after the first begin."""
    motion = rest(burst.slider, burst.orbits, burst.problem, nodes=16, truncation=1e-12)
    starts = [int(share * (burst.cycles - part)) // burst.stride * burst.stride for share in STEPPED_PARTS[1:]]
    records, states, done = [], [], 0
    for stop in (*starts, burst.cycles):
        records.append(steps(burst.problem, motion.state, stop - done, STEPS[level][0], stride=burst.stride))
        states.append(motion.state.copy())
        done = stop
    return motion, np.concatenate(records), states[:-1]


class _Part(NamedTuple):
    """A part of a burst: its first state, and the velocities at the ends of its cycles by the event-driven method."""

    state: np.ndarray
    velocities: np.ndarray

    @classmethod
    def of(cls, burst, state, cycles):
        """Return the part that follows a state."""
        nodes, truncation, longest = CHECK
        problem = burst.problem._replace(longest=longest * burst.problem.longest)
        exact = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
        exact.set_state(*state[: At.DEFORMATIONS], state[At.DEFORMATIONS :])
        return cls(state, exact.turn(cycles, stride=1)[:, Recorded.VELOCITY])

    def error(self, burst, level):
        """Return the largest difference of the velocity in fixed steps from the event-driven one, scaled."""
        number, cycles = STEPS[level][0], self.velocities.size
        found = steps(burst.problem, self.state.copy(), cycles, number, stride=1)[:, Recorded.VELOCITY]
        return float(np.max(np.abs(found - self.velocities)))


def _every_step(burst, level):
    """Return (velocities to compare, motion, record) of one run with the fixed time steps of a level of `STEPS`.

    On a track the motion along it follows, `Followed`.
    """
    factor = complex(burst.envelope.at(np.zeros(1))[0]) if burst.envelope is not None else 1.0
    motion = rest(burst.slider, burst.orbits, burst.problem, nodes=16, truncation=1e-12, factor=factor)
    number, stride = STEPS[level][0], burst.cycles_per_compared_sample
    if burst.track is not None:
        way = steps_along(
            burst.problem, motion.state, burst.track, burst.cycles, number, stride=stride, envelope=burst.envelope
        )
        return np.append(way.record[:, Recorded.VELOCITY], motion.state[At.VELOCITY]), motion, way.record, way
    record = steps(burst.problem, motion.state, burst.cycles, number, stride=stride, envelope=burst.envelope)
    return compared_velocities(record, motion.state), motion, record


class Window(NamedTuple):
    """The first cycles of a burst, computed by the exact method to measure the error of fixed time steps.

    If the burst has an envelope, the wave in the window has the envelope's largest amplitude throughout. On a track the
    slider remains in its first place in the window.
    """

    burst: Burst
    velocities: np.ndarray | None  # None if the exact method failed
    exact_error: float
    whole: bool  # True if the window is the whole burst, without an envelope

    @classmethod
    def of(cls, burst: Burst) -> "Window":
        """Return the window of a burst."""
        size = burst.envelope.largest(burst.duration) if burst.envelope is not None else 1.0
        cycles = burst.cycles if burst.cycles <= EXACT_CYCLES else WINDOW
        problem = burst.problem._replace(paths=times(burst.problem.paths, size))
        short = burst._replace(problem=problem, cycles=cycles, stride=cycles, envelope=None, track=None)
        whole = cycles == burst.cycles and burst.envelope is None and burst.track is None
        try:
            if exact_refusals(short):
                return cls(short, None, math.inf, whole)
            runs = [every_event(short, *ORDERS[k][:3])[2][:, Recorded.VELOCITY] for k in ((1, 2) if whole else (2,))]
        except ConvergenceError:
            return cls(short, None, math.inf, whole)
        return cls(short, runs[-1], float(np.max(np.abs(runs[-1] - runs[0]))), whole)

    def error(self, estimate: float, in_window: Callable, least: float) -> float:
        """Return the error of a method's velocity in the burst.

        It is the largest one after any cycle where the window is the whole burst. `estimate` is the method's own.
        `in_window()` returns the method's velocities in the window and its estimate for them. `least` as for
        `calibrated_error`.
        """
        if self.velocities is None:
            return calibrated_error(estimate, None, 0.0)
        velocities, stated = in_window()
        if self.whole:
            return float(np.max(np.abs(velocities - self.velocities))) + self.exact_error
        return calibrated_error(estimate, float(np.max(np.abs(velocities - self.velocities))), stated, least=least)
