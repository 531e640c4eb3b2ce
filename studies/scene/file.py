"""A scene file: its TOML table, and the line of every key for messages."""

import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from studies.refusal import SceneError, refuse_unknown, shown, suggestion, writing
from studies.scene.lines import key_lines, line_of
from studies.scene.override import replaced, setting_of, walk
from studies.scene.syntax import explained

SHIPPED = Path(__file__).parents[1] / "scenes"
# Keys that name a file, with the ending that its name must have to be one
FILES = {
    re.compile(r"piece\.\d+\.file|slider\.(?:pillars|roughness)\.file|(?:drive|wave)\.waveform\.file"): "",
    re.compile(r"slider\.(normal_)?law"): ".py",
    re.compile(r"stator\.material|piece\.\d+\.materials\.[^.]+"): ".toml",
}
MOST_NAMED = 5  # files beside one that does not exist
SCHEMA = "schema.json"  # beside the shipped scenes, which name it in their first line


@dataclass(frozen=True, kw_only=True)
class SceneFile:
    """The TOML document of a scene, not yet checked."""

    path: Path
    table: dict = field(repr=False)  # its keys and values
    text: str = field(repr=False)
    # Keys that the command line changed: their faults are not in the file
    changed: tuple[str, ...] = ()

    @classmethod
    def read(cls, source: str | Path) -> Self:
        """Read a file or a shipped scene; SceneError if it does not exist or cannot be decoded or parsed."""
        path = scene_path(source)
        text = _text(path)
        try:
            table = _with_absolute_paths(tomllib.loads(text), path)
            return cls(path=path, table=table, text=text)
        except tomllib.TOMLDecodeError as error:
            line, sentence = explained(text, error)
            raise SceneError("", sentence, f"{path}, line {line}") from None
        except (RecursionError, ValueError) as error:
            raise SceneError("", f"the scene {str(path)!r} is not TOML: {str(error)[:200]}") from None

    @cached_property
    def lines(self) -> dict[str, int]:
        """Line of every dotted key; half of the time of reading, for messages alone."""
        return key_lines(self.text)

    def replaced(self, key: str, value: Any) -> Self:
        """Return the file with the value at a dotted key replaced."""
        return replace(self, table=replaced(self.table, key, value), changed=(*self.changed, key))

    def assigned(self, setting: str) -> Self:
        """Return the file with one key changed as ``--set KEY=VALUE`` does."""
        return self.replaced(*setting_of(setting))

    @contextmanager
    def located(self) -> Iterator[None]:
        """Add file and line to every fault raised inside, and order the faults by line."""
        try:
            yield
        except SceneError as error:
            located = []
            for problem in error.problems:
                inside = any(f"{problem.path}.".startswith(f"{key}.") for key in self.changed)
                line = None if problem.location or inside else line_of(problem.path, self.lines)
                location = problem.location if line is None else f"{self.path}, line {line}"
                located.append((line or 0, SceneError(problem.path, problem.rule, location)))
            located.sort(key=lambda pair: pair[0])
            raise SceneError.together(problem for _, problem in located) from None


def _with_absolute_paths(table: dict, scene: Path) -> dict:
    """Return a scene's table with absolute paths of its files, so that it runs in any working directory."""
    for key, name in walk(table):
        endings = [ending for keys, ending in FILES.items() if keys.fullmatch(key)]
        if endings and isinstance(name, str) and name and name.endswith(endings[0]) and not Path(name).is_absolute():
            table = replaced(table, key, str((scene.parent / name).resolve()))
    return table


def shipped_scenes() -> dict[str, Path]:
    """Return the files of the scenes that ship, by name."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def scene_path(source: str | Path) -> Path:
    """Return the file of a scene from its path or shipped name."""
    if not isinstance(source, (str, Path)):
        raise SceneError("", f"a scene is a Scene, a file or the name of one that ships, got {shown(source)}")
    shipped, path = shipped_scenes(), Path(source)
    if path.is_file():
        return path
    if str(source) in shipped:
        return shipped[str(source)]
    if path.is_dir():
        resolved = path / "scene.toml"  # of a run
        hint = f"; did you mean {str(resolved)!r}?" if resolved.is_file() else ""
        raise SceneError("", f"{shown(str(source))} is a directory, not a scene file{hint}")
    beside = {each.name: str(each) for each in sorted(path.parent.glob("*.toml"))} if path.parent.is_dir() else {}
    # names alone are compared: with their folder all files of one folder resemble each other
    similar = suggestion(path.name, [*beside, *shipped])
    if similar is not None:
        hint = f"; did you mean {beside.get(similar, similar)}?"
    else:
        hint, own = f"; shipped: {', '.join(shipped)}", list(beside.values())
        hint += f"; files there: {', '.join(own[:MOST_NAMED])}" if own else ""
        hint += ", ..." if len(own) > MOST_NAMED else ""
    raise SceneError("", f"no scene file or shipped scene is named {shown(str(source))}{hint}")


def copied(name: str, file: Path) -> list[Path]:
    """Write a shipped scene into a new file, with the comment by which an editor finds the JSON Schema.

    Its meshes are written beside it, each with the script of the same name that made it.

    Returns
    -------
    list of Path
        The files that were written, the scene first. A mesh or script that exists with the same content is left
        as it is.

    Raises
    ------
    SceneError
        If no shipped scene has the name, if a file exists with another content, or if one cannot be written.
    """
    shipped = shipped_scenes()
    refuse_unknown(name, shipped, "--copy", f"no shipped scene is named {shown(name)}")
    text = shipped[name].read_text(encoding="utf-8")
    uri = (SHIPPED / SCHEMA).resolve().as_uri()
    text = text.replace(f"#:schema {SCHEMA}\n", f"#:schema {uri}\n", 1)
    contents = {file: text.encode()}
    for piece in tomllib.loads(text).get("piece", []):
        mesh = Path(piece["file"])
        beside = sorted((SHIPPED / mesh).parent.glob(f"{mesh.stem}.*"))
        contents |= {file.parent / mesh.parent / each.name: each.read_bytes() for each in beside}
    new = [each for each in contents if each == file or not each.is_file() or each.read_bytes() != contents[each]]
    for path in new:
        if path.exists():
            raise SceneError("--copy", f"does not overwrite {str(path)!r}, which exists: name another file or folder")
    for path in new:
        with writing(path, "--copy"):
            if path != file:
                path.parent.mkdir(exist_ok=True)
            path.write_bytes(contents[path])
    return new


def read_table(source: str | Path) -> dict:
    """Return the TOML document of a scene, not yet checked."""
    return SceneFile.read(source).table


def _text(path: Path) -> str:
    """Return the text of a file without a byte-order mark, lines ended by one character."""
    content, why = b"", None
    try:
        content = path.read_bytes()
    except OSError as error:
        why = error.strerror
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        why = "it is UTF-16 text; save it as UTF-8"
    if why is not None:
        raise SceneError("", f"the scene {str(path)!r} cannot be read: {why}")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise SceneError("", "a character is not UTF-8 text; save the file as UTF-8", f"{path}, line {line}") from None
