"""The contact of a run in the steady state over two cycles of the wave, as a picture, movie, HTML page or table.

The slow motion shows the ball, the orbit of the surface and the forces at the same instant. Heights, u_x, z and x are
to scale in nm. The radius of the ball is not to scale, because the ball would look flat. The history of a contact is a
table of columns in SI units, see `history_columns`.
"""

import logging
import math
import tempfile
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.patches import Circle, Patch

import contact
from studies.model.scene_errors import as_run_errors
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.files import write_columns
from studies.record.plots import COLOURS, arrow, curve, data_uri, new_figure, refuse_without_toolkit
from studies.record.quantities import Quantity, quantity
from studies.record.values import Columns
from studies.refusal import SceneError, refuse_if
from studies.report.page import picture_page
from studies.solve.solved_stator import contact_of_run
from studies.solve.surface_motion import surface_motion
from studies.view import movie
from studies.view.run_field import recomputed_motion

LOGGER = logging.getLogger(__name__)

CYCLES, INSTANTS = 2, 240  # cycles, and instants per cycle
FRAMES, RATE = 48, 12.0  # pictures of a movie, and pictures per second
DPI = 110
REGIMES = {"separated": "#FFFFFF", "stick": "#BBBBBB", "slip": "#56B4E9", "creep": "#F0E442", "partial": "#009E73"}
# quantity, and column, colour and legend name of each curve
TRACES = (
    ("approach_m", (("approach_m", "line", None),)),
    ("deformation_m", (("deformation_m", "line", None),)),
    ("normal_force_N", (("normal_force_N", "line", None),)),
    ("tangential_force_N", (("tangential_force_N", "intermittent", None),)),
    (
        quantity.velocity_m_per_s.column,
        (
            ("surface_velocity_m_per_s", "slip", "v of the surface"),
            ("slider_velocity_m_per_s", "line", "v of the slider"),
        ),
    ),
)
DRAWN = (
    "snapshots, not to scale: ball in the regime's colour, surface with marks that move with it, the path of a surface "
    "point (blue), arrows of P (black) and Q (orange)"
)
LETTERS = "abcdefgh"  # marks of the snapshots


def contact_writers(record: Record, wanted) -> dict[str, Callable]:
    """Return functions that write the contact of a run, by option, and the function that opens a window."""
    history, title = steady_history(record, level=wanted.level)

    def film(file) -> None:
        film_contact(history, title, wanted.frames or FRAMES, file, rate=RATE)

    def still(file) -> None:
        strip(history, title=title).savefig(file, dpi=DPI)

    def page(file) -> None:
        with tempfile.TemporaryDirectory() as folder:
            pictures = []
            for kind, write in (("gif", film), ("png", still)):
                picture = Path(folder) / f"contact.{kind}"
                write(picture)
                pictures.append((data_uri(picture.read_bytes(), kind), title))
        Path(file).write_text(picture_page(title, pictures), encoding="utf-8")

    return {
        "screenshot": still,
        "movie": film,
        "html": page,
        "data": lambda file: write_columns(Path(file), history),
        "window": lambda: _window(history, title),
    }


def steady_history(record: Record, *, level: float | None) -> tuple[Columns, str]:
    """Return the history of the first contact over two cycles of the steady state, and a title.

    ``level`` is a voltage in V, or the amplitude in m for a scene with a [wave]. None selects the largest level.
    """
    driven, level = driven_at(record, level)
    LOGGER.info("following the contact")
    slider, orbits = driven.slider, driven.at(level)
    refuse_if(
        math.isinf(slider.mass) or (isinstance(orbits, contact.PassingWave) and orbits.loaded_by(slider.preload)),
        "--show contact",
        "follows a slider within a cycle of the wave, and this one is too heavy for it, or loads the wave: show the "
        "field",
    )
    with as_run_errors():
        speed = contact.steady(slider, orbits, tolerance=record.tolerance).velocity
        history = contact.contact_history(
            slider, orbits, stage="steady", skip=0, cycles=CYCLES, points_per_cycle=INSTANTS
        )
    motion_text = f"slider at {drawn_quantity('velocity_m_per_s').with_unit(speed)}" if speed else "slider held at rest"
    return history_columns(history), f"{driven.scene.title}: {driven.scene.named(level)}, {motion_text}"


