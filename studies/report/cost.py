"""What a run is expected to cost: a small model, calibrated on one machine, that asks this machine for its speed.

The stator's work is dense algebra whose operations can be counted: each join of two pieces, each condensed column, the
guided modes, the open ends.  They are divided by the speed at which this machine multiplies complex matrices, which is
measured on the spot, times the share of it that the solver reaches.  The contact's costs per point and per cycle, and
what imports take, are plain constants in CPU seconds of a 2-core x86_64 machine of 2026 (matrix product: 46 Gflop/s).
Memory is what the blocks of the two finest discretisations hold, over what the imports take.
"""

import time

__all__ = [
    "MEMORY_WITHIN",
    "TIME_WITHIN",
    "band_seconds",
    "burst_seconds",
    "contact_seconds",
    "free_seconds",
    "machine_speed",
    "memory",
    "solution_operations",
]

TIME_WITHIN, MEMORY_WITHIN = 3.0, 2.0  # factors within which the predictions have been seen to hold
SOLVER_SHARE = 0.55  # of the speed of a product of two 300 x 300 matrices
JOIN = 12.7 * 4  # real operations over n^3 of one join, complex: a factorisation, 2 n solutions, a product
EIGENPAIRS = 25 * 4  # over m^3, of m eigenpairs with vectors
ENDS = 3.0  # joins, for each open end, and for each transducer between two of them
AUDIT = 8.0  # joins, of the power balance
CALL = 2e-3  # s, of everything in a join or a condensed column that is not algebra
KEPT = 1.35  # memory over that of the blocks alone: mirror images, modes, work space
PROCESS = 70e6  # bytes: Python with its numerical libraries
KERNELS = {
    "elastic": 28e6,
    "hysteretic": 108e6,
}  # bytes, the compiled contact; the hysteretic law's needs numba
LOAD, LOAD_KERNELS = 0.12, {"elastic": 0.1, "hysteretic": 0.6}  # s
COMPILE = 15.0  # s, of the kernels when they are not there yet
POINT = {"elastic": 0.006, "hysteretic": 0.04}  # s, of a steady state on one contact
CONTACTS = {
    "elastic": (0.008, 1.5),
    "hysteretic": (0.1, 2.0),
}  # s of a steady state on n > 1: factor, exponent
CYCLE = {"exact": 4.5e-5, "hysteretic": 2e-4, "stepped": 4.5e-6}  # s per cycle of a burst
AVERAGED = 0.05  # s, of a burst
BAND_NODES = 7  # solutions that preparing a band of frequencies is worth
BAND_KEPT = 5  # solutions whose blocks it holds at once
FREQUENCY = {"absorbing": (110, 0.013), "sent back": (1000, 0.03)}  # of a ring-up: how many, and s for each


def machine_speed() -> float:
    """Return how many real operations per second one thread here does in products of complex matrices."""
    import numpy as np

    from fem import one_blas_thread

    size = 300
    matrix = np.full((size, size), 0.5 + 0.5j)

    @one_blas_thread
    def product() -> float:
        begun = time.process_time()
        matrix @ matrix
        return time.process_time() - begun

    return 8.0 * size**3 / min(product() for _ in range(5))


def solution_operations(size, *, mirror: bool) -> float:
    """Return the real operations of a driven stator on one discretisation, a `fem.condense.size.StatorSize`."""
    n, order = size.line, size.resolution.order
    fields = len(size.section.solid.fields)
    inside, rim = (order - 1) ** 2 * fields, 4 * order * fields
    kinds = len({complex(height) for height in size.section.heights})
    element = _elimination(inside, rim)
    columns = size.condensed * (kinds * element + _elimination(size.faces, 2 * n))
    half = n if mirror else 2 * n
    rest = (
        EIGENPAIRS * half**3
        + JOIN * n**3 * ENDS * (1 if mirror else 2)
        + JOIN * n**3 * ENDS * size.scatterers
    )
    return (columns + JOIN * n**3 * size.joins) * (1.0 if size.complex else 0.25) + rest


def _elimination(inner: int, outer: int) -> float:
    """Real operations of eliminating complex unknowns: a factorisation, solutions, a product."""
    return 4 * (2 / 3 * inner**3 + 2 * inner**2 * outer + 2 * inner * outer**2)


def solution_seconds(size, speed: float, *, audited: bool = False) -> float:
    """Return the time of one discretisation at a machine's speed in operations per second."""
    operations = solution_operations(size, mirror=size.section.odd is not None)
    operations += AUDIT * JOIN * size.line**3 if audited else 0.0
    return operations / (SOLVER_SHARE * speed) + CALL * (size.joins + size.condensed)


def band_seconds(solution: float, ends: str) -> float:
    """Return the time that a band of frequencies takes, one solution of which takes as long as given."""
    number, each = FREQUENCY["absorbing" if ends == "absorbing" else "sent back"]
    return BAND_NODES * solution + number * each


def free_seconds(lines: list[int], speed: float) -> float:
    """Return the time of the free wave's eigenproblems, given the unknowns of a line at each order."""
    return 0.04 + sum(2 * EIGENPAIRS * line**3 for line in lines) / (SOLVER_SHARE * speed)


def contact_seconds(points: int, law: str, contacts: int, *, ready: bool) -> float:
    """Return the time of loading the kernels, or of compiling them if they are not ready, and of steady states."""
    factor, exponent = CONTACTS[law]
    return (
        LOAD_KERNELS[law]
        + (0.0 if ready else COMPILE)
        + points * (POINT[law] if contacts == 1 else factor * contacts**exponent)
    )


def burst_seconds(points: int, way: str, law: str, cycles: float) -> float:
    """Return the time of bursts of so many cycles of the wave."""
    if way == "averaged":
        return points * AVERAGED
    return points * cycles * CYCLE["hysteretic" if law == "hysteretic" and way == "exact" else way]


def memory(block_bytes: list[float], *, band: float, law: str | None) -> float:
    """Return the bytes of a process that keeps the blocks of its two finest discretisations.

    Parameters
    ----------
    block_bytes : list of float
        Of each discretisation.
    band : float
        Blocks of the discretisation of a band of frequencies; zero without one.
    law : str or None
        Of the contact; None without one.
    """
    kept = KEPT * (sum(sorted(block_bytes)[-2:]) + BAND_KEPT * band)
    return PROCESS + (KERNELS[law] if law else 0.0) + kept
