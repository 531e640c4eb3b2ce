"""Pictures: quantity and unit on both axes, theory as lines, simulation as points, colours for every eye.

Every function takes and returns an Axes; ``saved`` makes the figure and the file, off screen.
"""

import base64
import io
import math
import textwrap
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from studies.record.quantities import quantity
from studies.refusal import RunError

if TYPE_CHECKING:
    from studies.record import Record

# Okabe and Ito's palette: told apart by the colour-blind and in grey
COLOURS = {
    "stick": "#999999",
    "slip": "#0072B2",
    "intermittent": "#D55E00",
    "line": "#000000",
    "second": "#009E73",
}
PALETTE = ("slip", "intermittent", "second", "stick", "line")  # of a family of curves
SIZE, DPI = (7.0, 4.3), 150  # inches; dots per inch
TITLE_COLUMNS = 11  # letters of a title per inch of the figure's width
LEGEND_WIDTH = 1.6  # inches of an entry of a legend below the axes
BELOW = 38  # points from the axes to a legend below them: room for ticks and label
MAX_WAVELENGTHS = 40  # of a surface whose ripple a picture of this width resolves
WINDOW, WINDOW_ROOM = 12, 2.4  # wavelengths about the slider that are drawn larger; height of the axes for it
MARKS = {"stick": "s", "slip": "o", "intermittent": "^"}


def pictures(record: "Record") -> dict[str, Callable]:
    """Return what draws the pictures of a run on an Axes, by the name of their file; the main result first."""
    drawings = {"velocity": velocity} if record.scene.slider is not None else {}
    if record.trajectories:
        drawings["trajectory"] = trajectories
    if record.surface:
        drawings["surface"] = surface if record.scene.transducer else profile
    if "scan" in record.measured or "trace" in record.measured:
        drawings["measured"] = measured_picture
    if record.pillars:
        from studies.record import pillar_plots

        drawings |= {"slider_wave": pillar_plots.wave_along, "pressure": pillar_plots.pressure}
        if any(point.get("wave_power_in_W") for point in record.points):
            drawings["power"] = pillar_plots.power
    return {name: partial(draw, record) for name, draw in drawings.items()}


def measured_picture(record: "Record", ax):
    """Draw a scan or a trace over the run's own field or motion."""
    block = record.measured
    if "scan" in block:
        return draw_scan(block, ax)
    trace, unit, up = block["trace"], "m_per_s", quantity("velocity_m_per_s")
    if "measured_m" in trace:
        unit, up = "m", quantity("travelled_m")
    time = trace["time_s"] * quantity("time_s").scale
    curve(ax, time, trace[f"predicted_{unit}"] * up.scale, "-", "slip", "computed")
    curve(ax, time, trace[f"measured_{unit}"] * up.scale, "o", "line", f"measured, {block['file']}", size=2.5)
    title = f"Measured over computed: {block['quantity']}"
    return finished(ax, quantity("time_s").axis, up.axis, title, columns=2)


def draw_scan(block: dict, ax):
    """Draw a scan over its prediction: magnitudes over the place or the frequency."""
    import numpy as np

    points = block["scan"]
    by_frequency = "frequency_Hz" in points and np.ptp(points["frequency_Hz"]) > 0.0
    key = "frequency_Hz" if by_frequency else "y_m" if np.ptp(points["x_m"]) == 0.0 else "x_m"
    along, up = quantity(key), quantity("amplitude_m_per_V")
    at = np.asarray(points[key]) * along.scale
    order = np.argsort(at, kind="stable")
    computed, measured = (
        np.abs(points[f"{name}_m_per_V"])[order] * up.scale for name in ("predicted", "measured")
    )
    curve(ax, at[order], computed, "-", "slip", "computed")
    curve(ax, at[order], measured, "o", "line", f"measured, {block['file']}", size=2.5)
    return finished(ax, along.axis, up.axis, f"Measured over computed: {block['quantity']}", columns=2)


def draw_run(record: "Record", folder: Path) -> None:
    """Draw the pictures that a record has, into a directory."""
    for name, draw in pictures(record).items():
        saved(folder / f"{name}.png", draw)


def refuse_without_toolkit(what: str, instead: str) -> None:
    """Refuse where matplotlib can open no window, and name what to do instead."""
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == "agg":
        raise RunError(
            f"{what} needs a toolkit that matplotlib can use: pip install PySide6 on a machine with a display; "
            f"{instead}"
        )


def show(*drawings: Callable) -> None:
    """Show what functions draw on an Axes, each in a window, until they are closed."""
    from matplotlib import pyplot

    for draw in drawings:
        draw(pyplot.figure(figsize=SIZE, layout="constrained").add_subplot())
    pyplot.show()


