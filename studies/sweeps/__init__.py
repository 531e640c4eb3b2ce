"""Sweeps: many points of one scene, computed by several workers, stored as they come, resumed after an interruption.

``sweep("twente", {"slider.preload": "1 mN:100 mN:50", "drive.voltage": "5:60:12"}, out="map")``.  A point is the scene
with some keys changed; its row holds what a run of that scene would answer.  What several points share is computed
once in each worker: the stator for each frequency and geometry, then the contact for batches of points
(`studies.solve.stators`).
A row is written when its batch is done and is durable when it is counted; the same call goes on with what is
missing, and with points that were lost with their worker.
"""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from studies.model.changed_scenes import ChangedScenes
from studies.refusal import InterruptedRunError, SceneError
from studies.scene import Scene, read_table
from studies.scene.numbers import Quantity
from studies.sweeps.driver import Driver
from studies.sweeps.plan import Design, designed
from studies.sweeps.store import Store
from studies.sweeps.sweep_result import Sweep
from studies.sweeps.workers import workers as start_workers

__all__ = ["Sweep", "sweep"]


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
        Beside the velocity at the slider's position: "ripple" (its mean over place and range within half a wavelength),
        "limits", "thrust", "efficiency", "pressure", "step", "start-up".
    out : path, optional
        Directory of the store; in memory without one.
    workers : int or str
        Processes, 1 for this one; or the address of a Dask scheduler, such as ``"tcp://127.0.0.1:8786"``.
    progress : callable, optional
        Called with (points, of them stored, of those failed, seconds of work).

    Raises
    ------
    SceneError
        For a fault of all points, a store of another sweep, or one that cannot be written.
    RunError
        If another driver uses the store, the disk is full, or the sweep was interrupted.
    """
    start_time = perf_counter()
    tolerance = Quantity(below=1.0).read("tolerance", tolerance)
    design = designed(_table(scene), over, tolerance=tolerance, also=tuple(also))
    _refuse_hopeless(design)
    with closing(Store(None if out is None else Path(out), design)) as store:
        with closing(start_workers(workers)) as pool:
            try:
                Driver(design, store, pool, progress or (lambda *_: None)).run()
            except KeyboardInterrupt:
                stored = sum(store.counts().values())
                where = "" if out is None else " and the same command goes on from there"
                raise InterruptedRunError(f"interrupted: {stored} of {len(design)} points are kept{where}") from None
        return Sweep(
            path=store.path, points=len(design), counts=store.counts(), cost=store.cost(),
            seconds=perf_counter() - start_time, columns=store.columns, names=store.names,
            batches=store.batches, axes=design.axes,
        )  # fmt: skip


def _table(scene: Any) -> dict:
    """Return the TOML document of a scene, in SI units where it is one without the sweep's keys."""
    if isinstance(scene, Scene):
        return scene.to_table()
    table = scene if isinstance(scene, dict) else read_table(scene)
    try:
        return Scene.from_table("", table).to_table()
    except SceneError:
        return table  # it may lack a key that is on an axis


def _refuse_hopeless(design: Design) -> None:
    """Refuse a sweep whose first, middle and last point break the same rule of a key that is on no axis."""
    question, refusals = design.question, []
    scenes = ChangedScenes(question.table)
    for values in design.values(np.array([0, len(design) // 2, len(design) - 1])):
        try:
            scenes.scene(dict(zip(question.keys, values, strict=True)))
            return
        except SceneError as error:
            refusals.append(error)
    if len({str(error) for error in refusals}) == 1 and refusals[0].path not in question.keys:
        raise refusals[0]
