"""The system of three equations of Newton's methods, in the state."""

from contact.jit.compiled import compiled
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_index import Array


@compiled
def solve_matrix(state: Array) -> float:
    """Solve the system of Newton's method in place, the residual on its right; return 0, or 1 where it is singular."""
    k: int = 0
    while k < 3:
        state[index.MATRIX + 4 * k + 3] = -state[index.RESIDUAL + k]
        k = k + 1
    k = 0
    i: int = 0
    j: int = 0
    while k < 3:  # the diagonal is positive and large: no pivots
        pivot = state[index.MATRIX + 5 * k]
        if pivot == 0.0:
            return 1.0
        i = k + 1
        while i < 3:
            f = state[index.MATRIX + 4 * i + k] / pivot
            j = k
            while j < 4:
                state[index.MATRIX + 4 * i + j] = state[index.MATRIX + 4 * i + j] - f * state[index.MATRIX + 4 * k + j]
                j = j + 1
            i = i + 1
        k = k + 1
    k = 2
    while k >= 0:
        value = state[index.MATRIX + 4 * k + 3]
        j = k + 1
        while j < 3:
            value = value - state[index.MATRIX + 4 * k + j] * state[index.MATRIX + 4 * j + 3]
            j = j + 1
        state[index.MATRIX + 4 * k + 3] = value / state[index.MATRIX + 5 * k]
        k = k - 1
    return 0.0
