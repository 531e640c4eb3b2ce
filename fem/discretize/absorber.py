"""The absorbing bottom: elements below the solid in which waves decay.

Where every bulk wave carries its energy to the side in depth to which its phase goes, a perfectly matched layer: the
depth is continued into the complex plane (complex coordinate stretching; Berenger 1994).  In other cuts such a layer
makes some waves grow (Becache, Fauqueux and Joly 2003); there an absorbing (viscous) layer of increasing loss takes its
place.
"""

import numpy as np

from fem.materials.christoffel import stretch_absorbs
from fem.materials.medium import Medium, damped

# Perfectly matched layer from above: height of an element in wavelengths and its complex stretching factor, close to 1
# where waves arrive and large where only the static field is left.  The motion errs by 4e-6 or less on PZT-8, LiNbO3 YZ
# and ST-X quartz.
MATCHED_LAYER = ((0.5, 1 - 1j), (0.5, 1.5 - 2j), (0.5, 4 - 4j), (0.5, 12 - 8j), (0.5, 60 - 20j))


# Loss factor of the lowest element of a viscous layer, and the power of the depth by which it grows.  With 8 elements
# the motion on 128YX LiNbO3 errs by 2e-4; a square law gives 8e-4, a fourth power and a loss of 4 give 6e-4.
MAX_LOSS, LOSS_POWER = 0.6, 3


def absorber(solid, body: Medium, count: int) -> list[tuple[float, complex, Medium]]:
    """Elements below the solid from the bottom up: height, complex stretching factor, medium."""
    if stretch_absorbs(solid):
        return [(height, stretch, body) for height, stretch in MATCHED_LAYER[::-1]]
    losses = MAX_LOSS * ((np.arange(count) + 0.5) / count) ** LOSS_POWER
    return [(1.0, 1.0, damped(body, 1 - 1j * loss)) for loss in losses[::-1]]
