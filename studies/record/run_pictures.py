"""The pictures of a run, each drawn from its record on an Axes.

`pictures` gives them their file names; `errors` is drawn by the page alone.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.record.pillar_pictures import power, pressure, slider_wave
from studies.record.plane_pictures import motions as plane_motions
from studies.record.plane_pictures import path as plane_path
from studies.record.plots import BACKGROUND, COLOURS, curve, finished, saved, shaded, titled, upper_half
from studies.record.quantities import Quantity, quantity
from studies.record.values import Columns

if TYPE_CHECKING:
    from studies.record import Record

MAX_WAVELENGTHS = 40  # length of a surface whose ripple a picture of this width resolves
HEADROOM = 1.12  # of an axis of amplitudes, over the largest, which would touch the frame
WINDOW = 12  # width in wavelengths of the second axes, about the slider
BETWEEN_HALVES = 1.1  # height of the label of two axes that share a unit, in that of the lower one
WINDOW_DENSITY = 5  # curves in it have so many values for each of surface.csv, which has 12 in a wavelength
MAX_LABELLED = 2  # points whose velocities are written beside them
COMPARED = ("predicted", "measured")  # beginnings of columns of a comparison
MARKS = {"stick": "s", "slip": "o", "intermittent": "^"}


def pictures(record: "Record") -> dict[str, Callable]:
    """Return the functions that draw the pictures of a run on an Axes, by file name; the main result first."""
    drawings = {"velocity": velocity} if record.scene.slider is not None else {}
    if record.trajectories and record.scene.planar:
        drawings["trajectory"] = plane_motions
        if record.scene.slider.axis is None:
            drawings["path"] = plane_path
    elif record.trajectories:
        drawings["trajectory"] = trajectories
    if record.surface:
        drawings["surface"] = surface if record.scene.transducer else profile
    if "scan" in record.measured or "trace" in record.measured:
        drawings["measured"] = measured_picture
    if record.slider_wave:
        drawings |= {"slider_wave": slider_wave, "pressure": pressure}
        if any(point.wave_power_in_W for point in record.points):
            drawings["power"] = power
    return {name: partial(draw, record) for name, draw in drawings.items()}


def measured_picture(record: "Record", ax):
    """Draw a scan or a trace over the run's own field or motion."""
    block = record.measured
    if "scan" in block:
        return draw_scan(block, ax)
    trace = block["trace"]
    unit, up = ("m", quantity.travelled_m) if "measured_m" in trace else ("m_per_s", quantity.velocity_m_per_s)
    computed, measured = ((trace[quantity.time_s.column], trace[f"{name}_{unit}"]) for name in COMPARED)
    return _over_computed(ax, block, (quantity.time_s, up), computed, measured)


def draw_scan(block: dict, ax):
    """Draw a scan over its prediction: magnitudes over the position or the frequency."""
    points, line = (Columns(block.get(name, {})) for name in ("scan", "line"))
    by_frequency = "frequency_Hz" in points and np.ptp(points.frequency_Hz) > 0.0
    along = quantity.frequency_Hz if by_frequency else quantity.y_m if np.ptp(points.x_m) == 0.0 else quantity.x_m
    order = np.argsort(points[along.column], kind="stable")
    where = ""
    if along == quantity.x_m and line and np.ptp(points.y_m) > 0.0:  # of an area its row
        order = order[points.y_m[order] == line.y_m[0]]
        where = f", y = {quantity.y_m.with_unit(line.y_m[0])}"
    x, measured = points[along.column][order], np.abs(points["measured_m_per_V"])[order]
    if not line:
        computed, style = (x, np.abs(points["predicted_m_per_V"])[order]), "-" if np.ptp(points.y_m) == 0.0 else "x"
    else:
        computed, style = (line[along.column], np.abs(line["predicted_m_per_V"])), "-"
    return _over_computed(ax, block, (along, quantity.amplitude_m_per_V), computed, (x, measured), style, where)


def _over_computed(
    ax, block: dict, axes: tuple[Quantity, Quantity], computed: tuple, measured: tuple, style="-", where=""
):
    """Draw measured values over a computed curve; each x and y in SI units, ``where`` ends the title.

    ``axes``: the quantities along both.
    """
    along, height = axes
    curve(ax, computed[0] * along.scale, computed[1] * height.scale, style, "slip", "computed")
    label = f"measured, {block['file']}"
    curve(ax, measured[0] * along.scale, measured[1] * height.scale, "o", "line", label, size=2.5)
    return finished(ax, along.axis, height.axis, f"Measured over computed: {block['quantity']}{where}", columns=2)


