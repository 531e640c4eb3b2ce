"""How far a slider can travel along x: to the fingers of a transducer, a meshed piece or the stator's end.

Neither the wave's motion between fingers nor a contact that passes over their edges is part of the contact model. A
slider that stands on a transducer or a piece can travel to the end of it.
"""

from typing import NamedTuple

import numpy as np

from studies.model.contacts_of import contacts_of
from studies.model.model import Model


class FreeWay(NamedTuple):
    """Displacements of a slider in m along x up to which all its contacts stay on the surface about them."""

    low: float  # zero or negative
    high: float  # zero or positive
    # what happens there, in words
    at_low: str
    at_high: str


class _Obstacle(NamedTuple):
    low: float  # x in m
    high: float
    name: str
    clear: float = 0.0  # distance to keep from it, m


def free_way(model: Model, clear: float = 0.0) -> FreeWay:
    """Return how far the slider of a resolved scene on a stator can travel; ``clear``: distance from the fingers, m."""
    low, high = [], []
    for ball, x, y in contacts_of(model.scene.slider).places(model.scene.slider):
        left, right = _ends(_obstacles(model, y, clear), x, model.scene.stator.length)
        low.append((left[0] - x, f"{ball} {left[1]}, at x = {left[0] * 1e3:.6g} mm"))
        high.append((right[0] - x, f"{ball} {right[1]}, at x = {right[0] * 1e3:.6g} mm"))
    (first, at_low), (last, at_high) = max(low), min(high)
    return FreeWay(min(first, 0.0), max(last, 0.0), at_low, at_high)


def _ends(obstacles: list[_Obstacle], x: float, length: float) -> tuple[tuple[float, str], tuple[float, str]]:
    """Return the ends to the left and to the right of x, and what they are."""
    left, right = (0.0, "reaches the stator's end"), (length, "reaches the stator's end")
    for each in obstacles:
        if each.low <= x <= each.high:
            left, right = max(left, (each.low, f"leaves {each.name}")), min(right, (each.high, f"leaves {each.name}"))
        elif each.high < x:
            left = max(left, (min(x, each.high + each.clear), f"reaches {each.name}"))
        else:
            right = min(right, (max(x, each.low - each.clear), f"reaches {each.name}"))
    return left, right


def _obstacles(model: Model, y: float, clear: float) -> list[_Obstacle]:
    """Return fingers and meshed pieces on a line of constant y.

    Fingers that lie across x are in the way at any y, because bars join them beside the aperture; those of a rotated
    transducer within their rectangle.
    """
    found = []
    for each in model.transducers:
        extent = _crossing(each.corners, y) if model.scene.crossed else each.extent
        if extent is not None:
            found.append(_Obstacle(extent[0], extent[1], f"the fingers of transducer {each.name}", clear))
    return found + [_Obstacle(each.extent[0], each.extent[1], f"the piece {each.name}") for each in model.pieces]


def _crossing(corners: np.ndarray, y: float) -> tuple[float, float] | None:
    """Return where a line of constant y enters and leaves a convex polygon with corners (n, 2); None if it misses."""
    crossed = []
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if min(y0, y1) <= y <= max(y0, y1):
            crossed += [x0, x1] if y0 == y1 else [x0 + (y - y0) / (y1 - y0) * (x1 - x0)]
    return (float(min(crossed)), float(max(crossed))) if crossed else None
