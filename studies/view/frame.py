"""Where a stretch of the section lies in its picture, and what stands round it: ruler, crystal axes, colour bar.

Everything is placed in parts of the picture's width and height, so that a pixel is worth the same length in x and in z.
"""

import os
from dataclasses import dataclass

import numpy as np

from studies.refusal import RunError
from studies.view import description
from studies.view.run_field import RunField
from studies.view.shading import Shade

__all__ = [
    "MM",
    "Frame",
    "View",
    "bar",
    "caption",
    "crystal",
    "cut",
    "framed",
    "legend",
    "look",
    "pyvista_quietly",
    "ruler",
    "write",
]

MM = 1e3
TEXT_COLOUR = "#000000"
# of a view's width and height, the picture's edges to the section: room for the ruler and the colour bar
LEFT, RIGHT, LOW, HIGH = 0.075, 0.125, 0.17, 0.12
LEAST_LEFT, LEAST_RIGHT, LEAST_LOW, LEAST_HIGH = 96, 130, 32, 30  # pixels, for the letters
MARKS = 5
LETTERS, SMALL_LETTERS, LETTER = (
    12,
    8,
    0.56,
)  # sizes of the caption, and a letter's mean width over its size, in pixels
CAPTION = 34  # pixels that the caption takes at the top
BALL_SHARE = 0.35  # of a picture's height that a ball takes at most


@dataclass(frozen=True, kw_only=True)
class View:
    """A stretch of the section to look at.

    Attributes
    ----------
    name : str
    start, stop : float
        m.
    weight : float
        Of its height among the views.
    """

    name: str
    start: float
    stop: float
    weight: float


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Where a view's section lies: z limits in m, metres per pixel, pixels of the whole picture."""

    view: View
    bottom: float
    top: float
    pixel: float
    width: float
    height: float

    @property
    def left(self) -> float:
        """Part of the width to the left of the section."""
        return max(LEFT, LEAST_LEFT / self.width)

    @property
    def right(self) -> float:
        """Part of the width to its right."""
        return max(RIGHT, LEAST_RIGHT / self.width)

    @property
    def low(self) -> float:
        """Part of the height below the section."""
        return _margin(LOW, LEAST_LOW, self.height)

    @property
    def high(self) -> float:
        """Part of the height above it."""
        return _margin(HIGH, LEAST_HIGH, self.height)


def _margin(part: float, pixels: float, size: float) -> float:
    """Return a margin as a part of a picture's size: room for letters, but never most of a small picture."""
    return min(max(part, pixels / size), 0.38)


def framed(found: RunField, view: View, *, width: float, height: float) -> Frame:
    """Return where a view's section lies in a picture of some size in pixels.

    The length fills the width; how deep it is seen follows from the height.
    """
    sides = max(LEFT * width, LEAST_LEFT) + max(RIGHT * width, LEAST_RIGHT)
    pixel = (view.stop - view.start) / (width - sides)
    visible = height * (1 - _margin(LOW, LEAST_LOW, height) - _margin(HIGH, LEAST_HIGH, height)) * pixel
    carries = any(view.start <= place <= view.stop for place in found.balls)
    room = 0.15 * min(visible, 2 * found.wavelength)
    top = min(2.1 * found.radius, BALL_SHARE * visible) if carries else room
    bottom = max(found.field.z[0], top - visible)
    return Frame(view=view, bottom=float(bottom), top=top, pixel=pixel, width=width, height=height)


def write(
    plotter, text: str, at: tuple[float, float], size: int, *, side: str = "center", colour: str = TEXT_COLOUR
) -> None:
    """Write into the picture at parts of its width and height."""
    pyvista = pyvista_quietly()
    words = pyvista.Text(text, position=at)
    words.prop.font_size, words.prop.color = size, colour
    words.prop.justification_horizontal = side
    words.prop.justification_vertical = "center"
    words.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    plotter.renderer.add_actor(words, reset_camera=False, pickable=False, render=False)


def caption(plotter, frame: Frame, text: str) -> None:
    """Write above the section, in letters small enough for the picture's width."""
    room = 0.98 * frame.width
    size = int(np.clip(room / (LETTER * len(text)), SMALL_LETTERS, LETTERS))
    if LETTER * size * len(text) > room and " (" in text:
        text = text.replace(" (", "\n(", 1)
        size = int(np.clip(room / (LETTER * max(map(len, text.splitlines()))), SMALL_LETTERS, LETTERS))
    lines = text.count("\n") + 1
    write(plotter, text, (0.01, 1 - 0.5 * (1.3 * size * lines + 10) / frame.height), size, side="left")


def legend(plotter, frame: Frame, found: RunField) -> None:
    """Name the colours of the electrodes at the right of the section."""
    listed = description.electrodes(found)
    middle = _at(frame, 0.0, 0.5 * (frame.top + frame.bottom))[1]
    for number, each in enumerate(listed):
        up = middle + (0.5 * (len(listed) - 1) - number) * 17 / frame.height
        write(plotter, each.label, (1 - 0.9 * frame.right, up), 11, side="left", colour=each.colour)


def _at(frame: Frame, x: float, z: float) -> tuple[float, float]:
    """Return a place of the section (m) in parts of the picture's width and height."""
    middle = 0.5 * (frame.view.start + frame.view.stop), 0.5 * (frame.top + frame.bottom)
    across = 0.5 * (frame.left + 1 - frame.right) + (x - middle[0]) / frame.pixel / frame.width
    return across, 0.5 * (frame.low + 1 - frame.high) + (z - middle[1]) / frame.pixel / frame.height


