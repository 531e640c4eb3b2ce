"""Map of the surface amplitude of the beam model."""

import numpy as np

from studies.model import pillars
from studies.model.model import model_of
from studies.record.plots import COLOURS, finished
from studies.record.point import Point
from studies.record.quantities import quantity
from studies.record.surface_map import surface_map
from studies.scene import Scene


def draw_surface_map(beam, scene: Scene, ax, point: Point | None = None):
    """Draw |u_z| on the surface with the apertures of the transducers, the contacts and the side faces.

    ``point``: of a run; a slider in the plane is drawn with its body and the velocities there.
    """
    from matplotlib.patches import Polygon, Rectangle

    orange = COLOURS["intermittent"]
    across, up, shade = quantity.x_m, quantity.y_m, quantity.normal_m_per_V
    x, y, motion = surface_map(beam, scene.stator, picture=True)
    options = {"cmap": "viridis", "shading": "gouraud", "rasterized": True}
    colours = ax.pcolormesh(x * across.scale, y * up.scale, abs(motion[2]).T * shade.scale, **options)
    ax.figure.colorbar(colours, ax=ax, label=f"|{shade.head}| ({shade.shown})")
    for each in model_of(scene).transducers:
        ax.add_patch(Polygon(each.corners * across.scale, fill=False, edgecolor="white", linewidth=1.2))
    touching = ""
    if scene.slider is not None and scene.slider.pillars is not None:
        layout, touching = pillars.layout(scene.slider), "; orange: the pillars' area"
        (left, length), (low, width) = ((each.min(), np.ptp(each)) for each in (layout.x, layout.y))
        x_center, y_center = scene.slider.center
        corner = (x_center + left) * across.scale, (y_center + low) * up.scale
        size = length * across.scale, width * up.scale
        ax.add_patch(Rectangle(corner, *size, fill=False, edgecolor=orange, linewidth=1.2))
    elif scene.slider is not None:
        touching = "; points: the slider's contacts"
        at = np.array(scene.slider.contact_positions) * across.scale
        ax.plot(*at.T, "o", color=orange, markeredgecolor="white", markersize=6)
    if scene.planar and point is not None and point.answered:
        from studies.report.plane_drawing import draw_body

        touching += draw_body(ax, scene, point)
    for side in (-1, 1):
        ax.axhline(side * y[-1] * up.scale, color=COLOURS["line"], linewidth=2)
    ax.set_aspect("equal" if scene.stator.length < 12 * scene.stator.width else "auto")
    title = f"{scene.title}\nbeam: |u_z|, peak, per volt; white: apertures{touching}"
    return finished(ax, across.axis, up.axis, title, columns=0, grid=False)


def pixels(stator) -> tuple[int, int]:
    """Return the size of the map in pixels: the stator in proportion, with room for title, labels and colour bar."""
    scale = min(1250 / stator.length, 800 / stator.width)
    return round(scale * stator.length) + 350, max(round(scale * stator.width), 240) + 190
