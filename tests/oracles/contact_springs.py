r"""Independent oracle for the hysteretic law and punches: every contact is a row of springs, followed in small steps.

Method of dimensionality reduction (Popov and Hess, *Method of Dimensionality Reduction in Contact Mechanics and
Friction*, 2015, ch. 5): springs at s on -a..a under the profile s^2/R (sphere) or 0 (punch), each with normal
stiffness E ds, tangential stiffness 4 G ds and the friction limit mu times its own normal force. The slider on its
contacts is moved by velocity Verlet in SI units, its dampers by the trapezoidal rule. Nothing is shared with the
product: no events, no memory of turning points, no scaling.

Errors: of the springs' sums order 1.5 to 2 in their number (the edge of the contact falls between two springs), of the
motion order 2 in the step.
"""

import math

import numpy as np
from numba import njit
from scipy.optimize import brentq


@njit(cache=True)
def _forces(z, before, dx, profile, width, stretched, E, G, mu):
    """Move every spring of one contact by dx while its approach changes to z; return (P, Q), change the elongations.

    A spring that touches on the way takes its share of dx.
    """
    P = Q = 0.0
    for j in range(profile.size):
        pressed = z - profile[j]
        if pressed <= 0.0:
            stretched[j] = 0.0
            continue
        limit = mu * E * pressed / (4.0 * G)
        share = 1.0 if before >= profile[j] else pressed / (z - before)
        stretched[j] = min(max(stretched[j] + share * dx, -limit), limit)
        # both halves of the row
        P += 2.0 * E * width * pressed
        Q += 2.0 * 4.0 * G * width * stretched[j]
    return P, Q


@njit(cache=True)
def _run(normal, tangential, heights, slider, profile, width, stretched, y, cycles, per_cycle, frequency):
    """Return (z_s, z_s', v) after a number of cycles; u = Re(amplitude exp(i omega t)) of each contact."""
    E, G, mu, mass, preload, load, normal_damping, tangential_damping, chi = slider
    h, omega = 1.0 / frequency / per_cycle, 2.0 * math.pi * frequency
    height, climb, speed = y
    approach = heights + normal.real - height
    push = pull = damping = 0.0
    for step in range(cycles * per_cycle + 1):
        turn, before = np.exp(1j * omega * h * step), np.exp(1j * omega * h * (step - 1))
        travel = 0.0
        if step > 0:
            climb += 0.5 * h * (push - damping * climb)
            speed += 0.5 * h * (pull - tangential_damping / mass * speed)
            height += h * climb
            travel = h * speed
        push, pull, damping = -preload, -load, normal_damping
        for i in range(normal.size):
            dx = (tangential[i] * (turn - before)).real - travel if step > 0 else 0.0
            z = heights[i] + (normal[i] * turn).real - height
            P, Q = _forces(z, approach[i], dx, profile, width, stretched[i], E, G, mu)
            approach[i] = z
            push += P * (1.0 + chi * (1j * omega * normal[i] * turn).real)
            damping += chi * P
            pull += Q
        push, pull, damping = push / mass, pull / mass, damping / mass
        if step > 0:
            climb = (climb + 0.5 * h * push) / (1.0 + 0.5 * h * damping)
            speed = (speed + 0.5 * h * pull) / (1.0 + 0.5 * h * tangential_damping / mass)
    return height, climb, speed


def rest_position(slider, heights) -> float:
    """Return z_s in m at which contacts of some heights carry the preload, by root finding on P."""
    R, E = slider["radius"], slider["E"]

    def excess(position):
        z = np.maximum(np.asarray(heights) - position, 0.0)
        P = 2.0 * R * E * z if slider.get("punch") else 4.0 / 3.0 * E * math.sqrt(R) * z**1.5
        return float(np.sum(P)) - slider["preload"]

    return brentq(excess, min(heights) - 1e-3, max(heights), xtol=1e-300, rtol=1e-15)


def sheared(slider, approaches, profile, width):
    """Return the elongations of the springs at rest that carry the load, by root finding on Q."""
    E, G, mu = slider["E"], slider["G"], slider["mu"]
    limits = mu * E / (4.0 * G) * np.maximum(np.asarray(approaches)[:, None] - profile, 0.0)
    if slider["load"] == 0.0:
        return 0.0 * limits

    def excess(x):
        return 2.0 * 4.0 * G * width * float(np.sum(np.clip(x, -limits, limits))) - slider["load"]

    end = float(np.max(limits))
    return np.clip(brentq(excess, -end, end, xtol=1e-300, rtol=1e-15), -limits, limits)


def velocity_from_rest(normal, tangential, frequency, *, cycles, per_cycle, springs, slider, heights=None) -> float:
    """Return the slider's velocity in m/s some cycles after rest, where the contacts carry the load.

    Parameters
    ----------
    normal, tangential : sequences of complex
        Amplitude of each contact's surface, m: u = Re(amplitude exp(i omega t)).
    frequency : float
        Hz.
    cycles, per_cycle, springs : int
        Cycles, steps per cycle, springs on half of each row.
    slider : dict
        radius (m), E, G (Pa), mu, mass (kg), preload, load (N), normal_damping, tangential_damping (N s/m), chi (s/m);
        punch (bool, default False): flat punches of this radius instead of spheres.
    heights : sequence of float, optional
        How much further each contact stands out, m.
    """
    names = ("E", "G", "mu", "mass", "preload", "load", "normal_damping", "tangential_damping", "chi")
    values = tuple(float(slider[name]) for name in names)
    normal, tangential = np.asarray(normal, complex), np.asarray(tangential, complex)
    heights = np.zeros(normal.size) if heights is None else np.asarray(heights, float)
    rest = rest_position(slider, heights)
    deepest = float(np.max(heights)) - rest + np.max(np.abs(normal))
    profile, width = row(slider["radius"], 2.0 * deepest, springs, slider.get("punch", False))
    stretched = sheared(slider, heights - rest, profile, width)
    begin = (rest, 0.0, 0.0)
    y = _run(normal, tangential, heights, values, profile, width, stretched, begin, cycles, per_cycle, frequency)
    return y[2]


def row(radius, deepest, springs, punch):
    """Return (height of the profile at each spring of half a row, distance of the springs), m."""
    width = (radius if punch else math.sqrt(radius * deepest)) / springs
    sites = (np.arange(springs) + 0.5) * width
    return (0.0 * sites if punch else sites**2 / radius), width


def force_on_path(z, x, *, radius, E, G, mu, springs, punch=False) -> np.ndarray:
    """Return (P, Q) of one contact led along points (z, x), pressed on first: a (k, 2) array, N."""
    profile, width = row(radius, float(np.max(z)), springs, punch)
    stretched = np.zeros(springs)
    z, steps = np.asarray(z, float), np.diff(np.asarray(x, float), prepend=0.0)
    before = np.concatenate([z[:1], z[:-1]])
    lines = zip(z, before, steps, strict=True)
    return np.array([_forces(*line, profile, width, stretched, E, G, mu) for line in lines])
