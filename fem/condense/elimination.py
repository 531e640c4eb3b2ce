"""Elimination of unknowns inside a piece: static condensation (Guyan, AIAA J. 3 (1965) 380)."""

import numpy as np

from fem.exceptions import ConvergenceError

MAX_AMPLIFICATION = 1e9  # of the field inside a piece over that at its sides: seven digits are left


def schur(matrix, keep, drop):
    """Schur complement onto ``keep``, symmetrised against rounding, and the matrix from ``keep`` to ``drop``."""
    coupling = matrix[np.ix_(drop, keep)]
    remaining = matrix[np.ix_(keep, keep)]
    if not len(drop):
        return remaining, coupling
    back = sides_to_inside(matrix[np.ix_(drop, drop)], coupling)
    reduced = remaining + coupling.T @ back
    return 0.5 * (reduced + reduced.T), back


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
