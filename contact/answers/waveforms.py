r"""What happens at the contact points, instant by instant: the quantities of Feenstra and Breedveld's Figs 6 and 7.

Three stages: "start", after a number of cycles from rest; "steady", in the periodic motion; "after", after the wave
has stopped in the periodic motion, where one "cycle" is still a period of the wave that was.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.answers.methods import rest, rest_problem, silence
from contact.averaged.event_cycle import balanced
from contact.averaged.sweep_rows import MAX_RATIO_HELD
from contact.body import at_phase
from contact.choice import Answer, Answered
from contact.convergence_error import ConvergenceError
from contact.drive import towards_plus
from contact.events.segment import Sample
from contact.orbit import Orbit, as_orbits
from contact.periodic.settling import long_run, reached
from contact.periodic.shooting import periodic
from contact.slider import Slider

STAGES = ("start", "steady", "after")
# nodes per segment and its truncation, of the answer and of the second computation
FINE, COARSE = (16, 1e-12), (10, 1e-8)
# in the order of the numbers in `elastic`; an annulus that slips is "partial", a growing contact sticks
REGIMES = np.array(["separated", "stick", "slip", "creep", "partial", "stick"])


@dataclass(frozen=True, kw_only=True)
class History(Answered):
    """Contact points over a few cycles; arrays of k instants, those of contacts (k, n).

    Attributes
    ----------
    slider, orbits
        What was asked.
    time : (k,) array
        s from the first instant of the stage: start of the burst, upward zero of u_z of the first contact, or end of
        the wave.
    approach, deformation : (k, n) arrays
        z and x, m; z < 0 when separated.
    normal_force, tangential_force : (k, n) arrays
        Elastic P, and Q, N.
    regime : (k, n) array of str
        "separated", "stick", "slip", "creep" (with a stick band) or "partial" (an annulus slips; hysteretic law).
    surface_velocity : (k, n) array
        Tangential velocity v_t of the surface, m/s.
    slider_velocity : (k,) array
        v_s, m/s.
    answer : Answer
        v_s at the last instant, m/s; its error is that of v_s at any instant, from a second computation.
    statistics : dict
        Events by kind over the recorded span.
    """

    slider: Slider
    orbits: tuple[Orbit, ...]
    time: np.ndarray
    approach: np.ndarray
    deformation: np.ndarray
    normal_force: np.ndarray
    tangential_force: np.ndarray
    regime: np.ndarray
    surface_velocity: np.ndarray
    slider_velocity: np.ndarray
    answer: Answer
    statistics: dict


def contact_history(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    stage: str,
    skip: float,
    cycles: float,
    points_per_cycle: float,
) -> History:
    """Return the history of the contact points.

    Parameters
    ----------
    slider, orbits
        As for `steady`.
    stage : str
        "start", "steady" or "after".
    skip, cycles : float
        Cycles of the wave to pass before recording, and to record.
    points_per_cycle : float
        Instants per cycle; may be below one after the wave has stopped.

    Returns
    -------
    History
    """
    listed = as_orbits(orbits)
    bounds.choice("stage", stage, STAGES)
    bounds.non_negative("skip", skip, "cycles")
    bounds.positive("cycles", cycles, "cycles")
    bounds.positive("points_per_cycle", points_per_cycle, "")
    side, driven = towards_plus(listed)
    if stage == "start":
        problem, doubt = rest_problem(slider, driven), 0.0
        motions = [rest(slider, driven, problem, nodes=n, truncation=e) for n, e in (FINE, COARSE)]
    else:
        motions, doubt = _steady_motions(slider, driven)
        motions = [silence(each) for each in motions] if stage == "after" else motions
    turn, count, passed = 2.0 * math.pi, max(1, round(cycles * points_per_cycle)), int(skip)
    offset = turn * (skip if stage == "after" else skip - passed)
    at = offset + turn * cycles * np.arange(1, count + 1) / count
    recorded = []
    for motion in motions:
        if stage != "after":
            motion.turn(passed)
        if offset > 0.0:
            motion.move(0.0, offset, np.empty(0))
        motion.tally[:] = 0
        recorded.append(np.moveaxis(motion.move(offset, offset + turn * cycles * (1.0 + 1e-13), at), -1, 0))
    motion, (z, x, P, Q, regime, v) = motions[0], recorded[0]
    problem, speed = motion.problem, side * v[:, 0] * motion.problem.speed
    error = float(np.max(np.abs(v - recorded[-1][Sample.SLIDER_VELOCITY]))) + doubt
    force = slider.mass * problem.omega**2 * problem.length
    v_t = at_phase(problem.paths, np.arange(problem.contacts), np.cos(at)[:, None], np.sin(at)[:, None])[3]
    return History(
        slider=slider, orbits=listed, time=(at - offset + turn * skip) / problem.omega,
        approach=z * problem.length, deformation=side * x * problem.length, normal_force=P * force,
        tangential_force=side * Q * force, regime=REGIMES[regime.astype(int)],
        surface_velocity=side * v_t * problem.speed, slider_velocity=speed, statistics=motion.events(),
        answer=Answer(value=float(speed[-1]), error=error * problem.speed, reasons=(f"stage {stage}",)),
    )  # fmt: skip


def _steady_motions(slider, orbits):
    """Return the steady motion where u_z of the first contact passes zero upwards, at two orders, and its doubt in v.

    It is the motion that `steady` answers with: the one that repeats with the wave's period if it is stable and, where
    the contact resonates near the wave's frequency, if a slider from rest comes to it; else what it does come to, of
    which there is one order alone.
    """
    balance = balanced(slider, orbits)
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    try:
        found = periodic(balance, nodes=FINE[0], truncation=FINE[1])
    except ConvergenceError:
        if ratio <= MAX_RATIO_HELD:
            raise
        found = None
    run = None
    if found is None or not found.stable:
        run = long_run(slider, orbits, balance.load_sign)
    elif ratio > MAX_RATIO_HELD:
        run = reached(slider, orbits, balance, found).instead
    if run is not None:
        return [run.motion], run.error
    coarse = periodic(balance, nodes=COARSE[0], truncation=COARSE[1], near=found)
    problem, motions = rest_problem(slider, orbits), [found.motion, coarse.motion]
    for motion in motions:
        motion.move(0.0, _phase_between(motion.problem.paths, problem.paths), np.empty(0))
        motion.problem = problem
    return motions, found.step + found.rounding


def _phase_between(first, second):
    """Return the phase in [0, 2 pi) after which the first contact's path is the other one."""
    for axis in ("normal", "tangential"):
        # u = a cos phi + b sin phi: a + i b turns backwards
        before, after = (
            complex(getattr(paths, f"{axis}_cos")[0], getattr(paths, f"{axis}_sin")[0])
            for paths in (first, second)
        )
        if before and after:
            return float(-np.angle(after / before) % (2.0 * math.pi))
    return 0.0
