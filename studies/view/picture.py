"""Draw the field of a run with pyvista: deformed parts of the section, or the whole solid.

The views of the section are stacked vertically and keep their proportions. A window shows one view without a frame.

The picture of the solid depends on the model. If the run computed the finite aperture, the field is drawn on the
surface over the whole width, and the interior is not drawn. Otherwise the model is a section, which is valid for all y
within the aperture of the transducers as long as the beam does not spread. The field is then extruded over the
aperture; the solid outside the aperture is drawn without a field, and the picture says so. A free wave has no aperture
and is extruded over the whole width.

The displacement is enlarged by a factor that the picture states. Lengths are in mm.
"""

import textwrap
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import MaxNLocator
from PIL import Image

from studies.model.model import model_of
from studies.record.quantities import quantity
from studies.refusal import needed
from studies.view import overlays
from studies.view.field_points import SectionPart, Sheet, beam_sheet, magnification, sheets, strips
from studies.view.field_quantities import shade
from studies.view.run_field import RunField
from studies.view.views import BELOW, MM, RIGHT, SOLID, Frame, View, frames, right_edge

BARE, EDGE = "#D9D9D9", "#606060"
LINES = 24  # points per wavelength in a picture of the solid
LETTERS, MIN_LETTERS = 13, 10  # font size in pixels, and the smallest of a caption
MIN_SOLID_LETTERS = 8  # smallest font size in points of the captions of a solid or a window
CAPTION_LINE, MIN_VIEW = 14, 90  # height of a caption's line, and least height of a view below a long caption, pixels
SLENDER = 1.9  # height of a letter over its mean width
LEGEND_MARGIN, LEGEND_LINE = 22, 20  # pixels: above the legend of the fingers, and of each of its lines
# Pixels per wavelength below which a picture of the solid shows the amplitude instead of the wave, whose stripes would
# be aliased
MIN_PIXELS = 12
AZIMUTH, ELEVATION = 35, 28  # of the camera that looks at the solid, degrees
SOLID_CAPTIONS = 200  # height of the captions and the coordinate axes of a picture of the solid, pixels


class _Moving(NamedTuple):
    """A mesh with its points at rest and their complex displacement (m, shape (points, 3)), and its colour values."""

    mesh: Any
    rest: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray | None = None
    amplitude: np.ndarray | None = None


