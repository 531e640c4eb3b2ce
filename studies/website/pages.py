"""The pages of the site: executed notebooks, which Sphinx and MyST-NB turn into HTML."""

import os
import sys
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat

from studies.refusal import RunError, needed, refuse_unknown
from studies.scene import shipped_scenes
from studies.website.notebook import executed, notebook_of_document, notebook_of_example, notebook_of_scene

__all__ = ["build", "page_names", "page_notebook"]

TIMEOUT = 1800  # s, of one cell; the gallery takes about 75 s
CONFIGURATION = {
    "project": "sawmotor",
    "extensions": ["myst_nb"],
    "html_theme": "furo",
    "html_title": "sawmotor",
    "html_show_copyright": False,
    "html_static_path": ["_static"],
    "html_css_files": ["wide.css"],
    # executed before: MyST-NB 1.4.0 breaks lines where pieces of output meet, within a number too
    "nb_execution_mode": "off",
    "myst_heading_anchors": 3,
    "suppress_warnings": ["myst.header", "misc.highlighting_failure"],
}
# lines of code have up to 120 characters, tables of velocities more, and Furo's column has 46 em; sentences are wrapped
STYLE = """\
.main { justify-content: flex-start; min-width: 0; }
.content { flex: 1 1 46em; min-width: 0; max-width: 76em; }
.sidebar-drawer { width: 17em; }
div.output.stderr pre { white-space: pre-wrap; }
"""
SECTIONS = {"tutorial": "Tutorial", "gallery": "Gallery", "scenes": "Scenes", "examples": "Library examples"}


def page_names() -> list[str]:
    """Return the names of all pages: ``tutorial``, ``gallery``, ``scenes/NAME`` and ``examples/PACKAGE-NAME``."""
    scenes = [f"scenes/{name}" for name in shipped_scenes()]
    return ["tutorial", "gallery", *scenes, *(f"examples/{name}" for name in _examples())]


def page_notebook(name: str) -> Any:
    """Return the notebook of a page, not executed; a `studies.refusal.SceneError` names the pages if there is none."""
    section, _, rest = name.partition("/")
    refuse_unknown(name, page_names(), "", f"there is no page {name!r}")
    if name == "tutorial":
        return notebook_of_document((resources.files("studies") / "README.md").read_text(encoding="utf-8"))
    if name == "gallery":
        return notebook_of_document("# Gallery\n\n```sh\nsawmotor study gallery\n```\n")
    if section == "scenes":
        table = (resources.files("studies") / "scenes" / f"{rest}.toml").read_text(encoding="utf-8")
        return notebook_of_scene(rest, table)
    return notebook_of_example(rest.replace("-", "/"), _examples()[rest].read_text(encoding="utf-8"))


def build(out: Path, names: list[str] | None = None) -> Path:
    """Build the site, executing each page.

    Parameters
    ----------
    out : pathlib.Path
        The site's directory, made if absent.
    names : list of str, optional
        Of these pages only (`page_names`).

    Returns
    -------
    index : pathlib.Path
        Its first page.

    Raises
    ------
    studies.refusal.SceneError
        If there is no page of a name.
    studies.refusal.RunError
        If a page's cell fails, or Sphinx warns.

    Examples
    --------
    >>> from pathlib import Path
    >>> build(Path("site"), ["examples/contact-threshold"])  # doctest: +SKIP
    PosixPath('site/index.html')
    """
    Sphinx = needed("sphinx.application", "the site").Sphinx  # takes a second to import
    SphinxError = needed("sphinx.errors", "the site").SphinxError
    chosen = page_names() if names is None else names
    notebooks = {name: page_notebook(name) for name in chosen}
    with TemporaryDirectory() as folder:
        source = Path(folder) / "source"
        for name, notebook in notebooks.items():
            page = source / f"{name}.ipynb"
            page.parent.mkdir(parents=True, exist_ok=True)
            nbformat.write(_executed(name, notebook), page)
        (source / "_static").mkdir()
        (source / "_static" / "wide.css").write_text(STYLE, encoding="utf-8")
        (source / "index.md").write_text(_index(chosen), encoding="utf-8")
        try:
            app = Sphinx(source, None, out, Path(folder) / "doctrees", "html", CONFIGURATION, warningiserror=True)
            app.build()
        except SphinxError as error:
            raise RunError(f"the site was not built: {error}") from error
    if app.statuscode:
        raise RunError("the site was not built: Sphinx warned, as printed above")
    return out / "index.html"


def without_progress(notebook: Any) -> Any:
    """Return an executed notebook with the warnings of its commands alone, without the progress that they reported."""
    for cell in notebook.cells:
        if not cell.source.startswith("%%bash"):
            continue
        for output in cell.outputs:
            if output.get("name") == "stderr":
                output["text"] = "".join(
                    line for line in output["text"].splitlines(True) if line.startswith("sawmotor:")
                )
        cell.outputs = [each for each in cell.outputs if each.get("text", "text")]
    return notebook


def _executed(name: str, notebook: Any) -> Any:
    """Return the notebook of a page with its outputs; a `RunError` names the page if a cell fails."""
    failed = needed("nbclient.exceptions", "the site").CellExecutionError
    kept = os.environ.get("PATH", "")
    # the commands of a page are those of this interpreter's environment
    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), kept])
    try:
        with TemporaryDirectory() as folder:
            return without_progress(executed(notebook, Path(folder), timeout=TIMEOUT))
    except failed as error:
        raise RunError(f"the page {name} was not made: {error}") from error
    finally:
        os.environ["PATH"] = kept


def _examples() -> dict[str, Path]:
    """Return the files of the library examples by ``PACKAGE-NAME``."""
    packages = ("contact", "fem")
    folders = {package: Path(str(resources.files(package) / "examples")) for package in packages}
    return {f"{package}-{path.stem}": path for package in packages for path in sorted(folders[package].glob("*.py"))}


def _index(names: list[str]) -> str:
    """Return the first page: the pages by section."""
    lines = ["# sawmotor", "", "Surface-acoustic-wave motors, from drive voltage to slider velocity.", ""]
    for section, title in SECTIONS.items():
        pages = [name for name in names if name.partition("/")[0] == section]
        if pages:
            lines += ["```{toctree}", ":maxdepth: 1", f":caption: {title}", "", *pages, "```", ""]
    return "\n".join(lines)
