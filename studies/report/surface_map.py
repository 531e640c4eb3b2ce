"""The beam over the whole surface: its motion on a grid of places (x, y), as files and as a picture."""

from studies.report.figures import COLOURS, finished
from studies.scene import Scene

__all__ = ["SIZE", "draw_surface_map", "surface_map"]

PER_WAVELENGTH, LINES = 4, 81  # places along x and across the width
SIZE = (1600, 430)  # of the picture, pixels


def surface_map(beam, width: float):
    """Return x in m, y in m, and u_x, u_y and u_z of a `fem.SurfaceBeam` in m per V, shape (3, len(x), len(y))."""
    import numpy as np

    wave = beam.wave
    step = wave.phase_velocity / wave.frequency / PER_WAVELENGTH
    x = np.linspace(0.0, wave.length, int(np.ceil(wave.length / step)) + 1)
    y = np.linspace(-width / 2, width / 2, LINES)
    return x, y, beam.motion(x[:, None], y)


def draw_surface_map(beam, scene: Scene, ax):
    """Draw the size of u_z on the surface, with the transducers' apertures, the balls and the side faces."""
    from matplotlib.patches import Rectangle

    x, y, motion = surface_map(beam, scene.stator.width)
    size = abs(motion[2]).T * 1e9
    drawn = ax.pcolormesh(x * 1e3, y * 1e3, size, cmap="viridis", shading="gouraud", rasterized=True)
    ax.figure.colorbar(drawn, ax=ax, label="|u_z| (nm per V)")
    for each in scene.transducer:
        length = each.finger_pairs * each.period
        corner = (each.center - length / 2) * 1e3, -each.aperture / 2 * 1e3
        sides = length * 1e3, each.aperture * 1e3
        ax.add_patch(Rectangle(corner, *sides, fill=False, edgecolor="white", linewidth=1.2))
    ball = {"color": COLOURS["intermittent"], "markeredgecolor": "white", "markersize": 6}
    for place in () if scene.slider is None else scene.slider.places:
        ax.plot(*(1e3 * each for each in place), "o", **ball)
    for side in (-1, 1):
        ax.axhline(side * y[-1] * 1e3, color=COLOURS["line"], linewidth=2)
    ax.set_aspect("equal" if beam.wave.length < 12 * scene.stator.width else "auto")
    title = f"{scene.title}: u_z of the beam; frames: apertures, points: balls"
    return finished(ax, "x along the surface (mm)", "y (mm)", title, columns=0, grid=False)
