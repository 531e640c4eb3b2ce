"""A directory of results: a command writes into a hidden work folder, and ``commit`` moves the files to their names.

One rename of the work folder decides a commit.  The moves that follow are completed after an interrupt, or by the next
command that opens the directory if the process dies before.  The manifest lists every file that the program wrote, with
its SHA-256.  Files that it lists and that are unchanged are replaced.  A file of anybody else that has the name of a
new one, such as a table that was edited, is renamed (``velocity.former.csv``); all other files stay.  ``run.json`` or
``study.json`` is removed first and moved last: the files of a directory that has one belong together.
"""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from os.path import lexists
from pathlib import Path
from typing import Any

from fem.parameters import refuses
from studies.refusal import RunError, SceneError

MARKS = {"run.json": "run", "study.json": "study"}  # file whose presence makes a directory a result: kind
MANIFEST, LOCK = ".sawmotor.json", ".sawmotor.lock"
WORK, READY = ".sawmotor.work", ".sawmotor.ready"  # folders, present only while a program writes
HIDDEN = {MANIFEST, LOCK, WORK, READY}
NAMES_SHOWN = 6  # in a message


@dataclass(frozen=True, kw_only=True)
class Origin:
    """The run, study or export that a result belongs to."""

    kind: str  # "run", "study" or "export"
    name: str  # of the scene or the study
    source: Path | None = None  # the scene's file; None for a scene that ships

    def described(self, folder: Path) -> dict:
        """Return the origin in terms of JSON, the source relative to the directory of the result."""
        if self.source is None:
            return {"kind": self.kind, "name": self.name}
        source = str(self.source.resolve())
        with suppress(ValueError):  # on another drive it has no relative path
            source = os.path.relpath(source, folder.resolve())
        return {"kind": self.kind, "name": self.name, "source": source}


def read_manifest(folder: Path) -> dict:
    """Return kind, name, source and files (name: SHA-256) of the result in a folder; empty where there is none."""
    with suppress(OSError, ValueError):
        content = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        if isinstance(content, dict) and isinstance(content.get("files"), dict):
            return content
    return {}


