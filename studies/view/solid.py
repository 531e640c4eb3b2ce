"""The field in three dimensions by pyvista: the section to play and zoom, or the stator as a solid of its whole width.

Where the run computed the finite aperture the solid carries that field on its surface, over the whole width; nothing is
drawn below it.  Otherwise the model is a section: it holds, the same for every y, within the aperture of the
transducers, as far as the beam does not spread.  There the field is extruded; beside it the solid is drawn bare, and
the picture says so.  A free wave has no aperture and fills the width.  Lengths are in mm.
"""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from studies.refusal import SceneError, needed
from studies.scene import resolved
from studies.view import description
from studies.view.quantities import QUANTITIES, present, shade, shade_of
from studies.view.run_field import RunField
from studies.view.section import magnification, piece

__all__ = ["Solid", "open_window"]

MM = 1e3
BARE, EDGE = "#D9D9D9", "#606060"
LINES = 24  # per wavelength, of what is drawn
BEAM_LINES, ACROSS = 12, 81  # of the surface of a beam: per wavelength along x, and across the width
CROSSED_LINES = 8  # per wavelength along both, where beams cross
MOTIONS = ("u_x", "u_y", "u_z")
CYCLE, TICK = 2.5, 40  # s that one period of the wave takes; ms between instants


class _Moving(NamedTuple):
    """A mesh, its points at rest (m) and their complex displacement (m), shape (points, 3), and parts of a shade."""

    mesh: object
    rest: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray | None = None
    amplitude: np.ndarray | None = None


