"""``python -m studies.website OUT [PAGE ...]``: the site in a directory, or the tutorial as one notebook (.ipynb)."""

import argparse
import sys
from pathlib import Path

import nbformat

from studies.refusal import RunError, SceneError
from studies.website.pages import build, page_notebook


def main(words: list[str] | None = None) -> int:
    """Build the site or write the tutorial's notebook; return the exit code: 0, 2 for bad input, 3 if a page fails."""
    parser = argparse.ArgumentParser(prog="python -m studies.website", description=__doc__)
    parser.add_argument("out", type=Path, help="a directory, or a file that ends in .ipynb")
    parser.add_argument("pages", nargs="*", help="only these, such as tutorial, scenes/twente, examples/contact-burst")
    arguments = parser.parse_args(words)
    try:
        if arguments.out.suffix == ".ipynb":
            nbformat.write(page_notebook(*(arguments.pages or ["tutorial"])[:1]), arguments.out)
            print(arguments.out)
        else:
            print(build(arguments.out, arguments.pages or None))
    except (SceneError, RunError) as error:
        print(error, file=sys.stderr)
        return 2 if isinstance(error, SceneError) else 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
