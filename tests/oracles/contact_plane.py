r"""Friction of a contact in the plane, by two ways that share nothing with the product. SI units.

`cycle_means`: a contact under a body that keeps height and velocity, event by event: stick in closed form, the angle of
slip (c z) alpha' = t.w by scipy's Radau method together with the integrals of the forces, from the series
alpha = alpha_w + kappa/(1 + kappa) alpha_w' tau where slip begins at the touch. `in_steps`: the full motion of a rigid
body by Verlet's method, deformations cut to the disc of radius c z, extrapolated over the step size.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq


@dataclass(frozen=True)
class PlaneContact:
    """A ball or a flat punch under waves; amplitudes (w, 3) are complex and peak, of u_x, u_y, u_z."""

    stiffness: float  # of P = k z^1.5, or k z
    mu: float
    c: float
    frequencies: tuple[float, ...]
    amplitudes: np.ndarray
    height: float  # mean approach, m
    velocity: tuple[float, float]  # of the body at the contact
    punch: bool = False

    @cached_property
    def exponents(self):
        """Factors i omega of the waves."""
        return 2j * np.pi * np.array(self.frequencies)

    def displacement(self, t):
        """Return the surface's displacement (3,)."""
        return (np.exp(self.exponents * t) @ self.amplitudes).real

    def approach(self, t):
        return self.height + self.displacement(t)[2]

    def kinematics(self, t):
        """Return z, z', w, w'."""
        turning = np.exp(self.exponents * t)[:, None] * self.amplitudes
        factors = np.array([self.exponents**0, self.exponents, self.exponents**2])
        u, rate, second = (factors @ turning).real
        return self.height + u[2], rate[2], rate[:2] - self.velocity, second[:2]

    def load(self, z):
        """Return P."""
        return self.stiffness * (max(z, 0.0) if self.punch else max(z, 0.0) ** 1.5)

    def force(self, z, e):
        """Return Q (2,)."""
        size = math.hypot(*e)
        if size == 0.0:
            return np.zeros(2)
        return self.mu * (self.load(z) - self.load(z - size / self.c)) * np.asarray(e) / size


