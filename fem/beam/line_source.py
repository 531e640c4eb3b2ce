"""Guided modes excited by a line of charge on the bare surface, and their dependence on the lateral wavenumber k_y.

A surface charge q at x = 0 excites, to its right, -i q v_p (l_p . e) exp(-i k_p x) / (l_p . L'(k_p) v_p) in the guided
mode v_p, with L(k) = k^2 K2 + i k (K1 - K1^T) + K0 - omega^2 M and e the unknown of the surface's potential.  The left
eigenvector l_p is v_p with the opposite sign of its odd unknowns, because of the symmetry x -> -x.  If the section is
not grounded, k = 0 is a double pole,

    phi = s |x|,  u = s sgn(x) w,    (K0 - omega^2 M) w = (K1 - K1^T) 1,    s 1.(K2 1 + K1 w) = -q / 2,

with 1 the constant potential.  The potentials of this pole cancel outside a transducer without net charge, but its u_x
causes a near field in three dimensions.

In a solid isotropic about z the response to a wave vector of length k at any angle is that at k_y = 0, rotated to the
direction of the vector.  It depends only on k^2 = k_x^2 + k_y^2, so that the pole k_p moves to kappa_p = (k_p^2 -
k_y^2)^(1/2).  Relative to k_y = 0, the residue of u_z is multiplied by k_p / kappa_p, that of u_x does not change, and
that of u_y is k_y / kappa_p times that of u_x.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import LateralRule, evanescent, lateral_rule, wavenumber_along
from fem.materials.medium import Medium
from fem.waveguide.modes import GuidedModes

LOCAL = 12.0  # a mode that decays by more than exp(-LOCAL) in a wavelength is a local field, not a part of the beam
KEPT = 1e-12  # a mode is neglected if less than this fraction of its amplitude is left at the nearest point
# With the symmetry y -> -y the waves at -k_y follow from those at k_y: signs of k_y and factors of u_x, u_y and u_z.
SIGNS = ((1, np.ones(3)), (-1, np.array([1, -1, 1])))


class Branch(NamedTuple):
    """Waves that run to one side of a charge, at the nodes of a quadrature rule for the lateral wavenumber.

    Attributes
    ----------
    side : int
        1 for x beyond the charge, -1 for x before it.
    rule : LateralRule
    along : ndarray, shape (modes, n)
        kappa in rad/m: the waves change as exp(-i kappa |x|).
    motion : ndarray, shape (3, modes, n)
        u_x, u_y, u_z at the surface, m per C/m.
    signs : tuple
        Signs of k_y for which the branch is valid, each with its factors of u_x, u_y and u_z.
    """

    side: int
    rule: LateralRule
    along: np.ndarray
    motion: np.ndarray
    signs: tuple


@dataclass(frozen=True, kw_only=True)
class LineSource:
    """Surface motion of the modes that 1 C/m on the line x = 0 excites to its right.

    Attributes
    ----------
    surface : ndarray of bool, shape (modes,)
        True for the modes of the surface wave.
    wavenumbers : ndarray, shape (modes,)
        In rad/m, without k = 0.
    amplitudes : ndarray, shape (modes,)
        Amplitudes per C/m of the modes as scaled in `GuidedModes`.
    tangential, normal : ndarray, shape (modes,)
        u_x and u_z at the surface, m per C/m.
    potential : ndarray, shape (modes,)
        phi at the surface, V per C/m.
    static : complex
        u_x of the pole at k = 0, m per C/m; 0 if the section is grounded.
    slope : complex
        phi / |x| of this pole, V/m per C/m.
    """

    surface: np.ndarray = field(repr=False)
    wavenumbers: np.ndarray = field(repr=False)
    amplitudes: np.ndarray = field(repr=False)
    tangential: np.ndarray = field(repr=False)
    normal: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    static: complex
    slope: complex
    error: float = 0.0  # relative error of the modes at k_y != 0; here they are exact

    @property
    def surface_mode(self) -> "LineSource":
        """The surface wave alone."""
        return self.some(self.surface)

    @property
    def rough(self) -> "LineSource":
        """The same source: unlike those of a `CutSource`, its modes are cheap, so that none need be left out."""
        return self

    def some(self, modes: np.ndarray) -> "LineSource":
        """Source with a selection of the modes, without the pole at k = 0."""
        fields = ("surface", "wavenumbers", "amplitudes", "tangential", "normal", "potential")
        kept = {name: getattr(self, name)[modes] for name in fields}
        return LineSource(**kept, static=0.0, slope=0.0)

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Wavenumber along x of the surface wave at lateral wavenumbers, rad/m; in a plate the mean of both modes."""
        return np.sqrt(np.mean(self.wavenumbers[self.surface]) ** 2 - np.square(lateral))

    def branches(
        self, reach: float, distance: float, resolved: float, mirror_width: float | None, spacing: float = 1.0
    ) -> Iterator[Branch]:
        """Waves to both sides, for points at least ``distance`` from the charges and at most ``reach`` beside them (m).

        Modes that decay by more than exp(-LOCAL) over the length ``resolved`` are omitted.  ``spacing``: factor on the
        distance of the nodes in k_y.
        """
        highest = float(np.sqrt((self.wavenumbers**2).real.max()))
        fade = evanescent(highest, max(distance, resolved))
        rule = lateral_rule(highest, reach, fade, mirror_width, coarser=spacing)
        backward = self.wavenumbers.real < 0
        lasting = self._lasting(distance, resolved)
        for modes, contour in ((lasting & ~backward, rule), (lasting & backward, rule.conjugate)):
            along, motion = self._turned(modes, contour.nodes)
            if mirror_width is not None and contour is rule:  # the pole at k = 0, kappa = -i k_y
                pole = np.zeros((3, 1, len(contour.nodes)), dtype=complex)
                pole[0], pole[1] = self.static, 1j * self.static * (contour.nodes > 0)
                along, motion = (np.vstack([along, -1j * contour.nodes]), np.concatenate([motion, pole], axis=1))
            yield from _both_sides(contour, along, motion)

    def plane(self, resolved: float) -> Iterator[Branch]:
        """The same modes at k_y = 0, for fields that do not depend on y: a rule of one node with weight 1."""
        rule = LateralRule(nodes=np.zeros(1), weights=np.ones(1))
        yield from _both_sides(rule, *self._turned(self._lasting(0.0, resolved), rule.nodes))

    def _lasting(self, distance: float, resolved: float) -> np.ndarray:
        """True for modes that are neither decayed at a distance (m) nor local to the charge."""
        rate = -self.wavenumbers.imag
        return (rate * distance < -np.log(KEPT)) & (rate * resolved < LOCAL)

    def _turned(self, modes: np.ndarray, lateral: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Modes at lateral wavenumbers (n,): kappa_p, shape (modes, n), and u of waves to the right, (3, modes, n)."""
        k = self.wavenumbers[modes, None]
        along = wavenumber_along(k, lateral)
        tangential = np.broadcast_to(self.tangential[modes, None], along.shape)
        return along, np.stack([tangential, tangential * (lateral / along), self.normal[modes, None] * (k / along)])


def _both_sides(rule: LateralRule, along, motion) -> Iterator[Branch]:
    """Waves to the right, and their mirror images to the left, in which u_x has the opposite sign."""
    yield Branch(1, rule, along, motion, SIGNS)
    yield Branch(-1, rule, along, motion * np.array([-1, 1, 1])[:, None, None], SIGNS)


@lru_cache(maxsize=2)
def line_source(modes: GuidedModes) -> LineSource:
    """Response of the bare section to a line of charge.

    Parameters
    ----------
    modes : GuidedModes
        Modes of a section with a potential and with the symmetry x -> -x.

    Returns
    -------
    LineSource
    """
    section = modes.section
    second, first, _ = section.matrices(modes.frequency)
    at, moving = section.full.surface_dofs, np.flatnonzero(modes.wavenumbers != 0)
    k, right = modes.wavenumbers[moving], modes.right[:, moving]
    left = np.where(section.odd, -1.0, 1.0)[:, None] * right
    # Left and right modes are biorthogonal in exact arithmetic.  The two surface waves of a thick plate, whose k differ
    # by 1e-8, amplify rounding to 1e-4, so that the products of different modes are kept.
    products = (k[:, None] + k) * (left.T @ second @ right) + 1j * (left.T @ (first - first.T) @ right)
    norms = np.sqrt(np.diag(products))
    scale = charge_scale(section.solid)
    # (products) a = -i q e.l, solved with products scaled to a unit diagonal
    received = np.linalg.solve(products / np.outer(norms, norms), section.lift(left)[at["phi"]] / norms)
    amplitudes = -1j * scale * received / norms
    surface = section.lift(right) * amplitudes
    slope, motion = static_mode(modes) if section.floating_potential else (0.0, np.zeros(section.size))
    return LineSource(
        surface=np.isin(moving, modes.rayleigh),
        wavenumbers=k / section.length_unit,
        tangential=surface[at["ux"]],
        normal=surface[at["uz"]],
        potential=surface[at["phi"]] * section.solid.potential_unit,
        amplitudes=amplitudes,
        static=scale * slope * section.lift(motion)[at["ux"]],
        slope=scale * slope * section.solid.potential_unit / section.length_unit,
    )


def charge_scale(medium: Medium) -> float:
    """Reaction in the section's scaled units that corresponds to a charge of 1 C/m."""
    return -medium.potential_unit / medium.stress_unit


def static_mode(modes: GuidedModes) -> tuple[complex, np.ndarray]:
    """Slope s and shape w of the pole at k = 0 (module docstring) for a unit reaction, in a floating section."""
    section = modes.section
    second, first, zeroth = section.matrices(modes.frequency)
    constant = section.constant_potential
    border = constant[:, None]
    system = np.block([[zeroth, border], [border.T, np.zeros((1, 1))]])
    motion = np.linalg.solve(system, np.append((first - first.T) @ constant, 0.0))[:-1]
    return complex(-0.5 / (constant @ (second @ constant + first @ motion))), motion
