"""Measurements in a fresh process in which every library uses one thread, and the peak memory of a process.

The number of threads is set by environment variables before the libraries are imported.  Two measurements never share a
process, because a thread pool or a cache of the first would change the time and the memory of the second.
"""

import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

from studies.refusal import RunError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def alone(what: str, work: Callable, *arguments):
    """Return ``work(*arguments)``, called in a fresh process with one thread; ``work`` must be importable.

    Raises
    ------
    RunError
        If the process was terminated; ``what`` names it in the message.
    """
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            return pool.submit(work, *arguments).result()
    except BrokenProcessPool:
        raise RunError(f"{what}: its process was ended; it may want more memory") from None
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def peak_memory() -> int:
    """Peak memory of this process in bytes; on Linux the memory of its parent process is not included."""
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    try:
        import resource  # Windows has none
    except ImportError:
        raise RunError("the peak memory of a process is known on Linux and macOS only") from None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
