r"""Forces, deformations and regimes of the contact points as functions of time within a few wave cycles.

The quantities are those of Figs 6 and 7 of Feenstra and Breedveld. A history covers one of three stages:

- "start": some cycles after a start from rest,
- "steady": the periodic motion,
- "after": the motion after the wave stops during the periodic motion. Times are still counted in periods of that wave.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.answers.rest_motion import rest, rest_problem, silence
from contact.averaged.event_equilibrium import balanced
from contact.averaged.sweep_kernel import MAX_RATIO_HELD
from contact.body import at_phase
from contact.choice import Answer, Answered
from contact.error_estimate import two_orders_error
from contact.events.segment import SampleColumn
from contact.exceptions import ConvergenceError
from contact.orbit import Orbits, towards_plus
from contact.passing_wave import Surface, prescribed
from contact.periodic.settling import long_run, reached
from contact.periodic.shooting import COARSE, FINE, coarse_periodic, fine_periodic
from contact.slider import Slider

STAGES = ("start", "steady", "after")
# Names in the order of `codes.Regime`. A hysteretic contact with a slip annulus is "partial"; one that grows sticks.
REGIMES = np.array(["separated", "stick", "slip", "creep", "partial", "stick"])


@dataclass(frozen=True, kw_only=True)
class History(Answered):
    """Waveforms of n contact points at k times.

    Attributes
    ----------
    slider, orbits
        The arguments of `contact_history`.
    time : (k,) array
        Time in s. Zero is the start of the burst ("start"), an upward zero crossing of u_z of the first contact
        ("steady") or the end of the wave ("after").
    approach, deformation : (k, n) arrays
        Approach z and tangential deformation x, m; z < 0 if the contact is separated.
    normal_force, tangential_force : (k, n) arrays
        Elastic normal force P and tangential force Q, N.
    regime : (k, n) array of str
        "separated", "stick", "slip", "creep" (with a stick band) or "partial" (hysteretic law: an annulus slips).
    surface_velocity : (k, n) array
        Tangential velocity v_t of the surface, m/s.
    slider_velocity : (k,) array
        Velocity v_s of the slider, m/s.
    answer : Answer
        v_s at the last time, m/s. Its error is the largest error of v_s at any time, from a second computation.
    statistics : dict
        Number of events of each kind in the recorded time.
    """

    slider: Slider
    orbits: Orbits
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
    slider: Slider, orbits: Surface, *, stage: str, skip: float, cycles: float, points_per_cycle: float
) -> History:
    """Return the waveforms of the contact points.

    Parameters
    ----------
    slider, orbits
        As for `steady`.
    stage : str
        "start", "steady" or "after".
    skip, cycles : float
        Number of wave cycles before the recording starts, and number of cycles to record.
    points_per_cycle : float
        Number of recorded times per cycle. It may be below one, for a long stage "after".

    Returns
    -------
    History
    """
    slider, listed = prescribed(slider, orbits, in_time=True, each=True)
    parameter_check.choice("stage", stage, STAGES)
    parameter_check.non_negative("skip", skip, "cycles")
    parameter_check.positive("cycles", cycles, "cycles")
    parameter_check.positive("points_per_cycle", points_per_cycle, "")
    side, driven = towards_plus(listed)
    if stage == "start":
        problem, unseen = rest_problem(slider, driven), 0.0
        motions = [rest(slider, driven, problem, nodes=n, truncation=e) for n, e, *_ in (FINE, COARSE)]
    else:
        motions, unseen = _steady_motions(slider, driven)
        motions = [silence(each) for each in motions] if stage == "after" else motions
    # Phases are counted from the start of the cycle in which the recording begins, or from the end of the wave.
    turn, count, whole_cycles = 2.0 * math.pi, max(1, round(cycles * points_per_cycle)), int(skip)
    begin = turn * (skip if stage == "after" else skip - whole_cycles)
    phases = begin + turn * cycles * np.arange(1, count + 1) / count
    recorded = []
    for motion in motions:
        if stage != "after":
            motion.turn(whole_cycles)
        if begin > 0.0:
            motion.move(0.0, begin, np.empty(0))
        motion.tally[:] = 0
        recorded.append(np.moveaxis(motion.move(begin, begin + turn * cycles * (1.0 + 1e-13), phases), -1, 0))
    motion, (z, x, P, Q, regime, v) = motions[0], recorded[0]
    problem, speed = motion.problem, side * v[:, 0] * motion.problem.speed
    error = two_orders_error(float(np.max(np.abs(v - recorded[-1][SampleColumn.SLIDER_VELOCITY]))), unseen)
    force = slider.unit_mass * problem.omega**2 * problem.length / slider.contacts(len(listed)).weight
    v_t = at_phase(problem.paths, np.arange(problem.contacts), np.cos(phases)[:, None], np.sin(phases)[:, None])[3]
    return History(
        slider=slider, orbits=listed, time=(phases - begin + turn * skip) / problem.omega,
        approach=z * problem.length, deformation=side * x * problem.length, normal_force=P * force,
        tangential_force=side * Q * force, regime=REGIMES[regime.astype(int)],
        surface_velocity=side * v_t * problem.speed, slider_velocity=speed, statistics=motion.events(),
        answer=Answer(value=float(speed[-1]), error=error * problem.speed, reasons=(f"stage {stage}",)),
    )  # fmt: skip


def _steady_motions(slider, orbits):
    """Return (steady motions at two collocation orders, error of v that their difference does not show).

    At phase 0 u_z of the first contact crosses zero upwards. As in `steady`, the motion is the one that repeats with
    the wave's period, provided that it is stable and that a slider from rest reaches it. The latter is checked only if
    the contact resonance is near the wave frequency. Otherwise the motion is a long run from rest, computed at one
    order only, with its own estimate of the error.
    """
    balance = balanced(slider, orbits)
    ratio = slider.normal_resonance(len(orbits)) / orbits.frequency
    try:
        fine = fine_periodic(balance)
    except ConvergenceError:
        if ratio <= MAX_RATIO_HELD:
            raise
        fine = None
    run = None
    if fine is None or not fine.stable:
        run = long_run(slider, orbits, balance.load_sign)
    elif ratio > MAX_RATIO_HELD:
        run = reached(slider, orbits, balance, fine).instead
    if run is not None:
        return [run.motion], run.error
    coarse = coarse_periodic(balance, fine)
    problem, motions = rest_problem(slider, orbits), [fine.motion, coarse.motion]
    for motion in motions:
        motion.move(0.0, _phase_between(motion.problem.paths, problem.paths), np.empty(0))
        motion.problem = problem
    return motions, fine.unseen_error


def _phase_between(first, second):
    """Return the phase in [0, 2 pi) by which the second problem's path starts after the first one's, at contact 0."""
    for axis in ("normal", "tangential"):
        # u = a cos phi + b sin phi: a phase shift by +delta multiplies a + i b by exp(-i delta)
        before, after = (
            complex(getattr(paths, f"{axis}_cos")[0], getattr(paths, f"{axis}_sin")[0]) for paths in (first, second)
        )
        if before and after:
            return float(-np.angle(after / before) % (2.0 * math.pi))
    return 0.0
