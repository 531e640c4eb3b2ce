"""A run's field by pyvista: stretches of its deformed section in frames, one to move about in, or the whole solid.

Views of the section lie one above the other, each in its true proportions.  Where the run computed the finite aperture
the solid carries that field on its surface, over the whole width; nothing is drawn below it.  Otherwise the model is a
section: it holds, the same for every y, within the aperture of the transducers, as far as the beam does not spread.
There the field is extruded; beside it the solid is drawn bare, and the picture says so.  A free wave has no aperture
and fills the width.  The displacement is enlarged so that it is seen; the picture says how much.  Lengths are in mm.
"""

import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import MaxNLocator
from PIL import Image

from studies.chain import resolve
from studies.refusal import needed
from studies.view import description
from studies.view.quantities import shade
from studies.view.run_field import RunField
from studies.view.section import Piece, Sheet, beam_sheet, magnification, mesh_sheets, piece, sheets, strips
from studies.view.views import BELOW, Frame, frames

MM = 1e3
BARE, EDGE = "#D9D9D9", "#606060"
LINES = 24  # per wavelength, of what is drawn of a solid
LETTERS = 13  # pixels
MIN_PIXELS = (
    12  # per wavelength along a solid: below it stripes of the wave are an artefact, the amplitude is drawn
)


class _Moving(NamedTuple):
    """A mesh, its points at rest (m) and their complex displacement (m), shape (points, 3), and parts of a shade."""

    mesh: Any
    rest: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray | None = None
    amplitude: np.ndarray | None = None


