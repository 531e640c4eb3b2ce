"""A lock on a directory: one writer at a time, and none that outlives its process.

The operating system releases the lock when its process ends, however it ends: a stale file blocks nobody.
"""

from pathlib import Path

from filelock import FileLock, Timeout


class DirectoryInUseError(Exception):
    """Another process holds the lock."""


def locked(file: Path) -> FileLock:
    """Return the held lock of a file, made if absent, until it is released or its process ends.

    Raises DirectoryInUseError if somebody else holds it, OSError if the file cannot be written.
    """
    lock = FileLock(file, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise DirectoryInUseError(str(file)) from None
    return lock
