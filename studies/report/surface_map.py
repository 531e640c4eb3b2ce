"""Map of the surface amplitude of the beam model."""

from studies.chain import resolve
from studies.record.plots import COLOURS, finished
from studies.record.quantities import quantity
from studies.record.surface_map import surface_map
from studies.scene import Scene


def draw_surface_map(beam, scene: Scene, ax):
    """Draw |u_z| on the surface with the apertures of the transducers, the balls and the side faces."""
    from matplotlib.patches import Polygon

    x, y, motion = surface_map(beam, scene.stator)
    amplitude = abs(motion[2]).T * 1e9
    colours = ax.pcolormesh(x * 1e3, y * 1e3, amplitude, cmap="viridis", shading="gouraud", rasterized=True)
    ax.figure.colorbar(colours, ax=ax, label=quantity("normal_m_per_V").axis)
    for each in resolve.transducers(scene):
        ax.add_patch(Polygon(each.corners * 1e3, fill=False, edgecolor="white", linewidth=1.2))
    ball = {"color": COLOURS["intermittent"], "markeredgecolor": "white", "markersize": 6}
    for position in () if scene.slider is None else scene.slider.places:
        ax.plot(*(1e3 * each for each in position), "o", **ball)
    for side in (-1, 1):
        ax.axhline(side * y[-1] * 1e3, color=COLOURS["line"], linewidth=2)
    ax.set_aspect("equal" if scene.stator.length < 12 * scene.stator.width else "auto")
    title = f"{scene.title}: u_z of the beam; frames: apertures, points: balls"
    return finished(ax, quantity("x_m").axis, quantity("y_m").axis, title, columns=0, grid=False)


def pixels(stator) -> tuple[int, int]:
    """Return the size of the map in pixels: wide for a long stator, otherwise nearly square."""
    return (1600, 430) if stator.length > 1.2 * stator.width else (1000, 900)