class Picture:
    """A pyvista plotter with the field at any instant: views of the section from the top down, or the whole solid.

    ``quantity`` colours the field, ``phase`` is omega t in rad, ``factor`` that of the displacement (`magnification`
    if None), ``size`` in pixels.  A view that is ``framed`` has rulers and is drawn off screen; one that is not fills a
    window.

    Attributes
    ----------
    plotter : pyvista.Plotter
    """

    def __init__(self, run: RunField, views=(), *, quantity, phase, factor, size, framed=True):
        self.pyvista = needed("pyvista", "a picture or a window of the field")
        # without a display VTK says so on stderr before it finds another way
        self.pyvista.vtk_verbosity("off")
        self.run, self.phase, self.size, self.framed, self.solid = run, phase, size, framed, not views
        self.factor = magnification(run) if factor is None else factor
        self.spreads = self.solid and run.beam is not None
        self._length = run.scene.stator.length if self.spreads else run.length
        self.frames = frames(run, views, size=size, framed=framed)
        # the first renderer holds words and rulers, in pixels; without frames it holds the field too
        shape = 1 + framed * len(self.frames), 1
        self.plotter = self.pyvista.Plotter(
            off_screen=framed or None, window_size=size, shape=shape, border=False
        )
        self.set_quantity(quantity)
        for number, frame in enumerate(self.frames):
            self._go_to(number)
            self.plotter.renderer.viewport = tuple(np.divide(frame.box, 2 * self.size))
            self.plotter.enable_parallel_projection()
            self._stand()
            if self.solid:
                self._bare()
                self._look(frame)
            else:
                self._look_along(frame)
        self._write()

    def _go_to(self, number: int) -> None:
        """Make the renderer of a frame the one that is drawn into."""
        self.plotter.subplot(number + self.framed, 0)

    def set_quantity(self, name: str) -> None:
        """Colour the field by a quantity."""
        self._moving: list = []
        self.pieces: list = []
        if not self.spreads:
            self.shade = shade(self.run, name)
        for number, frame in enumerate(self.frames):
            self._go_to(number)
            if self.spreads:
                waves = self._length / self.run.wavelength
                self.shade, sheet, motion = beam_sheet(
                    self.run, name, envelope=self.size[0] < MIN_PIXELS * waves
                )
                self._lay(sheet)
            else:
                drawn = self._piece(frame)
                self.pieces.append(drawn)
                meshed = mesh_sheets(self.run, drawn, self.shade, solid=self.solid)
                for sheet in [*sheets(self.run, drawn, solid=self.solid), *meshed]:
                    self._lay(sheet)
                motion = drawn.surface
            self._add_electrodes(motion)
        self.plotter.subplot(0, 0)
        for former in list(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(former)
        width, height = self.size
        title, _, unit = self.shade.label.partition(" (")
        low, high = (0.5 * height, 0.85 * height) if self.solid else (0.7 * height, 0.9 * height)
        if self.framed and not self.solid:
            _, low, _, high = max((frame.box for frame in self.frames), key=lambda box: box[3] - box[1])
        self.plotter.add_scalar_bar(
            title="\n".join([*textwrap.wrap(title, 12), f"({unit}\n"]), mapper=self._mapper, vertical=True, n_labels=3,
            fmt="%.3g", position_x=1 - 112 / width, width=84 / width, position_y=low / height,
            height=(high - low) / height, title_font_size=LETTERS, label_font_size=LETTERS,
        )  # fmt: skip
        self.set_phase(self.phase)

    def set_phase(self, phase: float) -> None:
        """Move everything to another instant."""
        self.phase = phase
        turned = np.exp(1j * phase)
        for each in self._moving:
            each.mesh.points[:] = MM * (each.rest + self.factor * (each.displacement * turned).real)
            if each.amplitude is not None:
                wave = (each.amplitude * turned**self.shade.quantity.turns).real
                each.mesh["shade"][:] = each.mean + wave

    def image(self, phase: float) -> np.ndarray:
        """Return the picture at an instant, shape (height, width, 3)."""
        self.set_phase(phase)
        self.plotter.render()
        return self.plotter.screenshot(return_img=True)

    def save(self, file: str | Path, *, whole: bool = True) -> None:
        """Write the picture as it is, or without what its views leave empty at the bottom, and give it up."""
        drawn = self.plotter.screenshot(return_img=True)
        empty = 0 if whole or self.solid else max(int(self.frames[-1].box[1]) - BELOW, 0)
        Image.fromarray(drawn[: len(drawn) - empty]).save(file)
        self.plotter.close()

    def _add_electrodes(self, motion: Callable) -> None:
        """Add the strips of the electrodes, which move as a function of (x, y) in m says."""
        lift = 0.02 * self.run.wavelength if self.solid else 0.0
        for electrode in description.electrodes(self.run):
            corners = strips(self.run, electrode, spreads=self.spreads)
            rest = np.insert(corners, 2, lift, axis=-1)
            mesh = self.pyvista.PolyData.from_regular_faces(MM * rest, np.arange(len(corners)).reshape(-1, 4))
            self.plotter.add_mesh(
                mesh, color=electrode.colour, lighting=False, copy_mesh=False, show_edges=True, line_width=3,
                edge_color=electrode.colour, name=f"electrode {electrode.sign}", reset_camera=False,
                style="surface" if self.solid else "wireframe",  # a strip that is seen along y is a line
            )  # fmt: skip
            self._moving.append(_Moving(mesh, rest, motion(corners)))

    def _piece(self, frame: Frame) -> Piece:
        """Return the points of the section that a view, or the solid, needs."""
        run, span, bottom = self.run, (0.0, self.run.length), self.run.field.z[0]
        spacing = run.wavelength / LINES
        if frame.view is not None:
            start, stop = frame.view.start, frame.view.stop
            spare = 2 * (stop - start)
            if self.framed:
                # moves into the view from beyond its edges, which cut it
                spare = min(self.factor * float(abs(run.field.displacement).max()), spare)
                bottom, spacing = frame.bottom - spare, frame.pixel
            elif stop - start < 1.99 * run.wavelength:
                spacing = 5 * (stop - start) / 1000  # a short stretch is finer, and less is kept beside it
            else:
                spare = run.length
            span = max(start - spare, 0.0), min(stop + spare, run.length)
        return piece(run, self.shade, span=span, bottom=bottom, spacing=spacing)

    def _lay(self, sheet: Sheet) -> None:
        """Add a sheet of points."""
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

    def _bare(self) -> None:
        """Draw the parts of the solid that carry no field: beside the aperture, or below the surface of a beam."""
        run = self.run
        half, width, depth = 0.5 * run.aperture, 0.5 * run.scene.stator.width, run.field.z[0]
        parts = [(-width, -half, 0.25), (half, width, 1.0)]  # the half in front is seen through
        if self.spreads:
            parts = [(-width, width, 1.0)]
        elif width - half < 1e-9:
            return
        top = 0.0
        if self.spreads:  # below the troughs
            top = -self.factor * max(float(abs(each.displacement).max()) for each in self._moving)
        for low, high, opacity in parts:
            ends = (0.0, self._length, low, high, depth, top)
            box = self.pyvista.Box(tuple(MM * each for each in ends))
            self.plotter.add_mesh(box, color=BARE, opacity=opacity, lighting=False)
            self.plotter.add_mesh(box, style="wireframe", color=EDGE, line_width=1)
        if not self.spreads:
            return
        for each in resolve.transducers(run.scene):
            outline = np.insert(each.corners[[0, 1, 2, 3, 0]], 2, 0.1 * run.wavelength, axis=-1)
            self.plotter.add_mesh(self.pyvista.lines_from_points(MM * outline), color="black", line_width=2)

    def _look(self, frame: Frame) -> None:
        """Look at the whole solid from a corner."""
        camera, (left, low, right, high) = self.plotter.camera, frame.box
        self.plotter.camera_position = "xz"
        camera.azimuth, camera.elevation = 35, 28
        self.plotter.reset_camera()
        turn = self.pyvista.array_from_vtkmatrix(camera.GetViewTransformMatrix())[:2, :3]
        across, up = np.ptp(self.pyvista.Box(self.plotter.bounds).points @ turn.T, axis=0)
        camera.parallel_scale = 0.52 * max(up, across * (high - low) / (right - left))
        self.plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=3)

    def _look_along(self, frame: Frame) -> None:
        """Look along y at a view; give it its crystal axes and rulers."""
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
        start, pixel, colour = frame.view.start, frame.pixel, description.AXIS_COLOUR
        corner = MM * np.array([start + 40 * pixel, -self.run.aperture, frame.bottom + 30 * pixel])
        named = [
            (name, MM * pixel * np.array([x, 0, z])) for name, x, z in description.crystal_axes(self.run)
        ]
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
        """Put rulers below and beside a view."""
        left, low, _, high = frame.box
        ends = MM * np.array([[frame.view.start, frame.view.stop], [frame.bottom, frame.top]])
        (start, stop), (bottom, top) = ends
        ticks = [_ticks(start, stop, 8), _ticks(bottom, top, min((high - low) / 40, 5))[::-1]]
        if high - low > 80:
            middle = 26, (low + high) / 2 - 20
            self.plotter.add_text("z (mm)", position=middle, font_size=LETTERS / 2, orientation=90)
        else:
            ticks[1] = np.array([0.0, ends[1, 0]])
        for axis, (title, values) in enumerate(zip(("x (mm)", ""), ticks, strict=True)):
            # as many decimals for all: the axis leaves room for the width of the last
            decimals = int(np.ceil(-np.log10(abs(np.diff(values)).max(initial=1e-6))))
            written = f"%.{max(decimals, 0)}f" if axis == 0 or high - low > 80 else "%.3g"
            places = np.tile([left, low, 0.0], (2, 1))
            places[:, axis] += (values[[0, -1]] - ends[axis, 0]) / MM / frame.pixel
            ruler = self.plotter.add_ruler(
                *places, number_labels=len(values), label_format=written, title=title
            )
            ruler.SetRange(*values[[0, -1]])
            ruler.UseFontSizeFromPropertyOn()
            for letters in (ruler.GetLabelTextProperty(), ruler.GetTitleTextProperty()):
                letters.ShallowCopy(self.pyvista.TextProperty(color="black"))
                letters.SetFontSize(LETTERS)

    def _write(self) -> None:
        """Write captions and the names of the electrodes."""
        run, (width, height), plotter = self.run, self.size, self.plotter
        plotter.subplot(0, 0)
        drive = f"{run.drive}, {run.enlarged(self.factor)}"
        if self.solid or not self.framed:
            extents = self._length, run.scene.stator.width, -run.field.z[0]
            extent = " x ".join(f"{each * MM:.4g}" for each in extents)
            more = said(run).split("; ") if self.solid else ["x in mm; drag: move, wheel: zoom"]
            lines = [f"{run.scene.title}: {extent} mm (x, y, z)", drive, *more]
            letters = int(np.clip(0.98 * width / (0.6 * max(map(len, lines))), 6, 12))
            plotter.add_text("\n".join(lines), position="upper_left", font_size=letters, color="black")
        else:
            for frame in self.frames:
                fingers = description.shown_fingers(run, frame.view.start, frame.view.stop)
                name = f"{frame.view.name}, {fingers}" if fingers else frame.view.name
                if frame is self.frames[0]:
                    name = f"{run.scene.title}: {name} ({run.field.frequency / 1e6:g} MHz, {drive})"
                size = min(LETTERS + 1, 1.9 * frame.box[2] / len(name)) / 2
                plotter.add_text(name, position=(8, frame.box[3] + 8), font_size=size)
        if self.framed:
            plotter.renderer.viewport, camera = (0, 0, 1, 1), plotter.camera
            plotter.enable_parallel_projection()
            camera.focal_point, camera.position = (width / 2, height / 2, 0), (width / 2, height / 2, 1)
            camera.up, camera.parallel_scale = (0, 1, 0), height / 2
        listed = [(each.label, each.colour) for each in description.electrodes(run)]
        if listed:
            legend, up = plotter.add_legend(listed, bcolor=None, face="rectangle"), 20 * len(listed)
            legend.SetPosition(1 - 122 / width, 1 - (22 + up) / height)
            legend.SetPosition2(115 / width, up / height)

    def _stand(self) -> None:
        """Put the balls of the slider on the crests of the enlarged wave."""
        for ball in description.balls(self.run, spreads=self.spreads):
            centre = ball.place * MM, ball.lateral * MM, (ball.radius + self.factor * ball.crest) * MM
            sphere = self.pyvista.Sphere(
                radius=ball.radius * MM, center=centre, theta_resolution=90, phi_resolution=90
            )
            options = {"smooth_shading": True, "ambient": 0.5} if self.solid else {"lighting": False}
            self.plotter.add_mesh(sphere, color=description.BALL_COLOUR, **options)


def said(run: RunField) -> str:
    """Return where the drawn field is true."""
    if run.free:
        return "a straight-crested free wave: the same for every y"
    if run.beam is not None:
        return "field of the finite apertures (frames) on the surface; grey: not computed, --show field has the section"
    return (
        f"field drawn only within the {run.aperture * MM:g} mm aperture, where the model holds for every y "
        "(the beam does not spread in it); grey: not modelled"
    )


def _ticks(low: float, high: float, count: float) -> np.ndarray:
    """Return round numbers between two, about as many as asked for."""
    values = np.asarray(MaxNLocator(max(int(count), 2), steps=[1, 2, 5, 10]).tick_values(low, high))
    return values[(values > low - 1e-9) & (values < high + 1e-9)].round(9)
