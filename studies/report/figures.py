"""Pictures: quantity and unit on both axes, theory as lines, simulation as points, colours for every eye.

Every function takes and returns an Axes; ``saved`` makes the figure and the file, off screen.
"""

import base64
import io
import textwrap
from collections.abc import Callable
from pathlib import Path

from studies.record import Record
from studies.refusal import RunError

__all__ = [
    "AXES",
    "COLOURS",
    "PALETTE",
    "as_svg",
    "curve",
    "draw_run",
    "errors",
    "family",
    "finished",
    "legend_below",
    "lines",
    "logarithmic",
    "own",
    "pictures",
    "profile",
    "refuse_without_toolkit",
    "saved",
    "shaded",
    "show",
    "surface",
    "titled",
    "trajectories",
    "velocity",
]

# Okabe and Ito's palette: told apart by the colour-blind and in grey
COLOURS = {
    "stick": "#999999",
    "slip": "#0072B2",
    "intermittent": "#D55E00",
    "line": "#000000",
    "second": "#009E73",
}
PALETTE = ("slip", "intermittent", "second", "stick", "line")  # of a family of curves
AXES = {
    "frequency_Hz": ("frequency (MHz)", 1e-6),
    "voltage_V": ("drive voltage, peak (V)", 1.0),
    "normal_amplitude_m": ("normal amplitude (nm)", 1e9),
    "position_m": ("place of the slider (mm)", 1e3),
    "x_m": ("x along the surface (mm)", 1e3),
}  # of a column: label of its axis, factor from SI units
SIZE, DPI = (7.0, 4.3), 150  # inches; dots per inch
TITLE_COLUMNS = 11  # letters of a title per inch of the figure's width
BELOW = 38  # points from the axes to a legend below them: room for ticks and label
MARKS = {"stick": "s", "slip": "o", "intermittent": "^"}


def pictures(record: Record) -> dict[str, Callable]:
    """Return the functions that draw what a run found, by the name of their file."""
    found = {"velocity": velocity} if record.scene.slider is not None else {}
    if record.trajectories:
        found["trajectory"] = trajectories
    if record.surface:
        found["surface"] = surface if record.scene.transducer else profile
    return found


def draw_run(record: Record, folder: Path) -> None:
    """Draw the pictures that a record has, into a directory."""
    for name, draw in pictures(record).items():
        saved(folder / f"{name}.png", lambda ax, draw=draw: draw(record, ax))


def refuse_without_toolkit(what: str, instead: str) -> None:
    """Refuse where matplotlib can open no window, and name what to do instead."""
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == "agg":
        raise RunError(
            f"{what} needs a toolkit that matplotlib can use: pip install PySide6 on a machine with a display; "
            f"{instead}"
        )


def show(record: Record) -> None:
    """Show what a run found in windows until they are closed: velocity and trajectories, or surface or profile."""
    from matplotlib import pyplot

    for draw in pictures(record).values():
        pyplot.figure(figsize=(7.0, 4.3), layout="constrained")
        draw(record, pyplot.gca())
    pyplot.show()


