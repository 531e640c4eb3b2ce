"""The deformed section as a matplotlib figure: field, electrodes, slider, crystal axes; any instant.

A figure consists of views, one above the other, each a stretch of the section in its true proportions.  The
displacement is enlarged so that it is seen; the factor is written in the picture.  Field points are nodes: those nearer
to the one before than a pixel are passed over, and where nodes are far apart the modes and the elements'
polynomials give points between them.  Nothing is averaged.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from studies.refusal import SceneError
from studies.report.figures import arrow, new_figure
from studies.view import description
from studies.view.quantities import Shade, shade
from studies.view.run_field import LINES, RunField

__all__ = ["Section", "View", "chosen_views", "limits", "magnification", "near", "piece", "thinned", "views"]

MM = 1e3
AMPLITUDE = 0.08  # of a wavelength: as large as the largest displacement is drawn
CLOSE = 7.0  # wavelengths either side, in the close views
NARROWEST = 0.05  # wavelengths
DPI = 100
LEFT, RIGHT, ABOVE, BELOW = 90, 130, 30, 40  # pixels round a view, for letters and colour bar
BALL_SHARE = 0.35  # of a view's height that a ball takes at most
FACET = 4.0  # largest distance of drawn points over the smallest


@dataclass(frozen=True, kw_only=True)
class View:
    """A stretch of the section from start to stop (m), and its share of the picture's height."""

    name: str
    start: float
    stop: float
    weight: float


def limits(found: RunField, span) -> tuple[float, float] | None:
    """Return the stretch (m) that "whole", "slider", "wavelength" or two places mean; refuse one off the stator."""
    if span is None:
        return None
    if span == "whole":
        return 0.0, found.length
    if isinstance(span, str):
        half = (0.5 if span == "wavelength" else CLOSE) * found.wavelength
        return max(found.focus[1] - half, 0.0), min(found.focus[1] + half, found.length)
    if not 0 <= span[0] < span[1] <= found.length * (1 + 1e-9):
        rule = f"must lie on the stator, 0:{found.length * 1e3:g} mm"
        raise SceneError("--span", f"{rule}, got {span[0] * 1e3:g}:{span[1] * 1e3:g} mm")
    least = NARROWEST * found.wavelength
    if span[1] - span[0] < least:
        rule = f"must be at least {least * 1e3:.3g} mm long, a twentieth of a wavelength"
        raise SceneError("--span", f"{rule}, got {(span[1] - span[0]) * 1e3:.3g} mm")
    return span


def near(found: RunField) -> tuple[float, float]:
    """Return the two wavelengths (m) about what is to be looked at from near."""
    return found.focus[1] - found.wavelength, found.focus[1] + found.wavelength


def views(found: RunField) -> tuple[View, ...]:
    """Return what is shown unless something else is asked for: the whole, the driven transducer, the slider."""
    if found.free:
        return chosen_views(found, (0.0, found.length))
    driven, reach = found.scene.driven_transducer, CLOSE * found.wavelength
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.17)
    return whole, *(
        View(name=name, start=max(place - reach, 0.0), stop=min(place + reach, found.length), weight=0.4)
        for name, place in (
            (f"driven transducer {driven.name!r}", found.in_section(driven.place)),
            found.focus,
        )
    )


def chosen_views(found: RunField, span: tuple[float, float] | None) -> tuple[View, ...]:
    """Return the whole section and below it a stretch (m), what lies about the slider if None."""
    start, stop = span or limits(found, "slider")
    count = (stop - start) / found.wavelength
    name = "1 wavelength" if abs(count - 1) < 5e-4 else f"{count:.3g} wavelengths"
    if stop - start > 0.99 * found.length:
        return (View(name=name, start=start, stop=stop, weight=1.0),)
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.3)
    name = f"{name}, {start * MM:.4g} to {stop * MM:.4g} mm"
    return whole, View(name=name, start=start, stop=stop, weight=0.7)


def magnification(found: RunField) -> float:
    """Return how many times the displacement is enlarged unless asked otherwise: one round digit."""
    largest = float(abs(found.field.displacement).max())
    return float(f"{AMPLITUDE * found.wavelength / largest:.0e}") if largest else 1.0


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A piece of the section: x (n,) and z (m,) in m, complex u_x and u_z (n, m, 2), parts of a shade (n, m)."""

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray
    turns: int

    def places(self, phase: float, factor: float) -> np.ndarray:
        """Return the points' x and z in m with the displacement enlarged, shape (n, m, 2)."""
        moved = factor * (self.displacement * np.exp(1j * phase)).real
        return moved + np.stack(np.meshgrid(self.x, self.z, indexing="ij"), axis=-1)

    def values(self, phase: float) -> np.ndarray:
        """Return the coloured quantity at an instant, shape (n, m)."""
        return self.mean + (self.amplitude * np.exp(1j * self.turns * phase)).real


