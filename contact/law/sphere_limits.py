"""Limits of the adhesion of a sphere: Tabor's number, which tells its model, and the amplitude of its first release."""

import math

import numpy as np

from contact.exceptions import InputError
from contact.roots import bracketed

DISTANCE = 0.3e-9  # m, between the surfaces in contact, of Tabor's number
NODES = 48  # of a mean over a cycle; the force is smooth there


def tabor_number(radius: float, modulus: float, work: float, separation: float = DISTANCE) -> float:
    """Return Tabor's number of a sphere of a radius in m with the modulus E in Pa and a work of adhesion in J/m^2.

    ``separation``: of the surfaces in equilibrium, m.

    Examples
    --------
    >>> round(tabor_number(1e-3, 64e9, 0.05), 2)
    2.83
    """
    return (radius * work**2 / (modulus**2 * separation**3)) ** (1.0 / 3.0)


def check_carried(force: float, pull_off: float) -> None:
    """Refuse a force in N below minus the pull-off force in N, which no contact carries."""
    if force < -pull_off:
        raise InputError("force", "must be at least minus the pull-off force", force, "N")


def first_release(ball, preload: float) -> float:
    """Return the normal amplitude in m of the wave on which a heavy slider's ball just ends its contact in the trough.

    The mean force over the wave's cycle is the preload in N.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    lift = 1.0 + np.cos(0.5 * math.pi * (1.0 + nodes))

    def left(amplitude):
        return 0.5 * float(weights @ ball.closed(ball.break_approach + amplitude * lift)[1]) - preload

    high = ball.approach_under(preload) - ball.break_approach
    while left(high) < 0.0:
        high *= 2.0
    return bracketed(left, 0.0, high, tolerance=1e-12 * high)
