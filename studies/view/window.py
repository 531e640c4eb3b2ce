"""The window: the whole section above, a part of it below, and controls to play, pause, pick and zoom.

The controls are pyvista's own widgets.  One cycle of the wave takes ``CYCLE`` seconds.
"""

import time

import numpy as np

from studies.view.frame import View, write
from studies.view.run_field import RunField
from studies.view.shading import present
from studies.view.stage import Stage

__all__ = ["Window"]

CYCLE = 2.5  # s
TICK = 40  # ms between instants
SIZE, PANEL = (1500, 900), 0.2
NARROWEST = 1.0  # wavelengths
LETTERS = 0.11  # of the controls' height


class Window:
    """A stage with controls.

    Parameters
    ----------
    found : RunField
    quantity : str
    phase : float
        rad.
    factor : float or None
        Of the displacement.
    span : tuple of float or None
        m, of the lower view at first; two wavelengths about the slider if None.
    off_screen : bool
        For tests: the controls are there, nothing is opened.
    """

    def __init__(self, found: RunField, *, quantity, phase, factor, span, off_screen=False):
        self.found = found
        _, place = found.focus
        start, stop = span or (place - found.wavelength, place + found.wavelength)
        self.place, self.reach = 0.5 * (start + stop), stop - start
        self.names = present(found)
        self.playing, self._last, self._rested = True, time.perf_counter(), 0.0
        self.stage = Stage(
            found,
            (View(name="the whole section", start=0.0, stop=found.length, weight=0.25), self._view()),
            quantity=quantity,
            phase=phase,
            factor=factor,
            size=SIZE,
            off_screen=off_screen,
            smooth=False,
            panel=PANEL,
        )
        self._ready = False  # setting a slider up calls it
        self._controls(quantity, np.degrees(phase) % 360)
        self._ready = True

    def open(self) -> None:
        """Show the window until it is closed."""
        plotter = self.stage.plotter
        plotter.add_timer_event(max_steps=2**31 - 1, duration=TICK, callback=self.tick)
        plotter.show(title=f"sawmotor: {self.found.scene.title}")

    def tick(self, step: int) -> None:
        """Go on to the instant that the clock says, while playing."""
        now = time.perf_counter()
        if self.playing and now > self._rested:
            passed, self._last = now - self._last, now
            phase = (self.stage.phase + 2 * np.pi * passed / CYCLE) % (2 * np.pi)
            self.phase_slider.GetRepresentation().SetValue(np.degrees(phase))
            self.stage.set_phase(phase)
            self.stage.plotter.render()
            # half of the time is left to the mouse, however slowly the machine draws
            done = time.perf_counter()
            self._rested = done + (done - now)

    def play(self, playing: bool) -> None:
        """Play or pause."""
        self.playing, self._last = bool(playing), time.perf_counter()

    def pick_phase(self, degrees: float) -> None:
        """Show the instant of a phase, and pause."""
        self.play(False)
        self.play_button.GetRepresentation().SetState(0)
        self.stage.set_phase(np.radians(degrees))

    def pick_quantity(self, name: str) -> None:
        """Colour the field by another quantity."""
        if name != self.stage.shade.quantity.name:
            self.stage.set_quantity(name)

    def pick_zoom(self, exponent: float) -> None:
        """Show 10**exponent wavelengths in the lower view."""
        self.reach = min(10.0**exponent * self.found.wavelength, self.found.length)
        self.stage.set_view(1, self._view())

    def pick_place(self, millimetres: float) -> None:
        """Move the middle of the lower view."""
        self.place = millimetres * 1e-3
        self.stage.set_view(1, self._view())

    def _view(self) -> View:
        """The lower view, kept on the stator."""
        half = 0.5 * self.reach
        middle = float(np.clip(self.place, half, self.found.length - half))
        name = f"{self.reach / self.found.wavelength:.3g} wavelengths about x = {middle * 1e3:.4g} mm"
        return View(
            name=name, start=max(middle - half, 0.0), stop=min(middle + half, self.found.length), weight=0.55
        )

    def _controls(self, quantity: str, degrees: float) -> None:
        plotter, found = self.stage.plotter, self.found
        plotter.subplot(2, 0)
        self.play_button = plotter.add_checkbox_button_widget(
            self.play, value=True, position=(18.0, 40.0), size=34, color_on="#0072B2", color_off="#999999"
        )
        _write(plotter, "play", 0.023)
        widest = np.log10(found.length / found.wavelength)
        reach = np.log10(self.reach / found.wavelength)
        self.phase_slider = self._slider(
            self.pick_phase, (0, 360), degrees, "phase (degrees)", (0.08, 0.28), "%.0f", moving="always"
        )
        self.zoom_slider = self._slider(
            self.pick_zoom, (np.log10(NARROWEST), widest), reach, "zoom: log10 (wavelengths shown)", (0.54, 0.74),
            "%.2f",
        )  # fmt: skip
        self.place_slider = self._slider(
            self.pick_place,
            (0.0, found.length * 1e3),
            self.place * 1e3,
            "middle of it: x (mm)",
            (0.78, 0.98),
            "%.2f",
        )
        self.quantity_slider = plotter.add_text_slider_widget(
            self.pick_quantity, self.names, value=self.names.index(quantity), pointa=(0.34, 0.45),
            pointb=(0.48, 0.45), style="modern", color="black",
        )  # fmt: skip
        self.quantity_slider.GetRepresentation().SetTitleHeight(LETTERS)
        _write(plotter, "colour", 0.41)
        plotter.enable_2d_style()

    def _slider(self, callback, limits, value, title, across, fmt, *, moving="end"):
        plotter = self.stage.plotter
        slider = plotter.add_slider_widget(
            lambda value: callback(value) if self._ready else None,
            limits,
            value=value,
            pointa=(across[0], 0.45),
            pointb=(across[1], 0.45),
            fmt=fmt,
            style="modern",
            color="black",
            interaction_event=moving,
        )
        slider.GetRepresentation().SetLabelHeight(LETTERS)
        _write(plotter, title, 0.5 * (across[0] + across[1]))
        return slider


def _write(plotter, text: str, across: float) -> None:
    write(plotter, text, (across, 0.15), 12)
