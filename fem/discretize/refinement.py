"""Levels of discretisation, from coarse to fine, and by how much each divides the error."""

import numpy as np

from fem.discretize.section import Resolution
from fem.geometry import Stator
from fem.materials.christoffel import stretch_absorbs

# From coarse to fine: measured on the seed's stator (admittance and surface motion move together).
LEVELS = (
    Resolution(order=5, edge_layers=0, lossy_elements=5),
    Resolution(order=6, edge_layers=1, lossy_elements=6),
    Resolution(order=7, edge_layers=2, lossy_elements=8),
    Resolution(order=8, edge_layers=3, lossy_elements=10),
    Resolution(order=9, edge_layers=4, lossy_elements=12),
    Resolution(order=10, edge_layers=5, lossy_elements=14),
)


EXPECTED = (
    np.inf,
    5e-3,
    2e-4,
    2e-5,
    2e-6,
    3e-7,
)  # estimate at each level on an ordinary motor: where to begin


GAIN = 8.0  # a level divides the error by more: 6.7 per edge layer, and more by the order (11 to 25 seen)


LOSSY_GAIN = 1.5  # where a lossy layer stands for the half-space its thickness decides, squared


def level_gain(stator: Stator) -> float:
    """By how much a level divides the error, at least."""
    if stator.absorbs_below and not stretch_absorbs(stator.solid):
        return LOSSY_GAIN
    return GAIN


def first_level(tolerance: float) -> int:
    """Coarser of the two levels to begin with."""
    enough = [level for level, error in enumerate(EXPECTED) if error <= tolerance]
    return (enough[0] if enough else len(EXPECTED) - 1) - 1


def planned_levels(stator: Stator, tolerance: float) -> range:
    """Levels that an ordinary layout on this stator is solved at; where the estimate demands it one more follows."""
    first = first_level(tolerance)
    slower = (GAIN - 1) / (level_gain(stator) - 1)
    enough = [level for level, error in enumerate(EXPECTED) if error * slower <= tolerance]
    return range(first, max(first + 1, enough[0] if enough else len(LEVELS) - 1) + 1)
