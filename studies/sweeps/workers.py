"""Executors of a sweep: this process, processes on this machine, or the workers of a Dask scheduler.

All three are executors of concurrent.futures (Dask's by ``Client.get_executor``); they decide which batch runs
where.  One thread per worker: the stator's matrices are small, and processes share a machine better than threads
of a BLAS do.  The batches of a worker that vanishes are submitted again.
"""

import logging
import multiprocessing.connection
import os
import re
import signal
import threading
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager

from studies.refusal import RunError, SceneError, misread, refuse_if

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # a BLAS has one where these are 1


class Workers:
    """The calling process: a batch is computed when it is submitted, by kernels on all processors."""

    threads: int | None = None  # of each, None for all processors
    lost: tuple = (BrokenExecutor,)  # exceptions of a worker that vanished

    @property
    def slots(self) -> int:
        """Batches to submit at a time."""
        return 1

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

    def __init__(self, number: int):
        self._number = number
        self._start()

    @property
    def slots(self) -> int:
        """Batches to submit at a time: two for each process, so that none waits for the driver."""
        return 2 * self._number

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
        self._pool = ProcessPoolExecutor(self._number, mp_context=context, initializer=_settle)

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
            raise misread("scheduler", "such as tcp://127.0.0.1:8786", address)
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError:
            raise SceneError("scheduler", "needs Dask: pip install distributed") from None
        self.lost = (KilledWorker,)
        for name in list(logging.root.manager.loggerDict):  # errors are reported here, in one sentence
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
    def slots(self) -> int:
        """Batches to submit at a time, by the workers that the scheduler has now."""
        return 2 * max(1, len(self._client.scheduler_info(n_workers=-1)["workers"]))

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
    """Return the workers of a sweep: a number of processes, or those of the Dask scheduler at an address."""
    if isinstance(number, str):
        return OnDask(number)
    refuse_if(
        isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= 1000,
        "workers",
        f"must be a number from 1 to 1000, got {number!r}",
    )
    return Workers() if number == 1 else Processes(number)


@contextmanager
def _starting():
    """Block SIGINT and set one BLAS thread while processes start, which inherit both.

    No process is then interrupted before `_settle` makes it ignore the signal.  A BLAS reads its number of threads when
    it is loaded, and numpy is loaded before `_settle` runs.
    """
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ |= dict.fromkeys(ONE_THREAD, "1")
    can_block = hasattr(signal, "pthread_sigmask")  # not on Windows
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if can_block else set()
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
        if can_block:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _settle() -> None:
    """Make this process a worker: it ignores SIGINT, and ends when its driver has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    driver = multiprocessing.parent_process()

    def watch():
        multiprocessing.connection.wait([driver.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
