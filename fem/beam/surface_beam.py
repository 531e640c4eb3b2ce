"""Surface motion in three dimensions of a stator whose fingers end at y = +-W/2, per volt of the source.

A finger's charge is a sum of sheets, uniform over |y| < L_b / 2 (charges.py): the aperture and, for solids isotropic
about z between absorbing ends, shorter ones, by the mean potentials over the fingers (own_aperture.py, reception.py);
in other cuts and between reflecting ends it is the section's, uniform along y.  For every lateral wavenumber the bare
stator's response to it is a sum of guided modes (line_source.py): at x, what the charges q_j to the left send,

    u(x, y) = int dk_y / 2 pi  W sinc(k_y W / 2) exp(-i k_y y) sum_p a_p(k_y) sum_j q_j exp(-i kappa_p (x - x_j)),

for a sheet of length W, and the same from the right.  The contributions of all transducers add up: massless fingers
scatter by their charges alone.  So the field is known between and under the fingers too.  Free and clamped ends add
what they send back at each k_y (faces.py).

On the axis y = 0, u_y vanishes by symmetry.

Nothing nearer than a wavelength to the fingers' ends is resolved (evanescent modes that reach less far end there with
the aperture).  A strongly coupled plate mode near its cut-off changes the charge all along short fingers
(tests/fem/beam/test_volume.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fem.beam.charges import MAX_PHASE, ChargeSheet, ElectrodeCharges, Fingers, electrode_charges
from fem.beam.cut_source import CutSource, cut_source
from fem.beam.faces import Faces, faces
from fem.beam.line_source import Branch, LineSource, line_source
from fem.beam.own_aperture import STEPS
from fem.beam.reception import refuse_short_apertures, with_apertures
from fem.circuit import Circuit
from fem.geometry import Stator
from fem.materials import isotropic_about_normal
from fem.results.driven_answer import SurfaceWave
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.solution import Solution, driven_solution

GROUPS = (
    1.0,
    8.0,
)  # wavelengths from the charges between which points share a rule; nothing nearer is resolved in y
# of the difference to fewer steps along the fingers that is left; 0.2 to 0.4 seen (test_finger_ends.py)
COARSER_SHARE = 0.5
CHUNK = 2000  # points at a time whose distances to all fingers, or whose spectra, are tabulated
FULL_GRID = 4  # points of the grid of all x and y per point asked for, up to which the whole grid is computed
RULES = 4  # of the integral over k_y: all nodes, half, a quarter, and an earlier end
TINY = 1e-300
SAME_STEP = 1e-15  # m: steps from node to node that differ by less share their phases


class BeamError(ValueError):
    """A stator whose field in three dimensions is not covered, and why."""


@dataclass(frozen=True, kw_only=True)
class SurfaceBeam:
    """Surface motion in three dimensions.

    Attributes
    ----------
    wave : SurfaceWave
        Of the section.
    solution : Solution
        Ports and circuit with each transducer receiving the mean of the beams over its aperture.
    source : LineSource or CutSource
    charges : tuple of ElectrodeCharges
        Of each transducer from left to right.
    apertures, centers : tuple of float
        Sizes and middles along y, m.
    mirror_width : float or None
        m between two side faces that reflect like mirrors; None where nothing comes back from the sides.
    complete : bool
        Whether all modes of the section take part.
    faces : Faces or None
        Free or clamped ends; None where they absorb.

    Examples
    --------
    >>> beam = surface_beam(wave)  # doctest: +SKIP
    >>> u_x, u_y, u_z = beam.motion(0.08, 0.0)  # doctest: +SKIP
    """

    wave: SurfaceWave
    solution: Solution = field(repr=False)
    source: LineSource | CutSource = field(repr=False)
    charges: tuple[ElectrodeCharges, ...] = field(repr=False)
    apertures: tuple[float, ...]
    centers: tuple[float, ...]
    mirror_width: float | None = None
    complete: bool = True
    faces: Faces | None = field(default=None, repr=False)

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V.

        Parameters
        ----------
        x, y : float or ndarray
            m from the stator's left end and from its middle line; broadcast against each other.  Many
            points at few x, or on a grid, cost little more than few points.

        Returns
        -------
        ndarray, shape (3, *shape of x and y)

        Raises
        ------
        BeamError
            Outside the stator.
        """
        return self._by_rules(x, y)[0]

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Estimate of the error over max(|u_x|, |u_z|) at each point: the integral's, the section's, the modes'.

        The integral's follows from half and a quarter of the nodes, whose errors e_2 and e_4 make e_2^2 / e_4 probable:
        right where errors fall by a power of the spacing, stay or, with e_4 near 1, fall exponentially.  In cuts whose
        integral ends before all waves are evanescent along x, what an earlier end changes is added.  The section's
        error is relative to the section's amplitude, which interference may make larger than the beam's.  The modes' is
        what their sum at k_y = 0 leaves of the section's motion; nearer than a wavelength to the fingers the field
        contains it as far as the aperture goes.
        """
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion` and `relative_error` at once."""
        fine, half, quarter, narrow = self._by_rules(x, y)
        size = abs(fine[[0, 2]]).max(axis=0)
        largest = float(size.max())
        second, fourth = (abs(fine - each).max(axis=0) / largest for each in (half, quarter))
        rule = second**2 / np.clip(fourth, np.maximum(second, TINY), 1.0) * largest / size
        rule = rule + abs(fine - narrow).max(axis=0) / size
        if self.faces is not None:  # whose static part depends on |k_y|
            static = self._returned(*(each.ravel() for each in np.broadcast_arrays(x, y)), self.faces.static)
            rule = rule + abs(static[0, 0]).reshape(size.shape) / size
        places, where = np.unique(np.broadcast_to(x, size.shape), return_inverse=True)
        of_places = (self.wave.motion(places), self._beyond_the_modes(places))
        section, left_out = (abs(each).max(axis=0)[where.reshape(size.shape)] for each in of_places)
        left_out = np.maximum(left_out, self.source.error * section)
        return fine, rule + (np.maximum(size, section) * self.wave.relative_error + left_out) / size

    @property
    def length(self) -> float:
        """Of the surface, m."""
        return self.wave.length

    def in_section(self, x: float, y: float) -> float:
        """Where a place in m lies on the line of the section `wave`, m."""
        return x

    @property
    def circuit(self) -> Circuit:
        """Voltages and currents that belong to the motion."""
        return self.solution.circuit

    @cached_property
    def power(self) -> PowerBalance:
        """Where the power goes, of the mean waves over the apertures."""
        if self.solution.fields is self.wave.solution.fields:
            return self.wave.power
        return power_balance(self.solution)

    @cached_property
    def coarser(self) -> "SurfaceBeam | None":
        """The same with fewer steps of the charge along the fingers; None where the charge has none."""
        steps = [len(each.steps) for each in self.charges]
        if not any(steps):
            return None
        fields = self.wave.solution.fields
        for fineness in range(1, len(STEPS)):
            fewer = with_apertures(fields, self.mirror_width, fineness)
            found = aperture_beam(self.wave, Solution(fields=fewer, circuit=self.circuit), self.mirror_width)
            if [len(each.steps) for each in found.charges] != steps:
                return found
        return None

    def charge_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray | None:
        """What is left of |u_z| by the steps of the charge along the fingers: against fewer of them.

        It bounds the difference to 100 steps in combs of PZT (tests/fem/beam/test_finger_ends.py).  None where the
        charge is uniform along the fingers.
        """
        if self.coarser is None:
            return None
        here = self.motion(x, y)[2]
        return COARSER_SHARE * abs(abs(self.coarser.motion(x, y)[2]) - abs(here)) / abs(here)

    def unresolved(self, x: float, y: float) -> bool:
        """Return whether a place (m) is beside fingers or within a wavelength of their ends, in a cut of `CutSource`.

        What leaves at more than 45 degrees is left out there, which the error does not contain: 0.06 to 6 of the motion
        on YZ lithium niobate, 0.01 from a wavelength before the fingers on.
        """
        near = abs(self._resolved)
        return isinstance(self.source, CutSource) and any(
            each.extent[0] - near < x < each.extent[1] + near
            and abs(y - each.center_y) > each.aperture / 2 - near
            for each in self.solution.fields.transducers
        )

    def with_side_faces(self, width: float | None) -> "SurfaceBeam":
        """The same charges between mirrors a width apart, or None, in m; the waves to 1e-3, for an estimate."""
        return replace(self, mirror_width=width, source=self.source.rough)

    def with_longer_fingers(self, periods: float) -> "SurfaceBeam":
        """The same charges per length on fingers that are longer at both ends, by a part of their period."""
        longer = (each.aperture + 2 * periods * each.period for each in self.solution.fields.transducers)
        return replace(self, apertures=tuple(longer))

    @property
    def surface_mode(self) -> "SurfaceBeam":
        """The part of the field that the surface wave alone carries."""
        returned = self.faces and self.faces.surface_mode
        return replace(self, source=self.source.surface_mode, complete=False, faces=returned)

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Slowness curve: wavenumber along x of the surface wave, as it decays, at real lateral wavenumbers, rad/m.

        Its slope at 0 is minus the tangent of the power-flow angle; -k times its second derivative is 1 + gamma.
        """
        return self.source.surface_wavenumbers(np.asarray(lateral, dtype=float))

    @cached_property
    def _sheets(self) -> list[ChargeSheet]:
        """Uniform charges of all transducers from left to right."""
        each = zip(self.charges, self.apertures, self.centers, strict=True)
        return [sheet for charges, aperture, center in each for sheet in charges.sheets(aperture, center)]

    @cached_property
    def _nodes(self) -> "_Nodes":
        return _nodes_of(self._sheets)

    @cached_property
    def _section_nodes(self) -> "_Nodes":
        return _nodes_of(self._section_charges)

    @cached_property
    def _section_charges(self) -> tuple[ElectrodeCharges, ...]:
        return _charges_of(self.wave.solution)

    def _by_rules(self, x, y) -> tuple[np.ndarray, ...]:
        """Motion by the rule, by half and a quarter of its nodes, and by one that ends at smaller k_y."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        shape, x, y = x.shape, x.ravel(), y.ravel()
        self._refuse(x, y)
        distance = self._distances(x)
        group = np.searchsorted(np.divide(GROUPS, GROUPS[0]) * self._resolved, distance)
        total = np.empty((RULES, 3, len(x)), dtype=complex)
        for number in set(group.tolist()):
            some = group == number
            total[..., some] = self._modal(x[some], y[some], float(distance[some].min()))
            if self.complete and number == 0:
                total[..., some] += self._local(x[some], y[some])
        if self.mirror_width is None:
            total += self._static(x, y)
        if self.faces is not None:
            total += self._returned(x, y, self.faces.wanted)
        return tuple(total.reshape(RULES, 3, *shape))

    def _refuse(self, x, y):
        if not np.all((x >= 0) & (x <= self.wave.length)):
            raise BeamError(f"x must lie on the stator, 0 to {self.wave.length:g} m")
        limit = np.inf if self.mirror_width is None else self.mirror_width / 2
        if not np.all(np.isfinite(y) & (abs(y) <= limit)):
            raise BeamError(f"y must be finite and lie between the side faces, +-{limit:g} m")

    def _modal(self, x, y, distance: float) -> np.ndarray:
        """Sum of the modes at points at least a distance from all charges, by all rules, (RULES, 3, points)."""
        places, column = np.unique(x, return_inverse=True)
        lines, row = np.unique(y, return_inverse=True)
        total = np.zeros((RULES, 3, len(x)), dtype=complex)
        for branch in self.source.branches(self._reach(y), distance, self._resolved, self.mirror_width):
            total += self._inverse(
                branch,
                lambda spectra, branch=branch: _sent(self._nodes, branch, places, spectra),
                lines,
                column,
                row,
            )
        return total

    def _returned(self, x, y, modes) -> np.ndarray:
        """What the faces send back in some modes, by all rules, (RULES, 3, points)."""
        places, column = np.unique(x, return_inverse=True)
        lines, row = np.unique(y, return_inverse=True)
        found = self.faces.returned(self._reach(y), _sources(self._sheets), self.mirror_width)
        return self._inverse(
            found, lambda spectra: found.spectra(places, self.wave.length, spectra, modes), lines, column, row
        )

    def _reach(self, y) -> float:
        """Farthest lateral distance from points to an end of a finger, m."""
        spans = np.subtract.outer(y, self.centers)
        return float((abs(spans) + np.divide(self.apertures, 2)).max())

    def _inverse(self, waves, sent_by, lines, column, row) -> np.ndarray:
        """Fields of waves at points, by all rules, (RULES, 3, points); ``column`` of the places, ``row`` of y.

        ``sent_by``: spectra of u at the places, (places, 3, n), from those of the apertures, (transducers, n).
        """
        count, sent = len(column), None
        lateral, weights = waves.rule.nodes, waves.rule.weights / 2
        narrow = None if np.all(waves.rule.share == 1.0) else weights * waves.rule.share
        lengths, centers = (
            np.array([getattr(each, name) for each in self._sheets]) for name in ("length", "center")
        )
        uniform = lengths[:, None] * np.sinc(np.outer(lengths, lateral / (2 * np.pi)))
        total = np.zeros((RULES, 3, count), dtype=complex)
        for sign, factors in waves.signs:
            if sent is None or centers.any():
                sent = sent_by(uniform * np.exp(1j * sign * np.outer(centers, lateral)))
            phases = np.exp(-1j * sign * np.outer(lateral, lines))
            half, quarter = (1, 1) if self.mirror_width is not None else (2, 4)
            rules = (1, weights), (half, half * weights), (quarter, quarter * weights), (1, narrow)
            for rule, (step, own) in enumerate(rules):
                if own is None:
                    total[rule] = total[0]
                    continue
                weighted = factors[:, None] * sent[..., ::step] * own[::step]
                if len(sent) * len(lines) <= FULL_GRID * count:
                    total[rule] += (weighted @ phases[::step])[column, :, row].T
                else:
                    for start in range(0, count, CHUNK):
                        some = slice(start, start + CHUNK)
                        total[rule][:, some] += np.einsum(
                            "pcn,np->cp", weighted[column[some]], phases[::step, row[some]]
                        )
        return total

    def _local(self, x, y) -> np.ndarray:
        """What the section has beyond the modes above, within the aperture of the nearest transducer, (3, points)."""
        places, column = np.unique(x, return_inverse=True)
        nodes = self._section_nodes
        nearest = nodes.owner[abs(places[:, None] - nodes.x).argmin(axis=1)]
        owner = nearest[column]
        within = abs(y - np.array(self.centers)[owner]) < np.divide(self.apertures, 2)[owner]
        return np.insert(self._beyond_the_modes(places), 1, 0.0, axis=0)[:, column] * within

    def _distances(self, x) -> np.ndarray:
        """Of places to the nearest charge, m."""
        nodes = self._nodes.x
        after = np.searchsorted(nodes, x).clip(1, len(nodes) - 1)
        return np.minimum(abs(x - nodes[after - 1]), abs(x - nodes[after]))

    def _beyond_the_modes(self, places) -> np.ndarray:
        """Motion of the section less that of the modes at k_y = 0 from the same charges, shape (2, places)."""
        nodes, source, ones = self._section_nodes, self.source, np.ones((len(self.apertures), 1))
        sent = sum(_sent(nodes, branch, places, ones) for branch in source.plane(self._resolved))[..., 0]
        if self.faces is not None:
            plane = self.faces.plane(_sources(self._section_charges))
            sent = sent + plane.spectra(places, self.wave.length, ones, self.faces.wanted)[..., 0]
        to_the_left = np.append(0.0, np.cumsum(nodes.charge))[np.searchsorted(nodes.x, places, side="right")]
        rest = self.wave.motion(places) - sent.T[[0, 2]]
        rest[0] -= source.static * (2 * to_the_left - nodes.charge.sum())
        return rest

    @property
    def _resolved(self) -> float:
        return GROUPS[0] * self.wave.phase_velocity / self.wave.frequency

    def _static(self, x, y) -> np.ndarray:
        """Field of the pole at k = 0, where kappa = -i |k_y|, in closed form, shape (3, points).

        The integral over k_y of a charge at a distance X is a Laplace transform: with b = W/2 +- y, sum of
        arctan(b / X) / pi for u_x and difference of log(X^2 + b^2) / 2 pi for u_y.
        """
        out = np.zeros((3, len(x)), dtype=complex)
        if self.source.static == 0:
            return out
        for sheet in self._sheets:
            nodes, charge = sheet.lumps
            for start in range(0, len(x), CHUNK):
                some = slice(start, start + CHUNK)
                distance = np.subtract.outer(x[some], nodes)
                above, below = (sheet.length / 2 + sign * (y[some, None] - sheet.center) for sign in (1, -1))
                inward = np.arctan2(above, abs(distance)) + np.arctan2(below, abs(distance))
                sideways = 0.5 * np.log((distance**2 + above**2) / (distance**2 + below**2))
                out[0, some] += (np.sign(distance) * inward) @ charge
                out[1, some] += sideways @ charge
        return out * (self.source.static / np.pi)


