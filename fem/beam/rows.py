"""Rows of parallel transducers, each of which one section describes in axes s along and t across its waves."""

from dataclasses import dataclass, replace

import numpy as np

from fem.circuit import Drive, as_drive
from fem.geometry import Stator, Transducer, turn

PARALLEL = 1e-9  # rad; transducers whose angles differ by less are parallel
# Periods added to the length of a rotated row: the grid of `crossed_beam.interpolated_on_grid` lies on its stator.
ROOM = 4.0


@dataclass(frozen=True, kw_only=True)
class Row:
    """Parallel transducers in the axes of their waves.

    Attributes
    ----------
    angle : float
        Angle from x to s in rad, above -pi/2 and up to pi/2.
    stator : Stator
        The stator of the section, which extends along s.
    transducers : tuple of Transducer
        With s and t as their centres.  The fingers of a transducer rotated by pi are in reverse order.
    middle : tuple of float
        x and s of the stator's centre, m.
    """

    angle: float
    stator: Stator
    transducers: tuple[Transducer, ...]
    middle: tuple[float, float]

    def local(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates s and t in m of points (x, y) in m."""
        if self.angle == 0:
            return np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        (xs, ys), (xt, yt) = turn(self.angle)
        from_middle = np.asarray(x, dtype=float) - self.middle[0]
        return self.middle[1] + from_middle * xs + y * ys, from_middle * xt + y * yt

    @property
    def along_an_axis(self) -> bool:
        """True if s lies along x or y, so that a grid in x and y is also a grid in s and t."""
        return bool(np.any(turn(self.angle)[0] == 0))


def rows_of(stator: Stator, width: float, transducers: tuple[Transducer, ...], drive: str | Drive) -> tuple[Row, ...]:
    """Group a stator's transducers into rows; the first is the driven row whose waves run nearest to x."""
    rows: list[Row] = []
    for each in transducers:
        angle = each.angle - np.pi * np.ceil(each.angle / np.pi - 0.5 - PARALLEL)
        if abs(angle) < PARALLEL:
            angle = 0.0
        reversed_order = np.cos(each.angle - angle) < 0
        length = stator.length  # a rotated row extends over the diagonal of the surface, and ROOM
        if angle:
            length = float(np.hypot(length, width)) + ROOM * max(other.period for other in transducers)
        row = Row(
            angle=angle, stator=replace(stator, length=length), transducers=(), middle=(stator.length / 2, length / 2)
        )
        s, t = row.local(each.center, each.center_y)
        own = replace(
            each,
            center=float(s),
            center_y=float(t),
            angle=0.0,
            pattern=each.signs[::-1] if reversed_order else each.pattern,
        )
        for number, other in enumerate(rows):
            if abs(other.angle - angle) < PARALLEL and _clear(own, other.transducers):
                rows[number] = replace(other, transducers=(*other.transducers, own))
                break
        else:
            rows.append(replace(row, transducers=(own,)))
    drive = as_drive(drive)
    return tuple(sorted(rows, key=lambda row: (not driven_names(row, drive), round(-np.cos(row.angle), 9))))


def _clear(one: Transducer, others: tuple[Transducer, ...]) -> bool:
    """True if a transducer overlaps none of the others along s."""
    (left, right), spans = one.extent, [each.extent for each in others]
    return all(right < start or stop < left for start, stop in spans)


def driven_names(row: Row, drive: Drive) -> list[str]:
    """Names of the transducers of a row that have a source."""
    return [each.name for each in row.transducers if drive.sources.get(each.name)]
