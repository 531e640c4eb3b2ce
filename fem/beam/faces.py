"""Waves reflected by free or clamped ends, the faces x = 0 and x = L, at each lateral wavenumber k_y.

At k_y the field of a bare stator 0 < x < L is that of an infinitely long one plus all guided modes of the section from
each face, with the amplitudes c (from x = 0, to the right) and d (from x = L, to the left),

    c = R_0 (b + E d),    d = R_L (a + E c),    E = diag exp(-i kappa_p L),                                     (1)

where a and b are the amplitudes at x = L and x = 0 of the waves that the charges excite, so that

    c = (1 - R_0 E R_L E)^-1 R_0 (b + E R_L a).                                                                 (2)

The reflection matrix R of a face follows from its condition on the nodal fluxes or the displacements
(end_conditions.py).  For k_y != 0 a face couples sagittal and shear-horizontal (SH) modes, so that the section has all
three displacements.

In a solid isotropic about z the modes at k_y are those at k_y = 0, rotated.  With g = u_s / k, the displacement along
the wave vector over its length, e = (u_z, phi), and w the displacement of an SH mode,

    sagittal   u_x = kappa g,    u_y = k_y g,     (u_z, phi) = e,        kappa^2 = k^2 - k_y^2,
    SH         u_x = -k_y w,     u_y = kappa w,   (u_z, phi) = 0.                                               (3)

The nodal flux of a mode on a line x = const is K1(k_y) v - i kappa K2 v, with K1(k_y) = K1 + k_y K1'.  Let the indices
0, 1 and 2 denote the unknowns of u_x, of u_y / i and of (u_z, phi).  By symmetry K1 couples 0 with 2, K1' couples 0
with 1, and K2 couples none of them.  Inserting (3), and kappa^2 where it appears, leaves

                sagittal                                          SH
    flux_0      K1_02 e - i k^2 K2_00 g  + k_y^2 X_0 g            kappa k_y X_0 w
    flux_1      kappa k_y X_1 g                                   -k^2 K2_11 w  - k_y^2 X_1 w
    flux_2      kappa (K1_20 g - i K2_22 e)                       -k_y K1_20 w                                  (4)

with X_0 = i K2_00 - i K1'_01 and X_1 = K1'_10 - K2_11.

The response has poles on or near the real axis of k_y, where 2 kappa L plus the phases of both reflections is a
multiple of 2 pi (a resonance).  The contour of lateral.py stays at the distance D from them except near the origin.  A
lossless stator in resonance at k_y = 0 has no solution; with loss the poles are at least k / Q^(1/2) from the origin.
All modes use the contour of forward modes.  A propagating backward mode would be on the wrong sheet of the square root
beyond its own k.  If the section is not grounded, the reflected part of the pole at k = 0 depends on |k_y| and is not
analytic at k_y = 0.  The error of the quadrature is less than this part, which is 1e-5 to 5e-5 of the amplitude on
Feenstra and Breedveld's stator.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fem.beam.beam_of_charges import ChargeSheet
from fem.beam.lateral import (
    PLANE,
    LateralRule,
    evanescent,
    highest_wavenumber,
    lateral_rule,
    rounded_reach,
    wavenumber_along,
)
from fem.beam.line_source import NEGLIGIBLE, SIGNS, LineSource, load_scale, shear_modes, static_mode
from fem.discretize.depth_mesh import discretise
from fem.discretize.section import Section
from fem.waveguide.end_conditions import end_reflection
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.port_fields import PortFields

# k_y over the largest wavenumber that replaces k_y = 0, where the constant potential is a double root.
NEARLY_ZERO = 1e-8


class ExcitedModes(NamedTuple):
    """Modes of the section at one k_y, and the amplitudes to the right and left that 1 C/m on a line excites."""

    modes: GuidedModes
    right: np.ndarray
    left: np.ndarray


class ReflectedWaves(NamedTuple):
    """Waves reflected by the faces, at the nodes of a quadrature rule for the lateral wavenumber.

    Attributes
    ----------
    rule : LateralRule
    along : ndarray, shape (2, modes, n)
        Wavenumbers in rad/m: the waves from x = 0 and from x = L change as exp(-i along distance).
    motion : ndarray, shape (2, 3, sources, modes, n)
        u_x, u_y, u_z on the surface at the face, m per volt and unit of a source's spectrum.
    signs : tuple
        As in `Branch`.
    """

    rule: LateralRule
    along: np.ndarray
    motion: np.ndarray
    signs: tuple

    def spectra(self, x: np.ndarray, length: float, spectra: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Spectra of u at positions x, shape (positions, 3, n), for the spectra of the sources, (sources, n).

        ``modes`` selects the modes of the sum.
        """
        out = np.zeros((len(x), 3, len(self.rule.nodes)), dtype=complex)
        for distance, along, motion in zip((x, length - x), self.along, self.motion, strict=True):
            lasting = modes & ((-along.imag).min(axis=1) * distance.min() < -np.log(NEGLIGIBLE))
            motion = np.einsum("ctmn,tn->nmc", motion[:, :, lasting], spectra)
            for node, started in enumerate(motion):
                out[..., node] += np.exp(-1j * np.outer(distance, along[lasting, node])) @ started
        return out


