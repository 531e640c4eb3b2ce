r"""The equations of a slider in the plane, in the units of a wave, and the motion of its contacts.

The body has the coordinates q = (z_s, x, y, psi) and the rates p; contact i is at r_i from the point about which the
body turns, R the rotation by psi:

    approach       z_i = h_i + u_z,i - z_s
    surface speed  w_i = u_t,i' - (x', y') - psi' e_z x R r_i,       e_z x r = (-Y, X)
    body           q_k'' = inverse_k (sum of the contacts' forces + force_k - damping_k p_k)

with inverse = (1/m, 1/m, 1/m, 1/J), or 0 for a coordinate that is held: a heavy slider has inverse = 0. Unit of time
1/omega of the fastest wave, of length ell = max(rest approach, largest amplitude), of force m omega^2 ell.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled, native
from contact.law.normal import NormalLaw


class Body(IntEnum):
    """Index of the coordinates."""

    HEIGHT = 0
    X = 1
    Y = 2
    YAW = 3


class Surface(IntEnum):
    """Index of the surface's displacement and velocity."""

    X = 0
    Y = 1
    Z = 2
    X_RATE = 3
    Y_RATE = 4
    Z_RATE = 5


ENDS = 1e-9  # phase behind the last knot up to which a segment that ends there reaches


class Knots(NamedTuple):
    """Factors on the waves of w frequencies, a exp(i p): linear between k knots, constant beyond; none: 1."""

    at: np.ndarray  # (k,): phase, rad, rising
    amplitude: np.ndarray  # (w, k)
    angle: np.ndarray  # (w, k), rad


UNSHAPED = Knots(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)))


class PlaneProblem(NamedTuple):
    """A dimensionless problem; n contacts, w frequencies."""

    friction: float  # mu
    contact_damping: float  # chi
    normal: NormalLaw
    inverse: np.ndarray  # (4,), by `Body`
    force: np.ndarray  # (4,): preload, load and torque, with the sign in which they act on the slider
    damping: np.ndarray  # (4,)
    # Of the contacts, (n,): position from the axis of rotation, height, stiffness of P = kappa p(z), c
    x: np.ndarray
    y: np.ndarray
    height: np.ndarray
    stiffness: np.ndarray
    limit_slope: np.ndarray
    # Of the surface under each contact: u = e(phase) sum (cos_k cos(ratio_k phase) + sin_k sin(ratio_k phase))
    ratio: np.ndarray  # (w,): frequencies over that of the unit of time
    cos: np.ndarray  # (w, n, 3)
    sin: np.ndarray
    # The envelope e: 1 - exp(-phase/rise) up to `stop`, then falling with the same constant; 1 and 0 where rise is 0
    rise: float
    stop: float
    knots: Knots  # times this factor on the wave of each frequency, a exp(i p)


@compiled
def envelope(problem, phase):
    """Return the envelope and its rate."""
    if problem.rise == 0.0:
        return (1.0 if phase <= problem.stop else 0.0), 0.0
    if phase <= problem.stop:
        fall = np.exp(-phase / problem.rise)
        return 1.0 - fall, fall / problem.rise
    left = (1.0 - np.exp(-problem.stop / problem.rise)) * np.exp(-(phase - problem.stop) / problem.rise)
    return left, -left / problem.rise


@compiled
def factor_of(knots, j, phase):
    """Return (amplitude, its rate, angle, its rate) of the factor on the wave of frequency j.

    At a knot the rates are those behind it, at the last one those before it.
    """
    at = knots.at
    low, high = 0, at.size - 1
    if phase < at[0] or phase > at[high] + ENDS or high == 0:
        k = 0 if phase < at[0] else high
        return knots.amplitude[j, k], 0.0, knots.angle[j, k], 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if at[middle] <= phase:
            low = middle
        else:
            high = middle
    width = at[high] - at[low]
    a, p = knots.amplitude[j, low], knots.angle[j, low]
    a_rate, p_rate = (knots.amplitude[j, high] - a) / width, (knots.angle[j, high] - p) / width
    return a + a_rate * (phase - at[low]), a_rate, p + p_rate * (phase - at[low]), p_rate


@compiled
def _add_wave(problem, j, first, last, angle, nu, e, e_rate, out):
    """Add the wave of frequency j at an angle that grows at the rate nu, times a factor e."""
    c, s = np.cos(angle), np.sin(angle)
    for i in range(first, last):
        for k in range(3):
            a, b = problem.cos[j, i, k], problem.sin[j, i, k]
            u = a * c + b * s
            out[i, k] += e * u
            out[i, 3 + k] += e * nu * (b * c - a * s) + e_rate * u


@compiled
def _add_shaped(problem, first, last, phase, e, e_rate, out):
    """Add the waves with the factors of the knots, times a factor e."""
    for j in range(problem.ratio.size):
        a, a_rate, p, p_rate = factor_of(problem.knots, j, phase)
        nu = problem.ratio[j]
        _add_wave(problem, j, first, last, nu * phase + p, nu + p_rate, e * a, e_rate * a + e * a_rate, out)


@native("t i i f f2")
def fill_surface(problem, first, last, phase, out):
    """Fill displacement and velocity of the surface (`Surface`) under contacts `first` to `last` at a phase; return 0.

    Machine code of its own, for it is called from Python: numba's cache knows the law's functions in no other process,
    and its index, which grew by every process, could not be written any more after some twenty.
    """
    e, e_rate = envelope(problem, phase)
    for i in range(first, last):
        for k in range(6):
            out[i, k] = 0.0
    if problem.knots.at.size > 0:
        _add_shaped(problem, first, last, phase, e, e_rate, out)
        return 0
    for j in range(problem.ratio.size):
        nu = problem.ratio[j]
        _add_wave(problem, j, first, last, nu * phase, nu, e, e_rate, out)
    return 0


@compiled
def turned_by(problem, i, before, after):
    """Return how far a turn from one yaw to another moves contact i.

    A difference of two positions would round at 1e-16 of the arm, which is 1e5 of the lengths here.
    """
    half = 0.5 * (after - before)
    size, c, s = 2.0 * np.sin(half), np.cos(before + half), np.sin(before + half)
    return -size * (s * problem.x[i] + c * problem.y[i]), size * (c * problem.x[i] - s * problem.y[i])
