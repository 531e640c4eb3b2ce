"""Progress on stderr, for anything that takes longer than a second; stdout is left to the answer."""

import sys
import threading
import time

__all__ = ["Progress"]

PATIENCE = 1.0  # s


class Progress:
    """Shows what is being done and for how long: a live line in a terminal, now and then a line elsewhere.

    Used as ``with Progress() as progress: ...``, and called with a few words.
    """

    def __init__(self):
        self._begun = time.perf_counter()
        self._text = "starting"
        self._lock = threading.Lock()
        self._live = None
        self._shown = False
        self._printed = 0.0
        self._timer = threading.Timer(PATIENCE, self._appear)
        self._timer.daemon = True

    def __call__(self, text: str) -> None:
        """Say what is being done now."""
        with self._lock:
            self._text = text
            self._show()

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

                self._live = Console(stderr=True).status(self._text)
                self._live.start()
            self._show()

    def _show(self) -> None:
        if not self._shown:
            return
        if self._live is not None:
            self._live.update(self._text)
        elif (now := time.perf_counter()) > self._printed + PATIENCE:
            self._printed = now
            print(f"{self._text} ({now - self._begun:.1f} s)", file=sys.stderr, flush=True)