class Solid:
    """A pyvista plotter with the field at any instant: the whole solid, or the section seen along y.

    Parameters
    ----------
    found : RunField
    quantity : str
        What colours the field.
    phase : float
        omega t, rad.
    factor : float or None
        Of the displacement; None for `magnification`.
    size : tuple of int
        Pixels.
    off_screen : bool
    span : tuple of float or None
        m, of the section that is looked at; None for the whole solid.

    Attributes
    ----------
    plotter : pyvista.Plotter
    """

    def __init__(self, found: RunField, *, quantity, phase, factor, size, off_screen, span=None):
        self.pyvista = needed("pyvista", "a solid or a window of the field")
        self.pyvista.vtk_verbosity(
            "off"
        )  # without a display VTK says so on stderr before it finds another way
        self.found, self.phase, self.span = found, phase, span
        self.factor = magnification(found) if factor is None else factor
        self.spreads = span is None and found.beam is not None
        self._length = found.scene.stator.length if self.spreads else found.length
        self.plotter = self.pyvista.Plotter(off_screen=off_screen, window_size=size)
        self.set_quantity(quantity)
        self._stand()
        if span is None:
            self._bare()
        self._write(size)
        self._look(size)

    def set_quantity(self, name: str) -> None:
        """Colour the field by a quantity."""
        self._moving: list[_Moving] = []
        if self.spreads:
            motion = self._lay_beam(name)
        else:
            motion = self._lay_section(name)
        for electrode in description.electrodes(self.found):
            corners = self._strips(electrode)
            rest = np.insert(corners, 2, 0.02 * self.found.wavelength, axis=-1)
            mesh = self.pyvista.PolyData.from_regular_faces(MM * rest, np.arange(len(corners)).reshape(-1, 4))
            self.plotter.add_mesh(
                mesh, color=electrode.colour, lighting=False, copy_mesh=False, show_edges=True, line_width=3,
                edge_color=electrode.colour, name=f"electrode {electrode.sign}", reset_camera=False,
            )  # fmt: skip
            self._moving.append(_Moving(mesh, rest, motion(corners)))
        for former in list(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(former)
        self.plotter.add_scalar_bar(
            title=self.shade.label.replace(" (", "\n(") + "\n",
            mapper=self.plotter.actors["surface"].mapper, vertical=True, position_x=0.9, position_y=0.5,
            width=0.06, height=0.35, title_font_size=13, label_font_size=13, n_labels=3, fmt="%.3g",
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

    def _strips(self, electrode) -> np.ndarray:
        """Return the corners (x, y) of an electrode's strips in m, shape (4 n, 2), as they are or in the section."""
        if self.spreads:
            rows = resolved.transducers(self.found.scene)
            corners = np.concatenate([each.on_surface(each.strips(electrode.sign)) for each in rows])
            return corners.reshape(-1, 2)
        x = np.array(electrode.strips)[:, [0, 1, 1, 0]].ravel()
        return np.stack([x, np.resize(0.5 * self.found.aperture * np.array([-1, -1, 1, 1]), len(x))], axis=-1)

    def _lay_section(self, name: str) -> Callable:
        """Add the surface, the section in front and the right end; return the surface's motion over (x, y) in m."""
        found, (start, stop) = self.found, self.span or (0.0, self.found.length)
        self.shade, room = shade(found, name), stop - start
        kept = (0.0, found.length)  # a short stretch is finer, and less is kept beside it
        if room < 1.99 * found.wavelength:
            kept = max(start - room, 0.0), min(stop + room, found.length)
        spacing = min(found.wavelength / LINES, (kept[1] - kept[0]) / 1000)
        self._piece = drawn = piece(found, self.shade, span=kept, bottom=found.field.z[0], spacing=spacing)
        moved = np.insert(drawn.displacement, 1, 0.0, axis=-1)
        edges = np.array([-0.5, 0.5]) * found.aperture
        for part, lines, rows, y in (
            ("surface", slice(None), slice(-1, None), edges),
            ("section", slice(None), slice(None), edges[:1]),
            ("end", slice(-1, None), slice(None), edges),
        ):
            rest = np.stack(np.meshgrid(drawn.x[lines], drawn.z[rows], y, indexing="ij"), axis=-1)[
                ..., [0, 2, 1]
            ]
            values = (each[lines, rows, None] for each in (drawn.mean, drawn.amplitude))
            self._lay(part, rest, moved[lines, rows, None], *values)
        return lambda at: np.stack([np.interp(at[:, 0], drawn.x, each) for each in moved[:, -1].T], axis=-1)

    def _lay_beam(self, name: str) -> Callable:
        """Add the surface that the beam moves; return its motion over (x, y) in m."""
        found = self.found
        if name not in MOTIONS:
            raise SceneError(
                "--quantity",
                f"must be one of {', '.join(MOTIONS)} on the surface of the beam, got {name!r}: --show field has it in "
                "the section",
            )
        crossed, stator = found.scene.crossed, found.scene.stator
        lines = (CROSSED_LINES if crossed else BEAM_LINES) / found.wavelength
        x, half = np.linspace(0.0, stator.length, int(stator.length * lines) + 1), stator.width / 2
        y = np.linspace(-half, half, int(stator.width * lines) + 1 if crossed else ACROSS)
        moved = found.beam.motion(x[:, None], y)
        size = moved[MOTIONS.index(name), ..., None]
        self.shade = shade_of(QUANTITIES[name], abs(size), free=False)
        rest, amplitude = np.stack(np.meshgrid(x, y, 0.0, indexing="ij"), axis=-1), size * self.shade.scale
        self._lay("surface", rest, np.moveaxis(moved, 0, -1)[:, :, None], 0.0 * amplitude.real, amplitude)
        return RegularGridInterpolator((x, y), np.moveaxis(moved, 0, -1))

    def _lay(self, name: str, rest, displacement, mean, amplitude) -> None:
        """Add a structured grid of points (n, m, copies, 3) and its shade."""
        grid = self.pyvista.StructuredGrid(*np.moveaxis(MM * rest, -1, 0))

        def flat(values, *last):
            return np.broadcast_to(values, (*rest.shape[:3], *last)).reshape(-1, *last, order="F")

        grid["shade"] = np.zeros(grid.n_points)
        self.plotter.add_mesh(
            grid, scalars="shade", cmap=self.shade.colour_map, clim=self.shade.limits, lighting=False,
            show_scalar_bar=False, copy_mesh=False, name=name, reset_camera=False,
        )  # fmt: skip
        self._moving.append(_Moving(grid, flat(rest, 3), flat(displacement, 3), flat(mean), flat(amplitude)))

    def _stand(self) -> None:
        """Put the balls of the slider on the crests of the enlarged wave."""
        for ball in description.balls(self.found, spreads=self.spreads):
            centre = ball.place * MM, ball.lateral * MM, (ball.radius + self.factor * ball.crest) * MM
            sphere = self.pyvista.Sphere(
                radius=ball.radius * MM, center=centre, theta_resolution=90, phi_resolution=90
            )
            self.plotter.add_mesh(sphere, color=description.BALL_COLOUR, smooth_shading=True, ambient=0.5)

    def _bare(self) -> None:
        """Draw the parts of the solid that carry no field: beside the aperture, or below the surface of a beam."""
        found = self.found
        half, width, depth = 0.5 * found.aperture, 0.5 * found.scene.stator.width, found.field.z[0]
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
        for each in resolved.transducers(found.scene):
            outline = np.insert(each.corners[[0, 1, 2, 3, 0]], 2, 0.1 * found.wavelength, axis=-1)
            self.plotter.add_mesh(self.pyvista.lines_from_points(MM * outline), color="black", line_width=2)

    def _write(self, size: tuple[int, int]) -> None:
        """Write the caption and the names of the electrodes; show the directions, or of the section the scale."""
        found, section = self.found, self.span is not None
        extents = self._length, found.scene.stator.width, -found.field.z[0]
        extent = " x ".join(f"{each * MM:.4g}" for each in extents)
        lines = [
            f"{found.scene.title}: {extent} mm (x, y, z)",
            f"{found.drive}, {found.enlarged(self.factor)}",
        ]
        lines += ["scale in mm; drag: move, wheel: zoom"] if section else said(found).split("; ")
        letters = int(np.clip(0.98 * size[0] / (0.6 * max(map(len, lines))), 6, 12))
        self.plotter.add_text("\n".join(lines), position="upper_left", font_size=letters, color="black")
        listed = [(each.label, each.colour) for each in description.electrodes(found)]
        if listed:
            self.plotter.add_legend(
                listed, bcolor=None, face="rectangle", size=(0.12, 0.06), loc="upper right"
            )
        if section:
            self.plotter.add_legend_scale(
                color="black", left_axis_visibility=False, right_axis_visibility=False, top_axis_visibility=False,
                legend_visibility=False,
            )  # fmt: skip
        else:
            self.plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=3)

    def _look(self, size: tuple[int, int]) -> None:
        """Look at the whole solid from a corner, or along y at the stretch."""
        camera = self.plotter.camera
        if self.span is None:
            self.plotter.camera_position = "xz"
            camera.azimuth, camera.elevation = 35, 28
            self.plotter.enable_parallel_projection()
            self.plotter.reset_camera()
            camera.zoom(1.35)  # room for the colour bar
            return
        start, stop = self.span
        middle, height = 0.5 * (start + stop) * MM, 1.1 * (stop - start) * MM * size[1] / size[0]
        self.plotter.enable_parallel_projection()
        camera.up = (0, 0, 1)
        camera.focal_point = middle, 0.0, -0.15 * height
        camera.position = middle, -10 * self.found.length * MM, -0.15 * height
        camera.parallel_scale = 0.5 * height
        self.plotter.reset_camera_clipping_range()


def said(found: RunField) -> str:
    """Return where the drawn field is true."""
    if found.free:
        return "a straight-crested free wave: the same for every y"
    if found.beam is not None:
        return "field of the finite apertures (frames) on the surface; grey: not computed, --show field has the section"
    return (
        f"field drawn only within the {found.aperture * MM:g} mm aperture, where the model holds for every y "
        "(the beam does not spread in it); grey: not modelled"
    )


class Controls:
    """Play and pause, instant and colour of a `Solid`, by pyvista's own widgets."""

    def __init__(self, solid: Solid):
        self.solid, self.names = solid, list(MOTIONS) if solid.spreads else present(solid.found)
        self.playing, self._last, self._rested, self._ready = True, time.perf_counter(), 0.0, False
        plotter, given = solid.plotter, {"style": "modern", "color": "black"}
        self.play_button = plotter.add_checkbox_button_widget(
            self.play, value=True, position=(20.0, 70.0), size=34, color_on="#0072B2", color_off="#999999"
        )
        self.phase_slider = plotter.add_slider_widget(
            self.pick_phase, (0, 360), value=np.degrees(solid.phase) % 360, title="phase (degrees)", fmt="%.0f",
            pointa=(0.12, 0.13), pointb=(0.34, 0.13), interaction_event="always", title_height=0.015, **given,
        )  # fmt: skip
        plotter.add_text_slider_widget(
            self.pick_quantity, self.names, value=self.names.index(solid.shade.quantity.name),
            pointa=(0.42, 0.13), pointb=(0.6, 0.13), **given,
        )  # fmt: skip
        plotter.add_text("play", position=(62.0, 76.0), font_size=8, color="black")
        self._ready = True  # setting a slider up calls it

    def tick(self, step: int) -> None:
        """Go on to the instant that the clock says, while playing."""
        now = time.perf_counter()
        if self.playing and now > self._rested:
            passed, self._last = now - self._last, now
            phase = (self.solid.phase + 2 * np.pi * passed / CYCLE) % (2 * np.pi)
            self.phase_slider.GetRepresentation().SetValue(np.degrees(phase))
            self.solid.set_phase(phase)
            self.solid.plotter.render()
            # half of the time is left to the mouse, however slowly the machine draws
            done = time.perf_counter()
            self._rested = done + (done - now)

    def play(self, playing: bool) -> None:
        """Play or pause."""
        self.playing, self._last = bool(playing), time.perf_counter()

    def pick_phase(self, degrees: float) -> None:
        """Show the instant of a phase, and pause."""
        if self._ready:
            self.play(False)
            self.play_button.GetRepresentation().SetState(0)
            self.solid.set_phase(np.radians(degrees))

    def pick_quantity(self, name: str) -> None:
        """Colour the field by another quantity."""
        if self._ready and name != self.solid.shade.quantity.name:
            self.solid.set_quantity(name)


def open_window(solid: Solid) -> None:
    """Show a solid with its controls until the window is closed; of a section a drag moves and the wheel zooms."""
    controls = Controls(solid)
    if solid.span is not None:
        solid.plotter.enable_2d_style()
    solid.plotter.add_timer_event(max_steps=2**31 - 1, duration=TICK, callback=controls.tick)
    solid.plotter.show(title=f"sawmotor: {solid.found.scene.title}")
