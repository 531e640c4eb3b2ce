"""Mean velocity of a heavy slider on one ball that keeps contact: elastic law, from event to event by Gauss's rule.

The slider keeps its height h and its velocity v through a cycle; u_z = A cos phi and u_x = r A sin phi. With
z = h + u_z and |x| <= c z the friction is mu K (z^1.5 - (z - |x|/c)^1.5) sign x (Cattaneo and Mindlin). h follows from
<K z^1.5> = preload, v from <Q> = 0. Between events the deformation x is a closed expression, and events are its roots.
"""

import math
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

NODE, WEIGHT = np.polynomial.legendre.leggauss(40)


def _integral(function, low, high, panels=24):
    edges = np.linspace(low, high, panels + 1)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return float(np.sum(half * WEIGHT * function(middle + half * NODE)))


def _first_root(function, low, high):
    """Return the first phase at which a function that is negative just above `low` is zero; `high` without one."""
    t = np.linspace(low + 1e-6, high, 40_001)
    above = np.flatnonzero(function(t) > 0.0)
    return brentq(function, t[max(above[0] - 1, 0)], t[above[0]], xtol=1e-15) if above.size else high


class HeavyBall:
    """A ball of stiffness K in N/m^1.5 and slip slope c under a preload in N, on waves of one frequency."""

    def __init__(self, *, stiffness: float, slope: float, preload: float, ratio: float, omega: float):
        self.stiffness, self.slope, self.preload, self.ratio, self.omega = stiffness, slope, preload, ratio, omega

    def height(self, amplitude: float) -> float:
        """Return h in m."""
        wave = amplitude * np.cos(2.0 * np.pi * (np.arange(4096) + 0.5) / 4096)
        return brentq(
            lambda h: self.stiffness * np.mean((h + wave) ** 1.5) - self.preload, amplitude, 20 * amplitude, xtol=1e-24
        )

    def friction(self, amplitude: float, h: float, v: float) -> float:
        """Return the mean of Q over mu K."""
        c, side, drift = self.slope, self.ratio * amplitude, v / self.omega

        def z(t):
            return h + amplitude * np.cos(t)

        # forward slip ends where x' falls below c z'
        phase = start = math.atan2(c, self.ratio) + math.acos(drift / (math.hypot(self.ratio, c) * amplitude))
        x, total, stop = c * z(start), 0.0, start + 2.0 * math.pi
        while phase < stop - 1e-12:
            begin, deformation = phase, x

            def moved(t, begin=begin, deformation=deformation):
                return deformation + side * (np.sin(t) - math.sin(begin)) - drift * (t - begin)

            def force(t, moved=moved):
                return np.sign(moved(t)) * (z(t) ** 1.5 - np.maximum(z(t) - abs(moved(t)) / c, 0.0) ** 1.5)

            forward = _first_root(lambda t, moved=moved: moved(t) - c * z(t), begin, stop)
            back = _first_root(lambda t, moved=moved: -moved(t) - c * z(t), begin, stop)
            end = min(forward, back)
            graded = begin + (end - begin) * np.linspace(0.0, 1.0, 13) ** 4
            total += sum(_integral(force, low, high, 2) for low, high in pairwise(graded))
            if forward <= back:  # it slips forward to the end of the cycle
                return (total + _integral(lambda t: z(t) ** 1.5, end, stop)) / (2.0 * math.pi)
            phase = _first_root(lambda t: side * np.cos(t) - drift - c * amplitude * np.sin(t), end, stop)
            total -= _integral(lambda t: z(t) ** 1.5, end, phase)
            x = -c * z(phase)
        return total / (2.0 * math.pi)

    def velocity(self, amplitude: float) -> float:
        """Return v in m/s above the threshold."""
        h, top = self.height(amplitude), self.omega * self.ratio * amplitude
        return brentq(lambda v: self.friction(amplitude, h, v), 1e-3 * top, 0.999 * top, xtol=1e-13, rtol=1e-12)