class _Nodes(NamedTuple):
    """Places and charges of all nodes from left to right, and the transducers and fingers that they belong to."""

    x: np.ndarray
    charge: np.ndarray
    owner: np.ndarray
    finger: np.ndarray


def beam_refusal(stator: Stator) -> str:
    """Why the field in three dimensions of a stator is not known, in a sentence; empty where it is."""
    if stator.pieces:
        return "the field in three dimensions of a stator with meshed pieces is not computed"
    if stator.ends != "absorbing" and not isotropic_about_normal(stator.solid):
        return (
            f"in this cut the field in three dimensions needs stator.ends = 'absorbing', got {stator.ends!r}"
        )
    return ""


def _charges_of(solution: Solution) -> tuple[ElectrodeCharges, ...]:
    return tuple(electrode_charges(solution, index) for index in range(len(solution.fields.transducers)))


def _sources(charges: Sequence[ElectrodeCharges | ChargeSheet]) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(each.x, each.charge) for each in charges]


def _nodes_of(charges: Sequence[ElectrodeCharges | ChargeSheet]) -> _Nodes:
    owner = np.repeat(np.arange(len(charges)), [len(each.x) for each in charges])
    number = np.concatenate([each.finger for each in charges])
    another = (np.diff(number, prepend=number[0]) != 0) | (np.diff(owner, prepend=0) != 0)
    return _Nodes(
        x=np.concatenate([each.x for each in charges]),
        charge=np.concatenate([each.charge for each in charges]),
        owner=owner,
        finger=np.cumsum(another),
    )


