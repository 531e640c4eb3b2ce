"""A file of measured values that an option of the command names: how it is refused stands here, once."""

from pathlib import Path
from typing import Any

from studies.refusal import SceneError, reading


class InputFile:
    """A file, and the option or the key that names it."""

    path: Path
    option: str

    def __init__(self, path: Path, option: str) -> None:
        self.path, self.option = path, option

    def error(self, rule: str, line: int | None = None) -> SceneError:
        """Return the error that this file, or one of its lines, breaks a rule."""
        where = "" if line is None else f"line {line}: "
        return SceneError(self.option, f"{str(self.path)!r} {where}{rule}")

    def refuse_if(self, broken: Any, rule: str, line: int | None = None) -> None:
        """Raise the `error` if a condition holds."""
        if broken:
            raise self.error(rule, line)


def file_lines(path: Path, option: str) -> list[str]:
    """Return the lines of a text in UTF-8, UTF-16 or Latin-1, as instruments write it."""
    with reading(path, option):
        content = path.read_bytes()
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return content.decode("utf-16", errors="replace").splitlines()
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return content.decode("latin-1").splitlines()