class _Cycle:
    """One contact followed from event to event; sums of P, Q_x, Q_y and mu P lambda over time."""

    def __init__(self, contact, rtol):
        self.contact, self.rtol, self.sums, self.slips = contact, rtol, np.zeros(4), 0
        self.tick = 1.0 / max(contact.frequencies)

    def stick(self, t, stop, e):
        """Follow stick; return (end, e, what comes next)."""
        c, u_0 = self.contact, self.contact.displacement(t)
        (e_x, e_y), (v_x, v_y) = (e - u_0[:2]).tolist(), c.velocity

        def followed(s):
            """Return the approach and both deformations."""
            x, y, z = c.displacement(s).tolist()
            return c.height + z, e_x + x - v_x * (s - t), e_y + y - v_y * (s - t)

        def deformation(s):
            return np.array(followed(s)[1:])

        def size(s):
            return math.hypot(*followed(s)[1:])

        def margin(s):
            z, x, y = followed(s)
            return c.c * z - math.hypot(x, y)

        end, after, step, left = stop, "stop", self.tick / 256, t
        while left < stop:
            right = min(left + step, stop)
            if margin(right) < -1e-12 * c.c * abs(c.height):
                inside = left if margin(left) > 0.0 else left + 1e-4 * (right - left)
                if margin(inside) <= 0.0:
                    inside, right = left, left
                end = brentq(margin, inside, right, xtol=1e-20, rtol=1e-15) if right > inside else left
                after = "slip"
                break
            left = right

        def at(s):
            z, *x = followed(s)
            return np.array([c.load(z), *c.force(z, x), 0.0])

        # the force bends where |e| is least; square roots at both ends are taken out by s = t + (end - t) sin^2
        cycles = 1 + math.ceil((end - t) / self.tick)  # a stick may last for several, each with a least |e|
        inner = list(np.linspace(t, end, 8 * cycles + 1)[1:-1])
        nodes, weights = np.polynomial.legendre.leggauss(20)
        turn = np.linspace(t, end, 256 * cycles + 1)
        sizes = [size(s) for s in turn]
        for least in range(1, len(turn) - 1):
            if not sizes[least - 1] > sizes[least] <= sizes[least + 1]:
                continue
            low, high = turn[least - 1], turn[least + 1]
            for _ in range(80):
                third = (high - low) / 3.0
                if size(low + third) < size(high - third):
                    high -= third
                else:
                    low += third
            inner.append(0.5 * (low + high))
        edges = np.array([t, *sorted(inner), end])
        for a, b in pairwise(edges):
            theta = 0.25 * math.pi * (nodes + 1.0)
            points = a + (b - a) * np.sin(theta) ** 2
            factor = (b - a) * np.sin(2.0 * theta) * 0.25 * math.pi * weights
            self.sums += sum(w * at(s) for s, w in zip(points, factor, strict=True))
        return end, deformation(end), after

    def slip(self, t, stop, alpha):
        """Follow slip; return (end, e, what comes next)."""
        c = self.contact
        self.slips += 1
        scale = np.array([c.load(abs(c.height) + np.abs(c.amplitudes).sum()) * self.tick] * 3)
        power = c.mu * scale[0] / self.tick * np.abs(c.amplitudes).sum() * 6.0

        def rates(s, y):
            z, z_rate, w, _ = c.kinematics(s)
            n = np.array([math.cos(y[0]), math.sin(y[0])])
            p = c.load(z)
            turning = (n[0] * w[1] - n[1] * w[0]) / (c.c * max(z, 1e-30))
            return [turning, p, *(c.mu * p * n), c.mu * p * (n @ w - c.c * z_rate)]

        def gap(s, y):
            return c.approach(s) - 1e-5 * np.abs(c.amplitudes).sum()

        def ends(s, y):
            _, z_rate, w, _ = c.kinematics(s)
            return math.cos(y[0]) * w[0] + math.sin(y[0]) * w[1] - c.c * z_rate

        for event in (gap, ends):
            event.terminal, event.direction = True, -1
        z, z_rate, w, w_rate = c.kinematics(t)
        begin, start = t, alpha
        if z < 1e-9 * np.abs(c.amplitudes).sum():  # from the touch
            kappa = math.hypot(*w) / (c.c * z_rate)
            turn = (w[0] * w_rate[1] - w[1] * w_rate[0]) / (w @ w)
            begin = t + 1e-5 * self.tick
            rate = kappa / (1.0 + kappa) * turn
            start = alpha + rate * (begin - t)
            self.add(t, begin, lambda s: alpha + rate * (s - t))
        found = solve_ivp(
            rates, (begin, stop), [start, 0, 0, 0, 0], method="Radau", rtol=self.rtol, events=(gap, ends),
            atol=np.array([self.rtol, *(1e-3 * self.rtol * scale), 1e-3 * self.rtol * power]),
            max_step=self.tick / 40,
        )  # fmt: skip
        assert found.status >= 0, found.message
        end, y = found.t[-1], found.y[:, -1]
        self.sums += y[1:]
        opens, sticks = (each.size > 0 for each in found.t_events)
        if opens:
            opening = brentq(c.approach, end, end + 1e-2 * self.tick, xtol=1e-22, rtol=1e-15)
            self.add(end, opening, lambda s: y[0])
            return end, np.zeros(2), "open"
        e = c.c * c.approach(end) * np.array([math.cos(y[0]), math.sin(y[0])])
        return end, e, "stick" if sticks else "stop"

    def add(self, a, b, alpha):
        """Add the sums of slip in a known direction, at either end of a contact, where z is too small for Radau."""
        c = self.contact
        nodes, weights = np.polynomial.legendre.leggauss(12)
        theta = 0.25 * math.pi * (nodes + 1.0)
        for s, d in zip(
            a + (b - a) * np.sin(theta) ** 2, (b - a) * np.sin(2 * theta) * 0.25 * math.pi * weights, strict=True
        ):
            z, z_rate, w, _ = c.kinematics(s)
            n, p = np.array([math.cos(alpha(s)), math.sin(alpha(s))]), c.load(z)
            self.sums += d * np.array([p, *(c.mu * p * n), c.mu * p * (n @ w - c.c * z_rate)])

    def follow(self, t, stop, e=None):
        """Follow the contact from an instant at which it hangs in the air (e None) or sticks with e; return e."""
        c, state = self.contact, "open" if e is None else "stick"
        for _ in range(100_000):
            if t >= stop - 1e-15 * abs(stop):
                return e
            if state == "open":
                left, step = t, self.tick / 256
                left += 1e-3 * step
                while left < stop and not (c.approach(left) <= 0.0 < c.approach(left + step)):
                    left += step
                if (left + step > stop and c.approach(min(left + step, stop)) <= 0.0) or left >= stop:
                    return None
                t = brentq(c.approach, left, left + step, xtol=1e-22, rtol=1e-15)
                _, z_rate, w, _ = c.kinematics(t)
                e, state = np.zeros(2), "slip" if math.hypot(*w) > c.c * z_rate else "stick"
                alpha = math.atan2(w[1], w[0])
            if state == "stick":
                t, e, state = self.stick(t, stop, e)
                alpha = math.atan2(e[1], e[0])
            if state == "slip" and t < stop:
                t, e, state = self.slip(t, stop, alpha)
            if state == "stop":
                return e
        raise RuntimeError("too many events")


