"""Rows of parallel transducers: what one section holds, in the axes of their waves."""

from dataclasses import dataclass, replace

import numpy as np

from fem.circuit import Drive, as_drive
from fem.geometry import Stator, Transducer, turn

PARALLEL = 1e-9  # rad
ROOM = 4.0  # periods beyond a turned row's diagonal, for the lines of `crossed_beam._interpolated`


@dataclass(frozen=True, kw_only=True)
class Row:
    """Parallel transducers in the axes of their waves.

    Attributes
    ----------
    angle : float
        Of s from x, rad, above -pi/2 and up to pi/2.
    stator : Stator
        Along s.
    transducers : tuple of Transducer
        Their places are s and t; one turned by pi has its fingers in the reverse order.
    middle : tuple of float
        x and s of the stator's middle, m.
    """

    angle: float
    stator: Stator
    transducers: tuple[Transducer, ...]
    middle: tuple[float, float]

    def local(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """Places s and t in m of places x and y."""
        if self.angle == 0:
            return np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        (xs, ys), (xt, yt) = turn(self.angle)
        from_middle = np.asarray(x, dtype=float) - self.middle[0]
        return self.middle[1] + from_middle * xs + y * ys, from_middle * xt + y * yt

    @property
    def along_an_axis(self) -> bool:
        """Whether a grid of x and y is one of s and t."""
        return bool(np.any(turn(self.angle)[0] == 0))


def rows_of(
    stator: Stator, width: float, transducers: tuple[Transducer, ...], drive: str | Drive
) -> tuple[Row, ...]:
    """Rows of a stator's transducers; the first is the driven one whose waves run nearest to x."""
    rows: list[Row] = []
    for each in transducers:
        angle = each.angle - np.pi * np.ceil(each.angle / np.pi - 0.5 - PARALLEL)
        if abs(angle) < PARALLEL:
            angle = 0.0
        reversed_order = np.cos(each.angle - angle) < 0
        length = stator.length  # of a turned row: its diagonal and room for the lines of `_interpolated`
        if angle:
            length = float(np.hypot(length, width)) + ROOM * max(other.period for other in transducers)
        row = Row(
            angle=angle,
            stator=replace(stator, length=length),
            transducers=(),
            middle=(stator.length / 2, length / 2),
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
    (left, right), spans = one.extent, [each.extent for each in others]
    return all(right < start or stop < left for start, stop in spans)


def driven_names(row: Row, drive: Drive) -> list[str]:
    """Transducers of a row that have a source."""
    return [each.name for each in row.transducers if drive.sources.get(each.name)]
