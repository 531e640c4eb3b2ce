"""Modes that a line of charge on the bare surface sends out, and how they turn with the lateral wavenumber k_y.

A section with a surface charge q at x = 0 sends -i q v_p (l_p . e) exp(-i k_p x) / (l_p . L'(k_p) v_p) to the right in
the guided mode v_p, with L(k) = k^2 K2 + i k (K1 - K1^T) + K0 - omega^2 M, e the surface's potential and l_p the left
eigenvector: v_p with its odd unknowns turned, by x -> -x.  Where nothing grounds the section, k = 0 is a double pole,

    phi = s |x|,  u = s sgn(x) w,    (K0 - omega^2 M) w = (K1 - K1^T) 1,    s 1.(K2 1 + K1 w) = -q / 2,

whose potential is none for a transducer without net charge but whose u_x drives a near field in three dimensions.

In a solid isotropic about z the response in the plane of a wave vector of length k is that of k_y = 0, with u_x along
the vector.  The response over k is even in k^2 = k_x^2 + k_y^2, so every pole k_p moves to kappa_p = (k_p^2 -
k_y^2)^(1/2), and its residue's share of u_z becomes k_p / kappa_p, of u_x 1 and of u_y k_y / kappa_p times that of
u_z and u_x at k_y = 0.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import LateralRule, evanescent, lateral_rule
from fem.materials.medium import Medium
from fem.waveguide.modes import GuidedModes

LOCAL = 12.0  # exponent over a wavelength by which a mode decays that nothing sideways reaches
KEPT = 1e-12  # share of a mode's amplitude that must be left at the nearest point for it to count
SIGNS = ((1, np.ones(3)), (-1, np.array([1, -1, 1])))  # of k_y, where y -> -y is a symmetry


class Branch(NamedTuple):
    """Waves to one side at the nodes of a rule for the lateral wavenumber.

    Attributes
    ----------
    side : int
        1 for x beyond the charge, -1 for x before it.
    rule : LateralRule
    along : ndarray, shape (modes, n)
        kappa, rad/m: the phase grows as exp(-i kappa |x|).
    motion : ndarray, shape (3, modes, n)
        u_x, u_y, u_z at the surface, m per C/m.
    signs : tuple
        Signs of k_y that the branch serves, and the factors of u_x, u_y and u_z for each.
    """

    side: int
    rule: LateralRule
    along: np.ndarray
    motion: np.ndarray
    signs: tuple


@dataclass(frozen=True, kw_only=True)
class LineSource:
    """Surface motion of the modes sent to the right by 1 C/m on the line x = 0.

    Attributes
    ----------
    surface : ndarray of bool, shape (modes,)
        Which modes are the surface wave.
    wavenumbers : ndarray, shape (modes,)
        rad/m; no zero among them.
    amplitudes : ndarray, shape (modes,)
        Of the modes as `GuidedModes` scales them, per C/m.
    tangential, normal : ndarray, shape (modes,)
        u_x and u_z at the surface, m per C/m.
    potential : ndarray, shape (modes,)
        phi at the surface, V per C/m.
    static : complex
        u_x of the pole at k = 0, m per C/m; 0 where the section is grounded.
    slope : complex
        Of its potential, phi / |x|, V/m per C/m.
    """

    surface: np.ndarray = field(repr=False)
    wavenumbers: np.ndarray = field(repr=False)
    amplitudes: np.ndarray = field(repr=False)
    tangential: np.ndarray = field(repr=False)
    normal: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    static: complex
    slope: complex
    error: float = 0.0  # of the modes at other lateral wavenumbers

    @property
    def surface_mode(self) -> "LineSource":
        """The surface wave alone."""
        return self.some(self.surface)

    @property
    def rough(self) -> "LineSource":
        """As of `CutSource`; here all modes cost little."""
        return self

    def some(self, modes: np.ndarray) -> "LineSource":
        """Only some of the modes, without the pole at k = 0."""
        fields = ("surface", "wavenumbers", "amplitudes", "tangential", "normal", "potential")
        kept = {name: getattr(self, name)[modes] for name in fields}
        return LineSource(**kept, static=0.0, slope=0.0)

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Wavenumber along x of the surface wave at lateral wavenumbers, rad/m; in a plate the mean of its two."""
        return np.sqrt(np.mean(self.wavenumbers[self.surface]) ** 2 - np.square(lateral))

    def branches(
        self, reach: float, distance: float, resolved: float, mirror_width: float | None
    ) -> Iterator[Branch]:
        """Waves to both sides, at points beyond a distance from the charges and up to a lateral reach (m).

        Modes that decay by exp(-12) or more over the length ``resolved`` are left out.
        """
        highest = float(np.sqrt((self.wavenumbers**2).real.max()))
        rule = lateral_rule(highest, reach, evanescent(highest, max(distance, resolved)), mirror_width)
        backward = self.wavenumbers.real < 0
        lasting = self._lasting(distance, resolved)
        for modes, contour in ((lasting & ~backward, rule), (lasting & backward, rule.conjugate)):
            along, motion = self._turned(modes, contour.nodes)
            if mirror_width is not None and contour is rule:  # the pole at k = 0, kappa = -i k_y
                pole = np.zeros((3, 1, len(contour.nodes)), dtype=complex)
                pole[0], pole[1] = self.static, 1j * self.static * (contour.nodes > 0)
                along, motion = (
                    np.vstack([along, -1j * contour.nodes]),
                    np.concatenate([motion, pole], axis=1),
                )
            yield from _both_sides(contour, along, motion)

    def plane(self, resolved: float) -> Iterator[Branch]:
        """The same modes where nothing depends on y; one node of the weight 1."""
        rule = LateralRule(nodes=np.zeros(1), weights=np.ones(1))
        yield from _both_sides(rule, *self._turned(self._lasting(0.0, resolved), rule.nodes))

    def _lasting(self, distance: float, resolved: float) -> np.ndarray:
        rate = -self.wavenumbers.imag
        return (rate * distance < -np.log(KEPT)) & (rate * resolved < LOCAL)

    def _turned(self, modes: np.ndarray, lateral: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Modes at other lateral wavenumbers: kappa_p, shape (modes, n), and u to the right, shape (3, modes, n)."""
        k = self.wavenumbers[modes, None]
        along = np.where(k.real < 0, -1, 1) * np.sqrt(k**2 - lateral**2)
        along[along.imag > 0] *= -1
        tangential = np.broadcast_to(self.tangential[modes, None], along.shape)
        return along, np.stack(
            [tangential, tangential * (lateral / along), self.normal[modes, None] * (k / along)]
        )


def _both_sides(rule: LateralRule, along, motion) -> Iterator[Branch]:
    """Waves to the right and, mirrored, to the left; u_y turns its sign with k_y."""
    yield Branch(1, rule, along, motion, SIGNS)
    yield Branch(-1, rule, along, motion * np.array([-1, 1, 1])[:, None, None], SIGNS)


@lru_cache(maxsize=2)
def line_source(modes: GuidedModes) -> LineSource:
    """Response of the bare section to a line of charge.

    Parameters
    ----------
    modes : GuidedModes
        Of a section with a potential and with the symmetry x -> -x.

    Returns
    -------
    LineSource
    """
    section = modes.section
    second, first, _ = section.matrices(modes.frequency)
    at, moving = section.full.surface_dofs, np.flatnonzero(modes.wavenumbers != 0)
    k, right = modes.wavenumbers[moving], modes.right[:, moving]
    left = np.where(section.odd, -1.0, 1.0)[:, None] * right
    # biorthogonal but for rounding, which the two surface waves of a thick plate, 1e-8 apart, enlarge to 1e-4
    products = (k[:, None] + k) * (left.T @ second @ right) + 1j * (left.T @ (first - first.T) @ right)
    norms = np.sqrt(np.diag(products))
    scale = charge_scale(section.solid)
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
    """Scaled reaction of a charge of 1 C/m."""
    return -medium.potential_unit / medium.stress_unit


def static_mode(modes: GuidedModes) -> tuple[complex, np.ndarray]:
    """Slope s of the potential s |x| of a unit reaction where nothing grounds the section, and the shape w of u_x."""
    section = modes.section
    second, first, zeroth = section.matrices(modes.frequency)
    constant = section.constant_potential
    border = constant[:, None]
    system = np.block([[zeroth, border], [border.T, np.zeros((1, 1))]])
    motion = np.linalg.solve(system, np.append((first - first.T) @ constant, 0.0))[:-1]
    return complex(-0.5 / (constant @ (second @ constant + first @ motion))), motion
