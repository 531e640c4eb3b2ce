"""The deformed section on a pyvista plotter: field, electrodes, slider, crystal axes, ruler; any instant, any quantity.

Lengths are in mm.  The displacement is enlarged so that it is seen; the factor is written in the picture.  A picture
consists of views, one above the other, each a stretch of the section in its true proportions.
"""

import numpy as np

from studies.view import description
from studies.view.frame import (
    MM,
    Frame,
    View,
    bar,
    caption,
    crystal,
    cut,
    framed,
    legend,
    look,
    pyvista_quietly,
    ruler,
)
from studies.view.patch import Patch, patch
from studies.view.run_field import RunField
from studies.view.shading import Shade, shade

__all__ = ["Stage", "chosen_views", "magnification", "views"]

AMPLITUDE = 0.08  # of a wavelength: as large as the largest displacement is drawn
CLOSE = 7.0  # wavelengths either side, in the close pictures


def views(found: RunField) -> tuple[View, ...]:
    """Return what is shown unless something else is asked for: the whole, the driven transducer, the slider."""
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.17)
    if found.free:
        name = f"{found.length / found.wavelength:.3g} wavelengths"
        return (View(name=name, start=0.0, stop=found.length, weight=1.0),)
    driven = next(each for each in found.scene.transducer if each.name == found.scene.drive.transducer)
    reach = CLOSE * found.wavelength
    return (
        whole,
        *(
            View(
                name=name,
                start=max(place - reach, 0.0),
                stop=min(place + reach, found.length),
                weight=0.4,
            )
            for name, place in ((f"driven transducer {driven.name!r}", driven.center), found.focus)
        ),
    )


def chosen_views(found: RunField, span: tuple[float, float] | None) -> tuple[View, ...]:
    """Return the whole section and below it a stretch (m), what lies about the slider if None."""
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.3)
    _, place = found.focus
    if span is None:
        reach = CLOSE * found.wavelength
        span = max(place - reach, 0.0), min(place + reach, found.length)
    wavelengths = (span[1] - span[0]) / found.wavelength
    if span[1] - span[0] > 0.99 * found.length:
        return (View(name=_wavelengths(wavelengths), start=span[0], stop=span[1], weight=1.0),)
    at = f"{span[0] * MM:.4g} to {span[1] * MM:.4g} mm"
    return whole, View(name=f"{_wavelengths(wavelengths)}, {at}", start=span[0], stop=span[1], weight=0.7)


def _wavelengths(count: float) -> str:
    return "1 wavelength" if abs(count - 1) < 5e-4 else f"{count:.3g} wavelengths"


def magnification(found: RunField) -> float:
    """Return how many times the displacement is enlarged unless asked otherwise: one round digit."""
    largest = float(abs(found.field.displacement).max())
    if largest == 0:
        return 1.0
    return float(f"{AMPLITUDE * found.wavelength / largest:.0e}")


