r"""The normal force of one contact as a table: of a rough surface, or of a user's own law.

With the exponent m of the shape's own force (3/2 for a sphere, 1 for a punch), the table holds g = P^(1/m) at
approaches z that are measured from first touch, so that

    p(z) = P/K = (g(z)/K^(1/m))^m.

g is about linear where P = K z^m, and keeps the behaviour of P at first touch. Between the knots it is a polynomial of
degree 5 with four continuous derivatives in sqrt(1 + z/s), of equal steps u: small where the force begins, and growing
as sqrt(z). Solvers of high order find no kink in it. Behind the last knot g goes on as a straight line. The energy is
the integral of that p, by quadrature between knots, and the inverse its own, so that they agree to rounding.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.codes import Shape
from contact.exceptions import InputError
from contact.jit.compiled import formula
from contact.law.normal import SHAPES, NormalLaw, exponent, smooth_approach, smooth_force, smooth_slope

FEWEST, MOST = 32, 2048  # pieces of a table
TOLERANCE = 1e-9  # relative error of the force at which a table is not refined any more
COARSEST = 1e-4  # and beyond which it is refused
NEGLIGIBLE = 1e-9  # force over the largest below which its relative error is over this share of the largest
# Gauss-Legendre points of the energy within a piece
POINT, WEIGHT = (tuple(map(float, each)) for each in np.polynomial.legendre.leggauss(12))
BISECTIONS = 40  # of the inverse, before two steps by Newton's method


class Table(NamedTuple):
    """The numbers of a table; see the module's text."""

    pieces: np.ndarray  # (n, 6): coefficients of g in each piece, of rising powers; N^(1/m)
    work: np.ndarray  # (n,): integral of g^m dz up to each piece, J
    scale: float  # s, m
    step: float  # of u
    end: float  # the last knot, m
    last: float  # g there
    rise: float  # dg/dz there
    base: float  # K^(1/m)
    # the units of z in m and of g
    length: float
    unit: float


@formula
def _within(u, table):
    """Return (number of the piece, place in it) of a number of steps u."""
    k = np.int64(np.minimum(u, table.pieces.shape[0] - 1.0))
    return k, u - k


@formula
def _rise(u, table):
    """Return g and dg/du at a number of steps u."""
    k, t = _within(u, table)
    c = table.pieces
    a, b, d, e, f = c[k, 1], c[k, 2], c[k, 3], c[k, 4], c[k, 5]
    g = c[k, 0] + t * (a + t * (b + t * (d + t * (e + t * f))))
    return g, a + t * (2.0 * b + t * (3.0 * d + t * (4.0 * e + t * 5.0 * f)))


@formula
def _steps(z, table):
    """Return the number of steps u and the approach in m, both at most at the last knot, of z >= 0."""
    inner = np.minimum(z * table.length, table.end)
    ratio = inner / table.scale
    return ratio / ((1.0 + np.sqrt(1.0 + ratio)) * table.step), inner


@formula
def equal_approach(z, normal):
    """Return the approach at which the smooth shape carries what the table carries at z >= 0, and its derivative."""
    table = normal.table
    u, inner = _steps(z, table)
    g, rate = _rise(u, table)
    g = g + table.rise * (z * table.length - inner)
    stretch = 2.0 * table.scale * table.step * (1.0 + table.step * u)  # dz/du
    return g / table.unit, rate / stretch * (table.length / table.unit)


@formula
def table_force(stiffness, z, normal):
    """Return P of z >= 0."""
    return smooth_force(stiffness, equal_approach(z, normal)[0], normal)


@formula
def table_slope(z, normal):
    """Return dp/dz."""
    equal, rate = equal_approach(0.5 * (z + abs(z)), normal)
    return smooth_slope(equal, normal) * rate


@formula
def _work_within(k, t, normal):
    """Return the integral of g^m dz over a piece up to a place in it, J."""
    table, total = normal.table, 0.0
    for j in range(len(POINT)):
        # u = k + t s^2 takes the fractional power of first touch out
        s = 0.5 * (POINT[j] + 1.0)
        c, at = table.pieces, t * (s * s)
        g = c[k, 5]
        for power in range(4, -1, -1):
            g = c[k, power] + at * g
        stretch = 2.0 * table.scale * table.step * (1.0 + table.step * (k + at))  # dz/du
        total = total + WEIGHT[j] * s * t * stretch * smooth_force(1.0, g, normal)
    return total


