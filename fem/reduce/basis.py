"""Proper orthogonal decomposition of the fields on the interface lines between half cells.

The fields of all fingers, all ports and all incident waves, from full solutions at a few frequencies of a band, span
few dimensions.  One basis represents the lines at the middle of gaps, another those at the middle of fingers.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

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
# segment, and on an end, where errors of the basis matter less, if it keeps 100 times that over a wavelength.
INCIDENT_SHARE, INCIDENT_SHARE_AT_WALL = 0.1, 100.0


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
    def _projected(self):
        # Hz; at a speed of 1e3 m/s the wavelength is one length unit: inertia and stiffness are then comparable, and
        # their difference loses few digits
        reference = 1e3 / self.length_unit
        static, dynamic = (self.full.matrices(frequency) for frequency in (0.0, reference))
        # the third matrix is K0 - omega^2 M, so that this quotient is -M
        negative_mass = (dynamic[2] - static[2]) / (2 * np.pi * reference) ** 2
        return tuple(self.basis.T @ part @ self.basis for part in (*static, negative_mass))

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Projected K2, K1, K0 - omega^2 M."""
        second, first, static, negative_mass = self._projected
        return second, first, static + (2 * np.pi * frequency) ** 2 * negative_mass


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


def bases_of(
    line_fields: tuple[np.ndarray, np.ndarray], groups: list[np.ndarray], truncation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of both kinds of line, with equal numbers of vectors from every group of unknowns.

    ``groups`` are sets of unknowns from `parity_groups`; a basis vector is nonzero on one of them only.  Singular
    values below ``truncation`` times the largest of the group are left out.  Both kinds of line keep the larger of the
    two numbers of vectors, because both lines of a half cell must have the same size.
    """
    size = len(line_fields[0])
    columns: tuple[list, list] = ([], [])
    for group in groups:
        decompositions = []
        for part in line_fields:
            own = group[np.any(part[group], axis=1)]  # without a finger's potential, which is its electrode's
            real = np.hstack([part[own].real, part[own].imag]) / abs(part).max()
            # R of real^T = Q R has the left singular vectors of `real` in its transpose, with far fewer columns
            vectors, values, _ = np.linalg.svd(np.asarray(np.linalg.qr(real.T, mode="r")).T)
            decompositions.append((own, vectors, values))
        count = max(int(np.sum(values > truncation * values[0])) for _, _, values in decompositions)
        count = min(count, *(len(own) for own, _, _ in decompositions))
        for kind, (own, vectors, _) in enumerate(decompositions):
            embedded = np.zeros((size, count))
            embedded[own] = vectors[:, :count]
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


def _end_fields(modes: GuidedModes, ends: tuple, amplitude: float) -> list[np.ndarray]:
    """Reflected fields for every mode incident on an end: at a mesh's interface, at some distances from a plain end."""
    after_wavelength = abs(np.exp(-1j * modes.wavenumbers))
    incident = np.flatnonzero(
        (after_wavelength > min(INCIDENT_SHARE_AT_WALL * amplitude, 0.5)) & (modes.wavenumbers != 0)
    )
    fields = []
    outgoing = (modes.right, modes.wavenumbers), (modes.left, -modes.backwards)
    for side, (shapes, wavenumbers) in enumerate(outgoing):
        if ends[side] == "absorbing":
            continue
        reflected = end_reflection(modes, ends[side], side, incident)
        distances = (0.0,) if isinstance(ends[side], Wall) else WALL_DISTANCES
        for distance in WALL_WIDTH * np.array(distances):
            fields.append(shapes @ (np.exp(-1j * wavenumbers * distance)[:, None] * reflected))
    return fields


def snapshots(
    fields: PortFields, halves: dict[FingerShape, tuple[FingerColumns, FingerColumns]], amplitude: float
) -> tuple[np.ndarray, np.ndarray]:
    """Fields on the lines at mid-gap and at mid-finger, for a voltage at every port and for every incident mode.

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
    gap_lines: list[np.ndarray] = _end_fields(modes, network.ends, amplitude)
    finger_lines: list[np.ndarray] = []
    # A mode matters at a transducer if it survives the shortest gap on the way there (INCIDENT_SHARE).
    shortest = np.diff(network.segments, axis=1).min()
    incident = np.flatnonzero(abs(np.exp(-1j * modes.wavenumbers * shortest)) > INCIDENT_SHARE * amplitude)
    gap_lines += [modes.right[:, incident], modes.left[:, incident]]
    for scatterer, own_sides, owner in zip(network.scatterers, fields.sides, fields.owners, strict=True):
        at = scatterer.at
        incoming = np.zeros((at.ports.start, 2 * len(incident)), dtype=complex)
        incoming[at.left, : len(incident)] = modes.right[:, incident]
        incoming[at.right, len(incident) :] = modes.left[:, incident]
        # columns: response to every incident mode with all potentials zero, then the fields of the unit excitations
        no_voltage = np.zeros((len(scatterer.potentials), incoming.shape[1]))
        scattered = np.concatenate([scatterer.sides(incoming, no_voltage), no_voltage])
        sides = np.hstack([scattered, section.solid.potential_unit * own_sides])
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
