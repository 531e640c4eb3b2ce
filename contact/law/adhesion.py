r"""Adhesion of a sphere: the models of Johnson, Kendall and Roberts and of Derjaguin, Muller and Toporov; a meniscus.

With the work of adhesion w, E and R as in `law.normal`, K = (4/3) E and the radius a of the contact:

    JKR     P = K a^3/R - sqrt(8 pi w E a^3),    z = a^2/R - sqrt(2 pi w a/E)
            Johnson, Kendall and Roberts, Proc. R. Soc. A 324 (1971) 301
    DMT     P = K sqrt(R) z^(3/2) - 2 pi w R in contact, z = a^2/R
            Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53 (1975) 314
    meniscus    as DMT, with the attraction 4 pi gamma R cos(theta) of a liquid

Tabor's number (R w^2/(E^2 e^3))^(1/3), with the distance e = 0.3 nm between the surfaces, tells which one applies: JKR
above 5, DMT below 0.1. Contact begins at z = 0. A slider that is heavy on the wave's time scale prescribes z, so that a
contact of JKR ends where dz/da = 0, at a negative approach, and not at its largest tension of 1.5 pi w R. Between the
two branches the surfaces lose energy in every hop; DMT loses none.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.exceptions import InputError
from contact.law.holding import Hold, jkr
from contact.law.maugis import MaugisSphere
from contact.law.sphere_limits import DISTANCE, check_carried, first_release, tabor_number
from contact.roots import bracketed
from contact.rules import AdhesionRules

MODELS = ("DMT", "JKR")
ABOVE = 1e-7  # relative distance above a root that closed form rounds, from which Newton's method falls
ADHESIONS = ("DMT", "meniscus", "JKR", "Maugis")  # of a slider


def meniscus_force(radius: float, surface_tension: float, contact_angle: float = 0.0) -> float:
    """Return the attraction of a sphere by a liquid, 4 pi gamma R cos(theta), N.

    Parameters
    ----------
    radius : float
        R, m, positive.
    surface_tension : float
        gamma, N/m, positive.
    contact_angle : float
        theta, rad, from 0 to below pi/2.

    Examples
    --------
    >>> round(1e3 * meniscus_force(1e-3, 0.072), 4)  # mN, water
    0.9048
    """
    parameter_check.positive("adhesion.radius", radius, "m")
    parameter_check.positive("adhesion.surface_tension", surface_tension, "N/m")
    if not 0.0 <= contact_angle < 0.5 * math.pi:
        rule = "must be from 0 to below pi/2, where the liquid wets the surfaces"
        raise InputError("adhesion.contact_angle", rule, contact_angle, "rad")
    return 4.0 * math.pi * surface_tension * radius * math.cos(contact_angle)


@dataclass(frozen=True, kw_only=True)
class Adhesion(AdhesionRules):
    """Attraction of the balls of a slider: constant in contact and absent outside, or that of "JKR" or "Maugis".

    The friction limit follows from the elastic part of the normal force alone, so that a slider that keeps contact
    moves as under a preload that is larger by a constant attraction. Balls of "JKR" and "Maugis" hold on beyond the
    touch and lose energy in every hop (`law.holding`).

    Attributes
    ----------
    model : str
        "DMT" (Derjaguin, Muller and Toporov, 2 pi w R), "meniscus" (4 pi gamma R cos theta), "JKR" (Johnson, Kendall
        and Roberts) or "Maugis" (Maugis and Dugdale; `law.maugis`).
    work : float, optional
        Work of adhesion w, J/m^2, positive; not with "meniscus".
    surface_tension : float, optional
        gamma, N/m, positive; with "meniscus".
    contact_angle : float
        theta of the liquid, rad, from 0 to below pi/2; with "meniscus".
    separation : float, optional
        Equilibrium separation of the surfaces, m, positive; with "Maugis", 0.3 nm where it is left out.

    Examples
    --------
    >>> round(1e3 * Adhesion(model="DMT", work=0.05).attraction(1e-3), 4)  # mN
    0.3142
    """

    model: str
    work: float | None = None
    surface_tension: float | None = None
    contact_angle: float = 0.0
    separation: float | None = None

    def __post_init__(self):
        parameter_check.choice("adhesion.model", self.model, ADHESIONS)
        self._refuse("adhesion")
        if self.model == "Maugis" and self.separation is None:
            object.__setattr__(self, "separation", DISTANCE)
        self.attraction(1.0)

    @property
    def holds(self) -> bool:
        """Whether a contact ends beyond the approach at which it begins."""
        return self.model in ("JKR", "Maugis")

    def attraction(self, radius: float) -> float:
        """Return the constant attraction of a ball of a radius in m, N; 0 of one that holds on."""
        if self.surface_tension is not None:
            return meniscus_force(radius, self.surface_tension, self.contact_angle)
        work = parameter_check.positive("adhesion.work", self.work or 0.0, "J/m^2")
        return 0.0 if self.holds else 2.0 * math.pi * work * radius

    def hold(self, radius: float, modulus: float) -> Hold | None:
        """Return the numbers of a ball, radius in m and modulus E in Pa, that holds on; None of one that does not."""
        if not self.holds:
            return None
        if self.model == "Maugis":
            distance = self.separation or DISTANCE
            return MaugisSphere(radius=radius, modulus=modulus, work=self.work or 0.0, separation=distance).hold
        return jkr(math.sqrt(2.0 * math.pi * (self.work or 0.0) / modulus) * radius**0.25)


@dataclass(frozen=True, kw_only=True)
class AdhesiveSphere:
    """A sphere with adhesion at prescribed approaches.

    Attributes
    ----------
    radius, modulus : float
        R in m and E in Pa, positive.
    work : float
        Work of adhesion w, J/m^2, positive.
    model : str
        "JKR" or "DMT".

    Examples
    --------
    The ball of Feenstra and Breedveld under its preload of 0.873 mN:

    >>> ball = AdhesiveSphere(radius=1e-3, modulus=64e9, work=0.05, model="JKR")
    >>> a = ball.radius_under(0.87309e-3)
    >>> print(f"a {1e6 * a:.4f} um; leaves at {1e9 * ball.break_approach:.4f} nm and loses {ball.loss:.3e} J")
    a 3.0269 um; leaves at -1.3646 nm and loses 3.008e-13 J
    """

    radius: float
    modulus: float
    work: float
    model: str = "DMT"

    def __post_init__(self):
        for name, unit in (("radius", "m"), ("modulus", "Pa"), ("work", "J/m^2")):
            object.__setattr__(self, name, parameter_check.positive(f"adhesion.{name}", getattr(self, name), unit))
        parameter_check.choice("adhesion.model", self.model, MODELS)

    @property
    def tabor_number(self) -> float:
        """Tabor's number."""
        return tabor_number(self.radius, self.modulus, self.work)

    @property
    def pull_off(self) -> float:
        """Largest tension of the contact, N: 2 pi w R (DMT) or 1.5 pi w R (JKR)."""
        return (1.5 if self.model == "JKR" else 2.0) * math.pi * self.work * self.radius

    @property
    def _root(self) -> float:
        """Coefficient of sqrt(a) in the approach, 0 for DMT."""
        return math.sqrt(2.0 * math.pi * self.work / self.modulus) if self.model == "JKR" else 0.0

    def force(self, a):
        """Return P in N of a contact of radius a in m; a number or an array."""
        hertz = 4.0 / 3.0 * self.modulus * (a * a * a) / self.radius
        pull = 2.0 * self.modulus * self._root * a * np.sqrt(a) if self.model == "JKR" else self.pull_off
        return hertz - pull

    def approach(self, a):
        """Return z in m of a contact of radius a in m; a number or an array."""
        return a**2 / self.radius - self._root * np.sqrt(a)

    def stiffness(self, a):
        """Return dP/dz in N/m of a contact of radius a in m at prescribed approach; infinite at `break_radius`."""
        force_rate = 4.0 * self.modulus * a**2 / self.radius - 3.0 * self.modulus * self._root * np.sqrt(a)
        return force_rate / (2.0 * a / self.radius - 0.5 * self._root / np.sqrt(a))

    @property
    def break_radius(self) -> float:
        """Radius at which a contact that is drawn apart ends, dz/da = 0, m; 0 for DMT."""
        return (0.25 * self._root * self.radius) ** (2.0 / 3.0)

    @property
    def break_approach(self) -> float:
        """Approach at which it ends, m: negative, 0 for DMT."""
        return float(self.approach(self.break_radius))

    @property
    def make_radius(self) -> float:
        """Radius that a contact takes where it begins, at z = 0, m; 0 for DMT."""
        return (self._root * self.radius) ** (2.0 / 3.0)

    @property
    def loss(self) -> float:
        """Energy that one contact and separation lose, the work of P around both branches, J."""
        hertz, pull, root = 4.0 / 3.0 * self.modulus / self.radius, 2.0 * self.modulus * self._root, self._root

        def work(a):  # integral of P dz/da
            mixed = 0.5 * hertz * root + 2.0 * pull / self.radius
            return 0.4 * hertz * a**5 / self.radius - mixed * a**3.5 / 3.5 + 0.25 * pull * root * a**2

        return work(self.break_radius) - work(self.make_radius)

    def radius_at(self, z: float) -> float:
        """Return the radius of a contact at an approach in m that is at least `break_approach`, m."""
        if z < self.break_approach:
            raise InputError("approach", "must be at least that at which the contact ends", z, "m")
        top = (math.sqrt(self.radius * max(z, 0.0)) + self.make_radius) * (1.0 + 1e-9)  # beyond rounding
        return bracketed(lambda a: float(self.approach(a)) - z, self.break_radius, top)

    def radii_at(self, z) -> np.ndarray:
        """Return the radii at approaches in m, an array, that are at least `break_approach`, m.

        With y = sqrt(a) the approach is y^4/R - s y = z, whose largest root is Ferrari's. It is rounded where the
        coefficients cancel, and improved by Newton's method, which falls to it from above: the quartic is convex.
        """
        z, radius, root = np.asarray(z, float), self.radius, self._root
        if root == 0.0:
            return np.sqrt(radius * np.maximum(z, 0.0))
        third, square = 4.0 / 3.0 * radius * z, (root * radius) ** 2  # u^3 + 3 third u = square
        below = np.cbrt(0.5 * square + np.sqrt(np.maximum(0.25 * square**2 + third * third * third, 0.0)))
        above = third / below
        u = square / (below * below + third + above * above)
        y = np.sqrt(u)
        y = 0.5 * (y + np.sqrt(np.maximum(2.0 * root * radius / y - u, 0.0))) * (1.0 + ABOVE)
        for _ in range(4):  # the error squared at each; at `break_radius`, a double root, half of it
            cubic = y * y * y / radius  # a product: powers of arrays take ten times as long
            rate = 4.0 * cubic - root
            step = (y * (cubic - root) - z) / np.where(rate > 0.0, rate, np.inf)
            y = y - np.maximum(step, 0.0)
        return np.maximum(y * y, self.break_radius)

    def radius_under(self, force: float) -> float:
        """Return the radius of a contact that carries a normal force in N, at least minus the `pull_off`, m."""
        check_carried(force, self.pull_off)
        K = 4.0 / 3.0 * self.modulus
        total = force + self.pull_off
        if self.model == "DMT":
            return (self.radius * total / K) ** (1.0 / 3.0)
        half = 1.5 * math.pi * self.work * self.radius  # K a^3/R = P + 2 p + sqrt(4 p P + 4 p^2), p = 1.5 pi w R
        return (self.radius / K * (force + 2.0 * half + 2.0 * math.sqrt(half * total))) ** (1.0 / 3.0)

    make_approach = 0.0  # m: where a contact begins

    def closed(self, z) -> tuple[np.ndarray, np.ndarray]:
        """Return radii in m and forces in N of a closed contact at approaches in m of at least `break_approach`."""
        radii = self.radii_at(z)
        return radii, self.force(radii)

    def approach_under(self, force: float) -> float:
        """Return the approach in m of a contact that carries a force in N."""
        return float(self.approach(self.radius_under(force)))

    def release_amplitude(self, preload: float) -> float:
        """Return the normal amplitude in m at which a heavy slider's contact first ends, of first order."""
        return first_release(self, preload)
