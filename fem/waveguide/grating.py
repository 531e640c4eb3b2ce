"""Infinite grating of fingers: its stop bands, its waves and its capacitance.

One cell is half a gap, a finger and half a gap, condensed to its lines (fem/condense).  A field that changes from cell
to cell by a factor lambda (Floquet 1883, Bloch 1928), u_right = lambda u_left, g_right = -lambda g_left, obeys

    [lambda A_lr + A_ll + A_rr + A_lr^T / lambda] u = 0,                                                        (1)

with the fingers at zero potential (shorted) or each without charge (open).  If two pitches are one wavelength, a wave
couples to its reflection, and no wave propagates between the two frequencies at which lambda = -1:

    B(omega^2) u = 0,    B = A_ll + A_rr - A_lr - A_lr^T,    complex symmetric.                                 (2)

The frequencies at which B is singular are computed by successive linear problems (Ruhe 1973) and refined by the
symmetric Rayleigh functional omega^2 - u^T B u / (u^T B' u), which squares the error.  From a stop band's edges f1 <
f2: velocity p (f1 + f2), p the pitch, and reflectivity per finger |r| = pi (f2 - f1) / (f2 + f1) (coupled modes:
Plessky and Koskela 2000).  Where x -> -x is a symmetry, one of the two standing waves leaves every finger without net
charge: an edge that the open and the shorted grating share.  The bottom absorbs, so that the body is a half-space;
losses are left out.  Half a cell has no resonance near a stop band: it is condensed at a few Chebyshev nodes in omega^2
and interpolated.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fem.analytic.half_space import automatic_period
from fem.condense.finger_columns import FingerColumns
from fem.condense.transducer import Condensation, FingerShape, finger_cell, half_cells
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.discretize.spectral import chebyshev_nodes, lagrange_weights
from fem.exceptions import ConvergenceError, InputError
from fem.geometry import Above, Stator, Transducer
from fem.materials import Solid, fields
from fem.materials.christoffel import slowest_wavelength

STATIC = 1e-3  # frequency over the stop band's at which the admittance is that of the capacitance, to 1e-5
REACH = 0.04  # half-width of the range in which cells are interpolated, over the stop band's frequency
NODES = 6  # of that interpolation
STEP = 1e-4  # relative step in omega^2 of the difference for B'
NEAR = 0.25  # largest relative distance in omega^2 of an edge from the expected frequency
STEPS = 8  # largest number of refinements of an edge
SQUARE_TOLERANCE = 1e-11  # relative change of omega^2 at which they end
WAVES = 8  # number of eigenvalues lambda that are computed
SHIFT = -1.03 + 0.02j  # of the eigenvalue problem: near the lambda of a stop band, and equal to none of them


@dataclass(frozen=True, kw_only=True)
class StopBand:
    """Frequency range in which no surface wave propagates through a grating."""

    # lower, upper: Hz
    lower: float
    upper: float
    pitch: float  # from finger to finger, m

    @property
    def middle(self) -> float:
        """Hz."""
        return (self.lower + self.upper) / 2

    @property
    def velocity(self) -> float:
        """Velocity of the wave without the coupling by the fingers' reflections, m/s."""
        return 2 * self.pitch * self.middle

    @property
    def reflectivity(self) -> float:
        """|r| of one finger."""
        return float(np.pi * (self.upper - self.lower) / (self.upper + self.lower))


