"""A directory that is written: a hidden work folder, from which ``commit`` moves the files into place.

A commit replaces only files that the manifest lists and that are unchanged since.  Whatever else has the name of a new
file, such as a table that was edited or a file from before there were manifests, is renamed
(``velocity.former.csv``).  All other files stay.  ``run.json`` or ``study.json`` is moved last, so that a directory
that has one is whole.
"""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from os.path import lexists
from pathlib import Path
from typing import TYPE_CHECKING

from studies.refusal import RunError, SceneError
from studies.results.manifest import (
    FORMER,
    HIDDEN,
    LOCK,
    WORK,
    Origin,
    digest,
    files_below,
    free_name,
    named,
    origin_of,
    read_manifest,
    relative,
    write_manifest,
)

if TYPE_CHECKING:
    from filelock import FileLock

MARKS = {"run.json": "run", "study.json": "study"}  # file whose presence makes a directory a result: kind
NAMES_SHOWN = 6  # in a message


@dataclass(kw_only=True)
class ResultDirectory:
    """A directory that is being written."""

    folder: Path  # where to write; exists and is empty
    target: Path  # where the files shall be
    origin: Origin
    # sentences for the user: what was replaced, renamed and left alone
    notes: list[str] = field(default_factory=list)
    _written: dict[str, str] = field(default_factory=dict)  # name: SHA-256, by earlier commits

    def commit(self) -> None:
        """Move all files of the work folder into place; the first commit replaces the former result."""
        former = read_manifest(self.target)
        new = {name: digest(self.folder / name) for name in files_below(self.folder)}
        replaced, foreign = self._in_the_way(new, former.get("files", {}))
        about = {"program": "sawmotor", **self.origin.described(self.target), "files": self._written | new}
        renamed = {name: free_name(self.target / name) for name in foreign}
        away = [(self.target / name, self.target / FORMER / name) for name in sorted(replaced, key=_marks_first)]
        away += [(self.target / name, place) for name, place in renamed.items()]
        into = [(self.folder / name, self.target / name) for name in reversed(sorted(new, key=_marks_first))]
        try:
            for source, place in away:
                move(source, place)
            write_manifest(self.target, about)
            for source, place in into:
                move(source, place)
        except BaseException:
            for source, place in reversed(away + into):
                if lexists(place) and not lexists(source):
                    place.rename(source)
            write_manifest(self.target, former)
            _recover(self.target)
            raise
        shutil.rmtree(self.target / FORMER, ignore_errors=True)
        for name in replaced:
            with suppress(OSError):  # a folder that is not empty stays
                for folder in list(Path(name).parents)[:-1]:
                    (self.target / folder).rmdir()
        self._note(former, about, replaced, {name: place.name for name, place in renamed.items()})
        self._written |= new

    def _in_the_way(self, new: dict, former: dict) -> tuple[list[str], list[str]]:
        """Return the files that the commit replaces, and those of other origin that it renames."""
        stale = {} if self._written else former
        replaced, foreign = [], []
        for name in sorted(new | stale):
            place = self.target / name
            if not lexists(place):
                continue
            ours = name in former and place.is_file() and not place.is_symlink()
            if ours and digest(place) == former[name]:
                replaced.append(name)
            elif name in new:
                foreign.append(name)
        return replaced, foreign

    def _note(self, former: dict, about: dict, replaced: list[str], renamed: dict[str, str]) -> None:
        if replaced and not self._written:
            then, now = origin_of(former), origin_of(about)
            of = "" if then == now else f" of {named(then)}"
            self.notes.append(f"replaced the former result in {self.target}: {_listed(replaced)}{of}")
        if renamed:
            pairs = [f"{name} is now {kept}" for name, kept in renamed.items()]
            self.notes.append(f"kept in {self.target}, as sawmotor did not write them: {_listed(pairs)}")
        known = {name.split("/")[0] for name in (*about["files"], *renamed.values())} | HIDDEN
        others = sorted(each.name for each in self.target.iterdir() if each.name not in known)
        if others and not self._written and (replaced or renamed):
            self.notes.append(f"left as they were in {self.target}: {_listed(others)}")