def saved(file, draw: Callable, *, size: tuple[float, float] = SIZE, **options) -> None:
    """Make a figure with one Axes, let it be drawn and save it; nothing is shown."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure.add_subplot())
    # laid out once; savefig would draw everything for the layout first
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    figure.savefig(file, **options)


def as_svg(draw: Callable, *, size: tuple[float, float] = SIZE) -> str:
    """Make a figure with one Axes, let it be drawn and return it as a data URI."""
    file = io.BytesIO()
    saved(file, draw, size=size, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def legend_below(ax, handles=None, *, columns: int = 4) -> None:
    """Put the legend below the axes, where it covers no curve."""
    handles = ax.get_legend_handles_labels()[0] if handles is None else handles
    if handles and ax.figure.get_layout_engine() is None:  # no room is made below the axes
        ax.legend(handles=handles, loc="best", fontsize="small")
    elif handles:
        from matplotlib.transforms import ScaledTranslation

        below = ax.transAxes + ScaledTranslation(0.0, -BELOW / 72, ax.figure.dpi_scale_trans)
        labels = [each.get_label() for each in handles]
        ax.legend(
            handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below,
            ncols=min(columns, len(handles)), frameon=False, fontsize="small", borderaxespad=0.0,
        )  # fmt: skip


def finished(ax, across: str, up: str, title: str, *, columns: int = 4, grid: bool = True):
    """Write axes and title, put the legend below, and return the Axes."""
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    titled(ax, title)
    if grid:
        ax.grid(alpha=0.3)
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


def own(ax, x, y, label: str) -> None:
    """Draw the points at which the scene itself stands, as stars."""
    star = {"color": "#CC79A7", "markersize": 9, "markeredgecolor": "black", "markeredgewidth": 0.4}
    ax.plot(x, y, "*", linestyle="none", label=label, **star)


def shaded(ax, start: float, stop: float, label: str | None = None, *, colour: str = "stick") -> None:
    """Shade what lies between two places of the horizontal axis: a transducer, a band."""
    ax.axvspan(start, stop, color=COLOURS[colour], alpha=0.25, linewidth=0, label=label)


def lines(ax, panel, across: str, rows, up: str, *, factor: float = 1.0, columns: int = 4):
    """Draw columns of a study's panel over one of `AXES`, complex ones by their size, and finish the Axes.

    ``rows`` hold key, style, colour and label of each; ``factor`` leads from SI units to those of the label ``up``.
    """
    import numpy as np

    label, scale = AXES[across]
    for key, style, colour, name in rows:
        y = np.asarray(panel.data[key]) * factor
        curve(ax, panel.data[across] * scale, abs(y) if y.dtype.kind == "c" else y, style, colour, name)
    return finished(ax, label, up, panel.title, columns=columns)


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


def velocity(record: Record, ax):
    """Draw steady velocity against voltage or amplitude, by regime, with threshold and release."""
    given = record.level == "normal_amplitude_m"
    scale, unit = (1e9, "normal amplitude (nm)") if given else (1.0, "drive voltage, peak (V)")
    for regime, mark in MARKS.items():
        chosen = [point for point in record.points if point.get("regime") == regime]
        if chosen:
            at = [point[record.level] * scale for point in chosen]
            speeds = [point["velocity_m_per_s"] * 1e3 for point in chosen]
            ax.plot(at, speeds, mark, color=COLOURS[regime], label=regime)
    banded = sorted((p[record.level] * scale, p["velocity_low_m_per_s"] * 1e3, p["velocity_high_m_per_s"] * 1e3)
                    for p in record.points if "velocity_low_m_per_s" in p)  # fmt: skip
    if banded:
        label = f"95 % of the tolerances ({record.uncertainty['method']})"
        ax.fill_between(
            *zip(*banded, strict=True), color=COLOURS["slip"], alpha=0.2, linewidth=0, label=label
        )
    for name, style in (("threshold", ":"), ("release", "--")):
        limit = record.summary.get(f"{name}_amplitude_m" if given else f"{name}_voltage_V")
        if limit is not None and limit * scale <= 1.2 * max(record.scene.levels) * scale:
            ax.axvline(
                limit * scale, color=COLOURS["line"], linestyle=style, linewidth=1, label=f"{name} (theory)"
            )
    speeds = [point["velocity_m_per_s"] for point in record.points if "velocity_m_per_s" in point]
    if speeds and not any(speeds) and not record.measured:
        ax.set_ylim(-1.0, 1.0)
        ax.text(0.5, 0.75, "at rest: the slider sticks at every level", transform=ax.transAxes, ha="center")
    if record.measured:
        _measured(record, ax, scale)
    ax.set_xlabel(unit)
    _power_axis(record, ax)
    ax.set_ylabel("slider velocity (mm/s)")
    titled(ax, record.scene.title)
    ax.grid(alpha=0.3)
    legend_below(ax, columns=3)
    return ax


def _power_axis(record: Record, ax) -> None:
    """Put the source's available power on the upper axis, where it has a resistance."""
    available = record.electrical.get("power_available_W_per_V2")
    if available is None or not any(record.scene.levels):
        return
    import numpy as np
    from matplotlib.ticker import MaxNLocator

    def power(voltage):
        return available * np.maximum(voltage, 0.0) ** 2

    def voltage(power):
        return np.sqrt(np.maximum(power, 0.0) / available)

    upper = ax.secondary_xaxis("top", functions=(power, voltage))
    upper.xaxis.set_major_locator(MaxNLocator(6))
    upper.set_xlabel("available power (W)")


