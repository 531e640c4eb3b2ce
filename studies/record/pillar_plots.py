"""Pictures of a slider on pillars: the wave along it, the forces on its pillars, and where the wave's power goes."""

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from studies.record.quantities import quantity

if TYPE_CHECKING:
    from studies.record import Record

BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#999999"  # Okabe and Ito
BELOW = {
    "loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "ncols": 3, "frameon": False, "fontsize": "small",
}  # fmt: skip
TITLE_LETTERS = 75  # of a line
MAX_DOTS = 20_000  # pillars drawn; of more, evenly chosen ones
SHARES = (
    ("friction_power_W", "friction", ORANGE),
    ("thrust_power_W", "thrust", GREEN),
    ("wave_power_out_W", "carried on by the wave", BLUE),
)


def wave_along(record: "Record", ax):
    """Draw amplitude and phase of the waves along the slider, the phase on an axis of its own."""
    table = record.slider_wave
    x = np.asarray(table["x_m"]) * 1e3
    ahead = np.abs(table["forward_m"]).max() >= np.abs(table["backward_m"]).max()
    names = ("forward_m", "backward_m") if ahead else ("backward_m", "forward_m")
    main, other = (np.asarray(table[name]) for name in names)
    ax.plot(x, np.abs(main) * 1e9, color=BLUE, label="wave that drives, amplitude")
    ax.plot(x, np.abs(other) * 1e9, color=GREY, label="wave against it, amplitude")
    for style, n in zip(("--", "-.", ":"), (2, 3, 4), strict=True):
        if f"overtone_{n}_m" in table:
            size = np.abs(np.asarray(table[f"overtone_{n}_m"])) * 1e9
            ax.plot(x, size, style, color=GREEN, label=f"its overtone {n}, amplitude")
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(quantity("offset_m").axis)
    ax.set_ylabel(quantity("normal_amplitude_m").axis)
    right = ax.twinx()
    phase = np.unwrap(np.angle(main))
    right.plot(x, phase - phase[0 if ahead else -1], dashes=(8, 3), color=ORANGE, label="phase")
    right.set_ylabel(quantity("phase_rad").axis)
    handles = [each for axis in (ax, right) for each in axis.get_lines()]
    ax.legend(handles=handles, **BELOW)
    ax.grid(alpha=0.3)
    _titled(ax, f"{record.scene.title}: wave under the slider")
    return ax


def pressure(record: "Record", ax):
    """Draw the mean force on each pillar as a dot at its place."""
    table = record.pillars
    step = -(-len(table["x_m"]) // MAX_DOTS)
    x, y, force = (np.asarray(table[name])[::step] for name in ("x_m", "y_m", "normal_force_N"))
    size = float(np.clip(6e4 / x.size, 2.0, 200.0))
    dots = ax.scatter(x * 1e3, y * 1e3, c=force * 1e3, s=size, marker="s", cmap="viridis", linewidths=0)
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel(quantity("offset_m").axis)
    ax.set_ylabel(quantity("y_m").axis)
    ax.figure.colorbar(dots, ax=ax, label=quantity("normal_force_N").axis)
    _titled(ax, f"{record.scene.title}: forces on the pillars")
    return ax


def power(record: "Record", ax):
    """Draw where the power of the waves below the slider goes at each level, as stacked bars."""
    points = [point for point in record.points if "wave_power_in_W" in point]
    scale = quantity(record.level).scale
    places, bottom = np.arange(len(points)), np.zeros(len(points))
    for key, label, colour in SHARES:
        values = np.array([100 * point[key] / point["wave_power_in_W"] for point in points])
        if values.any():
            ax.bar(places, values, bottom=bottom, color=colour, label=label)
            bottom = bottom + values
    for place, point in zip(places, points, strict=True):
        ax.text(place, 101.0, f"{point['wave_power_in_W']:.3g} W", ha="center", fontsize="small")
    ax.set_xticks(places, [f"{point[record.level] * scale:.4g}" for point in points])
    ax.set_ylim(0.0, 108.0)
    ax.set_xlabel(quantity(record.level).axis)
    ax.set_ylabel(quantity("power_share").axis)
    _titled(ax, f"{record.scene.title}: power of the wave")
    ax.legend(**BELOW)
    return ax


def _titled(ax, text: str) -> None:
    ax.set_title("\n".join(textwrap.wrap(text, TITLE_LETTERS)), fontsize="medium")
