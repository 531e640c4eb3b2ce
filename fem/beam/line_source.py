"""Modes that a line of charge on the bare surface sends out, and how they turn with the lateral wavenumber k_y.

A section with a surface charge q at x = 0 obeys f(0-) - f(0+) = q e, e the surface's potential.  By x -> -x its odd
unknowns vanish there and f = X u on the right (guided modes), so that X_ee u_e = -q e / 2 for the even ones; the modes'
amplitudes are V^-1 u.  Where nothing grounds the section, the constant potential leaves X singular: what is sent
then includes the linear potential, the double pole of the response at k = 0,

    phi = s |x|,  u = s sgn(x) w,    (K0 - omega^2 M) w = (K1 - K1^T) 1,    s 1.(K2 1 + K1 w) = -q / 2,

whose potential is none for a transducer without net charge but whose u_x drives a near field in three dimensions.

In a solid isotropic about z the response in the plane of a wave vector of length k is that of k_y = 0, with u_x along
the vector.  The response over k is even in k^2 = k_x^2 + k_y^2, so every pole k_p moves to kappa_p = (k_p^2 -
k_y^2)^(1/2), and its residue's share of u_z becomes k_p / kappa_p, of u_x 1 and of u_y k_y / kappa_p times that of
u_z and u_x at k_y = 0.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.materials import Solid, rotated
from fem.waveguide.modes import GuidedModes

SYMMETRY = 1e-9  # of the moduli, to which a solid must be isotropic about z
KEPT = 1e-12  # share of a mode's amplitude that must be left at the nearest point for it to count
GENERIC_TURN = 33.0  # degrees; no crystal class has such an axis


@dataclass(frozen=True, kw_only=True)
class LineSource:
    """Surface motion of the modes sent to the right by 1 C/m on the line x = 0.

    Attributes
    ----------
    numbers : ndarray of int, shape (modes,)
        Of the modes in `GuidedModes`.
    wavenumbers : ndarray, shape (modes,)
        rad/m; no zero among them.
    amplitudes : ndarray, shape (modes,)
        Of the modes as `GuidedModes` scales them, per C/m.
    tangential, normal : ndarray, shape (modes,)
        u_x and u_z at the surface, m per C/m.
    static : complex
        u_x of the pole at k = 0, m per C/m; 0 where the section is grounded.
    """

    numbers: np.ndarray = field(repr=False)
    wavenumbers: np.ndarray = field(repr=False)
    amplitudes: np.ndarray = field(repr=False)
    tangential: np.ndarray = field(repr=False)
    normal: np.ndarray = field(repr=False)
    static: complex

    def lasting(self, distance: float, decay: float = np.inf) -> np.ndarray:
        """Indices of the modes that keep 1e-12 over a distance (m) and decay less than exp(-``decay``) a metre."""
        rate = -self.wavenumbers.imag
        return np.flatnonzero((rate * distance < -np.log(KEPT)) & (rate < decay))

    def turned(self, modes: np.ndarray, lateral: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Some modes at other lateral wavenumbers: kappa_p, shape (modes, n), and u_x, u_y, u_z, shape (3, modes, n).

        Of waves to the right and k_y as given; u_y turns its sign with k_y, u_x to the left.
        """
        k = self.wavenumbers[modes, None]
        along = np.where(k.real < 0, -1, 1) * np.sqrt(k**2 - lateral**2)
        along[along.imag > 0] *= -1
        tangential = np.broadcast_to(self.tangential[modes, None], along.shape)
        return along, np.stack(
            [tangential, tangential * (lateral / along), self.normal[modes, None] * (k / along)]
        )

    def with_static(self, along, motion, lateral) -> tuple[np.ndarray, np.ndarray]:
        """Append the pole at k = 0, kappa = -i k_y, to modes at real lateral wavenumbers that begin with 0."""
        pole = np.zeros((3, 1, len(lateral)), dtype=complex)
        pole[0], pole[1] = self.static, 1j * self.static * (lateral > 0)
        return np.vstack([along, -1j * lateral]), np.concatenate([motion, pole], axis=1)

    def of_modes(self, numbers: np.ndarray) -> "LineSource":
        """Some modes alone, by their numbers in `GuidedModes`."""
        some = np.isin(self.numbers, numbers)
        return LineSource(
            numbers=self.numbers[some],
            wavenumbers=self.wavenumbers[some],
            amplitudes=self.amplitudes[some],
            tangential=self.tangential[some],
            normal=self.normal[some],
            static=0.0,
        )


def isotropic_about_normal(solid: Solid) -> bool:
    """Whether a turn about z changes none of a solid's moduli (by more than 1e-9)."""
    turned = rotated(solid, (GENERIC_TURN, 0.0, 0.0))
    pairs = (
        (getattr(turned, name), getattr(solid, name)) for name in ("stiffness", "coupling", "permittivity")
    )
    return all(abs(after - before).max() <= SYMMETRY * abs(before).max() for after, before in pairs)


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
    n, medium = section.size, section.solid
    odd = section.odd
    even = np.flatnonzero(~odd)
    load = np.zeros(n, dtype=complex)
    load[section.surface_dofs["phi"]] = -0.5
    end = modes.right_end
    linear, slope = np.zeros(n), 0.0
    if section.floats:
        linear, slope = _linear_potential(modes)
        constant = section.constant_potential
        second, first, _ = section.matrices(modes.frequency)
        load = load + slope * (end @ linear - second @ constant - first @ linear)
        border = constant[even][:, None]
        system = np.block([[end[np.ix_(even, even)], border], [border.T, np.zeros((1, 1))]])
        solved = np.linalg.solve(system, np.append(load[even], 0.0))[:-1]
    else:
        solved = np.linalg.solve(end[np.ix_(even, even)], load[even])
    line = np.zeros(n, dtype=complex)
    line[even] = solved
    moving = np.flatnonzero(modes.wavenumbers != 0)
    # a charge of 1 C/m is a reaction of -potential_unit / stress_unit
    scale = -medium.potential_unit / medium.stress_unit
    amplitudes = scale * modes.right_amplitudes(line - slope * linear)[moving]
    tangential, normal = section.surface_rows @ modes.right[:, moving]
    return LineSource(
        numbers=moving,
        wavenumbers=modes.wavenumbers[moving] / section.length_unit,
        amplitudes=amplitudes,
        tangential=tangential * amplitudes,
        normal=normal * amplitudes,
        static=complex(scale * slope * linear[section.surface_dofs["ux"]]),
    )


def _linear_potential(modes: GuidedModes) -> tuple[np.ndarray, complex]:
    """Displacements w that go with phi = x, shape (n,), and the slope s of a unit reaction."""
    section = modes.section
    second, first, zeroth = section.matrices(modes.frequency)
    constant = section.constant_potential
    border = constant[:, None]
    system = np.block([[zeroth, border], [border.T, np.zeros((1, 1))]])
    solved = np.linalg.solve(system, np.append((first - first.T) @ constant, 0.0))[:-1]
    return solved, complex(-0.5 / (constant @ (second @ constant + first @ solved)))
