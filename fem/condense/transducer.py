"""Superelement of a transducer: from the columns of a finger's cell to a whole row of fingers.

A cell is half a gap, a finger and half a gap, condensed in two halves of which one is the mirror image of the other
where x -> -x is a symmetry; equal runs of cells are joined once.  The walk from columns to transducers is written once,
for any `Assembly`: `Condensation` does the work, `fem.condense.size` counts it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fem.condense.join import exchanged, joined, mirrored, open_circuited, repeated
from fem.condense.superelement import Superelement, condensed
from fem.discretize.grading import Resolution, edge_layers, graded
from fem.discretize.section import Section
from fem.geometry import Stator, Transducer, outer_gaps


class Assembly(Protocol):
    """What the walk asks for: columns of elements, and what is made of them.

    ``mirror`` says whether x -> -x is a symmetry; a finger is on electrode 0 until it is exchanged.
    """

    length_unit: float
    mirror: bool

    def column(self, width: float, electrode: int | None) -> Superelement:
        """Condense one column of elements."""

    def joined(self, left: Superelement, right: Superelement, electrode: int | None = None) -> Superelement:
        """Join two neighbours; ``electrode`` if a finger lies on the line they share."""

    def mirrored(self, superelement: Superelement) -> Superelement:
        """Reflect in x -> -x."""

    def exchanged(self, superelement: Superelement) -> Superelement:
        """Put the fingers on the other electrode."""

    def open_circuited(self, superelement: Superelement) -> Superelement:
        """Cut the finger off from its electrode."""


@dataclass(frozen=True)
class Condensation:
    """Superelements of a section at a frequency in Hz."""

    section: Section
    frequency: float

    @property
    def length_unit(self) -> float:
        """Length unit in m."""
        return self.section.length_unit

    @property
    def mirror(self) -> bool:
        """Whether x -> -x is a symmetry."""
        return self.section.odd is not None

    def column(self, width: float, electrode: int | None) -> Superelement:
        """Condense one column of elements."""
        return condensed(self.section, self.frequency, width=width, electrode=electrode)

    def joined(self, left: Superelement, right: Superelement, electrode: int | None = None) -> Superelement:
        """Join two neighbours."""
        phi = None if electrode is None else self.section.surface_dofs["phi"]
        return joined(left, right, phi=phi, electrode=electrode)

    def mirrored(self, superelement: Superelement) -> Superelement:
        """Reflect in x -> -x."""
        solid = self.section.solid
        return mirrored(superelement, self.section.odd, bool(solid.parity[solid.fields.index("phi")]))

    exchanged = staticmethod(exchanged)
    open_circuited = staticmethod(open_circuited)


@dataclass(frozen=True, kw_only=True)
class FingerShape:
    """A finger with the bare surface that counts to it, length units."""

    half_finger: float
    half_gaps: tuple[float, float]

    @property
    def even(self) -> bool:
        """Whether both gaps are alike."""
        return abs(self.half_gaps[0] - self.half_gaps[1]) < 1e-9 * self.half_gaps[0]


def half_cells(
    make: Assembly, shape: FingerShape, resolution: Resolution
) -> tuple[Superelement, Superelement]:
    """Condense the two halves of a finger's cell: gap to mid-finger, and mid-finger to gap, electrode 0."""
    done: dict[tuple, Superelement] = {}

    def piece(width: float, electrode: int | None) -> Superelement:
        key = (round(width, 12), electrode)
        if key not in done:
            done[key] = make.column(width, electrode)
        return done[key]

    def row(widths: np.ndarray, electrode: int | None) -> Superelement:
        whole = piece(widths[0], electrode)
        for width in widths[1:]:
            whole = make.joined(whole, piece(width, electrode), electrode)
        return whole

    smallest = min(shape.half_finger, *shape.half_gaps)
    metal, left, right = (
        graded(length, edge_layers(resolution, length, smallest), largest=resolution.element_size)
        for length in (shape.half_finger, *shape.half_gaps)
    )
    rising = make.joined(row(left, None), row(metal[::-1], 0), 0)
    if make.mirror and shape.even:
        return rising, make.mirrored(rising)
    return rising, make.joined(row(metal, 0), row(right[::-1], None), 0)


def finger_cell(make: Assembly, shape: FingerShape, resolution: Resolution) -> Superelement:
    """Condense half a gap, a finger of electrode 0 and half a gap."""
    return make.joined(*half_cells(make, shape, resolution), 0)


def fingers_in_row(
    make: Assembly,
    signs: str,
    gaps: Callable[[int], tuple[float, float]],
    cell: Callable[[float, float], Superelement],
    bare: Callable[[float, float], Superelement],
) -> Superelement:
    """Join the cells of a row of fingers, of signs "+", "-", "0" (left out) or "o" (open); equal runs are joined once.

    ``gaps``: number of a finger -> bare surface left and right of it; ``cell``, ``bare``: both gaps -> superelement of
    a finger of electrode 0, or of bare surface of the same width.
    """
    singles: dict[tuple, Superelement] = {}

    def single(sign: str, left: float, right: float) -> Superelement:
        if (sign, left, right) not in singles:
            kinds = {
                "+": cell,
                "-": lambda *gap: make.exchanged(cell(*gap)),
                "0": bare,
                "o": lambda *gap: make.open_circuited(cell(*gap)),
            }
            singles[sign, left, right] = kinds[sign](left, right)
        return singles[sign, left, right]

    fingers = [(sign, *gaps(place)) for place, sign in enumerate(signs)]
    runs: dict[tuple, Superelement] = {}

    def run(start: int, stop: int) -> Superelement:
        key = tuple(fingers[start:stop])
        if key not in runs:
            if stop - start == 1:
                runs[key] = single(*fingers[start])
            else:
                half = start + 2 ** ((stop - start - 1).bit_length() - 1)
                runs[key] = make.joined(run(start, half), run(half, stop))
        return runs[key]

    return run(0, len(fingers))


def transducer_superelements(
    make: Assembly, stator: Stator, transducers: tuple[Transducer, ...], resolution: Resolution
) -> list[Superelement]:
    """Superelements of transducers from left to right, between their outer gaps; equal ones are the same object."""
    made: dict[tuple, Superelement] = {}
    pieces = []
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        key = (transducer.signs, transducer.pitch, transducer.metallisation, gaps)
        if key not in made:
            made[key] = _transducer_superelement(make, transducer, gaps, resolution)
        pieces.append(made[key])
    return pieces


def _transducer_superelement(
    make: Assembly, transducer: Transducer, gaps, resolution: Resolution
) -> Superelement:
    unit = make.length_unit
    half_gap = transducer.half_gap / unit
    made: dict[tuple, Superelement] = {}

    def cell(left: float, right: float) -> Superelement:
        if (left, right) not in made:
            shape = FingerShape(half_finger=transducer.finger_width / 2 / unit, half_gaps=(left, right))
            made[left, right] = finger_cell(make, shape, resolution)
        return made[left, right]

    def bare(left: float, right: float) -> Superelement:
        widths = graded(left + transducer.finger_width / unit + right, 0, largest=resolution.element_size)
        return repeated(make.column(widths[0], None), len(widths), make.joined)

    outer = [half_gap if abs(gap / unit - half_gap) < 1e-9 * half_gap else gap / unit for gap in gaps]
    last = len(transducer.signs) - 1
    return fingers_in_row(
        make,
        transducer.signs,
        lambda place: (outer[0] if place == 0 else half_gap, outer[1] if place == last else half_gap),
        cell,
        bare,
    )
