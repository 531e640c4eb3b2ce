r"""A steady velocity held against another way: where a run in time that starts at the answer would settle.

From the answer's height and velocity the motion is followed in fixed steps, or event by event where these do not
apply, and once more from a velocity a little beside it. Of each run the mean velocities a and b are taken, over the
second and over the last quarter, with a smooth weight that passes over rings and bounces. The rate of settling
rho = (b_2 - b_1)/(a_2 - a_1) points to a + (b - a)/(1 - rho): no waiting for a heavy slider. Nothing of the search for
the steady state is used, neither the averaging nor Newton's method nor the cycle map.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.answers.methods import rest_problem, stepped_refusals
from contact.answers.steady import SteadyState
from contact.body import normal_amplitude, tangential_amplitude
from contact.convergence_error import ConvergenceError
from contact.drive import reference_speed, towards_plus
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.stepping.time_stepping import steps

# steps per cycle, the last for the answer and all for its error, and nodes of the exact way
STEPS, NODES = (64, 90, 128), (9, 14)
# cycles by steps; cycles by events at least, segments that they usually and at most take (5 s a run); how far beside,
# of the reference; by how much the height may still move
STEPPED_CYCLES, LEAST_CYCLES, EXACT_SEGMENTS, MAX_SEGMENTS = 20_000, 64, 60_000, 200_000
BESIDE, STILL = 1e-2, 1e-4


@dataclass(frozen=True, kw_only=True)
class SecondOpinion:
    """A steady velocity by another way.

    Attributes
    ----------
    velocity : float
        m/s.
    error : float
        Estimated, m/s: from two resolutions, and what is left to settle.
    way : str
        "stepped" or "exact".
    cycles : int
        Followed.
    """

    velocity: float
    error: float
    way: str
    cycles: int


def second_opinion(state: SteadyState) -> SecondOpinion:
    """Return the steady velocity that runs in time from an answer point to.

    Parameters
    ----------
    state : SteadyState
        Of a moving slider or one that is held.

    Raises
    ------
    ConvergenceError
        What the motion ran into.
    """
    side, driven = towards_plus(state.orbits)
    slider = state.slider
    problem = rest_problem(slider, driven)
    unit = problem.speed
    begin = np.zeros(3 + len(driven))
    begin[0], begin[2] = -state.height / problem.length, side * state.velocity / unit
    reference = reference_speed(state.velocity, driven) / unit
    stepped = not stepped_refusals(slider, problem, STEPS[0])
    resolutions = STEPS if stepped else NODES
    cycles = STEPPED_CYCLES if stepped else _affordable(problem)
    runs = [_quarters(_rows(problem, stepped, n, begin, cycles)) for n in resolutions]
    drift = abs(runs[-1][3] - runs[-1][2]) / (1.0 + abs(runs[-1][3]))
    if drift > STILL:
        raise ConvergenceError("not settled", f"the slider's height still drifts after {cycles} cycles")
    runs = [run[:2] for run in runs]
    a, b = runs[-1]
    if state.velocity == 0.0:
        # held: what the springs may give and take back is no motion
        every = np.arange(problem.contacts)
        reach = slider.limit_slope * (abs(begin[0]) + max(normal_amplitude(problem.paths, every)))
        reach += max(tangential_amplitude(problem.paths, every))
        error, settled = 2.0 * reach / (2.0 * math.pi * (cycles // 4)), [b]
    else:
        begin[2] += BESIDE * reference
        a2, b2 = _quarters(_rows(problem, stepped, resolutions[-1], begin, cycles))[:2]
        apart = a2 - a
        rho = min(max((b2 - b) / apart, 0.0), 1.0 - 1e-9) if abs(apart) > 1e-3 * BESIDE * reference else 0.0
        settled = [early + (late - early) / (1.0 - rho) for early, late in runs]
        # resolutions, and a secant that is straight to second order in how far it had to reach
        reached = abs(settled[-1] - b) + abs(b2 - b)
        error = max(abs(settled[-1] - other) for other in settled[:-1])
        error += reached * min(1.0, 4.0 * reached / max(reference, 1e-300)) + drift * reference / (1.0 - rho)
    return SecondOpinion(
        velocity=float(side * settled[-1] * unit), error=float(error * unit), way="stepped" if stepped else "exact",
        cycles=cycles,
    )  # fmt: skip


def _quarters(rows):
    """Return the means of v over the second and the last quarter, weighted by sin^4, then those of z_s."""
    quarter = len(rows) // 4
    weight = np.sin(np.pi * (np.arange(quarter) + 0.5) / quarter) ** 4
    weight /= np.sum(weight)
    return tuple(
        float(weight @ part) for k in (2, 1) for part in (rows[quarter : 2 * quarter, k], rows[-quarter:, k])
    )


def _affordable(problem):
    each = max(24.0, problem.segments)
    cycles = max(LEAST_CYCLES, int(EXACT_SEGMENTS / each))
    if cycles * each > MAX_SEGMENTS:
        raise ConvergenceError(
            "out of reach",
            f"a cycle takes {each:.3g} segments of the motion: too many to follow {LEAST_CYCLES} of them",
        )
    return cycles


def _rows(problem, stepped, resolution, begin, cycles):
    """Return the rows (v, z_s, mean v) of every cycle from a state, in fixed steps or from event to event."""
    if stepped:
        return steps(problem, begin.copy(), cycles, resolution)
    motion = Motion(problem, grid=collocation(resolution), truncation=10.0 ** (1 - resolution))
    motion.place(*begin[:3], begin[3:])
    return motion.turn(cycles, stride=1)
