"""Superelement of a transducer: from the columns of a finger's cell to a whole row of fingers.

A cell is half a gap, a finger and half a gap, condensed in two halves of which one is the mirror image of the other
where x -> -x is a symmetry; equal runs of cells are joined once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.condense.join import joined, mirrored, opened, repeated, swapped
from fem.condense.superelement import Block, condensed
from fem.discretize.grading import Resolution, edge_layers, graded
from fem.discretize.section import Section


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
    section: Section, frequency: float, shape: FingerShape, resolution: Resolution
) -> tuple[Block, Block]:
    """Condense the two halves of a finger's cell: gap to mid-finger, and mid-finger to gap, comb 0.

    Parameters
    ----------
    section : Section
    frequency : float
        Hz.
    shape : FingerShape
    resolution : Resolution
        Edge layers on either side of each finger edge, and the largest column.

    Returns
    -------
    rising, falling : Block
        Mirror images of each other where x -> -x is a symmetry.
    """
    phi = section.surface_dofs["phi"]
    done: dict[tuple, Block] = {}

    def piece(width: float, comb: int | None) -> Block:
        key = (round(width, 12), comb)
        if key not in done:
            done[key] = condensed(section, frequency, width=width, comb=comb)
        return done[key]

    def row(widths: np.ndarray, comb: int | None) -> Block:
        block = piece(widths[0], comb)
        for width in widths[1:]:
            block = joined(block, piece(width, comb), phi=phi, comb=comb)
        return block

    smallest = min(shape.half_finger, *shape.half_gaps)
    metal, left, right = (
        graded(length, edge_layers(resolution, length, smallest), largest=resolution.element_size)
        for length in (shape.half_finger, *shape.half_gaps)
    )
    rising = joined(row(left, None), row(metal[::-1], 0), phi=phi, comb=0)
    if section.odd is not None and shape.even:
        return rising, mirrored(rising, section.odd, bool(section.odd[phi]))
    return rising, joined(row(metal, 0), row(right[::-1], None), phi=phi, comb=0)


def finger_cell(section: Section, frequency: float, shape: FingerShape, resolution: Resolution) -> Block:
    """Condense half a gap, a finger of comb 0 and half a gap; parameters as in `half_cells`."""
    rising, falling = half_cells(section, frequency, shape, resolution)
    return joined(rising, falling, phi=section.surface_dofs["phi"], comb=0)


def bare_cell(section: Section, frequency: float, width: float, resolution: Resolution) -> Block:
    """Condense a stretch of bare surface as wide as a finger's cell (length units)."""
    widths = graded(width, 0, largest=resolution.element_size)
    return repeated(condensed(section, frequency, width=widths[0], comb=None), len(widths))


def fingers_in_row(
    signs: str,
    gaps: Callable[[int], tuple[float, float]],
    cell: Callable[[float, float], Block],
    bare: Callable[[float, float], Block],
) -> Block:
    """Join the cells of a row of fingers; equal runs are joined once.

    Parameters
    ----------
    signs : str
        "+", "-", "0" (left out) or "o" (open) for each finger.
    gaps : callable
        Number of a finger -> bare surface left and right of it.
    cell, bare : callable
        Both gaps -> block of a finger of comb 0, or of bare surface of the same width.

    Returns
    -------
    Block
    """
    singles: dict[tuple, Block] = {}

    def single(sign: str, left: float, right: float) -> Block:
        if (sign, left, right) not in singles:
            make = {
                "+": cell,
                "-": lambda *gap: swapped(cell(*gap)),
                "0": bare,
                "o": lambda *gap: opened(cell(*gap)),
            }
            singles[sign, left, right] = make[sign](left, right)
        return singles[sign, left, right]

    kinds = [(sign, *gaps(place)) for place, sign in enumerate(signs)]
    runs: dict[tuple, Block] = {}

    def run(start: int, stop: int) -> Block:
        key = tuple(kinds[start:stop])
        if key not in runs:
            if stop - start == 1:
                runs[key] = single(*kinds[start])
            else:
                half = start + 2 ** ((stop - start - 1).bit_length() - 1)
                runs[key] = joined(run(start, half), run(half, stop))
        return runs[key]

    return run(0, len(kinds))


def transducer_block(section, frequency, transducer, gaps, resolution) -> Block:
    """Superelement of a transducer from the beginning to the end of its outer gaps (m)."""
    unit = section.length_unit
    half_gap = transducer.half_gap / unit
    made: dict[tuple, Block] = {}

    def cell(left: float, right: float) -> Block:
        if (left, right) not in made:
            shape = FingerShape(half_finger=transducer.finger_width / 2 / unit, half_gaps=(left, right))
            made[left, right] = finger_cell(section, frequency, shape, resolution)
        return made[left, right]

    def bare(width: float) -> Block:
        if width not in made:
            made[width] = bare_cell(section, frequency, width, resolution)
        return made[width]

    outer = [half_gap if abs(gap / unit - half_gap) < 1e-9 * half_gap else gap / unit for gap in gaps]
    last = len(transducer.signs) - 1
    return fingers_in_row(
        transducer.signs,
        lambda place: (outer[0] if place == 0 else half_gap, outer[1] if place == last else half_gap),
        cell,
        lambda left, right: bare(left + transducer.finger_width / unit + right),
    )
