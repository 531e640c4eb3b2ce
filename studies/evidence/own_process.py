"""Work in a process of its own, with one thread for each library, and the peak memory of a process.

Libraries that thread are told so before they are loaded.  Two measurements never share a process: a thread pool or a
cache of the first would change what the second costs.
"""

import os
import resource
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

from studies.refusal import RunError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def alone(what: str, work: Callable, *arguments):
    """Return what some work gives in a fresh process with one thread; the function must be importable.

    Raises
    ------
    RunError
        If the process was ended; ``what`` names it.
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
    """Peak memory of this process in bytes; on Linux not what the process that it was forked from had."""
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