def cycle_means(contact: PlaneContact, period: float, rtol: float = 1e-9) -> np.ndarray:
    """Return the means of (P, Q_x, Q_y, slip power) over a period in which the contact repeats."""
    return repeated_cycle(contact, period, rtol)[0]


def repeated_cycle(contact: PlaneContact, period: float, rtol: float, start: np.ndarray | None = None):
    """Return the means of a period in which the contact repeats, and its deformation where the period begins.

    ``start``: the deformation of a contact that always touches from which the search begins, by default none.
    """
    grid = np.linspace(0.0, period, 4096, endpoint=False)
    lowest = grid[int(np.argmin([contact.approach(t) for t in grid]))]
    e = None if contact.approach(lowest) <= 0.0 else np.zeros(2) if start is None else start
    last = 0.0
    for count in range(200):
        run = _Cycle(contact, rtol)
        new = run.follow(lowest, lowest + period, e)
        change = 0.0 if e is None else math.hypot(*(new - e))
        if e is None or change < 1e-10 * contact.c * contact.approach(lowest):
            return run.sums / period, new
        share = change / last if last > 0.0 else 0.0
        e, last = new + (new - e) * (share / (1.0 - share) if count % 4 == 3 and share < 0.999 else 0.0), change
    raise RuntimeError("the contact does not repeat")


def mean_load(contact: PlaneContact, period: float) -> float:
    """Return the mean of P by quadrature between the roots of z."""
    grid = np.linspace(0.0, period, 4001)
    values = np.array([contact.approach(t) for t in grid])
    flips = np.flatnonzero((values[:-1] > 0.0) != (values[1:] > 0.0))
    roots = [brentq(contact.approach, grid[k], grid[k + 1], xtol=1e-22) for k in flips]
    edges = [0.0, *roots, period]
    total = 0.0
    for a, b in pairwise(edges):
        if contact.approach(0.5 * (a + b)) > 0.0:
            total += quad(
                lambda x, a=a, b=b: contact.load(contact.approach(a + (b - a) * math.sin(x) ** 2))
                * (b - a) * math.sin(2.0 * x), 0.0, 0.5 * math.pi, epsabs=0.0, epsrel=1e-11, limit=200,
            )[0]  # fmt: skip
    return total / period


