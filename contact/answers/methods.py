r"""Three ways through a burst, one model: every event, fixed steps, many cycles at once.

Each takes a slider at rest at phase 0 and returns its motion at the end, rows (v, z_s) on the way, the estimated error
of the last v and what it counted; each refuses where it does not apply. The errors come from two runs really made.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from contact.answers.averaged import averaged_run, why_not
from contact.convergence import ConvergenceError
from contact.drive import reference_speed
from contact.kinematics import Paths
from contact.law.normal import load
from contact.orbit import Orbit
from contact.problem import Problem, largest_resonance, scaled, without_wave
from contact.slider import Slider
from contact.solve.collocation import collocation
from contact.solve.equilibrium import opposed
from contact.solve.motion import Motion
from contact.solve.time_stepping import steps

# up to here "auto" follows every event, whatever the tolerance
EXACT_CYCLES = 3000
# of the velocity, per cycle that is followed exactly
ROUNDING = 1e-15
# segments that the exact method takes on at most, some minutes
MAX_SEGMENTS = 1e8
# steps per cycle that are tried, and the tolerance down to which each has been seen to serve
STEPS = ((24, 2e-3), (32, 4e-4), (56, 4e-5), (80, 1e-5), (128, 1.5e-6), (192, 2e-7), (256, 0.0))
# order that is counted on between two step sizes, and instants in the second half at which two runs are compared
ORDER, COMPARED = 1.75, 24
# share of the tolerance down to which a step size serves that no comparison takes away
FLOOR = 0.01
# nodes per segment, truncation of a segment, and the tolerance down to which each serves
ORDERS = ((8, 1e-5, math.inf), (8, 1e-7, 1e-8), (12, 1e-9, 1e-10), (16, 1e-12, 0.0))
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
        reason = why_not_stepped(slider, problem, number)
        if not reason:
            return number
    raise ConvergenceError("not applicable", f"an envelope needs fixed steps: {reason}")


def ring_down(slider, motion, envelope, *, longest=math.inf, samples=0):
    """Move the slider in fixed steps while the surface rings down.

    Returns (times in s from the end of the burst, rows), about as many as `samples`, one per cycle for 0.
    """
    frequency = motion.problem.omega / (2.0 * math.pi)
    number = shaped_steps(slider, motion.problem, RINGING_STEPS)
    loud = np.flatnonzero(envelope.amplitude > SPENT * np.max(envelope.amplitude))
    until = min(float(envelope.time[loud[-1]]) if loud.size else 0.0, longest)
    cycles = max(0, math.ceil(until * frequency))
    stride = max(1, cycles // samples) if samples else 1
    cycles -= cycles % stride
    shape = envelope.at(np.arange(cycles + 1) / frequency)
    rows = steps(motion.problem, motion.state, cycles, number, stride=stride, envelope=shape)
    return stride * np.arange(1, len(rows) + 1) / frequency, rows


class Burst(NamedTuple):
    """A burst to follow from rest; a row every `stride` cycles, `envelope` as in `time_stepping.steps`."""

    slider: Slider
    orbits: tuple[Orbit, ...]
    problem: Problem
    cycles: int
    stride: int
    tolerance: float
    envelope: np.ndarray

    def reference(self, velocity: float = 0.0) -> float:
        """Return the reference speed of a velocity; both scaled."""
        return reference_speed(velocity * self.problem.speed, self.orbits) / self.problem.speed


def _exact(burst):
    """Follow every event at two orders; where they do not agree to the tolerance, at the next."""
    if burst.cycles * burst.problem.segments > MAX_SEGMENTS:
        raise ConvergenceError(
            "out of reach",
            f"{burst.cycles} cycles of at least {burst.problem.segments:.3g} segments of the motion are more than can "
            "be followed; shorten the burst, raise the mass or lower the dampers",
        )

    def follow(level):
        nodes, truncation, _ = ORDERS[level]
        motion = rest(burst.slider, burst.orbits, burst.problem, nodes=nodes, truncation=truncation)
        motion.begin()
        rows = motion.turn(burst.cycles, stride=burst.stride)
        return motion.state[2:3].copy(), motion, rows

    def error(level, difference, reference):
        # two runs may agree by chance, but not so much better than their segments are laid out
        return max(difference, 3e-6 * ORDERS[level][1] * reference) + ROUNDING * burst.cycles * reference

    _, (_, motion, rows), estimate = _refined(burst, follow, error, ORDERS, 1)
    return motion, rows, estimate, motion.events()


def _stepped(burst):
    """Refine the steps until two runs agree; their differences on the way tell the error of the finer one."""
    factor = burst.envelope[0] if burst.envelope.size else 1.0
    begin = rest(burst.slider, burst.orbits, burst.problem, nodes=16, truncation=1e-12, factor=factor)
    most = max(1, burst.cycles // (2 * COMPARED))
    inner = _divisor(burst.stride, most)
    late = burst.cycles // inner // 2

    def follow(level):
        state = begin.state.copy()
        rows = steps(
            burst.problem, state, burst.cycles, STEPS[level][0], stride=inner, envelope=burst.envelope
        )
        return np.append(rows[late:, 0], state[2]), state, rows

    def error(level, difference, reference):
        # events fall anywhere in a step: one difference may vanish by chance, the largest of many does not
        gain = (STEPS[level][0] / STEPS[level - 1][0]) ** ORDER - 1.0
        return difference / gain + FLOOR * STEPS[level][1] * reference if reference > 0.0 else 0.0

    fits = [
        k for k, (number, *_) in enumerate(STEPS) if not why_not_stepped(burst.slider, burst.problem, number)
    ]
    level, (_, state, rows), estimate = _refined(burst, follow, error, STEPS, fits[1])
    begin.state[:] = state
    statistics = {
        "steps_per_cycle": STEPS[level][0], "cycles": burst.cycles,
        "omega_n_dt": largest_resonance(burst.problem) * 2.0 * math.pi / STEPS[level][0],
    }  # fmt: skip
    every = burst.stride // inner
    return begin, rows[every - 1 :: every], estimate, statistics


def _divisor(number, most):
    """Return the largest divisor of a number that is at most `most`."""
    return next(d for d in range(min(number, most), 0, -1) if number % d == 0)


def _averaged(burst):
    """Follow the averaged equations."""
    return averaged_run(burst, rest(burst.slider, burst.orbits, burst.problem, nodes=14, truncation=1e-11))


def _refined(burst, follow, error, levels, least):
    """Return (level, run, error) of the first level of resolution whose run agrees with that of the level before.

    A run begins with the velocities to compare, of which the last is that at the end; a level ends with the tolerance
    down to which it serves.
    """
    serving = (k for k, (*_, down_to) in enumerate(levels) if burst.tolerance >= down_to)
    level = max(next(serving, len(levels) - 1), least)
    coarse, fine = _both(follow, level - 1, level)
    while True:
        reference = burst.reference(float(fine[0][-1]))
        estimate = error(level, float(np.max(np.abs(fine[0] - coarse[0]))), reference)
        if estimate <= burst.tolerance * reference or level == len(levels) - 1:
            return level, fine, estimate
        level += 1
        coarse, fine = fine, follow(level)


def _both(work, first, second):
    """Return what some work gives for two arguments, at the same time: the kernels let other threads run."""
    if os.environ.get("SAWMOTOR_THREADS") == "1":
        return work(first), work(second)
    with ThreadPoolExecutor(1) as aside:
        job = aside.submit(work, first)
        result = work(second)
        return job.result(), result


def _exact_refusal(burst, by_name):
    return "it takes no envelope; use method stepped or leave the envelope out" if burst.envelope.size else ""


def _stepped_refusal(burst, by_name):
    # by name two step sizes are enough
    reason = why_not_stepped(burst.slider, burst.problem, STEPS[-2 if by_name else 0][0])
    return f"{reason}; use method exact" if reason else ""


def _averaged_refusal(burst, by_name):
    reason = why_not(burst.slider, burst.orbits)
    return (
        _exact_refusal(burst, by_name)
        or (f"{burst.cycles} cycles are too few; use method exact" if burst.cycles < 3 else "")
        or (f"{reason}; use method stepped or exact" if reason else "")
    )


# Method: (function, why it does not apply). The cheapest comes first: beyond EXACT_CYCLES cycles "auto" takes the first
# whose estimated error keeps the tolerance, up to there it follows every event.
STRATEGY = {
    # error: half the steps and fewer nodes; first against second order; shares of what second order leaves
    "averaged": (_averaged, _averaged_refusal),
    # error: two step sizes, compared at 24 instants
    "stepped": (_stepped, _stepped_refusal),
    # error: two collocation orders with two truncations; rounding per cycle
    "exact": (_exact, _exact_refusal),
}
METHODS = ("auto", *STRATEGY)


def run(method: str, burst: Burst):
    """Return (motion at the end, rows, error of v, statistics, method used) of a burst.

    The exact method leaves the energies in the motion's sums. A method asked for by name is refused where it does not
    apply, by a ConvergenceError of the status "not applicable".
    """
    if method != "auto":
        follow, refusal = STRATEGY[method]
        reason = refusal(burst, True)
        if reason:
            raise ConvergenceError("not applicable", f"the {method} method does not apply: {reason}")
        return (*follow(burst), method)
    best = None
    for name, (follow, refusal) in STRATEGY.items():
        if burst.cycles <= EXACT_CYCLES and burst.envelope.size == 0:
            break
        if refusal(burst, False):
            continue
        try:
            answer = (*follow(burst), name)
        except ConvergenceError:
            continue
        if best is None or answer[2] <= best[2]:
            best = answer
        if answer[2] <= burst.tolerance * burst.reference(float(answer[0].state[2])):
            break
        if name == "stepped" and burst.cycles > 100 * EXACT_CYCLES:
            break  # minutes of events are asked for by name
    return best or run("exact", burst)


def why_not_stepped(slider, problem, per_cycle):
    """Return why fixed steps cannot follow this motion, or an empty string."""
    if slider.stick_band > 0.0:
        return "slider.stick_band needs the events"
    if slider.law != "elastic" or slider.reciprocal:
        return "it knows the elastic law without its reciprocal force only"
    if slider.limit_slope == 0.0:
        return "no friction"
    step = 2.0 * math.pi / per_cycle
    turn = step * largest_resonance(problem)
    if turn > MAX_STEP:
        return (
            f"the contact resonance is too fast: omega_n dt = {turn:.3g} with {per_cycle} steps "
            f"per cycle, more than {MAX_STEP}"
        )
    # Hunt-Crossley's force enters by the rate, to first order in the step
    if step * problem.contact_damping * problem.stiffness * load(2.0, problem.shape) > MAX_DAMPING:
        return f"the contact's damper is too fast for {per_cycle} steps per cycle"
    if step * max(problem.normal_damping, problem.tangential_damping) > MAX_STEP:
        return f"the dampers are too fast for {per_cycle} steps per cycle"
    return ""
