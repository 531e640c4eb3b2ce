"""Modes that a line of charge sends out at any lateral wavenumber, in any cut.

With L(k) = k^2 K2 + i k (K1 - K1t) + K0 - omega^2 M at a lateral wavenumber k_y (section.py), a line of charge q has
the response u = L(k)^-1 q e over k_x, e the surface's potential.  With all eigenpairs k_p, v_p of both directions,

    L(k)^-1 = sum_p v_p l_p^T / (k - k_p),    [V; V diag(k_p)] [l_p^T] = [0; K2^-1],

so that the modes to the right are -i v_p (l_p . e) exp(-i k_p x), those to the left +i ... .  Reciprocity,
L(k, k_y)^T = L(-k, -k_y), gives the response at -k_y from the same eigenpairs.

Left out: what leaves a transducer at more than about 45 degrees, since the integral over k_y ends smoothly there;
modes whose phase runs against their power; where the bottom absorbs in a matched layer, all but the surface wave, which
is then followed from one k_y to the next.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import LateralRule, lateral_rule
from fem.beam.line_source import KEPT, LOCAL, Branch, charge_scale
from fem.convergence import ConvergenceError
from fem.discretize.absorber import absorber_kind
from fem.discretize.elements import discretise
from fem.discretize.grading import Resolution
from fem.discretize.section import Section
from fem.eigenproblem import companion_modes, even_odd_modes
from fem.geometry import Stator
from fem.waveguide.port_fields import PortFields

FADE = (
    0.6,
    0.85,
)  # of the surface wave's wavenumber: lateral wavenumbers between which the integral fades out
NEARLY_ZERO = 1e-5  # of the same: k_y in the place of 0, which makes the constant potential a double root
NEARLY_REAL = 0.3  # |Im k| / |Re k| below which a mode's power flux tells its direction
NEAR = 0.02  # relative distance of k at which a mode's localisation counts half
TWIN_SHARE, TWIN_DISTANCE = (
    0.4,
    0.03,
)  # localisation and k, relative, of a second mode of the surface wave in a plate
MAX_ITERATIONS, FOLLOWED = 8, 1e-10  # of a followed mode; last relative step
FITTED = 4  # places behind from which it is extrapolated
COARSER = 1.25  # spacing of the rule: 1e-6, where what is left out is 1e-5 and more
INTERPOLATED = 32  # nodes of a rule at which a mode is solved for, besides a few that check what lies between
# Between them; all nodes are solved for where it is not reached.  It moves YZ's beam by 2e-4, of a stated 6e-3.
ACCURACY = {"wavenumbers": 1e-5, "column": 5e-3}
LOST = "the surface wave cannot be followed to oblique directions in this cut"


class _Poles(NamedTuple):
    """Modes of both directions at one k_y.

    Wavenumbers (modes,) in rad/m, whether they go right, whether they are the surface wave; residues (modes, 3) of u
    per charge, and of the transposed response.
    """

    wavenumbers: np.ndarray
    right: np.ndarray
    surface: np.ndarray
    column: np.ndarray
    row: np.ndarray


@dataclass(frozen=True, kw_only=True)
class CutSource:
    """Surface motion of the modes sent by 1 C/m on the line x = 0 of a section, at any lateral wavenumber.

    Attributes
    ----------
    section : Section
        With all fields; without the edge layers of the fingers.
    frequency : float
        Hz.
    wavenumber : float
        Of the surface wave at k_y = 0, rad/m.
    followed : tuple of complex
        Scaled wavenumbers at k_y = 0 of the modes that alone are followed; empty for all modes.
    surface_only : bool
        Whether the surface wave alone is wanted.
    static : float
        As of `LineSource`; 0, for the modes contain it.
    """

    section: Section = field(repr=False)
    frequency: float
    wavenumber: float
    followed: tuple[complex, ...] = ()
    surface_only: bool = False
    static: float = 0.0
    _spectra: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def surface_mode(self) -> "CutSource":
        """The surface wave alone."""
        return replace(self, surface_only=True)

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """As of `LineSource`, for real lateral wavenumbers."""
        sizes, which = np.unique(abs(np.asarray(lateral)), return_inverse=True)
        poles = self._spectrum(sizes)
        forward = np.array([np.mean(each.wavenumbers[each.surface & each.right]) for each in poles])
        backward = np.array([np.mean(each.wavenumbers[each.surface & ~each.right]) for each in poles])
        return np.where(np.asarray(lateral) < 0, -backward[which], forward[which])

    def branches(self, reach: float, distance: float, _resolved: float, mirror_width) -> Iterator[Branch]:
        """Waves to both sides at the nodes of a rule that serves points up to ``reach``."""
        rounded = 2.0 ** (np.ceil(2 * np.log2(reach)) / 2)  # so that few rules are needed
        low, high = FADE
        fade = low * self.wavenumber, high * self.wavenumber
        coarser = 1.0 if self.section.floating_potential else COARSER  # u_x depends on |k_y| there
        rule = lateral_rule(self.wavenumber, rounded, fade, mirror_width, coarser=coarser)
        yield from self._lasting(rule, distance)

    def plane(self, _resolved: float) -> Iterator[Branch]:
        """Waves that do not depend on y."""
        for branch in self._lasting(LateralRule(nodes=np.zeros(1), weights=np.ones(1)), 0.0):
            if branch.signs[0][0] > 0:
                yield branch

    def _lasting(self, rule: LateralRule, distance: float) -> Iterator[Branch]:
        key = (len(rule.nodes), complex(rule.nodes[-1]))
        if key not in self._spectra:
            self._spectra[key] = self._spectrum(rule.nodes)
        poles = self._spectra[key]
        for side in (1, -1):
            for sign in (1, -1):
                along, motion = [], []
                for each in poles:
                    # at -k_y the poles are those of the other direction, their residues transposed
                    here = (each.right == (side * sign > 0)) & (each.surface | (not self.surface_only))
                    here &= -side * sign * each.wavenumbers.imag * distance < -np.log(KEPT)
                    along.append(side * sign * each.wavenumbers[here])
                    motion.append(-1j * side * sign * (each.column if sign > 0 else each.row)[here])
                count = max(len(each) for each in along)
                k, u = (
                    np.full((count, len(poles)), -1j * self.wavenumber),
                    np.zeros((3, count, len(poles)), complex),
                )
                for node, (some, moved) in enumerate(zip(along, motion, strict=True)):
                    k[: len(some), node], u[:, : len(some), node] = some, moved.T
                yield Branch(side, rule, k, u, ((sign, np.ones(3)),))

    @property
    def _surface(self) -> list[int]:
        """Unknowns u_x, u_y, u_z and phi at the surface."""
        return [self.section.surface_dofs[name] for name in ("ux", "uy", "uz", "phi")]

    def _spectrum(self, nodes) -> list[_Poles]:
        """Modes at every node; those that are followed are interpolated along the contour."""
        if not self.followed or len(nodes) <= INTERPOLATED:
            return self._solved(nodes)
        number = np.arange(len(nodes))
        some, between = (
            np.unique(np.round(number[-1] * np.sin(np.pi / 2 * np.linspace(0, 1, count)) ** 2).astype(int))
            for count in (INTERPOLATED, INTERPOLATED // 4)
        )
        between = np.setdiff1d(between + 1, [*some, len(nodes)])
        solved = np.union1d(some, between)
        fields = [np.stack(each) for each in zip(*self._solved(nodes[solved]), strict=True)]
        near = np.stack([_barycentric(some, each) for each in number])
        known, checked = np.isin(solved, some), np.isin(solved, between)
        found = []
        for name, each in zip(_Poles._fields, fields, strict=True):
            if each.dtype == bool:
                found.append(np.repeat(each[:1], len(nodes), axis=0))
                continue
            found.append(np.tensordot(near, each[known], 1))
            missed = abs(found[-1][between] - each[checked]).max()
            if missed > ACCURACY.get(name, ACCURACY["column"]) * abs(each).max():
                return self._solved(nodes)
        return [_Poles(*each) for each in zip(*found, strict=True)]

    @cached_property
    def _polynomials(self) -> list[tuple]:
        """Matrices of `Section.lateral_matrices` at k_y = 0, and their first and second power of k_y in rad/m."""
        step = self.wavenumber * self.section.length_unit
        below, here, above = (
            self.section.lateral_matrices(self.frequency, sign * step) for sign in (-1, 0, 1)
        )
        return [
            (b, (c - a) / (2 * self.wavenumber), (a - 2 * b + c) / (2 * self.wavenumber**2))
            for a, b, c in zip(below, here, above, strict=True)
        ]

    def _solved(self, nodes) -> list[_Poles]:
        """Modes at every node, which follow one another closely from 0 on."""
        size = self.section.size
        estimates = [(k, *np.random.default_rng(0).normal(size=(2, size))) for k in self.followed]
        out, surface = [], self.wavenumber
        passed, history = [0.0], [np.array(self.followed)]
        for node in nodes:
            lateral = max(abs(node), NEARLY_ZERO * self.wavenumber) * (node / abs(node) if node else 1.0)
            second, first, adjoint, zeroth = (
                a + lateral * (b + lateral * c) for a, b, c in self._polynomials
            )
            skew = first - adjoint
            if self.followed:
                recent = _barycentric(np.array(passed[-FITTED:]), lateral) @ np.stack(history[-FITTED:])
                found = [
                    _tracked(second, skew, zeroth, k, *each[1:])
                    for k, each in zip(recent, estimates, strict=True)
                ]
                estimates = found
                passed, history = [*passed, lateral], [*history, np.array([each[0] for each in found])]
                k, shapes, left = (np.stack(each, axis=-1) for each in zip(*found, strict=True))
                left = left[self._surface]
            else:
                k, shapes, left = _all_pairs(second, skew, zeroth, self.section.lateral_odd, self._surface)
            out.append(self._poles(k, shapes, left, first @ shapes - 1j * (second @ shapes) * k, surface))
            surface = next(iter(out[-1].wavenumbers[out[-1].surface & out[-1].right]), surface)
        return out

    def _poles(self, k, shapes, left, flux, expected: complex) -> _Poles:
        """Forward modes that are not local, of eigenpairs with their left eigenvectors (4, m) and fluxes."""
        section, unit = self.section, self.section.length_unit
        nearly_real = abs(k.imag) < NEARLY_REAL * abs(k.real)
        carried = -np.imag(np.sum(flux * shapes.conj(), axis=0))
        right = np.where(nearly_real, carried > 0, k.imag < 0)
        kept = (~nearly_real | (right == (k.real > 0))) & (
            abs(k.imag) < LOCAL * self.wavenumber * unit / (2 * np.pi)
        )
        surface = np.zeros(len(k), dtype=bool)
        for side in (
            right,
            ~right,
        ):  # the most localised mode near that of the k_y before, and its twin in a plate
            apart = abs(k) / abs(expected * unit) - 1
            share = section.surface_share(shapes) / (1 + (apart / NEAR) ** 2) * (side & nearly_real & kept)
            best = np.argmax(share)
            surface |= (share > TWIN_SHARE * share[best]) & (abs(k / k[best] - 1) < TWIN_DISTANCE)
        turn = np.ones((4, 1), dtype=complex)
        if section.solid.mirror_y is not None:  # fields that change sign under y -> -y are scaled by i
            turn[section.solid.mirror_y] = 1j
        shapes, left = turn * shapes[self._surface], turn.conj() * left
        scale = charge_scale(section.solid)
        column, row = scale * shapes[:3] * left[3], scale * shapes[3] * left[:3]
        return _Poles(k[kept] / unit, right[kept], surface[kept], column.T[kept], row.T[kept])


def _all_pairs(second, skew, zeroth, odd, at) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All wavenumbers of both directions, (2 n,), their shapes (n, 2 n) and some rows of the left ones."""
    if odd is not None:
        k, shapes = even_odd_modes(second, skew, zeroth, odd)
        k, shapes = np.append(k, -k), np.hstack([shapes, np.where(odd, -1.0, 1.0)[:, None] * shapes])
    else:
        k, shapes = companion_modes(second, 1j * skew, zeroth)
    shapes = shapes / np.linalg.norm(shapes, axis=0) / np.maximum(1.0, abs(k))
    load = np.zeros((len(k), len(at)), dtype=complex)
    load[len(second) :] = np.linalg.solve(second, np.eye(len(second))[:, at])
    return k, shapes, np.linalg.solve(np.vstack([shapes, shapes * k]), load).T


