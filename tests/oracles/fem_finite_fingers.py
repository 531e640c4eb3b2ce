"""Charge on massless fingers of finite length, and the field it causes: boundary elements in three dimensions.

Every finger |x - x_j| < a, |y| < b is an equipotential on the surface of a solid that is isotropic in the surface's
plane (a plate or half-space of ceramic poled along its normal), so that the responses to a surface charge
s(k) exp(i (omega t - k_x x - k_y y)) depend on k = |k| only (`PlateResponse`, exact partial waves):

    phi = G(k) s,    u_z = G_z(k) s,    (u_x, u_y) = (k_x, k_y) g(k) s.

Galerkin's method.  The charge of a finger, with s = (x - x_j) / a and t = y / b, is

    sum_mn  q_mn  T_m(s) T_n(t) / [pi^2 a b (1 - s^2)^(1/2) (1 - t^2)^(1/2)],    n even,

whose transform is sum q_mn i^m J_m(k_x a) i^n J_n(k_y b) exp(i k_x x_j); q_00 is the finger's net charge.  The
potential of one such function tested by another is

    Z = 1 / (2 pi)^2 int int G(k) (-i)^m i^m' J_m J_m'(k_x a) (-i)^n i^n' J_n J_n'(k_y b) exp(-i k_x (x_i - x_j)).

With c, c_3 the first terms of k G = c + c_3 / k^2 + ... at large k, G is the sum of

- c / (k^2 + K^2)^(1/2) + (c_3 + c K^2 / 2) / (k^2 + K^2)^(3/2), integrated over real k_x and k_y: along x these are the
  functions K_0(q |x|) / pi and |x| K_1(q |x|) / (pi q), q^2 = k_y^2 + K^2; a finger with itself is integrated over k_x.
  At large k_x or k_y the part of J J' that does not oscillate is (J J' + Y Y') / 2;
- the rest, which falls as k^-5, integrated over k_x and k_y that both pass above the positive and below the negative
  real axis, t + i D tanh(t / D): the poles and branch points of a solid with loss lie on the other side.

Fields a few wavelengths away: on the real axis each response is a rational function of k^2 to nearly rounding (the AAA
algorithm), sum r_p / (k^2 - k_p^2), and each term is a Hankel function of the distance to a charge,

    1 / (2 pi) int_0^inf k J_0(k r) / (k^2 - k_p^2) dk = -i/4 H_0^(2)(k_p r),    Im k_p < 0,

summed over Gauss-Chebyshev nodes on the fingers.  Above `FADED` wavenumbers the responses are replaced by zero, which
changes the near field only.

Sources: Mason and Handscomb, Chebyshev Polynomials, 2003, section 9.5; DLMF 10.22; Nakatsukasa, Sete and Trefethen,
SIAM J. Sci. Comput. 40 (2018) A1494 (AAA).  Nothing of the package is imported.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from scipy.interpolate import AAA, CubicSpline
from scipy.linalg import lu_factor, lu_solve
from scipy.special import erfc, hankel2, jv, kv, yv

VACUUM = 8.8541878188e-12


@dataclass(frozen=True, kw_only=True)
class PlaneResponse:
    """Responses of the surface to charge.

    Attributes
    ----------
    surface : callable
        u along k, u_z (m) and phi (V) per C/m2 at wavenumbers (rad/m), complex, shape (n, 3).
    wavenumber : float
        Largest real part of a pole or branch point, rad/m.
    vacuum : bool
        Whether there is a field above the surface; without it the charge is D_n inside.
    """

    surface: object
    wavenumber: float
    vacuum: bool = False

    NEAR, TERMS = 1.35, 24  # ratio to ``wavenumber`` beyond which k G is a polynomial in 1 / k^2
    FADED = 1.6, 2.6  # the responses of distant fields fade out between these ratios
    TOLERANCE = 1e-11  # of the rational functions

    def at(self, k):
        """Responses at wavenumbers of any shape with positive real part, shape (..., 3)."""
        k = np.asarray(k)
        found = np.concatenate([self.surface(part) for part in np.array_split(k.ravel(), 1 + k.size // 20000)])
        if self.vacuum:
            found = found / (1 + VACUUM * k.ravel() * found[:, 2])[:, None]
        return found.reshape(*k.shape, 3)

    @cached_property
    def _series(self) -> np.ndarray:
        """Chebyshev coefficients of k G over (k_0 / k)^2 from 0 to 1."""
        nodes = (1 + np.cos(np.pi * (np.arange(self.TERMS) + 0.5) / self.TERMS)) / 2
        k = self.NEAR * self.wavenumber / np.sqrt(nodes)
        return chebyshev.chebfit(2 * nodes - 1, k * self.at(k)[:, 2], self.TERMS - 1)

    @cached_property
    def static(self) -> tuple[complex, complex]:
        """The first two coefficients c and c_3."""
        slope = chebyshev.chebval(-1.0, chebyshev.chebder(self._series)) * 2
        return chebyshev.chebval(-1.0, self._series), slope * (self.NEAR * self.wavenumber) ** 2

    def potential(self, squares) -> np.ndarray:
        """G at complex k^2 of any shape."""
        out = np.empty(squares.shape, dtype=complex)
        unit = (self.NEAR * self.wavenumber) ** 2
        far = abs(squares) > unit
        some = squares[far]
        out[far] = chebyshev.chebval(2 * unit / some - 1, self._series) / np.sqrt(some)
        out[~far] = self.at(np.sqrt(squares[~far]))[:, 2]
        return out

    @cached_property
    def poles(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Wavenumbers k_p and residues of the rational functions g, G_z and G."""
        samples = np.linspace(0.004, self.FADED[1], 6001) * self.wavenumber
        ratio = samples / self.wavenumber
        window = 0.5 * erfc(7 * ((ratio - self.FADED[0]) / (self.FADED[1] - self.FADED[0]) - 0.5))
        values = self.at(samples) * np.stack([window / samples, window, window], axis=1)
        squares, out = ratio**2, []
        for each in values.T:
            found = AAA(squares, each, rtol=self.TOLERANCE, max_terms=160)
            poles, residues = found.poles(), found.residues()
            roots = np.sqrt(poles)
            out.append((np.where(roots.imag > 0, -roots, roots) * self.wavenumber, residues * self.wavenumber**2))
        return out


