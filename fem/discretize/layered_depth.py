"""Elements through the depth of a stator with layers: every interface is an end of an element.

Away from the plane of the fingers, where the charge at their edges is singular, the elements grow as those of one solid
do, by 1 / LAYER_RATIO, up to the largest size that the wavelength in their own solid allows. A layer between two of
these ends thus takes one element however thin it is.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fem.discretize.element_sizes import CORNER_RATIO, LAYER_RATIO, graded

SLACK = 1.15  # factor by which an element may exceed its size before another one is added


class Region(NamedTuple):
    """A solid between two depths."""

    thickness: float  # length units
    largest: float  # height of an element, length units
    solid: int  # number of the solid, from the bottom up


def divided(regions: Sequence[Region], smallest: float) -> list[tuple[float, int]]:
    """Heights and solids of the elements of regions, away from the plane where the first one has the size ``smallest``.

    ``smallest`` is infinite where nothing is singular in that plane: the elements of a region are then of one size.

    Examples
    --------
    >>> [round(float(height), 4) for height, _ in divided([Region(0.1, 1.0, 1), Region(0.5, 1.0, 0)], 0.02)]
    [0.02, 0.08, 0.5]
    """
    elements, start = [], 0.0
    for region in regions:
        stop = start + region.thickness
        if start == 0.0 and smallest < stop:
            elements.append((smallest, region.solid))
            start = smallest
        growth = 1.0 / LAYER_RATIO - 1.0 if np.isfinite(smallest) and start > 0.0 else np.inf
        heights = _filled(start, stop, growth, region.largest)
        elements += [(height, region.solid) for height in heights]
        start = stop
    return elements


def _filled(start: float, stop: float, growth: float, largest: float) -> list[float]:
    """Heights of the fewest elements between two distances, each at most ``growth`` times its distance, and largest."""
    if stop - start <= 1e-12 * stop:
        return []

    def ends(count: int, share: float) -> np.ndarray:
        at = [start]
        for _ in range(count):
            at.append(at[-1] + share * min(growth * at[-1] if np.isfinite(growth) else np.inf, largest))
        return np.array(at)

    count = 1
    while ends(count, SLACK)[-1] < stop:
        count += 1
    low, high = 0.0, SLACK
    for _ in range(60):
        share = 0.5 * (low + high)
        low, high = (share, high) if ends(count, share)[-1] < stop else (low, share)
    heights = np.diff(ends(count, high))
    return list(heights * ((stop - start) / heights.sum()))


def with_corner(elements: list[tuple[float, int]], layers: int, largest: float) -> list[tuple[float, int]]:
    """Return the elements, from the bottom up, with the lowest graded towards the bottom."""
    (height, solid), *others = elements
    lowest = graded(height, layers, largest=largest, smallest_first=True, ratio=CORNER_RATIO)
    return [(each, solid) for each in lowest] + others