def new_figure(width: float, height: float, *, rows: int = 1, columns: int = 1, dpi: float = 100, **kwargs):
    """Return a Figure of some size in inches that is drawn off screen, and its Axes; None for no rows."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **kwargs) if rows else None


def saved(file, draw: Callable, *, size: tuple[float, float] = SIZE, **options) -> None:
    """Make a figure with one Axes, let it be drawn and save it; nothing is shown."""
    figure, ax = new_figure(*size, dpi=DPI)
    draw(ax)
    # laid out once; savefig would draw everything for the layout first
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    figure.savefig(file, **options)


def as_uri(draw: Callable, *, size: tuple[float, float] = SIZE, kind: str = "svg+xml") -> str:
    """Make a figure with one Axes, let it be drawn and return it as a data URI of a kind of image."""
    file, remarks = io.BytesIO(), {"metadata": {"Date": None}} if kind == "svg+xml" else {}
    saved(file, draw, size=size, format=kind[:3], **remarks)
    return data_uri(file.getvalue(), kind)


def data_uri(image: bytes, kind: str) -> str:
    """Return an image of a kind, such as "png", as a data URI."""
    return f"data:image/{kind};base64,{base64.b64encode(image).decode('ascii')}"


def legend_below(ax, handles=None, *, columns: int = 4) -> None:
    """Put the legend below the axes, where it covers no curve."""
    handles = ax.get_legend_handles_labels()[0] if handles is None else handles
    if handles and ax.figure.get_layout_engine() is None:  # no room is made below the axes
        ax.legend(handles=handles, loc="best", fontsize="small")
    elif handles:
        from matplotlib.transforms import ScaledTranslation

        below = ax.transAxes + ScaledTranslation(0.0, -BELOW / 72, ax.figure.dpi_scale_trans)
        labels = [each.get_label() for each in handles]
        room = max(int(ax.figure.get_figwidth() / LEGEND_WIDTH), 1)
        columns = min(columns, len(handles), room)
        ax.legend(
            handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below,
            ncols=columns, frameon=False, fontsize="small", borderaxespad=0.0,
        )  # fmt: skip


def finished(ax, across: str, up: str, title: str, *, columns: int = 4, grid: bool = True):
    """Write axes and title, put the legend below unless it has no columns, and return the Axes."""
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    titled(ax, title)
    if grid:
        ax.grid(alpha=0.3)
    if columns:
        legend_below(ax, columns=columns)
    return ax


def titled(ax, title: str) -> None:
    """Write a title, in as many lines as the figure's width asks for."""
    columns = int(TITLE_COLUMNS * ax.figure.get_figwidth())
    lines = [textwrap.fill(line, columns) for line in title.splitlines()]
    ax.set_title("\n".join(lines), fontsize="medium", parse_math=False)


def curve(ax, x, y, style: str, colour: str, label: str | None = None, *, size: float = 3.0) -> None:
    """Draw a curve in a colour of `COLOURS`: theory as a line, computed values as points of a size."""
    ax.plot(x, y, style, color=COLOURS[colour], linewidth=1, markersize=size, label=label)


def arrow(ax, tail, head, colour: str, *, width: float = 1.6) -> None:
    """Draw an arrow between two points (x, y) in a colour of matplotlib."""
    drawn = {"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", head, tail, arrowprops=drawn)


def own(ax, x, y, label: str) -> None:
    """Draw the points at which the scene itself stands, as stars."""
    star = {"color": "#CC79A7", "markersize": 9, "markeredgecolor": "black", "markeredgewidth": 0.4}
    ax.plot(x, y, "*", linestyle="none", label=label, **star)


def shaded(ax, start: float, stop: float, label: str | None = None, *, colour: str = "stick") -> None:
    """Shade what lies between two places of the horizontal axis: a transducer, a band."""
    ax.axvspan(start, stop, color=COLOURS[colour], alpha=0.25, linewidth=0, label=label)


def lines(ax, panel, across: str, rows, up: str, *, columns: int = 4):
    """Draw columns of a study's panel over a quantity, complex ones by their size, and finish the Axes.

    ``rows`` hold key, style, colour and label of each; ``across`` and ``up`` are keys of the table of quantities.
    """
    import numpy as np

    along, height = quantity(across), quantity(up)
    for key, style, colour, name in rows:
        y = np.asarray(panel.data[key]) * height.scale
        curve(ax, panel.data[across] * along.scale, abs(y) if y.dtype.kind == "c" else y, style, colour, name)
    return finished(ax, along.axis, height.axis, panel.title, columns=columns)


