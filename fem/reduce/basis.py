"""Lines of few unknowns: a basis of the fields that ever stand on the lines between half cells.

The fields of all fingers, all ports and all waves that arrive span few dimensions (proper orthogonal decomposition of
full solutions at some frequencies of a band); one basis serves the lines in mid-gap, another those in mid-finger.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.columns import FingerColumns, lines
from fem.condense.transducer import Condensation, FingerShape, fingers_in_row
from fem.discretize.section import Section
from fem.geometry import Transducer
from fem.materials.medium import Medium
from fem.results.solution import driven_solution
from fem.waveguide.ends import Wall, end_reflection
from fem.waveguide.modes import GuidedModes
from fem.waveguide.port_fields import joined_fields

# Wavelengths of a free or clamped end that are condensed: too narrow for a resonance in the band
WALL_WIDTH = 0.2
WALL_DISTANCES = (1.0, 1.5, 3.0)  # in wall widths, where the fields sent back feed the basis
# Share, in ``kept``, of its amplitude that a mode must keep to count among those that arrive: at a transducer over the
# shortest segment; at a wall, where an error of the basis counts less, after a wavelength.
ARRIVING, ARRIVING_AT_WALL = 0.1, 100.0


@dataclass(frozen=True, kw_only=True)
class ReducedSection:
    """A section seen through a basis of fields."""

    full: Section
    # shape (full size, size), real, orthonormal, each column of one parity
    basis: np.ndarray = field(repr=False)
    odd: np.ndarray | None = field(repr=False)  # Parity of the columns

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
        """The field phi = 1, u = 0, which the basis holds."""
        return self.basis.T @ self.full.constant_potential

    @cached_property
    def surface_rows(self) -> np.ndarray:
        """What gives u_x and u_z at the surface, shape (2, size)."""
        return self.full.surface_rows @ self.basis

    @cached_property
    def mechanical(self) -> np.ndarray:
        """Columns that move; the basis keeps displacements and potential apart where ends are clamped."""
        moves = np.linalg.norm(self.basis[self.full.mechanical], axis=0)
        return np.flatnonzero(moves > 0.5)

    def surface_share(self, shapes: np.ndarray) -> np.ndarray:
        """Squared motion at the surface over its integral through the depth."""
        return self.full.surface_share(self.basis @ shapes)

    @cached_property
    def _projected(self):
        reference = 1.0 / self.length_unit  # Hz; any will do that makes inertia and stiffness comparable
        still, moving = (self.full.matrices(frequency) for frequency in (0.0, reference * 1e3))
        inertia = (moving[2] - still[2]) / (2 * np.pi * reference * 1e3) ** 2
        return tuple(self.basis.T @ part @ self.basis for part in (still[0], still[1], still[2], inertia))

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Projected K2, K1, K0 - omega^2 M."""
        second, first, still, inertia = self._projected
        return second, first, still + (2 * np.pi * frequency) ** 2 * inertia


def parity_groups(section: Section, apart: bool) -> list[np.ndarray]:
    """Unknowns that a basis vector may mix: those of one parity, or of one parity and kind."""
    odd = section.odd if section.odd is not None else np.zeros(section.size, dtype=bool)
    groups = [odd, ~odd]
    if apart:
        moves = np.zeros(section.size, dtype=bool)
        moves[section.mechanical] = True
        groups = [group & kind for group in groups for kind in (moves, ~moves)]
    return [np.flatnonzero(group) for group in groups if group.any()]


def even_rows(
    make: Condensation, transducers: tuple[Transducer, ...], cell: Callable[[FingerShape], FingerColumns]
) -> list[FingerColumns]:
    """FingerColumnss of transducers with equal gaps, from the cell of a finger of electrode 0 of each shape."""

    def no_bare_cell(*gaps):
        raise ValueError("a band of frequencies takes transducers without left-out fingers")

    shapes = [FingerShape.of(each, make.section.length_unit) for each in transducers]
    cells = {shape: cell(shape) for shape in dict.fromkeys(shapes)}
    rows = {
        (shape, signs): fingers_in_row(
            make, signs, lambda place: (0.0, 0.0), lambda *gaps, shape=shape: cells[shape], no_bare_cell
        )
        for shape, signs in dict.fromkeys(
            (shape, each.signs) for shape, each in zip(shapes, transducers, strict=True)
        )
    }
    return [rows[shape, each.signs] for shape, each in zip(shapes, transducers, strict=True)]