class Picture:
    """A pyvista plotter that shows the field at any instant, as stacked views of the section or as the whole solid.

    Parameters
    ----------
    run : RunField
    views : sequence of View
        Views of the section from top to bottom; empty for the solid.
    quantity : str
        Name of the quantity that colours the field.
    phase : float
        omega t in rad.
    factor : float or None
        Factor of the displacement; None selects `magnification`.
    size : (int, int)
        Width and height in pixels.
    framed : bool
        True for views with rulers, drawn off screen; False for a view that fills a window.

    Attributes
    ----------
    plotter : pyvista.Plotter
    """

    def __init__(self, run: RunField, views=(), *, quantity, phase, factor, size, framed=True):
        self.pyvista = needed("pyvista", "a picture or a window of the field")
        # without a display VTK writes messages to stderr before it falls back to off-screen rendering
        self.pyvista.vtk_verbosity("off")
        self.run, self.phase, self.size, self.framed, self.solid = run, phase, size, framed, not views
        self.factor = magnification(run) if factor is None else factor
        self.spreads = self.solid and run.beam is not None
        self._length = run.scene.stator.length if self.spreads else run.length
        self._heading = self._first_caption(views) if views and framed else ""
        self.frames = frames(run, views, size=size, framed=framed, head=CAPTION_LINE * self._heading.count("\n"))
        # the first renderer draws texts and rulers in pixels; without frames it also draws the field
        shape = 1 + framed * len(self.frames), 1
        self.plotter = self.pyvista.Plotter(off_screen=framed or None, window_size=size, shape=shape, border=False)
        self.set_quantity(quantity)
        for number, frame in enumerate(self.frames):
            self._select_renderer(number)
            self.plotter.renderer.viewport = tuple(np.divide(frame.box, 2 * self.size))
            self.plotter.enable_parallel_projection()
            self._add_balls()
            if self.solid:
                self._add_solid_without_field()
                self._aim_at_solid(frame)
            else:
                self._aim_at_section(frame)
        self._add_captions()

    def _select_renderer(self, number: int) -> None:
        """Select the renderer of a frame for drawing."""
        self.plotter.subplot(number + self.framed, 0)

    @property
    def _envelope(self) -> bool:
        """Whether the surface under a beam is coloured by the amplitude, since a wavelength is a few pixels."""
        return self.spreads and self.size[0] < MIN_PIXELS * self._length / self.run.wavelength

    def set_quantity(self, name: str) -> None:
        """Colour the field by a quantity."""
        self._moving: list = []
        self.parts: list = []
        if not self.spreads:
            self.shade = shade(self.run, name)
        for number, frame in enumerate(self.frames):
            self._select_renderer(number)
            if self.spreads:
                self.shade, sheet, motion = beam_sheet(self.run, name, envelope=self._envelope)
                self._add_sheet(sheet)
            else:
                drawn = self._part_of(frame)
                self.parts.append(drawn)
                for sheet in sheets(self.run, drawn, self.shade, solid=self.solid):
                    self._add_sheet(sheet)
                motion = partial(drawn.at_height, z=overlays.finger_height(self.run))
                self._add_interfaces(drawn)
            self._add_electrodes(motion)
        self._add_colour_bar()
        self.set_phase(self.phase)

    def _add_colour_bar(self) -> None:
        """Draw the colour bar at the right: beside the highest view, and below the legend of the electrodes."""
        self.plotter.subplot(0, 0)
        for former in list(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(former)
        width, height = self.size
        title, _, unit = self.shade.label.partition(" (")
        low, high = (0.5 * height, 0.85 * height) if self.solid else (0.7 * height, 0.9 * height)
        if self.framed and not self.solid:
            _, low, _, high = max((frame.box for frame in self.frames), key=lambda box: box[3] - box[1])
        entries = len(overlays.electrodes(self.run))
        too_high = max(high - (height - LEGEND_MARGIN - LEGEND_LINE * entries - LETTERS), 0)  # its title is below these
        high -= too_high
        if self.solid or not self.framed:
            low -= too_high
        self.plotter.add_scalar_bar(
            title="\n".join([*textwrap.wrap(title, 12), f"({unit}\n"]), mapper=self._mapper, vertical=True, n_labels=3,
            fmt="%.3g", position_x=1 - 112 / width, width=84 / width, position_y=low / height,
            height=(high - low) / height, title_font_size=LETTERS, label_font_size=LETTERS,
        )  # fmt: skip

    def set_phase(self, phase: float) -> None:
        """Show another instant."""
        self.phase = phase
        phase_factor = np.exp(1j * phase)
        for each in self._moving:
            each.mesh.points[:] = MM * (each.rest + self.factor * (each.displacement * phase_factor).real)
            if each.amplitude is not None:
                wave = (each.amplitude * phase_factor**self.shade.quantity.harmonic).real
                each.mesh["shade"][:] = each.mean + wave

    def image(self, phase: float) -> np.ndarray:
        """Return the picture at a phase in rad, shape (height, width, 3)."""
        self.set_phase(phase)
        self.plotter.render()
        return self.plotter.screenshot(return_img=True)

    def save(self, file: str | Path, *, whole: bool = True) -> None:
        """Write the picture and close the plotter; unless ``whole``, crop the empty part below the views."""
        image = self.plotter.screenshot(return_img=True)
        empty_rows = 0 if whole or self.solid else max(int(self.frames[-1].box[1]) - BELOW, 0)
        Image.fromarray(image[: len(image) - empty_rows]).save(file)
        self.plotter.close()

    def _add_electrodes(self, motion: Callable) -> None:
        """Add the strips of the electrodes; ``motion`` returns their displacement at points (x, y) in m."""
        lift = overlays.finger_height(self.run) + (0.02 * self.run.wavelength if self.solid else 0.0)
        for electrode in overlays.electrodes(self.run):
            corners = strips(self.run, electrode, spreads=self.spreads)
            rest = np.insert(corners, 2, lift, axis=-1)
            mesh = self.pyvista.PolyData.from_regular_faces(MM * rest, np.arange(len(corners)).reshape(-1, 4))
            self.plotter.add_mesh(
                mesh, color=electrode.colour, lighting=False, copy_mesh=False, show_edges=True, line_width=3,
                edge_color=electrode.colour, name=f"electrode {electrode.sign}", reset_camera=False,
                style="surface" if self.solid else "wireframe",  # in a view along y, a strip is a line
            )  # fmt: skip
            self._moving.append(_Moving(mesh, rest, motion(corners)))

    def _add_interfaces(self, drawn: SectionPart) -> None:
        """Add a line along each interface of the stator's layers."""
        side = -0.5 * self.run.aperture if self.solid else 0.0  # of the face of the solid that is seen
        for number, z in enumerate(overlays.interfaces(self.run)):
            rest = np.stack([drawn.x, np.full(len(drawn.x), side), np.full(len(drawn.x), z)], axis=-1)
            line = self.pyvista.lines_from_points(MM * rest)
            self.plotter.add_mesh(
                line, color="black", lighting=False, copy_mesh=False, line_width=1, name=f"interface {number}",
                reset_camera=False,
            )  # fmt: skip
            self._moving.append(_Moving(line, rest, drawn.at_height(rest[:, :2], z)))

    def _part_of(self, frame: Frame) -> SectionPart:
        """Return the part of the section that a view or the solid shows."""
        run, span, bottom = self.run, (0.0, self.run.length), self.run.field.z[0]
        spacing = run.wavelength / LINES
        if frame.view is not SOLID:
            start, stop = frame.view.start, frame.view.stop
            margin = 2 * (stop - start)
            if self.framed:
                # points outside the view can be displaced into it
                margin = min(self.factor * float(abs(run.field.displacement).max()), margin)
                bottom, spacing = frame.bottom - margin, frame.pixel
            elif stop - start < 1.99 * run.wavelength:
                spacing = 5 * (stop - start) / 1000  # a short view needs finer points and a smaller margin
            else:
                margin = run.length
            span = max(start - margin, 0.0), min(stop + margin, run.length)
        return SectionPart.of(run, self.shade, span=span, bottom=bottom, spacing=spacing)

    def _add_sheet(self, sheet: Sheet) -> None:
        """Add a sheet to the plotter."""
        shape = sheet.rest.shape
        if sheet.quads is None:
            grid = self.pyvista.StructuredGrid(*np.moveaxis(MM * sheet.rest, -1, 0))
        else:
            grid = self.pyvista.PolyData.from_regular_faces(MM * sheet.rest.reshape(-1, 3), sheet.quads)
        if sheet.hidden is not None and sheet.hidden.any():
            grid = grid.hide_cells(np.flatnonzero(sheet.hidden.ravel(order="F")))
        grid["shade"] = np.zeros(grid.n_points)
        self._mapper = self.plotter.add_mesh(
            grid, scalars="shade", cmap=self.shade.colour_map, clim=self.shade.limits, lighting=False,
            show_scalar_bar=False, copy_mesh=False, name=sheet.name, reset_camera=False,
        ).mapper  # fmt: skip
        vectors = (np.broadcast_to(each, shape).reshape(-1, 3, order="F") for each in sheet[1:3])
        values = (np.broadcast_to(each, shape[:3]).ravel(order="F") for each in sheet[3:5])
        self._moving.append(_Moving(grid, *vectors, *values))

    def _add_solid_without_field(self) -> None:
        """Draw the parts of the solid without a field: outside the aperture, or below the surface of a beam."""
        run = self.run
        half, width, depth = 0.5 * run.aperture, 0.5 * run.scene.stator.width, run.field.z[0]
        if self.spreads:  # the solid lies below the troughs of the wave, and at rest a little below its surface
            parts = [(-width, width, 1.0)]
            top = -self.factor * max(float(abs(each.displacement).max()) for each in self._moving)
            top -= 0.01 * run.wavelength
        elif width - half < 1e-9:
            return
        else:
            parts, top = [(-width, -half, 0.25), (half, width, 1.0)], 0.0  # the front half is transparent
        for low, high, opacity in parts:
            ends = (0.0, self._length, low, high, depth, top)
            box = self.pyvista.Box(tuple(MM * each for each in ends))
            self.plotter.add_mesh(box, color=BARE, opacity=opacity, lighting=False)
            self.plotter.add_mesh(box, style="wireframe", color=EDGE, line_width=1)
        if not self.spreads:
            return
        for each in model_of(run.scene).transducers:
            outline = np.insert(each.corners[[0, 1, 2, 3, 0]], 2, 0.1 * run.wavelength, axis=-1)
            self.plotter.add_mesh(self.pyvista.lines_from_points(MM * outline), color="black", line_width=2)

    def _aim_at_solid(self, frame: Frame) -> None:
        """Set the camera to look at the whole solid from a corner."""
        camera, (left, low, right, high) = self.plotter.camera, frame.box
        self.plotter.camera_position = "xz"
        camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
        self.plotter.reset_camera()
        view_axes = self.pyvista.array_from_vtkmatrix(camera.GetViewTransformMatrix())[:2, :3]
        width, height = np.ptp(self.pyvista.Box(self.plotter.bounds).points @ view_axes.T, axis=0)
        camera.parallel_scale = 0.52 * max(height, width * (high - low) / (right - left))
        self.plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=3)

    def _aim_at_section(self, frame: Frame) -> None:
        """Set the camera to look along y at a view, and add crystal axes and rulers."""
        camera, height = self.plotter.camera, frame.top - frame.bottom
        x, z = MM * 0.5 * (frame.view.start + frame.view.stop), MM * 0.5 * (frame.top + frame.bottom)
        camera.up, camera.focal_point, camera.parallel_scale = (0, 0, 1), (x, 0, z), 0.5 * MM * height
        camera.position = x, -10 * MM * self.run.length, z
        if self.framed and height > 140 * frame.pixel:
            self._add_crystal_axes(frame)
        self.plotter.reset_camera_clipping_range()
        if self.framed:
            self.plotter.renderer.add_border("black")
            self.plotter.subplot(0, 0)
            self._add_rulers(frame)
        else:
            sides = {f"{side}_axis_visibility": False for side in ("left", "right", "top")}
            self.plotter.add_legend_scale(color="black", legend_visibility=False, xy_label_mode=True, **sides)

    def _add_crystal_axes(self, frame: Frame) -> None:
        """Draw the crystal axes in the lower left corner of a view."""
        start, pixel, colour = frame.view.start, frame.pixel, overlays.AXIS_COLOUR
        corner = MM * np.array([start + 40 * pixel, -self.run.aperture, frame.bottom + 30 * pixel])
        named = [(name, MM * pixel * np.array([x, 0, z])) for name, x, z in overlays.crystal_axes(self.run)]
        for _, along in named:
            arrow = self.pyvista.Arrow(
                start=corner, direction=along, scale=24 * np.hypot(*along[::2]), shaft_radius=0.03
            )
            self.plotter.add_mesh(arrow, color=colour, lighting=False, reset_camera=False)
        centred = {f"justification_{way}": "center" for way in ("horizontal", "vertical")}
        self.plotter.add_point_labels(
            [corner + 32 * along for _, along in named], [name for name, _ in named], text_color=colour, shape=None,
            show_points=False, always_visible=True, font_size=LETTERS, bold=False, reset_camera=False, **centred,
        )  # fmt: skip

    def _add_rulers(self, frame: Frame) -> None:
        """Draw rulers below and to the left of a view."""
        left, low, _, high = frame.box
        ends = MM * np.array([[frame.view.start, frame.view.stop], [frame.bottom, frame.top]])
        (start, stop), (bottom, top) = ends
        ticks = [_ticks(start, stop, 8), _ticks(bottom, top, min((high - low) / 40, 5))[::-1]]
        if high - low > 80:
            middle = 26, (low + high) / 2 - 20
            self.plotter.add_text(quantity.z_m.heading, position=middle, font_size=LETTERS / 2, orientation=90)
        else:
            ticks[1] = np.array([0.0, ends[1, 0]])
        for axis, (title, values) in enumerate(zip((quantity.x_m.heading, ""), ticks, strict=True)):
            # the same number of decimals for all labels: the axis reserves the width of the last one
            decimals = int(np.ceil(-np.log10(abs(np.diff(values)).max(initial=1e-6))))
            label_format = f"%.{max(decimals, 0)}f" if axis == 0 or high - low > 80 else "%.3g"
            end_points = np.tile([left, low, 0.0], (2, 1))
            end_points[:, axis] += (values[[0, -1]] - ends[axis, 0]) / MM / frame.pixel
            ruler = self.plotter.add_ruler(
                *end_points, number_labels=len(values), label_format=label_format, title=title
            )
            ruler.SetRange(*values[[0, -1]])
            ruler.UseFontSizeFromPropertyOn()
            for letters in (ruler.GetLabelTextProperty(), ruler.GetTitleTextProperty()):
                letters.ShallowCopy(self.pyvista.TextProperty(color="black"))
                letters.SetFontSize(LETTERS)

    def _named(self, view: View) -> str:
        """Return the name of a view, with the number of its fingers."""
        fingers = overlays.shown_fingers(self.run, view.start, view.stop)
        return f"{view.name}, {fingers}" if fingers else view.name

    def _first_caption(self, views) -> str:
        """Return the caption of the first view, with scene and drive, in lines that are legible in a narrow picture."""
        run, (width, height) = self.run, self.size
        drive = f"{run.field.frequency / 1e6:g} MHz, {run.drive}, {run.enlarged(self.factor)}"
        caption = f"{run.scene.title}: {self._named(views[0])} ({drive})"
        if height < len(views) * MIN_VIEW + 4 * CAPTION_LINE:  # a low picture needs the room for its views
            return caption
        return textwrap.fill(caption, int(SLENDER * right_edge(width) / MIN_LETTERS))

    def _add_captions(self) -> None:
        """Write the captions and the legend of the electrodes."""
        run, (width, height), plotter = self.run, self.size, self.plotter
        plotter.subplot(0, 0)
        if self.solid or not self.framed:
            drive = f"{run.drive}, {run.enlarged(self.factor)}"
            extents = self._length, run.scene.stator.width, -run.field.z[0]
            extent = " x ".join(f"{each * MM:.4g}" for each in extents)
            more = validity(run).split("; ") if self.solid else ["x in mm; drag: move, wheel: zoom"]
            more += ["amplitude: mean over half a wavelength"] if self._envelope and run.crossed is None else []
            room = 0.98 * (width - (RIGHT if run.fingers else 0)) / 0.6  # beside the legend; in letters of one pixel
            texts = (f"{run.scene.title}: {extent} mm (x, y, z)", drive, *more)
            lines = [line for text in texts for line in textwrap.wrap(text, int(room / MIN_SOLID_LETTERS))]
            letters = int(min(room / max(map(len, lines)), 12))
            plotter.add_text("\n".join(lines), position="upper_left", font_size=letters, color="black")
        else:
            for frame in self.frames:
                caption = self._heading if frame is self.frames[0] else self._named(frame.view)
                longest = max(map(len, caption.splitlines()))
                size = min(LETTERS + 1, SLENDER * frame.box[2] / longest) / 2
                plotter.add_text(caption, position=(8, frame.box[3] + 8), font_size=size)
        if self.framed:
            plotter.renderer.viewport, camera = (0, 0, 1, 1), plotter.camera
            plotter.enable_parallel_projection()
            camera.focal_point, camera.position = (width / 2, height / 2, 0), (width / 2, height / 2, 1)
            camera.up, camera.parallel_scale = (0, 1, 0), height / 2
        entries = [(each.label, each.colour) for each in overlays.electrodes(run)]
        if entries:
            legend, up = (plotter.add_legend(entries, bcolor=None, face="rectangle"), LEGEND_LINE * len(entries))
            legend.SetPosition(1 - 122 / width, 1 - (LEGEND_MARGIN + up) / height)
            legend.SetPosition2(115 / width, up / height)

    def _add_balls(self) -> None:
        """Draw the balls of the slider on the crests of the enlarged wave."""
        for ball in overlays.balls(self.run, spreads=self.spreads):
            centre = ball.x * MM, ball.y * MM, (ball.radius + self.factor * ball.crest) * MM
            sphere = self.pyvista.Sphere(radius=ball.radius * MM, center=centre, theta_resolution=90, phi_resolution=90)
            options = {"smooth_shading": True, "ambient": 0.5} if self.solid else {"lighting": False}
            self.plotter.add_mesh(sphere, color=overlays.BALL_COLOUR, **options)