class DirectoryInUseError(Exception):
    """Another process holds the lock."""


def locked(file: Path) -> "FileLock":
    """Return the held lock of a file, made if absent, until it is released or its process ends, however it ends.

    Raises DirectoryInUseError if somebody else holds it, OSError if the file cannot be written.
    """
    from filelock import FileLock, Timeout  # brings asyncio along, 20 ms: a run with --json needs neither

    lock = FileLock(file, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise DirectoryInUseError(str(file)) from None
    return lock


@contextmanager
def result_directory(path: str | Path, origin: Origin, *, named_by_user: bool = True) -> Iterator[ResultDirectory]:
    """Lend a directory to write into; only what is committed stays.

    ``named_by_user`` is False for a default directory: there a result of another origin is refused (SceneError), not
    replaced.
    SceneError if the directory cannot be written or holds something that is no result; RunError if another run writes
    there, or if writing fails later, as on a full disk.
    """
    target = Path(path).absolute()
    made = [parent for parent in (target, *target.parents) if not parent.exists()]
    lock, lent = None, False
    try:
        try:
            _refuse_others(target, origin, named_by_user=named_by_user)
            target = target.resolve()
            target.mkdir(parents=True, exist_ok=True)
            lock = locked(target / LOCK)
            _recover(target)
            shutil.rmtree(target / WORK, ignore_errors=True)
            (target / WORK).mkdir()
            lent = True
            yield ResultDirectory(folder=target / WORK, target=target, origin=origin)
        except DirectoryInUseError:
            raise RunError(
                f"another run is writing into {str(target)!r}: wait for it, or name another directory with --out"
            ) from None
        except OSError as error:
            sentence = f"the result directory {str(path)!r} cannot be written: {error.strerror or error}"
            raise (RunError(sentence) if lent else SceneError("", sentence)) from None
    finally:
        if lock is not None:
            shutil.rmtree(target / WORK, ignore_errors=True)
            (target / LOCK).unlink(missing_ok=True)
            lock.release()
        for folder in made:
            with suppress(OSError):
                folder.rmdir()  # only if empty


def _refuse_others(target: Path, origin: Origin, *, named_by_user: bool) -> None:
    """Refuse a directory that holds no result, and as a default one that holds another's."""
    if not target.exists():
        return
    if not target.is_dir():
        raise SceneError("", f"the result directory {str(target)!r} cannot be written: a file of that name exists")
    held, then = {each.name for each in target.iterdir()}, origin_of(read_manifest(target))
    kinds = [kind for mark, kind in MARKS.items() if mark in held]
    if held - HIDDEN and not kinds and not then:
        raise SceneError(
            "", f"the result directory {str(target)!r} holds files that are not a result of sawmotor; name another"
        )
    if named_by_user:
        return
    if then and then != origin.described(target):
        choice = f"--out {relative(target, Path.cwd())} replaces it, another --out keeps both"
        raise SceneError("--out", f"is needed: {str(target)!r} holds {named(then)}; {choice}")
    if not then and kinds and origin.kind not in kinds:
        raise SceneError("--out", f"is needed: {str(target)!r} holds the result of a {kinds[0]}")


def _recover(target: Path) -> None:
    """Put back what a commit that did not end had moved away."""
    for name in files_below(target / FORMER):
        place = target / name
        if lexists(place):
            place = free_name(place)
        place.parent.mkdir(parents=True, exist_ok=True)
        (target / FORMER / name).rename(place)
    shutil.rmtree(target / FORMER, ignore_errors=True)


def move(source: Path, place: Path) -> None:
    """Move a file, the folder that it goes to made if absent."""
    place.parent.mkdir(parents=True, exist_ok=True)
    source.rename(place)


def _marks_first(name: str) -> tuple[bool, str]:
    """Return a key to sort names by: marks move away first and, in reverse, into place last."""
    return name not in MARKS, name


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(names[:NAMES_SHOWN]) + more
