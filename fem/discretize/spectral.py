"""Spectral elements on a line: Gauss-Lobatto-Legendre nodes and the exact 1-D matrices.

A layer homogeneous in x and z on a tensor grid needs no two-dimensional quadrature: every element matrix is a
sum of Kronecker products of the mass, stiffness and advection matrices of a line (Patera 1984; Deville, Fischer
and Mund, *High-Order Methods for Incompressible Fluid Flow*, 2002, section 4.5).  Nodal basis on GLL points,
integrals by a Gauss rule that is exact for them.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre


@lru_cache(maxsize=32)
def gll_nodes(order: int) -> np.ndarray:
    """Gauss-Lobatto-Legendre points of an element in [0, 1], ends included, increasing: shape (order + 1,)."""
    if order < 1:
        raise ValueError(f"order must be an integer of at least 1, got {order}")
    coefficients = np.zeros(order + 1)
    coefficients[order] = 1.0
    derivative = legendre.legder(coefficients)
    inner = np.sort(legendre.legroots(derivative).real)
    second = legendre.legder(derivative)
    for _ in range(3):
        inner = inner - legendre.legval(inner, derivative) / legendre.legval(inner, second)
    inner = 0.5 * (inner - inner[::-1])
    return _frozen((np.concatenate([[-1.0], inner, [1.0]]) + 1.0) / 2.0)


def lagrange_values(order: int, points: np.ndarray) -> np.ndarray:
    """Values of the nodal basis at points (m,) of the element [0, 1], shape (m, order + 1)."""
    vandermonde = legendre.legvander(2.0 * gll_nodes(order) - 1.0, order)
    at = legendre.legvander(2.0 * np.asarray(points, dtype=float) - 1.0, order)
    return np.linalg.solve(vandermonde.T, at.T).T


def lagrange(order: int, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives of the nodal basis at points (m,) of the element [0, 1], shape (m, order + 1) each."""
    vandermonde = legendre.legvander(2.0 * gll_nodes(order) - 1.0, order)
    at = 2.0 * np.asarray(points, dtype=float) - 1.0
    values = lagrange_values(order, points)
    slopes = np.stack([legendre.legval(at, legendre.legder(np.eye(order + 1)[k])) for k in range(order + 1)], axis=1)
    return values, 2.0 * np.linalg.solve(vandermonde.T, slopes.T).T


def chebyshev_nodes(low: float, high: float, count: int) -> np.ndarray:
    """Chebyshev nodes of an interval, from high to low, shape (count,)."""
    return (low + high) / 2 + (high - low) / 2 * np.cos(np.pi * (np.arange(count) + 0.5) / count)


def lagrange_weights(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of the values at distinct nodes in the polynomial's value at a position."""
    return np.array(
        [np.prod((at - np.delete(nodes, k)) / (node - np.delete(nodes, k))) for k, node in enumerate(nodes)]
    )


@dataclass(frozen=True, kw_only=True)
class LineMatrices:
    """Matrices of the reference element [0, 1], each of shape (order + 1, order + 1)."""

    mass: np.ndarray  # int N_i N_j; times h for an element of length h
    stiffness: np.ndarray  # int N_i' N_j'; over h
    advection: np.ndarray  # int N_i' N_j


@lru_cache(maxsize=32)
def reference_matrices(order: int) -> LineMatrices:
    """Exact matrices of one reference element of an order."""
    points, weights = legendre.leggauss(order + 1)
    values, slopes = lagrange(order, (points + 1.0) / 2.0)
    weights = weights / 2.0
    return LineMatrices(
        mass=_frozen(np.einsum("q,qi,qj->ij", weights, values, values)),
        stiffness=_frozen(np.einsum("q,qi,qj->ij", weights, slopes, slopes)),
        advection=_frozen(np.einsum("q,qi,qj->ij", weights, slopes, values)),
    )


def line_nodes(breakpoints: np.ndarray, order: int) -> np.ndarray:
    """Nodes of a line of elements, shared ones once: shape (elements * order + 1,), the breakpoints' unit."""
    breakpoints = np.asarray(breakpoints)
    nodes = breakpoints[:-1, None] + np.diff(breakpoints)[:, None] * gll_nodes(order)[None, :-1]
    return np.append(nodes.ravel(), breakpoints[-1])


def _frozen(array: np.ndarray) -> np.ndarray:
    """Make a cached array read-only, because its users share it."""
    array.flags.writeable = False
    return array
