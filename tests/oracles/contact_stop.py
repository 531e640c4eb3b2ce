r"""The slider's motion without events: a stop operator in fixed steps, extrapolated over the step size. SI units.

Shares nothing with the product and nothing with `contact_motion`, whose events it does without. Contacts of radii,
heights and surface motions of their own carry a rigid slider. Verlet's method moves the slider; each contact's
deformation follows the surface and is cut to the slip limit c z (with a stick band only while it slips faster than the
band); the force is mu (P(z) - P(z - |x|/c)). The rule errs by O(h^2), and where contacts close or slip begins by powers
of h between 1.5 and 3, so that `extrapolated` takes the difference of the two finest step sizes as its error.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

MASS, PRELOAD, LOAD, MU, C, CHI, R_N, R_T, OMEGA, PUNCH, BAND, MOBILE = range(12)
Z_S, RATE, V, TRAVEL, MEAN_P, MEAN_Q, HIGHEST = range(7)


@njit(cache=True)
def _profile(z, punch):
    return 0.0 if z <= 0.0 else (z if punch else z * math.sqrt(z))


@njit(cache=True)
def _factor(t, times, shape):
    """Return the envelope at a time: amplitude and phase linear between its times."""
    if times.size == 0:
        return 1.0 + 0.0j
    k = min(max(np.searchsorted(times, t) - 1, 0), times.size - 2)
    part = min(max((t - times[k]) / (times[k + 1] - times[k]), 0.0), 1.0)
    size, phase = (
        shape[0, k] + part * (shape[0, k + 1] - shape[0, k]),
        shape[1, k] + part * (shape[1, k + 1] - shape[1, k]),
    )
    return size * complex(math.cos(phase), math.sin(phase))


@njit(cache=True)
def _run(t, cycles, per_cycle, s, stiffness, heights, waves, times, shape, y, x, z, velocities):
    """Move slider y and deformations x, in place; fill the velocity after each cycle; return the time.

    z holds the approaches.
    """
    n, h = stiffness.size, 2.0 * math.pi / s[OMEGA] / per_cycle
    surface, normal_sum, along_sum = np.empty((2, n)), 0.0, 0.0
    means = np.zeros(2)
    for step in range(cycles * per_cycle + 1):
        half_rate, half_v = y[RATE], y[V]
        if step > 0:
            if s[MOBILE]:
                half_rate += 0.5 * h * normal_sum / s[MASS]
                half_v += 0.5 * h * along_sum / s[MASS]
            y[Z_S] += h * half_rate
            y[TRAVEL] += h * half_v
        rate, v = 2.0 * half_rate - y[RATE], 2.0 * half_v - y[V]  # at the end of the step, to second order
        now = t + step * h
        turn = _factor(now, times, shape) * complex(math.cos(s[OMEGA] * now), math.sin(s[OMEGA] * now))
        ahead = _factor(now + 1e-3 * h, times, shape) * complex(
            math.cos(s[OMEGA] * (now + 1e-3 * h)), math.sin(s[OMEGA] * (now + 1e-3 * h))
        )
        spin = (ahead - turn) / (1e-3 * h)
        normal_sum, along_sum = -s[PRELOAD] - s[R_N] * rate, -s[LOAD] - s[R_T] * v
        P_sum = Q_sum = 0.0
        for i in range(n):
            u_z, u_x = (waves[0, i] * turn).real, (waves[1, i] * turn).real
            before, new = z[i], u_z + heights[i] - y[Z_S]
            z_rate, x_rate = (waves[0, i] * spin).real - rate, (waves[1, i] * spin).real - v
            if step > 0:
                moved = u_x - surface[1, i] - h * half_v
                x[i] += moved * (new / (new - before) if before <= 0.0 < new else 1.0)
            surface[1, i], z[i] = u_x, new
            if new <= 0.0:
                x[i] = 0.0
                continue
            limit, side = s[C] * new, 1.0 if x[i] > 0.0 else -1.0
            if abs(x[i]) > limit and (s[BAND] == 0.0 or side * x_rate - s[C] * z_rate > s[BAND] or step == 0):
                x[i] = side * limit
            P = stiffness[i] * _profile(new, s[PUNCH])
            Q = side * s[MU] * (P - stiffness[i] * _profile(new - abs(x[i]) / s[C], s[PUNCH]))
            normal_sum += P * (1.0 + s[CHI] * z_rate)
            along_sum += Q
            P_sum += P
            Q_sum += Q
        if step > 0:
            if s[MOBILE]:
                y[RATE] = half_rate + 0.5 * h * normal_sum / s[MASS]
                y[V] = half_v + 0.5 * h * along_sum / s[MASS]
            means[0] += P_sum
            means[1] += Q_sum
            y[HIGHEST] = max(y[HIGHEST], y[Z_S])
            if step % per_cycle == 0:
                velocities[step // per_cycle - 1] = y[V]
                y[MEAN_P], y[MEAN_Q] = means / per_cycle
                means[:] = 0.0
    return t + cycles * per_cycle * h


@dataclass(frozen=True, kw_only=True)
class StopMotor:
    """A slider of n contacts; `u = Re(amplitude exp(i omega t))` of each, t = 0 at the first u_z's upward zero."""

    mass: float
    preload: float
    mu: float
    frequency: float
    normal: tuple
    tangential: tuple
    radii: tuple
    E: float = 64e9
    G: float = 12e9
    load: float = 0.0  # along -x
    chi: float = 0.0
    normal_damping: float = 0.0
    tangential_damping: float = 0.0
    punch: bool = False
    band: float = 0.0
    heights: tuple = ()
    times: tuple = ()
    amplitude: tuple = ()
    phase: tuple = ()

    @property
    def c(self):
        """Slip limit over the approach."""
        return self.mu * self.E / (4.0 * self.G)

    @property
    def stiffness(self):
        """K of P = K z^1.5 or K z."""
        R = np.array(self.radii, float)
        return 2.0 * self.E * R if self.punch else 4.0 / 3.0 * self.E * np.sqrt(R)

    @property
    def offsets(self):
        """Heights of the contacts."""
        return np.array(self.heights or (0.0,) * len(self.radii), float)

    @property
    def waves(self):
        """Amplitudes with time begun at the upward zero of the first u_z."""
        turn = np.exp(-1j * (math.pi / 2.0 + np.angle(complex(self.normal[0]))))
        return np.array([self.normal, self.tangential], complex) * turn

    def row(self, mobile=1.0):
        """The numbers as an array."""
        return np.array([
            self.mass, self.preload, self.load, self.mu, self.c, self.chi, self.normal_damping,
            self.tangential_damping, 2.0 * math.pi * self.frequency, self.punch, self.band, mobile,
        ], float)  # fmt: skip

    def rest_height(self):
        """Return the approach of height 0 under the preload, by bisection."""
        return self.height_under(lambda h: sum(
            k * _profile(h + d, self.punch) for k, d in zip(self.stiffness, self.offsets, strict=True)
        ))  # fmt: skip

    def height_under(self, force):
        """Return the height at which a rising function of it is the preload."""
        low, high = -1e-4, 1e-4
        for _ in range(120):
            h = 0.5 * (low + high)
            low, high = (low, h) if force(h) > self.preload else (h, high)
        return 0.5 * (low + high)

    def sheared(self):
        """Return the deformations with which the contacts carry the load at rest, all alike but for their limits."""
        z, c = np.maximum(self.rest_height() + self.offsets, 0.0), self.c

        def carried(x):
            return sum(
                self.mu * k * (_profile(a, self.punch) - _profile(a - min(x, c * a) / c, self.punch))
                for k, a in zip(self.stiffness, z, strict=True)
            )

        low, high = 0.0, c * float(np.max(z))
        for _ in range(120):
            x = 0.5 * (low + high)
            low, high = (low, x) if carried(x) > abs(self.load) else (x, high)
        return math.copysign(1.0, self.load) * np.minimum(0.5 * (low + high) if self.load else 0.0, c * z)

    def run(self, cycles, per_cycle, state=None, silent=False, mobile=True):
        """Return (velocities after each cycle, state); the state is (time, y, deformations, approaches)."""
        t, y, x, z = state or (0.0, np.array([-self.rest_height(), *[0.0] * HIGHEST]), self.sheared(), self.offsets)
        y, x, z, velocities = y.copy(), x.copy(), z.copy(), np.empty(cycles)
        shape = np.array([self.amplitude, self.phase], float).reshape(2, -1)
        t = _run(
            t, cycles, per_cycle, self.row(mobile), self.stiffness, self.offsets, self.waves * (not silent),
            np.array(self.times, float), shape, y, x, z, velocities,
        )  # fmt: skip
        return velocities, (t, y, x, z)

    def means(self, height, v, per_cycle, side=1.0):
        """Return the mean sum P and sum Q of a cycle that repeats at constant height and velocity, N.

        `side`: of the deformations before it, which contacts that stick at v = 0 keep.
        """
        y = np.array([-height, 0.0, v, *[0.0] * (HIGHEST - 2)])
        far = side * 10.0 * self.c * (
            abs(height) + np.abs(self.waves[0]) + np.abs(self.offsets)
        ) + 10.0 * side * np.abs(self.waves[1])
        _, (_, y, _, _) = self.run(3, per_cycle, (0.0, y, far, self.offsets), mobile=False)
        return y[MEAN_P], y[MEAN_Q]


def extrapolated(value, coarsest):
    """Return (value, error) of a function of the number of steps per cycle, at four times the coarsest number."""
    coarse, fine = value(2 * coarsest), value(4 * coarsest)
    return fine + (fine - coarse) / 3.0, np.abs(fine - coarse)
