"""One BLAS thread while the stator is solved, and several frequencies side by side.

Its matrices are small and many.  Threads of a BLAS that wait for each other, and for those of other libraries in the
process, make it several times slower than one (69 s against 5 s were seen); frequencies and scenes are what to spread.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import wraps

WORKERS = 2  # threads over frequencies; the linear algebra of each runs outside the interpreter's lock
VARIABLE = (
    "SAWMOTOR_THREADS"  # of the environment: another number of them, 1 where processes share the machine
)


def one_blas_thread(work: Callable) -> Callable:
    """Return the function, run with one BLAS thread whatever the process allows."""

    @wraps(work)
    def limited(*args, **kwargs):
        import scipy.linalg  # noqa: F401  its BLAS is another than numpy's, and only a loaded one can be limited
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return work(*args, **kwargs)

    return limited


@one_blas_thread
def side_by_side(work: Callable, items: Iterable, *, workers: int | None = None) -> list:
    """Return what ``work`` gives for every item, in their order, ``workers`` at a time."""
    with ThreadPoolExecutor(workers or int(os.environ.get(VARIABLE, WORKERS))) as pool:
        return list(pool.map(work, items))
