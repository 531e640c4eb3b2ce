"""Mean friction of a ball on one wave along a line: roots by scipy, 100 nodes of quadrature between events. SI units.

The slider keeps height and velocity within a cycle. While the ball sticks its deformation follows the surface, at the
limit c z it slips; its force is mu (P(z) - P(z - |x|/c)) sign x (Ciavarella 1998). Every integrand has the square roots
at both ends of its interval taken out by t = a + (b - a) sin^2.
"""

import math
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

NODES = np.polynomial.legendre.leggauss(100)  # 60 give the same to 1e-14
GRID = 4000  # points between which a root is bracketed


def _integral(f, a, b):
    """Return the integral of f from a to b."""
    theta = 0.25 * math.pi * (NODES[0] + 1.0)
    values = np.array([f(a + (b - a) * math.sin(each) ** 2) for each in theta])
    return 0.25 * math.pi * (b - a) * float(np.sum(NODES[1] * np.sin(2.0 * theta) * values))


def _first_fall(f, a, b, small):
    """Return where f first falls below zero between a and b, or b."""
    grid = np.linspace(a, b, GRID + 1)
    for low, high in pairwise(grid):
        if f(high) < -small:
            return brentq(f, low, high, xtol=1e-16, rtol=1e-15) if f(low) > 0.0 else low
    return b


def mean_height(stiffness, amplitude, preload):
    """Return the mean approach at which the mean of k z^1.5 over z = h + A cos t is the preload."""

    def mean(h):
        half = math.pi if h >= amplitude else math.acos(-h / amplitude)
        force = _integral(lambda t: stiffness * max(h + amplitude * math.cos(t), 0.0) ** 1.5, 0.0, half)
        return force / math.pi / preload - 1.0

    at_rest = (preload / stiffness) ** (2.0 / 3.0)
    return brentq(mean, -amplitude * (1.0 - 1e-9), at_rest + amplitude, xtol=1e-24, rtol=1e-14)


def mean_friction(speed, *, frequency, amplitude, ratio, stiffness, c, preload):
    """Return <Q>/(mu preload) at a speed of the slider, on u_z = A cos t and u_x = ratio A sin t."""
    h, v = mean_height(stiffness, amplitude, preload), speed / (2.0 * math.pi * frequency)
    a, closed = ratio * amplitude, h >= amplitude

    def load(z):
        return stiffness * max(z, 0.0) ** 1.5

    def z(t):
        return h + amplitude * math.cos(t)

    def slip_rate(t, sign):
        return sign * (a * math.cos(t) - v) + c * amplitude * math.sin(t)

    def travel(t):
        return a * math.sin(t) - v * t

    end = math.pi if closed else math.acos(-h / amplitude)
    kept = total = 0.0
    for _ in range(8 if closed else 1):  # a contact that stays closed keeps its deformation
        t, x, total = -end, kept, 0.0
        sign = math.copysign(1.0, a * math.cos(t) - v)
        slips = not closed and slip_rate(t, sign) > 0.0
        while t < end - 1e-14:
            if slips:
                until = _first_fall(lambda s, sign=sign: slip_rate(s, sign), t, end, 1e-15 * amplitude)
                total += sign * _integral(lambda s: load(z(s)), t, until)
                x = sign * c * z(until)
            else:
                base = x - travel(t)
                until = _first_fall(
                    lambda s, base=base: c * z(s) - abs(base + travel(s)), t, end, 1e-15 * amplitude
                )  # fmt: skip

                def force(s, base=base):
                    at = base + travel(s)
                    return math.copysign(load(z(s)) - load(z(s) - abs(at) / c), at)

                grid = np.linspace(t, until, 1001)[1:-1]
                values = [base + travel(s) for s in grid]
                bends = [
                    brentq(lambda s, base=base: base + travel(s), *grid[k : k + 2], xtol=1e-16, rtol=1e-15)
                    for k in range(len(grid) - 1) if values[k] * values[k + 1] < 0.0
                ]  # fmt: skip
                total += sum(_integral(force, *piece) for piece in pairwise([t, *bends, until]))
                x = base + travel(until)
                sign = math.copysign(1.0, x)
            t, slips = until, not slips
        kept = x
    return total / (2.0 * math.pi) / preload


def velocity_error(speed, **given):
    """Return by how much a speed differs from that of zero mean friction, over the speed."""
    rest = mean_friction(speed, **given)
    slope = (mean_friction(speed * (1.0 + 1e-4), **given) - rest) / (1e-4 * speed)
    return -rest / slope / speed
