"""What the pixels of a picture show: positions, values of the colours, edges of the section, the corners of the solid.

Oracle of positions: the scale that the picture's frames state, and orthographic projection from the corner of the
solid that the picture's documentation names (35 degrees about z, 28 degrees up).
"""

from typing import NamedTuple

import matplotlib
import numpy as np

MM = 1e3
BLACK, PINK, BALL, BARE = (0, 0, 0), (204, 121, 167), (0x99,) * 3, (0xD9,) * 3


def close(pixels, colour, within=12) -> np.ndarray:
    """True where a pixel has a colour."""
    return abs(pixels.astype(int) - colour).max(axis=-1) <= within


def ink(pixels) -> np.ndarray:
    """True where something is drawn on the white paper."""
    return pixels.min(axis=-1) < 250


def runs(mask) -> list[tuple[int, int]]:
    """First and last index, exclusive, of each run of True.

    Examples
    --------
    >>> runs(np.array([False, True, True, False, True]))
    [(1, 3), (4, 5)]
    """
    ends = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(mask, int), [0]])))
    return [(int(a), int(b)) for a, b in ends.reshape(-1, 2)]


def values(pixels, shade) -> np.ndarray:
    """The quantity that the colours state, NaN where a pixel's colour is none of the colour map."""
    colours = (matplotlib.colormaps[shade.colour_map](np.arange(256))[:, :3] * 255).round().astype(int)
    codes, where = np.unique(pixels.astype(int) @ [1 << 16, 1 << 8, 1], return_inverse=True)
    distance = abs(np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1)[:, None] - colours).max(axis=2)
    low, high = shade.limits
    value = low + (high - low) * (distance.argmin(axis=1) + 0.5) / 256
    return np.where(distance.min(axis=1) <= 4, value, np.nan)[where].reshape(pixels.shape[:-1])


class Window(NamedTuple):
    """The inside of a view's frame: pixels, and x of their columns and z of their rows in m."""

    pixels: np.ndarray
    x: np.ndarray
    z: np.ndarray

    @classmethod
    def of(cls, image, frame, border=3) -> "Window":
        """Cut a view out of the whole picture, without the line around it."""
        left, low, right, high = frame.box
        columns = np.arange(int(left) + border, int(right) - border)
        rows = np.arange(int(len(image) - high) + border, int(len(image) - low) - border)
        x = frame.view.start + (columns + 0.5 - left) * frame.pixel
        z = frame.top - (rows + 0.5 - (len(image) - high)) * frame.pixel
        return cls(image[np.ix_(rows, columns)], x, z)

    def edge(self, shade) -> np.ndarray:
        """Height in m of the section's upper edge in each column: where the first four colours of the map lie."""
        coloured = np.isfinite(values(self.pixels, shade))
        coloured[:-3] &= coloured[1:-2] & coloured[2:-1] & coloured[3:]  # one alone may be the edge of a letter
        return np.where(coloured.any(axis=0), self.z[coloured.argmax(axis=0)], np.nan)


def projected(points) -> np.ndarray:
    """Places (mm, mm) to the right and up in a picture of the solid of points (x, y, z), mm."""
    about, up = np.radians([35.0, 28.0])
    right = np.array([np.cos(about), np.sin(about), 0.0])
    above = np.array([-np.sin(about) * np.sin(up), np.cos(about) * np.sin(up), np.cos(up)])
    return np.stack([points @ right, points @ above], axis=-1)


class SolidPicture:
    """Where the points of a box x, y, z (low, high) in mm lie in a picture of the solid, found by the box's outline."""

    def __init__(self, image, frame, box):
        self.image = image
        left, low, right, high = (int(each) for each in frame.box)
        self.corners = projected(np.stack(np.meshgrid(*box), axis=-1).reshape(-1, 3))
        top = len(image) - high
        drawn = ink(image[top : len(image) - low, left:right])
        drawn[-len(drawn) // 5 :, : drawn.shape[1] // 5] = False  # the three axes in the corner
        self.extent = [(np.flatnonzero(drawn.any(axis=k))[[0, -1]] + [0, 1]) + o for k, o in ((0, left), (1, top))]
        self.scale = np.ptp(self.extent[0]) / np.ptp(self.corners[:, 0])

    @property
    def height(self) -> tuple[float, float]:
        """Height of the outline in pixels: drawn, and of the box."""
        return float(np.ptp(self.extent[1])), float(self.scale * np.ptp(self.corners[:, 1]))

    def colours(self, points) -> np.ndarray:
        """The pixels at points (..., 3) in mm."""
        across, up = np.moveaxis(projected(np.asarray(points)), -1, 0)
        columns = self.extent[0][0] + (across - self.corners[:, 0].min()) * self.scale
        rows = self.extent[1][1] - (up - self.corners[:, 1].min()) * self.scale
        return self.image[rows.astype(int), columns.astype(int)]
