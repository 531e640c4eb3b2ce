r"""The slider as a rigid body on the wave: generalised coordinates, and the approach and travel of its contacts.

The slider has the coordinates q = (z_s, travel): its height above the surface at rest and its way along the wave.
Contact i has the height h_i (positive: nearer to the surface) and meets a harmonic surface motion of its own,

    approach  z_i = u_z,i + h_i - z_s,      z_i' = u_z,i' - z_s',
    travel    x_i = u_x,i - travel,         x_i' = u_x,i' - v     while it sticks,     u = a cos phi + b sin phi,

and the body has the forces of its own -d_n z_s' - p and -d_t v - q. Every solver takes approach, travel and these
forces from here. A slider that tilts (many contacts, averaged motion) has coordinates of its own at each position,
z_s - theta x - psi y (`tilted`).
Slip of sign s goes on while s x' - c z' > 0 (Feenstra and Breedveld, eq. 3, with the sign that the paper leaves out).
"""

from typing import NamedTuple

import numpy as np

from contact.codes import SlipWindow
from contact.jit.compiled import compiled, formula


class Paths(NamedTuple):
    """Motion of the surface under each contact, and the contact's own height; arrays (n,)."""

    height: np.ndarray  # h, added to the approach
    # a and b of u_z, then of u_x
    normal_cos: np.ndarray
    normal_sin: np.ndarray
    tangential_cos: np.ndarray
    tangential_sin: np.ndarray


class Coordinates(NamedTuple):
    """Generalised coordinates of the slider, or their rates."""

    normal: float  # z_s, out of the surface
    along: float  # along the wave


class Point(NamedTuple):
    """One contact at an instant: approach z, deformation x, and their rates z' and x' while it sticks."""

    approach: float
    deformation: float
    approach_rate: float
    deformation_rate: float


@formula
def approach(paths, i, u_z, q):
    """Return the approach of contact i above a surface displaced by u_z."""
    return u_z + paths.height[i] - q.normal


def tilted(q, pitch, roll, x, y):
    """Return the coordinates at (x, y) from a tilted slider's centre; positive tilts, rad: approach grows with x, y."""
    return Coordinates(q.normal - pitch * x - roll * y, q.along)


def height_under(means, load, height, close):
    """Return the mean approach at which contacts carry a load, by Newton's method.

    It converges from any approach that is too large, because the forces are convex in it. Load and approach may be
    arrays.

    Parameters
    ----------
    means : callable
        Takes an approach and returns the force and its derivative.
    load, height : float or ndarray
        The load and an approach that is too large or right.
    close : float
        Largest step at which the search ends.
    """
    for _ in range(100):
        force, rate = means(height)
        step = (force - load) / rate
        height = height - step
        if np.max(np.abs(step)) < close:
            break
    return height


@formula
def approach_rate(u_z_rate, rate):
    """Return the rate of an approach; `rate` that of the coordinates."""
    return u_z_rate - rate.normal


@formula
def travel(u_x, q):
    """Return how far the surface has moved along past a contact; of rates the rate."""
    return u_x - q.along


@formula
def damping_force(problem, rate):
    """Return the generalised forces of the slider's own dampers."""
    return Coordinates(-problem.normal_damping * rate.normal, -problem.tangential_damping * rate.along)


@formula
def body_force(problem, rate):
    """Return the generalised forces on the slider besides its contacts': dampers, preload and load."""
    damping = damping_force(problem, rate)
    return Coordinates(damping.normal - problem.preload, damping.along - problem.load)


@formula
def harmonic_response(n, damping):
    """Return the amplitude of the slider's motion over that of the force, both in the nth harmonic of the wave."""
    return 1.0 / (n * (1j * damping - n))


@formula
def contact_force(problem, elastic, approach_rate):
    """Return the normal force of a contact with its damper, of the elastic one."""
    return elastic * (1.0 + problem.contact_damping * approach_rate)


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
    """Return (u_z, u_z', u_x, u_x') at the phase with this cosine and sine."""
    a, b, d, e = paths.normal_cos[i], paths.normal_sin[i], paths.tangential_cos[i], paths.tangential_sin[i]
    return a * cos + b * sin, b * cos - a * sin, d * cos + e * sin, e * cos - d * sin


@formula
def slip_speed(sign, z_rate, x_rate, c):
    """Return the speed of slip of a sign at the slip limit; negative where the contact sticks."""
    return sign * x_rate - c * z_rate


@compiled
def slip_window(sign, a, b, d, e, v, c):
    """Return (start, end, kind) of the phases at which a contact at its limit slips towards a side, `codes.SlipWindow`.

    Of u_z = a cos phi + b sin phi, u_x = d cos phi + e sin phi and a slider's velocity v, `slip_speed` is
    across cos phi + along sin phi - sign v.
    """
    across, along = sign * e - c * b, c * a - sign * d
    size = np.hypot(across, along)
    if sign * v >= size:
        return 0.0, 0.0, SlipWindow.NEVER
    if sign * v <= -size:
        return 0.0, 0.0, SlipWindow.ALWAYS
    centre, half = np.arctan2(along, across), np.arccos(sign * v / size)
    return centre - half, centre + half, SlipWindow.WINDOW


@formula
def of_run(paths, k):
    """Return the paths of run k of several, whose arrays are (runs, n)."""
    return Paths(
        paths.height[k], paths.normal_cos[k], paths.normal_sin[k], paths.tangential_cos[k], paths.tangential_sin[k]
    )  # fmt: skip


@compiled
def short_sine(t):
    """Return sin t and 1 - cos t for |t| <= 0.8 by their series, to rounding."""
    y = t * t
    s, v = 1.0 - y * (1.0 / 272.0), 1.0 - y * (1.0 / 306.0)
    s, v = 1.0 - y * (1.0 / 210.0) * s, 1.0 - y * (1.0 / 240.0) * v
    s, v = 1.0 - y * (1.0 / 156.0) * s, 1.0 - y * (1.0 / 182.0) * v
    s, v = 1.0 - y * (1.0 / 110.0) * s, 1.0 - y * (1.0 / 132.0) * v
    s, v = 1.0 - y * (1.0 / 72.0) * s, 1.0 - y * (1.0 / 90.0) * v
    s, v = 1.0 - y * (1.0 / 42.0) * s, 1.0 - y * (1.0 / 56.0) * v
    s, v = 1.0 - y * (1.0 / 20.0) * s, 1.0 - y * (1.0 / 30.0) * v
    s, v = 1.0 - y * (1.0 / 6.0) * s, 1.0 - y * (1.0 / 12.0) * v
    return t * s, 0.5 * y * v


@compiled
def circle(phi):
    """Return cos phi and sin phi to rounding, without a branch: several at once in the processor's lanes."""
    turns = np.floor(phi * (2.0 / np.pi) + 0.5)
    s, v = short_sine((phi - turns * 1.5707963267341256) - turns * 6.077100506506192e-11)
    v = 1.0 - v
    # quarter turns: (c, s), (-s, c), (-c, -s), (s, -c)
    quarter = turns - 4.0 * np.floor(0.25 * turns)
    c, s = (s, v) if quarter == 1.0 or quarter == 3.0 else (v, s)
    return (-c if quarter == 1.0 or quarter == 2.0 else c), (-s if quarter >= 2.0 else s)
