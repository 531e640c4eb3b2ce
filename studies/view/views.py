"""The stretches of the section that a picture shows, and their frames in it."""

from dataclasses import dataclass
from typing import NamedTuple

from studies.refusal import SceneError
from studies.view import description
from studies.view.run_field import RunField

MM = 1e3
CLOSE = 7.0  # wavelengths either side, in the close views
NARROWEST = 0.05  # wavelengths
LEFT, RIGHT, ABOVE, BELOW = 80, 130, 30, 50  # pixels round a view, for letters and colour bar
NARROW = 140  # pixels of height for each view, below which there is less room round it
BALL_SHARE = 0.35  # of a view's height that a ball takes at most


@dataclass(frozen=True, kw_only=True)
class View:
    """A stretch of the section from start to stop (m), and its share of the picture's height."""

    name: str
    start: float
    stop: float
    weight: float


class Frame(NamedTuple):
    """Rectangle of a view, or of the solid, in the picture: left, low, right, high in pixels.

    A view also has its scale ``pixel`` in m per pixel, and ``top``, the z in m at its upper edge.
    """

    box: tuple[float, float, float, float]
    view: View | None = None
    pixel: float = 0.0
    top: float = 0.0

    @property
    def bottom(self) -> float:
        """Lowest z that is seen, m."""
        return self.top - (self.box[3] - self.box[1]) * self.pixel


def limits(run: RunField, span) -> tuple[float, float] | None:
    """Return the stretch (m) that "whole", "slider", "wavelength" or two places mean; refuse one off the stator."""
    if span is None:
        return None
    if span == "whole":
        return 0.0, run.length
    if isinstance(span, str):
        focus, slider = run.focus[1], run.scene.slider
        half = (0.5 if span == "wavelength" else CLOSE) * run.wavelength
        if span == "slider" and slider is not None:  # all its balls
            farthest = max(abs(run.in_section(place) - focus) for place in slider.places)
            half = max(half, farthest + 2 * run.radius)
        return max(focus - half, 0.0), min(focus + half, run.length)
    if not 0 <= span[0] < span[1] <= run.length * (1 + 1e-9):
        rule = f"must lie on the stator, 0:{run.length * 1e3:g} mm"
        raise SceneError("--span", f"{rule}, got {span[0] * 1e3:g}:{span[1] * 1e3:g} mm")
    least = NARROWEST * run.wavelength
    if span[1] - span[0] < least:
        rule = f"must be at least {least * 1e3:.3g} mm long, a twentieth of a wavelength"
        raise SceneError("--span", f"{rule}, got {(span[1] - span[0]) * 1e3:.3g} mm")
    return span


def near(run: RunField) -> tuple[float, float]:
    """Return the two wavelengths (m) about what is to be looked at from near."""
    return run.focus[1] - run.wavelength, run.focus[1] + run.wavelength


def views(run: RunField) -> tuple[View, ...]:
    """Return what is shown unless something else is asked for: the whole, the driven transducer, the slider."""
    if run.free:
        return chosen_views(run, (0.0, run.length))
    driven, reach = run.in_section(run.scene.driven_transducer.place), CLOSE * run.wavelength
    start, stop = limits(run, "slider")
    whole = View(name="the whole section", start=0.0, stop=run.length, weight=0.17)
    name = f"driven transducer {run.scene.driven_transducer.name!r}"
    return (
        whole,
        View(name=name, start=max(driven - reach, 0.0), stop=min(driven + reach, run.length), weight=0.4),
        View(name=run.focus[0], start=start, stop=stop, weight=0.4),
    )


def chosen_views(run: RunField, span: tuple[float, float] | None) -> tuple[View, ...]:
    """Return the whole section and below it a stretch (m), what lies about the slider if None."""
    start, stop = span or limits(run, "slider")
    count = (stop - start) / run.wavelength
    name = "1 wavelength" if abs(count - 1) < 5e-4 else f"{count:.3g} wavelengths"
    if stop - start > 0.99 * run.length:
        return (View(name=name, start=start, stop=stop, weight=1.0),)
    whole = View(name="the whole section", start=0.0, stop=run.length, weight=0.3)
    name = f"{name}, {start * MM:.4g} to {stop * MM:.4g} mm"
    return whole, View(name=name, start=start, stop=stop, weight=0.7)


def frames(run: RunField, views, *, size: tuple[int, int], framed: bool) -> tuple[Frame, ...]:
    """Return where the views lie, from the top down; one takes no more than its share, or what it needs.

    Without views it is the frame of the solid; a view that is not ``framed`` fills the picture.
    """
    width, upper = size
    if not framed:
        pixel = (views[0].stop - views[0].start) / width if views else 0.0
        return (Frame((0, 0, width, upper), *views, *([pixel, 0.35 * upper * pixel] if views else ())),)
    right, listed = max(width - RIGHT, LEFT + 0.3 * width), []
    if not views:
        return (Frame((0, 0, right, max(upper - 4 * ABOVE, 0.4 * upper))),)
    weights, narrow = sum(view.weight for view in views), min(1.0, upper / (NARROW * len(views)))
    above, below = narrow * ABOVE, narrow * BELOW
    heights = [each.points[:, 1] for each in run.field.pieces]
    lowest = min([float(run.field.z[0]), *(float(each.min()) for each in heights)])
    highest = max([0.0, *(float(each.max()) for each in heights)])
    for view in views:
        pixel, share = (view.stop - view.start) / (right - LEFT), upper * view.weight / weights
        visible = pixel * max(share - above - below, 0.3 * share)
        carries = any(view.start <= ball.place <= view.stop for ball in description.balls(run))
        room = 0.15 * min(visible, 2 * run.wavelength)
        top = max(min(2.1 * run.radius, BALL_SHARE * visible) if carries else room, 1.3 * highest)
        high = upper - above
        low = high - (top - max(lowest, top - visible)) / pixel
        listed.append(Frame((LEFT, low, right, high), view, pixel, top))
        upper, weights = low - below, weights - view.weight
    return tuple(listed)