def draw_run(record: "Record", folder: Path, names: Sequence[str] | None = None) -> None:
    """Draw the pictures that a record has, or those of some names, into a directory."""
    for name, draw in pictures(record).items():
        if names is None or name in names:
            saved(folder / f"{name}.png", draw)


def velocity(record: "Record", ax):
    """Draw steady velocity against voltage or amplitude, by regime, with threshold and release.

    Of a slider in the plane, the velocity across is drawn too; of one on an axle, its rotation instead.
    """
    unit, scale = quantity(record.level).axis, quantity(record.level).scale
    axes = quantity(record.level), main_motion(record)
    where = ", at the position" if any(point.mean_velocity_m_per_s is not None for point in record.points) else ""
    for regime, mark in MARKS.items():
        points = [point for point in record.points if point.regime == regime]
        if points:
            ax.plot(*_shown(points, *axes), mark, color=COLOURS[regime], label=regime + where)
    if len(record.points) <= MAX_LABELLED:
        _values(ax, record, axes)
    _ripple(record, ax, axes[1])
    if axes[1] == quantity.velocity_m_per_s:
        _across(record, ax, axes[0])
    missed = [point for point in record.points if (point.relative_error or 0.0) > record.tolerance]
    if missed:
        ring = {"markersize": 11, "fillstyle": "none", "color": COLOURS["line"]}
        ax.plot(*_shown(missed, *axes), "o", label=f"error above {record.tolerance:g}", **ring)
    banded = sorted((p for p in record.points if p.velocity_low_m_per_s is not None), key=lambda point: point.level)
    if banded:
        label = f"95 % of the tolerances ({record.uncertainty.method})"
        band = _shown(banded, axes[0], quantity.velocity_low_m_per_s, quantity.velocity_high_m_per_s)
        ax.fill_between(*band, color=COLOURS["slip"], alpha=0.2, linewidth=0, label=label)
    for name, style in (("threshold", ":"), ("release", "--")):
        limit = record.limit(name)
        if limit is not None and limit <= 1.2 * max(record.scene.levels):
            options = {"linestyle": style, "linewidth": 1, "label": f"{name} (theory)"}
            ax.axvline(limit * scale, color=COLOURS["line"], **options)
    speeds = [point[axes[1].column] for point in record.points if axes[1].column in point]
    if speeds and not any(speeds) and not record.measured:
        ax.set_ylim(-1.0, 1.0)
        ax.text(0.5, 0.75, "at rest: the slider sticks at every level", transform=ax.transAxes, ha="center")
    if "points" in record.measured:
        _measured(record, ax, scale)
    _power_axis(record, ax)
    regimes, title = {point.regime for point in record.points if point.regime is not None}, record.scene.title
    alone = len(regimes) == len(ax.get_legend_handles_labels()[0]) == 1  # nothing for a legend to tell apart
    if alone:
        title = f"{title}\nevery point: {regimes.pop()}"
    return finished(ax, unit, axes[1].axis, title, columns=0 if alone else 3)


def main_motion(record: "Record") -> Quantity:
    """Return the quantity of a point that says how the slider moves: along x, or about its axle."""
    return quantity.velocity_m_per_s if record.scene.slider.axis is None else quantity.rotation_rpm


def _across(record: "Record", ax, level: Quantity) -> None:
    """Draw the velocity across of a slider in the plane, and its mean over place."""
    points = sorted((p for p in record.points if p.lateral_velocity_m_per_s is not None), key=lambda point: point.level)
    if not points:
        return
    at, across = _shown(points, level, quantity.lateral_velocity_m_per_s)
    curve(ax, at, across, "x", "second", "across (y)", size=6.0)
    means = [point for point in points if point.mean_lateral_velocity_m_per_s is not None]
    if means:
        at, across = _shown(means, level, quantity.mean_lateral_velocity_m_per_s)
        curve(ax, at, across, ":", "second", "across, mean over place")


