"""Free and clamped ends as faces x = 0 and x = L in three dimensions: what they send back at each lateral wavenumber.

At a lateral wavenumber k_y the fields of a strip 0 < x < L of the bare stator are those of the endless one and, from
each face, all guided modes of the section with the amplitudes c (from x = 0, to the right) and d (from x = L),

    c = R_0 (b + E d),    d = R_L (a + E c),    E = diag exp(-i kappa_p L),

a and b the amplitudes with which the charges' own waves arrive.  A face's reflection matrix R follows from its
condition on the nodal fluxes or the displacements (ends.py).  Sagittal and shear horizontal modes (SH) mix there as soon
as k_y differs from zero, so that the section has all three displacements.

In a solid isotropic about z the modes at k_y are those of k_y = 0, turned: with g = u_s / k, the displacement along the
wave vector over its length, u_x = kappa g and u_y = k_y g; an SH mode w has u_x = -k_y w and u_y = kappa w.

The strip's response has its poles on or near the real axis of k_y, where 2 kappa L and the phases of both faces are a
multiple of 2 pi.  The contour keeps its distance D but near the origin: a lossless strip in resonance at k_y = 0 has no
answer, with loss the poles are k / Q^(1/2) or more from there.  All modes take the contour of those whose phase runs
along their power: a mode with phase and power opposed that propagates would be on the wrong sheet beyond its own k.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig

from fem.beam.lateral import LateralRule, evanescent, lateral_rule
from fem.beam.line_source import KEPT, LineSource, charge_scale, static_mode
from fem.discretize.elements import discretise
from fem.discretize.section import Section
from fem.waveguide.ends import end_reflection
from fem.waveguide.modes import GuidedModes
from fem.waveguide.port_fields import PortFields

NEARLY_ZERO = 1e-4  # of the largest wavenumber: k_y in the place of 0, which makes the constant potential a double root
ROUNDING = 1e-9  # |Im k| / |k| of a mode without loss


class Sent(NamedTuple):
    """Modes of the section at one k_y, and their amplitudes from 1 C/m on the line x = 0, to the right and to the left."""

    modes: GuidedModes
    right: np.ndarray
    left: np.ndarray


class Returned(NamedTuple):
    """What both faces send back at one k_y: of the modes from x = 0 and of those from x = L.

    ``along``: decaying from their face as exp(-i along distance), rad/m, (n,) each; ``motion``: u at the surface there,
    (3, n) each.
    """

    along: tuple[np.ndarray, np.ndarray]
    motion: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Faces:
    """Two reflecting ends of a stator.

    Attributes
    ----------
    stator_length : float
        m.
    ends : str
        "free" or "clamped".
    highest : float
        Largest wavenumber of a propagating mode, rad/m.
    at : callable
        From k_y in rad/m to `Sent`.
    """

    stator_length: float
    ends: str
    highest: float
    at: Callable[[complex], Sent] = field(repr=False)

    def rule(self, reach: float, gap: float, mirror_width: float | None) -> LateralRule:
        """Rule for points up to a lateral reach, with ``gap`` m from the charges to the nearer face."""
        return lateral_rule(self.highest, reach, evanescent(self.highest, gap), mirror_width)

    def returned(self, lateral: complex, x: np.ndarray, charge: np.ndarray) -> Returned:
        """What comes back to charges (C/m at this k_y) at places x."""
        if abs(lateral) < NEARLY_ZERO * self.highest:
            lateral = NEARLY_ZERO * self.highest
        modes, to_right, to_left = self.at(lateral)
        unit, length = modes.section.length_unit, self.stator_length
        forward, backward = modes.wavenumbers / unit, -modes.backwards / unit
        gap = min(x.min(), length - x.max())
        kept = np.flatnonzero(np.minimum(-forward.imag, -backward.imag) * gap < -np.log(KEPT))
        at_right = to_right[kept] * (np.exp(-1j * np.outer(forward[kept], length - x)) @ charge)
        at_left = to_left[kept] * (np.exp(-1j * np.outer(backward[kept], x)) @ charge)
        left, right = (end_reflection(modes, self.ends, side, kept) for side in (0, 1))
        across, back = (np.exp(-1j * each[kept] * length) for each in (forward, backward))
        round_trip = (left[kept] * back) @ (right[kept] * across)
        started = left[kept] @ (at_left + back * (right[kept] @ at_right))
        c = np.linalg.solve(np.eye(len(kept)) - round_trip, started)
        d = right @ (at_right + across * c)
        c = left @ (at_left + back * d[kept])
        rows = [modes.section.surface_dofs[name] for name in ("ux", "uy", "uz")]
        turn = np.ones((3, 1), dtype=complex)
        if modes.section.solid.mirror_y is not None:  # u_y is scaled by i
            turn[1] = 1j
        return Returned(
            along=(forward, backward),
            motion=(turn * modes.right[rows] * c, turn * modes.left[rows] * d),
        )


def faces(fields: PortFields, source: LineSource) -> Faces:
    """Reflecting ends of a stator whose solid is isotropic about z, from the solution of its section."""
    stator = fields.stator
    turned = _turned_modes(fields, source)
    return Faces(
        stator_length=stator.length,
        ends=stator.ends,
        highest=float(np.sqrt((turned.wavenumbers**2).real.max())) / turned.section.length_unit,
        at=turned,
    )


class _TurnedModes(NamedTuple):
    """Modes at any k_y of a section isotropic about z: sagittal ones, then SH; n unknowns and as many modes.

    ``shapes``: u_s / k at k_y = 0 on the unknowns of u_x, the same on those of u_y, and u_z with phi, (3, n, n);
    ``fluxes``: the products of K1 at k_y = 0, its derivative by k_y and K2 with them, (3, 3, n, n); ``sent``: k times
    the amplitude that 1 C/m sends at k_y = 0, (n,).
    """

    section: Section
    frequency: float
    wavenumbers: np.ndarray
    sagittal: np.ndarray
    shapes: np.ndarray
    fluxes: np.ndarray
    sent: np.ndarray

    def __call__(self, lateral: complex) -> Sent:
        section = self.section
        k, k_y = self.wavenumbers, lateral * section.length_unit
        kappa = np.where(k.real < 0, -1, 1) * np.sqrt(k**2 - k_y**2)
        kappa[kappa.imag > ROUNDING * abs(kappa)] *= -1
        # the unknown of u_y is u_y / i
        weights = (
            np.where(self.sagittal, kappa, -k_y),
            -1j * np.where(self.sagittal, k_y, kappa),
            self.sagittal,
        )
        first, by_k_y, second = (sum(map(np.multiply, each, weights)) for each in self.fluxes)
        shapes, flux = sum(map(np.multiply, self.shapes, weights)), first + k_y * by_k_y - 1j * second * kappa
        mirror = np.where(section.lateral_odd, -1.0, 1.0)[:, None]
        modes = GuidedModes(
            section=section,
            frequency=self.frequency,
            wavenumbers=kappa,
            backwards=-kappa,
            right=shapes,
            left=mirror * shapes,
            right_flux=flux,
            left_flux=-mirror * flux,
            lateral_wavenumber=k_y,
        )
        return Sent(modes, self.sent / kappa, self.sent / kappa)


def _turned_modes(fields: PortFields, source: LineSource) -> _TurnedModes:
    plane, section = fields.modes, _with_all_displacements(fields)
    second, first, _, zeroth = section.lateral_matrices(fields.frequency, 0.0)
    by_k_y = section.lateral_matrices(fields.frequency, 1.0)[1] - first
    u_x, u_y, u_z, phi = (column[column >= 0] for column in section.dofs.T)
    tangential, _, normal, potential = (column[column >= 0] for column in plane.section.dofs.T)
    squares, shear = eig(-zeroth[np.ix_(u_y, u_y)], second[np.ix_(u_y, u_y)])
    moving, count = plane.wavenumbers != 0, plane.section.size
    k = np.append(plane.wavenumbers, np.sqrt(squares))
    lines = plane.right / np.where(moving, k[:count], 1.0)
    sent = np.zeros(section.size, dtype=complex)
    sent[:count][moving] = source.amplitudes * k[:count][moving]
    shapes = np.zeros((3, section.size, section.size), dtype=complex)
    if not moving.all():
        slope, motion = static_mode(plane)
        lines[:, ~moving] = -1j * motion[:, None]
        sent[:count][~moving] = 1j * slope * charge_scale(section.solid)
    for row, of_field in enumerate((u_x, u_y)):
        shapes[row, of_field, :count] = lines[tangential]
        shapes[row, of_field, count:] = shear
    shapes[2, u_z, :count], shapes[2, phi, :count] = plane.right[normal], plane.right[potential]
    if not moving.all():
        shapes[2][:, :count][:, ~moving] = section.constant_potential[:, None]
    return _TurnedModes(
        section=section,
        frequency=fields.frequency,
        wavenumbers=k,
        sagittal=np.arange(section.size) < count,
        shapes=shapes,
        fluxes=np.array([each @ shapes for each in (first, by_k_y, second)]),
        sent=sent,
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
