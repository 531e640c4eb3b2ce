"""Imports inside functions: each has a reason, of its library, of its folder, or beside it.

Regression of layout: a start stays cheap by the imports that are named here, and an import that is inside for no reason
hides what a module needs.
"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
INNER = re.compile(
    r"(?:^[ \t]+|[;:][ \t]*)(?:import|from)\b", re.MULTILINE
)  # an import that is not at the line's start
LIBRARIES = {
    "scipy": "0.1 s and more; a run of balls on a stator without pieces needs none",
    "matplotlib": "0.3 s; where something is drawn",
    "pint": "0.2 s; for units beyond those of the table",
    "skfem": "0.3 s; where a mesh is assembled",
    "meshio": "0.1 s; where a mesh is read or written",
    "numba": "0.5 s; where a kernel is compiled",
    "llvmlite": "as numba",
    "threadpoolctl": "where a run sets the threads of BLAS",
    "filelock": "where a directory is written",
    "distributed": "of the extra dask",
    "gwyfile": "of the extra lab: for the files of Gwyddion",
    "SurfaceTopography": "of the extra lab: for other topographies",
    "imageio_ffmpeg": "of the extra view",
    "jinja2": "0.05 s; where a page is written",
    "rich": "0.1 s; where progress is shown in a terminal",
    "hashlib": "3 ms of OpenSSL; where a file is written or a mesh read",
}
PARTS = {  # of a module's name
    ".plane": "of sliders that move in the plane; others start without it",
    ".rough": "of rough balls; smooth ones start without the readers of patches",
    ".adhesive": "of balls whose adhesion holds beyond the touch; others start without scipy",
}
PLACES = {
    "studies/command/": "a command imports what it runs when it is called: the others start without it",
    "studies/__main__.py": "the same, and a defect is reported even where an import fails",
    "contact/jit/": "without numba the kernels run uncompiled",
}


def without_reason(text: str, place: str) -> list[str]:
    """Return the imports inside functions of a module that have no reason: ``line: module``."""
    if not INNER.search(text):
        return []  # nothing to parse
    lines, found = text.splitlines(), []
    for function in ast.walk(ast.parse(text)):
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        for node in ast.walk(function):
            if not isinstance(node, ast.Import | ast.ImportFrom):
                continue
            module = node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
            before = node.lineno - 2  # a comment above a group of imports is that of each
            while lines[before].strip().startswith(("import ", "from ")):
                before -= 1
            said = "#" in lines[node.lineno - 1] or lines[before].strip().startswith("#")
            known = module.split(".")[0] in LIBRARIES or any(part in module for part in PARTS)
            if not (said or known or place.startswith(tuple(PLACES))):
                found.append(f"{node.lineno}: {module}")
    return sorted(set(found))


@pytest.mark.parametrize("package", ["fem", "contact", "studies"])
def test_each_import_inside_a_function_has_its_reason(package):
    paths = sorted((ROOT / package).rglob("*.py"))
    found = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in paths}
    missing = [f"{place}:{each}" for place, text in found.items() for each in without_reason(text, place)]
    assert not missing, "\n".join(missing)


def test_an_import_without_a_reason_is_found():
    text = "def load():\n    import json\n    import scipy.linalg\n    import csv  # 2 ms\n"
    assert without_reason(text, "fem/layout.py") == ["2: json"]
    assert without_reason("def load():\n    # as above\n    import json\n    import csv\n", "fem/layout.py") == []
    assert without_reason(text, "studies/command/run.py") == []
