"""The wave field of a run as a picture: the deformed section coloured by u_z, with electrodes and slider.

One instant, the real part of the field at 1 V of the source (of the free wave: 1 m of u_z at the surface),
lengths in mm.  The displacement is enlarged so that it is seen; the factor is written in the picture.
Above: the whole section. Below: what lies round the slider, or mid-stator.  pyvista is imported here and
nowhere else.
"""

import os
from collections.abc import Callable
from pathlib import Path

from studies.refusal import RunError, SceneError
from studies.run_field import RunField, run_field

__all__ = ["pictured", "screenshot", "section", "show"]

FORMATS = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
AMPLITUDE = 0.08  # of a wavelength: as large as the largest displacement is drawn
CLOSE, DEPTH = 7.0, 3.0  # wavelengths either side and below, in the close pictures
WIDTH, WHOLE_HEIGHT, CLOSE_HEIGHT = 1600, 260, 420  # pixels
MM = 1e3
COMB_COLOURS = {"+": "#000000", "-": "#E69F00", "o": "#999999"}


def screenshot(folder: str | Path, file: str | Path, *, progress: Callable[[str], None]) -> None:
    """Draw a run's field off screen into a file.

    Raises
    ------
    SceneError
        If the run has no field or the file's format is unknown.
    RunError
        If the picture cannot be drawn or written.
    """
    if Path(file).suffix.lower() not in FORMATS:
        raise SceneError("--screenshot", f"must end in one of {', '.join(FORMATS)}, got {str(file)!r}")
    found = run_field(folder, progress=progress)
    progress("drawing")
    plotter = pictured(found, off_screen=True)
    try:
        plotter.screenshot(str(file))
    except OSError as error:
        raise RunError(f"the picture {str(file)!r} cannot be written: {error.strerror or error}") from None
    finally:
        plotter.close()


def show(folder: str | Path, *, progress: Callable[[str], None]) -> None:
    """Open a run's field in a window."""
    if os.name == "posix" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RunError("there is no display to open a window on; --screenshot FILE draws without one")
    pictured(run_field(folder, progress=progress), off_screen=False).show()


def pictured(found: RunField, *, off_screen: bool):
    """Return the pyvista Plotter of a run's field, drawn and not yet shown."""
    pyvista = _pyvista()
    x, z = found.field.x, found.field.z
    reach, depth = CLOSE * found.wavelength, DEPTH * found.wavelength
    views = [(f"{found.title}: {found.span}", x[0], x[-1], z[0])]
    for name, place in found.close:
        views.append((name, max(place - reach, x[0]), min(place + reach, x[-1]), max(z[0], -depth)))
    heights = [WHOLE_HEIGHT if found.close else CLOSE_HEIGHT] + [CLOSE_HEIGHT] * len(found.close)
    plotter = pyvista.Plotter(
        shape=(len(views), 1),
        row_weights=heights,
        off_screen=off_screen,
        window_size=(WIDTH, sum(heights)),
        border=False,
    )
    factor = magnification(found)
    for row, (name, start, stop, bottom) in enumerate(views):
        plotter.subplot(row, 0)
        _draw(plotter, found, factor, start, stop, bottom)
        scale = f"{found.field.frequency / 1e6:g} MHz, {found.drive}, displacement x {factor:g}"
        plotter.add_text(f"{name} ({scale})" if row == 0 else name, font_size=8, position="upper_left")
        carries = any(start <= place <= stop for place in found.balls)
        top = 2 * found.radius if carries else 0.4 * found.wavelength
        _frame(plotter, (start * MM, stop * MM), (bottom * MM, top * MM), WIDTH / heights[row])
    return plotter


def magnification(found: RunField) -> float:
    """Return how many times the displacement of 1 V is enlarged: one round digit."""
    largest = float(abs(found.field.displacement).max())
    if largest == 0:
        return 1.0
    digits = f"{AMPLITUDE * found.wavelength / largest:.0e}"
    return float(digits)


