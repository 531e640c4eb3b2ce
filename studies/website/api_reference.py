"""``python -m studies.website.api_reference OUT``: the API reference of the three packages by pdoc, from docstrings.

Needs the extra ``docs``.  pdoc documents what lies in a module's namespace, and of a public name that a module's
``__getattr__`` imports on first use only the heading: all names are therefore imported before.
"""

import inspect
import sys
from importlib import import_module
from pathlib import Path

from studies.refusal import needed

__all__ = ["PACKAGES", "write_reference"]

PACKAGES = ("fem", "contact", "studies")


def write_reference(out: Path) -> Path:
    """Write a page for each package, with all public names, and return the first page.

    Parameters
    ----------
    out : pathlib.Path
        The directory of the pages, made if absent.

    Raises
    ------
    studies.refusal.RunError
        If pdoc is not installed.
    """
    pdoc, render = needed("pdoc", "the API reference"), needed("pdoc.render", "the API reference")
    for name in PACKAGES:
        package = import_module(name)
        for public in package.__all__:
            # a compiled kernel is documented as the function from which it was made
            setattr(package, public, inspect.unwrap(getattr(package, public)))
    render.configure(docformat="numpy")
    pdoc.pdoc(*PACKAGES, output_directory=out)
    return out / "index.html"


if __name__ == "__main__":
    print(write_reference(Path(sys.argv[1] if len(sys.argv) > 1 else "docs")))
