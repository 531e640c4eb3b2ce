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
from studies.record.plots import COLOURS, curve, finished, saved, shaded
from studies.record.quantities import quantity

if TYPE_CHECKING:
    from studies.record import Record

MAX_WAVELENGTHS = 40  # length of a surface whose ripple a picture of this width resolves
WINDOW = 12  # width in wavelengths of the inset about the slider
WINDOW_ROOM = 2.4  # upper limit of the axes over the largest amplitude, so that the inset has room above the curves
COMPARED = ("predicted", "measured")  # beginnings of columns of a comparison
MARKS = {"stick": "s", "slip": "o", "intermittent": "^"}


def pictures(record: "Record") -> dict[str, Callable]:
    """Return the functions that draw the pictures of a run on an Axes, by file name; the main result first."""
    drawings = {"velocity": velocity} if record.scene.slider is not None else {}
    if record.trajectories:
        drawings["trajectory"] = trajectories
    if record.surface:
        drawings["surface"] = surface if record.scene.transducer else profile
    if "scan" in record.measured or "trace" in record.measured:
        drawings["measured"] = measured_picture
    if record.pillars:
        drawings |= {"slider_wave": slider_wave, "pressure": pressure}
        if any(point.get("wave_power_in_W") for point in record.points):
            drawings["power"] = power
    return {name: partial(draw, record) for name, draw in drawings.items()}


def measured_picture(record: "Record", ax):
    """Draw a scan or a trace over the run's own field or motion."""
    block = record.measured
    if "scan" in block:
        return draw_scan(block, ax)
    trace = block["trace"]
    unit, up = ("m", "travelled_m") if "measured_m" in trace else ("m_per_s", "velocity_m_per_s")
    return _over_computed(ax, block, "time_s", trace["time_s"], up, *(trace[f"{name}_{unit}"] for name in COMPARED))


def draw_scan(block: dict, ax):
    """Draw a scan over its prediction: magnitudes over the position or the frequency."""
    points = block["scan"]
    by_frequency = "frequency_Hz" in points and np.ptp(points["frequency_Hz"]) > 0.0
    key = "frequency_Hz" if by_frequency else "y_m" if np.ptp(points["x_m"]) == 0.0 else "x_m"
    order = np.argsort(points[key], kind="stable")
    sizes = (np.abs(points[f"{name}_m_per_V"])[order] for name in COMPARED)
    return _over_computed(ax, block, key, points[key][order], "amplitude_m_per_V", *sizes)


def _over_computed(ax, block: dict, across: str, x, up: str, computed, measured):
    """Draw measured values over a computed curve, both in SI units."""
    along, height = quantity(across), quantity(up)
    curve(ax, x * along.scale, computed * height.scale, "-", "slip", "computed")
    curve(ax, x * along.scale, measured * height.scale, "o", "line", f"measured, {block['file']}", size=2.5)
    return finished(ax, along.axis, height.axis, f"Measured over computed: {block['quantity']}", columns=2)


def draw_run(record: "Record", folder: Path, names: Sequence[str] | None = None) -> None:
    """Draw the pictures that a record has, or those of some names, into a directory."""
    for name, draw in pictures(record).items():
        if names is None or name in names:
            saved(folder / f"{name}.png", draw)


def velocity(record: "Record", ax):
    """Draw steady velocity against voltage or amplitude, by regime, with threshold and release."""
    unit, scale = quantity(record.level).axis, quantity(record.level).scale
    axes = record.level, "velocity_m_per_s"
    for regime, mark in MARKS.items():
        points = [point for point in record.points if point.get("regime") == regime]
        if points:
            ax.plot(*_shown(points, *axes), mark, color=COLOURS[regime], label=regime)
    missed = [point for point in record.points if point.get("relative_error", 0.0) > record.tolerance]
    if missed:
        ring = {"markersize": 11, "fillstyle": "none", "color": COLOURS["line"]}
        ax.plot(*_shown(missed, *axes), "o", label=f"error above {record.tolerance:g}", **ring)
    banded = sorted((p for p in record.points if "velocity_low_m_per_s" in p), key=lambda point: point[record.level])
    if banded:
        label = f"95 % of the tolerances ({record.uncertainty['method']})"
        band = _shown(banded, record.level, "velocity_low_m_per_s", "velocity_high_m_per_s")
        ax.fill_between(*band, color=COLOURS["slip"], alpha=0.2, linewidth=0, label=label)
    for name, style in (("threshold", ":"), ("release", "--")):
        limit = record.limit(name)
        if limit is not None and limit <= 1.2 * max(record.scene.levels):
            options = {"linestyle": style, "linewidth": 1, "label": f"{name} (theory)"}
            ax.axvline(limit * scale, color=COLOURS["line"], **options)
    speeds = [point["velocity_m_per_s"] for point in record.points if "velocity_m_per_s" in point]
    if speeds and not any(speeds) and not record.measured:
        ax.set_ylim(-1.0, 1.0)
        ax.text(0.5, 0.75, "at rest: the slider sticks at every level", transform=ax.transAxes, ha="center")
    if "points" in record.measured:
        _measured(record, ax, scale)
    _power_axis(record, ax)
    regimes, title = {point["regime"] for point in record.points if "regime" in point}, record.scene.title
    alone = len(regimes) == len(ax.get_legend_handles_labels()[0]) == 1  # nothing for a legend to tell apart
    if alone:
        title = f"{title}\nevery point: {regimes.pop()}"
    return finished(ax, unit, quantity("velocity_m_per_s").axis, title, columns=0 if alone else 3)


