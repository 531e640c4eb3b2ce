"""Waves reflected by free or clamped ends, the faces x = 0 and x = L, at each lateral wavenumber k_y.

At k_y the field of a bare stator 0 < x < L is that of an infinitely long one plus all guided modes of the section from
each face, with the amplitudes c (from x = 0, to the right) and d (from x = L, to the left),

    c = R_0 (b + E d),    d = R_L (a + E c),    E = diag exp(-i kappa_p L),

where a and b are the amplitudes at x = L and x = 0 of the waves that the charges excite.  The reflection matrix R of a
face follows from its condition on the nodal fluxes or the displacements (ends.py).  For k_y != 0 a face couples
sagittal and shear-horizontal (SH) modes, so that the section has all three displacements.

In a solid isotropic about z the modes at k_y are those at k_y = 0, rotated.  With g = u_s / k, the displacement along
the wave vector over its length, a sagittal mode has u_x = kappa g and u_y = k_y g; an SH mode w has u_x = -k_y w and
u_y = kappa w.

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

from fem.beam.electrode_charges import ChargeSheet
from fem.beam.lateral import (
    PLANE,
    LateralRule,
    evanescent,
    highest_wavenumber,
    lateral_rule,
    rounded_reach,
    wavenumber_along,
)
from fem.beam.line_source import KEPT, SIGNS, LineSource, load_scale, shear_modes, static_mode
from fem.discretize.depth_mesh import discretise
from fem.discretize.section import Section
from fem.waveguide.ends import end_reflection
from fem.waveguide.modes import GuidedModes
from fem.waveguide.port_fields import PortFields

# k_y over the largest wavenumber that replaces k_y = 0, where the constant potential is a double root.
NEARLY_ZERO = 1e-8


class Sent(NamedTuple):
    """Modes of the section at one k_y, and the amplitudes to the right and left that 1 C/m on a line excites."""

    modes: GuidedModes
    right: np.ndarray
    left: np.ndarray


class Returned(NamedTuple):
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
            lasting = modes & ((-along.imag).min(axis=1) * distance.min() < -np.log(KEPT))
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
    surface, static, wanted : ndarray of bool, shape (modes,)
        True for the modes of the surface wave, for the pole at k = 0, and for the modes included in the field.
    at : callable
        Returns `Sent` for k_y in rad/m.
    """

    length: float
    ends: str
    highest: float
    surface: np.ndarray = field(repr=False)
    static: np.ndarray = field(repr=False)
    wanted: np.ndarray = field(repr=False)
    at: Callable[[complex], Sent] = field(repr=False)
    _known: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def surface_mode(self) -> "Faces":
        """The same faces with the surface wave alone in the field."""
        return replace(self, wanted=self.surface)

    def returned(self, reach: float, sources: list[ChargeSheet], mirror_width: float | None) -> Returned:
        """Reflected waves of sources, for points within a lateral reach in m."""
        fade = evanescent(self.highest, self._gap(sources))
        return self._at_nodes(lateral_rule(self.highest, rounded_reach(reach), fade, mirror_width), sources)

    def plane(self, sources: list[ChargeSheet]) -> Returned:
        """Reflected waves at k_y = 0, for fields that do not depend on y."""
        return self._at_nodes(PLANE, sources)

    def _gap(self, sources: list[ChargeSheet]) -> float:
        """Smallest distance between a face and a charge, m."""
        return min(min(each.x.min(), self.length - each.x.max()) for each in sources)

    def _at_nodes(self, rule: LateralRule, sources: list[ChargeSheet]) -> Returned:
        key = rule.nodes.tobytes(), *(each.tobytes() for source in sources for each in (source.x, source.charge))
        if key not in self._known:
            gap = self._gap(sources)
            by_node = [self._at_node(lateral, sources, gap) for lateral in rule.nodes]
            along, motion = (np.stack(each, axis=-1) for each in zip(*by_node, strict=True))
            self._known[key] = Returned(rule, along, motion, SIGNS)
        return self._known[key]

    def _at_node(self, lateral: complex, sources: list[ChargeSheet], gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Wavenumbers (2, modes) and motion (2, 3, sources, modes) of the reflected waves.

        The equations of the module docstring are solved for c = (1 - R_0 E R_L E)^-1 R_0 (b + E R_L a) on the modes
        that do not decay before they reach a face (``kept``); each face then reflects these into all modes.
        """
        if abs(lateral) < NEARLY_ZERO * self.highest:
            lateral = NEARLY_ZERO * self.highest
        modes, to_right, to_left = self.at(lateral)
        forward, backward = (each / modes.section.length_unit for each in (modes.wavenumbers, -modes.backwards))
        kept = np.flatnonzero(np.minimum(-forward.imag, -backward.imag) * gap < -np.log(KEPT))
        # a and b
        at_right, at_left = (
            amplitudes[kept, None] * np.stack([each.transform(k[kept], place) for each in sources], axis=1)
            for amplitudes, k, place in ((to_right, forward, self.length), (to_left, -backward, 0.0))
        )
        left = end_reflection(modes, self.ends, 0, kept)
        alike = modes.section.lateral_odd is not None
        right = left if alike else end_reflection(modes, self.ends, 1, kept)
        across, back = (np.exp(-1j * each[kept] * self.length)[:, None] for each in (forward, backward))
        round_trip = left[kept] @ (back * right[kept]) * across[:, 0]
        first_pass = left[kept] @ (at_left + back * (right[kept] @ at_right))
        from_left = np.linalg.solve(np.eye(len(kept)) - round_trip, first_pass)
        from_right = right @ (at_right + across * from_left)
        from_left = left @ (at_left + back * from_right[kept])
        rows = [modes.section.surface_dofs[name] for name in ("ux", "uy", "uz")]
        # Where y -> -y is a symmetry the unknown of u_y is u_y / i.
        factors = np.array([1.0, 1.0 if modes.section.solid.mirror_y is None else 1j, 1.0])[:, None]
        motion = [
            (factors * shapes[rows])[:, None] * amplitudes.T
            for shapes, amplitudes in ((modes.right, from_left), (modes.left, from_right))
        ]
        return np.stack([forward, backward]), np.stack(motion)


def faces(fields: PortFields, source: LineSource) -> Faces:
    """Reflecting ends of a stator whose solid is isotropic about z, from the solution of its section."""
    stator = fields.stator
    turned = _turned_modes(fields, source)
    surface = np.zeros(len(turned.wavenumbers), dtype=bool)
    surface[fields.modes.rayleigh] = True
    return Faces(
        length=stator.length,
        ends=stator.ends,
        highest=highest_wavenumber(turned.wavenumbers) / turned.section.length_unit,
        surface=surface,
        static=turned.wavenumbers == 0,
        wanted=np.ones_like(surface),
        at=turned,
    )


@dataclass(frozen=True, kw_only=True)
class _TurnedModes:
    """Modes at any k_y of a section isotropic about z, as many as unknowns, n: first ``count`` sagittal, then SH."""

    section: Section
    frequency: float
    count: int
    wavenumbers: np.ndarray  # (n,), at k_y = 0
    sent: np.ndarray  # (n,): k times the amplitude that 1 C/m excites at k_y = 0
    kinds: np.ndarray  # (n,): kind of each unknown, 0 for u_x, 1 for u_y (over i), 2 for u_z and phi
    # (n, n) each, unknowns by modes.  ``shapes``: u_s / k on the unknowns of u_x and of u_y, and u_z and phi, all at
    # k_y = 0.  ``flux``: nodal fluxes without their factors kappa and k_y.  ``by_square``: their coefficient of k_y^2.
    shapes: np.ndarray
    flux: np.ndarray
    by_square: np.ndarray

    def __call__(self, lateral: complex) -> Sent:
        section = self.section
        k, k_y, sagittal = (self.wavenumbers, lateral * section.length_unit, np.arange(section.size) < self.count)
        kappa = wavenumber_along(k, k_y)
        turned = [np.where(sagittal, kappa, -k_y), -1j * np.where(sagittal, k_y, kappa), np.ones_like(kappa)]
        right = np.array(turned)[self.kinds] * self.shapes
        of_flux = [np.where(sagittal, one, other) for one, other in ((1, kappa * k_y), (kappa * k_y, 1), (kappa, k_y))]
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
        return Sent(modes, self.sent / kappa, self.sent / kappa)


def _turned_modes(fields: PortFields, source: LineSource) -> _TurnedModes:
    """Modes of a section with all displacements, from the sagittal modes of its solution at k_y = 0.

    Sagittal modes are those of the solution, the SH modes those of `shear_modes`.  The nodal flux at k_y is
    K1(k_y) v - i kappa K2 v with K1(k_y) = K1 + k_y K1', ``first`` and ``by_k_y``.  Inserting v of the module docstring
    and kappa^2 = k^2 - k_y^2 leaves, for each kind of unknown and of mode, a factor 1, kappa, k_y or kappa k_y times a
    fixed vector, ``flux``, and a part in k_y^2, ``by_square``.
    """
    plane, section = fields.modes, with_all_displacements(fields)
    second, first, _, _ = section.lateral_matrices(fields.frequency, 0.0)
    by_k_y = section.lateral_matrices(fields.frequency, 1.0)[1] - first
    u_x, u_y, u_z, phi = (column[column >= 0] for column in section.dofs.T)
    tangential, _, normal, potential = (column[column >= 0] for column in plane.section.dofs.T)
    of_shear, shear = shear_modes(section, fields.frequency)
    moving, count = plane.wavenumbers != 0, plane.section.size
    k = np.append(plane.wavenumbers, of_shear)
    lines = plane.right / np.where(moving, k[:count], 1.0)
    even = plane.right.copy()
    sent = np.zeros(section.size, dtype=complex)
    sent[:count][moving] = source.amplitudes * k[:count][moving]
    if not moving.all():
        slope, motion = static_mode(plane)
        lines[:, ~moving], even[:, ~moving] = -1j * motion[:, None], plane.section.constant_potential[:, None]
        sent[:count][~moving] = 1j * slope * load_scale(section.solid, "charge")
    shapes = np.zeros((section.size, section.size), dtype=complex)
    for of_field in (u_x, u_y):
        shapes[of_field, :count], shapes[of_field, count:] = lines[tangential], shear
    shapes[u_z, :count], shapes[phi, :count] = even[normal], even[potential]
    kinds = np.full(section.size, 2)
    kinds[u_x], kinds[u_y] = 0, 1

    def product(matrix, to: int, of: int) -> np.ndarray:
        """Rows of kind ``to`` and columns of kind ``of`` of a matrix, times the shapes on the unknowns ``of``."""
        return matrix[np.ix_(kinds == to, kinds == of)] @ shapes[kinds == of]

    # the nodal flux K1(k_y) v - i kappa K2 v, with kappa^2 = k^2 - k_y^2
    flux, by_square = np.zeros_like(shapes), np.zeros_like(shapes)
    sagittal = np.arange(section.size) < count
    crossed = (1j * product(second, 0, 0) - 1j * product(by_k_y, 0, 1), product(by_k_y, 1, 0) - product(second, 1, 1))
    flux[kinds == 0] = np.where(sagittal, product(first, 0, 2) - 1j * k**2 * product(second, 0, 0), crossed[0])
    by_square[kinds == 0] = np.where(sagittal, crossed[0], 0)
    flux[kinds == 1] = np.where(sagittal, crossed[1], -(k**2) * product(second, 1, 1))
    by_square[kinds == 1] = np.where(sagittal, 0, -crossed[1])
    flux[kinds == 2] = np.where(sagittal, product(first, 2, 0) - 1j * product(second, 2, 2), -product(first, 2, 0))
    return _TurnedModes(
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
        surface_scale=min((each.finger_width / 2 for each in fields.transducers), default=np.inf),
        lateral=True,
    )
