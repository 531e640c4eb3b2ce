"""What a docstring, a comment or a document names exists: files, modules, functions, commands, options and keys."""

import ast
import importlib
import io
import json
import re
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path

import pytest

from studies.command.parser import COMMANDS, parser

ROOT = Path(__file__).parents[1]
PACKAGES = ("fem", "contact", "studies", "tests")
FILE = re.compile(r"`{1,2}((?:[\w-]+/)+[\w-]+\.(?:py|md|toml|html|json))`{1,2}")
NAME = re.compile(r"`{1,2}(\w+(?:\.\w+)+)(?:\(\))?`{1,2}")
# Python files, and any file by its path from the checkout on
BARE = re.compile(
    r"(?<![\w/.*])((?:[\w-]+/)*[\w-]+\.py|(?:fem|contact|studies|tests)/(?:[\w-]+/)*[\w-]+\.(?:toml|md|csv|txt|json|html))\b"
)
QUOTED = re.compile(r"(?<!`)`{1,2}([A-Za-z_]\w*(?:\.\w+)*)(?:\(\))?`{1,2}(?!`)")
COMMAND = re.compile(r"\bsawmotor ((?!did\b|there\b)[a-z]+)(?: [^`;\n]*?(--[a-z-]+))?")
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef)
NAME_FIELDS = {
    ast.Name: ("id",), ast.Attribute: ("attr",), ast.arg: ("arg",), ast.keyword: ("arg",), ast.FunctionDef: ("name",),
    ast.ClassDef: ("name",), ast.alias: ("name", "asname"),
}  # fmt: skip
# endings of columns whose names are composed of a quantity and a unit
COMPOSED = (*(f"_{unit}" for unit in ("m", "mm", "nm", "ms", "rad", "mm_per_s", "UNIT", "0", "1")),)
OTHERS = ("scipy", "numpy", "network")  # other libraries, and files that are named in an example
# files of a user, in examples
EXAMPLES = {"FILE.py", "my_law.py", "my_controller.py", "viscous.py", "plain.py"}
ENDINGS = ("py", "md", "toml", "csv", "json", "png", "html", "vtu", "gif", "msh")
WRITTEN = ("results/", "DIR/")  # by the program, not in the repository
SOURCES = sorted(
    path.relative_to(ROOT)
    for folder in PACKAGES
    for ending in ("py", "md")
    for path in (ROOT / folder).rglob(f"*.{ending}")
    if path != Path(__file__)  # which plants pointers to nothing
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


@cache
def prose_and_words(text: str) -> tuple[str, frozenset[str]]:
    """Return comments and docstrings of a source, and its identifiers with the words of its other strings."""
    prose, docstrings, words = re.findall(r"(?:^|\s)#[^\n]*", text), set(), set()
    for node in ast.walk(ast.parse(text)):  # a docstring is met before its own node, which lies deeper
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False):
            docstrings.add(id(node.body[0].value))
            prose.append(node.body[0].value.value)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            words.update(re.findall(r"\w+", node.value))
        for field in NAME_FIELDS.get(type(node), ()):
            words.update((getattr(node, field) or "").split("."))
    return "\n".join(prose), frozenset(words)


def prose(text: str, ending: str) -> str:
    """Return a document, or the comments and docstrings of a source."""
    return prose_and_words(text)[0] if ending == ".py" else text


def bare_names(text: str, ending: str) -> list[str]:
    """Return the files that a document, or the comments and docstrings of a source, name."""
    return [name for name in BARE.findall(prose(text, ending)) if name not in EXAMPLES]


@cache
def code_words() -> set[str]:
    """Return the words of all sources, and the names of their files and folders."""
    sources = [path for path in SOURCES if path.suffix == ".py"]
    named = {word for path in sources for word in (path.stem, path.parent.name)}
    return named.union(*(prose_and_words((ROOT / path).read_text(encoding="utf-8"))[1] for path in sources))


def gone_names(text: str) -> list[str]:
    """Return the names in backquotes of comments and docstrings of which a part occurs nowhere in the code."""
    return [
        name
        for name in QUOTED.findall(prose(text, ".py"))
        if any(word not in code_words() and not word.endswith(COMPOSED) for word in name.split("."))
        and name.split(".")[0] not in OTHERS
    ]