def _shown(points, *keys: str) -> list[Any]:
    """Return columns of points in the units in which they are drawn."""
    return [[point[key] * quantity(key).scale for point in points] for key in keys]


def _power_axis(record: "Record", ax) -> None:
    """Put the source's available power on the upper axis, where it has a resistance."""
    available = record.electrical.get("power_available_W_per_V2")
    if available is None or not any(record.scene.levels):
        return
    from matplotlib.ticker import MaxNLocator

    functions = (
        lambda voltage: available * np.maximum(voltage, 0.0) ** 2,
        lambda power: np.sqrt(np.maximum(power, 0.0) / available),
    )
    upper = ax.secondary_xaxis("top", functions=functions)
    upper.xaxis.set_major_locator(MaxNLocator(6))
    upper.set_xlabel(quantity("available_power_W").axis)


def _measured(record: "Record", ax, scale: float) -> None:
    """Draw measured points with their errors, and a line through the prediction that they are compared with."""
    points = record.measured["points"]
    predicted = {p[record.level]: p["velocity_m_per_s"] for p in record.points if "velocity_m_per_s" in p}
    predicted |= {p[record.level]: p["predicted_m_per_s"] for p in points if "predicted_m_per_s" in p}
    speed = quantity("velocity_m_per_s").scale
    at, speeds = zip(*sorted(predicted.items()), strict=True)
    curve(ax, [x * scale for x in at], [v * speed for v in speeds], "-", "line", "predicted")
    bars = [point["error_m_per_s"] * speed for point in points] if "error_m_per_s" in points[0] else None
    at, speeds = _shown(points, record.level, "velocity_m_per_s")
    style = {"markersize": 5, "markerfacecolor": "none", "capsize": 3, "label": "measured"}
    ax.errorbar(at, speeds, yerr=bars, fmt="D", color=COLOURS["second"], **style)


def trajectories(record: "Record", ax):
    """Draw v(t) of a burst at each level."""
    import matplotlib

    shown, across, up = quantity(record.level), quantity("time_s"), quantity("velocity_m_per_s")
    colours = matplotlib.colormaps["cividis"]
    count = max(len(record.trajectories) - 1, 1)
    for index, (level, motion) in enumerate(record.trajectories):
        label = shown.with_unit(level) if index in (0, count) else None
        time, velocity = motion.time * across.scale, motion.velocity * up.scale
        ax.plot(time, velocity, color=colours(index / count), linewidth=1, label=label)
    return finished(ax, across.axis, up.axis, record.scene.title)


