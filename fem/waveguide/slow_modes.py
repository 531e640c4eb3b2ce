"""Slowly decaying static modes of a plate under vacuum, to more digits than one eigensolve of the section gives.

The column of vacuum above a plate is up to 1e6 wavelengths high (`fem.discretize.vacuum`), and its modes decay as
slowly.  The eigensolver gives all k^2 with one absolute error, which then exceeds the smallest.  The space that it
finds for slow modes is right, however.  On that space the problem

    (k^2 A + k B + C) v = 0,    A = K2, B = i (K1 - K1t), C = K0 - omega^2 M,

is solved again, as the pencil [C 0; 0 -A] x = k [-B -A; -A 0] x with x = (v, k v), whose left eigenvector is made of
the mode w of the opposite wavenumber, (w, k w).  Two things keep the digits: a slow mode is nearly a constant potential
c, and C c = 0, so that C is applied to v less the constant that v is at the surface; and its flux of D vanishes,
c^T (k A + B) v = 0, from which the share of c in v follows.
"""

import numpy as np

STATIC = 0.1  # |k| below which modes are computed again, radians per length unit
PASSES = 3  # the first time the shapes are mixtures of slow modes, whose flux is not that of a wavenumber


def refined_slow_modes(
    modes: tuple[np.ndarray, np.ndarray],
    opposite: tuple[np.ndarray, np.ndarray],
    matrices: tuple[np.ndarray, np.ndarray, np.ndarray],
    constant: np.ndarray | None,
    surface: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Wavenumbers and shapes of the slow modes of both directions, and the numbers of those that they replace.

    Parameters
    ----------
    modes, opposite : tuple of ndarray
        k (n,) and shapes (n, n) of all modes to the right, and of those to the left whose k are nearly opposite.
    matrices : tuple of ndarray
        A, B and C, (n, n) each.
    constant : ndarray or None
        The unit shape of the constant potential if it floats.
    surface : int
        Unknown of the potential at the surface.

    Returns
    -------
    tuple or None
        k (2 m,), unit shapes (n, 2 m) and numbers (m,); None where no mode is slow.
    """
    slow = np.flatnonzero((abs(modes[0]) < STATIC) & (modes[0] != 0))
    if not len(slow):
        return None
    k = np.concatenate([modes[0][slow], opposite[0][slow]])
    shapes = np.hstack([modes[1][:, slow], opposite[1][:, slow]])
    for _ in range(PASSES):
        k, shapes = _solved_again(k, shapes, matrices, constant, surface)
    _, shapes = _without_flux(k, shapes, matrices, constant, surface)
    return k, shapes / np.linalg.norm(shapes, axis=0), slow


def _solved_again(k, shapes, matrices, constant, surface):
    """Eigenpairs of the pencil on the space of modes to the right and their partners to the left, in equal halves."""
    second, skew, zeroth = matrices
    bent, shapes = _without_flux(k, shapes, matrices, constant, surface)
    partners = np.roll(np.arange(len(k)), len(k) // 2)
    along, across = (shapes[:, partners].T @ each @ shapes for each in (second, skew))
    left = bent[:, partners].T @ zeroth @ bent - k[:, None] * along * k
    right = -across - along * k - k[:, None] * along
    scale = 1 / np.sqrt(np.diag(right))
    found, mixed = np.linalg.eig(np.linalg.solve(scale[:, None] * right * scale, scale[:, None] * left * scale))
    shapes = shapes @ (scale[:, None] * mixed)
    shapes = shapes / np.linalg.norm(shapes, axis=0)
    pairs = _opposite_pairs(found)
    return found[pairs], shapes[:, pairs]


def _without_flux(k, shapes, matrices, constant, surface):
    """Shapes less the constant that they are at the surface, and the shapes with the constant that ends their flux."""
    if constant is None:
        return shapes, shapes
    second, skew, _ = matrices
    bent = shapes - np.outer(constant, shapes[surface] / constant[surface])
    flux = k * ((constant @ second) @ bent) + (constant @ skew) @ bent
    return bent, bent - np.outer(constant, flux / (k * (constant @ second @ constant)))


def _opposite_pairs(k):
    """Numbers of wavenumbers such that those of the second half are most nearly opposite to those of the first."""
    first, second, free = [], [], list(np.argsort(abs(k)))
    while free:
        one = free.pop(0)
        other = min(free, key=lambda each: abs(k[each] + k[one]))
        free.remove(other)
        first.append(one)
        second.append(other)
    return np.array(first + second)
