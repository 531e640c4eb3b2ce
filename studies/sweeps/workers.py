"""Executors of a sweep: this process, processes on this machine, or the workers of a Dask scheduler.

All three are executors of concurrent.futures (Dask's by ``Client.get_executor``); which batch runs where is theirs to
decide.  One thread per worker: the stator's matrices are small, and processes share a machine better than threads
of a BLAS do.  A worker that vanishes costs its batches, which are given out again.
"""

import logging
import multiprocessing.connection
import os
import re
import signal
import threading
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager

from studies.refusal import RunError, SceneError, shown

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # a BLAS has one where these are 1


class Workers:
    """The calling process: a batch is done when it is submitted, on all processors where kernels share their work."""

    threads: int | None = None  # of each, None for all processors
    lost: tuple = (BrokenExecutor,)  # what says that a worker vanished

    @property
    def size(self) -> int:
        """Number of workers."""
        return 1

    @property
    def slots(self) -> int:
        """Batches to give out at a time."""
        return self.size if self.threads is None else 2 * self.size

    def submit(self, work, *arguments) -> Future:
        """Do the work now; an interrupt goes straight to the caller."""
        future: Future = Future()
        try:
            future.set_result(work(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def renew(self) -> None:
        """Replace workers that have vanished."""

    def close(self) -> None:
        """End the workers without waiting for their batches."""


class Processes(Workers):
    """Worker processes of this machine, which end with the driver however it ends."""

    threads = 1

    def __init__(self, size: int):
        self._size = size
        self._start()

    @property
    def size(self) -> int:
        """Number of processes."""
        return self._size

    def submit(self, work, *arguments) -> Future:
        """Give a batch to the next process that is free."""
        try:
            with _starting():
                return self._pool.submit(work, *arguments)  # may start a process
        except BrokenExecutor as error:
            future: Future = Future()
            future.set_exception(error)
            return future

    def renew(self) -> None:
        """Start processes anew after one has vanished; RunError if they do not start at all."""
        self._start()
        try:
            self.submit(os.getpid).result()
        except BrokenExecutor:
            raise RunError(
                "the worker processes do not start: a script that asks for workers must do so under "
                'if __name__ == "__main__":'
            ) from None

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(self.size, mp_context=context, initializer=_settle)

    def close(self) -> None:
        """End the processes without waiting for their batches."""
        # until Python 3.14 the pool has no method that ends a process at work
        for process in list((self._pool._processes or {}).values()):  # noqa: SLF001 - see above
            process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)


class OnDask(Workers):
    """The workers of a Dask scheduler at an address such as ``tcp://127.0.0.1:8786``."""

    threads = 1

    def __init__(self, address: str):
        if not re.fullmatch(r"(\w+://)?(\[[0-9a-fA-F:]+\]|[^\s/:]+):\d{1,5}", address):
            raise SceneError("scheduler", f"must be such as tcp://127.0.0.1:8786, got {shown(address)}")
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError:
            raise SceneError("scheduler", "needs Dask: pip install distributed") from None
        self.lost = (KilledWorker,)
        for name in list(logging.root.manager.loggerDict):  # what goes wrong is said here, in a sentence
            if name.split(".")[0] == "distributed":
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        try:
            self._client = Client(address, timeout=10, set_as_default=False)
        except ValueError as error:
            raise SceneError("scheduler", f"must be such as tcp://127.0.0.1:8786: {error}") from None
        except OSError as error:
            text = " ".join(str(error).split())
            raise RunError(f"no Dask scheduler answers at {address!r}: {text}") from None
        self._executor: Executor = self._client.get_executor(pure=False)

    @property
    def size(self) -> int:
        """The workers that there are now."""
        return max(1, len(self._client.scheduler_info(n_workers=-1)["workers"]))

    def submit(self, work, *arguments) -> Future:
        """Give a batch to the scheduler, which looks after its workers itself."""
        if self._client.status != "running":
            raise RunError("the Dask scheduler is gone; the same command goes on from what is kept")
        return self._executor.submit(work, *arguments)

    def close(self) -> None:
        """Withdraw what is still to be done and leave; the cluster goes on."""
        self._executor.shutdown(wait=False)
        self._client.close(timeout=2)


def workers(number: int | str) -> Workers:
    """Return the workers that a sweep asks for: so many processes, or those of a Dask scheduler's address."""
    if isinstance(number, str):
        return OnDask(number)
    if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= 1000:
        raise SceneError("workers", f"must be a number from 1 to 1000, got {number!r}")
    return Workers() if number == 1 else Processes(number)


@contextmanager
def _starting():
    """Hold back Ctrl-C and allow one thread while processes start, which inherit both.

    So none is interrupted before `_settle` makes it ignore the signal.  A BLAS reads its number of threads when it is
    loaded, and numpy is loaded before `_settle` runs.
    """
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ |= dict.fromkeys(ONE_THREAD, "1")
    held = hasattr(signal, "pthread_sigmask")  # not on Windows
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if held else set()
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
        if held:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _settle() -> None:
    """Make a process a worker: it ignores the terminal's interrupt, and ends when its driver is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    driver = multiprocessing.parent_process()

    def watch():
        multiprocessing.connection.wait([driver.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