def surface(record: "Record", ax, *, curves: bool = False):
    """Draw |u_z| and |u_x| per volt along the surface, with transducers and slider.

    The ripple of a standing wave cannot be resolved on a surface longer than MAX_WAVELENGTHS. The range within each
    wavelength is then shaded, and an inset shows the curves near the slider, or in the middle without a slider. With
    ``curves`` the curves are drawn along the whole surface whatever its length, for an axis that the caller limits.
    """
    columns, scene = record.surface, record.scene
    label, scale, up = quantity("x_m").axis, quantity("x_m").scale, quantity("amplitude_m_per_V")
    x = columns["x_m"] * scale
    what = "y = 0" if scene.driven_obliquely else "plane section"
    wavelength = scale * record.wave.get("phase_velocity_m_per_s", math.inf) / record.wave["frequency_Hz"]
    rippled = not curves and x[-1] - x[0] > MAX_WAVELENGTHS * wavelength
    sizes = [abs(columns[f"u_{axis}_m_per_V"]) * up.scale for axis in "zx"]
    for size, colour, name in zip(sizes, ("slip", "intermittent"), (f"|u_z|, {what}", "|u_x|"), strict=True):
        if rippled:
            at, low, high = _ranges(x, size, wavelength)
            ax.fill_between(at, low, high, color=COLOURS[colour], alpha=0.5, linewidth=0.5, label=f"{name}, range")
        else:
            curve(ax, x, size, "-", colour, name)
    if rippled:
        _window(record, ax, x, sizes, wavelength)
    for each in scene.transducer:
        if each.angle % 180 == 0:  # in the section
            half, center = each.half_length, each.center_xy[0]
            shaded(ax, (center - half) * scale, (center + half) * scale)
    for number, (start, stop) in enumerate(record.meshed_pieces):
        shaded(ax, start * scale, stop * scale, None if number else "meshed piece", colour="second")
    if scene.slider is not None:
        top = 1 / WINDOW_ROOM if rippled else 1.0
        ax.axvline(scene.slider.center[0] * scale, ymax=top, color=COLOURS["line"], linestyle=":", label="slider")
    if "section_normal_m_per_V" in record.wave and scene.slider is not None:
        position = [scene.slider.center[0] * scale]
        parts = (("normal", "slip", "finite aperture"), ("tangential", "intermittent", None))
        for part, colour, label_of_part in parts:
            curve(ax, position, [abs(record.wave[f"{part}_m_per_V"]) * up.scale], "D", colour, label_of_part, size=6.0)
    ax.set_ylim(bottom=0, top=WINDOW_ROOM * max(size.max() for size in sizes) if rippled else None)
    title = f"{scene.title}: {quantity('frequency_Hz').with_unit(record.wave['frequency_Hz'])}"
    return finished(ax, label, up.axis, title, columns=3, grid=False)


def _ranges(x, size, width: float):
    """Return the middles of intervals of a width along x, and the smallest and largest of ``size`` in each."""
    starts = np.searchsorted(x, np.arange(x[0], x[-1] - 0.5 * width, width))
    ends = np.append(starts[1:], len(x) - 1)
    return x[(starts + ends) // 2], np.minimum.reduceat(size, starts), np.maximum.reduceat(size, starts)


def _window(record: "Record", ax, x, sizes, wavelength: float) -> None:
    """Draw the curves within some wavelengths of the slider, or of the middle, above the whole surface."""
    scale, slider = quantity("x_m").scale, record.scene.slider
    middle = 0.5 * (x[0] + x[-1]) if slider is None else slider.center[0] * scale
    near = abs(x - middle) <= 0.5 * WINDOW * wavelength
    window = ax.inset_axes([0.07, 0.58, 0.9, 0.37])
    for size, colour in zip(sizes, ("slip", "intermittent"), strict=True):
        curve(window, x[near], size[near], "-", colour)
    if slider is not None:
        window.axvline(middle, color=COLOURS["line"], linestyle=":")
    window.set_ylim(bottom=0)
    window.set_in_layout(False)  # it lies within the axes
    window.tick_params(labelsize="small")
    about = "the middle" if slider is None else "the slider"
    window.text(0.01, 0.06, f"{WINDOW} wavelengths about {about}", transform=window.transAxes, fontsize="small")
    ax.axvspan(x[near][0], x[near][-1], ymax=1 / WINDOW_ROOM, fill=False, linestyle="--", linewidth=0.8)


def profile(record: "Record", ax):
    """Draw the free wave's displacements against depth."""
    columns, across = record.surface, quantity("depth_m")
    depth = -columns["z_m"] * across.scale
    for name, colour in (("u_z", "slip"), ("u_x", "intermittent"), ("u_y", "second")):
        values = columns[f"{name}_per_m_of_u_z"]
        if abs(values).max() > 1e-9:
            part, label = (values.imag, f"Im {name}") if name == "u_x" else (values.real, f"Re {name}")
            curve(ax, depth, part, ".-", colour, label)
    velocity = quantity("phase_velocity_m_per_s").with_unit(record.wave["phase_velocity_m_per_s"])
    title = f"{record.scene.title}: {velocity}"
    return finished(ax, across.axis, quantity("relative_displacement").axis, title)


def errors(record: "Record", ax):
    """Draw the estimated error of each point, with the tolerance."""
    points = [point for point in record.points if point.get("relative_error")]
    at, sizes = _shown(points, record.level, "relative_error")
    curve(ax, at, sizes, "o", "slip", "estimated error", size=5.0)
    ax.axhline(record.tolerance, color=COLOURS["line"], linestyle="--", linewidth=1, label="tolerance")
    ax.set_yscale("log")
    return finished(ax, quantity(record.level).axis, quantity("relative_error").axis, record.scene.title)
