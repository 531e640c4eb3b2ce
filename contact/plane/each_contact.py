"""Mean forces of each contact of a heavy slider as a function of the velocity of the contact itself.

The heights are those at which the slider stands on the waves (`heights`). A body that moves the contacts of one height
with other velocities finds its own balance from them.
"""

from typing import NamedTuple

import numpy as np

from contact.plane.averaged import SEARCH, Averaged
from contact.plane.disc_contacts import Sum
from contact.plane.plane_waves import SurfaceWaves
from contact.plane.rest import dragged_against
from contact.plane.scaling import refuse_slow_beat
from contact.plane.steady_state import refuse
from contact.slider import Slider


class ContactForces(NamedTuple):
    """Mean forces of n contacts at k velocities."""

    loads: np.ndarray  # (n,) N
    forces: np.ndarray  # (k, n, 2) N, on the slider
    repeats: np.ndarray  # (k,): True where the motion of every contact repeats within the periods that are followed


def contact_forces(slider: Slider, waves: SurfaceWaves, velocities, along=None) -> ContactForces:
    """Return the mean forces of each contact at each of several velocities in m/s, (k, 2) or of each contact (k, n, 2).

    A contact that never opens comes from a motion ``along`` a direction, by default that of its velocity. At rest its
    force is the end of the band of forces that friction can carry.

    Raises
    ------
    ConvergenceError
        "not applicable" on a slow beat, "not converged" where no height carries the preload.

    Examples
    --------
    >>> import math
    >>> slider = Slider(
    ...     radius=1e-3, mass=math.inf, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    ... )
    >>> waves = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-6.7e-9j, 0.0, 10e-9]]])
    >>> found = contact_forces(slider, waves, [(0.0, 0.0), (0.0683658806, 0.0)])
    >>> print((1e6 * found.forces[:, 0, 0]).round(3))  # uN; at the steady velocity there is none
    [69.167 -0.   ]
    """
    refuse(slider)
    refuse_slow_beat(slider, waves)
    averaged = Averaged.of(slider, waves)
    units, n = averaged.scaled, waves.count
    at, along = (_of_each(each, n) for each in (velocities, velocities if along is None else along))
    at = at / units.speed
    loads, forces, repeats = np.zeros(n), np.zeros((len(at), n, 2)), np.zeros(len(at), bool)
    for k, velocity in enumerate(at):
        averaged.deformation = dragged_against(along[k])
        contacts, repeats[k] = averaged.contact_means(velocity, SEARCH)
        loads, forces[k] = contacts[:, Sum.NORMAL], contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]]
    return ContactForces(loads * units.force, forces * units.force, repeats)


def _of_each(vectors, n: int) -> np.ndarray:
    """Return vectors (k, 2) or (k, n, 2) as those of each of n contacts, (k, n, 2)."""
    vectors = np.asarray(vectors, float)
    vectors = np.broadcast_to(vectors[:, None], (len(vectors), n, 2)) if vectors.ndim == 2 else vectors
    return np.ascontiguousarray(vectors)
