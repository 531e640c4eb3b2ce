r"""A rigid slider on flat pillars that load the wave: rows, waves from both sides and first harmonics, independently.

Shares nothing with the product. The stop operator of each pillar is followed through three cycles with events by
bisection and Gauss-Legendre points between them; U+ and U- are marched over the rows with the forces at the middle of
each jump, by Anderson's acceleration of plain sweeps; SciPy finds approach, tilts and velocity.

    dU+ = +i g (P_1 + C* Q_1) exp(+i k x),    dU- = -i g (P_1 + C Q_1) exp(-i k x),    C = i r,    g = Gamma/w
"""

import math

import numpy as np
from numba import njit
from scipy.optimize import root

POINT, WEIGHT = np.polynomial.legendre.leggauss(5)
INTERVALS = 256


@njit(cache=True)
def _state(phi, h, A, d, e, w):
    """Return z, z', y, y' of a pillar: z = h + A cos, y = d cos + e sin - w phi."""
    co, si = math.cos(phi), math.sin(phi)
    return h + A * co, -A * si, d * co + e * si - w * phi, e * co - d * si - w


@njit(cache=True)
def _next_mode(mode, phi, x, h, A, d, e, w, c):
    """Return (mode, x) after an event: 0 apart, 2 stick, 1 and -1 slip."""
    z, dz, _, dy = _state(phi, h, A, d, e, w)
    if mode == 0:
        side = 1.0 if dy > 0.0 else -1.0
        return (int(side) if side * dy - c * dz > 0.0 else 2), 0.0
    if z <= 1e-13 * (abs(h) + A) and dz < 0.0:
        return 0, 0.0
    if mode == 2:
        side = 1.0 if x > 0.0 else -1.0
        return int(side), side * c * z
    return 2, mode * c * z


@njit(cache=True)
def _ends(mode, phi, x0, y0, h, A, d, e, w, c):
    """Return True if a mode has ended."""
    z, dz, y, dy = _state(phi, h, A, d, e, w)
    if mode == 0:
        return z > 0.0
    if z < 0.0:
        return True
    if mode == 2:
        return abs(x0 + y - y0) > c * z
    return mode * dy - c * dz < 0.0


@njit(cache=True)
def pillar(h, A, d, e, w, c, side, points, weights):
    """Return (<z>, Re z_1, <x>, cos and sin part of x_1, friction c <z |slip|>, contact share)."""
    out = np.zeros(7)
    if h + A <= 0.0:
        return out
    start = -math.pi
    z, _, y, _ = _state(start, h, A, d, e, w)
    # a pillar that always touches begins at the limit that its motion would have brought it to
    mode, x0, y0 = (2, -side * c * z * (1.0 - 1e-12), y) if z > 0.0 else (0, 0.0, y)
    width = 2.0 * math.pi / INTERVALS
    for turn in range(3):
        for k in range(INTERVALS):
            a, b = start + width * (turn * INTERVALS + k), start + width * (turn * INTERVALS + k + 1)
            for _ in range(20):
                if b - a < 1e-15:
                    break
                stop, ended = b, False
                if _ends(mode, b, x0, y0, h, A, d, e, w, c):
                    low, high, ended = a, b, True
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        if middle <= low or middle >= high:
                            break
                        if _ends(mode, middle, x0, y0, h, A, d, e, w, c):
                            high = middle
                        else:
                            low = middle
                    stop = high
                if turn == 2 and mode != 0:
                    half = 0.5 * (stop - a)
                    for j in range(points.size):
                        phi = a + half * (1.0 + points[j])
                        z, dz, y, dy = _state(phi, h, A, d, e, w)
                        x = x0 + y - y0 if mode == 2 else mode * c * z
                        q = half * weights[j] / math.pi
                        out[0] += 0.5 * q * z
                        out[1] += q * z * math.cos(phi)
                        out[2] += 0.5 * q * x
                        out[3] += q * x * math.cos(phi)
                        out[4] += q * x * math.sin(phi)
                        if mode != 2:
                            out[5] += 0.5 * q * c * z * (mode * dy - c * dz)
                        out[6] += 0.5 * q
                a = stop
                if ended:
                    _, _, y, _ = _state(stop, h, A, d, e, w)
                    x = x0 + y - y0 if mode == 2 else 0.0
                    mode, x0 = _next_mode(mode, stop, x, h, A, d, e, w, c)
                    y0 = y
    return out


