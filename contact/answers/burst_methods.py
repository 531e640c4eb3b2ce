r"""Three methods to compute the motion during a burst: event-driven, fixed time steps and averaged.

Each method starts from a slider at rest at phase 0. It returns the motion at the end of the burst, its record (v, z_s),
the error of the last v (`error_estimate`) and statistics. A method refuses a problem to which it does not apply.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from contact.averaged.burst import COMPARED, averaged_run, refusals
from contact.averaged.event_equilibrium import opposed
from contact.body import Paths
from contact.choice import Choice, Method, Result, choose, refused
from contact.codes import At, Recorded
from contact.envelope import Envelope
from contact.error_estimate import (
    FLOOR,
    LEAST_SHARE,
    averaged_burst_error,
    calibrated_error,
    event_driven_error,
    held_orbits_error,
    reference_speed,
    stepped_error,
)
from contact.events.collocation import collocation
from contact.events.motion import Motion, rest_state
from contact.exceptions import ConvergenceError
from contact.law.normal import load
from contact.orbit import Orbits
from contact.problem import Problem, largest_resonance, scaled, without_wave
from contact.slider import Slider
from contact.stepping.along_track import Followed, Scaled, steps_along
from contact.stepping.time_stepping import steps

# Choice of the method. EXACT_CYCLES: method "auto" uses the event-driven method up to this number of cycles, whatever
# the tolerance. MAX_EXACT_CYCLES: if another method misses the tolerance, the exact method takes over up to this number
# (about 10 s).
EXACT_CYCLES = 3000
MAX_EXACT_CYCLES = 100_000

# Exact method. It refuses bursts of more segments than this (some minutes, at 2 to 4 us for one to three contacts).
MAX_SEGMENTS = 1e8
# Nodes per segment, truncation error of a segment, maximum segment length over that of the problem, and the smallest
# tolerance for which this level is fine enough. Neighbouring levels differ in all three, so that their difference shows
# the error: the truncation has no effect if events limit the segments, and the number of nodes has none if the forces
# are polynomials (a punch).
ORDERS = ((8, 1e-5, 0.8, math.inf), (10, 1e-7, 1.0, 1e-8), (12, 1e-9, 0.8, 1e-10), (16, 1e-12, 1.0, 0.0))

# A burst of at least SPOT_CYCLES cycles is computed once at the level ANSWER and again at the level CHECK, which
# differs in all three, over PARTS of it (start and end over its length), the later ones from states of the answer.
# Tolerances below SPOT_TOLERANCE take two whole runs. SPOT_FACTOR: stated error over that of the parts, which see
# neither all cycles nor how a motion of little damping enlarges an error. In 174 draws the true error was up to 1.5
# times that without the factor (`tests/benchmarks/spot_checks.py`).
ANSWER, CHECK = (8, 1e-6, 1.0), (10, 1e-7, 0.8)
SPOT_CYCLES, SPOT_TOLERANCE, SPOT_FACTOR = 64, 1e-8, 3.0
PARTS = (0.0, 1 / 10), (1 / 2, 21 / 40), (39 / 40, 1.0)

# A burst of more than EXACT_CYCLES in fixed steps, without envelope and track, is computed once. From its states at
# STEPPED_PARTS of its length the event-driven method at the level CHECK follows it over PART_PERIODS / 2 pi periods of
# the contact resonance, but PART_CYCLES (least, most). The errors of a cycle there are added over the burst and
# enlarged by STEPPED_FACTOR; without it the true error was up to 1.46 times that (`tests/benchmarks/stepped_error.py`,
# `--parts`).
STEPPED_PARTS, PART_PERIODS, PART_CYCLES, STEPPED_FACTOR = (0.0, 0.25, 0.5, 1.0), 3.0, (256, 1500), 1.5
# A level of so many times the coarsest one's steps is chosen by the errors from the states of a run at the coarsest.
COARSE_SHARE = 3

# Fixed time steps. Numbers of steps per cycle, and the smallest tolerance for which each was seen to be fine enough.
STEPS = ((24, 2e-3), (32, 4e-4), (56, 4e-5), (80, 1e-5), (128, 1.5e-6), (192, 2e-7), (256, 0.0))
# largest omega_n dt (contact resonance times step)
MAX_STEP = 0.2
# largest relative change of velocity in one step by the contact damper
MAX_DAMPING = 5e-3
ENVELOPE_OUT = "leave the envelope out, or give the elastic law without reciprocal force and stick band, and more mass"
# SPENT: a ring-down ends when the amplitude is below this fraction of the envelope's maximum. A wave that is cut there
# shifts the final position, by up to 4.2 times its amplitude (`error_estimate.CUT`).
# RINGING_STEPS: minimum number of steps per cycle during the ring-down.
SPENT, RINGING_STEPS = 1e-7, 80

# Errors are calibrated by the exact method in this many first cycles: those of the fixed time steps, and those of the
# averaged method. Where averaging fails it fails in the first cycles too: 24 to 256 of them find no more
# (`tests/benchmarks/averaging_error.py`, `--checked`).
WINDOW, CHECKED = 1000, 16


def rest_problem(slider, orbits):
    """Return the scaled problem; at phase 0 u_z of the first contact crosses zero upwards."""
    return scaled(slider, orbits, direction=opposed(slider, orbits), start=orbits[0].upward_zero)


def rest(slider, orbits, problem, *, nodes, truncation, factor=1.0):
    """Return the motion at phase 0 of a slider at rest whose contacts are deformed by the load alone.

    `factor` is the envelope's value at phase 0. The wave of that size decides which contacts touch at the start: a
    contact that touches keeps its deformation. A contact with memory is deformed on the surface at rest, before the
    wave displaces the surface.
    """
    begun, state = problem._replace(paths=_times(problem.paths, factor)), rest_state(slider, problem)
    motion = Motion(without_wave(problem), grid=collocation(nodes), truncation=truncation)
    for surface in (begun,) if motion.memory is None else (motion.problem, begun):
        motion.set_state(*state[: At.DEFORMATIONS], state[At.DEFORMATIONS :], problem=surface)
    motion.problem = problem
    return motion


def _times(paths, factor):
    """Return the paths of a wave times a complex factor."""
    normal = factor * (paths.normal_cos - 1j * paths.normal_sin)
    tangential = factor * (paths.tangential_cos - 1j * paths.tangential_sin)
    return Paths(paths.height, normal.real.copy(), -normal.imag, tangential.real.copy(), -tangential.imag)


def silence(motion):
    """Return a copy of the motion that continues from the state at phase 0 without the wave."""
    still = motion.copy()
    still.set_state(*motion.state[:3], motion.state[3:], problem=without_wave(motion.problem))
    still.begin()
    return still


def shaped_steps(slider, problem, least: int) -> int:
    """Return the smallest number of steps per cycle, from `least` and `STEPS`, that can follow an envelope."""
    for number in (least, *(number for number, _ in STEPS if number > least)):
        reasons = stepped_refusals(slider, problem, number)
        if not reasons:
            return number
    raise refused("an envelope", {"stepped": reasons}, ENVELOPE_OUT)


def ring_down(slider, motion, envelope, *, longest=math.inf, samples=0, least=RINGING_STEPS, track=None, start=0.0):
    """Move the slider in fixed time steps while the surface rings down.

    Returns (times in s from the end of the burst, record) of about `samples` samples, or one per cycle if it is 0; with
    a `track` (`Scaled`) on which the slider is displaced by `start` at first, also the motion along it (`Followed`).
    """
    frequency = motion.problem.omega / (2.0 * math.pi)
    number = shaped_steps(slider, motion.problem, least)
    cycles = max(0, math.ceil(min(spent(envelope), longest) * frequency))
    stride = max(1, cycles // samples) if samples else 1
    cycles -= cycles % stride
    if track is not None:
        way = steps_along(
            motion.problem, motion.state, track, cycles, number, stride=stride, envelope=envelope, start=start
        )
        return stride * np.arange(1, len(way.record) + 1) / frequency, way.record, way
    record = steps(motion.problem, motion.state, cycles, number, stride=stride, envelope=envelope)
    return stride * np.arange(1, len(record) + 1) / frequency, record


def spent(envelope):
    """Return the time in s at which an envelope has fallen to SPENT of its maximum for good, or its last time."""
    level = SPENT * np.max(envelope.amplitude)
    loud = np.flatnonzero(envelope.amplitude > level)
    if loud.size == 0:
        return 0.0
    last = loud[-1]
    if last + 1 == envelope.time.size:
        return float(envelope.time[last])
    ends = envelope.amplitude[last + 1], envelope.amplitude[last]
    return float(np.interp(level, ends, (envelope.time[last + 1], envelope.time[last])))


class Burst(NamedTuple):
    """A burst from rest that returns a sample every `stride` cycles."""

    slider: Slider
    orbits: Orbits
    problem: Problem
    cycles: int
    stride: int
    tolerance: float
    envelope: Envelope | None
    track: Scaled | None = None  # None: the slider remains where it is

    @property
    def duration(self) -> float:
        """Length of the burst, s."""
        return 2.0 * math.pi * self.cycles / self.problem.omega

    @property
    def cycles_per_compared_sample(self) -> int:
        """Number of cycles between two compared samples, a divisor of `stride`."""
        return largest_divisor(self.stride, max(1, self.cycles // (2 * COMPARED)))

    @property
    def compared_per_returned_sample(self) -> int:
        """Number of compared samples for each returned one."""
        return self.stride // self.cycles_per_compared_sample

    def allowed(self, velocity: float) -> float:
        """Return the allowed error of a velocity, both scaled."""
        return self.tolerance * self.reference(velocity)

    def reference(self, velocity: float = 0.0) -> float:
        """Return the reference speed for a velocity, both scaled."""
        return reference_speed(velocity * self.problem.speed, self.orbits) / self.problem.speed


def _exact(burst):
    """Run the event-driven method at two levels of `ORDERS`, and at finer ones until the tolerance is met."""
    if burst.track is not None:
        return _exact_along(burst)
    spotted = spot_checked(burst)
    if spotted is not None:
        return spotted

    def follow(level):
        return _every_event(burst, *ORDERS[level][:3])

    def error(level, run, difference, reference):
        return event_driven_error(
            difference, truncation=ORDERS[level][1], reference=reference, cycles=burst.cycles,
            segments=burst.problem.segments, moves=np.any(run[0]),
        )  # fmt: skip

    for least in range(1, len(ORDERS)):
        try:
            _, (_, motion, record), result = _refined(burst, follow, error, ORDERS, least)
            break
        except ConvergenceError:  # with few nodes the solver may report events without end: try the next level
            if least == len(ORDERS) - 1:
                raise
    every = burst.compared_per_returned_sample
    return result._replace(run=(motion, record[every - 1 :: every]), statistics=motion.events())


def spot_checked(burst: Burst) -> Result | None:
    """Return the result of one event-driven run that is checked over a part of its cycles (`PARTS`).

    None if it misses the tolerance, or if the burst is not one for it. The errors of single cycles are added.
    """
    if burst.cycles < SPOT_CYCLES or burst.tolerance < SPOT_TOLERANCE:
        return None
    motion = _at_rest(burst, ANSWER)
    if motion.memory is not None:  # it is laid out for the nodes of one level
        return None
    parts = [[round(share * burst.cycles) for share in part] for part in PARTS]
    states, records, done = {0: motion.copy()}, [], 0
    try:
        for stop in sorted({burst.cycles, *(stop for part in parts for stop in part)} - {0}):
            records.append(motion.turn(stop - done, stride=1))  # so that samples do not change the motion
            states[stop], done = motion.copy(), stop
        errors = [
            _apart(burst, _at_rest(burst, CHECK) if start == 0 else _continued(burst, states[start], CHECK),
                   states[stop], stop - start)
            for start, stop in parts if stop > start
        ]  # fmt: skip
    except ConvergenceError:
        return None
    checked = sum(stop - start for start, stop in parts)
    record, velocity = np.concatenate(records), float(motion.state[At.VELOCITY])
    error = event_driven_error(
        SPOT_FACTOR * sum(errors) * burst.cycles / checked, truncation=ANSWER[1], reference=burst.reference(velocity),
        cycles=burst.cycles, segments=burst.problem.segments, moves=bool(np.any(record[:, Recorded.VELOCITY])),
    )  # fmt: skip
    if error > burst.allowed(velocity):
        return None
    motion.problem = burst.problem
    every = record[burst.stride - 1 :: burst.stride]
    return Result((motion, every), error, burst.allowed(velocity), motion.events())


def _apart(burst, motion, other, cycles):
    """Return the distance of a motion after some cycles from another, in velocity, scaled.

    Errors of height and deformations become some of the velocity within a period of the contact's resonance.
    """
    motion.turn(cycles)
    rate, change = largest_resonance(burst.problem), np.abs(motion.state - other.state)
    normal = change[At.NORMAL_VELOCITY] + rate * change[At.POSITION]
    along = change[At.VELOCITY] + rate * np.max(change[At.DEFORMATIONS :])
    return float(along + burst.problem.friction * normal)


def _at_rest(burst, level):
    """Return the motion at phase 0 of a slider at rest, for a run at a level such as those of `ORDERS`."""
    nodes, truncation, longest = level
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    motion = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    motion.begin()
    return motion


def _continued(burst, motion, level):
    """Return a motion that continues from a state at another level."""
    nodes, truncation, longest = level
    other = motion.copy()
    other.grid, other.truncation = collocation(nodes), truncation
    other.problem = burst.problem._replace(longest=longest * burst.problem.longest)
    return other


def _every_event(burst, *level):
    """Return (velocities to compare, motion, record) of one event-driven run."""
    motion = _at_rest(burst, level)
    record = motion.turn(burst.cycles, stride=burst.cycles_per_compared_sample)
    motion.problem = burst.problem
    return _compared(record, motion.state), motion, record


def _exact_along(burst):
    """Run the event-driven method on a track, the orbits constant for one cycle, and for two in a coarser run."""
    coarse, fine = (_events_along(burst, ORDERS[level], hold) for level, hold in ((1, 2), (2, 1)))
    velocity = float(fine[0][-1])
    error = event_driven_error(
        _difference(coarse[0], fine[0]), truncation=ORDERS[2][1], reference=burst.reference(velocity),
        cycles=burst.cycles, segments=burst.problem.segments, moves=np.any(fine[0]),
    )  # fmt: skip
    _, motion, record, followed, turned = fine
    error += held_orbits_error(turned, burst.reference(velocity))
    every = burst.compared_per_returned_sample
    followed = followed._replace(displacement=followed.displacement[every - 1 :: every])
    return Result((motion, record[every - 1 :: every], followed), error, burst.allowed(velocity), {})


def _events_along(burst, order, hold):
    """Return (velocities to compare, motion, record, `Followed`, change) of one event-driven run along a track.

    The orbits are those of the middle of each `hold` cycles. Where they change, a closed contact goes with its surface.
    `change`: largest of an amplitude from one to the next, over the largest amplitude.
    """
    nodes, truncation, longest, _ = order
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    motion = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    stride, (low, high) = burst.cycles_per_compared_sample, burst.track.limits
    record, passed, place, advance, cycle, turned = [], [], 0.0, 0.0, 0, 0.0
    while cycle < burst.cycles:
        many = min(hold, burst.cycles - cycle)
        if not low < place + many * advance < high:
            break
        u_x, u_z = burst.track.at(place + 0.5 * many * advance)
        paths = Paths(problem.paths.height, u_z.real.copy(), -u_z.imag, u_x.real.copy(), -u_x.imag)
        old = motion.problem.paths
        gone = paths.tangential_cos - old.tangential_cos
        changes = [np.abs(new - before) for new, before in zip(paths[1:], old[1:], strict=True)]
        turned = max(turned, float(np.max(changes)) / max(np.max(np.abs(u_x)), np.max(np.abs(u_z)), 1e-300))
        state = motion.state.copy()
        motion.set_state(
            *state[: At.DEFORMATIONS], state[At.DEFORMATIONS :] + gone, problem=problem._replace(paths=paths)
        )
        for row in motion.turn(many, stride=1):
            cycle, advance = cycle + 1, 2.0 * math.pi * row[Recorded.MEAN_VELOCITY]
            place += advance
            if cycle % stride == 0:
                record.append(row)
                passed.append(place)
    record = np.array(record).reshape(-1, len(Recorded))
    followed = Followed(record, np.array(passed), cycle, place, cycle < burst.cycles)
    motion.problem = burst.problem
    return np.append(record[:, Recorded.VELOCITY], motion.state[At.VELOCITY]), motion, record, followed, turned


def _difference(coarse, fine):
    """Return the largest difference of two runs' velocities in the second half of what both followed, and at the end.

    The last entry of each is that at the end, which is earlier where the slider came to an end of the track.
    """
    common = min(len(coarse), len(fine)) - 1
    apart = np.abs(coarse[:common] - fine[:common])[common // 2 :]
    return float(max(np.max(apart, initial=0.0), abs(coarse[-1] - fine[-1])))


def _compared(record, state):
    """Return the velocities in the second half of a burst and at its end."""
    return np.append(record[len(record) // 2 :, Recorded.VELOCITY], state[At.VELOCITY])


def _exact_refusals(burst):
    reasons = ("it takes no envelope",) if burst.envelope is not None else ()
    if burst.cycles * burst.problem.segments > MAX_SEGMENTS:
        reasons += (
            f"{burst.cycles} cycles of at least {burst.problem.segments:.3g} segments of the motion are too many "
            "(shorten the burst, raise the mass or lower the dampers)",
        )
    return reasons


def _stepped(burst):
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
        return window.error(estimate, run[0][-1], lambda: in_window(level), least) if reference > 0.0 else 0.0

    small = [k for k, (number, _) in enumerate(STEPS) if not stepped_refusals(burst.slider, burst.problem, number)]
    # the coarsest level with small enough steps is run for comparison only
    level, (_, motion, record, *way), result = _refined(burst, follow, error, STEPS, small[1])
    every = burst.compared_per_returned_sample
    way = [each._replace(displacement=each.displacement[every - 1 :: every]) for each in way]
    return result._replace(run=(motion, record[every - 1 :: every], *way), statistics=_statistics(burst, level))


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
    fastest, states = burst.orbits.peak_speed / burst.problem.speed, []
    try:
        if STEPS[levels[0]][0] >= COARSE_SHARE * STEPS[small[0]][0]:
            motion, _, states = _steps_with_states(burst, small[0], part)
            fastest = float(motion.state[At.VELOCITY])
        for level in levels:
            expected = sum(_error_in_part(burst, level, state, part) for state in (begun, *states))
            if growth * expected > burst.allowed(fastest) and level != levels[-1]:
                continue  # no need to run the whole burst
            motion, record, states = _steps_with_states(burst, level, part)
            errors = [_error_in_part(burst, level, state, part) for state in (begun, *states)]
            velocity = fastest = float(motion.state[At.VELOCITY])
            reference = burst.reference(velocity)
            error = growth * sum(errors) + FLOOR * STEPS[level][1] * reference
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


def _error_in_part(burst, level, state, cycles):
    """Return the largest difference of the velocity from the event-driven one over cycles from a state, scaled."""
    nodes, truncation, longest = CHECK
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    exact = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    exact.set_state(*state[: At.DEFORMATIONS], state[At.DEFORMATIONS :])
    true = exact.turn(cycles, stride=1)[:, Recorded.VELOCITY]
    found = steps(burst.problem, state.copy(), cycles, STEPS[level][0], stride=1)[:, Recorded.VELOCITY]
    return float(np.max(np.abs(found - true)))


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
    return _compared(record, motion.state), motion, record


def largest_divisor(number, most):
    """Return the largest divisor of a number that is at most `most`."""
    return next(d for d in range(min(number, most), 0, -1) if number % d == 0)


def _averaged(burst):
    """Integrate the averaged equations, checked by the exact method in the first cycles."""
    nodes, truncation, _, _ = ORDERS[0 if burst.tolerance >= 1e-5 else 1]
    motion = rest(burst.slider, burst.orbits, burst.problem, nodes=nodes, truncation=truncation)
    exact, true = motion.copy(), None
    motion, record, error, check, statistics = averaged_run(burst, motion, np.arange(2, CHECKED + 1))
    checked, velocities, stated = check
    try:
        first = exact.turn(int(checked[-1]), stride=1)[checked - 1, Recorded.VELOCITY]
        true = float(np.max(np.abs(velocities - first)))
    except ConvergenceError:  # the estimate remains without check
        pass
    error, velocity = averaged_burst_error(error, true, stated), float(motion.state[At.VELOCITY])
    return Result((motion, record), error, burst.allowed(velocity), statistics)


def _averaged_refusals(burst):
    reasons = refusals(burst.slider, burst.orbits)
    if burst.envelope is not None:
        reasons += ("it takes no envelope",)
    if burst.track is not None:
        reasons += ("it takes no track",)
    return (*reasons, f"{burst.cycles} cycles are too few") if burst.cycles < 3 else reasons


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
        problem = burst.problem._replace(paths=_times(burst.problem.paths, size))
        short = burst._replace(problem=problem, cycles=cycles, stride=cycles, envelope=None, track=None)
        whole = cycles == burst.cycles and burst.envelope is None and burst.track is None
        try:
            if _exact_refusals(short):
                return cls(short, None, math.inf, whole)
            runs = [_every_event(short, *ORDERS[k][:3])[2][:, Recorded.VELOCITY] for k in ((1, 2) if whole else (2,))]
        except ConvergenceError:
            return cls(short, None, math.inf, whole)
        return cls(short, runs[-1], float(abs(runs[-1][-1] - runs[0][-1])), whole)

    def error(self, estimate: float, velocity: float, in_window: Callable, least: float) -> float:
        """Return the error of a method's velocity at the end of the burst.

        `estimate` is the method's own estimate. `in_window()` returns the method's velocities in the window and its
        estimate for them. `least` as for `calibrated_error`.
        """
        if self.velocities is None:
            return calibrated_error(estimate, None, 0.0)
        if self.whole:
            return abs(velocity - float(self.velocities[-1])) + self.exact_error
        velocities, stated = in_window()
        return calibrated_error(estimate, float(np.max(np.abs(velocities - self.velocities))), stated, least=least)


def _refined(burst, follow, error, levels, least):
    """Return (level, run, result) of the first level of resolution whose estimated error is within the tolerance.

    The error is estimated from the difference to the run at the previous level. The run at the last level is returned
    whatever its error.

    Parameters
    ----------
    follow : callable
        Takes a level and returns the run, a tuple. Its first entry holds the velocities to compare; the last of these
        is the velocity at the end of the burst.
    error : callable
        Takes (level, run, largest difference of these velocities, reference speed) and returns the estimated error,
        all scaled.
    levels : tuple of tuple
        Resolutions from coarse to fine, such as `STEPS`. The last entry of each is the smallest tolerance for which
        it is fine enough.
    least : int
        The first level to run is the coarsest one that is fine enough for the tolerance, but not below this one.
    """
    serving = (k for k, (*_, down_to) in enumerate(levels) if burst.tolerance >= down_to)
    level = max(next(serving, len(levels) - 1), least)
    coarse, fine = _both(follow, level - 1, level)
    while True:
        velocity = float(fine[0][-1])
        apart = _difference if burst.track is not None else _largest_difference
        estimate = error(level, fine, apart(coarse[0], fine[0]), burst.reference(velocity))
        if estimate <= burst.allowed(velocity) or level == len(levels) - 1:
            return level, fine, Result((), estimate, burst.allowed(velocity), {})
        level += 1
        coarse, fine = fine, follow(level)


def _largest_difference(coarse, fine):
    return float(np.max(np.abs(fine - coarse)))


def _both(work, first, second):
    """Return work(first) and work(second), computed in two threads; the kernels release the interpreter lock."""
    if os.environ.get("SAWMOTOR_THREADS") == "1":
        return work(first), work(second)
    with ThreadPoolExecutor(1) as aside:
        job = aside.submit(work, first)
        result = work(second)
        return job.result(), result


# The cheapest method comes first.
BURST_METHODS = {
    "averaged": Method(_averaged, _averaged_refusals),
    "stepped": Method(_stepped, lambda burst: stepped_refusals(burst.slider, burst.problem, STEPS[-2][0])),
    "exact": Method(_exact, _exact_refusals),
}
METHODS = ("auto", *BURST_METHODS)


def run(method: str, burst: Burst) -> Choice:
    """Return the run (motion at the end, record) of a burst, its error and the method used.

    Method "auto" uses the exact method up to `EXACT_CYCLES` cycles; if it fails, and for longer bursts, the cheapest
    one within the tolerance. Only the exact method accumulates the energies in the motion's sums.
    """
    way = "leave the envelope out and use method exact" if burst.envelope is not None else "shorten the burst"
    fixed = burst.track is None  # along a track, fixed steps follow the orbits better than the events do
    return choose(
        BURST_METHODS, burst, method, what="a burst", exact=fixed and burst.cycles <= MAX_EXACT_CYCLES,
        exact_first=fixed and burst.cycles <= EXACT_CYCLES, way=way,
    )  # fmt: skip


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
