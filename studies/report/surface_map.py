"""The beam over the whole surface: its motion on a grid of places (x, y), as files and as a picture."""

from pathlib import Path

from studies.scene import Scene, resolved

__all__ = ["draw_surface_map", "surface_map", "write_surface_map"]

PER_WAVELENGTH, LINES = 4, 81  # places along x and across the width


def surface_map(beam, stator):
    """Return x in m, y in m, and u_x, u_y and u_z of a beam on a scene's stator in m per V, (3, len(x), len(y))."""
    import numpy as np

    wave = beam.wave
    step = wave.phase_velocity / wave.frequency / PER_WAVELENGTH
    x = np.linspace(0.0, stator.length, int(np.ceil(stator.length / step)) + 1)
    y = np.linspace(-stator.width / 2, stator.width / 2, LINES)
    return x, y, beam.motion(x[:, None], y)


def write_surface_map(beam, stator, folder: Path) -> None:
    """Write surface_map.vtu and surface_map.csv, a line for every place."""
    import numpy as np

    import fem
    from studies.report.files import write_columns

    x, y, motion = surface_map(beam, stator)
    fem.write_surface(x, y, motion, folder / "surface_map.vtu")
    columns = {"x_m": np.repeat(x, y.size), "y_m": np.tile(y, x.size)}
    columns |= {f"u_{name}_m_per_V": each.ravel() for name, each in zip("xyz", motion, strict=True)}
    write_columns(folder / "surface_map.csv", columns)


def draw_surface_map(beam, scene: Scene, ax):
    """Draw the size of u_z on the surface, with the transducers' apertures, the balls and the side faces."""
    from matplotlib.patches import Polygon

    from studies.report.figures import COLOURS

    width = scene.stator.width
    x, y, motion = surface_map(beam, scene.stator)
    drawn = ax.pcolormesh(
        x * 1e3, y * 1e3, abs(motion[2]).T * 1e9, cmap="viridis", shading="gouraud", rasterized=True
    )
    ax.figure.colorbar(drawn, ax=ax, label="|u_z| (nm per V)")
    for each in resolved.transducers(scene):
        ax.add_patch(Polygon(each.corners * 1e3, fill=False, edgecolor="white", linewidth=1.2))
    for place in () if scene.slider is None else scene.slider.places:
        ax.plot(
            *(1e3 * each for each in place),
            "o",
            color=COLOURS["intermittent"],
            markeredgecolor="white",
            markersize=6,
        )
    for side in (-1, 1):
        ax.axhline(side * width / 2 * 1e3, color=COLOURS["line"], linewidth=2)
    ax.set_xlabel("x along the surface (mm)")
    ax.set_ylabel("y (mm)")
    ax.set_aspect("equal" if scene.stator.length < 12 * width else "auto")
    what = "u_z of the beam; frames: apertures, points: balls, lines: side faces"
    between = ": " if scene.stator.length > 1.2 * scene.stator.width else "\n"
    ax.set_title(f"{scene.title}{between}{what}", fontsize="medium", parse_math=False)
    return ax
