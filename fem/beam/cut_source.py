"""Guided modes excited by a line of charge or force at any lateral wavenumber k_y, in any crystal cut.

With L(k) = k^2 K2 + i k (K1 - K1t) + K0 - omega^2 M at k_y (section.py), a line of charge q has the response
u(k_x) = L(k_x)^-1 q e, where e is the unknown of the surface's potential, or of u_x or u_z for a force.  With all
eigenpairs k_p, v_p of both directions,

    L(k)^-1 = sum_p v_p l_p^T / (k - k_p),    [V; V diag(k_p)] [l_p^T] = [0; K2^-1],                       (1)

so that a mode to the right is -i v_p (l_p . e) exp(-i k_p x), and one to the left has +i instead of -i.  Reciprocity,
L(k, k_y)^T = L(-k, -k_y), gives the response at -k_y from the same eigenpairs.  In a half-space the discrete modes
represent the bulk waves too.

The eigenproblem is solved on a reduced basis: the fields of loads on the surface at some wave vectors within a disc
(`_reduced`; Benner, Gugercin and Willcox, SIAM Review 57 (2015) 483), at a tenth of the cost of the whole section.

Limits: backward waves are neglected, and so are waves whose power leaves at more than 45 degrees to the opposite side
of their phase.  The integral over k_y ends smoothly at the wavenumber of the surface wave.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import PLANE, LateralRule, lateral_rule, rounded_reach
from fem.beam.line_source import LOADED, LOCAL, NEGLIGIBLE, Branch, Load, load_scale
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.eigenproblem import companion_modes, even_odd_modes, opposite_modes
from fem.waveguide.port_fields import PortFields
from fem.waveguide.surface_modes import TWIN_MODES, TWIN_SHARE, weighed

SURFACE_FIELDS = ("ux", "uy", "uz", "phi")
# Lateral wavenumbers over the surface wave's wavenumber between which the integral is faded out.
FADE = (0.8, 1.0)
# Factor on both for a second, narrower integral; the change estimates the error by neglecting more oblique waves.
NARROWER = 0.8
# k_y over the surface wave's wavenumber that replaces k_y = 0, where the constant potential is a double root.
NEARLY_ZERO = 1e-5
NEARLY_REAL = 0.3  # |Im k| / |Re k| below which the power flux of a mode determines its direction
# Modes of absorbing layers may grow by this share of the surface wave's wavenumber.
GROWTH = 1e-3
# Factors on `lateral.SPACING`, the distance of the nodes in k_y, where the potential is grounded somewhere or floats.
# With a floating potential u_x depends on |k_y|, a cusp that the nodes have to resolve: with 1 its error is 7e-5, and
# the shipped motor on 128YX lithium niobate then misses its tolerance at the first solution of the section.
SPACING_GROUNDED, SPACING_FLOATING = 1.6, 0.85
# Distance of the contour from the real axis over the wavenumber, if the potential does not float; with SPACING_GROUNDED
# the error is 2e-5 on YZ and 128YX lithium niobate.
CONTOUR_TILT_GROUNDED = 0.06
# Wave vectors of the reduced basis: number of directions on a half circle, range of sizes over the surface wave's, and
# their angle in the complex plane in rad, which avoids the real wavenumbers of lossless modes.  The skimming waves need
# many directions: with 111 fingers at the free wavelength on a half-space of YZ lithium niobate, where u_z is weak, u_y
# is up to 9e-4 of the motion off, with 10 directions 3e-3, with 7 at 0.05 rad 3e-2 (against Stroh's problem as in
# test_oblique_bulk.py).
DIRECTIONS, SIZES, BASIS_ANGLE = 14, (0.02, 1.2), 0.02
ORDER, LAYER = 7, 3  # least resolution of the section
DEPTH = 0.5  # wavelengths of the half-space above its absorbing layer; 2 change the motion by less than 1e-4
# Height of the vacuum in wavelengths: with the slow static modes of a higher one (`fem.discretize.vacuum`) the source
# takes 18 CPU seconds on 128YX instead of 0.6, for 3e-6 of the motion.
VACUUM = 64.0
# Least singular value over the largest of the vectors in the basis, for each level of the section.  At TRIALS random
# wave vectors between those of the basis the error of the response must be less than ten times this value.
SINGULAR, TRIALS = (3e-5, 3e-5, 3e-5, 7e-6, 1.4e-6, 3e-7), 20
# Sizes of these wave vectors over the surface wave's: those of the bulk waves, where the basis errs most.  In four of
# five tests on 21 random cuts the largest error at the trials exceeded the error at 95 % of 200 other wave vectors.
# With 5 trials of all SIZES the largest error was up to 76 times the stated one in 20 of these cuts, 1100 in one.
TRIAL_SIZES = (0.35, 0.8)
# Where modes of the reduced section grow although those of the section do not, the responses at their wavenumbers are
# added to the basis, at most so many times; one time suffices on 128YX lithium niobate, where the modes of the backward
# bulk waves grow by 5e-3 without it and the beam lacks 7e-4 of the motion (test_cut_source.py).
MAX_REFINEMENTS = 3
# Size of the basis over the section's unknowns above which it is accepted whatever its error.
MAX_BASIS_SHARE = 0.8


class Poles(NamedTuple):
    """Modes of both directions at one k_y.

    ``wavenumbers`` (modes,) are in rad/m; ``right`` is True for modes that run to the right, ``surface`` for those of
    the surface wave.  ``column`` (modes, 3): u_x, u_y and u_z at the surface of each mode's residue per unit
    load; ``transposed`` (modes, 3): those of the transposed response.
    """

    wavenumbers: np.ndarray
    right: np.ndarray
    surface: np.ndarray
    column: np.ndarray
    transposed: np.ndarray


@dataclass(frozen=True, kw_only=True)
class CutSource:
    """Response of the bare stator to a load on the line x = 0, in any crystal cut; a `line_source.ModeSource`.

    It has the surface motion of the modes sent by 1 C/m or 1 N/m on the line x = 0, at any lateral wavenumber.

    Attributes
    ----------
    load : "charge", "x" or "z"
        A charge, or a force along x or z.
    section : Section
        Section with all fields, but without the layers of elements for the finger edges.
    reduced : LateralSection
        Matrices of the section on a reduced basis.
    frequency : float
        Hz.
    wavenumber : float
        Wavenumber of the surface wave at k_y = 0, rad/m.
    surface_only : bool
        True if the field is that of the surface wave alone.
    static : float
        0, because the modes contain the pole at k = 0.
    omits_oblique : bool
        True: waves whose power leaves at more than 45 degrees are neglected.
    known_poles : dict
        Poles at the nodes of the rules that were integrated so far, by node; finer rules contain those of coarser ones.
    """

    section: Section = field(repr=False)
    reduced: "LateralSection" = field(repr=False)
    frequency: float
    wavenumber: float
    surface_only: bool = False
    static: float = 0.0
    omits_oblique: bool = True
    load: Load = "charge"
    known_poles: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def error(self) -> float:
        """Relative error by the reduced basis."""
        return self.reduced.error

    @property
    def surface_mode(self) -> "CutSource":
        """The same source with the surface wave alone."""
        return replace(self, surface_only=True)

    def loaded(self, load: Load) -> "CutSource":
        """Source of another load in the same section."""
        return replace(self, load=load, known_poles={})

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Wavenumbers of the surface wave along x in rad/m, at real lateral wavenumbers of either sign."""
        sizes, which = np.unique(abs(np.asarray(lateral)), return_inverse=True)
        poles = self.poles_at(sizes)
        forward = np.array([np.mean(each.wavenumbers[each.surface & each.right]) for each in poles])
        backward = np.array([np.mean(each.wavenumbers[each.surface & ~each.right]) for each in poles])
        return np.where(np.asarray(lateral) < 0, -backward[which], forward[which])

    def branches(
        self, reach: float, distance: float, resolved: float, mirror_width: float | None, halvings: int = 0
    ) -> Iterator[Branch]:
        """Waves to both sides, as `ModeSource.branches`, for points at least ``distance`` from the load.

        ``resolved`` has no effect: the modes that are left out are always those of `select_poles`.
        """
        low, high = (each * self.wavenumber for each in FADE)
        floats = self.section.floating_potential
        options: dict = {"cusp": True} if floats else {"max_tilt": CONTOUR_TILT_GROUNDED}
        options |= {"coarser": SPACING_FLOATING if floats else SPACING_GROUNDED, "halvings": halvings}
        narrow = NARROWER * low, NARROWER * high
        rule = lateral_rule(self.wavenumber, rounded_reach(reach), (low, high), mirror_width, narrow=narrow, **options)
        yield from self._branches_at(rule, distance)

    def plane(self, resolved: float) -> Iterator[Branch]:
        """Waves at k_y = 0, for fields that do not depend on y."""
        for branch in self._branches_at(PLANE, 0.0):
            if branch.signs[0][0] > 0:
                yield branch

    def static_motion(
        self, distance: np.ndarray, above: np.ndarray, below: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Zero: the modes contain the pole at k = 0."""
        return np.zeros_like(distance), np.zeros_like(distance)

    def _branches_at(self, rule: LateralRule, distance: float) -> Iterator[Branch]:
        """Waves to both sides at the nodes of a rule, without those that decay within ``distance`` (m)."""
        poles = self.poles_at(rule.nodes)
        for side in (1, -1):
            for sign in (1, -1):
                along, motion = [], []
                for each in poles:
                    # By reciprocity the poles at -k_y are those of the other direction, with transposed residues.
                    lasting = (each.right == (side * sign > 0)) & (each.surface | (not self.surface_only))
                    lasting &= -side * sign * each.wavenumbers.imag * distance < -np.log(NEGLIGIBLE)
                    along.append(side * sign * each.wavenumbers[lasting])
                    motion.append(-1j * side * sign * (each.column if sign > 0 else each.transposed)[lasting])
                count = max(len(each) for each in along)
                k, u = (np.full((count, len(poles)), -1j * self.wavenumber), np.zeros((3, count, len(poles)), complex))
                for node, (some, moved) in enumerate(zip(along, motion, strict=True)):
                    k[: len(some), node], u[:, : len(some), node] = some, moved.T
                yield Branch(side, rule, k, u, ((sign, np.ones(3)),))

    def poles_at(self, nodes) -> list[Poles]:
        """Modes at lateral wavenumbers ``nodes``, rad/m.

        The surface wave is followed from the first node on, so that nodes must be close together.
        """
        out, surface_wavenumber = [], self.wavenumber
        for node in np.asarray(nodes):
            if (key := complex(node)) not in self.known_poles:
                self.known_poles[key] = self._poles_at(node, surface_wavenumber)
            out.append(self.known_poles[key])
            surface_waves = out[-1].wavenumbers[out[-1].surface & out[-1].right]
            surface_wavenumber = next(iter(surface_waves), surface_wavenumber)
        return out

    def _poles_at(self, node: complex, surface_wavenumber: complex) -> Poles:
        """Modes at one k_y in rad/m, with the surface wave near its wavenumber."""
        lateral = max(abs(node), NEARLY_ZERO * self.wavenumber) * (node / abs(node) if node else 1.0)
        # On the complex contour a wave whose power leaves to the opposite side of its lateral phase grows along x
        # by Im k_y times the tangent of the angle of its power, which is 1 at this module's limit, 45 degrees.
        allowed = abs(np.imag(lateral)) + GROWTH * self.wavenumber
        return self.select_poles(*self.reduced.modes(lateral), surface_wavenumber, allowed * self.section.length_unit)

    def select_poles(self, k, shapes, left, carried, expected: complex, allowed: float) -> Poles:
        """Select the forward modes that do not decay within a wavelength (LOCAL), and the surface wave among them.

        A mode is right-going if its power flows to the right or, if it hardly propagates, if it decays to the right.
        By equation (1) the field of a unit load is sum_p v_p (l_p . e) / (k - k_p).  ``column`` of the result is the
        displacement in v_p times l_p . e; ``transposed``, for the response at -k_y, is v_p . e times that in l_p.

        The modes have wavenumbers ``k``, ``shapes`` in the reduced basis, left shapes ``left`` at the surface (4, m)
        and powers ``carried``.
        ``expected``: wavenumber of the surface wave at the k_y before; ``allowed``: largest growth in the direction of
        the power, radians per length unit.
        """
        section, unit = self.section, self.section.length_unit
        nearly_real = abs(k.imag) < NEARLY_REAL * abs(k.real)
        right = np.where(nearly_real, carried > 0, k.imag < 0)
        is_forward = ~nearly_real | (right == (k.real > 0))
        selected = is_forward & (abs(k.imag) < LOCAL * self.wavenumber * unit / (2 * np.pi))
        # beyond the disc of the reduced basis there are no waves, but artefacts of the basis, which may grow
        in_disc = abs(k) < SIZES[1] * self.wavenumber * unit
        growth = np.where(right, k.imag, -k.imag)
        selected &= growth < np.where(in_disc, allowed, 0.0)
        surface = np.zeros(len(k), dtype=bool)
        # in each direction: the most localised mode near the surface wave at the k_y before, and its twin in a plate
        for side in (right, ~right):
            distance = abs(k) / abs(expected * unit) - 1
            candidates = np.flatnonzero(side & nearly_real & selected)
            share = np.zeros(len(k))
            localised = section.surface_share(self.reduced.basis @ shapes[:, candidates])
            share[candidates] = weighed(localised, distance[candidates])
            best = np.argmax(share)
            surface |= (share > TWIN_SHARE * share[best]) & (abs(k / k[best] - 1) < TWIN_MODES)
        factors = np.ones((len(left), 1), dtype=complex)
        if section.solid.mirror_y is not None:  # fields that change sign under y -> -y are scaled by i
            factors[section.solid.mirror_y] = 1j
        shapes, left = factors * (self.reduced.surface @ shapes), factors.conj() * left
        scale, at = load_scale(section.solid, self.load), SURFACE_FIELDS.index(LOADED[self.load])
        column, transposed = scale * shapes[:3] * left[at], scale * shapes[at] * left[:3]
        return Poles(k[selected] / unit, right[selected], surface[selected], column.T[selected], transposed.T[selected])


def surface_unknowns(section: Section) -> list[int]:
    """Numbers of the unknowns u_x, u_y, u_z and, in a piezoelectric solid, phi at the surface."""
    return [section.surface_dofs[name] for name in SURFACE_FIELDS if name in section.surface_dofs]


class LateralPolynomials(NamedTuple):
    """Coefficients of K2, K1, K1t and K0 - omega^2 M as quadratic polynomials of k_y in rad/m."""

    coefficients: list[tuple]

    @classmethod
    def of(cls, section: Section, frequency: float, wavenumber: float) -> "LateralPolynomials":
        """Fit the polynomials of a section at a frequency in Hz, through k_y = 0 and plus and minus ``wavenumber``."""
        step = wavenumber * section.length_unit
        matrices = (section.lateral_matrices(frequency, sign * step) for sign in (-1, 0, 1))
        return cls(
            [
                (b, (c - a) / (2 * wavenumber), (a - 2 * b + c) / (2 * wavenumber**2))
                for a, b, c in zip(*matrices, strict=True)
            ]
        )

    def at(self, lateral: complex) -> list[np.ndarray]:
        """The four matrices at a lateral wavenumber in rad/m."""
        return [a + lateral * (b + lateral * c) for a, b, c in self.coefficients]

    def projected(self, basis: np.ndarray) -> "LateralPolynomials":
        """The polynomials projected on a basis."""
        return LateralPolynomials([tuple(basis.T @ each @ basis for each in parts) for parts in self.coefficients])

    def operator(self, along: complex, lateral: complex) -> np.ndarray:
        """L at a wave vector: k_x in radians per length unit, k_y in rad/m."""
        (second, _, _), (first, change, _), (adjoint, opposite, _), (zeroth, linear, square) = self.coefficients
        along = 1j * along
        return (zeroth - along**2 * second + along * (first - adjoint)) + lateral * (
            along * (change - opposite) + linear + lateral * square
        )


class LateralSection(NamedTuple):
    """Section at any lateral wavenumber, on a reduced basis.

    The basis is real, so that reciprocity and the sign of losses are kept.

    Attributes
    ----------
    basis : ndarray, shape (n, r)
        Columns over the n unknowns of the section, orthonormal.
    matrices : LateralPolynomials
        Matrices of the section, projected on the basis.
    surface : ndarray, shape (4, r)
        u_x, u_y, u_z and phi at the surface.
    odd : ndarray of bool, shape (r,), or None
        Parity of the columns under x -> -x, where that is a symmetry.
    opposite : bool
        True if y -> -y is a symmetry, so that k and -k are modes together.
    error : float
        Relative error of the response at wave vectors between those that made the basis.
    """

    basis: np.ndarray
    matrices: LateralPolynomials
    surface: np.ndarray
    odd: np.ndarray | None
    opposite: bool
    error: float

    def response(self, along: complex, lateral: complex) -> np.ndarray:
        """Fields at the surface for unit loads at the surface, (4, 4)."""
        return self.surface @ np.linalg.solve(self.matrices.operator(along, lateral), self.surface.T)

    def modes(self, lateral: complex) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Modes of both directions: k (m,), shapes (r, m), left shapes at the surface (4, m), powers (m,)."""
        second, first, adjoint, zeroth = self.matrices.at(lateral)
        if self.odd is not None:
            k, shapes = even_odd_modes(second, first - adjoint, zeroth, self.odd)
            k = np.append(k, -k)
            shapes = np.hstack([shapes, np.where(self.odd, -1.0, 1.0)[:, None] * shapes])
        else:
            solve = opposite_modes if self.opposite else companion_modes
            k, shapes = solve(second, 1j * (first - adjoint), zeroth)
        shapes = shapes / np.linalg.norm(shapes, axis=0) / np.maximum(1.0, abs(k))
        load = np.zeros((len(k), len(self.surface)), dtype=complex)
        load[len(second) :] = np.linalg.solve(second, self.surface.T)
        left = np.linalg.solve(np.vstack([shapes, shapes * k]), load).T
        flux = first @ shapes - 1j * (second @ shapes) * k
        return k, shapes, left, -np.imag(np.sum(flux * shapes.conj(), axis=0))

    def growing(self, lateral: float, surface_wavenumber: float) -> np.ndarray:
        """Real parts of the wavenumbers of modes that grow in the direction of their power.

        ``lateral``: k_y in rad/m; ``surface_wavenumber``: in radians per length unit.
        """
        k, _, _, carried = self.modes(lateral)
        grows = np.sign(carried) * k.imag > GROWTH * surface_wavenumber
        return k.real[grows & (abs(k.imag) < NEARLY_REAL * abs(k.real)) & (abs(k) < SIZES[1] * surface_wavenumber)]


def _reduced(section: Section, frequency: float, wavenumber: float, singular: float) -> LateralSection:
    """Reduce a section to the fields of unit loads on its surface at wave vectors within a disc.

    The number of wave vectors is doubled until the reduced response agrees with the section's at others between them.
    Responses at the wavenumbers of modes that grow are added until none does.
    """
    whole, surface, snapshots = LateralPolynomials.of(section, frequency, wavenumber), surface_unknowns(section), []
    loads, odd = np.eye(section.size)[:, surface], section.lateral_odd
    groups = [np.ones(section.size, dtype=bool)] if odd is None else [odd, ~odd]
    scale = wavenumber * np.exp(1j * BASIS_ANGLE)

    def vector(size: float, angle: float) -> tuple[complex, complex]:
        return size * scale * np.cos(angle) * section.length_unit, size * scale * np.sin(angle)

    trials = np.random.default_rng(0).uniform([TRIAL_SIZES[0], 0], [TRIAL_SIZES[1], np.pi], (TRIALS, 2))
    # with 3 instead of 5 the stated error of the shipped motor on YZ lithium niobate is ten times as large
    count, refinements = int(np.ceil(5 + np.ptp(section.breakpoints))), 0
    vectors = [vector(*each) for each in _polar_grid(count)]
    while True:
        for each in vectors:
            response = np.linalg.solve(whole.operator(*each), loads)
            response /= abs(response).max(axis=0)
            snapshots += [response.real, response.imag]
        columns = [_singular_vectors(np.hstack(snapshots), group, section, singular) for group in groups]
        basis = np.hstack(columns)
        parity = None if odd is None else np.arange(basis.shape[1]) < columns[0].shape[1]
        opposite = section.solid.mirror_y is not None
        reduced = LateralSection(basis, whole.projected(basis), basis[surface], parity, opposite, np.inf)
        largest_error = 0.0
        for trial in trials:
            true = np.linalg.solve(whole.operator(*vector(*trial)), loads)[surface]
            error = abs(reduced.response(*vector(*trial)) - true).max(axis=0) / abs(true).max(axis=0)
            largest_error = max(largest_error, float(error.max()))
        reduced = reduced._replace(error=largest_error)
        if basis.shape[1] > MAX_BASIS_SHARE * section.size:
            return reduced
        if largest_error >= 10 * singular:
            count *= 2
            vectors = [vector(*each) for each in _polar_grid(count)]
            continue
        lateral = NEARLY_ZERO * wavenumber
        growing = reduced.growing(lateral, wavenumber * section.length_unit)
        if not len(growing) or refinements == MAX_REFINEMENTS:
            return reduced
        vectors, refinements = [(each, lateral) for each in growing], refinements + 1


def _polar_grid(count: int) -> list[tuple[float, float]]:
    """Sizes over the surface wave's wavenumber, and angles in rad, of the wave vectors of a basis."""
    sizes = SIZES[0] + (SIZES[1] - SIZES[0]) * (np.arange(count) + 0.5) / count
    turns = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    return [
        (size, angle + (number % 3 + 0.5) / 3 * np.pi / DIRECTIONS)
        for number, size in enumerate(sizes)
        for angle in turns
    ]


def _singular_vectors(fields: np.ndarray, group: np.ndarray, section: Section, singular: float) -> np.ndarray:
    """Orthonormal basis of the columns of ``fields`` in a group of unknowns, truncated by singular values.

    It contains the constant potential if the section floats, because that is a mode at k = 0.
    """
    own, exact = fields[group], section.constant_potential[group, None] * section.floating_potential
    exact = exact[:, np.any(exact, axis=0)]
    exact = exact / np.linalg.norm(exact, axis=0)
    own = own - exact @ (exact.T @ own)
    triangular = np.asarray(np.linalg.qr(own.T, mode="r"))
    vectors, values, _ = np.linalg.svd(triangular.T, full_matrices=False)
    basis = np.hstack([exact, vectors[:, values > singular * values[0]]])
    out = np.zeros((len(fields), basis.shape[1]))
    out[group] = basis
    return out


def cut_source(fields: PortFields) -> CutSource:
    """Source of a solved stator; the section has the resolution of the solution, without layers for finger edges."""
    modes, resolution, stator = fields.modes, fields.resolution, fields.stator
    if stator.absorbs_below:  # every thickness stands for the same half-space
        stator = replace(stator, thickness=np.inf)
    section = discretise(
        stator,
        Resolution(
            order=max(resolution.order, ORDER), edge_layers=0, absorber=max(resolution.absorber, LAYER), vacuum=VACUUM
        ),
        wavelength=modes.section.length_unit,
        surface_scale=np.inf,
        lateral=True,
        least_depth=DEPTH,
    )
    wavenumber = float(np.mean(modes.wavenumbers[modes.rayleigh].real) / modes.section.length_unit)
    return CutSource(
        section=section,
        reduced=_reduced(section, modes.frequency, wavenumber, SINGULAR[resolution.absorber]),
        frequency=modes.frequency,
        wavenumber=wavenumber,
    )