def section(found: RunField, factor: float, start: float, stop: float, bottom: float):
    """Return the deformed section between two places and down to a depth (m) as a StructuredGrid in mm.

    Its point data ``found.label`` is the real part of u_z.
    """
    import numpy as np

    pyvista = _pyvista()
    field = found.field
    chosen = (field.x >= start) & (field.x <= stop)
    deep = field.z >= bottom
    moved = field.displacement[np.ix_(chosen, deep)].real
    x = field.x[chosen, None] + factor * moved[:, :, 0]
    z = field.z[None, deep] + factor * moved[:, :, 2]
    grid = pyvista.StructuredGrid(x * MM, np.zeros_like(x), z * MM)
    grid[found.label] = (moved[:, :, 2] * found.scale).ravel(order="F")
    return grid


def _draw(plotter, found: RunField, factor: float, start: float, stop: float, bottom: float) -> None:
    pyvista = _pyvista()
    grid = section(found, factor, start, stop, bottom)
    reach = float(abs(found.field.displacement[:, :, 2]).max()) * found.scale
    bar = {
        "title": f"{found.label}\n",
        "vertical": True,
        "position_x": 0.935,
        "position_y": 0.1,
        "height": 0.8,
        "width": 0.05,
    }
    bar |= {"title_font_size": 14, "label_font_size": 12, "n_labels": 3}
    plotter.add_mesh(
        grid, scalars=found.label, cmap="coolwarm", clim=(-reach, reach), lighting=False, scalar_bar_args=bar
    )
    lift = 0.03 * found.wavelength * MM
    for sign, edges in found.fingers.items():
        strips = [strip for strip in edges if strip[1] > start and strip[0] < stop]
        blocks = [pyvista.Box((a * MM, b * MM, -lift, lift, 3 * lift, 6 * lift)) for a, b in strips]
        if blocks:
            plotter.add_mesh(pyvista.merge(blocks), color=COMB_COLOURS[sign], lighting=False)
    for place in found.balls:
        if start <= place <= stop:
            ball = pyvista.Sphere(radius=found.radius * MM, center=(place * MM, 0, found.radius * MM))
            plotter.add_mesh(ball, color="#999999", smooth_shading=True)


def _frame(plotter, x: tuple[float, float], z: tuple[float, float], aspect: float) -> None:
    """Look along +y at a stretch of the section, with marks in mm below and at the left; all in mm."""
    import numpy as np

    pyvista = _pyvista()
    (left, right), (low, top) = x, z
    half_height = max(1.35 * (right - left) / 2 / aspect, 1.5 * (top - low) / 2)
    gap = 0.06 * half_height
    along, down = np.linspace(left, right, 5), np.linspace(low, 0, 3)
    marks = {f"x = {place:g} mm": (place, 0, low - 3 * gap) for place in np.round(along, 2)}
    marks |= {f"z = {place:.3g} mm": (left - 8 * gap, 0, place) for place in np.round(down, 3) + 0.0}
    plotter.add_point_labels(
        np.array(list(marks.values())),
        list(marks),
        shape=None,
        show_points=False,
        always_visible=True,
        font_size=13,
        justification_horizontal="center",
        justification_vertical="center",
    )
    for place in along:
        plotter.add_mesh(pyvista.Line((place, 0, low - gap), (place, 0, low)), color="black")
    for place in down:
        plotter.add_mesh(pyvista.Line((left - gap, 0, place), (left, 0, place)), color="black")
    plotter.enable_parallel_projection()
    plotter.view_xz()
    camera, height = plotter.camera, (top + low) / 2
    camera.focal_point = ((left + right) / 2, 0.0, height)
    camera.position = ((left + right) / 2, -10 * (right - left), height)
    camera.parallel_scale = half_height
    plotter.renderer.ResetCameraClippingRange()


def _pyvista():
    """Import pyvista, quietly: without a display VTK says so on stderr before it finds another way."""
    try:
        import pyvista
    except ImportError:
        raise RunError(
            "pictures of the field need pyvista, which is not installed: pip install pyvista"
        ) from None
    pyvista.vtk_verbosity("off")
    return pyvista
