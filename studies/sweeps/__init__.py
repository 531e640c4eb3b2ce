"""Many points of one scene: designed, computed wherever there are workers, kept as they come, resumed where they stop.

``sweep("twente", {"slider.preload": "1 mN:100 mN:50", "drive.voltage": "5:60:12"}, out="map")``.  A point is the scene
with some keys changed; its row is what a run of that scene would find.  What several points share is computed
once in each worker: the stator for each frequency and geometry, then the contact for batches of points
(``changed_contacts``).
A row is written when its batch is done and is durable when it is counted; the same call goes on with what is
missing, and with points that were lost with their worker.
"""

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.chain.changed_scenes import ChangedScenes
from studies.record.quantities import described
from studies.record.status import Status
from studies.refusal import InterruptedRunError, SceneError, needed
from studies.scene import Scene, read_table
from studies.scene.keys import rule_at
from studies.scene.keys import unit_of as scene_unit
from studies.scene.numbers import Quantity
from studies.sweeps.axes import Axis
from studies.sweeps.driver import Driver
from studies.sweeps.plan import Design, designed
from studies.sweeps.store import Store
from studies.sweeps.workers import workers as chosen_workers

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Sweep", "sweep"]


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """What a sweep left.

    Attributes
    ----------
    path : Path or None
        The SQLite file; None for a sweep in memory.
    points : int
        Of the design, each with its row.
    counts : dict
        How many rows of each kind: ok, refused, no answer, above tolerance, lost.
    cost : float
        Seconds of work, in this process or in workers, earlier drivers' included.
    seconds : float
        Of this driver.
    columns : callable
        Returns the rows in the order of their points, as columns by name; what a row has not is None.
    axes : tuple of studies.sweeps.axes.Axis
        Keys and values.
    """

    path: Path | None
    points: int
    counts: dict[str, int]
    cost: float
    seconds: float
    columns: Callable[[], dict[str, list]] = field(repr=False)
    axes: tuple[Axis, ...] = field(default=(), repr=False)

    @property
    def failed(self) -> int:
        """Rows without an answer within the tolerance."""
        return self.points - self.counts.get(Status.OK, 0)

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the rows as a pandas table, in the order of their points.

        Raises
        ------
        RunError
            If pandas is not installed.
        """
        return needed("pandas", "to_dataframe").DataFrame(self.columns()).set_index("point")

    def to_xarray(self) -> "xr.Dataset":
        """Return the rows as an xarray Dataset, a dimension for each axis; what a row has not is NaN.

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
            if name in dict(pairs) or name == "point":
                continue
            text = any(isinstance(value, str) for value in column)
            values = np.array([value or "" for value in column] if text else np.array(column, float))
            data[name] = (dims, values.reshape(shape), described(name))
        return needed("xarray", "to_xarray").Dataset(data, dict(pairs))


def sweep(
    scene: Scene | str | Path | dict,
    over: Any = None,
    *,
    tolerance: float = 1e-3,
    also: tuple[str, ...] = (),
    out: str | Path | None = None,
    workers: int | str = 1,
    progress: Callable[[int, int, int, float], None] | None = None,
) -> Sweep:
    """Compute every point of a sweep that its store does not hold yet.

    Parameters
    ----------
    scene : Scene, str, Path or dict
        A scene, its file, the name of one that ships, or its TOML document.
    over : dict, Path, data frame or list of them
        Axes: key to values, or to a text such as ``"1 mN:100 mN:50:log"``; or points, such as a Latin hypercube by
        `scipy.stats.qmc`: a CSV file or a table with a column for each key.  Several are multiplied.
    tolerance : float
        As in a run.
    also : tuple of str
        Beside the velocity: "limits", "thrust", "efficiency".
    out : path, optional
        Directory of the store; in memory without one.
    workers : int or str
        Processes, 1 for this one; or the address of a Dask scheduler, such as ``"tcp://127.0.0.1:8786"``.
    progress : callable, optional
        Called with (points, of them kept, of those failed, seconds of work).

    Raises
    ------
    SceneError
        For what is wrong whatever the point, a store of another sweep, or one that cannot be written.
    RunError
        If another driver is at work, the disk is full, or the sweep was interrupted.
    """
    start_time = perf_counter()
    tolerance = Quantity(below=1.0).read("tolerance", tolerance)
    design = designed(_table(scene), over, tolerance=tolerance, also=tuple(also))
    _refuse_hopeless(design)
    with closing(Store(None if out is None else Path(out), design)) as store:
        with closing(chosen_workers(workers)) as pool:
            try:
                Driver(design, store, pool, progress or (lambda *_: None)).run()
            except KeyboardInterrupt:
                kept = sum(store.counts().values())
                where = "" if out is None else " and the same command goes on from there"
                raise InterruptedRunError(f"interrupted: {kept} of {len(design)} points are kept{where}") from None
        return Sweep(
            path=store.path, points=len(design), counts=store.counts(), cost=store.cost(),
            seconds=perf_counter() - start_time, columns=store.columns, axes=design.axes,
        )  # fmt: skip


def _units(key: str) -> dict[str, str]:
    """Return the attributes in xarray of a scene's key."""
    unit = scene_unit(rule_at(key))
    return {} if unit is None else {"units": unit or "1"}


def _table(scene: Any) -> dict:
    """Return the TOML document of a scene, in SI units where it is one without the sweep's keys."""
    if isinstance(scene, Scene):
        return scene.to_table()
    table = scene if isinstance(scene, dict) else read_table(scene)
    try:
        return Scene.from_table("", table).to_table()
    except SceneError:
        return table  # it may lack what an axis gives


def _refuse_hopeless(design: Design) -> None:
    """Refuse a sweep whose first, middle and last point break one and the same rule of no axis."""
    question, refusals = design.question, []
    scenes = ChangedScenes(question.table)
    for own in design.values(np.array([0, len(design) // 2, len(design) - 1])):
        try:
            scenes.scene(dict(zip(question.keys, own, strict=True)))
            return
        except SceneError as error:
            refusals.append(error)
    if len({str(error) for error in refusals}) == 1 and refusals[0].path not in question.keys:
        raise refusals[0]
