r"""Averaged steady states of one slider or of many: velocities, their errors, and the effect of the wave's error.

Each problem is scaled and solved by itself in one compiled loop (`solve.averaged_sweep`), with the second-order
correction, so that its answer does not depend, to the last bit, on which problems are computed beside it, nor on the
number of threads. A single steady state (`mean_motion`) and a map over amplitude and preload (`steady_map`) are sweeps.
What averaging does not know or does not reach has the regime "unknown", and is left to `steady`.

The wave's relative error bounds the change of both amplitudes, a common phase apart, relative to the larger one. Four
changes of that size (both amplitudes up, down, their ratio, their phase) are tried in first order, whose derivatives
are good to O((f_n/f)^2), and their effects added in quadrature.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from contact import bounds
from contact.answers.averaged import HARMONICS, STIFFEST_STEADY, refuse_unless_applicable, why_not
from contact.answers.closed_forms import closed_form
from contact.codes import Status, Steady
from contact.convergence import ConvergenceError
from contact.drive import reference_speed, towards_plus
from contact.kinematics import Paths
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

REGIMES = np.array([regime.name.lower() for regime in Steady])


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Steady states of many problems; arrays of one shape, NaN where the regime is "unknown".

    Attributes
    ----------
    velocity : ndarray
        Mean, m/s; exactly 0 where held.
    first_order : ndarray
        The velocity without the second-order correction, m/s.
    height : ndarray
        Mean approach h, m; negative where the slider rides above the surface at rest.
    regime : ndarray of str
        "stick", "slip", "intermittent", or "unknown" where averaging does not apply or did not settle.
    held : ndarray of bool
        Whether friction keeps the slider at rest.
    error : ndarray
        Of the velocity as computed, over max(|v|, omega |u_x|/10).
    error_from_wave : ndarray
        What the wave's error makes of it, over the same.
    blocked_thrust : ndarray
        Load at which the slider stalls, N; 0 where the unloaded slider is held.
    """

    velocity: np.ndarray
    first_order: np.ndarray
    height: np.ndarray
    regime: np.ndarray
    held: np.ndarray
    error: np.ndarray
    error_from_wave: np.ndarray
    blocked_thrust: np.ndarray


@dataclass(frozen=True, kw_only=True)
class MeanMotion:
    """One averaged steady state.

    Attributes
    ----------
    velocity : float
        Mean, m/s; exactly 0 when held.
    first_order : float
        The velocity without the second-order correction, m/s.
    height : float
        Mean approach h, m.
    regime : str
        "stick", "slip" or "intermittent".
    held : bool
        Whether friction keeps the slider at rest.
    relative_error : float
        Estimated error of `velocity` over max(|v|, omega |u_x|/10).
    error : float
        The same in m/s.
    load_sign : float
        +1 where the load opposes motion in the direction in which the crests drive, -1 where the opposite.
    """

    velocity: float
    first_order: float
    height: float
    regime: str
    held: bool
    relative_error: float
    error: float
    load_sign: float


def steady_sweep(
    sliders: list[Slider],
    waves: list[tuple[Orbit, ...]],
    *,
    which: np.ndarray,
    factors: np.ndarray,
    wave_errors: np.ndarray,
    threads: int | None = None,
) -> Sweep:
    """Return the steady states of n problems, as arrays (n,).

    Parameters
    ----------
    sliders : list of Slider
    waves : list of tuple of Orbit
        One orbit per contact, all tuples of one length.
    which : (n, 2) array of int
        Slider and wave of each problem.
    factors : (n,) array
        On the wave's amplitudes, zero or positive.
    wave_errors : (w,) array
        Relative, of the waves.
    threads : int, optional
        As many as there are processors when absent.
    """
    rows = _rows(sliders, waves, np.asarray(which, np.int64).reshape(-1, 2), factors, wave_errors, threads)
    return _sweep(rows, (len(rows),))


def steady_map(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    factors: np.ndarray,
    preloads: np.ndarray,
    threads: int | None = None,
) -> Sweep:
    """Return steady states over factors on the orbits and preloads in N, as arrays (preloads, factors).

    Parameters
    ----------
    slider : Slider
        Its own preload is not used.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact at factor 1.
    factors : (n,) array
        Zero or positive.
    preloads : (m,) array
        N, positive.
    threads : int, optional
        As many as there are processors when absent.
    """
    factors, preloads = np.atleast_1d(np.asarray(factors, float)), np.atleast_1d(np.asarray(preloads, float))
    for factor in factors:
        bounds.non_negative("factors", factor, "")
    for preload in preloads:
        bounds.positive("preloads", preload, "N")
    sliders = [replace(slider, preload=float(preload)) for preload in preloads]
    which = np.zeros((preloads.size * factors.size, 2), np.int64)
    which[:, 0] = np.repeat(np.arange(preloads.size), factors.size)
    rows = _rows(sliders, [as_orbits(orbits)], which, np.tile(factors, preloads.size), np.zeros(1), threads)
    return _sweep(rows, (preloads.size, factors.size))


