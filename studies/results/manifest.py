"""The manifest of a directory of results: which files the program wrote there, and what they belong to.

``.sawmotor.json`` holds kind and name of the result, the scene's file relative to the directory, and the SHA-256 of
every file that the program wrote there.
"""

import hashlib
import json
import os
from dataclasses import dataclass
from os.path import lexists
from pathlib import Path

MANIFEST, LOCK = ".sawmotor.json", ".sawmotor.lock"
WORK, FORMER = ".sawmotor.work", ".sawmotor.former"  # folders, present only while a program writes
HIDDEN = frozenset({MANIFEST, f"{MANIFEST}.new", LOCK, WORK, FORMER})
KEYS = ("kind", "name", "source")


@dataclass(frozen=True, kw_only=True)
class Origin:
    """What a result belongs to."""

    kind: str  # "run" or "study"
    name: str  # of the scene or the study
    source: Path | None = None  # the scene's file; None for what has none, such as a scene that ships

    def described(self, folder: Path) -> dict:
        """Return the origin in terms of JSON, the source relative to the directory of the result."""
        content = {"kind": self.kind, "name": self.name}
        if self.source is not None:
            content["source"] = relative(self.source.resolve(), folder.resolve())
        return content


def read_manifest(folder: Path) -> dict:
    """Return the manifest of a directory; empty where there is none."""
    try:
        content = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    sound = isinstance(content, dict) and isinstance(content.get("files"), dict)
    return content if sound else {}


def write_manifest(folder: Path, manifest: dict) -> None:
    """Write a manifest, or remove it where it is empty."""
    if not manifest:
        (folder / MANIFEST).unlink(missing_ok=True)
        return
    half = folder / f"{MANIFEST}.new"
    half.write_text(json.dumps(manifest, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    half.replace(folder / MANIFEST)


def origin_of(manifest: dict) -> dict:
    """Return what a manifest says about the origin of its result."""
    return {key: manifest[key] for key in KEYS if key in manifest}


def named(origin: dict) -> str:
    """Return an origin as part of a sentence."""
    source = f" (scene {origin['source']}, relative to it)" if "source" in origin else ""
    return f"the {origin.get('kind', 'result')} {origin.get('name', '')}{source}"


def files_below(folder: Path) -> list[str]:
    """Return the names of all files below a folder, relative to it."""
    files = (each for each in folder.rglob("*") if each.is_symlink() or not each.is_dir())
    return sorted(each.relative_to(folder).as_posix() for each in files)


def free_name(place: Path) -> Path:
    """Return a name that is free beside a file: velocity.former.csv, velocity.former-2.csv, ..."""
    number, other = 1, place.with_name(f"{place.stem}.former{place.suffix}")
    while lexists(other):
        number += 1
        other = place.with_name(f"{place.stem}.former-{number}{place.suffix}")
    return other


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def relative(path: Path, folder: Path) -> str:
    """Return a path relative to a folder, or itself where they are on different drives."""
    try:
        return os.path.relpath(path, folder)
    except ValueError:
        return str(path)
