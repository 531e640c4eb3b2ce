r"""An independent witness for the seed's motor: one contact, SI units, classical Runge-Kutta in very small steps.

Shares nothing with the product: the paper's formulas as printed (contact radius by a cube root,
x_max = 3 mu P/(16 a G)), the four-stage Runge-Kutta method in fixed steps, events by bisection of the step's length
with the far side accepted. Neither x = 0 nor the square roots at contact and slip are treated: the steps are so small
that the error of order 2.5 per event is 1e-8 and below at 1000 steps per cycle. Velocities are sums of a million
increments in double precision: steady velocities carry rounding of about 1e-8.
"""

import math

import numpy as np
from numba import njit
from scipy.integrate import quad
from scipy.optimize import brentq

from tests import seed_motor

MOTOR = {
    "radius": 1e-3,
    **seed_motor.BODY,
    "mu": 0.08,
    "E": 64e9,
    "G": 12e9,
    **seed_motor.DAMPERS,
    "frequency": 2.2e6,
    "ratio": 0.7,
}
ORDER = tuple(MOTOR)


@njit(cache=True)
def _forces(z, x, regime, s, R, mu, E, G):
    if regime == 0 or z <= 0.0:
        return 0.0, 0.0
    P = 4.0 / 3.0 * E * math.sqrt(R) * z**1.5
    if regime == 2:
        return P, s * mu * P
    a = (3.0 * P * R / (4.0 * E)) ** (1.0 / 3.0)
    argument = 1.0 - 16.0 * abs(x) * a * G / (3.0 * mu * P)
    Q = mu * P * (1.0 - max(argument, 0.0) ** 1.5)
    return P, (Q if x >= 0.0 else -Q)


@njit(cache=True)
def _rates(t, zs, w, v, x, regime, s, A, p):
    R, m, F, mu, E, G, rn, rt, f, ratio = p
    om = 2.0 * math.pi * f
    P, Q = _forces(A * math.sin(om * t) - zs, x, regime, s, R, mu, E, G)
    vt = ratio * A * om * math.sin(om * t)
    return w, (P - rn * w - F) / m, (Q - rt * v) / m, (vt - v if regime == 1 else 0.0)


@njit(cache=True)
def _step(t, h, y, regime, s, A, p):
    zs, w, v, x = y
    a1, b1, c1, d1 = _rates(t, zs, w, v, x, regime, s, A, p)
    k = 0.5 * h
    a2, b2, c2, d2 = _rates(t + k, zs + k * a1, w + k * b1, v + k * c1, x + k * d1, regime, s, A, p)
    a3, b3, c3, d3 = _rates(t + k, zs + k * a2, w + k * b2, v + k * c2, x + k * d2, regime, s, A, p)
    a4, b4, c4, d4 = _rates(t + h, zs + h * a3, w + h * b3, v + h * c3, x + h * d3, regime, s, A, p)
    k = h / 6.0
    return (
        zs + k * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        w + k * (b1 + 2.0 * b2 + 2.0 * b3 + b4),
        v + k * (c1 + 2.0 * c2 + 2.0 * c3 + c4),
        x + k * (d1 + 2.0 * d2 + 2.0 * d3 + d4),
    )


@njit(cache=True)
def _slip_limit(z, R, mu, E, G):
    P = 4.0 / 3.0 * E * math.sqrt(R) * max(z, 0.0) ** 1.5
    a = (3.0 * P * R / (4.0 * E)) ** (1.0 / 3.0)
    return 3.0 * mu * P / (16.0 * a * G) if a > 0.0 else 0.0


@njit(cache=True)
def _violated(t, y, regime, s, A, p):
    """0: the regime may go on; 1: contact or release; 2: stick or slip ends."""
    R, _, _, mu, E, G, _, _, f, ratio = p
    om = 2.0 * math.pi * f
    zs, w, v, x = y
    z = A * math.sin(om * t) - zs
    if regime == 0:
        return 1 if z > 0.0 else 0
    if z <= 0.0:
        return 1
    if regime == 1:
        return 2 if abs(x) > _slip_limit(z, R, mu, E, G) else 0
    slope = 0.25 * mu * E / G
    vf = s * (ratio * A * om * math.sin(om * t) - v) - slope * (A * om * math.cos(om * t) - w)
    return 2 if vf < 0.0 else 0


