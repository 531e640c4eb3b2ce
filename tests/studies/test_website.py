"""The site and the notebooks made from the documents: cells, execution, what fails."""

import json
import re
from pathlib import Path

import pytest

from studies.refusal import RunError, SceneError
from studies.website.__main__ import main
from studies.website.fenced import Fenced, pieces
from studies.website.notebook import executed, notebook_of_document, notebook_of_example
from studies.website.pages import page_names, page_notebook

ROOT = Path(__file__).parents[2]
DOCUMENT = """\
# A motor

![stored](pictures/stored.png) [scenes](scenes/README.md)

| | |
|---|---|
| ![one](a.png) | ![two](b.png) |

| question | answer |
|---|---|
| why | so |

```toml
# motor.toml
name = "motor"
```

<!-- part of a scene -->
```toml
[slider]
```

```sh
echo 1.5 mm/s
```
```
2.5 mm/s
```

```sh
sawmotor view results/motor
```

<!-- not run: needs a cluster -->
```python
1 / 0
```

```python
print(open("motor.toml").read())
```
"""


def cells(notebook):
    return [(cell.cell_type, cell.source) for cell in notebook.cells]


def test_the_pieces_of_a_document_make_it_up():
    found = pieces(DOCUMENT)
    languages = [each.language for each in found if isinstance(each, Fenced)]
    assert languages == ["toml", "toml", "sh", "", "sh", "python", "python"]
    assert found[0].startswith("# A motor")
    lines = DOCUMENT.splitlines()
    for each in found:
        if isinstance(each, Fenced):
            opening = next(line for line in lines[each.line - 1 :] if line and not line.startswith("<!--"))
            assert opening == f"```{each.language}"


def test_a_document_becomes_cells_without_stored_answers_and_pictures():
    kinds = cells(notebook_of_document(DOCUMENT))
    code = [text for kind, text in kinds if kind == "code"]
    prose = "\n".join(text for kind, text in kinds if kind == "markdown")
    assert code[0] == '%%writefile motor.toml\n# motor.toml\nname = "motor"'
    assert code[1] == "%%bash\necho 1.5 mm/s"
    assert "Image(path)" in code[2]
    assert code[3] == 'print(open("motor.toml").read())'
    assert len(code) == 4
    assert "2.5 mm/s" not in prose
    assert "stored.png" not in prose
    assert "README" not in prose
    assert "| |" not in prose
    for kept in (
        "| question | answer |\n|---|---|\n| why | so |",
        "# A motor",
        "scenes",
        "[slider]",
        "sawmotor view",
        "1 / 0",
    ):
        assert kept in prose


@pytest.fixture(scope="module")
def run_document(tmp_path_factory):
    return executed(notebook_of_document(DOCUMENT), tmp_path_factory.mktemp("notebook"), timeout=60)


def test_an_executed_notebook_holds_what_its_commands_print(run_document):
    outputs = [cell.outputs for cell in run_document.cells if cell.cell_type == "code"]
    assert outputs[1][0]["text"] == "1.5 mm/s\n"
    assert 'name = "motor"' in outputs[3][0]["text"]


@pytest.mark.parametrize("block", ["```sh\nfalse\n```\n", "```python\n1 / 0\n```\n"])
def test_a_page_whose_command_fails_is_no_page(block, tmp_path):
    from nbclient.exceptions import CellExecutionError

    with pytest.raises(CellExecutionError):
        executed(notebook_of_document(block), tmp_path, timeout=60)


def test_output_in_pieces_is_one_text_and_the_kernel_says_nothing(tmp_path, capfd):
    lines = (
        "import sys, time",
        "for each in ('1.', '5'):",
        "    print(each, end='', flush=True)",
        "    time.sleep(0.3)",
    )
    block = "```python\n" + "\n".join(lines) + "\n```\n"
    notebook = executed(notebook_of_document(block), tmp_path, timeout=60)
    assert notebook.cells[0].outputs[0]["text"] == "1.5"
    assert capfd.readouterr().err == ""  # each page's kernel warned that it does not encrypt


