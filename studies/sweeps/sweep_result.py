"""The result of a sweep: counts and columns of its rows, as text, data frame and xarray."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from studies.progress import duration
from studies.record.files import labelled_column
from studies.record.quantities import quantity
from studies.record.status import Status
from studies.record.text import labelled, table
from studies.record.values import Columns
from studies.refusal import needed
from studies.scene.keys import rule_at, unit_of
from studies.sweeps.axes import Axis

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

REASONS = 5  # shown; all are in the rows
SHOWN = (
    quantity.velocity_m_per_s, quantity.lateral_velocity_m_per_s, quantity.rotation_rpm, quantity.mean_velocity_m_per_s,
    quantity.normal_amplitude_m, quantity.thrust_N, quantity.contact_efficiency, quantity.motor_efficiency,
)  # fmt: skip


@dataclass(frozen=True, kw_only=True, repr=False)
class Sweep:
    """The result of a sweep.

    Attributes
    ----------
    path : Path or None
        The SQLite file; None for a sweep in memory.
    points : int
        Of the design, each with its row.
    counts : dict
        Number of rows of each `studies.record.status.Status`.
    cost : float
        Seconds of work of all workers, those of earlier drivers included.
    seconds : float
        Wall time of this driver.
    columns : callable
        Returns the columns by name, in the order of the points; a missing value is None.
    names : tuple of str
        Of the columns.
    batches : callable
        Yields rows of the columns of some names, many at a time, in the order of the points.
    axes : tuple of studies.sweeps.axes.Axis
        Keys and values.
    """

    path: Path | None
    points: int
    counts: dict[str, int]
    cost: float
    seconds: float
    columns: Callable[[], Columns]
    names: tuple[str, ...]
    batches: Callable[[Sequence[str]], Iterator[list[tuple]]]
    axes: tuple[Axis, ...] = ()

    @property
    def failed(self) -> int:
        """Rows without an answer within the tolerance."""
        return self.points - self.counts.get(Status.OK, 0)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What `sawmotor sweep --json` prints: counts, ranges of the outcomes, reasons of the failures, cost."""
        names = [each.column for each in SHOWN if each.column in self.names]
        ends = {name: [math.inf, -math.inf] for name in names}
        worst, failures, first = None, Counter[str](), dict[str, int]()
        # not all rows at once: a million of them take 0.6 GB
        for rows in self.batches(("point", "status", "relative_error", *names)):
            points, statuses, errors, *values = zip(*rows, strict=True)
            for name, column in zip(names, values, strict=True):
                if some := [each for each in column if each is not None]:
                    ends[name] = [min(ends[name][0], *some), max(ends[name][1], *some)]
            kept = [error for error, status in zip(errors, statuses, strict=True) if status == Status.OK]
            worst = max(kept if worst is None else [worst, *kept], default=None)
            for point, status in zip(points, statuses, strict=True):
                if status != Status.OK:
                    failures[status] += 1
                    first.setdefault(status, point)
        return {
            "store": str(self.path), "points": self.points, "counts": self.counts,
            "ranges": Columns((name, each) for name, each in ends.items() if each[0] <= each[1]),
            "largest_relative_error": worst,
            "reasons": [
                {"status": status, "points": count, "first_point": first[status]}
                for status, count in failures.most_common(REASONS)
            ],
            "seconds": self.seconds, "work_seconds": self.cost,
        }  # fmt: skip

    def __str__(self) -> str:
        """Return what `sawmotor sweep` prints."""
        kinds = ", ".join(f"{number} {kind}" for kind, number in self.counts.items())
        ranges = [
            [each.heading, each.text(low), "to", each.text(high)]
            for each, (low, high) in ((quantity(name), ends) for name, ends in self.summary["ranges"].items())
        ]
        notes = [
            ("not ok", f"{each['points']} (first: point {each['first_point']}): {each['status']}")
            for each in self.summary["reasons"]
        ]
        if self.summary["largest_relative_error"] is not None:
            notes.insert(0, ("relative error", f"{self.summary['largest_relative_error']:.1e} at most, where ok"))
        if {quantity.velocity_m_per_s.column, quantity.conductance_S.column} <= set(self.names):  # on a stator
            mean = (
                ""
                if quantity.mean_velocity_m_per_s.column in self.names
                else "; --also ripple adds mean and range about it"
            )
            notes.append(("velocity", f"that of the slider's position{mean}"))
        notes += [("seconds", f"{self.seconds:.2f}, {duration(self.cost)} of work"), ("results", f"{self.path}")]
        points = labelled([("points", f"{self.points}: {kinds}")])
        return "\n".join([*points, *(table(ranges) if ranges else []), *labelled(notes)])

    def __repr__(self) -> str:
        """Return the axes with their sizes, the kinds of rows and the range of the velocity on one line."""
        axes = [f"{' and '.join(each.keys)} ({len(each)})" for each in self.axes]
        parts = [" x ".join(axes) or "one point", ", ".join(f"{number} {kind}" for kind, number in self.counts.items())]
        if ends := self.summary["ranges"].get(quantity.velocity_m_per_s.column):
            parts.append(f"velocity {quantity.velocity_m_per_s.interval(*ends)}")
        return f"Sweep({'; '.join(parts)})"

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the rows as a pandas table, in the order of their points.

        Raises
        ------
        RunError
            If pandas is not installed.
        """
        return needed("pandas", "to_dataframe").DataFrame(self.columns()).set_index("point")

    def to_xarray(self) -> "xr.Dataset":
        """Return the rows as an xarray Dataset, a dimension for each axis; a missing number is NaN.

        Raises
        ------
        RunError
            If xarray is not installed.

        Examples
        --------
        >>> from studies import sweep
        >>> over = {"wave.normal_amplitude": [3e-9, 9e-9, 1e-8], "slider.preload": ["1 mN", "2 mN"]}
        >>> dict(sweep("twente-contact", over).to_xarray()["velocity_m_per_s"].sizes)
        {'wave.normal_amplitude': 3, 'slider.preload': 2}
        """
        dims = ["+".join(each.keys) if len(each.keys) < 3 else "point" for each in self.axes]
        pairs = [
            (key, (dim, list(column), _units(key)))
            for each, dim in zip(self.axes, dims, strict=True)
            for key, column in zip(each.keys, each.columns, strict=True)
        ]
        data, shape = {}, tuple(map(len, self.axes))
        for name, column in self.columns().items():
            if name not in dict(pairs) and name != "point":
                values, attributes = labelled_column(name, column)
                data[name] = (dims, values.reshape(shape), attributes)
        return needed("xarray", "to_xarray").Dataset(data, dict(pairs))


def _units(key: str) -> dict[str, str]:
    """Return the attributes in xarray of a scene's key."""
    unit = unit_of(rule_at(key))
    return {} if unit is None else {"units": unit or "1"}
