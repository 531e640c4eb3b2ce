"""Progress as the modules log it: the steps of a computation at level INFO, the details of a step at DEBUG.

`Progress` shows it on stderr when a computation takes longer than a second; stdout is for the answer.
"""

import logging
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from rich.text import Text

Item = TypeVar("Item")
LOGGERS = ("studies", "fem", "contact")
PATIENCE = 1.0  # s
MIN_INTERVAL = 0.05  # between two lines without a terminal, relative to the time so far
MIN_EXPECTED = 5.0  # s: an expected time below is not shown
MAX_SILENCE = 10.0  # s without a line, after which the last text is repeated with the time so far


class _Messages(logging.Handler):
    """Calls a function with each message; a detail is preceded by its step."""

    def __init__(self, receive: Callable[[str], None]):
        super().__init__()
        self._receive, self._step = receive, ""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.levelno > logging.DEBUG:
            self._step = text
        elif self._step:
            text = f"{self._step}, {text}"
        self._receive(text)


@contextmanager
def reported_to(progress: Callable[[str], None] | None) -> Iterator[None]:
    """Call a function with a text of each step that is logged meanwhile; None calls nothing."""
    if progress is None:
        yield
        return
    handler, loggers = _Messages(progress), [logging.getLogger(name) for name in LOGGERS]
    levels = [each.level for each in loggers]
    for each in loggers:
        each.addHandler(handler)
        each.setLevel(logging.DEBUG)
    try:
        yield
    finally:
        for each, level in zip(loggers, levels, strict=True):
            each.removeHandler(handler)
            each.setLevel(level)


class Countdown:
    """Text on the parts of a computation that are done, and on the time that the others take at the same rate.

    Parameters
    ----------
    what : str
        Name of the computation.
    total : int
        Number of its parts; 0 if it is unknown, and no time is given.
    parts : str
        What the parts are called; empty to leave it out.

    Examples
    --------
    >>> Countdown("load lines", 4).text(0)
    'load lines: 0 of 4'
    """

    def __init__(self, what: str, total: int, parts: str = ""):
        self._what, self._total, self._start = what, total, time.perf_counter()
        self._parts = f" {parts}" if parts else ""

    def text(self, done: int) -> str:
        """Return the text after a number of parts."""
        if done > self._total:  # unknown, or an estimate that was too small
            return f"{self._what}: {done}{self._parts}"
        left = (time.perf_counter() - self._start) * (self._total / done - 1.0) if done else 0.0
        about = f", about {duration(left)} left" if left > PATIENCE else ""
        return f"{self._what}: {done} of {self._total}{self._parts}{about}"


def counted(logger: logging.Logger, what: str, items: Collection[Item]) -> Iterator[Item]:
    """Yield the items of a collection; log before each how many are done, and about how long the others take."""
    countdown = Countdown(what, len(items))
    for done, item in enumerate(items):
        logger.info(countdown.text(done))
        yield item


class Progress:
    """Context manager that shows what is logged meanwhile and for how long.

    In a terminal it is one live line, elsewhere a new line now and then.

    Parameters
    ----------
    expected : float, optional
        Time in s that the whole computation is expected to take, which is shown beside the time so far.
    """

    def __init__(self, expected: float | None = None):
        self._start_time, self._expected = time.perf_counter(), expected
        self.text = "starting"
        self._lock = threading.Lock()
        self._live: Any = None  # rich's, which is imported where it is shown
        self._first: tuple[int, float] | None = None
        self._shown = self._over = False
        self._printed = 0.0
        self._reports = reported_to(self)
        self._timer = threading.Timer(PATIENCE, self._appear)
        self._timer.daemon = True

    def __call__(self, text: str) -> None:
        """Show a text from now on."""
        with self._lock:
            self.text = text
            self._show()

    def points(self, total: int, done: int, failed: int, cost: float) -> None:
        """Show how many points of a sweep are stored, the rate, and the seconds of work."""
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
        self._reports.__enter__()
        return self

    def __exit__(self, *_):
        self._reports.__exit__(None, None, None)
        with self._lock:
            self._shown, self._over = False, True
            self._timer.cancel()
            if self._live is not None:
                self._live.stop()

    def _appear(self) -> None:
        with self._lock:
            if self._over:
                return
            self._shown = True
            if sys.stderr.isatty():
                from rich.console import Console

                self._live = Console(stderr=True).status(self)
                self._live.start()
            else:
                self._rearm()
            self._show()

    def _rearm(self) -> None:
        """Let the last text be repeated after a silence of `MAX_SILENCE`."""
        self._timer = threading.Timer(MAX_SILENCE, self._repeat)
        self._timer.daemon = True
        self._timer.start()

    def _repeat(self) -> None:
        with self._lock:
            if not self._shown:
                return
            if time.perf_counter() >= self._printed + MAX_SILENCE:
                self._show()
            self._rearm()

    def __rich__(self) -> "Text":
        """Return what the live line shows; rich asks for it at each drawing."""
        from rich.text import Text

        return Text(f"{self.text} ({so_far(time.perf_counter() - self._start_time, self._expected)})")

    def _show(self) -> None:
        if not self._shown or self._live is not None:
            return
        if (now := time.perf_counter()) > self._printed + max(PATIENCE, MIN_INTERVAL * (now - self._start_time)):
            self._printed = now
            print(f"{self.text} ({so_far(now - self._start_time, self._expected)})", file=sys.stderr, flush=True)


def so_far(seconds: float, expected: float | None) -> str:
    """Return the time that a computation has taken, and what it is expected to take where that is known.

    Examples
    --------
    >>> so_far(12.1, None), so_far(12.1, 21.0), so_far(75.0, 21.0)
    ('12.1 s', '12.1 s of about 21 s', '1 min 15 s; about 21 s were expected')
    """
    passed = duration(seconds)
    if expected is None or expected < MIN_EXPECTED:
        return passed
    about = f"about {duration(round(expected)).replace('.0 s', ' s')}"
    return f"{passed} of {about}" if seconds <= expected else f"{passed}; {about} were expected"


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
