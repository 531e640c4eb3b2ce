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

w is the displacement under the pressure everywhere. An asperity feels that of the others alone, and the nearest stands
at the distance d = `Roughness.spacing` or farther: the disc of this radius about it is counted too much, by
w_own = 2 p d/E. So samples carry more than the field at the same approach: 8 to 14 % in the mean of 24, with an rms of
1, 3 and 5 nm on the ball of Feenstra and Breedveld at its load and at 2.5 times that. Without w_own the field carries
what they do to 0.3 to 5 %, about one standard deviation of their mean (`tests/contact/test_own_dent.py`). It stays as
Greenwood and Tripp have it; a run has the difference as the line "single asperities instead of their mean field".
"""

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from contact import parameter_check
from contact.exceptions import ConvergenceError, InputError
from contact.law.asperities import FINE, Asperities, Rows
from contact.law.force_table import ForceTable
from contact.law.normal import SPHERE, approach, stiffness
from contact.law.table import TabulatedForce
from contact.roots import bracketed

ASPERITY_RADIUS = 10e-6  # m, of polished balls by atomic force microscopy; a factor of 5 changes the stiffness by 5 %
ASPERITIES = 0.05  # eta beta sigma of surfaces without a measured density
FEWEST = 10.0  # asperities in contact below which the mean field is not that of one sphere
COVERED = 0.4  # random places one after another fill 0.547 of a plane with discs
FIRST = 4.5  # standard deviations between the mean planes from which on asperities are counted to carry: 1e-5 of a load
START, GRADED = 6.0, 3.0  # standard deviations: where a table starts, and from where on its steps grow
STOP_ROWS = 256  # rows of the first table of one stop
STEP_OF_ROWS, FINEST = 0.2, 64  # of asinh of the approach in a first table, and its smallest part
TABLE = 1e-5  # relative error of the force as a normal law
# Its end: this share of the ball's radius, where that of the contact is a seventieth of it, within these numbers of
# standard deviations. With 0.3 nm an end at 25 of them changed forces at 10 nm by 5e-4.
SHALLOW, DEEPEST, DEEPEST_OF_FINE = 2e-4, 25.0, 2000.0
RINGS = 160  # rings of pressure; 320 change the approach by 2e-5
REACH = 7.0  # standard deviations above the mean plane beyond which asperities carry nothing
FAR = -12.0  # t below which the series of a tail has rounding errors only
STEP = 0.04  # of the variable of integration of a tail; 0.08 gives 1e-9
TAILS = 64  # rows of the table of tails a standard deviation: 4e-7 of a tail
LATEST = 16  # fields under forces, and tables, that are kept
CLOSE = 1e-12  # relative change of the largest pressure or approach at which Newton's method ends


def tail(power: float, t: np.ndarray) -> np.ndarray:
    r"""Return int_t^inf (s - t)^power phi(s) ds of the standard normal density.

    With s - t = x^2 the integrand is even in x and falls as exp(-x^4/2), so that the trapezoidal rule gives it to
    rounding.

    Parameters
    ----------
    power : float
        -1/2, 1/2, 3/2 or another half of an odd number.
    t : ndarray
        Lower limits.

    Examples
    --------
    >>> [round(float(each), 6) for each in tail(0.5, np.array([0.0, -25.0]))]  # Gamma(3/4)/(2^(3/4) sqrt(pi)), 5
    [0.411089, 4.998998]
    """
    t = np.asarray(t, dtype=float)
    near = np.maximum(t, FAR)[..., None]
    x = STEP * np.arange(math.ceil(math.sqrt(9.0 - FAR) / STEP))
    weight = np.full(x.size, 2.0 * STEP)
    weight[0] = STEP
    found = np.exp(-0.5 * (x**2 + near) ** 2) @ (weight * x ** (2.0 * power + 1.0)) / math.sqrt(2.0 * math.pi)
    away = np.maximum(-t, -FAR)
    total = term = np.ones_like(away)
    for k in range(1, 12):
        # E[(T + s)^power] = sum over k of binom(power, 2k) (2k - 1)!! T^(power - 2k)
        term = term * (power - 2 * k + 2) * (power - 2 * k + 1) / (2 * k) / away**2
        total = total + term
    return np.where(t < FAR, total * away**power, found)


@cache
def _tail_table() -> np.ndarray:
    """Return the tails of the powers 3/2, 1/2 and -1/2 from `FAR` on, shape (3, n)."""
    t = np.arange(FAR, REACH + 2.0, 1.0 / TAILS)
    return np.array([tail(power, t) for power in (1.5, 0.5, -0.5)])


def pressure_tails(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the tail of the power 3/2 and less its derivative: by cubics in a table, or by `tail` before it."""
    values = _tail_table()
    at = np.clip((t - FAR) * TAILS, 0.0, values.shape[1] - 1.001)
    row = at.astype(int)
    s, found = at - row, []
    for power, value, slope in ((1.5, values[0], values[1]), (0.5, values[1], values[2])):
        low, high, rise, fall = value[row], value[row + 1], -power / TAILS * slope[row], -power / TAILS * slope[row + 1]
        cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
        found.append(low + s * (rise + s * (square + s * cubic)))
    far = t < FAR
    if far.any():
        for power, each in zip((1.5, 0.5), found, strict=True):
            each[far] = tail(power, t[far])
    return found[0], 1.5 * found[1]


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


