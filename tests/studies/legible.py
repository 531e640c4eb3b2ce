"""Whether a matplotlib picture can be read: words inside it and on no other word, legends on no curve."""

import numpy as np
from matplotlib.text import Text

__all__ = ["assert_legible"]

NEAR = 1.0  # pixel


def assert_legible(figure):
    """Words lie in the figure and apart from each other; no data point lies under a legend or under a written value."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    beyond = _beyond(figure)
    words = [
        text for text in figure.findobj(Text) if text not in beyond and text.get_visible() and text.get_text().strip()
    ]
    boxes = [(text.get_text(), Text.get_window_extent(text, renderer)) for text in words]
    for number, (text, box) in enumerate(boxes):
        assert box.x0 >= -NEAR, text
        assert box.y0 >= -NEAR, text
        assert box.x1 <= figure.bbox.width + NEAR, text
        assert box.y1 <= figure.bbox.height + NEAR, text
        for other, earlier in boxes[:number]:
            across = min(box.x1, earlier.x1) - max(box.x0, earlier.x0)
            up = min(box.y1, earlier.y1) - max(box.y0, earlier.y0)
            assert min(across, up) <= NEAR, (text, other)
    for ax in figure.axes:
        legend = ax.get_legend()
        covered = [] if legend is None else [legend.get_window_extent(renderer)]
        # words with a background are read before a curve
        covered += [Text.get_window_extent(each, renderer) for each in ax.texts if each.get_bbox_patch() is None]
        for other in figure.axes:
            for line in other.lines:
                points = line.get_transform().transform(_dense(line.get_xydata()))
                seen = points[_within(other.bbox, points)]
                for box in covered:
                    assert not _within(box, seen).any(), (line.get_label(), "under the legend or a word")


def _beyond(figure) -> set:
    """Return the labels of ticks that lie outside their axes, which matplotlib keeps and does not draw."""
    found = set()
    for ax in figure.findobj(lambda each: hasattr(each, "xaxis") and hasattr(each, "yaxis")):
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            margin = 1e-9 * (high - low)
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                if not (ax.get_visible() and low - margin <= tick.get_loc() <= high + margin):
                    found |= {tick.label1, tick.label2}
    return found


def _dense(points):
    """Return the points of a line and some between them."""
    if len(points) < 2:
        return points
    at = np.arange(len(points))
    fine = np.linspace(0, len(points) - 1, 10 * (len(points) - 1) + 1)
    return np.stack([np.interp(fine, at, column) for column in np.transpose(points)], axis=1)


def _within(box, points):
    x, y = np.transpose(points)
    return (x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)
