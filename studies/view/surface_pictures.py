"""Pictures of the moving surface: orbits along the stator, amplitude with its ripple, profile through the depth.

Every function takes plain arrays and returns a matplotlib Figure; nothing is shown or written.  Theory is a line,
computed values are points.
"""

import numpy as np

from studies.report.figures import COLOURS, legend_below

__all__ = ["amplitude", "anticlockwise", "depth_profile", "new_figure", "orbits"]

NM, MM = 1e9, 1e3
TURN = np.linspace(0.0, 2 * np.pi, 121)


def new_figure(width: float, height: float, *, rows: int = 1, columns: int = 1, **kwargs):
    """Return a Figure of some size in inches that is drawn off screen, and its Axes; None for no rows."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **kwargs) if rows else None


def anticlockwise(tangential, normal) -> np.ndarray:
    """Return whether orbits turn anticlockwise, x to the right and z up: x dz/dt - z dx/dt > 0.

    A wave that runs to +x turns so (retrograde: against the wave at the crest), one that runs to -x the other way.

    Examples
    --------
    >>> bool(anticlockwise(1j, 1.0)), bool(anticlockwise(-1j, 1.0))
    (True, False)
    """
    return np.imag(np.asarray(tangential) * np.conj(normal)) > 0


def orbits(places, tangential, normal, *, per: str, title: str):
    """Draw the orbits of surface points at places (m), complex u_x and u_z (m), an arrow along each at the crest."""
    places, tangential, normal = np.asarray(places), np.asarray(tangential) * NM, np.asarray(normal) * NM
    columns = min(6, len(places))
    rows = -(-len(places) // columns)
    figure, axes = new_figure(
        1.35 * columns + 0.6,
        1.55 * rows + 0.7,
        rows=rows,
        columns=columns,
        sharex=True,
        sharey=True,
        squeeze=False,
    )
    reach = 1.15 * max(abs(tangential).max(), abs(normal).max())
    for ax, place, a, b in zip(axes.flat, places, tangential, normal, strict=False):
        turning = bool(anticlockwise(a, b))
        colour = COLOURS["slip" if turning else "intermittent"]
        ax.plot((a * np.exp(1j * TURN)).real, (b * np.exp(1j * TURN)).real, color=colour, linewidth=1.4)
        crest = -np.angle(b)  # omega t of largest u_z
        # a stretch of the orbit about the crest, so that the arrow lies on it
        tail, head = (
            (a * np.exp(1j * t)).real + 1j * (b * np.exp(1j * t)).real for t in (crest - 0.35, crest + 0.35)
        )
        ax.annotate(
            "",
            (head.real, head.imag),
            (tail.real, tail.imag),
            arrowprops={
                "arrowstyle": "-|>",
                "color": colour,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 14,
            },
        )
        ax.plot([0], [0], "+", color=COLOURS["line"], markersize=5)
        ax.set_title(f"x = {place * MM:.4g} mm", fontsize="small")
        ax.set_aspect("equal")
        ax.set_xlim(-reach, reach)
        ax.set_ylim(-reach, reach)
        ax.tick_params(labelsize="x-small")
        ax.grid(alpha=0.3)
    for ax in axes.flat[len(places) :]:
        ax.set_visible(False)
    figure.supxlabel(f"u_x ({per}); arrow: motion at the crest", fontsize="small")
    figure.supylabel(f"u_z ({per})", fontsize="small")
    turning = anticlockwise(tangential, normal)
    colours = f"{turning.sum()} anticlockwise (blue), {(~turning).sum()} clockwise (orange)"
    figure.suptitle(f"{title}\nsurface orbits, {colours}", fontsize="medium")
    return figure


def amplitude(
    x, tangential, normal, *, wavelength: float, covered, focus: tuple[str, float], per: str, title: str
):
    """Draw |u_x| and |u_z| (m) along the surface (m), and within 4 wavelengths of the focus, its name and place."""
    figure, (whole, near) = new_figure(7.2, 5.2, rows=2)
    sizes = (("|u_z|", abs(normal) * NM, "slip"), ("|u_x|", abs(tangential) * NM, "intermittent"))
    name, place = focus
    window = abs(x - place) <= 4 * wavelength
    for ax, chosen, width in ((whole, slice(None), 0.7), (near, window, 1.4)):
        for label, size, colour in sizes:
            ax.plot(x[chosen] * MM, size[chosen], color=COLOURS[colour], linewidth=width, label=label)
        ax.axvline(place * MM, color=COLOURS["line"], linestyle=":", linewidth=1.2, label=name)
        ax.set_xlabel("x along the surface (mm)")
        ax.set_ylabel(f"amplitude, peak ({per})")
        highest = max(size[chosen].max() for _, size, _ in sizes)
        ax.set_ylim(0.0, 1.12 * highest)
        ax.grid(alpha=0.3)
    for start, stop in covered:
        whole.axvspan(start * MM, stop * MM, color=COLOURS["stick"], alpha=0.3, linewidth=0)
    whole.set_title(f"{title}\namplitude along the surface (grey: transducers)", fontsize="medium")
    size = abs(normal[abs(x - place) <= wavelength])
    ratio = size.max() / size.min()
    near.set_title(
        f"within 4 wavelengths of the {name}: largest over smallest |u_z| {ratio:.3g} (within one wavelength)",
        fontsize="small",
    )
    legend_below(near)
    return figure


def depth_profile(line_depth, analytic, computed, *, title: str):
    """Draw computed points of a wave, name to (depth in wavelengths, parts by name), on the lines of the half-space."""
    figure, ax = new_figure(7.2, 4.2)
    tones = [COLOURS["slip"], COLOURS["intermittent"], COLOURS["second"]]
    for name, tone in zip(analytic, tones, strict=False):
        ax.plot(line_depth, analytic[name], color=tone, linewidth=1.3, label=f"{name}, half-space (theory)")
    for number, (what, (depth, values)) in enumerate(computed.items()):
        for name, tone, mark in zip(values, tones, "o^s", strict=False):
            colour = COLOURS["stick"] if number else tone
            ax.plot(
                depth,
                values[name],
                mark,
                color=colour,
                markersize=3.5,
                zorder=2 - number,
                label=f"{name}, {what}",
            )
    ax.axhline(0, color=COLOURS["line"], linewidth=0.6)
    ax.set_xlabel("depth (wavelengths)")
    ax.set_ylabel("amplitude over |u_z| at the surface")
    ax.set_title(title, fontsize="medium")
    ax.grid(alpha=0.3)
    legend_below(ax, columns=2)
    return figure
