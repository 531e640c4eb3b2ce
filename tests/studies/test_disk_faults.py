"""A disk that fails, memory that is exhausted: at each operation of a run that replaces a former result; a full store.

The fault is raised by the operation itself (`io.open`, a write, a rename, ...), at every operation in turn, so that no
place is left out. Nothing of the user's is lost, the message is one sentence, and the next command repairs the rest.
"""

import errno
import io
import json
import os
import shutil
import sqlite3
import sys
from contextlib import closing

import pytest

import studies
from studies.__main__ import main
from studies.inverse.evaluations import Options
from studies.refusal import RunError, SceneError
from studies.results.directory import MANIFEST, read_manifest

OPERATIONS = ("rename", "replace", "mkdir", "unlink", "rmdir")  # of the module os; pathlib calls them
NOTE, FORMER = "my notes", "edited by hand"


class FailingFile:
    """A file whose writing fails; the rest is the file's."""

    def __init__(self, file, disk):
        self._file, self._disk = file, disk

    def write(self, text):
        """Write, if the disk lets it."""
        self._disk.operate()
        return self._file.write(text)

    def __getattr__(self, name):
        return getattr(self._file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def __iter__(self):
        return iter(self._file)


class Disk:
    """The operations on files below a folder; the one of a number fails, and all that follow where it is full."""

    def __init__(self, monkeypatch, folder, error):
        self.folder, self.error, self.count, self.fails = str(folder), error, 0, None
        plain = io.open

        def opened(file, mode="r", *arguments, **keywords):
            if not self._mine(file) or not set(mode) & set("wax+"):
                return plain(file, mode, *arguments, **keywords)
            self.operate()
            return FailingFile(plain(file, mode, *arguments, **keywords), self)

        for where in ("builtins.open", "io.open"):
            monkeypatch.setattr(where, opened)
        for name in OPERATIONS:
            monkeypatch.setattr(os, name, self._failing(getattr(os, name)))

    def _mine(self, path):
        return isinstance(path, str | os.PathLike) and os.fspath(path).startswith(self.folder)

    def _failing(self, function):
        def operation(path, *arguments, **keywords):
            if self._mine(path):
                self.operate()
            return function(path, *arguments, **keywords)

        return operation

    def operate(self):
        """Count an operation and raise if it is the one that fails."""
        self.count += 1
        if self.count - 1 == self.fails:
            raise type(self.error)(*self.error.args)


def written(folder):
    """Return the content of each file of a folder by name, but for what only a program that writes leaves."""
    files = (each for each in folder.rglob("*") if each.is_file() and not each.name.startswith(".sawmotor."))
    return {each.relative_to(folder).as_posix(): each.read_bytes() for each in files} | {
        MANIFEST: (folder / MANIFEST).read_bytes() if (folder / MANIFEST).exists() else b""
    }


def refuse_mixture(folder):
    """Fail where a directory with a run.json holds files of two runs."""
    if (folder / "run.json").exists():
        json.loads((folder / "run.json").read_text())
        missing = [name for name in read_manifest(folder)["files"] if not (folder / name).exists()]
        assert not missing


def told(status, said, reason, k) -> bool:
    """Return whether a call whose operation k fails has failed, which it must say in one sentence."""
    if status:
        assert status in (2, 3), (k, said)
        assert len(said) == 1, (k, said)
        assert reason in said[0], (k, said)
    return bool(status)


FAULTS = {
    "full": (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), os.strerror(errno.ENOSPC)),
    "broken": (OSError(errno.EIO, os.strerror(errno.EIO)), os.strerror(errno.EIO)),
    "memory": (MemoryError(), "needs more memory than this machine gives it"),
}


