r"""The slider's full motion, independently: an explicit Runge-Kutta method of order 8 between located events, SI units.

Shares nothing with the product. n equal contacts of a rigid slider on harmonic surface motions, whose size may follow
an envelope. Spheres or punches, springs of Cattaneo and Mindlin with stick and slip, a friction coefficient mu(p, w)
of mean pressure and slip speed, reciprocal force, stick band, contact damper and dampers of the slider. A jitted
function gives so that the laws of users can be written down a second time.

Dormand's and Prince's coefficients are SciPy's. Events (contact, release, slip, stick) are located by bisection on the
step's length. The embedded error estimate shortens the steps where the springs have powers of 1.5.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.integrate import DOP853

_A = np.ascontiguousarray(DOP853.A)
_B = np.ascontiguousarray(DOP853.B)
_C = np.ascontiguousarray(DOP853.C)
_E3, _E5 = np.ascontiguousarray(DOP853.E3), np.ascontiguousarray(DOP853.E5)
APART, STICK, SLIP, CREEP = 0, 1, 2, 3
MASS, PRELOAD, LOAD, RADIUS, E, G, CHI, R_N, R_T, OMEGA, PUNCH, RECIPROCAL, BAND, STEPS = range(14)


@njit(cache=True)
def _mu(p, w, n):
    """Return (mu_h + (mu - mu_h)/(1 + p/p_h)) (r + (1 - r) exp(-w/w_s)) + w/w_0; n: mu, r, w_s, mu_h, p_h, w_0."""
    return (n[3] + (n[0] - n[3]) / (1.0 + p / n[4])) * (n[1] + (1.0 - n[1]) * math.exp(-w / n[2])) + w / n[5]


@njit(cache=True)
def _push(z, s):
    if z <= 0.0:
        return 0.0
    return 2.0 * s[E] * s[RADIUS] * z if s[PUNCH] else 4.0 / 3.0 * s[E] * math.sqrt(s[RADIUS]) * z * math.sqrt(z)


@njit(cache=True)
def _coefficient(z, w, s, numbers):
    area = math.pi * s[RADIUS] * (s[RADIUS] if s[PUNCH] else max(z, 1e-30))
    return _mu(_push(max(z, 1e-30), s) / area, w, numbers)


@njit(cache=True)
def _limit(z, s, numbers):
    """Return the deformation at which Mindlin's spring carries mu P: mu E z/4G for both shapes."""
    return _coefficient(z, 0.0, s, numbers) * s[E] / (4.0 * s[G]) * z


@njit(cache=True)
def _limit_rate(z, s, numbers):
    h = 1e-5 * max(abs(z), 1e-14)
    z = max(z, 2.0 * h)
    return (_limit(z + h, s, numbers) - _limit(z - h, s, numbers)) / (2.0 * h)


@njit(cache=True)
def _wave(t, i, s, waves, times, shape):
    """Return u_z, u_z', u_x, u_x' of a contact; shape are amplitude and phase at the envelope's times."""
    omega, e, e_rate = s[OMEGA], 1.0 + 0.0j, 0.0j
    if times.size:
        k = min(max(np.searchsorted(times, t, side="right") - 1, 0), times.size - 2)
        span = times[k + 1] - times[k]
        part = min(max((t - times[k]) / span, 0.0), 1.0)
        a, b = (
            shape[0, k] + part * (shape[0, k + 1] - shape[0, k]),
            shape[1, k] + part * (shape[1, k + 1] - shape[1, k]),
        )
        inside = times[0] <= t <= times[-1]
        da, db = ((shape[0, k + 1] - shape[0, k]) / span * inside, (shape[1, k + 1] - shape[1, k]) / span * inside)
        turn = complex(math.cos(b), math.sin(b))
        e, e_rate = a * turn, (da + 1j * db * a) * turn
    turn = complex(math.cos(omega * t), math.sin(omega * t))
    u_z, u_x = e * waves[0, i] * turn, e * waves[1, i] * turn
    v_z, v_x = (1j * omega * e + e_rate) * waves[0, i] * turn, (1j * omega * e + e_rate) * waves[1, i] * turn
    return u_z.real, v_z.real, u_x.real, v_x.real


@njit(cache=True)
def _slip_speed(sign, z, z_rate, x_rate, s, numbers):
    return sign * x_rate - _limit_rate(z, s, numbers) * z_rate


