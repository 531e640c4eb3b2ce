"""Solutions of sparse complex symmetric systems.

MKL Pardiso where `pypardiso` is installed, SuperLU in symmetric mode otherwise (one BLAS thread; beyond 3e5 unknowns it
runs out of memory).
"""

import numpy as np

MATRIX_TYPE = 6  # of Pardiso: complex symmetric
# Raised without pypardiso, without MKL, or by another version of pypardiso's private interface
MISSING = (ImportError, AttributeError, TypeError, OSError)


def sparse_solution(matrix, load: np.ndarray) -> np.ndarray:
    """Solve a sparse complex symmetric system (n, n) for loads (n, m), shape (n, m)."""
    try:
        return _pardiso_solution(matrix, load)
    except MISSING:
        from scipy.sparse.linalg import splu

        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
        factor = splu(matrix.tocsc().astype(complex), diag_pivot_thresh=0.01, **symmetric)
        return factor.solve(np.asarray(load, dtype=complex))


def _upper(matrix):
    from scipy.sparse import triu

    upper = triu(matrix, format="csr").astype(complex)
    upper.sort_indices()
    return upper


def _pardiso_solution(matrix, load: np.ndarray) -> np.ndarray:
    """Solve with MKL Pardiso; the public ``solve`` of pypardiso takes float64 only."""
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=MATRIX_TYPE, phase=13)
    answer = solver._call_pardiso(_upper(matrix), np.asfortranarray(load, dtype=complex))
    solver.free_memory(everything=True)
    return answer