def solid_height(run: RunField, width: int) -> int:
    """Return the height in pixels at which the solid, seen from its corner, and its captions fill a picture.

    At most the width, so that a block that is as wide as long is not larger than its picture.
    """
    length = run.scene.stator.length if run.beam is not None else run.length
    azimuth, elevation = np.deg2rad([AZIMUTH, ELEVATION])
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    up = np.array([np.sin(azimuth) * np.sin(elevation), np.cos(azimuth) * np.sin(elevation), np.cos(elevation)])
    sizes = np.array([length, run.scene.stator.width, -run.field.z[0] + 2.0 * run.radius])
    return min(int((width - RIGHT) * (up @ sizes) / (across @ sizes)) + SOLID_CAPTIONS, width)


def validity(run: RunField) -> str:
    """Return a sentence on the region in which the drawn field is valid."""
    if run.free:
        return "a straight-crested free wave: the same for every y"
    if run.beam is not None:
        return "field of the finite apertures (frames) on the surface; grey: not computed, --show field has the section"
    return (
        f"field drawn only within the {run.aperture * MM:g} mm aperture, where the model holds for every y "
        "(the beam does not spread in it); grey: not modelled"
    )


def _ticks(low: float, high: float, count: float) -> np.ndarray:
    """Return about ``count`` round numbers between two limits."""
    values = np.asarray(MaxNLocator(max(int(count), 2), steps=[1, 2, 5, 10]).tick_values(low, high))
    return values[(values > low - 1e-9) & (values < high + 1e-9)].round(9)