@njit(cache=True)
def _contact_forces(z, z_rate, x, x_rate, regime, sign, s, numbers):
    """Return P with its damper and the reciprocal force, and Q."""
    if regime == APART or z <= 0.0:
        return 0.0, 0.0
    P, c0 = _push(z, s), _coefficient(z, 0.0, s, numbers)
    c = c0 * s[E] / (4.0 * s[G])
    size = c * z if regime != STICK else min(abs(x), c * z)
    if regime != STICK:
        w = max(_slip_speed(sign, z, z_rate, x_rate, s, numbers), 0.0)
        if regime == CREEP:
            w = 0.0
        Q = sign * _coefficient(z, w, s, numbers) * P
    else:
        Q = c0 * (P - _push(z - size / c, s)) if c > 0.0 else 0.0
        Q = Q if x >= 0.0 else -Q
    total = P * (1.0 + s[CHI] * z_rate)
    if s[RECIPROCAL]:
        slope = P / z if s[PUNCH] else 1.5 * P / z
        total += c0 * c * (size / c * slope - P + _push(z - size / c, s))
    return total, Q


@njit(cache=True)
def _rates(t, y, regime, sign, s, numbers, waves, heights, times, shape, out):
    n = heights.size
    push, pull = -s[R_N] * y[1] - s[PRELOAD], -s[R_T] * y[2] - s[LOAD]
    for i in range(n):
        u, du, _, dx = _wave(t, i, s, waves, times, shape)
        P, Q = _contact_forces(u + heights[i] - y[0], du - y[1], y[3 + i], dx - y[2], regime[i], sign[i], s, numbers)
        push += P
        pull += Q
        out[3 + i] = dx - y[2] if regime[i] == STICK else 0.0
    out[0], out[1], out[2] = y[1], push / s[MASS], pull / s[MASS]
    out[3 + n] = y[2]


@njit(cache=True)
def _guards(t, y, regime, sign, s, numbers, waves, heights, times, shape, band, out):
    """Fill out (n, 3) with guards, positive inside the regime; the third is the passage of x through 0."""
    for i in range(heights.size):
        u, du, _, dx = _wave(t, i, s, waves, times, shape)
        z, dz, dx = u + heights[i] - y[0], du - y[1], dx - y[2]
        out[i, 0], out[i, 1], out[i, 2] = z, 1.0, 1.0
        if regime[i] == APART:
            out[i, 0] = -z
        elif regime[i] == STICK:
            out[i, 1], out[i, 2] = _limit(z, s, numbers) - abs(y[3 + i]), sign[i] * y[3 + i]
        elif regime[i] == SLIP:
            out[i, 1] = _slip_speed(sign[i], z, dz, dx, s, numbers) - s[BAND]
        else:
            slow = s[BAND] - _slip_speed(sign[i], z, dz, dx, s, numbers)
            out[i, 1] = min(slow * band, sign[i] * y[3 + i] - _limit(z, s, numbers))


@njit(cache=True)
def _follow(t, y, i, which, regime, sign, s, numbers, waves, heights, times, shape):
    u, du, _, dx = _wave(t, i, s, waves, times, shape)
    z, dz, dx = u + heights[i] - y[0], du - y[1], dx - y[2]
    if which == 2:
        sign[i], y[3 + i] = -sign[i], 0.0
        return
    if which == 0 and regime[i] != APART:
        regime[i], y[3 + i] = APART, 0.0
        return
    if which == 0:
        sign[i] = -1.0 if dx < 0.0 else 1.0
        y[3 + i] = 0.0
        regime[i] = SLIP if _slip_speed(sign[i], 1e-25, dz, dx, s, numbers) > 0.0 else STICK
        return
    if regime[i] == STICK:
        sign[i] = 1.0 if y[3 + i] > 0.0 else -1.0
        if _slip_speed(sign[i], z, dz, dx, s, numbers) > s[BAND]:
            regime[i] = SLIP
        else:
            y[3 + i] = sign[i] * _limit(z, s, numbers) * (1.0 - 1e-14)
    else:
        regime[i], y[3 + i] = STICK, sign[i] * _limit(z, s, numbers) * (1.0 - 1e-14)


