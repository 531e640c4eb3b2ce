"""The views of the section in a picture, and their positions in it."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from studies.record.quantities import quantity
from studies.refusal import refuse_if
from studies.view import overlays
from studies.view.run_field import RunField

MM = quantity.x_m.scale  # from m to the unit of lengths in pictures
HALF_SPAN = 7.0  # half-length of an enlarged view, in wavelengths
MIN_SPAN = 0.05  # smallest length of a view, in wavelengths
LEFT, RIGHT, ABOVE, BELOW = 80, 130, 30, 50  # margins of a view in pixels, for labels and colour bar
FULL_MARGINS = 140  # pixels of height per view below which the margins shrink
BALL_SHARE = 0.35  # largest fraction of the height of a view that a ball covers


@dataclass(frozen=True, kw_only=True)
class View:
    """A part of the section from ``start`` to ``stop`` (m), and its weight in the height of the picture."""

    name: str
    start: float
    stop: float
    weight: float


SOLID = View(name="the solid", start=-math.inf, stop=math.inf, weight=1.0)


class Frame(NamedTuple):
    """Rectangle of a view or of the solid in the picture: left, low, right and high in pixels.

    A view also has its scale ``pixel`` in m per pixel, and ``top``, the z in m at its upper edge.
    """

    box: tuple[float, float, float, float]
    view: View = SOLID
    pixel: float = 0.0
    top: float = 0.0

    @property
    def bottom(self) -> float:
        """Lowest visible z, m."""
        return self.top - (self.box[3] - self.box[1]) * self.pixel


def limits(run: RunField, span: str | tuple[float, float]) -> tuple[float, float]:
    """Return the limits in m of "whole", "slider", "wavelength" or of two positions, which must lie on the stator."""
    if span == "whole":
        return 0.0, run.length
    if isinstance(span, str):
        focus, slider = run.focus[1], run.scene.slider
        half = (0.5 if span == "wavelength" else HALF_SPAN) * run.wavelength
        if span == "slider" and slider is not None:  # include all balls
            farthest = max(abs(run.in_section(each) - focus) for each in slider.contact_positions)
            half = max(half, farthest + 2 * run.radius)
        return max(focus - half, 0.0), min(focus + half, run.length)
    got = f"got {span[0] * MM:g}:{span[1] * MM:g} mm"
    refuse_if(span[0] >= span[1], "--span", f"must have START below STOP, {got}")
    on_stator = span[0] >= 0 and span[1] <= run.length * (1 + 1e-9)
    refuse_if(not on_stator, "--span", f"must lie on the stator, 0:{run.length * MM:g} mm, {got}")
    min_length = MIN_SPAN * run.wavelength
    rule = f"must be at least {min_length * MM:.3g} mm long, a twentieth of a wavelength"
    refuse_if(span[1] - span[0] < min_length, "--span", f"{rule}, got {(span[1] - span[0]) * MM:.3g} mm")
    return span


def near(run: RunField) -> tuple[float, float]:
    """Return the limits in m of the two wavelengths around the focus of the run."""
    return run.focus[1] - run.wavelength, run.focus[1] + run.wavelength


def views(run: RunField) -> tuple[View, ...]:
    """Return the default views: the whole section, the driven transducer and the slider."""
    if run.free:
        return span_views(run, (0.0, run.length))
    driven, half_length = run.in_section(run.scene.driven_transducer.center_xy), HALF_SPAN * run.wavelength
    start, stop = limits(run, "slider")
    whole = View(name="the whole section", start=0.0, stop=run.length, weight=0.17)
    name = f"driven transducer {run.scene.driven_transducer.name!r}"
    return (
        whole,
        View(name=name, start=max(driven - half_length, 0.0), stop=min(driven + half_length, run.length), weight=0.4),
        View(name=run.focus[0], start=start, stop=stop, weight=0.4),
    )


def span_views(run: RunField, span: tuple[float, float] | None) -> tuple[View, ...]:
    """Return a view of the whole section and one of ``span`` (m); None selects the surroundings of the slider."""
    start, stop = span or limits(run, "slider")
    count = (stop - start) / run.wavelength
    name = "1 wavelength" if abs(count - 1) < 5e-4 else f"{count:.3g} wavelengths"
    if stop - start > 0.99 * run.length:
        return (View(name=name, start=start, stop=stop, weight=1.0),)
    whole = View(name="the whole section", start=0.0, stop=run.length, weight=0.3)
    name = f"{name}, {start * MM:.4g} to {stop * MM:.4g} mm"
    return whole, View(name=name, start=start, stop=stop, weight=0.7)


def right_edge(width: int) -> float:
    """Return the right edge of the frames in a picture of this width, both in pixels."""
    return max(width - RIGHT, LEFT + 0.3 * width)


def frames(run: RunField, views, *, size: tuple[int, int], framed: bool, head: int = 0) -> tuple[Frame, ...]:
    """Return the frames of the views from top to bottom. A frame is at most as high as its weight or its content.

    Without views, return the frame of the solid. A view that is not ``framed`` fills the picture. ``head``: pixels at
    the top of the picture that stay free for a caption of several lines.
    """
    width, upper = size[0], size[1] - head
    if not framed:
        pixel = (views[0].stop - views[0].start) / width if views else 0.0
        return (Frame((0, 0, width, upper), *views, *([pixel, 0.35 * upper * pixel] if views else ())),)
    right, result = right_edge(width), []
    if not views:
        return (Frame((0, 0, right, max(upper - 4 * ABOVE, 0.4 * upper))),)
    weights, margin_scale = sum(view.weight for view in views), min(1.0, upper / (FULL_MARGINS * len(views)))
    above, below = margin_scale * ABOVE, margin_scale * BELOW
    heights = [each.points[:, 1] for each in run.field.pieces]
    lowest = min([float(run.field.z[0]), *(float(each.min()) for each in heights)])
    highest = max([0.0, *(float(each.max()) for each in heights)])
    for view in views:
        pixel, available = (view.stop - view.start) / (right - LEFT), upper * view.weight / weights
        visible = pixel * max(available - above - below, 0.3 * available)
        has_ball = any(view.start <= ball.x <= view.stop for ball in overlays.balls(run))
        headroom = 0.15 * min(visible, 2 * run.wavelength)
        top = max(min(2.1 * run.radius, BALL_SHARE * visible) if has_ball else headroom, 1.3 * highest)
        high = upper - above
        low = high - (top - max(lowest, top - visible)) / pixel
        result.append(Frame((LEFT, low, right, high), view, pixel, top))
        upper, weights = low - below, weights - view.weight
    return tuple(result)
