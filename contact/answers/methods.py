r"""Three ways through a burst, one model: every event, fixed steps, many cycles at once.

Each takes a slider at rest at phase 0 and returns its motion at the end, rows (v, z_s) on the way, the estimated error
of the last v and what it counted; each refuses where it does not apply. The errors come from two runs really made.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from contact.answers.averaged import averaged_run, why_not
from contact.convergence import ConvergenceError
from contact.drive import reference_speed
from contact.law.normal import load
from contact.problem import largest_resonance

METHODS = ("auto", "exact", "stepped", "averaged")
# up to here "auto" follows every event, whatever the tolerance
EXACT_CYCLES = 3000
# of the velocity, per cycle that is followed exactly
ROUNDING = 1e-15
# stretches that the exact way takes on at most, some minutes
MOST_STRETCHES = 1e8
# steps per cycle that are tried, and the tolerance down to which each has been seen to serve
STEPS = ((24, 2e-3), (32, 4e-4), (56, 4e-5), (80, 1e-5), (128, 1.5e-6), (192, 2e-7), (256, 0.0))
# order that is counted on between two step sizes, and instants in the second half at which two runs are compared
ORDER, WITNESSES = 1.75, 24
# share of the tolerance down to which a step size serves that no comparison takes away
FLOOR = 0.01
# nodes per stretch, truncation of a stretch, and the tolerance down to which each serves
ORDERS = ((8, 1e-5, math.inf), (8, 1e-7, 1e-8), (12, 1e-9, 1e-10), (16, 1e-12, 0.0))
# change of the contact's own oscillation in a step, omega_n dt, above which fixed steps are refused
LARGEST_STEP = 0.2
# share of its velocity that the contact's damper may take in a step
LARGEST_DAMPING = 5e-3


def rest_problem(slider, orbits):
    """Return the scaled problem whose phase 0 is where u_z of the first contact passes zero upwards."""
    from contact.problem import scaled
    from contact.solve.equilibrium import opposed

    direction = opposed(slider, orbits)
    return scaled(
        slider, orbits, direction=direction, start=-0.5 * math.pi - float(np.angle(orbits[0].normal))
    )


def rest(slider, orbits, problem, *, nodes, truncation):
    """Return the motion at phase 0 of a slider at rest, its contacts deformed by the load alone."""
    from contact.solve.collocation import collocation
    from contact.solve.motion import Motion

    contacts = len(orbits)
    motion = Motion(problem, table=collocation(nodes), truncation=truncation)
    depth = slider.rest_approach(contacts) / problem.length
    x = slider.rest_deformations(contacts) / problem.length
    motion.place(-depth, 0.0, 0.0, math.copysign(1.0, problem.load) * x)
    return motion


def silence(motion):
    """Return the motion that goes on where this one stands, at phase 0, when the wave stops."""
    from contact.problem import without_wave

    still = motion.copy()
    still.problem = without_wave(motion.problem)
    still.tally[:], still.sums[:] = 0, 0.0
    still.place(*motion.state[:3], motion.state[3:])
    return still


def run(method, slider, orbits, problem, cycles, stride, tolerance, envelope):
    """Return (motion, rows, error, statistics, method used) of a burst; `envelope` as in `time_stepping.steps`.

    The exact way leaves the energies of the burst in the motion's sums, and in `motion.begun` those at its start.
    """
    if method != "auto":
        return (*_one(method, slider, orbits, problem, cycles, stride, tolerance, envelope), method)
    reference = reference_speed(0.0, orbits) / problem.speed
    tried = None
    for way in _order(slider, orbits, problem, cycles, envelope):
        try:
            found = _one(way, slider, orbits, problem, cycles, stride, tolerance, envelope)
        except ConvergenceError:
            if way == "exact":
                if tried is None:
                    raise
                break
            continue
        if tried is None or found[2] <= tried[2]:
            tried = (*found, way)
        if found[2] <= tolerance * max(reference, abs(float(found[0].state[2]))):
            break
        if way == "stepped" and cycles > 100 * EXACT_CYCLES:
            break  # minutes of events are asked for by name
    return tried


def _order(slider, orbits, problem, cycles, envelope):
    """Return the ways that may serve, the cheapest first."""
    shaped = envelope.size > 0
    steppable = not why_not_stepped(slider, problem, STEPS[0][0])
    if cycles <= EXACT_CYCLES and not shaped:
        return ("exact",)
    ways = [] if shaped or why_not(slider, orbits) else ["averaged"]
    ways += ["stepped"] if steppable else []
    return (*ways, *(() if shaped and steppable else ("exact",)))


def _one(method, slider, orbits, problem, cycles, stride, tolerance, envelope):
    if method == "stepped":
        return _stepped(slider, orbits, problem, cycles, stride, tolerance, envelope)
    if envelope.size > 0:
        raise ConvergenceError(
            "not applicable",
            f"the {method} way takes no envelope; use method stepped or leave the envelope out",
        )
    if method == "averaged":
        if cycles < 3:
            raise ConvergenceError(
                "not applicable", f"{cycles} cycles are too few for the averaged way; use method exact"
            )
        begin = rest(slider, orbits, problem, nodes=14, truncation=1e-11)
        return averaged_run(slider, orbits, problem, begin, cycles, stride, tolerance)
    return _exact(slider, orbits, problem, cycles, stride, tolerance)


def _exact(slider, orbits, problem, cycles, stride, tolerance):
    """Follow every event at two orders; where they do not agree to the tolerance, at the next."""
    if cycles * problem.segments > MOST_STRETCHES:
        raise ConvergenceError(
            "out of reach",
            f"{cycles} cycles of at least {problem.segments:.3g} stretches of the motion are more than can be "
            "followed; shorten the burst, raise the mass or lower the dampers",
        )
    level = next((k for k, (_, _, down_to) in enumerate(ORDERS) if tolerance >= down_to), len(ORDERS) - 1)

    def follow(order):
        nodes, truncation, _ = ORDERS[order]
        motion = rest(slider, orbits, problem, nodes=nodes, truncation=truncation)
        motion.begun = motion.energy()
        return motion, motion.turn(cycles, stride=stride)

    (coarse, _), (fine, rows) = _both(follow, level - 1, level)
    while True:
        reference = reference_speed(float(fine.state[2]) * problem.speed, orbits) / problem.speed
        # two runs may agree by chance, but not so much better than their stretches are laid out
        error = max(abs(float(fine.state[2] - coarse.state[2])), 3e-6 * ORDERS[level][1] * reference)
        error += ROUNDING * cycles * reference
        if error <= tolerance * reference or level == len(ORDERS) - 1:
            return fine, rows, error, fine.events()
        level += 1
        coarse, (fine, rows) = fine, follow(level)


def _both(work, first, second):
    """Return what some work gives for two arguments, at the same time: the kernels let other threads run."""
    if os.environ.get("SAWMOTOR_THREADS") == "1":
        return work(first), work(second)
    with ThreadPoolExecutor(1) as aside:
        job = aside.submit(work, first)
        found = work(second)
        return job.result(), found


def _stepped(slider, orbits, problem, cycles, stride, tolerance, envelope):
    """Refine the steps until two runs agree; their differences on the way tell the error of the finer one."""
    from contact.solve.time_stepping import steps

    begin = rest(slider, orbits, problem, nodes=16, truncation=1e-12)
    fits = [k for k, (number, _) in enumerate(STEPS) if not why_not_stepped(slider, problem, number)]
    if len(fits) < 2:
        refusal = why_not_stepped(slider, problem, STEPS[-2][0])
        raise ConvergenceError(
            "not applicable", f"the stepped way does not apply: {refusal}; use method exact"
        )

    inner = _divisor(stride, max(1, cycles // (2 * WITNESSES)))
    late = cycles // inner // 2

    def follow(k):
        state, rows = begin.state.copy(), np.empty((cycles // inner, 3))
        if not steps(problem, state, cycles, STEPS[k][0], inner, rows, envelope):
            raise ConvergenceError("not finite", "the stepped motion overflowed; use method exact")
        return np.append(rows[late:, 0], state[2]), state, rows

    k = max(next(k for k, (_, down_to) in enumerate(STEPS) if tolerance >= down_to), fits[1])
    (coarse, _, _), (fine, state, rows) = _both(follow, k - 1, k)
    while True:
        reference = reference_speed(float(state[2]) * problem.speed, orbits) / problem.speed
        # events fall anywhere in a step: one difference may vanish by chance, the largest of many does not
        error = float(np.max(np.abs(fine - coarse))) / ((STEPS[k][0] / STEPS[k - 1][0]) ** ORDER - 1.0)
        error = error + FLOOR * STEPS[k][1] * reference if reference > 0.0 else 0.0
        if error <= tolerance * reference or k == len(STEPS) - 1:
            break
        k += 1
        coarse, (fine, state, rows) = fine, follow(k)
    begin.state[:] = state
    statistics = {
        "steps_per_cycle": STEPS[k][0], "cycles": cycles,
        "omega_n_dt": _resonance(problem) * 2.0 * math.pi / STEPS[k][0],
    }  # fmt: skip
    every = stride // inner
    return begin, rows[every - 1 :: every], error, statistics


def _divisor(number, most):
    """Return the largest divisor of a number that is at most `most`."""
    return next(d for d in range(min(number, most), 0, -1) if number % d == 0)


def _resonance(problem):
    return largest_resonance(problem.stiffness, problem.shape, problem.contacts)


def why_not_stepped(slider, problem, per_cycle):
    """Return why fixed steps cannot follow this motion, or an empty string."""
    if slider.stick_band > 0.0:
        return "slider.stick_band needs the events"
    if slider.law != "elastic" or slider.reciprocal:
        return "it knows the elastic law without its reciprocal force only"
    if slider.limit_slope == 0.0:
        return "no friction"
    step = 2.0 * math.pi / per_cycle
    turn = step * _resonance(problem)
    if turn > LARGEST_STEP:
        return (
            f"the contact resonance is too fast: omega_n dt = {turn:.3g} with {per_cycle} steps "
            f"per cycle, more than {LARGEST_STEP}"
        )
    # Hunt-Crossley's force enters by the rate, to first order in the step
    if step * problem.contact_damping * problem.stiffness * load(2.0, problem.shape) > LARGEST_DAMPING:
        return f"the contact's damper is too fast for {per_cycle} steps per cycle"
    if step * max(problem.normal_damping, problem.tangential_damping) > LARGEST_STEP:
        return f"the dampers are too fast for {per_cycle} steps per cycle"
    return ""
