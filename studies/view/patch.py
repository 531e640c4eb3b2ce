"""A piece of the section as it is drawn: which points, how they move, how they are coloured at an instant.

Points are nodes of the field.  Those that lie nearer to the one before than the spacing asked for (half a pixel of the
picture) are passed over; where the nodes are far apart the modes and the elements' polynomials give points between
them.  Nothing is averaged.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from studies.view.run_field import LINES
from studies.view.shading import Shade

__all__ = ["Patch", "patch", "thinned"]

FACET = 6.0  # spacings: half pixels, so three pixels


@dataclass(frozen=True, kw_only=True)
class Patch:
    """Nodes of a piece of the section; n lines of m nodes.

    Attributes
    ----------
    x, z : ndarray, shapes (n,) and (m,)
        m.
    displacement : ndarray, shape (n, m, 2)
        Complex u_x and u_z, m per V.
    mean, amplitude : ndarray, shape (n, m)
        Of the shade, in its unit.
    turns : int
        Frequency of the amplitude over the wave's.
    """

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray = field(repr=False)
    mean: np.ndarray = field(repr=False)
    amplitude: np.ndarray = field(repr=False)
    turns: int

    def places(self, phase: float, factor: float) -> np.ndarray:
        """Return the nodes' x and z in m with the displacement enlarged, shape (n, m, 2)."""
        moved = factor * (self.displacement * np.exp(1j * phase)).real
        moved[..., 0] += self.x[:, None]
        moved[..., 1] += self.z
        return moved

    def values(self, phase: float) -> np.ndarray:
        """Return the coloured quantity at an instant, shape (n, m)."""
        return self.mean + (self.amplitude * np.exp(1j * self.turns * phase)).real

    @property
    def triangles(self) -> np.ndarray:
        """Corners of two triangles to each quadrilateral of neighbours, shape (2 (n - 1) (m - 1), 3)."""
        rows = len(self.z)
        corner = (np.arange(len(self.x) - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
        one = np.stack([corner, corner + rows, corner + rows + 1], axis=1)
        other = np.stack([corner, corner + rows + 1, corner + 1], axis=1)
        return np.concatenate([one, other])


def patch(found, shade: Shade, *, span: tuple[float, float], bottom: float, spacing: float) -> Patch:
    """Return the piece of a run's field between two places and down to a depth.

    Parameters
    ----------
    found : studies.view.run_field.RunField
    shade : Shade
        Of the same run.
    span : tuple of float
        m.
    bottom : float
        z, m.
    spacing : float
        Smallest distance of neighbours, m; the largest is about ``FACET`` times as much.
    """
    energies = shade.quantity.turns == 2
    facet = FACET * spacing
    if facet < found.wavelength / LINES:
        field = found.compute(span=span, per_wavelength=found.wavelength / facet, energies=energies)
    else:
        field = found.whole(energies=energies)
    lines = thinned(field.x, spacing, *span)
    z = _heights(field.z, spacing, max(bottom, field.z[0]), facet)
    basis = field.depth_basis(z)

    def at(values):
        return np.einsum("kj,xj...->xk...", basis, values[lines])

    mean, amplitude = shade.parts(field)
    return Patch(
        x=field.x[lines],
        z=z,
        displacement=at(field.displacement[..., [0, 2]]),
        mean=at(mean),
        amplitude=at(amplitude),
        turns=shade.quantity.turns,
    )


def _heights(nodes: np.ndarray, spacing: float, bottom: float, facet: float) -> np.ndarray:
    """Nodes through the depth from the bottom of the piece up, thinned, and points between those that are far apart."""
    ends = np.append(bottom, nodes[nodes > bottom])
    ends = ends[thinned(ends, spacing, bottom, 0.0)]
    parts = [
        np.linspace(low, high, max(int(np.ceil((high - low) / facet)), 1), endpoint=False)
        for low, high in pairwise(ends)
    ]
    return np.append(np.concatenate(parts), 0.0)


def thinned(places: np.ndarray, spacing: float, start: float, stop: float) -> np.ndarray:
    """Return the numbers of increasing places between two limits, each at least a spacing after the one before.

    The first and the last within the limits are always among them.

    Examples
    --------
    >>> thinned(np.array([0.0, 0.1, 0.2, 1.0, 2.0, 3.0]), 0.15, 0.0, 2.0)
    array([0, 2, 3, 4])
    """
    inside = np.flatnonzero((places >= start) & (places <= stop)).tolist()
    kept = inside[:1]
    for number in inside[1:]:
        if places[number] - places[kept[-1]] >= spacing:
            kept.append(number)
    if kept[-1] != inside[-1]:
        # the end is kept: its neighbour gives way
        kept[max(len(kept) - 1, 1) :] = inside[-1:]
    return np.array(kept)
