"""Velocity, thrust and efficiency of a motor over any two of its parameters.

Method: a sweep of the scene (``twente-contact`` by default) over two axes: amplitude and preload, or those of two
options ``--over KEY=START:STOP:N``. Each point gives the steady velocity, the blocked thrust, and the efficiency at
half of this thrust. The closed forms of threshold and release give the factor by which the drive must change to reach
them; their lines are drawn where this factor is 1. A star marks the operating point of the scene. Expected: the slider
moves exactly where the drive exceeds the threshold, and leaves the surface in every cycle exactly where it exceeds the
release; the thrust is at most mu times the preload. Run time: about 8 s.
"""

import logging
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from fem.parameters import refuses
from studies.model.resolve import resolved
from studies.motor.regime_map import finite_lists, refuse_frictionless
from studies.record.plots import finished, logarithmic, own
from studies.record.prefixes import key_axis, si
from studies.record.quantities import quantity
from studies.record.values import Columns
from studies.refusal import RunError, SceneError, refuse_if
from studies.scene import Scene
from studies.scene.keys import rule_at, unit_of
from studies.scene.override import replaced, value_at
from studies.study_list import Answered, Finding, Panel, judged, of_record, study
from studies.sweeps import sweep
from studies.sweeps.axes import axis, level_key

LOGGER = logging.getLogger(__name__)

QUICK = {"counts": (3, 3)}
SMALLEST = 100.0  # ratio of the largest value of a map to the smallest value with a separate colour
# column of the sweep on each panel
PANELS = {
    "velocity": quantity.velocity_m_per_s, "thrust": quantity.thrust_N,
    "contact_efficiency": quantity.contact_efficiency, "motor_efficiency": quantity("panel.motor_efficiency"),
}  # fmt: skip


@study("twente-contact")
def run(
    scene: Scene, *, over: dict | None = None, counts: tuple[int, int] = (28, 22), tolerance: float = 1e-3
) -> Answered:
    """Return the maps, the lines of threshold and release, and the point of the scene.

    Parameters
    ----------
    over : dict, optional
        Two keys of numbers and their values, as for a sweep.
    counts : tuple of int
        Numbers of levels and of preloads, if ``over`` is None.
    tolerance : float
        Of the slider velocity.
    """
    resolved_scene = resolved(scene)
    if resolved_scene.slider is None:
        resolved_scene.refuse("slider", "is missing: without one there is nothing to map")
    table = resolved_scene.to_table()
    level = level_key(table) or ""
    axes = [axis(key, values) for key, values in (over or _default_axes(resolved_scene, level, counts)).items()]
    _check(axes)
    (x_key, y_key), (x, y) = (each.keys[0] for each in axes), (each.columns[0] for each in axes)
    title = resolved_scene.title
    if level not in (x_key, y_key):
        largest = max(resolved_scene.levels)
        table = replaced(table, level, [largest])
        title += f", {level.rpartition('.')[2].replace('_', ' ')} {si(largest, unit_of(rule_at(level)) or '')}"
    LOGGER.info(f"design map: {len(x) * len(y)} points")

    def report(total, done, failed, _seconds):
        LOGGER.info(f"design map: {done} of {total} points, {failed} failed")

    also = ("limits", "thrust", "efficiency")
    points = sweep(table, {y_key: y, x_key: x}, tolerance=tolerance, also=also, progress=report)
    failed = f"{points.failed} of {points.points} points have no answer"
    columns, shape = points.columns(), (len(y), len(x))
    grid = Columns(
        (name, np.array(column, float).reshape(shape))
        for name, column in columns.items()
        if name.endswith(("_factor", "_efficiency", "_m_per_s", "_N"))
    )
    known = np.isfinite(grid.velocity_m_per_s) & (grid.threshold_factor > 0.0)  # 0: there is no threshold
    if not known.any():
        raise RunError(f"the map is empty: {failed}, {columns.status[0]}")
    shared = {
        "x_key": x_key, "x": x, "y_key": y_key, "y": y, "own_x": _own(table, x_key), "own_y": _own(table, y_key),
        **{key: finite_lists(grid[key]) for key in ("threshold_factor", "release_factor")},
    }  # fmt: skip
    panels = [
        Panel(name=name, title=title, data=shared | {
            "value": finite_lists(grid[drawn.column]), "label": drawn.axis, "scale": drawn.scale,
        })
        for name, drawn in PANELS.items() if drawn.column in grid
    ]  # fmt: skip
    return panels, _findings(resolved_scene.slider, columns, grid, known, failed)


def _findings(slider: Any, columns: Columns, grid: Columns, known: np.ndarray, failed: str) -> Iterator[Finding]:
    """Yield the findings on regimes, efficiency and thrust at the points with a known answer, an array of bool."""
    moves, leaves = grid.velocity_m_per_s != 0.0, np.reshape(columns.regime, known.shape) == "intermittent"
    agreement = {
        "threshold": moves == (grid.threshold_factor < 1.0), "release": leaves == (grid.release_factor < 1.0)
    }  # fmt: skip
    for name, agrees in agreement.items():
        yield judged(f"The closed form of the {name} separates the regimes.", "fraction of points on the expected side",
                     np.mean(agrees[known]), holds=np.all(agrees[known]), expected="1", remark=failed)  # fmt: skip
    yield judged("The load receives less power than the wave delivers.", "largest efficiency of the contact",
                 np.nanmax(grid.contact_efficiency[known]), low=0, high=1)  # fmt: skip
    preload, mu = (
        np.reshape(columns.get(f"slider.{key}", [value] * known.size), known.shape).astype(float)
        for key, value in (("preload", slider.preload_force), ("friction_coefficient", slider.static_coefficient))
    )
    yield judged("The blocked thrust is at most mu times the preload.", "largest blocked thrust over mu times preload",
                 np.nanmax((grid.thrust_N / (mu * preload))[known]), low=0, high=1 + 1e-9,
                 expected="above 0, up to 1")  # fmt: skip


