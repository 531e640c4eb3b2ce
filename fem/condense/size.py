"""How large a driven stator's discretised problem is, counted from the geometry before anything is solved.

The counts follow what `fem.condense.transducer` does: equal columns are condensed once, equal runs of fingers joined
once.
"""

from dataclasses import dataclass

import numpy as np

from fem.condense.superelement import PORTS
from fem.discretize.grading import Resolution, edge_layers, graded
from fem.discretize.section import Section, discretise
from fem.geometry import Stator, Transducer, outer_gaps
from fem.materials.christoffel import slowest_wavelength


@dataclass(frozen=True, kw_only=True)
class StatorSize:
    """What one discretisation of a driven stator consists of.

    Attributes
    ----------
    section : Section
        Its elements through the depth and the unknowns of a line.
    resolution : Resolution
    columns : int
        Of elements under all fingers.
    condensed : int
        Columns that differ: each is condensed once.
    joins : int
        Of two neighbours that differ from all other pairs.
    mirrored : int
        Joins of which a mirror image is kept too.
    scatterers : int
        Transducers that differ.
    """

    section: Section
    resolution: Resolution
    columns: int
    condensed: int
    joins: int
    mirrored: int
    scatterers: int

    @property
    def line(self) -> int:
        """Unknowns of a vertical line: as many guided modes run to either side."""
        return self.section.size

    @property
    def unknowns(self) -> int:
        """Of the problem that is condensed: lines under all fingers times the unknowns of a line."""
        return self.columns * self.resolution.order * self.line

    @property
    def complex(self) -> bool:
        """Whether the blocks are complex: there is loss or an absorbing bottom."""
        parts = (self.section.heights, *(medium.xx for medium in self.section.media))
        return np.result_type(*parts).kind == "c"

    @property
    def faces(self) -> int:
        """Unknowns on the faces between a column's elements, which a condensation eliminates."""
        nodes = self.section.dofs[:: self.resolution.order]
        return int((nodes >= 0).sum()) * (self.resolution.order - 1)

    @property
    def block_bytes(self) -> int:
        """Memory of the blocks that one solution keeps, for the way back to every line."""
        sides = 2 * self.line + PORTS
        joins = (self.joins + self.mirrored) * (sides + self.line) * sides
        columns = self.condensed * (sides + self.faces) * sides
        return (joins + columns) * (16 if self.complex else 8)


def stator_size(
    stator: Stator, transducers: tuple[Transducer, ...], *, frequency: float, resolution: Resolution
) -> StatorSize:
    """Return the size of a driven stator at a frequency in Hz.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        At least one.
    frequency : float
        Hz.
    resolution : Resolution

    Returns
    -------
    StatorSize
    """
    row = tuple(sorted(transducers, key=lambda each: each.center))
    unit = slowest_wavelength(stator.solid, frequency)
    scale = min(each.finger_width / 2 for each in row)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    counts = np.zeros(4, dtype=int)
    known: dict[tuple, int] = {}
    for each, gaps in zip(row, outer_gaps(stator, row), strict=True):
        key = (each.signs, each.pitch, each.metallisation, gaps)
        if key not in known:
            known[key], *new = _transducer(each, gaps, unit, resolution, mirror=section.odd is not None)
            counts[1:] += new
        counts[0] += known[key]
    columns, condensed, joins, mirrored = counts.tolist()
    return StatorSize(
        section=section,
        resolution=resolution,
        columns=columns,
        condensed=condensed,
        joins=joins,
        mirrored=mirrored,
        scatterers=len(known),
    )


def _transducer(transducer, gaps, unit, resolution, *, mirror) -> tuple[int, int, int, int]:
    """Columns of a transducer, those that are condensed, joins, and joins with a mirror image."""
    half_gap = transducer.half_gap / unit
    outer = [half_gap if abs(gap / unit - half_gap) < 1e-9 * half_gap else gap / unit for gap in gaps]
    last = len(transducer.signs) - 1
    kinds = [
        (sign != "0", outer[0] if place == 0 else half_gap, outer[1] if place == last else half_gap, sign)
        for place, sign in enumerate(transducer.signs)
    ]
    finger = transducer.finger_width / unit
    cells = {
        (metal, left, right): _finger(finger / 2, left, right, resolution, mirror)
        if metal
        else _bare(left + finger + right, resolution)
        for metal, left, right, _ in kinds
    }
    columns = sum(cells[kind[:3]][0] for kind in kinds)
    condensed, joins, images = (sum(cell[part] for cell in cells.values()) for part in (1, 2, 3))
    return columns, condensed, joins + _runs(kinds), images


def _finger(half_finger, left, right, resolution, mirror) -> tuple[int, int, int, int]:
    smallest = min(half_finger, left, right)
    metal, before, after = (
        graded(length, edge_layers(resolution, length, smallest), largest=resolution.element_size)
        for length in (half_finger, left, right)
    )
    columns = 2 * len(metal) + len(before) + len(after)
    bare = {round(width, 12) for width in (*before, *after)}
    condensed = len({round(width, 12) for width in metal}) + len(bare)
    even = abs(left - right) < 1e-9 * left
    joins = len(before) + len(metal) - 1
    if mirror and even:
        return columns, condensed, 1 + joins, joins
    return columns, condensed, 1 + joins + len(after) + len(metal) - 1, 0


def _bare(width, resolution) -> tuple[int, int, int, int]:
    count = len(graded(width, 0, largest=resolution.element_size))
    return count, 1, count.bit_length() - 1 + count.bit_count() - 1, 0


def _runs(kinds: list[tuple]) -> int:
    """Joins of a row of cells, halved until single; equal runs count once."""
    seen: set[tuple] = set()
    open_runs = [tuple(kinds)]
    while open_runs:
        run = open_runs.pop()
        if len(run) > 1 and run not in seen:
            seen.add(run)
            half = 2 ** ((len(run) - 1).bit_length() - 1)
            open_runs += [run[:half], run[half:]]
    return len(seen)