class Stage:
    """A plotter with views of one field.

    Parameters
    ----------
    found : RunField
    shown : tuple of View
        From top to bottom.
    quantity : str
        What colours the field.
    phase : float
        omega t, rad.
    factor : float or None
        Of the displacement; None for `magnification`.
    size : tuple of int
        Pixels, width and height.
    off_screen : bool
    smooth : bool
        Whether edges are smoothed, which takes three times as long where no graphics card draws.
    panel : float
        Weight of an empty row below the views.
    """

    def __init__(
        self,
        found: RunField,
        shown: tuple[View, ...],
        *,
        quantity: str,
        phase: float,
        factor: float | None,
        size: tuple[int, int],
        off_screen: bool,
        smooth: bool,
        panel: float = 0.0,
    ):
        pyvista = pyvista_quietly()
        self.found, self.shown, self.size, self.panel = found, list(shown), size, panel
        self.phase = phase
        self.factor = magnification(found) if factor is None else factor
        self.reach = self.factor * float(abs(found.field.displacement).max())
        self.shade: Shade = shade(found, quantity)
        weights = [view.weight for view in self.shown] + ([panel] if panel else [])
        self.plotter = pyvista.Plotter(
            shape=(len(weights), 1),
            row_weights=weights,
            off_screen=off_screen,
            window_size=size,
            border=False,
        )
        if not smooth:
            self.plotter.render_window.SetMultiSamples(0)
        self.pieces = [self._drawn(row) for row in range(len(self.shown))]

    def set_phase(self, phase: float) -> None:
        """Move everything to another instant."""
        self.phase = phase
        for piece in self.pieces:
            piece.move(phase)

    def set_quantity(self, name: str) -> None:
        """Colour the field by another quantity."""
        self.shade = shade(self.found, name)
        self.pieces = [self._drawn(row) for row in range(len(self.shown))]

    def set_view(self, row: int, view: View) -> None:
        """Look at another stretch of the section in one row."""
        self.shown[row] = view
        self.pieces[row] = self._drawn(row)

    def image(self) -> np.ndarray:
        """Return the picture as it is now, (height, width, 3) of uint8."""
        self.plotter.render()
        return self.plotter.screenshot(return_img=True)

    def close(self) -> None:
        """Give back what the plotter holds."""
        self.plotter.close()

    def frame(self, row: int) -> Frame:
        """Return where a row's section lies in its picture."""
        view = self.shown[row]
        share = view.weight / (sum(each.weight for each in self.shown) + self.panel)
        return framed(self.found, view, width=self.size[0], height=self.size[1] * share)

    def _drawn(self, row: int) -> "Piece":
        plotter = self.plotter
        plotter.subplot(row, 0)
        plotter.renderer.RemoveAllViewProps()
        frame = self.frame(row)
        piece = Piece(self, frame)
        actor = plotter.add_mesh(
            piece.mesh,
            scalars="shade",
            cmap=self.shade.colour_map,
            clim=self.shade.limits,
            lighting=False,
            show_scalar_bar=False,
            copy_mesh=False,
        )
        cut(actor.mapper, frame)
        if frame.view.weight == max(view.weight for view in self.shown) and not self._bar_above(row):
            bar(plotter, frame, self.shade, actor.mapper)
        for electrode, fingers in piece.fingers:
            plotter.add_mesh(fingers.mesh, color=electrode.colour, lighting=False, copy_mesh=False)
        self._stand(row, frame)
        ruler(plotter, frame)
        crystal(plotter, frame, self.found)
        field = self.found.field
        scale = f"{field.frequency / 1e6:g} MHz, {self.found.drive}, {self.found.enlarged(self.factor)}"
        fingers = description.shown_fingers(self.found, frame.view.start, frame.view.stop)
        name = f"{frame.view.name}, {fingers}" if fingers else frame.view.name
        caption(plotter, frame, f"{self.found.scene.title}: {name} ({scale})" if row == 0 else name)
        if row == 0 and len(self.shown) > 1:
            legend(plotter, frame, self.found)
        look(plotter, frame)
        piece.move(self.phase)
        return piece

    def _bar_above(self, row: int) -> bool:
        """Whether a row further up is as high: one colour bar is enough."""
        return any(view.weight == self.shown[row].weight for view in self.shown[:row])

    def _stand(self, row: int, frame: Frame) -> None:
        """Put the balls of the slider on the crests of the enlarged wave."""
        pyvista, found = pyvista_quietly(), self.found
        for ball in description.balls(found):
            if not frame.view.start <= ball.place <= frame.view.stop:
                continue
            height = ball.radius + self.factor * ball.crest
            disc = pyvista.Disc(
                center=(ball.place * MM, 0.0, height * MM),
                inner=0.0,
                outer=ball.radius * MM,
                normal=(0, 1, 0),
                c_res=120,
            )
            drawn = self.plotter.add_mesh(
                disc, color=description.BALL_COLOUR, lighting=False, name=f"ball {ball.place:g}"
            )
            cut(drawn.mapper, frame, top=True)
            if height < frame.top:
                mark = pyvista.PolyData(np.array([(ball.place * MM, -0.001, height * MM)]))
                self.plotter.add_mesh(mark, color="black", point_size=5, name=f"centre {ball.place:g}")


