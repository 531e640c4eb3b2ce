"""Pictures of a run that its page alone shows: layout, wave in the section, beam, and speed against load."""

from collections.abc import Callable
from functools import partial

import numpy as np

import contact
import fem
from studies.model.model import model_of
from studies.record import Record
from studies.record.plots import COLOURS, curve, finished, shaded
from studies.record.prefixes import key_axis
from studies.record.quantities import quantity
from studies.report.beam_map import draw_surface_map
from studies.solve.solved_stator import contact_of_run

SHOWN_WAVELENGTHS = 12  # of the section that is drawn
PER_WAVELENGTH = 16  # lines of the drawn section
LOADS = 21  # points of the load line
LOAD_LINE_TOLERANCE = 1e-3  # relative to the speed without load: finer than a line of the picture


def drawings(record: Record) -> dict[str, Callable]:
    """Return the functions that draw them on an Axes, by name, with what the record has."""
    scene = record.scene
    drawn: dict[str, Callable] = {}
    if scene.transducer:
        drawn["layout"] = partial(layout, record)
    if record.surface_wave is not None:
        drawn["section_field"] = partial(section_field, record)
        if record.surface_motion.beam is not None:
            last = record.points[-1] if record.points else None
            drawn["beam"] = partial(draw_surface_map, record.surface_motion.beam, scene, point=last)
    moving = any(point.velocity_m_per_s for point in record.points)
    if moving and not scene.planar and (record.surface_wave is not None or scene.wave is not None):
        drawn["load_line"] = partial(load_line, record)
    return drawn


def layout(record: Record, ax):
    """Draw the surface from above: transducers, driven ones filled, meshed pieces, contacts, absorbing ends."""
    from matplotlib.patches import Polygon, Rectangle

    scene, along, across = record.scene, quantity.x_m, quantity.y_m
    length, width = scene.stator.length * along.scale, scene.stator.width * across.scale
    ax.add_patch(Rectangle((0.0, -width / 2), length, width, facecolor="#F2EEE6", edgecolor=COLOURS["line"]))
    for each in model_of(scene).transducers:
        driven = each.name in scene.drive.driven
        colour = COLOURS["slip" if driven else "stick"]
        label = f"{each.name}, {'driven' if driven else 'not driven'}"
        ax.add_patch(Polygon(each.corners * along.scale, facecolor=colour, alpha=0.6, edgecolor=colour, label=label))
    for number, (start, stop) in enumerate(record.meshed_pieces):
        shaded(ax, start * along.scale, stop * along.scale, None if number else "meshed piece", colour="second")
    if scene.slider is not None:
        at = np.array(scene.slider.contact_positions) * along.scale
        ax.plot(*at.T, "o", color=COLOURS["intermittent"], markersize=5, label="contacts of the slider")
    ax.set_xlim(-0.02 * length, 1.02 * length)
    ax.set_ylim(-0.6 * width, 0.6 * width)
    ax.set_aspect("equal" if length < 12 * width else "auto")
    ends = scene.stator.ends if isinstance(scene.stator.ends, str) else ", ".join(scene.stator.ends)
    return finished(ax, along.axis, across.axis, f"{scene.title}\nends: {ends}", grid=False)


def section_field(record: Record, ax):
    """Draw u_z in the section at one instant, within some wavelengths of the slider or of the middle."""
    wave, scene = record.surface_wave, record.scene
    wavelength = wave.phase_velocity / wave.frequency
    middle = record.surface_motion.in_section(scene.slider.center) if scene.slider is not None else 0.5 * wave.length
    span = tuple(np.clip(middle + 0.5 * SHOWN_WAVELENGTHS * wavelength * np.array([-1.0, 1.0]), 0.0, wave.length))
    drawn = fem.wave_field(wave, span=span, per_wavelength=PER_WAVELENGTH)
    across, up, shade = quantity.x_m, quantity.z_m, quantity.normal_m_per_V
    size = drawn.displacement[..., 2].real * shade.scale
    largest = float(np.nanmax(abs(size)))
    deep = drawn.z * up.scale
    colours = ax.pcolormesh(
        drawn.x * across.scale, deep, size.T, cmap="RdBu_r", shading="gouraud", vmin=-largest, vmax=largest,
        rasterized=True,
    )  # fmt: skip
    ax.figure.colorbar(colours, ax=ax, label=f"{shade.head} ({shade.shown})")
    ax.set_ylim(max(deep[0], -4.0 * wavelength * up.scale), 0.0)
    title = f"{scene.title}: the plane section at one instant, per volt"
    return finished(ax, across.axis, up.axis, title, columns=0, grid=False)


def load_line(record: Record, ax):
    """Draw the speed at the largest level of the drive against the load of the whole slider."""
    driven, up, scene = contact_of_run(record), quantity.velocity_m_per_s, record.scene
    orbits = driven.at(max(scene.levels))
    try:
        line = contact.load_line(driven.slider, orbits, points=LOADS, tolerance=LOAD_LINE_TOLERANCE)
    except contact.ConvergenceError as error:
        ax.text(0.5, 0.5, f"no load line: {error}", transform=ax.transAxes, ha="center", wrap=True)
        return finished(ax, "load", up.axis, scene.title, columns=0)
    share = scene.slider.share
    factor, label = key_axis("slider.load", share * line.load[-1])
    curve(ax, share * line.load * factor, line.velocity * up.scale, ".-", "slip")
    return finished(ax, label, up.axis, f"{scene.title}: {driven.scene.named(max(scene.levels))}", columns=0)
