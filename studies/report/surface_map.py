"""The picture of the beam over the whole surface."""

from studies.chain import resolve
from studies.record.plots import COLOURS, finished
from studies.record.quantities import quantity
from studies.record.surface_map import surface_map
from studies.scene import Scene


def draw_surface_map(beam, scene: Scene, ax):
    """Draw the size of u_z on the surface, with the transducers' apertures, the balls and the side faces."""
    from matplotlib.patches import Polygon

    x, y, motion = surface_map(beam, scene.stator)
    size = abs(motion[2]).T * 1e9
    drawn = ax.pcolormesh(x * 1e3, y * 1e3, size, cmap="viridis", shading="gouraud", rasterized=True)
    ax.figure.colorbar(drawn, ax=ax, label=quantity("normal_m_per_V").axis)
    for each in resolve.transducers(scene):
        ax.add_patch(Polygon(each.corners * 1e3, fill=False, edgecolor="white", linewidth=1.2))
    ball = {"color": COLOURS["intermittent"], "markeredgecolor": "white", "markersize": 6}
    for place in () if scene.slider is None else scene.slider.places:
        ax.plot(*(1e3 * each for each in place), "o", **ball)
    for side in (-1, 1):
        ax.axhline(side * y[-1] * 1e3, color=COLOURS["line"], linewidth=2)
    ax.set_aspect("equal" if scene.stator.length < 12 * scene.stator.width else "auto")
    title = f"{scene.title}: u_z of the beam; frames: apertures, points: balls"
    return finished(ax, quantity("x_m").axis, quantity("y_m").axis, title, columns=0, grid=False)


def pixels(stator) -> tuple[int, int]:
    """Return the size of the picture of a scene's stator, which may be long or nearly square."""
    return (1600, 430) if stator.length > 1.2 * stator.width else (1000, 900)