@formula
def table_energy(z, normal):
    """Return the integral of p from 0 to z."""
    table, m = normal.table, exponent(normal)
    up = 0.5 * (z + abs(z))
    u, inner = _steps(up, table)
    k, t = _within(u, table)
    total = table.work[k] + _work_within(k, t, normal)
    beyond = table.last + table.rise * (up * table.length - inner)
    total = total + (
        beyond * smooth_force(1.0, beyond, normal) - table.last * smooth_force(1.0, table.last, normal)
    ) / ((m + 1.0) * table.rise)
    return total / (smooth_force(1.0, table.unit, normal) * table.length)


@formula
def table_approach(p, normal):
    """Return z of p, by bisection and Newton's method."""
    table = normal.table
    wanted = smooth_approach(p, normal) * table.unit
    inner = np.minimum(wanted, table.last)
    low = 0.0 * inner
    high = low + table.pieces.shape[0]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        above = 1.0 * (_rise(middle, table)[0] > inner)
        low, high = low + (1.0 - above) * (middle - low), high - above * (high - middle)
    u = 0.5 * (low + high)
    for _ in range(2):
        g, rate = _rise(u, table)
        u = np.maximum(u - (g - inner) / rate, 0.0)
    far = table.step * u
    return (table.scale * far * (2.0 + far) + (wanted - inner) / table.rise) / table.length


@formula
def table_scaled(normal, length):
    """Return the law of lengths in this unit, of a law in SI units."""
    table = normal.table
    unit = equal_approach(length, normal)[0] * table.unit
    own = Table(
        table.pieces, table.work, table.scale, table.step, table.end, table.last, table.rise, table.base, length, unit
    )
    onset = normal.onset * smooth_force(1.0, length * table.base / unit, normal)
    pull = normal.pull / smooth_force(1.0, unit / table.base, normal)
    return NormalLaw(
        normal.shape, 0, onset, pull, normal.force, normal.slope, normal.energy, normal.approach, normal.scaled,
        normal.unit_load, own, normal.hold,
    )  # fmt: skip


@formula
def table_unit_load(normal, length):
    """Return p in SI units of the unit of length."""
    table = normal.table
    return smooth_force(1.0, table.unit / table.base, normal)


