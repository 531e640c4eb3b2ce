"""A lock on a directory: one writer at a time, and none that outlives its process.

The operating system releases the lock when its process ends, however it ends: a stale file blocks nobody.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from filelock import FileLock


class DirectoryInUseError(Exception):
    """Another process holds the lock."""


def locked(file: Path) -> "FileLock":
    """Return the held lock of a file, made if absent, until it is released or its process ends.

    Raises DirectoryInUseError if somebody else holds it, OSError if the file cannot be written.
    """
    from filelock import FileLock, Timeout  # brings asyncio along, 20 ms: a run with --json needs neither

    lock = FileLock(file, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise DirectoryInUseError(str(file)) from None
    return lock