@pytest.mark.parametrize(("error", "reason"), FAULTS.values(), ids=FAULTS)
def test_no_failing_operation_of_a_run_loses_anything(error, reason, tmp_path, monkeypatch, capsys):
    former, folder = tmp_path / "former", tmp_path / "motor"
    words = ["run", "rayleigh", "--no-plot", "--out", str(folder)]
    assert main(words) == 0
    (folder / "note.txt").write_text(NOTE)
    (folder / "profile.csv").write_text(FORMER)  # a table that the user edited
    folder.rename(former)
    capsys.readouterr()
    changed = [*words, "--set", "drive.frequency=2.3e6"]
    record = studies.run(studies.Scene.load("rayleigh").replace(drive={"frequency": 2.3e6}))
    monkeypatch.setattr("studies.runs.run", lambda *_, **__: record)  # the disk is tested, not the solver

    failed, k = 0, 0
    while True:
        shutil.copytree(former, folder)
        with monkeypatch.context() as patch:
            disk = Disk(patch, folder, error)
            disk.fails = k
            status = main(changed)
        said = [line for line in capsys.readouterr().err.splitlines() if "warning" not in line]
        assert (folder / "note.txt").read_text() == NOTE
        assert FORMER in [each.read_text() for each in folder.glob("profile*.csv")]
        refuse_mixture(folder)
        failed += told(status, said, reason, k)
        assert main(changed) == 0, k
        assert (folder / "note.txt").read_text() == NOTE
        assert FORMER in [each.read_text() for each in folder.glob("profile*.csv")]
        assert json.loads((folder / "run.json").read_text())["scene"]["drive"]["frequency"] == 2.3e6
        refuse_mixture(folder)
        capsys.readouterr()
        shutil.rmtree(folder)
        if disk.count <= k:
            break
        k += 1
    assert failed > 8  # the two tables, run.json, the scene, the manifest, the moves


def test_no_failing_operation_of_a_design_is_a_defect(tmp_path, monkeypatch):
    motor = studies.Scene.load("twente-contact")
    options = Options(evaluations=12)
    best = studies.design(motor, ["velocity"], {"slider.preload": (4e-4, 1e-2)}, options=options)
    broken, folder = OSError(errno.EIO, os.strerror(errno.EIO)), tmp_path / "design"
    with monkeypatch.context() as patch:
        disk = Disk(patch, tmp_path, broken)
        best.write(folder)
    assert disk.count > 3  # the folder and three files
    for k in range(disk.count):
        shutil.rmtree(folder, ignore_errors=True)
        with monkeypatch.context() as patch:
            Disk(patch, tmp_path, broken).fails = k
            with pytest.raises(SceneError, match=f"cannot write .*: {os.strerror(errno.EIO)}"):
                best.write(folder)
    best.write(folder)


@pytest.mark.parametrize(("error", "reason"), FAULTS.values(), ids=FAULTS)
def test_no_failing_operation_of_a_fit_loses_anything(error, reason, tmp_path, monkeypatch, capsys):
    """The former fit, and what the user put beside it, stay as they are, or the new fit is there as a whole."""
    data, former, folder = tmp_path / "lab.csv", tmp_path / "former", tmp_path / "fit"
    data.write_text("normal_amplitude_m,velocity_m_per_s\n5e-9,0.022\n1e-8,0.06\n2e-8,0.14\n")
    words = ["fit", "twente-contact", "--data", str(data), "--free", "slider.friction_coefficient=0.02:0.3"]
    words += ["--no-next", "--no-plot", "--out", str(folder)]
    found = []
    fitted = studies.inverse.fit
    monkeypatch.setattr("studies.inverse.fit", lambda *of, **to: found.append(fitted(*of, **to)) or found[-1])
    assert main(words) == 0
    (folder / "note.txt").write_text(NOTE)
    folder.rename(former)
    before = written(former)
    capsys.readouterr()
    monkeypatch.setattr("studies.inverse.fit", lambda *_, **__: found[0])  # the disk is tested, not the solver

    failed, k = 0, 0
    while True:
        shutil.copytree(former, folder)
        with monkeypatch.context() as patch:
            disk = Disk(patch, folder, error)
            disk.fails = k
            status = main(words)
        said = [line for line in capsys.readouterr().err.splitlines() if "warning" not in line]
        kept = written(folder)
        assert (folder / "note.txt").read_text() == NOTE
        assert all(kept.get(name) == content for name, content in before.items() if name != MANIFEST), k
        failed += told(status, said, reason, k)
        assert main(words) == 0, k
        assert json.loads((folder / "fit.json").read_text())["parameters"]
        capsys.readouterr()
        shutil.rmtree(folder)
        if disk.count <= k:
            break
        k += 1
    assert failed > 5  # the table, the scene, fit.json, the manifest, the moves