@dataclass(kw_only=True)
class ResultDirectory:
    """A directory that is being written."""

    folder: Path  # to write into; exists and is empty
    target: Path  # of the files after a commit
    origin: Origin
    # sentences for the user: what was replaced, renamed and left alone
    notes: list[str] = field(default_factory=list)
    _written: dict[str, str] = field(default_factory=dict)  # name: SHA-256, by earlier commits

    def commit(self) -> None:
        """Move all files of the work folder to the target; the first commit replaces the former result."""
        first, former = not self._written, read_manifest(self.target)
        self._written |= {name: _digest(self.folder / name) for name in _files_below(self.folder)}
        about = {"program": "sawmotor", **self.origin.described(self.target), "files": self._written}
        (self.folder / MANIFEST).write_text(json.dumps(about, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        for name in self._written:  # before the rename that decides, because it needs space and permission
            (self.target / name).parent.mkdir(parents=True, exist_ok=True)
        self.folder.rename(self.target / READY)
        replaced, renamed = _complete(self.target)
        self.folder.mkdir()
        if first and replaced:
            of = "" if _origin(former) == _origin(about) else f" of {_named(former)}"
            self.notes.append(f"replaced the former result in {self.target}: {_listed(replaced)}{of}")
        if renamed:
            pairs = [f"{name} is now {new_name}" for name, new_name in renamed.items()]
            self.notes.append(f"kept in {self.target}, as sawmotor did not write them: {_listed(pairs)}")
        known = {name.split("/")[0] for name in (*self._written, *renamed.values())} | HIDDEN
        others = sorted(each.name for each in self.target.iterdir() if each.name not in known)
        if first and others and (replaced or renamed):
            self.notes.append(f"left as they were in {self.target}: {_listed(others)}")


@contextmanager
def result_directory(path: str | Path, origin: Origin, *, named_by_user: bool = True) -> Iterator[ResultDirectory]:
    """Provide a directory to write into; only committed files stay.

    ``named_by_user`` is False for a default directory: there a result of another origin is refused (SceneError), not
    replaced.
    SceneError if the directory cannot be written or holds something that is no result; RunError if another run writes
    there, or if writing fails later, as on a full disk.
    """
    from filelock import FileLock, Timeout  # brings asyncio along, 20 ms: a run with --json needs neither

    target = Path(path).absolute()
    made = [parent for parent in (target, *target.parents) if not parent.exists()]
    lock, ready = None, False
    try:
        _refuse_others(target, origin, named_by_user=named_by_user)
        target = target.resolve()
        target.mkdir(parents=True, exist_ok=True)
        lock = FileLock(target / LOCK, timeout=0)
        lock.acquire()
        _complete(target)
        shutil.rmtree(target / WORK, ignore_errors=True)
        (target / WORK).mkdir()
        ready = True
        yield ResultDirectory(folder=target / WORK, target=target, origin=origin)
    except Timeout:
        hint = "wait for it, or name another directory with --out"
        raise RunError(f"another run is writing into {str(target)!r}: {hint}") from None
    except OSError as error:
        sentence = f"the result directory {str(path)!r} cannot be written: {error.strerror or error}"
        raise (RunError(sentence) if ready else SceneError("", sentence)) from None
    finally:
        if lock is not None and lock.is_locked:
            try:
                with suppress(OSError):
                    _complete(target)  # of a commit that was interrupted
                shutil.rmtree(target / WORK, ignore_errors=True)
                with suppress(OSError):  # the lock ends with its process; its file does no harm
                    (target / LOCK).unlink(missing_ok=True)
            finally:  # exhausted memory is no OSError
                lock.release()
        for folder in made:
            with suppress(OSError):
                folder.rmdir()  # only if empty


def _complete(target: Path) -> tuple[list[str], dict[str, str]]:
    """Move the files of a decided commit to their names; return replaced names, and the new names of a user's files."""
    ready, former, new = target / READY, read_manifest(target), read_manifest(target / READY)
    if not new:
        return [], {}
    waiting = [name for name in _files_below(ready) if name != MANIFEST]
    stale = [name for name in former.get("files", {}) if name not in new["files"]]
    replaced, renamed = [], {}
    for name in sorted({*waiting, *stale}, key=lambda each: (each not in MARKS, each)):
        path = target / name
        if path.is_file() and not path.is_symlink() and _digest(path) == former.get("files", {}).get(name):
            replaced.append(name)
            if name in stale or name in MARKS:
                path.unlink()
        elif lexists(path) and name in waiting:
            renamed[name] = path.rename(_free_name(path)).name
    for name in [*sorted(waiting, key=MARKS.__contains__), MANIFEST]:
        (ready / name).replace(target / name)
    for folder in {folder for name in stale for folder in list(Path(name).parents)[:-1]}:
        with suppress(OSError):  # a folder that is not empty stays
            (target / folder).rmdir()
    shutil.rmtree(ready)
    return sorted(replaced), renamed


@refuses(SceneError)
def _refuse_others(target: Path, origin: Origin, *, named_by_user: bool) -> Iterator[Any]:
    """Refuse a directory that holds no result; as a default directory also one that holds another result."""
    if not target.exists():
        return
    if not target.is_dir():
        yield "", f"the result directory {str(target)!r} cannot be written: a file of that name exists"
    names = {each.name for each in target.iterdir()}
    former = read_manifest(target / READY) or read_manifest(target)
    kinds = [kind for mark, kind in MARKS.items() if mark in names]
    if names - HIDDEN and not kinds and not former:
        hint = "files that are not a result of sawmotor; name another"
        yield "", f"the result directory {str(target)!r} holds {hint}"
    if named_by_user:
        return
    if former and _origin(former) != origin.described(target):
        choice = f"--out {os.path.relpath(target)} replaces it, another --out keeps both"
        yield "--out", f"is needed: {str(target)!r} holds {_named(former)}; {choice}"
    if not former and kinds and origin.kind not in kinds:
        yield "--out", f"is needed: {str(target)!r} holds the result of a {kinds[0]}"


def _origin(manifest: dict) -> dict:
    return {key: manifest[key] for key in ("kind", "name", "source") if key in manifest}


def _named(manifest: dict) -> str:
    source = f" (scene {manifest['source']}, relative to it)" if "source" in manifest else ""
    return f"the {manifest.get('kind', 'result')} {manifest.get('name', '')}{source}"


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(names[:NAMES_SHOWN]) + more


def _files_below(folder: Path) -> list[str]:
    return sorted(each.relative_to(folder).as_posix() for each in folder.rglob("*") if not each.is_dir())


def _free_name(path: Path) -> Path:
    """Return an unused name beside a file: velocity.former.csv, velocity.former-2.csv, ..."""
    number, other = 1, path.with_name(f"{path.stem}.former{path.suffix}")
    while lexists(other):
        number += 1
        other = path.with_name(f"{path.stem}.former-{number}{path.suffix}")
    return other


def _digest(path: Path) -> str:
    import hashlib  # 3 ms, and a check writes no directory

    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