def _values(ax, record: "Record", axes: tuple[Quantity, Quantity]) -> None:
    """Write the velocity beside each of a few points, on axes that begin at zero: so few show no curve."""
    points = [point for point in record.points if axes[1].column in point]
    largest = max(record.scene.levels) * axes[0].scale
    for point, x, y in zip(points, *_shown(points, *axes), strict=True):
        left = x > 0.5 * largest
        place = {"xytext": (-6 if left else 6, 0), "ha": "right" if left else "left", "va": "center"}
        text = axes[1].with_unit(point[axes[1].column])
        ax.annotate(text, (x, y), textcoords="offset points", fontsize="small", bbox=BACKGROUND, **place)
    ax.set_xlim(0.0, 1.15 * largest or None)
    ax.plot([0.0], [0.0], linestyle="none")  # the origin lies within the axes


def _ripple(record: "Record", ax, motion: Quantity) -> None:
    """Shade the range of the velocity over half a wavelength, and draw its mean over place; of a rotor over a turn."""
    if motion == quantity.rotation_rpm:
        points = sorted((p for p in record.points if p.mean_rotation_rpm is not None), key=lambda point: point.level)
        at, mean = _shown(points, quantity(record.level), quantity.mean_rotation_rpm)
        if points:
            curve(ax, at, mean, "-." if len(points) > 1 else "_", "line", "mean over a turn", size=10.0)
        return
    points = sorted((p for p in record.points if p.mean_velocity_m_per_s is not None), key=lambda point: point.level)
    if not points:
        return
    at, low, mean, high = _shown(
        points, quantity(record.level), quantity.lowest_velocity_m_per_s, quantity.mean_velocity_m_per_s,
        quantity.highest_velocity_m_per_s,
    )  # fmt: skip
    style = {"color": COLOURS["stick"], "linewidth": 0}
    if len(points) == 1:
        ax.vlines(
            at, low, high, color=COLOURS["stick"], alpha=0.4, linewidth=6, zorder=1, label="range, half a wavelength"
        )
        curve(ax, at, mean, "_", "line", "mean over place", size=10.0)
        return
    ax.fill_between(at, low, high, alpha=0.25, label="range, half a wavelength", **style)
    curve(ax, at, mean, "-.", "line", "mean over place")


def _shown(points, *columns: Quantity) -> list[Any]:
    """Return columns of points in the units in which they are drawn."""
    return [[point[each.column] * each.scale for point in points] for each in columns]


def _power_axis(record: "Record", ax) -> None:
    """Put the source's available power on the upper axis, where it has a resistance."""
    available = record.electrical.power_available_W_per_V2
    if available is None or not any(record.scene.levels):
        return
    from matplotlib.ticker import MaxNLocator

    functions = (
        lambda voltage: available * np.maximum(voltage, 0.0) ** 2,
        lambda power: np.sqrt(np.maximum(power, 0.0) / available),
    )
    upper = ax.secondary_xaxis("top", functions=functions)
    upper.xaxis.set_major_locator(MaxNLocator(6))
    upper.set_xlabel(quantity.available_power_W.axis)


def _measured(record: "Record", ax, scale: float) -> None:
    """Draw measured points with their errors, and a line through the prediction that they are compared with."""
    points = record.measured["points"]
    predicted = {p.level: p.velocity_m_per_s for p in record.points if p.velocity_m_per_s is not None}
    predicted |= {p[record.level]: p["predicted_m_per_s"] for p in points if "predicted_m_per_s" in p}
    speed, threshold = quantity.velocity_m_per_s.scale, record.limit("threshold")
    if threshold is not None and min(predicted) < threshold < max(predicted):
        predicted[threshold] = 0.0  # where the curve leaves zero
    at, speeds = zip(*sorted(predicted.items()), strict=True)
    curve(ax, [x * scale for x in at], [v * speed for v in speeds], "-", "line", "predicted")
    bars = [point["error_m_per_s"] * speed for point in points] if "error_m_per_s" in points[0] else None
    at, speeds = _shown(points, quantity(record.level), quantity.velocity_m_per_s)
    style = {"markersize": 5, "markerfacecolor": "none", "capsize": 3, "label": "measured"}
    ax.errorbar(at, speeds, yerr=bars, fmt="D", color=COLOURS["second"], **style)