class FailingConnection:
    """A connection to a store whose second write of a transaction fails, which SQLite then takes back."""

    def __init__(self, connection, error):
        self._connection, self._error, self._writes = connection, error, 0

    def executemany(self, question, rows):
        """Write, if it is the first time."""
        self._writes += 1
        if self._writes > 1:
            raise self._error
        return self._connection.executemany(question, rows)

    def __enter__(self):
        return self._connection.__enter__()

    def __exit__(self, *error):
        return self._connection.__exit__(*error)

    def __getattr__(self, name):
        return getattr(self._connection, name)


STORE_FAULTS = {
    "full": (None, RunError, "database or disk is full.*is the disk full"),
    "broken": (sqlite3.OperationalError("disk I/O error"), RunError, "cannot be written .disk I/O error"),
    "memory": (MemoryError(), MemoryError, "^$"),
}


@pytest.mark.parametrize(("fault", "raised", "said"), STORE_FAULTS.values(), ids=STORE_FAULTS)
def test_a_failing_store_keeps_the_points_that_were_reported(tmp_path, monkeypatch, fault, raised, said):
    """SQLite's own limit of pages stands for a full disk; other faults come in the midst of a transaction."""
    from studies.sweeps import store

    scene, keys = studies.Scene.load("twente-contact"), {"slider.load": [0.0, 1e-5, 2e-5, 3e-5, 4e-5]}
    whole = studies.sweep(scene, keys)
    kept = []
    write = store.Store.write

    def failing_after_two(self, rows, batches):
        if len(kept) >= 2 and fault is None:
            pages = self.connection.execute("pragma page_count").fetchone()[0]
            self.connection.execute(f"pragma max_page_count = {pages}")
            rows = [(*row[:-1], "long " * 20_000) for row in rows]
        elif len(kept) >= 2:
            self.connection = FailingConnection(self.connection, fault)
        write(self, rows, batches)
        kept.extend(rows)

    with monkeypatch.context() as patch:
        patch.setattr(store.Store, "write", failing_after_two)
        with pytest.raises(raised, match=said):
            studies.sweep(scene, keys, out=tmp_path / "sweep", workers=1)
    with closing(sqlite3.connect(tmp_path / "sweep" / store.FILE)) as connection:
        points = [row[0] for row in connection.execute("select point from points order by point")]
    assert points == sorted(row[0] for row in kept)
    assert 2 <= len(points) < 5
    again = studies.sweep(scene, keys, out=tmp_path / "sweep")
    assert again.columns() == whole.columns()


def test_a_store_that_cannot_be_read_is_one_sentence_and_stays(tmp_path, capsys):
    from studies.sweeps import store

    words = ["sweep", "twente-contact", "--over", "slider.load=[0,1e-5,2e-5]", "--out", str(tmp_path / "sweep")]
    assert main(words) == 0
    file = tmp_path / "sweep" / store.FILE
    content = file.read_bytes()
    page = 4096
    damaged = content[:page] + b"\xff" * (len(content) - page)  # the head of the file, and no table
    file.write_bytes(damaged)
    capsys.readouterr()
    assert main(words) == 3
    (said,) = capsys.readouterr().err.splitlines()
    assert "cannot be read (database disk image is malformed)" in said
    assert file.read_bytes() == damaged
    file.write_bytes(content)  # from the backup: the lock is free
    assert main(words) == 0


def test_exhausted_memory_is_one_sentence(monkeypatch, capsys):
    def exhausted(*_, **__):
        raise MemoryError

    monkeypatch.setattr("studies.runs.run", exhausted)
    assert main(["run", "rayleigh", "--json"]) == 3
    said = capsys.readouterr().err.splitlines()
    assert said == ["sawmotor: the run needs more memory than this machine gives it; a looser --tolerance needs less"]
    assert sys.exc_info() == (None, None, None)
