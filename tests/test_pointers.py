"""What a docstring, a comment or a document names exists: files, also without backquotes, modules and functions."""

import ast
import importlib
import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("fem", "contact", "studies", "tests")
FILE = re.compile(r"`{1,2}((?:[\w-]+/)+[\w-]+\.(?:py|md|toml|html|json))`{1,2}")
NAME = re.compile(r"`{1,2}(\w+(?:\.\w+)+)(?:\(\))?`{1,2}")
BARE = re.compile(r"(?<![\w/.*])((?:[\w-]+/)*[\w-]+\.py)\b")
# files of a user, in examples
EXAMPLES = {"FILE.py", "my_law.py", "my_controller.py", "viscous.py", "plain.py"}
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


NAMES = {path.name for path in SOURCES} | {path.name for path in ROOT.glob("*.py")}


@pytest.mark.parametrize("folder", PACKAGES)
def test_a_file_that_prose_names_exists(folder):
    missing = [
        f"{path}: {name}"
        for path in SOURCES
        if path.parts[0] == folder
        for name in bare_names((ROOT / path).read_text(encoding="utf-8"), path.suffix)
        if not exists(name, path)
    ]
    assert not missing, "\n".join(missing)


def bare_names(text: str, ending: str) -> list[str]:
    """Return the Python files that a document, or the comments and docstrings of a source, name."""
    if ending == ".py":
        comments = (
            token.string
            for token in tokenize.generate_tokens(io.StringIO(text).readline)
            if token.type == tokenize.COMMENT
        )
        kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
        docstrings = (ast.get_docstring(node) or "" for node in ast.walk(ast.parse(text)) if isinstance(node, kinds))
        text = "\n".join([*comments, *docstrings])
    return [name for name in BARE.findall(text) if name not in EXAMPLES]


def exists(name: str, path: Path) -> bool:
    """Return whether a file that a source names is one of ours: by its name alone, or by a path from some folder on."""
    if "/" not in name:
        return name in NAMES
    return any((ROOT / folder / name).exists() for folder in (*path.parents, *PACKAGES))


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
    assert bare_names("x = 'gone.py'  # as absent.py\n", ".py") == ["absent.py"]
    assert not exists("absent.py", Path("fem/geometry.py"))
    assert not exists("solve/absent.py", Path("fem/geometry.py"))
    assert exists("solve/passband.py", Path("fem/geometry.py"))
    assert not found("contact.answers.steady.nothing")
    assert not known("fem.nothing")
    assert known("contact.answers.steady")
    assert known("numpy.linalg")


def test_every_test_that_is_left_out_by_default_exists():
    named = [line.split("[")[0].split("::") for line in (ROOT / "tests/thorough.txt").read_text().splitlines()[1:]]
    gone = [f"{file}: {name}" for file, name in named if f"def {name}(" not in (ROOT / file).read_text()]
    assert len(named) > 50
    assert not gone, "\n".join(gone)