def _measured(record: Record, ax, scale: float) -> None:
    """Draw measured points with their errors, and a line through the prediction that they are compared with."""
    known = sorted((p[record.level], p["velocity_m_per_s"]) for p in record.points if "velocity_m_per_s" in p)
    at, speeds = zip(*known, strict=True)
    ax.plot(
        [value * scale for value in at],
        [value * 1e3 for value in speeds],
        color=COLOURS["line"],
        linewidth=0.8,
        label="predicted",
        zorder=1,
    )
    points = record.measured["points"]
    bars = [point["error_m_per_s"] * 1e3 for point in points] if "error_m_per_s" in points[0] else None
    ax.errorbar(
        [point[record.level] * scale for point in points],
        [point["velocity_m_per_s"] * 1e3 for point in points],
        yerr=bars,
        fmt="D",
        color=COLOURS["second"],
        markersize=5,
        markerfacecolor="none",
        capsize=3,
        label="measured",
    )


def trajectories(record: Record, ax):
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
    return finished(ax, "time (ms)", "slider velocity (mm/s)", record.scene.title)


def surface(record: Record, ax):
    """Draw |u_z| and |u_x| per volt along the surface, with transducers and slider."""
    columns = record.surface
    x = columns["x_m"] * 1e3
    ax.plot(
        x,
        abs(columns["u_z_m_per_V"]) * 1e9,
        color=COLOURS["slip"],
        linewidth=0.8,
        label="|u_z|, plane section",
    )
    ax.plot(x, abs(columns["u_x_m_per_V"]) * 1e9, color=COLOURS["intermittent"], linewidth=0.8, label="|u_x|")
    for transducer in record.scene.transducer:
        if transducer.angle % 180:
            continue  # not in the section
        half, center = transducer.finger_pairs * transducer.period / 2, transducer.place[0]
        ends = (center - half) * 1e3, (center + half) * 1e3
        ax.axvspan(*ends, color=COLOURS["stick"], alpha=0.25, linewidth=0)
    if record.scene.slider is not None:
        ax.axvline(record.scene.slider.center[0] * 1e3, color=COLOURS["line"], linestyle=":", label="slider")
    ax.set_ylim(bottom=0)
    return finished(
        ax,
        "x along the surface (mm)",
        "amplitude per volt, peak (nm/V)",
        f"{record.scene.title}: {record.wave['frequency_Hz'] / 1e6:g} MHz",
        grid=False,
    )


def profile(record: Record, ax):
    """Draw the free wave's displacements against depth."""
    columns = record.surface
    depth = -columns["z_m"] * 1e3
    for name, colour in (("u_z", "slip"), ("u_x", "intermittent"), ("u_y", "second")):
        values = columns[f"{name}_per_m_of_u_z"]
        part = values.imag if name == "u_x" else values.real
        if abs(values).max() > 1e-9:
            label = f"Im {name}" if name == "u_x" else f"Re {name}"
            ax.plot(depth, part, ".-", color=COLOURS[colour], markersize=3, linewidth=0.8, label=label)
    return finished(
        ax,
        "depth (mm)",
        "displacement over u_z at the surface",
        f"{record.scene.title}: {record.wave['phase_velocity_m_per_s']:.2f} m/s",
    )


def errors(record: Record, ax):
    """Draw the estimated error of each point, with what was asked for."""
    given = record.level == "normal_amplitude_m"
    scale, unit = (1e9, "normal amplitude (nm)") if given else (1.0, "drive voltage, peak (V)")
    known = [point for point in record.points if point.get("relative_error")]
    at = [point[record.level] * scale for point in known]
    ax.semilogy(
        at, [point["relative_error"] for point in known], "o", color=COLOURS["slip"], label="estimated error"
    )
    ax.axhline(record.tolerance, color=COLOURS["line"], linestyle="--", linewidth=1, label="asked for")
    return finished(ax, unit, "relative error", record.scene.title)
