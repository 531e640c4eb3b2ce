"""Sparse complex symmetric systems: solutions and Schur complements.

MKL Pardiso where `pypardiso` is installed, SuperLU in symmetric mode otherwise (one BLAS thread; beyond 3e5 unknowns it
runs out of memory).  Pardiso gives a Schur complement from its own factorisation (iparm(36) = 2); SuperLU solves for
every column of the coupling, which takes about seven times as long.
"""

import ctypes

import numpy as np

MATRIX_TYPE = 6  # of Pardiso: complex symmetric
MISSING = (
    ImportError,
    AttributeError,
    TypeError,
    OSError,
)  # no pypardiso, no MKL, or another private interface


def sparse_solution(matrix, load: np.ndarray) -> np.ndarray:
    """Solve a sparse complex symmetric system (n, n) for loads (n, m), shape (n, m)."""
    try:
        return _pardiso_solution(matrix, load)
    except MISSING:
        return _factor(matrix).solve(np.asarray(load, dtype=complex))


def schur_complement(matrix, count: int) -> np.ndarray:
    """Schur complement of a sparse complex symmetric matrix onto its last ``count`` unknowns, dense.

    The result is symmetrised against rounding; it is real where the matrix is.
    """
    if matrix.shape[0] == count:
        result = matrix.toarray()
    else:
        try:
            result = _pardiso_schur(matrix, count)
        except MISSING:
            result = _schur_by_columns(matrix.tocsc(), count)
    if not np.iscomplexobj(matrix.data):
        result = result.real
    return 0.5 * (result + result.T)


def _factor(matrix):
    from scipy.sparse.linalg import splu

    return splu(
        matrix.tocsc().astype(complex),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )


def _schur_by_columns(matrix, count: int) -> np.ndarray:
    inner = matrix.shape[0] - count
    coupling = matrix[:inner, inner:].toarray().astype(complex)
    solved = _factor(matrix[:inner, :inner]).solve(coupling)
    return matrix[inner:, inner:].toarray() - coupling.T @ solved


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


def _pardiso_schur(matrix, count: int) -> np.ndarray:
    """Schur complement by MKL Pardiso: it comes back in the place of the solution."""
    from pypardiso import PyPardisoSolver

    solver, upper, size = PyPardisoSolver(mtype=MATRIX_TYPE, phase=12), _upper(matrix), matrix.shape[0]
    solver.perm = np.zeros(size, dtype=np.int32)
    solver.perm[-count:] = 1
    # own settings; nested dissection; pivots perturbed by 1e-8; Bunch-Kaufman pivots; Schur complement
    for number, value in ((1, 1), (2, 2), (10, 8), (21, 1), (36, 2)):
        solver.iparm[number - 1] = value
    result = np.zeros((count, count), dtype=complex, order="F")
    integers, numbers = ctypes.POINTER(ctypes.c_int32), ctypes.POINTER(ctypes.c_double)
    starts, columns = (1 + each.astype(np.int32) for each in (upper.indptr, upper.indices))
    error = ctypes.c_int32(0)

    def whole(value: int):
        return ctypes.byref(ctypes.c_int32(value))

    solver._mkl_pardiso(
        solver.pt.ctypes.data_as(ctypes.POINTER(solver._pt_type[0])),
        *(whole(value) for value in (1, 1, MATRIX_TYPE, 12, size)),  # maxfct, mnum, mtype, phase, n
        upper.data.ctypes.data_as(numbers),
        starts.ctypes.data_as(integers),
        columns.ctypes.data_as(integers),
        solver.perm.ctypes.data_as(integers),
        whole(1),
        solver.iparm.ctypes.data_as(integers),
        whole(0),
        np.zeros((size, 1), dtype=complex).ctypes.data_as(numbers),
        result.ctypes.data_as(numbers),
        ctypes.byref(error),
    )
    solver.free_memory(everything=True)
    if error.value:
        raise TypeError(f"Pardiso returns error {error.value}")
    return result