def driven_at(record: Record, level: float | None) -> tuple[Contact, float]:
    """Return the contact of a run, whose stator is solved again where it is not kept, and the level to show."""
    scene = record.scene
    if scene.slider is None:
        raise SceneError("", "there is no contact to show: the scene of this run has no slider")
    level = max(scene.levels) if level is None else level
    refuse_if(level == 0, "--voltage", "must be above 0: at 0 nothing moves")
    if scene.wave is None and record.surface_motion is None:
        LOGGER.info("solving the stator")
        motion = recomputed_motion(record)
        if motion.beam is None:
            motion = surface_motion(motion.wave, scene.stator, scene.slider.contact_positions)
        record = replace(record, surface_motion=motion)
    return contact_of_run(record), level


def film_contact(history, title: str, count: int, file, *, rate: float, dpi: float = 100) -> None:
    """Write a movie of the first cycle of a contact history."""
    motion = SlowMotion(history, title=title)
    motion.figure.set_dpi(dpi)
    movie.save(lambda number: motion.image(round(number * INSTANTS / count)), count, file, rate=rate)


def _window(history, title: str) -> None:
    """Show the slow motion in a window until it is closed."""
    from matplotlib import pyplot

    refuse_without_toolkit("a window of the contact", "--screenshot, --movie and --html FILE need none")
    figure = pyplot.figure(figsize=(9.0, 4.6), layout="constrained")
    motion = SlowMotion(history, title=title, figure=figure)
    _animation = FuncAnimation(  # the variable keeps the animation alive while the window is open
        figure, motion.show, frames=range(0, INSTANTS, INSTANTS // FRAMES), interval=1000 / RATE
    )
    pyplot.show()


def history_columns(history, contact: int = 0) -> Columns:
    """Return one contact of a `contact.History` (stage "start" or "steady") as columns of a table.

    The time starts at an upward zero crossing of u_z under the first contact.
    """
    orbit = history.orbits[contact]
    phase_factor = np.exp(1j * (orbit.omega * history.time - 0.5 * np.pi - np.angle(history.orbits[0].normal)))
    return Columns(
        time_s=history.time,
        u_x_m=(orbit.tangential * phase_factor).real,
        u_z_m=(orbit.normal * phase_factor).real,
        approach_m=history.approach[:, contact],
        deformation_m=history.deformation[:, contact],
        normal_force_N=history.normal_force[:, contact],
        tangential_force_N=history.tangential_force[:, contact],
        regime=history.regime[:, contact],
        surface_velocity_m_per_s=history.surface_velocity[:, contact],
        slider_velocity_m_per_s=history.slider_velocity,
    )


class SlowMotion:
    """Figure of one contact at a selectable instant, drawn off screen unless ``figure`` belongs to a window."""

    def __init__(self, table: Columns, *, title: str, figure=None):
        self.table, self.figure = table, figure or new_figure(9.0, 4.6, rows=0)[0]
        left, right = self.figure.subfigures(1, 2, width_ratios=(1.0, 1.35))
        self._ax = left.subplots()
        self._cursors = [ax.axvline(0.0, color="black", linewidth=1.2) for ax in traces(right, table)]
        self.figure.suptitle(title, fontsize="medium")
        self.show(0)
        self.figure.canvas.draw()
        # keep the layout: computing it takes most of the time of a picture
        self.figure.set_layout_engine("none")

    def show(self, index: int) -> None:
        """Show the instant with this index."""
        table, ax = self.table, self._ax
        ax.clear()
        _draw(ax, table, index)
        ax.tick_params(labelsize="x-small")
        ax.set_xlabel(f"{drawn_quantity('u_x_m').axis}; the ball's radius is not to scale", fontsize="small")
        ax.set_ylabel(drawn_quantity("u_z_m").axis, fontsize="small")
        P, Q = (drawn_quantity(key).with_unit(table[key][index]) for key in ("normal_force_N", "tangential_force_N"))
        ax.set_title(f"{table.regime[index]}: P = {P}, Q = {Q}", fontsize="small")
        for cursor in self._cursors:
            cursor.set_xdata([table.time_s[index] * drawn_quantity("time_s").scale] * 2)

    def image(self, index: int) -> np.ndarray:
        """Return the picture of the instant with this index, shape (height, width, 3)."""
        self.show(index)
        self.figure.canvas.draw()
        return np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()


def strip(table: Columns, *, title: str):
    """Draw snapshots of one contact over the traces of the same clock."""
    figure, _ = new_figure(11.0, 6.6, rows=0)
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 2.0))
    shots, axes = top.subplots(1, len(LETTERS)), traces(bottom, table)
    instants = np.linspace(0, len(table.time_s), len(LETTERS), endpoint=False).astype(int)
    for letter, ax, index in zip(LETTERS, shots, instants, strict=True):
        _draw(ax, table, index)
        ax.set(xticks=[], yticks=[])
        ax.set_title(f"{letter}: {table.regime[index]}", fontsize="small")
        time = table.time_s[index] * drawn_quantity("time_s").scale
        for each in axes:
            each.axvline(time, color="black", linestyle=":", linewidth=0.8)
        axes[0].text(time, 1.02, letter, transform=axes[0].get_xaxis_transform(), fontsize="small", ha="center")
    top.supxlabel(DRAWN, fontsize="small")
    figure.suptitle(title, fontsize="medium")
    return figure


