r"""A rough sphere on a flat half-space: normal force by a mean field of asperities.

The asperities are spherical caps of one radius beta, density eta and Gaussian heights of the standard deviation sigma.

**Mean field** (Greenwood and Tripp, J. Appl. Mech. 34 (1967) 153). The pressure under a mean plane that is dented by
w(r) follows from the local separation d(r) of the mean planes,

    p(r) = (4/3) E eta sqrt(beta) int_d (s - d)^(3/2) phi(s) ds,        d(r) = -z + r^2/2R + w(r),

phi the density of the heights, z the approach of the mean planes, and w the displacement of the half-space under p. On
rings of constant pressure w is a sum of displacements of discs (Johnson, *Contact Mechanics* (1985), section 3.4(b)),
and Newton's method solves for p. The integral is Gamma(5/2)/sqrt(2 pi) sigma^(3/2) exp(-t^2/4) D(-5/2, t), t = d/sigma,
with the parabolic cylinder function D. The field is smooth where many asperities carry; where fewer than about ten do,
one sphere differs from the next, and only a sample (`law.asperities`) tells by how much.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from contact import parameter_check
from contact.exceptions import ConvergenceError
from contact.law.asperities import Asperities, State
from contact.law.normal import SPHERE, approach, stiffness
from contact.roots import bracketed

ASPERITY_RADIUS = 10e-6  # m, of polished balls by atomic force microscopy; a factor of 5 changes the stiffness by 5 %
ASPERITIES = 0.05  # eta beta sigma of surfaces without a measured density
FEWEST = 10.0  # asperities in contact below which the mean field is not that of one sphere
COVERED = 0.4  # random places one after another fill 0.547 of a plane with discs
FIRST = 4.5  # standard deviations between the mean planes from which on asperities are counted to carry: 1e-5 of a load
HEIGHTS, PLACES = 16, 24  # classes of height, and rings, of the asperities of a field; 64 and 80: 2e-3 of the velocity
RINGS = 160  # rings of pressure; 320 change the approach by 2e-5
REACH = 7.0  # standard deviations above the mean plane beyond which asperities carry nothing
FAR = -12.0  # t below which the series of a tail has rounding errors only
CLOSE = 1e-12  # relative change of the largest pressure or approach at which Newton's method ends


def tail(power: float, t: np.ndarray) -> np.ndarray:
    r"""Return int_t^inf (s - t)^power phi(s) ds of the standard normal density.

    Parameters
    ----------
    power : float
        1/2 or 3/2; any number above -1 serves.
    t : ndarray
        Lower limits.

    Examples
    --------
    >>> [round(float(each), 6) for each in tail(1.0, np.array([0.0, -20.0]))]  # 1/sqrt(2 pi), and 20
    [0.398942, 20.0]
    """
    from scipy.special import gamma, pbdv  # of the rough contact alone: scipy is not imported where it is absent

    t = np.asarray(t, dtype=float)
    near = np.maximum(t, FAR)
    found = gamma(power + 1.0) / math.sqrt(2.0 * math.pi) * np.exp(-0.25 * near**2) * pbdv(-power - 1.0, near)[0]
    away = np.maximum(-t, -FAR)
    total = term = np.ones_like(away)
    for k in range(1, 12):
        # E[(T + s)^power] = sum over k of binom(power, 2k) (2k - 1)!! T^(power - 2k)
        term = term * (power - 2 * k + 2) * (power - 2 * k + 1) / (2 * k) / away**2
        total = total + term
    return np.where(t < FAR, total * away**power, found)


def disc_displacement(radius, r) -> np.ndarray:
    """Return the normal displacement at r under a unit pressure on a disc over 1/E, m, on a half-space.

    E is the modulus of `Slider.effective_modulus`. Johnson, eqs 3.29a and 3.29b, with complete elliptic integrals.
    """
    from scipy.special import ellipe, ellipkm1

    radius, r = np.broadcast_arrays(np.asarray(radius, float), np.asarray(r, float))
    inside, larger = r <= radius, np.maximum(np.maximum(radius, r), 1e-300)
    m = (np.minimum(radius, r) / larger) ** 2
    # (1 - m) K(m), which vanishes at m = 1
    first = (1.0 - m) * ellipkm1(np.maximum(1.0 - m, 1e-300))
    return 4.0 / math.pi * larger * (ellipe(m) - np.where(inside, 0.0, first))


class Field(NamedTuple):
    """The mean field at one approach."""

    force: float  # N
    stiffness: float  # dP/dz, N/m
    r: np.ndarray  # middle radii of the rings, m
    pressure: np.ndarray  # mean pressure of the rings, Pa
    touching: float  # asperities in contact
    separation: np.ndarray  # of the mean planes at the rings, m
    separation_rate: np.ndarray  # its derivative in z


@dataclass(frozen=True, kw_only=True)
class Roughness:
    """Heights of the asperities of a sphere.

    Attributes
    ----------
    rms : float
        Standard deviation sigma of the heights over the size of the contact, m, positive.
    asperity_radius : float
        Radius beta of the asperities, m, positive; 10 um where it is not given.
    density : float, optional
        Asperities per area eta, 1/m^2, positive; None: 0.05/(beta sigma).

    Examples
    --------
    >>> f"{Roughness(rms=3e-9).density:.4g}"  # 1/m^2: spacing 0.77 um
    '1.667e+12'
    """

    rms: float
    asperity_radius: float = ASPERITY_RADIUS
    density: float | Any = None

    def __post_init__(self):
        for name, unit in (("rms", "m"), ("asperity_radius", "m")):
            object.__setattr__(self, name, parameter_check.positive(f"roughness.{name}", getattr(self, name), unit))
        density = ASPERITIES / (self.asperity_radius * self.rms) if self.density is None else self.density
        object.__setattr__(self, "density", parameter_check.positive("roughness.density", density, "1/m^2"))

    @property
    def spacing(self) -> float:
        """Smallest distance between two asperities of a sample, m: caps of the height sigma that just touch.

        Of dense asperities it is smaller: discs of this diameter cover at most `COVERED` of the area, so that random
        places are found.
        """
        return min(
            2.0 * math.sqrt(2.0 * self.asperity_radius * self.rms), 2.0 * math.sqrt(COVERED / math.pi / self.density)
        )

    def drawn(self, seed: int, reach: float) -> Asperities:
        """Return a sample: asperities at random places (a Poisson process) within a distance `reach` in m.

        They are drawn from the middle outwards, so that the sample of a larger reach begins with that of a smaller
        one. A place nearer than `spacing` to an earlier one is drawn again, at the same distance from the middle a
        hundred times, then further out.
        """
        places, heights = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])
        x, y, square = np.empty(0), np.empty(0), 0.0
        while (square := square + places.exponential(1.0 / (math.pi * self.density))) < reach**2:
            r = math.sqrt(square)
            rim = np.hypot(x, y) > r - self.spacing
            for angle in places.uniform(0.0, 2.0 * math.pi, 100):
                new = r * math.cos(angle), r * math.sin(angle)
                if not np.any(np.hypot(x[rim] - new[0], y[rim] - new[1]) < self.spacing):
                    x, y = np.append(x, new[0]), np.append(y, new[1])
                    break
        return Asperities(x=x, y=y, heights=heights.normal(scale=self.rms, size=x.size), radius=self.asperity_radius)


class MeanField:
    """The normal force of a rough sphere by the mean field of its asperities.

    Parameters
    ----------
    radius : float
        R, m.
    effective_modulus : float
        E of 1/E = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2, Pa.
    roughness : Roughness
    rings : int
        Rings of constant pressure.

    Examples
    --------
    A ball of 1 mm with an rms of 3 nm at the approach at which it carries 0.873 mN; smooth, it is 4.713 nm:

    >>> ball = MeanField(1e-3, 64e9, Roughness(rms=3e-9))
    >>> round(1e3 * ball.at(4.2130e-9).force, 4)
    0.8731
    """

    def __init__(self, radius: float, effective_modulus: float, roughness: Roughness, rings: int = RINGS):
        self.radius = parameter_check.positive("radius", radius, "m")
        self.modulus = parameter_check.positive("effective_modulus", effective_modulus, "Pa")
        self.roughness, self.rings = roughness, rings
        self._edges = np.linspace(0.0, 1.0, rings + 1)
        middle = self.middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        # displacements scale with the outermost radius
        discs = disc_displacement(self._edges[None, :], middle[:, None])
        self._influence = np.diff(discs, axis=1) / effective_modulus

    def at(self, z: float, near: Field | None = None, *, reach: float | None = None) -> Field:
        """Return the field at an approach z of the mean planes in m; it is negative where few asperities touch.

        `near` is that at another approach, whose pressures the search starts from, and `reach` the radius of the
        outermost ring in m.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge.
        """
        sigma, rough = self.roughness.rms, self.roughness
        reach = reach or self.reach(z)
        r, influence = reach * self.middle, reach * self._influence
        area = math.pi * np.diff((reach * self._edges) ** 2)
        scale = rough.density * float(stiffness(rough.asperity_radius, self.modulus, SPHERE.shape)) * sigma**1.5
        plane = r**2 / (2.0 * self.radius) - z
        p, identity = np.zeros(self.rings), np.eye(self.rings)
        if near is not None:
            p = np.interp(r, near.r, near.pressure, right=0.0)
        for _ in range(100):
            t = (plane + influence @ p) / sigma
            wanted, falls = scale * tail(1.5, t), 1.5 * scale / sigma * tail(0.5, t)
            jacobian = identity + falls[:, None] * influence
            step = np.linalg.solve(jacobian, wanted - p)
            p = np.maximum(p + step, 0.0)
            if np.max(np.abs(step)) <= CLOSE * np.max(p):
                break
        else:
            raise ConvergenceError("not converged", f"the mean field of asperities at an approach of {z:.4g} m")
        touching = rough.density * float(area @ tail(0.0, t))
        rise = np.linalg.solve(jacobian, falls)
        separation = plane + influence @ p
        return Field(float(area @ p), float(area @ rise), r, p, touching, separation, influence @ rise - 1.0)

    def reach(self, z: float) -> float:
        """Return the radius in m within which asperities may touch at an approach z in m."""
        sigma = self.roughness.rms
        return math.sqrt(2.0 * self.radius * max(z + REACH * sigma, 0.5 * sigma))

    def lowest(self, _radius: float) -> float:
        """Return the approach of the mean planes in m from which the asperities are counted to carry; see `FIRST`."""
        return -FIRST * self.roughness.rms

    def parting(self, _radius: float) -> float:
        """Return the approach of the mean planes in m at which half of all balls touch nothing.

        So it is where ln 2 asperities of a Poisson process are expected to touch, of surfaces that are not dented:
        2 pi R eta sigma times the mean of what is higher than the separation.
        """
        rough = self.roughness
        number = 2.0 * math.pi * self.radius * rough.density * rough.rms

        def left(t):
            return number * float(tail(1.0, np.array([t]))[0]) - math.log(2.0)

        return -rough.rms * bracketed(left, FAR, REACH)

    def ball(self, _radius: float, _modulus: float, deepest: float) -> "FieldBall":
        """Return the asperities of the field as those of one ball, up to an approach in m."""
        return FieldBall(self, deepest)

    def approach(self, force: float) -> float:
        """Return the approach of the mean planes in m under a force in N, by Newton's method on its logarithm."""
        parameter_check.positive("force", force, "N")
        z = float(approach(force / stiffness(self.radius, self.modulus, SPHERE.shape), SPHERE))
        for _ in range(100):
            field = self.at(z)
            step = math.log(force / field.force) * field.force / field.stiffness
            z += max(min(step, 2.0 * self.roughness.rms), -2.0 * self.roughness.rms)
            if abs(step) <= CLOSE * (abs(z) + self.roughness.rms):
                return z
        raise ConvergenceError("not converged", f"the approach of a rough sphere under {force:.4g} N")