def family(curves: dict):
    """Return name, values and colour of each of a family of curves.

    Examples
    --------
    >>> list(family({"10 V": [1, 2]}))
    [('10 V', [1, 2], 'slip')]
    """
    return ((name, values, colour) for (name, values), colour in zip(curves.items(), PALETTE, strict=False))


def logarithmic(axis) -> None:
    """Make an axis logarithmic, with plain numbers at 1, 2 and 5, at decades alone where there are many."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    getattr(axis.axes, f"set_{axis.axis_name}scale")("log")
    low, high = sorted(axis.get_view_interval())
    few = high < 150 * low
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def velocity(record: "Record", ax):
    """Draw steady velocity against voltage or amplitude, by regime, with threshold and release."""
    unit, scale = quantity(record.level).axis, quantity(record.level).scale
    for regime, mark in MARKS.items():
        points = [point for point in record.points if point.get("regime") == regime]
        if points:
            at = [point[record.level] * scale for point in points]
            speeds = [point["velocity_m_per_s"] * 1e3 for point in points]
            ax.plot(at, speeds, mark, color=COLOURS[regime], label=regime)
    missed = [point for point in record.points if point.get("relative_error", 0.0) > record.tolerance]
    if missed:
        at = [point[record.level] * scale for point in missed]
        speeds = [point["velocity_m_per_s"] * 1e3 for point in missed]
        ring = {"markersize": 11, "fillstyle": "none", "color": COLOURS["line"]}
        ax.plot(at, speeds, "o", label=f"error above {record.tolerance:g}", **ring)
    banded = sorted((p[record.level] * scale, p["velocity_low_m_per_s"] * 1e3, p["velocity_high_m_per_s"] * 1e3)
                    for p in record.points if "velocity_low_m_per_s" in p)  # fmt: skip
    if banded:
        label = f"95 % of the tolerances ({record.uncertainty['method']})"
        ax.fill_between(
            *zip(*banded, strict=True), color=COLOURS["slip"], alpha=0.2, linewidth=0, label=label
        )
    for name, style in (("threshold", ":"), ("release", "--")):
        limit = record.summary.get(f"{name}_{record.level.removeprefix('normal_')}")
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
    return finished(ax, unit, quantity("velocity_m_per_s").axis, record.scene.title, columns=3)


def _power_axis(record: "Record", ax) -> None:
    """Put the source's available power on the upper axis, where it has a resistance."""
    available = record.electrical.get("power_available_W_per_V2")
    if available is None or not any(record.scene.levels):
        return
    import numpy as np
    from matplotlib.ticker import MaxNLocator

    upper = ax.secondary_xaxis(
        "top",
        functions=(
            lambda voltage: available * np.maximum(voltage, 0.0) ** 2,
            lambda power: np.sqrt(np.maximum(power, 0.0) / available),
        ),
    )
    upper.xaxis.set_major_locator(MaxNLocator(6))
    upper.set_xlabel(quantity("available_power_W").axis)


def _measured(record: "Record", ax, scale: float) -> None:
    """Draw measured points with their errors, and a line through the prediction that they are compared with."""
    points = record.measured["points"]
    known = {p[record.level]: p["velocity_m_per_s"] for p in record.points if "velocity_m_per_s" in p}
    known |= {p[record.level]: p["predicted_m_per_s"] for p in points if "predicted_m_per_s" in p}
    at, speeds = zip(*sorted(known.items()), strict=True)
    curve(ax, [x * scale for x in at], [v * 1e3 for v in speeds], "-", "line", "predicted")
    bars = [point["error_m_per_s"] * 1e3 for point in points] if "error_m_per_s" in points[0] else None
    at, speeds = zip(*((p[record.level] * scale, p["velocity_m_per_s"] * 1e3) for p in points), strict=True)
    style = {"markersize": 5, "markerfacecolor": "none", "capsize": 3, "label": "measured"}
    ax.errorbar(at, speeds, yerr=bars, fmt="D", color=COLOURS["second"], **style)


def trajectories(record: "Record", ax):
    """Draw v(t) of a burst at each level."""
    import matplotlib

    unit, scale = ("nm", 1e9) if record.level == "normal_amplitude_m" else ("V", 1.0)
    colours = matplotlib.colormaps["cividis"]
    count = max(len(record.trajectories) - 1, 1)
    for index, (level, motion) in enumerate(record.trajectories):
        label = f"{level * scale:g} {unit}" if index in (0, count) else None
        ax.plot(
            motion.time * 1e3, motion.velocity * 1e3, color=colours(index / count), linewidth=1, label=label
        )
    return finished(ax, quantity("time_s").axis, quantity("velocity_m_per_s").axis, record.scene.title)


