"""Guided modes of a uniform segment and the radiation impedance; surface_modes.py selects the surface wave.

In a segment that is uniform in x the unknowns of a line are sums of modes v exp(-i k x) with (section.py)

    [k^2 K2 + i k (K1 - K1t) + K0 - omega^2 M] v = 0,    nodal flux f = (K1 - i k K2) v.

All modes of the discretised section are kept, evanescent ones included, so that they span every line.  With their
shapes V and fluxes F as columns, a semi-infinite segment is the exact relation f = X u with the radiation impedance
(Dirichlet-to-Neumann map) X = F V^-1: nothing is reflected and no absorbing layer has to be tuned.  A mode goes right
if it decays to the right or, without loss, carries power to the right; the mean power along +x of a field is
-(omega/2) Im(u^H f), its mechanical and its electric part together.  The constant potential, which is a mode where
the section is not grounded, is counted as outgoing and has no flux of D: the far ends carry no charge.

Where x -> -x is a symmetry the eigenproblem is linear in k^2 and of half the size (u_x, or u_x and phi, odd).
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.discretize.section import LineSpace
from fem.eigenproblem import companion_modes, even_odd_modes
from fem.exceptions import ConvergenceError
from fem.waveguide.slow_modes import STATIC, refined_slow_modes
from fem.waveguide.surface_modes import surface_modes

POLISHING_STEPS = 6
# Residual of the radiation impedance, and error of the flux of a slow mode by it: ordinary sections reach 1e-15, and
# 1e-7 on the finest level.  Both decide: a residual below 1e-10 has been seen where the fluxes were off by their size.
RICCATI_TOLERANCE, MODES_TOLERANCE = 1e-12, 1e-3
SLOW = 40.0  # |k| below which a mode is slow, radians per slowest bulk wavelength
PROPAGATING = 0.3  # a mode whose |Im k| is below this share of |Re k| counts as propagating
MOVING = 0.1  # share of a mode's norm that is motion, at least; a static field of wavenumber k << 1 has one of about k
# |Im k| / |Re k| below which the power flux decides the direction of a mode that carries power
NEARLY_REAL = 3e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class GuidedModes:
    """Modes of a uniform segment at one frequency, as many to the right as a line has unknowns."""

    section: LineSpace
    frequency: float  # Hz
    # k of the modes that go right and of those that go left, shape (n,), radians per length unit
    wavenumbers: np.ndarray = field(repr=False)
    backwards: np.ndarray = field(repr=False)
    # shapes of the same modes in columns, (n, n)
    right: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)
    # nodal fluxes of the same modes in columns, (n, n)
    right_flux: np.ndarray = field(repr=False)
    left_flux: np.ndarray = field(repr=False)
    # k_y in radians per length unit, of fields that vary as exp(-i k_y y).  Where y -> -y is a symmetry of
    # the solid, the unknowns that change sign (u_y) are u_y / i.
    lateral_wavenumber: complex = 0.0

    @cached_property
    def _symmetric_matrices(self) -> tuple[np.ndarray, ...]:
        """K2, K1 and K0 - omega^2 M, for the radiation impedance, where the problem is complex symmetric."""
        if not self.lateral_wavenumber:
            return self.section.matrices(self.frequency)
        if self.section.solid.mirror_y is None:
            raise ValueError(
                "the radiation impedance at a lateral wavenumber is known where y -> -y is a symmetry of the solid; "
                "this cut has no such symmetry"
            )
        second, first, _, zeroth = self.section.full.lateral_matrices(self.frequency, self.lateral_wavenumber)
        return second, first, zeroth

    @cached_property
    def right_impedance(self) -> np.ndarray:
        """Radiation impedance X of a segment that extends to the right without end, f = X u, shape (n, n)."""
        second, first, zeroth = self._symmetric_matrices
        return _radiation_impedance(second, first, zeroth, self.wavenumbers, self.right, self.right_flux)

    @cached_property
    def left_impedance(self) -> np.ndarray:
        """Radiation impedance X of a segment that extends to the left without end, -f = X u, shape (n, n)."""
        odd = _odd(self.section, self.lateral_wavenumber)
        if odd is not None:
            mirror = np.where(odd, -1.0, 1.0)
            return mirror[:, None] * self.right_impedance * mirror
        second, first, zeroth = self._symmetric_matrices
        return _radiation_impedance(second, -first, zeroth, -self.backwards, self.left, -self.left_flux)

    @cached_property
    def impedance_sum(self) -> np.ndarray:
        """Sum of the radiation impedances, which relates a jump of the flux to the field that it sends both ways."""
        return self.right_impedance + self.left_impedance

    def right_amplitudes(self, field_right: np.ndarray) -> np.ndarray:
        """Amplitudes of the modes in a field that goes right, shape as the field (n, ...)."""
        return np.linalg.solve(self.right, field_right)

    def left_amplitudes(self, field_left: np.ndarray) -> np.ndarray:
        """Amplitudes of the modes in a field that goes left, shape as the field (n, ...)."""
        return np.linalg.solve(self.left, field_left)

    @property
    def nearest_cut_off(self) -> float:
        """Smallest |k|, radians per length unit, of all modes with motion: static fields have none and no cut-off."""
        motion = np.linalg.norm(self.right[self.section.mechanical], axis=0)
        return float(abs(self.wavenumbers[motion > MOVING * np.linalg.norm(self.right, axis=0)]).min())

    @property
    def propagating(self) -> np.ndarray:
        """Indices of the modes that propagate almost without decay."""
        return np.flatnonzero(abs(self.wavenumbers.imag) < PROPAGATING * abs(self.wavenumbers.real))

    @cached_property
    def rayleigh(self) -> np.ndarray:
        """Indices of the surface wave's modes, the most localised first.

        Localisation is the squared motion at the surface over its integral through the depth, reduced where the
        wavenumber is far from that of the half-space.  In a plate whose two faces are alike the surface wave is the
        sum of a symmetric and an antisymmetric mode of nearly the same velocity, each with half of its motion at
        the bottom: both are returned.  The eigensolver may return any mixture of two modes of the same velocity, so
        that such a pair is returned whatever their shapes.
        """
        moving = self.propagating
        if len(moving) == 0:
            raise ConvergenceError(
                f"no mode of this section propagates at {self.frequency:g} Hz: it is too thin or too lossy"
            )
        expected = None
        if self.section.surface_speed is not None:
            expected = 2 * np.pi * self.frequency * self.section.length_unit / self.section.surface_speed
        share = self.section.surface_share(self.right[:, moving])
        return moving[surface_modes(self.wavenumbers[moving], share, expected, self.lateral_wavenumber)]


def power(displacement: np.ndarray, flux: np.ndarray, frequency: float) -> np.ndarray:
    """Mean power along +x of each column of a field (u, f) on a line, -(omega/2) Im(f u*), in the fields' unit."""
    return -np.pi * frequency * np.imag(np.sum(flux * np.conj(displacement), axis=0))


