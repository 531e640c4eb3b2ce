"""Charges on equal strips of an infinite plate, and the motion they cause: boundary elements, no mesh of the body.

The fingers are massless, so their charge is all that drives the plate.  On a strip of half-width a about x_f the
charge is a sum of Chebyshev polynomials over the square root that it has at the edges,

    sigma(x) = sum_n q_n T_n(s) / (pi a sqrt(1 - s^2)),  s = (x - x_f) / a,
    transform: sum_n q_n i^n J_n(k a) exp(i k x_f),

and the potential at one strip of a charge on another, tested with a charge, an integral over k of G(k), the plate's
potential per charge (fem_plate_response.py).  Real axis up to K, beyond all propagating modes, which loss keeps off it;
from there obliquely down (exp(-i k d)) and up (exp(i k d)), where the integrand dies exponentially; for a strip with
itself on along the real axis, the tail c / k of G in closed form.  The pole c / k^2 of G at k = 0 (the plate conducts
D along x) is taken out under a Gaussian and put back as a function of x; charges that sum to zero do not see its
constant.

Measured on the seed's stator: finer quadrature, another K or slope, more terms change the answer by 1e-12.

Limits: absorbing ends (an infinite plate), one half-width, x -> -x a symmetry, loss.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tests.oracles.fem_plate_response import PlateResponse

__all__ = ["StripCharges"]

_POINTS = 20  # of a Gauss panel
_PANEL = 5.0  # rad/m: poles keep 1.5 rad/m off the axis at Q = 1000
_BEYOND = 1.25  # K over the shear wavenumber: the surface wave's is 1.1
_ANGLE = np.pi / 6  # of the slopes: a plate's evanescent modes lie at 78 to 90 degrees in hard PZT, not on one axis
_SMOOTH = 1e-3  # m, width of the Gaussian that takes 1 / k^2 out
_SELF_REACH = 1500.0  # k a up to which G is integrated for a strip with itself; c / k beyond, error (k a)^-3


@dataclass(frozen=True, kw_only=True)
class StripCharges:
    """Strips on a plate.

    Attributes
    ----------
    plate : PlateResponse
    centers : ndarray, shape (strips,)
        m.
    half_width : float
        m.
    terms : int
        Chebyshev polynomials on each strip.
    """

    plate: PlateResponse
    centers: np.ndarray = field(repr=False)
    half_width: float
    terms: int

    def charges(self, owner: np.ndarray, held: dict[int, float]) -> tuple[np.ndarray, np.ndarray]:
        """Charge of conductors that tie strips together.

        Parameters
        ----------
        owner : ndarray of int, shape (strips,)
            Conductor of each strip.
        held : dict
            Potential of those that are held (V), up to one constant common to all; the others take no net charge,
            nor do the held ones together.

        Returns
        -------
        charges : ndarray, shape (conductors,)
            C/m.
        coefficients : ndarray, shape (strips, terms)
            q_n of every strip, C/m.
        """
        count, terms = len(self.centers), self.terms
        conductors = int(owner.max()) + 1
        loose = [each for each in range(conductors) if each not in held]
        size = count * terms
        net = np.arange(count) * terms  # where the net charge of each strip stands
        system = np.zeros((size + 1 + len(loose),) * 2, dtype=complex)
        system[:size, :size] = self.matrix
        load = np.zeros(len(system), dtype=complex)
        scale = abs(self.matrix).max()
        for strip, conductor in enumerate(owner):
            column = size if conductor in held else size + 1 + loose.index(conductor)
            system[net[strip], column] -= scale
            system[column, net[strip]] -= scale
            load[net[strip]] = held.get(int(conductor), 0.0)
        solved = np.linalg.solve(system, load)
        coefficients = solved[:size].reshape(count, terms)
        return np.array([coefficients[owner == each, 0].sum() for each in range(conductors)]), coefficients

    def motion(self, coefficients: np.ndarray, place: float) -> np.ndarray:
        """u_x and u_z (m) at a place (m) outside the strips, shape (2,)."""
        total = np.zeros(2, dtype=complex)
        for side in (1.0, -1.0):  # strips left of the place, then those right of it, mirrored
            chosen = side * (place - self.centers) > 0
            if not chosen.any():
                continue
            distances = side * (place - self.centers[chosen])
            signs = side ** np.arange(self.terms)
            own = coefficients[chosen] * signs
            k, weights = self._axis
            spectrum = self._spectrum(k, own, distances, -1.0)
            mirrored = self._spectrum(k, own, distances, 1.0)
            response = self._response[:, :2]
            parity = np.array([-1.0, 1.0])  # u_x is odd in k
            part = weights @ (response * (spectrum[:, None] + parity * mirrored[:, None]))
            for turn in (-1.0, 1.0):
                k, weights = self._slope(distances.min() - self.half_width, turn)
                response = self.plate.surface(k)[:, :2] * (1.0 if turn < 0 else parity)
                part = part + weights @ (response * self._spectrum(k, own, distances, turn)[:, None])
            total += part * np.array([side, 1.0]) / (2 * np.pi)
        return total

    def _spectrum(self, k, coefficients, distances, turn) -> np.ndarray:
        """Transform of charges seen from a place: exp(turn i k d) times (-turn i)^n J_n(k a)."""
        from scipy.special import jv

        orders = np.arange(self.terms)
        bessel = jv(orders, k[:, None] * self.half_width) * (-turn * 1j) ** orders
        return np.sum((np.exp(turn * 1j * np.outer(k, distances)) @ coefficients) * bessel, axis=1)

    @cached_property
    def matrix(self) -> np.ndarray:
        """Potentials of charges, V m/C, shape (strips terms,) * 2: complex symmetric."""
        count, terms = len(self.centers), self.terms
        apart = self.centers[:, None] - self.centers[None, :]
        table = np.zeros((count, terms, count, terms), dtype=complex)
        made: dict[int, np.ndarray] = {}
        for row in range(count):
            for column in range(row + 1):
                key = round(apart[row, column] / self.half_width * 1e6)
                if key not in made:
                    made[key] = self._pair(float(apart[row, column])) if row != column else self._own()
                table[row, :, column] = made[key]
                table[column, :, row] = made[key].T
        return table.reshape(count * terms, count * terms)

    def _pair(self, distance: float) -> np.ndarray:
        """Of a strip with another that lies a distance to its left, shape (terms, terms)."""
        forth, back = self._phases
        k, weights = self._axis
        regular = weights * self._regular
        bessel = self._bessel(k)
        wave = np.exp(-1j * k * distance)
        total = forth * (bessel.T @ ((regular * wave)[:, None] * bessel))
        total += back * (bessel.T @ ((regular / wave)[:, None] * bessel))
        for turn, phase in ((-1.0, forth), (1.0, back)):
            k, weights = self._slope(distance - 2 * self.half_width, turn)
            response = self.plate.surface(k)[:, 2]
            bessel = self._bessel(k)
            total += phase * (bessel.T @ ((weights * response * np.exp(turn * 1j * k * distance))[:, None] * bessel))
        return total / (2 * np.pi) + self._smooth(distance)

    def _own(self) -> np.ndarray:
        """Of a strip with itself."""
        forth, back = self._phases
        k, weights = self._axis
        bessel = self._bessel(k)
        total = bessel.T @ ((weights * self._regular)[:, None] * bessel)
        last = self._last
        panels = int(np.ceil((_SELF_REACH / self.half_width - last) * self.half_width / 1.5))
        k, weights = _panels(np.linspace(last, _SELF_REACH / self.half_width, panels + 1))
        bessel = self._bessel(k)
        tail = self.plate.high_wavenumber
        total = total + bessel.T @ ((weights * (self.plate.surface(k)[:, 2] - tail / k))[:, None] * bessel)
        total = total + tail * self._reciprocal_tail(last)
        return (forth + back) * total / (2 * np.pi) + self._smooth(0.0)

    def _reciprocal_tail(self, start: float) -> np.ndarray:
        """Integrals of J_m(k a) J_n(k a) / k beyond ``start`` (rad/m), m + n even (DLMF 10.22.57; 0, 0: its limit)."""
        first = start * self.half_width
        t, weights = _panels(np.linspace(0.0, first, int(np.ceil(first)) + 2))
        bessel = self._bessel(t / self.half_width)
        table = -(bessel.T @ ((weights / t)[:, None] * bessel))
        orders = np.arange(1, self.terms)
        table[orders, orders] += 1 / (2 * orders)
        regular = np.sum(weights * (bessel[:, 0] ** 2 - 1.0) / t)
        table[0, 0] = np.log(2.0) - np.euler_gamma - np.log(first) - regular
        return table

    def _smooth(self, distance: float) -> np.ndarray:
        """What was taken out: c_0 exp(-(b k)^2) / k^2, as the function of x that it transforms to."""
        from scipy.special import erf

        nodes = np.cos(np.pi * (np.arange(3 * self.terms) + 0.5) / (3 * self.terms))
        basis = np.cos(np.outer(np.arccos(nodes), np.arange(self.terms))) / len(nodes)
        x = distance + self.half_width * (nodes[:, None] - nodes[None, :])
        values = x / 2 * erf(x / (2 * _SMOOTH)) + _SMOOTH / np.sqrt(np.pi) * np.exp(-((x / (2 * _SMOOTH)) ** 2))
        return -self._low * (basis.T @ values @ basis)

    @cached_property
    def _low(self) -> complex:
        return complex(self.plate.low_wavenumbers[0])

    @cached_property
    def _last(self) -> float:
        """K in rad/m."""
        plate = self.plate
        shear = 2 * np.pi * plate.frequency * np.sqrt(plate.density / abs(plate.stiffness[4, 4]))
        return float(_BEYOND * shear)

    @cached_property
    def _axis(self) -> tuple[np.ndarray, np.ndarray]:
        return _panels(np.linspace(0.0, self._last, int(np.ceil(self._last / _PANEL)) + 1))

    @cached_property
    def _response(self) -> np.ndarray:
        return self.plate.surface(self._axis[0])

    @cached_property
    def _regular(self) -> np.ndarray:
        """G on the axis without its pole at k = 0: by difference, and near the pole by its series."""
        k, plate = self._axis[0], self.plate
        difference = self._response[:, 2] - self._low * np.exp(-((k * _SMOOTH) ** 2)) / k**2
        series = np.polynomial.polynomial.polyval(k**2, plate.low_wavenumbers[1:])
        series = series - self._low * np.expm1(-((k * _SMOOTH) ** 2)) / k**2
        return np.where(k < plate.small_wavenumber / 2, series, difference)

    def _slope(self, reach: float, turn: float) -> tuple[np.ndarray, np.ndarray]:
        """From K down (turn -1) or up (+1) to where exp(-reach Im k) is below rounding; finer near the poles."""
        direction = np.exp(turn * 1j * _ANGLE)
        far = 40.0 / (reach * np.sin(_ANGLE))
        graded = 0.02 * self._last * 2.0 ** np.arange(40)
        t, weights = _panels(np.union1d(np.linspace(0.0, far, 17), graded[graded < far]))
        return self._last + direction * t, direction * weights

    def _bessel(self, k) -> np.ndarray:
        from scipy.special import jv

        return jv(np.arange(self.terms), k[:, None] * self.half_width)

    @cached_property
    def _phases(self) -> tuple[np.ndarray, np.ndarray]:
        """Of (-i)^m i^n for k and for -k."""
        orders = np.arange(self.terms)
        forth = np.outer((-1j) ** orders, 1j**orders)
        return forth, forth * (-1.0) ** (orders[:, None] + orders)


def _panels(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights over panels."""
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    half = np.diff(edges) / 2
    return ((edges[:-1] + half)[:, None] + half[:, None] * nodes).ravel(), np.outer(half, weights).ravel()