def bases_of(
    fields_seen: tuple[np.ndarray, np.ndarray], groups: list[np.ndarray], kept: float
) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of both kinds of line, equally many vectors of every group.

    Singular values below ``kept`` times the largest are left out.
    """
    size = len(fields_seen[0])
    columns: tuple[list, list] = ([], [])
    for group in groups:
        found = []
        for part in fields_seen:
            own = group[np.any(part[group], axis=1)]  # without a finger's potential, which is its electrode's
            here = np.hstack([part[own].real, part[own].imag]) / abs(part).max()
            vectors, values, _ = np.linalg.svd(np.asarray(np.linalg.qr(here.T, mode="r")).T)
            found.append((own, vectors, values))
        count = max(int(np.sum(values > kept * values[0])) for _, _, values in found)
        count = min(count, *(len(own) for own, _, _ in found))
        for side, (own, vectors, _) in enumerate(found):
            vectors_here = np.zeros((size, count))
            vectors_here[own] = vectors[:, :count]
            columns[side].append(vectors_here)
    return np.hstack(columns[0]), np.hstack(columns[1])


def holding(basis: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis turned so that it holds a vector which it nearly holds, exactly.

    Left out by 4e-6, the constant potential, which is a mode, spoils the reciprocity of the ports by 1e-8.
    """
    unit = vector / np.linalg.norm(vector)
    inside = basis.T @ unit
    inside /= np.linalg.norm(inside)
    return basis + np.outer(unit - basis @ inside, inside)


def _end_fields(modes: GuidedModes, ends: tuple, kept: float) -> list[np.ndarray]:
    """Fields near both ends for every mode that may arrive there: at a mesh, at some distances from a plain end."""
    arriving = np.flatnonzero(
        (abs(np.exp(-1j * modes.wavenumbers)) > min(ARRIVING_AT_WALL * kept, 0.5)) & (modes.wavenumbers != 0)
    )
    found = []
    onwards = (modes.right, modes.wavenumbers), (modes.left, -modes.backwards)
    for side, (go, wavenumbers) in enumerate(onwards):
        if ends[side] == "absorbing":
            continue
        sent = end_reflection(modes, ends[side], side, arriving)
        distances = (0.0,) if isinstance(ends[side], Wall) else WALL_DISTANCES
        for distance in WALL_WIDTH * np.array(distances):
            found.append(go @ (np.exp(-1j * wavenumbers * distance)[:, None] * sent))
    return found


def snapshots(stator, transducers, modes, halves, row, condensed, drive, kept):
    """Fields on the lines in mid-gap and in mid-finger, of every port and every mode that may arrive; the solution."""
    section = modes.section
    make = Condensation(section, modes.frequency)
    pieces = even_rows(make, transducers, lambda shape: make.joined(*halves[shape], 0))
    fields_of_ports = joined_fields(
        stator,
        transducers,
        pieces,
        modes=modes,
        resolution=row.resolution,
        pieces=row.arranged(condensed, modes),
    )
    network, volt = fields_of_ports.network, section.solid.potential_unit
    gaps, fingers = _end_fields(modes, network.ends, kept), []
    nearest = np.diff(network.segments, axis=1).min()
    arriving = np.flatnonzero(abs(np.exp(-1j * modes.wavenumbers * nearest)) > ARRIVING * kept)
    gaps += [modes.right[:, arriving], modes.left[:, arriving]]
    for index, scatterer in enumerate(network.scatterers):
        at = scatterer.at
        incoming = np.zeros((at.ports.start, 2 * len(arriving)), dtype=complex)
        incoming[at.left, : len(arriving)] = modes.right[:, arriving]
        incoming[at.right, len(arriving) :] = modes.left[:, arriving]
        no_voltage = np.zeros((len(scatterer.potentials), incoming.shape[1]))
        scattered = np.concatenate([scatterer.sides(incoming, no_voltage), no_voltage])
        together = np.hstack([scattered, volt * fields_of_ports.sides[index]])
        owner = fields_of_ports.owners[index]
        if owner is None:
            gaps += [together[at.left], together[at.right]]
            continue
        quarter = halves[FingerShape.of(transducers[owner], section.length_unit)][0].width
        for count, (_, _, sides) in enumerate(lines(scatterer.piece, together, finest=1.001 * quarter)):
            (fingers if count % 2 else gaps).append(sides[at.left])
        gaps.append(together[at.right])
    finger_lines = np.hstack(fingers)
    finger_lines[section.surface_dofs["phi"]] = 0.0
    return np.hstack(gaps), finger_lines, driven_solution(fields_of_ports, drive)