def _tracked(second, skew, zeroth, k: complex, right: np.ndarray, left: np.ndarray):
    """Eigenvalue and both eigenvectors of L next to an estimate: two-sided Rayleigh quotient iteration."""
    from scipy.linalg import lu_factor, lu_solve

    for _ in range(MAX_ITERATIONS):
        matrix, slope = k**2 * second + 1j * k * skew + zeroth, 2 * k * second + 1j * skew
        factor = lu_factor(matrix, check_finite=False)
        right = lu_solve(factor, slope @ right, check_finite=False)
        left = lu_solve(factor, slope.T @ left, trans=1, check_finite=False)
        right, left = right / np.linalg.norm(right), left / np.linalg.norm(left)
        step = (left @ matrix @ right) / (left @ slope @ right)
        k -= step
        if abs(step) < FOLLOWED * abs(k):
            return k, right, left / (left @ slope @ right)
    raise ConvergenceError(LOST)


def _barycentric(places: np.ndarray, at: complex) -> np.ndarray:
    """Weights of values at some places for the polynomial through them elsewhere, shape of the places."""
    here = abs(at - places) < 1e-14 * abs(places).max()
    if here.any() or len(places) == 1:
        return here.astype(float) if here.any() else np.ones(1)
    spread = np.ptp(places)
    apart = (places[:, None] - places) / spread + np.eye(len(places))
    weights = 1 / (np.prod(apart, axis=1) * (at - places))
    return weights / weights.sum()


def follows_one_mode(stator: Stator) -> bool:
    """True if the surface wave alone is followed: below it modes of oblique waves grow in the absorbing layer.

    In a selective layer none grows (tests/fem/discretize/test_absorber.py): all modes together are the half-space.
    """
    return stator.absorbs_below and absorber_kind(stator.solid) != "selective"


def cut_source(fields: PortFields) -> CutSource:
    """Source of a solved stator, from the solution's resolution without its edge layers."""
    modes = fields.modes
    section = discretise(
        fields.stator,
        Resolution(order=fields.resolution.order, edge_layers=0, absorber=fields.resolution.absorber),
        wavelength=modes.section.length_unit,
        surface_scale=np.inf,
        lateral=True,
    )
    surface = modes.rayleigh
    ratio = section.length_unit / modes.section.length_unit
    followed = (modes.wavenumbers[surface[0]] * ratio, modes.backwards[surface[0]] * ratio)
    return CutSource(
        section=section,
        frequency=modes.frequency,
        wavenumber=float(np.mean(modes.wavenumbers[surface].real) / modes.section.length_unit),
        followed=followed if follows_one_mode(fields.stator) else (),
    )
