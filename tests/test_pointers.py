"""What a docstring or a document names in backquotes exists: files, modules, functions, and commands of the program."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("fem", "contact", "studies", "tests")
FILE = re.compile(r"`{1,2}((?:[\w-]+/)+[\w-]+\.(?:py|md|toml|html|json))`{1,2}")
NAME = re.compile(r"`{1,2}(\w+(?:\.\w+)+)(?:\(\))?`{1,2}")
ENDINGS = ("py", "md", "toml", "csv", "json", "png", "html", "vtu", "gif", "msh")
WRITTEN = ("results/", "DIR/")  # by the program, not in the repository
SOURCES = sorted(
    path.relative_to(ROOT)
    for folder in PACKAGES
    for ending in ("py", "md")
    for path in (ROOT / folder).rglob(f"*.{ending}")
)


@pytest.mark.parametrize("folder", [*PACKAGES, "README.md"])
def test_what_is_named_exists(folder):
    named = [path for path in SOURCES if path.parts[0] == folder] or [Path(folder)]
    missing = [f"{path}: {each}" for path in named for each in missing_of(path)]
    assert not missing, "\n".join(missing)


def missing_of(path: Path) -> list[str]:
    """Return the files and names in backquotes of a source that do not exist."""
    text = (ROOT / path).read_text(encoding="utf-8")
    folders = [ROOT / parent for parent in path.parents]
    files = [
        name
        for name in FILE.findall(text)
        if not name.startswith(WRITTEN) and not any((folder / name).exists() for folder in folders)
    ]
    return files + [name for name in NAME.findall(text) if not known(name)]


def known(name: str) -> bool:
    """Return whether a dotted name is no pointer into these packages, or one that leads somewhere."""
    first, *_, last = name.split(".")
    return first not in PACKAGES or last in ENDINGS or found(name)


def found(name: str) -> bool:
    """Return whether a dotted name is a module, or an attribute of one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            value = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[count:]:
            if not hasattr(value, attribute) and attribute not in getattr(value, "__dataclass_fields__", {}):
                return False
            value = getattr(value, attribute, None)
        return True
    return False


def test_a_pointer_to_nothing_is_seen():
    assert not found("contact.answers.steady.nothing")
    assert not known("fem.nothing")
    assert known("contact.answers.steady")
    assert known("numpy.linalg")
