"""Proper orthogonal decomposition of the fields on the interface lines between half cells.

The fields of all fingers, all ports and all incident waves, from full solutions at a few frequencies of a band, span
few dimensions.  One basis represents the lines at the middle of gaps, another those at the middle of fingers.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fem.condense.finger_columns import FingerColumns, columns_from_left
from fem.condense.transducer import Condensation, FingerShape, joined_fingers
from fem.discretize.section import Section
from fem.geometry import Transducer
from fem.materials.medium import Medium
from fem.waveguide.end_conditions import Wall, end_reflection
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.port_fields import PortFields

# Width of the condensed layer at a free or clamped end, in wavelengths: too narrow for a resonance in the band
WALL_WIDTH = 0.2
# From the end, in wall widths: where snapshots of the reflected fields are taken
WALL_DISTANCES = (1.0, 1.5, 3.0)
# A mode counts as incident on a transducer if it keeps 0.1 of the smallest retained amplitude over the shortest
# segment, and on an end, where errors of the basis matter less, if it keeps 100 times that over the segment beside it.
INCIDENT_SHARE, INCIDENT_SHARE_AT_END = 0.1, 100.0


@dataclass(frozen=True, kw_only=True)
class ReducedSection:
    """A section whose lines are represented in a basis of fields."""

    full: Section
    basis: np.ndarray = field(repr=False)  # (full size, size): real, orthonormal, each column of one parity
    odd: np.ndarray | None = field(repr=False)  # parity of the columns

    def lift(self, lines: np.ndarray) -> np.ndarray:
        """Unknowns of the full section on lines."""
        return self.basis @ lines

    @property
    def size(self) -> int:
        """Unknowns on a line."""
        return self.basis.shape[1]

    @property
    def solid(self) -> Medium:
        """Medium of the stator."""
        return self.full.solid

    @property
    def length_unit(self) -> float:
        """Unit of length, m."""
        return self.full.length_unit

    @property
    def surface_speed(self) -> float | None:
        """Velocity of the half-space's Rayleigh wave, m/s."""
        return self.full.surface_speed

    @property
    def floating_potential(self) -> bool:
        """True if the potential floats."""
        return self.full.floating_potential

    @cached_property
    def constant_potential(self) -> np.ndarray:
        """The field phi = 1, u = 0, which the basis represents exactly."""
        return self.basis.T @ self.full.constant_potential

    @cached_property
    def surface_rows(self) -> np.ndarray:
        """Rows that give u_x and u_z at the surface, shape (2, size)."""
        return self.full.surface_rows @ self.basis

    @cached_property
    def mechanical(self) -> np.ndarray:
        """Columns with displacements; with clamped ends each column is a displacement or a potential alone."""
        displacement = np.linalg.norm(self.basis[self.full.mechanical], axis=0)
        return np.flatnonzero(displacement > 0.5)

    def surface_share(self, shapes: np.ndarray) -> np.ndarray:
        """Squared motion at the surface over its integral through the depth."""
        return self.full.surface_share(self.basis @ shapes)

    @cached_property
    def _projected(self) -> tuple[np.ndarray, ...]:
        return tuple(self.basis.T @ part @ self.basis for part in self.full.frequency_free_matrices)

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Projected K2, K1, K0 - omega^2 M."""
        second, first, static, mass = self._projected
        return second, first, static - (2 * np.pi * frequency) ** 2 * mass


def parity_groups(section: Section, separate_potential: bool) -> list[np.ndarray]:
    """Unknowns that one basis vector may combine: those of one parity and, if separate, of one kind."""
    odd = section.odd if section.odd is not None else np.zeros(section.size, dtype=bool)
    groups = [odd, ~odd]
    if separate_potential:
        mechanical = np.zeros(section.size, dtype=bool)
        mechanical[section.mechanical] = True
        groups = [group & kind for group in groups for kind in (mechanical, ~mechanical)]
    return [np.flatnonzero(group) for group in groups if group.any()]


def even_transducers(
    make: Condensation, transducers: tuple[Transducer, ...], cell: Callable[[FingerShape], FingerColumns]
) -> list[FingerColumns]:
    """`FingerColumns` of transducers with equal gaps, from the cell of a finger of electrode 0 of each shape."""

    def no_bare_cell(shape):
        raise ValueError("a band of frequencies takes transducers without left-out fingers")

    shapes = [FingerShape.of(each, make.section.length_unit) for each in transducers]
    cells = {shape: cell(shape) for shape in dict.fromkeys(shapes)}
    superelements = {
        (shape, signs): joined_fingers(make, signs, [shape] * len(signs), cells.__getitem__, no_bare_cell)
        for shape, signs in dict.fromkeys((shape, each.signs) for shape, each in zip(shapes, transducers, strict=True))
    }
    return [superelements[shape, each.signs] for shape, each in zip(shapes, transducers, strict=True)]


class Directions(NamedTuple):
    """Left singular vectors and values of the fields on one kind of line, of one group of unknowns."""

    unknowns: np.ndarray  # numbers of the unknowns that are not zero in all fields
    vectors: np.ndarray  # (unknowns, unknowns)
    values: np.ndarray


def decomposed(
    line_fields: tuple[np.ndarray, np.ndarray], groups: list[np.ndarray]
) -> list[tuple[Directions, Directions]]:
    """Proper orthogonal decomposition of the fields on both kinds of line, for each group of `parity_groups`."""
    decompositions = []
    for group in groups:
        both = []
        for part in line_fields:
            own = group[np.any(part[group], axis=1)]  # without a finger's potential, which is its electrode's
            chosen = part[own]
            both.append(Directions(own, *_left_singular(np.hstack([chosen.real, chosen.imag]) / abs(part).max())))
        decompositions.append((both[0], both[1]))
    return decompositions


def _left_singular(fields: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Left singular vectors and values of a real matrix with far more columns than rows.

    The eigenvectors of F F^T alone are right to half of the digits.  In their basis the rows of F are nearly
    orthogonal, so that the same step with rows of unit norm gives the rest.
    """
    _, vectors = np.linalg.eigh(fields @ fields.T)
    turned = vectors.T @ fields
    norms = np.linalg.norm(turned, axis=1)
    turned /= np.where(norms, norms, 1.0)[:, None]
    squares, mixed = np.linalg.eigh(turned @ turned.T)
    left, values, _ = np.linalg.svd((vectors * norms) @ mixed * np.sqrt(np.maximum(squares, 0.0)))
    return left, values


