r"""Adhesion of a sphere with a constant traction over a finite distance: the model of Maugis and Dugdale.

Maugis, J. Colloid Interface Sci. 150 (1992) 243; Johnson and Greenwood, J. Colloid Interface Sci. 192 (1997) 326.
The surfaces attract with sigma_0 where their gap is below h_0, sigma_0 h_0 = w, between the radius a of the contact and
the radius c of the attraction. With sigma_0 = 1.026 w/e, the largest traction of a Lennard-Jones potential with the
equilibrium separation e, lambda = 1.157 times Tabor's number. JKR is the limit of large, DMT that of small numbers.

With K = (4/3) E, and lengths of contact in units of (pi w R^2/K)^(1/3), forces in pi w R, approaches in
(pi^2 w^2 R/K^2)^(1/3), and cos t = a/c, the equations of both papers are

    (lambda c^2/2) (sin t cos t - t cos 2t) + (4 lambda^2 c/3) (t sin t - 1 + cos t) = 1                     (1)
    P = a^3 - lambda c^2 (t + sin t cos t)                                                                   (2)
    z = a^2 - (4/3) lambda c sin t                                                                           (3)

(1) is a quadratic equation in c, so that t from 0 to pi/2 runs through all contacts in closed form. At t = pi/2 the
contact is a point; beyond, the surfaces attract without touching, over a radius c with a uniform traction (Johnson,
*Contact Mechanics* (1985), section 3.4(a)):

    P = -pi c^2 sigma_0,     z = c^2/2R - 4 sigma_0 c/(pi E) - h_0                                           (4)

Where z is prescribed, attraction begins at z = -h_0 and ends at the smallest z of (3) and (4).
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from contact import parameter_check
from contact.law.adhesion import DISTANCE, first_release, tabor_number
from contact.roots import bracketed

LARGEST = 16.0 / (9.0 * math.sqrt(3.0))  # traction of a Lennard-Jones potential over w/e
SMALL = 0.05  # t below which sin t cos t - t cos 2t is a series: 1e-16 of its rounding
MOST = 1e6  # number of Tabor: a larger one makes no difference to JKR, and is lost in rounding
FLAT = 1e-14  # t of the largest contact that is looked for
ROWS = 4000  # of a table of angles, from which the search begins
NODES = 200  # of the integral of the loss, in each part


def _first(t):
    """Return sin t cos t - t cos 2t."""
    x = 2.0 * t
    series = x**3 / 6.0 * (1.0 - x**2 / 10.0 * (1.0 - x**2 / 28.0 * (1.0 - x**2 / 54.0)))
    return np.where(t < SMALL, series, 0.5 * (np.sin(x) - x * np.cos(x)))


@dataclass(frozen=True, kw_only=True)
class MaugisSphere:
    """A sphere with adhesion over a finite distance at prescribed approaches.

    Attributes
    ----------
    radius, modulus : float
        R in m and E in Pa, positive.
    work : float
        Work of adhesion w, J/m^2, positive.
    separation : float
        Equilibrium separation e of the surfaces, m, positive.

    Examples
    --------
    >>> ball = MaugisSphere(radius=1e-3, modulus=64e9, work=0.05, separation=0.3e-9)
    >>> print(f"closes at {1e9 * ball.make_approach:.4f} nm, leaves at {1e9 * ball.break_approach:.4f} nm")
    closes at -0.2923 nm, leaves at -1.3830 nm
    """

    radius: float
    modulus: float
    work: float
    separation: float = DISTANCE

    def __post_init__(self):
        units = {"radius": "m", "modulus": "Pa", "work": "J/m^2", "separation": "m"}
        for name, unit in units.items():
            object.__setattr__(self, name, parameter_check.positive(f"adhesion.{name}", getattr(self, name), unit))
        number = self.tabor_number
        rule = f"must give a number of Tabor of at most {MOST:g}, got {number:.3g}: this is the limit JKR"
        parameter_check.refuse_if(number > MOST, "adhesion.separation", rule)

    @property
    def tabor_number(self) -> float:
        """Tabor's number with the separation of the surfaces."""
        return tabor_number(self.radius, self.modulus, self.work, self.separation)

    @property
    def traction(self) -> float:
        """Attraction sigma_0 of the surfaces, Pa."""
        return LARGEST * self.work / self.separation

    @property
    def make_approach(self) -> float:
        """Approach at which the surfaces begin to attract, -h_0, m."""
        return -self.work / self.traction

    @cached_property
    def _units(self) -> tuple[float, float, float, float]:
        """Maugis's lambda and the units of radius, force and approach."""
        K, R, w = 4.0 / 3.0 * self.modulus, self.radius, self.work
        lam = 2.0 * self.traction * (R / (math.pi * w * K**2)) ** (1.0 / 3.0)
        return (
            lam, (math.pi * w * R**2 / K) ** (1.0 / 3.0), math.pi * w * R, (math.pi**2 * w**2 * R / K**2) ** (1.0 / 3.0)
        )  # fmt: skip

    def at_angle(self, t):
        """Return radius a in m, P in N and z in m of contacts with cos t = a/c, arrays; equations (1) to (3)."""
        lam, length, force, approach = self._units
        square, slope = 0.5 * lam * _first(t), 4.0 * lam**2 / 3.0 * (t * np.sin(t) - 2.0 * np.sin(0.5 * t) ** 2)
        c = 2.0 / (slope + np.sqrt(slope**2 + 4.0 * square))
        a = c * np.cos(t)
        P = a**3 - lam * c**2 * (t + np.sin(t) * np.cos(t))
        z = a**2 - 4.0 / 3.0 * lam * c * np.sin(t)
        return length * a, force * P, approach * z

    def _apart(self, c):
        """Return P and z of surfaces that attract over a radius c without touching; equation (4)."""
        return -math.pi * c**2 * self.traction, c**2 / (2.0 * self.radius) - self._pull * c + self.make_approach

    @property
    def _pull(self) -> float:
        return 4.0 * self.traction / (math.pi * self.modulus)

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Angle and radius of attraction at which a contact that is drawn apart ends: pi/2 where it ends apart."""
        _, _, z = self.at_angle(np.array(0.5 * math.pi))
        apart = self._pull * self.radius  # the smallest z of (4)
        if apart < self._touch:
            return 0.5 * math.pi, apart
        t = np.geomspace(1e-6, 0.5 * math.pi, 4000)
        z = self.at_angle(t)[2]
        k = int(np.argmin(z))
        step = 1e-6

        def rate(at):
            high, low = (float(self.at_angle(np.array(at * (1.0 + sign * step)))[2]) for sign in (1, -1))
            return high - low

        low, high = t[max(k - 1, 0)], min(t[min(k + 1, t.size - 1)], 0.5 * math.pi * (1.0 - 2.0 * step))
        return (bracketed(rate, low, high) if rate(low) * rate(high) < 0.0 else float(t[k])), self._touch

    @cached_property
    def _touch(self) -> float:
        """Radius of attraction at which the contact is a point, m."""
        lam, length, *_ = self._units
        slope = 4.0 * lam**2 / 3.0 * (0.5 * math.pi - 1.0)
        return length * 2.0 / (slope + math.sqrt(slope**2 + math.pi * lam))

    @cached_property
    def break_approach(self) -> float:
        """Smallest approach, at which a contact that is drawn apart ends, m."""
        t, c = self._ends
        return float(self.at_angle(np.array(t))[2] if c == self._touch else self._apart(c)[1])

    @property
    def pull_off(self) -> float:
        """Largest tension where the load is prescribed, N."""
        t = np.geomspace(1e-6, 0.5 * math.pi, 20_000)
        return max(float(-np.min(self.at_angle(t)[1])), math.pi * self._touch**2 * self.traction)

    @cached_property
    def _angles(self):
        """Spline of ln t over s = (z - z_end)^(1/2), in which the end of a contact is no singularity."""
        from scipy.interpolate import CubicSpline  # of this law alone

        t = np.geomspace(FLAT, self._ends[0], ROWS)[::-1]
        s = np.sqrt(np.maximum(self.at_angle(t)[2] - self._lowest, 0.0))
        return CubicSpline(s, np.log(t))

    @property
    def _lowest(self) -> float:
        """Approach of the smallest contact, that of a point or that at the end, m."""
        return float(self.at_angle(np.array(self._ends[0]))[2])

    def _angle(self, z: np.ndarray) -> np.ndarray:
        """Return the angles of contacts at approaches from that of the smallest one on, by a spline and two steps."""
        s = np.sqrt(np.maximum(z - self._lowest, 0.0))
        logarithm, slope = self._angles(s), self._angles(s, 1)
        for _ in range(2):
            own = np.sqrt(np.maximum(self.at_angle(np.exp(logarithm))[2] - self._lowest, 0.0))
            logarithm = np.minimum(logarithm + slope * (s - own), math.log(self._ends[0]))
        return np.exp(logarithm)

    def closed(self, z) -> tuple[np.ndarray, np.ndarray]:
        """Return radii a in m and forces in N of a closed contact at approaches in m of at least `break_approach`."""
        z = np.asarray(z, dtype=float)
        a, force, _ = self.at_angle(self._angle(z))
        point = float(self.at_angle(np.array(0.5 * math.pi))[2])
        if self._ends[1] == self._touch:
            return a, force
        root = np.sqrt(np.maximum(self._pull**2 + 2.0 * (z - self.make_approach) / self.radius, 0.0))
        apart = self._apart(self.radius * (self._pull + root))[0]
        return np.where(z < point, 0.0, a), np.where(z < point, apart, force)

    def approach_under(self, force: float) -> float:
        """Return the approach in m at which a closed contact carries a force in N that is positive."""
        parameter_check.positive("force", force, "N")
        high = (0.75 * force / self.modulus / math.sqrt(self.radius)) ** (2.0 / 3.0)
        low = self.make_approach
        while float(self.closed(high)[1]) < force:
            low, high = high, 2.0 * high
        return bracketed(lambda z: float(self.closed(z)[1]) - force, low, high)

    @cached_property
    def loss(self) -> float:
        """Energy that one contact and separation lose, the work of P around both branches, J."""
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        start, stop = self.make_approach, self.break_approach
        # z = stop + s^2 takes out the square root with which the force ends; a point of contact is a kink
        point = float(self.at_angle(np.array(0.5 * math.pi))[2])
        edges = sorted({stop, start, *([point] if stop < point < start else [])})
        total = 0.0
        for low, high in pairwise(edges):
            ends = math.sqrt(low - stop), math.sqrt(high - stop)
            s = 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * nodes
            total -= float(0.5 * (ends[1] - ends[0]) * weights @ (2.0 * s * self.closed(stop + s**2)[1]))
        return total

    def release_amplitude(self, preload: float) -> float:
        """Return the normal amplitude in m at which a heavy slider's contact first ends, of first order."""
        return first_release(self, preload)

    def radius_under(self, force: float) -> float:
        """Return the radius of a contact that carries a positive force in N, m."""
        return float(self.closed(self.approach_under(force))[0])
