"""The stator as a solid of its whole width, with the field in the beam that the aperture cuts out of it.

The model is a section: it holds, the same for every y, within the aperture of the transducers, as far as the beam does
not spread.  There the field is extruded; beside it the solid is drawn bare, and the picture says so.  A free wave has
no aperture and fills the width.
"""

import numpy as np

from studies.view import description
from studies.view.frame import LETTER, LETTERS, MM, SMALL_LETTERS, pyvista_quietly, write
from studies.view.patch import patch
from studies.view.run_field import RunField
from studies.view.shading import shade

__all__ = ["solid"]

BARE, EDGE = "#D9D9D9", "#606060"
SPACING = 1 / 12  # wavelengths: distance of the lines that are drawn


def solid(
    found: RunField, *, quantity: str, phase: float, factor: float, size: tuple[int, int], off_screen: bool
):
    """Return a pyvista Plotter with the stator as a solid.

    Parameters
    ----------
    found : RunField
    quantity : str
    phase : float
        rad.
    factor : float
        Of the displacement.
    size : tuple of int
        Pixels.
    off_screen : bool
    """
    pyvista = pyvista_quietly()
    stator = found.scene.stator
    shading, width, beam = shade(found, quantity), stator.width, found.aperture
    bottom = found.field.z[0]
    piece = patch(found, shading, span=(0.0, found.length), bottom=bottom, spacing=SPACING * found.wavelength)
    places, values = piece.places(phase, factor), piece.values(phase)
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=size)
    front, back = -0.5 * beam, 0.5 * beam
    faces = {
        # surface: lines x and two edges of the beam; front face: the section itself; right end
        "surface": _grid(places[:, -1:], np.array([front, back]), values[:, -1:]),
        "section": _grid(places, np.array([front]), values),
        "end": _grid(places[-1:], np.array([front, back]), values[-1:]),
    }
    for name, face in faces.items():
        plotter.add_mesh(
            face,
            scalars="shade",
            cmap=shading.colour_map,
            clim=shading.limits,
            lighting=False,
            show_scalar_bar=False,
            name=name,
        )
    for low, high in ((-0.5 * width, front), (back, 0.5 * width)):
        if high - low > 1e-9:
            box = pyvista.Box(tuple(MM * each for each in (0.0, found.length, low, high, bottom, 0.0)))
            # the half in front is seen through: the field's section lies behind it
            plotter.add_mesh(box, color=BARE, opacity=0.25 if low < front else 1.0, lighting=False)
            plotter.add_mesh(box, style="wireframe", color=EDGE, line_width=1)
    lift = 0.05 * found.wavelength
    for electrode in description.electrodes(found):
        blocks = [
            pyvista.Box(tuple(MM * each for each in (a, b, front, back, lift, 2 * lift)))
            for a, b in electrode.strips
        ]
        plotter.add_mesh(pyvista.merge(blocks), color=electrode.colour, lighting=False)
    for ball in description.balls(found):
        sphere = pyvista.Sphere(radius=ball.radius * MM, center=(ball.place * MM, 0.0, ball.radius * MM))
        plotter.add_mesh(sphere, color=description.BALL_COLOUR, smooth_shading=True)
    _words(plotter, found, shading, factor, size)
    plotter.camera_position = "xz"
    plotter.camera.azimuth, plotter.camera.elevation = 35, 28
    plotter.camera.enable_parallel_projection()
    plotter.reset_camera()
    plotter.camera.zoom(1.5)
    return plotter


def said(found: RunField) -> str:
    """Return where the extruded field is true."""
    if found.free:
        return "a straight-crested free wave: the same for every y"
    return (
        f"field drawn only within the {found.aperture * MM:g} mm aperture, where the model holds for every y "
        "(the beam does not spread in it); grey: not modelled"
    )


def _words(plotter, found: RunField, shading, factor: float, size: tuple[int, int]) -> None:
    """Write the caption above, the legend below it, and the colour bar with its quantity."""
    width, height = size
    extent = " x ".join(
        f"{each * MM:.4g}" for each in (found.length, found.scene.stator.width, -found.field.z[0])
    )
    lines = [
        f"{found.scene.title}: {extent} mm (x, y, z), {found.drive}, {found.enlarged(factor)}",
        *said(found).split("; "),
    ]
    largest = max(LETTERS, height // 65)
    letters = int(np.clip(0.98 * width / (LETTER * max(map(len, lines))), SMALL_LETTERS, largest))
    for number, line in enumerate(lines):
        write(plotter, line, (0.01, 1 - (number + 0.7) * 1.5 * letters / height), letters, side="left")
    for number, each in enumerate(description.electrodes(found)):
        up = 1 - (len(lines) + number + 1.2) * 1.5 * letters / height
        write(plotter, each.label, (0.01, up), letters, side="left", colour=each.colour)
    plotter.add_scalar_bar(
        title="", mapper=plotter.actors["surface"].mapper, position_x=0.3, position_y=0.02,
        width=0.4, height=0.06, title_font_size=1, label_font_size=letters, n_labels=3, fmt="%.3g",
    )  # fmt: skip
    write(plotter, shading.label, (0.74, 0.04), letters, side="left")
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=3)


def _grid(places: np.ndarray, y: np.ndarray, values: np.ndarray):
    """Return lines of places (n, m, 2) in m, extruded over y, as a structured grid in mm with its shade."""
    pyvista = pyvista_quietly()
    n, m = places.shape[:2]
    points = np.empty((n, m, len(y), 3))
    points[..., 0], points[..., 2] = places[..., None, 0], places[..., None, 1]
    points[..., 1] = y
    grid = pyvista.StructuredGrid(*(MM * points[..., axis] for axis in range(3)))
    grid["shade"] = np.repeat(values[..., None], len(y), axis=2).ravel(order="F")
    return grid
