r"""Three ways through a burst, one model: every event, fixed steps, many cycles at once.

Each takes a slider at rest at phase 0 and returns its motion at the end, rows (v, z_s) on the way, the estimated error
of the last v and what it counted; each refuses where it does not apply. The errors come from two runs really made.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from contact.averaged.event_cycle import opposed
from contact.averaged.run import averaged_run, refusals
from contact.body import Paths
from contact.choice import Choice, Method, Result, choose, refused
from contact.convergence_error import ConvergenceError
from contact.drive import reference_speed
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.events.segment import At, Column
from contact.law.normal import load
from contact.orbit import Orbit
from contact.problem import Problem, largest_resonance, scaled, without_wave
from contact.slider import Slider
from contact.stepping.time_stepping import steps

# largest number of cycles for which `auto` follows every event, whatever the tolerance
EXACT_CYCLES = 3000
# of the velocity, per cycle that is followed exactly
ROUNDING = 1e-15
# largest number of cycles for which the exact method takes over from one that misses the tolerance; some ten seconds
MAX_EXACT_CYCLES = 100_000
# cycles of a longer burst in which the errors of the other methods are calibrated
WINDOW = 1000
# factors on that calibration, on an estimate beyond the window, and on the error of a run that cannot be calibrated
CALIBRATION, BEYOND, UNCHECKED = 2.0, 1.5, 5.0
# segments that the exact method takes on at most, some minutes
MAX_SEGMENTS = 1e8
# steps per cycle that are tried, and the tolerance down to which each has been seen to serve
STEPS = ((24, 2e-3), (32, 4e-4), (56, 4e-5), (80, 1e-5), (128, 1.5e-6), (192, 2e-7), (256, 0.0))
# Order in the step size that is counted on. Spheres converge with 1.5 to 2, punches and contact dampers with 1, and
# either may do so more slowly between two neighbouring step sizes.
ORDER = 1.0
# instants in the second half of a burst at which two runs are compared
COMPARED = 24
# added to every estimate of fixed steps: this share of the tolerance for which the step size serves (`STEPS`), so that
# two runs that agree by chance do not claim a vanishing error
FLOOR = 0.01
# Nodes per segment, truncation of a segment, its longest length over that of the problem, and the tolerance down to
# which each serves. Neighbours differ in all three: where events set the segments' lengths the truncation changes
# nothing, and where the forces are polynomials (a punch) the nodes do not either.
ORDERS = ((8, 1e-5, 0.8, math.inf), (10, 1e-7, 1.0, 1e-8), (12, 1e-9, 0.8, 1e-10), (16, 1e-12, 1.0, 0.0))
# amplitude over the envelope's largest below which a surface that rings down stands still; least steps per cycle there
SPENT, RINGING_STEPS = 1e-3, 80
# change of the contact's own oscillation in a step, omega_n dt, above which fixed steps are refused
MAX_STEP = 0.2
# share of its velocity that the contact's damper may take in a step
MAX_DAMPING = 5e-3


def rest_problem(slider, orbits):
    """Return the scaled problem whose phase 0 is where u_z of the first contact passes zero upwards."""
    start = -0.5 * math.pi - float(np.angle(orbits[0].normal))
    return scaled(slider, orbits, direction=opposed(slider, orbits), start=start)


def rest(slider, orbits, problem, *, nodes, truncation, factor=1.0):
    """Return the motion at phase 0 of a slider at rest, its contacts deformed by the load alone.

    `factor` is that on the wave at phase 0, the envelope's first: a contact that the wave has not parted keeps its
    deformation.
    """
    contacts = len(orbits)
    begun = problem._replace(paths=_times(problem.paths, factor))
    motion = Motion(begun, grid=collocation(nodes), truncation=truncation)
    depth = slider.rest_approach(contacts) / problem.length
    x = slider.rest_deformations(contacts) / problem.length
    motion.place(-depth, 0.0, 0.0, math.copysign(1.0, problem.load) * x)
    motion.problem = problem
    return motion


def _times(paths, factor):
    """Return the paths of a wave times a complex factor."""
    normal = factor * (paths.normal_cos - 1j * paths.normal_sin)
    tangential = factor * (paths.tangential_cos - 1j * paths.tangential_sin)
    return Paths(paths.height, normal.real.copy(), -normal.imag, tangential.real.copy(), -tangential.imag)


def silence(motion):
    """Return the motion that goes on where this one stands, at phase 0, when the wave stops."""
    still = motion.copy()
    still.problem = without_wave(motion.problem)
    still.place(*motion.state[:3], motion.state[3:])
    still.begin()
    return still


def shaped_steps(slider, problem, least: int) -> int:
    """Return the fewest steps per cycle, a number of `STEPS` or the least, in which an envelope can be followed."""
    for number in (least, *(number for number, _ in STEPS if number > least)):
        reasons = stepped_refusals(slider, problem, number)
        if not reasons:
            return number
    raise refused("an envelope", {"stepped": reasons}, ENVELOPE_OUT)


def ring_down(slider, motion, envelope, *, longest=math.inf, samples=0, least=RINGING_STEPS):
    """Move the slider in fixed steps while the surface rings down.

    Returns (times in s from the end of the burst, rows), about as many as `samples`, one per cycle for 0.
    """
    frequency = motion.problem.omega / (2.0 * math.pi)
    number = shaped_steps(slider, motion.problem, least)
    loud = np.flatnonzero(envelope.amplitude > SPENT * np.max(envelope.amplitude))
    until = min(float(envelope.time[loud[-1]]) if loud.size else 0.0, longest)
    cycles = max(0, math.ceil(until * frequency))
    stride = max(1, cycles // samples) if samples else 1
    cycles -= cycles % stride
    shape = envelope.at(np.arange(cycles + 1) / frequency)
    rows = steps(motion.problem, motion.state, cycles, number, stride=stride, envelope=shape)
    return stride * np.arange(1, len(rows) + 1) / frequency, rows


ENVELOPE_OUT = (
    "leave the envelope out, or give the elastic law without reciprocal force and stick band, and more mass"
)


class Burst(NamedTuple):
    """A burst to follow from rest; a row every `stride` cycles, `envelope` as in `time_stepping.steps`."""

    slider: Slider
    orbits: tuple[Orbit, ...]
    problem: Problem
    cycles: int
    stride: int
    tolerance: float
    envelope: np.ndarray

    @property
    def inner(self) -> int:
        """Cycles between the rows that are compared: a divisor of `stride`."""
        return _divisor(self.stride, max(1, self.cycles // (2 * COMPARED)))

    @property
    def every(self) -> int:
        """Compared rows from one reported row to the next."""
        return self.stride // self.inner

    def allowed(self, velocity: float) -> float:
        """Return the error allowed in a velocity, scaled."""
        return self.tolerance * self.reference(velocity)

    def reference(self, velocity: float = 0.0) -> float:
        """Return the reference speed of a velocity; both scaled."""
        return reference_speed(velocity * self.problem.speed, self.orbits) / self.problem.speed


def _exact(burst):
    """Follow every event at two orders; where they do not agree to the tolerance, at the next."""

    def follow(level):
        return _every_event(burst, *ORDERS[level][:3])

    def error(level, run, difference, reference):
        # two runs may agree by chance, but not so much better than their segments are laid out
        return max(difference, 3e-6 * ORDERS[level][1] * reference) + ROUNDING * burst.cycles * reference

    for least in range(1, len(ORDERS)):
        try:
            _, (_, motion, rows), result = _refined(burst, follow, error, ORDERS, least)
            break
        except ConvergenceError:  # with few nodes events may follow each other without end
            if least == len(ORDERS) - 1:
                raise
    return result._replace(run=(motion, rows[burst.every - 1 :: burst.every]), statistics=motion.events())


def _every_event(burst, nodes, truncation, longest):
    """Return (velocities to compare, motion, rows) of an event-driven run."""
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    motion = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    motion.begin()
    rows = motion.turn(burst.cycles, stride=burst.inner)
    motion.problem = burst.problem
    return _compared(rows, motion.state), motion, rows


def _compared(rows, state):
    """Return the velocities in the second half of a burst and at its end."""
    return np.append(rows[len(rows) // 2 :, Column.VELOCITY], state[At.VELOCITY])


def _exact_refusals(burst):
    reasons = ("it takes no envelope",) if burst.envelope.size else ()
    if burst.cycles * burst.problem.segments > MAX_SEGMENTS:
        reasons += (
            f"{burst.cycles} cycles of at least {burst.problem.segments:.3g} segments of the motion are too many "
            "(shorten the burst, raise the mass or lower the dampers)",
        )
    return reasons


def _stepped(burst):
    """Refine the steps until the error keeps the tolerance."""
    start = _at_rest(burst)
    window = Window.of(burst)

    def gain(level):
        return (STEPS[level][0] / STEPS[level - 1][0]) ** ORDER - 1.0

    def follow(level):
        state = start.state.copy()
        rows = steps(
            burst.problem, state, burst.cycles, STEPS[level][0], stride=burst.inner, envelope=burst.envelope
        )
        return _compared(rows, state), state, rows

    def in_window(level):
        coarse, fine = (
            steps(window.burst.problem, _at_rest(window.burst).state.copy(), window.burst.cycles, STEPS[k][0],
                  stride=window.burst.inner)[:, Column.VELOCITY]
            for k in (level - 1, level)
        )  # fmt: skip
        return fine, float(np.max(np.abs(fine - coarse))) / gain(level)

    def error(level, run, difference, reference):
        # events fall anywhere in a step: one difference may vanish by chance, the largest of many does not
        estimate = difference / gain(level) + FLOOR * STEPS[level][1] * reference
        return window.error(estimate, run[0][-1], lambda: in_window(level)) if reference > 0.0 else 0.0

    level, (_, state, rows), result = _refined(burst, follow, error, STEPS, _serving_steps(burst)[1])
    start.state[:] = state
    statistics = {
        "steps_per_cycle": STEPS[level][0], "cycles": burst.cycles,
        "omega_n_dt": largest_resonance(burst.problem) * 2.0 * math.pi / STEPS[level][0],
    }  # fmt: skip
    return result._replace(run=(start, rows[burst.every - 1 :: burst.every]), statistics=statistics)


def _serving_steps(burst):
    """Return the levels of `STEPS` that are fine enough for the slider."""
    return [
        k for k, (number, *_) in enumerate(STEPS) if not stepped_refusals(burst.slider, burst.problem, number)
    ]


def _at_rest(burst):
    """Return the motion at the beginning of a burst."""
    factor = burst.envelope[0] if burst.envelope.size else 1.0
    return rest(burst.slider, burst.orbits, burst.problem, nodes=16, truncation=1e-12, factor=factor)


def _divisor(number, most):
    """Return the largest divisor of a number that is at most `most`."""
    return next(d for d in range(min(number, most), 0, -1) if number % d == 0)


def _averaged(burst):
    """Follow the averaged equations."""
    window = Window.of(burst)

    def follow(asked):
        return averaged_run(
            asked, rest(asked.slider, asked.orbits, asked.problem, nodes=14, truncation=1e-11)
        )

    def in_window():
        _, rows, error, _ = follow(window.burst._replace(stride=window.burst.inner))
        return rows[:, Column.VELOCITY], error

    motion, rows, error, statistics = follow(burst)
    velocity = float(motion.state[At.VELOCITY])
    return Result(
        (motion, rows), window.error(error, velocity, in_window), burst.allowed(velocity), statistics
    )


def _averaged_refusals(burst):
    reasons = refusals(burst.slider, burst.orbits)
    if burst.envelope.size:
        reasons += ("it takes no envelope",)
    return (*reasons, f"{burst.cycles} cycles are too few") if burst.cycles < 3 else reasons


class Window(NamedTuple):
    """The first cycles of a burst, followed exactly: what the error of another method is there.

    Under an envelope the wave is taken at its largest size throughout.
    """

    burst: Burst
    velocities: np.ndarray | None  # None where they could not be followed
    exact_error: float
    whole: bool  # whether the window is the burst

    @classmethod
    def of(cls, burst: Burst) -> "Window":
        """Return the window of a burst."""
        size = float(np.max(np.abs(burst.envelope))) if burst.envelope.size else 1.0
        cycles = burst.cycles if burst.cycles <= EXACT_CYCLES else WINDOW
        problem = burst.problem._replace(paths=_times(burst.problem.paths, size))
        short = burst._replace(problem=problem, cycles=cycles, stride=cycles, envelope=np.empty(0, complex))
        whole = cycles == burst.cycles and not burst.envelope.size
        try:
            if _exact_refusals(short):
                return cls(short, None, math.inf, whole)
            runs = [
                _every_event(short, *ORDERS[k][:3])[2][:, Column.VELOCITY]
                for k in ((1, 2) if whole else (2,))
            ]
        except ConvergenceError:
            return cls(short, None, math.inf, whole)
        return cls(short, runs[-1], float(abs(runs[-1][-1] - runs[0][-1])), whole)

    def error(self, estimate: float, velocity: float, in_window: Callable) -> float:
        """Return the error of a velocity at the burst's end, of which a method states an estimate.

        `in_window()` returns the velocities in the window by the same method, and the error that it states for them.
        The estimate is taken as many times larger as it is too small there.
        """
        if self.velocities is None:
            return UNCHECKED * estimate
        if self.whole:
            return abs(velocity - float(self.velocities[-1])) + self.exact_error
        velocities, stated = in_window()
        true = float(np.max(np.abs(velocities - self.velocities)))
        return max(BEYOND * estimate * max(1.0, CALIBRATION * true / (stated + 1e-300)), true)


def _refined(burst, follow, error, levels, least):
    """Return (level, run, result) of the first level of resolution whose estimated error keeps the tolerance.

    The error is estimated from the difference to the run of the level before. Of the last level the run is returned
    whatever its error.

    Parameters
    ----------
    follow : callable
        Level to run: a tuple whose first entry holds the velocities to compare, the one at the end last.
    error : callable
        (level, run, largest difference of these velocities, reference speed) to the estimated error; scaled.
    levels : tuple of tuple
        Resolutions from coarse to fine, such as `STEPS`; the last entry of each is the tolerance down to which it
        serves. The first that serves, but at least number `least`, is run first.
    """
    serving = (k for k, (*_, down_to) in enumerate(levels) if burst.tolerance >= down_to)
    level = max(next(serving, len(levels) - 1), least)
    coarse, fine = _both(follow, level - 1, level)
    while True:
        velocity = float(fine[0][-1])
        estimate = error(level, fine, float(np.max(np.abs(fine[0] - coarse[0]))), burst.reference(velocity))
        if estimate <= burst.allowed(velocity) or level == len(levels) - 1:
            return level, fine, Result(None, estimate, burst.allowed(velocity), {})
        level += 1
        coarse, fine = fine, follow(level)


def _both(work, first, second):
    """Return work(first) and work(second), from two threads: kernels release the interpreter's lock."""
    if os.environ.get("SAWMOTOR_THREADS") == "1":
        return work(first), work(second)
    with ThreadPoolExecutor(1) as aside:
        job = aside.submit(work, first)
        result = work(second)
        return job.result(), result