@dataclass(frozen=True, kw_only=True)
class Faces:
    """Two reflecting ends of a stator.

    Attributes
    ----------
    length : float
        Length of the stator, m.
    ends : str
        "free" or "clamped".
    highest : float
        Largest wavenumber of a propagating mode, rad/m.
    surface, static, included : ndarray of bool, shape (modes,)
        True for the modes of the surface wave, for the pole at k = 0, and for the modes included in the field.
    at : callable
        Returns `ExcitedModes` for k_y in rad/m.
    """

    length: float
    ends: str
    highest: float
    surface: np.ndarray = field(repr=False)
    static: np.ndarray = field(repr=False)
    included: np.ndarray = field(repr=False)
    at: Callable[[complex], ExcitedModes] = field(repr=False)
    _known: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def surface_mode(self) -> "Faces":
        """The same faces with the surface wave alone in the field."""
        return replace(self, included=self.surface)

    def reflected(self, reach: float, sources: list[ChargeSheet], mirror_width: float | None) -> ReflectedWaves:
        """Reflected waves of sources, for points within a lateral reach in m."""
        fade = evanescent(self.highest, self._gap(sources))
        return self._at_nodes(lateral_rule(self.highest, rounded_reach(reach), fade, mirror_width), sources)

    def plane(self, sources: list[ChargeSheet]) -> ReflectedWaves:
        """Reflected waves at k_y = 0, for fields that do not depend on y."""
        return self._at_nodes(PLANE, sources)

    def _gap(self, sources: list[ChargeSheet]) -> float:
        """Smallest distance between a face and a charge, m."""
        return min(min(each.x.min(), self.length - each.x.max()) for each in sources)

    def _at_nodes(self, rule: LateralRule, sources: list[ChargeSheet]) -> ReflectedWaves:
        key = rule.nodes.tobytes(), *(each.tobytes() for source in sources for each in (source.x, source.charge))
        if key not in self._known:
            gap = self._gap(sources)
            by_node = [self._at_node(lateral, sources, gap) for lateral in rule.nodes]
            along, motion = (np.stack(each, axis=-1) for each in zip(*by_node, strict=True))
            self._known[key] = ReflectedWaves(rule, along, motion, SIGNS)
        return self._known[key]

    def _at_node(self, lateral: complex, sources: list[ChargeSheet], gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Wavenumbers (2, modes) and motion (2, 3, sources, modes) of the reflected waves.

        Equation (2) is solved for the modes that do not decay before they reach a face (``lasting``); each face then
        reflects these into all modes.
        """
        if abs(lateral) < NEARLY_ZERO * self.highest:
            lateral = NEARLY_ZERO * self.highest
        modes, to_right, to_left = self.at(lateral)
        forward, backward = (each / modes.section.length_unit for each in (modes.wavenumbers, -modes.backwards))
        lasting = np.flatnonzero(np.minimum(-forward.imag, -backward.imag) * gap < -np.log(NEGLIGIBLE))
        a, b = (
            amplitudes[lasting, None] * np.stack([each.transform(k[lasting], face) for each in sources], axis=1)
            for amplitudes, k, face in ((to_right, forward, self.length), (to_left, -backward, 0.0))
        )
        r_0 = end_reflection(modes, self.ends, 0, lasting)
        mirror_images = modes.section.full.lateral_odd is not None
        r_l = r_0 if mirror_images else end_reflection(modes, self.ends, 1, lasting)
        # E of the waves to the right and to the left, whose wavenumbers differ without mirror symmetry
        e_right, e_left = (np.exp(-1j * each[lasting] * self.length)[:, None] for each in (forward, backward))
        round_trip = r_0[lasting] @ (e_left * r_l[lasting]) * e_right[:, 0]
        c = np.linalg.solve(np.eye(len(lasting)) - round_trip, r_0[lasting] @ (b + e_left * (r_l[lasting] @ a)))  # (2)
        from_right = r_l @ (a + e_right * c)  # (1), all modes
        from_left = r_0 @ (b + e_left * from_right[lasting])
        on_surface = [modes.section.full.surface_dofs[name] for name in ("ux", "uy", "uz")]
        # Where y -> -y is a symmetry the unknown of u_y is u_y / i.
        factors = np.array([1.0, 1.0 if modes.section.solid.mirror_y is None else 1j, 1.0])[:, None]
        motion = [
            (factors * shapes[on_surface])[:, None] * amplitudes.T
            for shapes, amplitudes in ((modes.right, from_left), (modes.left, from_right))
        ]
        return np.stack([forward, backward]), np.stack(motion)


def faces(fields: PortFields, modes: GuidedModes, source: LineSource) -> Faces:
    """Reflecting ends of a stator whose solid is isotropic about z, from the solution of its section.

    ``modes``: all those of the section, and ``source`` excites them.
    """
    stator = fields.stator
    modes_at = _rotated_modes(fields, modes, source)
    surface = np.zeros(len(modes_at.wavenumbers), dtype=bool)
    surface[modes.rayleigh] = True
    return Faces(
        length=stator.length,
        ends=stator.ends,
        highest=highest_wavenumber(modes_at.wavenumbers) / modes_at.section.length_unit,
        surface=surface,
        static=modes_at.wavenumbers == 0,
        included=np.ones_like(surface),
        at=modes_at,
    )


@dataclass(frozen=True, kw_only=True)
class _RotatedModes:
    """Modes at any k_y of a section isotropic about z, as many as unknowns, n: first ``count`` sagittal, then SH."""

    section: Section
    frequency: float
    count: int
    wavenumbers: np.ndarray  # (n,), at k_y = 0
    sent: np.ndarray  # (n,): k times the amplitude that 1 C/m excites at k_y = 0
    kinds: np.ndarray  # (n,): index of each unknown in equation (4), 0 for u_x, 1 for u_y / i, 2 for u_z and phi
    # (n, n) each, unknowns by modes.  ``shapes``: g or w on the unknowns of u_x and of u_y, and e, all at k_y = 0.
    # ``flux``: the fluxes (4) without their factors kappa and k_y.  ``by_square``: their coefficient of k_y^2.
    shapes: np.ndarray
    flux: np.ndarray
    by_square: np.ndarray

    def __call__(self, lateral: complex) -> ExcitedModes:
        section = self.section
        k, k_y, sagittal = (self.wavenumbers, lateral * section.length_unit, np.arange(section.size) < self.count)
        kappa = wavenumber_along(k, k_y)
        # factors of equations (3) and (4), (kinds, modes)
        of_shapes = [np.where(sagittal, kappa, -k_y), -1j * np.where(sagittal, k_y, kappa), np.ones_like(kappa)]
        of_flux = [np.where(sagittal, one, other) for one, other in ((1, kappa * k_y), (kappa * k_y, 1), (kappa, k_y))]
        right = np.array(of_shapes)[self.kinds] * self.shapes
        right_flux = np.array(of_flux)[self.kinds] * self.flux + k_y**2 * self.by_square
        left, left_flux = right.copy(), -right_flux
        for each in (left, left_flux):
            each[section.lateral_odd] *= -1
        modes = GuidedModes(
            section=section,
            frequency=self.frequency,
            wavenumbers=kappa,
            backwards=-kappa,
            right=right,
            left=left,
            right_flux=right_flux,
            left_flux=left_flux,
            lateral_wavenumber=k_y,
        )
        return ExcitedModes(modes, self.sent / kappa, self.sent / kappa)


def _rotated_modes(fields: PortFields, plane: GuidedModes, source: LineSource) -> _RotatedModes:
    """Modes of a section with all displacements, from the sagittal modes of its solution at k_y = 0.

    Sagittal modes are those of the solution, the SH modes those of `shear_modes`.  The fluxes are those of equation
    (4).
    """
    section = with_all_displacements(fields)
    k2, k1, _, _ = section.lateral_matrices(fields.frequency, 0.0)
    k1_prime = section.lateral_matrices(fields.frequency, 1.0)[1] - k1
    u_x, u_y, u_z, phi = (column[column >= 0] for column in section.dofs.T)
    tangential, _, normal, potential = (column[column >= 0] for column in plane.section.full.dofs.T)
    shear_wavenumbers, w = shear_modes(section, fields.frequency)
    moving, count = plane.wavenumbers != 0, plane.section.size
    k = np.append(plane.wavenumbers, shear_wavenumbers)
    g = plane.right / np.where(moving, k[:count], 1.0)
    e = plane.right.copy()
    sent = np.zeros(section.size, dtype=complex)
    sent[:count][moving] = source.amplitudes * k[:count][moving]
    if not moving.all():  # the constant potential, k = 0: the limits of g and of k times the amplitude
        slope, motion = static_mode(plane)
        g[:, ~moving], e[:, ~moving] = -1j * motion[:, None], plane.section.constant_potential[:, None]
        sent[:count][~moving] = 1j * slope * load_scale(section.solid, "charge")
    shapes = np.zeros((section.size, section.size), dtype=complex)
    for of_field in (u_x, u_y):
        shapes[of_field, :count], shapes[of_field, count:] = g[tangential], w
    shapes[u_z, :count], shapes[phi, :count] = e[normal], e[potential]
    kinds = np.full(section.size, 2)
    kinds[u_x], kinds[u_y] = 0, 1

    def product(matrix, to: int, of: int) -> np.ndarray:
        """Block of a matrix from unknowns of kind ``of`` to those of kind ``to``, times the shapes on the former."""
        return matrix[np.ix_(kinds == to, kinds == of)] @ shapes[kinds == of]

    # equation (4); the product X_0 g in the columns of sagittal modes is X_0 w in those of SH modes
    flux, by_square = np.zeros_like(shapes), np.zeros_like(shapes)
    sagittal = np.arange(section.size) < count
    x_0 = 1j * product(k2, 0, 0) - 1j * product(k1_prime, 0, 1)
    x_1 = product(k1_prime, 1, 0) - product(k2, 1, 1)
    flux[kinds == 0] = np.where(sagittal, product(k1, 0, 2) - 1j * k**2 * product(k2, 0, 0), x_0)
    by_square[kinds == 0] = np.where(sagittal, x_0, 0)
    flux[kinds == 1] = np.where(sagittal, x_1, -(k**2) * product(k2, 1, 1))
    by_square[kinds == 1] = np.where(sagittal, 0, -x_1)
    flux[kinds == 2] = np.where(sagittal, product(k1, 2, 0) - 1j * product(k2, 2, 2), -product(k1, 2, 0))
    return _RotatedModes(
        section=section,
        frequency=fields.frequency,
        count=count,
        wavenumbers=k,
        sent=sent,
        kinds=kinds,
        shapes=shapes,
        flux=flux,
        by_square=by_square,
    )


def with_all_displacements(fields: PortFields) -> Section:
    """Section of a solution with u_y as an additional unknown, which is uncoupled at k_y = 0."""
    return discretise(
        fields.stator,
        fields.resolution,
        wavelength=fields.section.length_unit,
        surface_scale=fields.section.full.surface_scale,
        lateral=True,
    )
