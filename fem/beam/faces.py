"""Free and clamped ends as faces x = 0 and x = L in three dimensions: what they send back at each lateral wavenumber.

At a lateral wavenumber k_y the fields of a strip 0 < x < L of the bare stator are those of the endless one and, from
each face, all guided modes of the section with the amplitudes c (from x = 0, to the right) and d (from x = L),

    c = R_0 (b + E d),    d = R_L (a + E c),    E = diag exp(-i kappa_p L),

a and b the amplitudes with which the charges' own waves arrive.  A face's reflection matrix R follows from its
condition on the nodal fluxes or the displacements (ends.py).  Sagittal and shear horizontal modes (SH) mix there as
soon as k_y differs from zero, so that the section has all three displacements.

In a solid isotropic about z the modes at k_y are those of k_y = 0, turned: with g = u_s / k, the displacement along the
wave vector over its length, u_x = kappa g and u_y = k_y g; an SH mode w has u_x = -k_y w and u_y = kappa w.

The strip's response has its poles on or near the real axis of k_y, where 2 kappa L and the phases of both faces are a
multiple of 2 pi.  The contour keeps its distance D but near the origin: a lossless strip in resonance at k_y = 0 has no
answer, with loss the poles are k / Q^(1/2) or more from there.  All modes take the contour of those whose phase runs
along their power: a mode with phase and power opposed that propagates would be on the wrong sheet beyond its own k.
Where nothing grounds the section, what the faces send back of the pole at k = 0 depends on |k_y|: the rule's error is
less than this part (1e-5 to 5e-5 of the amplitude on Feenstra and Breedveld's stator).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import LateralRule, evanescent, lateral_rule
from fem.beam.line_source import KEPT, SIGNS, LineSource, charge_scale, static_mode
from fem.discretize.elements import discretise
from fem.discretize.section import Section
from fem.waveguide.ends import end_reflection
from fem.waveguide.modes import GuidedModes
from fem.waveguide.port_fields import PortFields

NEARLY_ZERO = (
    1e-8  # of the largest wavenumber: k_y in the place of 0, which makes the constant potential a double root
)
SAME_STEP = 1e-15  # m: steps from charge to charge that differ by less share their phases
ROUNDING = 1e-9  # |Im k| / |k| of a mode without loss


class Sent(NamedTuple):
    """Modes of the section at one k_y, and their amplitudes to the right and to the left from 1 C/m on a line."""

    modes: GuidedModes
    right: np.ndarray
    left: np.ndarray


class Returned(NamedTuple):
    """Waves that come back from the faces at the nodes of a rule for the lateral wavenumber.

    Attributes
    ----------
    rule : LateralRule
    along : ndarray, shape (2, modes, n)
        rad/m: from x = 0 and from x = L they change as exp(-i along distance).
    motion : ndarray, shape (2, 3, sources, modes, n)
        u_x, u_y, u_z at the surface where they start, m per volt and unit of a source's spectrum.
    signs : tuple
        As of `Branch`.
    """

    rule: LateralRule
    along: np.ndarray
    motion: np.ndarray
    signs: tuple

    def spectra(self, x: np.ndarray, length: float, spectra: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Spectra of u at places x, shape (places, 3, n), of some modes, for those of the sources, (sources, n)."""
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
        Of the stator, m.
    ends : str
        "free" or "clamped".
    highest : float
        Largest wavenumber of a propagating mode, rad/m.
    surface, static, wanted : ndarray of bool, shape (modes,)
        Which modes are the surface wave, the pole at k = 0, and which count.
    at : callable
        From k_y in rad/m to `Sent`.
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
        """The surface wave alone."""
        return replace(self, wanted=self.surface)

    def returned(self, reach: float, sources: list, mirror_width: float | None) -> Returned:
        """Waves that come back, of sources (places and charges each) and for points up to a lateral reach in m."""
        reach = 2.0 ** (np.ceil(2 * np.log2(reach)) / 2)  # so that few rules are needed
        rule = lateral_rule(self.highest, reach, evanescent(self.highest, self._gap(sources)), mirror_width)
        return self._at_nodes(rule, sources)

    def plane(self, sources: list) -> Returned:
        """Waves that do not depend on y."""
        return self._at_nodes(LateralRule(nodes=np.zeros(1), weights=np.ones(1)), sources)

    def _gap(self, sources: list) -> float:
        """Distance between a face and the charge next to it, m."""
        return min(min(x.min(), self.length - x.max()) for x, _ in sources)

    def _at_nodes(self, rule: LateralRule, sources: list) -> Returned:
        key = rule.nodes.tobytes(), *(each.tobytes() for source in sources for each in source)
        if key not in self._known:
            gap = self._gap(sources)
            found = [self._at_node(lateral, sources, gap) for lateral in rule.nodes]
            along, motion = (np.stack(each, axis=-1) for each in zip(*found, strict=True))
            self._known[key] = Returned(rule, along, motion, SIGNS)
        return self._known[key]

    def _at_node(self, lateral: complex, sources: list, gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Wavenumbers (2, modes) and motion (2, 3, sources, modes) of what comes back."""
        if abs(lateral) < NEARLY_ZERO * self.highest:
            lateral = NEARLY_ZERO * self.highest
        modes, to_right, to_left = self.at(lateral)
        forward, backward = (
            each / modes.section.length_unit for each in (modes.wavenumbers, -modes.backwards)
        )
        kept = np.flatnonzero(np.minimum(-forward.imag, -backward.imag) * gap < -np.log(KEPT))
        at_right, at_left = (
            sent[kept, None] * np.stack([_arriving(k[kept], *each) for each in seen], axis=1)
            for sent, k, seen in (
                (to_right, forward, [(self.length - x[::-1], charge[::-1]) for x, charge in sources]),
                (to_left, backward, sources),
            )
        )
        left = end_reflection(modes, self.ends, 0, kept)
        alike = modes.section.lateral_odd is not None
        right = left if alike else end_reflection(modes, self.ends, 1, kept)
        across, back = (np.exp(-1j * each[kept] * self.length)[:, None] for each in (forward, backward))
        round_trip = left[kept] @ (back * right[kept]) * across[:, 0]
        once = left[kept] @ (at_left + back * (right[kept] @ at_right))
        from_left = np.linalg.solve(np.eye(len(kept)) - round_trip, once)
        from_right = right @ (at_right + across * from_left)
        from_left = left @ (at_left + back * from_right[kept])
        rows = [modes.section.surface_dofs[name] for name in ("ux", "uy", "uz")]
        turn = np.array([1.0, 1.0 if modes.section.solid.mirror_y is None else 1j, 1.0])[
            :, None
        ]  # of u_y / i
        motion = [
            (turn * shapes[rows])[:, None] * amplitudes.T
            for shapes, amplitudes in ((modes.right, from_left), (modes.left, from_right))
        ]
        return np.stack([forward, backward]), np.stack(motion)


def _arriving(k: np.ndarray, x: np.ndarray, charge: np.ndarray) -> np.ndarray:
    """Sum of q_j exp(-i k x_j) for increasing x_j, most of which are equal steps apart, shape of k."""
    steps, which = np.unique(np.round(np.diff(x, prepend=0.0) / SAME_STEP), return_inverse=True)
    return np.cumprod(np.exp(-1j * np.outer(k, steps * SAME_STEP))[:, which], axis=1) @ charge


def faces(fields: PortFields, source: LineSource) -> Faces:
    """Reflecting ends of a stator whose solid is isotropic about z, from the solution of its section."""
    stator = fields.stator
    turned = _turned_modes(fields, source)
    surface = np.zeros(len(turned.wavenumbers), dtype=bool)
    surface[fields.modes.rayleigh] = True
    return Faces(
        length=stator.length,
        ends=stator.ends,
        highest=float(np.sqrt((turned.wavenumbers**2).real.max())) / turned.section.length_unit,
        surface=surface,
        static=turned.wavenumbers == 0,
        wanted=np.ones_like(surface),
        at=turned,
    )


@dataclass(frozen=True, kw_only=True)
class _TurnedModes:
    """Modes at any k_y of a section isotropic about z: ``count`` sagittal ones, then SH; as many as unknowns, n."""

    section: Section
    frequency: float
    count: int
    wavenumbers: np.ndarray  # (n,), at k_y = 0
    sent: np.ndarray  # (n,): k times the amplitude that 1 C/m sends at k_y = 0
    kinds: np.ndarray  # (n,): of the unknowns: 0 for u_x, 1 for u_y (over i), 2 for u_z and phi
    # (n, n): u_s / k at k_y = 0 on the unknowns of u_x and of u_y, u_z and phi; fluxes but for factors of kappa and
    # k_y; what k_y^2 adds to them
    shapes: np.ndarray
    flux: np.ndarray
    by_square: np.ndarray

    def __call__(self, lateral: complex) -> Sent:
        section = self.section
        k, k_y, sagittal = (
            self.wavenumbers,
            lateral * section.length_unit,
            np.arange(section.size) < self.count,
        )
        kappa = np.where(k.real < 0, -1, 1) * np.sqrt(k**2 - k_y**2)
        kappa[kappa.imag > ROUNDING * abs(kappa)] *= -1
        turned = [np.where(sagittal, kappa, -k_y), -1j * np.where(sagittal, k_y, kappa), np.ones_like(kappa)]
        right = np.array(turned)[self.kinds] * self.shapes
        of_flux = [
            np.where(sagittal, one, other)
            for one, other in ((1, kappa * k_y), (kappa * k_y, 1), (kappa, k_y))
        ]
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
    plane, section = fields.modes, _with_all_displacements(fields)
    second, first, _, zeroth = section.lateral_matrices(fields.frequency, 0.0)
    by_k_y = section.lateral_matrices(fields.frequency, 1.0)[1] - first
    u_x, u_y, u_z, phi = (column[column >= 0] for column in section.dofs.T)
    tangential, _, normal, potential = (column[column >= 0] for column in plane.section.dofs.T)
    squares, shear = np.linalg.eig(-np.linalg.solve(second[np.ix_(u_y, u_y)], zeroth[np.ix_(u_y, u_y)]))
    moving, count = plane.wavenumbers != 0, plane.section.size
    k = np.append(plane.wavenumbers, np.sqrt(squares.astype(complex)))
    lines = plane.right / np.where(moving, k[:count], 1.0)
    even = plane.right.copy()
    sent = np.zeros(section.size, dtype=complex)
    sent[:count][moving] = source.amplitudes * k[:count][moving]
    if not moving.all():
        slope, motion = static_mode(plane)
        lines[:, ~moving], even[:, ~moving] = -1j * motion[:, None], plane.section.constant_potential[:, None]
        sent[:count][~moving] = 1j * slope * charge_scale(section.solid)
    shapes = np.zeros((section.size, section.size), dtype=complex)
    for of_field in (u_x, u_y):
        shapes[of_field, :count], shapes[of_field, count:] = lines[tangential], shear
    shapes[u_z, :count], shapes[phi, :count] = even[normal], even[potential]
    kinds = np.full(section.size, 2)
    kinds[u_x], kinds[u_y] = 0, 1

    def product(matrix, to: int, of: int) -> np.ndarray:
        """Rows of one kind of a matrix times the shapes' rows of another."""
        return matrix[np.ix_(kinds == to, kinds == of)] @ shapes[kinds == of]

    # the nodal flux K1(k_y) v - i kappa K2 v, with kappa^2 = k^2 - k_y^2
    flux, by_square = np.zeros_like(shapes), np.zeros_like(shapes)
    sagittal = np.arange(section.size) < count
    crossed = (
        1j * product(second, 0, 0) - 1j * product(by_k_y, 0, 1),
        product(by_k_y, 1, 0) - product(second, 1, 1),
    )
    flux[kinds == 0] = np.where(
        sagittal, product(first, 0, 2) - 1j * k**2 * product(second, 0, 0), crossed[0]
    )
    by_square[kinds == 0] = np.where(sagittal, crossed[0], 0)
    flux[kinds == 1] = np.where(sagittal, crossed[1], -(k**2) * product(second, 1, 1))
    by_square[kinds == 1] = np.where(sagittal, 0, -crossed[1])
    flux[kinds == 2] = np.where(
        sagittal, product(first, 2, 0) - 1j * product(second, 2, 2), -product(first, 2, 0)
    )
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


def _with_all_displacements(fields: PortFields) -> Section:
    """The section of a solution with u_y, which is uncoupled at k_y = 0."""
    return discretise(
        fields.stator,
        fields.resolution,
        wavelength=fields.section.length_unit,
        surface_scale=min(each.finger_width / 2 for each in fields.transducers),
        lateral=True,
    )
