r"""An independent check of a steady velocity: the limit of a run in time that starts at the answer.

The motion is computed in time from the height and the velocity of the answer, and a second time from a slightly
different velocity. Fixed steps are used where they are applicable, otherwise the event-driven method. In each run, a
and b are the mean velocities over the second and over the last quarter, with a smooth weight that suppresses the
ringing and the bounce. With the ratio rho = (b_2 - b_1)/(a_2 - a_1) of the two runs, the extrapolated limit is
a + (b - a)/(1 - rho), so that the run need not be as long as the settling of a heavy slider. The check uses no part of
the steady-state solvers: no averaging, no Newton iteration and no cycle map.
"""

import math
from dataclasses import dataclass

import numpy as np

import contact
from contact.answers.rest_motion import rest_problem
from contact.answers.steady import SteadyState
from contact.answers.stepped_burst import stepped_refusals
from contact.body import normal_amplitude, tangential_amplitude
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.exceptions import ConvergenceError
from contact.orbit import towards_plus
from contact.passing_wave import prescribed
from contact.stepping.time_stepping import steps

# Steps per cycle and collocation nodes of the two methods. The last gives the velocity, all give its error.
STEPS, NODES = (64, 90, 128), (9, 14)
# Cycles with fixed steps; for the event-driven method the least number of cycles, and the usual and the largest number
# of segments (5 s per run)
STEPPED_CYCLES, LEAST_CYCLES, EXACT_SEGMENTS, MAX_SEGMENTS = 20_000, 64, 60_000, 200_000
# Offset of the second start velocity over the reference speed, and of the third run's start height over the wave's
# amplitude; largest relative drift of the height
BESIDE, HIGHER, STILL = 1e-2, 0.1, 1e-4


@dataclass(frozen=True, kw_only=True)
class CrossCheck:
    """A steady velocity from runs in time."""

    velocity: float  # m/s
    error: float  # estimated, m/s, from the resolutions and the remaining settling
    method: str  # "stepped" or "exact"
    cycles: int  # number of computed cycles


def cross_check(state: SteadyState) -> CrossCheck:
    """Return the steady velocity to which runs in time from an answer extrapolate.

    Parameters
    ----------
    state : SteadyState
        Steady state of a moving or a sticking slider.

    Raises
    ------
    ConvergenceError
        If the motion cannot be computed or does not settle.
    """
    slider, orbits = prescribed(state.slider, state.orbits)
    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    unit = problem.speed
    begin = np.zeros(3 + len(driven))
    begin[0], begin[2] = -state.height / problem.length, side * state.velocity / unit
    reference = contact.reference_speed(state.velocity, driven) / unit
    stepped = not stepped_refusals(slider, problem, STEPS[0])
    resolutions = STEPS if stepped else NODES
    cycles = STEPPED_CYCLES if stepped else _cycle_count(problem)
    runs = [_quarters(_rows(problem, stepped, n, begin, cycles)) for n in resolutions]
    drift = abs(runs[-1][3] - runs[-1][2]) / (1.0 + abs(runs[-1][3]))
    if drift > STILL:
        raise ConvergenceError("not settled", f"the slider's height still drifts after {cycles} cycles")
    runs = [run[:2] for run in runs]
    a, b = runs[-1]
    if state.velocity == 0.0:
        # sticking: a displacement within the elastic limit of the contacts is no motion
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
        # resolutions, and a secant whose error is of second order in the distance of extrapolation
        reached = abs(settled[-1] - b) + abs(b2 - b)
        error = max(abs(settled[-1] - other) for other in settled[:-1])
        error += reached * min(1.0, 4.0 * reached / max(reference, 1e-300)) + drift * reference / (1.0 - rho)
        if not stepped:
            # a stiff damper of the contacts retains the initial height, and thus the velocity, for 10^5 cycles
            begin[0] += HIGHER * max(normal_amplitude(problem.paths, np.arange(problem.contacts)))
            higher = _quarters(_rows(problem, stepped, resolutions[0], begin, cycles))[1]
            if abs(higher - b2) > max(error, STILL * reference):
                raise ConvergenceError("not settled", f"the velocity still depends on the start after {cycles} cycles")
    return CrossCheck(
        velocity=float(side * settled[-1] * unit), error=float(error * unit), method="stepped" if stepped else "exact",
        cycles=cycles,
    )  # fmt: skip


def _quarters(rows):
    """Return the means of v over the second and the last quarter, weighted by sin^4, then those of z_s."""
    quarter = len(rows) // 4
    weight = np.sin(np.pi * (np.arange(quarter) + 0.5) / quarter) ** 4
    weight /= np.sum(weight)
    return tuple(float(weight @ part) for k in (2, 1) for part in (rows[quarter : 2 * quarter, k], rows[-quarter:, k]))


def _cycle_count(problem):
    segments_per_cycle = max(24.0, problem.segments)
    cycles = max(LEAST_CYCLES, int(EXACT_SEGMENTS / segments_per_cycle))
    if cycles * segments_per_cycle > MAX_SEGMENTS:
        raise ConvergenceError(
            "out of reach",
            f"a cycle takes {segments_per_cycle:.3g} segments of the motion: too many to follow {LEAST_CYCLES} of them",
        )
    return cycles


def _rows(problem, stepped, resolution, begin, cycles):
    """Return the rows (v, z_s, mean v) of every cycle from a state, in fixed steps or from event to event."""
    if stepped:
        return steps(problem, begin.copy(), cycles, resolution)
    motion = Motion(problem, grid=collocation(resolution), truncation=10.0 ** (1 - resolution))
    motion.set_state(*begin[:3], begin[3:])
    return motion.turn(cycles, stride=1)
