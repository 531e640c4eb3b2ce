"""Every rule of an input is said by one place: no sentence "must ..." stands twice in the packages.

Sentences are compared with their numbers, quoted words, keys and inserted values left out. `contact` and `fem` know
nothing of each other, so that each has its own words for single numbers; those are named here.
"""

import ast
import re
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[1]
INSERTED = "\N{MIDDLE DOT}"
LEFT_OUT = (
    r"\"[^\"]*\"|'[^']*'|`[^`]*`",  # quoted
    r"\[+[\w.]+\]+|\b\w+(\.\w+)+\b|\b\w+_\w+\b",  # blocks and keys
    r"[-+]?\d[\d_.]*(e[-+]?\d+)?",  # numbers
    rf"({INSERTED}[ ,]*(or |and )?)+{INSERTED}",  # several of them
)


def normalised(sentence: str) -> str:
    for pattern in LEFT_OUT:
        sentence = re.sub(pattern, INSERTED, sentence)
    return " ".join(sentence.split()).lower().rstrip(" ,.:;")


def parts(node: ast.AST) -> str | None:
    """Return a string constant, or an f-string with its values left out; None for another node."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        return "".join(str(each.value) if isinstance(each, ast.Constant) else INSERTED for each in node.values)
    return None


def sentences(source: str) -> list[tuple[str, int]]:
    """Return what stands from "must" on in the strings of a module, documentation left out, and their lines."""
    if "must" not in source:
        return []  # nothing to parse
    nodes = list(ast.walk(ast.parse(source)))
    skipped = {id(x.value) for x in nodes if isinstance(x, ast.Expr) and isinstance(x.value, ast.Constant)}
    skipped |= {id(y) for x in nodes if isinstance(x, ast.JoinedStr) for y in ast.walk(x) if y is not x}
    found = []
    for node in nodes:
        text = None if id(node) in skipped else parts(node)
        if text is not None and (start := re.search(r"\bmust\b", text)):
            found.append((normalised(text[start.start() :]), node.lineno))
    return found


def test_a_rule_that_stands_twice_is_seen():
    twice = 'a = f"must be at most {x}, got 3"\nb = "must be at most 0.5, got 7"\n'
    assert len({sentence for sentence, _ in sentences(twice)}) == 1
    assert sentences("def f():\n    'It must not.'\n") == []


def test_no_rule_stands_twice():
    where = defaultdict(list)
    for package in ("fem", "contact", "studies"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for sentence, line in sentences(path.read_text(encoding="utf-8")):
                where[sentence].append(f"{path.relative_to(ROOT)}:{line}")
    says_something = {s: at for s, at in where.items() if re.sub(rf"must|be|got|hold|[{INSERTED},\s]", "", s)}
    twice = [f"{sentence!r}: {', '.join(at)}" for sentence, at in says_something.items() if len(at) > 1]
    assert not twice, "\n".join(twice)