@dataclass(frozen=True, eq=False)
class TabulatedForce:
    """The normal force of one contact at given approaches, as a table.

    Attributes
    ----------
    scale, end : float
        s and the last knot, m; the knots are at s ((1 + j step)^2 - 1).
    values : ndarray, shape (n + 1,)
        g at the knots, N^(1/m), rising from 0.
    shape : str
        "sphere" or "punch", whose exponent the force has at first touch.
    error : float
        Relative error of the force by interpolation, as found in the middle of the pieces.

    Examples
    --------
    >>> hertz = TabulatedForce.of(lambda z: 2.7e9 * z**1.5, scale=1e-9, end=1e-6)
    >>> hertz.error < 1e-9
    True
    """

    scale: float
    end: float
    values: np.ndarray
    shape: str
    error: float
    _pieces: np.ndarray = field(init=False, repr=False)

    @classmethod
    def of(
        cls, force: Callable[[float], float], *, scale: float, end: float, shape: str = "sphere",
        tolerance: float = TOLERANCE,
    ) -> "TabulatedForce":  # fmt: skip
        """Return the table of a function, refined until its interpolation errs by less than a tolerance.

        Parameters
        ----------
        force : callable
            Takes an approach in m, from first touch on, and returns the force of one contact in N; it rises from 0.
        scale : float
            Approach in m up to which knots are about evenly spaced; beyond, their distance grows with the approach.
        end : float
            Largest approach in m; beyond, P^(1/m) goes on as a straight line.
        shape : str
            "sphere" or "punch".
        tolerance : float
            Relative error of the force.

        Raises
        ------
        InputError
            If the force is not finite, does not rise, or is not smooth enough for a relative error of 1e-4.
        """
        parameter_check.choice("normal_law.shape", shape, SHAPES)
        scale = parameter_check.positive("normal_law.scale", scale, "m")
        end = parameter_check.positive("normal_law.end", end, "m")
        m = exponent_of(shape)
        known: dict[float, float] = {}
        last = _last_step(scale, end)

        def at(share):
            """Return g at shares of the steps."""
            return np.array([known[each] if each in known else known.setdefault(each, root(each)) for each in share])

        def root(share):
            far = share * last
            z = scale * far * (2.0 + far)
            value = float(force(float(z))) if share > 0.0 else 0.0
            if not (np.isfinite(value) and value >= 0.0):
                where = f"at an approach of {z:.4g} m"
                raise InputError(
                    "slider.normal_law", f"must give a force that is finite and not negative {where}", value, "N"
                )
            return value ** (1.0 / m)

        number = FEWEST
        while True:
            knots = np.linspace(0.0, 1.0, number + 1)
            values, middles = at(knots.tolist()), at((0.5 * (knots[1:] + knots[:-1])).tolist())
            if number < MOST and np.all(np.diff(values) > 0.0) and not _rises(_polynomials(values)):
                number *= 2  # too few pieces for a spline of a force that rises
                continue
            found = cls(scale, end, values, shape, 0.0)
            least = NEGLIGIBLE ** (1.0 / m) * values[-1]
            error = m * float(np.max(np.abs(found.middles - middles) / np.maximum(middles, least)))
            if error <= tolerance or number >= MOST:
                break
            number *= 2
        if not error <= COARSEST:
            raise InputError("slider.normal_law", f"must be smooth: a table of {number} pieces errs by {error:.2g}")
        return cls(scale, end, values, shape, error)

    def __post_init__(self):
        """Make the pieces; raise unless the force rises throughout."""
        values = np.ascontiguousarray(self.values, float)
        if np.any(np.diff(values) <= 0.0):
            raise InputError("slider.normal_law", "must give a force that rises with the approach")
        pieces = _polynomials(values)
        object.__setattr__(self, "_pieces", pieces)
        if not _rises(pieces):
            raise InputError("slider.normal_law", "must give a force that rises with the approach, without steps")
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    @property
    def middles(self) -> np.ndarray:
        """G in the middle of the pieces, N^(1/m)."""
        return self._pieces @ 0.5 ** np.arange(6.0)

    @property
    def _key(self):
        return self.scale, self.end, self.shape, self.values.tobytes()

    def __eq__(self, other):
        return isinstance(other, TabulatedForce) and self._key == other._key

    def __hash__(self):
        return hash(self._key)

    def law(self, stiffness: float) -> NormalLaw:
        """Return the law of contacts with P = K p(z), K = `stiffness`."""
        number, shape = len(self._pieces), SHAPES.index(self.shape)
        step = _last_step(self.scale, self.end) / number
        base = float(stiffness ** (1.0 / exponent_of(self.shape)))
        stretch = 2.0 * self.scale * step  # dz/du at first touch
        last, rise = (
            float(self.values[-1]),
            float(self._pieces[-1] @ np.arange(6.0)) / (stretch * (1.0 + step * number)),
        )
        first = float(self._pieces[0, 1]) / stretch / base
        empty = Table(self._pieces, np.zeros(number), self.scale, step, self.end, last, rise, base, 1.0, base)
        law = NormalLaw(
            shape, 0, first ** exponent_of(self.shape), 0.0, table_force, table_slope, table_energy, table_approach,
            table_scaled, table_unit_load, empty,
        )  # fmt: skip
        work = np.cumsum(_work_within(np.arange(number), 1.0, law)) - _work_within(np.arange(number), 1.0, law)
        return law._replace(table=empty._replace(work=np.ascontiguousarray(work)))


def _polynomials(values):
    """Return the coefficients of the spline between values, of rising powers in each piece, shape (n, 6)."""
    from scipy.interpolate import PPoly, make_interp_spline  # of tables alone: scipy may be absent elsewhere

    number = values.size - 1
    spline = PPoly.from_spline(make_interp_spline(np.arange(number + 1.0), values, k=5))
    # the spline has no knots of its own next to its ends: there several pieces are one polynomial
    pieces = np.empty((number, 6))
    for power in range(6):
        factor = 1.0 / np.prod(np.arange(1.0, power + 1.0))
        pieces[:, power] = spline(np.arange(float(number)), nu=power) * factor
    pieces[0, 0] = 0.0
    return pieces


def _rises(pieces):
    """Return whether polynomials rise throughout their pieces."""
    t = np.linspace(0.0, 1.0, 9)
    return bool(np.all(sum(k * pieces[:, k, None] * t ** (k - 1) for k in range(1, 6)) > 0.0))


def _last_step(scale, end):
    """Return sqrt(1 + end/s) - 1."""
    return end / scale / (1.0 + float(np.sqrt(1.0 + end / scale)))


def exponent_of(shape: str) -> float:
    """Return m of a shape."""
    return 1.5 if SHAPES.index(shape) == Shape.SPHERE else 1.0
