"""The block of a slider's pillars; `studies.model.pillars` reads their file."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.scene.block import Block
from studies.scene.numbers import FixedList, Quantity
from studies.scene.rule import FLAG, RANDOM_SEED, TEXT, Count

MAX_PILLARS = 1_000_000
TOUCHING = 1e-9  # relative: pillars whose pitch is less than their diameter by up to this touch and do not overlap
SEED = 2003  # default of the random heights
PAIR = Quantity("m") | FixedList((Quantity("m"),) * 2, "[along, across]")
GRID = ("pitch", "rows", "columns", "area", "height_scatter", "seed")


@dataclass(frozen=True, kw_only=True)
class Pillars(Block):
    """The flat-topped pillars of a slider, instead of its radius, contacts and heights."""

    block: ClassVar[str] = "slider.pillars"
    diameter: Annotated[
        float | Any, Quantity("m"), "Diameter of each pillar; required unless the file has the column diameter_m."
    ] = None
    height: Annotated[
        float | None, Quantity("m"), "Height of each pillar, which adds compliance. Absent: rigid pillars."
    ] = None
    pitch: Annotated[
        float | tuple[float, float] | None,
        PAIR,
        "Distance between the centres of neighbours: one value or [along the wave, across].",
    ] = None
    rows: Annotated[
        int | Any, Count(MAX_PILLARS), "Number of pillars along the wave; required with pitch unless area is given."
    ] = None
    columns: Annotated[
        int | Any, Count(MAX_PILLARS), "Number of pillars across the wave; required with pitch unless area is given."
    ] = None
    area: Annotated[
        float | tuple[float, float] | None,
        PAIR,
        "Area filled with pillars, instead of rows and columns: one side length or [along the wave, across].",
    ] = None
    height_scatter: Annotated[
        float, Quantity("m", zero=True), "Standard deviation of the heights, which are normally distributed."
    ] = 0.0
    seed: Annotated[int | None, RANDOM_SEED, "Seed of the random heights. Absent: 2003."] = None
    file: Annotated[
        str | None,
        TEXT,
        "CSV file with one pillar in each row, instead of pitch, rows, columns, area, height_scatter and seed; the "
        "path is relative to the folder of the scene. Columns: x_m and y_m from the slider's centre, height_m "
        "(projection towards the stator) and optionally diameter_m.",
    ] = None
    width: Annotated[
        float | None,
        Quantity("m"),
        "Width of the strip over which the pillars' forces act on the wave. Absent: the extent of the pillars "
        "across the wave plus one pitch.",
    ] = None
    curvature: Annotated[
        float, Quantity("1/m", negative=True), "Curvature of the slider's face; positive if the middle projects."
    ] = 0.0
    interaction: Annotated[bool, FLAG, "true: the elastic interaction of neighbours is included."] = False
    youngs_modulus: Annotated[
        float | Any,
        Quantity("Pa"),
        "Young's modulus of the pillars. Absent: that of slider.ball, otherwise of silicon.",
    ] = None
    poisson_ratio: Annotated[
        float | Any,
        Quantity(negative=True, below=0.5),
        "Poisson's ratio of the pillars. Absent: that of slider.ball, otherwise of silicon.",
    ] = None

    def check_layout(self):
        if self.file is not None:
            for key in GRID:
                if getattr(self, key) != getattr(Pillars, key):
                    yield key, "must be absent with slider.pillars.file, which gives every pillar"
            return
        if self.pitch is None:
            yield "pitch", "is required and missing: give a length in m, or a file of the pillars"
            return
        if self.diameter is None:
            yield "diameter", "is required and missing: give a length in m"
        elif min(self.pitches) < self.diameter * (1 - TOUCHING):
            rule = f"must be at least the diameter, {self.diameter:g} m, or the pillars overlap"
            yield "pitch", f"{rule}, got {min(self.pitches):g} m"
        if self.area is not None:
            for key in ("rows", "columns"):
                if getattr(self, key) is not None:
                    yield key, "must be absent with slider.pillars.area, which gives the number"
        elif self.rows is None or self.columns is None:
            yield "rows", "and columns are required and missing: give both numbers, or the area"
            return
        along, across = self.counts
        if min(along, across) < 1:
            area = as_lengths(self.area)
            yield "area", f"must hold at least one pillar, got {area} m at a pitch of {self.pitches} m"
        elif along * across > MAX_PILLARS:
            yield "rows", f"times columns must be at most {MAX_PILLARS} pillars, got {along} x {across}"

    @property
    def pitches(self) -> tuple[float, float]:
        """Pitch along the wave and across, m."""
        return as_lengths(self.pitch)

    @property
    def counts(self) -> tuple[int, int]:
        """Number of pillars of a grid along the wave and across."""
        if self.area is None:
            return self.rows, self.columns
        (along, across), (pitch, side_pitch) = as_lengths(self.area), self.pitches
        return int(along / pitch + 1e-9), int(across / side_pitch + 1e-9)


def as_lengths(value) -> tuple[float, float]:
    """Return what `PAIR` reads as (along, across)."""
    return tuple(value) if isinstance(value, tuple) else (value, value)