def guided_modes(section: LineSpace, frequency: float, lateral_wavenumber: complex = 0.0) -> GuidedModes:
    """All modes of a uniform segment with a bare surface at a frequency in Hz.

    ``lateral_wavenumber``: k_y in radians per length unit; it takes a `Section` with all fields (``lateral=True`` in
    `fem.discretize.depth_mesh.discretise`).
    """
    if lateral_wavenumber:
        if section is not section.full:
            raise ValueError("modes at a lateral wavenumber need the full section: solve one frequency, not a band")
        second, first, adjoint, zeroth = section.full.lateral_matrices(frequency, lateral_wavenumber)
        skew = first - adjoint
    else:
        second, first, zeroth = section.matrices(frequency)
        skew = first - first.T
    constant = None
    if section.floating_potential and not lateral_wavenumber:
        constant = section.constant_potential / np.linalg.norm(section.constant_potential)
    odd = _odd(section, lateral_wavenumber)
    if odd is not None:
        mirror = np.where(odd, -1.0, 1.0)
        wavenumbers, right = even_odd_modes(second, skew, zeroth, odd)
        right_flux = _flux(second, first, wavenumbers, right)
        reversed_ones = ~_goes_right(wavenumbers, right, right_flux)
        wavenumbers = np.where(reversed_ones, -wavenumbers, wavenumbers)
        right = np.where(reversed_ones, mirror[:, None] * right, right)
        wavenumbers, right = _with_constant(constant, wavenumbers, right)
        backwards, left = -wavenumbers, mirror[:, None] * right
    else:
        (wavenumbers, right), (backwards, left) = _both_ways(constant, second, first, skew, zeroth)
    if section is section.full and not lateral_wavenumber and "phi" in section.solid.fields:
        _refine_slow_modes(section.full, (wavenumbers, right), (backwards, left), constant, (second, first, zeroth))
    right_flux = _flux(second, first, wavenumbers, right)
    left_flux = _flux(second, first, backwards, left)
    return GuidedModes(
        section=section,
        frequency=frequency,
        wavenumbers=wavenumbers,
        backwards=backwards,
        right=right,
        left=left,
        right_flux=right_flux,
        left_flux=left_flux,
        lateral_wavenumber=lateral_wavenumber,
    )


