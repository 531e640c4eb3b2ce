"""Each library example of `fem` and `contact` runs, and ends with a comparison with a known number."""

import ast
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted(ROOT.glob("*/examples/*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: f"{path.parts[-3]}/{path.stem}")
def test_an_example_runs_to_its_known_number(path, capsys):
    body = ast.parse(path.read_text(encoding="utf-8")).body
    assert isinstance(body[-1], ast.Assert)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


def test_there_are_examples_of_both_packages():
    assert {path.parts[-3] for path in EXAMPLES} == {"contact", "fem"}