@of_record
def figure(record: Panel, ax):
    """Draw one quantity as contours, the closed forms as lines and the point of the scene as a star."""
    data = record.data
    value = np.ma.masked_invalid(np.asarray(data["value"], float) * data["scale"])
    (x_scale, x_label), (y_scale, y_label) = (key_axis(data[f"{at}_key"], np.abs(data[at]).max()) for at in "xy")
    x, y = x_scale * np.asarray(data["x"], float), y_scale * np.asarray(data["y"], float)
    if value.count() and np.ptp(value) > 0.0:
        levels = contour_levels(value.compressed())
        shades = BoundaryNorm(levels, 256)
        drawn = ax.contourf(x, y, value, levels=levels, cmap="viridis", norm=shades)
        bar = ax.figure.colorbar(drawn, ax=ax, label=data["label"], ticks=levels)
        bar.ax.tick_params(labelsize="small")
        between = [level for level in levels if level != 0.0]
        ax.contour(x, y, value, levels=between, colors="white", linestyles="solid", linewidths=0.5)
    for name, style in (("threshold", ":"), ("release", "--")):
        factor = np.asarray(data[f"{name}_factor"], float)
        factor = np.log(np.where(np.isfinite(factor) & (factor > 0.0), factor, 1e6))
        if factor.min() < 0.0 < factor.max():
            options = {"levels": [0.0], "colors": "black", "linestyles": style, "linewidths": 1.6}
            line = ax.contour(x, y, factor, **options)
            line.set_path_effects([withStroke(linewidth=3.0, foreground="white")])
            ax.plot([], [], style, color="black", linewidth=1.6, label=f"{name} (theory)")
    points = [(a * x_scale, b * y_scale) for a in data["own_x"] for b in data["own_y"]]
    inside = [(a, b) for a, b in points if x.min() <= a <= x.max() and y.min() <= b <= y.max()]
    if inside:
        own(ax, [a for a, _ in inside], [b for _, b in inside], "the scene's own")
    for side, values in ((ax.xaxis, x), (ax.yaxis, y)):
        if _even_in_logarithm(values):
            logarithmic(side)
    return finished(ax, x_label, y_label, record.title, grid=False)


def contour_levels(values) -> list[float]:
    """Return contour levels: uniform, or a 1-2-5 series if the values cover more than a decade.

    Half of a map may lie below a hundredth of its largest value, where uniform levels would show one colour.
    """
    low, high = float(values.min()), float(values.max())
    size = max(abs(low), abs(high))
    if low * high >= 0.0 and np.median(abs(values)) > 0.1 * size:
        return list(map(float, MaxNLocator(12).tick_values(low, high)))
    steps = np.outer(10.0 ** np.arange(-30.0, 30.0), (1, 2, 5)).ravel()

    def series(stop: float) -> list[float]:
        first, last = np.searchsorted(steps, (size / SMALLEST, stop))
        return steps[first : last + 1].tolist() if stop > 0.0 else []

    return [*(-level for level in reversed(series(-low))), 0.0, *series(high)]


def _default_axes(scene: Scene, level: str, counts: tuple[int, int]) -> dict:
    """Return axes of the level (amplitude or voltage) and of the preload that cover all regimes."""
    preload = scene.slider.preload
    refuse_frictionless(scene)
    table = replaced(scene.to_table(), level, [max(scene.levels)])
    columns = sweep(table, {}, also=("limits",), tolerance=1e-2).columns()
    factors = columns.threshold_factor[0], columns.release_factor[0]
    refuse_if(None in factors, "over", "must be used twice: this scene has no threshold or release to derive axes from")
    low, high = (max(scene.levels) * factor for factor in factors)
    return {
        level: np.geomspace(0.4 * low, 6.0 * high, counts[0]),
        "slider.preload": preload * np.geomspace(0.1, 10.0, counts[1]),
    }


@refuses(SceneError)
def _check(axes) -> Iterator[Any]:
    if len(axes) != 2:
        yield "over", f"must be used twice for a map, with START:STOP:N or a list, got {len(axes)}"
    for each in axes:
        values, key = each.columns[0], each.keys[0]
        if unit_of(rule_at(key)) is None or not all(isinstance(value, (int, float)) for value in values):
            yield f"over {key}", "must be of numbers for a map"
        if len(values) < 3 or not all(a < b for a, b in pairwise(values)):
            yield f"over {key}", "must hold three values or more for a map, rising"


def _own(table: dict, key: str) -> list[float]:
    """Return the numerical values of a key in the scene as a list, which may be empty."""
    value = value_at(table, key)
    return [each for each in (value if isinstance(value, list) else [value]) if isinstance(each, (int, float))]


def _even_in_logarithm(values) -> bool:
    if values[0] <= 0.0 or values[-1] <= 3.0 * values[0]:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6, atol=0.0))