def full_modes(modes: GuidedModes) -> GuidedModes:
    """Modes on lines with all unknowns, of modes whose lines may be reduced to the basis of a band."""
    full = modes.section.full
    return modes if full is modes.section else guided_modes(full, modes.frequency)


def _odd(section: LineSpace, lateral_wavenumber: complex) -> np.ndarray | None:
    """Unknowns that change sign under x -> -x, where that is a symmetry."""
    return section.full.lateral_odd if lateral_wavenumber else section.odd


def _flux(second, first, wavenumbers, shapes):
    return first @ shapes - 1j * (second @ shapes) * wavenumbers


def _radiation_impedance(second, first, zeroth, wavenumbers, shapes, flux):
    """X = F V^-1, improved by Newton's method on the Riccati equation (X - K1^T) K2^-1 (X - K1) = K0 - omega^2 M.

    The eigensolver gives strongly evanescent modes to few digits.  With the residual R of the equation the correction Z
    obeys G^T Z + Z G = -R, where G = K2^-1 (X - K1) = V (-i k) V^-1.  In the basis of the modes, Z' = V^T Z V and
    R' = V^T R V, this is

        Z'_ij = R'_ij / (i (k_i + k_j)),    Z = V^-T Z' V^-1.                                                    (1)

    X is symmetric; rounding is removed at each step.
    """
    impedance = _symmetric(np.linalg.solve(shapes.T, flux.T).T)
    sums = 1j * (wavenumbers[:, None] + wavenumbers[None, :])
    # between two slow modes, which are right already, rounding of the residual decides
    settled = (sums == 0) | np.logical_and.outer(abs(wavenumbers) < STATIC, abs(wavenumbers) < STATIC)
    weights = np.where(settled, 0.0, 1.0 / np.where(settled, 1.0, sums))
    scale = abs(zeroth).max()
    best_residual, best = np.inf, impedance
    for _ in range(POLISHING_STEPS):
        difference = impedance - first  # X - K1
        residual = difference.T @ np.linalg.solve(second, difference) - zeroth
        relative = float(abs(residual).max() / scale)
        if relative >= 0.5 * best_residual:
            break
        best_residual, best = relative, impedance
        if relative < 1e-15:
            break
        in_modes = weights * (shapes.T @ residual @ shapes)  # Z' of equation (1)
        from_left = np.linalg.solve(shapes.T, in_modes)  # V^-T Z'
        impedance = _symmetric(impedance + np.linalg.solve(shapes.T, from_left.T).T)
    slow = (abs(wavenumbers) < SLOW) & (wavenumbers != 0)  # the constant potential has no flux
    fluxes = flux[:, slow]
    missed = float(np.max(abs(best @ shapes[:, slow] - fluxes).max(axis=0) / abs(fluxes).max(axis=0), initial=0.0))
    if not (best_residual < RICCATI_TOLERANCE and missed < MODES_TOLERANCE):
        raise ConvergenceError(
            f"the guided modes leave a residual of {best_residual:.1e} in the equation of the radiation impedance and "
            f"miss their own fluxes by {missed:.1e}: ask for a looser tolerance, take less extreme "
            "fingers or, in a stator far smaller than a wavelength, a higher frequency"
        )
    return best


def _unit_shapes(shapes):
    return shapes / np.sqrt(np.sum(abs(shapes) ** 2, axis=0))


def _nearest_to_constant(constant, wavenumbers, shapes):
    """Indices of the modes by |k|; 1 is added to |k| unless the unit shape is nearly the constant potential."""
    return np.argsort(abs(wavenumbers) + (abs(constant @ shapes) < 0.9), kind="stable")