class Piece:
    """The moving parts of a view: the section's mesh and the electrodes riding on it."""

    def __init__(self, stage: Stage, frame: Frame):
        pyvista = pyvista_quietly()
        found = stage.found
        self.factor = stage.factor
        # moves into the frame from beyond its edges, which cut it
        spare = min(stage.reach, 2 * (frame.view.stop - frame.view.start))
        self.patch: Patch = patch(
            found,
            stage.shade,
            span=(max(frame.view.start - spare, 0.0), min(frame.view.stop + spare, found.length)),
            bottom=frame.bottom - spare,
            spacing=0.5 * frame.pixel,
        )
        self.mesh = _surface(pyvista, self.patch.places(0.0, 0.0), self.patch.triangles)
        self.mesh["shade"] = np.zeros(self.mesh.n_points, dtype=np.float32)
        self.fingers = []
        for electrode in description.electrodes(found):
            strips = [
                strip
                for strip in electrode.strips
                if strip[1] > frame.view.start and strip[0] < frame.view.stop
            ]
            if strips:
                self.fingers.append((electrode, Fingers(pyvista, self.patch, strips, 5 * frame.pixel)))

    def move(self, phase: float) -> None:
        """Show another instant."""
        places = self.patch.places(phase, self.factor).reshape(-1, 2) * MM
        points = self.mesh.points
        points[:, 0], points[:, 2] = places[:, 0], places[:, 1]
        self.mesh["shade"][:] = self.patch.values(phase).reshape(-1)
        self.mesh.GetPoints().Modified()
        self.mesh.GetPointData().GetScalars().Modified()
        self.mesh.Modified()
        for _, fingers in self.fingers:
            fingers.move(phase, self.factor)


class Fingers:
    """Electrodes of one sign as strips that ride on the surface, thick enough to be seen."""

    def __init__(self, pyvista, patch: Patch, strips, thickness: float):
        places = np.array([[left, 0.5 * (left + right), right] for left, right in strips]).ravel()
        top = patch.displacement[:, -1]
        parts = [[np.interp(places, patch.x, part(top[:, k])) for part in (np.real, np.imag)] for k in (0, 1)]
        self._motion = np.stack([real + 1j * imaginary for real, imaginary in parts], axis=1)
        self._places, self._thickness = places, thickness
        corner = 2 * np.arange(len(places)).reshape(-1, 3)[:, :2].ravel()
        triangles = np.concatenate(
            [np.stack([corner, corner + 2, corner + 3], 1), np.stack([corner, corner + 3, corner + 1], 1)]
        )
        self.mesh = _surface(pyvista, np.zeros((len(places), 2, 2)), triangles)

    def move(self, phase: float, factor: float) -> None:
        """Ride on the surface of another instant."""
        moved = factor * (self._motion * np.exp(1j * phase)).real
        points = self.mesh.points
        points[:, 0] = np.repeat(self._places + moved[:, 0], 2) * MM
        points[:, 2] = np.repeat(moved[:, 1], 2) * MM
        points[1::2, 2] += self._thickness * MM
        points[:, 1] = -0.01  # before the section
        self.mesh.GetPoints().Modified()
        self.mesh.Modified()


def _surface(pyvista, places: np.ndarray, triangles: np.ndarray):
    """Return triangles over (n, m, 2) places in x and z as PolyData, in mm."""
    points = np.zeros((places.shape[0] * places.shape[1], 3), dtype=np.float32)
    points[:, [0, 2]] = places.reshape(-1, 2) * MM
    return pyvista.PolyData.from_regular_faces(points, triangles)
