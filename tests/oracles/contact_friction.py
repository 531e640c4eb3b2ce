r"""Friction that depends on slip speed and pressure, independently: DOP853 between located events, SI units.

Shares nothing with the product. n contacts with elastic tangential springs on a rigid slider; the friction coefficient
is a function mu(p, w) of the mean pressure and the slip speed, given as plain Python. The spring follows Cattaneo and
Mindlin with the coefficient mu(p, 0) (a punch: linear), slip begins where the spring carries mu(p, 0) P, and its speed
is s (u_x' - v) - dX/dt, X the slip limit, whose rate comes from differences.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from tests.seed_motor import MASS, PRELOAD


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A slider of n equal contacts on given harmonic surface motions, SI units."""

    mu: Callable[[float, float], float]  # of mean pressure in Pa and slip speed in m/s
    mass: float = MASS
    preload: float = PRELOAD
    load: float = 0.0
    radius: float = 1e-3
    E: float = 64e9
    G: float = 12e9
    normal_damping: float = 0.5
    tangential_damping: float = 1e-4
    frequency: float = 2.2e6
    # Of each contact, u = amplitude sin(omega t + phase); the tangential velocity follows u_z: a wave in quadrature
    amplitudes: tuple[float, ...] = (4e-9,)
    phases: tuple[float, ...] = (0.0,)
    heights: tuple[float, ...] = (0.0,)
    ratio: float = 0.7
    punch: bool = False

    def push(self, z):
        """Return P."""
        if z <= 0.0:
            return 0.0
        return 2.0 * self.E * self.radius * z if self.punch else 4.0 / 3.0 * self.E * math.sqrt(self.radius) * z**1.5

    def coefficient(self, z, w):
        """Return mu at an approach and a speed."""
        area = math.pi * self.radius * (self.radius if self.punch else max(z, 1e-30))
        return self.mu(self.push(z) / area, w)

    def limit(self, z):
        """Return X, from 3 mu P/(16 a G) for a sphere and mu P/(8 a G) for a punch."""
        if z <= 0.0:
            return self.coefficient(1e-30, 0.0) * self.E / (4.0 * self.G) * z
        mu, P = self.coefficient(z, 0.0), self.push(z)
        return (
            mu * P / (8.0 * self.radius * self.G)
            if self.punch
            else 3.0 * mu * P / (16.0 * math.sqrt(self.radius * z) * self.G)
        )

    def limit_rate(self, z, rate):
        """Return dX/dt."""
        step = 1e-6 * max(abs(z), 1e-13)
        return (self.limit(z + step) - self.limit(z - step)) / (2.0 * step) * rate

    def stuck(self, z, x):
        """Return Q in stick."""
        if z <= 0.0:
            return 0.0
        if self.punch:
            return 8.0 * self.radius * self.G * x
        share = 1.0 - max(1.0 - abs(x) / self.limit(z), 0.0) ** 1.5
        return math.copysign(self.coefficient(z, 0.0) * self.push(z) * share, x)

    def surface(self, i, t):
        """Return u_z, u_z', u_x'."""
        om, a = 2.0 * math.pi * self.frequency, self.amplitudes[i]
        s, c = math.sin(om * t + self.phases[i]), math.cos(om * t + self.phases[i])
        return self.heights[i] + a * s, a * om * c, self.ratio * a * om * s

    def kinematics(self, i, t, y):
        """Return z, z', u_x' - v of a contact."""
        u, rate, along = self.surface(i, t)
        return u - y[0], rate - y[1], along - y[2]

    def slip_speed(self, i, s, t, y):
        """Return s (u_x' - v) - dX/dt."""
        z, rate, along = self.kinematics(i, t, y)
        return s * along - self.limit_rate(z, rate)

    def forces(self, i, t, y, regime):
        """Return P and Q; a regime is (name, sign)."""
        name, s = regime
        z, *_ = self.kinematics(i, t, y)
        if name == "apart" or z <= 0.0:
            return 0.0, 0.0
        P = self.push(z)
        if name == "slip":
            return P, s * self.coefficient(z, max(self.slip_speed(i, s, t, y), 0.0)) * P
        return P, self.stuck(z, y[3 + i])