@njit(cache=True)
def _all(h, A, d, e, w, c, side, points, weights):
    out = np.empty((h.size, 7))
    for i in range(h.size):
        out[i] = pillar(h[i], A[i], d[i], e[i], w, c[i], side, points, weights)
    return out


class Slider:
    """Pillars at places x, y in m with heights s, stiffnesses k_n, k_t in N/m, on waves from both sides, SI units."""

    def __init__(
        self, *, x, y, heights, k_n, k_t, mu, preload, frequency, wavelength, ratio, forward, backward=0.0,
        gamma=0.0, width=1.0, tilt="held", preload_at=(0.0, 0.0), load_height=0.0, load=0.0, damping=0.0, soft=False,
    ):  # fmt: skip
        order = np.argsort(x, kind="stable")
        self.order = order
        self.x, self.y, self.s = (np.broadcast_to(np.asarray(v, float), np.shape(x))[order] for v in (x, y, heights))
        self.k_n, self.k_t = (np.broadcast_to(np.asarray(v, float), np.shape(x))[order] for v in (k_n, k_t))
        self.mu, self.preload, self.load, self.damping = mu, preload, load, damping
        self.omega, self.k, self.C = 2.0 * math.pi * frequency, 2.0 * math.pi / wavelength, 1j * ratio
        self.forward, self.backward, self.g, self.width, self.gamma = (forward, backward, gamma / width, width, gamma)
        self.tilt, self.at, self.b, self.soft = tilt, preload_at, load_height, soft
        new = np.append(True, np.diff(self.x) > 1e-12)
        self.row, self.places = np.cumsum(new) - 1, self.x[new]
        self.first = np.flatnonzero(new)
        self.turn = np.exp(-1j * self.k * self.places)
        self.size = max(abs(forward), abs(backward))
        self.q = np.concatenate([forward * self.turn, backward * self.turn.conj()])  # waves at the rows
        self.H = None

    def sums(self, values):
        """Return sums over the rows."""
        return np.add.reduceat(values, self.first)

    def contacts(self, approach, w):
        """Return the columns of `pillar` and complex P_1, Q_1 at the present waves."""
        m = self.places.size
        u = (self.q[:m] + self.q[m:])[self.row]
        v = (self.C * self.q[:m] + self.C.conjugate() * self.q[m:])[self.row]
        A = abs(u)
        crest = np.where(A > 0.0, u / np.where(A > 0.0, A, 1.0), 1.0)
        along = v * crest.conj()
        side = math.copysign(1.0, w)
        out = _all(approach, A, along.real.copy(), -along.imag, w, self.mu * self.k_n / self.k_t, side, POINT, WEIGHT)
        return out, self.k_n * out[:, 1] * crest, self.k_t * (out[:, 3] - 1j * out[:, 4]) * crest

    def swept(self, approach, w):
        """Return new waves at the rows from the present ones, and what leaves on either side."""
        out, P, Q = self.contacts(approach, w)
        rise = 1j * self.g * self.sums(P + self.C.conjugate() * Q) * self.turn.conj()
        fall = 1j * self.g * self.sums(P + self.C * Q) * self.turn
        plus = self.forward + np.cumsum(rise)
        minus = self.backward + np.cumsum(fall[::-1])[::-1]  # dU-/dx is negative: it grows towards the left
        new = np.concatenate([(plus - 0.5 * rise) * self.turn, (minus - 0.5 * fall) * self.turn.conj()])
        return new, out, (plus[-1], minus[0])

    def heights_of_rows(self, w):
        """Return H of each row for equal force per pillar (soft backing)."""
        out = np.empty(self.places.size)
        u = abs(self.q[: out.size] + self.q[out.size :])
        for j in range(out.size):
            mine = self.row == j
            share = self.preload * np.sum(mine) / self.x.size
            low, high = -1e-6, 1e-6
            for _ in range(100):
                h = 0.5 * (low + high)
                total = 0.0
                for a, k in zip(self.s[mine] + h, self.k_n[mine], strict=True):
                    p = math.acos(min(max(-a / u[j], -1.0), 1.0)) if u[j] > 0.0 else math.pi * (a > 0.0)
                    total += k * (u[j] * math.sin(p) + a * p) / math.pi
                low, high = (low, h) if total > share else (h, high)
            out[j] = 0.5 * (low + high)
        return out

    def settled(self, unknowns, w):
        """Return the columns with waves that agree with the forces, and what leaves."""
        history = []
        for _ in range(300):
            if self.soft:
                approach = self.heights_of_rows(w)[self.row] + self.s
            else:
                approach = unknowns[0] + unknowns[1] * self.x + unknowns[2] * self.y + self.s
            new, out, left = self.swept(approach, w)
            step = new - self.q
            if self.g == 0.0 or np.max(abs(step)) < 1e-13 * self.size:
                break
            history = [*history[-6:], (self.q.copy(), step)]
            if len(history) < 3:
                self.q = self.q + step
                continue
            last_q, last_step = history[-1]
            dq = np.array([last_q - a for a, _ in history[:-1]]).T
            ds = np.array([last_step - b for _, b in history[:-1]]).T
            real = np.concatenate([ds.real, ds.imag])
            share = np.linalg.lstsq(real, np.concatenate([last_step.real, last_step.imag]), rcond=1e-12)[0]
            self.q = last_q + last_step - (dq + ds) @ share
        else:
            raise RuntimeError(f"waves do not settle: {np.max(abs(step)) / self.size:.1e}")
        return out, left

    def residual(self, scaled, names, speed):
        """Return the scaled residuals of forces and moments."""
        values = dict(zip(names, scaled, strict=True))
        arm = self.arm
        unknowns = (
            values.get("H", 0.0) * self.size,
            *(values.get(n, 0.0) * self.size / a for n, a in zip(("pitch", "roll"), arm, strict=True)),
        )
        w = values.get("w", speed / self.size) * self.size
        out, left = self.settled(unknowns, w)
        P, Q = self.k_n * out[:, 0], self.k_t * out[:, 2]
        self.last = unknowns, w, out, left
        at = self.at[0] - self.b * self.load / self.preload
        full = {
            "H": (P.sum() - self.preload) / self.preload,
            "pitch": ((P * self.x).sum() - self.preload * at) / self.preload / arm[0],
            "roll": ((P * self.y).sum() - self.preload * self.at[1]) / self.preload / arm[1],
            "w": (Q.sum() - self.load - self.damping * w * self.omega) / (self.mu * self.preload),
        }
        return [full[n] for n in names]

    @property
    def arm(self):
        """Half the extents, m."""
        return [max(np.ptp(each), 1e-9) / 2.0 for each in (self.x, self.y)]

    def solve(self, guess):
        """Return the velocity in m/s near a guess (H in m, pitch, roll, v in m/s)."""
        names = (
            ([] if self.soft else ["H"])
            + {"held": [], "pitch": ["pitch"], "free": ["pitch", "roll"]}[self.tilt]
            + ["w"]
        )
        all_of = {
            "H": guess[0] / self.size,
            "pitch": guess[1] * self.arm[0] / self.size,
            "roll": guess[2] * self.arm[1] / self.size,
            "w": guess[3] / self.omega / self.size,
        }
        found = root(
            self.residual,
            [all_of[n] for n in names],
            args=(names, 0.0),
            method="hybr",
            tol=1e-12,
            options={"eps": 1e-7},
        )
        final = np.max(np.abs(self.residual(found.x, names, 0.0)))
        if final > 1e-8:
            raise RuntimeError(f"no equilibrium: {final:.1e}")
        return self.last[1] * self.omega

    def report(self):
        """Return exit and reflected amplitude over the incident one, powers and shares of the last solution."""
        unknowns, w, out, left = self.last
        friction = self.k_t * self.omega * out[:, 5]
        power = self.omega * self.width / 4.0 / self.gamma if self.gamma else 0.0
        into, gone = (power * (abs(a) ** 2 + abs(b) ** 2) for a, b in ((self.forward, self.backward), left))
        normal, each = np.empty_like(friction), np.empty_like(friction)
        normal[self.order], each[self.order] = self.k_n * out[:, 0], friction
        return {
            "H": unknowns[0], "tilt": unknowns[1:], "right": left[0], "left": left[1], "friction": friction.sum(),
            "thrust": self.load * w * self.omega, "in": into, "out": gone, "touching": float(np.mean(out[:, 6] > 0.0)),
            "normal": normal, "friction_each": each,
        }  # fmt: skip