def bases_of(
    decompositions: list[tuple[Directions, Directions]], size: int, truncation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of both kinds of line, with equal numbers of vectors from every group of unknowns.

    ``decompositions`` are those of `decomposed`; a basis vector is nonzero on one group of unknowns only.  Singular
    values below ``truncation`` times the largest of the group are left out.  Both kinds of line keep the larger of the
    two numbers of vectors, because both lines of a half cell must have the same size.  ``size``: unknowns of a line.
    """
    columns: tuple[list, list] = ([], [])
    for both in decompositions:
        count = max(int(np.sum(each.values > truncation * each.values[0])) for each in both)
        count = min(count, *(len(each.unknowns) for each in both))
        for kind, each in enumerate(both):
            embedded = np.zeros((size, count))
            embedded[each.unknowns] = each.vectors[:, :count]
            columns[kind].append(embedded)
    return np.hstack(columns[0]), np.hstack(columns[1])


def containing(basis: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Rotate an orthonormal basis so that it contains a vector that it contains approximately.

    The constant potential is such a vector: represented to 4e-6 only, it leaves errors of 1e-8 in the reciprocity of
    the ports.  Let e be the unit vector and c the normalised coefficients B^T e.  Then B + (e - B c) c^T maps c to e,
    changes no combination orthogonal to c, and has orthonormal columns.
    """
    unit = vector / np.linalg.norm(vector)
    inside = basis.T @ unit
    inside /= np.linalg.norm(inside)
    return basis + np.outer(unit - basis @ inside, inside)


def _arriving(modes: GuidedModes, distance: float) -> np.ndarray:
    """Amplitude of each mode after a distance, 1 where it set out."""
    return abs(np.exp(-1j * modes.wavenumbers * distance))


def _end_fields(modes: GuidedModes, ends: tuple, lengths: tuple[float, float], amplitude: float) -> list[np.ndarray]:
    """Reflected fields for every mode incident on an end: at a mesh's interface, at some distances from a plain end.

    Each is weighted with the amplitude at which it arrives over the segment beside the end, of ``lengths`` (left,
    right).
    """
    fields = []
    outgoing = (modes.right, modes.wavenumbers), (modes.left, -modes.backwards)
    for side, (shapes, wavenumbers) in enumerate(outgoing):
        if ends[side] == "absorbing":
            continue
        arriving = _arriving(modes, lengths[side])
        incident = np.flatnonzero((arriving > INCIDENT_SHARE_AT_END * amplitude) & (modes.wavenumbers != 0))
        reflected = end_reflection(modes, ends[side], side, incident) * arriving[incident]
        distances = (0.0,) if isinstance(ends[side], Wall) else WALL_DISTANCES
        for distance in WALL_WIDTH * np.array(distances):
            fields.append(shapes @ (np.exp(-1j * wavenumbers * distance)[:, None] * reflected))
    return fields


def snapshots(
    fields: PortFields, halves: dict[FingerShape, tuple[FingerColumns, FingerColumns]], amplitude: float
) -> tuple[np.ndarray, np.ndarray]:
    """Fields on the lines at mid-gap and at mid-finger, for a voltage at every port and for every incident mode.

    A mode is incident with the amplitude that the shortest segment leaves of it.

    Parameters
    ----------
    fields : PortFields
        Full solution of the stator at one frequency.
    halves : dict
        Half cells by the shape of their finger.
    amplitude : float
        Smallest relative amplitude that the basis must represent.

    Returns
    -------
    gap_lines, finger_lines : ndarray, shape (n, fields)
        Gap lines include those at the ends of the stator and on both sides of meshed pieces.
    """
    modes, network, section = fields.modes, fields.network, fields.section
    lengths = np.diff(network.segments, axis=1)[:, 0]
    gap_lines: list[np.ndarray] = _end_fields(modes, network.ends, (lengths[0], lengths[-1]), amplitude)
    finger_lines: list[np.ndarray] = []
    arriving = _arriving(modes, lengths.min())
    incident = np.flatnonzero(arriving > INCIDENT_SHARE * amplitude)
    rightwards, leftwards = (shapes[:, incident] * arriving[incident] for shapes in (modes.right, modes.left))
    gap_lines += [rightwards, leftwards]
    known: set[int] = set()  # equal transducers share a scatterer, which scatters the incident modes once
    for scatterer, own_sides, owner in zip(network.scatterers, fields.sides, fields.owners, strict=True):
        at, sides = scatterer.at, section.solid.potential_unit * own_sides
        if id(scatterer) not in known:
            known.add(id(scatterer))
            # columns: response to every incident mode with all potentials zero, then the fields of the unit excitations
            from_left, from_right, _ = scatterer.responses(incident)
            responses = np.hstack([from_left * arriving[incident], from_right * arriving[incident]])
            no_voltage = np.zeros((len(scatterer.potentials), responses.shape[1]))
            sides = np.hstack([np.concatenate([responses, no_voltage]), sides])
        gap_lines.append(sides[at.right])
        if owner is None or not isinstance(scatterer.piece, FingerColumns):  # a meshed piece
            gap_lines.append(sides[at.left])
            continue
        half_cell = halves[FingerShape.of(fields.transducers[owner], section.length_unit)][0].width
        # left lines of all half cells: a cell begins in mid-gap, its second half in mid-finger
        for number, (_, _, part) in enumerate(columns_from_left(scatterer.piece, sides, finest=1.001 * half_cell)):
            (finger_lines if number % 2 else gap_lines).append(part[at.left])
    on_fingers = np.hstack(finger_lines)
    on_fingers[section.full.finger_potential] = 0.0  # the electrode's
    return np.hstack(gap_lines), on_fingers