def mean_motion(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> MeanMotion:
    """Return the steady state by averaging with the second-order correction.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact.

    Raises
    ------
    ConvergenceError
        Status "not applicable", "runaway" or "not converged".
    """
    from contact.solve import averaged_sweep

    listed = as_orbits(orbits)
    row = _rows([slider], [listed], np.zeros((1, 2), np.int64), np.ones(1), np.zeros(1), 1)[0]
    status = row[averaged_sweep.STATUS]
    if math.isnan(status):
        closed_form(slider, listed)  # says so if it runs away
        refuse_unless_applicable(slider, listed, STIFFEST_STEADY)
    if status == Status.RUNAWAY:
        raise ConvergenceError(
            "runaway",
            "friction cannot balance the load at any speed and no tangential damping bounds it; "
            "lower slider.load or give slider.damping.tangential",
        )
    if status == Status.NEAR_THRESHOLD:
        raise ConvergenceError(
            "not applicable",
            "the slider is held, but so near the threshold that averaging cannot tell; use method exact",
        )
    if status != Status.DONE or row[averaged_sweep.REGIME] == Steady.UNKNOWN:
        raise ConvergenceError("not converged", "the averaged motion was not reached; use method exact")
    velocity, relative = float(row[averaged_sweep.VELOCITY]), float(row[averaged_sweep.ERROR])
    return MeanMotion(
        velocity=velocity, first_order=float(row[averaged_sweep.FIRST_ORDER]),
        height=float(row[averaged_sweep.HEIGHT]), regime=str(REGIMES[int(row[averaged_sweep.REGIME])]),
        held=bool(row[averaged_sweep.HELD]), relative_error=relative,
        error=relative * reference_speed(velocity, listed),
        load_sign=float(row[averaged_sweep.SIGN_OF_LOAD]),
    )  # fmt: skip


def _sweep(rows, shape):
    from contact.solve import averaged_sweep as columns

    regime = np.nan_to_num(rows[:, columns.REGIME]).astype(int)
    rows[regime == Steady.UNKNOWN] = math.nan
    column = {
        name: rows[:, getattr(columns, name)].reshape(shape)
        for name in ("VELOCITY", "FIRST_ORDER", "HEIGHT", "HELD", "ERROR", "FROM_WAVE", "THRUST")
    }
    return Sweep(
        velocity=column["VELOCITY"], first_order=column["FIRST_ORDER"], height=column["HEIGHT"],
        regime=REGIMES[regime].reshape(shape), held=column["HELD"] == 1.0, error=column["ERROR"],
        error_from_wave=column["FROM_WAVE"], blocked_thrust=column["THRUST"],
    )  # fmt: skip


def _rows(sliders, waves, which, factors, wave_errors, threads):
    """Return the columns of `averaged_sweep` of every problem; NaN as status where averaging does not apply."""
    from contact.solve import averaged_sweep as columns

    number, contacts = len(which), len(waves[0])
    factors = np.asarray(factors, float)
    parameters = np.array([_parameters(slider, contacts) for slider in sliders])
    heights = np.array([slider.offsets(contacts) for slider in sliders])
    sides, driven = zip(*(towards_plus(orbits) for orbits in waves), strict=True)
    u_z, u_x = (
        np.array([[getattr(orbit, name) for orbit in orbits] for orbits in driven])
        for name in ("normal", "tangential")
    )
    paths = Paths(np.zeros(u_z.shape), u_z.real.copy(), -u_z.imag, u_x.real.copy(), -u_x.imag)
    omegas = np.array([orbits[0].omega for orbits in waves])
    resonances = np.array([slider.normal_resonance(contacts) for slider in sliders])
    ratios = resonances[which[:, 0]] * 2.0 * math.pi / omegas[which[:, 1]]
    out = np.full((number, columns.ANSWER), math.nan)
    out[:, columns.REGIME] = Steady.UNKNOWN
    apply, known = factors > 0.0, {}
    for k, pair in enumerate(map(tuple, which.tolist())):
        if pair not in known:
            known[pair] = not why_not(sliders[pair[0]], driven[pair[1]], STIFFEST_STEADY)
        apply[k] &= known[pair]
        if not apply[k]:
            _fill_closed(sliders[pair[0]], driven[pair[1]], factors[k], out[k])
    todo = np.flatnonzero(apply)
    given = columns.Given(
        parameters, heights, paths, omegas, np.asarray(wave_errors, float), ratios, which, factors
    )
    _spread(given, out, todo, threads)
    side = np.array(sides)[which[:, 1]]
    for column in (columns.VELOCITY, columns.FIRST_ORDER):
        out[:, column] = side * out[:, column] + 0.0  # no negative zero
    return out


def _fill_closed(slider, orbits, factor, row):
    """Fill the row of a problem with a closed form, if it has one; its errors are zero."""
    from contact.solve import averaged_sweep as columns

    try:
        found = closed_form(slider, tuple(orbit.scaled(factor) for orbit in orbits))
    except ConvergenceError:
        return
    if found is None:
        return
    row[:] = 0.0
    row[columns.SIGN_OF_LOAD] = 1.0
    row[columns.VELOCITY] = row[columns.FIRST_ORDER] = found["velocity"]
    row[columns.HEIGHT], row[columns.HELD] = found["height"], found["regime"] == "stick"
    row[columns.REGIME] = np.flatnonzero(found["regime"] == REGIMES)[0]


def _parameters(s: Slider, contacts: int) -> tuple[float, ...]:
    return (
        s.mass, s.normal_stiffness, s.limit_slope, s.preload, s.load, s.friction_coefficient, s.contact_damping,
        s.normal_damping, s.tangential_damping, float(s.contact_shape),
        float(np.max(s.rest_approaches(contacts))),
    )  # fmt: skip


def _spread(given, out, todo, threads):
    from contact.solve.averaged_sweep import states

    threads = min(threads or os.cpu_count() or 1, max(1, len(todo) // 8))
    if threads == 1:
        states(given, out, todo, HARMONICS, 0, 1)
        return
    with ThreadPoolExecutor(threads) as pool:  # interleaved: neighbours cost alike
        jobs = [pool.submit(states, given, out, todo, HARMONICS, first, threads) for first in range(threads)]
        for job in jobs:
            job.result()
