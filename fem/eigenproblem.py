"""Quadratic eigenvalue problem of the guided modes: all wavenumbers, slow and strongly evanescent ones alike.

The arguments are the matrices of section.py, (n, n) each: ``second`` is K2, ``zeroth`` K0 - omega^2 M, and ``skew``
K1 - K1t, times i where the problem has no factor i.

Elements of a thousandth of a wavelength at the fingers' edges stand beside elements stretched a thousandfold in an
absorbing layer.  The problem is solved in scaled unknowns; unscaled, the slow modes of such a section lose five digits.
For the problem that is linear in k^2 the diagonal of K2 is scaled to 1; for the one that is linear in k its entries
above the median are scaled to the median.
"""

import numpy as np

COMPANION_SHIFT = 2 * np.pi * (0.31 + 0.57j)  # away from all wavenumbers of a body with little loss
WIDE_SPECTRUM = 1e7  # largest over typical eigenvalue above which one eigensolve cannot serve both ends


def even_odd_modes(second, skew, zeroth, odd):
    """Eigenpairs (k, v) of k^2 second + i k skew + zeroth, one of each pair k, -k, where x -> -x is a symmetry.

    ``skew`` couples only odd unknowns with even ones; with u_o = -i k w for the odd ones the problem is linear in k^2.
    """
    scale = 1 / np.sqrt(abs(np.diag(second)))
    second, skew, zeroth = (scale[:, None] * each * scale for each in (second, skew, zeroth))
    even = ~odd
    odds, size = int(odd.sum()), len(odd)
    dtype = np.result_type(second, skew, zeroth)
    left = np.zeros((size, size), dtype=dtype)
    left[:odds, :odds] = second[np.ix_(odd, odd)]
    left[odds:, odds:] = second[np.ix_(even, even)]
    left[odds:, :odds] = skew[np.ix_(even, odd)]
    right = np.zeros((size, size), dtype=dtype)
    right[:odds, :odds] = -zeroth[np.ix_(odd, odd)]
    right[:odds, odds:] = skew[np.ix_(odd, even)]
    right[odds:, odds:] = -zeroth[np.ix_(even, even)]
    squares, vectors = _graded_eigenpairs(left, right, (2 * np.pi) ** 2 * (-0.3 + 0.9j))
    wavenumbers = np.sqrt(squares.astype(complex))
    shapes = np.empty((size, size), dtype=complex)
    shapes[odd] = -1j * wavenumbers * vectors[:odds]
    shapes[even] = vectors[odds:]
    return wavenumbers, scale[:, None] * shapes


def opposite_modes(second, skew, zeroth):
    """Eigenpairs (k, v), then all (-k, w), of k^2 second + k skew + zeroth: symmetric matrices, antisymmetric skew.

    With p = k second v + skew v / 2 the problem is H (v, p) = k (v, p), H a Hamiltonian matrix, H^T J = -J H with
    J = [[0, 1], [-1, 0]].  All eigenvalues of W = (H - s)^-1 (H + s)^-1, 1 / (k^2 - s^2), are double and W^T J = J W: a
    Krylov space of W that is kept orthogonal to J times its conjugate holds one vector of each pair, so that a matrix
    of the size n is left of one of 2 n (Mehrmann and Watkins, SIAM J. Sci. Comput. 22 (2001) 1905).
    """
    size, shift = len(second), COMPANION_SHIFT
    inverse = np.linalg.inv(shift**2 * second + shift * skew + zeroth)

    def resolvent(inverse, at):
        """(H - at)^-1."""
        half = skew / 2 + at * second
        product = inverse @ half
        return np.block([[-product, -inverse], [second - half @ product, -half @ inverse]])

    operator = resolvent(inverse, shift) @ resolvent(inverse.T, -shift)
    vectors = np.empty((2 * size, 2 * size), dtype=complex)  # of the space and J times their conjugates in turn
    adjoint, reduced = np.empty_like(vectors), np.zeros((size, size), dtype=complex)
    new = np.random.default_rng(0).normal(size=2 * size) + 0j
    for number in range(size):
        length = np.linalg.norm(new)
        if number:
            reduced[number, number - 1] = length
        new = new / length
        last = slice(2 * number, 2 * number + 2)
        vectors[:, last] = np.transpose([new, np.append(new[size:], -new[:size]).conj()])
        adjoint[last] = vectors[:, last].conj().T
        new, so_far = operator @ new, slice(0, last.stop)
        for _ in range(2):  # the second time removes what rounding has left
            parts = adjoint[so_far] @ new
            new = new - vectors[:, so_far] @ parts
            reduced[: number + 1, number] += parts[::2]
    inverses, combinations = np.linalg.eig(reduced)
    wavenumbers = np.sqrt(shift**2 + 1 / inverses)
    mixed = vectors[:, ::2] @ combinations  # of the two eigenvectors of each pair, which H +- k tells apart
    slope = np.linalg.solve(second, mixed[size:] - skew @ mixed[:size] / 2)
    change = wavenumbers * mixed[:size]
    return np.append(wavenumbers, -wavenumbers), np.hstack([slope + change, slope - change])


def companion_modes(second, skew, zeroth):
    """All eigenpairs (k, v) of k^2 second + k skew + zeroth, both directions together, 2 n of them."""
    size = len(second)
    diagonal = abs(np.diag(second))
    scale = 1 / np.sqrt(np.maximum(diagonal / np.median(diagonal), 1.0))
    second, skew, zeroth = (scale[:, None] * each * scale for each in (second, skew, zeroth))
    nothing, unit = np.zeros((size, size)), np.eye(size)
    left = np.block([[unit, nothing], [nothing, second]])
    right = np.block([[nothing, unit], [-zeroth, -skew]])
    wavenumbers, pairs = _graded_eigenpairs(left, right, COMPANION_SHIFT)
    return wavenumbers, scale[:, None] * pairs[:size]


def _graded_eigenpairs(left, right, shift):
    """All eigenpairs of right v = s left v whose s span many decades (fine layers: s = k^2 up to 1e14).

    The shift-inverted problem gives the small eigenvalues to all digits and the shapes of the large ones to fewer.  In
    the basis V of all these shapes the direct problem left^-1 right is nearly diagonal.  With V = [V_small, V_large],

        left^-1 right V_large = V_small G + V_large H,      H y = s y,      v = V_large y + V_small z,

    where z_i = (G y)_i / (s - s_i), because the small ones are eigenpairs already.
    """
    # numpy's eigensolver releases the global interpreter lock, scipy's does not; the matrices are ill-conditioned, and
    # only the accurate part of the spectrum is used
    inverses, vectors = np.linalg.eig(np.linalg.solve(right - shift * left, left))
    order = np.argsort(-abs(inverses))
    values, vectors = shift + 1.0 / inverses[order], vectors[:, order]
    sizes = abs(values)
    if sizes[-1] < WIDE_SPECTRUM * abs(shift):
        return values, vectors
    middle = int(np.searchsorted(sizes, np.sqrt(sizes[-1] * abs(shift))))
    near = np.arange(max(1, middle - 8), min(len(sizes) - 1, middle + 8))
    cut = int(near[np.argmax(sizes[near] / sizes[near - 1])])
    both = np.linalg.solve(vectors, np.linalg.solve(left, right @ vectors[:, cut:]))  # G and H
    large, combinations = np.linalg.eig(both[cut:])
    parts = both[:cut] @ combinations / (large - values[:cut, None])
    shapes = vectors @ np.concatenate([parts, combinations])
    return np.append(values[:cut], large), np.hstack([vectors[:, :cut], shapes])