@njit(cache=True)
def _step(t, h, y, regime, sign, s, numbers, waves, heights, times, shape, k, new, scale, A, B, C, E3, E5):
    """Take one step; return the error over the tolerance."""
    m = y.size
    for stage in range(12):
        for j in range(m):
            total = 0.0
            for q in range(stage):
                total += A[stage, q] * k[q, j]
            new[j] = y[j] + h * total
        _rates(t + C[stage] * h, new, regime, sign, s, numbers, waves, heights, times, shape, k[stage])
    for j in range(m):
        total = 0.0
        for q in range(12):
            total += B[q] * k[q, j]
        new[j] = y[j] + h * total
    _rates(t + h, new, regime, sign, s, numbers, waves, heights, times, shape, k[12])
    five, three = 0.0, 0.0
    for j in range(m):
        a, b = 0.0, 0.0
        for q in range(13):
            a += E5[q] * k[q, j]
            b += E3[q] * k[q, j]
        five += (a / scale[j]) ** 2
        three += (b / scale[j]) ** 2
    bottom = five + 0.01 * three
    return abs(h) * five / math.sqrt(bottom * m) if bottom > 0.0 else 0.0


@njit(cache=True)
def _run(t, stops, y, regime, sign, s, numbers, waves, heights, times, shape, scale, A, B, C, E3, E5, rows):
    """Go to each of the stops and fill the rows; return (t, number of events)."""
    n, m, events = heights.size, y.size, 0
    k, new, trial = np.empty((13, m)), np.empty(m), np.empty(m)
    guards, slips = np.empty((n, 3)), np.zeros(n)
    T = 2.0 * math.pi / s[OMEGA]
    h = T / 200.0
    for row in range(stops.size):
        stop = stops[row]
        while t < stop:
            h = min(h, T / s[STEPS])
            left = stop - t
            last = h >= left * (1.0 - 1e-12)
            used = left if last else h
            error = _step(
                t, used, y, regime, sign, s, numbers, waves, heights, times, shape, k, new, scale, A, B, C, E3, E5
            )
            if error > 1.0 and used > 1e-9 * T:
                h = used * max(0.2, 0.9 * error ** (-1.0 / 8.0))
                continue
            _guards(t + used, new, regime, sign, s, numbers, waves, heights, times, shape, 1.0, guards)
            if np.min(guards) >= 0.0:
                grow = min(4.0, 0.9 * error ** (-1.0 / 8.0)) if error > 0.0 else 4.0
                t = stop if last else t + used
                if not last or grow < 1.0:
                    h = used * grow
                y[:] = new
                continue
            low, high = 0.0, used
            for _ in range(70):
                middle = 0.5 * (low + high)
                if middle == low or middle == high:
                    break
                _step(
                    t,
                    middle,
                    y,
                    regime,
                    sign,
                    s,
                    numbers,
                    waves,
                    heights,
                    times,
                    shape,
                    k,
                    trial,
                    scale,
                    A,
                    B,
                    C,
                    E3,
                    E5,
                )
                _guards(t + middle, trial, regime, sign, s, numbers, waves, heights, times, shape, 1.0, guards)
                if np.min(guards) >= 0.0:
                    low = middle
                else:
                    high = middle
            _step(t, high, y, regime, sign, s, numbers, waves, heights, times, shape, k, trial, scale, A, B, C, E3, E5)
            _guards(t + high, trial, regime, sign, s, numbers, waves, heights, times, shape, 1.0, guards)
            y[:] = trial
            t += high
            events += 1
            for i in range(n):
                if regime[i] == STICK and min(guards[i, 0], guards[i, 1]) < 0.0:
                    slips[i] += 1
                if guards[i, 0] < 0.0:
                    _follow(t, y, i, 0, regime, sign, s, numbers, waves, heights, times, shape)
                elif guards[i, 1] < 0.0:
                    _follow(t, y, i, 1, regime, sign, s, numbers, waves, heights, times, shape)
                elif guards[i, 2] < 0.0:
                    _follow(t, y, i, 2, regime, sign, s, numbers, waves, heights, times, shape)
            h = max(min(h, T / 200.0), 1e-9 * T)
        rows[row, 0], rows[row, 1], rows[row, 2] = y[2], y[m - 1], y[0]
        rows[row, 3:] = slips
    return t, events


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A slider of n equal contacts, SI units; `u = Re(amplitude exp(i omega t))` of each contact."""

    mass: float
    preload: float
    frequency: float
    normal: tuple
    tangential: tuple
    load: float = 0.0  # along -x
    radius: float = 1e-3
    E: float = 64e9
    G: float = 12e9
    chi: float = 0.0
    normal_damping: float = 0.0
    tangential_damping: float = 0.0
    punch: bool = False
    reciprocal: bool = False
    band: float = 0.0
    heights: tuple = ()
    # mu, r, w_s, mu_h, p_h and w_0 of `_mu`
    numbers: tuple = (0.1, 1.0, 1.0, 0.1, 1.0, math.inf)
    times: tuple = ()
    amplitude: tuple = ()
    phase: tuple = ()
    tolerance: float = 1e-12
    per_cycle: float = 60.0  # least number of steps; a slip shorter than a step may be missed

    @property
    def row(self):
        """The numbers as an array."""
        return np.array([
            self.mass, self.preload, self.load, self.radius, self.E, self.G, self.chi, self.normal_damping,
            self.tangential_damping, 2.0 * math.pi * self.frequency, self.punch, self.reciprocal, self.band,
            self.per_cycle,
        ], float)  # fmt: skip

    @property
    def offsets(self):
        """Heights of the contacts."""
        return np.array(self.heights or (0.0,) * len(self.normal), float)

    def rest_height(self):
        """Return the approach of height 0 under the preload by bisection."""
        s, low, high = self.row, -1e-3, 1e-3
        for _ in range(300):
            h = 0.5 * (low + high)
            low, high = (low, h) if sum(_push(h + d, s) for d in self.offsets) > self.preload else (h, high)
        return 0.5 * (low + high)

    def sheared(self):
        """Return the common deformation with which the contacts hold the load at rest, each up to its limit."""
        s, z, numbers = self.row, self.rest_height() + self.offsets, np.array(self.numbers, float)
        limits = np.array([_limit(a, s, numbers) if a > 0.0 else 0.0 for a in z])

        def held(x):
            return sum(
                _contact_forces(a, 0.0, min(x, b), 0.0, STICK, 1.0, s, numbers)[1]
                for a, b in zip(z, limits, strict=True)
                if a > 0.0
            )

        low, high, size = 0.0, float(np.max(limits)), abs(self.load)
        for _ in range(200):
            x = 0.5 * (low + high)
            low, high = (low, x) if held(x) > size else (x, high)
        return math.copysign(1.0, self.load) * np.minimum(0.5 * (low + high), limits) if self.load else 0.0 * z

    def start(self, height=None, speed=0.0):
        """Return (t, y, regime, sign) at the upward zero of the first contact's u_z."""
        n, s, numbers = len(self.normal), self.row, np.array(self.numbers, float)
        y = np.zeros(4 + n)
        y[0], y[2] = -(self.rest_height() if height is None else height), speed
        y[3 : 3 + n] = self.sheared()
        t = 0.0
        waves, times, shape = self.waves
        regime, sign = np.full(n, STICK), np.ones(n)
        for i in range(n):
            z = _wave(t, i, s, waves, times, shape)[0] + self.offsets[i] - y[0]
            if z <= 0.0:
                regime[i], y[3 + i] = APART, 0.0
            else:
                most = _limit(z, s, numbers) * (1.0 - 1e-14)
                y[3 + i] = min(max(y[3 + i], -most), most)
                along = _wave(t, i, s, waves, times, shape)[3] - y[2]
                sign[i] = -1.0 if y[3 + i] < 0.0 or (y[3 + i] == 0.0 and along < 0.0) else 1.0
        return t, y, regime, sign

    @property
    def waves(self):
        """Amplitudes with the time axis begun where u_z of the first contact crosses zero upwards, and the envelope."""
        first = complex(self.normal[0])
        turn = np.exp(-1j * (math.pi / 2.0 + np.angle(first)))
        waves = np.array([self.normal, self.tangential], complex) * turn
        return (waves, np.array(self.times, float), np.array([self.amplitude, self.phase], float).reshape(2, -1))

    def run(self, cycles, every=1, state=None, silent=False):
        """Return (times, rows, state); rows of v, travel, z_s and number of slips of each contact."""
        t, y, regime, sign = state or self.start()
        waves, times, shape = self.waves
        if silent:
            waves = 0.0 * waves
        size = np.max(np.abs(waves[0])) if np.max(np.abs(waves)) > 0.0 else abs(y[0])
        length = max(size, abs(self.rest_height()), 1e-15)
        omega = 2.0 * math.pi * self.frequency
        scale = self.tolerance * length * np.array([1.0, omega, 1e-1 * omega, *[0.1] * len(self.normal), 1.0])
        stops = t + np.arange(every, cycles + 1, every) / self.frequency
        rows = np.empty((stops.size, 3 + len(self.normal)))
        t, _ = _run(
            t, stops, y, regime, sign, self.row, np.array(self.numbers, float), waves, self.offsets, times,
            shape, scale, _A, _B, _C, _E3, _E5, rows,
        )  # fmt: skip
        return stops, rows, (t, y, regime, sign)
