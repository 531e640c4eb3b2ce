"""Interactive window of the field of a run, with pyvista widgets."""

import time

import numpy as np

from studies.view.field_points import MOTIONS
from studies.view.field_quantities import present
from studies.view.picture import Picture

CYCLE, TICK = 2.5, 40  # duration of one period of the wave in s; interval between instants in ms


class Controls:
    """Widgets that control animation, phase and quantity of a `Picture`."""

    def __init__(self, picture: Picture):
        self.picture, self.names = picture, list(MOTIONS) if picture.spreads else present(picture.run)
        self.playing, self._last, self._rested, self._ready = True, time.perf_counter(), 0.0, False
        plotter, options = picture.plotter, {"style": "modern", "color": "black"}
        self.play_button = plotter.add_checkbox_button_widget(
            self.play, value=True, position=(20.0, 70.0), size=34, color_on="#0072B2", color_off="#999999"
        )
        self.phase_slider = plotter.add_slider_widget(
            self.pick_phase, (0, 360), value=np.degrees(picture.phase) % 360, title="phase (degrees)", fmt="%.0f",
            pointa=(0.12, 0.13), pointb=(0.34, 0.13), interaction_event="always", title_height=0.015, **options,
        )  # fmt: skip
        plotter.add_text_slider_widget(
            self.pick_quantity, self.names, value=self.names.index(picture.shade.quantity.name),
            pointa=(0.42, 0.13), pointb=(0.6, 0.13), **options,
        )  # fmt: skip
        plotter.add_text("play", position=(62.0, 76.0), font_size=8, color="black")
        self._ready = True  # creating a slider calls its function, which must then do nothing

    def tick(self, step: int) -> None:
        """While playing, advance the phase by the elapsed time."""
        now = time.perf_counter()
        if self.playing and now > self._rested:
            passed, self._last = now - self._last, now
            phase = (self.picture.phase + 2 * np.pi * passed / CYCLE) % (2 * np.pi)
            self.phase_slider.GetRepresentation().SetValue(np.degrees(phase))
            self.picture.set_phase(phase)
            self.picture.plotter.render()
            # leave half of the time to mouse events, even if drawing is slow
            done = time.perf_counter()
            self._rested = done + (done - now)

    def play(self, playing: bool) -> None:
        """Start or pause the animation."""
        self.playing, self._last = bool(playing), time.perf_counter()

    def pick_phase(self, degrees: float) -> None:
        """Show the instant of a phase in degrees and pause the animation."""
        if self._ready:
            self.play(False)
            self.play_button.GetRepresentation().SetState(0)
            self.picture.set_phase(np.radians(degrees))

    def pick_quantity(self, name: str) -> None:
        """Colour the field by another quantity."""
        if self._ready and name != self.picture.shade.quantity.name:
            self.picture.set_quantity(name)


def open_window(picture: Picture) -> None:
    """Show a picture with its controls until the window is closed.

    In a section, dragging moves the view and the mouse wheel zooms.
    """
    controls = Controls(picture)
    if not picture.solid:
        picture.plotter.enable_2d_style()
    picture.plotter.add_timer_event(max_steps=2**31 - 1, duration=TICK, callback=controls.tick)
    picture.plotter.show(title=f"sawmotor: {picture.run.scene.title}")
