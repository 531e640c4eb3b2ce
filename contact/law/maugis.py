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

(1) is a quadratic equation in c, so that t from 0 to pi/2 runs through all contacts in closed form (`law.holding`).
Where z is prescribed, an open contact closes at z = -h_0, where the surfaces begin to attract. A closed one opens at
the smallest z of (3), where dz/da = 0, or for small lambda where it becomes a point, t = pi/2. Where that lies beyond
-h_0, it closes as a point too.

What is left out: beyond the point the surfaces attract without touching, up to about -h_0. Like the attraction of
Derjaguin, Muller and Toporov, that of this model exists in contact alone. It matters where lambda is small and h_0 is
not small against the motion.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contact import parameter_check
from contact.jit.compiled import native
from contact.law import holding
from contact.law.sphere_limits import DISTANCE, check_carried, first_release, tabor_number
from contact.roots import bracketed

LARGEST = 16.0 / (9.0 * math.sqrt(3.0))  # traction of a Lennard-Jones potential over w/e
NANO_PER = 1e9  # nm in a metre
MOST = 1e6  # number of Tabor: a larger one makes no difference to JKR, and is lost in rounding


@native("f1 t f1 f1", {"z": "n", "depths": "n", "forces": "n"})
def _closed(z, hold, depths, forces):
    """Write depths and forces over the stiffness of closed contacts at approaches."""
    for k in range(z.size):
        d, attraction = holding.circle(z[k], 0.0, hold)
        depths[k], forces[k] = d, d * np.sqrt(d) - attraction
    return 0


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
    def reach(self) -> float:
        """Largest gap h_0 of surfaces that attract, m."""
        return self.work / self.traction

    @property
    def make_approach(self) -> float:
        """Approach at which an open contact closes, m: -h_0, or where it is a point."""
        return self.hold.make

    @cached_property
    def hold(self) -> holding.Hold:
        """The numbers of the contact as the solvers in time take them, lengths in m."""
        K, R, w = 4.0 / 3.0 * self.modulus, self.radius, self.work
        number = 2.0 * self.traction * (R / (math.pi * w * K**2)) ** (1.0 / 3.0)
        return holding.maugis(number, (math.pi**2 * w**2 * R / K**2) ** (1.0 / 3.0), -self.reach)

    @property
    def _stiffness(self) -> float:
        """K of P = K d^(3/2), N/m^1.5."""
        return 4.0 / 3.0 * self.modulus * math.sqrt(self.radius)

    def at_angle(self, t):
        """Return radius a in m, P in N and z in m of contacts with cos t = a/c, arrays; equations (1) to (3)."""
        number, unit = self.hold.number, self.hold.unit
        rims = [holding.rim_at_angle(1.0 / math.tan(each), number) for each in np.ravel(t)]
        a, pull, z = np.array([(each.a, holding.rim_pull(each, number), holding.rim_approach(each, number))
                               for each in rims]).T.reshape(3, *np.shape(t))  # fmt: skip
        return math.sqrt(self.radius * unit) * a, self._stiffness * unit**1.5 * (a**3 - pull), unit * z

    @property
    def break_approach(self) -> float:
        """Approach at which a contact that is drawn apart ends, m."""
        return self.hold.leave

    @cached_property
    def pull_off(self) -> float:
        """Largest tension where the load is prescribed, N."""
        hold = self.hold

        def rise(root):  # dP/dd over K, as the force is convex in d
            return 1.5 * root - holding.attraction_rate(root * root, hold)

        root = bracketed(rise, 0.0, 2.0 * math.sqrt(hold.unit))
        return self._stiffness * (float(holding.attraction(root * root, 0.0, hold)) - root**3)

    def closed(self, z) -> tuple[np.ndarray, np.ndarray]:
        """Return radii a in m and forces in N of a closed contact at approaches in m of at least `break_approach`."""
        z = np.asarray(z, dtype=float)
        # in nm, so that what counts as rounding is small
        depths, forces = np.empty(z.size), np.empty(z.size)
        _closed(NANO_PER * z.ravel(), self._in_nanometres, depths, forces)
        a = np.sqrt(self.radius * depths.reshape(z.shape) / NANO_PER)
        return a, self._stiffness * forces.reshape(z.shape) / NANO_PER**1.5

    @cached_property
    def _in_nanometres(self) -> holding.Hold:
        return holding.rescaled(self.hold, 1.0 / NANO_PER)

    def approach_under(self, force: float) -> float:
        """Return the approach in m of a contact that carries a force in N, at least minus the `pull_off`."""
        return float(holding.approach_at(self._depth_under(force), self.hold))

    def radius_under(self, force: float) -> float:
        """Return the radius in m of a contact that carries a force in N, at least minus the `pull_off`."""
        return math.sqrt(self.radius * self._depth_under(force))

    def _depth_under(self, force: float) -> float:
        check_carried(force, self.pull_off)
        return float(holding.depth_under(force / self._stiffness, self.hold))

    @property
    def loss(self) -> float:
        """Energy that one contact and separation lose, the work of P around both branches, J."""
        return self._stiffness * float(holding.stored(self.hold.end_depth, self.hold))

    def release_amplitude(self, preload: float) -> float:
        """Return the normal amplitude in m at which a heavy slider's contact first ends, of first order."""
        return first_release(self, preload)