# The cheapest comes first. Error of averaging: half the steps and fewer nodes, first against second order; of stepping:
# two step sizes; both calibrated by the exact method. Of the exact method: two collocation orders, rounding per cycle.
BURST_METHODS = {
    "averaged": Method(_averaged, _averaged_refusals),
    "stepped": Method(_stepped, lambda burst: stepped_refusals(burst.slider, burst.problem, STEPS[-2][0])),
    "exact": Method(_exact, _exact_refusals),
}
METHODS = ("auto", *BURST_METHODS)


def run(method: str, burst: Burst) -> Choice:
    """Return the run (motion at the end, rows) of a burst, its error and the method used.

    Up to `EXACT_CYCLES` cycles "auto" follows every event. The exact method leaves the energies in the motion's sums.
    """
    if method == "auto" and burst.cycles <= EXACT_CYCLES and not _exact_refusals(burst):
        method = "exact"
    way = "leave the envelope out and use method exact" if burst.envelope.size else "shorten the burst"
    return choose(
        BURST_METHODS, burst, method, what="a burst", exact=burst.cycles <= MAX_EXACT_CYCLES, way=way
    )


def stepped_refusals(slider, problem, per_cycle) -> tuple[str, ...]:
    """Return why fixed steps cannot follow this motion; nothing where they can."""
    why: tuple[str, ...] = ()
    if slider.stick_band > 0.0:
        why += ("slider.stick_band needs the events",)
    if slider.law != "elastic" or slider.reciprocal:
        why += ("it knows the elastic law without its reciprocal force only",)
    if slider.limit_slope == 0.0:
        why += ("there is no friction",)
    step = 2.0 * math.pi / per_cycle
    turn = step * largest_resonance(problem)
    if turn > MAX_STEP:
        why += (
            f"the contact resonance is too fast: omega_n dt = {turn:.3g} with {per_cycle} steps "
            f"per cycle, more than {MAX_STEP}",
        )
    # Hunt-Crossley's force enters by the rate, to first order in the step
    if step * problem.contact_damping * problem.stiffness * load(2.0, problem.shape) > MAX_DAMPING:
        why += (f"the contact's damper is too fast for {per_cycle} steps per cycle",)
    if step * max(problem.normal_damping, problem.tangential_damping) > MAX_STEP:
        why += (f"the dampers are too fast for {per_cycle} steps per cycle",)
    return why
