"""Guided modes excited by a line of charge or force on the bare surface, at any lateral wavenumber k_y.

With L(k) = k^2 K2 + i k (K1 - K1^T) + K0 - omega^2 M and e the unknown of the surface's potential, a surface charge q
at x = 0 excites the guided modes v_p to its right,

    u = sum_p a_p v_p exp(-i k_p x),    a_p = -i q (l_p . e) / (l_p . L'(k_p) v_p).                         (1)

The left eigenvector l_p is v_p with the opposite sign of its odd unknowns, because of the symmetry x -> -x.  If the
section is not grounded, k = 0 is a double pole,

    phi = s |x|,  u = s sgn(x) w,    (K0 - omega^2 M) w = (K1 - K1^T) c,    s c.(K2 c + K1 w) = -q / 2,     (2)

with c the vector of the constant potential phi = 1.  The potentials of this pole cancel outside a transducer without
net charge, but its u_x causes a near field in three dimensions.

In a solid isotropic about z the response to a wave vector of length k at any angle is that at k_y = 0, rotated to the
direction of the vector.  It depends only on k^2 = k_x^2 + k_y^2, so that the pole k_p moves to kappa_p = (k_p^2 -
k_y^2)^(1/2).  Relative to k_y = 0, the residue of u_z is multiplied by k_p / kappa_p, that of u_x does not change, and
that of u_y is k_y / kappa_p times that of u_x.

A line force F (N/m) is a load on the unknown of u_x or u_z instead of that of the potential.  A normal force turns as a
charge does.  A force along x has the part F kappa_p / k_p along the wave vector, which excites the same (sagittal)
modes, and the part -F k_y / k_p across it, which excites shear-horizontal (SH) modes,

    (k^2 K2 + K0 - omega^2 M) w = 0 on the unknowns of u_y,    u_t = -i F w_0^2 exp(-i k_p x) / (2 k_p w.K2 w),  (3)

with u_t the displacement across the wave vector and w_0 the value of w at the surface.

At k_y != 0 the double pole k = 0 of a floating section moves to kappa = -i |k_y|.  To the right of a line charge it
gives u_x = s w_x exp(-|k_y| x) and u_y = i sgn(k_y) u_x, with w_x the value of u_x at the surface; of a force along x
it gives |k_y| times that with s w_x^2 instead of s w_x (`LineSource.static`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal, NamedTuple, Protocol

import numpy as np

from fem.beam.lateral import (
    PLANE,
    LateralRule,
    amplitude_ratio,
    evanescent,
    highest_wavenumber,
    lateral_rule,
    wavenumber_along,
)
from fem.discretize.section import FIELD_COLUMN, Section
from fem.materials.medium import Medium
from fem.waveguide.guided_modes import GuidedModes

LOCAL = 12.0  # a mode that decays by more than exp(-LOCAL) in a wavelength is a local field, not a part of the beam
NEGLIGIBLE = 1e-12  # a mode is neglected if less than this fraction of its amplitude is left at the nearest point
# A load is a charge, or a force along x or z; it acts on the surface's unknown of one field of the section.
Load = Literal["charge", "x", "z"]
LOADED = {"charge": "phi", "x": "ux", "z": "uz"}
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


class ModeSource(Protocol):
    """Response of the bare stator to a load on the line x = 0: `LineSource`, or `CutSource` in any crystal cut."""

    @property
    def static(self) -> complex:
        """u_x of the pole at k = 0, m per unit of load; 0 without one."""

    @property
    def error(self) -> float:
        """Relative error of the modes at k_y != 0."""

    @property
    def omits_oblique(self) -> bool:
        """True if waves whose power leaves at more than 45 degrees are neglected."""

    @property
    def surface_mode(self) -> "ModeSource":
        """The same source with the surface wave alone."""

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Wavenumber along x of the surface wave at real lateral wavenumbers, rad/m."""

    def branches(
        self, reach: float, distance: float, resolved: float, mirror_width: float | None, halvings: int = 0
    ) -> Iterator[Branch]:
        """Waves to both sides, for points at least ``distance`` from the load and at most ``reach`` beside it (m).

        Modes that are local to the load may be omitted, those that decay by more than exp(-LOCAL) over the length
        ``resolved`` (m).  ``halvings``: of the distance of the nodes in k_y.
        """

    def plane(self, resolved: float) -> Iterator[Branch]:
        """The same modes at k_y = 0, for fields that do not depend on y: a rule of one node with weight 1."""

    def static_motion(
        self, distance: np.ndarray, above: np.ndarray, below: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """u_x and u_y in m of the pole at k = 0 by a unit of load per metre of a sheet.

        ``distance``: along x from the load, m; ``above``, ``below``: from the point to the sheet's ends along y, m.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class LineSource:
    """`ModeSource` in a solid isotropic about z.

    It has the surface motion of the modes that a load of 1 C/m or 1 N/m on the line x = 0 excites to its right.

    Attributes
    ----------
    load : "charge", "x" or "z"
        A charge, or a force along x or z.
    surface : ndarray of bool, shape (modes,)
        True for the modes of the surface wave.
    wavenumbers : ndarray, shape (modes,)
        In rad/m, without k = 0.
    amplitudes : ndarray, shape (modes,)
        Amplitudes per unit of load of the modes as scaled in `GuidedModes`; of sagittal modes.
    tangential, normal : ndarray, shape (modes,)
        u_x and u_z at the surface, m per unit of load; 0 for SH modes.
    shear : ndarray, shape (modes,)
        Displacement of SH modes along a force that acts across their wave vector, m per N/m; 0 for sagittal modes.
    potential : ndarray, shape (modes,)
        phi at the surface, V per unit of load.
    static : complex
        Factor of u_x of the pole at k = 0: s w_x of a charge, m per C/m; s w_x^2 of a force along x, m2 per N/m; 0 if
        the section is grounded, and of a normal force.
    slope : complex
        phi / |x| of this pole, V/m per C/m; of charges.
    """

    load: Load = "charge"
    surface: np.ndarray = field(repr=False)
    wavenumbers: np.ndarray = field(repr=False)
    amplitudes: np.ndarray = field(repr=False)
    tangential: np.ndarray = field(repr=False)
    normal: np.ndarray = field(repr=False)
    shear: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    static: complex
    slope: complex
    error: float = 0.0  # the modes at k_y != 0 are exact
    omits_oblique: bool = False

    @property
    def surface_mode(self) -> "LineSource":
        """The surface wave alone."""
        return self.some(self.surface)

    def some(self, modes: np.ndarray) -> "LineSource":
        """Source with a selection of the modes, without the pole at k = 0."""
        fields = ("surface", "wavenumbers", "amplitudes", "tangential", "normal", "shear", "potential")
        selected = {name: getattr(self, name)[modes] for name in fields}
        return replace(self, **selected, static=0.0, slope=0.0)

    def with_shear(self, section: Section, frequency: float) -> "LineSource":
        """Source of a force along x with the SH modes, equation (3), of the same section with all displacements."""
        wavenumbers, shapes = shear_modes(section, frequency)
        on_surface = shapes[np.searchsorted(_shear_dofs(section), section.surface_dofs["uy"])]
        shear = -0.5j * load_scale(section.solid, "x") * on_surface**2 / wavenumbers
        none = np.zeros(len(shear))
        return replace(
            self,
            tangential=np.append(self.tangential, none),
            normal=np.append(self.normal, none),
            potential=np.append(self.potential, none),
            surface=np.append(self.surface, none.astype(bool)),
            wavenumbers=np.append(self.wavenumbers, wavenumbers / section.length_unit),
            amplitudes=np.append(self.amplitudes, none),
            shear=np.append(self.shear, shear),
        )

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Wavenumber along x of the surface wave, rad/m; in a plate the mean of the two modes that form it."""
        return wavenumber_along(np.mean(self.wavenumbers[self.surface]), lateral)

    def branches(
        self, reach: float, distance: float, resolved: float, mirror_width: float | None, halvings: int = 0
    ) -> Iterator[Branch]:
        """Waves to both sides: as of `ModeSource`."""
        highest = highest_wavenumber(self.wavenumbers)
        fade = evanescent(highest, max(distance, resolved))
        rule = lateral_rule(highest, reach, fade, mirror_width, halvings=halvings)
        lasting = self._lasting(distance, resolved)
        for modes, contour in rule.contours(self.wavenumbers):
            along, motion = self._at_lateral(lasting & modes, contour.nodes)
            if mirror_width is not None and contour is rule:  # the pole at k = 0, kappa = -i k_y
                pole = np.zeros((3, 1, len(contour.nodes)), dtype=complex)
                pole[0], pole[1] = self.static, 1j * self.static * (contour.nodes > 0)
                pole = pole * contour.nodes if self.load == "x" else pole
                along, motion = (np.vstack([along, -1j * contour.nodes]), np.concatenate([motion, pole], axis=1))
            yield from self._both_sides(contour, along, motion)

    def plane(self, resolved: float) -> Iterator[Branch]:
        """The same modes at k_y = 0, for fields that do not depend on y: a rule of one node with weight 1."""
        yield from self._both_sides(PLANE, *self._at_lateral(self._lasting(0.0, resolved), PLANE.nodes))

    def static_motion(
        self, distance: np.ndarray, above: np.ndarray, below: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """u_x and u_y in m of the pole at k = 0, where kappa = -i |k_y|: as of `ModeSource`.

        The integral over k_y of a charge is a Laplace transform: sum of arctan(b / |x|) / pi for u_x and difference of
        log(x^2 + b^2) / 2 pi for u_y, with b = ``above`` and ``below``.  That of a force is minus its slope in |x|.
        The sum of both arctan is the angle of (|x| + i above) (|x| + i below).
        """
        square = distance**2
        squares = square + above**2, square + below**2
        if self.load == "x":
            inward = above / squares[0] + below / squares[1]
            sideways = distance / squares[1] - distance / squares[0]
        else:
            angle = np.arctan2((above + below) * abs(distance), square - above * below)
            inward, sideways = np.sign(distance) * angle, 0.5 * np.log(squares[0] / squares[1])
        return inward * (self.static / np.pi), sideways * (self.static / np.pi)

    def _lasting(self, distance: float, resolved: float) -> np.ndarray:
        """True for modes that are neither decayed at a distance (m) nor local to the charge."""
        rate = -self.wavenumbers.imag
        return (rate * distance < -np.log(NEGLIGIBLE)) & (rate * resolved < LOCAL)

    def _at_lateral(self, modes: np.ndarray, lateral: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Modes at lateral wavenumbers (n,): kappa_p, shape (modes, n), and u of waves to the right, (3, modes, n)."""
        k = self.wavenumbers[modes, None]
        along = wavenumber_along(k, lateral)
        sent = amplitude_ratio(k, along, tangential=self.load == "x")
        u_s, u_z = (each[modes, None] * np.broadcast_to(sent, along.shape) for each in (self.tangential, self.normal))
        u_t = -self.shear[modes, None] * lateral / along
        cosine, sine = along / k, lateral / k
        return along, np.stack([u_s * cosine - u_t * sine, u_s * sine + u_t * cosine, u_z])

    def _both_sides(self, rule: LateralRule, along, motion) -> Iterator[Branch]:
        """Waves to the right and their mirror images to the left: of a force along x, u_x is even in x, else odd."""
        mirrored = np.array([1, -1, -1] if self.load == "x" else [-1, 1, 1])[:, None, None]
        yield Branch(1, rule, along, motion, SIGNS)
        yield Branch(-1, rule, along, motion * mirrored, SIGNS)


@lru_cache(maxsize=4)  # no default arguments: with and without one the cache would hold the same source twice
def line_source(modes: GuidedModes, load: Load) -> LineSource:
    """Response of the bare section to a line of charge or force.

    Parameters
    ----------
    modes : GuidedModes
        Modes of a section with a potential and with the symmetry x -> -x.
    load : "charge", "x" or "z"
        A force along x excites SH modes at k_y != 0 too (`LineSource.with_shear`).

    Returns
    -------
    LineSource
    """
    section = modes.section
    if section.odd is None:
        raise ValueError("the section must have the symmetry x -> -x")
    second, first, _ = section.matrices(modes.frequency)
    at, moving = section.full.surface_dofs, np.flatnonzero(modes.wavenumbers != 0)
    k, right = modes.wavenumbers[moving], modes.right[:, moving]
    left = np.where(section.odd, -1.0, 1.0)[:, None] * right
    # Left and right modes are biorthogonal in exact arithmetic.  The two surface waves of a thick plate, whose k differ
    # by 1e-8, amplify rounding to 1e-4, so that the products of different modes are kept.
    products = (k[:, None] + k) * (left.T @ second @ right) + 1j * (left.T @ (first - first.T) @ right)
    norms = np.sqrt(np.diag(products))
    scale = load_scale(section.solid, load)
    # equation (1): (products) a = -i q e.l, solved with products scaled to a unit diagonal
    received = np.linalg.solve(products / np.outer(norms, norms), section.lift(left)[at[LOADED[load]]] / norms)
    amplitudes = -1j * scale * received / norms
    surface = section.lift(right) * amplitudes
    static: complex = 0.0
    slope: complex = 0.0
    if section.floating_potential and load != "z":
        unit_slope, motion = static_mode(modes)
        tangential = section.lift(motion)[at["ux"]]
        static = scale * unit_slope * tangential
        if load == "x":
            static *= tangential * section.length_unit
        else:
            slope = scale * unit_slope * section.solid.potential_unit / section.length_unit
    return LineSource(
        load=load,
        surface=np.isin(moving, modes.rayleigh),
        wavenumbers=k / section.length_unit,
        amplitudes=amplitudes,
        tangential=surface[at["ux"]],
        normal=surface[at["uz"]],
        shear=np.zeros(len(k), dtype=complex),
        potential=surface[at["phi"]] * section.solid.potential_unit if "phi" in at else np.zeros(len(k)),
        static=static,
        slope=slope,
    )


def shear_modes(section: Section, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """SH modes w of equation (3), scaled to w.K2 w = 1, of a section with all displacements.

    Returns
    -------
    wavenumbers : ndarray, shape (modes,)
        Radians per length unit, to the right.
    shapes : ndarray, shape (unknowns of u_y, modes)
    """
    second, _, _, zeroth = section.lateral_matrices(frequency, 0.0)
    own = np.ix_(_shear_dofs(section), _shear_dofs(section))
    squares, shapes = np.linalg.eig(-np.linalg.solve(second[own], zeroth[own]))
    shapes = shapes / np.sqrt(np.sum(shapes * (second[own] @ shapes), axis=0).astype(complex))
    return wavenumber_along(np.sqrt(squares.astype(complex)), np.zeros(1)), shapes


def _shear_dofs(section: Section) -> np.ndarray:
    """Unknowns of u_y, from the bottom up."""
    column = section.dofs[:, FIELD_COLUMN["uy"]]
    return column[column >= 0]


def load_scale(medium: Medium, load: Load) -> float:
    """Reaction in the section's scaled units that corresponds to a load of 1 C/m or 1 N/m."""
    return -medium.potential_unit / medium.stress_unit if load == "charge" else 1 / medium.stress_unit


def static_mode(modes: GuidedModes) -> tuple[complex, np.ndarray]:
    """Slope s and shape w of the pole at k = 0, equation (2), for a unit reaction, in a floating section."""
    section = modes.section
    second, first, zeroth = section.matrices(modes.frequency)
    constant = section.constant_potential
    border = constant[:, None]
    system = np.block([[zeroth, border], [border.T, np.zeros((1, 1))]])
    motion = np.linalg.solve(system, np.append((first - first.T) @ constant, 0.0))[:-1]
    return complex(-0.5 / (constant @ (second @ constant + first @ motion))), motion
