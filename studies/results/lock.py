"""A lock on a directory: one writer at a time, and none that outlives its process.

The lock is an exclusive transaction on a small SQLite file in the directory.  The operating system releases it when the
process ends, however it ends, so a stale file blocks nobody; SQLite does this on every platform.
"""

import os
import sqlite3
from contextlib import suppress
from pathlib import Path


class DirectoryInUseError(Exception):
    """Another process holds the lock."""


def locked(file: Path) -> sqlite3.Connection:
    """Return a connection that holds the lock of a file, made if absent, until it is closed or its process ends.

    Raises DirectoryInUseError if another process holds it, OSError if the file cannot be written.
    """
    while True:
        file.touch()  # never opened here: to close a second handle would drop this process's lock (POSIX)
        with suppress(FileNotFoundError):
            before = file.stat()
            connection = sqlite3.connect(file, timeout=0, isolation_level=None)
            try:
                connection.execute("pragma journal_mode = memory")  # nothing is ever written: no journal file
                connection.execute("begin exclusive")
            except sqlite3.Error as error:
                connection.close()
                if "locked" in str(error):
                    raise DirectoryInUseError(str(file)) from None
                raise OSError(0, str(error), str(file)) from None
            if file.exists() and os.path.samestat(before, file.stat()):
                return connection
            connection.close()  # a former holder has deleted the file between touch and lock