def _sent(nodes: _Nodes, branch: Branch, places, spectra) -> np.ndarray:
    """Spectra of u at places from the charges that send a branch there, shape (places, 3, n)."""
    side, along = branch.side, branch.along
    out = np.zeros((len(places), 3, len(spectra[0])), dtype=complex)
    if not along.size:
        return out
    sources, owners, amplitudes = _sources_beside(nodes, places, side * along)
    count = len(sources)
    at = side * np.append(sources, places)
    is_place = np.arange(len(at)) >= count
    arrived = np.zeros((len(along), len(spectra[0])), dtype=complex)
    steps: dict[int, np.ndarray] = {}
    before, sends = 0.0, False
    for number in np.lexsort((side * is_place, at)):  # a charge counts at its own place, once
        if sends and at[number] != before:
            key = round((at[number] - before) / SAME_STEP)
            if key not in steps:
                steps[key] = np.exp(-1j * along * (at[number] - before))
            arrived *= steps[key]
        before = at[number]
        if not is_place[number]:
            arrived += amplitudes[number] * spectra[owners[number]]
            sends = True
        elif sends:
            out[number - count] = np.einsum("cmn,mn->cn", branch.motion, arrived)
    return out


def _sources_beside(nodes: _Nodes, places, along) -> tuple[np.ndarray, np.ndarray, list]:
    """Places of the charges, their transducers, and what each sends, a number or of the shape of ``along`` (signed).

    A finger on which no place lies counts as one, by the exponentials' Taylor series about its middle.
    """
    fingers = Fingers.of(nodes.x, nodes.charge, nodes.finger)
    ordered = np.sort(places)
    whole = np.searchsorted(ordered, fingers.first) == np.searchsorted(ordered, fingers.last, side="right")
    whole &= fingers.phase(along).max() < MAX_PHASE
    single = ~whole[nodes.finger]
    owners = nodes.owner[np.searchsorted(nodes.finger, np.flatnonzero(whole))]
    return (
        np.append(fingers.middles[whole], nodes.x[single]),
        np.append(owners, nodes.owner[single]),
        [*fingers._replace(moments=fingers.moments[whole]).sums(along), *nodes.charge[single]],
    )