@njit(cache=True)
def run(A, p, y, regime, s, t, steps, per_cycle):
    """Return (state, regime, sign, mean v) after a number of steps from time t; the wave is A sin, r A sin' ."""
    R, _, _, mu, E, G, _, _, f, ratio = p
    om = 2.0 * math.pi * f
    h = 1.0 / f / per_cycle
    t0, mean = t, 0.0
    for k in range(steps):
        t, stop = t0 + k * h, t0 + (k + 1) * h
        for _ in range(50):
            left = stop - t
            if left <= 0.0:
                break
            new = _step(t, left, y, regime, s, A, p)
            why = _violated(stop, new, regime, s, A, p)
            took = left
            if why > 0:
                lo, hi = 0.0, left
                for _ in range(60):
                    mid = 0.5 * (lo + hi)
                    trial = _step(t, mid, y, regime, s, A, p)
                    hit = _violated(t + mid, trial, regime, s, A, p)
                    if hit > 0:
                        hi, new, why = mid, trial, hit
                    else:
                        lo = mid
                took = hi
            mean += 0.5 * took * (y[2] + new[2])
            t, y = t + took, new
            zs, w, v, x = y
            z = A * math.sin(om * t) - zs
            vt = ratio * A * om * math.sin(om * t)
            slope = 0.25 * mu * E / G
            zr = A * om * math.cos(om * t) - w
            if why == 1:
                if regime != 0:
                    regime, x = 0, 0.0
                else:
                    s = 1.0 if vt - v > 0.0 else -1.0
                    regime = 2 if s * (vt - v) - slope * zr > 0.0 else 1
                    x = 0.0
            elif why == 2:
                if regime == 1:
                    s = 1.0 if x > 0.0 else -1.0
                    if s * (vt - v) - slope * zr > 0.0:
                        regime = 2
                    else:
                        x = s * _slip_limit(z, R, mu, E, G) * (1.0 - 1e-15)
                else:
                    regime, x = 1, s * _slip_limit(z, R, mu, E, G) * (1.0 - 1e-15)
            y = (zs, w, v, x)
            if took == left:
                break
        if regime == 2:  # keep x up to date, for who looks at it
            z = A * math.sin(om * stop) - y[0]
            y = (y[0], y[1], y[2], s * _slip_limit(z, R, mu, E, G))
    return y, regime, s, mean / (steps * h)


def parameters(**changed) -> tuple[float, ...]:
    """Return the motor's parameters in the order `run` wants, some of them changed."""
    motor = MOTOR | changed
    return tuple(float(motor[name]) for name in ORDER)


def rest_height(p) -> float:
    """Return the approach at rest by root finding on Hertz's law."""
    R, F, E = p[0], p[2], p[4]
    return brentq(lambda z: 4.0 / 3.0 * E * math.sqrt(R) * z**1.5 - F, 0.0, 1e-3, xtol=1e-300, rtol=1e-15)


def velocity_from_rest(A: float, cycles: int, per_cycle: int, **changed) -> float:
    """Return v in m/s after a number of cycles from rest; u_z = A sin, surface velocity r A omega sin."""
    p = parameters(**changed)
    y, *_ = run(A, p, (-rest_height(p), 0.0, 0.0, 0.0), 1, 1.0, 0.0, cycles * per_cycle, per_cycle)
    return y[2]


def steady_velocity(A: float, per_cycle: int, **changed) -> float:
    """Return the mean velocity of the periodic motion: secant on a frozen slider, then Newton on the cycle map."""
    p = parameters(**changed)
    R, F, E, f = p[0], p[2], p[4], p[8]
    K = 4.0 / 3.0 * E * math.sqrt(R)

    def mean_force(h):
        half = math.pi if h >= A else math.acos(-h / A)
        return K * quad(lambda q: max(h + A * math.cos(q), 0.0) ** 1.5, 0.0, half, epsabs=0, epsrel=1e-10)[0] / math.pi

    h = brentq(lambda q: mean_force(q) - F, -A, rest_height(p), rtol=1e-12)
    trough = 0.75 / f
    heavy = parameters(**(changed | {"mass": 1e30, "tangential_damping": 0.0, "normal_damping": 0.0}))

    def cycle(par, y):
        """One cycle from the trough, the deformation first settled on a slider of boundless mass."""
        z = -A - y[0]
        slope = 0.25 * p[3] * p[4] / p[5]
        regime, x = (2, -slope * z) if z > 0.0 else (0, 0.0)
        out = ((*y, x), regime, -1.0, 0.0)
        for _ in range(3):
            out = run(A, heavy, out[0], out[1], out[2], trough, per_cycle, per_cycle)
        return run(A, par, (*y, out[0][3]), out[1], out[2], trough, per_cycle, per_cycle)

    def drag(v):  # mean traction: what a slider 1e6 times as heavy gains in a cycle
        light = parameters(**(changed | {"mass": p[1] * 1e6, "tangential_damping": 0.0, "normal_damping": 0.0}))
        return (cycle(light, (-h, 0.0, v))[0][2] - v) * light[1] * f - p[7] * v

    top = 2.0 * math.pi * f * MOTOR["ratio"] * A
    v = brentq(drag, 1e-3 * top, top, rtol=1e-6)
    y = np.array([-h, 0.0, v])
    scale = np.array([1e-9, 1e-9 * 2 * math.pi * f, 1.0])

    def gap(q):
        return (np.array(cycle(p, tuple(q))[0][:3]) - q) / scale

    base = gap(y)
    jacobian = np.empty((3, 3))
    for k in range(3):
        near = y.copy()
        near[k] += 1e-5 * (scale[k] if k < 2 else v)
        jacobian[:, k] = (gap(near) - base) / (near[k] - y[k])
    x, regime, s = 0.0, -1, 0.0
    for _ in range(30):
        # from the second time on the deformation is that which the last cycle left, not a heavy slider's
        if regime < 0:
            out = cycle(p, tuple(y))
        else:
            out = run(A, p, (*y, x), regime, s, trough, per_cycle, per_cycle)
        x, regime, s, mean = out[0][3], out[1], out[2], out[3]
        move = np.linalg.solve(jacobian, (y - np.array(out[0][:3])) / scale)
        y = y + move
        if abs(move[2]) < 1e-12 * abs(v):
            break
    return mean
