r"""Many sliders at once: steady velocities over amplitude and preload, and full simulations.

The steady states are those of `mean_motion`, one after the other in a compiled loop and shared among threads (the
kernels hold no lock). What the averaged way does not know, or does not reach, is marked and left to `steady`.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from contact import bounds, scaling
from contact.answers.averaged import HARMONICS, STIFFEST_STEADY, why_not
from contact.drive import towards_plus
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

REGIMES = np.array(["stick", "slip", "intermittent", "unknown"])
STICK, SLIP, INTERMITTENT, UNKNOWN = 0, 1, 2, 3
POWERS = (
    (scaling.KAPPA, 0.5), (scaling.CHI, 1.0), (scaling.PRELOAD, -1.0), (scaling.LOAD, -1.0), (scaling.STICK_BAND, -1.0),
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class SteadyMap:
    """Steady states of one slider over amplitude and preload; arrays (preloads, amplitudes).

    Attributes
    ----------
    factors : (n,) array
        On the orbits.
    preloads : (m,) array
        N.
    velocity : (m, n) array
        Mean, m/s; nan where unknown.
    height : (m, n) array
        Mean approach h, m; negative when the slider rides above the surface at rest.
    regime : (m, n) array of str
        "stick", "slip", "intermittent", or "unknown" where the averaged way does not apply.
    error : (m, n) array
        Estimated, m/s.
    """

    factors: np.ndarray
    preloads: np.ndarray
    velocity: np.ndarray
    height: np.ndarray
    regime: np.ndarray
    error: np.ndarray


def steady_map(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    factors: np.ndarray,
    preloads: np.ndarray,
    workers: int | None = None,
) -> SteadyMap:
    """Return steady states over factors on the orbits and preloads in N.

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
    workers : int, optional
        Threads; as many as there are processors when absent.
    """
    listed = as_orbits(orbits)
    factors, preloads = np.atleast_1d(np.asarray(factors, float)), np.atleast_1d(np.asarray(preloads, float))
    for factor in factors:
        bounds.non_negative("factors", factor, "")
    for preload in preloads:
        bounds.positive("preloads", preload, "N")
    side, driven = towards_plus(listed)
    shape = (preloads.size, factors.size)
    parameters = np.empty((*shape, scaling.scaled(slider, driven, direction=1.0, start=0.0).parameters.size))
    waves, speeds, lengths = np.empty((*shape, len(driven), 4)), np.empty(shape), np.empty(shape)
    known = np.zeros(shape, bool)
    # the scaled parameters go with powers of the length unit: no Python per point
    unit = np.array([[o.normal.real, -o.normal.imag, o.tangential.real, -o.tangential.imag] for o in driven])
    reach = max(max(abs(o.normal), abs(o.tangential)) for o in driven)
    for k, preload in enumerate(preloads):
        loaded = replace(slider, preload=float(preload))
        length = np.maximum(np.maximum(loaded.rest_approach(len(driven)), reach * factors), 1e-300)
        base = scaling.scaled(loaded, driven, direction=1.0, start=0.0)
        parameters[k] = base.parameters
        for name, power in POWERS:
            parameters[k, :, name] *= (length / base.length) ** power
        waves[k] = unit * (factors / length)[:, None, None]
        lengths[k], speeds[k] = length, length * driven[0].omega
        known[k] = not why_not(loaded, driven, STIFFEST_STEADY) if np.any(factors > 0.0) else False
    out, why = _swept(
        parameters.reshape(-1, parameters.shape[-1]), waves.reshape(-1, len(driven), 4), workers
    )
    out, why = out.reshape(*shape, 7), why.reshape(shape)
    still = np.broadcast_to(factors == 0.0, shape)
    found = (why == 0) & known & ~still
    backwards = (
        found & (out[..., 0] < 0.0) & (slider.load > 0.0)
    )  # which way the load points is `mean_motion`'s to say
    found &= ~backwards
    regime = np.where(out[..., 4] > 0, INTERMITTENT, np.where(out[..., 5] > 0, SLIP, STICK))
    regime = np.where(found, regime, np.where(still, STICK, UNKNOWN))
    velocity = np.where(found, side * out[..., 0] * speeds, np.where(still, 0.0, math.nan))
    error = np.maximum.reduce([out[..., 6], out[..., 2], 1e-11 * abs(out[..., 0])]) * speeds
    return SteadyMap(
        factors=factors, preloads=preloads, velocity=velocity, height=out[..., 1] * lengths,
        regime=REGIMES[regime], error=np.where(found, error, np.where(still, 0.0, math.nan)),
    )  # fmt: skip


def _swept(parameters, waves, workers):
    """Return (out, why) of `averaged.balances`, in slices among threads."""
    from contact.solve import averaged
    from contact.solve.cycle_mean import quadrature

    number = len(parameters)
    workers = min(workers or os.cpu_count() or 1, max(1, number // 8))
    out, why = np.zeros((number, 7)), np.zeros(number, np.int64)
    rule = quadrature(16)
    # interleaved slices: neighbours cost alike
    if workers == 1:
        averaged.balances(parameters, waves, rule, HARMONICS, out, why, 0, 1)
        return out, why
    with ThreadPoolExecutor(workers) as pool:
        jobs = [
            pool.submit(averaged.balances, parameters, waves, rule, HARMONICS, out, why, first, workers)
            for first in range(workers)
        ]
        for job in jobs:
            job.result()
    return out, why