def follow(motor: Motor, cycles: float) -> tuple[np.ndarray, float, float, int]:
    """Return (state z_s, z_s', v, x_i), mean v of the last cycle, normal and tangential work of the wave, events.

    From rest under the preload, t = 0 where the sine of the first contact begins.
    """
    n, T = len(motor.amplitudes), 1.0 / motor.frequency
    low, high = -1e-6, 1e-6  # of the contact of height 0 under the preload, by bisection
    for _ in range(200):
        h = 0.5 * (low + high)
        low, high = (low, h) if sum(motor.push(h + each) for each in motor.heights) > motor.preload else (h, high)
    y, t = np.zeros(3 + n + 3), 0.0
    y[0] = -h
    regimes = []
    for i in range(n):
        z, _, along = motor.kinematics(i, 0.0, y)
        regimes.append(("stick", 1.0) if z > 0.0 else ("apart", 1.0))

    def rates(t, y):
        out = np.zeros_like(y)
        out[0] = y[1]
        out[1], out[2] = (-motor.normal_damping * y[1] - motor.preload, -motor.tangential_damping * y[2] - motor.load)
        for i in range(n):
            P, Q = motor.forces(i, t, y, regimes[i])
            _, up, along = motor.surface(i, t)
            out[1] += P
            out[2] += Q
            out[-3] += P * up
            out[-2] += Q * along
            out[3 + i] = along - y[2] if regimes[i][0] == "stick" else 0.0
        out[1:3] /= motor.mass
        out[-1] = y[2]
        return out

    scale = np.array([1e-9, 1e-2, 1e-2, *[1e-9] * n, 1e-12, 1e-12, 1e-8])
    events, start, stops = 0, 0.0, cycles * T
    marks = [(cycles - 1.0) * T, stops]
    while t < stops * (1.0 - 1e-15):
        stop = next(m for m in marks if m > t * (1.0 + 1e-15) + 1e-30)
        watched = []
        for i, (name, s) in enumerate(regimes):
            watched.append((i, "gap", lambda t, y, i=i: motor.kinematics(i, t, y)[0]))
            if name == "stick":
                for side in (1.0, -1.0):
                    watched.append(
                        (i, side, lambda t, y, i=i, s=side: motor.limit(motor.kinematics(i, t, y)[0]) - s * y[3 + i])
                    )
            elif name == "slip":
                watched.append((i, "end", lambda t, y, i=i, s=s: motor.slip_speed(i, s, t, y)))
        functions = []
        for i, kind, f in watched:

            def guarded(t, y, f=f):
                return f(t, y)

            guarded.terminal = True
            guarded.direction = 1.0 if kind == "gap" and regimes[i][0] == "apart" else -1.0
            functions.append(guarded)
        run = solve_ivp(
            rates, (t, stop), y, method="DOP853", rtol=1e-11, atol=1e-12 * scale, events=functions, max_step=T / 12
        )
        assert run.success
        t, y = run.t[-1], run.y[:, -1].copy()
        if run.status == 1:
            events += 1
            k = next(k for k, each in enumerate(run.t_events) if each.size)
            i, kind, _ = watched[k]
            name, s = regimes[i]
            _, rate, along = motor.kinematics(i, t, y)
            if kind == "gap" and name != "apart":
                regimes[i], y[3 + i] = ("apart", s), 0.0
            elif kind == "gap":
                s = math.copysign(1.0, along)
                slips = s * along - motor.limit_rate(1e-22, rate) > 0.0
                regimes[i], y[3 + i] = ("slip" if slips else "stick", s), 0.0
            elif kind == "end":
                regimes[i], y[3 + i] = (("stick", s), s * motor.limit(motor.kinematics(i, t, y)[0]) * (1.0 - 1e-13))
            else:
                regimes[i] = ("slip", kind)
        if abs(t - marks[0]) < 1e-15 * stops + 1e-22:
            start = y[-1]
    return y[: 3 + n], (y[-1] - start) / T, y[-3], y[-2], events