def piece(
    found: RunField, shading: Shade, *, span: tuple[float, float], bottom: float, spacing: float
) -> Piece:
    """Return a piece of the field between two places and down to a depth; neighbours at least a spacing (m) apart."""
    energies, facet = shading.quantity.turns == 2, FACET * spacing
    if facet < found.wavelength / LINES:
        field = found.compute(span=span, per_wavelength=found.wavelength / facet, energies=energies)
    else:
        field = found.whole(energies=energies)
    lines = thinned(field.x, spacing, *span)
    bottom = max(bottom, field.z[0])
    nodes = np.append(bottom, field.z[field.z > bottom])
    nodes = nodes[thinned(nodes, spacing, bottom, 0.0)]
    parts = [
        np.linspace(low, high, int(np.ceil((high - low) / facet)), endpoint=False)
        for low, high in pairwise(nodes)
    ]
    z = np.append(np.concatenate(parts), 0.0)
    basis = field.depth_basis(z)
    displacement, mean, amplitude = (
        np.einsum("kj,xj...->xk...", basis, values[lines])
        for values in (field.displacement[..., [0, 2]], *shading.parts(field))
    )
    return Piece(
        x=field.x[lines], z=z, displacement=displacement, mean=mean, amplitude=amplitude,
        turns=shading.quantity.turns,
    )  # fmt: skip


def thinned(places: np.ndarray, spacing: float, start: float, stop: float) -> np.ndarray:
    """Return the numbers of increasing places between two limits, each at least a spacing after the one before.

    The first and the last within the limits are always among them.

    Examples
    --------
    >>> thinned(np.array([0.0, 0.1, 0.2, 1.0, 2.0, 3.0]), 0.15, 0.0, 2.0)
    array([0, 2, 3, 4])
    """
    inside = np.flatnonzero((places >= start) & (places <= stop)).tolist()
    kept = inside[:1]
    for number in inside[1:]:
        if places[number] - places[kept[-1]] >= spacing:
            kept.append(number)
    if kept[-1] != inside[-1]:
        # the end is kept: its neighbour gives way
        kept[max(len(kept) - 1, 1) :] = inside[-1:]
    return np.array(kept)