@cache
def _influence(rings: int) -> np.ndarray:
    """Return E w at the middle of equal rings under unit pressures on each, m; it scales with the outermost radius."""
    edges = np.linspace(0.0, 1.0, rings + 1)
    return np.diff(disc_displacement(edges[None, :], 0.5 * (edges[1:] + edges[:-1])[:, None]), axis=1)


class Field(NamedTuple):
    """The mean field at one approach."""

    approach: float  # z, m
    force: float  # N
    stiffness: float  # dP/dz, N/m
    r: np.ndarray  # middle radii of the rings, m
    pressure: np.ndarray  # mean pressure of the rings, Pa
    touching: float  # asperities in contact
    dent: np.ndarray  # displacement of the half-space at the rings, m
    dent_rate: np.ndarray  # its derivative in z


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
        Asperities per area eta, 1/m^2, positive and at most 1/(beta sigma); None: 0.05/(beta sigma). Of random
        surfaces eta beta sigma is 0.03 to 0.1 (McCool, Wear 107 (1986) 37).

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
        most = 1.0 / (self.asperity_radius * self.rms)
        if self.density > most:
            rule = f"must be at most 1/(asperity_radius rms) = {most:.4g} 1/m^2, got {self.density:.4g}"
            raise InputError("roughness.density", rule)

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
        self._solved: dict[int, Field] = {}
        self._under: dict[float, Field] = {}
        self._tables: dict[tuple[float, int], ForceTable] = {}
        self._edges = np.linspace(0.0, 1.0, rings + 1)
        self.middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        self._influence = _influence(rings) / effective_modulus

    def at(self, z: float, near: Field | None = None) -> Field:
        """Return the field at an approach z of the mean planes in m; it is negative where few asperities touch.

        `near` is that at another approach, from which the search starts.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge.
        """
        from scipy.special import ndtr

        sigma, rough, reach = self.roughness.rms, self.roughness, self.reach(z)
        r, influence = reach * self.middle, reach * self._influence
        area = math.pi * np.diff((reach * self._edges) ** 2)
        scale = rough.density * float(stiffness(rough.asperity_radius, self.modulus, SPHERE.shape)) * sigma**1.5
        plane = r**2 / (2.0 * self.radius) - z
        dent = np.zeros(self.rings)
        if near is not None:
            dent = np.interp(r, near.r, near.dent + (z - near.approach) * near.dent_rate)
        bound = CLOSE * sigma + 1e-15 * float(np.max(np.abs(plane)))
        identity = np.eye(self.rings)

        def residual(dent):
            pressures, falls = pressure_tails((plane + dent) / sigma)
            return dent - influence @ (scale * pressures), scale * pressures, scale / sigma * falls

        left, p, falls = residual(dent)
        for _ in range(100):
            jacobian = identity + influence * falls
            step = np.linalg.solve(jacobian, -left)
            for _ in range(40):
                new, p, falls = residual(dent + step)
                if new @ new < left @ left or np.max(np.abs(step)) <= bound:
                    break
                step = 0.5 * step
            dent, left = dent + step, new
            if np.max(np.abs(step)) <= bound:
                break
        else:
            raise ConvergenceError("not converged", f"the mean field of asperities at an approach of {z:.4g} m")
        # p = f(z - plane - dent), so that dp = f' (dz - influence dp)
        dent_rate = np.linalg.solve(identity + influence * falls, influence @ falls)
        touching = rough.density * float(area @ ndtr(-(plane + dent) / sigma))
        rise = falls * (1.0 - dent_rate)
        return Field(z, float(area @ p), float(area @ rise), r, p, touching, dent, dent_rate)

    def reach(self, z: float) -> float:
        """Return the radius in m within which asperities may touch at an approach z in m."""
        sigma = self.roughness.rms
        return math.sqrt(2.0 * self.radius * max(z + REACH * sigma, 0.5 * sigma))

    def lowest(self, _radius: float) -> float:
        """Return the approach of the mean planes in m from which the asperities are counted to carry; see `FIRST`."""
        return -FIRST * self.roughness.rms

    def parting(self, _radius: float) -> float:
        """Return the approach of the mean planes in m at which half of all balls touch nothing."""
        return self._parting

    @cached_property
    def _parting(self) -> float:
        """Where ln 2 asperities of a Poisson process are expected to touch, of surfaces that are not dented.

        2 pi R eta sigma times the mean of what is higher than the separation.
        """
        rough = self.roughness
        number = 2.0 * math.pi * self.radius * rough.density * rough.rms

        def left(t):
            above = math.exp(-0.5 * t**2) / math.sqrt(2.0 * math.pi) - 0.5 * t * math.erfc(t / math.sqrt(2.0))
            return number * above - math.log(2.0)

        return -rough.rms * bracketed(left, FAR, REACH)

    def ball(self, _radius: float, _modulus: float, _deepest: float) -> "FieldBall":
        """Return one ball with the force of the field."""
        return FieldBall(self)

    def force_table(self, deepest: float, doubling: int) -> ForceTable:
        """Return the force up to an approach in m, see `forces`."""
        if (deepest, doubling) in self._tables:
            return self._tables[deepest, doubling]
        z, spacing = np.linspace(self._nodes(deepest, doubling)[0].approach, deepest, FINE + 1, retstep=True)
        force, slope = self.forces(z, deepest, doubling)
        table = ForceTable(force[None], spacing * slope[None], z[:1], np.array([spacing]))
        return _kept(self._tables, (deepest, doubling), table)

    def forces(self, z: np.ndarray, deepest: float, doubling: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the force in N and its derivative at approaches in m, up to a `deepest` one.

        log P is a cubic between approaches s sinh(k step), s = `GRADED` standard deviations: about equally spaced near
        the mean plane, and growing beyond as the force becomes a power of z. Each doubling halves the step, and keeps
        the fields that are solved.
        """
        fields, scale, step = self._nodes(deepest, doubling), GRADED * self.roughness.rms, STEP_OF_ROWS / 2**doubling
        logs = np.log([each.force for each in fields])
        slopes = step * np.array([each.stiffness / each.force * math.hypot(each.approach, scale) for each in fields])
        at = np.arcsinh(z / scale) / step - round(math.asinh(fields[0].approach / scale) / step)
        row = np.clip(at.astype(int), 0, len(fields) - 2)
        t, low, high, rise, fall = at - row, logs[row], logs[row + 1], slopes[row], slopes[row + 1]
        cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
        force = np.exp(low + t * (rise + t * (square + t * cubic)))
        return force, force * (rise + t * (2.0 * square + 3.0 * t * cubic)) / (step * np.hypot(z, scale))

    def _nodes(self, deepest: float, doubling: int) -> list[Field]:
        """Return the fields between which the force is interpolated."""
        scale, step = GRADED * self.roughness.rms, STEP_OF_ROWS / 2**doubling
        first = math.floor(math.asinh(-START / GRADED) / step)
        last = math.ceil(math.asinh(max(deepest, 0.0) / scale) / step)
        return [self._field(k * FINEST // 2**doubling) for k in range(first, last + 1)]

    def tabulated(self) -> TabulatedForce:
        """Return the force as a normal law of one stop, measured from `lowest`.

        ln P is a spline of degree 5 between the fields of `force_table`. Over the first third of a standard deviation,
        where 1e-5 of a load is carried, the force begins as that of a sphere; beyond the end (`SHALLOW`) P^(2/3)
        goes on as a straight line.
        """
        from scipy.interpolate import make_interp_spline

        sigma, lowest = self.roughness.rms, self.lowest(self.radius)
        scale, step = GRADED * sigma, 0.5 * STEP_OF_ROWS
        first = math.floor(math.asinh(lowest / scale) / step)
        end = min(max(SHALLOW * self.radius, DEEPEST * sigma), DEEPEST_OF_FINE * sigma)
        last = max(math.ceil(math.asinh(end / scale) / step), first + 6)
        fields = [self._field(k * FINEST // 2) for k in range(first, last + 1)]
        nodes = [step * k for k in range(first, last + 1)]
        spline = make_interp_spline(nodes, [math.log(each.force) for each in fields], k=5)

        def force(z):
            begins = -math.expm1(-((3.0 * z / sigma) ** 1.5))
            return begins * math.exp(float(spline(math.asinh((z + lowest) / scale))))

        return TabulatedForce.of(force, scale=0.05 * sigma, end=end, tolerance=TABLE)

    def _field(self, number: int) -> Field:
        """Return the field at one of the approaches of the finest table, solved once."""
        if number not in self._solved:
            before = [each for each in self._solved if each < number]
            near = self._solved[max(before)] if before else None
            z = GRADED * self.roughness.rms * math.sinh(number * STEP_OF_ROWS / FINEST)
            self._solved[number] = self.at(z, near)
        return self._solved[number]

    def approach(self, force: float) -> float:
        """Return the approach of the mean planes in m under a force in N."""
        return self.under(force).approach

    def under(self, force: float) -> Field:
        """Return the field under a force in N, by Newton's method on its logarithm; the latest are kept."""
        parameter_check.positive("force", force, "N")
        if force in self._under:
            return self._under[force]

        def smooth(force):
            return float(approach(force / stiffness(self.radius, self.modulus, SPHERE.shape), SPHERE))

        field = min(self._under.values(), key=lambda each: abs(each.force - force), default=None)
        z = smooth(force) + (field.approach - smooth(field.force) if field else 0.0)
        largest = 2.0 * self.roughness.rms + 0.2 * smooth(force)
        for _ in range(100):
            field = self.at(z, field)
            step = math.log(force / field.force) * field.force / field.stiffness
            if abs(step) <= CLOSE * (abs(z) + self.roughness.rms):
                break
            z += max(min(step, largest), -largest)
        else:
            raise ConvergenceError("not converged", f"the approach of a rough sphere under {force:.4g} N")
        return _kept(self._under, force, field)


def _kept(latest: dict, key, value):
    """Return a value that is kept, in the place of the oldest of `LATEST`."""
    if len(latest) >= LATEST:
        del latest[next(iter(latest))]
    latest[key] = value
    return value


class FieldBall:
    """One ball with the force of a mean field, as if it were one asperity of the ball's own radius.

    Attributes
    ----------
    stiffness, merged : ndarray, shape (1,)
        K in N/m^1.5 of the smooth ball, and no approach at which it would merge with others.
    """

    def __init__(self, field: MeanField):
        self.field, self.force_table = field, field.force_table
        self.stiffness = np.array([float(stiffness(field.radius, field.modulus, SPHERE.shape))])
        self.merged = np.array([math.inf])

    def carries(self, force: float, z: float) -> bool:
        """Return whether the force at an approach z in m is at least one in N."""
        return z >= self.field.approach(force)

    def rows(self, deepest: float, doubling: int) -> Rows:
        """Return the approaches at which the smooth ball has the force, at equally spaced ones up to one in m.

        They begin with `MeanField.lowest`, as `MeanField.tabulated` does.
        """
        field = self.field
        z = np.linspace(field.lowest(field.radius), deepest, STOP_ROWS * 2**doubling + 1)
        force, slope = field.forces(z, deepest, doubling)
        ratio = 3.0 * (z - z[0]) / field.roughness.rms
        begins, rises = -np.expm1(-(ratio**1.5)), 4.5 / field.roughness.rms * np.sqrt(ratio) * np.exp(-(ratio**1.5))
        u = (force * begins / self.stiffness[0]) ** (2.0 / 3.0)
        rate = np.empty_like(u)
        rate[1:] = u[1:] / 1.5 * (slope / force + rises / np.maximum(begins, 1e-300))[1:]
        rate[0] = (force[0] / self.stiffness[0]) ** (2.0 / 3.0) * 3.0 / field.roughness.rms
        return Rows(z, u[:, None], rate[:, None])


def johnson_number(rms: float, approach: float) -> float:
    """Return alpha = sigma R/a^2 = sigma/z of a sphere; Hertz is within 7 % below 0.05.

    Greenwood, Johnson and Matsubara, Wear 100 (1984) 47. `approach`: of the smooth sphere under its load, m.
    """
    return rms / approach if approach > 0.0 else math.inf
