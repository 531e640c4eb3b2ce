"""Size of a driven stator's discretised problem: the steps of `fem.condense.transducer` are counted, not computed."""

from dataclasses import dataclass, field
from typing import cast

import numpy as np

from fem.condense.cascade_piece import ELECTRODES
from fem.condense.condensed_mesh import Assembly
from fem.condense.mesh_assembly import assembled
from fem.condense.transducer import Condensation, transducer_superelements
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.geometry import Stator, Transducer


@dataclass(frozen=True, kw_only=True)
class StatorSize:
    """Numbers of columns, joins and transducers of one discretisation of a driven stator."""

    section: Section
    resolution: Resolution
    columns: int  # of elements under all fingers
    condensed: int  # distinct columns: each is condensed once
    joins: int  # of distinct pairs of neighbours
    mirrored: int  # joins whose mirror image is kept too
    scatterers: int  # distinct transducers
    meshes: tuple[Assembly, ...] = field(repr=False)  # at every position; those of equal pieces are the same object

    @property
    def line(self) -> int:
        """Unknowns of a vertical line, equal to the number of guided modes in either direction."""
        return self.section.size

    @property
    def unknowns(self) -> int:
        """Unknowns before condensation: lines under all fingers times the unknowns of a line, and those of meshes."""
        return self.columns * self.resolution.order * self.line + sum(each.unknowns for each in self.meshes)

    @property
    def distinct_meshes(self) -> set[Assembly]:
        """Meshed pieces that are condensed."""
        return set(self.meshes)

    @property
    def complex(self) -> bool:
        """True if the superelements are complex, because of losses or an absorbing bottom."""
        parts = (self.section.heights, *(medium.xx for medium in self.section.media))
        return np.result_type(*parts).kind == "c"

    @property
    def faces(self) -> int:
        """Unknowns on the faces between a column's elements, which a condensation eliminates."""
        nodes = self.section.dofs[:: self.resolution.order]
        return int((nodes >= 0).sum()) * (self.resolution.order - 1)

    @property
    def block_bytes(self) -> int:
        """Memory of the superelements that one solution keeps to recover the field on every line."""
        sides = 2 * self.line + len(ELECTRODES)
        joins = (self.joins + self.mirrored) * (sides + self.line) * sides
        columns = self.condensed * (sides + self.faces) * sides
        return (joins + columns) * (16 if self.complex else 8) + sum(each.block_bytes for each in self.distinct_meshes)


@dataclass(eq=False)
class _Counted:
    """Stands in for a superelement: its number of columns and of joins."""

    columns: int = 1
    joins: int = 0


@dataclass(eq=False)
class _Count(Condensation):
    """Stands in for a `Condensation` and counts its steps."""

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
    """Return the size of a stator with at least one transducer, discretised for a frequency in Hz.

    Meshed pieces are assembled, which takes a tenth of their condensation.  Those at a step of thickness are counted
    without the line of the section behind it.
    """
    in_order = tuple(sorted(transducers, key=lambda each: each.center))
    unit = stator.slowest_wavelength(frequency)
    scale = min(each.finger_width / 2 for each in in_order)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    count = _Count(section, frequency)
    pieces = cast("list[_Counted]", transducer_superelements(count, stator, in_order, resolution))  # what `count` makes
    meshes = {
        contents: assembled(
            piece,
            stator,
            section,
            {side: section for side in ("left", "right") if piece.fits(side, stator.depth)},
            frequency=frequency,
            resolution=resolution,
        )
        for contents, piece in {piece.contents: piece for piece in stator.pieces}.items()
    }
    return StatorSize(
        section=section,
        resolution=resolution,
        columns=sum(piece.columns for piece in pieces),
        condensed=count.condensed,
        joins=count.joins,
        mirrored=count.images,
        scatterers=len({id(piece) for piece in pieces}),
        meshes=tuple(meshes[piece.contents] for piece in stator.pieces),
    )