def _with_constant(constant, wavenumbers, shapes):
    """Modes with shapes of unit norm.  In a floating section the constant potential replaces the mode nearest to it.

    ``constant``: its unit shape; None where the section is grounded.
    """
    shapes = _unit_shapes(shapes)
    if constant is not None:
        at = int(_nearest_to_constant(constant, wavenumbers, shapes)[0])
        wavenumbers = wavenumbers.copy()
        wavenumbers[at], shapes[:, at] = 0.0, constant
    return wavenumbers, shapes


def _both_ways(constant, second, first, skew, zeroth):
    """Modes going right and left where x -> -x is no symmetry: twice (wavenumbers, shapes).

    A mode that goes left has the number of the mode that goes right whose wavenumber is most nearly opposite.  The
    constant potential is a double mode, once in each direction.
    """
    size = len(second)
    wavenumbers, shapes = companion_modes(second, 1j * skew, zeroth)
    rightgoing = _goes_right(wavenumbers, shapes, _flux(second, first, wavenumbers, shapes))
    if constant is not None:
        pair = _nearest_to_constant(constant, wavenumbers, _unit_shapes(shapes))[:2]
        rightgoing[pair] = True, False
    if rightgoing.sum() != size:
        raise ConvergenceError(
            f"{int(rightgoing.sum())} of {2 * size} modes go right where {size} should: a mode without loss is at "
            "its cut-off; change the frequency slightly or give the solid a mechanical_quality"
        )
    right = _with_constant(constant, wavenumbers[rightgoing], shapes[:, rightgoing])
    backwards, left_shapes = _with_constant(constant, wavenumbers[~rightgoing], shapes[:, ~rightgoing])
    partner = _partners(right[0], backwards)
    return right, (backwards[partner], left_shapes[:, partner])


def _partners(wavenumbers, backwards):
    """Numbers of the modes to the left whose wavenumbers are most nearly opposite, in the order of rising |k|."""
    partner, free = np.empty(len(wavenumbers), dtype=int), np.ones(len(wavenumbers), dtype=bool)
    for index in np.argsort(abs(wavenumbers)):
        candidates = np.flatnonzero(free)
        partner[index] = candidates[np.argmin(abs(backwards[candidates] + wavenumbers[index]))]
        free[partner[index]] = False
    return partner


def _refine_slow_modes(section, rightgoing, leftgoing, constant, matrices):
    """Replace slowly decaying static modes by those of `refined_slow_modes`, in place."""
    second, first, zeroth = matrices
    refined = refined_slow_modes(
        rightgoing, leftgoing, (second, 1j * (first - first.T), zeroth), constant, section.surface_dofs["phi"]
    )
    if refined is None:
        return
    wavenumbers, shapes, numbers = refined
    right = _goes_right(wavenumbers, shapes, _flux(second, first, wavenumbers, shapes))
    if right.sum() != len(numbers):
        raise ConvergenceError(
            f"{int(right.sum())} of {len(right)} slow modes go right where {len(numbers)} should: change the frequency "
            "slightly or give the solid a mechanical_quality"
        )
    back = np.flatnonzero(~right)[_partners(wavenumbers[right], wavenumbers[~right])]
    for each, chosen in ((rightgoing, np.flatnonzero(right)), (leftgoing, back)):
        each[0][numbers], each[1][:, numbers] = wavenumbers[chosen], shapes[:, chosen]


def _goes_right(wavenumbers, shapes, flux):
    """True for modes that go right.

    The power flux decides for a mode that carries power and hardly decays, and the decay for all others.  With loss the
    two agree.  By the error of an absorbing layer a surface wave may grow by 1e-4 or less in the direction in which it
    propagates; then only the flux is right.
    """
    carried = -np.imag(np.sum(flux * np.conj(shapes), axis=0))
    apparent = np.sum(abs(flux * shapes), axis=0)
    nearly_real = abs(wavenumbers.imag) < NEARLY_REAL * abs(wavenumbers.real)
    lossless = abs(wavenumbers.imag) <= 1e-9 * (1.0 + abs(wavenumbers))
    by_flux = lossless | (nearly_real & (abs(carried) > 1e-6 * apparent))
    return np.where(by_flux, carried > 0, wavenumbers.imag < 0)


def _symmetric(matrix):
    return 0.5 * (matrix + matrix.T)
