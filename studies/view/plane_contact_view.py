"""The first contact of a slider in the plane over one period of its waves, as a picture or table.

Height and velocity of the slider are the averaged ones, see `contact.plane.contact_cycle`. Above, the paths of the
sliding velocity, of the deformation and of the force in the plane; below, the traces over time.
"""

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np

from contact import plane
from studies.model.scene_errors import as_run_errors, slider_keys
from studies.record import Record
from studies.record.files import write_columns
from studies.record.plots import COLOURS, curve, new_figure
from studies.record.values import Columns
from studies.refusal import refuse_if
from studies.solve.plane_motor import PlaneMotor
from studies.view.contact_view import DPI, INSTANTS, LETTERS, REGIMES, drawn_quantity, driven_at, traces

LOGGER = logging.getLogger(__name__)

# quantity, and column, colour and legend name of each curve
TRACES = (
    ("approach_m", (("approach_m", "line", None),)),
    (
        "plane_deformation_m",
        (
            ("deformation_m", "slip", "along x"),
            ("lateral_deformation_m", "intermittent", "along y"),
            ("limit_m", "stick", "limit c z"),
            ("lower_limit_m", "stick", None),
        ),
    ),
    ("normal_force_N", (("normal_force_N", "line", None),)),
    ("tangential_force_N", (("tangential_force_N", "slip", None), ("lateral_force_N", "intermittent", None))),
    (
        "sliding_velocity_m_per_s",
        (("sliding_velocity_m_per_s", "slip", None), ("lateral_sliding_velocity_m_per_s", "intermittent", None)),
    ),
)
# paths in the plane: quantity of the axes, columns along x and y
PATHS = (
    ("sliding_velocity_m_per_s", "sliding_velocity_m_per_s", "lateral_sliding_velocity_m_per_s"),
    ("plane_deformation_m", "deformation_m", "lateral_deformation_m"),
    ("tangential_force_N", "tangential_force_N", "lateral_force_N"),
)
OFFERED = "of one in the plane there are --screenshot FILE.png and --data FILE.csv"
EDGE = 1.06  # half width of a path's axes over its largest value


def plane_contact_writers(record: Record, wanted) -> dict[str, Callable]:
    """Return functions that write the contact of a run whose slider moves in the plane, by option."""
    for option in ("movie", "html"):
        refuse_if(getattr(wanted, option) is not None, f"--{option}", f"shows a contact that moves along x: {OFFERED}")
    refuse_if(not wanted.files, "--show", f"contact opens a window for a slider that moves along x: {OFFERED}")
    table, title = plane_cycle(record, level=wanted.level)
    return {
        "screenshot": lambda file: plane_strip(table, title=title).savefig(file, dpi=DPI),
        "data": lambda file: write_columns(Path(file), table),
    }


def plane_cycle(record: Record, *, level: float | None) -> tuple[Columns, str]:
    """Return the first contact over one period as columns of a table, and a title; ``level`` as `steady_history`."""
    driven, level = driven_at(record, level)
    LOGGER.info("following the contact")
    with as_run_errors(), slider_keys():
        motor = PlaneMotor.of(driven, level, record.tolerance)
        cycle = plane.contact_cycle(motor.slider, motor.waves, points_per_cycle=INSTANTS, tolerance=motor.tolerance)
    sliding = cycle.surface_velocity[:, 0] - cycle.contact_velocity[0]
    table = Columns(
        time_s=cycle.time,
        **{f"u_{axis}_m": cycle.displacement[:, 0, k] for k, axis in enumerate("xyz")},
        approach_m=cycle.approach[:, 0], limit_m=cycle.limit[:, 0],
        deformation_m=cycle.deformation[:, 0, 0], lateral_deformation_m=cycle.deformation[:, 0, 1],
        normal_force_N=cycle.normal_force[:, 0],
        tangential_force_N=cycle.tangential_force[:, 0, 0], lateral_force_N=cycle.tangential_force[:, 0, 1],
        regime=cycle.regime[:, 0], sliding_velocity_m_per_s=sliding[:, 0],
        lateral_sliding_velocity_m_per_s=sliding[:, 1],
    )  # fmt: skip
    speeds = [drawn_quantity("velocity_m_per_s").with_unit(each) for each in cycle.contact_velocity[0]]
    text = f"slider at the contact: {speeds[0]} along x and {speeds[1]} along y"
    return table, f"{driven.scene.title}: {driven.scene.named(level)}, first contact\n{text}"


def plane_strip(table: Columns, *, title: str):
    """Draw the paths of one contact in the plane over the traces of the same clock."""
    figure, _ = new_figure(11.0, 9.6, rows=0)
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 1.7))
    axes = traces(bottom, Columns(table, lower_limit_m=-table.limit_m), TRACES)
    instants = np.linspace(0, len(table.time_s), len(LETTERS), endpoint=False).astype(int)
    scale = drawn_quantity("time_s").scale
    for letter, index in zip(LETTERS, instants, strict=True):
        time = table.time_s[index] * scale
        for each in axes:
            each.axvline(time, color="black", linestyle=":", linewidth=0.8)
        axes[0].text(time, 1.02, letter, transform=axes[0].get_xaxis_transform(), fontsize="small", ha="center")
    for ax, (key, along, across) in zip(top.subplots(1, len(PATHS)), PATHS, strict=True):
        _path(ax, table, key, table[along], table[across], instants)
    top.supxlabel(
        "paths in the plane in the colours of the regime (grey line: separated); dashed circles: the limit c z of the "
        "deformation at the letters",
        fontsize="small",
    )
    figure.suptitle(title, fontsize="medium")
    return figure


def _path(ax, table: Columns, key: str, along, across, instants) -> None:
    """Draw the path of a vector, with the letters of some instants."""
    drawn = drawn_quantity(key)
    x, y = along * drawn.scale, across * drawn.scale
    curve(ax, np.append(x, x[0]), np.append(y, y[0]), "-", "stick")
    for regime, colour in REGIMES.items():
        inside = table.regime == regime
        if inside.any() and regime != "separated":
            ax.plot(x[inside], y[inside], ".", color=colour, markersize=4, markeredgewidth=0)
    size = np.hypot(x, y).max()
    if key == "plane_deformation_m":
        angle = np.linspace(0.0, 2.0 * np.pi, 100)
        for limit in table.limit_m[instants] * drawn.scale:
            ax.plot(limit * np.cos(angle), limit * np.sin(angle), "--", color=COLOURS["stick"], linewidth=0.6)
            size = max(size, limit)
    for letter, index in zip(LETTERS, instants, strict=True):
        if table.regime[index] != "separated" or key == "sliding_velocity_m_per_s":
            ax.annotate(letter, (x[index], y[index]), (3, 2), textcoords="offset points", fontsize="small")
            curve(ax, [x[index]], [y[index]], "o", "line", size=2.5)
    ax.axhline(0, color="black", linewidth=0.5)
    ax.axvline(0, color="black", linewidth=0.5)
    size = EDGE * size or 1.0
    ax.set(xlim=(-size, size), ylim=(-size, size), aspect="equal")
    ax.tick_params(labelsize="small")
    ax.set_xlabel(f"{drawn.heading} along x", fontsize="small")
    ax.set_ylabel(f"{drawn.heading} along y", fontsize="small")
    ax.set_title(drawn.label, fontsize="small")