def surface_beam(wave: SurfaceWave, *, mirror_width: float | None = None) -> SurfaceBeam:
    """Field in three dimensions of a driven stator, from the section's solution.

    Parameters
    ----------
    wave : SurfaceWave
        Of `fem.driven_wave`.  Between free or clamped ends, and unless the solid is isotropic about z, the first
        evaluation takes some seconds, for a problem at every lateral wavenumber, and transducers receive as in the
        section.
    mirror_width : float, optional
        Distance in m of two side faces that reflect like mirrors (u_y = 0, no shear traction); without, the stator is
        infinitely wide.  Free faces are neither: the difference shows how much the width could matter.  In cuts without
        the symmetry y -> -y the images repeat the field, unmirrored.

    Returns
    -------
    SurfaceBeam

    Raises
    ------
    BeamError
        For free or clamped ends in cuts that are not isotropic about z, and a width smaller than an aperture.
    InputError
        For an aperture below half a wavelength.
    """
    solution = wave.solution
    refusal = beam_refusal(solution.fields.stator)
    if refusal:
        raise BeamError(refusal)
    refuse_short_apertures(solution.fields.transducers, wave.phase_velocity / wave.frequency)
    apertures = tuple(each.aperture for each in solution.fields.transducers)
    if mirror_width is not None and not max(apertures) <= mirror_width < np.inf:
        raise BeamError(
            f"mirror_width must be at least the largest aperture, {max(apertures):g} m, got {mirror_width!r}"
        )
    isotropic = isotropic_about_normal(solution.fields.stator.solid)
    centers = tuple(each.center_y for each in solution.fields.transducers)
    if any(centers) and (mirror_width is not None or not isotropic):
        raise BeamError(
            "transducers beside the middle line need a solid isotropic about z and absorbing sides"
        )
    fields = with_apertures(solution.fields, mirror_width)
    if fields is not solution.fields:
        solution = driven_solution(fields, solution.circuit.drive)
    return aperture_beam(wave, solution, mirror_width)


def aperture_beam(wave: SurfaceWave, solution: Solution, mirror_width: float | None = None) -> SurfaceBeam:
    """Field of the charges of a solution, whose circuit may be part of a larger one."""
    transducers, stator = solution.fields.transducers, solution.fields.stator
    isotropic = isotropic_about_normal(stator.solid)
    source = line_source(solution.fields.modes) if isotropic else cut_source(solution.fields)
    return SurfaceBeam(
        wave=wave,
        solution=solution,
        source=source,
        faces=None if stator.ends == "absorbing" else faces(solution.fields, source),
        charges=_charges_of(solution),
        apertures=tuple(each.aperture for each in transducers),
        centers=tuple(each.center_y for each in transducers),
        mirror_width=mirror_width,
    )
