"""Pictures of motions in the plane: the path of the centre with the contacts at its end, and velocity and yaw."""

import numpy as np

from studies.record.plots import COLOURS, curve, finished, upper_half
from studies.record.quantities import quantity


def draw_path(ax, name: str, pose: np.ndarray, contacts: np.ndarray, colour: str) -> None:
    """Draw the path of poses (k, 3) and the contacts (n, 2), from the centre, at its last one."""
    along, across = quantity.x_m, quantity.y_m
    curve(ax, pose[:, 0] * along.scale, pose[:, 1] * across.scale, "-", colour, name)
    x, y, yaw = pose[-1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    at_x, at_y = cos * contacts[:, 0] - sin * contacts[:, 1] + x, sin * contacts[:, 0] + cos * contacts[:, 1] + y
    balls = at_x * along.scale, at_y * across.scale
    ax.fill(*balls, facecolor="none", edgecolor=COLOURS[colour], linewidth=0.8, alpha=0.6)
    ax.plot(*balls, "o", color=COLOURS[colour], markersize=3)


def path(record, ax):
    """Draw the path of the slider's centre in the burst at each level, with its end and that of the burst."""
    import matplotlib

    shown, along, across = quantity(record.level), quantity.travelled_m, quantity.travelled_m
    colours, count = matplotlib.colormaps["cividis"], max(len(record.trajectories) - 1, 1)
    for index, (level, motion) in enumerate(record.trajectories):
        x, y = (np.append(0.0, motion.pose[:, k]) * along.scale for k in (0, 1))
        label = shown.with_unit(level) if index in (0, count) else None
        ax.plot(x, y, color=colours(index / count), linewidth=1, label=label)
        ax.plot(x[-1], y[-1], "o", color=colours(index / count), markersize=4)
        if hasattr(motion, "duration"):
            end = motion.burst_end + 1
            ax.plot(x[end], y[end], "s", color=colours(index / count), markersize=4, markerfacecolor="none")
    grey = COLOURS["line"]
    if any(hasattr(motion, "duration") for _, motion in record.trajectories):
        ax.plot([], [], "s", color=grey, markersize=4, markerfacecolor="none", label="end of the burst")
    ax.plot([], [], "o", color=grey, markersize=4, label="end of the motion")
    ax.set_aspect("equal", adjustable="datalim")
    return finished(ax, f"x: {along.axis}", f"y: {across.axis}", record.scene.title)


def motions(record, ax):
    """Draw the velocity along x and y, or of an axle the yaw rate, against time, above it the yaw."""
    import matplotlib

    shown, time, up, yaw = quantity(record.level), quantity.time_s, quantity.velocity_m_per_s, quantity.yaw_rad
    rates: tuple = ((0, "-", "along x, "), (1, "--", "along y, "))
    if record.scene.slider.axis is not None:
        rates, up = ((2, "-", ""),), quantity.yaw_rate_rad_per_s
    colours, count = matplotlib.colormaps["cividis"], max(len(record.trajectories) - 1, 1)
    upper = upper_half(ax, share=True) if record.scene.slider.turns and ax.get_subplotspec() is not None else None
    for index, (level, motion) in enumerate(record.trajectories):
        colour, at = colours(index / count), motion.time * time.scale
        for k, style, name in rates:
            label = f"{name}{shown.with_unit(level)}" if index in (0, count) else None
            ax.plot(at, motion.rates[:, k] * up.scale, style, color=colour, linewidth=1, label=label)
        if upper is not None:
            upper.plot(at, motion.pose[:, 2] * yaw.scale, color=colour, linewidth=1)
        if hasattr(motion, "duration"):
            ax.axvline(motion.duration * time.scale, color=COLOURS["line"], linestyle=":", linewidth=1)
    finished(ax, time.axis, up.axis, record.scene.title if upper is None else "")
    if upper is not None:
        finished(upper, "", yaw.axis, record.scene.title, columns=0)
    return ax