@pytest.mark.parametrize("folder", PACKAGES)
def test_a_name_in_backquotes_is_one_of_the_code(folder):
    """Functions, classes, arguments, attributes and keys that comments and docstrings mention."""
    sources = [path for path in SOURCES if path.parts[0] == folder and path.suffix == ".py"]
    missing = [f"{path}: {each}" for path in sources for each in gone_names((ROOT / path).read_text(encoding="utf-8"))]
    assert not missing, "\n".join(missing)


def unknown_commands(text: str) -> list[str]:
    """Return the commands, and options of commands, that a comment or docstring names and the program does not have."""
    return [
        f"sawmotor {call} {option}".strip()
        for call, option in COMMAND.findall(prose(text, ".py"))
        if call not in COMMANDS or (option and option not in options_of(call))
    ]


@cache
def options_of(command: str) -> set[str]:
    """Return the options that the help of a command lists."""
    printed = io.StringIO()
    with redirect_stdout(printed), pytest.raises(SystemExit):
        parser(command).parse_args([command, "--help"])
    return set(re.findall(r"--[a-z][a-z-]*", printed.getvalue()))


@pytest.mark.parametrize("folder", PACKAGES)
def test_a_command_that_a_docstring_names_exists(folder):
    sources = [path for path in SOURCES if path.parts[0] == folder and path.suffix == ".py"]
    wrong = [f"{path}: {each}" for path in sources for each in unknown_commands((ROOT / path).read_text("utf-8"))]
    assert not wrong, "\n".join(wrong)


def unknown_keys(text: str) -> list[str]:
    """Return the keys of scene blocks in backquotes of a document that neither a scene nor a table of results has."""
    tables = set(re.findall(r"^\| `([\w.]+)`", (ROOT / "studies/README.md").read_text(encoding="utf-8"), re.MULTILINE))
    blocks = json.loads((ROOT / "studies/scenes/schema.json").read_text(encoding="utf-8"))["properties"]
    found = re.findall(r"(?<![\w`.])`((\w+)\.\w+(?:\.\w+)*)\b", text)
    keys = [key for key, block in found if block in blocks and key.split(".")[-1] not in ENDINGS]
    return [key for key in keys if key not in tables and not in_schema(blocks, key)]


def in_schema(properties: dict, key: str) -> bool:
    """Return whether a dotted key leads somewhere in the properties of a schema; numbers count the items of a list."""
    name, _, rest = key.partition(".")
    if name.isdigit():
        return in_schema(properties, rest)
    value = properties.get(name)
    below: dict = {}
    for each in (value or {}, *(value or {}).get("anyOf", ())):
        below |= each.get("properties", {}) | each.get("items", {}).get("properties", {})
    return value is not None and (not rest or in_schema(below, rest))


@pytest.mark.parametrize("path", [path for path in SOURCES if path.suffix == ".md"] + [Path("README.md")], ids=str)
def test_a_key_that_a_document_names_exists(path):
    assert unknown_keys((ROOT / path).read_text(encoding="utf-8")) == []


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
    assert exists("solve/best_frequency.py", Path("fem/geometry.py"))
    assert not found("contact.answers.steady.nothing")
    assert not known("fem.nothing")
    assert known("contact.answers.steady")
    assert known("numpy.linalg")
    assert bare_names("# see tests/fem/absent.toml", ".py") == ["tests/fem/absent.toml"]
    assert gone_names('"""As `nowhere_defined` and ``Scene.no_such`` of `Scene.replace`."""') == [
        "nowhere_defined", "Scene.no_such",
    ]  # fmt: skip
    assert unknown_commands("# sawmotor explode; sawmotor run x --speed 3; sawmotor run x --voltage 3") == [
        "sawmotor explode", "sawmotor run --speed",
    ]  # fmt: skip
    assert unknown_keys("`slider.weight`, `slider.mass`, `transducer.0.fingers`, `slider.damping.contact`") == [
        "slider.weight", "transducer.0.fingers",
    ]  # fmt: skip


def test_every_test_that_is_left_out_by_default_exists():
    named = [line.split("[")[0].split("::") for line in (ROOT / "tests/thorough.txt").read_text().splitlines()[1:]]
    gone = [f"{file}: {name}" for file, name in named if f"def {name}(" not in (ROOT / file).read_text()]
    assert len(named) > 50
    assert not gone, "\n".join(gone)
