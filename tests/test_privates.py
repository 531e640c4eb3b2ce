"""Names: no test takes a private part of another module by a string, which ruff does not see; none hides a module."""

import ast
import re
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

import pytest

TESTS = Path(__file__).parent
CALLS = {"setattr", "delattr", "getattr", "hasattr", "object", "patch", "import_module"}
PRIVATE = re.compile(r"(?:^|\.)_[a-zA-Z]\w*$")
QUOTED = re.compile(r"""["'.]_[a-zA-Z]\w*["']""")  # as it ends a string of a source
PATHS = sorted(TESTS.rglob("*.py"))


def private_names(text: str) -> list[str]:
    """Return the private names that are given as strings to calls that look up or replace an attribute."""
    found = []
    for node in ast.walk(ast.parse(text)) if QUOTED.search(text) else ():
        if isinstance(node, ast.Call):
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            words = [each.value for each in node.args[:2] if isinstance(each, ast.Constant)]
            if called in CALLS:
                found += [each for each in words if isinstance(each, str) and PRIVATE.search(each)]
    return found


def test_no_private_name_is_looked_up_by_a_string():
    looked_up = {str(path.relative_to(TESTS)): private_names(path.read_text(encoding="utf-8")) for path in PATHS}
    assert {path: names for path, names in looked_up.items() if names} == {}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('monkeypatch.setattr(band, "_errors", None)', ["_errors"]),
        ('monkeypatch.setattr("fem.solve.band_solution._errors", None)', ["fem.solve.band_solution._errors"]),
        ('getattr(motion, "_limit")(1.0)', ["_limit"]),
        ('with patch.object(module, "_loaded"): pass', ["_loaded"]),
        ('monkeypatch.setattr(compiled.Kernel, "__call__", None)', []),
        ('monkeypatch.setattr(band, "project", None)', []),
    ],
)
def test_a_private_name_in_a_string_is_seen(text, names):
    assert private_names(text) == names


def packages(name: str) -> list:
    """Return a package and all packages below it."""
    package = import_module(name)
    below = [each.name for each in iter_modules(package.__path__) if each.ispkg]
    return [package, *(inner for each in below for inner in packages(f"{name}.{each}"))]


@pytest.mark.parametrize("root", ["fem", "contact", "studies"])
def test_no_public_name_hides_a_module_of_its_package(root):
    # `import fem.circuit.touchstone` would give the function
    for package in packages(root):
        modules = {each.name for each in iter_modules(package.__path__)}
        hiding = [each for each in getattr(package, "__all__", ()) if each in modules]
        assert [each for each in hiding if not isinstance(getattr(package, each), ModuleType)] == [], package.__name__
