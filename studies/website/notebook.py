"""Notebooks from documents: a tutorial in Markdown, a shipped scene, an example of the libraries.

Texts become Markdown cells, Python blocks code cells, commands cells of the shell; a TOML block that names its file in
the first line is written into that file.  After each command a cell shows the pictures that it drew.  What a document
says a command prints is left out: the notebook prints it itself, and so are stored pictures.
"""

import ast
import re
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from studies.refusal import needed
from studies.website.fenced import Fenced, is_shell, named_file, pieces

__all__ = ["executed", "notebook_of_document", "notebook_of_example", "notebook_of_scene"]

PICTURE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
EMPTY_TABLE = re.compile(r"(?:^\|[\s|-]*\|\n)+(?![|])", re.MULTILINE)  # one whose cells were pictures
# to another document of the repository
LINK = re.compile(r"\[([^\]]+)\]\((?!https?:|#|mailto:)[^)]+\)")
WINDOW = re.compile(r"^sawmotor view (?!.*--(screenshot|movie|html|data|surface))", re.MULTILINE)
SHOW_PICTURES = """\
from pathlib import Path
from IPython.display import Image, display

shown = globals().get("shown", set())
for path in sorted(Path().rglob("*.png"), key=lambda each: each.stat().st_mtime):
    if (path, path.stat().st_mtime) not in shown:
        shown.add((path, path.stat().st_mtime))
        display(Image(path))"""
NO_SOURCE = {"tags": ["remove-input"]}


def notebook_of_document(text: str) -> Any:
    """Return a document as a notebook.

    Parameters
    ----------
    text : str
        Markdown, with fenced blocks as `studies.website.fenced` reads them.

    Returns
    -------
    notebook : nbformat.NotebookNode
        Not executed.
    """
    cells = []
    printed = False  # whether the next block without a language is what a command printed
    for piece in pieces(text):
        if isinstance(piece, str):
            prose = LINK.sub(r"\1", EMPTY_TABLE.sub("", PICTURE.sub("", piece))).strip()
            cells += [new_markdown_cell(prose)] if prose else []
        elif not _runs(piece):
            if not printed or piece.language:
                cells.append(new_markdown_cell(f"```{piece.language}\n{piece.text}```"))
        elif piece.language == "python":
            cells.append(new_code_cell(piece.text.rstrip()))
        elif piece.language == "toml":
            cells.append(new_code_cell(f"%%writefile {named_file(piece)}\n{piece.text.rstrip()}"))
        else:
            cells += _shell_cells(piece.text)
            printed = True
    return new_notebook(cells=cells, metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}})


def notebook_of_scene(name: str, table: str) -> Any:
    """Return a notebook that shows a shipped scene, runs it and draws it; ``table``: the scene's TOML."""
    text = f"# {name}\n\n```toml-shown\n{table}```\n\n```sh\nsawmotor run {name}\n```\n"
    return notebook_of_document(text.replace("toml-shown", "text"))


def notebook_of_example(name: str, source: str) -> Any:
    """Return a library example as a notebook: its docstring as text, its statements as one cell."""
    tree = ast.parse(source)
    first, *rest = (ast.get_docstring(tree) or "").split("\n\n")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip()
    return notebook_of_document(f"# {name}\n\n" + "\n\n".join([first, *rest]) + f"\n\n```python\n{code}\n```\n")


def executed(notebook: Any, folder: Path, *, timeout: float) -> Any:
    """Return a notebook with the outputs of its cells, run in a directory.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
    folder : pathlib.Path
        The working directory of its cells, which must exist.
    timeout : float
        Longest time of one cell, s.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell raises, or a command fails.
    """
    client = needed("nbclient", "an executed notebook").NotebookClient
    written = nbformat.from_dict(notebook)
    # output comes in pieces that end anywhere, within a number too: joined, as they are; a kernel of this machine alone
    # needs no encryption, of which each one warns
    options = {"coalesce_streams": True, "extra_arguments": ["--IPKernelApp.log_level=ERROR"]}
    return client(written, timeout=timeout, resources={"metadata": {"path": folder}}, **options).execute()


def _runs(block: Fenced) -> bool:
    if block.remark.startswith("<!-- not run:"):
        return False
    if block.language == "toml":
        return named_file(block) is not None
    return block.language == "python" or is_shell(block)


def _shell_cells(text: str) -> list[Any]:
    """Return the cells of a block of commands; what opens a window is left to the reader."""
    if WINDOW.search(text):
        return [new_markdown_cell(f"```sh\n{text}```")]
    return [new_code_cell(f"%%bash\n{text.rstrip()}"), new_code_cell(SHOW_PICTURES, metadata=NO_SOURCE)]