def test_a_page_has_the_warnings_of_a_command_and_not_its_progress(tmp_path):
    from studies.website.pages import without_progress

    said = ("stator (1.0 s)", "sawmotor: warning: warm", "stator (2.0 s)")
    loud = "; ".join(f"echo '{line}' >&2" for line in said)
    quiet = "echo 'stator (1.0 s)' >&2; echo 3"
    document = f"```sh\n{loud}\n```\n```sh\n{quiet}\n```\n```python\nimport sys\nprint('mine', file=sys.stderr)\n```\n"
    cells = without_progress(executed(notebook_of_document(document), tmp_path, timeout=60)).cells
    found = [[(each["name"], each["text"]) for each in cell.outputs] for cell in cells]
    assert [each for each in found if each] == [
        [("stderr", "sawmotor: warning: warm\n")], [("stdout", "3\n")], [("stderr", "mine\n")],
    ]  # fmt: skip


def test_a_page_that_fails_is_named(tmp_path, monkeypatch):
    from studies.website import pages

    monkeypatch.setattr(pages, "page_notebook", lambda name: notebook_of_document("```sh\nfalse\n```\n"))
    with pytest.raises(RunError, match="page scenes/rayleigh was not made"):
        pages.build(tmp_path / "site", ["scenes/rayleigh"])


def test_every_scene_example_and_the_tutorial_has_a_page():
    names = page_names()
    assert {"tutorial", "gallery", "scenes/twente", "scenes/rotor", "examples/contact-burst"} < set(names)
    assert len([name for name in names if name.startswith("examples/")]) == len(list(ROOT.glob("*/examples/*.py")))
    assert "sawmotor run rotor" in str(cells(page_notebook("scenes/rotor")))


def test_an_example_becomes_its_text_and_one_cell():
    source = '"""A title.\n\nAnd a reason.\n"""\n\nx = 1\nprint(x)\n'
    assert cells(notebook_of_example("a/b", source)) == [
        ("markdown", "# a/b\n\nA title.\n\nAnd a reason."),
        ("code", "x = 1\nprint(x)"),
    ]


def test_the_tutorial_is_written_as_a_notebook(tmp_path, capsys):
    import nbformat

    assert main([str(tmp_path / "tutorial.ipynb")]) == 0
    written = json.loads((tmp_path / "tutorial.ipynb").read_text(encoding="utf-8"))
    nbformat.validate(written)
    code = ["".join(cell["source"]) for cell in written["cells"] if cell["cell_type"] == "code"]
    assert any(text.startswith("%%writefile my-motor.toml") for text in code)
    assert "%%bash\nsawmotor check my-motor.toml" in code


def test_an_unknown_page_is_named(tmp_path, capsys):
    assert main([str(tmp_path / "site"), "examples/contact-bursts"]) == 2
    assert "did you mean examples/contact-burst?" in capsys.readouterr().err
    with pytest.raises(SceneError):
        page_notebook("nothing")


def test_a_small_part_of_the_site_is_built(tmp_path):
    assert main([str(tmp_path / "site"), "examples/fem-half_space", "scenes/rayleigh"]) == 0
    page = (tmp_path / "site" / "scenes" / "rayleigh.html").read_text(encoding="utf-8")
    assert "sawmotor run rayleigh" in page
    assert "m/s" in page
    assert "examples/fem-half_space.html" in (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    assert "Copyright" not in page
    # lines of code of 120 characters and long warnings were cut in the theme's column
    assert re.search(r'href="\.\./_static/wide\.css', page)
    assert "max-width: 76em" in (tmp_path / "site" / "_static" / "wide.css").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_tutorial_runs_as_a_notebook(tmp_path):
    notebook = executed(page_notebook("tutorial"), tmp_path, timeout=1800)
    pictures = [
        output for cell in notebook.cells for output in cell.get("outputs", ()) if "image/png" in output.get("data", {})
    ]
    assert len(pictures) > 3