def trajectories(record: "Record", ax):
    """Draw v(t) of a burst at each level, above it the distance that the slider has travelled, and the burst's end."""
    import matplotlib
    from scipy.integrate import cumulative_trapezoid

    shown, across, up = quantity(record.level), quantity.time_s, quantity.velocity_m_per_s
    along, upper = quantity.travelled_m, None if ax.get_subplotspec() is None else upper_half(ax, share=True)
    colours = matplotlib.colormaps["cividis"]
    count = max(len(record.trajectories) - 1, 1)
    for index, (level, motion) in enumerate(record.trajectories):
        label = shown.with_unit(level) if index in (0, count) else None
        time, velocity = motion.time * across.scale, motion.velocity * up.scale
        ax.plot(time, velocity, color=colours(index / count), linewidth=1, label=label)
        if upper is not None:
            travelled = cumulative_trapezoid(motion.velocity, motion.time, initial=0.0) * along.scale
            upper.plot(time, travelled, color=colours(index / count), linewidth=1)
    end = record.trajectories[0][1].duration * across.scale
    _waveform(record, ax if upper is None else upper, across)
    for each in (ax,) if upper is None else (upper, ax):
        each.axvline(end, color=COLOURS["line"], linestyle=":", linewidth=1, label="end of the burst")
    finished(ax, across.axis, up.axis, record.scene.title if upper is None else "")
    if upper is not None:
        upper.set_ylabel(along.axis)
        upper.grid(alpha=0.3)
        titled(upper, record.scene.title)
    return ax


def _waveform(record: "Record", ax, across: Quantity):
    """Draw the amplitude of the burst's waveform, if it has one, on an axis of its own at the right."""
    if record.scene.source.waveform is None:
        return
    from studies.record.waveform import instants, modulation  # contact is no part of a picture without a waveform

    shape = modulation(record.scene)
    if shape is None:
        return
    duration = record.scene.burst
    time = instants(shape.envelope, duration)
    right = ax.twinx()
    right.plot(time * across.scale, abs(shape.envelope.at(time)), color=COLOURS["line"], linewidth=1, alpha=0.4)
    right.set(ylim=(0.0, None), ylabel="amplitude of the drive\nover its level (grey)")


def surface(record: "Record", ax, *, curves: bool = False, window: bool = True):
    """Draw |u_z| and |u_x| per volt along the surface, with transducers and slider.

    The ripple of a standing wave cannot be resolved on a surface longer than MAX_WAVELENGTHS. The range within each
    wavelength is then shaded, and unless ``window`` is false the upper half of the place of ``ax`` shows the curves
    near the slider, or in the middle without one. With ``curves`` they are drawn along the whole surface whatever its
    length, for an axis that the caller limits.
    """
    columns, scene = record.surface, record.scene
    label, scale, up = quantity.x_m.axis, quantity.x_m.scale, quantity.amplitude_m_per_V
    x = columns.x_m * scale
    what = "y = 0" if scene.driven_obliquely else "plane section"
    wavelength = scale * (record.wave.phase_velocity_m_per_s or math.inf) / record.wave.frequency_Hz
    rippled = not curves and x[-1] - x[0] > MAX_WAVELENGTHS * wavelength
    values = [columns[f"u_{axis}_m_per_V"] * up.scale for axis in "zx"]
    sizes = [abs(each) for each in values]
    for size, colour, name in zip(sizes, ("slip", "intermittent"), (f"|u_z|, {what}", "|u_x|"), strict=True):
        if rippled:
            at, low, high = _ranges(x, size, wavelength)
            ax.fill_between(at, low, high, color=COLOURS[colour], alpha=0.5, linewidth=0.5, label=f"{name}, range")
        else:
            curve(ax, x, size, "-", colour, name)
    top = _window(record, ax, x, values, wavelength) if window and rippled and ax.get_subplotspec() is not None else ax
    for each in scene.transducer:
        if each.angle % 180 == 0:  # in the section
            half, center = each.half_length, each.center_xy[0]
            shaded(ax, (center - half) * scale, (center + half) * scale)
    for number, (start, stop) in enumerate(record.meshed_pieces):
        shaded(ax, start * scale, stop * scale, None if number else "meshed piece", colour="second")
    if scene.slider is not None:
        ax.axvline(scene.slider.center[0] * scale, color=COLOURS["line"], linestyle=":", label="slider")
    if record.wave.section_normal_m_per_V is not None and scene.slider is not None:
        position = [scene.slider.center[0] * scale]
        parts = (("normal", "slip", "finite aperture"), ("tangential", "intermittent", None))
        for part, colour, label_of_part in parts:
            curve(ax, position, [abs(record.wave[f"{part}_m_per_V"]) * up.scale], "D", colour, label_of_part, size=6.0)
    ax.set_ylim(0.0, HEADROOM * ax.dataLim.y1)
    finished(ax, label, up.axis, "", columns=3, grid=False)
    if top is not ax:
        ax.yaxis.label.set_y(BETWEEN_HALVES)
    titled(top, f"{scene.title}: {quantity.frequency_Hz.with_unit(record.wave.frequency_Hz)}")
    return ax


