r"""Any number of sliders on any waves at once: velocities, their errors and what the wave's error makes of them.

Each problem is scaled and solved by itself in one compiled loop, so that its answer does not depend, to the last
bit, on which problems are computed beside it, nor on the number of threads. The steady state is that of `mean_motion`:
averaged, with the second-order correction. What that does not know or does not reach is marked, and left to `steady`.

The wave's relative error bounds the change of both amplitudes, a common phase apart, relative to the larger one. Four
changes of that size (both amplitudes up, down, their ratio, their phase) are tried in first order, whose derivatives
are good to O((f_n/f)^2), and their effects added in quadrature.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from contact.answers.averaged import HARMONICS, why_not
from contact.answers.steady import LARGEST_AVERAGED
from contact.drive import towards_plus
from contact.orbit import Orbit
from contact.slider import Slider

REGIMES = np.array(["unknown", "stick", "slip", "intermittent"])
# columns of an answer
VELOCITY, HEIGHT, REGIME, ERROR, FROM_WAVE, THRUST, HELD = range(7)
NODES = 20


@dataclass(frozen=True, kw_only=True)
class Population:
    """Steady states of many problems; arrays (n,), NaN where the regime is "unknown".

    Attributes
    ----------
    velocity : ndarray
        Mean, m/s; exactly 0 where held.
    height : ndarray
        Mean approach h, m.
    regime : ndarray of str
        "stick", "slip", "intermittent", or "unknown" where the averaged way does not apply or did not settle.
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
    height: np.ndarray
    regime: np.ndarray
    held: np.ndarray
    error: np.ndarray
    error_from_wave: np.ndarray
    blocked_thrust: np.ndarray


def steady_population(
    sliders: list[Slider],
    waves: list[tuple[Orbit, ...]],
    *,
    which: np.ndarray,
    factors: np.ndarray,
    wave_errors: np.ndarray,
    threads: int | None = None,
) -> Population:
    """Return the steady states of n problems.

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
    which, factors = np.asarray(which, np.int64).reshape(-1, 2), np.asarray(factors, float)
    contacts, number = len(waves[0]), len(which)
    rows = np.array([_row(slider) for slider in sliders])
    sides, driven = zip(*(towards_plus(orbits) for orbits in waves), strict=True)
    shapes = np.array([[_quarters(orbit) for orbit in orbits] for orbits in driven])
    omegas = np.array([orbits[0].omega for orbits in waves])
    apply, memory = np.ones(number, bool), {}
    for k, (slider, wave) in enumerate(which.tolist()):
        if (slider, wave) not in memory:
            memory[slider, wave] = not why_not(sliders[slider], driven[wave], LARGEST_AVERAGED)
        apply[k] = memory[slider, wave] and factors[k] > 0.0
    ratios = np.array([slider.normal_resonance(contacts) for slider in sliders])
    out = np.full((number, 7), math.nan)
    out[:, REGIME] = 0.0
    todo = np.flatnonzero(apply)
    _spread(
        (rows, shapes, omegas, np.asarray(wave_errors, float), ratios, which, factors, out, todo), threads
    )
    regime = out[:, REGIME].astype(int)
    out[regime == 0] = math.nan
    velocity = out[:, VELOCITY]
    velocity[velocity != 0.0] *= np.array(sides)[which[:, 1]][velocity != 0.0]  # no negative zero
    return Population(
        velocity=velocity, height=out[:, HEIGHT], regime=REGIMES[regime], held=out[:, HELD] == 1.0,
        error=out[:, ERROR], error_from_wave=out[:, FROM_WAVE], blocked_thrust=out[:, THRUST],
    )  # fmt: skip


def _row(s: Slider) -> tuple[float, ...]:
    return (
        s.mass, s.hertz_stiffness, s.limit_slope, s.preload, s.load, s.friction_coefficient, s.contact_damping,
        s.normal_damping, s.tangential_damping,
    )  # fmt: skip


def _quarters(orbit: Orbit) -> tuple[float, ...]:
    return orbit.normal.real, -orbit.normal.imag, orbit.tangential.real, -orbit.tangential.imag


def _spread(problem, threads):
    from contact.solve.averaged_sweep import states
    from contact.solve.cycle_mean import quadrature

    todo = problem[-1]
    threads = min(threads or os.cpu_count() or 1, max(1, len(todo) // 8))
    rule = quadrature(NODES)
    if threads == 1:
        states(*problem, rule, HARMONICS, 0, 1)
        return
    with ThreadPoolExecutor(threads) as pool:  # interleaved: neighbours cost alike
        jobs = [pool.submit(states, *problem, rule, HARMONICS, first, threads) for first in range(threads)]
        for job in jobs:
            job.result()