def surface(record: "Record", ax, *, curves: bool = False):
    """Draw |u_z| and |u_x| per volt along the surface, with transducers and slider.

    Where the surface is many wavelengths long the ripple of a standing wave cannot be told apart: the range within
    each wavelength is shaded, and a window shows the curves about the slider (without one, the middle); ``curves``
    draws these alone.
    """
    columns, scene = record.surface, record.scene
    label, scale = quantity("x_m").axis, quantity("x_m").scale
    x = columns["x_m"] * scale
    what = "y = 0" if scene.driven_obliquely else "plane section"
    wavelength = scale * record.wave.get("phase_velocity_m_per_s", math.inf) / record.wave["frequency_Hz"]
    rippled = not curves and x[-1] - x[0] > MAX_WAVELENGTHS * wavelength
    sizes = [abs(columns[f"u_{axis}_m_per_V"]) * 1e9 for axis in "zx"]
    for size, colour, name in zip(sizes, ("slip", "intermittent"), (f"|u_z|, {what}", "|u_x|"), strict=True):
        if rippled:
            at, low, high = _ranges(x, size, wavelength)
            ax.fill_between(
                at, low, high, color=COLOURS[colour], alpha=0.5, linewidth=0.5, label=f"{name}, range"
            )
        else:
            curve(ax, x, size, "-", colour, name)
    if rippled:
        _window(record, ax, x, sizes, wavelength)
    for each in scene.transducer:
        if each.angle % 180 == 0:  # in the section
            half, center = each.half_length, each.place[0]
            shaded(ax, (center - half) * scale, (center + half) * scale)
    if scene.slider is not None:
        top = 1 / WINDOW_ROOM if rippled else 1.0
        ax.axvline(
            scene.slider.center[0] * scale, ymax=top, color=COLOURS["line"], linestyle=":", label="slider"
        )
    if "section_normal_m_per_V" in record.wave and scene.slider is not None:
        place = [scene.slider.center[0] * scale]
        for part, colour, what in (
            ("normal", "slip", "finite aperture"),
            ("tangential", "intermittent", None),
        ):
            curve(ax, place, [abs(record.wave[f"{part}_m_per_V"]) * 1e9], "D", colour, what, size=6.0)
    ax.set_ylim(bottom=0, top=WINDOW_ROOM * max(size.max() for size in sizes) if rippled else None)
    title = f"{scene.title}: {record.wave['frequency_Hz'] / 1e6:g} MHz"
    return finished(ax, label, quantity("amplitude_m_per_V").axis, title, columns=3, grid=False)


def _ranges(x, size, width: float):
    """Return the middles of intervals of a width along x, and the smallest and largest of ``size`` in each."""
    import numpy as np

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
    window.tick_params(labelsize="small")
    about = "the middle" if slider is None else "the slider"
    window.text(
        0.01, 0.06, f"{WINDOW} wavelengths about {about}", transform=window.transAxes, fontsize="small"
    )
    ax.axvspan(x[near][0], x[near][-1], ymax=1 / WINDOW_ROOM, fill=False, linestyle="--", linewidth=0.8)


def profile(record: "Record", ax):
    """Draw the free wave's displacements against depth."""
    columns = record.surface
    depth = -columns["z_m"] * 1e3
    for name, colour in (("u_z", "slip"), ("u_x", "intermittent"), ("u_y", "second")):
        values = columns[f"{name}_per_m_of_u_z"]
        if abs(values).max() > 1e-9:
            part, label = (values.imag, f"Im {name}") if name == "u_x" else (values.real, f"Re {name}")
            curve(ax, depth, part, ".-", colour, label)
    title = f"{record.scene.title}: {record.wave['phase_velocity_m_per_s']:.2f} m/s"
    return finished(ax, quantity("depth_m").axis, "displacement over u_z at the surface", title)


def errors(record: "Record", ax):
    """Draw the estimated error of each point, with what was asked for."""
    unit, scale = quantity(record.level).axis, quantity(record.level).scale
    known = [point for point in record.points if point.get("relative_error")]
    at, sizes = zip(*((p[record.level] * scale, p["relative_error"]) for p in known), strict=True)
    curve(ax, at, sizes, "o", "slip", "estimated error", size=5.0)
    ax.axhline(record.tolerance, color=COLOURS["line"], linestyle="--", linewidth=1, label="asked for")
    ax.set_yscale("log")
    return finished(ax, unit, quantity("relative_error").axis, record.scene.title)
