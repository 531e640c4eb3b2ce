"""Steady states of a body whose heat depends on its own temperature, from samples of that dependence.

With the temperature as the parameter nothing is iterated: at each rise t above the surroundings the powers are known,
and with them the rise m(t) that they would hold; a steady state is m(t) = t, stable where m falls below t beyond it. A
resonance whose heat depends on the frequency alone, m(u), is met at a rise m by the drive u (1 + TCF m), which has an
extremum at each fold (`fem.heat.hot_resonance` has both in closed form for one resonance).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fem.exceptions import InputError
from fem.heat.hot_resonance import FOLDOVER_LIMIT

MIN_SAMPLES = 4  # of a cubic spline


@dataclass(frozen=True, kw_only=True)
class HeatedState:
    """A steady state.

    Attributes
    ----------
    rise : float
        Above the surroundings, K.
    stable : bool
        True if a body that is a little warmer cools, and one that is a little cooler warms.
    """

    rise: float
    stable: bool


def heated_states(rises: ArrayLike, held: ArrayLike) -> tuple[HeatedState, ...]:
    """Return the steady states among sampled rises, the coolest first: that which a cold start comes to.

    Parameters
    ----------
    rises : array_like, shape (n,)
        Sampled rises t, rising, K.
    held : array_like, shape (n,)
        Rise m(t) that the powers at each would hold, K; between the samples a cubic spline.

    Examples
    --------
    >>> heated_states([0.0, 10.0, 20.0, 30.0], [12.0, 11.0, 10.0, 9.0])
    (HeatedState(rise=10.909..., stable=True),)
    """
    from scipy.interpolate import CubicSpline

    at = _sampled("rises", rises)
    excess = CubicSpline(at, np.asarray(held, dtype=float) - at)
    return tuple(
        HeatedState(rise=float(root), stable=bool(excess(root, 1) < 0.0)) for root in excess.roots(extrapolate=False)
    )


def drive_folds(frequencies: ArrayLike, held: ArrayLike, coefficient: float) -> tuple[float, ...]:
    """Return the drive frequencies in Hz at which steady states of a resonance meet and vanish, rising.

    Parameters
    ----------
    frequencies : array_like, shape (n,)
        Sampled frequencies u of the cold body, rising, Hz.
    held : array_like, shape (n,)
        Rise in K that the powers at each would hold.
    coefficient : float
        TCF, 1/K.
    """
    from scipy.interpolate import CubicSpline

    at = _sampled("frequencies", frequencies)
    drive = CubicSpline(at, at * (1.0 + coefficient * np.asarray(held, dtype=float)))
    return tuple(sorted(drive(drive.derivative().roots(extrapolate=False)).tolist()))


def sampled_foldover_number(frequencies: ArrayLike, held: ArrayLike, coefficient: float) -> float:
    """Return the foldover number of sampled powers, of any number of resonances above any floor.

    Two stable states exist where d(drive)/du = 0 somewhere, from TCF dm/d(ln u) = -1 on; a lone resonance has its
    steepest flank at b / 1.5396. Parameters as of `drive_folds`.
    """
    from scipy.interpolate import CubicSpline

    at = _sampled("frequencies", frequencies)
    slope = CubicSpline(at, np.asarray(held, dtype=float)).derivative()
    turns = slope.derivative().roots(extrapolate=False)
    steepest = -coefficient * np.append(turns * slope(turns), at * slope(at))
    return float(max(steepest.max(), 0.0)) * FOLDOVER_LIMIT


def _sampled(key: str, values: ArrayLike) -> np.ndarray:
    at = np.asarray(values, dtype=float)
    if at.ndim != 1 or len(at) < MIN_SAMPLES or not np.all(np.diff(at) > 0.0):
        raise InputError(key, f"must be at least {MIN_SAMPLES} rising numbers")
    return at