def ruler(plotter, frame: Frame) -> None:
    """Mark x below and z at the left, in mm."""
    pyvista, view = pyvista_quietly(), frame.view
    tick, lines = 5 * frame.pixel, []
    digits = _digits(view)
    for place in np.linspace(view.start, view.stop, MARKS):
        place = np.clip(round(place * MM, digits) / MM, view.start, view.stop)
        lines.append([(place, 0, frame.bottom - tick), (place, 0, frame.bottom)])
        across, _ = _at(frame, place, 0.0)
        low = _at(frame, place, frame.bottom)[1] - 21 / frame.height
        write(plotter, f"x = {place * MM:.{digits}f} mm", (across, low), 11)
    depths = (
        (0.0, frame.bottom) if -frame.bottom / frame.pixel < 70 else (0.0, 0.5 * frame.bottom, frame.bottom)
    )
    for depth in depths:
        depth = float(f"{depth:.2g}")
        lines.append([(view.start - tick, 0, depth), (view.start, 0, depth)])
        across, up = _at(frame, view.start, depth)
        write(plotter, f"z = {depth * MM + 0.0:.2g} mm", (across - 12 / frame.width, up), 11, side="right")
    points = np.array(lines).reshape(-1, 3) * MM
    plotter.add_mesh(pyvista.line_segments_from_points(points), color=TEXT_COLOUR, line_width=1)


def _digits(view: View) -> int:
    return int(max(0, np.ceil(1 - np.log10((view.stop - view.start) * MM / MARKS))))


def crystal(plotter, frame: Frame, found: RunField) -> None:
    """Draw the crystal axes in the lower left corner of the section; one that is normal to it is a word."""
    size = 26 * frame.pixel
    if -frame.bottom < 3 * size:
        return
    origin = np.array([frame.view.start + 2 * size, frame.bottom + 1.2 * size])
    pyvista = pyvista_quietly()
    for name, x, z in description.crystal_axes(found):
        tip = origin + size * np.array([x, z])
        line = pyvista.Line((origin[0] * MM, -0.02, origin[1] * MM), (tip[0] * MM, -0.02, tip[1] * MM))
        plotter.add_mesh(line, color=description.AXIS_COLOUR, line_width=3)
        write(plotter, name, _at(frame, *(origin + 1.35 * size * np.array([x, z]))), 11)
    write(plotter, "crystal", _at(frame, origin[0] + 0.9 * size, origin[1] - 0.5 * size), 9)


def bar(plotter, frame: Frame, shade: Shade, mapper) -> None:
    """Draw the colour bar at the right, quantity and unit above it."""
    for former in list(plotter.scalar_bars.keys()):
        plotter.remove_scalar_bar(former, render=False)
    plotter.add_scalar_bar(
        title="",
        mapper=mapper,
        vertical=True,
        n_labels=3,
        position_x=1 - 0.76 * frame.right,
        position_y=frame.low,
        width=0.02,
        height=1 - frame.low - frame.high - 40 / frame.height,
        label_font_size=11,
        title_font_size=1,
        fmt="%.3g",
        render=False,
    )
    title, unit = shade.label.split(" (")
    write(plotter, f"{title}\n({unit}", (1 - frame.right / 2, 1 - frame.high - 14 / frame.height), 11)


def cut(mapper, frame: Frame, *, top: bool = False) -> None:
    """Cut what is drawn off at the sides and at the bottom of its frame, and if asked below the caption."""
    from vtkmodules.vtkCommonDataModel import vtkPlane

    view = frame.view
    planes = [((1, 0, 0), view.start), ((-1, 0, 0), view.stop), ((0, 0, 1), frame.bottom - frame.pixel)]
    if top:
        planes.append(((0, 0, -1), frame.top + (frame.high * frame.height - CAPTION) * frame.pixel))
    for normal, origin in planes:
        plane = vtkPlane()
        plane.SetNormal(normal)
        plane.SetOrigin(*(origin * MM * abs(part) for part in normal))
        mapper.AddClippingPlane(plane)


def look(plotter, frame: Frame) -> None:
    """Look along +y, so that a pixel is what the frame says."""
    camera, view = plotter.camera, frame.view
    across, up = 0.5 * (frame.left + 1 - frame.right) - 0.5, 0.5 * (frame.low + 1 - frame.high) - 0.5
    x = 0.5 * (view.start + view.stop) - across * frame.width * frame.pixel
    z = 0.5 * (frame.top + frame.bottom) - up * frame.height * frame.pixel
    camera.enable_parallel_projection()
    camera.focal_point, camera.position = (x * MM, 0.0, z * MM), (x * MM, -10.0, z * MM)
    camera.up = (0, 0, 1)
    camera.parallel_scale = 0.5 * frame.height * frame.pixel * MM
    camera.clipping_range = (1.0, 30.0)


def pyvista_quietly():
    """Import pyvista, quietly: without a display VTK says so on stderr before it finds another way.

    Raises
    ------
    RunError
        If it is not installed.
    """
    try:
        import pyvista
    except ImportError:
        raise RunError(
            "pictures of the field need pyvista, which is not installed: pip install pyvista"
        ) from None
    pyvista.vtk_verbosity("off")
    return pyvista


def refuse_without_display() -> None:
    """Refuse to open a window where there is nothing to open it on.

    Raises
    ------
    RunError
        Naming what to do instead.
    """
    if os.name == "posix" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RunError(
            "there is no display to open a window on; --screenshot FILE, --movie FILE and --html FILE draw without one"
        )
