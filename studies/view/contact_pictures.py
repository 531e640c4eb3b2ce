"""Pictures of one contact: slow motion of ball, orbit and forces on one clock, and the slider's start and stop.

Heights, u_x, z and x are to scale in nm; the ball's radius is not, at that scale it would be flat.  Every function
takes plain results of `contact` and returns a matplotlib Figure; nothing is shown or written.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from studies.report.figures import COLOURS, legend_below
from studies.view.surface_pictures import NM, TURN, new_figure

__all__ = ["SlowMotion", "moments", "start_and_stop", "strip"]

REGIMES = {
    "separated": "#FFFFFF",
    "stick": "#BBBBBB",
    "slip": "#56B4E9",
    "creep": "#F0E442",
    "partial": "#009E73",
}
NORMAL, TANGENTIAL = "#000000", "#D55E00"
MEANING = "z: approach of ball and surface, x: tangential deformation,\nP: normal force, Q: friction force, v: velocity"
DRAWN = (
    "snapshots, not to scale: ball in the regime's colour, surface with marks that move with it, the path of a surface "
    "point (blue), arrows of P (black) and Q (orange)"
)
SNAPSHOTS = 8


@dataclass(frozen=True, kw_only=True)
class Moments:
    """One contact over time, n instants, in SI units.

    Attributes
    ----------
    time : ndarray
        s.
    surface : ndarray, shape (n, 2)
        u_x and u_z of the surface point under the ball.
    approach, deformation, normal_force, tangential_force : ndarray
        z, x, P and Q.
    regime : ndarray of str
    surface_velocity, slider_velocity : ndarray
        Tangential, m/s.
    orbit : ndarray, shape (m, 2)
        The surface point's whole path.
    """

    time: np.ndarray = field(repr=False)
    surface: np.ndarray = field(repr=False)
    approach: np.ndarray = field(repr=False)
    deformation: np.ndarray = field(repr=False)
    normal_force: np.ndarray = field(repr=False)
    tangential_force: np.ndarray = field(repr=False)
    regime: np.ndarray = field(repr=False)
    surface_velocity: np.ndarray = field(repr=False)
    slider_velocity: np.ndarray = field(repr=False)
    orbit: np.ndarray = field(repr=False)

    def columns(self) -> dict[str, np.ndarray]:
        """Return the series as the columns of a table."""
        return {
            "time_s": self.time,
            "u_x_m": self.surface[:, 0],
            "u_z_m": self.surface[:, 1],
            "approach_m": self.approach,
            "deformation_m": self.deformation,
            "normal_force_N": self.normal_force,
            "tangential_force_N": self.tangential_force,
            "regime": self.regime,
            "surface_velocity_m_per_s": self.surface_velocity,
            "slider_velocity_m_per_s": self.slider_velocity,
        }


def moments(history, contact: int = 0) -> Moments:
    """Return one contact of a `contact.History` of the stages "start" and "steady".

    Its clock starts at an upward zero of u_z of the first contact.
    """
    first, orbit = history.orbits[0], history.orbits[contact]
    shift = -0.5 * np.pi - np.angle(first.normal)

    def at(angle):
        turn = np.exp(1j * (angle + shift))
        return np.stack([(orbit.tangential * turn).real, (orbit.normal * turn).real], axis=-1)

    return Moments(
        time=history.time,
        surface=at(orbit.omega * history.time),
        approach=history.approach[:, contact],
        deformation=history.deformation[:, contact],
        normal_force=history.normal_force[:, contact],
        tangential_force=history.tangential_force[:, contact],
        regime=history.regime[:, contact],
        surface_velocity=history.surface_velocity[:, contact],
        slider_velocity=history.slider_velocity,
        orbit=at(TURN),
    )


class SlowMotion:
    """A figure of one contact whose instant can be set; drawn off screen unless one of a window is given."""

    def __init__(self, moments: Moments, *, title: str, figure=None):
        self.moments, self.figure = moments, figure or new_figure(9.0, 4.6, rows=0)[0]
        left, right = self.figure.subfigures(1, 2, width_ratios=(1.0, 1.35))
        self._ax = left.subplots()
        self._cursors = [
            ax.axvline(0.0, color=COLOURS["line"], linewidth=1.2) for ax in traces(right, moments)
        ]
        self.figure.suptitle(title, fontsize="medium")
        self.show(0)
        self.figure.canvas.draw()
        self.figure.set_layout_engine("none")  # found once: finding it again takes most of a picture's time

    def show(self, index: int) -> None:
        """Show an instant."""
        self._ax.clear()
        _draw(self._ax, self.moments, index)
        place = self.moments.time[index] * 1e9
        for cursor in self._cursors:
            cursor.set_xdata([place, place])


def strip(moments: Moments, *, title: str):
    """Draw snapshots of one contact over the traces of the same clock."""
    figure, _ = new_figure(11.0, 6.6, rows=0)
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 2.0))
    chosen = np.linspace(0, len(moments.time), SNAPSHOTS, endpoint=False).astype(int)
    for number, (ax, index) in enumerate(zip(top.subplots(1, SNAPSHOTS), chosen, strict=True)):
        _draw(ax, moments, int(index), small=True)
        ax.set_title(f"{'abcdefgh'[number]}: {moments.regime[index]}", fontsize="small")
    top.supxlabel(DRAWN, fontsize="small")
    for ax in traces(bottom, moments):
        for index in chosen:
            ax.axvline(moments.time[index] * 1e9, color=COLOURS["line"], linestyle=":", linewidth=0.8)
    last = bottom.axes[0]
    for number, index in enumerate(chosen):
        last.text(moments.time[index] * 1e9, 1.02, "abcdefgh"[number], transform=last.get_xaxis_transform(),
                  fontsize="small")  # fmt: skip
    figure.suptitle(title, fontsize="medium")
    return figure


def traces(figure, moments: Moments) -> list:
    """Draw z, x, P, Q and the velocities on one clock, the regime behind them; return the Axes."""
    axes = figure.subplots(5, 1, sharex=True)
    time = moments.time * 1e9
    series = (
        ("z (nm)", [(moments.approach * NM, COLOURS["line"], None)]),
        ("x (nm)", [(moments.deformation * NM, COLOURS["line"], None)]),
        ("P (mN)", [(moments.normal_force * 1e3, NORMAL, None)]),
        ("Q (mN)", [(moments.tangential_force * 1e3, TANGENTIAL, None)]),
        (
            "v (mm/s)",
            [
                (moments.surface_velocity * 1e3, COLOURS["slip"], "surface"),
                (moments.slider_velocity * 1e3, COLOURS["line"], "slider"),
            ],
        ),
    )
    borders = np.flatnonzero(moments.regime[1:] != moments.regime[:-1]) + 1
    ends = np.concatenate([[0], borders, [len(time) - 1]])
    for ax, (label, lines) in zip(axes, series, strict=True):
        for start, stop in pairwise(ends):
            colour = REGIMES[str(moments.regime[start])]
            ax.axvspan(time[start], time[stop], color=colour, alpha=0.45, linewidth=0)
        for values, colour, name in lines:
            ax.plot(time, values, color=colour, linewidth=1.2, label=name)
        ax.axhline(0, color=COLOURS["line"], linewidth=0.5)
        ax.set_ylabel(label, fontsize="small")
        ax.tick_params(labelsize="small")
        ax.set_xlim(time[0], time[-1])
    speeds = axes[-1].get_lines()[:2]
    axes[-1].set_xlabel(f"time (ns)\n{MEANING}", fontsize="x-small")
    seen = [name for name in REGIMES if name in set(moments.regime.tolist())]
    _key(axes[0], seen, speeds)
    return list(axes)


def start_and_stop(trajectories, *, acceleration: float, title: str):
    """Draw trajectories of bursts by name, closely how they stop, and the largest acceleration (m/s^2) of friction."""
    import matplotlib

    figure, (whole, end) = new_figure(7.6, 6.0, rows=2)
    colours = matplotlib.colormaps["cividis"](np.linspace(0.0, 0.85, len(trajectories)))
    longest = 0.0
    for (name, motion), colour in zip(trajectories, colours, strict=True):
        whole.plot(motion.time * 1e3, motion.velocity * 1e3, color=colour, linewidth=1.3, label=name)
        after = motion.time >= motion.duration - 1e-12
        end.plot((motion.time[after] - motion.duration) * 1e3, motion.velocity[after] * 1e3, color=colour)
        longest = max(longest, abs(motion.velocity_at_burst_end) / acceleration)
    reference = max(
        (motion for _, motion in trajectories), key=lambda motion: abs(motion.velocity_at_burst_end)
    )
    sign = np.sign(reference.velocity_at_burst_end) or 1.0
    fall = np.array([0.0, longest])
    speed = sign * (abs(reference.velocity_at_burst_end) - acceleration * fall) * 1e3
    end.plot(fall * 1e3, speed, ":", color=COLOURS["line"], label="mu preload / m (theory)")
    rise = np.array([0.0, abs(reference.velocity).max() / acceleration])
    whole.plot(
        rise * 1e3,
        sign * acceleration * rise * 1e3,
        ":",
        color=COLOURS["line"],
        label="mu preload / m (theory)",
    )
    whole.axvline(reference.duration * 1e3, color=COLOURS["stick"], linewidth=1, label="end of the burst")
    whole.set_xlabel("time (ms)")
    end.set_xlabel("time after the burst (ms)")
    whole.set_title(f"{title}\nstart and stop", fontsize="medium")
    for ax in (whole, end):
        ax.set_ylabel("slider velocity (mm/s)")
        ax.grid(alpha=0.3)
    legend_below(end, whole.get_legend_handles_labels()[0], columns=5)
    return figure


def _draw(ax, moments: Moments, index: int, *, small: bool = False) -> None:
    """Draw ball, surface, orbit and forces of one instant."""
    from matplotlib.patches import Circle

    across, up = moments.surface[index] * NM
    path = moments.orbit * NM
    scale = max(float(abs(moments.orbit).max()), 0.4 * float(moments.approach.max())) * NM
    bottom = up - moments.approach[index] * NM
    lowest = (moments.surface[:, 1] - moments.approach).min() * NM
    colour = REGIMES[str(moments.regime[index])]
    reach, radius = 2.4 * scale, 2.0 * scale
    ax.add_patch(
        Circle((0.0, bottom + radius), radius, facecolor=colour, edgecolor=COLOURS["line"], alpha=0.9)
    )
    ax.fill_between([-reach, reach], [-9 * scale] * 2, [up] * 2, color="#E6D8C3", linewidth=0, alpha=0.7)
    marks = np.arange(-3, 4) * scale + across
    ax.plot(marks, np.full(len(marks), up), "|", color=COLOURS["line"], markersize=6)
    ax.axhline(up, color=COLOURS["line"], linewidth=1)
    ax.plot(path[:, 0], path[:, 1], color=COLOURS["slip"], linewidth=1.2)
    ax.plot([across], [up], "o", color=COLOURS["slip"], markersize=4 if small else 6)
    largest = max(abs(moments.normal_force).max(), 1e-300)
    sideways = max(abs(moments.tangential_force).max(), 1e-300)
    for tip, tone in (
        ((0.0, 1.6 * scale * moments.normal_force[index] / largest), NORMAL),
        ((1.8 * scale * moments.tangential_force[index] / sideways, 0.0), TANGENTIAL),
    ):
        if np.hypot(*tip) > 0.05 * scale:
            ax.annotate(
                "",
                (tip[0], up + tip[1]),
                (0.0, up),
                arrowprops={"arrowstyle": "-|>", "color": tone, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0},
            )
    ax.set_xlim(-reach, reach)
    ax.set_ylim(min(-1.4 * scale, lowest - 0.4 * scale), lowest + 4.2 * scale)
    ax.set_aspect("equal")
    ax.tick_params(labelsize="x-small")
    if small:
        ax.set_xticks([])
        ax.set_yticks([])
        return
    ax.set_xlabel("x of the surface (nm); the ball's radius is not to scale", fontsize="small")
    ax.set_ylabel("z (nm)", fontsize="small")
    force = (
        f"P = {moments.normal_force[index] * 1e3:.3g} mN, Q = {moments.tangential_force[index] * 1e3:.3g} mN"
    )
    ax.set_title(f"{moments.regime[index]}: {force}", fontsize="small")


def _key(ax, names, speeds) -> None:
    """Write what the colours behind the traces and those of the velocities mean above them."""
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=REGIMES[name], alpha=0.6, edgecolor="#666666", label=name) for name in names]
    for line in speeds:
        handles.append(type(line)([], [], color=line.get_color(), label=f"v of the {line.get_label()}"))
    ax.legend(handles=handles, frameon=False, fontsize="x-small", ncols=len(handles), loc="lower right",
              bbox_to_anchor=(1.0, 1.12), borderaxespad=0.0)  # fmt: skip