class FieldBall:
    """The asperities of a mean field as a sample: classes of height on rings, which the field dents alike.

    Attributes
    ----------
    near : ndarray
        Numbers of the classes.
    stiffness, merged : ndarray, shape (n,)
        Of the asperities of each class together, N/m^1.5; no approach at which they meet.
    """

    def __init__(self, field: MeanField, deepest: float):
        self.field = MeanField(field.radius, field.modulus, field.roughness, PLACES)
        sigma, self.reach = field.roughness.rms, self.field.reach(deepest)
        steps = (np.arange(HEIGHTS) + 0.5) / HEIGHTS * 2.0 * FIRST - FIRST
        share = np.exp(-0.5 * steps**2)
        self.heights = sigma * steps
        areas = math.pi * np.diff((self.reach * np.linspace(0.0, 1.0, PLACES + 1)) ** 2)
        each = float(stiffness(field.roughness.asperity_radius, field.modulus, SPHERE.shape))
        self.stiffness = (each * field.roughness.density * np.outer(areas, share / share.sum())).ravel()
        self.merged, self.near = np.full(self.stiffness.size, np.inf), np.arange(self.stiffness.size)
        self._last: Field | None = None

    def at(self, z: float, near: np.ndarray | None = None) -> State:
        """Return the approaches of the asperities at an approach z in m, and their derivatives."""
        self._last = field = self.field.at(z, self._last if near is not None else None, reach=self.reach)
        approaches = self.heights - field.separation[:, None]
        return State(approaches.ravel(), np.repeat(-field.separation_rate, HEIGHTS))

    def forces(self, u: np.ndarray) -> np.ndarray:
        """Return the forces at approaches u, N."""
        return self.stiffness * np.maximum(u, 0.0) ** 1.5


def johnson_number(rms: float, approach: float) -> float:
    """Return alpha = sigma R/a^2 = sigma/z of a sphere; Hertz is within 7 % below 0.05.

    Greenwood, Johnson and Matsubara, Wear 100 (1984) 47. `approach`: of the smooth sphere under its load, m.
    """
    return rms / approach if approach > 0.0 else math.inf
