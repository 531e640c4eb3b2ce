"""How far a sweep is, on stderr: points, rate, time left, failures and the cost so far.

A live bar in a terminal, a line every few seconds elsewhere; nothing for a sweep of less than a second.
"""

import sys
import time

__all__ = ["Meter", "duration"]

PATIENCE, BETWEEN = 1.0, 5.0  # s before the first word, and between lines where there is no terminal


class Meter:
    """Used as ``with Meter() as meter: ... meter(count, done, failed, cost)``."""

    def __init__(self):
        self._begun = self._said = time.perf_counter()
        self._first = None
        self._bar = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, count: int, done: int, failed: int, cost: float) -> None:
        """Say how many of the points have a row that is kept, how many of them failed, and the workers' seconds."""
        now = time.perf_counter()
        if self._first is None:
            self._first = done, now
            return
        if now - self._begun < PATIENCE:
            return
        rate = (done - self._first[0]) / max(now - self._first[1], 1e-9)
        left = (count - done) / rate if rate > 0 else None
        words = f"{rate:.3g} points/s, {'-' if left is None else duration(left)} left, {failed} failed"
        words += f", {duration(cost)} of work"
        if sys.stderr.isatty():
            self._show(count, done, words)
        elif now - self._said > BETWEEN or done == count:
            self._said = now
            print(f"{done} of {count} points kept: {words}", file=sys.stderr, flush=True)

    def _show(self, count, done, words) -> None:
        if self._bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

            columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
            self._bar = Progress(*columns, console=Console(stderr=True))
            self._task = self._bar.add_task(words, total=count)
            self._bar.start()
        self._bar.update(self._task, completed=done, description=words)


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
