"""A directory of results, written whole or not at all.

Files go into a temporary directory beside the final one, which takes its name at the end; a former result
of that name is replaced.  A directory that holds anything else is never touched.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from studies.refusal import RunError

__all__ = ["MARKS", "result_directory"]

MARKS = ("run.json", "study.json")  # a directory with one of these is a former result


@contextmanager
def result_directory(path: str | Path) -> Iterator[Path]:
    """Lend a directory to write into; it takes the path's place when the block ends without an exception.

    Parameters
    ----------
    path : str or Path
        Where the result shall be.

    Yields
    ------
    Path
        An empty directory beside it.

    Raises
    ------
    RunError
        If the place cannot be written, or holds something that is no result.
    """
    target = Path(path).absolute()
    made = [parent for parent in target.parents if not parent.exists()]
    try:
        _refuse_strangers(target)
        target = target.resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
        folder.chmod(0o777 & ~_umask())
    except OSError as error:
        raise RunError(f"the result directory {str(path)!r} cannot be written: {error.strerror}") from None
    try:
        yield folder
        _take_place(folder, target)
    except OSError as error:
        raise RunError(
            f"the result directory {str(path)!r} cannot be written: {error.strerror or error}"
        ) from None
    finally:
        if folder.exists():
            shutil.rmtree(folder, ignore_errors=True)
            for parent in made:
                _remove_if_empty(parent)


def _refuse_strangers(target: Path) -> None:
    if not target.exists():
        return
    if not target.is_dir():
        raise RunError(f"the result directory {str(target)!r} cannot be written: a file of that name exists")
    if any(target.iterdir()) and not any((target / mark).is_file() for mark in MARKS):
        raise RunError(
            f"the result directory {str(target)!r} holds something that is no former result; name another"
        )


def _take_place(folder: Path, target: Path) -> None:
    if not target.exists():
        folder.rename(target)
        return
    former = Path(tempfile.mkdtemp(prefix=f".{target.name}.former.", dir=target.parent))
    target.rename(former / "result")
    try:
        folder.rename(target)
    except OSError:
        (former / "result").rename(target)
        raise
    finally:
        shutil.rmtree(former, ignore_errors=True)


def _remove_if_empty(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError:
        return


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