@dataclass(frozen=True, kw_only=True)
class Grating:
    """Discretised cell of the grating, which can be evaluated at any frequency."""

    section: Section
    shape: FingerShape
    pitch: float  # m
    resolution: Resolution
    middle: float  # frequency in Hz about which cells are interpolated

    @cached_property
    def _halves(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodes in omega^2 and the matrices of both half cells there, shape (nodes, 2 n + 2, 2 n + 2)."""
        low, high = ((2 * np.pi * self.middle * (1 + side * REACH)) ** 2 for side in (-1, 1))
        squares = chebyshev_nodes(low, high, NODES)
        pairs = [
            half_cells(Condensation(self.section, float(np.sqrt(square)) / (2 * np.pi)), self.shape, self.resolution)
            for square in squares
        ]
        left, right = (np.stack([pair[side].matrix for pair in pairs]) for side in (0, 1))
        return squares, left, right

    def cell(self, frequency: float, *, open_fingers: bool) -> FingerColumns:
        """Condensed cell at a frequency in Hz."""
        make = Condensation(self.section, frequency)
        if abs(frequency / self.middle - 1) > REACH:
            whole = finger_cell(make, self.shape, self.resolution)
        else:
            squares, *halves = self._halves
            weights = lagrange_weights(squares, (2 * np.pi * frequency) ** 2)
            rising, falling = (
                FingerColumns(size=self.section.size, matrix=np.tensordot(weights, half, axes=1), width=1.0)
                for half in halves
            )
            whole = make.joined(rising, falling, 0)
        return make.open_circuited(whole) if open_fingers else whole

    def edge_matrix(self, omega_squared: float, *, open_fingers: bool) -> np.ndarray:
        """Matrix B for lambda = -1, shape (n, n)."""
        cell = self.cell(float(np.sqrt(omega_squared)) / (2 * np.pi), open_fingers=open_fingers)
        both, across = _coupling(cell)
        return both - across - across.T

    def factors(self, frequency: float, *, open_fingers: bool) -> tuple[np.ndarray, np.ndarray]:
        """The lambda nearest to -1 at a frequency in Hz, shape (WAVES,), and their fields in mid-gap, (n, WAVES).

        They are eigenvalues of (1) in linear form, with x = (u, lambda u),

            [[0, 1], [-A_lr^T, -(A_ll + A_rr)]] x = lambda [[1, 0], [0, A_lr]] x,

        which is solved by shift and inversion about SHIFT.
        """
        from scipy.linalg import lu_factor, lu_solve
        from scipy.sparse.linalg import LinearOperator, eigs

        cell = self.cell(frequency, open_fingers=open_fingers)
        n, (both, across) = cell.size, _coupling(cell)
        factor = lu_factor(across.T + SHIFT * both + SHIFT**2 * across, check_finite=False)

        def inverted(x: np.ndarray) -> np.ndarray:
            load = across @ (x[n:] + SHIFT * x[:n]) + both @ x[:n]
            u = -lu_solve(factor, load, check_finite=False)
            return np.concatenate([u, x[:n] + SHIFT * u])

        operator = LinearOperator((2 * n, 2 * n), matvec=inverted, dtype=complex)
        values, vectors = eigs(operator, k=WAVES, v0=np.ones(2 * n, dtype=complex), tol=1e-12)
        return SHIFT + 1 / values, vectors[:n]

    def surface_factor(self, frequency: float, *, open_fingers: bool) -> complex:
        """Lambda = exp(-i k p) of the surface wave that runs or decays to the right, near the first stop band.

        Of the pair lambda, 1 / lambda it is the smaller one, or if both have size 1 the one with 0 < Re k p < pi.
        """
        values, shapes = self.factors(frequency, open_fingers=open_fingers)
        near = np.flatnonzero((abs(np.log(abs(values) + 1e-300)) < 1.0) & (values.real < 0))
        share = self.section.surface_share(shapes[:, near])
        best = values[near[np.argmax(share)]]
        if abs(abs(best) - 1) > 1e-7:
            return complex(best if abs(best) < 1 else 1 / best)
        return complex(best if best.imag < 0 else np.conj(best))

    def stop_band(self, *, open_fingers: bool) -> StopBand:
        """Edges of the first stop band; a ConvergenceError if no two surface waves with lambda = -1 exist."""
        from scipy.linalg import eig

        start = (2 * np.pi * self.middle) ** 2
        matrix, slope = self._matrix_and_slope(start, open_fingers)
        # B + (omega^2 - start) B' = 0 has the eigenvalues -1 / (omega^2 - start) of B^-1 B'
        inverse, vectors = eig(np.linalg.solve(matrix, slope))
        near = np.flatnonzero(abs(inverse) * start * NEAR > 1)
        share = self.section.surface_share(vectors[:, near]) if len(near) else np.zeros(0)
        surface_waves = near[np.argsort(-share)[:2]]
        if len(surface_waves) < 2:
            raise ConvergenceError(f"no two standing waves near {self.middle:g} Hz: the cut guides no surface wave")
        edges = sorted(
            self._polished((start - 1 / inverse[index]).real, vectors[:, index], open_fingers)
            for index in surface_waves
        )
        return StopBand(lower=edges[0], upper=edges[1], pitch=self.pitch)

    def _matrix_and_slope(self, omega_squared, open_fingers):
        """B and its derivative with respect to omega^2, by differences."""
        step = STEP * omega_squared
        around = [self.edge_matrix(omega_squared + side * step, open_fingers=open_fingers) for side in (-1, 1)]
        return (around[0] + around[1]) / 2, (around[1] - around[0]) / (2 * step)

    def _polished(self, square: float, shape: np.ndarray, open_fingers: bool) -> float:
        """Frequency (Hz) at which B is singular on a shape like this one: inverse iteration, Rayleigh functional."""
        for _ in range(STEPS):
            matrix, slope = self._matrix_and_slope(square, open_fingers)
            shape = np.linalg.solve(matrix, slope @ shape)
            shape = shape / np.linalg.norm(shape)
            change = complex((shape @ matrix @ shape) / (shape @ slope @ shape)).real
            square -= change
            if abs(change) < SQUARE_TOLERANCE * square:
                return float(np.sqrt(square) / (2 * np.pi))
        raise ConvergenceError(f"a stop band's edge near {np.sqrt(square) / (2 * np.pi):g} Hz does not settle")

    def capacitance(self) -> float:
        """Capacitance of a finger pair far below its resonances, F per metre of aperture.

        With fingers at +V/2 and -V/2 in turn lambda = -1, so that B u + (A_lp - A_rp) v = 0 with the finger's potential
        v = V/2.  The charge of the finger is minus its reaction, A_pp v + (A_lp - A_rp)^T u.
        """
        frequency = STATIC * self.middle
        cell = self.cell(frequency, open_fingers=False)
        at, finger = cell.at, cell.at.ports.start
        matrix = self.edge_matrix((2 * np.pi * frequency) ** 2, open_fingers=False)
        by_potential = cell.matrix[at.left, finger] - cell.matrix[at.right, finger]
        line = -np.linalg.solve(matrix, by_potential)
        reaction = cell.matrix[finger, finger] + by_potential @ line
        medium = self.section.solid
        return float(-0.5 * reaction.real * medium.stress_unit / medium.potential_unit**2)


def _coupling(cell: FingerColumns) -> tuple[np.ndarray, np.ndarray]:
    """A_ll + A_rr and A_lr of a cell."""
    at, matrix = cell.at, cell.matrix
    return matrix[at.left, at.left] + matrix[at.right, at.right], matrix[at.left, at.right]


def grating(solid: Solid, *, period: float, metallisation: float, above: Above, resolution: Resolution) -> Grating:
    """Discretise one cell of an infinite grating on a half-space.

    Parameters
    ----------
    solid : Solid
        In the stator's frame, piezoelectric; its losses are left out.
    period, metallisation : float
        Of two fingers and two gaps, m; finger width over finger width plus gap, between 0 and 1.
    above : str
        "none" or "vacuum".
    """
    if "phi" not in fields(solid):
        raise InputError("solid", f"must be piezoelectric under a grating of fingers, and {solid.name} is not")
    pair = Transducer(
        name="grating", center=0.0, finger_pairs=1, period=period, metallisation=metallisation, aperture=1.0
    )
    bare = replace(solid, mechanical_quality=np.inf, dielectric_loss=0.0)
    middle = automatic_period(bare, 1.0, metallisation) / period
    unit = slowest_wavelength(bare, middle)
    stator = Stator(solid=bare, length=period, thickness=np.inf, ends="absorbing", above=above)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=pair.finger_width / 2)
    shape = FingerShape.of(pair, unit)
    return Grating(section=section, shape=shape, pitch=pair.pitch, resolution=resolution, middle=middle)
