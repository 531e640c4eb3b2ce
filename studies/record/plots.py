"""How pictures are drawn: quantity and unit on both axes, theory as lines, simulation as points, colours for all eyes.

Functions that draw take and return an Axes; ``saved`` makes the figure and the file, off screen.
"""

import base64
import io
import re
import textwrap
from collections.abc import Callable

import numpy as np

from studies.record.quantities import Quantity
from studies.refusal import RunError

# Palette of Okabe and Ito, which can be distinguished with colour blindness and in grey
COLOURS = {"stick": "#999999", "slip": "#0072B2", "intermittent": "#D55E00", "line": "#000000", "second": "#009E73"}
PALETTE = ("slip", "intermittent", "second", "stick", "line")  # of a family of curves
SIZE, DPI = (7.0, 4.3), 150  # inches; dots per inch
TITLE_COLUMNS = 11  # letters of a title per inch of the figure's width
LEGEND_WIDTH = 1.6  # inches of an entry of a legend below the axes
NUMBER_AND_UNIT = re.compile(r"(?<=\d) (?=(?:[fpn\u00b5umkMG]?(?:Hz|m|V|N|s|W|g|Pa|ohm)|%|mm/s|m/s|1/min|rpm)(?:\W|$))")
BACKGROUND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}  # of words over curves
BELOW = 38  # points from the axes to a legend below them: room for ticks and label


def leave_out_property_tables() -> None:
    """Import matplotlib's artists without the tables of properties in their docstrings: a quarter of its import's time.

    For processes in which nobody reads these docstrings.
    """
    import matplotlib.artist

    matplotlib.artist.kwdoc = lambda artist: ""


def refuse_without_toolkit(what: str, instead: str) -> None:
    """Refuse where matplotlib can open no window, and name what to do instead."""
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == "agg":
        remedy = "pip install PySide6 on a machine with a display"
        raise RunError(f"{what} needs a toolkit that matplotlib can use: {remedy}; {instead}")


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
    lay_out(figure)
    figure.savefig(file, **options)


def lay_out(figure) -> None:
    """Lay a figure out once: with any layout engine, also "none", savefig draws everything once more beforehand."""
    if len(figure.axes) == 1:  # neither colour bar nor second axis: one pass of the layout, in half the time
        figure.set_layout_engine("tight", pad=0.3)
    figure.get_layout_engine().execute(figure)
    if any([_ticks_kept(ax) for ax in figure.axes]) or _beyond_left(figure):
        figure.get_layout_engine().execute(figure)
    figure.set_layout_engine(None)
    _words_within(figure)


def _beyond_left(figure) -> bool:
    """Return whether the label of a y axis leaves the picture: the ticks at the final size may be longer."""
    renderer = figure.canvas.get_renderer()
    boxes = [ax.yaxis.get_tightbbox(renderer) for ax in figure.axes]
    return any(box is not None and box.x0 < 0.0 for box in boxes)


def _words_within(figure) -> None:
    """Move titles along their axes, and labels of y axes, so far that they lie in the picture and apart.

    A layout leaves room beside the axes, not beyond the ends of words that are longer than these.
    """
    for ax in figure.axes:
        ax.apply_aspect()
        title = ax.title.get_window_extent()
        shift = max(0.0, -title.x0) - max(0.0, title.x1 - figure.bbox.width)
        ax.title.set_x(ax.title.get_position()[0] + shift / ax.bbox.width)
        label = ax.yaxis.label
        box = label.get_window_extent()
        below = ax.title.get_text() and title.x0 + shift < box.x1 and box.x0 < title.x1 + shift
        top = title.y0 if below else figure.bbox.height
        down = min(max(0.0, box.y1 - top), box.y0) if box.y0 > 0.0 else box.y0
        label.set_y(label.get_position()[1] - down / ax.bbox.height)


def _ticks_kept(ax) -> bool:
    """Keep the ticks of an Axes with equal scales at its final size; return whether it is one.

    A layout measures them before the scales have shrunk it, and leaves too little room for those that are drawn.
    """
    from matplotlib.ticker import AutoLocator

    if ax.get_aspect() == "auto":
        return False
    ax.apply_aspect()
    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_ticks([place for place in axis.get_majorticklocs() if low <= place <= high])
    return True


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
    """Write a title, wrapped to the figure's width."""
    columns = int(TITLE_COLUMNS * ax.figure.get_figwidth())
    # a number stays with its unit: textwrap breaks no line at U+00A0
    kept = [NUMBER_AND_UNIT.sub("\u00a0", line) for line in title.splitlines()]
    lines = [textwrap.fill(line, columns).replace("\u00a0", " ") for line in kept]
    # matplotlib finds the height only where an axis lies above: it measures all ticks for it, three times a picture
    height = None if any(child.get_in_layout() for child in ax.child_axes) else 1.0
    ax.set_title("\n".join(lines), fontsize="medium", parse_math=False, y=height)


def upper_half(ax, *, share: bool = False):
    """Move an Axes into the lower half of its place and return a new one in the upper half."""
    halves = ax.get_subplotspec().subgridspec(2, 1)
    ax.set_subplotspec(halves[1])
    upper = ax.figure.add_subplot(halves[0], sharex=ax if share else None)
    if share:
        upper.tick_params(labelbottom=False)
    return upper


def curve(ax, x, y, style: str, colour: str, label: str | None = None, *, size: float = 3.0) -> None:
    """Draw a curve in a colour of `COLOURS`: theory as a line, computed values as points of a size."""
    ax.plot(x, y, style, color=COLOURS[colour], linewidth=1, markersize=size, label=label)


def arrow(ax, tail, head, colour: str, *, width: float = 1.6) -> None:
    """Draw an arrow between two points (x, y) in a colour of matplotlib."""
    drawn = {"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", head, tail, arrowprops=drawn)


def own(ax, x, y, label: str) -> None:
    """Draw the points of the scene's own values, as stars."""
    star = {"color": "#CC79A7", "markersize": 9, "markeredgecolor": "black", "markeredgewidth": 0.4}
    ax.plot(x, y, "*", linestyle="none", label=label, **star)


def shaded(ax, start: float, stop: float, label: str | None = None, *, colour: str = "stick") -> None:
    """Shade an interval of the horizontal axis, such as a transducer or a band."""
    ax.axvspan(start, stop, color=COLOURS[colour], alpha=0.25, linewidth=0, label=label)


def lines(ax, panel, across: Quantity, curves, up: Quantity, *, columns: int = 4):
    """Draw columns of a study's panel over a quantity, complex ones by their size, and finish the Axes.

    ``curves`` hold key, style, colour and label of each.
    """
    for key, style, colour, name in curves:
        y = np.asarray(panel.data[key]) * up.scale
        x = panel.data[across.column] * across.scale
        curve(ax, x, abs(y) if y.dtype.kind == "c" else y, style, colour, name)
    return finished(ax, across.axis, up.axis, panel.title, columns=columns)


def symmetric_logarithmic(axis, linear: float) -> None:
    """Make an axis logarithmic on both sides of a linear range about zero, with plain numbers at the decades."""
    from matplotlib.ticker import FuncFormatter, SymmetricalLogLocator

    getattr(axis.axes, f"set_{axis.axis_name}scale")("symlog", linthresh=linear)
    axis.set_major_locator(SymmetricalLogLocator(base=10, linthresh=linear))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


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