class Section:
    """A figure of the deformed section: its views from top to bottom, each with the `Piece` that is drawn in it.

    ``phase`` is omega t in rad, ``factor`` that of the displacement (`magnification` if None), ``size`` in pixels.
    """

    def __init__(self, found: RunField, shown: tuple[View, ...], *, quantity, phase, factor, size):
        self.found, self.shown, self.size = found, shown, size
        self.factor = magnification(found) if factor is None else factor
        self.shade: Shade = shade(found, quantity)
        self.figure, _ = new_figure(size[0] / DPI, size[1] / DPI, rows=0, dpi=DPI)
        self.figure.set_layout_engine("none")
        total, upper = sum(view.weight for view in shown), 1.0
        self.pieces, self._moving = [], []
        for row, view in enumerate(shown):
            share = view.weight / total
            self._draw(row, view, upper - share, share)
            upper -= share
        self.show(phase)

    def show(self, phase: float) -> None:
        """Move everything to another instant."""
        for number, (ax, mesh, drawn, fingers) in enumerate(self._moving):
            if mesh is not None:
                mesh.remove()
            places = drawn.places(phase, self.factor) * MM
            mesh = ax.pcolormesh(
                places[..., 0], places[..., 1], drawn.values(phase), shading="gouraud",
                cmap=self.shade.colour_map, clim=self.shade.limits, zorder=1,
            )  # fmt: skip
            for lines, strips in fingers:
                lines.set_segments(
                    [
                        np.stack([np.interp(strip, drawn.x, places[:, -1, axis]) for axis in (0, 1)], axis=-1)
                        for strip in strips
                    ]
                )
            self._moving[number] = ax, mesh, drawn, fingers

    def _draw(self, row: int, view: View, low: float, share: float) -> None:
        """Draw one view into a strip of the figure."""
        found, (width, height) = self.found, self.size
        across = max(width - LEFT - RIGHT, 0.3 * width)
        up = max(share * height - ABOVE - BELOW, 0.3 * share * height)
        pixel = (view.stop - view.start) / across
        top, bottom = self._depths(view, up * pixel)
        ax = self.figure.add_axes((LEFT / width, low + BELOW / height, across / width, up / height))
        ax.set(xlim=(view.start * MM, view.stop * MM), ylim=(bottom * MM, top * MM), facecolor="none")
        ax.set_aspect("equal", anchor="N")
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize="small")
        ax.set_xlabel("x (mm)", fontsize="small", labelpad=1)
        deep = (top - bottom) / pixel
        if deep < 60:
            ax.set_yticks([bottom * MM, 0.0], [f"{bottom * MM:.2g} mm", "0"])
        else:
            ax.locator_params(axis="y", nbins=min(4, int(deep / 40)))
            ax.set_ylabel("z (mm)", fontsize="small")
        # moves into the view from beyond its edges, which cut it
        spare = min(self.factor * float(abs(found.field.displacement).max()), 2 * (view.stop - view.start))
        drawn = piece(
            found, self.shade, span=(max(view.start - spare, 0.0), min(view.stop + spare, found.length)),
            bottom=bottom - spare, spacing=pixel,
        )  # fmt: skip
        fingers = []
        for electrode in description.electrodes(found):
            strips = [
                np.linspace(left, right, 3)
                for left, right in electrode.strips
                if right > view.start and left < view.stop
            ]
            lines = LineCollection([], colors=electrode.colour, linewidths=3, zorder=3, capstyle="butt")
            ax.add_collection(lines, autolim=False)
            fingers.append((lines, strips))
        for ball in description.balls(found):
            centre = ball.place * MM, (ball.radius + self.factor * ball.crest) * MM
            ax.add_patch(
                Circle(centre, ball.radius * MM, color=description.BALL_COLOUR, linewidth=0, zorder=4)
            )
        self.pieces.append(drawn)
        self._moving.append((ax, None, drawn, fingers))
        self._write(ax, row, view, deep)

    def _depths(self, view: View, visible: float) -> tuple[float, float]:
        """Return the largest and the smallest z (m) of a view of some height (m): room for a ball, then depth."""
        found = self.found
        carries = any(view.start <= place <= view.stop for place in found.balls)
        room = 0.15 * min(visible, 2 * found.wavelength)
        top = min(2.1 * found.radius, BALL_SHARE * visible) if carries else room
        return top, max(float(found.field.z[0]), top - visible)

    def _write(self, ax, row: int, view: View, deep: float) -> None:
        """Write caption, crystal axes, legend and colour bar."""
        found, highest = self.found, max(each.weight for each in self.shown)
        fingers = description.shown_fingers(found, view.start, view.stop)
        name = f"{view.name}, {fingers}" if fingers else view.name
        if row == 0:
            scale = f"{found.field.frequency / 1e6:g} MHz, {found.drive}, {found.enlarged(self.factor)}"
            name = f"{found.scene.title}: {name} ({scale})"
        letters = float(np.clip(0.98 * self.size[0] / (0.75 * len(name)), 5, 10))
        ax.annotate(
            name, (0, 1), (8 - LEFT, 8), xycoords="axes fraction", textcoords="offset pixels",
            fontsize=letters, parse_math=False,
        )  # fmt: skip
        if deep > 100:
            colour = description.AXIS_COLOUR
            for axis, x, z in description.crystal_axes(found):
                place, given = (40 + 30 * x, 30 + 30 * z), {"xycoords": "axes pixels", "color": colour}
                ax.annotate(axis, place, ha="center", va="center", fontsize="small", **given)
                pixels = {"xycoords": "axes pixels", "textcoords": "axes pixels"}
                arrow(ax, (40, 30), (40 + 24 * x, 30 + 24 * z), colour, width=1.0, **pixels)
        if row == 0:
            handles = [
                Line2D([], [], color=each.colour, linewidth=3, label=each.label)
                for each in description.electrodes(found)
            ]
            if handles:
                self.figure.legend(
                    handles=handles, loc="upper right", frameon=False, fontsize="small",
                    handlelength=1, borderpad=0.2, bbox_to_anchor=(1.0, 1.0 - 24 / self.size[1]),
                )  # fmt: skip
        if view.weight == highest and not any(each.weight == highest for each in self.shown[:row]):
            box = ax.get_position(original=True)
            bar = self.figure.add_axes((1 - 105 / self.size[0], box.y0, 14 / self.size[0], 0.85 * box.height))
            colours = ScalarMappable(cmap=self.shade.colour_map)
            colours.set_clim(self.shade.limits)
            self.figure.colorbar(colours, cax=bar, ticks=[*self.shade.limits, 0.0], format="%.3g")
            bar.tick_params(labelsize="small")
            bar.set_title(self.shade.label.replace(" (", "\n("), fontsize="small", loc="left")
