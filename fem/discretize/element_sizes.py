"""Element sizes: how finely a stator is discretised, and geometric layers towards singular points.

An hp mesh whose elements shrink by a fixed ratio towards a singularity converges exponentially in the number of
layers (Schwab, *p- and hp-Finite Element Methods*, 1998, chapter 4).  Singular are the charge at finger edges
(r^-1/2) and the stress where a clamped face meets a free one.  Lengths are in one unit, usually the wavelength of the
slowest bulk wave.
"""

from dataclasses import dataclass

import numpy as np

from fem.geometry import Stator

LAYER_RATIO = 0.15
# Where a clamped face meets a free one the displacement varies as r^0.6 to r^0.8 (Williams, J. Appl. Mech. 19 (1952)
# 526), so that a layer of this ratio divides the error as much as one of LAYER_RATIO does at a finger edge (r^0.5).
CORNER_RATIO = 0.2


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """How finely a stator is discretised.

    Attributes
    ----------
    order : int
        Polynomial order of every element.
    edge_layers : int
        Geometric layers towards finger edges and the surface, ratio 0.15 each.
    element_size : float
        Largest element in wavelengths of the slowest bulk wave.
    absorber : int
        Level of the absorbing layer (`fem.discretize.absorber.DEPTHS`) and of the height of the vacuum
        (`fem.discretize.vacuum`), from 0 to 5.
    vacuum : float
        Largest height of the vacuum in wavelengths.
    """

    order: int
    edge_layers: int
    element_size: float = 1.0
    absorber: int = 2
    vacuum: float = 2e5  # beyond it the eigenproblem has too few digits for slowly decaying fields

    @property
    def name(self) -> str:
        """Order and edge layers, as messages and results name them.

        Examples
        --------
        >>> Resolution(order=6, edge_layers=1).name
        'order 6, 1 edge layer'
        """
        return f"order {self.order}, {self.edge_layers} edge layer{'s' * (self.edge_layers != 1)}"


def graded(
    length: float, layers: int, *, largest: float, smallest_first: bool = False, ratio: float = LAYER_RATIO
) -> np.ndarray:
    """Element sizes that sum to a length: equal ones of at most ``largest``, the last split into geometric layers.

    The smallest last, or first on request.
    """
    count = max(1, int(np.ceil(length / largest - 1e-9)))
    sizes = [length / count] * (count - 1)
    rest = length / count
    for _ in range(layers):
        sizes.append(rest * (1 - ratio))
        rest *= ratio
    sizes.append(rest)
    return np.array(sizes[::-1] if smallest_first else sizes)


def bottom_corners(stator: Stator) -> bool:
    """True if a clamped face meets a free one at the lower corners, where the stress is then singular.

    At the upper corners of clamped ends the layers below the surface's finger edges do the same.
    """
    if stator.absorbs_below or stator.ends == "absorbing":
        return False
    return (stator.ends == "clamped") != (stator.bottom == "clamped")


def edge_layers(resolution: Resolution, length: float, smallest: float) -> int:
    """Layers for a length so that its last element is as fine as those of the smallest length beside it."""
    more = np.log(length / smallest) / np.log(1 / LAYER_RATIO)
    return resolution.edge_layers + (max(0, int(np.ceil(more - 0.5))) if resolution.edge_layers else 0)