@njit(cache=True)
def _steps(cycles, per_cycle, omega, amplitudes, rise, body, balls, punch, fixed, state, times, factors):
    """Move state (z, x, y, psi, rates) for so many cycles of the first frequency; return 0.

    times (k,), factors (2, w, k): amplitude and phase of a factor on each wave, linear between the times.

    fixed: x and y are held by an axle; body: mass, 1/inertia, preload, F_x, F_y, M, R_n, R_t, chi;
    balls (n, 6): x, y, height, k, c, mu.
    """
    knot, n, h = 0, balls.shape[0], 2.0 * math.pi / omega[0] / per_cycle
    old, z_old = np.zeros((n, 2)), np.zeros(n)
    e, force = np.zeros((n, 2)), np.zeros(4)
    inverse = np.array([1.0 / body[0], 0.0 if fixed else 1.0 / body[0], 0.0 if fixed else 1.0 / body[0], body[1]])
    damping, push = np.array([body[6], body[7], body[7], 0.0]), np.array([-body[2], -body[3], -body[4], -body[5]])
    for step in range(cycles * per_cycle + 1):
        t = step * h
        if step > 0:
            for k in range(4):
                state[4 + k] += 0.5 * h * inverse[k] * (force[k] + push[k] - damping[k] * state[4 + k])
                state[k] += h * state[4 + k]
        envelope = 1.0 - math.exp(-t / rise) if rise > 0.0 else 1.0
        grows = (1.0 - envelope) / rise if rise > 0.0 else 0.0
        while knot + 2 < times.size and times[knot + 1] < t:
            knot += 1
        width = times[knot + 1] - times[knot]
        part = min(max((t - times[knot]) / width, 0.0), 1.0)
        force[:] = 0.0
        for i in range(n):
            x, y = balls[i, 0], balls[i, 1]
            a, b = math.cos(state[3]) * x - math.sin(state[3]) * y, math.sin(state[3]) * x + math.cos(state[3]) * y
            u_x = u_y = u_z = w_z = 0.0
            for j in range(omega.size):
                size = factors[0, j, knot] + part * (factors[0, j, knot + 1] - factors[0, j, knot])
                angle = omega[j] * t + factors[1, j, knot] + part * (factors[1, j, knot + 1] - factors[1, j, knot])
                turn = complex(math.cos(angle), math.sin(angle))
                u_x += envelope * size * (amplitudes[j, i, 0] * turn).real
                u_y += envelope * size * (amplitudes[j, i, 1] * turn).real
                u_z += envelope * size * (amplitudes[j, i, 2] * turn).real
                growth = (factors[0, j, knot + 1] - factors[0, j, knot]) / width if 0.0 < part < 1.0 else 0.0
                shift = (factors[1, j, knot + 1] - factors[1, j, knot]) / width if 0.0 < part < 1.0 else 0.0
                w_z += envelope * (amplitudes[j, i, 2] * (1j * (omega[j] + shift) * size + growth) * turn).real
                w_z += grows * size * (amplitudes[j, i, 2] * turn).real
            place_x, place_y = u_x - state[1] - a, u_y - state[2] - b
            z = balls[i, 2] + u_z - state[0]
            if step > 0 and z > 0.0:
                share = z / (z - z_old[i]) if z_old[i] < 0.0 else 1.0
                e[i, 0] += share * (place_x - old[i, 0])
                e[i, 1] += share * (place_y - old[i, 1])
            old[i, 0], old[i, 1], z_old[i] = place_x, place_y, z
            if z <= 0.0:
                e[i] = 0.0
                continue
            size, limit = math.sqrt(e[i, 0] ** 2 + e[i, 1] ** 2), balls[i, 4] * z
            if size > limit:
                e[i] *= limit / size
                size = limit
            stuck = z - size / balls[i, 4]
            p = balls[i, 3] * (z if punch else z * math.sqrt(z))
            q = balls[i, 5] * (p - balls[i, 3] * (stuck if punch else stuck * math.sqrt(max(stuck, 0.0))))
            force[0] += p * (1.0 + body[8] * (w_z - state[4]))
            if size > 0.0:
                force[1] += q * e[i, 0] / size
                force[2] += q * e[i, 1] / size
                force[3] += q * (a * e[i, 1] - b * e[i, 0]) / size
        if step > 0:
            for k in range(4):
                half = 0.5 * h * inverse[k]
                state[4 + k] = (state[4 + k] + half * (force[k] + push[k])) / (1.0 + half * damping[k])
    return 0


def in_steps(
    cycles, frequencies, amplitudes, rise, body, balls, punch, start, sizes=(1024, 2048, 4096), fixed=False, shape=None
):
    """Return (state, error) after so many cycles from `start` (8,), extrapolated over the step size.

    The rule is of first order, with terms of h^1.5 where events fall within a step; the error is the change by the last
    extrapolation and a share of its correction. ``shape``: times (k,)
    in s, and amplitude and phase (w, k) of a factor on the waves there.
    """
    ones = np.ones((len(frequencies), 2))
    times, *factors = (np.array([0.0, 1.0]), ones, 0.0 * ones) if shape is None else shape
    runs = []
    for per_cycle in sizes:
        state = np.array(start, float)
        _steps(
            cycles, per_cycle, 2.0 * np.pi * np.array(frequencies), np.ascontiguousarray(amplitudes), rise,
            np.array(body, float), np.array(balls, float), punch, fixed, state,
            np.array(times, float), np.array(factors, float),
        )  # fmt: skip
        runs.append(state)
    first, second = 2.0 * runs[1] - runs[0], 2.0 * runs[2] - runs[1]
    return second, np.abs(second - first) + 1e-2 * np.abs(runs[2] - runs[1])
