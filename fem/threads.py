"""One BLAS thread while the stator is solved, and several frequencies side by side.

Its matrices are small and many.  Threads of a BLAS that wait for each other, and for those of other libraries in the
process, make it several times slower than one (69 s against 5 s were seen); frequencies and scenes are what to spread.
"""

import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import wraps

_workers = 2  # threads over frequencies; the linear algebra of each runs outside the interpreter's lock


class _Limit:
    """The limit of this process: set at the first `enter`, lifted at the last `leave`.

    The number of BLAS threads belongs to the process.  If two threads each saved and restored it, one could lift the
    limit while the other still needs it, or leave it set for good.
    """

    def __init__(self):
        self._lock, self._users, self._limits, self._seen = threading.Lock(), 0, [], False

    def enter(self) -> None:
        """Count one more user; limit every BLAS that is not limited yet, also one that was loaded meanwhile."""
        from threadpoolctl import threadpool_limits

        with self._lock:
            loaded = "scipy.linalg" in sys.modules  # its BLAS is another than numpy's
            if self._users == 0 or (loaded and not self._seen):
                _release_control()
                self._limits.append(threadpool_limits(limits=1, user_api="blas"))
                self._seen = loaded
            self._users += 1

    def leave(self) -> None:
        """Count one user less; the last one restores the numbers of threads from before the first."""
        with self._lock:
            self._users -= 1
            while self._users == 0 and self._limits:
                _release_control()
                self._limits.pop().restore_original_limits()
                _release_control()  # else other threads could not set the number while this one lives


def _release_control() -> None:
    """Allow any thread to set the number of BLAS threads; threadpoolctl (3.8) allows only the first that did."""
    from threadpoolctl import OpenBLASController

    clear = getattr(OpenBLASController, "clear_controlling_thread", None)
    if clear is not None:
        clear(force=True)


_limit = _Limit()


@contextmanager
def blas_on_one_thread() -> Iterator[None]:
    """Limit BLAS to one thread within a block; safe in several threads at once, and nested."""
    import numpy  # noqa: F401  only a loaded BLAS can be limited

    _limit.enter()
    try:
        yield
    finally:
        _limit.leave()


def one_blas_thread(work: Callable) -> Callable:
    """Return the function, run with one BLAS thread whatever the process allows."""

    @wraps(work)
    def limited(*args, **kwargs):
        with blas_on_one_thread():
            return work(*args, **kwargs)

    return limited


def set_workers(number: int) -> None:
    """Set how many threads of this process work side by side: 1 where processes share the machine."""
    global _workers
    _workers = number


@one_blas_thread
def side_by_side(work: Callable, items: Iterable) -> list:
    """Return what ``work`` gives for every item, in their order, as many at a time as `set_workers` allows."""
    with ThreadPoolExecutor(_workers) as pool:
        return list(pool.map(work, items))
