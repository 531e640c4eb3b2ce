r"""Averaged steady states of one or many sliders, with their errors and the effect of an error of the wave.

A compiled loop (`sweep_kernel`) scales and solves each problem separately, with the second-order correction. Hence a
result does not depend, to the last bit, on the other problems in the sweep or on the number of threads. A single steady
state (`mean_motion`) is a sweep of one problem. A problem to which averaging does not apply, or for which it does not
converge, has the regime "unknown"; use `steady` for it.

The relative error of the wave bounds the change of the two complex amplitudes, except for a common phase, relative to
the larger amplitude. The effect on the velocity is the root of the sum of squares over four changes of that size: both
amplitudes larger, both smaller, their ratio, and their phase difference. It is computed by first-order averaging, whose
derivatives have a relative error of O((f_n/f)^2).
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.averaged.adhesive_motion import holding_balls
from contact.averaged.burst import HARMONICS, STIFFEST_STEADY, refusals, refuse_unless_applicable
from contact.averaged.closed_forms import closed_form
from contact.averaged.coupled_motion import coupled_motion, unloaded
from contact.averaged.cycle_mean import ContactMean, MeanForces, contact_cycles, forces_of
from contact.averaged.cycle_pieces import FORWARD, cycle_arrays
from contact.averaged.equilibrium import FINE_NODES, Entry
from contact.averaged.riding import quadrature, riding_approach
from contact.averaged.sweep_kernel import Sweep, solve_problems
from contact.codes import Status, SteadyRegime
from contact.error_estimate import averaged_stall_error, first_order_error, reference_speed
from contact.exceptions import RUNAWAY, ConvergenceError
from contact.orbit import Orbits, as_orbits, crest_velocities, towards_plus
from contact.passing_wave import Surface, coupling, crest_direction, prescribed, resonance_ratio
from contact.problem import numbers, paths_of, scaled
from contact.slider import Slider

HOLDING = 1e-6  # tolerance of the cycle means of balls that hold on beyond the touch
REGIMES = np.array([regime.name.lower() for regime in SteadyRegime])
REFUSALS = {
    Status.RUNAWAY: ("runaway", RUNAWAY),
    Status.NEAR_THRESHOLD: (
        "near the threshold",
        "the slider is held, or nearly so, and averaging cannot tell which; use method exact",
    ),
}


@dataclass(frozen=True)
class MeanMotion:
    """Averaged steady state of one problem (numbers), or of many (arrays of one shape, NaN where "unknown").

    Attributes
    ----------
    velocity : float or ndarray
        Mean velocity, m/s; exactly 0 if held.
    first_order : float or ndarray
        Velocity without the second-order correction, m/s.
    height : float or ndarray
        Mean approach h, m; negative if the slider rides above the surface at rest.
    regime : str or ndarray of str
        "stick", "slip", "intermittent", or "unknown" if averaging does not apply or does not converge.
    held : bool or ndarray of bool
        True if friction keeps the slider at rest.
    relative_error : float or ndarray
        Computational error of the velocity over max(|v|, omega |u_x|/10).
    error_from_wave : float or ndarray
        Error of the velocity due to the error of the wave, over the same reference speed.
    blocked_thrust : float or ndarray
        Load at which the slider stalls, N, by first-order averaging; 0 if the unloaded slider is held.
    blocked_thrust_error : float or ndarray
        Error of the blocked thrust by averaging, N.
    load_sign : float or ndarray
        +1 if the load opposes motion in the direction in which the crests drive, -1 if it opposes the other direction.
    """

    velocity: np.ndarray
    first_order: np.ndarray
    height: np.ndarray
    regime: np.ndarray
    held: np.ndarray
    relative_error: np.ndarray
    error_from_wave: np.ndarray
    blocked_thrust: np.ndarray
    blocked_thrust_error: np.ndarray
    load_sign: np.ndarray


def steady_sweep(
    sliders: list[Slider],
    waves: list[Orbits],
    *,
    which: np.ndarray,
    factors: np.ndarray,
    wave_errors: np.ndarray,
    threads: int | None = None,
) -> MeanMotion:
    """Return the steady states of many problems, as arrays of the shape of `factors`.

    A map over amplitude and preload is a sweep whose `factors` have two axes.

    Parameters
    ----------
    sliders : list of Slider
    waves : list of Orbits, or of sequences of Orbit
        One orbit per contact, all of one length.
    which : (..., 2) array of int
        Slider and wave of each problem.
    factors : (...) array
        Factors on the wave's amplitudes, zero or positive.
    wave_errors : (w,) array
        Relative errors of the waves.
    threads : int, optional
        Number of threads; by default the number of processors.
    """
    factors = np.asarray(factors, float)
    for factor in factors[~((factors >= 0.0) & (factors < math.inf))]:
        parameter_check.non_negative("factors", factor, "")
    results = _entries(sliders, waves, which, factors.ravel(), wave_errors, threads)
    return _answer(results.reshape(*factors.shape, -1))


def mean_motion(slider: Slider, orbits: Surface) -> MeanMotion:
    """Return the steady state by averaging, with the second-order correction on prescribed orbits.

    Parameters
    ----------
    slider, orbits
        As for `steady`.

    Raises
    ------
    ConvergenceError
        Status "not applicable", "near the threshold", "runaway" or "not converged".
    """
    if coupling(slider, orbits):
        return _coupled(slider, orbits)
    slider, listed = prescribed(slider, orbits)
    if slider.profile.hold is not None:
        return _of_holding_balls(slider, listed)
    result = _entries([slider], [listed], [(0, 0)], [1.0], [0.0], 1)[0]
    status = result[Entry.STATUS]
    if math.isnan(status):
        closed_form(slider, listed)  # raises with status "runaway" if nothing balances the load
        refuse_unless_applicable(slider, listed, STIFFEST_STEADY)
    if status != Status.DONE or result[Entry.REGIME] == SteadyRegime.UNKNOWN:
        unreached = "not converged", "the averaged motion was not reached; use method exact"
        raise ConvergenceError(*REFUSALS.get(status, unreached))
    return _answer(result)


def mean_forces(slider: Slider, orbits: Surface, motion: MeanMotion) -> MeanForces:
    """Return the forces of each contact in an averaged steady state of `mean_motion`, by first-order averaging.

    The phases of the harmonics refer to t = 0 of the orbits' complex amplitudes. The force of a contact that always
    sticks depends on its history; its deformation is taken as the least possible one.
    """
    slider, listed = prescribed(slider, orbits, each=True)
    if slider.profile.hold is not None:
        normal, tangential, *firsts = holding_balls(slider).harmonics(tuple(listed), float(motion.first_order))
        unknown = np.full((len(ContactMean), len(listed)), math.nan)
        return MeanForces(normal.real, tangential.real, firsts[0], firsts[1], unknown)
    problem = scaled(slider, listed, direction=1.0, start=0.0)
    by_contact = np.empty((len(ContactMean), len(listed)))
    velocities = np.full(len(listed), motion.first_order / problem.speed)
    work, rule = cycle_arrays(1, FINE_NODES), quadrature(FINE_NODES)
    contact_cycles(problem, riding_approach(problem), velocities, FORWARD, rule, work, by_contact)
    if slider.static_friction(len(listed)) == 0.0:  # slip begins at no deformation: the kernel's spring is 0/0
        by_contact[[ContactMean.TANGENTIAL, ContactMean.TANGENTIAL_COS, ContactMean.TANGENTIAL_SIN]] = 0.0
    force_units = slider.unit_mass * problem.omega**2 * problem.length / slider.contacts(len(listed)).weight
    return forces_of(by_contact, force_units, force_units)


def _coupled(slider, wave):
    """Return the `MeanMotion` of a slider whose wave or tilts depend on its forces."""
    found, ratio = coupled_motion(slider, wave), resonance_ratio(slider, wave)
    search, _, direction = unloaded(slider, wave)
    thrust = max(search.stall(direction)[0], 0.0)
    values = (
        found.velocity, found.velocity, found.height, found.regime, found.regime == "stick",
        found.relative_error + first_order_error(ratio), 0.0, thrust, thrust * averaged_stall_error(ratio),
        direction * crest_direction(wave),
    )  # fmt: skip
    return MeanMotion(*map(np.asarray, values))


def _of_holding_balls(slider, orbits):
    """Return the `MeanMotion` of balls that hold on beyond the touch, by first-order averaging."""
    balls, listed, ratio = holding_balls(slider), tuple(orbits), resonance_ratio(slider, orbits)
    found = balls.motion(listed, tolerance=HOLDING)
    low, high = balls.held_loads(listed)
    thrust = max(low, -high, 0.0)
    reference = reference_speed(found.velocity.value, orbits)
    return MeanMotion(
        velocity=np.asarray(found.velocity.value), first_order=np.asarray(found.velocity.value),
        height=np.asarray(found.height), regime=np.asarray(found.regime), held=np.asarray(found.velocity.value == 0.0),
        relative_error=np.asarray(found.velocity.error / reference + first_order_error(ratio)),
        error_from_wave=np.asarray(0.0), blocked_thrust=np.asarray(thrust),
        blocked_thrust_error=np.asarray(thrust * averaged_stall_error(ratio)),
        load_sign=np.asarray(balls.load_sign(listed)),
    )  # fmt: skip


def _answer(results):
    """Return the `MeanMotion` of result columns (`Entry`)."""
    regime = np.nan_to_num(results[..., Entry.REGIME]).astype(int)
    results = np.where(regime[..., None] == SteadyRegime.UNKNOWN, math.nan, results)
    return MeanMotion(
        velocity=results[..., Entry.VELOCITY], first_order=results[..., Entry.FIRST_ORDER],
        height=results[..., Entry.HEIGHT], regime=REGIMES[regime], held=results[..., Entry.HELD] == 1.0,
        relative_error=results[..., Entry.ERROR], error_from_wave=results[..., Entry.FROM_WAVE],
        blocked_thrust=results[..., Entry.THRUST], blocked_thrust_error=results[..., Entry.THRUST_ERROR],
        load_sign=results[..., Entry.LOAD_SIGN],
    )  # fmt: skip


def _entries(sliders, waves, which, factors, wave_errors, threads):
    """Return the result columns (`Entry`) of every problem; the status is NaN if averaging does not apply."""
    which, factors = np.asarray(which, np.int64).reshape(-1, 2), np.array(factors, float)
    listed, contacts = [as_orbits(orbits) for orbits in waves], len(waves[0])
    parameters = np.array([numbers(slider, contacts) for slider in sliders])
    heights = np.array([slider.offsets(contacts) for slider in sliders])
    contact_factors = np.array([slider.contact_factors(contacts) for slider in sliders])
    omegas = np.array([orbits.omega for orbits in listed])
    normal, tangential = (np.array([getattr(orbits, name) for orbits in listed]) for name in ("normal", "tangential"))
    # every wave is solved as one whose crests drive towards +x (`orbit.towards_plus`)
    sides = np.where(np.sum(crest_velocities(omegas[:, None], normal, tangential), axis=1) < 0.0, -1.0, 1.0)
    paths = paths_of(normal, sides[:, None] * tangential, np.zeros(normal.shape))
    resonances = np.array([slider.normal_resonance(contacts) for slider in sliders])
    ratios = resonances[which[:, 0]] * 2.0 * math.pi / omegas[which[:, 1]]
    out = np.full((len(which), len(Entry)), math.nan)
    out[:, Entry.REGIME] = SteadyRegime.UNKNOWN
    averaged = factors > 0.0  # problems that averaging solves
    applies = {}  # by (slider, wave)
    for k, (slider, wave) in enumerate(which.tolist()):
        if (slider, wave) not in applies:
            applies[slider, wave] = not refusals(sliders[slider], listed[wave], STIFFEST_STEADY)
        averaged[k] &= applies[slider, wave]
        if not averaged[k]:
            _fill_closed(sliders[slider], towards_plus(listed[wave])[1], factors[k], out[k])
    errors = np.asarray(wave_errors, float)
    for law, law_numbers, own, members, harmonics in _by_law(sliders, which, np.flatnonzero(averaged)):
        problems = Sweep(
            parameters, law_numbers, law, own, heights, contact_factors, paths, omegas, errors, ratios, which,
            factors,
        )  # fmt: skip
        _solve(problems, out, members, harmonics, threads)
    side = sides[which[:, 1]]
    for column in (Entry.VELOCITY, Entry.FIRST_ORDER):
        out[:, column] = side * out[:, column] + 0.0  # no negative zero
    return out


def _by_law(sliders, which, averaged):
    """Yield (law, numbers, normal law, members, harmonics) for each kind of slider of the problems `averaged`.

    Of a kind are sliders of one tangential law, one normal law, and finite or infinite mass.
    `members` are its problems, `harmonics` those of the slider's motion within a cycle.

    A kernel is compiled for the functions of one law, so that laws which differ only in their numbers are one law here.
    `numbers` has shape (sliders, k). The entry of a slider with another law holds the numbers of the first slider with
    this law; no problem of this group uses it.
    """
    laws = [slider.tangential_law for slider in sliders]
    functions = [
        (law._replace(numbers=None), slider.profile_key, slider.mass == math.inf)
        for law, slider in zip(laws, sliders, strict=True)
    ]
    for kind in dict.fromkeys(functions):
        at = functions.index(kind)
        first, same = laws[at], np.array([other == kind for other in functions])
        numbers = np.array([(law if of_kind else first).numbers for law, of_kind in zip(laws, same, strict=True)])
        members = averaged[same[which[averaged, 0]]]
        if members.size:
            yield first, numbers, sliders[at].profile, members, 0 if kind[2] else HARMONICS


def _fill_closed(slider, orbits, factor, result):
    """Fill the result of a problem by a closed form, if one applies; its errors are zero."""
    try:
        closed = closed_form(slider, orbits.scaled(factor))
    except ConvergenceError:
        return
    if closed is None:
        return
    result[:] = 0.0
    result[Entry.LOAD_SIGN] = 1.0
    result[Entry.VELOCITY] = result[Entry.FIRST_ORDER] = closed["velocity"]
    result[Entry.HEIGHT], result[Entry.HELD] = closed["height"], closed["regime"] == "stick"
    result[Entry.REGIME] = np.flatnonzero(closed["regime"] == REGIMES)[0]


def _solve(problems, out, members, harmonics, threads):
    """Fill the results of `members` in several threads, interleaved because neighbours have similar cost."""
    threads = min(threads or os.cpu_count() or 1, max(1, len(members) // 8))
    if threads == 1:
        solve_problems(problems, out, members, harmonics, 0, 1)
        return
    with ThreadPoolExecutor(threads) as pool:
        jobs = [
            pool.submit(solve_problems, problems, out, members, harmonics, first, threads) for first in range(threads)
        ]
        for job in jobs:
            job.result()
