"""The pictures of a run with a slider on pillars: the wave below it, the forces on its pillars, and the power."""

from typing import TYPE_CHECKING

import numpy as np

from studies.record.plots import COLOURS, finished, legend_below
from studies.record.prefixes import si
from studies.record.quantities import quantity

if TYPE_CHECKING:
    from studies.record import Record

MAX_DOTS = 20_000  # pillars drawn; of more pillars every n-th
MAX_TEXTS = 8  # numbers above the bars that fit beside each other
# what the wave under a slider on pillars loses: key of a point, label, colour
LOSSES = (("friction_power_W", "friction", "intermittent"), ("thrust_power_W", "thrust", "second"))


def _at_last_level(record: "Record") -> str:
    """Return the level of a record's pillars and waves, the last that has an answer, for a title."""
    levels = [point.level for point in record.points if point.velocity_m_per_s is not None]
    return f" at {quantity(record.level).with_unit(levels[-1])}" if levels else ""


def slider_wave(record: "Record", ax):
    """Draw amplitude and phase of the waves along the slider, the phase on an axis of its own."""
    table, across, up = record.slider_wave, quantity.offset_m, quantity.normal_amplitude_m
    x = table.x_m * across.scale
    ahead = np.abs(table.forward_m).max() >= np.abs(table.backward_m).max()
    main, other = (table.forward_m, table.backward_m) if ahead else (table.backward_m, table.forward_m)
    ax.plot(x, np.abs(main) * up.scale, color=COLOURS["slip"], label="driving wave, amplitude")
    ax.plot(x, np.abs(other) * up.scale, color=COLOURS["stick"], label="opposing wave, amplitude")
    for style, n in zip(("--", "-.", ":"), (2, 3, 4), strict=True):
        if f"overtone_{n}_m" in table:
            size = np.abs(table[f"overtone_{n}_m"]) * up.scale
            ax.plot(x, size, style, color=COLOURS["second"], label=f"its overtone {n}, amplitude")
    ax.set_ylim(bottom=0.0)
    right = ax.twinx()
    phase = np.unwrap(np.angle(main))
    right.plot(x, phase - phase[0 if ahead else -1], dashes=(8, 3), color=COLOURS["intermittent"], label="phase")
    right.set_ylabel(quantity.phase_rad.axis)
    legend_below(ax, [each for axis in (ax, right) for each in axis.get_lines()], columns=3)
    title = f"{record.scene.title}: wave under the slider{_at_last_level(record)}"
    return finished(ax, across.axis, up.axis, title, columns=0)


def pressure(record: "Record", ax):
    """Draw the mean force on each pillar as a dot at its position."""
    table = record.pillars
    step = -(-len(table.x_m) // MAX_DOTS)
    across, up, shade = quantity.offset_m, quantity.y_m, quantity.normal_force_N
    x, y, force = (
        table.x_m[::step] * across.scale,
        table.y_m[::step] * up.scale,
        table.normal_force_N[::step] * shade.scale,
    )
    size = float(np.clip(6e4 / x.size, 2.0, 200.0))
    dots = ax.scatter(x, y, c=force, s=size, marker="s", cmap="viridis", linewidths=0.6)
    ax.set_aspect("equal", adjustable="box")
    ax.figure.colorbar(dots, ax=ax, label=shade.axis)
    title = f"Forces on the pillars{_at_last_level(record)}"
    return finished(ax, across.axis, up.axis, title, columns=0, grid=False)


def power(record: "Record", ax):
    """Draw what the waves below the slider lose at each level, as stacked bars, and above them what remains."""
    points = [point for point in record.points if point.wave_power_in_W is not None]
    level, share = quantity(record.level), quantity("power_share")
    positions, top = np.arange(len(points)), np.zeros(len(points))
    for key, label, colour in LOSSES:
        values = np.array([share.scale * point[key] / point.wave_power_in_W for point in points])
        if values.any():
            ax.bar(positions, values, bottom=top, color=COLOURS[colour], label=label)
            top = top + values
    highest, step = max(float(top.max()), 1e-3), -(-len(points) // MAX_TEXTS)
    for position, height, point in zip(positions, top, points, strict=True):
        remaining = share.scale * point.wave_power_out_W / point.wave_power_in_W
        text = f"{remaining:.3g} %\nof {si(point.wave_power_in_W, 'W', 3)}"
        if position % step == 0:
            ax.text(position, height + 0.01 * highest, text, ha="center", va="bottom", fontsize="small")
    ax.set_xticks(positions[::step], [level.text(point.level) for point in points[::step]])
    ax.set_xlim(-0.75, len(points) - 0.25)
    ax.set_ylim(0.0, 1.2 * highest)
    title = f"{record.scene.title}: power that the wave loses; in numbers, what remains in it"
    return finished(ax, level.axis, share.axis, title, columns=3, grid=False)