def traces(figure, table: Columns, shown=TRACES) -> list:
    """Draw columns over time (by default z, x, P, Q and v), with the regime as background; return the Axes."""
    axes, regime, drawn = figure.subplots(len(shown), 1, sharex=True), table.regime, drawn_quantity("time_s")
    time = table.time_s * drawn.scale
    ends = [0, *np.flatnonzero(regime[1:] != regime[:-1]) + 1, len(time) - 1]
    quantities = [drawn_quantity(key) for key, _ in shown]
    for ax, each, (_, curves) in zip(axes, quantities, shown, strict=True):
        for start, stop in pairwise(ends):
            ax.axvspan(time[start], time[stop], color=REGIMES[str(regime[start])], alpha=0.45, linewidth=0)
        for key, colour, name in curves:
            curve(ax, time, table[key] * each.scale, "-", colour, name)
        ax.axhline(0, color="black", linewidth=0.5)
        ax.set_ylabel(each.heading, fontsize="small")
        ax.tick_params(labelsize="small")
        ax.set_xlim(time[0], time[-1])
    meanings = [f"{each.head}: {each.label}" for each in quantities]
    axes[-1].set_xlabel(f"{drawn.axis}\n{', '.join(meanings[:2])},\n{', '.join(meanings[2:])}", fontsize="x-small")
    handles = [
        Patch(facecolor=REGIMES[name], label=name, alpha=0.6, edgecolor="#666666") for name in REGIMES if name in regime
    ]
    handles += [each for ax in axes for each in ax.get_legend_handles_labels()[0]]
    axes[0].legend(handles=handles, frameon=False, fontsize="x-small", ncols=len(handles), loc="lower right",
                   bbox_to_anchor=(1.0, 1.32), borderaxespad=0.0)  # fmt: skip
    return list(axes)


def drawn_quantity(key: str) -> Quantity:
    """Return a quantity of the contact's history."""
    return quantity(f"history.{key}")


def _draw(ax, table: Columns, index: int) -> None:
    """Draw the ball, the surface, the orbit and the forces at one instant."""
    u_x, u_z, approach = (table[key] * drawn_quantity(key).scale for key in ("u_x_m", "u_z_m", "approach_m"))
    x, z = u_x[index], u_z[index]
    scale = max(np.hypot(u_x, u_z).max(), 0.4 * approach.max())
    lowest, half_width, radius = (u_z - approach).min(), 2.4 * scale, 2.0 * scale
    ball = {"facecolor": REGIMES[str(table.regime[index])], "edgecolor": "black", "alpha": 0.9}
    ax.add_patch(Circle((0.0, z - approach[index] + radius), radius, **ball))
    ax.fill_between([-half_width, half_width], [-9 * scale] * 2, [z] * 2, color="#E6D8C3", linewidth=0, alpha=0.7)
    mark_positions = np.arange(-3, 4) * scale + x
    ax.plot(mark_positions, np.full(len(mark_positions), z), "|", color="black", markersize=6)
    ax.axhline(z, color="black", linewidth=1)
    curve(ax, u_x, u_z, "-", "slip")
    curve(ax, [x], [z], "o", "slip", size=5.0)
    for name, length, direction, colour in (
        ("normal", 1.6, (0.0, 1.0), COLOURS["line"]),
        ("tangential", 1.8, (1.0, 0.0), COLOURS["intermittent"]),
    ):
        force = table[f"{name}_force_N"]
        size = length * scale * force[index] / max(abs(force).max(), 1e-300)
        if abs(size) > 0.05 * scale:
            arrow(ax, (0.0, z), (size * direction[0], z + size * direction[1]), colour)
    ax.set(xlim=(-half_width, half_width), ylim=(min(-1.4 * scale, lowest - 0.4 * scale), lowest + 4.2 * scale))
    ax.set_aspect("equal")
