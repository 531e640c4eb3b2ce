"""Charges and forces on the surface become a beam: sheets, their lateral spectra, and the motion that they send.

A sheet is a charge on nodes x_j of the surface, uniform along y over |y - y_0| < W / 2; a force on a strip is a sheet
of one node, with N/m instead of C/m.  Along y the charge of a finger is a sum of sheets: one over the whole aperture,
and shorter ones with the same middle, which together make a charge that is concentrated at the finger's ends
(own_aperture.py).  For every lateral wavenumber k_y the bare stator's response to a line of charge or of force
(`ModeSource`) is a sum of guided modes p, of motion M_p and wavenumber kappa_p along x.  The charges q_j at x_j < x
contribute at x, for a sheet of length W,

    u(x, y) = int dk_y / 2 pi  s(k_y) exp(-i k_y y) sum_p M_p sum_j q_j exp(-i kappa_p (x - x_j)),               (1)
    s(k_y) = W sinc(k_y W / 2) exp(i k_y y_0),

and those to the right of x contribute a similar sum over the modes that run to the left.

`Emitter.spectra` sums over the charges and modes at the k_y of a quadrature rule, `EmittedBeam.by_rules` integrates.
`surface_beam.SurfaceBeam` adds what the ends of the stator reflect (`faces.py`) and the near field beyond the modes.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from itertools import groupby
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import RULES, Points, inverse_transform
from fem.beam.line_source import Branch, ModeSource

# Largest phase k a in rad, with a half a finger's width, for which exp(i k x) is summed as a Taylor series, and its
# number of terms: 3^28 / 28! = 8e-17 is rounding.
MAX_PHASE, TERMS = 3.0, 28
SAME_STEP = 1e-15  # m: steps from node to node that differ by less share their phase factors
# Distances from the nearest charge, in wavelengths, between the groups of points that share a quadrature rule in k_y.
GROUPS = (1.0, 8.0)
CHUNK = 2000  # points for which distances are tabulated at a time, to limit memory
# The spacing of the nodes in k_y is halved, at most MAX_HALVINGS times, until two rules agree (`Agreement`).  It is too
# wide where the power of a wave leaves obliquely: such a wave grows along the complex contour, and the more the farther
# the point is.
MAX_HALVINGS = 4


class Agreement(NamedTuple):
    """When a rule is fine enough: how little it differs from the rule with every second of its nodes.

    Attributes
    ----------
    share : float
        Largest difference over the motion at each point.
    least : float
        Least motion that counts, over the largest one of all points.
    """

    share: float
    least: float

    def reached(self, fine: np.ndarray, coarse: np.ndarray) -> bool:
        """True if two motions agree, shape (3, points) each."""
        size, difference = (abs(each).max(axis=0) for each in (fine, fine - coarse))
        return bool(np.all(difference <= self.share * np.maximum(size, self.least * size.max())))


# Of pictures, whose scale is the largest motion.  On the shipped motor of YZ lithium niobate the first rule then errs
# by up to 1.3 % of that beside fingers, 0.1 % in the mean, in an eighth of the time of `AT_POINTS`.
AT_POINTS, IN_PICTURES = Agreement(0.03, 0.1), Agreement(0.1, 1.0)


class Fingers(NamedTuple):
    """First and last node of every finger (m), half the largest width (m), and the moments of the charges.

    With a = ``half_width`` and x_0 the middle of a finger, its moments and the transform of its charges are

        M_n = sum_j q_j ((x_j - x_0) / a)^n,                                                                (2)
        sum_j q_j exp(i k (x_j - x_0)) = sum_n (i k a)^n / n! M_n.                                          (3)
    """

    first: np.ndarray
    last: np.ndarray
    half_width: float
    moments: np.ndarray  # shape (..., fingers, TERMS)

    @classmethod
    def of(cls, x: np.ndarray, charge: np.ndarray, finger: np.ndarray) -> "Fingers":
        """Return the fingers of charges at nodes x from left to right, (..., nodes).

        ``finger``: number of each node's finger, (nodes,).
        """
        starts = np.flatnonzero(np.diff(finger, prepend=finger[0] - 1))
        stops = np.append(starts[1:], len(x))
        first, last = x[starts], x[stops - 1]
        # ``tiny`` avoids a division by zero if every finger is a single node (a line of charge)
        half = float((last - first).max()) / 2 or np.finfo(float).tiny
        local = (x - np.repeat((first + last) / 2, stops - starts)) / half
        moments = np.add.reduceat(charge[..., None] * np.vander(local, TERMS, increasing=True), starts, axis=-2)
        return cls(first, last, half, moments)

    @property
    def middles(self) -> np.ndarray:
        """Return x of the centres of the fingers, m."""
        return (self.first + self.last) / 2

    @property
    def lumps(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m) and sizes of three point charges per finger, for static fields: (n,) and (..., n).

        The charges (M_2 - M_1)/2, M_0 - M_2 and (M_2 + M_1)/2 at the finger's left end, middle and right end have its
        total charge, dipole moment and second moment.  Here the unit of length of M_n is half the finger's own width.
        """
        half = np.maximum(self.last - self.first, np.finfo(float).tiny) / 2  # ``tiny``: as in `of`
        total, dipole, second = (self.moments[..., power] * (self.half_width / half) ** power for power in range(3))
        positions = np.concatenate([self.middles - half, self.middles, self.middles + half])
        return positions, np.concatenate([(second - dipole) / 2, total - second, (second + dipole) / 2], axis=-1)

    def phase(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return the phase of waves across half a finger, rad; below MAX_PHASE the series of `sums` is accurate."""
        return abs(wavenumbers) * self.half_width

    def powers(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return (i k a)^n / n! of equation (3), shape (TERMS, *shape of k)."""
        ratios = np.multiply.outer(1j * self.half_width / np.arange(1, TERMS), wavenumbers)  # i k a / n
        return np.cumprod(np.concatenate([np.ones((1, *wavenumbers.shape)), ratios]), axis=0)

    def sums(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return the transform (3) of the charges of each finger, shape (fingers, *shape of k)."""
        return np.tensordot(self.moments, self.powers(wavenumbers), axes=1)


@dataclass(frozen=True)
class ChargeSheet:
    """Charges that are uniform over |y - center| < length / 2; x, charge and finger as in `ElectrodeCharges`."""

    x: np.ndarray
    charge: np.ndarray
    finger: np.ndarray
    length: float
    center: float

    @cached_property
    def fingers(self) -> Fingers:
        """Fingers and the moments of their charges."""
        return Fingers.of(self.x, self.charge, self.finger)

    def transform(self, wavenumbers: np.ndarray, origin: float) -> np.ndarray:
        """T(k) = sum_j q_j exp(i k (x_j - x_0)) in C/m per V, for k in rad/m of any shape and x_0 = ``origin`` in m.

        Small k by finger, equation (3); large k by node.
        """
        k, fingers = np.asarray(wavenumbers), self.fingers
        out = np.empty(k.shape, dtype=complex)
        small = fingers.phase(k) < MAX_PHASE
        phases = np.exp(1j * np.multiply.outer(fingers.middles - origin, k[small]))
        out[small] = np.sum(fingers.sums(k[small]) * phases, axis=0)
        out[~small] = np.exp(1j * np.multiply.outer(k[~small], self.x - origin)) @ self.charge
        return out


class Strip(NamedTuple):
    """A force on a strip of the surface: a sheet of one node with N/m for its charge, and the stator's response."""

    sheet: ChargeSheet
    source: ModeSource


@dataclass(frozen=True)
class Emitter:
    """Sheets from left to right that send waves by one source; a sheet of force has N/m for its charge."""

    source: ModeSource
    sheets: list[ChargeSheet]

    @cached_property
    def x(self) -> np.ndarray:
        """Positions of the nodes of all sheets, m."""
        return np.concatenate([each.x for each in self.sheets])

    @cached_property
    def charge(self) -> np.ndarray:
        """Charges of the nodes."""
        return np.concatenate([each.charge for each in self.sheets])

    @cached_property
    def on_same_nodes(self) -> list[tuple[slice, ChargeSheet, np.ndarray, Fingers]]:
        """Sheets that share their nodes: their numbers, the first of them, all charges (sheets, nodes), and moments."""
        out, first = [], 0
        for _, same_nodes in groupby(self.sheets, key=lambda sheet: id(sheet.x)):
            sheets = list(same_nodes)
            charge = np.stack([each.charge for each in sheets])
            fingers = Fingers.of(sheets[0].x, charge, sheets[0].finger)
            out.append((slice(first, first + len(sheets)), sheets[0], charge, fingers))
            first += len(sheets)
        return out

    @cached_property
    def _widest(self) -> Fingers:
        """Fingers of the sheets that have the widest one."""
        return max((fingers for *_, fingers in self.on_same_nodes), key=lambda fingers: fingers.half_width)

    def plane_waves(self, positions: np.ndarray, distance: float) -> np.ndarray:
        """Motion u at k_y = 0 and positions in m by the modes that reach a distance in m, shape (positions, 3)."""
        ones = np.ones((len(self.sheets), 1))
        return np.sum([self.spectra(branch, positions, ones) for branch in self.source.plane(distance)], axis=0)[..., 0]

    def spectra(self, branch: Branch, positions: np.ndarray, shapes: np.ndarray) -> np.ndarray:
        """Spectra of u at the positions ``positions`` by all charges upstream of them in one branch, (positions, 3, n).

        u^(x) = sum_m M_m sum_j q_j s_j exp(-i kappa_m |x - x_j|) with the modes m of the branch, their motion M_m, and
        the charges q_j at x_j upstream of x on sheets of spectrum s_j, the rows of ``shapes``, (sheets, n).  The inner
        sum is carried from charge to charge: it is multiplied by exp(-i kappa_m d) over each distance d, and q_j s_j is
        added at each charge.
        """
        side, along = branch.side, branch.along
        out = np.zeros((len(positions), 3, shapes.shape[1]), dtype=complex)
        if not along.size:
            return out
        short = self._widest.phase(along).max(axis=1) >= MAX_PHASE
        if short.any() and not short.all():  # few modes need every node of a finger, the others its moments
            long, rest = (branch._replace(along=along[some], motion=branch.motion[:, some]) for some in (~short, short))
            return self.spectra(long, positions, shapes) + self.spectra(rest, positions, shapes)
        sources, waves = self._sources_beside(positions, side * along, shapes)
        count = len(sources)
        at = side * np.append(sources, positions)
        is_position = np.arange(len(at)) >= count
        arrived = np.zeros((len(along), shapes.shape[1]), dtype=complex)
        steps: dict[int, np.ndarray] = {}
        before, sends = 0.0, False  # position of the last stop; whether any charge lies upstream of it
        # Walk downstream from charge to charge.  The sort counts a charge at its own position in one direction only.
        for number in np.lexsort((side * is_position, at)):
            if sends and at[number] != before:
                key = round((at[number] - before) / SAME_STEP)
                if key not in steps:
                    steps[key] = np.exp(-1j * along * (at[number] - before))
                arrived *= steps[key]
            before = at[number]
            if not is_position[number]:
                arrived += waves[number]
                sends = True
            elif sends:
                out[number - count] = np.einsum("cmn,mn->cn", branch.motion, arrived)
        return out

    def _sources_beside(self, x_of_field, along, shapes) -> tuple[np.ndarray, list[np.ndarray]]:
        """Positions of the charges, and what they send, (modes, n) or, where that is the same for all modes, (n,).

        The charges of all sheets on the same fingers are added.  All charges of a finger without any requested position
        on it are combined to one source at its centre, by the Taylor series of the exponentials about the centre,
        equation (3).  ``along`` is signed by the direction of the branch.
        """
        positions, waves, ordered = [], [], np.sort(x_of_field)
        for numbers, sheet, charge, fingers in self.on_same_nodes:
            # A finger is combined if no requested position lies on it, provided that the series is accurate for the
            # widest finger (MAX_PHASE).  `whole` marks the combined fingers, `single` the nodes of all others.
            whole = np.searchsorted(ordered, fingers.first) == np.searchsorted(ordered, fingers.last, side="right")
            whole &= fingers.phase(along).max() < MAX_PHASE
            single = ~whole[sheet.finger - sheet.finger[0]]
            moments = np.tensordot(shapes[numbers], fingers.moments[:, whole], axes=(0, 0))  # (n, fingers, TERMS)
            of_fingers = moments @ np.moveaxis(fingers.powers(along), 2, 0)  # (n, fingers, modes)
            positions += [fingers.middles[whole], sheet.x[single]]
            waves += [*of_fingers.transpose(1, 2, 0), *(charge[:, single].T @ shapes[numbers])]
        return np.concatenate(positions), waves


@dataclass(frozen=True)
class EmittedBeam:
    """Motion of the bare surface by emitters, by equation (1).

    Attributes
    ----------
    emitters : list of Emitter
    wavelength : float
        Of the surface wave, m.
    mirror_width : float or None
        Distance in m of two side faces that reflect like mirrors.
    agreement : Agreement
        Of two rules in k_y.
    """

    emitters: list[Emitter]
    wavelength: float
    mirror_width: float | None
    agreement: Agreement = AT_POINTS

    @cached_property
    def nodes(self) -> np.ndarray:
        """Positions of all charges and forces in increasing order, m."""
        return np.sort(np.concatenate([emitter.x for emitter in self.emitters]))

    def distances(self, x: np.ndarray) -> np.ndarray:
        """Distance along x from each point to the nearest charge or force, m."""
        after = np.searchsorted(self.nodes, x).clip(1, max(len(self.nodes) - 1, 1))
        last = len(self.nodes) - 1
        return np.minimum(abs(x - self.nodes[after - 1]), abs(x - self.nodes[np.minimum(after, last)]))

    def reach(self, y: np.ndarray) -> float:
        """Largest distance along y from a point to the end of a finger or of a strip, m."""
        return max(
            float(abs(y - each.center).max()) + each.length / 2 for emitter in self.emitters for each in emitter.sheets
        )

    def near(self, x: np.ndarray) -> np.ndarray:
        """True for points within GROUPS[0] wavelengths of a charge or force, shape (points,)."""
        return self._groups(x) == 0

    def by_rules(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Motion at points in m by all RULES of the integral over k_y, shape (RULES, 3, points)."""
        total = np.empty((RULES, 3, len(x)), dtype=complex)
        distance, group = self.distances(x), self._groups(x)
        for number in set(group.tolist()):
            members = group == number
            total[..., members] = self._converged(x[members], y[members], float(distance[members].min()))
        if self.mirror_width is None:
            total += self._static(x, y)
        return total

    def _groups(self, x: np.ndarray) -> np.ndarray:
        """Number of each point's group, by its distance from the nearest charge."""
        return np.searchsorted(np.multiply(GROUPS, self.wavelength), self.distances(x))

    def _converged(self, x: np.ndarray, y: np.ndarray, distance: float) -> np.ndarray:
        """`modal` with as many nodes in k_y as the points need."""
        for halvings in range(MAX_HALVINGS + 1):
            rules = self.modal(x, y, distance, halvings)
            if self.agreement.reached(rules[0], rules[1]):
                break
        return rules

    def modal(self, x: np.ndarray, y: np.ndarray, distance: float, halvings: int) -> np.ndarray:
        """Sum of the modes at points no nearer than ``distance`` to any charge, shape (RULES, 3, points)."""
        points, reach = Points.of(x, y), self.reach(y)
        total = np.zeros((RULES, 3, len(x)), dtype=complex)
        for emitter in self.emitters:
            for branch in emitter.source.branches(reach, distance, self.wavelength, self.mirror_width, halvings):
                spectra = partial(emitter.spectra, branch, points.x)
                total += inverse_transform(branch, emitter.sheets, points, spectra, self.mirror_width is None)
        return total

    def _static(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Field of the pole at k = 0 in closed form (`ModeSource.static_motion`), shape (3, points)."""
        out = np.zeros((3, len(x)), dtype=complex)
        for emitter in (each for each in self.emitters if each.source.static):
            for numbers, _, _, fingers in emitter.on_same_nodes:
                nodes, charges = fingers.lumps
                for sheet, charge in zip(emitter.sheets[numbers], charges, strict=True):
                    for start in range(0, len(x), CHUNK):
                        chunk = slice(start, start + CHUNK)
                        to_ends = (sheet.length / 2 + sign * (y[chunk, None] - sheet.center) for sign in (1, -1))
                        distances = np.subtract.outer(x[chunk], nodes)
                        along_x, along_y = emitter.source.static_motion(distances, *to_ends)
                        out[0, chunk] += along_x @ charge
                        out[1, chunk] += along_y @ charge
        return out
