"""Progress on stderr, for anything that takes longer than a second; stdout is left to the answer."""

import sys
import threading
import time

PATIENCE = 1.0  # s
BETWEEN = 0.05  # of the time so far: between two lines where there is no terminal


class Progress:
    """Shows what is being done and for how long: a live line in a terminal, now and then a line elsewhere.

    Used as ``with Progress() as progress: ...``, and called with a few words.
    """

    def __init__(self):
        self._begun = time.perf_counter()
        self.text = "starting"
        self._lock = threading.Lock()
        self._live = self._first = None
        self._shown = False
        self._printed = 0.0
        self._timer = threading.Timer(PATIENCE, self._appear)
        self._timer.daemon = True

    def __call__(self, text: str) -> None:
        """Say what is being done now."""
        with self._lock:
            self.text = text
            self._show()

    def points(self, total: int, done: int, failed: int, cost: float) -> None:
        """Say how many points of a sweep have a row that is kept, at what rate, and the workers' seconds."""
        now = time.perf_counter()
        if self._first is None:
            self._first = done, now
        rate = (done - self._first[0]) / max(now - self._first[1], 1e-9)
        left = duration((total - done) / rate) if rate > 0 else "-"
        self(
            f"{done} of {total} points kept: {rate:.3g} points/s, {left} left, {failed} failed, "
            f"{duration(cost)} of work"
        )

    def __enter__(self):
        self._timer.start()
        return self

    def __exit__(self, *_):
        self._timer.cancel()
        with self._lock:
            self._shown = False
            if self._live is not None:
                self._live.stop()

    def _appear(self) -> None:
        with self._lock:
            if self._timer.finished.is_set():
                return
            self._shown = True
            if sys.stderr.isatty():
                from rich.console import Console

                self._live = Console(stderr=True).status(self.text)
                self._live.start()
            self._show()

    def _show(self) -> None:
        if not self._shown:
            return
        if self._live is not None:
            self._live.update(self.text)
        elif (now := time.perf_counter()) > self._printed + max(PATIENCE, BETWEEN * (now - self._begun)):
            self._printed = now
            print(f"{self.text} ({now - self._begun:.1f} s)", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> duration(3.21), duration(200), duration(9000)
    ('3.2 s', '3 min 20 s', '2 h 30 min')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    if seconds < 3600:
        return f"{int(seconds // 60)} min {int(seconds % 60)} s"
    return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"