def _ranges(x, size, width: float):
    """Return the middles of intervals of a width along x, and the smallest and largest of ``size`` in each."""
    starts = np.searchsorted(x, np.arange(x[0], x[-1] - 0.5 * width, width))
    ends = np.append(starts[1:], len(x) - 1)
    return x[(starts + ends) // 2], np.minimum.reduceat(size, starts), np.maximum.reduceat(size, starts)


def _window(record: "Record", ax, x, values, wavelength: float):
    """Draw the curves within some wavelengths of the slider, or of the middle, in the upper half of an Axes' place.

    The complex motion is smooth, its magnitude has a ripple of half a wavelength, for which the samples are few: cubic
    splines through the motion are drawn, which differ from it by 2e-4 at 12 samples in a wavelength, (2 pi/12)^4/384.
    """
    from scipy.interpolate import CubicSpline

    scale, slider = quantity.x_m.scale, record.scene.slider
    middle = 0.5 * (x[0] + x[-1]) if slider is None else slider.center[0] * scale
    near = np.flatnonzero(abs(x - middle) <= 0.5 * WINDOW * wavelength)
    dense = np.linspace(x[near[0]], x[near[-1]], WINDOW_DENSITY * len(near))
    window = upper_half(ax)
    for motion, colour in zip(values, ("slip", "intermittent"), strict=True):
        smooth = CubicSpline(x, np.stack([motion.real, motion.imag]), axis=1)(dense)
        curve(window, dense, np.hypot(*smooth), "-", colour)
    if slider is not None:
        window.axvline(middle, color=COLOURS["line"], linestyle=":")
    window.set_xlim(dense[0], dense[-1])
    window.set_ylim(0.0, HEADROOM * window.dataLim.y1)
    window.tick_params(labelsize="small")
    about = "the middle" if slider is None else "the slider"
    text = f"{WINDOW} wavelengths about {about}"
    window.text(0.01, 0.06, text, transform=window.transAxes, fontsize="small", bbox=BACKGROUND)
    ax.axvspan(dense[0], dense[-1], fill=False, linestyle="--", linewidth=0.8)
    return window


def profile(record: "Record", ax):
    """Draw the free wave's displacements against depth."""
    columns, across = record.surface, quantity.depth_m
    depth = -columns.z_m * across.scale
    for axis, colour in (("z", "slip"), ("x", "intermittent"), ("y", "second")):
        values = columns[f"u_{axis}_per_m_of_u_z"]
        if abs(values).max() > 1e-9:
            part, label = (values.imag, f"Im u_{axis}") if axis == "x" else (values.real, f"Re u_{axis}")
            curve(ax, depth, part, ".-", colour, label)
    velocity = quantity.phase_velocity_m_per_s.with_unit(record.wave.phase_velocity_m_per_s)
    title = f"{record.scene.title}: {velocity}"
    return finished(ax, across.axis, quantity.relative_displacement.axis, title)


def errors(record: "Record", ax):
    """Draw the estimated error of each point, with the tolerance."""
    points = [point for point in record.points if point.relative_error]
    at, sizes = _shown(points, quantity(record.level), quantity.relative_error)
    curve(ax, at, sizes, "o", "slip", "estimated error", size=5.0)
    ax.axhline(record.tolerance, color=COLOURS["line"], linestyle="--", linewidth=1, label="tolerance")
    ax.set_yscale("log")
    return finished(ax, quantity(record.level).axis, quantity.relative_error.axis, record.scene.title)
