r"""How the contacts move: approach and slip rate of each from the surface's motion, the slider's, and its own height.

Contact i has the height h_i (positive: nearer to the surface) and meets a harmonic surface motion of its own,

    z_i = h_i + u_z,i - z_s,   z_i' = u_z,i' - z_s',   x_i' = u_x,i' - v while it sticks,   u = a cos phi + b sin phi.

Slip of sign s goes on while s x' - c z' > 0 (Feenstra and Breedveld, eq. 3, with the sign that the paper leaves out).
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import formula


class Paths(NamedTuple):
    """Motion of the surface under each contact, and the contact's own height; arrays (n,)."""

    height: np.ndarray  # h, added to the approach
    # a and b of u_z, then of u_x
    normal_cos: np.ndarray
    normal_sin: np.ndarray
    tangential_cos: np.ndarray
    tangential_sin: np.ndarray


class Point(NamedTuple):
    """One contact at an instant: approach z, deformation x, and their rates z' and x' while it sticks."""

    approach: float
    deformation: float
    approach_rate: float
    deformation_rate: float


@formula
def normal_amplitude(paths, i):
    """Return |u_z| of a contact."""
    return np.hypot(paths.normal_cos[i], paths.normal_sin[i])


@formula
def tangential_amplitude(paths, i):
    """Return |u_x| of a contact."""
    return np.hypot(paths.tangential_cos[i], paths.tangential_sin[i])


@formula
def at_phase(paths, i, cos, sin):
    """Return (u_z, u_z', u_x, u_x') at the phase with this cosine and sine; u_z without the contact's height."""
    a, b, d, e = paths.normal_cos[i], paths.normal_sin[i], paths.tangential_cos[i], paths.tangential_sin[i]
    return a * cos + b * sin, b * cos - a * sin, d * cos + e * sin, e * cos - d * sin


@formula
def slip_speed(sign, z_rate, x_rate, c):
    """Return the speed of slip of a sign at the slip limit; negative where the contact sticks."""
    return sign * x_rate - c * z_rate


@formula
def of_run(paths, k):
    """Return the paths of run k of several, whose arrays are (runs, n)."""
    return Paths(
        paths.height[k], paths.normal_cos[k], paths.normal_sin[k], paths.tangential_cos[k], paths.tangential_sin[k]
    )  # fmt: skip
