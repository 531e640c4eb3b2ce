"""Print the statements that raise or refuse and that no test of a coverage run has reached.

    coverage run --branch -m pytest ... && python -m tests.uncovered_errors [FOLDER ...]

Errors inside compiled kernels count as not reached unless they ran as plain Python.
"""

import ast
import sys
from pathlib import Path


def error_lines(source: str) -> set[int]:
    r"""Return the first lines of the statements that raise or call a refusal.

    >>> sorted(error_lines("if x:\n    raise ValueError\nscene.refuse('key', 'rule')\nanswer()"))
    [2, 3]
    """
    return {
        node.lineno
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Raise)
        or (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Call)
            and ast.unparse(node.value.func).rpartition(".")[2].startswith("refuse")
        )
    }


def main(folders: list[str]) -> None:
    """Print file, line and text of each, by package."""
    import coverage  # an extra of the project, which the tests do without

    measured = coverage.Coverage()
    measured.load()
    for folder in folders:
        lines = []
        for path in sorted(Path(folder).rglob("*.py")):
            _, _, _, missing, _ = measured.analysis2(str(path))
            text = path.read_text(encoding="utf-8")
            rows = text.splitlines()
            lines += [f"{path}:{line}: {rows[line - 1].strip()}" for line in sorted(error_lines(text) & set(missing))]
        print(f"{folder}: {len(lines)} errors are not raised", *lines, sep="\n  ")


if __name__ == "__main__":
    main(sys.argv[1:] or ["fem", "contact", "studies"])
