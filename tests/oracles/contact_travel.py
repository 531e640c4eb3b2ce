r"""A slider that travels along a partly standing wave, independently: small fixed steps at the slider's own place.

Shares nothing with the product. n spheres of a rigid slider, the elastic law of Cattaneo and Mindlin as a stop
operator, viscous dampers of the slider. The surface under a ball at X = x_i + travel moves as

    u_z = Re[A (e^(-i k X) + R e^(i k X)) e^(i omega t)],   u_x = Re[-i r A (e^(-i k X) - R e^(i k X)) e^(i omega t)],

evaluated at every step at the place of that step: bounce, reversal and Doppler shift are those of the equations of
motion. (The change of u_x from place to place counts as motion of the surface, too: the strain, 1e-4, times the
slider's velocity.) Velocity Verlet, without corrections at the events: twice as many steps show the error.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numba import njit


@njit(cache=True)
def _run(cycles, per_cycle, s, balls, A, R, start, rows):
    mass, preload, load, radius, E, G, mu, r_n, r_t, omega, k, ratio = s
    n = balls.size
    stiffness, c = 4.0 / 3.0 * E * math.sqrt(radius), mu * E / (4.0 * G)
    h = 2.0 * math.pi / omega / per_cycle
    z_s, w, X, v = -((preload / n / stiffness) ** (2.0 / 3.0)), 0.0, 0.0, 0.0
    u_old, x = np.zeros(n), np.zeros(n)
    push, pull = 0.0, 0.0
    for step in range(cycles * per_cycle + 1):
        if step > 0:
            half_w = w + 0.5 * h * (push - r_n * w - preload) / mass
            half_v = v + 0.5 * h * (pull - r_t * v - load) / mass
            z_s += h * half_w
            X += h * half_v
        t_phase = start + 2.0 * math.pi * (step % per_cycle) / per_cycle
        turn = complex(math.cos(t_phase), math.sin(t_phase))
        push, pull = 0.0, 0.0
        for i in range(n):
            a = k * (balls[i] + X)
            there, back = A * complex(math.cos(a), -math.sin(a)), A * R * complex(math.cos(a), math.sin(a))
            u_z, u_x = ((there + back) * turn).real, (-1j * ratio * (there - back) * turn).real
            approach = u_z - z_s
            if step == 0:
                u_old[i] = u_x
            moved = u_x - u_old[i] - (h * half_v if step > 0 else 0.0)
            u_old[i] = u_x
            if approach <= 0.0:
                x[i] = 0.0
                continue
            limit = c * approach
            x[i] = min(max(x[i] + moved, -limit), limit)
            P = stiffness * approach * math.sqrt(approach)
            rest = approach - abs(x[i]) / c
            Q = mu * (P - stiffness * rest * math.sqrt(max(rest, 0.0)))
            push += P
            pull += Q if x[i] > 0.0 else -Q
        if step > 0:
            w = (half_w + 0.5 * h * (push - preload) / mass) / (1.0 + 0.5 * h * r_n / mass)
            v = (half_v + 0.5 * h * (pull - load) / mass) / (1.0 + 0.5 * h * r_t / mass)
            if step % per_cycle == 0:
                cycle = step // per_cycle
                rows[cycle - 1, 0], rows[cycle - 1, 1] = v, X


@dataclass(frozen=True, kw_only=True)
class Traveller:
    """A slider on balls at x_i from where the waves' phases are counted; SI units, load along -x."""

    mass: float
    preload: float
    frequency: float
    wavelength: float
    amplitude: float  # A, m
    reflection: complex  # R
    ratio: float  # r
    balls: tuple
    load: float = 0.0
    radius: float = 1e-3
    E: float = 64e9
    G: float = 12e9
    mu: float = 0.1
    normal_damping: float = 0.0
    tangential_damping: float = 0.0

    def orbits_at(self, displacements):
        """Return complex u_x and u_z of each ball, shape (2, balls, displacements)."""
        a = 2.0 * np.pi / self.wavelength * (np.array(self.balls)[:, None] + np.asarray(displacements))
        there, back = np.exp(-1j * a), self.reflection * np.exp(1j * a)
        return self.amplitude * np.array([-1j * self.ratio * (there - back), there + back])

    def run(self, cycles, per_cycle):
        """Return velocity and displacement at the end of each cycle, from rest at an upward zero of ball 1's u_z."""
        omega = 2.0 * math.pi * self.frequency
        s = np.array([
            self.mass, self.preload, self.load, self.radius, self.E, self.G, self.mu, self.normal_damping,
            self.tangential_damping, omega, 2.0 * math.pi / self.wavelength, self.ratio,
        ])  # fmt: skip
        first = complex(self.orbits_at([0.0])[1, 0, 0])
        rows = np.empty((cycles, 2))
        start = -0.5 * math.pi - cmath.phase(first)
        _run(
            cycles, per_cycle, s, np.array(self.balls, float), complex(self.amplitude), complex(self.reflection), start,
            rows,
        )  # fmt: skip
        return rows.T
