r"""A slider on one ball that adhesion holds, integrated from event to event by SciPy's DOP853. SI units.

Shares nothing with the product. A ball of Johnson, Kendall and Roberts closes where its approach z rises through zero,
with the circle of the radius a(0), and opens where dz/da = 0. While it is closed, y = sqrt(a) is a variable of the
integration in the place of the slider's height, z = y^4/R - sqrt(2 pi w/E) y, and tau with

    d phi/d tau = M/(1 + M),   dy/d tau = z'/(1 + M),   M = dz/dy (scaled),   ' = d/d phi,

in the place of the phase phi: M passes zero linearly at the end, so that no root is drawn, and nothing is singular. The
deformation x follows the surface while the ball sticks, and is mu E a^2/(4 G R) while it slips. Four further components
add up the work of the surface and the losses.

Of a ball of Maugis and Dugdale (J. Colloid Interface Sci. 150 (1992) 243), y = cot arccos(a/c), with the radius c of
the attraction. It closes where its gap is that which the attraction reaches over, or as a point, and opens where
dz/da = 0 or as a point; in both M passes zero.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

OPEN, STICK, SLIP = "open", "stick", "slip"
LENGTH = 1e-9  # m, of the integration; time in 1/omega
PHASE, PLACE, RATE, VELOCITY, X, TRAVEL, WAVE_NORMAL, WAVE_TANGENTIAL, SLIP_LOSS, NORMAL_LOSS = range(10)
MAX_STEP = 0.05


@dataclass(frozen=True, kw_only=True)
class HoldingBall:
    """One ball and its wave: amplitudes of exp(i omega t) in m, everything else in SI units."""

    radius: float
    modulus: float
    tangential_modulus: float
    work: float
    mu: float
    mass: float
    preload: float
    frequency: float
    normal: complex
    tangential: complex
    normal_damping: float = 0.0
    tangential_damping: float = 0.0
    load: float = 0.0

    @property
    def omega(self):
        return 2.0 * math.pi * self.frequency

    @property
    def root(self):
        return math.sqrt(2.0 * math.pi * self.work / self.modulus)

    @property
    def slope(self):
        return self.mu * self.modulus / (4.0 * self.tangential_modulus)

    closes_at = 0.0  # approach

    @property
    def unit(self):
        """Unit of y, its value where the ball closes."""
        return (self.root * self.radius) ** (1.0 / 3.0)

    @property
    def first(self):
        """Return y of a ball that has just closed."""
        return self.unit

    def approach(self, y):
        return y**4 / self.radius - self.root * y

    def approach_slope(self, y):
        return 4.0 * y**3 / self.radius - self.root

    def depth(self, y):
        """Return a^2/R."""
        return y**4 / self.radius

    def depth_slope(self, y):
        return 4.0 * y**3 / self.radius

    def place_at(self, z):
        """Return y of a closed ball: the largest root, from the eigenvalues of the companion matrix."""
        unit = self.unit
        lead, linear = unit**4 / self.radius, self.root * unit
        y = max(each.real for each in np.roots([lead, 0.0, 0.0, -linear, -z]) if abs(each.imag) < 1e-6)
        for _ in range(3):
            y -= (lead * y**4 - linear * y - z) / (4.0 * lead * y**3 - linear)
        return y * unit

    def normal_force(self, y):
        a = y * y
        hertz = 4.0 * self.modulus * a**3 / (3.0 * self.radius)
        return hertz - math.sqrt(8.0 * math.pi * self.work * self.modulus) * a**1.5

    def friction_force(self, y, x):
        """Return Q: mu times the elastic force less that of the part that sticks."""
        stiffness, depth = 4.0 / 3.0 * self.modulus * math.sqrt(self.radius), self.depth(y)
        left = max(depth - abs(x) / self.slope, 0.0)
        return math.copysign(self.mu * stiffness * (depth**1.5 - left**1.5), x)

    def spring(self, y, x):
        """Return the energy of the tangential spring, the integral of Q dx, J."""
        depth, stiffness = self.depth(y), 4.0 / 3.0 * self.modulus * math.sqrt(self.radius)
        left = max(depth - abs(x) / self.slope, 0.0)
        return self.mu * stiffness * self.slope * ((depth - left) * depth**1.5 - 0.4 * (depth**2.5 - left**2.5))


@dataclass(frozen=True, kw_only=True)
class DugdaleBall(HoldingBall):
    """One ball of Maugis and Dugdale."""

    separation: float  # of the surfaces in equilibrium, m

    @property
    def traction(self):
        """Largest traction of a Lennard-Jones potential, Pa."""
        return 16.0 / (9.0 * math.sqrt(3.0)) * self.work / self.separation

    @property
    def number(self):
        rigid = 4.0 / 3.0 * self.modulus
        return 2.0 * self.traction * (self.radius / (math.pi * self.work * rigid**2)) ** (1.0 / 3.0)

    unit = 1.0

    @cached_property
    def last(self):
        """Return the smallest y: 0 of a point, or where dz/dy vanishes."""
        y = np.geomspace(1e-4, 1e3, 4000)
        rising = np.array([self.approach_slope(each) for each in y]) > 0.0
        if rising.all():
            return 0.0
        k = int(np.flatnonzero(~rising)[-1])
        return brentq(self.approach_slope, y[k], y[k + 1], xtol=1e-15)

    @cached_property
    def closes_at(self):
        return max(-self.work / self.traction, float(self.approach(self.last)))

    @cached_property
    def first(self):
        return self.last if self.closes_at == float(self.approach(self.last)) else self.place_at(self.closes_at)

    def _radii(self, y):
        """Return radius of contact and of attraction in Maugis's unit, and the angle; y may be complex."""
        lam, t = self.number, 0.5 * math.pi - np.arctan(y)
        square = 0.5 * lam * (np.sin(t) * np.cos(t) - t * np.cos(2.0 * t))
        linear = 4.0 / 3.0 * lam**2 * (t * np.sin(t) - 1.0 + np.cos(t))
        c = (np.sqrt(linear**2 + 4.0 * square) - linear) / (2.0 * square)
        return c * np.cos(t), c, t

    def approach(self, y):
        a, c, t = self._radii(y)
        unit = (math.pi**2 * self.work**2 * self.radius / (4.0 / 3.0 * self.modulus) ** 2) ** (1.0 / 3.0)
        return unit * (a**2 - 4.0 / 3.0 * self.number * c * np.sin(t))

    def approach_slope(self, y):
        return self.approach(y + 1e-30j).imag / 1e-30

    def depth(self, y):
        a = self._radii(y)[0]
        return (math.pi**2 * self.work**2 * self.radius / (4.0 / 3.0 * self.modulus) ** 2) ** (1.0 / 3.0) * a**2

    def depth_slope(self, y):
        return self.depth(y + 1e-30j).imag / 1e-30

    def place_at(self, z):
        return brentq(lambda y: float(self.approach(y)) - z, self.last, 1e3, xtol=1e-15, rtol=1e-14)

    def normal_force(self, y):
        a, c, t = self._radii(y)
        return math.pi * self.work * self.radius * (a**3 - self.number * c**2 * (t + np.sin(t) * np.cos(t)))