def _panels(edges: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(points)
    half = np.diff(edges) / 2
    return ((edges[:-1] + half)[:, None] + half[:, None] * nodes).ravel(), np.outer(half, weights).ravel()


@dataclass(frozen=True, kw_only=True)
class FiniteFingers:
    """Equal and equidistant fingers.

    Attributes
    ----------
    response : PlaneResponse
    count : int
        Fingers.
    pitch, half_width, half_length : float
        Distance of the centres, a and b, m.
    across, along : int
        Functions across a finger and (even ones) along it.
    """

    response: PlaneResponse
    count: int
    pitch: float
    half_width: float
    half_length: float
    across: int = 4
    along: int = 60
    points: int = 10  # of a Gauss panel
    panel: float = 200.0  # rad/m, longest panel of the path where there are poles
    depth: float = 100.0  # rad/m, D
    smoothing: float = 1.0  # K over the response's wavenumber
    highest: float = 9.0  # of the path, over the response's wavenumber
    longest: float = 20.0  # k_y a up to which products along y are integrated; their mean beyond

    @property
    def _orders(self):
        return 2 * np.arange(self.along)

    @cached_property
    def _pairs(self) -> list[tuple[int, int]]:
        return [(m, n) for m in range(self.across) for n in range(self.across)]

    def _phase(self, m, n) -> complex:
        return (-1j) ** m * 1j**n

    def _path(self):
        """Wavenumbers t + i D tanh(t / D), t > 0, and weights."""
        last = self.response.wavenumber
        graded = 0.02 * 2.0 ** np.arange(30)
        graded = np.append(0.0, graded[graded < self.panel])
        near = np.arange(1, int(1.4 * last / self.panel) + 1) * self.panel
        width = 1.5 * self.panel
        far = near[-1] + width * np.arange(1, int((self.highest * last - near[-1]) / width) + 1)
        t, weights = _panels(np.concatenate([graded, near, far]), self.points)
        return t + 1j * self.depth * np.tanh(t / self.depth), weights * (1 + 1j * (1 - np.tanh(t / self.depth) ** 2))

    def _parts(self) -> tuple[complex, complex, float]:
        """Factors of the static functions, and K."""
        scale = self.smoothing * self.response.wavenumber
        first, third = self.response.static
        return first, third + first * scale**2 / 2, scale

    @cached_property
    def blocks(self) -> np.ndarray:
        """Z at distances 0, pitch, ... (x_i - x_j > 0), shape (fingers, across, across, along, along)."""
        return self.coupling([(number * self.pitch, self.half_width, self.half_width) for number in range(self.count)])

    def coupling(self, kinds) -> np.ndarray:
        """Z of two fingers of each kind: x_i - x_j >= 0, a_i, a_j in m; (kinds, across, across, along, along)."""
        total = self._dynamic(kinds) + self._static(kinds)
        sign = (-1.0) ** np.arange(self.along)
        total = total * np.outer(sign, sign) / np.pi  # both signs of k_y
        return total.reshape(len(kinds), self.across, self.across, self.along, self.along)

    def _products(self, k_y, kernel) -> np.ndarray:
        """Sums over k_y of J J' times a kernel, (n, columns), shape (columns, along, along)."""
        bessel = jv(self._orders, k_y[:, None] * self.half_length)
        return np.stack([bessel.T @ (column[:, None] * bessel) for column in kernel.T])

    def _dynamic(self, kinds) -> np.ndarray:
        path, weights = self._path()
        first, third, scale = self._parts()
        over = {a: jv(np.arange(self.across), path[:, None] * a) for _, *both in kinds for a in both}
        columns = []
        for distance, one, other in kinds:
            wave = np.exp(-1j * path * distance)
            for m, n in self._pairs:
                parity = wave + (-1) ** (m + n) / wave
                both = over[one][:, m] * over[other][:, n]
                columns.append(self._phase(m, n) * both * parity * weights / (2 * np.pi))
        columns = np.stack(columns, axis=1)
        rows, cols = np.tril_indices(len(path))
        rest = np.empty((len(path), len(path)), dtype=complex)
        for some in np.array_split(np.arange(len(rows)), 1 + len(rows) // 200000):
            squares = path[rows[some]] ** 2 + path[cols[some]] ** 2
            root = np.sqrt(squares + scale**2)
            rest[rows[some], cols[some]] = self.response.potential(squares) - first / root - third / root**3
        kernel = np.tril(rest) @ columns + np.tril(rest, -1).T @ columns
        return self._products(path, kernel * weights[:, None])

    def _static(self, kinds) -> np.ndarray:
        first, third, scale = self._parts()
        b, pairs, narrowest = self.half_length, len(self._pairs), min(each[1] for each in kinds)
        last = self.longest / narrowest
        k_y, weights = _panels(np.linspace(0.0, last, int(np.ceil(last * b / np.pi)) + 1), self.points)
        total = np.zeros((len(kinds), pairs, self.along, self.along), dtype=complex)
        nodes = np.cos(np.pi * (np.arange(16) + 0.5) / 16)
        basis = np.cos(np.outer(np.arccos(nodes), np.arange(self.across))) / 16
        for number, (distance, one, other) in enumerate(kinds):
            if distance == 0.0:
                total[number] = self._with_itself(k_y, weights, one)
                continue
            near = np.hypot(k_y, scale) < 45 / (distance - one - other)
            q = np.hypot(k_y[near], scale)[:, None, None]
            x = distance + np.subtract.outer(one * nodes, other * nodes)
            values = (first * kv(0, q * x) + third * x / q * kv(1, q * x)) / np.pi
            kernel = np.einsum("sm,qst,tn->qmn", basis, values, basis, optimize=True).reshape(-1, pairs)
            total[number] = self._products(k_y[near], kernel * weights[near, None])
        return total.reshape(-1, self.along, self.along)

    def _with_itself(self, k_y, weights, a) -> np.ndarray:
        """Static part of a finger of half width a, of which products along y are integrated over k_y."""
        first, third, scale = self._parts()
        table = np.geomspace(scale * 0.999, 2000 / a, 300)
        own = CubicSpline(np.log(table), self._own_static(table, first, third, a))
        kernel = own(np.log(np.hypot(k_y, scale)))
        total = self._products(k_y, kernel * weights[:, None])
        rest, step = np.linspace(np.log(k_y[-1]), np.log(table[-1]), 2000, retstep=True)
        size = np.full(len(rest), step)
        size[[0, -1]] /= 2
        outer = own(np.log(np.hypot(np.exp(rest), scale))) * (np.exp(rest) * size)[:, None] / 2
        for kind in (jv, yv):
            bessel = kind(self._orders, np.exp(rest)[:, None] * self.half_length)
            total += np.stack([bessel.T @ (column[:, None] * bessel) for column in outer.T])
        return total

    def _own_static(self, q, first, third, a) -> np.ndarray:
        """The static functions of a finger of half width a with itself, integrated over k_x, shape (q, pairs)."""
        last = 400.0
        k, weights = _panels(np.linspace(0.0, last, 267), 10)
        rest, step = np.linspace(np.log(last), np.log(1e7), 3000, retstep=True)
        size = np.full(len(rest), step)
        size[[0, -1]] /= 2
        k, weights = np.append(k, np.exp(rest)), np.append(weights, np.exp(rest) * size / 2)
        inner = slice(0, len(k) - len(rest))
        outer = slice(inner.stop, None)
        order = np.arange(self.across)
        bessel, other = jv(order, k[:, None]), np.zeros((len(k), self.across))
        other[outer] = yv(order, k[outer, None])
        root = np.hypot(k / a, q[:, None])
        values = (first / root + third / root**3) * weights / (np.pi * a)
        columns = [
            self._phase(m, n).real * (bessel[:, m] * bessel[:, n] + other[:, m] * other[:, n]) * ((m + n) % 2 == 0)
            for m, n in self._pairs
        ]
        return values @ np.stack(columns, axis=1)

    @property
    def size(self) -> int:
        """Unknowns of a finger."""
        return self.across * self.along

    @property
    def centers(self) -> np.ndarray:
        """Positions of the fingers' centres about the middle of all, m."""
        return (np.arange(self.count) - (self.count - 1) / 2) * self.pitch

    @cached_property
    def _halves(self) -> dict:
        """Factors of the matrices of the right half, for charges that are even (1) and odd (-1) in x."""
        half, size = self.count // 2, self.size
        own = (-1.0) ** np.arange(self.across)
        forth = self.blocks
        back = forth * np.outer(own, own)[:, :, None, None]
        out = {}
        for parity in (1, -1):
            matrix = np.empty((half, size, half, size), dtype=complex)
            for i, j in np.ndindex(half, half):
                direct = forth[i - j] if i >= j else back[j - i]
                both = direct + parity * forth[i + j + 1] * own[:, None, None]
                matrix[i, :, j] = both.transpose(0, 2, 1, 3).reshape(size, size)
            out[parity] = lu_factor(matrix.reshape(half * size, half * size))
        return out

    def _mirrored(self, values) -> np.ndarray:
        return values[::-1] * (-1.0) ** np.arange(self.across)[:, None]

    def _free(self, tested) -> np.ndarray:
        """Coefficients of charges whose potential, tested by all functions, is given, both (fingers, across, along)."""
        right, image = tested[self.count // 2 :], self._mirrored(tested)[self.count // 2 :]
        total = np.zeros(tested.shape, dtype=complex)
        for parity, factors in self._halves.items():
            part = lu_solve(factors, ((right + parity * image) / 2).ravel()).reshape(right.shape)
            total += np.concatenate([parity * self._mirrored(part), part])
        return total

    def constant(self, potentials) -> np.ndarray:
        """Tested potentials of fingers that are equipotentials, (fingers, across, along)."""
        tested = np.zeros((self.count, self.across, self.along), dtype=complex)
        tested[:, 0, 0] = potentials
        return tested

    def charges(self, tested, isolated) -> np.ndarray:
        """Coefficients q_mn in C, shape (fingers, across, along).

        ``tested``: potentials of all functions, given up to a constant on each conductor; ``isolated``: fingers of each
        conductor, (conductors, fingers), 1 or 0; none has a net charge.
        """
        found = self._free(tested)
        units = [self._free(self.constant(each)) for each in isolated]
        net = isolated @ np.stack([each[:, 0, 0] for each in units], axis=1)
        lift = np.linalg.solve(net, isolated @ found[:, 0, 0])
        return found - np.tensordot(lift, units, axes=1)

    @property
    def half_widths(self) -> np.ndarray:
        """Half widths of the fingers, m."""
        return np.full(self.count, self.half_width)

    def nodes(self, along: int, across: int):
        """Gauss-Chebyshev nodes on the fingers, x and y in m, and the functions there, (across, :), (along, :)."""
        angles = [np.pi * (np.arange(n) + 0.5) / n for n in (across, along)]
        x = self.centers[:, None, None] + np.outer(self.half_widths, np.cos(angles[0]))[:, :, None]
        y = self.half_length * np.cos(angles[1])
        over, length = np.cos(np.outer(np.arange(self.across), angles[0])), np.cos(np.outer(self._orders, angles[1]))
        return *np.broadcast_arrays(x, y), over / across, length / along

    def point_charges(self, coefficients, along: int | None = None, across: int | None = None):
        """Positions x and y (m) and charges (C) that replace the fingers for distant points, all (charges,)."""
        x, y, over, length = self.nodes(along or 4 * self.along, across or self.across + 2)
        charges = np.einsum("ms,jmn,nt->jst", over, coefficients, length, optimize=True)
        return x.ravel(), y.ravel(), charges.ravel()


@dataclass(frozen=True, kw_only=True)
class UnevenFingers(FiniteFingers):
    """Fingers of any widths at any places: ``edges`` in m, (count, 2); pitch and half_width are not used."""

    edges: np.ndarray = None
    pitch: float = np.nan
    half_width: float = np.nan

    @property
    def centers(self) -> np.ndarray:
        """Positions of the fingers' centres, m."""
        return self.edges.mean(axis=1)

    @property
    def half_widths(self) -> np.ndarray:
        """Half widths of the fingers, m."""
        return np.ptp(self.edges, axis=1) / 2

    @cached_property
    def _factors(self):
        """Factors of the matrix of all fingers; Z of two fingers in the other order is its transpose."""
        pairs = [(i, j) for i in range(self.count) for j in range(i + 1)]
        middles, halves = self.centers, self.half_widths
        own = [(middles[i] - middles[j], halves[i], halves[j]) for i, j in pairs]
        own = [tuple(np.round(each, 12).tolist()) for each in own]
        kinds = sorted(set(own))
        blocks = self.coupling(kinds)
        matrix = np.empty((self.count, self.size, self.count, self.size), dtype=complex)
        for (i, j), kind in zip(pairs, own, strict=True):
            block = blocks[kinds.index(kind)].transpose(0, 2, 1, 3).reshape(self.size, self.size)
            matrix[i, :, j], matrix[j, :, i] = block, block.T
        return lu_factor(matrix.reshape(self.count * self.size, -1))

    def _free(self, tested) -> np.ndarray:
        return lu_solve(self._factors, tested.ravel()).reshape(tested.shape)


class Field:
    """Hankel functions of the rational responses, tabulated over the distance from a charge.

    ``nearest`` and ``farthest``: distances in m; ``step``: of the table, m, interpolated by cubic splines.
    """

    def __init__(self, response: PlaneResponse, nearest: float, farthest: float, step: float = 1.5e-5):
        r = np.arange(nearest, farthest + step, step)
        (slope_k, slope_r), *scalars = response.poles
        tables = [self._summed(r, slope_k, -slope_r * slope_k, 1)]
        tables += [self._summed(r, k, residues, 0) for k, residues in scalars]
        self.table = CubicSpline(r, -0.25j * np.stack(tables, axis=1), axis=0)

    @staticmethod
    def _summed(r, wavenumbers, residues, order) -> np.ndarray:
        total = np.zeros(len(r), dtype=complex)
        for k, residue in zip(wavenumbers, residues, strict=True):
            near = r < 80 / max(-k.imag, 1e-9)
            total[near] += residue * hankel2(order, k * r[near])
        return total

    def motion(self, x, y, sources_x, sources_y, charges) -> np.ndarray:
        """u_x, u_y, u_z (m) and phi (V) at points by point charges (C), shape (4, points)."""
        out = np.empty((4, len(x)), dtype=complex)
        for number, (a, b) in enumerate(zip(x, y, strict=True)):
            apart = np.stack([a - sources_x, b - sources_y])
            r = np.hypot(*apart)
            values = self.table(r) * charges[:, None]
            out[:2, number] = 1j * ((apart / r) @ values[:, 0])
            out[2:, number] = values[:, 1:].sum(axis=0)
        return out


class Pair:
    """Two equal transducers in one row, the first driven; each has its own charges and receives those of the other.

    ``distance``: of their centres, m; ``along``: nodes along a finger that send and receive.
    """

    ITERATIONS, ACROSS = 3, 4

    def __init__(self, fingers: FiniteFingers, field: Field, distance: float, along: int):
        self.fingers, self.field, self.distance, self.along = fingers, field, distance, along

    def received(self, coefficients, shift: float) -> np.ndarray:
        """Potential, tested, of charges on one transducer at the other, whose centre lies ``shift`` to the right."""
        x, y, over, length = self.fingers.nodes(self.along, self.ACROSS)
        half = (self.along + 1) // 2  # y -> -y is a symmetry
        places = (x[..., :half] + shift).ravel(), y[..., :half].ravel()
        found = self.field.motion(*places, *self.fingers.point_charges(coefficients, self.along, self.ACROSS))[3]
        potential = np.empty(x.shape, dtype=complex)
        potential[..., :half] = found.reshape((*x.shape[:2], half))
        potential[..., half:] = potential[..., : self.along - half][..., ::-1]
        return np.einsum("ms,jst,nt->jmn", over, potential, length, optimize=True)

    def charges(self, potentials, isolated) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients on the driven transducer, of given potentials, and on the other, of ``isolated`` conductors."""
        held, together = self.fingers.constant(potentials), np.ones((1, self.fingers.count))
        one = self.fingers.charges(held, together)
        for _ in range(self.ITERATIONS):
            other = self.fingers.charges(-self.received(one, self.distance), isolated)
            one = self.fingers.charges(held - self.received(other, -self.distance), together)
        return one, other
