r"""Radau's collocation on a step of time, with maps that remove square roots at its ends.

A step of phase, H, is mapped from 0 <= s <= 1 by one of four maps. Near the instant at which a sphere touches, opens
or begins to slip its force has a term (phase - phase_0)^(3/2), which is smooth in s:

    LINEAR   phi = H s            BEGIN   phi = H s^2            END   phi = H (1 - (1 - s)^2)
    BOTH     phi = H s^2 (3 - 2 s)

Radau's rule has the end of the step among its nodes, is stable for stiff equations and has the order 2 n - 1
(Hairer and Wanner, *Solving Ordinary Differential Equations II*, section IV.5).
"""

from enum import IntEnum
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre


class Map(IntEnum):
    """Map of a step."""

    LINEAR = 0
    BEGIN = 1
    END = 2
    BOTH = 3


class Nodes(NamedTuple):
    """A Radau rule with n nodes; arrays."""

    phase: np.ndarray  # (4, n): phase of the nodes over H, by `Map`
    rate: np.ndarray  # (4, n): its derivative in s
    integral: np.ndarray  # (n, n): integrals from 0 to each node of the polynomial through the nodes
    speed: np.ndarray  # (4, n, n): integrals over the phase from the start to each node, over H
    way: np.ndarray  # (4, n, n): the same twice, over H^2
    weight: np.ndarray  # (n,): weights of the integral over the step
    difference: np.ndarray  # (n,): those of the rule less those of the rule without one of its nodes
    slope: np.ndarray  # (4, n): weights of the derivative in phase, times H, at the end of the step
    power: np.ndarray  # (n, n): coefficients of s, s^2, ... of the integral from 0 of each node's polynomial


@cache
def radau(n: int) -> Nodes:
    """Return the rule with n nodes."""
    polynomial = Legendre.basis(n) - Legendre.basis(n - 1)  # its roots in [-1, 1) and +1 are the nodes, mirrored
    x = np.sort(polynomial.roots().real)
    for _ in range(3):
        x = x - polynomial(x) / polynomial.deriv()(x)
    x[-1] = 1.0
    s = 0.5 * (x + 1.0)
    integral, weight = _integrals(s)
    middle = np.delete(np.arange(n), n // 2)
    difference = weight.copy()
    difference[middle] -= _integrals(s[middle])[1]
    phase = np.array([s, s**2, 1.0 - (1.0 - s) ** 2, s**2 * (3.0 - 2.0 * s)])
    rate = np.array([np.ones(n), 2.0 * s, 2.0 * (1.0 - s), 6.0 * s * (1.0 - s)])
    slope = np.array([_slope_at_end(each) for each in phase])
    own = [Polynomial.fromroots(np.delete(s, k)) for k in range(n)]
    power = np.array([(each / each(at)).integ().coef[1:] for each, at in zip(own, s, strict=True)])
    speed = integral * rate[:, None, :]
    way = (speed[:, :, :, None] * speed[:, None]).sum(axis=2)
    return Nodes(phase, rate, integral, speed, way, weight, difference, slope, power)


def _integrals(s):
    """Return the integrals of the polynomial through nodes s from 0 to each, and to 1."""
    node, weight = np.polynomial.legendre.leggauss(len(s))
    unit = _basis(s)
    ends = np.append(s, 1.0)
    rows = np.array([0.5 * end * (weight[:, None] * unit(0.5 * end * (node + 1.0))).sum(axis=0) for end in ends])
    return rows[:-1].copy(), rows[-1].copy()


def _basis(s):
    """Return the function that gives Lagrange's polynomials of nodes s at points, (points, n).

    By their products: scipy's barycentric interpolator takes the nodes in an order that it draws, so that its last
    digits differ from process to process, and sums of a library of linear algebra depend on where an array lies.
    """

    def at(points):
        columns = [np.prod((points[:, None] - np.delete(s, k)) / (each - np.delete(s, k)), axis=1)
                   for k, each in enumerate(s)]  # fmt: skip
        return np.stack(columns, axis=1)

    return at


def _slope_at_end(phase):
    """Return the weights of the derivative of the polynomial through values at phases, at the last of them."""
    n, at = len(phase), phase[-1]
    row = np.empty(n)
    for k in range(n):
        roots = np.delete(phase, k)
        basis = Polynomial.fromroots(roots)
        row[k] = basis.deriv()(at) / basis(phase[k])
    return row