class Integration:
    """The motion of a ball from a state (z_s, z_s', v, x) at phase 0, in SI units."""

    def __init__(self, ball: HoldingBall, state, *, closed: bool, tolerance=1e-11):
        self.ball, self.sign, self.tolerance = ball, 1.0, tolerance
        self.mode = STICK if closed else OPEN
        self.unit = ball.unit  # of y
        height, rate, velocity, x = state
        self.y = np.zeros(10)
        self.y[RATE : X + 1] = rate / ball.omega / LENGTH, velocity / ball.omega / LENGTH, x / LENGTH
        self.y[PLACE] = height / LENGTH
        if closed:
            self.y[PLACE] = ball.place_at(self.surface(0.0)[0] - height) / self.unit
        self.lost, self.hops = 0.0, 0

    def surface(self, phase):
        """Return u_z, u_z', u_x, u_x' in m and per radian."""
        turn = complex(math.cos(phase), math.sin(phase))
        u_z, u_x = self.ball.normal * turn, self.ball.tangential * turn
        return u_z.real, (1j * u_z).real, u_x.real, (1j * u_x).real

    def slowness(self, y):
        """Return M, 0 where a closed ball opens; infinite (None) of an open one."""
        if self.mode == OPEN:
            return None
        return self.ball.approach_slope(y[PLACE] * self.unit) * self.unit / LENGTH

    def deformation(self, y):
        if self.mode == STICK:
            return LENGTH * y[X]
        return self.sign * self.ball.slope * self.ball.depth(y[PLACE] * self.unit)

    def slip(self, y, z_rate, x_rate):
        """Return the speed of slip times M, in m per radian."""
        place = y[PLACE] * self.unit
        deeper = self.ball.slope * self.ball.depth_slope(place) * self.unit * z_rate / LENGTH
        return self.sign * x_rate * self.slowness(y) - deeper

    def rates(self, _, y):
        ball, (_, u_z_rate, _, u_x_rate) = self.ball, self.surface(y[PHASE])
        M = self.slowness(y)
        normal = along = lost = 0.0
        share = 1.0
        x_rate = u_x_rate - LENGTH * y[VELOCITY]
        if M is not None:
            share = M / (1.0 + M)
            place = y[PLACE] * self.unit
            normal, along = ball.normal_force(place), ball.friction_force(place, self.deformation(y))
            z_rate = u_z_rate - LENGTH * y[RATE]
            moved = z_rate / LENGTH / (1.0 + M)
            if self.mode == SLIP:
                lost = abs(along) * self.slip(y, z_rate, x_rate) / (1.0 + M)
        else:
            moved = y[RATE]
        unit = ball.mass * ball.omega**2 * LENGTH
        damper, drag = ball.normal_damping * ball.omega * LENGTH, ball.tangential_damping * ball.omega * LENGTH
        energy = unit * LENGTH
        return np.array([
            share, moved, share * (normal - ball.preload - damper * y[RATE]) / unit,
            share * (along - ball.load - drag * y[VELOCITY]) / unit,
            share * x_rate / LENGTH if self.mode == STICK else 0.0, share * y[VELOCITY],
            share * normal * u_z_rate / energy, share * along * u_x_rate / energy, lost / energy,
            share * damper * LENGTH * y[RATE] ** 2 / energy,
        ])  # fmt: skip

    def _events(self, stop):
        ball = self.ball

        def ends(_, y):
            return y[PHASE] - stop

        def closes(_, y):
            return (self.surface(y[PHASE])[0] - ball.closes_at) / LENGTH - y[PLACE]

        def opens(_, y):
            return self.slowness(y)

        def slips(_, y):
            return (ball.slope * ball.depth(y[PLACE] * self.unit) - LENGTH * abs(y[X])) / LENGTH

        def sticks(_, y):
            _, u_z_rate, _, u_x_rate = self.surface(y[PHASE])
            return self.slip(y, u_z_rate - LENGTH * y[RATE], u_x_rate - LENGTH * y[VELOCITY]) / LENGTH

        own = {OPEN: [(closes, 1.0)], STICK: [(opens, -1.0), (slips, -1.0)], SLIP: [(opens, -1.0), (sticks, -1.0)]}
        found = [(ends, 1.0), *own[self.mode]]
        for function, direction in found:
            function.terminal, function.direction = True, direction
        return [function for function, _ in found]

    def until(self, stop):
        """Go on to a phase."""
        for _ in range(10_000):
            if self.y[PHASE] >= stop - 1e-12:
                return
            found = solve_ivp(
                self.rates, (0.0, 1e3), self.y, method="DOP853", rtol=self.tolerance, atol=self.tolerance,
                events=self._events(stop), max_step=MAX_STEP,
            )  # fmt: skip
            if found.status != 1:
                raise RuntimeError(found.message)
            self.y = found.y[:, -1]
            which = next(k for k, each in enumerate(found.t_events) if each.size)
            if which > 0:
                self._pass(which)
        raise RuntimeError("too many events")

    def _pass(self, which):
        """Enter the mode behind an event."""
        ball, y = self.ball, self.y
        if self.mode == OPEN:
            self.mode, y[X], self.hops = STICK, 0.0, self.hops + 1
            _, z_rate, _, x_rate = self.surface(y[PHASE])
            z_rate, x_rate = z_rate - LENGTH * y[RATE], x_rate - LENGTH * y[VELOCITY]
            y[PLACE] = ball.first / self.unit
            if (
                ball.depth(ball.first) < 1e-25
            ):  # as a point: it slips where the surface runs faster than the limit grows
                near = ball.first + 1e-6
                deeper = ball.slope * ball.depth_slope(near) / ball.approach_slope(near) * z_rate
                if abs(x_rate) > deeper:
                    self.mode, self.sign = SLIP, math.copysign(1.0, x_rate)
        elif which == 1:
            place = y[PLACE] * self.unit
            self.lost += ball.spring(place, self.deformation(y))
            height = self.surface(y[PHASE])[0] - ball.approach(place)
            self.mode, y[PLACE], y[X] = OPEN, height / LENGTH, 0.0
        elif self.mode == STICK:
            self.mode, self.sign = SLIP, math.copysign(1.0, y[X])
        else:
            self.mode, y[X] = STICK, self.deformation(y) / LENGTH

    @property
    def state(self):
        """z_s in m, z_s' and v in m/s, x in m."""
        y, ball = self.y, self.ball
        height = LENGTH * y[PLACE]
        if self.mode != OPEN:
            height = self.surface(y[PHASE])[0] - ball.approach(y[PLACE] * self.unit)
        x = 0.0 if self.mode == OPEN else self.deformation(y)
        return np.array([height, LENGTH * ball.omega * y[RATE], LENGTH * ball.omega * y[VELOCITY], x])

    @property
    def energies(self):
        """Works and losses, J: of the normal and tangential motion of the surface, by slip, in the normal damper."""
        return self.y[WAVE_NORMAL:] * self.ball.mass * self.ball.omega**2 * LENGTH**2
