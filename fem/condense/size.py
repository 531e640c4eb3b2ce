"""How large a driven stator's discretised problem is, counted by the walk of `fem.condense.transducer` without work."""

from dataclasses import dataclass

import numpy as np

from fem.condense.column import ELECTRODES
from fem.condense.transducer import Condensation, transducer_superelements
from fem.discretize.elements import discretise
from fem.discretize.grading import Resolution
from fem.discretize.section import Section
from fem.geometry import Stator, Transducer
from fem.materials.christoffel import slowest_wavelength


@dataclass(frozen=True, kw_only=True)
class StatorSize:
    """What one discretisation of a driven stator consists of."""

    section: Section  # its elements through the depth and the unknowns of a line
    resolution: Resolution
    columns: int  # of elements under all fingers
    condensed: int  # columns that differ: each is condensed once
    joins: int  # of two neighbours that differ from all other pairs
    mirrored: int  # joins of which a mirror image is kept too
    scatterers: int  # transducers that differ

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
        """Whether the superelements are complex: there is loss or an absorbing bottom."""
        parts = (self.section.heights, *(medium.xx for medium in self.section.media))
        return np.result_type(*parts).kind == "c"

    @property
    def faces(self) -> int:
        """Unknowns on the faces between a column's elements, which a condensation eliminates."""
        nodes = self.section.dofs[:: self.resolution.order]
        return int((nodes >= 0).sum()) * (self.resolution.order - 1)

    @property
    def block_bytes(self) -> int:
        """Memory of the superelements that one solution keeps, for the way back to every line."""
        sides = 2 * self.line + len(ELECTRODES)
        joins = (self.joins + self.mirrored) * (sides + self.line) * sides
        columns = self.condensed * (sides + self.faces) * sides
        return (joins + columns) * (16 if self.complex else 8)


@dataclass(eq=False)
class _Counted:
    """In the place of a superelement: columns in it, and the joins that its columns took."""

    columns: int = 1
    joins: int = 0


@dataclass(eq=False)
class _Count(Condensation):
    """In the place of a condensation: counts what it would do."""

    condensed: int = 0
    joins: int = 0
    images: int = 0

    def column(self, width, electrode):
        self.condensed += 1
        return _Counted()

    def joined(self, left, right, electrode=None):
        self.joins += 1
        return _Counted(left.columns + right.columns, left.joins + right.joins + 1)

    def mirrored(self, superelement):
        self.images += superelement.joins
        return superelement

    def exchanged(self, superelement):
        return superelement

    open_circuited = exchanged


def stator_size(
    stator: Stator, transducers: tuple[Transducer, ...], *, frequency: float, resolution: Resolution
) -> StatorSize:
    """Return the size of a stator with at least one transducer, discretised for a frequency in Hz."""
    row = tuple(sorted(transducers, key=lambda each: each.center))
    unit = slowest_wavelength(stator.solid, frequency)
    scale = min(each.finger_width / 2 for each in row)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    count = _Count(section, frequency)
    pieces = transducer_superelements(count, stator, row, resolution)
    return StatorSize(
        section=section,
        resolution=resolution,
        columns=sum(piece.columns for piece in pieces),
        condensed=count.condensed,
        joins=count.joins,
        mirrored=count.images,
        scatterers=len({id(piece) for piece in pieces}),
    )
