"""The store of a sweep: one SQLite file, in which every point that was reported survives any failure.

SQLite, rather than Parquet or Zarr, because each commit is durable by itself (a write-ahead log, flushed to the disk
before the commit returns), it can be read while the sweep runs, a row may hold a text where another holds
numbers, and Python, R, Julia and every shell read it, such as ``pandas.read_sql("select * from points", connection)``.
Only the driver opens the file, so that it may lie on any local disk.

Tables: ``points`` (a row each: values of the keys, outcomes), ``sweep`` (the question, the versions),
``batches`` (points and seconds of each).  A second driver is refused by a lock that the operating system releases
whenever a process ends.
"""

import json
import os
import socket
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from filelock import FileLock, Timeout

from studies.record.status import Status
from studies.record.values import Columns
from studies.refusal import RunError, SceneError, refuse_if
from studies.results.content import provenance
from studies.sweeps.plan import Design

FILE, LOCK = "points.sqlite", "driver.lock"
BATCH = 10_000  # rows that are read at once
TABLES = """
create table if not exists sweep (name text primary key, value text not null);
create table if not exists batches (finished text default current_timestamp, points integer, seconds real);
"""


class Store:
    """The points of one sweep, in a folder whose lock it holds, or in memory."""

    def __init__(self, folder: Path | None, design: Design, identity: dict[str, str] | None = None):
        self.folder, self.names = folder, ("point", *design.question.keys, *design.question.outcomes)
        self._lock = None if folder is None else _lock(folder)
        self.path = None if folder is None else folder / FILE
        self._kept: Columns | None = None  # what a store in memory held when it was closed
        with self._explained():
            self.connection = sqlite3.connect(self.path or ":memory:")
        try:
            with self._explained():
                self.connection.execute("pragma journal_mode = wal")
                self.connection.execute("pragma synchronous = full")
                self.connection.executescript(TABLES)
            self._begin(design, identity or design.identity)
        except (SceneError, RunError):
            self._release()
            raise
        self._insert = f"insert or replace into points values ({', '.join('?' * len(self.names))})"

    def columns(self) -> Columns:
        """Return the rows in the order of their points, as columns, also after `close`; None for no value."""
        if self._kept is not None:
            return self._kept
        rows = chain.from_iterable(self.batches(self.names))
        return Columns(zip(self.names, map(list, zip(*rows, strict=True)), strict=True))

    def batches(self, names: Sequence[str]) -> Iterator[list[tuple]]:
        """Yield some columns of all rows in the order of their points, so many rows at a time, also after `close`."""
        if self._kept is not None:
            yield list(zip(*(self._kept[name] for name in names), strict=True))
            return
        connected = closing(sqlite3.connect(self.path)) if self.path else nullcontext(self.connection)
        chosen = ", ".join(f'"{name}"' for name in names)
        with self._explained("read"), connected as connection:
            rows = connection.execute(f"select {chosen} from points order by point")
            while some := rows.fetchmany(BATCH):
                yield some

    def rows(self, first: int, end: int) -> Iterator[Columns]:
        """Yield the rows of the points from ``first`` up to and without ``end``, as values by name."""
        wanted = "select * from points where point >= ? and point < ? order by point"
        rows = self._read(wanted, (first, end))
        yield from (Columns(zip(self.names, row, strict=True)) for row in rows)

    def close(self) -> None:
        """Close the file and release the lock; the rows of a store in memory stay."""
        if self.path is None:
            self._kept = self.columns()
        self._release()

    def _release(self) -> None:
        self.connection.close()
        if self._lock is not None:
            self._lock.release()

    def done(self, count: int):
        """Return which of the first `count` points have a row and were not lost with a worker, an array of bool."""
        done = np.zeros(count, bool)
        with self._explained("read"):
            rows = self.connection.execute(
                "select point from points where status not like ? and point < ?", (f"{Status.LOST.value}:%", count)
            )
            while some := rows.fetchmany(100_000):
                done[np.array(some)[:, 0]] = True
        return done

    def write(self, rows: list[tuple], batches: list[tuple[int, float]]) -> None:
        """Write rows (point, values, outcomes) and batches (points, seconds); durable on return."""
        with self._explained(), self.connection:
            self.connection.executemany(self._insert, ([_stored(each) for each in row] for row in rows))
            self.connection.executemany("insert into batches (points, seconds) values (?, ?)", batches)

    def counts(self) -> dict[str, int]:
        """Return the number of points of each `Status`."""
        rows = self._read(
            "select case when instr(status, ':') then substr(status, 1, instr(status, ':') - 1) else status end,"
            " count(*) from points group by 1 order by 2 desc"
        )
        return dict(rows)

    def cost(self) -> float:
        """Return the seconds that workers have spent, those of earlier drivers included."""
        return self._read("select coalesce(sum(seconds), 0.0) from batches")[0][0]

    def _read(self, question: str, values: tuple = ()) -> list[tuple]:
        with self._explained("read"):
            return self.connection.execute(question, values).fetchall()

    def _begin(self, design: Design, identity: dict[str, str]) -> None:
        """Write the question of the sweep; refuse a file that holds another sweep."""
        identity = identity | {f"version of {name}": version for name, version in provenance().items()}
        for (text,) in self._read("select value from sweep where name = 'identity'"):
            stored = json.loads(text)
            names = [name for name in stored | identity if stored.get(name) != identity.get(name)]
            what = f"its {', '.join(names)} {'differs' if len(names) == 1 else 'differ'}"
            refuse_if(names, "out", f"{str(self.folder)!r} holds another sweep: {what}; name another directory")
        question = design.question
        about: dict[str, Any] = {
            "identity": identity, "scene": question.table, "keys": question.keys, "tolerance": question.tolerance,
            "points": len(design), "driver": f"process {os.getpid()} on {socket.gethostname()}",
        }  # fmt: skip
        with self._explained(), self.connection:
            columns = ", ".join(f'"{name}"' for name in self.names[1:])
            self.connection.execute(f"create table if not exists points (point integer primary key, {columns})")
            self.connection.executemany(
                "insert or replace into sweep values (?, ?)",
                ((name, json.dumps(value)) for name, value in about.items()),
            )

    @contextmanager
    def _explained(self, done: str = "written"):
        """Raise a RunError in one sentence for a failure of the disk; ``done``: what cannot be done, "written", "read".

        A store that cannot be read holds what the disk has left of it.
        """
        try:
            yield
        except (sqlite3.DatabaseError, OSError) as error:
            hint = "is the disk full? Every point that was reported is kept; the same command goes on from there"
            if done == "read":
                hint = "copy what a reader of SQLite still gets out of it, and name another directory"
            raise RunError(f"the store {str(self.folder)!r} cannot be {done} ({error}): {hint}") from None


def _lock(folder: Path) -> FileLock:
    """Return the acquired lock of a folder, which ends with its process at the latest."""
    try:
        refuse_if(folder.exists() and not folder.is_dir(), "out", f"{str(folder)!r} is a file; name another directory")
        refuse_if(
            folder.exists() and any(folder.iterdir()) and not (folder / LOCK).exists(),
            "out",
            f"{str(folder)!r} holds something that is no sweep; name another directory",
        )
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / LOCK, timeout=0)
        lock.acquire()
        return lock
    except Timeout:
        hint = "wait for it, or name another directory"
        raise RunError(f"another sweep{_owner(folder)} is writing into {str(folder)!r}: {hint}") from None
    except OSError as error:
        raise SceneError("out", f"cannot write {str(folder)!r}: {error.strerror}") from None


def _owner(folder: Path) -> str:
    try:
        with closing(sqlite3.connect(f"file:{folder / FILE}?mode=ro", uri=True, timeout=0)) as reader:
            owner = reader.execute("select value from sweep where name = 'driver'").fetchone()
    except sqlite3.Error:
        return ""
    return "" if owner is None else f", {json.loads(owner[0])},"


def _stored(value):
    return json.dumps(value) if isinstance(value, (list, tuple, dict)) else value
