"""A resonance at a fixed frequency that its own heat moves, and a power that grows with the temperature.

With the detuning x = 2 Q (f/f_0 - 1) against the cold peak and the power y over that of the peak,

    y (1 + (x - s b y)^2) = 1,    b = 2 Q |TCF| R W_peak,    s = sign of TCF

(TCF the temperature coefficient of the resonance's frequency, R in K/W). Two stable states exist from
b = 8/(3 sqrt 3) on. They end at folds, where dx/dy = 0: 4 b^2 y^3 (1 - y) = 1.
"""

import math

import numpy as np

from fem.exceptions import InputError

FOLDOVER_LIMIT = 8.0 / (3.0 * math.sqrt(3.0))  # 1.5396


def foldover_number(*, quality: float, frequency_coefficient: float, resistance: float, peak_power: float) -> float:
    """Return b = 2 Q |TCF| R W_peak.

    Parameters
    ----------
    quality : float
        Loaded quality factor of the resonance.
    frequency_coefficient : float
        TCF, 1/K; either sign.
    resistance : float
        Rise of the temperature per watt, K/W.
    peak_power : float
        Heat at the peak, W.
    """
    return 2.0 * quality * abs(frequency_coefficient) * resistance * peak_power


def folds(number: float, sign: float = 1.0) -> tuple[tuple[float, float], ...]:
    """Return detuning x and power y of the two folds, that of the smaller power first; none below the limit.

    ``sign``: of TCF. For a negative one the resonance moves down as it warms, and x changes its sign.

    Examples
    --------
    >>> [(round(x, 6), round(y, 6)) for x, y in folds(2.0)]
    [(2.0, 0.5), (2.134884, 0.919643)]
    >>> folds(1.5)
    ()
    """
    if number < FOLDOVER_LIMIT:
        return ()
    roots = np.roots([-4.0 * number**2, 4.0 * number**2, 0.0, 0.0, -1.0])
    powers = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-6 and 0.0 < root.real < 1.0)
    if len(powers) < 2:  # at the limit both are 3/4
        powers = [0.75, 0.75]
    side = math.copysign(1.0, sign)
    return tuple((side * (number * y + math.sqrt(1.0 / y - 1.0)), y) for y in powers)


def heated_powers(detuning: float, number: float, sign: float = 1.0) -> tuple[float, ...]:
    """Return the powers y over the peak's that are steady at a detuning x; three between the folds, rising.

    The outer two are stable, the middle one is not.
    """
    x = detuning * math.copysign(1.0, sign)
    roots = np.roots([number**2, -2.0 * number * x, 1.0 + x * x, -1.0]) if number else np.array([1.0 / (1.0 + x * x)])
    scale = 1.0 + abs(x)
    return tuple(sorted(float(root.real) for root in roots if abs(root.imag) < 1e-7 * scale and 0.0 < root.real))


def runaway_rise(power: float, resistance: float, growth: float) -> float:
    """Return the steady rise in K of a power that grows with the temperature, W = W_0 (1 + a T).

    Parameters
    ----------
    power : float
        W_0 at the surroundings' temperature, W.
    resistance : float
        K/W.
    growth : float
        a, 1/K.

    Raises
    ------
    InputError
        Where a R W_0 is 1 or more: there is no steady temperature.
    """
    product = growth * resistance * power
    if product >= 1.0:
        rule = "x resistance x power must be below 1, from which on each kelvin makes more heat than the plate loses"
        raise InputError("growth", rule, f"{product:.3g}")
    return resistance * power / (1.0 - product)
