"""Elimination of unknowns inside a piece: static condensation (Guyan, AIAA J. 3 (1965) 380)."""

import numpy as np

from fem.exceptions import ConvergenceError

MAX_AMPLIFICATION = 1e9  # of the field inside a piece over that at its sides: seven digits are left
# Columns of `symmetric_product` that are multiplied whole; 32 and 128 take the same time within 5 %
SMALLEST_BLOCK = 64


def schur(matrix, keep, drop):
    """Schur complement of a symmetric matrix onto ``keep``, and the matrix from ``keep`` to ``drop``."""
    coupling = matrix[drop[:, None], keep]
    remaining = matrix[keep[:, None], keep]
    if not len(drop):
        return remaining, coupling
    back = sides_to_inside(matrix[drop[:, None], drop], coupling)
    remaining += symmetric_product(coupling, back)
    return remaining, back


def symmetric_product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return left^T right where that is symmetric but for rounding, exactly symmetric; about half of it is computed.

    Examples
    --------
    >>> import numpy as np
    >>> symmetric_product(np.array([[1.0, 2.0]]), np.array([[3.0, 6.0]])).tolist()
    [[3.0, 6.0], [6.0, 12.0]]
    """
    product = np.empty((left.shape[1],) * 2, dtype=np.result_type(left, right))
    _fill_symmetric(product, left, right)
    return product


def _fill_symmetric(product: np.ndarray, left: np.ndarray, right: np.ndarray) -> None:
    """Write left^T right, by halves of the columns."""
    if left.shape[1] <= SMALLEST_BLOCK:
        whole = left.T @ right
        np.add(whole, whole.T, out=product)
        product *= 0.5
        return
    first, second = slice(None, left.shape[1] // 2), slice(left.shape[1] // 2, None)
    for half in (first, second):
        _fill_symmetric(product[half, half], left[:, half], right[:, half])
    np.matmul(left[:, first].T, right[:, second], out=product[first, second])
    product[second, first] = product[first, second].T


def sides_to_inside(inside: np.ndarray, coupling: np.ndarray) -> np.ndarray:
    """Matrix from the fields at the sides to those inside, minus the inverse of ``inside`` times ``coupling``.

    Each decade of amplification costs a digit of the answer.  A piece that resonates between clamped lines makes its
    condensation singular, though not the stator's problem; it raises a ConvergenceError.
    """
    try:
        back = -np.linalg.solve(inside, coupling)
    except np.linalg.LinAlgError:
        back = np.array(np.inf)
    if not abs(back).max(initial=0.0) < MAX_AMPLIFICATION:
        raise ConvergenceError(
            "a piece of the transducer, clamped at its sides, resonates at this very frequency: "
            "change the frequency by a part in a million, or give the solid a mechanical_quality"
        )
    return back
