"""The free wave of a section: velocity, ellipse and profile of its surface mode."""

from dataclasses import dataclass, field

import numpy as np

from fem.materials import Solid


@dataclass(frozen=True, kw_only=True)
class FreeWave:
    """Surface mode of a bare section.

    Attributes
    ----------
    frequency : float
        Hz.
    velocity : float
        m/s.
    attenuation : float
        Of the amplitude, 1/m.
    surface_ratio : float
        |u_x / u_z| at the surface.
    depth : ndarray, shape (nodes,)
        z of the profile's nodes in m, 0 at the surface.
    profile : ndarray, shape (nodes, 4)
        Complex u_x, u_y, u_z over u_z at the surface, and phi in V per m of u_z.
    order : int
        Polynomial order of the elements that the nodes belong to.
    solid : Solid
        The section's, in the frame of the cut.
    relative_error : float
        Of the velocity, from two orders.
    unknowns : int
    seconds : float
    """

    frequency: float
    velocity: float
    attenuation: float
    surface_ratio: float
    depth: np.ndarray = field(repr=False)
    profile: np.ndarray = field(repr=False)
    order: int
    solid: Solid = field(repr=False)
    relative_error: float
    unknowns: int
    seconds: float
